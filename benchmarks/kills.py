"""Kill a running study at random moments, run it again, and compare what it finds with an undisturbed run.

uv run python benchmarks/kills.py                       100 kills: half an hour
uv run python benchmarks/kills.py 6 --seed 2            six of them
uv run python benchmarks/kills.py 100 --posteriors      of a study with posteriors
uv run python benchmarks/kills.py 100 --posteriors --in-a-row    the same run again and again until it ends
uv run python benchmarks/kills.py 100 --extraction      of `vasowave extract`, beside what an earlier one had kept
uv run python benchmarks/kills.py --docs

Of ten kills, four fall at any moment of the run and six after its first finished animal. Every second one kills the
program alone, whose workers must notice, the others all its processes. A moment that comes too late, because the run
had ended, is drawn again. In a row, a run that went on is killed again, at first within a quarter of the time of a
whole one, until it reaches its end; what it then holds has been through all of these kills. Exit code 1: a run that
went on did not find the same values.
"""

import argparse
import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from itertools import count, islice
from pathlib import Path
from typing import NamedTuple

import numpy as np

import vasowave as vw
from faults import PROGRAM, run, same, write_study
from phantom import embed, render
from robustness_page import put
from vasowave.lung import written
from vasowave.lung.read import write_volume

EARLY = 4  # of ten kills
PARTS = 4  # of the time of a whole run, within one of which a kill in a row falls
FINISHED = "results/cache/*.nc"
STAMPED = 20  # bytes: four times of four, and a check sum


Write = Callable[[Path], Path]


class Kill(NamedTuple):
    """What one kill left behind, and what the run that went on made of it."""

    finished: int  # animals that were kept when it fell
    values: bool  # whether all are those of the undisturbed run
    equal: int  # files of animals that are so to the last bit, but for when they were made


def start(folder: Path) -> "subprocess.Popen[bytes]":
    """Start a study, in a group of processes of its own."""
    command = [*PROGRAM, str(folder), "--workers", "1", "--no-report"]
    return subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, start_new_session=True)


def with_posteriors(folder: Path) -> Path:
    """Write the study of `write_study` with posteriors."""
    study = write_study(folder) / "study.yaml"
    study.write_text(study.read_text() + "inference: posterior\n")
    return folder


def first_finished(process: "subprocess.Popen[bytes]", folder: Path) -> None:
    """Wait until an animal is kept, or the run has ended."""
    while process.poll() is None and not list(folder.glob(FINISHED)):
        time.sleep(0.02)


def killed(folder: Path, moment: float, late: bool, whole: bool) -> bool:
    """Kill a run, or the `whole` group of its processes, after `moment` s; False if it had ended before."""
    process = start(folder)
    if late:
        first_finished(process, folder)
    try:
        process.wait(moment)
    except subprocess.TimeoutExpired:
        (os.killpg if whole else os.kill)(process.pid, signal.SIGKILL)
        process.wait()
        return True
    return False


def durations(folder: Path) -> tuple[float, float]:
    """Return how long a run lasts, and how long it goes on after its first finished animal, s."""
    begun = time.monotonic()
    process = start(folder)
    first_finished(process, folder)
    first = time.monotonic()
    process.wait()
    return time.monotonic() - begun, time.monotonic() - first


def went_on(folder: Path, sound: Path) -> Kill:
    """Run a killed study to its end and compare it with the undisturbed one."""
    finished = len(list(folder.glob(FINISHED)))
    after = run(folder)
    if after.status != 0:
        print(after.words[-300:])
        return Kill(finished, False, 0)
    pieces = [{piece.name.partition("-")[0]: piece for piece in one.glob(FINISHED)} for one in (sound, folder)]
    equal = sum(key in pieces[1] and alike(piece, pieces[1][key]) for key, piece in pieces[0].items())
    return Kill(finished, same(sound, folder), equal)


def alike(one: Path, other: Path) -> bool:
    """Whether two files differ at most in the time that HDF5 writes into them, and in its check sum."""
    first, second = (np.frombuffer(path.read_bytes(), np.uint8) for path in (one, other))
    return len(first) == len(second) and int((first != second).sum()) <= STAMPED


def struck_once(
    place: Path, written_as: Write, sound: Path, lasts: dict[bool, float], rng: random.Random
) -> Iterator[Kill]:
    """Kill runs of studies, each once; `lasts` are the times of a whole run and of one after its first animal, s."""
    done = 0
    for number in count():
        late, folder = done % 10 >= EARLY, written_as(place / str(number))
        moment = rng.uniform(0.0, lasts[late])
        if not killed(folder, moment, late, whole=done % 2 == 1):
            lasts[late] = moment  # the machine has become quicker
            continue
        done += 1
        yield went_on(folder, sound)


