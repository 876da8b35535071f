"""Print what a simulation, an ensemble, a Jacobian and a calibration cost, and how the cost grows with the network.

uv run python benchmarks/solver.py           and the ratios to the stored run
uv run python benchmarks/solver.py --keep    store this run
uv run python benchmarks/solver.py --ensemble 100000    an ensemble of so many members alone, and the memory it takes

Counts of work (cell steps, vessel-end steps) are the same on every machine. Times are the shortest of several, of the
processor and not of the clock. For the comparison with the stored run they are counted in units of a fixed piece of
compiled work, timed in the same run: not every machine counts instructions.
"""

import argparse
import json
import os
import resource
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
from numba import njit

from vasowave.pulse.calibration import DERIVATIVE_ERROR, Objective, Search, calibrate, compared_part, parameter_space
from vasowave.pulse.cycle import Inflow
from vasowave.pulse.examples import control_network, ejection, virtual_mouse
from vasowave.pulse.model import Blood, LinearWall, Model, Numerics, TangentWall, estimate_nominal, windkessels
from vasowave.pulse.network import Network
from vasowave.pulse.solver import simulate_run, simulate_runs, sweep, tangent

WALLS = {"linear": LinearWall(57.0), "tangent": TangentWall(7.0, 4.0)}
FIRST_CALL = """
import time
from vasowave.pulse.examples.published import control_network
from vasowave.pulse.examples.mouse import ejection
from vasowave.pulse.model.model import Model
from vasowave.pulse.model.nominal import windkessels
from vasowave.pulse.solver.simulation import simulate
from vasowave.pulse.model.walls import LinearWall
network = control_network()
start = time.perf_counter()
simulate(Model(network, LinearWall(57.0), windkessels(network, 76.0, 0.12, 0.12)), ejection())
print(time.perf_counter() - start)
"""


STORED = Path(__file__).with_suffix(".json")


def timed(task: Callable[[], object], repeats: int = 7, clock: Callable[[], float] = time.process_time) -> float:
    """Return the shortest of several times of `task`, s."""
    times = []
    for _ in range(repeats):
        start = clock()
        task()
        times.append(clock() - start)
    return min(times)


def unit() -> float:
    """Return the time of a fixed piece of work, s: ten million tangents as the solver takes them."""
    one = njit(tangent)

    @njit
    def work(count: int) -> float:
        total = 0.0
        for i in range(count):
            total += one(1e-7 * i)
        return total

    work(1)
    return timed(lambda: work(10_000_000))


def compared(costs: dict[str, float]) -> None:
    """Print every cost and its ratio to that of the stored run."""
    stored = json.loads(STORED.read_text()) if STORED.exists() else {}
    for name, cost in costs.items():
        before = f"{cost / stored[name]:6.2f} of the stored run" if name in stored else "  not stored"
        print(f"{name:32} {cost:10.5g} {before}")


def tree(count: int) -> Network:
    """Return a binary tree of `count` vessels of like size."""
    parent = (np.arange(count) - 1) // 2
    parent[0] = -1
    depth = np.floor(np.log2(np.arange(count) + 1))
    return Network(tuple(map(str, range(count))), parent, np.full(count, 0.2), 0.047 * 0.88**depth)


def compiling() -> None:
    """Print how long the first simulation of a new process takes, without and with what was compiled before."""
    with tempfile.TemporaryDirectory() as cache:
        environment = {**os.environ, "NUMBA_CACHE_DIR": cache}
        command = [sys.executable, "-c", FIRST_CALL]
        first, cached = (
            float(subprocess.run(command, env=environment, capture_output=True, text=True, check=True).stdout)
            for _ in range(2)
        )
    print(f"first simulation of a process: {first:.1f} s with compiling, {cached:.2f} s with what was compiled before")


def one_simulation(name: str, wall: LinearWall | TangentWall) -> tuple[dict[str, float], dict[str, float]]:
    """Print the cost of one simulation, a Jacobian and an ensemble; return work counted and times, s."""
    inflow, network = ejection(), control_network()
    model = Model(network, wall, windkessels(network, 76.0, 0.12, 0.12))
    run = simulate_run(model, inflow, Numerics())
    seconds = timed(lambda: simulate_run(model, inflow, Numerics()))
    cycles, cells = len(run.convergence.changes), int(run.grid.is_cell.sum())
    print(
        f"{name} wall: {1e3 * seconds:.1f} ms a simulation of {cycles} cycles ({7e3 * seconds / cycles:.1f} ms for 7), "
        f"{run.steps} steps, {cells} cells; {cells * run.steps * cycles / seconds:.3g} cell steps/s"
    )
    faster, busier = of_threads([model] * 16, inflow)
    print(
        f"  ensemble of 16: {faster:.2f} times as fast on {os.cpu_count()} cores as on one, beside all that runs, "
        f"{busier:.2f} of the processor time"
    )
    alone, exact, rough, free = cost_of_a_jacobian(name)
    print(
        f"  a Jacobian of {free} parameters costs as much as {exact / alone:.2f} simulations near by, one for a search "
        f"{rough / alone:.2f}"
    )
    work: dict[str, float] = {
        f"{name}, cell steps": cells * run.steps * cycles,
        f"{name}, end steps": 2 * len(network) * run.steps * cycles,
    }
    times = {f"{name}, simulation": seconds, f"{name}, near by": alone, f"{name}, Jacobian": exact}
    return work, times


