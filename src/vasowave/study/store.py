"""What a run keeps in the folder of the results: finished pieces, journals of unfinished ones, and the lock.

A piece is one file ``KEY-DIGEST.nc``: KEY stands for everything that entered its computation, the animal included,
DIGEST is the SHA-256 of the file itself. It appears by renaming a complete file, and a file that does not match its
DIGEST, or that does not hold its KEY, is not a piece. So there is no moment at which a killed program or a full disk
could leave something that is mistaken for a result, and no result of one animal is taken for another's.

The journal of an animal holds every search of its fits as it ends, so that a run that was killed goes on from there:
one line of JSON an end, with a check sum. A line that was cut off by a kill or damaged since counts for nothing: its
search is made again. Whoever watches a run reads the journals of the animals that are being computed.
"""

import hashlib
import json
import os
import platform
import re
import threading
import zlib
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from datetime import datetime
from pathlib import Path
from typing import Any

import numpy as np

from vasowave.calibration import SearchEnd
from vasowave.errors import InputError
from vasowave.findings import look_kind, warn
from vasowave.io.files import made_inside, not_written, remove_parts, write_file
from vasowave.io.textfile import look, read_bytes
from vasowave.runtime.kept import digest_of, program
from vasowave.runtime.locks import lock_open_file

CACHE, SEARCHES, LOCK = "cache", "searches", "running.lock"
"""Folders of the pieces and of the journals, and the lock file, in the folder of the results."""

NO_LOCKS = look_kind("run.no-locks", "this file system knows no locks ({why}); {remedy}", "do not start a second run")
_NUMERICAL = ("numpy", "scipy", "numba", "xarray")
_NOT_NUMERICAL = ("cli", "workbench", "exchange", "datasets", "imaging", "figures", "report", "cohort")
"""Parts of the package that no run loads, or that only show what was computed: a change there asks for no
recomputation.
"""
_DIGITS = 32  # of a key
_OPEN = os.O_RDWR | os.O_CREAT | os.O_APPEND | getattr(os, "O_NOFOLLOW", 0)


def source_digest() -> str:
    """Return the digest of the sources that compute an animal, and of the numerical libraries' versions."""
    return program("", _NOT_NUMERICAL, _NUMERICAL)


def key_of(what: Any, files: Iterable[tuple[str, Path]]) -> str:
    """Return the key of values, of the bytes of files by their roles, and of the program; never of a file's time.

    Raises
    ------
    InputError
        A file cannot be read.
    """
    return digest_of(source_digest(), what, [(role, look(path).sha256) for role, path in files])[:_DIGITS]


class Store:
    """The folder of finished pieces in that of the results. One program at a time may write to it (see `locked`).

    It is made if missing; unfinished files of an earlier program are removed.
    """

    def __init__(self, results: Path) -> None:
        self.folder = made_inside(results, CACHE)
        remove_parts(self.folder)

    def find(self, key: str) -> Path | None:
        """Return the piece of `key`; None if there is none, or only a damaged one, which is removed.

        Raises
        ------
        InputError
            Something that is no file stands in its place and cannot be removed.
        """
        there = os.listdir(self.folder) if self.folder.is_dir() else []  # by a pattern, thousands would take seconds
        for path in (self.folder / name for name in sorted(there) if name.startswith(f"{key}-") and name[-3:] == ".nc"):
            if _is_whole(path, key):
                return path
            if path.is_dir() and not path.is_symlink():
                raise InputError(f"{path}: a folder where a finished piece should be; remove it and run again")
            try:
                path.unlink(missing_ok=True)
            except OSError as error:
                raise not_written(path, error) from None
        return None

    def keep(self, key: str, content: bytes) -> Path:
        """Store a piece, in whose content its key stands, and return its file.

        Raises
        ------
        InputError
            It could not be written, because the disk is full or read-only; nothing is left of it.
        """
        if not self.folder.is_dir():
            raise InputError(f"{self.folder}: was removed while the study ran; run again, nothing else is lost")
        return write_file(self.folder / f"{key}-{hashlib.sha256(content).hexdigest()}.nc", content)


