"""The published tables, their networks, and animals and lungs that the package makes itself."""

from vasowave.base.faces import attach_face

__getattr__, __dir__ = attach_face(__name__)
