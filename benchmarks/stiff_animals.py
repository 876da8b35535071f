"""Count sick animals, stiff and with little flow, that fall out of a study, and laws that fail without a reason.

    uv run python benchmarks/stiff_animals.py                     # 200 scaled animals, 100 trees: about an hour
    uv run python benchmarks/stiff_animals.py 20 --kinds trees    # fewer, of one kind
    uv run python benchmarks/stiff_animals.py 20 --seed 7

Kinds: `scaled`, the measured cycle of mouse C6 (stands beside the project) with its pressure times 1 to 3.5, its flow
times 0.5 to 1.1 and a period of 0.09 to 0.14 s; `trees`, random trees of seven vessels with a tangent wall as truth;
and for a look at what nothing was chosen on: `mice`, the published virtual mice with the same factors, `bounds`, laws
within odd bounds, `own`, a law of a user that raises errors where it does not hold.
"""

import argparse
import time
import warnings
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from pathlib import Path
from typing import NamedTuple

import numpy as np

from vasowave.base import Law, NumericalError, Parameter, VasowaveWarning
from vasowave.base.runtime import VARIABLE
from vasowave.catheter.read import read_recording
from vasowave.pulse.cycle import Inflow, Recording
from vasowave.pulse.examples import control_network, ejection, virtual_mouse
from vasowave.pulse.model import Model, Numerics, TangentWall, windkessels
from vasowave.pulse.network import Network
from vasowave.pulse.solver import simulate
from vasowave.study.animal import Animal, Settings, analyze

LAWS = ("linear", "tangent", "power")
STARTS = 3
NUMERICS = Numerics(cell_size=0.3, tolerance=1e-6)
MOUSE = Path(__file__).parents[1] / ".." / "shared" / "data" / "mouse-c6"
_PARENTS = [-1, 0, 0, 1, 1, 2, 2]


class OwnWall(NamedTuple):
    """A law as a user may write one, p = E (e^(ks) - 1)/k of the strain s, that raises errors out of its range."""

    E: float
    k: float

    @staticmethod
    def law():
        E = Parameter("mmHg", "E", "stiffness", "", 0.5, (1e-4, 20.0))
        k = Parameter("1", "k", "stiffening", "", 1.0, (0.01, 400.0))
        return Law("own", "exponential", "p = E (e^(ks) - 1)/k", "own", (E, k), "E")

    @staticmethod
    def pressure_at(a, E, k):
        return E * (np.exp(k * (a - 1.0)) - 1.0) / k

    @staticmethod
    def ratio_at(p, E, k):
        return 1.0 + np.log(1.0 + k * p / E) / k

    @staticmethod
    def slope_at(p, E, k):
        return 1.0 / (E + k * p)

    @staticmethod
    def limits(E, k):
        if np.any(k > 20.0):
            raise OverflowError("k is too large")
        if np.any(E < 2.0):
            raise ValueError("E is too small")
        return 0.0 * E, 0.0 * E + np.inf


class Came(NamedTuple):
    """What came out of one animal: the laws fitted, the reasons of the others, and if it was lost as a whole."""

    kind: str
    seed: int
    mean_pressure: float
    fitted: tuple[str, ...]
    reasons: dict[str, str]
    lost: str
    starts_failed: int
    simulations: int
    seconds: float
    RMSE: dict[str, float]


def scaled(recording: Recording, rng: np.random.Generator) -> Recording:
    """Return a cycle as of a stiff animal with little flow."""
    pressure, flow = rng.uniform(1.0, 3.5), rng.uniform(0.5, 1.1)
    return Recording(pressure * recording.pressure, flow * recording.flow, rng.uniform(0.09, 0.14))


def tree(rng: np.random.Generator) -> tuple[Network, Recording]:
    """Return a random tree of seven vessels and the cycle of a tangent wall in it; trees it cannot hold are left."""
    while True:
        radius = [0.05 * np.exp(0.15 * rng.standard_normal())]
        for parent in _PARENTS[1:]:
            radius.append(radius[parent] * rng.uniform(0.6, 0.9))
        length = rng.uniform(0.15, 0.6, 7)
        network = Network(tuple("1234567"), _PARENTS, length, radius)
        shape = ejection(256, 0.40, 0.70 + 0.05 * rng.standard_normal()).flow
        mean_flow, target = rng.uniform(0.08, 0.25), rng.uniform(12.0, 45.0)
        inflow = Inflow(mean_flow * shape / shape.mean(), rng.uniform(0.09, 0.14))
        wall = TangentWall(*(np.exp(rng.uniform(*np.log(span))) for span in ((4.0, 40.0), (0.8, 6.0))))
        outlets = windkessels(network, target / mean_flow, rng.uniform(0.08, 0.2), rng.uniform(0.06, 0.2))
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", VasowaveWarning)
                run = simulate(Model(network, wall, outlets), inflow, Numerics(cell_size=0.1, samples=256))
        except NumericalError:
            continue
        noise = 0.3 * np.sin(2 * np.pi * (rng.integers(2, 9) * np.arange(256) / 256 + rng.uniform()))
        pressure = run.pressure.values[:, network.root, 0] + noise + 0.05 * rng.standard_normal(256)
        return network, Recording(pressure, inflow.resampled(256), inflow.period)


