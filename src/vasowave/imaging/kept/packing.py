"""Values of an extraction as a file, and back: a line of JSON, then plain arrays; no code is ever read.

The line begins with the check sum of the rest of it, and holds that of every array.
"""

import json
import zlib
from dataclasses import fields, is_dataclass
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np

from vasowave.imaging.lumen.segmentation import Segmentation
from vasowave.imaging.measure.profiles import Profile
from vasowave.imaging.measure.spread import Elsewhere
from vasowave.imaging.read.volume import Volume
from vasowave.imaging.tree import Line, Tree
from vasowave.imaging.witness.skeleton import Branches

_ALL = (Volume, Segmentation, Line, Tree, Elsewhere, Branches, Profile)
_KINDS: dict[str, type] = {one.__name__: one for one in _ALL}
_BITS = np.dtype(bool).str
_SUM = 8  # hexadecimal digits of a check sum


def write_value(path: Path, key: str, value: Any) -> None:
    """Write `value` under `key`.

    Parameters
    ----------
    path : Path
    key : str
    value
        Dataclasses of an extraction, tuples, arrays, numbers, text and None, inside one another.
    """
    arrays: list[np.ndarray] = []
    plain = _plain(value, arrays)
    sizes = [(one.dtype.str, one.size, zlib.crc32(_bytes(one))) for one in arrays]
    head = json.dumps({"key": key, "arrays": sizes, "value": plain}).encode()
    with path.open("wb") as file:
        file.write(_check(head) + head + b"\n")
        for one in arrays:
            file.write(_bytes(one))


def read_value(path: Path, key: str) -> Any:
    """Return the value that `write_value` wrote under `key`; any error where another one stands there, or half of it.

    The key is compared before any array is read.
    """
    with path.open("rb") as file:
        line = file.readline()
        head = json.loads(line[_SUM:])
        if line[:_SUM] != _check(line[_SUM:-1]) or line[-1:] != b"\n" or head["key"] != key:
            raise ValueError("another value, or a damaged head")
        arrays = [_array(file, *size) for size in head["arrays"]]
        if file.read(1):
            raise ValueError("more than was written")
    return _value(head["value"], arrays)


def _check(head: bytes) -> bytes:
    return f"{zlib.crc32(head):0{_SUM}x}".encode()


def _array(file: BinaryIO, kind: str, size: int, check: int) -> np.ndarray:
    array = np.fromfile(file, np.dtype(kind), size)
    if array.size != size or zlib.crc32(_bytes(array)) != check:
        raise ValueError("an array is damaged")
    return array


def _value(plain: Any, arrays: list[np.ndarray]) -> Any:
    if isinstance(plain, list):
        return tuple(_value(one, arrays) for one in plain)
    if not isinstance(plain, dict):
        return plain
    if "kind" in plain:
        return _KINDS[plain["kind"]](**{name: _value(one, arrays) for name, one in plain["fields"].items()})
    array, shape = arrays[plain["array"]], tuple(plain["shape"])
    if plain["type"] == _BITS:
        array = np.unpackbits(array, count=int(np.prod(shape)))
    return array.view(plain["type"]).reshape(shape)


def _plain(value: Any, arrays: list[np.ndarray]) -> Any:
    if isinstance(value, np.ndarray):
        arrays.append(np.packbits(value) if value.dtype == bool else value)
        return {"array": len(arrays) - 1, "shape": value.shape, "type": value.dtype.str}
    if is_dataclass(value):
        own = {entry.name: _plain(getattr(value, entry.name), arrays) for entry in fields(value)}
        return {"kind": type(value).__name__, "fields": own}
    if isinstance(value, tuple):
        return [_plain(one, arrays) for one in value]
    return value.item() if isinstance(value, np.generic) else value


def _bytes(array: np.ndarray) -> np.ndarray:
    return np.ascontiguousarray(array).reshape(-1).view(np.uint8)
