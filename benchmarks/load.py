"""How time and memory grow with the number of animals.

uv run python benchmarks/load.py                  10 and 100 animals: a few minutes
uv run python benchmarks/load.py 10 100 200 1000  as in docs/robustness.md
uv run python benchmarks/load.py 3 6 --docs

Six virtual mice are analyzed, or fewer where the smallest study has fewer; every animal of a larger study has one of
their stored results under its own name, and a recording of its own. So nothing is solved here: what is measured is to
write the results, to run again where everything is kept, and to make the report, each in a process of its own.
"""

import argparse
import math
import os
import subprocess
import sys
import tempfile
import time
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

import vasowave as vw
from robustness_page import put
from vasowave.study.animal import to_bytes
from vasowave.study.folder import RESULTS, Study
from vasowave.study.results import ResultStore, animal_key
from vasowave.study.running import read_study

SOLVED = 6
SETTINGS = """\
groups: [CTL, HPH]
calibration: {walls: [linear, tangent], starts: 1}
model_selection: false
report: {pdf: false}
"""
STEPS = {
    "results": ["run", "--no-report"],
    "kept re-run": ["run", "--no-report"],
    "report": ["report"],
}


class Cost(NamedTuple):
    """What one step took: time of the processor (s; others on the machine hardly change it) with all its processes,
    time of the clock (s), and the memory of its largest process (GB)."""

    seconds: float
    clock: float
    memory: float


def write_study(folder: Path, count: int) -> Study:
    """Write a study of `count` animals, each with a recording that differs a little."""
    folder.mkdir()
    vw.write_network(vw.control_network(), folder / "n.csv")
    mouse, rng = vw.virtual_mouse(), np.random.default_rng(3)
    rows = ["animal,group,network,recording,synthetic"]
    for number in range(count):
        scale = 1 + 0.05 * rng.standard_normal()
        signals = np.column_stack([mouse.time, mouse.pressure * scale, mouse.flow])
        np.savetxt(
            folder / f"{number}.csv", signals, "%.6f", ",", header="time [s],pressure [mmHg],flow [ml/s]", comments=""
        )
        rows.append(f"mouse {number},{('CTL', 'HPH')[number % 2]},n.csv,{number}.csv,yes")
    (folder / "animals.csv").write_text("\n".join(rows) + "\n")
    (folder / "study.yaml").write_text(SETTINGS)
    return read_study(folder)


def solved(folder: Path, count: int) -> list:
    """Return the results of the mice that are analyzed."""
    study = write_study(folder, count)
    with ThreadPoolExecutor(1) as here:
        vw.run_study(study, executor=here)
    results = vw.read_results(folder)
    return [results[name] for name in results]


def fill_store(study: Study, results: list) -> None:
    """Keep a piece for every animal of a study, as if it had been analyzed."""
    (study.folder / RESULTS).mkdir()
    store = ResultStore(study.results)
    for number, row in enumerate(study.animals):
        result = replace(results[number % len(results)], name=row.animal, group=row.group)
        store.keep(animal_key(row, study.settings, study.folder), to_bytes(result.to_datatree()))


def cost(command: list[str], folder: Path) -> Cost:
    """Run one command of vasowave in a process of its own."""
    program = "from vasowave.cli import run; run()"
    begun = time.monotonic()
    process = subprocess.Popen(
        [sys.executable, "-c", program, command[0], str(folder), *command[1:]], stdout=subprocess.DEVNULL
    )
    _, status, usage = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode != 0:
        raise RuntimeError(f"{command} ended with status {process.returncode}")
    return Cost(usage.ru_utime + usage.ru_stime, time.monotonic() - begun, usage.ru_maxrss / 1e6)


def exponent(costs: dict[int, Cost]) -> float:
    """Return the growth between the two largest studies, as a power of the number of animals; NaN of one study."""
    if len(costs) < 2:
        return math.nan
    (small, first), (large, last) = sorted(costs.items())[-2:]
    return math.log(last.seconds / first.seconds) / math.log(large / small)


def table(costs: dict[str, dict[int, Cost]]) -> str:
    """Return time and memory of every step by number of animals."""
    counts = sorted(next(iter(costs.values())))
    lines = ["| step | " + " | ".join(f"{count} animals" for count in counts) + " | exponent |"]
    lines.append("|" + "---|" * (len(counts) + 2))
    for step, found in costs.items():
        cells = [
            f"{found[count].seconds:.1f} s ({found[count].clock:.0f}), {found[count].memory:.2f} GB" for count in counts
        ]
        lines.append(f"| {step} | {' | '.join(cells)} | {exponent(found):.2f} |")
    return "\n".join(lines) + "\n"


def main() -> int:
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("counts", type=int, nargs="*", default=[10, 100])
    parser.add_argument("--docs", action="store_true", help="put the table into docs/robustness.md")
    arguments = parser.parse_args()
    costs: dict[str, dict[int, Cost]] = {step: {} for step in STEPS}
    with tempfile.TemporaryDirectory() as name:
        results = solved(Path(name) / "solved", min(SOLVED, *arguments.counts))
        for count in arguments.counts:
            study = write_study(Path(name) / str(count), count)
            fill_store(study, results)
            for step, command in STEPS.items():
                costs[step][count] = cost(command, study.folder)
                print(f"{count} animals, {step}: {costs[step][count]}", flush=True)
    print("\n" + table(costs))
    if arguments.docs:
        put("load", table(costs))
    return 0


if __name__ == "__main__":
    sys.exit(main())
