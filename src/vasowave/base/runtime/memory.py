"""Signs of a lack of memory, and the time that goes to finding what is no longer used."""

import errno
import gc
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

_SIGNS = (
    "failed to map segment",  # a library that could not be loaded
    "cannot allocate memory",
    "unable to allocate",
    "can't start new thread",
    "can't allocate lock",
    "without setting an exception",  # compiled code that met it
)


_SELDOM = 70  # times as many new objects as usual


@contextmanager
def seldom_collected() -> Iterator[None]:
    """Look for garbage seldom within the block, where nearly all of many objects stay in use: results, figures."""
    first, *thresholds = gc.get_threshold()
    gc.set_threshold(_SELDOM * first, *thresholds)
    try:
        yield
    finally:
        gc.set_threshold(first, *thresholds)


def is_starved(error: BaseException | None) -> bool:
    """Whether an error says, in one of its many ways, that there was no memory left."""
    if error is None:
        return False
    if isinstance(error, MemoryError) or (isinstance(error, OSError) and error.errno == errno.ENOMEM):
        return True
    words = str(error).lower()
    return any(sign in words for sign in _SIGNS) or is_starved(error.__cause__ or error.__context__)


def kills_for_memory() -> int:
    """Return how many programs the system has killed for lack of memory since it began; 0 where it does not say."""
    try:
        counted = Path("/proc/vmstat").read_text(encoding="ascii")
    except OSError:
        return 0
    return next((int(line.split()[1]) for line in counted.splitlines() if line.startswith("oom_kill ")), 0)
