"""Small real computations for workers in other processes; each leaves a line in a log that says it ran."""

import os
import signal
import time
from pathlib import Path

import numpy as np

from vasowave.base import InputError
from vasowave.base.runtime import threads


def decay_time(log: str, name: str, seconds: float = 0.0) -> float:
    """Return the time constant of a noisy exponential, by a log-linear fit."""
    with Path(log).open("a") as file:
        file.write(f"{name}\n")
    time.sleep(seconds)
    rng = np.random.default_rng(len(name))
    t = np.linspace(0, 1, 200)
    y = np.exp(-t / 0.3) * np.exp(0.01 * rng.standard_normal(200))
    return float(-1 / np.polyfit(t, np.log(y), 1)[0])


def sometimes_wrong(log: str, name: str) -> float:
    if name == "wrong":
        raise InputError("wrong.csv, line 3: a gap")
    if name == "unforeseen":
        return float(np.array([1.0])[7])
    return decay_time(log, name)


def kills_its_process(log: str, name: str) -> float:
    if name == "deadly":
        os.kill(os.getpid(), signal.SIGKILL)
    return decay_time(log, name, 0.3)


def allowed_threads(log: str, name: str) -> tuple[int, str]:
    return threads(), os.environ["OMP_NUM_THREADS"]


def no_space(log: str, name: str) -> float:
    raise OSError(28, "No space left on device")


def process_and_wait(log: str, name: str) -> None:
    Path(log).write_text(str(os.getpid()))
    time.sleep(60)


def starved_once(log, name):
    """Find no memory the first time, as beside others."""
    seen = Path(f"{log} {name}")
    if seen.exists():
        return name
    seen.touch()
    raise MemoryError("Unable to allocate 8.00 KiB")


def always_starved(log, name):
    raise MemoryError("Unable to allocate 8.00 KiB")
