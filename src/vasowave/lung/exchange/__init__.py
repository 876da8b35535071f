"""Files of other programs."""

from vasowave.base.faces import attach_face

__getattr__, __dir__ = attach_face(__name__)
