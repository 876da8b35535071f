"""How much the radii of a tree depend on the threshold."""

import warnings
from dataclasses import replace

import numpy as np

from vasowave.errors import InputError, VasowaveWarning
from vasowave.imaging.axes.stretches import clear_stretches
from vasowave.imaging.axes.vessels import in_another_lumen
from vasowave.imaging.lumen.segmentation import Segmentation, Segmenter
from vasowave.imaging.measure.measurement import Measurement
from vasowave.imaging.measure.radii import densitometry
from vasowave.imaging.measure.sizes import network_of
from vasowave.imaging.read.volume import Volume
from vasowave.imaging.tree import Tree

FACTORS = 0.8, 1.2
"""The radii are measured again at these multiples of the threshold."""
ENDS = 0.3
"""Standard deviation of the places of a vessel's ends that no threshold shows, voxels."""


def with_spread(
    measured: Measurement, volume: Volume, root: np.ndarray, threshold: float, segmenter: Segmenter
) -> Measurement:
    """Return `measured` with the SD of each vessel's radius and length over three thresholds.

    At 0.8 and 1.2 times `threshold` the axes of the tree are fitted and all radii measured anew, each by the estimator
    that it has in `measured`.

    Parameters
    ----------
    measured : Measurement
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
        No lumen at a threshold; vessels that are not in it.
    """
    tree, radius = measured.tree, measured.network.radius
    part = _around(volume, tree, root)
    radii, lengths = [radius], [measured.network.length]
    for level in (factor * threshold for factor in FACTORS):
        try:
            sizes = _sizes_in(segmenter(part, level, root), tree, part, np.isfinite(measured.densitometric))
        except InputError as error:
            _warn(f"at threshold {level:g} no tree, so radius_sd is unknown: {error}")
            sizes = np.full((2, len(radius)), np.nan)
        radii.append(sizes[0])
        lengths.append(sizes[1])
    grey = np.zeros(len(radius)) if measured.grey is None else np.nan_to_num(measured.grey.sd)
    spacing = float(volume.spacing[0])
    spread = np.hypot(np.std(radii, axis=0, ddof=1), grey)
    return replace(measured, radius_sd=spread, length_sd=np.hypot(np.std(lengths, axis=0, ddof=1), ENDS * spacing))


def _sizes_in(lumen: Segmentation, tree: Tree, volume: Volume, dense: np.ndarray) -> np.ndarray:
    lost = ~_in_lumen(tree, lumen)
    if lost.any():
        names = ", ".join(str(row + 1) for row in np.flatnonzero(lost))
        _warn(f"at threshold {lumen.threshold:g} the lumen does not hold vessel(s) {names}: radius_sd is unknown there")
    again = in_another_lumen(tree, lumen)
    network = network_of(again)
    inscribed = network.radius
    radius = np.where(dense, densitometry(again, volume, inscribed).radius, inscribed)
    return np.where(lost, np.nan, [radius, network.length])


def _in_lumen(tree: Tree, lumen: Segmentation) -> np.ndarray:
    """Return whether most of each vessel's clear stretch lies in `lumen`."""
    inside = []
    for line, (begin, end) in zip(tree.lines, clear_stretches(tree), strict=True):
        clear = (line.run > begin) & (line.run < end)
        points = line.points[clear] if clear.any() else line.points[len(line) // 2 :]
        voxels = np.round((points - lumen.origin) / lumen.spacing).astype(int)
        seen = ((voxels >= 0) & (voxels < lumen.mask.shape)).all(axis=1)
        seen[seen] = lumen.mask[tuple(voxels[seen].T)]
        inside.append(seen.mean() > 0.5)
    return np.array(inside)


def _around(volume: Volume, tree: Tree, root: np.ndarray) -> Volume:
    """Return the part of `volume` that holds `tree` and `root`, without a copy."""
    places = (np.vstack([tree.line.points, root]) - volume.origin) / volume.spacing
    reach = 2 * tree.line.radius.max() / volume.spacing[0] + 10
    low = np.maximum(places.min(axis=0) - reach, 0).astype(int)
    high = (places.max(axis=0) + reach + 1).astype(int)
    box = tuple(slice(a, b) for a, b in zip(low, high, strict=True))
    return Volume(volume.grey[box], volume.spacing, volume.origin + low * volume.spacing)


def _warn(message: str) -> None:
    warnings.warn(message, VasowaveWarning, stacklevel=4)
