"""A model and its waves in the files of other programs, and back: ParaView, MATLAB, openBF, svZeroDSolver, tables."""

from vasowave.exchange.export import FORMATS, export_model
from vasowave.exchange.openbf_reading import read_openbf

__all__ = ["FORMATS", "export_model", "read_openbf"]
