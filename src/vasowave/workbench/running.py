"""A run of the study as a program of its own: it outlives the workbench, and is the same as `vasowave run`."""

import os
import platform
import subprocess
import sys
from pathlib import Path
from typing import Any

from vasowave.base.errors import InputError
from vasowave.base.io.files import made_inside
from vasowave.study.folder.places import RESULTS
from vasowave.study.folder.problems import refuse
from vasowave.study.folder.study import Study
from vasowave.study.results.store import LOCK, holder, locked
from vasowave.study.running.plan import inspect_study
from vasowave.study.running.run_state import ask_to_stop, record_end, reserved, run_status
from vasowave.study.running.status import study_status
from vasowave.workbench.desk import Desk


class Runs:
    """The run that was begun here, if there is one.

    Holds state because it is a program that goes on beside this one and may be stopped.
    """

    def __init__(self) -> None:
        self.program: subprocess.Popen[bytes] | None = None
        self.results: Path = Path()
        self.stops_with_us = False

    def start(self, desk: Desk) -> None:
        """Begin a run; `InputError` if one is going on, the study is wrong, or nothing can be written."""
        if (runner := self.runner(desk)) is not None:
            raise InputError(f"the study is being run by {runner} already; wait for it, or stop it first")
        refuse([problem for problem in inspect_study(desk.folder)[1] if problem.error])
        self.results = made_inside(desk.folder, RESULTS)
        with locked(self.results / LOCK), reserved(self.results):
            pass
        command = [sys.executable, "-m", "vasowave", "run", str(desk.folder.absolute())]
        nothing = subprocess.DEVNULL
        self.program = subprocess.Popen(command, stdin=nothing, stdout=nothing, stderr=nothing, start_new_session=True,
                                        cwd=desk.folder)  # fmt: skip

    def runner(self, desk: Desk) -> str | None:
        """Return who runs the study now, here or elsewhere."""
        if self.program is not None and self.program.poll() is None:
            return f"process {self.program.pid} on {platform.node()}"
        return holder(desk.results / LOCK)

    def stop(self, desk: Desk) -> str:
        """Ask the run to stop, as Ctrl-C does, and return what happens; what had finished is kept."""
        if self._is_starting():
            assert self.program is not None
            self.program.terminate()
        return ask_to_stop(desk.results, f"the workbench (process {os.getpid()} on {platform.node()})")

    def close(self) -> bool:
        """Let a run that was begun here go on, or stop it, as the user chose; return whether one goes on."""
        if self.program is None or self.program.poll() is not None:
            return False
        if self.stops_with_us:
            self.stop(Desk(self.results.parent))
        return not self.stops_with_us

    def _is_starting(self) -> bool:
        """Whether a run was begun here that has not written anything yet."""
        now = run_status(self.results)
        return self.program is not None and self.program.poll() is None and (now is None or now.ended is not None)

    def progress(self, desk: Desk, study: Study | None) -> dict[str, Any]:
        """Return how far every animal is, the time left, and how the last run ended."""
        runner = self.runner(desk)
        begun = self.program
        if begun is not None and begun.poll() is not None:
            record_end(desk.results, begun.pid, begun.returncode)
        run = run_status(desk.results)
        ended = None if runner or run is None else run.ended
        if run is None and not runner and begun is not None and begun.poll():
            message = (f"The run ended before it read the study (exit status {begun.returncode}); "
                       "run it in a terminal to see why")  # fmt: skip
        else:
            message = "" if run is None else str(run)
        animals = study_status(study).animals if study is not None else ()
        return {
            "runner": runner,
            "left": run.left if run is not None and runner else None,
            "animals": {
                status.animal: {"state": status.state, "text": str(status), "searches": status.searches}
                for status in animals
            },
            "ended": ended,
            "said": message,
            "stops_with_us": self.stops_with_us,
        }
