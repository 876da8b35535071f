"""Jobs on a study in which the n-th call to the system fails.

    python tests/failing_calls.py JOB FOLDER STEP [all]

Everything is loaded and computed once; then one n after another, in steps of STEP, is tried in a fork of this program
on a fresh copy of the study FOLDER/before, and the job is repeated in another fork: with a kill and one of the other
kinds of failing, or with all kinds. Counted are calls about what lies inside the study: opening, writing, waiting for
the disk, renaming, linking, removing, making folders, locking. Each try prints a line of JSON: how it ended, and all
that was not as it must be.
"""

import asyncio
import builtins
import errno
import fcntl
import io
import json
import os
import re
import shutil
import signal
import sys
import time
import traceback
from collections.abc import Callable, Iterator
from contextlib import contextmanager, redirect_stderr, redirect_stdout
from datetime import datetime
from functools import partial
from pathlib import Path
from typing import Any

KINDS = {"no space": errno.ENOSPC, "I/O": errno.EIO, "read-only": errno.EROFS, "no access": errno.EACCES, "kill": 0}
CALLS = {
    os: ("open", "write", "fsync", "replace", "rename", "link", "unlink", "mkdir", "ftruncate"),
    fcntl: ("flock",),
    io: ("open",),
    builtins: ("open",),
}
NEVER = 1 << 30
_PART = ".vasowave-part-"
_OF_THE_MOMENT = (".lock", ".status", ".jsonl")
"""Ends of the files that say how a job goes on."""

_FOREIGN = re.compile(r"Traceback|please report|unexpected \w+Error|the workbench failed")
_LONGEST = 300  # s of a job
_open, _read = os.open, os.read  # those that never fail


class Failing:
    """Counts the calls inside a folder, and lets one of them fail."""

    def __init__(self, folder: Path, at: int = NEVER, code: int = 0) -> None:
        self.folder, self.at, self.code = os.fsencode(folder.resolve()), at, code
        self.count, self.what = 0, ""

    def counted(self, call: Callable[..., Any], name: str) -> Callable[..., Any]:
        """Return a call that is counted."""

        def one(*arguments: Any, **named: Any) -> Any:
            if arguments and self._is_inside(arguments[0]):
                self.count += 1
                if self.count == self.at:
                    self.what = f"{name} {arguments[0]}"
                    if self.code == 0:
                        os.kill(os.getpid(), signal.SIGKILL)
                    raise OSError(self.code, os.strerror(self.code), str(arguments[0]))
            return call(*arguments, **named)

        return one

    def _is_inside(self, what: Any) -> bool:
        if isinstance(what, int):
            try:
                what = os.readlink(f"/proc/self/fd/{what}")
            except OSError:
                return False
        return os.path.abspath(os.fsencode(os.fspath(what))).startswith(self.folder)


@contextmanager
def failing(folder: Path, at: int = NEVER, code: int = 0) -> Iterator[Failing]:
    """Let the n-th call inside a folder fail, with the number of an error, or 0 to be killed there."""
    from vasowave.base.io import reserved

    here, file = Failing(folder, at, code), reserved.FileIO
    waiting = here.counted(lambda handle: None, "FileIO.write")

    class File(io.FileIO):
        def write(self, content: Any) -> int:
            waiting(self.fileno())
            return super().write(content)

    before = [(module, name, getattr(module, name)) for module, names in CALLS.items() for name in names]
    try:
        reserved.FileIO = File  # type: ignore[attr-defined]
        for module, name, call in before:
            setattr(module, name, here.counted(call, f"{module.__name__}.{name}"))
        yield here
    finally:
        reserved.FileIO = file  # type: ignore[attr-defined]
        for module, name, call in before:
            setattr(module, name, call)


def of_command(*arguments: str) -> Callable[[Path], int]:
    """Return what gives a command to a study and returns its exit status."""

    def do(study: Path) -> int:
        import vasowave.cli

        sys.argv = ["vasowave", *(one.replace("STUDY", str(study)) for one in arguments)]
        try:
            vasowave.cli.run()
        except SystemExit as leaving:
            return leaving.code if isinstance(leaving.code, int) else int(leaving.code is not None)
        return 0

    return do


