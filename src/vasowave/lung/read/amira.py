"""Lattices of Amira and Avizo (.am): uniform, of one number a voxel, as bytes, packed or as text."""

import re
import zlib
from pathlib import Path

import numpy as np

from vasowave.base.errors import InputError
from vasowave.base.io.textfile import read_start
from vasowave.lung.read.formats import VOLUMES, VolumeFormat
from vasowave.lung.read.payload import centimeters
from vasowave.lung.read.raw import RawVoxels
from vasowave.lung.read.volume import UNSIZED, Image

_TYPES = {"byte": "u1", "short": "i2", "ushort": "u2", "int": "i4", "float": "f4", "double": "f8"}
_CODES = (None, "HxByteRLE", "HxZip")
_MAX_HEADER_BYTES = 1 << 20
_SECTION = re.compile(rb"^@1[ \t]*\r?\n", re.MULTILINE)


def read_amira(path: Path) -> Image:
    """Read a lattice whose voxels are packed or text; `InputError` as `map_amira`."""
    layout, fields = _layout(path)
    shape, count = layout.shape, int(np.prod(layout.shape, dtype=object))
    size = count * layout.kind.itemsize
    with path.open("rb") as file:
        file.seek(layout.start)
        content = file.read(int(fields["length"]) if fields["length"] else -1)
    try:
        if "ASCII" in fields["form"]:
            words = content.split()[:count]
            values = np.array(words, dtype=float).astype(layout.kind)
        else:
            engine = zlib.decompressobj()
            unpacked = (
                engine.decompress(content, size + 1) if fields["code"] == "HxZip" else _run_lengths(content, size)
            )
            values = np.frombuffer(unpacked, layout.kind)
        if len(values) != count:
            raise ValueError(f"{len(values)} of {count} voxels")
    except (ValueError, zlib.error) as error:
        raise InputError(f"{path}: truncated or damaged ({error}); export it again") from None
    return Image(values.reshape(shape), layout.spacing, layout.origin, provenance=layout.provenance)


def map_amira(path: Path) -> Image | None:
    """Return a lattice whose voxels are plain bytes.

    Raises
    ------
    InputError
        No uniform lattice of one number a voxel, damaged or truncated.
    """
    layout, fields = _layout(path)
    return None if fields["code"] or "ASCII" in fields["form"] else layout.image(padded=True)


def _layout(path: Path) -> tuple[RawVoxels, dict[str, str]]:
    """Return where the voxels stand, and form, packing and packed length; the bounding box joins centers of voxels."""
    start = read_start(path, _MAX_HEADER_BYTES)
    data = _SECTION.search(start)
    head = start[: data.start() if data else 0].decode("utf-8", errors="replace")
    form = re.match(r"#\s*(?:AmiraMesh|Avizo)(?: 3D)?\s+(ASCII|BINARY-LITTLE-ENDIAN|BINARY)", head)
    sizes = re.search(r"define\s+Lattice\s+(\d+)\s+(\d+)\s+(\d+)", head)
    entry = re.search(r"Lattice\s*\{\s*(\w+)\s+\w+\s*\}\s*=?\s*@1\s*(?:\((\w+)\s*,\s*(\d+)\))?", head)
    box = re.search(r"BoundingBox\s+((?:[-+\d.eE]+[ \t]*){6})", head)
    is_uniform = re.search(r'CoordType\s+"uniform"', head)
    if not (data and form and sizes and entry and is_uniform) or entry[1] not in _TYPES or entry[2] not in _CODES:
        raise InputError(
            f"{path}: not a uniform lattice of one number a voxel that can be read; save it as NRRD or as AmiraMesh, "
            "binary and not packed"
        )
    x, y, z = counts = [int(number) for number in sizes.groups()]
    spacing, origin, provenance = UNSIZED, np.zeros(3), "its header names no unit of its BoundingBox"
    unit = re.search(r'Units\s*\{[^}]*?Coordinates\s+"([^"]*)"', head)
    length = centimeters(unit[1]) if unit else 0.0
    corners = np.array((box[1] if box else "").split(), dtype=float).reshape(-1, 2)
    if corners.shape == (3, 2) and length and min(counts) > 1:
        spacing = (np.diff(corners)[:, 0] / (np.array(counts) - 1))[::-1] * length
        origin, provenance = corners[::-1, 0] * length, "BoundingBox and Units of its header"
    order = "<" if "LITTLE" in form[1] else ">"
    layout = RawVoxels(path, data.end(), (z, y, x), np.dtype(order + _TYPES[entry[1]]), spacing, provenance, origin)
    return layout, {"form": form[1], "code": entry[2] or "", "length": entry[3] or ""}


def _run_lengths(content: bytes, size: int) -> bytes:
    """Unpack HxByteRLE: a count and the byte to repeat, or 128 and more and so many bytes as they are."""
    pieces, place, length = [], 0, 0
    while place < len(content) - 1 and length <= size:
        count = content[place]
        step = count - 128 if count > 127 else 1
        piece = content[place + 1 : place + 1 + step]
        pieces.append(piece if count > 127 else piece * count)
        place, length = place + 1 + step, length + len(pieces[-1])
    return b"".join(pieces)


VOLUMES.register(VolumeFormat("amira", "Amira lattice", (".am",), None, read_amira, None, map_amira, False))
