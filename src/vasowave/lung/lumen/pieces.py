"""Connected pieces of what is bright: the one that is the tree, and others as large as a vessel."""

import numpy as np
from scipy import ndimage
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from vasowave.base.errors import InputError
from vasowave.base.findings import look_kind, warn
from vasowave.lung.places import written
from vasowave.lung.read.volume import Volume

MIN_PIECE_VOXELS, MIN_PIECE_SHARE = 100, 0.003
"""A separate piece of so many voxels, and of such a share of the lumen, is as large as a vessel."""
TWO_TREES = look_kind(
    "image.two-trees", "two separate trees ({larger} and {smaller} voxels): took the larger; {remedy}", "a seed chooses"
)
BRANCHES = look_kind(
    "image.holder",
    "the largest bright piece ({larger} voxels) does not branch, as holders and tubes do not: took the piece of "
    "{smaller} voxels that does; {remedy}",
    "a seed chooses",
)
COMPARABLE_SHARE, MAX_COMPARED = 0.1, 8
"""A piece with a larger share of the voxels of the largest may be another tree; of the so many largest, one that
branches is the tree beside a holder, which may be many times its size."""
COARSE_EDGE, MIN_ENDS, MORE_ENDS = 96, 3, 2.0
"""Pieces are cut across on a grid of so many voxels; a tree falls into so many spots, and so many times as many."""
MIN_CUT_SHARE = 0.5
"""Cuts through less than this share of the mean area graze a wall, which noise breaks into spots."""


def connected_pieces(
    volume: Volume, bright: np.ndarray, seed: np.ndarray | None
) -> tuple[np.ndarray, list[np.ndarray]]:
    """Return the voxels of the connected piece of `bright` that holds `seed`, or of the largest, shape (voxel, 3), and
    those of each other piece that is as large as a vessel.

    Only the bright voxels are looked at, a few in a thousand: labels for all would take half a gigabyte.
    """
    places = np.flatnonzero(bright)
    if len(places) == 0:
        raise InputError("the lumen is empty; check the mask, the region and the threshold")
    voxels = np.stack([coordinate.astype(np.int32) for coordinate in np.unravel_index(places, bright.shape)], axis=1)
    links = []
    for axis, stride in enumerate((bright.shape[1] * bright.shape[2], bright.shape[2], 1)):
        inner = np.flatnonzero(voxels[:, axis] < bright.shape[axis] - 1)
        inner = inner[bright.ravel()[places[inner] + stride]]
        links.append((inner.astype(np.int32), np.searchsorted(places, places[inner] + stride).astype(np.int32)))
    rows, columns = (np.concatenate(side) for side in zip(*links, strict=True))
    del links
    touching = coo_array((np.ones(len(rows), dtype=bool), (rows, columns)), shape=(len(places), len(places)))
    labels = connected_components(touching, directed=False)[1]
    chosen, sizes = _chosen(volume, voxels, labels, seed), np.bincount(labels)
    large = np.flatnonzero(sizes >= max(MIN_PIECE_VOXELS, MIN_PIECE_SHARE * sizes[chosen]))
    return voxels[labels == chosen], [voxels[labels == label] for label in large if label != chosen]


def _chosen(volume: Volume, voxels: np.ndarray, labels: np.ndarray, seed: np.ndarray | None) -> int:
    """Return the label of the voxel at `seed`, or the commonest."""
    if seed is not None:
        matches = np.flatnonzero((voxels == np.round((np.asarray(seed) - volume.origin) / volume.spacing)).all(axis=1))
        if len(matches) == 0:
            raise InputError(
                f"the point {written(np.asarray(seed))} cm (x,y,z) is not inside a vessel; move it or the threshold"
            )
        return int(labels[matches[0]])
    sizes = np.append(np.bincount(labels), 0)
    largest, second, *smaller = np.argsort(sizes)[::-1][:MAX_COMPARED].tolist()
    large = max(MIN_PIECE_VOXELS, MIN_PIECE_SHARE * sizes[largest])
    pieces = [label for label in (largest, second, *smaller) if sizes[label] >= large]
    if len(pieces) < 2:
        return int(largest)
    spots = {label: _spots_across(voxels[labels == label]) for label in pieces}
    best = max(spots, key=lambda label: spots[label])
    if spots[best] >= max(MIN_ENDS, MORE_ENDS * spots[int(largest)]):
        warn(BRANCHES(larger=int(sizes[largest]), smaller=int(sizes[best])), stacklevel=3)
        return best
    if sizes[second] > COMPARABLE_SHARE * sizes[largest]:
        warn(TWO_TREES(larger=int(sizes[largest]), smaller=int(sizes[second])), stacklevel=3)
    return int(largest)


def _spots_across(voxels: np.ndarray) -> int:
    """Return into how many spots a piece falls where it is cut across, at most: a tree into its vessels."""
    low = voxels.min(axis=0)
    size = int(np.ceil((voxels.max(axis=0) - low + 1).max() / COARSE_EDGE))
    coarse = np.zeros((voxels.max(axis=0) - low) // size + 1, dtype=bool)
    coarse[tuple(((voxels - low) // size).T)] = True
    within = np.zeros((3, 3, 3), dtype=int)
    within[1] = 1
    counts = []
    for axis in range(3):
        planes = np.moveaxis(coarse, axis, 0)
        spots, _ = ndimage.label(planes, within)
        area = planes.sum(axis=(1, 2))
        cuts = spots[area >= MIN_CUT_SHARE * area.mean()]
        counts.append(np.quantile([len(np.unique(plane[plane > 0])) for plane in cuts], 0.95))
    return int(max(counts))