def of_workbench(study: Path) -> int:
    """Change table and settings by the workbench and drop a file into it; what is confirmed is there."""
    from vasowave.workbench import Workbench

    cells = {"do": "set-cells", "animal": "mouse 0", "cells": {"image pressure [mmHg]": "4.5"}}
    starts = {"do": "set-setting", "key": "calibration.starts", "value": "3"}
    asked = [
        ("POST", "/act", "", json.dumps(cells).encode(), "animals.csv", b",4.5"),
        ("POST", "/act", "", json.dumps(starts).encode(), "study.yaml", b"starts: 3"),
        ("PUT", "/upload", "name=more.csv", b"time,pressure\n0,1\n", "recordings/more.csv", b"time,pressure\n0,1\n"),
    ]
    app, worst = Workbench(study).app(), 0
    for *request, file, content in asked:
        status, answer = asyncio.run(_asked(app, *request))
        if status != 200:
            print(f"Error: {json.loads(answer)['error']}")
        if status == 200 and content not in _content(study / file):
            print(f"Traceback: {file} was confirmed and is not there")
        worst = max(worst, 0 if status == 200 else 3 if status == 500 else 1)
    return worst


async def _asked(app: Any, method: str, path: str, query: str, body: bytes) -> tuple[int, bytes]:
    scope = {"type": "http", "method": method, "path": path, "query_string": query.encode(), "headers": []}
    came, sent = [{"type": "http.request", "body": body, "more_body": False}], list[Any]()

    async def receive() -> Any:
        return came.pop(0) if came else await asyncio.Event().wait()

    async def send(message: Any) -> None:
        sent.append(message)

    await app(scope, receive, send)
    return sent[0]["status"], b"".join(one.get("body", b"") for one in sent[1:])


JOBS: dict[str, Callable[[Path], int]] = {
    "run": of_command("run", "STUDY", "--workers", "1", "--no-report"),
    "report": of_command("report", "STUDY"),
    "add": of_command("add", "STUDY", "STUDY/../new"),
    "open": of_workbench,
    "extract": of_command("extract", "STUDY/image.nrrd", "-o", "STUDY/out", "--root", "0,0,-0.2"),
}


def contents(folder: Path) -> dict[str, bytes]:
    """Return what the files of a study hold, but for what is of the moment."""
    return {file.relative_to(folder).as_posix(): file.read_bytes() for file in sorted(folder.rglob("*"))
            if file.is_file() and not file.name.endswith(_OF_THE_MOMENT)}  # fmt: skip


def _content(file: Path) -> bytes:
    return _read(_open(file, os.O_RDONLY), 1 << 20) if file.exists() else b""


def wrong(status: int, said: str, now: dict[str, bytes], before: dict[str, bytes], sound: dict[str, bytes]
          ) -> list[str]:  # fmt: skip
    """Return what is not as it must be after a job in which a call failed, or that was killed."""
    killed = status == -signal.SIGKILL
    found = [f"status {status}"] * (status not in (0, 1, 3) and not killed)
    found += [said] * bool(_FOREIGN.search(said))
    if status > 0 and not re.search(r"^(Error|failed|error): |\d errors? to mend", said, re.MULTILINE):
        found.append(f"no sentence: {said}")
    for name, content in now.items():
        if _PART in name:
            found += [f"left behind: {name}"] * (not killed)
        elif content not in (before.get(name), sound.get(name)):
            found.append(f"neither as before nor as after: {name}")
    return found + [f"lost: {name}" for name in before if name not in now and name in sound]


def main() -> None:
    """Try one n after another."""
    job, place, step, every = sys.argv[1], Path(sys.argv[2]).resolve(), int(sys.argv[3]), sys.argv[4:] == ["all"]
    _ready(job, place)
    before, study, repeated = contents(place / "before"), place / "study", set[Any]()
    tried = partial(_forked, study, job, place / "said")

    def fresh() -> None:
        shutil.rmtree(study, ignore_errors=True)
        shutil.copytree(place / "before", study)

    fresh()
    status, count, said, _ = tried(NEVER, 0)
    assert status == 0, said
    sound, (*errors, kill) = contents(study), KINDS
    for number, at in enumerate(range(1, count + 1, step)):
        for kind in KINDS if every else (errors[number % len(errors)], kill):
            fresh()
            status, _, said, what = tried(at, KINDS[kind])
            now = contents(study)
            found = wrong(status, said, now, before, sound)
            if "unlink" in what:  # what cannot be removed stays for a while
                now = {name: content for name, content in now.items() if _PART not in name}
                found = [one for one in found if not one.startswith("left behind")]
            if status == 0 and now != sound:
                found.append("said nothing, and is not as it must be")
            for rest in study.rglob(f"{_PART}*"):
                os.utime(rest, (time.time() - 10, time.time() - 10))  # repeated a while later
            if (state := tuple(sorted(_whole(study).items()))) not in repeated:
                ended, _, later, _ = tried(NEVER, 0)
                after = contents(study)
                other = [name for name in {**after, **sound} if after.get(name) != sound.get(name)]
                if ended or other:
                    found.append(f"repeated: status {ended}, others: {other}, {later}")
                repeated.add(state)
            lines = [line for line in said.splitlines() if line.startswith(("Error", "failed", "error"))]
            told = {"call": at, "of": count, "what": what, "kind": kind, "status": status, "said": lines}
            print(json.dumps(told | {"wrong": found}), flush=True)


