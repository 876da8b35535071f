"""How often intervals hold the truth where the noise is of a kind that the prior of its spectrum does not expect.

    python benchmarks/other_noise.py --out found.csv --animals 20      7 s of CPU each

Trees of seven vessels with linear walls, their image right and taken as exact, with noise of 0.4 mmHg of each kind:
white up to harmonic 24, in the mean and the first harmonic alone, and in a hump at the fifth harmonic.
"""

import argparse
import csv
from pathlib import Path

import numpy as np
import pandas as pd

from interval_coverage import QUANTITIES, by_fit
from known_animals import NOISE, SAMPLES, WHITE, heart
from posterior_modes import tree
from vasowave.pulse import derived
from vasowave.pulse.calibration import Search, calibrate
from vasowave.pulse.cycle import Recording
from vasowave.pulse.inference import Priors, posterior
from vasowave.pulse.model import LinearWall, Model, Numerics, windkessels
from vasowave.pulse.solver import simulate

HARMONIC = np.arange(SAMPLES // 2 + 1)
KINDS = {
    "white": 1.0 * (HARMONIC < 25),
    "first harmonic": 1.0 * (HARMONIC < 2),
    "hump": np.exp(-0.5 * ((HARMONIC - 5) / 1.5) ** 2),
}
"""Power of the noise by harmonic."""
PRIORS = Priors(radius=0, length=0, radius_scale_sd=0, length_scale_sd=0, k_sd=0, flow_gain_sd=0, taper_sd=0)
FIELDS = ("kind", "animal", "method", "quantity", "truth", "low", "high")


def noise(power, rng):
    """Return one period of noise of variance 1."""
    wave = np.fft.irfft(np.fft.rfft(rng.standard_normal(SAMPLES)) * np.sqrt(power), SAMPLES)
    return wave / np.sqrt((power[0] + 2 * power[1:-1].sum() + power[-1]) / SAMPLES)


def lines(kind, number):
    """Analyze one animal; return its lines of the file."""
    rng = np.random.default_rng([77, number])
    network, inflow = tree(rng), heart(rng)
    wall = LinearWall(57.0 * np.exp(0.3 * rng.standard_normal()))
    R_T, tau = 76.0 * np.exp(0.2 * rng.standard_normal()), 0.12 * np.exp(0.2 * rng.standard_normal())
    model = Model(network, wall, windkessels(network, R_T, tau, rng.uniform(0.06, 0.25)))
    waves = simulate(model, inflow, Numerics(samples=SAMPLES))["pressure"].to_numpy()
    disturbed = NOISE * noise(KINDS[kind], rng) + WHITE * rng.standard_normal(SAMPLES)
    recording = Recording(waves[:, network.root, 0] + disturbed, inflow.flow, inflow.period)
    truth = derived(model, recording.mean_pressure)
    fitted = by_fit(calibrate(network, recording, "linear", search=Search(starts=2)), network, recording)
    drawn = posterior(network, recording, "linear", priors=PRIORS, draws=150, workers=1).summary
    for name in QUANTITIES:
        low, _, high = fitted[name]
        yield [kind, number, "fit", name, truth[name], low, high]
        yield [kind, number, "posterior", name, truth[name], *drawn.loc[name, ["interval_low", "interval_high"]]]


def table(path):
    """Return how many intervals hold the truth, by kind and method, with their median half width in percent."""
    data = pd.read_csv(path)
    data["held"] = data["truth"].between(data["low"], data["high"])
    data["half"] = 50 * np.log(data["high"] / data["low"])
    rows = [f"| noise | method | animals | {' | '.join(QUANTITIES)} |", "|---" * (3 + len(QUANTITIES)) + "|"]
    for (kind, method), part in data.groupby(["kind", "method"], sort=False):
        ones = [part[part["quantity"] == name] for name in QUANTITIES]
        cells = [f"{one['held'].sum()} ({one['half'].median():.0f})" for one in ones]
        rows.append(f"| {kind} | {method} | {part['animal'].nunique()} | {' | '.join(cells)} |")
    return "\n".join(rows)


def main():
    """Analyze the animals that are not in the file yet, then print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--animals", type=int, default=20)
    options = parser.parse_args()
    if not options.out.exists():
        options.out.write_text(",".join(FIELDS) + "\n", encoding="utf-8")
    done = set(pd.read_csv(options.out)[["kind", "animal"]].itertuples(index=False, name=None))
    for number in range(options.animals):
        for kind in KINDS:
            if (kind, number) not in done:
                found = list(lines(kind, number))
                with options.out.open("a", newline="", encoding="utf-8") as file:
                    csv.writer(file).writerows(found)
    print(table(options.out))


if __name__ == "__main__":
    main()
