"""How much radii and lengths depend on the threshold, and lengths on where the fit of the axes begins."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from vasowave.base.errors import InputError
from vasowave.base.findings import look_kind, warn
from vasowave.lung.axes.vessels import in_another_lumen
from vasowave.lung.lumen.segmentation import Segmenter
from vasowave.lung.measure.measurement import Measurement, network_of
from vasowave.lung.measure.profiles import Look, profile
from vasowave.lung.measure.radii import densitometric_radii, windows
from vasowave.lung.read.volume import Volume, part_of
from vasowave.lung.tree import Tree, clear_stretches

FACTORS = 0.8, 1.2
"""The radii are measured again at these multiples of the threshold."""
ENDS = 0.3
"""Standard deviation of the places of a vessel's ends that no threshold shows, voxels."""

_THRESHOLD = "Look at the lumen at this threshold, or choose another."
NO_TREE = look_kind(
    "image.no-tree-at-threshold",
    "no tree was found at threshold {threshold:g}, so radius_sd is unknown: {why}",
    _THRESHOLD,
)
NOT_IN_LUMEN = look_kind(
    "image.not-in-lumen",
    "at threshold {threshold:g} the lumen does not hold vessel(s) {vessels}: radius_sd is unknown there",
    _THRESHOLD,
)


@dataclass(frozen=True, eq=False)
class Elsewhere:
    """The vessels of a tree in the lumen of another threshold.

    Attributes
    ----------
    tree : Tree
        The same vessels, axes and inscribed radii fitted anew.
    threshold : float
        Grey level.
    mask, origin, spacing
        That lumen, see `Segmentation`.
    """

    tree: Tree
    threshold: float
    mask: np.ndarray
    origin: np.ndarray
    spacing: float


def elsewhere(
    tree: Tree, volume: Volume, root: np.ndarray, threshold: float, segmenter: Segmenter
) -> tuple[Elsewhere, ...]:
    """Return the vessels of `tree` at 0.8 and 1.2 times `threshold`.

    Parameters
    ----------
    tree : Tree
        At `threshold`.
    volume : Volume
        Only what lies around the tree and the root is looked at.
    root : float array, shape (3,)
        Where the blood enters, in the lumen, z, y, x, cm.
    threshold : float
        Grey level.
    segmenter : callable
        Finds the lumen in a volume at a threshold from a point in it, see `segment`.

    Warns
    -----
    VasowaveWarning
        No lumen at a threshold, which is then left out.
    """
    region = _around(volume, tree, root)
    alternatives = []
    for level in (factor * threshold for factor in FACTORS):
        try:
            lumen = segmenter(region, level, root)
            again = in_another_lumen(tree, lumen)
        except InputError as error:
            warn(NO_TREE(threshold=level, why=str(error)), stacklevel=4)
            continue
        alternatives.append(Elsewhere(again, level, lumen.mask, lumen.origin, lumen.spacing))
    return tuple(alternatives)


def with_spread(
    measured: Measurement,
    alternatives: Sequence[Elsewhere],
    open_sd: np.ndarray,
    volume: Volume,
    profiler: Look = profile,
) -> Measurement:
    """Return `measured` with the SD of each vessel's radius and length over three thresholds.

    All radii are measured anew at the other thresholds, each by the estimator that it has in `measured`.

    Parameters
    ----------
    measured : Measurement
    alternatives : sequence of Elsewhere
        The same vessels at the other thresholds; without one of them the SD is unknown.
    open_sd : float array, shape (vessel,)
        SD of the lengths for what no threshold shows, cm: where vessels meet (`settled`), where the root begins.
    volume : Volume
    profiler : callable
        See `densitometry`.

    Warns
    -----
    VasowaveWarning
        Vessels that are not in the lumen of a threshold.
    """
    radius = measured.network.radius
    radii, lengths = [radius], [measured.network.length]
    unknown = np.full((2, len(radius)), np.nan)
    for alternative in alternatives:
        sizes = _sizes_in(alternative, measured, volume, profiler)
        radii.append(sizes[0])
        lengths.append(sizes[1])
    if len(alternatives) < len(FACTORS):
        radii.append(unknown[0])
        lengths.append(unknown[1])
    grey = np.zeros(len(radius)) if measured.grey is None else np.nan_to_num(measured.grey.sd)
    spread = np.hypot(np.std(radii, axis=0, ddof=1), grey)
    fixed = np.hypot(open_sd, ENDS * float(volume.spacing[0]))
    return replace(measured, radius_sd=spread, length_sd=np.hypot(np.std(lengths, axis=0, ddof=1), fixed))


def _sizes_in(alternative: Elsewhere, measured: Measurement, volume: Volume, profiler: Look) -> np.ndarray:
    """Return radius and length of every vessel at another threshold, NaN where it is not in that lumen."""
    lost = ~_in_lumen(measured.tree, alternative)
    if lost.any():
        names = ", ".join(str(row + 1) for row in np.flatnonzero(lost))
        warn(NOT_IN_LUMEN(threshold=float(alternative.threshold), vessels=names), stacklevel=4)
    network = network_of(alternative.tree)
    dense, window = (
        np.isfinite(measured.densitometric),
        windows(measured.densitometric, measured.inscribed, float(volume.spacing[0])),
    )
    grey = densitometric_radii(alternative.tree, volume, network.radius, window, profiler)
    grey *= 1.0 if measured.grey is None else measured.grey.share
    radius = np.where(dense, grey, network.radius)
    return np.where(lost, np.nan, [radius, network.length])


def _in_lumen(tree: Tree, lumen: Elsewhere) -> np.ndarray:
    """Return whether most of each vessel's clear stretch lies in `lumen`."""
    inside = []
    for line, (begin, end) in zip(tree.lines, clear_stretches(tree), strict=True):
        clear = (line.run > begin) & (line.run < end)
        points = line.points[clear] if clear.any() else line.points[len(line) // 2 :]
        voxels = np.round((points - lumen.origin) / lumen.spacing).astype(int)
        covered = ((voxels >= 0) & (voxels < lumen.mask.shape)).all(axis=1)
        covered[covered] = lumen.mask[tuple(voxels[covered].T)]
        inside.append(covered.mean() > 0.5)
    return np.array(inside)


def _around(volume: Volume, tree: Tree, root: np.ndarray) -> Volume:
    """Return the part of `volume` that holds `tree` and `root`, without a copy."""
    places = (np.vstack([tree.line.points, root]) - volume.origin) / volume.spacing
    reach = 2 * tree.line.radius.max() / volume.spacing[0] + 10
    low, high = places.min(axis=0) - reach, places.max(axis=0) + reach + 1
    return part_of(volume, low.astype(int), high.astype(int))
