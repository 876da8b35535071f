"""Where a junction is said to be: a convention, which moves length between a parent and its daughters."""

from dataclasses import replace
from typing import Literal

import numpy as np
from scipy.spatial import cKDTree

from vasowave.lung.measure.measurement import Measurement
from vasowave.lung.tree import Line, Tree

Junction = Literal["axes", "tube", "vmtk"]
_SHARES = {"tube": 0.5, "vmtk": 1.0}
"""An axis leaves its sister where it is this share of the sister's inscribed radius away from the sister's axis."""
_MAX_SHARE = 0.5
"""At most this share of a daughter is given to its parent."""


def with_junctions_at(measured: Measurement, junction: Junction) -> Measurement:
    """Return `measured` with lengths by another convention of the junction's place; radii and axes stay.

    A daughter begins where its axis has left the tubes of all its sisters; what lies before is its parent's, whose
    length grows by the mean over its daughters, so that the way from the root to the ends stays the same in the mean.

    Parameters
    ----------
    measured : Measurement
        Junctions where the axes meet.
    junction : "axes", "tube" or "vmtk"
        Where the axes meet; where they leave tubes of half the radius, as lines of other programs are cut (see
        `merged`); or of the whole radius, the split point of VMTK's branch extractor (Antiga and Steinman 2004).
    """
    if junction == "axes":
        return measured
    tree, length = measured.tree, measured.network.length.copy()
    for row in range(len(tree)):
        daughters = tree.daughters(row)
        if len(daughters) > 1:
            shared = np.array([_shared(tree, int(daughter), daughters, _SHARES[junction]) for daughter in daughters])
            length[daughters] -= shared
            length[row] += shared.mean()
    return replace(measured, network=replace(measured.network, length=length))


def _shared(tree: Tree, row: int, sisters: np.ndarray, share: float) -> float:
    """Return how far along itself a vessel is last inside the tube of a sister, cm."""
    line = tree.lines[row]
    crossing = max(_left(line, tree.lines[sister], share) for sister in sisters if sister != row)
    return min(crossing, _MAX_SHARE * line.length)


def _left(line: Line, sister: Line, share: float) -> float:
    """Return where `line` crosses the wall of the tube last, between its points."""
    distance, nearest = cKDTree(sister.points).query(line.points)
    outside = distance - share * sister.radius[nearest]
    last = int(np.flatnonzero(outside <= 0)[-1])  # it begins on the sister's axis
    if last == len(line) - 1:
        return line.length
    before, after = outside[last], outside[last + 1]
    return float(line.run[last] + (line.run[last + 1] - line.run[last]) * before / (before - after))
