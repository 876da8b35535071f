"""Which voxels are vessel: smoothing by the measured noise, a threshold, the component that holds the seed."""

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from vasowave.base.errors import EXTRAS, InputError
from vasowave.base.findings import look_kind, warn
from vasowave.lung.kernels import smoothed_plane
from vasowave.lung.lumen.inclusions import fill_inclusions
from vasowave.lung.lumen.levels import background_and_noise, levels_of
from vasowave.lung.lumen.pieces import connected_pieces
from vasowave.lung.read.volume import Volume

Segmenter = Callable[[Volume, float, np.ndarray | None], "Segmentation"]
"""Finds the lumen in a volume at a threshold, from a point in it (or the largest)."""
_TRUNCATE = 3.0  # standard deviations of the smoothing
Parts = Callable[[np.ndarray, np.ndarray], np.ndarray]
"""Gives the grey levels of a part of a volume, from a voxel (z, y, x) to before another."""
MARGIN = 3
"""Voxels kept around the lumen."""
LARGE = 1 << 30
"""Bytes of grey levels beyond which a volume is smoothed in parts."""
_SIZE = 4  # bytes of a smoothed grey level
AT_BORDER = look_kind(
    "image.lumen-at-border",
    "the lumen touches the border of the volume: the vessels that leave it end there, cut",
    "Scan or crop wider, if these vessels matter.",
)


def reach_of(width: float) -> int:
    """Return how far smoothing of the standard deviation `width` reaches, voxels."""
    return int(_TRUNCATE * width + 0.5)


def smoothed(grey: np.ndarray, width: float) -> np.ndarray:
    """Return `grey` (shape (z, y, x)) smoothed, float32, by a Gaussian of standard deviation `width`, voxels.

    The image goes on beyond its faces as its mirror image. Planes are read once, so that no second copy is held.
    """
    reach = reach_of(width)
    weights = np.exp(-0.5 / width**2 * np.arange(-reach, reach + 1) ** 2)
    weights = (weights / weights.sum())[reach:]
    along, down, across = (np.pad(np.arange(count), reach, mode="symmetric") for count in grey.shape)
    planes = np.empty((len(weights) + reach, *grey.shape[1:]), dtype=np.float32)  # of each plane those beside it
    result, count = np.empty(grey.shape, dtype=np.float32), len(planes)
    for z in range(len(grey)):
        for new in range(z + reach if z else 0, min(z + reach + 1, len(grey))):
            planes[new % count] = grey[new]
        smoothed_plane(planes, along[z : z + count] % count, down, across, weights, result[z])
    return result


@dataclass(frozen=True, eq=False)
class Segmentation:
    """One connected lumen, cropped.

    Attributes
    ----------
    mask : bool array, shape (z, y, x)
        The lumen within the crop.
    grey : float array, shape (z, y, x)
        Smoothed grey levels of the crop; what is not lumen is below the threshold.
    corner : int array, shape (3,)
        Voxel of the volume at which the crop starts.
    spacing : float
        Voxel size, cm.
    origin : float array, shape (3,)
        Position of the crop's voxel (0, 0, 0), cm.
    threshold, background, noise : float
        Grey levels; noise is the standard deviation measured in the volume.
    apart : tuple of float array, shape (voxel, 3)
        Places, cm, of the voxels of each other piece that is as bright and as large as a vessel.
    inclusions : int array, shape (voxel, 3)
        Voxels of the crop that are dark and were closed: holes, and what the lumen nearly encloses.
    """

    mask: np.ndarray
    grey: np.ndarray
    corner: np.ndarray
    spacing: float
    origin: np.ndarray
    threshold: float
    background: float
    noise: float
    apart: tuple[np.ndarray, ...] = ()
    inclusions: np.ndarray = field(default_factory=lambda: np.empty((0, 3), dtype=np.int32))

    @property
    def roughness(self) -> float:
        """Noise over the contrast between wall and background: how much noise bends the surface."""
        return self.noise / (self.threshold - self.background)

    @cached_property
    def iso_surface(self) -> tuple[np.ndarray, np.ndarray]:
        """Corners of the grey levels' surface, voxels of the crop + 1, and triangles, clockwise seen from outside.

        Raises
        ------
        InputError
            Without the extra 'imaging'.
        """
        try:
            from skimage.measure import marching_cubes
        except ImportError:
            raise InputError(f"the surface needs the extra 'imaging': {EXTRAS}") from None
        grey = np.pad(self.grey, 1, constant_values=float(self.grey.min()))
        corners, triangles, *_ = marching_cubes(grey, self.threshold, gradient_direction="ascent")
        return corners, triangles


