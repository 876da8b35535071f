"""Print what a simulation, an ensemble, a Jacobian and a calibration cost, and how the cost grows with the network."""

import os
import time
from collections.abc import Callable

import numpy as np

from vasowave.calibration import calibrate
from vasowave.datasets import control_network
from vasowave.datasets.virtual import ejection, virtual_mouse
from vasowave.model import Model
from vasowave.network import Network
from vasowave.nominal import windkessels
from vasowave.solver import Numerics, simulate
from vasowave.solver.simulate import simulate_runs
from vasowave.walls import LinearWall, TangentWall


def timed(task: Callable[[], object], repeats: int = 5) -> float:
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


def main() -> None:
    """Print the table."""
    inflow = ejection()
    network = control_network()
    for wall in (LinearWall(57.0), TangentWall(7.0, 4.0)):
        model = Model(network, wall, windkessels(network, 76.0, 0.12, 0.12))
        first = timed(lambda model=model: simulate(model, inflow), 1)
        result = simulate(model, inflow)
        seconds = timed(lambda model=model: simulate(model, inflow))
        cycles, steps = result.attrs["cycles"], result.attrs["steps_per_cycle"]
        cells = simulate(model, inflow, Numerics(every_cell=True)).sizes["cell"]
        rate = cells * steps * cycles / seconds
        print(f"{type(wall).__name__}: first call {first:.2f} s (compiling, or loading what was compiled)")
        print(
            f"  {1e3 * seconds:.1f} ms a simulation: {cycles} cycles, {steps} steps, {cells} cells, "
            f"{rate:.3g} cell steps/s"
        )
        many = [model] * 16
        one, all_cores = (
            timed(lambda w=w, many=many: simulate_runs(many, inflow, Numerics(), workers=w), 3) for w in (1, None)
        )
        print(f"  ensemble of 16: {one / all_cores:.2f} times as fast on {os.cpu_count()} cores as on one")
    base = None
    for count in (21, 210, 2100, 20000):
        model = Model(tree(count), LinearWall(60.0), windkessels(tree(count), 76.0, 0.12, 0.2))
        numerics = Numerics(samples=32, cycles_from_rest=2)
        seconds = timed(lambda model=model, numerics=numerics: simulate(model, inflow, numerics), 1)
        steps = simulate(model, inflow, numerics).attrs["steps_per_cycle"]
        cost = seconds / count / steps
        base = base or cost
        print(
            f"{count} vessels: {seconds:.2f} s for 2 cycles of {steps} steps; "
            f"per vessel and step {cost / base:.2f} times that of 21"
        )
    for wall in ("linear", "tangent"):
        start = time.perf_counter()
        fit = calibrate(network, virtual_mouse(), wall)
        free = int(fit.parameters["free"].sum())
        print(
            f"calibration, {wall} wall, 4 starts: {time.perf_counter() - start:.1f} s, "
            f"{int(fit.starts['simulations'].sum())} simulations (a Jacobian is {free})"
        )


if __name__ == "__main__":
    main()
