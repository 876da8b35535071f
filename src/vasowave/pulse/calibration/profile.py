"""Profile likelihood: how much worse the best fit becomes as one parameter moves away from its optimum."""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import xarray as xr

from vasowave.base.descriptions import LEVEL
from vasowave.base.errors import InputError, NumericalError
from vasowave.base.runtime.thread_limits import threads
from vasowave.pulse.calibration.generalized import Optimum, Whiten, beside_sites, least_squares_optimum, reoptimize
from vasowave.pulse.calibration.result import CalibratedModel

_CHI2_95 = 3.841458820694124  # 95 % quantile of χ² with one degree of freedom


def profile_likelihood(
    fit: CalibratedModel,
    name: str,
    *,
    whiten: Whiten | None = None,
    points: int = 11,
    span: float = 0.7,
    progress: Callable[[int, int], None] | None = None,
) -> xr.Dataset:
    """Fit all other parameters again with one held at each value of a grid around its optimum.

    Parameters
    ----------
    fit : CalibratedModel
    name : str
        A free parameter of the fit.
    whiten : callable, optional
        Of a noise model fitted to the residuals, ``noise.whiten``. Without it the noise counts as independent with the
        variance of the residuals, which makes intervals of smooth residuals far too short.
    points : int
        Grid values, evenly spaced in the logarithm, besides the optimum.
    span : float
        The grid reaches from value·exp(-span) to value·exp(span), within the bounds of the fit.
    progress : callable, optional
        Called with finished and all grid values.

    Returns
    -------
    Dataset
        Dim ``point``: the profiled parameter and all others, ``deviance`` (twice the loss of log-likelihood against the
        best point), ``S`` (mmHg², eq. 14), ``converged``. Attributes: parameter, lower, upper: where the deviance
        passes 3.84, the 95 % interval; NaN where it stays below to the end of the grid.

    Raises
    ------
    InputError
        A parameter that is not free, a grid of fewer than four values, a span that is not positive.

    Examples
    --------
    >>> import vasowave as vw
    >>> search = vw.Search(starts=1, fixed={"r1": 1.0, "c1": 1.0})
    >>> fit = vw.calibrate(vw.control_network(), vw.virtual_mouse(), search=search)
    >>> profile = vw.profile_likelihood(fit, "beta", points=4, span=0.2)
    >>> profile.attrs["parameter"], float(profile["deviance"].min())
    ('beta', 0.0)
    """
    if name not in fit.parameters.index or not fit.parameters["free"][name]:
        free = ", ".join(str(free_name) for free_name in fit.parameters.index[fit.parameters["free"]])
        raise InputError(f"'{name}' is no free parameter of the {fit.wall} wall; free are: {free}")
    if points < 4 or not span > 0:
        raise InputError(f"points {points}, span {span:g}: give at least four points and a positive span")
    metric, workers = beside_sites(whiten or _independent(fit), fit), threads()
    best = least_squares_optimum(fit, workers) if whiten is None else reoptimize(fit, whiten, workers=workers)
    values = _grid(fit, name, best.values[name], points, span)
    ends: dict[float, Optimum] = {best.values[name]: best}
    below, above = values[values < best.values[name]][::-1], values[values > best.values[name]]
    for side in (below, above):
        start = np.delete(best.x, best.space.free_names.index(name))
        for value in side:
            try:
                held = {name: float(value)}
                end = reoptimize(fit, whiten or _independent(fit), start=start, fixed=held, workers=workers)
            except NumericalError:
                break  # over the edge of what can be simulated; what lies beyond stays unknown
            start, ends[float(value)] = end.x, end
            if progress is not None:
                progress(len(ends) - 1, len(below) + len(above))
    return _dataset(name, [ends[value] for value in sorted(ends)], metric)


def _independent(fit: CalibratedModel) -> Whiten:
    free = int(fit.parameters["free"].sum())
    scale = np.sqrt(np.sum(fit.residual**2) / (fit.N - free))
    return lambda values: values / scale


def _grid(fit: CalibratedModel, name: str, best: float, points: int, span: float) -> np.ndarray:
    row = fit.parameters.loc[name]
    low, high = max(best * np.exp(-span), row["lower"]), min(best * np.exp(span), row["upper"])
    return np.geomspace(low, high, points)


def _dataset(name: str, ends: Sequence[Optimum], metric: Whiten) -> xr.Dataset:
    chi2 = np.array([float(np.sum(metric(end.residual) ** 2)) for end in ends])
    deviance = chi2 - chi2.min()
    values: dict[Any, np.ndarray] = {key: np.array([end.values[key] for end in ends]) for key in ends[0].space.names}
    lower, upper = _crossings(np.log(values[name]), deviance)
    variables = {key: ("point", value, {"units": ends[0].space.parameters[key].unit}) for key, value in values.items()}
    S = np.array([float(end.residual @ end.residual) for end in ends])
    return xr.Dataset(
        {
            **variables,
            "deviance": ("point", deviance, {"units": "1", "long_name": "twice the loss of log-likelihood"}),
            "S": ("point", S, {"units": "mmHg2", "long_name": "objective (eq. 14), pressure only"}),
            "converged": ("point", np.array([end.converged for end in ends])),
        },
        attrs={"parameter": name, "level": LEVEL, "lower": float(np.exp(lower)), "upper": float(np.exp(upper))},
    )


def _crossings(x: np.ndarray, deviance: np.ndarray) -> tuple[float, float]:
    """Return where the deviance last stays below its limit on either side of its least value, NaN where it does."""
    best, limits = int(np.argmin(deviance)), [np.nan, np.nan]
    for side, step in enumerate((-1, 1)):
        i = best
        while 0 <= i + step < len(x) and np.isnan(limits[side]):
            j = i + step
            if deviance[j] >= _CHI2_95:
                # The deviance is nearly a parabola, so its root is nearly straight between two points.
                a, b = np.sqrt(deviance[i]), np.sqrt(deviance[j])
                limits[side] = x[i] + (np.sqrt(_CHI2_95) - a) / (b - a) * (x[j] - x[i])
            i = j
    return limits[0], limits[1]
