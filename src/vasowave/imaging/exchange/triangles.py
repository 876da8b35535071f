"""Surfaces of triangles as STL and VTK PolyData."""

from pathlib import Path

import numpy as np

from vasowave.imaging.exchange.polydata import data_array
from vasowave.imaging.lumen.surface import Surface


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
