"""How often a run is within the accuracy that was asked for, by runs on twice as many cells.

uv run python benchmarks/asked_accuracy.py 100 --seed 3      random models of all kinds of `solver_sweep`

The accuracy is a thousandth of the mean pressure; the true error is the difference to twice the cells over 3/4.
Models whose own run, or whose finer one, ends with an error count
apart: nothing was promised of the first, and nothing is known of the second.
"""

import argparse
import time
import warnings
from collections import Counter
from typing import NamedTuple

import numpy as np

from solver_sweep import KINDS, ORDER, drawn
from vasowave.base import NumericalError, VasowaveError, VasowaveWarning
from vasowave.pulse.model import Numerics
from vasowave.pulse.solver import run_on_cells, run_to_accuracy

SHARE = 0.001
"""Of the mean pressure, that is asked for."""
FINER = 2
SEEN = 3 / 4  # of an error of second order, by twice the cells


class Kept(NamedTuple):
    """What came of one model; errors in the accuracy that was asked for."""

    outcome: str
    error: float
    estimate: float
    seconds: float


def kept(name: str, number: int, seed: int) -> Kept:
    """Return what came of one model: how it ended, its true error and the run's own estimate, CPU seconds."""
    model, inflow = drawn(KINDS[name], np.random.default_rng([seed, ORDER.index(name), number]))
    asked = SHARE * float(np.mean(inflow.flow)) * model.outlets.total_resistance()
    started = time.process_time()
    try:
        run = run_to_accuracy(model, inflow, Numerics(), asked)
    except NumericalError:
        return Kept("error", np.nan, np.nan, time.process_time() - started)
    seconds, estimate = time.process_time() - started, run.error_estimate / asked
    try:
        fine = run_on_cells(model, inflow, Numerics(tolerance=run.tolerance), FINER * run.grid.counts)
    except VasowaveError:
        return Kept("no truth", np.nan, estimate, seconds)
    error = float(np.max(np.abs(run.pressure - fine.pressure))) / SEEN / asked
    return Kept("kept" if error <= 1 else "missed", error, estimate, seconds)


def main() -> None:
    """Print counts, the largest errors and the cost."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("count", nargs="?", type=int, default=40)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--kinds", nargs="+", default=[name.split()[0] for name in KINDS])
    chosen = parser.parse_args()
    warnings.simplefilter("ignore", VasowaveWarning)
    names = [name for name in KINDS if name.split()[0] in chosen.kinds]
    print(
        "| kind | kept | missed | no truth | error | largest error, in what was asked | in the estimate "
        "| within the estimate | CPU s |\n"
        + "|---" * 9 + "|"
    )  # fmt: skip
    every = []
    for name in names:
        rows = [kept(name, number, chosen.seed) for number in range(-(-chosen.count // len(names)))]
        every += rows
        print(_line(name, rows), flush=True)
    print(_line("all", every))


def _line(name: str, rows: list[Kept]) -> str:
    counts = Counter(one.outcome for one in rows)
    judged = [one for one in rows if np.isfinite(one.error)]
    worst, within = max((one.error for one in judged), default=0.0), sum(one.error <= one.estimate for one in judged)
    over = max((one.error / one.estimate for one in judged), default=0.0)
    cells = [name, *(counts[one] for one in ("kept", "missed", "no truth", "error")), f"{worst:.2f}", f"{over:.2f}"]
    return f"| {' | '.join(map(str, cells))} | {within} of {len(judged)} | {sum(one.seconds for one in rows):.0f} |"


if __name__ == "__main__":
    main()
