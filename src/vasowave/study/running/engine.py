"""Compute many independent pieces on any executor, keep each as soon as it is there, and go on when one fails."""

import os
import time
from collections import deque
from collections.abc import Callable, Sequence
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, CancelledError, Executor, Future, wait
from contextlib import AbstractContextManager
from dataclasses import dataclass
from typing import Any, NamedTuple

from vasowave.base.errors import InputError, VasowaveError
from vasowave.base.io.files import is_full
from vasowave.base.runtime.kernels import seconds_compiling
from vasowave.base.runtime.memory import is_starved
from vasowave.base.runtime.thread_limits import VARIABLE, cores
from vasowave.study.animal.failure import unforeseen
from vasowave.study.results.store import source_digest

Pools = Callable[[int], AbstractContextManager[Executor]]
"""Gives an executor with (up to) the stated number of workers."""

_DEATH_TEXT = (
    "its process died or ran out of memory, also when nothing ran beside it; give it more memory and run again"
)


@dataclass(frozen=True)
class Job:
    """One piece to compute: `function(*arguments)` must be picklable."""

    name: str
    """What messages call it."""
    key: str
    """Stands for everything that enters."""
    load: Callable[[], tuple[Any, ...]]
    """Returns the arguments; called here, just before the piece is handed to a worker."""


@dataclass(frozen=True)
class Progress:
    """The event that a run emits whenever a piece is done.

    Attributes
    ----------
    name : str
    what : {"kept", "computed", "failed"}
        Known from an earlier run; computed now; failed now.
    done, count : int
        Pieces that are done, and all.
    left : float or None
        Estimated time left, s; None while nothing is known.
    message : str
        Why it failed.
    """

    name: str
    what: str
    done: int
    count: int
    left: float | None = None
    message: str = ""


def run_jobs(
    jobs: Sequence[Job],
    function: Callable[..., Any],
    keep: Callable[[Job, Any], None],
    pools: Pools,
    workers: int,
    threads: int | None = None,
    progress: Callable[[Progress], None] | None = None,
) -> dict[str, str]:
    """Compute every job and hand each result to `keep` as soon as it is there.

    Parameters
    ----------
    jobs : sequence of Job
    function : callable
        Importable by the workers.
    keep : callable
        Called here, one result at a time. What it raises ends the run.
    pools : callable
    workers : int
        Jobs that are handed out at once.
    threads : int, optional
        Threads that one job may use; by default what its worker's process is set to.
    progress : callable, optional

    Returns
    -------
    dict
        Name of every job that failed, and why.

    Raises
    ------
    InputError
        A disk is full, here or where a job ran.
    """
    run = _Run(function, keep, threads, len(jobs), progress or (lambda step: None))
    waiting = deque(jobs)
    suspects: list[Job] = []
    while waiting:
        with pools(min(workers, len(waiting))) as executor:
            suspects += run.round(executor, waiting, workers)
    # A process died under them, or its memory did not suffice. Each alone, so that the one that does it is known.
    for job in suspects:
        with pools(1) as executor:
            if run.round(executor, deque([job]), 1):
                run.failed(job, _DEATH_TEXT)
    return run.failures


