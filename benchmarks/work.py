"""Count the work that a task of the solver and its searches asks for; every machine repeats these numbers.

Functions are counted where they are entered, so nothing of the program is changed for it.
"""

import sys
import threading
from collections.abc import Callable
from types import FrameType
from typing import Any, NamedTuple


class Work(NamedTuple):
    """What a task asked for."""

    cycles: int  # cycles of the scheme
    linearized: int  # cycles of its linearization, all directions at once
    linear: int  # answers of the linear model of a straight tree


_COUNTED: dict[tuple[str, str], tuple[str, Callable[[dict[str, Any]], int]]] = {
    ("stepper.py", "Stepper.cycle"): ("cycles", lambda local: 1),
    ("varied_stepper.py", "VariedStepper._cycle"): ("linearized", lambda local: 1),
    ("straight_trees.py", "solve_members"): ("linear", lambda local: len(local["members"].end)),
}
"""By file and function: what a call is, and how many."""


def work_of(task: Callable[[], object]) -> Work:
    """Return what a task asked for, in this thread and in those that it starts."""
    counts, lock = dict.fromkeys(Work._fields, 0), threading.Lock()

    def look(frame: FrameType, event: str, argument: object) -> None:
        if event != "call":
            return
        code = frame.f_code
        if rule := _COUNTED.get((code.co_filename.rpartition("/")[2], code.co_qualname)):
            with lock:
                counts[rule[0]] += rule[1](frame.f_locals)

    before = sys.getprofile()
    threading.setprofile(look)
    sys.setprofile(look)
    try:
        task()
    finally:
        sys.setprofile(before)
        threading.setprofile(None)
    return Work(**counts)
