"""Does R_T hold where the gain of the flow probe is 7 % wrong? Trees of seven vessels with linear walls.

    python benchmarks/known_errors.py --out found.csv --animals 200 --posteriors 40      about 1 and 8 s of CPU each
    python benchmarks/known_errors.py --out found.csv --animals 0 --docs                 the table into docs/coverage.md

Walls, radii, lengths, beds, output and heart rate vary; the recorded flow is the true one times a gain that varies by
7 % (SD), the pressure has the noise of `known_animals`. Each animal is a line in the file as soon as it is done.
"""

import argparse
import csv
import warnings
from pathlib import Path

import numpy as np
import pandas as pd

from known_animals import NOISE, SAMPLES, WHITE, heart, smooth_noise
from posterior_modes import tree
from robustness_page import put
from vasowave.animal.animal import Animal, Settings
from vasowave.animal.pipeline import analyze
from vasowave.errors import VasowaveWarning
from vasowave.inference import Priors, posterior
from vasowave.model.model import Model
from vasowave.model.nominal import windkessels
from vasowave.model.walls import LinearWall
from vasowave.quantities import derived
from vasowave.recording import Recording
from vasowave.solver import Numerics, simulate

GAIN = 0.07
PAGE = Path(__file__).parents[1] / "docs" / "coverage.md"
NAMES = ("R_T", "wave_speed")
FIELDS = ("animal", "gain", "way", "told", "quantity", "truth", "low", "high")


def animal(number):
    """Return the network, the recording with its gain, the gain, and the true model."""
    rng = np.random.default_rng([28, number])
    network, inflow = tree(rng), heart(rng)
    wall = LinearWall(57.0 * np.exp(0.3 * rng.standard_normal()))
    R_T, tau = 76.0 * np.exp(0.2 * rng.standard_normal()), 0.12 * np.exp(0.2 * rng.standard_normal())
    model = Model(network, wall, windkessels(network, R_T, tau, rng.uniform(0.06, 0.25)))
    waves = simulate(model, inflow, Numerics(samples=SAMPLES))["pressure"].to_numpy()
    pressure = waves[:, network.root, 0] + NOISE * smooth_noise(rng) + WHITE * rng.standard_normal(SAMPLES)
    gain = float(np.exp(GAIN * rng.standard_normal()))
    return network, Recording(pressure, inflow.flow * gain, inflow.period), gain, model


def lines(number, posteriors):
    """Analyze one animal; return its lines of the file."""
    network, recording, gain, model = animal(number)
    truth, found = derived(model, recording.mean_pressure), []
    for told in (False, True):
        how = {"flow_gain_sd": GAIN} if told else {}
        settings = Settings(walls=("linear",), starts=3, model_selection=False, **how)
        result = analyze(Animal("mouse", "CTL", network, recording), settings)
        for name in NAMES:
            ends = result.laws["linear"].quantities[name].attrs
            found.append([number, gain, "fit", told, name, truth[name], ends["interval_low"], ends["interval_high"]])
        if posteriors:
            priors = Priors(radius=0, length=0, radius_scale_sd=0, length_scale_sd=0, k_sd=0, **how)
            drawn = posterior(network, recording, "linear", priors=priors, draws=200, workers=1)
            for name in NAMES:
                ends = drawn.summary.loc[name]
                low, high = ends["interval_low"], ends["interval_high"]
                found.append([number, gain, "posterior", told, name, truth[name], low, high])
    return found


def table(path):
    """Return the table of what is in the file."""
    data = pd.read_csv(path)
    data["held"] = data["truth"].between(data["low"], data["high"])
    data["half"] = 50 * np.log(data["high"] / data["low"])
    rows = ["| gain of the probe 7 % wrong | animals | R_T held | half width, % | wave speed held | half width, % |",
            "|---|---|---|---|---|---|"]  # fmt: skip
    for (way, told), part in data.groupby(["way", "told"]):
        said = "told (`flow_gain_sd: 0.07`)" if told else "not told"
        cells = [f"{one['held'].mean():.3f} | {one['half'].median():.0f}"
                 for one in (part[part["quantity"] == name] for name in NAMES)]  # fmt: skip
        rows.append(f"| {way}, {said} | {part['animal'].nunique()} | {' | '.join(cells)} |")
    return "\n".join(rows)


def main():
    """Analyze animals, then print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--animals", type=int, default=200)
    parser.add_argument("--posteriors", type=int, default=40, help="the first ones have posteriors, too")
    parser.add_argument("--docs", action="store_true")
    options = parser.parse_args()
    warnings.simplefilter("ignore", VasowaveWarning)
    if not options.out.exists():
        options.out.write_text(",".join(FIELDS) + "\n", encoding="utf-8")
    done = set(pd.read_csv(options.out)["animal"])
    for number in range(options.animals):
        if number not in done:
            found = lines(number, number < options.posteriors)
            with options.out.open("a", newline="", encoding="utf-8") as file:
                csv.writer(file).writerows(found)
    print(text := table(options.out))
    if options.docs:
        put("known errors", text, PAGE)


if __name__ == "__main__":
    main()
