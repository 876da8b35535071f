"""Pressure behind the beds: how often posteriors hold wave speed and R_T where it is told, untold or unknown.

    python benchmarks/wedge.py [--animals 20] [--docs]

Trees of seven vessels with a linear wall and 2, 5, 8, 11 or 15 mmHg behind their beds, noise of 2 % of the pulse. Told:
the true pressure; untold: none; unknown: one that is wrong with an SD of 2 mmHg, which the prior knows.
"""

import argparse
from dataclasses import replace
from pathlib import Path

import numpy as np

from known_animals import heart
from posterior_modes import tree
from robustness_page import put, shown
from vasowave.pulse import derived
from vasowave.pulse.cycle import Recording, resample
from vasowave.pulse.inference import Priors, posterior
from vasowave.pulse.model import LinearWall, Model, Numerics, windkessels
from vasowave.pulse.solver import simulate

BEHIND = (2.0, 5.0, 8.0, 11.0, 15.0)  # mmHg
NOISE, FALLS = 0.02, 2.0  # of the pulse; harmonics over which it falls to 1/e
UNKNOWN = 2.0  # mmHg, SD
SAMPLES = 128
TOLD = ("wave_speed", "R_T")
PAGE = Path(__file__).parents[1] / "docs" / "coverage.md"


def animal(number):
    """Return network, recording without a wedge, true wedge, one that is wrong, and true quantities."""
    rng = np.random.default_rng([77, number])
    network, inflow, behind = tree(rng), heart(rng), BEHIND[number % len(BEHIND)]
    resistance, tau = 60.0 * np.exp(0.2 * rng.standard_normal()), 0.12 * np.exp(0.2 * rng.standard_normal())
    beds = windkessels(network, resistance, tau, rng.uniform(0.06, 0.25))
    model = Model(network, LinearWall(57.0 * np.exp(0.3 * rng.standard_normal())), beds, outlet_pressure=behind)
    pressure = simulate(model, inflow, Numerics(samples=SAMPLES))["pressure"].to_numpy()[:, network.root, 0]
    white = np.fft.rfft(rng.standard_normal(SAMPLES))
    noise = np.fft.irfft(white * np.exp(-np.arange(len(white)) / FALLS), SAMPLES)
    noise *= NOISE * np.ptp(pressure) / noise.std()
    recording = Recording(pressure + noise, resample(inflow.flow, SAMPLES), inflow.period, source=f"wedge {number}")
    wrong = max(behind + UNKNOWN * rng.standard_normal(), 0.5)
    return network, recording, behind, wrong, derived(model, float(pressure.mean()))


def held(network, recording, truth, wedge, priors):
    """Return of each quantity whether its interval holds the truth, and half its width, %."""
    told = replace(recording, wedge_pressure=wedge)
    table = posterior(network, told, "linear", draws=150, workers=1, priors=priors).summary
    ends = ([float(table.loc[name, one]) for one in ("interval_low", "interval_high")] for name in TOLD)
    return [(low < truth[name] < high, 50 * np.log(high / low)) for name, (low, high) in zip(TOLD, ends, strict=True)]


def rows(count):
    """Yield the lines of the table."""
    yield "| wedge | wave speed held | half width, % | R_T held | half width, % |"
    yield "|---" * 5 + "|"
    animals = [animal(number) for number in range(count)]
    for way in ("told", "untold", "unknown"):
        found = np.array([
            held(network, recording, truth, {"told": behind, "untold": 0.0, "unknown": wrong}[way],
                 Priors(wedge=UNKNOWN) if way == "unknown" else Priors())
            for network, recording, behind, wrong, truth in animals
        ])  # fmt: skip
        columns = ((f"{int(found[:, name, 0].sum())} of {count}", f"{np.median(found[:, name, 1]):.0f}")
                   for name in range(len(TOLD)))  # fmt: skip
        cells = [text for column in columns for text in column]
        yield f"| {way} | {' | '.join(cells)} |"


def main():
    """Print the table, and put it into the docs if asked."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--animals", type=int, default=20)
    parser.add_argument("--docs", action="store_true")
    options = parser.parse_args()
    table = shown(rows(options.animals))
    if options.docs:
        put("wedge", table, PAGE)


if __name__ == "__main__":
    main()
