"""Print what a simulation, an ensemble, a Jacobian and a calibration cost, and how the cost grows with the network.

uv run python benchmarks/solver.py

Times are the shortest of several; ratios are of times of the same run.
"""

import os
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable

import numpy as np

from vasowave.blood import Blood
from vasowave.calibration import Search, calibrate
from vasowave.calibration.compared import compared_part
from vasowave.calibration.objective import Objective
from vasowave.calibration.parameters import parameter_space
from vasowave.datasets import control_network
from vasowave.datasets.virtual import ejection, virtual_mouse
from vasowave.model import Model
from vasowave.network import Network
from vasowave.nominal import estimate_nominal, windkessels
from vasowave.solver import Numerics
from vasowave.solver.simulate import simulate_run, simulate_runs
from vasowave.walls import LinearWall, TangentWall

WALLS = {"linear": LinearWall(57.0), "tangent": TangentWall(7.0, 4.0)}
FIRST_CALL = """
import time
from vasowave.datasets import control_network
from vasowave.datasets.virtual import ejection
from vasowave.model import Model
from vasowave.nominal import windkessels
from vasowave.solver import simulate
from vasowave.walls import LinearWall
network = control_network()
start = time.perf_counter()
simulate(Model(network, LinearWall(57.0), windkessels(network, 76.0, 0.12, 0.12)), ejection())
print(time.perf_counter() - start)
"""


def timed(task: Callable[[], object], repeats: int = 7) -> float:
    """Return the shortest of several times of `task`, s."""
    times = []
    for _ in range(repeats):
        start = time.perf_counter()
        task()
        times.append(time.perf_counter() - start)
    return min(times)


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


def one_simulation(name: str, wall: LinearWall | TangentWall) -> None:
    """Print the cost of one simulation, of an ensemble and of a Jacobian."""
    inflow, network = ejection(), control_network()
    model = Model(network, wall, windkessels(network, 76.0, 0.12, 0.12))
    run = simulate_run(model, inflow, Numerics())
    seconds = timed(lambda: simulate_run(model, inflow, Numerics()))
    cycles, cells = len(run.convergence.changes), int(run.grid.is_cell.sum())
    print(
        f"{name} wall: {1e3 * seconds:.1f} ms a simulation of {cycles} cycles ({7e3 * seconds / cycles:.1f} ms for 7), "
        f"{run.steps} steps, {cells} cells; {cells * run.steps * cycles / seconds:.3g} cell steps/s"
    )
    one, all_cores = (
        timed(lambda w=w: simulate_runs([model] * 16, inflow, Numerics(), workers=w), 3) for w in (1, None)
    )
    print(f"  ensemble of 16: {one / all_cores:.2f} times as fast on {os.cpu_count()} cores as on one")
    alone, jacobian, free = cost_of_a_jacobian(name)
    print(f"  a Jacobian of {free} parameters costs as much as {jacobian / alone:.1f} simulations near by")


def cost_of_a_jacobian(name: str) -> tuple[float, float, int]:
    """Return the time of a simulation from a neighbouring one and of a Jacobian, s, and the count of parameters."""
    network, mouse = control_network(), virtual_mouse()
    space = parameter_space(name, network, estimate_nominal(network, mouse), Blood(), {}, {}, False)
    objective = Objective(space, compared_part(mouse), Numerics(tolerance=1e-7), 1, threading.Event())
    x = np.log(space.nominal[space.free])
    objective.residuals(x)
    start = objective.last
    model = space.model(space.values(x + 0.1))
    alone = timed(lambda: simulate_run(model, mouse.inflow, objective.numerics, start))
    return alone, timed(lambda: objective.jacobian(x)), len(x)


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


def calibrations() -> None:
    """Print the cost of the calibration of one mouse."""
    for name in WALLS:
        start = time.perf_counter()
        fit = calibrate(control_network(), virtual_mouse(), name, search=Search(starts=4))
        print(
            f"calibration, {name} wall, 4 starts, N = {fit.N}: {time.perf_counter() - start:.1f} s, "
            f"{int(fit.starts['simulations'].sum())} simulations"
        )


if __name__ == "__main__":
    compiling()
    for law, parameters in WALLS.items():
        one_simulation(law, parameters)
    growth()
    calibrations()
