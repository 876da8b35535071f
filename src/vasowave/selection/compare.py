"""The paper's table: which wall law each noise model prefers, by AICc and BIC."""

from collections.abc import Mapping, Sequence
from typing import Literal

import numpy as np
import pandas as pd

from vasowave.errors import InputError
from vasowave.noise.arma import fit_arma
from vasowave.noise.likelihood import FAMILIES, KERNELS, Family, fit_kernel, maximize, named, regularized
from vasowave.noise.models import CirculantNoise, Noise
from vasowave.selection.criteria import aicc, bic

Sharing = Literal["joint", "average"]

NOISE = (*KERNELS, "circulant", "ARMA", "independent")
"""Names of the noise models: the paper's, the periodic stationary process, and white noise."""

UNDECIDED = 5.0
"""Differences of AICc or BIC below this decide nothing."""


def compare_models(
    residuals: Mapping[str, np.ndarray],
    n_parameters: Mapping[str, int],
    period: float,
    *,
    noise: Sequence[str] = NOISE,
    sharing: Sharing = "joint",
    norm: int = 2,
    largest_weight: float = 0.1,
    starts: int = 4,
    rng: np.random.Generator | None = None,
) -> pd.DataFrame:
    """AICc and BIC of every model under every noise model, best first (eqs. 21 to 23; the paper's table AICcBIC).

    Parameters
    ----------
    residuals : mapping of model name to array, shape (sample,)
        Measured minus simulated pressure, mmHg, evenly spaced over one period: at the least-squares optimum as in the
        paper, or at the generalized-least-squares one. Call once for each.
    n_parameters : mapping of model name to int
        D, the fitted parameters of each model; hyperparameters of the noise are shared and not counted.
    period : float
        T, s.
    noise : sequence of str
        Of `NOISE`.
    sharing : {"joint", "average"}
        How the one covariance of all models is found: by their joint likelihood, or as the mean of separate ones.
    norm : {1, 2}
        Norm of the condition number that λ brings below 10⁴. In the 2-norm λ never exceeds N/(10⁴ - 1 + N).
    largest_weight : float
        Noise models that need a larger λ are discarded.
    starts : int
        Starts of each likelihood maximization.
    rng : numpy.random.Generator, optional
        Default: a generator with seed 0.

    Returns
    -------
    DataFrame
        One row per noise model, criterion and model: ``score``, ``difference`` to the best model, ``verdict``
        ("preferred", "worse", "undecided" where the runner-up is closer than `UNDECIDED`, "discarded"), ``lambda``,
        D, N, log-likelihood, hyperparameters, norm and sharing. Discarded noise models stand last.

    Raises
    ------
    InputError
        Fewer than two models, series of different length or without variance, unknown names.
    """
    series = _series(residuals, n_parameters, period)
    rng = rng or np.random.default_rng(0)
    rows: list[dict[str, object]] = []
    for name in noise:
        model = fit_noise(name, series, period, sharing=sharing, norm=norm, starts=starts, rng=rng)
        found = {key: model.log_likelihood(r) for key, r in zip(residuals, series)}
        discarded = model.weight > largest_weight
        for criterion, score in (("AICc", aicc), ("BIC", bic)):
            scores = {key: score(found[key], n_parameters[key], series.shape[1]) for key in residuals}
            for key, difference, verdict in verdicts(scores):
                rows.append(
                    {
                        "noise": name,
                        "criterion": criterion,
                        "model": key,
                        "score": scores[key],
                        "difference": difference,
                        "verdict": "discarded" if discarded else verdict,
                        "lambda": model.weight,
                        "D": n_parameters[key],
                        "N": series.shape[1],
                        "log likelihood": found[key],
                        "hyperparameters": ", ".join(f"{k} {v:.4g}" for k, v in model.hyperparameters.items()),
                        "norm": "none" if isinstance(model, CirculantNoise) else f"{norm}-norm",
                        "sharing": sharing,
                    }
                )
    table = pd.DataFrame(rows)
    last = table["verdict"].eq("discarded")
    return pd.concat([table[~last], table[last]], ignore_index=True)


def fit_noise(
    name: str,
    residuals: np.ndarray,
    period: float,
    *,
    sharing: Sharing = "joint",
    norm: int = 2,
    starts: int = 4,
    rng: np.random.Generator,
) -> Noise:
    """Fit one noise model to residuals, shape (model, sample), mmHg; arguments as in `compare_models`."""
    if name not in NOISE:
        raise InputError(f"unknown noise model '{name}'; known: {', '.join(NOISE)}")
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
    return regularized(sigma, _mean([values for _, values in pairs]), norm)


def _arma(residuals: np.ndarray) -> tuple[np.ndarray, dict[str, float]]:
    found = fit_arma(residuals)
    sigma = found.covariance(residuals.shape[1])
    values = {"amplitude [mmHg2]": float(sigma[0, 0]), "p": float(len(found.ar)), "q": float(len(found.ma))}
    for letter, coefficients in (("phi", found.ar), ("theta", found.ma)):
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


def verdicts(scores: Mapping[str, float]) -> list[tuple[str, float, str]]:
    """Return (model, difference, verdict), best first."""
    order = sorted(scores, key=lambda key: scores[key])
    best = scores[order[0]]
    decided = scores[order[1]] - best >= UNDECIDED
    found = []
    for key in order:
        difference = scores[key] - best
        clear = difference >= UNDECIDED or (key == order[0] and decided)
        found.append((key, difference, ("preferred" if key == order[0] else "worse") if clear else "undecided"))
    return found


def _series(residuals: Mapping[str, np.ndarray], n_parameters: Mapping[str, int], period: float) -> np.ndarray:
    """Return the residuals as one array, shape (model, sample), or say what is wrong with them."""
    if len(residuals) < 2:
        raise InputError(f"a comparison needs two models; residuals were given for {len(residuals)}")
    if set(residuals) != set(n_parameters):
        raise InputError(f"residuals are of {', '.join(residuals)}; n_parameters of {', '.join(n_parameters)}")
    if not (np.isfinite(period) and period > 0):
        raise InputError(f"period {period:g} s is not a positive number")
    arrays = {key: np.asarray(r, dtype=float) for key, r in residuals.items()}
    first = next(iter(arrays))
    for key, r in arrays.items():
        if r.ndim != 1 or r.shape != arrays[first].shape or len(r) < 16:
            raise InputError(f"residuals of '{key}' have shape {r.shape}, of '{first}' {arrays[first].shape}")
        if not np.all(np.isfinite(r)) or not np.any(r):
            raise InputError(f"residuals of '{key}' are all zero or not finite; a covariance cannot be estimated")
    return np.stack(list(arrays.values()))
