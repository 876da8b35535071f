"""The places where animals are computed: a pool of processes on this machine, or a Dask cluster."""

import logging
import os
import signal
import threading
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Executor, Future, InvalidStateError, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager, suppress
from functools import partial
from importlib import import_module
from multiprocessing import active_children, get_context, parent_process, resource_tracker
from typing import TYPE_CHECKING, Any, TypeVar
from weakref import WeakSet

from vasowave.base.errors import InputError
from vasowave.base.runtime.memory import is_starved
from vasowave.base.runtime.thread_limits import cores, limit_threads
from vasowave.pulse.model.law_files import LawFile, files_of, learn

if TYPE_CHECKING:
    from vasowave.study.report.files import Each

_ANALYSIS_MODULES = (
    *("scipy.interpolate", "scipy.optimize", "scipy.signal", "scipy.stats", "dask.array"),
    *("vasowave.study.results.loading", "vasowave.pulse.solver.ready"),
)
"""What an analysis loads when it first needs it; xarray looks for Dask, which need not be there."""

_DRAWING_MODULES = ("vasowave.study.animal.files", "vasowave.study.figures.rendering", "matplotlib.figure")
_MIN_ANIMALS = 10
"""For fewer animals processes take longer to start than they save (12: 35 s in place of 42, on 2 cores)."""
_TASKS_PER_CALL = 4  # results or figures that a process gets at once

_END_PATIENCE_S = 5.0  # s, for a process that was told to end

_T = TypeVar("_T")


@contextmanager
def process_pool(
    workers: int, threads: int = 1, laws: Sequence[str] = (), loaded: Sequence[str] = _ANALYSIS_MODULES
) -> Iterator[Executor]:
    """Give a pool of fresh processes, each with `threads` threads; none of them outlives the block or this program.

    Each loads the modules `loaded` when it starts. The kernels of the wall laws and of the noise are compiled first,
    each by another process, where they are not there already.
    """
    before, safe = set(active_children()), os.environ.get("PYTHONSAFEPATH")
    os.environ["PYTHONSAFEPATH"] = "1"  # a process that starts looks for no module in the folder it starts in
    pool: _Pool | None = None
    try:
        pool = _shared_pool(workers, threads, loaded)
        with pool.watched():
            for law in laws:
                pool.submit(_compile_kernels, law, files_of(laws))
            if laws:
                pool.submit(_compile_noise)
            yield pool
        pool.shutdown()
    except BaseException:
        if pool is not None:
            pool.shutdown(wait=False, cancel_futures=True)
        raise
    finally:
        if safe is None:
            os.environ.pop("PYTHONSAFEPATH", None)
        # After an error nobody waits for the results any more, and a task may have minutes to go.
        for process in set(active_children()) - before:
            process.terminate()
            process.join(_END_PATIENCE_S)


def _shared_pool(workers: int, threads: int, loaded: Sequence[str]) -> "_Pool":
    """Return a pool; `InputError` where the system leaves no room for the locks that its processes share."""
    try:
        return _Pool(workers, get_context("spawn"), _start_worker, (threads, loaded))
    except OSError as error:
        reason = f" ({os.strerror(error.errno)})" if error.errno else ""
        raise InputError(
            f"processes cannot be started: the locks that they share have no space left, or need a file larger than "
            f"this system or its limits allow{reason}; look at /dev/shm and `ulimit -f`"
        ) from error


@contextmanager
def side_by_side(workers: int, animals: int) -> Iterator["Each"]:
    """Give a `map` for reading and drawing that works in processes, where there are enough animals to pay for them."""
    if workers == 1 or animals < _MIN_ANIMALS:
        yield map
        return
    with process_pool(workers, loaded=_DRAWING_MODULES) as pool:
        yield partial(pool.map, chunksize=_TASKS_PER_CALL)


