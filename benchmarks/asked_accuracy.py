"""How often a run is within the accuracy that was asked for, by runs on twice as many cells.

uv run python benchmarks/asked_accuracy.py 100 --seed 3      random models of all kinds of `solver_sweep`

The accuracy is a thousandth of the mean pressure. Models whose own run, or whose finer one, ends with an error count
apart: nothing was promised of the first, and nothing is known of the second.
"""

import argparse
import time
import warnings
from collections import Counter
from unittest.mock import patch

import numpy as np

from solver_sweep import KINDS, ORDER, drawn
from vasowave.errors import NumericalError, VasowaveError, VasowaveWarning
from vasowave.solver import Numerics, accuracy
from vasowave.solver.run import run_to_periodic

SHARE = 0.001
"""Of the mean pressure, that is asked for."""
FINER = 2


def kept(name: str, number: int, seed: int) -> tuple[str, float, float]:
    """Return what came of one model, its true error in the accuracy asked for, and CPU seconds of its run."""
    model, inflow = drawn(KINDS[name], np.random.default_rng([seed, ORDER.index(name), number]))
    asked = SHARE * float(np.mean(inflow.flow)) * model.outlets.total_resistance()
    started, grids = time.process_time(), []

    def noted(*given, **more):
        grids.append((given[2], more.get("refinement", 1)))
        return run_to_periodic(*given, **more)

    try:
        with patch.object(accuracy, "run_to_periodic", noted):
            run = accuracy.run_to_accuracy(model, inflow, Numerics(), asked)
    except NumericalError:
        return "error", np.nan, time.process_time() - started
    seconds = time.process_time() - started
    numerics, refinement = grids[-1]
    try:
        fine = run_to_periodic(model, inflow, numerics, refinement=FINER * refinement)
    except VasowaveError:
        return "no truth", np.nan, seconds
    error = float(np.max(np.abs(run.pressure - fine.pressure))) / asked
    return "kept" if error <= 1 else "missed", error, seconds


def main() -> None:
    """Print counts, the largest errors and the cost."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("count", nargs="?", type=int, default=40)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--kinds", nargs="+", default=[name.split()[0] for name in KINDS])
    chosen = parser.parse_args()
    warnings.simplefilter("ignore", VasowaveWarning)
    names = [name for name in KINDS if name.split()[0] in chosen.kinds]
    print(f"| kind | kept | missed | no truth | error | largest error, in what was asked | CPU s |\n{'|---' * 7}|")
    every = []
    for name in names:
        rows = [kept(name, number, chosen.seed) for number in range(-(-chosen.count // len(names)))]
        every += rows
        print(_line(name, rows), flush=True)
    print(_line("all", every))


def _line(name: str, rows: list[tuple[str, float, float]]) -> str:
    counts = Counter(outcome for outcome, _, _ in rows)
    worst = max((error for _, error, _ in rows if np.isfinite(error)), default=0.0)
    cells = [name, *(counts[one] for one in ("kept", "missed", "no truth", "error")), f"{worst:.2f}"]
    return f"| {' | '.join(map(str, cells))} | {sum(seconds for _, _, seconds in rows):.0f} |"


if __name__ == "__main__":
    main()
