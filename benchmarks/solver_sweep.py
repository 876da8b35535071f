"""Simulate random models of many kinds, repeat a tenth on twice the cells, and count what went wrong in silence.

uv run python benchmarks/solver_sweep.py                      1000 models of all kinds
uv run python benchmarks/solver_sweep.py 5000 --seed 7 --keep sweep.jsonl    more; goes on where it was stopped
uv run python benchmarks/solver_sweep.py 600 --kinds mouse rat --share 0.5   of two kinds, every second one repeated

A result is wrong when it differs anywhere by more than 2 % of the largest pressure from that of twice the cells. The
reason of every error is tried by a run that would contradict it (`solver_reasons`). Kinds marked * were not looked at
when thresholds were chosen.
"""

import argparse
import json
import time
import warnings
from collections import Counter
from collections.abc import Callable
from dataclasses import replace
from itertools import product
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from solver_reasons import contradiction
from vasowave.base import InputError, NumericalError, VasowaveWarning
from vasowave.pulse.cycle import Inflow
from vasowave.pulse.model import (
    Blood,
    BoundaryLayer,
    LinearWall,
    Model,
    Numerics,
    Poiseuille,
    PowerLaw,
    Shape,
    TangentWall,
    wave_speed_at_rest,
    windkessels,
)
from vasowave.pulse.network import Network
from vasowave.pulse.solver import run_to_periodic

WRONG = 0.02  # of the largest pressure
RIGHT = 0.0025  # likewise: a note about the grid of a model that is less wrong is false


class Kind(NamedTuple):
    """Ranges from which the models of one kind are drawn, log-uniformly.

    Lengths are multiples of the radius; the mean pressure fixes the resistance; the strain at it fixes the wall; the
    peak flow is that share of the area times the wave speed at rest. `falls` is the range, evenly drawn, of what radii
    fall from inlet to outlet; `back` the flow that returns after ejection, over the peak; `changed` what the radius of
    one vessel is multiplied by; `behind` the pressure behind the beds, in mean pressures below zero; `spike` the height
    of a spike of one to four of 256 samples on the flow, over the peak.
    fall from inlet to outlet; `back` the flow that returns after ejection, over the peak; `bridges` the vessels, at
    most, that join junctions of the tree to loops.
    """

    radius: tuple[float, float]
    length: tuple[float, float]
    period: tuple[float, float]
    mean_pressure: tuple[float, float]
    strain: tuple[float, float]
    peak: tuple[float, float]
    ejection: tuple[float, float]
    falls: tuple[float, float] = (0.0, 0.0)
    back: float = 0.0
    junctions: Any = None
    changed: tuple[float, float] | None = None
    behind: tuple[float, float] | None = None
    spike: tuple[float, float] | None = None
    bridges: int = 0


