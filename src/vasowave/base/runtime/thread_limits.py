"""The threads that one process may use, so that several processes on one machine do not get in each other's way."""

import os

VARIABLE = "VASOWAVE_THREADS"
"""Environment variable that limits the threads of a process."""

_LIBRARIES = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")


def cores() -> int:
    """Return the cores that this process may run on."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def threads() -> int:
    """Return how many threads this process may use: the limit, if one is set, else all cores."""
    limit = os.environ.get(VARIABLE, "")
    return int(limit) if limit.isdecimal() and int(limit) > 0 else cores()


def limit_threads(count: int) -> None:
    """Let this process use `count` threads, and numerical libraries that are loaded later one each."""
    os.environ[VARIABLE] = str(count)
    for variable in _LIBRARIES:
        os.environ[variable] = "1"


def spare_threads() -> None:
    """Let numerical libraries that are loaded later use one thread each, where their user has not said how many.

    Our matrices are small: with more, their threads spin while they wait for each other.
    """
    for variable in _LIBRARIES:
        os.environ.setdefault(variable, "1")
