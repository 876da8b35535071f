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
import time
import zlib
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from vasowave.base.errors import InputError
from vasowave.base.findings import look_kind, warn
from vasowave.base.io.files import check_home, in_words, made_inside, make_folder, remove_file, remove_parts, write_file
from vasowave.base.io.textfile import look, read_bytes
from vasowave.base.runtime.kept import digest_of, program
from vasowave.base.runtime.locks import lock_open_file
from vasowave.base.runtime.writing import append, open_regular, opened, write_all
from vasowave.base.stores import parsed_as, stored

if TYPE_CHECKING:
    from vasowave.pulse.calibration.optimization import SearchEnd

CACHE, SEARCHES, LOCK = "cache", "searches", "running.lock"
"""Folders of the pieces and of the journals, and the lock file, in the folder of the results."""

NO_LOCKS = look_kind("run.no-locks", "this file system knows no locks ({why}); {remedy}", "do not start a second run")
_NUMERICAL_PACKAGES = ("numpy", "scipy", "numba", "xarray")
_NOT_NUMERICAL = (
    "cli",
    "workbench",
    "lung",
    "pulse/examples",
    *(f"study/{room}" for room in ("door", "exchange", "datasets", "figures", "report", "cohort")),
)
"""Parts of the package that no run loads, or that only show what was computed: a change there asks for no
recomputation.
"""
_KEY_DIGITS = 32  # of a key
_LOCK_TRIES, _LOCK_WAIT_S = 5, 0.05  # tries of locking, and s between them
_MAX_LOCK_BYTES = 1000  # bytes of a lock that are read


def source_digest() -> str:
    """Return the digest of the sources that compute an animal, and of the numerical libraries' versions."""
    return program("", _NOT_NUMERICAL, _NUMERICAL_PACKAGES)


def key_of(values: Any, files: Iterable[tuple[str, Path]]) -> str:
    """Return the key of values, of the bytes of files by their roles, and of the program; never of a file's time.

    Raises
    ------
    InputError
        A file cannot be read.
    """
    return digest_of(source_digest(), values, [(role, look(path).sha256) for role, path in files])[:_KEY_DIGITS]


