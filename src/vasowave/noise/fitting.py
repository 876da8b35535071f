"""One noise model, chosen by its name, fitted to the residuals of several models at once."""

from typing import Literal

import numpy as np

from vasowave.errors import InputError, did_you_mean
from vasowave.noise.arma import fit_arma
from vasowave.noise.likelihood import FAMILIES, KERNELS, Family, fit_kernel, maximize, named, regularized
from vasowave.noise.models import CirculantNoise, Noise

Sharing = Literal["joint", "average"]

NOISE = (*KERNELS, "circulant", "ARMA", "independent")
"""Names of the noise models: the paper's, the periodic stationary process, and white noise."""


def fit_noise(
    name: str,
    residuals: np.ndarray,
    period: float,
    *,
    sharing: Sharing = "joint",
    starts: int = 4,
    rng: np.random.Generator,
) -> Noise:
    """Fit one noise model to residuals, shape (model, sample), mmHg.

    Parameters
    ----------
    name : str
        Of `NOISE`.
    residuals : array, shape (model, sample)
        Evenly spaced over one period, mmHg.
    period : float
        T, s.
    sharing : {"joint", "average"}
        One covariance of all models by their joint likelihood, or the mean of separate ones.
    starts : int
        Of the maximization of the likelihood.
    rng : numpy.random.Generator

    Raises
    ------
    InputError
        An unknown noise model or sharing.
    """
    if name not in NOISE:
        raise InputError(f"unknown noise model '{name}'{did_you_mean(name, NOISE)}; known: {', '.join(NOISE)}")
    if sharing not in ("joint", "average"):
        raise InputError(f"sharing '{sharing}': give 'joint' or 'average'")
    groups = [residuals] if sharing == "joint" else [r[np.newaxis] for r in residuals]
    if name in KERNELS:
        pairs = [fit_kernel(KERNELS[name], group, period, rng, starts) for group in groups]
    elif name == "ARMA":
        pairs = [_arma(group) for group in groups]
    else:
        return _circulant(FAMILIES[name], groups, period, rng, starts)
    sigma = np.mean([matrix for matrix, _ in pairs], axis=0)
    return regularized(sigma, _mean([values for _, values in pairs]))


def _arma(residuals: np.ndarray) -> tuple[np.ndarray, dict[str, float]]:
    model = fit_arma(residuals)
    sigma = model.covariance(residuals.shape[1])
    values = {"amplitude [mmHg2]": float(sigma[0, 0]), "p": float(len(model.ar)), "q": float(len(model.ma))}
    for letter, coefficients in (("phi", model.ar), ("theta", model.ma)):
        values |= {f"{letter}{i}": float(value) for i, value in enumerate(coefficients, 1)}
    return sigma, values


def _circulant(
    family: Family, groups: list[np.ndarray], period: float, rng: np.random.Generator, starts: int
) -> CirculantNoise:
    powers, values, count = [], [], groups[0].shape[1]
    for group in groups:
        theta, amplitude = maximize(family, group, rng, starts)
        powers.append(amplitude * family.noise(count, theta).power)  # type: ignore[attr-defined]
        values.append(named(family, theta, period, amplitude))
    return CirculantNoise(np.mean(powers, axis=0), count, _mean(values))


def _mean(fits: list[dict[str, float]]) -> dict[str, float]:
    """Return the means of what all fits have: ARMA models of different orders share few."""
    shared = [name for name in fits[0] if all(name in fit for fit in fits)]
    return {name: float(np.mean([fit[name] for fit in fits])) for name in shared}
