"""How often a fit's intervals hold the truth, and how much wider than needed they are, where the image is wrong.

    python benchmarks/untold_geometry.py --out found.csv --animals 40     fits alone: 3 s of CPU each

Trees of seven vessels with linear walls, as in `known_errors`. Radii and lengths are 4 % wrong (SD of the logarithm),
all vessels' alike (common) or each vessel's own (each), and every vessel falls by 12 % of its radius from inlet to
outlet, which nobody tells. The lab says nothing (default), or says that wall and instruments are exact (instruments),
which in these animals they are: what is left are the usual errors of an image.
"""

import argparse
import csv
import warnings
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd

from known_animals import NOISE, SAMPLES, WHITE, heart, smooth_noise
from posterior_modes import tree
from vasowave.base import VasowaveWarning
from vasowave.pulse import derived
from vasowave.pulse.calibration import calibrate
from vasowave.pulse.cycle import Recording
from vasowave.pulse.inference import columns
from vasowave.pulse.model import LinearWall, Model, Numerics, Shape, windkessels
from vasowave.pulse.solver import simulate
from vasowave.study.animal import Animal, Settings, result_of

WRONG, FALL = 0.04, 0.12
KINDS = ("common", "each")
NAMES = ("R_T", "wave_speed")
TOLD = {
    "nothing": dict.fromkeys(columns(), 0.0),
    "default": {},
    "instruments": {"k_sd": 0.0, "flow_gain_sd": 0.0, "zero_sd": 0.0},
}  # fmt: skip
"""What the lab tells; with nothing left to be wrong intervals are those of the recording alone."""
FIELDS = ("animal", "kind", "told", "quantity", "truth", "value", "low", "high")


def animal(number, kind):
    """Return the network as the image shows it, the recording, the true model and the true mean pressure."""
    rng = np.random.default_rng([49, KINDS.index(kind), number])
    seen, inflow = tree(rng), heart(rng)
    beta = 57.0 * np.exp(0.3 * rng.standard_normal())
    R_T, tau = 76.0 * np.exp(0.2 * rng.standard_normal()), 0.12 * np.exp(0.2 * rng.standard_normal())
    ratio, noise = rng.uniform(0.06, 0.25), NOISE * smooth_noise(rng) + WHITE * rng.standard_normal(SAMPLES)
    count = len(seen) if kind == "each" else 1
    true = seen.resized(
        radius=seen.radius * np.exp(WRONG * rng.standard_normal(count)),
        length=seen.length * np.exp(WRONG * rng.standard_normal(count)),
    )
    model = Model(
        true, LinearWall(beta), windkessels(true, R_T, tau, ratio), shape=Shape.falling(np.full(len(true), FALL))
    )
    waves = simulate(model, inflow, Numerics(samples=SAMPLES))["pressure"].to_numpy()
    recording = Recording(waves[:, true.root, 0] + noise, inflow.flow, inflow.period)
    return seen, recording, model


def lines(number, kind):
    """Analyze one animal; return its lines of the file."""
    network, recording, model = animal(number, kind)
    truth, found = derived(model, recording.mean_pressure), []
    fit = calibrate(network, recording, "linear", starts=3)
    mouse, plain = (
        Animal("mouse", "CTL", network, recording),
        Settings(walls=("linear",), starts=3, model_selection=False),
    )
    for told, errors in TOLD.items():
        quantities = result_of(mouse, [fit], replace(plain, **errors)).laws["linear"].quantities
        for name in NAMES:
            one = quantities[name]
            ends = one.attrs["interval_low"], one.attrs["interval_high"]
            found.append([number, kind, told, name, truth[name], float(one), *ends])
    return found


def table(path):
    """Return the table of what is in the file."""
    data = pd.read_csv(path)
    data["held"] = data["truth"].between(data["low"], data["high"])
    data["half"] = np.log(data["high"] / data["low"]) / 2
    data["off"] = np.log(data["value"] / data["truth"])
    rows = ["| errors of | told | quantity | animals | held | off, r.m.s. % | half width, % | over what is needed |",
            "|---|---|---|---|---|---|---|---|"]  # fmt: skip
    for (kind, told, name), part in data.groupby(["kind", "told", "quantity"], sort=False):
        off, half = np.sqrt((part["off"] ** 2).mean()), part["half"].median()
        cells = kind, told, name, len(part), part["held"].sum(), f"{100 * off:.1f}", f"{100 * half:.1f}"
        rows.append(f"| {' | '.join(map(str, cells))} | {half / (1.96 * off):.2f} |")
    return "\n".join(rows)


def main():
    """Analyze animals, then print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--animals", type=int, default=40)
    parser.add_argument("--kinds", nargs="*", default=KINDS, choices=KINDS)
    options = parser.parse_args()
    warnings.simplefilter("ignore", VasowaveWarning)
    if not options.out.exists():
        options.out.write_text(",".join(FIELDS) + "\n", encoding="utf-8")
    done = set(pd.read_csv(options.out)[["animal", "kind"]].itertuples(index=False, name=None))
    for number in range(options.animals):
        for kind in options.kinds:
            if (number, kind) not in done:
                found = lines(number, kind)
                with options.out.open("a", newline="", encoding="utf-8") as file:
                    csv.writer(file).writerows(found)
    print(table(options.out))


if __name__ == "__main__":
    main()
