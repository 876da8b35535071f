"""Cross-sections of vessels: the grey levels on planes across an axis."""

import numpy as np
from scipy.ndimage import map_coordinates

STEP = 0.5
"""Distance of the samples in a section, voxels."""

_SPLINE_REACH = 6  # voxels from which a spline is as if it saw the whole image


def tangents(points: np.ndarray, reach: int = 3) -> np.ndarray:
    """Return the unit direction of the axis through `points` at each, from those `reach` before and after it."""
    rows = np.arange(len(points))
    along = points[np.minimum(rows + reach, len(points) - 1)] - points[np.maximum(rows - reach, 0)]
    return along / np.maximum(np.linalg.norm(along, axis=1, keepdims=True), 1e-12)


def across(axes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return two unit vectors perpendicular to each of `axes` and to one another, each of shape (axis, 3)."""
    u = np.cross(axes, np.eye(3)[np.argmin(np.abs(axes), axis=1)])
    u /= np.linalg.norm(u, axis=1, keepdims=True)
    return u, np.cross(axes, u)


def carried(axes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return what `across` does, the first vectors turning from axis to axis no more than the axes do."""
    u, _ = across(axes)
    for row in range(1, len(u)):
        turned = u[row - 1] - axes[row] * (u[row - 1] @ axes[row])
        u[row] = turned / max(float(np.linalg.norm(turned)), 1e-12)
    return u, np.cross(axes, u)


def disc(reach: float, step: float) -> np.ndarray:
    """Return the points of a square grid of `step` within `reach` of its middle, shape (sample, 2)."""
    side = np.arange(-int(reach / step) - 1, int(reach / step) + 2) * step
    a, b = np.meshgrid(side, side, indexing="ij")
    inside = np.hypot(a, b) <= reach
    return np.column_stack([a[inside], b[inside]])


def sampled(grey: np.ndarray, places: np.ndarray, origin: np.ndarray, spacing: float) -> np.ndarray:
    """Return `grey` interpolated linearly at `places` (z, y, x, cm; any shape + (3,))."""
    coordinates = np.moveaxis((places - origin) / spacing, -1, 0)
    return np.asarray(map_coordinates(grey, coordinates, order=1, mode="nearest", output=np.float32))


def sampled_by_splines(grey: np.ndarray, places: np.ndarray, origin: np.ndarray, spacing: float) -> np.ndarray:
    """Return `grey` interpolated by cubic splines, as `sampled` takes it: what it adds at an edge is a quarter."""
    coordinates = np.moveaxis((places - origin) / spacing, -1, 0)
    around = coordinates.reshape(3, -1)
    last = np.array(grey.shape) - 1
    low = np.clip(np.floor(around.min(axis=1)).astype(int) - _SPLINE_REACH, 0, last)
    high = np.clip(np.ceil(around.max(axis=1)).astype(int) + _SPLINE_REACH, 0, last) + 1
    crop = grey[tuple(map(slice, low, high))]
    shifted = coordinates - low.reshape(3, *[1] * (coordinates.ndim - 1))
    return np.asarray(map_coordinates(crop, shifted, order=3, mode="nearest", output=np.float32))


def medians(values: np.ndarray, chosen: np.ndarray) -> np.ndarray:
    """Return the median of the `chosen` values of each row; each row has one."""
    rows, count = np.sort(np.where(chosen, values, np.inf), axis=1), chosen.sum(axis=1)
    lower, upper = (
        np.take_along_axis(rows, position[:, None], axis=1)[:, 0] for position in ((count - 1) // 2, count // 2)
    )
    return np.asarray((lower + upper) / 2)
