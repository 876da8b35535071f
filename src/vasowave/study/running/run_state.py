"""The status of a run: begun, how far, asked to stop by whom, ended how. It survives a full disk and a killed program.

It stands beside the results in slots whose room is reserved: two that the run overwrites in turn, and one for whoever
asks it to stop. A run that is killed writes no end: the lock that it no longer holds tells, and the program that began
it, if there is one, knows by which signal.
"""

import json
import os
import platform
import signal
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import asdict, dataclass, replace
from datetime import datetime
from enum import StrEnum
from io import FileIO
from pathlib import Path
from typing import Any, NamedTuple

from vasowave.base.errors import InputError, VasowaveError
from vasowave.base.io.files import is_full, made_inside, not_written
from vasowave.base.io.reserved import opened, read_slots, reserve, write_slot
from vasowave.base.runtime.interrupts import interrupt_main, is_heard, is_interrupt
from vasowave.base.runtime.memory import is_starved, kills_for_memory
from vasowave.base.stores import parsed_as, stored
from vasowave.study.animal.failure import unforeseen
from vasowave.study.folder.places import RESULTS
from vasowave.study.results.store import LOCK, holder, locked

STATUS = "run.status"
"""The file of the slots, in the folder of the results."""

_SLOT_COUNT, _REQUEST_SLOT = 3, 2
_LOOK_INTERVAL_S = 0.5  # s between looks for somebody who asks the run to stop
_REPEAT_AFTER_S = 3.0  # s after which an interruption that a library swallowed comes again
_STOP_PATIENCE_S = 5.0  # s from the first request until a second one ends the program at once
_MAX_MESSAGE_LETTERS = 1000  # letters of a message


class Ended(StrEnum):
    """How a run ended."""

    FINISHED = "finished"
    STOPPED = "stopped"
    FAILED = "failed"
    KILLED = "killed"
    OUT_OF_MEMORY = "out of memory"
    DISK_FULL = "disk full"


_REMEDIES = {
    Ended.STOPPED: "Run it again to go on",
    Ended.KILLED: "The system may have killed it for lack of memory; run it again, with fewer processes if it ends so "
    "again",
    Ended.OUT_OF_MEMORY: "Close other programs or take fewer processes, and run it again",
    Ended.DISK_FULL: "Make room on the disk, and run it again",
}


@dataclass(frozen=True)
class RunStatus:
    """How far a run of a study is, or how it ended.

    Attributes
    ----------
    begun : str
        Date and time, local.
    process : int
    node : str
        The machine.
    started : str
        What tells the process from a later one of the same number; empty where the system does not say.
    stage : str
        ``reading files``, ``computing``, ``writing the results`` or ``writing the report``.
    done, count : int
        Animals that are done, and all.
    left : float or None
        Estimated time left for the animals, s.
    stopped_by : str
        Who asked it to stop; empty if nobody did.
    ended : Ended or None
        None while it goes on.
    message : str
        What came out, or why it ended.
    written : int
        How often it was written down.
    locks : bool
        Whether the file system knows locks.
    killed_before : int
        Programs that the system had killed for lack of memory when it began.
    """

    begun: str
    process: int
    node: str
    started: str = ""
    stage: str = "reading files"
    done: int = 0
    count: int = 0
    left: float | None = None
    stopped_by: str = ""
    ended: Ended | None = None
    message: str = ""
    written: int = 0
    locks: bool = True
    killed_before: int = 0

    def __str__(self) -> str:
        """Return the status as sentences."""
        progress = f"{self.stage}, {self.done} of {self.count} animals done"
        by = f" by {self.stopped_by}" if self.stopped_by else ""
        if self.ended is None:
            return f"{progress}; asked to stop{by}" if by else progress
        progress = "" if self.ended is Ended.FINISHED else f" while {progress}"
        sentences = [text for text in (self.message, _REMEDIES.get(self.ended, "")) if text]
        return f"The last run, of {self.begun}: {'. '.join([f'{self.ended}{by}{progress}', *sentences])}"

    @property
    def is_alive(self) -> bool:
        """Whether its process is there; of another machine this is believed where no lock can tell."""
        if self.node != platform.node():
            return not self.locks
        return self.started != "" and self.started == _start_of(self.process)


