"""The formats of volumes: one module each, which registers what it reads."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from vasowave.base.io.formats import Format, Registry


@dataclass(frozen=True)
class VolumeFormat(Format):
    """How images of one kind are known and read: by their names, because compiled libraries look into them.

    Attributes
    ----------
    read : callable
        Takes a path, returns an `Image`; it runs in another process.
    check : callable, optional
        Takes a path and whether the voxel size must be told; refuses a file that does not hold what its header says.
    """

    check: Callable[[Path, bool], None] | None = None


class _Volumes(Registry[VolumeFormat]):
    def start(self, path: Path) -> bytes:
        """Return nothing: images are long."""
        return b""


VOLUMES = _Volumes("vasowave.lung.read", "other image")
"""Every format of volumes."""