KINDS = {
    "mouse": Kind((0.035, 0.06), (2, 12), (0.08, 0.16), (10, 35), (0.2, 0.8), (0.1, 0.35), (0.3, 0.5)),
    "human": Kind((0.3, 1.0), (3, 30), (0.6, 1.2), (12, 110), (0.08, 0.5), (0.05, 0.4), (0.3, 0.45)),
    "mismatched": Kind((0.002, 1.0), (2, 60), (0.08, 1.2), (5, 120), (0.03, 1.0), (0.02, 1.0), (0.1, 0.6)),
    "rat *": Kind((0.06, 0.15), (2, 15), (0.14, 0.25), (12, 45), (0.15, 0.7), (0.1, 0.4), (0.3, 0.5)),
    "arterioles *": Kind((0.002, 0.01), (5, 40), (0.08, 1.2), (8, 60), (0.05, 0.5), (0.005, 0.1), (0.3, 0.6)),
    "sudden *": Kind((0.02, 0.5), (3, 30), (0.08, 0.6), (10, 80), (0.1, 0.8), (0.05, 0.6), (0.05, 0.2)),
    "tapering *": Kind(
        (0.035, 1.0), (2, 30), (0.08, 1.2), (10, 110), (0.08, 0.8), (0.05, 0.4), (0.3, 0.5), (-0.2, 0.5), 0.2
    ),
    "total *": Kind(
        (0.002, 1.0), (2, 60), (0.08, 1.2), (5, 120), (0.03, 1.0), (0.02, 1.0), (0.1, 0.6), back=0.4, junctions="total"
    ),
    "stenosis *": Kind(
        (0.035, 1.0), (2, 30), (0.08, 1.2), (10, 110), (0.08, 0.8), (0.05, 0.3), (0.3, 0.5), changed=(0.2, 0.7)
    ),
    "aneurysm *": Kind(
        (0.035, 1.0), (2, 30), (0.08, 1.2), (10, 110), (0.08, 0.8), (0.05, 0.4), (0.3, 0.5), changed=(1.5, 4.0)
    ),
    "negative *": Kind(
        (0.035, 1.0), (2, 30), (0.08, 1.2), (5, 60), (0.08, 0.4), (0.03, 0.3), (0.3, 0.5), behind=(0.5, 3.0)
    ),
    "spike *": Kind(
        (0.035, 1.0), (2, 30), (0.08, 1.2), (10, 110), (0.08, 0.8), (0.05, 0.3), (0.3, 0.5), spike=(0.1, 1.0)
    ),
    "loop *": Kind(
        (0.035, 1.0), (2, 30), (0.08, 1.2), (10, 110), (0.08, 0.8), (0.05, 0.4), (0.3, 0.5), back=0.2, bridges=4
    ),
}
ORDER = (*sorted(list(KINDS)[:8]), *list(KINDS)[8:])
"""Which number a kind has in seeds: later ones come behind, so that earlier models stay what they were."""


def drawn(kind: Kind, rng: np.random.Generator) -> tuple[Model, Inflow]:
    """Return a random model of one kind and its inflow."""

    def draw(name: str) -> float:
        low, high = getattr(kind, name)
        return float(np.exp(rng.uniform(np.log(low), np.log(high))))

    network = tree(int(2 ** rng.uniform(0, 6)), draw("radius"), lambda: draw("length"), rng)
    if kind.changed:
        radius = network.radius.copy()
        radius[rng.integers(len(radius))] *= draw("changed")
        network = replace(network, radius=radius)
    if kind.bridges:
        network = looped(network, int(rng.integers(1, kind.bridges + 1)), lambda: draw("length"), rng)
    period, mean, strain = draw("period"), draw("mean_pressure"), draw("strain")
    beta = mean / (np.sqrt(1 + strain) - 1)
    wall: Any = LinearWall(beta)
    if rng.random() < 0.5:  # p1 and gamma with the same strain at the mean pressure
        p1 = mean * np.exp(rng.uniform(np.log(0.3), np.log(3)))
        wall = TangentWall(p1, np.pi * strain / np.arctan(mean / p1))
    friction = [BoundaryLayer(), Poiseuille(), PowerLaw(9.0)][rng.integers(3)]
    blood = Blood(friction=friction)
    c0 = float(wave_speed_at_rest(wall, blood.inertia))
    phase = (np.arange(256) / 256 - 0.05) / draw("ejection")
    shape = np.where((phase > 0) & (phase < 1), np.sin(np.pi * np.clip(phase, 0, 1)) ** 2 * (1.35 - 0.7 * phase), 0)
    shape = shape / shape.max()
    if kind.back:
        after = (phase - 1.0) / 0.3
        shape -= rng.uniform(0.0, kind.back) * np.where((after > 0) & (after < 1), np.sin(np.pi * after) ** 2, 0.0)
    if kind.spike:
        first = rng.integers(256)
        shape[(first + np.arange(rng.integers(1, 5))) % 256] += draw("spike")
    flow = draw("peak") * c0 * network.area[network.root] * shape
    resistance = mean / flow.mean()
    outlets = windkessels(network, resistance, period * rng.uniform(0.3, 3), rng.uniform(0.03, 0.4))
    falls = rng.uniform(*kind.falls, len(network)) if kind.falls[1] else np.zeros(len(network))
    tapers = Shape(1.0 + np.outer(falls, [0.5, -0.5]))
    behind = -mean * draw("behind") if kind.behind else 0.0
    model = Model(network, wall, outlets, blood, behind, shape=tapers, junctions=kind.junctions)
    return model, Inflow(flow, period)


