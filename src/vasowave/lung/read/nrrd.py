"""NRRD files (.nrrd, .nhdr): whether they are whole, what their header names, and the unit of their lengths."""

import re
from collections.abc import Sequence
from math import prod
from pathlib import Path

from vasowave.base.errors import InputError
from vasowave.base.io.textfile import read_start
from vasowave.lung.read.formats import VOLUMES, Contents, VolumeFormat
from vasowave.lung.read.itk import read_itk
from vasowave.lung.read.payload import Packing, centimeters, data_file, require_bytes
from vasowave.lung.read.volume import Image

_BYTES = {
    **dict.fromkeys(("signed char", "int8", "int8_t", "uchar", "unsigned char", "uint8", "uint8_t"), 1),
    **dict.fromkeys(("short", "short int", "signed short", "signed short int", "int16", "int16_t"), 2),
    **dict.fromkeys(("ushort", "unsigned short", "unsigned short int", "uint16", "uint16_t"), 2),
    **dict.fromkeys(("int", "signed int", "int32", "int32_t", "uint", "unsigned int", "uint32", "uint32_t"), 4),
    **dict.fromkeys(("longlong", "long long", "long long int", "signed long long", "signed long long int"), 8),
    **dict.fromkeys(("ulonglong", "unsigned long long", "unsigned long long int", "uint64", "uint64_t"), 8),
    **dict.fromkeys(("int64", "int64_t", "double"), 8), "float": 4,
}  # fmt: skip
_PACKINGS: dict[str, Packing] = {
    "raw": "raw", "gzip": "gzip", "gz": "gzip", "bzip2": "bzip2", "bz2": "bzip2"
}  # fmt: skip
_LIST = re.compile(r"data ?file:\s*LIST(?:\s+\d+)?\s*$", re.IGNORECASE)
_COUNTED = re.compile(r"([^%]*%0?\d{0,2}d[^%]*?)\s+(-?\d{1,9})\s+(-?\d{1,9})\s+(-?\d{1,9})(?:\s+\d+)?")
_MOST_FILES = 1 << 15
"""Forms of `data file` where voxels lie in several: names in a list, or with a number, its first, last and step."""
_TEXTS = ("ascii", "text", "txt", "hex")
_MAX_HEADER_BYTES = 1 << 21
"""No header is longer, bytes."""


def check_nrrd(path: Path) -> Contents:
    """Return what a header announces; `InputError` unless just these voxels are there, in its own folder."""
    fields, end = _header(path)
    if "datafile" not in fields and end < 0:
        raise InputError(f"{path}: not an image that can be read: its header has no end; truncated?")
    names = _names(path, fields)
    holders = [data_file(path, name) for name in names] or [path]
    count = _require_voxels(path, fields, holders, 0 if names else end)
    if int(fields["dimension"]) < 3:
        raise InputError(f"{path}: not a three-dimensional grey-level image; export a 3D volume")
    size = (fields.get("spacedirections") or fields.get("spacings") or "none").lower()
    words = re.findall(r"\([^)]*\)|[^\s()]+", size)
    vectors = [word for word in words if not re.search("none|nan", word)]
    lengths = [int(length) for word, length in zip(words, fields["sizes"].split(), strict=False) if word not in vectors]
    if len(vectors) != 3 or set(lengths) - {1}:
        return Contents(count, "its header has no (or not all) space directions or spacings")
    units = f"its header has lengths in {_units(fields)}, which is not a unit of a length"
    return Contents(count, "" if _millimeters(fields) else units)


def _header(path: Path) -> tuple[dict[str, str], int]:
    """Return the fields of a header by their names in lower case without blanks, and where it ends; -1 without end."""
    start = read_start(path, _MAX_HEADER_BYTES)
    if not start.startswith(b"NRRD"):
        raise InputError(f"{path}: not an image that can be read: no NRRD file")
    end = re.search(rb"\r?\n\r?\n", start)
    lines = start[: end.start() if end else None].decode("utf-8", errors="replace").splitlines()[1:]
    count = next((i for i, line in enumerate(lines, 1) if _LIST.match(line)), len(lines))
    pairs = (line.split(": ", 1) for line in lines[:count] if ": " in line and not line.startswith("#"))
    fields = {key.strip().lower().replace(" ", ""): value.strip() for key, value in pairs}
    if count and _LIST.match(lines[count - 1]):  # the names of files stand below it, to the end
        fields["files"] = "\n".join(filter(None, map(str.strip, lines[count:])))
    return fields, end.end() if end else -1


def _names(path: Path, fields: dict[str, str]) -> list[str]:
    """Return the names of the files of voxels, none where these stand in the header's own file."""
    name = fields.get("datafile", "")
    if "files" in fields:
        names = fields["files"].splitlines()
    elif counted := _COUNTED.fullmatch(name):
        first, last, step = map(int, counted.group(2, 3, 4))
        numbers = range(first, last + (1 if step > 0 else -1), step) if step else range(0)
        names = [counted[1] % number for number in numbers[: _MOST_FILES + 1]]
    else:
        return [name] if name else []
    if not 0 < len(names) <= _MOST_FILES:
        raise InputError(f"{path}: its header names no files of voxels, or too many ({name}); save it again")
    return names


def read_nrrd(path: Path) -> Image:
    """Read an NRRD file as `read_itk` does, with lengths in the unit that it names; mm where it names none."""
    fields, image = _header(path)[0], read_itk(path)
    scale, names = _millimeters(fields) or 1.0, "space directions" if "spacedirections" in fields else "spacings"
    provenance = f"{names} of its header" + ("" if _units(fields) else ", in mm, for it names no unit")
    return image._replace(spacing=image.spacing * scale, origin=image.origin * scale, provenance=provenance)


def _millimeters(fields: dict[str, str]) -> float | None:
    """Return how many mm the unit of a header's lengths is; None if it is not one unit of a length."""
    named = set(re.findall(r'"([^"]*)"', _units(fields).lower())) - {"", "none"}
    scales = {10 * centimeters(word) for word in named} or {1.0}
    return (scales.pop() or None) if len(scales) == 1 else None


def _units(fields: dict[str, str]) -> str:
    return fields.get("spaceunits" if "spacedirections" in fields else "units", "")


def _require_voxels(path: Path, fields: dict[str, str], holders: Sequence[Path], start: int) -> int:
    """Return how many bytes of voxels a header announces; `InputError` unless its files hold as many, evenly."""
    try:
        sizes = [int(size) for size in fields["sizes"].split()]
        count = prod(sizes) * _BYTES[fields["type"].lower()]
        encoding = fields["encoding"].lower()
        lines, offset = (int(fields.get(key, 0)) for key in ("lineskip", "byteskip"))
        if len(sizes) != int(fields["dimension"]) or min(sizes, default=0) < 1 or lines < 0:
            raise ValueError
        if encoding not in (*_PACKINGS, *_TEXTS) or count % len(holders):
            raise ValueError
    except (KeyError, ValueError):
        raise InputError(f"{path}: not an image that can be read: its header is damaged; export it again") from None
    if not lines and encoding not in _TEXTS:  # the library counts the numbers of a text itself
        for holder in holders:
            require_bytes(holder, start, count // len(holders), _PACKINGS[encoding], offset)
    return count


VOLUMES.register(VolumeFormat("nrrd", "NRRD", (".nrrd", ".nhdr"), None, read_nrrd, check_nrrd))