class _Request(NamedTuple):
    """Somebody asks a run to stop: which one, who, and when (s)."""

    begun: str
    process: int
    by: str
    asked_at: float


@stored("status of a run", f"{RESULTS}/{STATUS}")
def run_status(results: Path) -> RunStatus | None:
    """Return how far the run is that goes on, or how the last one ended; None where none was begun.

    Parameters
    ----------
    results : Path
        The folder of the results.
    """
    going = holder(results / LOCK)
    status, request = _read(results)
    if status is None or (status.ended and going and not status.is_alive):  # another, which has only begun
        return None
    if status.ended:
        return status
    status = replace(status, stopped_by=request.by if request else "")
    if going or status.is_alive or holder(results / LOCK):
        return status
    ended, reason = Ended.KILLED, "Its process ended without a word"
    if request:
        ended, reason = Ended.STOPPED, "Its process was ended at once"
    elif status.node == platform.node() and kills_for_memory() > status.killed_before:
        ended, reason = Ended.OUT_OF_MEMORY, "The system killed programs for lack of memory while it went on"
    return replace(status, ended=ended, message=reason)


def _read(results: Path) -> tuple[RunStatus | None, _Request | None]:
    """Return what the run wrote last, whole, and the request that it stop."""
    *written, request_text = read_slots(results / STATUS, _SLOT_COUNT)
    statuses = [candidate for candidate in (_value(text, RunStatus) for text in written) if candidate]
    status = max(statuses, key=lambda candidate: candidate.written, default=None)
    request = _value(request_text, _Request)
    of_it = status and request and request[:2] == (status.begun, status.process)
    return status, request if of_it else None


def _value(text: str, kind: Any) -> Any:
    """Return what a text says, checked; None if it is nothing of ours, or no terminal should show it."""
    try:
        value = parsed_as(kind, text)
    except ValueError:
        return None
    return value if str(value).replace("\n", "").isprintable() else None


class RunRecord:
    """What a run that goes on here writes of itself; what cannot be written is not, and the run goes on.

    Holds state because only what has changed is told, and a run may be asked to stop.

    Attributes
    ----------
    status : RunStatus
        As it was written last.
    """

    def __init__(self, results: Path, file: FileIO, status: RunStatus) -> None:
        self.results: Path = results
        self.status: RunStatus = status
        self._file, self._asked, self._over = file, threading.Event(), threading.Event()

    def write(self, **changes: Any) -> None:
        """Write what has changed."""
        self.status = replace(self.status, **changes, written=self.status.written + 1)
        _write(self._file, self.status)

    def go_on(self) -> None:
        """Raise `KeyboardInterrupt` if the run is asked to stop and no signal can interrupt it."""
        if self._asked.is_set():
            raise KeyboardInterrupt

    @contextmanager
    def watched(self) -> Iterator[None]:
        """Look, while the block goes on, whether somebody asks the run to stop; write how it ended."""
        watcher = threading.Thread(target=self._watch, args=(is_heard(),), daemon=True)
        watcher.start()
        ended, message, by = Ended.FINISHED, "", ""
        try:
            yield
        except BaseException as error:
            ended, message = _ending(error)
            if ended is Ended.STOPPED:
                request = _read(self.results)[1]
                by = request.by if request else (str(error) if isinstance(error, KeyboardInterrupt) else "") or "Ctrl-C"
            raise
        finally:
            self._over.set()
            watcher.join()
            self.write(ended=ended, message=message or self.status.message, stopped_by=by, left=None)

    def _watch(self, heard: bool) -> None:
        while not self._over.wait(_REPEAT_AFTER_S if self._asked.is_set() else _LOOK_INTERVAL_S):
            if self._asked.is_set() or _read(self.results)[1]:
                self._asked.set()
                if heard:
                    interrupt_main()


