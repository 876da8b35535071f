"""What several wall laws say together: the mixture of what each says, by the weights of the laws."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import xarray as xr

from vasowave.base.descriptions import TAILS
from vasowave.base.errors import InputError


class Averaged(NamedTuple):
    """One quantity over several laws.

    Attributes
    ----------
    value : float
        Median of the mixture of the laws' own distributions.
    low, high : float
        Ends of its central 95 % interval.
    between : float
        Share of the variance of the logarithm that lies between laws; where it is large, the law is the answer.
    """

    value: float
    low: float
    high: float
    between: float


def law_weights(selection: xr.Dataset) -> xr.DataArray:
    """Weights exp(-ΔAICc/2) of the wall laws, which sum to 1 (Burnham & Anderson).

    Parameters
    ----------
    selection : Dataset
        From `compare_models`. Rows that are not discarded are read.

    Returns
    -------
    DataArray
        Dims ``covariance`` (noise models, the likeliest first) and ``wall``. A weight is as good as the noise model
        behind it: where the rows disagree, so do the answers.

    Raises
    ------
    InputError
        No noise model is left.
    """
    table = selection.to_dataframe()
    table = table[~table["discarded"].astype(bool)]
    if not len(table):
        raise InputError("every noise model of the comparison is discarded; there are no weights")
    differences = table.pivot(index="covariance", columns="wall", values="AICc_difference")
    differences = differences.loc[table["covariance"].drop_duplicates()]
    relative = np.exp(-0.5 * differences.to_numpy(float))
    return xr.DataArray(
        relative / relative.sum(axis=1, keepdims=True),
        {"covariance": differences.index.to_numpy(object), "wall": differences.columns.to_numpy(object)},
        ("covariance", "wall"),
        attrs={"units": "1", "long_name": "weight of the wall law, exp(-ΔAICc/2)"},
    )


def averaged(values: Sequence[float], errors: Sequence[float], weights: Sequence[float]) -> Averaged:
    """Average a positive quantity over laws.

    Parameters
    ----------
    values : sequence of float, one a law
    errors : sequence of float
        Standard errors of their logarithms, each normal around its value.
    weights : sequence of float
        Of the laws; they are made to sum to 1.

    Raises
    ------
    InputError
        A value or error that is not positive, or no weight.

    Examples
    --------
    >>> from vasowave.pulse.selection.averaging import averaged
    >>> round(averaged([100.0, 400.0], [0.1, 0.1], [0.5, 0.5]).value, 6)
    200.0
    """
    from scipy.optimize import brentq
    from scipy.special import ndtr

    q, s, w = (np.asarray(sequence, dtype=float) for sequence in (values, errors, weights))
    if not (np.all(np.isfinite(q) & (q > 0) & (s > 0)) and np.all(w >= 0) and w.sum() > 0):
        raise InputError("an average over laws needs positive values, errors and weights")
    w = w / w.sum()

    def quantile(share: float) -> float:
        ends = float(np.min(np.log(q) - 5 * s)), float(np.max(np.log(q) + 5 * s))
        return float(brentq(lambda x: float(w @ ndtr((x - np.log(q)) / s)) - share, *ends))

    return _averaged([quantile(share) for share in TAILS], np.log(q), s**2, w)


def averaged_draws(draws: Sequence[np.ndarray], weights: np.ndarray) -> Averaged:
    """Average a positive quantity over laws, of which equally weighted draws are known, by weights that sum to 1."""
    logs = [np.log(log_draws) for log_draws in draws]
    draw_weights = np.concatenate(
        [np.full(len(log_draws), w / len(log_draws)) for log_draws, w in zip(logs, weights, strict=True)]
    )
    ends = np.quantile(np.concatenate(logs), TAILS, method="inverted_cdf", weights=draw_weights)
    return _averaged(
        ends,
        np.array([log_draws.mean() for log_draws in logs]),
        np.array([log_draws.var() for log_draws in logs]),
        weights,
    )


def _averaged(ends: Sequence[float] | np.ndarray, means: np.ndarray, variances: np.ndarray, w: np.ndarray) -> Averaged:
    """Return the average by low end, median and high end of the mixture, and what each law says; all of logarithms."""
    low, middle, high = map(float, np.exp(ends))
    between = float(w @ (means - w @ means) ** 2)
    return Averaged(middle, low, high, between / (between + float(w @ variances)))
