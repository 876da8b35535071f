"""Which vessels there are, and where their axes run."""

from vasowave.base.faces import attach_face

__getattr__, __dir__ = attach_face(__name__)
