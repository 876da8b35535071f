"""A model and its waves in the files of other programs, and back: ParaView, MATLAB, openBF, svZeroDSolver, tables."""

from vasowave.base.faces import attach_face

__getattr__, __dir__ = attach_face(__name__)
