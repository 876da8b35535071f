"""Sobol' indices: which share of the variance of an answer each parameter brings, alone and with the others."""

from collections.abc import Callable, Sequence

import numpy as np
import pandas as pd

from vasowave.base.descriptions import NORMAL
from vasowave.base.errors import InputError
from vasowave.pulse.analysis.sensitivity_table import COLUMNS

_RESAMPLES = 64  # of the bootstrap that makes standard errors
_ROUNDING = 1e-9  # share of an answer by which it changes through rounding alone


def sobol_table(
    function: Callable[[np.ndarray], np.ndarray],
    bounds: np.ndarray,
    names: Sequence[str],
    answers: Sequence[str],
    *,
    samples: int = 4096,
    seed: int = 0,
) -> pd.DataFrame:
    """Return Sobol' indices of first and total order with 95 % intervals.

    Estimators are those of Saltelli et al. (2010) in ``scipy.stats.sobol_indices``, on Sobol' points; intervals tell
    the error of so many samples, by a bootstrap's standard errors. Parameters are independent and uniform.

    Parameters
    ----------
    function : callable
        Maps points, shape (point, parameter), to answers, shape (point, answer).
    bounds : array, shape (parameter, 2)
    names, answers : sequence of str
    samples : int
        A power of 2; the function is asked for ``samples * (parameters + 2)`` points.
    seed : int

    Returns
    -------
    DataFrame
        Index: answer, parameter; columns `COLUMNS`. NaN where an answer does not change.
    """
    from scipy.stats import qmc, sobol_indices

    check_samples(samples)
    count = len(names)
    points = qmc.Sobol(2 * count, seed=np.random.default_rng(seed)).random(samples)
    low, high = np.asarray(bounds, dtype=float).T
    first, second = (low + (high - low) * half for half in (points[:, :count], points[:, count:]))
    crossed = np.repeat(first[np.newaxis], count, axis=0)
    crossed[np.arange(count), :, np.arange(count)] = second.T
    points = np.concatenate([first, second, crossed.reshape(-1, count)])
    values = np.asarray(function(points), dtype=float).reshape(count + 2, samples, len(answers))
    table = np.full((len(answers), count, len(COLUMNS)), np.nan)
    moving = np.ptp(values, axis=(0, 1)) > _ROUNDING * np.abs(values).max(axis=(0, 1))
    chosen = np.moveaxis(values[..., moving], 2, 1)

    def indices_of(values: np.ndarray) -> np.ndarray:
        indices = sobol_indices(func={"f_A": values[0], "f_B": values[1], "f_AB": values[2:]}, n=samples)
        return np.stack([indices.first_order, indices.total_order]).reshape(2, -1, count)  # SciPy drops axes of 1

    if moving.any():
        resamples = np.random.default_rng([seed, 1]).integers(samples, size=(_RESAMPLES, samples))
        errors = np.std([indices_of(chosen[..., rows]) for rows in resamples], axis=0, ddof=1)
        for column, (middle, error) in enumerate(zip(indices_of(chosen), errors, strict=True)):
            half = NORMAL * error
            table[moving, :, 3 * column : 3 * column + 3] = np.stack([middle, middle - half, middle + half], axis=-1)
    rows = pd.MultiIndex.from_product([answers, names], names=["quantity", "parameter"])
    return pd.DataFrame(table.reshape(-1, len(COLUMNS)), rows, [*COLUMNS])


def check_samples(samples: int) -> None:
    """Raise `InputError` for a number of samples that is no power of 2."""
    if not (isinstance(samples, int | np.integer) and samples >= 2 and not samples & (samples - 1)):
        raise InputError(f"samples: {samples!r}; give a power of 2, as 4096")