def struck_in_a_row(
    place: Path, written_as: Write, sound: Path, lasts: dict[bool, float], rng: random.Random
) -> Iterator[Kill]:
    """Kill a run, let it go on and kill it again until it ends; each of the kills has what that end shows."""
    for number in count():
        folder, finished = written_as(place / f"row {number}"), []
        # Later ones come later, so that a run gets on that takes most of the time to begin.
        while killed(
            folder,
            rng.uniform(0.0, lasts[False] / PARTS * (1 + len(finished) / PARTS)),
            late=False,
            whole=len(finished) % 2 == 1,
        ):
            finished.append(len(list(folder.glob(FINISHED))))
        end = went_on(folder, sound)
        yield from (end._replace(finished=one) for one in finished)


def table(kills: list[Kill]) -> str:
    """Return the kills by what had finished when they fell."""
    lines = [
        "| finished when killed | kills | same values | files the same to the last bit, but for the time |",
        "|---|---|---|---|",
    ]
    for finished in sorted({kill.finished for kill in kills}):
        those = [kill for kill in kills if kill.finished == finished]
        same_values, equal = sum(kill.values for kill in those), sum(kill.equal for kill in those)
        lines.append(f"| {finished} of 3 | {len(those)} | {same_values} | {equal} of {3 * len(those)} |")
    return "\n".join(lines) + "\n"


def extracted(image: Path, folder: Path, root: str, *more: str) -> "subprocess.Popen[bytes]":
    """Start an extraction into a folder."""
    command = [*PROGRAM[:-1], "extract", str(image), "-o", str(folder), "--root", root, *more]
    return subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, start_new_session=True)


def tables(folder: Path) -> list[str]:
    """Return what an extraction found, as text."""
    return [(folder / name).read_text(encoding="utf-8") for name in ("network.csv", "vessels.csv")]


def kills_of_extractions(place: Path, count: int, rng: random.Random) -> int:
    """Kill extractions at random moments, do each again, and return how many found what an undisturbed one finds.

    Every second one falls into a folder where an extraction at another threshold had kept its stages.
    """
    small = vw.Network(("1", "2", "3"), [-1, 0, 0], [0.35, 0.4, 0.3], [0.052, 0.042, 0.032])
    placed = embed(small, np.random.default_rng(5))
    image, root = place / "image.nrrd", written(placed.cannula[0])
    write_volume(render(placed, 110, 0.0105, np.random.default_rng(5)), image)
    before, sound = place / "before", place / "sound"
    assert extracted(image, before, root, "--threshold", "50").wait() == 0
    assert extracted(image, sound, root).wait() == 0
    begun = time.monotonic()
    assert extracted(image, place / "timed", root).wait() == 0
    lasts, same_values, done, number = time.monotonic() - begun, 0, 0, 0
    while done < count:
        number, folder = number + 1, place / str(number)
        if done % 2:
            shutil.copytree(before, folder)
        process = extracted(image, folder, root)
        try:
            process.wait(rng.uniform(0.0, lasts))
            continue  # it had ended
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, signal.SIGKILL)
            process.wait()
        again = extracted(image, folder, root).wait()
        done, same_values = done + 1, same_values + (again == 0 and tables(folder) == tables(sound))
        print(f"{done}: {same_values} with the same values", flush=True)
        shutil.rmtree(folder)
    return same_values


def main() -> int:
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("count", type=int, nargs="?", default=100)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--docs", action="store_true", help="put the table into docs/robustness.md")
    parser.add_argument("--posteriors", action="store_true", help="of a study with posteriors")
    parser.add_argument("--in-a-row", action="store_true", help="the same run again and again, until it ends")
    parser.add_argument("--extraction", action="store_true", help="of an extraction, in place of a study")
    arguments = parser.parse_args()
    rng, kills = random.Random(arguments.seed), []
    if arguments.extraction:
        with tempfile.TemporaryDirectory() as place:
            return int(kills_of_extractions(Path(place), arguments.count, rng) != arguments.count)
    written_as = with_posteriors if arguments.posteriors else write_study
    with tempfile.TemporaryDirectory() as place:
        sound = written_as(Path(place) / "sound")
        assert run(sound).status == 0  # compiles
        lasts = dict(zip((False, True), durations(written_as(Path(place) / "timed")), strict=True))
        strike = struck_in_a_row if arguments.in_a_row else struck_once
        for kill in islice(strike(Path(place), written_as, sound, lasts, rng), arguments.count):
            kills.append(kill)
            print(f"{len(kills)}: {kill}", flush=True)
    print("\n" + table(kills))
    if arguments.docs:
        put("kills", table(kills))
    return 0 if len(kills) >= arguments.count and all(kill.values for kill in kills) else 1


if __name__ == "__main__":
    sys.exit(main())
