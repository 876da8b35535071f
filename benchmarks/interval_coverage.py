"""How often 95 % intervals hold the truth when model, geometry or recording are wrong, and how wide they are.

    python benchmarks/interval_coverage.py --out found.csv                 10 animals of every row; an hour or more
    python benchmarks/interval_coverage.py --out found.csv --method fit --animals 40      minutes: no posterior
    python benchmarks/interval_coverage.py --out found.csv --docs          tables of what is in the file, in the docs

Every animal is drawn, simulated with the solver, disturbed as its row says, and given smooth noise of 0.4 mmHg (its
spectrum is not of the family that is assumed) and white noise of 0.03 mmHg. Then it is analyzed twice with default
settings: by the fit with its interval (two starts), and by the posterior (150 draws). Each animal is a line in the file
as soon as it is done; a run that was stopped goes on where it was.
"""

import argparse
import csv
import warnings
import zlib
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pandas as pd

from robustness_page import put
from vasowave.animal.quantities import derived as quantities_of
from vasowave.animal.quantities import errors_of, model_of
from vasowave.calibration import Search, calibrate
from vasowave.datasets import control_network
from vasowave.datasets.raw import Disturbances, synthetic_raw_recording
from vasowave.datasets.virtual import ejection
from vasowave.errors import VasowaveWarning
from vasowave.inference import posterior
from vasowave.inference.derived import derived
from vasowave.model import Model
from vasowave.network import Network
from vasowave.nominal import windkessels
from vasowave.recording import Inflow, Recording, average_beats
from vasowave.solver import Numerics, simulate
from vasowave.walls import LinearWall, TangentWall

SAMPLES, NOISE, WHITE = 512, 0.4, 0.03
LASTS, DRIFT = 12.0, 2.0  # s, mmHg
METHODS = ("fit", "posterior")
QUANTITIES = ("wave_speed", "R_T", "a", "C_p")


class Row(NamedTuple):
    """Truth, fitted law, what is wrong, what is said of it, and the row whose animals it takes, if not its own."""

    truth: str
    fitted: str
    wrong: str
    said: str
    animals: str = ""


GEOMETRY = "radii 5 % in common and 5 % each, lengths 5 % wrong"
ROWS = {
    "linear": Row("linear", "linear", "nothing", "linear → linear"),
    "geometry": Row("linear", "linear", "geometry", f"linear, {GEOMETRY} → linear"),
    "stiffening": Row("linear", "linear", "stiffening", "linear, stiffness ∝ r^-0.7 → linear"),
    "tangent": Row("tangent", "tangent", "nothing", "tangent → tangent"),
    "linear as tangent": Row("linear", "tangent", "nothing", "linear → tangent"),
    "tangent as linear": Row("tangent", "linear", "nothing", "tangent → linear"),
    "taper": Row("linear", "linear", "taper", "linear, vessels taper by 20 % → linear"),
    "drift": Row("linear", "linear", "offset", "linear, zero 1 mmHg off and nobody knows → linear"),
    "drift seen": Row("linear", "linear", "drift", "linear, 2 mmHg of drift left in, seen in the beats → linear"),
    "linear again": Row("linear", "linear", "nothing", "linear → linear, other animals", "linear as tangent"),
    "tangent, linear": Row("tangent", "linear", "nothing", "tangent → linear, other animals", "tangent"),
    "geometry, tangent": Row("linear", "tangent", "geometry", f"linear, {GEOMETRY} → tangent", "geometry"),
    "stiffening, tangent": Row("linear", "tangent", "stiffening", "linear, stiffness ∝ r^-0.7 → tangent", "stiffening"),
    "taper, tangent": Row("linear", "tangent", "taper", "linear, vessels taper by 20 % → tangent", "taper"),
}
"""Every row of the tables."""

LEAST = 0.90  # share of intervals that hold the truth, below which an entry is marked
PAGE = Path(__file__).parents[1] / "docs" / "coverage.md"

FIELDS = (
    "row", "animal", "method", "quantity", "truth", "low", "middle", "high", "k_hat", "simulations", "log_evidence",
)  # fmt: skip


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
    law, fitted, wrong, _, others = ROWS[row]
    rng = np.random.default_rng([zlib.crc32((others or row).encode()), number])
    model, inflow = truth_of(law, wrong, rng), heart(rng)
    waves = simulate(model, inflow, Numerics(samples=SAMPLES))["pressure"].to_numpy()
    pressure = waves[:, model.network.root, 0] + NOISE * smooth_noise(rng) + WHITE * rng.standard_normal(SAMPLES)
    if wrong == "offset":  # as of 2 mmHg of drift in the beats behind an averaged cycle
        pressure = pressure + rng.choice([-1.0, 1.0])
    recording = Recording(pressure, inflow.flow, inflow.period)
    return (with_drift(recording, rng) if wrong == "drift" else recording), model, fitted


def with_drift(cycle, rng):
    """Return the average of beats from a recording whose pressure drifts by 2 mmHg, its zero right at the start."""
    fall = rng.choice([-DRIFT, DRIFT]) / LASTS
    usual = Disturbances(pressure_drift=60.0 * fall)  # mmHg/min
    raw = synthetic_raw_recording(cycle, rng, duration=LASTS, disturbances=usual).raw
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", VasowaveWarning)  # that it drifts
        return average_beats(raw, drift="warn").recording


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
    rows = {"fit": (classic, np.nan, int(fit.starts["simulations"].sum()), np.nan)}
    if "posterior" in methods:
        bayes, diagnostics = by_posterior(network, recording, wall, fit, draws)
        rows["posterior"] = (bayes, diagnostics.k_hat, diagnostics.simulations, diagnostics.log_evidence)
    for method in methods:
        found, *rest = rows[method]
        for name in QUANTITIES:
            yield [row, number, method, name, truth[name], *found[name], *rest]


def entry(group):
    """Return how many intervals hold the truth, their median half width, and the one that all would need, %."""
    inside = int(((group["low"] <= group["truth"]) & (group["truth"] <= group["high"])).sum())
    half = 50 * np.log(group["high"] / group["low"]).median()
    needed = 100 * np.quantile(np.abs(np.log(group["middle"] / group["truth"])), 0.95)
    missing = "**" if inside < LEAST * len(group) else ""
    return f"{missing}{inside}{missing} ({half:.0f}; {needed:.0f})"


def table(path, method):
    """Return the table of one method."""
    data = pd.read_csv(path)
    data = data[data["method"] == method]
    lines = [f"| truth → fitted | animals | {' | '.join(QUANTITIES)} |", "|---|---|" + "---|" * len(QUANTITIES)]
    for row in [row for row in ROWS if row in set(data["row"])]:
        one = data[data["row"] == row]
        cells = [entry(one[one["quantity"] == name]) for name in QUANTITIES]
        lines.append(f"| {ROWS[row].said} | {one['animal'].nunique()} | {' | '.join(cells)} |")
    return "\n".join(lines)


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
    parser.add_argument("--docs", action="store_true", help="compute nothing; put the tables into docs/coverage.md")
    chosen = parser.parse_args()
    for row, number, methods in [] if chosen.docs else work(chosen):
        found = list(lines(row, number, methods, chosen.draws))
        with chosen.out.open("a", newline="") as file:
            csv.writer(file).writerows(found)
        print(row, number, *(f"{x[2]} {x[3]} {x[4]:.3g} in [{x[5]:.3g}, {x[7]:.3g}]" for x in found[::4]), flush=True)
    for method in METHODS:
        print(table(chosen.out, method))
        if chosen.docs:
            put(method, table(chosen.out, method), PAGE)


if __name__ == "__main__":
    main()