def piece_digest(path: Path) -> str:
    """Return the SHA-256 that the name of a piece states."""
    return path.stem.rpartition("-")[2]


def _is_whole(path: Path, key: str) -> bool:
    try:
        content = read_bytes(path)
    except InputError:  # a folder or a link to nowhere in its place
        return False
    return hashlib.sha256(content).hexdigest() == piece_digest(path) and key.encode() in content


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
                f"{path.parent}: the study is being run by {_runner(file.read())}; wait for it, or stop it first"
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
                return _runner(file.read())
    except OSError:
        pass
    return None


def _runner(content: bytes) -> str:
    return content.decode(errors="replace").strip() or "another program"


class Journal:
    """The file of one animal; made when the first search ends.

    Parameters
    ----------
    path : Path
        Its folder exists on this machine, or nothing is kept (a cluster without a common disk).
    """

    def __init__(self, path: Path) -> None:
        self.path, self._lock = path, threading.Lock()
        self.known = {(one["wall"], one["stage"], one["start"]): _search_end(one) for one in read_journal(path)}

    def of(self, wall: str, starts: int) -> "WallEnds":
        """Return where the ends of the searches of one wall law are found and kept."""
        return WallEnds(self, wall, starts)

    def simulations(self, wall: str) -> Path | None:
        """Return the file that keeps the simulations of the posterior of one wall law, if its folder is here."""
        name = re.sub(r"\W", "_", wall)
        return self.path.with_name(f"{self.path.stem}-{name}.npz") if self.path.parent.is_dir() else None

    def write(self, entry: Mapping[str, Any]) -> None:
        """Add an end; what cannot be written is not kept, and the work goes on."""
        text = json.dumps(entry)
        with self._lock:
            try:
                torn = self.path.exists() and not self.path.read_bytes().endswith(b"\n")
                with self.path.open("a", encoding="utf-8") as file:
                    file.write("\n" * torn + f"{_checksum(text):08x} {text}\n")
            except OSError:
                return


class WallEnds:
    """The ends of the searches with one wall law, see `calibration.calibrate`."""

    def __init__(self, journal: Journal, wall: str, starts: int) -> None:
        self.journal, self.wall, self.starts = journal, wall, starts

    def find(self, stage: str, start: int) -> SearchEnd | None:
        """Return where the search of a stage from a start ended, if that is known."""
        return self.journal.known.get((self.wall, stage, start))

    def keep(self, stage: str, start: int, end: SearchEnd) -> None:
        """Keep where the search of a stage from a start ended."""
        entry = {"wall": self.wall, "stage": stage, "start": start, "starts": self.starts} | vars(end)
        self.journal.write(entry | {"x": end.x.tolist(), "residual": end.residual.tolist()})


def read_journal(path: Path) -> list[dict[str, Any]]:
    """Return the whole lines of a journal, in order; none where there is no journal."""
    try:
        lines = path.read_text("utf-8", errors="replace").splitlines()
    except OSError:
        return []
    split = (line.partition(" ") for line in lines)
    return [json.loads(text) for check, _, text in split if check == f"{_checksum(text):08x}"]


def remove_journals(folder: Path) -> None:
    """Remove the journals of animals that are done."""
    for kind in ("*.jsonl", "*.npz"):
        for path in (folder / SEARCHES).glob(kind):
            path.unlink(missing_ok=True)


def _search_end(entry: Mapping[str, Any]) -> SearchEnd:
    values = {name: entry[name] for name in ("S", "simulations", "converged", "message", "joined")}
    return SearchEnd(x=np.array(entry["x"]), residual=np.array(entry["residual"]), **values)


def _checksum(text: str) -> int:
    return zlib.crc32(text.encode())
