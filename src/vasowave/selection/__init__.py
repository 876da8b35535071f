"""Which wall law the data prefer: residual covariance, regularization, AICc and BIC."""

from vasowave.selection.covariance import matern32, matern52, neural_network, periodic, regularize, squared_exponential
from vasowave.selection.criteria import aicc, bic, log_likelihood, whiten

__all__ = [
    "aicc",
    "bic",
    "log_likelihood",
    "matern32",
    "matern52",
    "neural_network",
    "periodic",
    "regularize",
    "squared_exponential",
    "whiten",
]
