"""Arrays by name, as files of MATLAB, NumPy, JSON and Igor Pro's text hold them: ``pressure``, ``rec.PAP.data``."""

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from vasowave.base import units
from vasowave.base.errors import InputError
from vasowave.base.io.apart import ReaderAnswer, read_apart
from vasowave.base.io.matlab import is_mat, read_mat
from vasowave.base.io.remembered import remembered
from vasowave.base.io.textfile import look, read_bytes
from vasowave.base.stores import parsed

_NUMPY = (b"PK\x03\x04", b"\x93NUMPY")
_JSON, _JSON_OBJECTS = re.compile(rb"\s*[\[{]"), re.compile(rb"\s*(?:\[\s*)?\{\s*[\"}]")
_JSON_LINES = re.compile(rb"\s*\{[^\n]*\}[ \t\r]*\n\s*\{")  # an object a line
_WAVES = re.compile(
    r"^WAVES(?P<flags>(?:\s*/\S+)*)\s+(?P<names>[^\n]+)\s+BEGIN\s+(?P<rows>.*?)^\s*END\b", re.M | re.S | re.I
)
_WAVE = re.compile(r"'([^']+)'|([^\s,;']+)")
_SCALE = re.compile(
    r"SetScale\s*(?P<kind>/\w)?\s+(?P<axis>\w)[\s,]+(?P<first>[^,]+),(?P<last>[^,]+),\s*\"(?P<unit>[^\"]*)\"\s*,(?P<names>[^;\n]+)",
    re.IGNORECASE,
)


def holds_names(path: Path, start: bytes) -> bool:
    """Whether a file is one of NumPy, JSON or Igor's text, by its first bytes."""
    is_numpy = path.suffix.lower() in (".npz", ".npy") and start.startswith(_NUMPY)
    is_json = (_JSON if path.suffix.lower() == ".json" else _JSON_OBJECTS).match(start)  # '[Header]' begins tables
    return bool(is_numpy or start.startswith(b"IGOR") or is_json)


@remembered
def read_named(path: Path) -> dict[str, np.ndarray]:
    """Return the arrays of a file by name; those of structures, objects in objects, have points in theirs.

    Raises
    ------
    InputError
        A file that is damaged, or whose arrays have no names.
    """
    start = look(path).start
    if is_mat(path, start):
        return read_mat(path)
    if start.startswith(b"IGOR"):
        return _of_igor(path, "\n".join(read_bytes(path).decode("utf-8", "replace").splitlines()))
    if start.startswith(_NUMPY):
        names, arrays = read_apart(arrays_of_numpy, path, "a NumPy file", "save it again with numpy.savez")
        return dict(zip(names, arrays, strict=True))
    content = read_bytes(path)
    if _JSON_LINES.match(content):
        content = b"[" + b",".join(filter(None, map(bytes.strip, content.splitlines()))) + b"]"
    try:
        return dict(_of_json(parsed(content)))
    except ValueError as error:
        raise InputError(f"{path}: truncated, damaged, or no JSON ({error}); write it again") from None


def arrays_of_numpy(path: Path) -> ReaderAnswer:
    """Return the arrays of an archive, or the fields of a structured array; any exception of NumPy."""
    content = np.load(path, allow_pickle=False)
    if not (names := content.dtype.names if isinstance(content, np.ndarray) else content.files):
        raise InputError(f"{path}: an array without names of its columns; save each by its name: "
                         "np.savez(FILE, time=…, pressure=…, flow=…)")  # fmt: skip
    arrays = {name: array for name in names if (array := _without_objects(content, name)).dtype.kind in "biufU"}
    return ReaderAnswer(list(arrays), list(arrays.values()))


def _without_objects(content: Any, name: str) -> np.ndarray:
    """Return an array; an empty one for objects of Python, which could run anything when they are read."""
    if not isinstance(content, np.ndarray):
        with content.zip.open(f"{name}.npy") as file:
            is_first_form = np.lib.format.read_magic(file) == (1, 0)
            header = np.lib.format.read_array_header_1_0 if is_first_form else np.lib.format.read_array_header_2_0
            if header(file)[2].hasobject:
                return np.empty(0, object)
    return np.asarray(content[name])


def _of_json(content: Any, place: str = "") -> Iterator[tuple[str, np.ndarray]]:
    """Go through the arrays in an object of JSON, or in a list of its rows."""
    content = _columns(content) if not place else content
    for key, value in content.items() if isinstance(content, dict) else ():
        name = place + key.replace(".", " ")
        value = _columns(value, is_plain=True)
        objects = {name: value} if isinstance(value, dict) else {}
        if isinstance(value, list) and value and all(isinstance(row, dict) for row in value):
            objects = {f"{name}({i})": row for i, row in enumerate(value, 1)}
        for held, inner in objects.items():
            yield from _of_json(inner, f"{held}.")
        if not objects and (array := _array(value)).dtype.kind in "iufU":
            yield name, array


def _columns(value: Any, is_plain: bool = False) -> Any:
    """Return the columns of rows, listed or by number as of pandas, that are objects, perhaps of plain cells only."""
    if isinstance(value, dict) and value and all(map(str.isdigit, value)):
        value = [*value.values()]
    if not (isinstance(value, list) and value and all(isinstance(row, dict) for row in value)):
        return value
    if is_plain and any(isinstance(cell, (dict, list)) for row in value for cell in row.values()):
        return value
    return {key: [row.get(key) for row in value] for key in dict.fromkeys(key for row in value for key in row)}


def _array(value: Any) -> np.ndarray:
    """Return a number, text or list of them as an array, with NaN for what is missing; objects where it is no such."""
    try:
        return np.array([np.nan if cell is None else cell for cell in value] if isinstance(value, list) else value)
    except ValueError:
        return np.empty(0, object)


def _of_igor(path: Path, text: str) -> dict[str, np.ndarray]:
    """Return the waves of Igor's text by name, their units as ``wave_unit``, and the samples a second as ``fs``."""
    waves, scales = dict[str, np.ndarray](), set[tuple[float, float]]()
    try:
        for match in _WAVES.finditer(text):
            if "/T" in match["flags"].upper():  # texts
                continue
            names = [quoted or plain for quoted, plain in _WAVE.findall(match["names"])]
            rows = np.array([line.split() for line in match["rows"].splitlines() if line.strip()], float)
            waves |= dict(zip(names, rows.T if "/N=(" not in match["flags"].upper() else [rows], strict=True))
        for match in _SCALE.finditer(text):
            for quoted, plain in _WAVE.findall(match["names"]):
                name = quoted or plain
                if match["axis"].lower() != "x":
                    waves[f"{name}_unit"] = np.array(match["unit"])
                elif match["unit"]:  # else nobody set its scale
                    scales.add(_scale_of(match, len(waves.get(name, ()))))
    except (ValueError, ZeroDivisionError) as error:
        raise InputError(f"{path}: truncated, damaged, or no text of Igor Pro ({error}); export it again") from None
    if len(scales) > 1:
        raise InputError(f"{path}: its waves have different rates or starts; export those of one scale into a file")
    return {**waves, "fs": np.array(scales.pop()[0])} if scales else waves


def _scale_of(scale: re.Match[str], count: int) -> tuple[float, float]:
    """Return the samples a second of a wave of so many, by its first place and the step, last place or end; and that
    first place."""
    first, last = float(scale["first"]), float(scale["last"])
    steps = {"/p": 1, "/i": count - 1}.get((scale["kind"] or "").lower(), count)
    step = (last if steps == 1 else (last - first) / steps) * units.factor(scale["unit"], "time")
    return round(1 / step, 9), first