class _Run:
    """One run.

    Holds state because what is done, what failed, and how long it took change with every job that ends.
    """

    def __init__(
        self,
        function: Callable[..., Any],
        keep: Callable[[Job, Any], None],
        threads: int | None,
        count: int,
        progress: Callable[[Progress], None],
    ) -> None:
        self.function, self.keep, self.threads, self.count, self.progress = function, keep, threads, count, progress
        self.failures: dict[str, str] = {}
        self.done = 0
        self.started = time.monotonic()
        self.at_once = 1
        self.began: dict[str, float] = {}
        self.lasted: list[float] = []

    def round(self, executor: Executor, waiting: deque[Job], at_once: int) -> list[Job]:
        """Compute the waiting jobs; after a process died, return those that were being computed."""
        running: dict[Future[Any], Job] = {}
        self.at_once = at_once
        while waiting or running:
            try:
                while waiting and len(running) < at_once:
                    job = waiting.popleft()
                    arguments = self.loaded(job)
                    if arguments is not None:
                        running[self.submit(executor, job, arguments)] = job
            except (BrokenExecutor, CancelledError):
                return [job, *running.values()]
            suspects = []
            for future in wait(running, return_when=FIRST_COMPLETED).done:
                job = running.pop(future)
                if _is_lost(future):
                    suspects.append(job)
                else:
                    self.finish(job, future)
            if suspects:
                return suspects + list(running.values())
        return []

    def submit(self, executor: Executor, job: Job, arguments: tuple[Any, ...]) -> Future[Any]:
        self.began[job.name] = time.monotonic()
        return executor.submit(perform, self.function, arguments, self.threads, source_digest())

    def loaded(self, job: Job) -> tuple[Any, ...] | None:
        try:
            return job.load()
        except Exception as error:
            self.failed(job, _reason(error))
            return None

    def finish(self, job: Job, future: Future[Any]) -> None:
        error = future.exception()
        if error is None:
            try:
                performed = future.result()
                self.began[job.name] = time.monotonic() - performed.seconds
                self.keep(job, performed.piece)
            except VasowaveError:
                raise
            except Exception as unforeseen:
                self.failed(job, _reason(unforeseen))
            else:
                self.advance(job, "computed")
        elif is_full(error):
            raise InputError(f"{job.name}: no space left where it was computed; make room and run again") from error
        else:
            self.failed(job, _reason(error))

    def failed(self, job: Job, reason: str) -> None:
        self.failures[job.name] = reason
        self.advance(job, "failed", reason)

    def advance(self, job: Job, state: str, message: str = "") -> None:
        self.done += 1
        began = self.began.pop(job.name, None)
        if began is not None:
            self.lasted.append(time.monotonic() - began)
        self.progress(Progress(job.name, state, self.done, self.count, self.remaining(), message))

    def remaining(self) -> float | None:
        """Return the time left, s, if the animals that are not done take as long as those that are, on average."""
        if not self.lasted:
            return None
        now, mean_duration, remaining = time.monotonic(), sum(self.lasted) / len(self.lasted), self.count - self.done
        if self.at_once > cores():  # a cluster: how many it computes at once shows only in what it has done
            return (now - self.started) / self.done * remaining
        running = sum(max(mean_duration - (now - began), 0.0) for began in self.began.values())
        return (running + mean_duration * (remaining - len(self.began))) / min(self.at_once, max(remaining, 1))


def _is_lost(future: Future[Any]) -> bool:
    """Whether what computed a piece is gone: its process, its memory, or the scheduler of a cluster, with its work."""
    if future.cancelled():
        return True
    error = future.exception()
    return isinstance(error, (BrokenExecutor, CancelledError)) or is_starved(error)


class Performed(NamedTuple):
    """The answer of a worker: the piece, and how long it took, s, without what happens once: starting and compiling."""

    piece: Any
    seconds: float


def perform(function: Callable[..., Any], arguments: tuple[Any, ...], threads: int | None, source: str) -> Performed:
    """Compute one piece; runs in a worker, possibly on another machine."""
    if source_digest() != source:
        raise InputError("the worker has another version of vasowave than the program that sent it work; update it")
    if threads is not None:
        os.environ[VARIABLE] = str(threads)
    began, before = time.monotonic(), seconds_compiling()
    piece = function(*arguments)
    return Performed(piece, time.monotonic() - began - (seconds_compiling() - before))


def _reason(error: BaseException) -> str:
    """Return why a piece failed, in words; for a failure that nobody foresaw, also where."""
    if isinstance(error, VasowaveError):
        return str(error)
    if is_starved(error):
        return "out of memory; give this program more of it, or close others, and run again"
    remote = str(error.__cause__ or "").strip().splitlines()
    lines = [line.strip() for line in remote if line.strip().startswith("File ")]
    return unforeseen(error, lines[-1] if lines else "")
