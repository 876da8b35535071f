"""Where terminal vessels end: on the lumen's surface, straight ahead of their axis."""

from dataclasses import replace

import numpy as np

from vasowave.imaging.sections import STEP, across, disc, sampled
from vasowave.imaging.segmentation import Segmentation
from vasowave.imaging.tree import Tree, distance_along

FARTHEST = 2.0
"""An end moves by at most so many voxels from the surface."""
PLATEAU = 1.5, 3.0
"""The vessel's own grey is that on its axis so many voxels before its end; in wide vessels to 1.5 radii before it."""


def with_ends_at_the_surface(tree: Tree, surface: np.ndarray) -> Tree:
    """Return `tree` with the last radius of every terminal replaced by its axis, prolonged to the surface.

    Within a radius of a blind end a center path turns to its farthest corner. The end is the median of the
    surface's points ahead that lie within half a radius of the axis; a terminal without such points keeps its end.

    Parameters
    ----------
    tree : Tree
    surface : float array, shape (corner, 3)
        Points of the lumen's surface, cm (see `Paths`).
    """
    lines = list(tree.lines)
    for row in set(range(len(lines))) - set(tree.parent.tolist()):
        lines[row] = _prolonged(lines[row], surface)
    return replace(tree, lines=tuple(lines))


def _prolonged(line: np.ndarray, surface: np.ndarray) -> np.ndarray:
    run = distance_along(line)
    radius = float(np.median(line[run > 0.5 * run[-1], 3]))
    kept = line[run <= max(run[-1] - radius, 0.5 * run[-1])]
    straight = line[: len(kept)][run[: len(kept)] >= run[len(kept) - 1] - 2.5 * radius, :3]
    if len(straight) < 3:
        return line
    axis = np.linalg.svd(straight - straight.mean(axis=0), full_matrices=False)[2][0]
    axis *= np.sign(axis @ (straight[-1] - straight[0]))
    ahead = (surface - kept[-1, :3]) @ axis
    aside = np.linalg.norm(surface - kept[-1, :3] - ahead[:, None] * axis, axis=1)
    cap = ahead[(ahead > 0) & (ahead < 3 * radius) & (aside < 0.5 * radius)]
    if len(cap) < 3:
        return line
    far = float(np.median(cap))
    steps = max(2, round(far / (run[-1] / (len(run) - 1))))
    along = np.linspace(0, far, steps + 1)[1:]
    added = kept[-1, :3] + along[:, None] * axis
    return np.concatenate([kept, np.column_stack([added, np.minimum(kept[-1, 3], far - along)])])


def with_ends_at_half_grey(tree: Tree, lumen: Segmentation) -> Tree:
    """Return `tree` with every terminal's end moved along its axis to where the grey falls to half the vessel's own.

    Blur takes the axis of a thin vessel far below the lumen's grey, so that its surface at a fixed threshold lies
    inside of its end; half of what the vessel itself shows above the background does not know blur nor threshold.

    Parameters
    ----------
    tree : Tree
        With its ends at the surface.
    lumen : Segmentation
    """
    lines = list(tree.lines)
    for row in set(range(len(lines))) - set(tree.parent.tolist()):
        lines[row] = _half_grey(lines[row], lumen)
    return replace(tree, lines=tuple(lines))


def _half_grey(line: np.ndarray, lumen: Segmentation) -> np.ndarray:
    """Return `line` shortened or prolonged by at most FARTHEST voxels."""
    run, radius = distance_along(line), float(np.median(line[len(line) // 2 :, 3]))
    axis = line[-1, :3] - line[np.searchsorted(run, run[-1] - radius) - 1, :3]
    axis /= np.linalg.norm(axis)
    (u,), (v,) = across(axis[None])
    grid = disc(0.5 * radius, STEP * lumen.spacing)
    full = PLATEAU[0], max(PLATEAU[1], 1.5 * radius / lumen.spacing)
    at = np.arange(-full[1], FARTHEST + 0.05, 0.1)
    centers = line[-1, :3] + at[:, None] * lumen.spacing * axis
    places = centers[:, None] + grid[:, :1] * u + grid[:, 1:] * v
    profile = sampled(lumen.grey, places, lumen.origin, lumen.spacing).mean(axis=1)
    half = (np.median(profile[at <= -full[0]]) + lumen.background) / 2
    falls = np.flatnonzero((profile[:-1] >= half) & (profile[1:] < half) & (at[:-1] >= -FARTHEST))
    if len(falls) == 0:
        return line
    move = float(at[falls[np.argmin(np.abs(at[falls]))]]) * lumen.spacing
    end = line[-1] + np.append(move * axis, 0.0)
    return np.concatenate([line[run < run[-1] + move], end[None]])
