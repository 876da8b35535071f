"""A grey-level volume on a grid of known spacing."""

import math
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from vasowave.base.errors import InputError
from vasowave.base.findings import Finding
from vasowave.lung.places import Frame

SKEWED = 1e-2
"""Axes that are no rotation within this are damaged."""

VOXELS = (1e-6, 5.0)
"""Sizes of voxels outside are no image's of an animal, cm: from 10 nm to ten times the slices of a clinical scanner."""

MOST_VOXELS = 2**33
"""No volume is resampled to more: 32 GiB of grey levels, for which no machine of a lab has the memory."""


UNSIZED = np.full(3, np.nan)
"""Spacing of an image whose file does not say it."""


class Image(NamedTuple):
    """What a file holds: grey levels in their own type, spacing, origin, axes and provenance as `Volume`.

    Where a file does not say the size of a voxel, the spacing is `UNSIZED` and the provenance is why. Findings tell
    what is odd.
    """

    grey: np.ndarray
    spacing: np.ndarray
    origin: np.ndarray
    axes: np.ndarray = np.eye(3)
    provenance: str = ""
    findings: tuple[Finding, ...] = ()


@dataclass(frozen=True, eq=False)
class Volume:
    """Grey levels and where they lie.

    Attributes
    ----------
    grey : array, shape (z, y, x)
        Whole numbers of 8 or 16 bits as they are, which takes a half or a quarter of the memory; all others as float32.
    spacing : float array, shape (3,)
        Distance of neighboring voxels along z, y, x, cm.
    origin : float array, shape (3,)
        Position of voxel (0, 0, 0), z, y, x, cm.
    axes : float array, shape (3, 3)
        Directions of the image's axes in the world, see `Frame`; the identity where it lies straight.
    provenance : str
        What says the size of a voxel; empty for an image of arrays.

    Raises
    ------
    InputError
        Not three-dimensional, values that are not finite, one grey level everywhere, a spacing that is not positive, an
        origin that is not finite, axes that are not perpendicular.
    """

    grey: np.ndarray
    spacing: np.ndarray
    origin: np.ndarray
    axes: np.ndarray = field(default_factory=lambda: np.eye(3))
    provenance: str = ""

    def __post_init__(self) -> None:
        """Check the grid and the grey levels once, and freeze them."""
        for name in ("grey", "spacing", "origin", "axes"):
            array = np.asarray(getattr(self, name))
            array = np.asarray(array, dtype=_levels(array.dtype) if name == "grey" else np.float64).view()
            array.setflags(write=False)
            object.__setattr__(self, name, array)
        if self.grey.ndim != 3 or min(self.grey.shape) < 3:
            raise InputError(f"volume: shape {self.grey.shape}; a stack of at least 3 x 3 x 3 voxels is needed")
        if self.spacing.shape != (3,) or not (np.isfinite(self.spacing).all() and (self.spacing > 0).all()):
            raise InputError(f"volume: spacing {self.spacing} cm; give three positive numbers (z, y, x)")
        if not (self.spacing.min() >= VOXELS[0] and self.spacing.max() <= VOXELS[1]):
            raise InputError(
                f"volume: spacing {self.spacing} cm; voxels of an animal measure {VOXELS[0]:g} to {VOXELS[1]:g} cm; is "
                "the unit right?"
            )
        if self.origin.shape != (3,) or not np.isfinite(self.origin).all():
            raise InputError(f"volume: origin {self.origin} cm; give three finite numbers (z, y, x)")
        if self.axes.shape != (3, 3) or not np.allclose(self.axes @ self.axes.T, np.eye(3), atol=SKEWED):
            raise InputError(f"volume: axes {self.axes.tolist()}; give three perpendicular directions of length 1")
        lowest, highest = self.grey.min(), self.grey.max()
        if not np.isfinite([lowest, highest]).all():
            raise InputError("volume: grey levels that are not finite (NaN or infinity); repair the reconstruction")
        if lowest == highest:
            raise InputError(f"volume: every voxel has grey level {self.grey.flat[0]:g}; is this the right file?")

    @property
    def frame(self) -> Frame:
        """How the image's axes lie in the world."""
        return Frame(self.origin, self.axes)


def _levels(dtype: np.dtype) -> np.dtype:
    """Return the type that holds grey levels of a type, exactly where float32 does."""
    small = dtype.kind in "iu" and dtype.itemsize <= 2
    return dtype.newbyteorder("=") if small else np.dtype(np.float32)


def part_of(volume: Volume, low: np.ndarray, high: np.ndarray) -> Volume:
    """Return the voxels from `low` up to `high` (z, y, x), as far as there are any, without a copy."""
    low = np.maximum(low, 0)
    grey = volume.grey[tuple(map(slice, low, high))]
    return Volume(grey, volume.spacing, volume.origin + low * volume.spacing, volume.axes, volume.provenance)


def is_cubic(volume: Volume) -> bool:
    """Whether the voxels are cubes within 0.1 %."""
    return bool(np.allclose(volume.spacing, volume.spacing.min(), rtol=1e-3))


def isotropic(volume: Volume) -> Volume:
    """Return `volume` resampled linearly to cubes of exactly its smallest spacing; unchanged if cubic within 0.1 %.

    The first voxel stays where it is; less than one voxel is lost at the far end of an axis.

    Raises
    ------
    InputError
        It would have more than `MOST_VOXELS` cubes; nothing was computed.
    """
    from scipy.ndimage import affine_transform

    if is_cubic(volume):
        return volume
    smallest = float(volume.spacing.min())
    step = smallest / volume.spacing
    counts = np.floor((np.array(volume.grey.shape) - 1) / step + 1e-6).astype(int) + 1
    if math.prod(counts.tolist()) > MOST_VOXELS:
        z, y, x = volume.spacing
        raise InputError(
            f"volume: voxels of {x:.3g} x {y:.3g} x {z:.3g} cm would be resampled to {counts.prod(dtype=float):.2g} "
            f"cubes of {smallest:.3g} cm, more than {MOST_VOXELS:.2g}; is the unit right? Otherwise resample the image "
            "to larger voxels, or cut out a part"
        )
    grey = affine_transform(volume.grey, step, output_shape=tuple(counts), order=1, mode="nearest", output=np.float32)
    return Volume(grey, np.full(3, smallest), volume.origin, volume.axes, volume.provenance)
