"""How often intervals hold the truth where image, probe, transducer, blood or wall is not what is assumed.

    python benchmarks/known_errors.py --out found.csv --animals 200 --posteriors 40 --errors flow_gain
    python benchmarks/known_errors.py --out found.csv --animals 40        all errors, fits alone: 2 s of CPU each
    python benchmarks/known_errors.py --out found.csv --animals 0 --docs  the table into docs/coverage.md

Trees of seven vessels with linear walls. Walls, radii, lengths, beds, output and heart rate vary; the pressure has the
noise of `known_animals`. One thing is not what is assumed, by as much as its SD says; it is told to the program, or
not. What is wrong is made here by hand, not by the program's own description of errors. Each animal is some lines in
the file as soon as it is done.
"""

import argparse
import csv
import warnings
from itertools import product
from pathlib import Path

import numpy as np
import pandas as pd

from known_animals import NOISE, SAMPLES, WHITE, heart, smooth_noise
from posterior_modes import tree
from robustness_page import put
from vasowave.base import VasowaveWarning
from vasowave.pulse import derived
from vasowave.pulse.cycle import Recording
from vasowave.pulse.inference import Priors, columns, posterior
from vasowave.pulse.model import Blood, LinearWall, Model, Numerics, windkessels
from vasowave.pulse.solver import simulate
from vasowave.study.animal import Animal, Settings, analyze

ERRORS = {
    "flow_gain": 0.07, "flow_delay": 0.002, "zero": 1.0, "radius_scale": 0.05, "length_scale": 0.05,
    "image_pressure": 0.3, "viscosity": 0.15, "k": 0.5, "pressure_lag": 0.003,
}  # fmt: skip
"""SD of what is wrong: of a logarithm, but for delay and lag (s), the zero (mmHg) and the exponent k."""
IMAGED = 6.0  # mmHg, at which the image is said to have been taken where that is in doubt
PAGE = Path(__file__).parents[1] / "docs" / "coverage.md"
NAMES = ("R_T", "wave_speed")
FIELDS = ("animal", "error", "score", "way", "told", "quantity", "truth", "low", "high")


def animal(number, error):
    """Return the network and the recording as they are seen, how many SD the error is, the truth and its mean."""
    rng = np.random.default_rng([28, number])
    network, inflow = tree(rng), heart(rng)
    beta = 57.0 * np.exp(0.3 * rng.standard_normal())
    R_T, tau = 76.0 * np.exp(0.2 * rng.standard_normal()), 0.12 * np.exp(0.2 * rng.standard_normal())
    ratio, noise = rng.uniform(0.06, 0.25), NOISE * smooth_noise(rng) + WHITE * rng.standard_normal(SAMPLES)
    score = rng.standard_normal()
    size = ERRORS[error] * score
    factor = np.exp(size)
    seen = network.resized(pressure=IMAGED) if error == "image_pressure" else network
    true = {
        "radius_scale": network.resized(radius=network.radius * factor),
        "length_scale": network.resized(length=network.length * factor),
        "image_pressure": network.resized(pressure=IMAGED * factor),
    }.get(error, network)
    exponent = size if error == "k" else 0.0
    wall = LinearWall(beta * (network.radius / network.radius[network.root]) ** -exponent)
    blood = Blood(viscosity=Blood().viscosity * (factor if error == "viscosity" else 1.0))
    model = Model(true, wall, windkessels(true, R_T, tau, ratio), blood)
    waves = simulate(model, inflow, Numerics(samples=SAMPLES))["pressure"].to_numpy()
    pressure, flow = waves[:, network.root, 0] + noise, inflow.flow
    mean = float(pressure.mean())
    if error == "flow_gain":
        flow = flow * factor
    elif error == "flow_delay":  # what is recorded now was so a while ago
        time = np.arange(len(flow)) * inflow.period / len(flow)
        flow = np.interp(time - size, time, flow, period=inflow.period)
    elif error == "zero":
        pressure = pressure + size
    elif error == "pressure_lag":  # which no filter makes shorter
        frequency = np.fft.rfftfreq(SAMPLES, inflow.period / SAMPLES)
        pressure = np.fft.irfft(np.fft.rfft(pressure) / (1 + 2j * np.pi * frequency * abs(size)), SAMPLES)
    return seen, Recording(pressure, flow, inflow.period), score, model, mean


def lines(number, error, posteriors):
    """Analyze one animal; return its lines of the file."""
    network, recording, score, model, mean = animal(number, error)
    truth, found = derived(model, mean), []
    for told in (False, True):
        how = dict.fromkeys(columns(), 0.0) | ({f"{error}_sd": ERRORS[error]} if told else {})
        settings = Settings(walls=("linear",), starts=3, model_selection=False, **how)
        result = analyze(Animal("mouse", "CTL", network, recording), settings)
        rows = {name: result.laws["linear"].quantities[name].attrs for name in NAMES}
        ways = {"fit": rows}
        if posteriors:
            priors = Priors(radius=0, length=0, **how | ({} if how["zero_sd"] else {"zero_sd": None}))
            ways["posterior"] = posterior(network, recording, priors=priors, draws=200, workers=1).summary.T
        for way, each in ways.items():
            for name in NAMES:
                ends = each[name]
                low, high = ends["interval_low"], ends["interval_high"]
                found.append([number, error, score, way, told, name, truth[name], low, high])
    return found


def table(path):
    """Return the table of what is in the file."""
    data = pd.read_csv(path)
    data["held"] = data["truth"].between(data["low"], data["high"])
    data["half"] = 50 * np.log(data["high"] / data["low"])
    rows = ["| what is wrong, by | analyzed | animals | R_T held | half width, % | wave speed held | half width, % |",
            "|---|---|---|---|---|---|---|"]  # fmt: skip
    data["place"] = data["error"].map(list(ERRORS).index)
    for (_, way, told), part in data.groupby(["place", "way", "told"]):
        error = part["error"].iloc[0]
        said = "told" if told else "not told"
        cells = [f"{one['held'].mean():.3f} | {one['half'].median():.0f}"
                 for one in (part[part["quantity"] == name] for name in NAMES)]  # fmt: skip
        wrong = f"`{error}_sd`: {ERRORS[error]:g}"
        rows.append(f"| {wrong} | {way}, {said} | {part['animal'].nunique()} | {' | '.join(cells)} |")
    return "\n".join(rows)


def main():
    """Analyze animals, then print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--animals", type=int, default=200)
    parser.add_argument("--posteriors", type=int, default=0, help="so many have posteriors, too")
    parser.add_argument("--errors", nargs="*", default=list(ERRORS), choices=ERRORS)
    parser.add_argument("--docs", action="store_true")
    options = parser.parse_args()
    warnings.simplefilter("ignore", VasowaveWarning)
    if not options.out.exists():
        options.out.write_text(",".join(FIELDS) + "\n", encoding="utf-8")
    done = set(pd.read_csv(options.out)[["animal", "error"]].itertuples(index=False, name=None))
    for number, error in product(range(options.animals), options.errors):
        if (number, error) not in done:
            found = lines(number, error, number < options.posteriors)
            with options.out.open("a", newline="", encoding="utf-8") as file:
                csv.writer(file).writerows(found)
    print(text := table(options.out))
    if options.docs:
        put("known errors", text, PAGE)


if __name__ == "__main__":
    main()