def _write(file: FileIO, status: RunStatus) -> None:
    with suppress(OSError):
        write_slot(file, status.written % _REQUEST_SLOT, json.dumps(asdict(status)))


def _ending(error: BaseException) -> tuple[Ended, str]:
    text = str(error) if isinstance(error, VasowaveError) else unforeseen(error)
    plain = "".join(sign if sign.isprintable() or sign == "\n" else "?" for sign in text)
    message = plain if len(plain) <= _MAX_MESSAGE_LETTERS else f"{plain[:_MAX_MESSAGE_LETTERS]} …"
    if is_interrupt(error):
        return Ended.STOPPED, "What had finished is kept"
    if is_full(error):
        return Ended.DISK_FULL, message
    return (Ended.OUT_OF_MEMORY, "What had finished is kept") if is_starved(error) else (Ended.FAILED, message)


@contextmanager
def running(folder: Path, count: int = 0) -> Iterator[RunRecord]:
    """Hold the lock of a study and write down how its run goes, until results and report are written.

    Raises
    ------
    InputError
        Another run is going on in this study; the disk is full or read-only.
    """
    results, process = made_inside(folder, RESULTS), os.getpid()
    with locked(results / LOCK) as locks, reserved(results) as file:
        begun, started = f"{datetime.now():%Y-%m-%d %H:%M:%S}", _start_of(process)
        status = RunStatus(begun, process, platform.node(), started, count=count, locks=locks)
        record = RunRecord(results, file, replace(status, killed_before=kills_for_memory()))
        record.write()
        with record.watched():
            yield record


def reserved(results: Path) -> FileIO:
    """Return the file in which a run that is to begin will write; `InputError` on a full or read-only disk."""
    try:
        return reserve(results / STATUS, _SLOT_COUNT)
    except OSError as error:
        raise not_written(results / STATUS, error) from error


def ask_to_stop(results: Path, by: str) -> str:
    """Ask the run that goes on to stop, wherever it runs; once more after some seconds, end its process at once.

    Returns
    -------
    str
        What happens now.

    Raises
    ------
    InputError
        It cannot be asked; or it was, runs on another machine, and does not stop.
    """
    status, request = run_status(results), _read(results)[1]
    if status is None or status.ended:
        return "nothing runs here"
    if request is None:
        stop_request = _Request(status.begun, status.process, by, time.time())
        try:
            with opened(results / STATUS, _SLOT_COUNT) as file:
                write_slot(file, _REQUEST_SLOT, json.dumps(stop_request))
        except OSError as error:
            raise not_written(results / STATUS, error) from error
    elif time.time() - request.asked_at > _STOP_PATIENCE_S:
        if status.node != platform.node() or not status.is_alive:
            raise InputError(f"the run was asked to stop and does not; end process {status.process} on {status.node}")
        with suppress(ProcessLookupError):
            os.kill(status.process, getattr(signal, "SIGKILL", signal.SIGTERM))
        return "the run did not stop and was ended at once; what had finished is kept"
    patience = f"{_STOP_PATIENCE_S:.0f} s"
    return f"the run is being stopped; what had finished is kept. If it goes on, stop it again after {patience}"


def record_end(results: Path, process: int, code: int) -> None:
    """Write how a run ended that could not do so itself: whoever began it knows its exit status, or its signal."""
    written, status = _read(results)[0], run_status(results)
    if written is None or written.process != process or written.ended or status is None or status.ended is None:
        return
    if status.ended is Ended.KILLED:
        cause = signal.Signals(-code).name if code < 0 else f"exit status {code}"
        status = replace(status, message=f"Its process ended without a word ({cause})")
    with suppress(OSError), opened(results / STATUS, _SLOT_COUNT) as file:
        _write(file, replace(status, written=status.written + 1))


def _start_of(process: int) -> str:
    """Return when a process began, by the system's own count; empty where there is none, or the system does not say."""
    try:
        state, *fields = Path(f"/proc/{process}/stat").read_text(encoding="utf-8").rpartition(")")[2].split()
    except OSError:
        return ""
    return "" if state == "Z" else fields[18]
