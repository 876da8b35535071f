"""Compare what two versions of the source cost, in one run: each task in turn by the one and by the other.

uv run python benchmarks/solver_ratio.py ../before            simulations
uv run python benchmarks/solver_ratio.py ../before --longer   and fits from four and twenty starts, sweeps, posteriors
uv run python benchmarks/solver_ratio.py 3fedd0a4 --also "linear fit" --limit 1.2   exit code 1: a median is above

`../before` is another checkout of this project, 3fedd0a4 a commit of it. Both versions live through the whole run, each
in a process of its own, and take turns, so that both meet the same load of the machine. Times are of the processor;
what is printed is the median of the ratios of all turns, and the range that holds the middle half of them.
"""

import argparse
import os
import subprocess
import sys
import tarfile
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from io import BytesIO
from pathlib import Path

import numpy as np

HERE = Path(__file__).parents[1]
SIMULATIONS = "linear simulation", "tangent simulation"
LONGER = tuple(f"{law} {kind}" for kind in ("fit", "twenty", "sweep", "posterior") for law in ("linear", "tangent"))
WORKER = """
import sys, time, warnings
import numpy as np
import vasowave as vw
warnings.simplefilter("ignore")
network = vw.control_network()
mouse = vw.read_recording(*sys.argv[1:3], period=float(sys.argv[3])) if len(sys.argv) > 1 else vw.virtual_mouse()
nominal = vw.estimate_nominal(network, mouse)
walls = {"linear": vw.LinearWall(57.0), "tangent": vw.TangentWall(7.0, 4.0)}
def search(starts):
    try:
        return vw.Search(starts=starts, pressure_harmonics="all")
    except TypeError:  # a version that always compares all of them
        return vw.Search(starts=starts)
for line in sys.stdin:
    name, kind = line.split()
    model = vw.Model(network, walls[name], nominal.outlets)
    start, found = time.process_time(), 0.0
    if kind in ("fit", "twenty"):
        found = vw.calibrate(network, mouse, name, search=search(4 if kind == "fit" else 20)).S
    elif kind == "sweep":
        stiffness = {"linear": ("beta", 40, 80), "tangent": ("p1", 5, 9)}[name]
        values = {stiffness[0]: np.linspace(*stiffness[1:], 25), "R_T": np.linspace(60, 100, 40)}
        found = float(vw.sweep(model, mouse, values)["root_pressure"].mean())
    elif kind == "posterior":
        found = vw.posterior(network, mouse, name, workers=1).diagnostics.log_evidence
    else:
        for _ in range(3):
            vw.simulate(model, mouse)
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
        """Return the time of a task, s, and what it found: S of a fit, a sweep's mean pressure, log evidence."""
        assert self.process.stdin is not None
        assert self.process.stdout is not None
        self.process.stdin.write(task + "\n")
        self.process.stdin.flush()
        seconds, found = self.process.stdout.readline().split()
        return float(seconds), float(found)


@contextmanager
def source_of(before: str) -> Iterator[Path]:
    """Give the folder of a checkout, or of the source of a commit."""
    if Path(before).is_dir():
        yield Path(before)
        return
    packed = subprocess.run(["git", "archive", before, "src"], cwd=HERE, check=True, stdout=subprocess.PIPE).stdout
    with tempfile.TemporaryDirectory() as folder, tarfile.open(fileobj=BytesIO(packed)) as archive:
        archive.extractall(folder, filter="data")
        yield Path(folder)


def main() -> int:
    """Print a line for every task; return 1 where one costs more than the limit."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("before")
    parser.add_argument("--rounds", type=int, default=31)
    parser.add_argument("--longer", action="store_true")
    parser.add_argument("--also", nargs="+", choices=LONGER, default=[])
    parser.add_argument("--limit", type=float, default=float("inf"))
    parser.add_argument("--recording", nargs=3, default=[], metavar=("PRESSURE", "FLOW", "PERIOD"))
    chosen = parser.parse_args()
    with source_of(chosen.before) as before:
        both = [Version(source, chosen.recording) for source in (before, HERE)]
        ratios = [
            compared(task, both, 1 + chosen.rounds // 20 if task in LONGER else chosen.rounds)
            for task in (*SIMULATIONS, *(LONGER if chosen.longer else chosen.also))
        ]
        for version in both:
            version.process.communicate()
    return int(max(ratios) > chosen.limit)


def compared(task: str, both: list[Version], rounds: int) -> float:
    """Print what a task costs the second version as a share of the first, and return it: the median of turns."""
    for version in both:
        version.does(task)  # compiles
    turns = np.array([[version.does(task) for version in both] for _ in range(rounds)])
    ratio = turns[:, 1, 0] / turns[:, 0, 0]
    low, middle, high = np.quantile(ratio, [0.25, 0.5, 0.75])
    seconds, found = np.median(turns[:, :, 0], axis=0), turns[0, :, 1]
    said = f"; {found[0]:.6g} and {found[1]:.6g}" if task in LONGER else ""
    print(f"{task:20} {middle:.2f} ({low:.2f} to {high:.2f}) of {seconds[0]:.3g} s{said}", flush=True)
    return float(middle)


if __name__ == "__main__":
    sys.exit(main())
