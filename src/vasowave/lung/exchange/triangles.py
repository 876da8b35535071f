"""Surfaces of triangles as STL and VTK PolyData."""

import re
from pathlib import Path

import numpy as np

from vasowave.base.errors import InputError
from vasowave.base.io.files import write_file
from vasowave.base.io.textfile import read_bytes
from vasowave.lung.exchange.polydata import data_array, read_polydata
from vasowave.lung.lumen.surface import Surface

MIN_CORNERS = 100
"""A surface of vessels has so many corners."""


def write_stl(surface: Surface, path: str | Path) -> None:
    """Write `surface` as binary STL, x, y, z in mm, as Slicer and ITK-SNAP do."""
    corners = (10 * surface.points[:, ::-1]).astype("<f4")[surface.triangles]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-30)
    table = np.zeros(len(corners), dtype=[("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("count", "<u2")])
    table["normal"], table["corners"] = normal, corners
    head = b"lumen, mm".ljust(80) + np.array(len(corners), "<u4").tobytes()
    write_file(Path(path), head + table.tobytes())


def write_surface_vtp(surface: Surface, path: str | Path) -> None:
    """Write `surface` as VTK PolyData, x, y, z in mm: binary, compressed with zlib."""
    ends = 3 * np.arange(1, len(surface.triangles) + 1)
    write_file(
        Path(path),
        '<?xml version="1.0"?>\n<VTKFile type="PolyData" version="1.0" byte_order="LittleEndian" '
        'header_type="UInt64" compressor="vtkZLibDataCompressor"><PolyData>\n'
        f'<Piece NumberOfPoints="{len(surface.points)}" NumberOfVerts="0" NumberOfLines="0" NumberOfStrips="0" '
        f'NumberOfPolys="{len(surface.triangles)}">\n'
        f"<Points>{data_array('Points', 10 * surface.points[:, ::-1], 'Float32')}</Points>\n"
        f"<Polys>{data_array('connectivity', surface.triangles.ravel(), 'Int64')}\n"
        f"{data_array('offsets', ends, 'Int64')}</Polys>\n"
        "</Piece></PolyData></VTKFile>\n",
    )


def read_surface_points(path: str | Path, unit: float) -> np.ndarray:
    """Return the corners of the triangles in a surface file, z, y, x, cm, shape (corner, 3).

    Parameters
    ----------
    path : path
        .stl (binary or text), .vtp or .vtk.
    unit : float
        Unit of length of the file, cm.

    Raises
    ------
    InputError
        Unreadable file, too few corners, one that is not finite.
    """
    path = Path(path)
    points = _stl_corners(path) if path.suffix.lower() == ".stl" else read_polydata(path).points
    if len(points) < MIN_CORNERS or not np.isfinite(points).all():
        raise InputError(f"{path}: {len(points)} corners, or one that is not finite; is this the vessels' surface?")
    return unit * np.unique(points, axis=0)[:, ::-1]


def _stl_corners(path: Path) -> np.ndarray:
    content = read_bytes(path)
    count = int.from_bytes(content[80:84], "little")
    if len(content) == 84 + 50 * count:
        table = np.frombuffer(content, [("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("count", "<u2")], offset=84)
        return table["corners"].reshape(-1, 3).astype(float)
    corners = re.findall(rb"vertex\s+(\S+)\s+(\S+)\s+(\S+)", content)
    try:
        if not (content.lstrip().startswith(b"solid") and content.rstrip().split(b"\n")[-1].startswith(b"endsolid")):
            raise ValueError
        return np.array(corners, dtype=float).reshape(-1, 3)
    except ValueError:
        raise InputError(f"{path}: not a whole STL file; export the surface again") from None
