"""Values of an extraction as arrays and plain text, and back: no code is ever read."""

from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from typing import Any

import numpy as np

from vasowave.imaging.lumen.segmentation import Segmentation
from vasowave.imaging.measure.spread import Elsewhere
from vasowave.imaging.read.volume import Volume
from vasowave.imaging.tree import Line, Tree
from vasowave.imaging.witness.skeleton import Branches

_KINDS: dict[str, type] = {one.__name__: one for one in (Volume, Segmentation, Line, Tree, Elsewhere, Branches)}
_BITS = np.dtype(bool).str
_SHORT = np.iinfo(np.int16)


def packed(value: Any) -> tuple[Any, dict[str, np.ndarray]]:
    """Return `value` as what JSON holds, and the arrays that it names.

    Parameters
    ----------
    value
        Dataclasses of an extraction, tuples, arrays, numbers, text and None, inside one another.
    """
    arrays: dict[str, np.ndarray] = {}
    return _plain(value, arrays), arrays


def unpacked(plain: Any, arrays: Mapping[str, np.ndarray]) -> Any:
    """Return the value that `packed` made into `plain` and `arrays`; any error where they were not made so."""
    if isinstance(plain, list):
        return tuple(unpacked(one, arrays) for one in plain)
    if not isinstance(plain, dict):
        return plain
    if "kind" in plain:
        return _KINDS[plain["kind"]](**{name: unpacked(one, arrays) for name, one in plain["fields"].items()})
    found, shape, kind = arrays[plain["array"]], tuple(plain["shape"]), plain["type"]
    if kind == _BITS:
        return np.unpackbits(found, count=int(np.prod(shape))).astype(bool).reshape(shape)
    return found.astype(np.dtype(kind), copy=False).reshape(shape)


def _plain(value: Any, arrays: dict[str, np.ndarray]) -> Any:
    if isinstance(value, np.ndarray):
        name = f"array{len(arrays)}"
        arrays[name] = _small(value)
        return {"array": name, "shape": value.shape, "type": value.dtype.str}
    if is_dataclass(value):
        own = {entry.name: _plain(getattr(value, entry.name), arrays) for entry in fields(value)}
        return {"kind": type(value).__name__, "fields": own}
    if isinstance(value, tuple):
        return [_plain(one, arrays) for one in value]
    return value.item() if isinstance(value, np.generic) else value


def _small(array: np.ndarray) -> np.ndarray:
    """Return `array` in fewer bytes where none of its values changes: bits, or the scanner's own whole numbers."""
    if array.dtype == bool:
        return np.packbits(array)
    if array.dtype == np.float32 and array.size and array.min() >= _SHORT.min and array.max() <= _SHORT.max:
        short = array.astype(np.int16)
        return short if np.array_equal(short, array) else array
    return array
