"""VTK PolyData lines: read .vtp (XML) and .vtk (legacy), write .vtp; no VTK needed."""

import base64
import zlib
from pathlib import Path
from xml.etree import ElementTree

import numpy as np

from vasowave.base.errors import InputError
from vasowave.base.io.files import write_file
from vasowave.base.io.textfile import read_bytes
from vasowave.lung.exchange.legacy_vtk import PolyLines, parse_legacy
from vasowave.lung.read.vti import DAMAGE, TYPES, array_of, document


def read_polydata(path: str | Path) -> PolyLines:
    """Read the lines of a PolyData file: .vtp (ascii, binary or appended, zlib, lzma or LZ4) or legacy .vtk.

    Raises
    ------
    InputError
        Missing, truncated or foreign file; an encoding that is not one of these.
    """
    path = Path(path)
    raw = read_bytes(path)
    try:
        return parse_legacy(raw) if raw.startswith(b"# vtk") else _xml(raw)
    except InputError as error:
        raise InputError(f"{path}: {error}") from None
    except DAMAGE as error:
        raise InputError(f"{path}: damaged or truncated PolyData ({error}); write the file again") from None
    except ElementTree.ParseError as error:
        raise InputError(f"{path}: not valid XML ({error}); truncated, or no .vtp file") from None


def write_vtp(data: PolyLines, path: str | Path) -> None:
    """Write `data` as .vtp: binary, compressed with zlib, little endian."""

    ends = np.cumsum([len(line) for line in data.lines])
    fields = "\n".join(data_array(name, values, "Float64") for name, values in data.fields.items())
    write_file(
        Path(path),
        '<?xml version="1.0"?>\n<VTKFile type="PolyData" version="1.0" byte_order="LittleEndian" '
        'header_type="UInt64" compressor="vtkZLibDataCompressor"><PolyData>\n'
        f'<Piece NumberOfPoints="{len(data.points)}" NumberOfVerts="0" NumberOfLines="{len(data.lines)}" '
        'NumberOfStrips="0" NumberOfPolys="0">\n'
        f"<PointData>{fields}</PointData>\n<Points>{data_array('Points', data.points, 'Float64')}</Points>\n"
        f"<Lines>{data_array('connectivity', np.concatenate(data.lines), 'Int64')}\n"
        f"{data_array('offsets', ends, 'Int64')}</Lines>\n</Piece></PolyData></VTKFile>\n",
    )


def data_array(name: str, values: np.ndarray, kind: str) -> str:
    """Return the XML element that holds `values` in VTK's type `kind`: little endian, zlib, base64, one block."""
    width = f' NumberOfComponents="{values.shape[1]}"' if values.ndim == 2 else ""
    content = np.ascontiguousarray(values, dtype="<" + TYPES[kind]).tobytes()
    packed = zlib.compress(content)
    header = np.array([1, len(content), len(content), len(packed)], "<u8").tobytes()
    text = base64.b64encode(header).decode() + base64.b64encode(packed).decode()
    return f'<DataArray type="{kind}" Name="{name}"{width} format="binary">{text}</DataArray>'


def _xml(raw: bytes) -> PolyLines:
    top, appended = document(raw)
    if top.tag != "VTKFile" or top.get("type") != "PolyData":
        raise InputError("not VTK PolyData; export the centerlines as .vtp")
    pieces = top.findall("./PolyData/Piece")
    points, lines, count = [], [], 0
    fields: list[dict[str, np.ndarray]] = []
    cells: list[dict[str, np.ndarray]] = []
    for piece in pieces:
        holder = piece.find("./Points/DataArray")
        if holder is None or not int(piece.get("NumberOfPoints", 0)):
            continue
        points.append(array_of(holder, top, appended).reshape(-1, 3).astype(float))
        _require_count("points", len(points[-1]), piece.get("NumberOfPoints"))
        values = {a.get("Name"): a for a in piece.findall("./Lines/DataArray")}
        if values:
            joined, ends = (array_of(values[name], top, appended) for name in ("connectivity", "offsets"))
        else:  # a surface
            joined = ends = np.empty(0, np.int64)
        _require_count("lines", len(ends), piece.get("NumberOfLines"))
        if len(joined) != (ends[-1] if len(ends) else 0) or (np.diff(ends, prepend=0) < 0).any():
            raise InputError(f"the lines hold {len(joined)} point numbers, their offsets say otherwise")
        lines += [line.astype(np.int64) + count for line in np.split(joined, ends[:-1])]
        for kind, into in (("PointData", fields), ("CellData", cells)):
            arrays = [a for a in piece.findall(f"./{kind}/DataArray") if a.get("type") in TYPES]
            into.append({str(a.get("Name")): array_of(a, top, appended) for a in arrays})
        count += len(points[-1])
    if not points:
        raise InputError("no points; are these centerlines?")
    return PolyLines(np.concatenate(points), tuple(lines), _joined(fields), _joined(cells))


def _require_count(kind: str, count: int, announced: str | None) -> None:
    if announced is not None and int(announced) != count:
        raise InputError(f"{count} {kind} where {announced} were announced; write the file again")


def _joined(pieces: list[dict[str, np.ndarray]]) -> dict[str, np.ndarray]:
    """Return the arrays that all pieces have, one piece after the other."""
    names = set.intersection(*(set(piece) for piece in pieces))
    return {name: np.concatenate([piece[name] for piece in pieces]) for name in names}