def tree(count: int, radius: float, length: Callable[[], float], rng: np.random.Generator) -> Network:
    """Return a random binary tree whose radii obey r^ξ = r1^ξ + r2^ξ and end at 0.002 cm."""
    parent, radii = [-1], [radius]
    while len(parent) + 2 <= count:
        ends = [row for row in range(len(parent)) if row not in parent]
        row = int(rng.choice(ends))
        share, power = rng.uniform(0.15, 0.85), rng.uniform(2.3, 3.0)
        for part in (share, 1 - share):
            parent.append(row)
            radii.append(max(0.002, radii[row] * part ** (1 / power)))
    lengths = np.array([length() for _ in radii]) * radii
    return Network(tuple(str(i) for i in range(len(parent))), np.array(parent), lengths, np.array(radii))


def looped(network: Network, count: int, length: Callable[[], float], rng: np.random.Generator) -> Network:
    """Return a tree with vessels more between the ends of two of its vessels that lead on, some of them parallel.

    What one vessel leads to is enough for a loop: the new vessel then runs beside it.
    """
    inner = np.setdiff1d(np.arange(len(network)), network.terminals)
    if not len(inner):
        network = Network(
            ("0", "1", "2"), np.array([-1, 0, 0]), np.repeat(network.length, 3), network.radius[[0, 0, 0]]
        )
        inner = np.array([0])
    nodes, radii = [*np.column_stack([network.start, network.end]).tolist()], [*network.radius]
    for _ in range(count):
        first, last = rng.choice(inner), rng.choice(inner)
        start = network.start[first] if first == last and first != network.root else network.end[first]
        if start == network.end[last]:
            continue
        nodes.append([int(start), int(network.end[last])])
        radii.append(rng.uniform(0.3, 1.0) * network.radius[last])
    if len(nodes) == len(network):  # two ends in one: the tree's last vessels meet before one more
        ends = network.end[network.terminals[-2:]].tolist()
        nodes = [[start, ends[0] if end in ends else end] for start, end in nodes] + [[ends[0], ends[1]]]
        radii.append(network.radius[network.terminals[-2:]].max())
    new = np.array([length() for _ in nodes[len(network) :]]) * radii[len(network) :]
    names = tuple(str(row) for row in range(len(nodes)))
    return Network(names, None, np.concatenate([network.length, new]), np.array(radii), nodes=np.array(nodes))


def simulated(model: Model, inflow: Inflow, repeat: bool) -> dict[str, Any]:
    """Return what came of one model: an error, or its extremes, notes and (if repeated) its true error."""
    started = time.process_time()
    try:
        run = run_to_periodic(model, inflow, Numerics())
    except (InputError, NumericalError) as error:
        seconds = time.process_time() - started
        return {"error": str(error), "seconds": seconds, "contradiction": contradiction(model, inflow, str(error))}
    extremes = run.extremes
    found: dict[str, Any] = {name: getattr(extremes, name).value for name in extremes._fields}
    pressure = run.pressure
    found |= {"peak": float(np.abs(pressure).max()), "range": float(np.ptp(pressure)), "mach": run.mach.value}
    found["of grid"] = sum(one.code.startswith("solver.depends-on-grid") for one in run.notes)
    found |= {"notes": list(map(str, run.notes)), "steps": run.steps, "cycles": len(run.convergence.changes)}
    found["seconds"] = time.process_time() - started
    if repeat:
        try:
            fine = run_to_periodic(model, inflow, Numerics(), refinement=2)
        except NumericalError as error:
            return found | {"fine error": str(error)}
        found["wrong"] = float(np.max(np.abs(pressure - fine.pressure))) / found["peak"]
    return found


