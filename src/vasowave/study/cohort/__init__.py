"""Groups of animals: who belongs to which, described, compared, and the one of each that is shown."""

from vasowave.base.faces import attach_face

__getattr__, __dir__ = attach_face(__name__)
