"""Legacy VTK files of PolyData lines, versions 1 to 5.1, ASCII and binary."""

import re
from collections.abc import Callable

import numpy as np

from vasowave.errors import InputError
from vasowave.imaging.exchange.polylines import PolyLines

_TYPES = {
    "char": "i1", "unsigned_char": "u1", "short": "i2", "unsigned_short": "u2", "int": "i4", "unsigned_int": "u4",
    "long": "i8", "vtktypeint64": "i8", "vtkIdType": "i8", "float": "f4", "double": "f8",
}  # fmt: skip

Reader = Callable[[int, int, str], np.ndarray]


def parse_legacy(raw: bytes) -> PolyLines:
    """Return the lines in the bytes of a legacy file.

    Raises
    ------
    InputError
        Not PolyData, no points or lines, truncated.
    """
    version, _, form, kind = raw.split(b"\n", 4)[:4]
    if kind.split() != [b"DATASET", b"POLYDATA"]:
        raise InputError("not PolyData; export the centerlines as PolyData")
    number = re.search(rb"\nPOINTS (\d+) (\w+)[^\n]*\n", raw)
    listed = re.search(rb"\nLINES (\d+) (\d+)[^\n]*\n", raw)
    if number is None or listed is None:
        raise InputError("no POINTS or no LINES; are these centerlines?")
    values = _reader(raw, form.strip() == b"BINARY")
    count = int(number[1])
    points = values(number.end(), 3 * count, number[2].decode()).reshape(-1, 3).astype(float)
    lines_of = _lines_by_offsets if float(version.split()[-1]) > 4.2 else _lines_by_counts
    fields = {}
    for match in re.finditer(rb"\nSCALARS (\S+) (\w+)[^\n]*\nLOOKUP_TABLE [^\n]*\n", raw):
        fields[match[1].decode()] = values(match.end(), count, match[2].decode())
    for match in re.finditer(rb"\n(\S+) 1 %d (float|double) *\n" % count, raw):
        fields[match[1].decode()] = values(match.end(), count, match[2].decode())
    return PolyLines(points, tuple(lines_of(raw, listed, values)), fields)


def _reader(raw: bytes, binary: bool) -> Reader:
    """Return a function of place, count and type name that reads values."""

    def values(at: int, count: int, name: str) -> np.ndarray:
        if binary:
            return np.frombuffer(raw, ">" + _TYPES[name], count, at)
        numbers = np.array(raw[at : at + 64 * count].split(maxsplit=count)[:count], dtype=_TYPES[name])
        if len(numbers) < count:
            raise InputError("truncated; write the file again")
        return numbers

    return values


def _lines_by_counts(raw: bytes, listed: re.Match[bytes], values: Reader) -> list[np.ndarray]:
    """Return the lines of versions up to 4.2: counts and numbers in one list."""
    packed = values(listed.end(), int(listed[2]), "int").astype(np.int64)
    lines, at = [], 0
    for _ in range(int(listed[1])):
        lines.append(packed[at + 1 : at + 1 + packed[at]])
        at += 1 + packed[at]
    return lines


def _lines_by_offsets(raw: bytes, listed: re.Match[bytes], values: Reader) -> list[np.ndarray]:
    """Return the lines of version 5: where each begins, one more for the end, then the numbers."""
    offsets = re.compile(rb"OFFSETS (\w+) *\n").match(raw, listed.end())
    numbers = re.compile(rb"CONNECTIVITY (\w+) *\n").search(raw, listed.end())
    if offsets is None or numbers is None:
        raise InputError("LINES without OFFSETS and CONNECTIVITY; write the file again")
    ends = values(offsets.end(), int(listed[1]), offsets[1].decode()).astype(np.int64)
    joined = values(numbers.end(), int(listed[2]), numbers[1].decode()).astype(np.int64)
    if len(ends) == 0 or ends[0] != 0 or ends[-1] != len(joined) or (np.diff(ends) < 0).any():
        raise InputError(
            f"the lines hold {len(joined)} point numbers, their offsets say otherwise; write the file again"
        )
    return np.split(joined, ends[1:-1])