def swept(name: str, number: int, seed: int, share: float) -> dict[str, Any]:
    """Return what came of one model of one kind; a random share of the models is repeated."""
    rng = np.random.default_rng([seed, ORDER.index(name), number])
    model, inflow = drawn(KINDS[name], rng)
    row = simulated(model, inflow, rng.random() < share)
    return row | {"seed": seed, "kind": name, "number": number, "vessels": len(model.network)}


COLUMNS = [
    "kind",
    "models",
    "errors",
    "false_reason",
    "noted",
    "false_note",
    "repeated",
    "wrong",
    "wrong_in_silence",
    "worst_in_silence",
]


def summary(name: str, rows: list[dict[str, Any]]) -> str:
    """Return one line of the table."""
    done = [row for row in rows if "error" not in row]
    false = sum(bool(row.get("contradiction")) for row in rows)
    judged = [row for row in done if "wrong" in row]
    wrong = [row for row in judged if row["wrong"] > WRONG]
    silent = [row for row in wrong if not row["notes"]]
    noted = sum(bool(row["notes"]) for row in done)
    worst = max((row["wrong"] for row in judged if not row["notes"]), default=0.0)
    idle = sum(bool(row["of grid"]) and row["wrong"] < RIGHT for row in judged)
    cells = [name, len(rows), len(rows) - len(done), false, noted, idle, len(judged), len(wrong), len(silent)]
    return f"| {' | '.join(map(str, cells))} | {100 * worst:.2f} % |"


def kept_rows(path: Path | None, seed: int) -> list[dict[str, Any]]:
    """Return the rows of an earlier call with this seed, one a line of the file; a torn last line is dropped."""
    if path is None or not path.exists():
        return []
    lines = path.read_text().splitlines(keepends=True)
    whole = [line for line in lines if line.endswith("\n")]
    path.write_text("".join(whole))
    return [row for row in map(json.loads, whole) if row["seed"] == seed]


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("count", nargs="?", type=int, default=1000, help="models of all kinds together")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--share", type=float, default=0.1, help="of the models, repeated on twice the cells")
    parser.add_argument("--kinds", nargs="+", default=[name.split()[0] for name in KINDS])
    parser.add_argument("--keep", type=Path, help="write every model's row to this file, and take what stands there")
    chosen = parser.parse_args()
    warnings.simplefilter("ignore", VasowaveWarning)
    names = [name for name in KINDS if name.split()[0] in chosen.kinds]
    count = -(-chosen.count // len(names))
    rows = [row for row in kept_rows(chosen.keep, chosen.seed) if row["kind"] in names and row["number"] < count]
    there = {(row["number"], row["kind"]) for row in rows}
    for number, name in [one for one in product(range(count), names) if one not in there]:
        rows.append(swept(name, number, chosen.seed, chosen.share))
        if chosen.keep:
            with chosen.keep.open("a") as file:
                file.write(json.dumps(rows[-1]) + "\n")
    print(f"| {' | '.join(COLUMNS).replace('_', ' ')} |\n{'|---' * len(COLUMNS)}|")
    for name in names:
        print(summary(name, [row for row in rows if row["kind"] == name]))
    print(summary("all", rows))
    report_errors(rows)


def report_errors(rows: list[dict[str, Any]]) -> None:
    """Print how often each reason was given, and every one that was contradicted."""
    failed = [row for row in rows if "error" in row]
    for reason, count in Counter(row["error"].split("; ")[0][-60:] for row in failed).most_common(12):
        print(f"{count:5} … {reason}")
    for row in failed:
        if row["contradiction"]:
            print(f"false: {row['kind']} {row['number']}: {row['contradiction']}\n       {row['error']}")


if __name__ == "__main__":
    main()
