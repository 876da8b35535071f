"""Strike a program at a random moment: a disk fills, a folder turns read-only, a kill of add, report or workbench.

    python benchmarks/moments.py full 20            runs whose disk fills to its last byte; needs the right to mount
    python benchmarks/moments.py read-only 20       runs whose folders turn read-only
    python benchmarks/moments.py add 25             kills of `vasowave add`
    python benchmarks/moments.py report 25          kills of `vasowave report`
    python benchmarks/moments.py workbench 25       kills of `vasowave open` while a page changes cells

Afterwards the obstacle goes, `vasowave status` is read, and the same is asked for again. A line for each try; exit code
1: something was lost, changed by half, ended in a foreign error, or a number is another than without any strike. Kills
of `run` and `extract` are in kills.py.
"""

import argparse
import contextlib
import json
import os
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from urllib.error import URLError
from urllib.parse import urlsplit
from urllib.request import Request, urlopen

import numpy as np

from faults import PROGRAM, run, same, write_study
from vasowave.study.entering import read_rows

COMMAND = PROGRAM[:-1]
ALL = [*PROGRAM, "STUDY", "--workers", "1", "--no-report"]
LONGEST = 300  # s
FOREIGN = ("Traceback", "please report")


def started(command: list[str], study: Path, **options: object) -> "subprocess.Popen[str]":
    """Start a command on a study, in a group of processes of its own, its words to be read."""
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.STDOUT, "text": True, "start_new_session": True}
    return subprocess.Popen([str(study) if part == "STUDY" else part for part in command], **pipes, **options)


def status(study: Path) -> str:
    """Return what `vasowave status` says of a study's last run: its first lines."""
    done = subprocess.run([*COMMAND, "status", str(study)], check=False, capture_output=True, text=True)
    return " | ".join((done.stdout + done.stderr).split("\n")[:3])


def words_of(process: "subprocess.Popen[str]") -> str:
    """Return what a process says until it ends."""
    try:
        return process.communicate(timeout=LONGEST)[0]
    except subprocess.TimeoutExpired:
        os.killpg(process.pid, signal.SIGKILL)
        return f"Traceback: did not end in {LONGEST} s"


@contextlib.contextmanager
def small_disk(place: Path) -> Iterator[Path]:
    """Mount a disk of 16 MB."""
    place.mkdir()
    subprocess.run(["mount", "-t", "tmpfs", "-o", "size=16m", "tmpfs", str(place)], check=True)
    try:
        yield place
    finally:
        subprocess.run(["umount", "-l", str(place)], check=True)


def fill(file: Path) -> None:
    """Write until not one byte more has room."""
    with file.open("wb", buffering=0) as filler:
        size = 1 << 20
        while size:
            try:
                filler.write(b"0" * size)
            except OSError:
                size //= 2


def full(place: Path, sound: Path, moment: float) -> str:
    """Fill the disk of a run; return what went wrong."""
    with small_disk(place) as disk:
        study = write_study(disk / "study")
        process = started(ALL, study)
        with contextlib.suppress(subprocess.TimeoutExpired):
            process.wait(moment)
        fill(disk / "filler")
        return went_on(study, sound, words_of(process), (disk / "filler").unlink)


def read_only(place: Path, sound: Path, moment: float) -> str:
    """Take the right to write from a run; return what went wrong."""
    study = write_study(place)
    mortal = ["setpriv", "--inh-caps=-all", "--bounding-set=-all"] if os.geteuid() == 0 else []
    process = started([*mortal, *ALL], study)
    with contextlib.suppress(subprocess.TimeoutExpired):
        process.wait(moment)
    change_modes(study, 0o555)
    return went_on(study, sound, words_of(process), lambda: change_modes(study, 0o755))


def change_modes(study: Path, mode: int) -> None:
    """Let folders of a study be written to, or not."""
    for folder in [study, *(one for one in study.rglob("*") if one.is_dir())]:
        with contextlib.suppress(FileNotFoundError):
            folder.chmod(mode)


def went_on(study: Path, sound: Path, words: str, free: object) -> str:
    """Return what is wrong with the words of a run, its status, or with what it finds once it can go on."""
    said = status(study)
    free()
    print(f"  {words.strip().splitlines()[-1][:110] if words.strip() else '(no words)'} | {said[:200]}")
    after = run(study)
    if after.status:
        return f"did not go on: {after.words[-300:]}"
    wrong = [] if same(study, sound) else ["other numbers"]
    return "; ".join(wrong + [f"foreign: {words[-300:]}" for one in FOREIGN if one in words + said])


def add(place: Path, sound: Path, moment: float) -> str:
    """Kill `vasowave add` of a recording; return what went wrong."""
    study = write_study(place)
    before = (study / "animals.csv").read_bytes()
    head, file = (study / "0.csv").open().readline(), study / "mouse 9.csv"
    signals = np.loadtxt(study / "0.csv", delimiter=",", skiprows=1) * (1.0, 1.2, 1.0)
    np.savetxt(file, signals, "%.9f", ",", header=head.strip(), comments="")
    command = [*COMMAND, "add", "STUDY", str(file), "--group", "CTL", "--network", str(study / "n.csv")]
    kill(started(command, study), moment)
    names = [row["animal"] for row in read_rows(study / "animals.csv").rows]
    if (study / "animals.csv").read_bytes() != before and names != [*(f"mouse {i}" for i in range(3)), "mouse 9"]:
        return f"half a table: {names}"
    again = words_of(started(command, study))
    names = [row["animal"] for row in read_rows(study / "animals.csv").rows]
    wrong = [] if names.count("mouse 9") == 1 and len(names) == 4 else [f"rows {names}; {again[-200:]}"]
    return "; ".join(wrong + [again[-300:] for one in FOREIGN if one in again] + left_behind(study))


