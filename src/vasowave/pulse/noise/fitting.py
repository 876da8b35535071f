"""One noise model, chosen by its name, fitted to the residuals of several models at once."""

from typing import Literal, get_args

import numpy as np

from vasowave.base.errors import InputError, did_you_mean
from vasowave.pulse.noise.arma import fit_arma
from vasowave.pulse.noise.likelihood import FAMILIES, KERNELS, NoiseFamily, fit_kernel, maximize, named, regularized
from vasowave.pulse.noise.models import CirculantNoise, Noise

Own = Literal["circulant", "ARMA", "independent"]
Name = Literal[Own, "squared exponential", "Matern 3/2", "Matern 5/2", "neural network", "periodic"]
NOISE: tuple[Own, ...] = get_args(Own)
"""Noise models of a closed cycle: the periodic stationary process, ARMA, and white noise."""
OF_PAPER: tuple[Name, ...] = get_args(Name)
"""Those and the paper's kernels."""


def fit_noise(
    name: str,
    residuals: np.ndarray,
    period: float,
    *,
    starts: int = 4,
    rng: np.random.Generator,
) -> Noise:
    """Fit one noise model to residuals of all models, shape (model, sample), mmHg, by their joint likelihood.

    Parameters
    ----------
    name : str
        Of `OF_PAPER`.
    residuals : array, shape (model, sample)
        Evenly spaced over one period, mmHg.
    period : float
        T, s.
    starts : int
        Of the maximization of the likelihood.
    rng : numpy.random.Generator

    Raises
    ------
    InputError
        An unknown noise model.
    """
    if name not in OF_PAPER:
        raise InputError(f"unknown noise model '{name}'{did_you_mean(name, OF_PAPER)}; known: {', '.join(OF_PAPER)}")
    if name in KERNELS:
        return regularized(*fit_kernel(KERNELS[name], residuals, period, rng, starts))
    return (
        regularized(*_arma(residuals)) if name == "ARMA" else _circulant(FAMILIES[name], residuals, period, rng, starts)
    )


def _arma(residuals: np.ndarray) -> tuple[np.ndarray, dict[str, float]]:
    model = fit_arma(residuals)
    sigma = model.covariance(residuals.shape[1])
    values = {"amplitude [mmHg2]": float(sigma[0, 0]), "p": float(len(model.ar)), "q": float(len(model.ma))}
    for letter, coefficients in (("phi", model.ar), ("theta", model.ma)):
        values |= {f"{letter}{i}": float(value) for i, value in enumerate(coefficients, 1)}
    return sigma, values


def _circulant(
    family: NoiseFamily, residuals: np.ndarray, period: float, rng: np.random.Generator, starts: int
) -> CirculantNoise:
    count = residuals.shape[1]
    theta, amplitude = maximize(family, residuals, rng, starts)
    power = amplitude * family.noise(count, theta).power  # type: ignore[attr-defined]
    return CirculantNoise(power, count, named(family, theta, period, amplitude))
