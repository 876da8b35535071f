"""Which wall law the data prefer: residual covariance, regularization, AICc and BIC."""

from vasowave.noise.arma import Arma, fit_arma
from vasowave.noise.covariance import matern32, matern52, neural_network, periodic, regularize, squared_exponential
from vasowave.noise.gaussian import log_likelihood, whiten
from vasowave.noise.likelihood import KERNELS, Kernel, fit_circulant, fit_kernel
from vasowave.noise.models import CirculantNoise, DenseNoise, Noise
from vasowave.selection.compare import NOISE, compare_models, fit_noise
from vasowave.selection.criteria import aicc, bic
from vasowave.selection.fits import compare_fits
from vasowave.selection.generalized import Mixture, generalized_fit, noise_posterior

__all__ = [
    "KERNELS",
    "NOISE",
    "Arma",
    "CirculantNoise",
    "DenseNoise",
    "Kernel",
    "Mixture",
    "Noise",
    "aicc",
    "bic",
    "compare_fits",
    "compare_models",
    "fit_arma",
    "fit_circulant",
    "fit_kernel",
    "fit_noise",
    "generalized_fit",
    "log_likelihood",
    "matern32",
    "matern52",
    "neural_network",
    "noise_posterior",
    "periodic",
    "regularize",
    "squared_exponential",
    "whiten",
]
