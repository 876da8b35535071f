"""What the residual of a fit says about its noise: spectra, kernels, ARMA processes, and their likelihood."""
