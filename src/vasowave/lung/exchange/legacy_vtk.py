"""Lines of VTK PolyData, and legacy files of them, versions 1 to 5.1, ASCII and binary, read from beginning to end."""

import re
from dataclasses import dataclass, field

import numpy as np

from vasowave.base.errors import InputError

_TYPES = {
    "bit": "u1", "char": "i1", "unsigned_char": "u1", "short": "i2", "unsigned_short": "u2", "int": "i4",
    "unsigned_int": "u4", "long": "i8", "unsigned_long": "u8", "vtktypeint64": "i8", "vtkidtype": "i8", "float": "f4",
    "double": "f8",
}  # fmt: skip
_WIDTHS = {"VECTORS": 3, "NORMALS": 3, "TENSORS": 9, "TENSORS6": 6, "GLOBAL_IDS": 1, "PEDIGREE_IDS": 1}
_CELLS = ("VERTICES", "LINES", "POLYGONS", "TRIANGLE_STRIPS")
_NO_NUMBERS = re.compile(rb"^[^\n]*[^\s0-9eE+\-.naifNAIF][^\n]*$", re.MULTILINE)
"""A line that is not just numbers: there a list of numbers ends."""


@dataclass(frozen=True, eq=False)
class PolyLines:
    """Lines through numbered points.

    Attributes
    ----------
    points : float array, shape (point, 3)
        x, y, z in the unit of the file.
    lines : tuple of int array
        Numbers of the points of each line, in order.
    fields : dict of str to array, shape (point,) or (point, component)
        Values at the points.
    cells : dict of str to array, shape (line,) or (line, component)
        Values of the lines.
    """

    points: np.ndarray
    lines: tuple[np.ndarray, ...]
    fields: dict[str, np.ndarray]
    cells: dict[str, np.ndarray] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Check that lines and values refer to the points there are."""
        count = len(self.points)
        if self.points.ndim != 2 or self.points.shape[1] != 3 or not np.isfinite(self.points).all():
            raise InputError("points are not finite triples x, y, z; write the file again")
        for number, line in enumerate(self.lines):
            if len(line) and (line.min() < 0 or line.max() >= count):
                raise InputError(f"line {number} names a point that does not exist ({count} points)")
        for name, values in self.fields.items():
            if len(values) != count:
                raise InputError(f"array '{name}' has {len(values)} values for {count} points")
        object.__setattr__(self, "cells", {k: v for k, v in self.cells.items() if len(v) == len(self.lines)})


def parse_legacy(raw: bytes) -> PolyLines:
    """Return the lines in the bytes of a legacy file.

    Raises
    ------
    InputError
        Not PolyData, no points or lines, surplus or missing numbers, something that no such file holds.
    """
    file = _File(raw)
    while words := file.words():
        file.section(words[0].upper(), words[1:])
    if file.points is None or file.lines is None:
        raise InputError("no POINTS or no LINES; are these centerlines?")
    return PolyLines(file.points, file.lines, file.point_data, file.cell_data)


class _File:
    """A file while it is read: what was found, and where reading stands."""

    def __init__(self, raw: bytes) -> None:
        version, _, form, kind, _ = [*raw.split(b"\n", 4), b""][:5]
        if kind.split() != [b"DATASET", b"POLYDATA"]:
            raise InputError("not PolyData; export the centerlines as PolyData")
        self.raw, self.at = raw, raw.index(kind) + len(kind)
        self.binary, self.offsets = form.strip().upper() == b"BINARY", float(version.split()[-1]) > 4.2
        self.points: np.ndarray | None = None
        self.lines: tuple[np.ndarray, ...] | None = None
        self.point_data: dict[str, np.ndarray] = {}
        self.cell_data: dict[str, np.ndarray] = {}
        self.cells = 0
        self._into: dict[str, np.ndarray] = {}
        self._rows = -1

    def words(self) -> list[str]:
        """Return the words of the next line that has any; none at the end."""
        while self.at < len(self.raw):
            end = self.raw.find(b"\n", self.at)
            end = len(self.raw) if end < 0 else end
            words = self.raw[self.at : min(end, self.at + 1000)].decode("latin-1").split()
            self.at = end + 1
            if words:
                return words
        return []

    def values(self, count: int, kind: str) -> np.ndarray:
        """Return the next `count` numbers; after them there is a line that is none, or the end."""
        dtype = np.dtype(">" + _TYPES[kind.lower()])
        if self.binary:
            numbers = np.frombuffer(self.raw, dtype, count, self.at)
            self.at += numbers.nbytes
            return numbers
        stop = _NO_NUMBERS.search(self.raw, self.at)
        end = len(self.raw) if stop is None else stop.start()
        words = self.raw[self.at : end].split()
        if len(words) != count:
            problem = "truncated" if len(words) < count else "surplus numbers"
            raise InputError(f"{problem}: {len(words)} numbers where {count} were announced; write the file again")
        self.at = end
        return np.array(words, dtype=dtype)

    def section(self, key: str, words: list[str]) -> None:
        """Read what stands under one key word."""
        if key == "POINTS":
            self.points = self.values(3 * _count(words[0]), words[1]).reshape(-1, 3).astype(float)
        elif key in _CELLS:
            cells = (self._by_offsets if self.offsets else self._by_counts)(_count(words[0]), _count(words[1]))
            self.cells += len(cells)
            self.lines = tuple(cells) if key == "LINES" else self.lines
        elif key in ("POINT_DATA", "CELL_DATA"):
            self._begin_data(key, _count(words[0]))
        elif key == "METADATA":
            while self.raw[self.at : self.at + 1] not in (b"\n", b"\r", b""):
                self.words()
        elif key == "FIELD":
            for _ in range(_count(words[1])):
                self._field(self.words())
        else:
            self._attribute(key, words)

    def _begin_data(self, key: str, count: int) -> None:
        at_points = key == "POINT_DATA"
        expected = (0 if self.points is None else len(self.points)) if at_points else self.cells
        if count != expected:
            raise InputError(f"{key} for {count}, but there are {expected}; write the file again")
        self._into, self._rows = (self.point_data if at_points else self.cell_data), count

    def _attribute(self, key: str, words: list[str]) -> None:
        """Read one array of point or cell data that stands under its own key word."""
        if key == "LOOKUP_TABLE":
            self.values(4 * _count(words[1]), "unsigned_char" if self.binary else "float")
        elif key == "COLOR_SCALARS":
            self.values(self._rows * _count(words[1]), "unsigned_char" if self.binary else "float")
        elif key == "SCALARS":
            if self.words()[:1] != ["LOOKUP_TABLE"]:
                raise InputError("SCALARS without LOOKUP_TABLE; write the file again")
            self._keep(words[0], _count(words[2]) if len(words) > 2 else 1, words[1])
        elif key == "TEXTURE_COORDINATES":
            self._keep(words[0], _count(words[1]), words[2])
        elif key in _WIDTHS:
            self._keep(words[0], _WIDTHS[key], words[1])
        else:
            raise InputError(f"'{key[:20]}' where a key word should stand: surplus or damaged numbers before it")

    def _keep(self, name: str, width: int, kind: str) -> None:
        if self._rows < 0:
            raise InputError(f"array '{name}' belongs neither to points nor to cells; write the file again")
        values = self.values(self._rows * width, kind)
        self._into[name] = values if width == 1 else values.reshape(-1, width)

    def _field(self, words: list[str]) -> None:
        """Read one array of a FIELD; those that belong to nothing are not kept."""
        while words[:1] == ["METADATA"]:
            self.section("METADATA", [])
            words = self.words()
        name, width, rows, kind = words
        if kind == "string" and not self.binary:
            for _ in range(_count(width) * _count(rows)):
                self.words()
            return
        values = self.values(_count(width) * _count(rows), kind)
        if self._rows >= 0 and _count(rows) != self._rows:
            raise InputError(f"array '{name}' has {rows} rows for {self._rows}; write the file again")
        self._into[name] = values if width == "1" else values.reshape(-1, _count(width))

    def _by_counts(self, count: int, size: int) -> list[np.ndarray]:
        """Return the cells of versions up to 4.2: counts and numbers in one list."""
        packed = self.values(size, "int").astype(np.int64)
        lines, position = [], 0
        for _ in range(count):
            lines.append(packed[position + 1 : position + 1 + packed[position]])
            position += 1 + int(packed[position])
        if position != size or sum(map(len, lines)) != size - count:
            raise InputError(f"the lines fill {position} of {size} numbers; write the file again")
        return lines

    def _by_offsets(self, count: int, size: int) -> list[np.ndarray]:
        """Return the cells of version 5: where each begins, one more for the end, then the numbers."""
        ends = self._named("OFFSETS", count)
        joined = self._named("CONNECTIVITY", size)
        if count == 0 or ends[0] != 0 or ends[-1] != len(joined) or (np.diff(ends) < 0).any():
            raise InputError(
                f"the lines hold {len(joined)} point numbers, their offsets say otherwise; write the file again"
            )
        return np.split(joined, ends[1:-1])

    def _named(self, key: str, count: int) -> np.ndarray:
        words = self.words()
        if len(words) != 2 or words[0] != key:
            raise InputError("cells without OFFSETS and CONNECTIVITY; write the file again")
        return self.values(count, words[1]).astype(np.int64)


def _count(word: str) -> int:
    """Return a count; `ValueError` where it is none."""
    if not word.isdecimal():
        raise ValueError(f"'{word}' is not a count")
    return int(word)
