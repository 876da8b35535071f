"""What values of lower parts can do by upper ones: draw, simulate, sample, report."""

from vasowave.base.faces import attach_face

__getattr__, __dir__ = attach_face(__name__)