def animal_of(kind: str, seed: int) -> tuple[Animal, Settings]:
    """Return the animal of a kind and a seed, and how it is analyzed."""
    rng = np.random.default_rng([seed, *kind.encode()])
    settings = {"walls": LAWS, "starts": STARTS, "model_selection": False, "numerics": NUMERICS, "seed": seed}
    network = control_network()
    if kind == "scaled":
        files = MOUSE / "pC6_1024.dat", MOUSE / "qC6_1024.dat"
        recording = scaled(read_recording(*files, period=0.11), rng)
    elif kind == "trees":
        network, recording = tree(rng)
    else:
        recording = scaled(virtual_mouse(seed=seed), rng)
    if kind == "bounds":
        low = {name: rng.uniform(0.1, 0.9) for name in ("m", "gamma", "r1", "c1")}
        high = {"m": rng.uniform(1.0, 200.0), "gamma": rng.uniform(3.0, 60.0), "r1": 2.0, "c1": 3.0}
        settings["bounds"] = {name: (low[name], high[name]) for name in low}
        settings["method"] = "sqp" if seed % 2 else "least-squares"
    if kind == "own":
        settings["walls"] = ("linear", f"{Path(__file__).stem}:OwnWall")
    return Animal(f"{kind} {seed}", "HPH", network, recording, synthetic=True), Settings(**settings)


def came(kind: str, seed: int) -> Came:
    """Analyze one animal."""
    begun = time.process_time()
    animal, settings = animal_of(kind, seed)
    try:
        result = analyze(animal, settings)
    except Exception as error:
        lost = f"{type(error).__name__}: {error}"
        return Came(kind, seed, animal.recording.mean_pressure, (), {}, lost, 0, 0, time.process_time() - begun, {})
    fits = {wall: result.laws[wall].calibration for wall in result.laws}
    return Came(
        kind, seed, animal.recording.mean_pressure, tuple(fits), {one.law: one.reason for one in result.failures}, "",
        sum(int((~np.isfinite(fit["start_S"].values)).sum()) for fit in fits.values()),
        sum(int(fit["start_simulations"].sum()) for fit in fits.values()),
        time.process_time() - begun, {wall: float(fit["RMSE"]) for wall, fit in fits.items()},
    )  # fmt: skip


def all_of(counts: dict[str, int], seed: int, workers: int) -> Iterator[Came]:
    """Analyze so many animals of every kind."""
    with ProcessPoolExecutor(workers) as pool:
        for kind, count in counts.items():
            yield from pool.map(partial(came, kind), range(1000 * seed, 1000 * seed + count))


def summary(cases: list[Came]) -> str:
    """Return one line on the animals of a kind."""
    laws = 2 if cases[0].kind == "own" else len(LAWS)
    silent = sum(laws - len(one.fitted) - len(one.reasons) for one in cases if not one.lost)
    return (
        f"{cases[0].kind}: {len(cases)} animals, {sum(bool(one.lost) for one in cases)} lost, "
        f"{sum(len(one.reasons) for one in cases)} laws failed with a reason, {silent} without; "
        f"{sum(one.starts_failed for one in cases)} starts failed; {sum(one.simulations for one in cases)} "
        f"simulations, {sum(one.seconds for one in cases):.0f} s"
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("count", nargs="?", type=int, help="animals of each kind")
    parser.add_argument("--kinds", nargs="+", default=["scaled", "trees"])
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--workers", type=int, default=1)
    given = parser.parse_args()
    counts = {kind: given.count or (200 if kind == "scaled" else 100) for kind in given.kinds}
    cases: dict[str, list[Came]] = {}
    for one in all_of(counts, given.seed, given.workers):
        cases.setdefault(one.kind, []).append(one)
        errors = ", ".join(f"{wall} {value:.3g}" for wall, value in one.RMSE.items())
        print(f"{one.kind} {one.seed}: mPAP {one.mean_pressure:.1f}; RMSE {errors} {one.reasons or ''} {one.lost}",
              flush=True)  # fmt: skip
    print(*map(summary, cases.values()), sep="\n")


if __name__ == "__main__":
    import os

    os.environ.setdefault(VARIABLE, "1")
    main()
