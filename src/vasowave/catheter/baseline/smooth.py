"""A curve through scattered levels that bends only as far as they ask: penalized cubic splines."""

from typing import NamedTuple

import numpy as np

_CURVATURE_WEIGHTS = 10.0 ** np.arange(-4.0, 7.1, 0.5)
"""Weights of the curvature among which the likelihood chooses; the last leaves a straight line."""


class Curve(NamedTuple):
    """A smooth curve, the heights of known steps, and what is left.

    Attributes
    ----------
    values : float array, shape (point,)
        The curve at all points, extra columns left out.
    at_anchor : float
        The curve at the anchor.
    extra : float array, shape (column,)
        Coefficients of the extra columns.
    error : float array, shape (point,)
        Standard error of the difference between every point and the anchor.
    """

    values: np.ndarray
    at_anchor: float
    extra: np.ndarray
    error: np.ndarray


def smooth_curve(
    positions: np.ndarray, values: np.ndarray, used: np.ndarray, spacing: float, anchor: float, extra: np.ndarray
) -> Curve:
    """Fit a penalized cubic spline and extra columns to the `used` values; the bending is chosen by likelihood.

    A straight line costs nothing, and the weight of the curvature maximizes the restricted likelihood of a random walk
    of slopes (Wahba 1985; Eilers & Marx 1996).

    Parameters
    ----------
    positions, values : float array, shape (point,)
    used : bool array, shape (point,)
        Points that are fitted; the curve is given at all.
    spacing : float
        Distance of knots, in the unit of `positions`; at most 60 stretches are made.
    anchor : float
        Where the curve is wanted besides; it may lie outside.
    extra : float array, shape (point, column)
        Columns fitted with the curve and without penalty, for example steps.
    """
    from scipy.interpolate import BSpline
    from scipy.sparse import csr_array, hstack

    points = np.append(positions, anchor)
    stretches = int(np.clip(np.ceil(np.ptp(points) / spacing), 4, 60))
    inner = np.linspace(points.min(), points.max(), stretches + 1)
    width = inner[1] - inner[0]
    knots = np.concatenate([inner[0] - width * np.arange(3, 0, -1), inner, inner[-1] + width * np.arange(1, 4)])
    basis = csr_array(BSpline.design_matrix(points, knots, 3))  # four of the splines are not zero at a point
    count = basis.shape[1]
    bends = np.diff(np.eye(count), 2, axis=0)
    design = csr_array(hstack([basis[:-1], csr_array(extra)]))
    penalty = np.zeros((design.shape[1],) * 2)
    penalty[:count, :count] = bends.T @ bends
    # Extra columns the used points do not tell apart get nothing.
    fitted = design[np.flatnonzero(used)]
    gram = (fitted.T @ fitted).toarray() + 1e-9 * np.eye(design.shape[1])
    moment = fitted.T @ values[used]
    power = float(values[used] @ values[used])
    free = int(used.sum()) - extra.shape[1] - 2
    best, chosen = -np.inf, (moment, gram, 0.0)
    for strength in _CURVATURE_WEIGHTS:
        matrix = gram + strength * penalty
        solution = np.linalg.solve(matrix, moment)
        variance = max(power - float(moment @ solution), 1e-12 * power + 1e-300) / max(free, 1)
        likelihood = len(bends) * np.log(strength) - np.linalg.slogdet(matrix)[1] - free * np.log(variance)
        if likelihood > best:
            best, chosen = likelihood, (solution, matrix, variance)
    solution, matrix, variance = chosen
    covariance = variance * np.linalg.inv(matrix)[:count, :count]
    curve = basis @ solution[:count]
    spread = basis @ covariance
    anchored = basis[[-1]].toarray()[0]
    variances = basis.multiply(spread).sum(axis=1) - 2.0 * spread @ anchored + spread[-1] @ anchored
    error = np.sqrt(np.maximum(variances[:-1], 0.0))
    return Curve(curve[:-1], float(curve[-1]), solution[count:], error)
