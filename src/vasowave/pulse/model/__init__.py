"""The model of an animal: walls, blood, outlets of a network, and their linear theory and first estimate."""

from vasowave.base.faces import attach_face

__getattr__, __dir__ = attach_face(__name__)