def report(place: Path, sound: Path, moment: float) -> str:
    """Kill `vasowave report`; return what went wrong."""
    shutil.copytree(sound, place)
    command = [*COMMAND, "report", "STUDY"]
    kill(started(command, place), moment)
    again = words_of(process := started(command, place))
    page = place / "report" / "report.html"
    wrong = [] if process.returncode == 0 and page.is_file() else [f"no page: {again[-300:]}"]
    return "; ".join(wrong + ([] if same(place, sound) else ["other numbers"]) + left_behind(place))


def workbench(place: Path, sound: Path, moment: float) -> str:
    """Kill a workbench while a page changes a cell; return what went wrong."""
    shutil.copytree(sound, place)
    process = started([*COMMAND, "open", "STUDY", "--no-browser"], place)
    address = next(found[0] for line in process.stdout if (found := re.findall(r"http://\S+", line)))
    door = address.partition("#")[0]
    ends, confirmed = time.monotonic() + moment, ""
    post(door, {"do": "add-column", "title": "note"})
    with contextlib.suppress(URLError, ConnectionError):
        for number in range(100_000):
            if time.monotonic() > ends:
                os.killpg(process.pid, signal.SIGKILL)
            text = f"note {number}"
            if post(door, {"do": "set-cells", "animal": "mouse 1", "cells": {"note": text}}):
                confirmed = text
    process.communicate()
    now = next(row["note"] for row in read_rows(place / "animals.csv").rows if row["animal"] == "mouse 1")
    later = f"note {int((confirmed or 'note -1').split()[1]) + 1}"  # written, and killed before it was confirmed
    wrong = [] if now in (confirmed, later) else [f"{confirmed} was confirmed, there is {now}"]
    print(f"  {confirmed or 'nothing'} confirmed, {now} there")
    again = started([*COMMAND, "open", "STUDY", "--no-browser"], place)
    opened = any("http://" in line for line in again.stdout)
    os.killpg(again.pid, signal.SIGKILL)
    again.communicate()
    return "; ".join(wrong + ([] if opened else ["did not open again"]))


def post(door: str, what: dict[str, object]) -> bool:
    """Ask a workbench for a change; return whether it was confirmed."""
    headers = {"Content-Type": "application/json", "Origin": "{0.scheme}://{0.netloc}".format(urlsplit(door))}
    with urlopen(Request(f"{door}act", json.dumps(what).encode(), headers), timeout=LONGEST) as answer:
        return answer.status == 200


def kill(process: "subprocess.Popen[str]", moment: float) -> None:
    """Kill a process and all that it started after `moment` s."""
    with contextlib.suppress(subprocess.TimeoutExpired):
        process.wait(moment)
    with contextlib.suppress(ProcessLookupError):
        os.killpg(process.pid, signal.SIGKILL)
    process.communicate()


def left_behind(study: Path) -> list[str]:
    """Return the parts of files that a killed program left, and the next one did not remove."""
    parts = [str(one.relative_to(study)) for one in study.rglob(".*") if one.is_file() and "part" in one.name]
    return [f"left behind {parts}"] if parts else []


STRIKES = {"full": full, "read-only": read_only, "add": add, "report": report, "workbench": workbench}


def main() -> int:
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("strike", choices=STRIKES)
    parser.add_argument("count", type=int)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--longest", type=float, help="latest moment, s; else what an undisturbed one takes")
    asked = parser.parse_args()
    rng, bad = np.random.default_rng(asked.seed), 0
    with tempfile.TemporaryDirectory() as place:
        sound = write_study(Path(place) / "sound")
        assert run(sound).status == 0
        longest = asked.longest or undisturbed(asked.strike, Path(place), sound)
        for number in range(asked.count):
            folder, moment = Path(place) / f"try {number}", rng.uniform(0.0, longest)
            wrong = STRIKES[asked.strike](folder, sound, moment)
            bad += bool(wrong)
            print(f"{number + 1}: after {moment:.2f} of {longest:.1f} s: {wrong or 'good'}", flush=True)
            shutil.rmtree(folder, ignore_errors=True)
    print(f"{asked.strike}: {asked.count - bad} of {asked.count} good")
    return int(bad > 0)


def undisturbed(strike: str, place: Path, sound: Path) -> float:
    """Return how long what is struck takes, s."""
    begun = time.monotonic()
    folder = write_study(place / "timed") if strike != "report" else Path(shutil.copytree(sound, place / "timed"))
    command = {"add": [*COMMAND, "add", "STUDY", str(folder / "0.csv")], "report": [*COMMAND, "report", "STUDY"]}
    words_of(started(command.get(strike, ALL), folder))
    return 6.0 if strike == "workbench" else time.monotonic() - begun


if __name__ == "__main__":
    sys.exit(main())
