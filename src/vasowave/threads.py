"""How many threads one process may use, so that several processes on one machine do not get in each other's way."""

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
    """Let this process use `count` threads; numerical libraries obey if they are loaded later."""
    for variable in (VARIABLE, *_LIBRARIES):
        os.environ[variable] = str(count)
