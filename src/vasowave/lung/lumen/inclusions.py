"""Dark inclusions of the lumen, as clots and bubbles: closed where the lumen lies around them on nearly all sides."""

from dataclasses import dataclass, replace

import numpy as np
from scipy import ndimage
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from vasowave.lung.kernels import enclosed_voxels, encloses
from vasowave.lung.read.volume import Volume


@dataclass(frozen=True)
class InclusionRules:
    """When a dark place is one of the lumen's own.

    Attributes
    ----------
    min_directions : int
        So many of the 26 directions to neighbors meet the lumen.
    min_rim : int
        And so many where it goes on from there: outside a round vessel fewer than 13 do.
    min_seed_share : float
        So much of it meets the lumen in `min_directions`: of clefts among three vessels 1 to 6 %, of clots a third.
    reach_radii : float
        Within so many mean radii of the lumen.
    min_voxels : int
        What is smaller is a dent of noise.
    window : int
        The agent's level is that of the lumen within so many voxels.
    """

    min_directions: int = 22
    min_rim: int = 15
    min_seed_share: float = 0.2
    reach_radii: float = 3.0
    min_voxels: int = 8
    window: int = 6


RULES = InclusionRules()
_TOUCHING = np.ones((3, 3, 3), dtype=bool)


def dark_inclusions(mask: np.ndarray, voxels: np.ndarray) -> np.ndarray:
    """Return the voxels (shape (voxel, 3)) that `mask` nearly encloses; it is bool, and consists of `voxels`."""
    stamps = np.zeros(mask.shape, dtype=np.uint8)
    places, seeds = enclosed_voxels(mask, voxels, stamps, RULES.reach_radii, RULES.min_directions, RULES.min_rim)
    return large_pieces(np.array(places, dtype=np.int32).reshape(-1, 3), seeds)


def large_pieces(voxels: np.ndarray, seeds: int) -> np.ndarray:
    """Return those of the `voxels` whose connected piece is no dent of noise, and no cleft: the first are `seeds`."""
    if len(voxels) < RULES.min_voxels:
        return voxels[:0]
    pairs = cKDTree(voxels).query_pairs(1.8, output_type="ndarray")
    graph = coo_array((np.ones(len(pairs), dtype=bool), pairs.T), shape=(len(voxels),) * 2)
    labels = connected_components(graph, directed=False)[1]
    size = np.bincount(labels)
    sure = np.bincount(labels[:seeds], minlength=len(size))
    return np.asarray(voxels[((size >= RULES.min_voxels) & (sure >= RULES.min_seed_share * size))[labels]])


def without_inclusions(volume: Volume, mask: np.ndarray, corner: np.ndarray, inclusions: np.ndarray) -> Volume:
    """Return `volume` with the inclusions as bright as the agent around each; a copy if there are any.

    The blurred rim of an inclusion is filled too, but for the outermost voxels of the lumen, which are the wall's.

    Parameters
    ----------
    volume : Volume
    mask : bool array, shape (z, y, x)
        The lumen with its inclusions, within a crop.
    corner : int array, shape (3,)
        Voxel of `volume` at which the crop starts.
    inclusions : int array, shape (voxel, 3)
        Voxels of the crop.
    """
    if len(inclusions) == 0:
        return volume
    grey = np.array(volume.grey)
    crop = grey[tuple(slice(first, first + count) for first, count in zip(corner, mask.shape, strict=True))]
    inside = np.zeros(mask.shape, dtype=bool)
    inside[tuple(inclusions.T)] = True
    pieces, count = ndimage.label(inside, _TOUCHING)
    for label, place in enumerate(ndimage.find_objects(pieces, count), 1):
        window = tuple(slice(max(side.start - RULES.window, 0), side.stop + RULES.window) for side in place)
        lumen = mask[window]
        filled = ndimage.binary_dilation(pieces[window] == label, _TOUCHING, 2)
        core = ndimage.binary_erosion(lumen, border_value=1)
        agent = crop[window][core & ~filled]
        if len(agent):
            filled &= core
            crop[window][filled] = np.maximum(crop[window][filled], np.median(agent))
    return replace(volume, grey=grey)


def fill_inclusions(mask: np.ndarray, voxels: np.ndarray, closes_inclusions: bool) -> np.ndarray:
    """Fill the holes of `mask`, which consists of `voxels`, and what it nearly encloses; return the inclusions."""
    holes = _holes(mask)
    mask |= holes
    if not closes_inclusions:
        return np.empty((0, 3), dtype=np.int32)
    dark = dark_inclusions(mask, voxels)
    mask[tuple(dark.T)] = True
    closed = np.argwhere(holes).astype(np.int32)
    return np.vstack([large_pieces(closed, len(closed)), dark]) if len(closed) else dark


def _holes(mask: np.ndarray) -> np.ndarray:
    """Return what `mask`, one piece, encloses."""
    if not encloses(np.pad(mask, 1)):
        return np.zeros_like(mask)
    outside, count = ndimage.label(~mask)
    faces = [np.take(outside, end, axis=axis).ravel() for axis in range(3) for end in (0, -1)]
    enclosed = np.setdiff1d(np.arange(1, count + 1), np.concatenate(faces))
    return np.isin(outside, enclosed)
