"""Taper: how the radius changes along each vessel, which a network of straight tubes leaves out."""

from dataclasses import dataclass

import numpy as np

from vasowave.imaging.axes.stretches import clear_stretches
from vasowave.imaging.tree import Line, Tree


@dataclass(frozen=True, eq=False)
class Taper:
    """Straight lines through the inscribed radius of each vessel; NaN for vessels without a free stretch.

    Attributes
    ----------
    slope : float array, shape (vessel,)
        -dr/ds, cm per cm; positive where the vessel narrows away from the heart.
    slope_se : float array, shape (vessel,)
        Standard error of the slope with as many independent points as radii fit into the stretch.
    proximal, distal : float array, shape (vessel,)
        Radius of that line at the vessel's beginning and end, cm.
    """

    slope: np.ndarray
    slope_se: np.ndarray
    proximal: np.ndarray
    distal: np.ndarray


def taper(tree: Tree) -> Taper:
    """Fit r(s) = r0 - slope · s over each vessel's clear stretch: outside junctions, sisters and its free end.

    Radii of neighboring points are of one sphere, so a stretch holds only as many independent values as radii fit
    into it; vessels with a free stretch below three radii have no taper (NaN).
    """
    rows = [_fit(line, *stretch) for line, stretch in zip(tree.lines, clear_stretches(tree), strict=True)]
    return Taper(*np.array(rows).T)


def _fit(line: Line, begin: float, end: float) -> tuple[float, float, float, float]:
    run, radius = line.run, line.radius
    free = (run > begin) & (run < end)
    independent = np.ptp(run[free]) / line.typical_radius if free.any() else 0.0
    if independent < 3 or free.sum() < 5:
        return (np.nan,) * 4
    s, r = run[free], radius[free]
    slope, intercept = np.polyfit(s, r, 1)
    residual = float(np.std(r - intercept - slope * s))
    error = residual / (float(np.std(s)) * np.sqrt(independent))
    return -float(slope), error, float(intercept), float(intercept + slope * run[-1])
