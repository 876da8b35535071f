"""The cannula of known diameter: where it ends in the root vessel, and the scale it gives."""

from dataclasses import replace

import numpy as np

from vasowave.errors import InputError
from vasowave.imaging.tree import Tree

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
    run = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(line[:, :3], axis=0), axis=1))])
    typical = np.median(line[:, 3])
    inner = np.flatnonzero((run > 1.2 * typical) & (run < run[-1] - 1.2 * typical))
    if len(inner) < 12:
        raise InputError("the root vessel is too short to show where the cannula ends; give the tip instead")
    radius, margin = line[inner, 3], 4
    cost = [radius[:k].var() * k + radius[k:].var() * (len(radius) - k) for k in range(margin, len(radius) - margin)]
    best = margin + int(np.argmin(cost))
    near, far = radius[:best].mean(), radius[best:].mean()
    if abs(far - near) < 0.03 * near:
        raise InputError(
            f"no cannula found: the root's radius changes only from {near:.4g} to {far:.4g} cm; give the tip instead"
        )
    return int(inner[best])


def without_cannula(tree: Tree) -> tuple[Tree, float]:
    """Return `tree` with its root cut at the cannula's tip, and the cannula's mean radius, cm."""
    root = int(np.flatnonzero(tree.parent < 0)[0])
    line = tree.lines[root]
    tip = cannula_tip(line)
    run = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(line[:, :3], axis=0), axis=1))])
    inside = (run > 1.2 * np.median(line[:, 3])) & (run < run[tip] - 0.5 * line[tip, 3])
    measured = float(line[inside, 3].mean()) if inside.any() else float(line[tip // 2, 3])
    lines = list(tree.lines)
    lines[root] = line[tip:]
    return replace(tree, lines=tuple(lines)), measured
