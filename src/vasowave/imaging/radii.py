"""The densitometric radius: the grey level integrated over the cross-section, which hardly knows the threshold."""

import numpy as np
from scipy.stats import trim_mean

from vasowave.imaging.sections import STEP, across, disc, sampled, tangents
from vasowave.imaging.tree import Tree, distance_along
from vasowave.imaging.volume import Volume

DISC, RING = 2.0, 7.0
"""A section is integrated up to DISC voxels beyond the radius, its background taken from there to RING voxels."""


def densitometric_radii(tree: Tree, volume: Volume, inscribed: np.ndarray) -> np.ndarray:
    """Return a radius per vessel, cm, shape (vessel,); NaN for vessels without a free stretch.

    The area of a section is ∫(g - background)/(lumen - background) dA, the background being that of a ring around
    it and the lumen's grey level that on the axes of the vessels wider than 4 voxels.
    Blur conserves this integral, so neither blur nor threshold changes it.

    Parameters
    ----------
    tree : Tree
    volume : Volume
    inscribed : float array, shape (vessel,)
        First estimate of the radii, cm.
    """
    lumen = lumen_grey(tree, volume)
    ends = set(range(len(tree.lines))) - set(tree.parent.tolist())
    found = np.full(len(tree.lines), np.nan)
    for row, line in enumerate(tree.lines):
        run = distance_along(line)
        tail = 1.3 * inscribed[row] if row in ends else 1.5 * line[-1, 3]
        free = np.flatnonzero((run > 1.5 * line[0, 3] + 0.5 * inscribed[row]) & (run < run[-1] - tail))
        found[row] = densitometric_radius(line, free, inscribed[row], volume, lumen)
    return found


def densitometric_radius(
    line: np.ndarray, sections: np.ndarray, inscribed: float, volume: Volume, lumen: float
) -> float:
    """Return the radius from the mean area of `sections` (points of `line`), cm; NaN without sections.

    The mean is that of the middle half: neighbors disturb some sections, noise all.
    """
    areas = [_section_area(line, int(point), inscribed, volume, lumen) for point in sections]
    return float(np.sqrt(trim_mean(areas, 0.25) / np.pi)) if areas else np.nan


def lumen_grey(tree: Tree, volume: Volume) -> float:
    """Return the grey level of the lumen: the median on the axes of the wide vessels, which blur does not reach."""
    points = np.concatenate(tree.lines)
    deep = points[points[:, 3] > min(4 * volume.spacing[0], np.quantile(points[:, 3], 0.8))]
    return float(np.median(sampled(volume.grey, deep[:, :3], volume.origin, volume.spacing[0])))


def _section_area(line: np.ndarray, point: int, radius: float, volume: Volume, lumen: float) -> float:
    """Return the area of the section across `line` at `point`, cm²."""
    (u,), (v,) = across(tangents(line, 4)[point][None])
    step = STEP * volume.spacing[0]
    inner, outer = radius + DISC * volume.spacing[0], radius + RING * volume.spacing[0]
    grid = disc(outer, step)
    rho = np.hypot(*grid.T)
    places = line[point, :3] + grid[:, :1] * u + grid[:, 1:] * v
    grey = sampled(volume.grey, places, volume.origin, volume.spacing[0])
    background = float(np.median(grey[rho > inner]))
    return float(np.maximum((grey[rho <= inner] - background).sum(), 0.0) / (lumen - background) * step**2)
