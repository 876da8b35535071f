"""How often 95 % intervals hold the truth when model, geometry or recording are wrong, and how wide they are.

    uv run python benchmarks/coverage.py --out coverage.csv             10 animals of every row; an hour or more
    uv run python benchmarks/coverage.py --out coverage.csv --animals 2 --rows linear   a quick look
    uv run python benchmarks/coverage.py --out coverage.csv --table     the table of what is in the file

Every animal is drawn, simulated with the solver, disturbed as its row says, and given smooth noise of 0.4 mmHg (its
spectrum is not of the family that the posterior assumes) and white noise of 0.03 mmHg. Then it is analyzed twice with
default settings: by the fit with its interval, and by the posterior. Each animal is a line in the file as soon as it is
done; a run that was stopped goes on where it was.
"""

import argparse
import csv
import zlib
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd

from vasowave.animal.quantities import derived as quantities_of
from vasowave.animal.quantities import errors_of, model_of
from vasowave.calibration import Search, calibrate
from vasowave.datasets import control_network
from vasowave.datasets.virtual import ejection
from vasowave.inference import posterior
from vasowave.inference.derived import derived
from vasowave.model import Model
from vasowave.network import Network
from vasowave.nominal import windkessels
from vasowave.recording import Inflow, Recording
from vasowave.solver import Numerics, simulate
from vasowave.walls import LinearWall, TangentWall

SAMPLES, NOISE, WHITE = 512, 0.4, 0.03
METHODS = ("fit", "posterior")
QUANTITIES = ("wave_speed", "R_T", "a", "C_p")
ROWS = {
    "linear": ("linear", "linear", "nothing"),
    "geometry": ("linear", "linear", "geometry"),
    "stiffening": ("linear", "linear", "stiffening"),
    "tangent": ("tangent", "tangent", "nothing"),
    "linear as tangent": ("linear", "tangent", "nothing"),
    "tangent as linear": ("tangent", "linear", "nothing"),
    "taper": ("linear", "linear", "taper"),
    "drift": ("linear", "linear", "drift"),
}
"""Truth, fitted law, and what is wrong."""

FIELDS = ("row", "animal", "method", "quantity", "truth", "low", "middle", "high", "k_hat", "simulations")


def heart(rng):
    """Return an inflow that varies from animal to animal."""
    shape = ejection(SAMPLES, 0.40 + 0.015 * rng.standard_normal(), 0.70 + 0.05 * rng.standard_normal()).flow
    output = 0.18 * np.exp(0.1 * rng.standard_normal())
    return Inflow(output * shape / shape.mean(), 0.11 * np.exp(0.08 * rng.standard_normal()))


def wall_of(law, rng):
    first, second = rng.standard_normal(2)
    if law == "linear":
        return LinearWall(57.0 * np.exp(0.3 * first))
    return TangentWall(7.0 * np.exp(0.3 * first), 4.0 * np.exp(0.2 * second))


def wrong_sizes(network, rng):
    """Radii 5 % in common and 5 % each, lengths 5 % each."""
    radius = np.exp(0.05 * rng.standard_normal() + 0.05 * rng.standard_normal(len(network)))
    length = np.exp(0.05 * rng.standard_normal(len(network)))
    return replace(network, radius=network.radius * radius, length=network.length * length)


def tapered(network, pieces=4, fall=0.2):
    """Return the network with every vessel cut into pieces, whose radii fall by 20 % from inlet to outlet."""
    factor = 1 + fall * (0.5 - (np.arange(pieces) + 0.5) / pieces)
    names = tuple(f"{name} {i}" for name in network.name for i in range(pieces))
    first = np.arange(len(network)) * pieces
    parent = np.repeat(first, pieces) + np.tile(np.arange(pieces), len(network)) - 1
    parent[first] = np.where(network.parent >= 0, first[network.parent] + pieces - 1, -1)
    radius = np.repeat(network.radius, pieces) * np.tile(factor, len(network))
    return Network(names, parent, np.repeat(network.length / pieces, pieces), radius)


def truth_of(law, wrong, rng):
    """Return the true model; the image shows the control network."""
    image = control_network()
    network = {"geometry": lambda: wrong_sizes(image, rng), "taper": lambda: tapered(image)}.get(wrong, lambda: image)()
    wall = wall_of(law, rng)
    if wrong == "stiffening":
        wall = LinearWall(wall.beta * (network.radius / network.radius[network.root]) ** -0.7)
    R_T, tau = 76.0 * np.exp(0.15 * rng.standard_normal()), 0.12 * np.exp(0.15 * rng.standard_normal())
    shared = image if wrong == "taper" else network
    return Model(network, wall, windkessels(shared, R_T, tau, rng.uniform(0.06, 0.25)))


