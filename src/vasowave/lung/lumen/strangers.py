"""Strangers that hang together with the lumen: plates of holders, and wide tubes that leave the image."""

from dataclasses import dataclass, replace

import numpy as np
from scipy import ndimage

from vasowave.base.findings import look_kind, warn
from vasowave.lung.lumen.segmentation import Segmentation


@dataclass(frozen=True)
class StrangerRules:
    """When what touches vessels counts as a holder or an organ; `d` is its radius, or half a plate's thickness, voxels.

    Attributes
    ----------
    max_width : float
        A tube wider than so many radii of the root.
    min_spread : float
        A plate leaves through an area so many times that of its inscribed circle.
    core, thickest : float
        The middle of a stranger lies so many d deep at least; that of a plate at most so many.
    medial : float
        It is no shallower than this share of the deepest around it.
    min_fill : float
        d³ of lumen in a box of 8 d around the middle of a plate; tubes have 25 to 75.
    min_extent, gap : float
        Edge of a plate, and reach of what closes gaps in it, d.
    thicknesses, min_inner_extent
        Half the thicknesses at which plates that end within the image are looked for, voxels of the grid, and their
        edge, d: a flat vessel is long, but not wide.
    rim : float
        So many voxels around a stranger are cut too.
    max_edge, reach : int
        Strangers are looked for on a grid of so many voxels along an edge; the root's depth so near to the root.
    """

    max_width: float = 1.3
    min_spread: float = 10.0
    core: float = 0.8
    thickest: float = 1.5
    medial: float = 0.85
    min_fill: float = 90.0
    min_extent: float = 6.0
    gap: float = 2.5
    thicknesses: tuple[float, ...] = (2.0, 2.8, 4.0, 5.6, 8.0)
    min_inner_extent: float = 10.0
    rim: float = 1.5
    max_edge: int = 160
    reach: int = 8


RULES = StrangerRules()
_WINDOW = 40  # voxels around the root: its vessel is no wider
_TOUCHING = np.ones((3, 3, 3), dtype=bool)
STRANGER = look_kind(
    "image.stranger",
    "a plate or a tube {width:.2g} cm thick touches the vessels and is probably a holder or a neighboring organ: "
    "{share:.0%} of the lumen were cut off, and vessels that touch it end there: {remedy}",
    "look, and give a mask or a region without it",
)
STRANGER_LEFT = look_kind(
    "image.stranger-left",
    "a plate or a tube {width:.2g} cm thick touches the vessels, is probably a holder or a neighboring organ, and "
    "could not be cut off without the vessels: {remedy}",
    "look, and give a mask or a region without it",
)


