"""How often refitted cohorts without any effect show one, where every animal has a lung and each group one image.

    python benchmarks/null_cohorts.py --out found.csv --cohorts 60 [--sizes 7 5] [--lungs 0.1]
    python benchmarks/null_cohorts.py --out found.csv --cohorts 0 --docs     the table into docs/comparisons.md

All animals are of one population: the control network with walls, beds, output and heart rate that vary. Every animal
has a lung of its own, whose radii all differ from the mean lung's by a factor (SD `--lungs`); the image of a group is
of one more lung, and 5 % wrong. Each animal is fitted with the image of its group, and told the usual errors; the
groups are compared as a study's are. Each cohort is some lines in the file as soon as it is done.
"""

import argparse
import csv
import warnings
from pathlib import Path

import numpy as np
import pandas as pd

from false_positives import header
from known_animals import NOISE, SAMPLES, WHITE, heart, smooth_noise
from robustness_page import put
from vasowave.base import VasowaveWarning
from vasowave.pulse.cycle import Recording
from vasowave.pulse.examples import control_network
from vasowave.pulse.model import LinearWall, Model, Numerics, windkessels
from vasowave.pulse.solver import simulate
from vasowave.study.animal import Animal, Settings, analyze
from vasowave.study.cohort import Family, gathered, primary_comparison

PAGE = Path(__file__).parents[1] / "docs" / "comparisons.md"
USUAL = {"radius_scale_sd": 0.05, "length_scale_sd": 0.05, "k_sd": 0.5, "zero_sd": 0.5}
SETTINGS = Settings(walls=("linear",), starts=2, model_selection=False, **USUAL)
FIELDS = ("sizes", "lungs", "cohort", "told", "quantity", "source", "ratio", "p", "untested")


def recorded(rng, lungs):
    """Return the recording of an animal with a lung of its own."""
    network = control_network()
    network = network.resized(radius=network.radius * np.exp(lungs * rng.standard_normal()))
    beta, R_T, tau = (middle * np.exp(0.2 * rng.standard_normal()) for middle in (57.0, 76.0, 0.12))
    inflow = heart(rng)
    model = Model(network, LinearWall(beta), windkessels(network, R_T, tau, rng.uniform(0.08, 0.2)))
    waves = simulate(model, inflow, Numerics(samples=SAMPLES))["pressure"].to_numpy()
    noise = NOISE * smooth_noise(rng) + WHITE * rng.standard_normal(SAMPLES)
    pressure = waves[:, network.root, 0] + noise + USUAL["zero_sd"] * rng.standard_normal()
    return Recording(pressure, inflow.flow, inflow.period)


def cohort(number, sizes, lungs):
    """Return the fitted animals of one cohort without an effect."""
    results = []
    for place, (group, count) in enumerate(zip(("CTL", "HPH"), sizes, strict=True)):
        rng = np.random.default_rng([48, number, place])
        image = control_network()
        wrong = np.exp(np.hypot(lungs, USUAL["radius_scale_sd"]) * rng.standard_normal())
        longer = np.exp(USUAL["length_scale_sd"] * rng.standard_normal())
        seen = image.resized(radius=image.radius * wrong, length=image.length * longer)
        for animal in range(count):
            results.append(
                analyze(Animal(f"{group} {animal}", group, seen, recorded(rng, lungs), synthetic=True), SETTINGS)
            )
    return gathered(results)


def lines(number, sizes, lungs):
    """Return what the comparison says of a cohort whose lungs are told, and not."""
    fitted = cohort(number, sizes, lungs)
    for told in (lungs, 0.0):
        rows = primary_comparison(fitted, Family(lung_sd=told)).table()
        for row in rows.to_dict("records"):
            yield {"sizes": f"{sizes[0]} + {sizes[1]}", "lungs": lungs, "cohort": number, "told": told} | {
                name: row[name] for name in FIELDS[4:]
            }


def table(found):
    """Return false positives of the page: of all rows, of those of the model, of those that need no image."""
    text = header("refitted cohorts without an effect", ("cohorts", "any row", "of the model", "without an image"))
    for (sizes, lungs, told), part in found.groupby(["sizes", "lungs", "told"], sort=False):
        shown = part.assign(shown=part["p"] < 0.05, modeled=part["source"] != "measured")
        count = part["cohort"].nunique()
        cells = [
            one.groupby("cohort")["shown"].any().sum() / count
            for one in (shown, shown[shown["modeled"]], shown[~shown["modeled"]])
        ]
        name = f"{sizes}, lungs differ by {100 * lungs:g} %, {'told' if told else 'not told'}"
        text.append(f"| {name} | {count} | {' | '.join(f'{cell:.3f}' for cell in cells)} |")
    return "\n".join(text)


def main():
    """Append cohorts to the file, and print the table of all that are in it."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--first", type=int, default=0, help="number of the first cohort")
    parser.add_argument("--cohorts", type=int, default=60)
    parser.add_argument("--sizes", type=int, nargs=2, default=(7, 5))
    parser.add_argument("--lungs", type=float, default=0.1)
    parser.add_argument("--docs", action="store_true", help="put the table into docs/comparisons.md")
    options = parser.parse_args()
    for number in range(options.first, options.first + options.cohorts):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", VasowaveWarning)
            rows = list(lines(number, tuple(options.sizes), options.lungs))
        new = not options.out.exists()
        with options.out.open("a", newline="", encoding="utf-8") as file:
            writer = csv.DictWriter(file, FIELDS)
            if new:
                writer.writeheader()
            writer.writerows(rows)
    text = table(pd.read_csv(options.out))
    print(text)
    if options.docs:
        put("refitted", text, PAGE)


if __name__ == "__main__":
    main()