def smooth_noise(rng):
    """One period of noise of variance 1 whose power falls exponentially with the harmonic, to 1/e over two."""
    amplitude = np.exp(-0.25 * np.arange(SAMPLES // 2 + 1))
    whole = np.fft.irfft(np.fft.rfft(rng.standard_normal(SAMPLES)) * amplitude, SAMPLES)
    return whole / np.sqrt((amplitude[0] ** 2 + 2 * np.sum(amplitude[1:-1] ** 2) + amplitude[-1] ** 2) / SAMPLES)


def animal(row, number):
    """Return the recording of an animal, its true model, and the law to fit."""
    law, fitted, wrong = ROWS[row]
    rng = np.random.default_rng([zlib.crc32(row.encode()), number])
    model, inflow = truth_of(law, wrong, rng), heart(rng)
    waves = simulate(model, inflow, Numerics(samples=SAMPLES))["pressure"].to_numpy()
    pressure = waves[:, model.network.root, 0] + NOISE * smooth_noise(rng) + WHITE * rng.standard_normal(SAMPLES)
    if wrong == "drift":  # 2 mmHg over the recording: the average of its beats stands 1 mmHg off
        pressure = pressure + rng.choice([-1.0, 1.0])
    return Recording(pressure, inflow.flow, inflow.period), model, fitted


def by_fit(network, recording, wall):
    """Return low, middle, high of every quantity as the fit reports them, and the fit."""
    fit = calibrate(network, recording, wall, search=Search(starts=2))
    mean, diastolic = recording.mean_pressure, np.full(len(network), recording.diastolic_pressure)

    def derive(values):
        return quantities_of(model_of(fit, values), values, diastolic, mean)

    middle, errors = derive(fit.parameters["value"].to_dict()), errors_of(fit, derive)
    reach = {name: np.exp(min(errors[name][1], 200.0)) for name in QUANTITIES}
    return {name: (middle[name] / reach[name], middle[name], middle[name] * reach[name]) for name in QUANTITIES}, fit


def by_posterior(network, recording, wall, fit, draws):
    found = posterior(network, recording, wall, fit=fit, draws=draws)
    columns = ["interval_low", "median", "interval_high"]
    return {name: tuple(found.summary.loc[name, columns]) for name in QUANTITIES}, found.diagnostics


def lines(row, number, methods, draws):
    """Analyze one animal by the methods asked for; yield the lines of the file."""
    recording, model, wall = animal(row, number)
    network, truth = control_network(), derived(model, recording.mean_pressure)
    classic, fit = by_fit(network, recording, wall)
    rows = {"fit": (classic, np.nan, int(fit.starts["simulations"].sum()))}
    if "posterior" in methods:
        bayes, diagnostics = by_posterior(network, recording, wall, fit, draws)
        rows["posterior"] = (bayes, diagnostics.k_hat, diagnostics.simulations)
    for method in methods:
        found, k, count = rows[method]
        for name in QUANTITIES:
            yield [row, number, method, name, truth[name], *found[name], k, count]


def table(path):
    """Return coverage, median half width (%) and 1.96 times the root-mean-square error of the middle (%)."""
    data = pd.read_csv(path)
    data["inside"] = (data["low"] <= data["truth"]) & (data["truth"] <= data["high"])
    data["half"] = 50 * np.log(data["high"] / data["low"])
    data["square"] = np.log(data["middle"] / data["truth"]) ** 2
    grouped = data.groupby(["row", "method", "quantity"], sort=False)
    found = grouped.agg(
        inside=("inside", "sum"), of=("inside", "size"), half=("half", "median"), square=("square", "mean"),
        k_hat=("k_hat", "max"),
    )  # fmt: skip
    found["needed"] = 196 * np.sqrt(found.pop("square"))
    return found.round({"half": 1, "needed": 1, "k_hat": 2}).reset_index()


def done(path):
    """Return row, animal and method of all that stands in the file."""
    if not path.exists():
        with path.open("w", newline="") as file:
            csv.writer(file).writerow(FIELDS)
    data = pd.read_csv(path)
    return set(data[["row", "animal", "method"]].itertuples(index=False, name=None))


def work(chosen):
    """Yield row, number and methods of the animals that are not in the file yet, every row's first animal first."""
    finished = done(chosen.out)
    for number in range(chosen.first, chosen.first + chosen.animals):
        for row in chosen.rows:
            methods = [one for one in chosen.method if (row, number, one) not in finished]
            if methods:
                yield row, number, methods


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=Path, required=True, help="file of results, one line a quantity")
    parser.add_argument("--animals", type=int, default=10, help="of every row")
    parser.add_argument("--first", type=int, default=0, help="number of the first animal")
    parser.add_argument("--rows", nargs="*", default=list(ROWS), choices=list(ROWS))
    parser.add_argument("--method", nargs="*", default=list(METHODS), choices=list(METHODS))
    parser.add_argument("--draws", type=int, default=150, help="draws of each posterior")
    parser.add_argument("--table", action="store_true", help="print the table and compute nothing")
    chosen = parser.parse_args()
    for row, number, methods in [] if chosen.table else work(chosen):
        found = list(lines(row, number, methods, chosen.draws))
        with chosen.out.open("a", newline="") as file:
            csv.writer(file).writerows(found)
        print(row, number, *(f"{x[2]} {x[3]} {x[4]:.3g} in [{x[5]:.3g}, {x[7]:.3g}]" for x in found[::4]), flush=True)
    with pd.option_context("display.width", 200, "display.max_rows", 200):
        print(table(chosen.out))


if __name__ == "__main__":
    main()
