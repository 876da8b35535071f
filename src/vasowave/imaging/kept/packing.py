"""Values of an extraction as a file, and back: a piece of JSON, then plain arrays; no code is ever read."""

import json
from dataclasses import fields, is_dataclass
from pathlib import Path
from typing import Any

import numpy as np

from vasowave.imaging.axes.starts import Settled
from vasowave.imaging.lumen.segmentation import Segmentation
from vasowave.imaging.measure.grey_scale import GreyScale
from vasowave.imaging.measure.profiles import Profile
from vasowave.imaging.measure.spread import Elsewhere
from vasowave.imaging.read.volume import Volume
from vasowave.imaging.tree import Line, Tree
from vasowave.imaging.witness.grey import GreyLook
from vasowave.imaging.witness.skeleton import Thinned
from vasowave.runtime.kept import keep, recall

_ALL = (Volume, Segmentation, Line, Tree, Elsewhere, Settled, Thinned, Profile, GreyLook, GreyScale)
_KINDS: dict[str, type] = {one.__name__: one for one in _ALL}
_BITS = np.dtype(bool).str
_WORD = 16
"""Arrays begin at multiples of so many bytes."""


def write_value(path: Path, key: str, value: Any) -> None:
    """Write `value` under `key`; `OSError` where that fails.

    Parameters
    ----------
    path : Path
    key : str
    value
        Dataclasses of an extraction, tuples, arrays, numbers, text and None, inside one another.
    """
    arrays: list[np.ndarray] = []
    plain = _plain(value, arrays)
    head = json.dumps({"arrays": [(one.dtype.str, one.size) for one in arrays], "value": plain}).encode()
    parts: list[Any] = [len(head).to_bytes(_WORD, "little"), head, *map(_bytes, arrays)]
    keep(path, key, *(piece for part in parts for piece in (part, bytes(-len(part) % _WORD))))


def read_value(path: Path, key: str) -> Any:
    """Return the value that `write_value` wrote under `key`; any error where no such one stands there."""
    with path.open("rb") as file:
        content = recall(file, key)
    if content is None:
        raise ValueError("another value, or a damaged one")
    length = int.from_bytes(content[:_WORD].tobytes(), "little")
    head = json.loads(content[_WORD : _WORD + length].tobytes())
    arrays, at = [], _next(_WORD + length)
    for kind, size in head["arrays"]:
        end = at + size * np.dtype(kind).itemsize
        arrays.append(content[at:end].view(kind))
        at = _next(end)
    return _value(head["value"], arrays)


def _next(at: int) -> int:
    return at + -at % _WORD


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
