"""The lumen for other programs: its mask as an image, its smoothed surface as triangles."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.sparse import coo_array, diags_array

from vasowave.errors import InputError
from vasowave.imaging.polydata import data_array
from vasowave.imaging.segmentation import Segmentation
from vasowave.imaging.volume import Volume

_SHRINK, _SWELL = 0.5, -0.53  # Taubin's pair: smooths without losing volume


@dataclass(frozen=True, eq=False)
class Surface:
    """A closed surface of triangles.

    Attributes
    ----------
    points : float array, shape (point, 3)
        z, y, x, cm.
    triangles : int array, shape (triangle, 3)
        Rows of `points`; counter-clockwise seen from outside.
    """

    points: np.ndarray
    triangles: np.ndarray


def smooth_surface(lumen: Segmentation, rounds: int = 10) -> Surface:
    """Return the iso-surface of the lumen's grey levels, smoothed by `rounds` of Taubin's two steps.

    Raises
    ------
    InputError
        Without the extra 'imaging'.
    """
    try:
        from skimage.measure import marching_cubes
    except ImportError:
        raise InputError("the surface needs the extra 'imaging': install vasowave[imaging]") from None
    grey = np.pad(lumen.grey, 1, constant_values=float(lumen.grey.min()))
    corners, triangles = marching_cubes(grey, lumen.threshold, gradient_direction="ascent")[:2]
    mean = _neighbor_mean(triangles, len(corners))
    for _ in range(rounds):
        for weight in (_SHRINK, _SWELL):
            corners = corners + weight * (mean @ corners - corners)
    return Surface((corners - 1) * lumen.spacing + lumen.origin, triangles[:, ::-1])


def enclosed_volume(surface: Surface) -> float:
    """Return the volume inside a closed surface, cm³: positive if its triangles face outward."""
    a, b, c = (surface.points[surface.triangles[:, k], ::-1] for k in range(3))
    return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6)


def write_stl(surface: Surface, path: str | Path) -> None:
    """Write `surface` as binary STL, x, y, z in mm, as Slicer and ITK-SNAP do."""
    corners = (10 * surface.points[:, ::-1]).astype("<f4")[surface.triangles]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-30)
    table = np.zeros(len(corners), dtype=[("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("count", "<u2")])
    table["normal"], table["corners"] = normal, corners
    with Path(path).open("wb") as file:
        file.write(b"lumen, mm".ljust(80))
        file.write(np.array(len(corners), "<u4").tobytes())
        file.write(table.tobytes())


def write_surface_vtp(surface: Surface, path: str | Path) -> None:
    """Write `surface` as VTK PolyData, x, y, z in mm: binary, compressed with zlib."""
    ends = 3 * np.arange(1, len(surface.triangles) + 1)
    Path(path).write_text(
        '<?xml version="1.0"?>\n<VTKFile type="PolyData" version="1.0" byte_order="LittleEndian" '
        'header_type="UInt64" compressor="vtkZLibDataCompressor"><PolyData>\n'
        f'<Piece NumberOfPoints="{len(surface.points)}" NumberOfVerts="0" NumberOfLines="0" NumberOfStrips="0" '
        f'NumberOfPolys="{len(surface.triangles)}">\n'
        f"<Points>{data_array('Points', 10 * surface.points[:, ::-1], 'Float32')}</Points>\n"
        f"<Polys>{data_array('connectivity', surface.triangles.ravel(), 'Int64')}\n"
        f"{data_array('offsets', ends, 'Int64')}</Polys>\n"
        "</Piece></PolyData></VTKFile>\n",
        encoding="ascii",
    )


def write_mask(lumen: Segmentation, image: Volume, path: str | Path) -> None:
    """Write the lumen's voxels as an image of 0 and 1 on the grid of `image` (.nrrd, .nii.gz, .mha), spacing in mm.

    Parameters
    ----------
    lumen : Segmentation
    image : Volume
        The volume as read; a lumen found on a resampled grid goes back to the nearest voxels.
    path : path
    """
    try:
        import SimpleITK
    except ImportError:
        raise InputError("writing images needs the extra 'imaging': install vasowave[imaging]") from None
    found = SimpleITK.GetImageFromArray(full_mask(lumen, image).astype(np.uint8))
    found.SetSpacing([float(h) for h in image.spacing[::-1] * 10])
    found.SetOrigin([float(h) for h in image.origin[::-1] * 10])
    SimpleITK.WriteImage(found, str(path), True)


def full_mask(lumen: Segmentation, image: Volume) -> np.ndarray:
    """Return which voxels of `image` lie in the lumen, bool, shape (z, y, x)."""
    inside = np.zeros(image.grey.shape, dtype=bool)
    places = []
    for axis, count in enumerate(image.grey.shape):
        at = image.origin[axis] + np.arange(count) * image.spacing[axis]
        near = np.round((at - lumen.origin[axis]) / lumen.spacing).astype(int)
        there = np.flatnonzero((near >= 0) & (near < lumen.mask.shape[axis]))
        places.append((there, near[there]))
    inside[np.ix_(*(there for there, _ in places))] = lumen.mask[np.ix_(*(near for _, near in places))]
    return inside


def _neighbor_mean(triangles: np.ndarray, count: int) -> coo_array:
    """Return the matrix that replaces each point by the mean of its neighbors."""
    a, b = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]).T
    touching = coo_array((np.ones(2 * len(a)), (np.r_[a, b], np.r_[b, a])), shape=(count, count)).tocsr()
    touching.data[:] = 1.0
    return diags_array(1.0 / np.maximum(touching.sum(axis=1), 1.0)) @ touching
