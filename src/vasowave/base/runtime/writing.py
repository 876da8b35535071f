"""The one place that opens, moves and removes files for writing; all that stands above writes through it.

A folder from elsewhere may hold a link, a pipe or a device where a file is to be: none of them is followed or opened. A
file appears whole, by renaming, or not at all. It keeps the mode of the file that it replaces, else it has that of the
user's mask.
"""

import errno
import os
import secrets
import stat
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from types import TracebackType
from typing import Self

import numpy as np

from vasowave.base.runtime.locks import lock_open_file

PART = ".vasowave-part-"
"""Beginning of the hidden names; what a killed program left under such a name may be removed."""

Piece = bytes | np.ndarray
_DEFAULT_MODE = 0o666  # before the user's mask
_PLAIN_FLAGS = getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0)  # no pipe holds the program
_NO_LINK = getattr(os, "O_NOFOLLOW", 0)
_WORDS = {
    errno.EISDIR: "is a directory", errno.ENXIO: "is a pipe or a device, not a file", errno.EMLINK: "has a second name"
}  # fmt: skip


def open_regular(path: Path, flags: int = os.O_RDONLY, *, links: bool = False, mode: int = _DEFAULT_MODE) -> int:
    """Return the handle of a regular file; `OSError` where it cannot be opened, or is a pipe, a device or a folder.

    Unless `links`, it is none that a link leads to, and has no second name: what is written must not be elsewhere, too.
    """
    handle = os.open(path, flags | _PLAIN_FLAGS | (0 if links else _NO_LINK), mode)
    if wrong := _wrong(os.fstat(handle), links):
        os.close(handle)
        raise OSError(wrong, _WORDS[wrong], str(path))
    return handle


def _wrong(about: os.stat_result, links: bool) -> int:
    """Return why a file is none to be opened, as the number of an error; 0 where it may be."""
    if not stat.S_ISREG(about.st_mode):
        return errno.EISDIR if stat.S_ISDIR(about.st_mode) else errno.ENXIO
    return errno.EMLINK if about.st_nlink > 1 and not links else 0


@contextmanager
def opened(path: Path, flags: int = os.O_RDONLY, *, links: bool = False) -> Iterator[int]:
    """Give the handle of a regular file, and close it; see `open_regular`."""
    handle = open_regular(path, flags, links=links)
    try:
        yield handle
    finally:
        os.close(handle)


class Part:
    """A file under a hidden name beside its place, until it is whole; left without that, it is removed.

    It gets `mode`, by default that of the file in this place, or else of the user's mask. `OSError` where it cannot be
    made, or a pipe, a device or a file that may not be written stands in the place.
    """

    def __init__(self, place: Path, mode: int | None = None) -> None:
        self.place: Path = place
        self._before = _mode_of(place) if mode is None else None
        self.path: Path = place.with_name(f"{PART}{secrets.token_hex(8)}{place.suffix}")
        self._handle = open_regular(
            self.path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, mode=_DEFAULT_MODE if mode is None else mode
        )
        if os.name != "nt":
            with suppress(OSError):  # a file system without locks
                lock_open_file(self._handle)  # so that it is not taken for what a killed program left
        self._open = True

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        if self._open:
            os.close(self._handle)
        with suppress(OSError):  # it is another's to remove, see `io.files.remove_parts`
            self.path.unlink(missing_ok=True)

    def write(self, piece: Piece) -> None:
        """Write a piece behind the others."""
        write_all(self._handle, piece)

    def end(self) -> None:
        """Wait until all is on the disk."""
        if self._before not in (None, stat.S_IMODE(os.fstat(self._handle).st_mode)):
            os.chmod(self.path, self._before)
        os.fsync(self._handle)
        if os.name == "nt":  # where nobody moves or removes a file that is open
            self._open = False
            os.close(self._handle)

    def take_place(self) -> None:
        """Replace what stands in the place, a link too."""
        os.replace(self.path, self.place)


def _mode_of(place: Path) -> int | None:
    """Return the mode of the file in a place; None where there is none, or a link, which is replaced."""
    try:
        about = os.lstat(place)
    except FileNotFoundError:
        return None
    if stat.S_ISLNK(about.st_mode) or stat.S_ISDIR(about.st_mode):  # renaming refuses a folder, in better words
        return None
    if wrong := _wrong(about, links=True) or (0 if os.access(place, os.W_OK) else errno.EACCES):
        raise OSError(wrong, os.strerror(wrong), str(place))
    return about.st_mode & 0o777


def write_all(handle: int, piece: Piece) -> None:
    """Write a piece into an open file, in as many steps as the system takes."""
    remainder = memoryview(piece)
    remainder = remainder.cast("B") if remainder.nbytes else remainder[:0]
    while len(remainder):
        remainder = remainder[os.write(handle, remainder) :]


def put(path: Path, pieces: Iterable[Piece], mode: int | None = None) -> None:
    """Write a file, whole or not at all; `OSError` where that fails, and nothing is left of it. See `Part`."""
    with Part(path, mode) as file:
        for piece in pieces:
            file.write(piece)
        file.end()
        file.take_place()


def append(path: Path, line: bytes) -> None:
    """Add a line to a file, made if missing; behind one that was cut off it begins a line of its own."""
    with opened(path, os.O_RDWR | os.O_CREAT | os.O_APPEND) as handle:
        os.lseek(handle, max(0, os.fstat(handle).st_size - 1), os.SEEK_SET)
        write_all(handle, b"\n" * (os.read(handle, 1) not in (b"", b"\n")) + line + b"\n")


def flush(path: Path) -> None:
    """Wait until a file or folder is on the disk, not only in memory."""
    if path.is_symlink():
        return
    flags = os.O_RDONLY if path.is_dir() or os.name != "nt" else os.O_RDWR
    try:
        handle = os.open(path, flags)
    except PermissionError:  # Windows does not open folders
        return
    try:
        os.fsync(handle)
    finally:
        os.close(handle)
