"""The formats of volumes: one module each, which registers what it reads."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

from vasowave.base.io.formats import Format, Registry
from vasowave.lung.read.volume import Image


class Contents(NamedTuple):
    """What a header announces.

    Attributes
    ----------
    size : int
        Of its voxels, unpacked, bytes.
    unsized : str
        Why the size of a voxel is not known; empty where it is.
    """

    size: int
    unsized: str = ""


@dataclass(frozen=True)
class VolumeFormat(Format):
    """How images of one kind are known and read: by their names, because compiled libraries look into them.

    Attributes
    ----------
    read : callable
        Takes a path, returns an `Image`; it runs in another process.
    check : callable, optional
        Takes a path, returns its `Contents`; refuses a file that does not hold what its header says.
    mapped : callable, optional
        Takes a path, returns an `Image` whose voxels lie in a file as in memory, None where they do not; it calls no
        compiled library and runs in this process.
    oriented : bool
        Whether such files say how their axes lie in the world.
    """

    check: Callable[[Path], Contents] | None = None
    mapped: Callable[[Path], Image | None] | None = None
    oriented: bool = True


class _Volumes(Registry[VolumeFormat]):
    def start(self, path: Path) -> bytes:
        """Return nothing: images are long."""
        return b""


VOLUMES = _Volumes("vasowave.lung.read", "other image")
"""Every format of volumes."""