def segment(volume: Volume, threshold: float = 45.0, seed: np.ndarray | None = None) -> Segmentation:
    """Return the vessel tree of `volume` brighter than `threshold`.

    Parameters
    ----------
    volume : Volume
        Cubic voxels (see `isotropic`).
    threshold : float
        Grey level of the wall (the paper's 45).
    seed : float array, shape (3,), optional
        A point (z, y, x, cm) in the tree; the largest component where none is given.

    Raises
    ------
    InputError
        Voxels not cubic, nothing or nearly everything above the threshold, a seed outside the lumen.

    Warns
    -----
    VasowaveWarning
        A second tree of comparable size; a lumen that touches the border of the volume.
    """
    levels = Smoothed(volume, threshold)
    bright = levels.brighter(threshold)
    if not bright.any():
        raise InputError(
            f"no voxel is brighter than {threshold:g}; the brightest has {volume.grey.max():.4g}: lower the threshold"
            f"{_about(volume)}"
        )
    if bright.sum() > 0.5 * bright.size:
        raise InputError(
            f"more than half of the volume is brighter than {threshold:g}; raise the threshold{_about(volume)}"
        )
    return connected_lumen(volume, levels.part, bright, threshold, levels, seed, closes_inclusions=True)


def _about(volume: Volume) -> str:
    """Return what a threshold of `volume` may be, in words."""
    levels = levels_of(volume)
    return (
        f" to about {levels.threshold:g} (around the vessels the grey level is {levels.background:.4g}, in the widest "
        f"{levels.lumen:.4g})"
    )


class Smoothed:
    """The grey levels of `volume` (cubic voxels), smoothed as much as noise and contrast need.

    The wall at `threshold` is half the contrast away from the background, so noise over contrast says how much
    smoothing the surface needs. A large volume is smoothed in parts, when they are asked for.

    Attributes
    ----------
    background, noise : float
        Grey levels; noise is its standard deviation.

    Raises
    ------
    InputError
        Voxels not cubic.
    """

    def __init__(self, volume: Volume, threshold: float) -> None:
        if not np.allclose(volume.spacing, volume.spacing[0], rtol=2e-3):
            raise InputError(f"segment: spacing {volume.spacing} cm is not cubic; resample it first (`isotropic`)")
        self.background: float
        self.noise: float
        self.background, self.noise = background_and_noise(volume)
        self._grey = np.asarray(volume.grey)
        self._width = float(np.clip(0.5 + 1.1 * self.noise / self.contrast(threshold), 0.5, 1.3))
        self._reach = reach_of(self._width)
        self._slab = max(1, LARGE // (_SIZE * self._grey[0].size))  # planes

    def contrast(self, threshold: float) -> float:
        """Return how far a wall at `threshold` is above the background."""
        return max(threshold - self.background, 1e-9)

    @cached_property
    def whole(self) -> np.ndarray:
        """Return all levels."""
        return smoothed(self._grey, self._width)

    def part(self, low: np.ndarray, high: np.ndarray) -> np.ndarray:
        """Return the levels from voxel `low` to before `high`, as they are in the whole."""
        if self._slab >= len(self._grey):
            return self.whole[_box(low, high)]
        around = np.maximum(low - self._reach, 0), np.minimum(high + self._reach, self._grey.shape)
        levels = smoothed(self._grey[_box(*around)], self._width)
        return levels[_box(low - around[0], high - around[0])]

    def brighter(self, threshold: float) -> np.ndarray:
        """Return which voxels are brighter than `threshold`, bool, shape of the volume."""
        bright = np.empty(self._grey.shape, dtype=bool)
        for first in range(0, len(bright), self._slab):
            low, high = np.array([first, 0, 0]), np.array([min(first + self._slab, len(bright)), *bright.shape[1:]])
            np.greater(self.part(low, high), threshold, out=bright[_box(low, high)])
        return bright


def parts_of(grey: np.ndarray) -> Parts:
    """Return what gives parts of grey levels that are there as a whole."""
    return lambda low, high: grey[_box(low, high)]


def _box(low: np.ndarray, high: np.ndarray) -> tuple[slice, ...]:
    return tuple(slice(a, b) for a, b in zip(low, high, strict=True))


def connected_lumen(
    volume: Volume,
    crop: Parts,
    bright: np.ndarray,
    threshold: float,
    levels: Smoothed,
    seed: np.ndarray | None,
    closes_inclusions: bool = False,
) -> Segmentation:
    """Return the piece of `bright` (bool, shape of the volume) that holds `seed`, or the largest, holes filled.

    Where the levels of a `crop` contradict the piece, they are set to just above or below the threshold. What the piece
    encloses nearly is filled if `closes_inclusions`: a cut that was drawn by hand stays.
    """
    contrast = levels.contrast(threshold)
    voxels, other_pieces = connected_pieces(volume, bright, seed)
    low, high = voxels.min(axis=0), voxels.max(axis=0) + 1
    if (low == 0).any() or (high == bright.shape).any():
        warn(AT_BORDER(), stacklevel=3)
    low, high = np.maximum(low - MARGIN, 0), np.minimum(high + MARGIN, bright.shape)
    mask = np.zeros(high - low, dtype=bool)
    mask[tuple((voxels - low).T)] = True
    inclusions = fill_inclusions(mask, voxels - low, closes_inclusions)
    local = crop(low, high)
    inside = np.maximum(local[mask], threshold + 1e-3 * contrast)
    local = np.minimum(local, threshold - 1e-6)
    local[mask] = inside
    spacing = float(volume.spacing[0])
    origin = volume.origin + low * spacing
    return Segmentation(mask, local, low, spacing, origin, threshold, threshold - contrast, levels.noise,
                        tuple(volume.origin + piece * volume.spacing for piece in other_pieces),
                        inclusions)  # fmt: skip
