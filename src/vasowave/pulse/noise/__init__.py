"""What the residual of a fit says about its noise: spectra, kernels, ARMA processes, and their likelihood."""

from vasowave.base.faces import attach_face

__getattr__, __dir__ = attach_face(__name__)
