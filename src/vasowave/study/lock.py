"""One run at a time in one study."""

import os
import platform
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from datetime import datetime
from pathlib import Path

from vasowave.errors import InputError
from vasowave.findings import look_kind, warn
from vasowave.io.files import not_written
from vasowave.runtime.locks import lock_open_file

_OPEN = os.O_RDWR | os.O_CREAT | os.O_APPEND | getattr(os, "O_NOFOLLOW", 0)

NO_LOCKS = look_kind("run.no-locks", "this file system knows no locks ({why}); {remedy}", "do not start a second run")


@contextmanager
def locked(path: Path) -> Iterator[None]:
    """Hold the lock file `path`.

    The operating system holds the lock, and lets go of it however the program ends; a file that a killed program left
    behind is therefore no lock.

    Raises
    ------
    InputError
        Another program holds it; the message says which and since when.

    Warns
    -----
    VasowaveWarning
        If the file system knows no locks; the run goes on without.
    """
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        handle = os.open(path, _OPEN, 0o644)  # a link in its place is refused
    except OSError as error:
        raise not_written(path, error) from None
    with os.fdopen(handle, "rb+", buffering=0) as file:  # without a buffer, which on a full disk closing writes again
        try:
            lock_open_file(handle)
        except BlockingIOError:
            raise InputError(
                f"{path.parent}: the study is being run by {_said(file.read())}; wait for it, or stop it first"
            ) from None
        except OSError as error:
            warn(NO_LOCKS(why=error.strerror or "").at(str(path)), stacklevel=3)
        with suppress(OSError):  # on a full disk nobody learns who holds the lock; it holds all the same
            file.truncate(0)
            file.write(f"process {os.getpid()} on {platform.node()} since {datetime.now():%Y-%m-%d %H:%M:%S}".encode())
        yield


def holder(path: Path) -> str | None:
    """Return who holds the lock file `path`, as it wrote itself there; None if nobody does."""
    try:
        with path.open("rb+") as file:
            try:
                lock_open_file(file.fileno())
            except BlockingIOError:
                return _said(file.read())
    except OSError:
        pass
    return None


def _said(content: bytes) -> str:
    return content.decode(errors="replace").strip() or "another program"
