"""One cycle of pressure and flow, with its harmonics, its errors and what was observed beside it."""

from vasowave.base.faces import attach_face

__getattr__, __dir__ = attach_face(__name__)
