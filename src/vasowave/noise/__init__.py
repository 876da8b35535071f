"""What the residual of a fit says about its noise: spectra, kernels, ARMA processes, and their likelihood."""

from vasowave.noise.arma import Arma, fit_arma
from vasowave.noise.fitting import NOISE, OF_PAPER, fit_noise
from vasowave.noise.likelihood import (
    KERNELS,
    Kernel,
    fit_kernel,
    matern32,
    matern52,
    neural_network,
    periodic,
    regularize,
    squared_exponential,
)
from vasowave.noise.models import CirculantNoise, DenseNoise, Noise, log_likelihood, whiten
from vasowave.noise.spectrum import Spectra, likely_spectra

__all__ = [
    "KERNELS",
    "NOISE",
    "OF_PAPER",
    "Arma",
    "CirculantNoise",
    "DenseNoise",
    "Kernel",
    "Noise",
    "Spectra",
    "fit_arma",
    "fit_kernel",
    "fit_noise",
    "likely_spectra",
    "log_likelihood",
    "matern32",
    "matern52",
    "neural_network",
    "periodic",
    "regularize",
    "squared_exponential",
    "whiten",
]
