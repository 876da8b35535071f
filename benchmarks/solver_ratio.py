"""Compare what two versions of the source cost, in one run: each task in turn by the one and by the other.

uv run python benchmarks/solver_ratio.py ../before                     simulations
uv run python benchmarks/solver_ratio.py ../before --fits --rounds 5   and calibrations from four starts

`../before` is another checkout of this project. Both versions live through the whole run, each in a process of its own,
and take turns, so that both meet the same load of the machine. Times are of the processor; what is printed is the
median of the ratios of all turns, and the range that holds the middle half of them.
"""

import argparse
import os
import subprocess
import sys
from pathlib import Path

import numpy as np

HERE = Path(__file__).parents[1]
SIMULATIONS, FITS = ("linear simulation", "tangent simulation"), ("linear fit", "tangent fit")
WORKER = """
import sys, time, warnings
warnings.simplefilter("ignore")
from vasowave.calibration import Search, calibrate
from vasowave.datasets import control_network
from vasowave.datasets.virtual import ejection, virtual_mouse
from vasowave.model.model import Model
from vasowave.model.nominal import windkessels
from vasowave.recording import read_recording
from vasowave.solver import Numerics
from vasowave.solver.simulate import simulate_run
from vasowave.model.walls import LinearWall, TangentWall
network = control_network()
mouse = read_recording(*sys.argv[1:3], period=float(sys.argv[3])) if len(sys.argv) > 1 else virtual_mouse()
walls = {"linear": LinearWall(57.0), "tangent": TangentWall(7.0, 4.0)}
try:
    search = Search(starts=4, pressure_harmonics="all")
except TypeError:  # a version that always compares all of them
    search = Search(starts=4)
for line in sys.stdin:
    name, kind = line.split()
    model, inflow = Model(network, walls[name], windkessels(network, 76.0, 0.12, 0.12)), ejection()
    start, found = time.process_time(), 0.0
    if kind == "fit":
        found = calibrate(network, mouse, name, search=search).S
    else:
        for _ in range(3):
            simulate_run(model, inflow, Numerics())
    print(time.process_time() - start, found, flush=True)
"""


class Version:
    """One version of the source in a process of its own."""

    def __init__(self, source: Path, recording: list[str]) -> None:
        environment = {**os.environ, "PYTHONPATH": str(source / "src")}
        command = [sys.executable, "-c", WORKER, *recording]
        self.process = subprocess.Popen(
            command, env=environment, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
        )

    def does(self, task: str) -> tuple[float, float]:
        """Return the time of a task, s, and the S of the fit that it was."""
        assert self.process.stdin is not None
        assert self.process.stdout is not None
        self.process.stdin.write(task + "\n")
        self.process.stdin.flush()
        seconds, found = self.process.stdout.readline().split()
        return float(seconds), float(found)


def main() -> None:
    """Print a line for every task."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("before", type=Path)
    parser.add_argument("--rounds", type=int, default=31)
    parser.add_argument("--fits", action="store_true")
    parser.add_argument("--recording", nargs=3, default=[], metavar=("PRESSURE", "FLOW", "PERIOD"))
    chosen = parser.parse_args()
    both = [Version(source, chosen.recording) for source in (chosen.before, HERE)]
    for task in (*SIMULATIONS, *(FITS if chosen.fits else ())):
        for version in both:
            version.does(task)  # compiles
        rounds = 1 + chosen.rounds // 20 if task in FITS else chosen.rounds
        turns = np.array([[version.does(task) for version in both] for _ in range(rounds)])
        ratio = turns[:, 1, 0] / turns[:, 0, 0]
        low, middle, high = np.quantile(ratio, [0.25, 0.5, 0.75])
        seconds, S = np.median(turns[:, :, 0], axis=0), turns[0, :, 1]
        said = f"; S {S[0]:.6g} and {S[1]:.6g}" if task in FITS else ""
        print(f"{task:20} {middle:.2f} ({low:.2f} to {high:.2f}) of {seconds[0]:.3g} s{said}", flush=True)
    for version in both:
        version.process.communicate()


if __name__ == "__main__":
    main()
