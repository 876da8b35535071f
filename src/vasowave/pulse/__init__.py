"""The 1D library: network, model, solver, calibration, posterior and analysis of one cycle of pressure and flow."""

from vasowave.base.faces import attach_face

__getattr__, __dir__ = attach_face(__name__)
