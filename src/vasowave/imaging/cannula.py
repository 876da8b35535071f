"""The cannula of known diameter: where it ends in the root vessel, and the scale it gives."""

from dataclasses import replace

import numpy as np

from vasowave.errors import InputError
from vasowave.imaging.radii import densitometric_radius
from vasowave.imaging.tree import Tree, distance_along
from vasowave.imaging.volume import Volume

PE90_RADIUS = 0.043
"""Inner radius of PE-90 tubing, cm."""


def cannula_tip(line: np.ndarray) -> int:
    """Return the point at which the cannula ends in the root's `line` (z, y, x, r): the change point of r(s).

    Two constant radii are fitted by least squares to the points outside both ends' inscribed balls.

    Raises
    ------
    InputError
        A line too short, or one whose two radii differ by less than 3 %: no cannula can be told from the vessel.
    """
    run = distance_along(line)
    typical = np.median(line[:, 3])
    inner = np.flatnonzero((run > 1.2 * typical) & (run < run[-1] - 1.2 * typical))
    if len(inner) < 12:
        raise InputError(
            "the root vessel is too short to show where the cannula ends; give the outlets, if false branches cut it, "
            "or the tip instead"
        )
    radius, margin = line[inner, 3], 4
    cost = [radius[:k].var() * k + radius[k:].var() * (len(radius) - k) for k in range(margin, len(radius) - margin)]
    best = margin + int(np.argmin(cost))
    near, far = radius[:best].mean(), radius[best:].mean()
    if abs(far - near) < 0.03 * near:
        raise InputError(
            f"no cannula found: the root's radius changes only from {near:.4g} to {far:.4g} cm; give the tip instead"
        )
    return int(inner[best])


def without_cannula(tree: Tree) -> tuple[Tree, np.ndarray]:
    """Return `tree` with its root cut at the cannula's tip, and the cannula's line from its outer end to the tip."""
    root = int(np.flatnonzero(tree.parent < 0)[0])
    line = tree.lines[root]
    tip = cannula_tip(line)
    lines = list(tree.lines)
    lines[root] = line[tip:]
    return replace(tree, lines=tuple(lines)), line[: tip + 1]


def cannula_radius(line: np.ndarray, volume: Volume, lumen: float) -> float:
    """Return the densitometric radius of the cannula's `line`, cm, the estimator of the vessels' radii.

    Raises
    ------
    InputError
        If the line has no stretch clear of its outer end and its tip.
    """
    run, typical = distance_along(line), float(np.median(line[:, 3]))
    free = np.flatnonzero((run > 1.2 * typical) & (run < run[-1] - 0.5 * typical))
    if len(free) == 0:
        raise InputError(f"the cannula shows only {run[-1]:.3g} cm, too little to measure its radius; give the spacing")
    return densitometric_radius(line, free, typical, volume, lumen)
