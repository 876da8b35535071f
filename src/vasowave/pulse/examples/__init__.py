"""The published tables and their networks, and a virtual mouse."""

from vasowave.base.faces import attach_face

__getattr__, __dir__ = attach_face(__name__)
