"""Finished pieces of a study, found again by what went into them.

A piece is one file ``KEY-DIGEST.nc``: KEY stands for everything that entered its computation, DIGEST is the SHA-256 of
the file itself. It appears by renaming a complete file, and a file that does not match its DIGEST is not a piece. So
there is no moment at which a killed program or a full disk could leave something that is mistaken for a result.
"""

import errno
import hashlib
import os
import tempfile
from collections.abc import Callable
from pathlib import Path

from vasowave.errors import InputError

_PART = ".part"
_FULL = {errno.ENOSPC, errno.EFBIG, getattr(errno, "EDQUOT", errno.ENOSPC)}


class Store:
    """The folder of finished pieces. One program at a time may write to it (see `study.lock`).

    Parameters
    ----------
    folder : Path
        Made if missing; unfinished files of an earlier program are removed.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        try:
            folder.mkdir(parents=True, exist_ok=True)
            for rest in folder.glob(f"*{_PART}*"):
                rest.unlink()
        except OSError as error:
            raise not_written(folder, error) from None

    def find(self, key: str) -> Path | None:
        """Return the piece of `key`; None if there is none, or only a damaged one, which is removed."""
        for path in sorted(self.folder.glob(f"{key}-*.nc")):
            if path.stem.rpartition("-")[2] == digest(path):
                return path
            path.unlink(missing_ok=True)
        return None

    def keep(self, key: str, write: Callable[[Path], object]) -> Path:
        """Store what `write` writes to the path it is given.

        Raises
        ------
        InputError
            It could not be written, because the disk is full or read-only; nothing is left of it.
        """
        handle, name = tempfile.mkstemp(f"{_PART}.nc", f"{key}-", self.folder)
        os.close(handle)
        part = Path(name)
        try:
            write(part)
            flush(part)
            final = self.folder / f"{key}-{digest(part)}.nc"
            part.replace(final)
            flush(self.folder)
        except (OSError, RuntimeError) as error:  # the netCDF library reports a full disk as RuntimeError
            raise not_written(self.folder, error) from None
        finally:
            part.unlink(missing_ok=True)
        return final


def replace_file(path: Path, write: Callable[[Path], object]) -> None:
    """Put what `write` writes in the place of `path`, whole or not at all.

    Raises
    ------
    InputError
        It could not be written; what was there before still is.
    """
    part = path.with_name(f".{path.stem}{_PART}{path.suffix}")
    try:
        write(part)
        flush(part)
        part.replace(path)
        flush(path.parent)
    except (OSError, RuntimeError) as error:
        raise not_written(path, error) from None
    finally:
        part.unlink(missing_ok=True)


def digest(path: Path) -> str:
    """Return the SHA-256 of a file."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def is_full(error: BaseException) -> bool:
    """Whether an error says that the disk, or the quota on it, is full."""
    return isinstance(error, OSError) and error.errno in _FULL


def not_written(path: Path, error: OSError | RuntimeError) -> InputError:
    """Return the error that says why `path` could not be written, and what to do."""
    if is_full(error):
        return InputError(f"{path}: no space left; what had finished is kept, make room and run again")
    return InputError(
        f"{path}: cannot be written ({getattr(error, 'strerror', None) or error}); what had finished is kept"
    )


def flush(path: Path) -> None:
    """Wait until a file or folder is on the disk, not only in memory."""
    flags = os.O_RDONLY if path.is_dir() or os.name != "nt" else os.O_RDWR
    try:
        handle = os.open(path, flags)
    except PermissionError:  # Windows does not open folders
        return
    try:
        os.fsync(handle)
    finally:
        os.close(handle)