def of_threads(models: list[Model], inflow: Inflow) -> tuple[float, float]:
    """Return how many times as fast all cores are, and how much processor time they take of one; medians of turns."""

    def costs(workers: int | None) -> tuple[float, float]:
        clock, processor = time.perf_counter(), time.process_time()
        list(simulate_runs(models, inflow, Numerics(), workers=workers))
        return time.perf_counter() - clock, time.process_time() - processor

    turns = np.array([[costs(workers) for workers in (1, None)] for _ in range(15)])
    ratios = turns[:, 0] / turns[:, 1]
    return float(np.median(ratios[:, 0])), float(np.median(1 / ratios[:, 1]))


def cost_of_a_jacobian(name: str) -> tuple[float, float, float, int]:
    """Return times, s, of a simulation near by, a Jacobian, one for a search; and the count of parameters."""
    network, mouse = control_network(), virtual_mouse()
    space = parameter_space(name, network, estimate_nominal(network, mouse), Blood())
    objective = Objective(space, compared_part(mouse), Numerics(tolerance=1e-7), 1, threading.Event())
    x = np.log(space.nominal[space.free])
    objective.residuals(x)
    start = objective.last
    model = space.model(space.values(x + 0.1))
    alone = timed(lambda: simulate_run(model, mouse.inflow, objective.numerics, start))
    exact = timed(lambda: objective.jacobian(x))
    objective.exactness = DERIVATIVE_ERROR
    return alone, exact, timed(lambda: objective.jacobian(x)), len(x)


def growth() -> None:
    """Print how the cost grows with the network."""
    base = None
    for count in (21, 210, 2100, 20000):
        network = tree(count)
        model = Model(network, LinearWall(60.0), windkessels(network, 76.0, 0.12, 0.2))
        numerics = Numerics(samples=32, steps_per_cycle=640, cycles_from_rest=2)
        seconds = timed(lambda model=model, numerics=numerics: simulate_run(model, ejection(), numerics), 2)
        base = base or seconds / count
        print(
            f"{count} vessels: {seconds:.2f} s for 2 cycles of 640 steps, {seconds / count / base:.2f} of 21 by vessel"
        )


def calibrations() -> dict[str, float]:
    """Print and return the cost of the calibration of one mouse, s."""
    costs = {}
    for name in WALLS:
        start = time.process_time()
        fit = calibrate(control_network(), virtual_mouse(), name, search=Search(starts=4))
        costs[f"{name}, 4 starts"] = time.process_time() - start
        print(
            f"calibration, {name} wall, 4 starts, N = {fit.N}: {costs[f'{name}, 4 starts']:.1f} s, "
            f"{int(fit.starts['simulations'].sum())} simulations and Jacobians"
        )
    return costs


def ensemble(count: int) -> None:
    """Print time and memory of an ensemble of tubes of four cells: every combination of stiffness and resistance."""
    network = Network(("tube",), np.array([-1]), np.array([0.4]), np.array([0.047]))
    model = Model(network, LinearWall(57.0), windkessels(network, 76.0, 0.12, 0.12))
    inflow, numerics, few = ejection(), Numerics(samples=32), round(count**0.5)

    def swept(members: int) -> float:
        values = {"beta": np.linspace(40, 90, few).tolist(), "R_T": np.linspace(60, 95, members // few).tolist()}
        start = time.perf_counter()
        failed = int((sweep(model, inflow, values, numerics, samples=32).failure.to_numpy() != "").sum())
        size = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
        seconds = time.perf_counter() - start
        print(
            f"{few * (members // few)} members of one vessel: {seconds:.1f} s, {failed} failed, {size:.0f} MB at most"
        )
        return seconds

    swept(10 * few)
    swept(count)


def main() -> None:
    """Print all costs; with --keep, store them."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--keep", action="store_true")
    parser.add_argument("--ensemble", type=int, metavar="MEMBERS")
    chosen = parser.parse_args()
    if chosen.ensemble:
        ensemble(chosen.ensemble)
        return
    compiling()
    costs: dict[str, float] = {}
    seconds: dict[str, float] = {}
    for law, parameters in WALLS.items():
        work, times = one_simulation(law, parameters)
        costs, seconds = costs | work, seconds | times
    growth()
    seconds |= calibrations()
    one = unit()
    costs |= {f"{name}, units of work": value / one for name, value in seconds.items()}
    compared(costs)
    if chosen.keep:
        STORED.write_text(json.dumps({name: round(cost, 4) for name, cost in costs.items()}, indent=2) + "\n")


if __name__ == "__main__":
    main()
