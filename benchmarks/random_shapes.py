"""How far random shapes with points are from what far shorter cells show, and from what their runs state.

    python benchmarks/random_shapes.py FILE.csv [--count 200] [--seed 48]

Every model is a fork or a chain with two to five random points a vessel (radii 0.45 to 1.8 of the vessel's, stiffness
0.4 to 2.5), a loss or none, static or total pressure at junctions, a linear or a tangent wall, and one of five beds.
Each is a line of the file as soon as it is done; what the file holds is not run again. True errors are the largest
difference of the pressure, at any station and time, to a fifth of the cell length.
"""

import argparse
import csv
from pathlib import Path

import numpy as np
import pandas as pd

from vasowave.base import VasowaveError
from vasowave.pulse.cycle import Inflow
from vasowave.pulse.model import (
    Blood,
    CompliantBed,
    LinearWall,
    Model,
    Numerics,
    ReflectionCoefficient,
    Resistance,
    Shape,
    Site,
    StructuredTree,
    TangentWall,
    Windkessel,
    windkessels,
)
from vasowave.pulse.network import Network
from vasowave.pulse.solver import run_on_cells, run_to_periodic

FIELDS = ("number", "what", "largest", "true", "stated", "ended")
FINER = 5


def ejection(rng):
    """Return a flow whose mean is 0.1 ml/s, ejected within a random part of a random cycle."""
    t, width = np.arange(256) / 256, rng.uniform(0.07, 0.13)
    flow = np.exp(-0.5 * ((t - 0.3) / width) ** 2)
    return Inflow(0.1 * flow / flow.mean(), rng.uniform(0.09, 0.15))


def beds_of(rng, network, stiffness):
    """Return beds of a random kind that take 46 to 122 mmHg s/ml, and what they are called."""
    total, tau, a = 76.0 * rng.uniform(0.6, 1.6), rng.uniform(0.06, 0.2), rng.uniform(0.05, 0.3)
    kind = [Windkessel, CompliantBed, Resistance, ReflectionCoefficient, StructuredTree][rng.integers(5)]
    if kind is Windkessel:
        return windkessels(network, total, tau, a), kind.__name__
    return kind.of(network, Site(total, tau, stiffness, Blood())), kind.__name__


def drawn(number, seed):
    """Return the model and the inflow of a number, and what they are in words."""
    rng = np.random.default_rng([seed, number])
    parents = [-1, 0, 0] if rng.random() < 0.6 else [-1, 0, 1]
    length, radius = rng.uniform(0.25, 0.6, 3), np.array([0.047, 0.036, 0.033]) * rng.uniform(0.85, 1.15, 3)
    network = Network(("a", "b", "c"), parents, length, radius)
    points = int(rng.integers(2, 6))
    radius, factors = (np.exp(rng.uniform(*np.log(ends), (3, points))) for ends in ((0.45, 1.8), (0.4, 2.5)))
    shape = Shape(radius, factors if rng.random() < 0.5 else 1.0)
    stiffness = rng.uniform(40, 120)
    wall = LinearWall(stiffness) if rng.random() < 0.6 else TangentWall(stiffness / 3, 2.0)
    junctions, loss = str(rng.choice(["static", "total"])), float(rng.choice([0.0, rng.uniform(0.1, 1.0)]))
    beds, name = beds_of(rng, network, stiffness)
    what = f"{points} points, {type(wall).__name__}, {junctions}, loss {loss:.2g}, {name}"
    return Model(network, wall, beds, shape=shape, junctions=junctions, loss=loss), ejection(rng), what


def line(number, seed):
    """Return what came of the model of a number."""
    try:
        model, inflow, what = drawn(number, seed)
    except VasowaveError as error:
        return {"number": number, "what": "", "ended": f"no model: {error}"}
    try:
        run = run_to_periodic(model, inflow, Numerics())
        fine = run_on_cells(model, inflow, Numerics(tolerance=1e-5), FINER * run.grid.counts)
    except VasowaveError as error:
        return {"number": number, "what": what, "ended": str(error).splitlines()[0][:150]}
    true = float(np.max(np.abs(run.pressure - fine.pressure)))
    stated = run.extremes.grid_error.value
    return {"number": number, "what": what, "largest": run.largest_pressure, "true": true, "stated": stated}


def main():
    """Append models to the file, and print what all that are in it came to."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("file", type=Path)
    parser.add_argument("--count", type=int, default=200)
    parser.add_argument("--seed", type=int, default=48)
    options = parser.parse_args()
    known = {int(row["number"]) for row in csv.DictReader(options.file.open())} if options.file.exists() else set()
    with options.file.open("a", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, FIELDS)
        if not known:
            writer.writeheader()
        for number in range(options.count):
            if number not in known:
                writer.writerow(line(number, options.seed))
                file.flush()
    found = pd.read_csv(options.file)
    ran = found[found["ended"].isna()]
    ratio, share = ran["true"] / ran["stated"], ran["true"] / ran["largest"]
    print(f"{len(ran)} of {len(found)} ran; the others:", found["ended"].dropna().str[:60].value_counts().to_dict())
    print(f"true over stated {ratio.min():.2f} to {ratio.max():.2f}, above 3: {(ratio > 3).sum()}")
    print(f"largest true error {100 * share.max():.2f} % of the largest pressure; above 1 %: {(share > 0.01).sum()}")


if __name__ == "__main__":
    main()