def without_strangers(lumen: Segmentation, shape: tuple[int, ...], root: np.ndarray | None = None) -> Segmentation:
    """Return `lumen` without plates, and without tubes that leave the image; warn of what was cut off.

    Parameters
    ----------
    lumen : Segmentation
    shape : tuple of int
        Of the volume, voxels.
    root : float array, shape (3,), optional
        Where the blood enters, cm; without it plates alone are cut.
    """
    spots = _spots(lumen, shape)
    plates = [radius for radius, area in spots if area > RULES.min_spread * np.pi * radius**2]
    width = np.inf if root is None or not spots else RULES.max_width * _depth_at(lumen, root)
    tubes = [radius for radius, _ in spots if radius > width]
    step = -(-max(lumen.mask.shape) // RULES.max_edge)
    coarse = lumen.mask[::step, ::step, ::step]
    depth = step * ndimage.distance_transform_edt(coarse)
    core = _leaving(depth >= RULES.core * min(tubes, default=np.inf))
    for radius in plates:
        core |= _plate(coarse, depth, radius, step, RULES.min_extent)
    for radius in step * np.array(RULES.thicknesses):
        core |= _plate(coarse, depth, radius, step, RULES.min_inner_extent)
    if not plates and not tubes and not core.any():
        return lumen
    if not core.any():
        return _uncut(lumen, [*plates, *tubes])
    thick = float(np.median(depth[core]))
    away = step * ndimage.distance_transform_edt(~core)
    cut = (away <= depth[core].max() + RULES.rim + step - 1).repeat(step, 0).repeat(step, 1).repeat(step, 2)
    piece = _piece_at(lumen, lumen.mask & ~cut[tuple(map(slice, lumen.mask.shape))], root)
    if piece is None:
        return _uncut(lumen, [*plates, *tubes] or [thick])
    warn(STRANGER(width=2 * thick * lumen.spacing, share=1 - float(piece.sum() / lumen.mask.sum())))
    lost = lumen.mask & ~piece
    grey = np.where(lost, np.minimum(lumen.grey, lumen.threshold - 1e-6), lumen.grey)
    return replace(lumen, mask=piece, grey=grey)


def _uncut(lumen: Segmentation, radii: list[float]) -> Segmentation:
    warn(STRANGER_LEFT(width=2 * max(radii) * lumen.spacing), stacklevel=3)
    return lumen


def _leaving(core: np.ndarray) -> np.ndarray:
    """Return the pieces of `core` that reach a face of the crop."""
    pieces, _ = ndimage.label(core, _TOUCHING)
    ends = [np.take(pieces, end, axis=axis).ravel() for axis in range(3) for end in (0, -1)]
    return np.isin(pieces, np.setdiff1d(np.concatenate(ends), [0]))


def _spots(lumen: Segmentation, shape: tuple[int, ...]) -> list[tuple[float, int]]:
    """Return inscribed radius and area, voxels, of each place where the lumen meets a face of the image."""
    spots = []
    for axis in range(3):
        ends = lumen.corner[axis] == 0, lumen.corner[axis] + lumen.mask.shape[axis] == shape[axis]
        for end, is_face in zip((0, -1), ends, strict=True):
            plane = np.take(lumen.mask, end, axis=axis)
            if not is_face or not plane.any():
                continue
            labels, count = ndimage.label(plane)
            depth = ndimage.distance_transform_edt(plane)
            radii = ndimage.maximum(depth, labels, np.arange(1, count + 1))
            spots += list(zip(map(float, radii), np.bincount(labels.ravel())[1:].tolist(), strict=True))
    return spots


def _depth_at(lumen: Segmentation, root: np.ndarray) -> float:
    """Return the greatest distance to the wall near the root, voxels; infinite where no lumen is."""
    middle = np.round((root - lumen.origin) / lumen.spacing).astype(int)
    low, high = np.maximum(middle - _WINDOW, 0), np.maximum(middle + _WINDOW + 1, 0)
    around = lumen.mask[tuple(map(slice, low, high))]
    if not around.any() or around.all():
        return np.inf
    depth = ndimage.distance_transform_edt(around)
    center = middle - low
    nearest = depth[tuple(map(slice, np.maximum(center - RULES.reach, 0), center + RULES.reach + 1))]
    return float(nearest.max(initial=0.0)) or np.inf


def _plate(coarse: np.ndarray, depth: np.ndarray, radius: float, step: int, min_extent: float) -> np.ndarray:
    """Return the middle of plates of half the thickness `radius`: flat where a tube of that width would be slender."""
    min_voxels = (min_extent * radius / step) ** 2
    medial = (depth >= RULES.core * radius) & (depth <= RULES.thickest * radius)
    medial &= depth >= RULES.medial * ndimage.maximum_filter(depth, 2 * int(np.ceil(radius / step)) + 1)
    if medial.sum() < min_voxels:
        return np.zeros_like(coarse)
    edge = int(8 * radius / step) | 1
    fill = ndimage.uniform_filter(coarse.astype(np.float32), edge, mode="nearest") * (edge * step) ** 3
    pieces, _ = ndimage.label(medial & (fill > RULES.min_fill * radius**3), _TOUCHING)
    large = np.bincount(pieces.ravel()) >= min_voxels
    if not large[1:].any():
        return np.zeros_like(coarse)
    large[0] = False
    reach = int(np.ceil(RULES.gap * radius / step))  # where a vessel touches, the plate is thicker
    padded = np.pad(large[pieces], reach, mode="edge")
    closed = ndimage.binary_closing(padded, _TOUCHING, reach)[tuple(slice(reach, -reach) for _ in range(3))]
    return np.asarray(closed & coarse)


def _piece_at(lumen: Segmentation, mask: np.ndarray, root: np.ndarray | None) -> np.ndarray | None:
    """Return the piece of `mask` nearest to the root, or the largest; None without one at the root."""
    pieces, count = ndimage.label(mask)
    if not count:
        return None
    if root is None:
        return np.asarray(pieces == 1 + int(np.argmax(np.bincount(pieces.ravel())[1:])))
    voxels = np.argwhere(mask)
    gap = np.linalg.norm(voxels * lumen.spacing + lumen.origin - root, axis=1)
    nearest = int(np.argmin(gap))
    return None if gap[nearest] > RULES.reach * lumen.spacing else np.asarray(pieces == pieces[tuple(voxels[nearest])])