class ResultStore:
    """The folder of finished pieces in that of the results. One program at a time may write to it (see `locked`).

    It is made if missing; unfinished files of an earlier program are removed.
    """

    def __init__(self, results: Path) -> None:
        self.folder: Path = made_inside(results, CACHE)
        remove_parts(self.folder)

    @stored("finished piece", f"results/{CACHE}/*.nc")
    def find(self, key: str) -> Path | None:
        """Return the piece of `key`; None if there is none, or only a damaged one, which is removed.

        Raises
        ------
        InputError
            Something that is not a file stands in its place and cannot be removed.
        """
        names = os.listdir(self.folder) if self.folder.is_dir() else []  # by a pattern, thousands would take seconds
        for path in (self.folder / name for name in sorted(names) if name.startswith(f"{key}-") and name[-3:] == ".nc"):
            if _is_whole(path, key):
                return path
            if path.is_dir() and not path.is_symlink():
                raise InputError(f"{path}: a folder where a finished piece should be; remove it and run again")
            remove_file(path)
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
        piece = self.folder / f"{key}-{hashlib.sha256(content).hexdigest()}.nc"
        check_home(piece, 2)
        return write_file(piece, content)


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
def locked(path: Path) -> Iterator[bool]:
    """Hold the lock file `path`; gives False where the file system knows no locks.

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
    make_folder(path.parent)
    with in_words(path):
        handle = open_regular(path, os.O_RDWR | os.O_CREAT)
    try:
        held = True
        try:
            _lock_patiently(handle)
        except BlockingIOError:
            raise InputError(
                f"{path.parent}: the study is being run by {_runner(handle)}; wait for it, or stop it first"
            ) from None
        except OSError as error:
            warn(NO_LOCKS(why=error.strerror or "").at(str(path)), stacklevel=3)
            held = False
        with suppress(OSError):  # on a full disk nobody learns who holds the lock; it holds all the same
            owner_text = f"process {os.getpid()} on {platform.node()} since {datetime.now():%Y-%m-%d %H:%M:%S}"
            os.ftruncate(handle, 0)
            write_all(handle, owner_text.encode())
        yield held
    finally:
        os.close(handle)


def _lock_patiently(handle: int) -> None:
    """Lock an open file; who only looks whether it is locked (`holder`) holds it for a moment."""
    for _ in range(_LOCK_TRIES - 1):
        with suppress(BlockingIOError):
            return lock_open_file(handle)
        time.sleep(_LOCK_WAIT_S)
    lock_open_file(handle)


def holder(path: Path) -> str | None:
    """Return who holds the lock file `path`, as it wrote itself there; None if nobody does."""
    with suppress(OSError), opened(path, os.O_RDWR) as handle:
        try:
            lock_open_file(handle)
        except BlockingIOError:
            return _runner(handle)
    return None


def _runner(handle: int) -> str:
    os.lseek(handle, 0, os.SEEK_SET)
    return os.read(handle, _MAX_LOCK_BYTES).decode(errors="replace").strip() or "another program"


@dataclass(frozen=True)
class JournalEnd:
    """A line of a journal: where the search of a stage from one of all starts ended, see `calibration.SearchEnd`."""

    wall: str
    stage: str
    start: int
    starts: int
    x: list[float]
    S: float
    simulations: int
    converged: bool
    message: str
    residual: list[float]
    joined: bool


class Journal:
    """The file of one animal; made when the first search ends.

    Holds state because searches of several threads write into it, one at a time.

    Parameters
    ----------
    path : Path
        Its folder exists on this machine, or nothing is kept (a cluster without a common disk).
    """

    def __init__(self, path: Path) -> None:
        self.path: Path = path
        self._lock = threading.Lock()
        self.known: dict[tuple[str, str, int], SearchEnd] = {
            (end.wall, end.stage, end.start): _search_end(end) for end in read_journal(path)
        }

    def searches(self, wall: str, starts: int) -> "WallEnds":
        """Return where the ends of the searches of one wall law are found and kept."""
        return WallEnds(self, wall, starts)

    def simulations(self, wall: str) -> Path | None:
        """Return the file that keeps the simulations of the posterior of one wall law, if its folder is here."""
        name = re.sub(r"\W", "_", wall)
        return self.path.with_name(f"{self.path.stem}-{name}.npz") if self.path.parent.is_dir() else None

    def write(self, end: JournalEnd) -> None:
        """Add an end; what cannot be written is not kept, and the work goes on."""
        text = json.dumps(vars(end))
        with self._lock, suppress(OSError, InputError):
            check_home(self.path, 2)
            append(self.path, f"{_checksum(self.path, text):08x} {text}".encode())


class WallEnds:
    """The ends of the searches with one wall law, see `calibration.fitting`."""

    def __init__(self, journal: Journal, wall: str, starts: int) -> None:
        self.journal: Journal = journal
        self.wall: str = wall
        self.starts: int = starts

    def find(self, stage: str, start: int) -> "SearchEnd | None":
        """Return where the search of a stage from a start ended, if that is known."""
        return self.journal.known.get((self.wall, stage, start))

    def keep(self, stage: str, start: int, end: "SearchEnd") -> None:
        """Keep where the search of a stage from a start ended."""
        plain: Any = vars(end) | {"x": end.x.tolist(), "residual": end.residual.tolist()}
        self.journal.write(JournalEnd(self.wall, stage, start, self.starts, **plain))


@stored("journal of searches", f"results/{SEARCHES}/*.jsonl")
def read_journal(path: Path) -> list[JournalEnd]:
    """Return the whole lines of a journal, in order; none where there is no journal."""
    try:
        with opened(path) as handle, open(handle, encoding="utf-8", errors="replace", closefd=False) as file:
            lines = file.read().splitlines()
    except OSError:
        return []
    ends = []
    for check, _, text in (line.partition(" ") for line in lines):
        if check == f"{_checksum(path, text):08x}":
            with suppress(ValueError):
                ends.append(parsed_as(JournalEnd, text))
    return ends


def remove_journals(folder: Path) -> None:
    """Remove the journals of animals that are done."""
    for kind in ("*.jsonl", "*.npz"):
        for path in (folder / SEARCHES).glob(kind):
            remove_file(path)


def _search_end(end: JournalEnd) -> "SearchEnd":
    from vasowave.pulse.calibration.optimization import SearchEnd

    x, residual = np.array(end.x), np.array(end.residual)
    return SearchEnd(x, end.S, end.simulations, end.converged, end.message, residual, end.joined)


def _checksum(journal: Path, text: str) -> int:
    """Return the check sum of a line, which is none in the journal of another animal."""
    return zlib.crc32(f"{journal.stem} {text}".encode())