def _whole(study: Path) -> dict[str, bytes]:
    return {str(file): file.read_bytes() for file in study.rglob("*")
            if file.is_file() and not file.name.endswith((".lock", ".status"))}  # fmt: skip


def _forked(study: Path, job: str, told: Path, at: int, code: int) -> tuple[int, int, str, str]:
    """Do a job in a fork; return its status (negative: a signal), how many calls it made, what it said, what failed."""
    with told.open("wb") as file:
        if (child := os.fork()) == 0:
            signal.alarm(_LONGEST)
            os.dup2(file.fileno(), 1)
            os.dup2(file.fileno(), 2)
            status = 70
            with failing(study, at, code) as here:
                try:
                    status = JOBS[job](study)
                except BaseException:
                    traceback.print_exc()
            sys.stdout.flush()
            sys.stderr.flush()
            os.write(2, f"\ncalls {here.count} {here.what}".encode())
            os._exit(status)
        status = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
    said, _, last = told.read_text(encoding="utf-8", errors="replace").rpartition("\ncalls ")
    count, _, what = last.partition(" ")
    return (status, int(count), said, what) if said or count.isdigit() else (status, 0, last, "")


def _ready(job: str, place: Path) -> None:
    """Do a job once in this program, which then has loaded what it needs, and knows what was computed and drawn."""
    from concurrent.futures import ThreadPoolExecutor

    import vasowave.base.software as software
    import vasowave.lung.kept.stages as stages
    import vasowave.study.report.blocks as blocks
    import vasowave.study.report.extraction as extraction
    import vasowave.study.report.write as write
    import vasowave.study.running.plan as plan
    import vasowave.study.running.runs as running
    from vasowave.study.results import Journal, read_journal

    known: dict[Any, Any] = {}

    def once(key: Any, make: Callable[[], Any]) -> Any:
        if key not in known:
            known[key] = make()
        return known[key]

    def analyzed(*given: Any) -> bytes:
        journal = Path(given[3])
        content, ends = once(given[4], lambda: (compute(*given), read_journal(journal)))
        own = Journal(journal)
        for end in ends:
            if (end.wall, end.stage, end.start) not in own.known:
                own.write(end)
        return bytes(content)

    @contextmanager
    def here(*_: Any) -> Iterator[Any]:
        with ThreadPoolExecutor(1) as pool:
            yield pool

    def kept(self: Any, name: str, key: str, make: Callable[[], Any]) -> Any:
        return keep(self, name, key, lambda: once((name, key), make))

    class Then(datetime):
        @classmethod
        def now(cls, tz: Any = None) -> "Then":
            return cls(2026, 1, 1, tzinfo=tz)

    compute, running.analyzed_bytes, running.process_pool = running.analyzed_bytes, analyzed, here
    keep, stages.Stages.kept = stages.Stages.kept, kept  # type: ignore[method-assign]
    software.datetime = plan.datetime = Then  # type: ignore[attr-defined]
    for module, name in ((write, "report_of"), (write, "supplement_of"), (extraction, "extraction_figures")):
        make = getattr(module, name)
        setattr(module, name, lambda *given, name=name, make=make: once(name, lambda: make(*given)))
    blocks.svg = lambda figure: '<svg width="9pt" height="9pt" viewBox="0 0 9 9"></svg>'
    extraction._picture = lambda *given: b"<svg/>"
    shutil.rmtree(place / "primed", ignore_errors=True)
    shutil.copytree(place / "before", place / "primed")
    told = io.StringIO()
    with redirect_stdout(told), redirect_stderr(told):
        status = JOBS[job](place / "primed")
    assert status == 0, told.getvalue()


if __name__ == "__main__":
    main()
