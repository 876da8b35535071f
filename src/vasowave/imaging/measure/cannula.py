"""The cannula of known diameter: where it ends in the root vessel, and the scale it gives."""

import warnings

import numpy as np

from vasowave.errors import InputError, VasowaveWarning
from vasowave.imaging.measure.radii import densitometric_radius, lumen_grey
from vasowave.imaging.read.volume import Volume
from vasowave.imaging.tree import Line, Tree

_ELSE = "or the root is not at the cannula's outer end"


def cannula_tip(line: Line) -> int:
    """Return the point at which the cannula ends in the root's `line`: the change point of r(s).

    Two constant radii are fitted by least squares to the points outside both ends' inscribed balls.

    Raises
    ------
    InputError
        A line too short, or one whose two radii differ by less than 3 %: no cannula can be told from the vessel.
    """
    run, typical = line.run, np.median(line.radius)
    inner = np.flatnonzero((run > 1.2 * typical) & (run < run[-1] - 1.2 * typical))
    if len(inner) < 12:
        raise InputError(
            "the root vessel is too short to show where the cannula ends; give the outlets, if false branches cut it, "
            f"or the tip instead; {_ELSE}"
        )
    radius, margin = line.radius[inner], 4
    cost = [radius[:k].var() * k + radius[k:].var() * (len(radius) - k) for k in range(margin, len(radius) - margin)]
    best = margin + int(np.argmin(cost))
    near, far = radius[:best].mean(), radius[best:].mean()
    if abs(far - near) < 0.03 * near:
        raise InputError(
            f"no cannula found: the root's radius changes only from {near:.4g} to {far:.4g} cm; give the tip "
            f"instead; {_ELSE}"
        )
    return int(inner[best])


def without_cannula(tree: Tree) -> tuple[Tree, Line]:
    """Return `tree` with its root cut at the cannula's tip, and the cannula's line from its outer end to the tip."""
    line = tree.lines[tree.root]
    tip = cannula_tip(line)
    lines = list(tree.lines)
    lines[tree.root] = line[tip:]
    return tree.with_lines(lines), line[: tip + 1]


def cannula_radius(line: Line, volume: Volume, lumen: float) -> float:
    """Return the densitometric radius of the cannula's `line`, cm, the estimator of the vessels' radii.

    Raises
    ------
    InputError
        If the line has no stretch clear of its outer end and its tip.
    """
    run, typical = line.run, float(np.median(line.radius))
    free = np.flatnonzero((run > 1.2 * typical) & (run < run[-1] - 0.5 * typical))
    if len(free) == 0:
        raise InputError(f"the cannula shows only {run[-1]:.3g} cm, too little to measure its radius; {_ELSE}")
    return densitometric_radius(line, free, typical, volume, lumen)


def scale_of(cannula: Line, volume: Volume, tree: Tree, known: float) -> float:
    """Return the known over the measured radius of the `cannula`.

    Warns
    -----
    VasowaveWarning
        They differ by more than 1 %.
    """
    measured = cannula_radius(cannula, volume, lumen_grey(tree, volume))
    scale = known / measured
    if abs(scale - 1) > 0.01:
        warnings.warn(
            f"the cannula measures {measured:.4g} cm instead of {known:.4g}: its scale differs by "
            f"{100 * (scale - 1):+.1f} % from the file's voxel size, which was used; check the spacing",
            VasowaveWarning,
            stacklevel=2,
        )
    return scale
