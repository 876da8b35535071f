"""Whether the voxels that a header announces are there: libraries fill what is missing with zeros."""

import bz2
import zlib
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, Literal

from vasowave.base import units
from vasowave.base.cures import VOXEL
from vasowave.base.errors import InputError
from vasowave.base.io.textfile import regular_file

Packing = Literal["raw", "zlib", "gzip", "bzip2"]

LARGE, DENSE = 1 << 31, 200
"""What unpacks to more than LARGE bytes, and to more than DENSE times its size, is refused before it is unpacked."""

_CHUNK = 1 << 20  # bytes that are read at a time
_UNPACKED = 1 << 24  # bytes that are unpacked at a time
_REMEDY = "copy or export it again"


def no_voxel_size(path: Path, problem: str) -> InputError:
    """Return the error that a header does not say how large a voxel is: nothing is assumed."""
    return InputError(
        f"{path}: {problem}, so that the size of its voxels is not known; give it in cm: one number, or x,y,z",
        [VOXEL],
    )


_ELSEWHERE = {"nm": 1e-7, "inch": 2.54, "inches": 2.54}  # cm
_WORDS = {"millimeter": "mm", "millimetre": "mm", "centimeter": "cm", "centimetre": "cm", "meter": "m", "metre": "m",
          "micrometer": "um", "micrometre": "um", "micron": "um", "\\u00b5m": "um"}  # fmt: skip


def centimeters(unit: str) -> float:
    """Return how many cm a unit of length is, as files write it; 0 where it is none, as a pixel."""
    word = unit.strip(" \t\0\"'").lower()
    word = _WORDS.get(word, _WORDS.get(word.removesuffix("s"), word))
    return units.factor(word, "length") if units.is_of(word, "length") else _ELSEWHERE.get(word, 0.0)


def data_file(header: Path, name: str) -> Path:
    """Return the file of voxels that `header` names.

    Raises
    ------
    InputError
        It lies neither beside the header nor below: a header from elsewhere may name any file of this machine.
    """
    if Path(name).is_absolute() or ".." in Path(name).parts:
        raise InputError(
            f"{header}: names voxels outside its own folder ({name}); put that file, or a link to it, beside the "
            "header and name it there"
        )
    try:
        return regular_file(header.parent / name)
    except InputError as error:
        raise InputError(f"{header}: not an image that can be read: its voxels, {error}") from None


def require_bytes(path: Path, start: int, count: int, packing: Packing = "raw", offset: int = 0) -> None:
    """Raise `InputError` unless exactly `count` bytes of voxels stand in `path` from byte `start` on.

    `offset` bytes before them are skipped, of what comes out where they are packed; -1: they end the file. Packed
    voxels are unpacked in pieces, never more than there are; their own check sum must agree.
    """
    if packing == "raw":
        size = path.stat().st_size
        actual = min(size - start, count) if offset == -1 else size - start - offset
    else:
        size, count = path.stat().st_size, count + max(offset, 0)
        if count > max(LARGE, DENSE * size):
            raise InputError(
                f"{path}: {min(count, 10**30) / 1e9:.3g} GB of voxels in {size / 1e6:.1f} MB; no image is so even: "
                "it is damaged, or must be saved without compression"
            )
        try:
            actual = sum(map(len, unpacked(path, start, packing, count)))
        except (EOFError, OSError, ValueError, zlib.error) as error:
            raise InputError(f"{path}: truncated or damaged ({error}); {_REMEDY}") from None
    if actual < count:
        raise InputError(f"{path}: truncated, {max(actual, 0)} of {count} bytes of voxels; {_REMEDY}")
    if actual > count:
        raise InputError(f"{path}: more voxels than the {count} bytes that its header announces; {_REMEDY}")


def unpacked(path: Path, start: int, packing: Packing, limit: int) -> Iterator[bytes]:
    """Yield what stands packed in `path` from byte `start` on, in pieces; it ends soon after `limit` bytes.

    Raises
    ------
    EOFError
        The stream ends early.
    zlib.error, OSError, ValueError
        It is damaged.
    """
    stream, size = _stream(packing), 0
    with path.open("rb") as file:
        file.seek(start)
        while size <= limit:
            if stream.ended:
                remainder = stream.unused
                if packing == "zlib" or not (remainder or (remainder := file.read(_CHUNK))).strip(b"\0"):
                    return
                stream = _stream(packing)  # gzip and bzip2 may hold several streams, one after the other
                piece = stream.add(remainder)
            elif stream.hungry:
                chunk = file.read(_CHUNK)
                if not chunk:
                    raise EOFError("it ends too early")
                piece = stream.add(chunk)
            else:
                piece = stream.add(b"")
            size += len(piece)
            yield piece


class _Stream:
    """One packed stream that is unpacked in bounded pieces, whichever library does it."""

    def __init__(self, engine: Any, is_hungry: Callable[[Any], bool]) -> None:
        self._engine, self._is_hungry = engine, is_hungry

    def add(self, chunk: bytes) -> bytes:
        """Return at most `_UNPACKED` bytes more."""
        waiting = getattr(self._engine, "unconsumed_tail", b"")
        return self._engine.decompress(waiting + chunk, _UNPACKED)

    @property
    def hungry(self) -> bool:
        """Whether nothing more comes out before something goes in."""
        return self._is_hungry(self._engine)

    @property
    def ended(self) -> bool:
        """Whether the stream has come to its end."""
        return bool(self._engine.eof)

    @property
    def unused(self) -> bytes:
        """What stands behind the end."""
        return bytes(self._engine.unused_data)


def _stream(packing: Packing) -> _Stream:
    if packing == "bzip2":
        return _Stream(bz2.BZ2Decompressor(), lambda engine: engine.needs_input)
    window = {"zlib": zlib.MAX_WBITS, "gzip": 16 + zlib.MAX_WBITS}[packing]
    return _Stream(zlib.decompressobj(window), lambda engine: not engine.unconsumed_tail)