class _Pool(ProcessPoolExecutor):
    """A pool that breaks when one of its own threads dies of a lack of memory; by itself it would wait for ever.

    Holds state because what was submitted must end when such a thread is lost.
    """

    def __init__(self, *arguments: Any) -> None:
        super().__init__(*arguments)
        self._given: WeakSet[Future[Any]] = WeakSet()
        self._lost = False

    def submit(self, function: Callable[..., _T], /, *arguments: Any, **options: Any) -> Future[_T]:
        with interrupts_held():
            future = super().submit(function, *arguments, **options)
        self._given.add(future)
        if self._lost:
            self._break()
        return future

    def _break(self) -> None:
        self._lost = True
        for future in list(self._given):
            with suppress(InvalidStateError):
                future.set_exception(BrokenProcessPool("no memory left for the pool itself"))

    @contextmanager
    def watched(self) -> Iterator[None]:
        """Break the pool if one of its threads dies of a lack of memory while the block runs."""
        before = threading.excepthook

        def hear(died: threading.ExceptHookArgs) -> None:
            if type(died.thread).__module__ == ProcessPoolExecutor.__module__ and is_starved(died.exc_value):
                self._break()
            else:
                before(died)

        threading.excepthook = hear
        try:
            yield
        finally:
            threading.excepthook = before


@contextmanager
def interrupts_held() -> Iterator[None]:
    """Hold Ctrl-C back while processes are started; it is heard at the end of the block.

    A process that gets half of what it is started with, or is interrupted while it imports, would print a traceback. It
    keeps the blocked signals of the thread that starts it until `_start_worker` ignores this one.
    """
    if not hasattr(signal, "pthread_sigmask"):  # Windows
        yield
        return
    resource_tracker.ensure_running()  # it unblocks the signal where it starts
    heard, before = list[int](), signal.getsignal(signal.SIGINT)
    in_main_thread = threading.current_thread() is threading.main_thread() and callable(before)
    if in_main_thread:  # other threads of this process take the signal too, and Python raises what they hear here
        signal.signal(signal.SIGINT, lambda number, frame: heard.append(number))
    blocked = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, blocked)
        if in_main_thread:
            signal.signal(signal.SIGINT, before)
    if heard:
        signal.raise_signal(signal.SIGINT)


@contextmanager
def dask_cluster(address: str, patience: float = 30.0) -> Iterator[Executor]:
    """Give the Dask cluster whose scheduler listens at `address`.

    Raises
    ------
    InputError
        Dask is not installed, or nothing answers there within `patience` seconds.
    """
    try:
        from distributed import Client
    except ImportError:
        raise InputError("a cluster needs Dask; install vasowave with the extra 'cluster'") from None
    try:
        client = Client(address, timeout=patience, set_as_default=False)
    except (OSError, TimeoutError, ValueError) as error:
        raise InputError(
            f"no Dask scheduler answers at '{address}' ({error}); start one with `dask scheduler` and give its "
            "address, for example tcp://host:8786. What has finished is kept"
        ) from None
    with _quiet("distributed"), client, client.get_executor(pure=False) as executor:
        try:
            yield executor
        except BaseException:
            executor.shutdown(wait=False)  # else it waits for all animals that were handed out
            raise


@contextmanager
def _quiet(library: str) -> Iterator[None]:
    """Keep a library from printing the errors that it also raises, with its tracebacks."""
    printers = {printer: printer.level for printer in logging.getLogger(library).handlers}
    for printer in printers:
        printer.setLevel(logging.CRITICAL + 1)
    try:
        yield
    finally:
        for printer, level in printers.items():
            printer.setLevel(level)


def _compile_kernels(law: str, files: Sequence[LawFile]) -> None:
    from vasowave.pulse.solver.ready import compile_kernels

    learn(files)
    compile_kernels(law)


def _compile_noise() -> None:
    from vasowave.pulse.noise.arma import compile_kernels

    compile_kernels()


def compile_beside(law: str) -> None:
    """Begin to compile the kernels of a wall law in another process, which ends with this one."""
    if cores() == 1:
        return
    with suppress(OSError), interrupts_held():  # no process to be had: they are compiled when they are needed
        get_context("spawn").Process(target=_compile_alone, args=(law,), daemon=True).start()


def _compile_alone(law: str) -> None:
    _start_worker(1, ())
    _compile_kernels(law, ())


def _start_worker(threads: int, loaded: Sequence[str]) -> None:
    """Prepare a process of the pool, before it imports anything numerical."""
    limit_threads(threads)
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for the program that waits for us
    threading.Thread(target=_end_with_parent, daemon=True).start()
    for name in loaded:  # now, so that the first piece tells how long the others will take
        try:
            import_module(name)
        except (ImportError, MemoryError) as error:
            if is_starved(error):
                os._exit(1)  # the program that waits for us says it in words


def _end_with_parent() -> None:
    """End this process when the one that started it is gone, also by kill -9; it would wait for work forever."""
    parent = parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)
