"""A run of the study as a program of its own: it outlives the workbench, and is the same as `vasowave run`."""

import json
import os
import platform
import re
import signal
import subprocess
import sys
from contextlib import suppress
from pathlib import Path
from typing import Any

from vasowave.errors import InputError
from vasowave.io.files import made_inside
from vasowave.study.plan import RESULTS, Study
from vasowave.study.status import study_status
from vasowave.study.store import LOCK, holder
from vasowave.workbench.desk import Desk

_LOG, _ERRORS = "run.jsonl", "run.txt"
"""What the run that began last told, in the folder of the results: steps, and what else it said."""

_LATEST = 1 << 16  # bytes of either that are looked at


class Runs:
    """The run that was begun here, if there is one."""

    def __init__(self) -> None:
        self.program: subprocess.Popen[bytes] | None = None
        self.stops_with_us = False

    def start(self, desk: Desk) -> None:
        """Begin a run; `InputError` if one is going on."""
        if runner := self.runner(desk):
            raise InputError(f"the study is being run by {runner} already")
        results = made_inside(desk.folder, RESULTS)
        command = [sys.executable, "-m", "vasowave", "run", str(desk.folder.absolute()), "--json"]
        with (results / _LOG).open("wb") as told, (results / _ERRORS).open("wb") as errors:
            self.program = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=told, stderr=errors,
                                            start_new_session=True, cwd=desk.folder)  # fmt: skip

    def runner(self, desk: Desk) -> str | None:
        """Return who runs the study now, here or elsewhere."""
        if self.program is not None and self.program.poll() is None:
            return f"process {self.program.pid} on {platform.node()}"
        return holder(desk.results / LOCK)

    def stop(self, desk: Desk) -> None:
        """Interrupt the run as Ctrl-C does; what had finished is kept. `InputError` if it runs on another machine."""
        runner = self.runner(desk)
        if runner is None:
            return
        found = re.match(r"process (\d+) on (.*?)(?: since .*)?$", runner)
        if not found or found[2] != platform.node():
            raise InputError(f"the study is being run by {runner}; stop it there")
        with suppress(ProcessLookupError):
            os.kill(int(found[1]), signal.SIGINT)

    def close(self) -> bool:
        """Let a run that was begun here go on, or stop it, as the user chose; return whether one goes on."""
        if self.program is None or self.program.poll() is not None:
            return False
        if self.stops_with_us:
            with suppress(ProcessLookupError):
                self.program.send_signal(signal.SIGINT)
        return not self.stops_with_us

    def progress(self, desk: Desk, study: Study | None) -> dict[str, Any]:
        """Return how far every animal is, the time left, and how the last run ended."""
        runner = self.runner(desk)
        events = _events(desk.results / _LOG)
        left = next((one.get("left_s") for one in reversed(events) if one["event"] == "animal"), None)
        animals = study_status(study).animals if study is not None else ()
        ended = next((one for one in reversed(events) if one["event"] == "done"), None)
        failed = "" if runner or ended else _tail(desk.results / _ERRORS)  # nothing where no run was ever begun here
        return {
            "runner": runner,
            "left": left if runner else None,
            "animals": {
                one.animal: {"state": one.state, "text": str(one), "searches": one.searches} for one in animals
            },
            "ended": ended is not None,
            "error": failed,
            "stops_with_us": self.stops_with_us,
        }


def _events(path: Path) -> list[dict[str, Any]]:
    events = []
    for line in _end_of(path).splitlines():
        with suppress(ValueError):  # a line that is being written, or was cut off
            one = json.loads(line)
            if isinstance(one, dict) and "event" in one:
                events.append(one)
    return events


def _tail(path: Path) -> str:
    lines = [line for line in _end_of(path).splitlines() if line.startswith(("Error", "failed", "What", "Interrupted"))]
    return "\n".join(lines[-8:])


def _end_of(path: Path) -> str:
    try:
        with path.open("rb") as file:
            size = file.seek(0, os.SEEK_END)
            file.seek(max(0, size - _LATEST))
            return file.read().decode(errors="replace")
    except OSError:
        return ""
