"""Simulation-based calibration: the ranks of truths among the draws of their posteriors, uniform if these are right.

    python benchmarks/ranks.py --out found.csv --animals 200      of each of three laws; 3 to 16 s of CPU each
    python benchmarks/ranks.py --out found.csv --animals 0 --docs      the table of what is there, into docs/coverage.md

Trees of seven vessels. All that a posterior leaves open is drawn from its prior: parameters, scales and single errors
of radii and lengths, exponent k, taper, gain of the flow, zero of the pressure, size and spectrum of the discrepancy,
errors of measurement. The animal is simulated, disturbed, and analyzed under the same prior; models that cannot be
simulated are drawn anew, as a posterior leaves them out. Of 400 draws most are left to the emulator, as by default; 150
are all simulated. Each animal is a line a quantity in the file as soon as it is done; a run that was stopped goes on
where it was.
"""

import argparse
import csv
import os
import time
import zlib
from dataclasses import replace
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # small matrices: more threads spin while they wait

import numpy as np
import pandas as pd
from scipy.stats import binom, kstest

from known_animals import SAMPLES, heart
from posterior_modes import tree
from robustness_page import put
from vasowave.base import VasowaveError
from vasowave.pulse import derived
from vasowave.pulse.analysis import operating_point, wave_intensity
from vasowave.pulse.calibration import Search, compared_part
from vasowave.pulse.cycle import Inflow, Recording, resample
from vasowave.pulse.inference import Sampling, posterior_of, problem_of
from vasowave.pulse.model import LinearWall, Model, Numerics, windkessels
from vasowave.pulse.noise import LOG_POWER_PRIOR, LOG_RATE_PRIOR, SIZE_PRIOR, harmonics
from vasowave.pulse.solver import simulate

LAWS = {"linear": 1.0, "tangent": 1.0, "power": 1.0, "linear, dog": 8.0}
"""Wall law and animal, and how many times as long as a mouse's its vessels and its beats are."""
QUANTITIES = ("wave_speed", "R_T", "a", "C_p", "I_R", "area_compliance")
COMPARED = 12  # harmonics
WAVE_SAMPLES = 256  # of a cycle whose waves are separated
ERROR = 0.005  # mmHg, standard error of each harmonic by the scatter of the beats
FIELDS = ("law", "animal", "quantity", "truth", "rank", "low", "high", "k_hat", "draws", "cpu")
PAGE = Path(__file__).parents[1] / "docs" / "coverage.md"


def pilot(law, draws, seed, rng):
    """Return how is drawn, and the problem of a nominal mouse, whose recording fixes the centers of all priors."""
    size, small, heartbeat = LAWS[law], tree(rng), heart(rng)
    network = small.resized(radius=size * small.radius, length=size * small.length)
    inflow = Inflow(size**2 * heartbeat.flow, size * heartbeat.period)  # velocities are alike, and so are pressures
    numerics = Numerics(cell_size=0.1 * size)
    model = Model(network, LinearWall(57.0), windkessels(network, 76.0 / size**2, 0.12 * size, 0.2))
    waves = simulate(model, inflow, replace(numerics, samples=SAMPLES))["pressure"].to_numpy()
    recording = Recording(waves[:, network.root, 0], inflow.flow, inflow.period,
                          pressure_error=np.full(COMPARED + 1, ERROR))  # fmt: skip
    search = Search(pressure_harmonics=COMPARED)
    how = Sampling(draws=draws, seed=seed, workers=1, search=search, numerics=numerics)
    return how, problem_of(network, recording, law.split(",")[0], how)


def discrepancy(problem, pulse, rng):
    """Return the coefficients of a discrepancy from its prior, written down anew: σ, r and s are log-normal."""
    k = harmonics(problem.samples)
    r, s = (np.exp(mean + sd * rng.standard_normal()) for mean, sd in (LOG_RATE_PRIOR, LOG_POWER_PRIOR))
    shape = (1 + r * k / s) ** -s
    variance = (SIZE_PRIOR[0] * pulse * np.exp(SIZE_PRIOR[1] * rng.standard_normal())) ** 2 * shape / shape.mean()
    variance[0] = min(variance[0], problem.samples * problem.discrepancy().of_mean ** 2)
    return np.sqrt(variance) * rng.standard_normal(problem.samples)


def animal(problem, rng):
    """Return the problem of a recorded animal from the prior, and the truth of every quantity."""
    unknowns = problem.unknowns
    while True:
        scores = rng.standard_normal(len(unknowns.all))
        radii, lengths, _ = (sd * rng.standard_normal(len(sd)) for sd in unknowns.own_errors)
        falls = np.full(len(radii), unknowns.priors.sd("taper", unknowns.network) * rng.standard_normal())
        try:
            model, recorded = unknowns.posed(scores, radii, lengths, falls)
            waves = simulate(model, recorded.inflow, problem.numerics)["pressure"].to_numpy()
        except (VasowaveError, ArithmeticError):
            continue
        true = waves[:, model.network.root, 0]
        errors = np.sqrt(problem.measurement_error) * rng.standard_normal(problem.samples)  # the zero's among them
        wrong = problem.in_time(discrepancy(problem, np.ptp(true), rng) + errors)
        recording = replace(problem.recording, pressure=resample(true, SAMPLES) + resample(wrong, SAMPLES))
        break
    again, compared = replace(unknowns, recording=recording), compared_part(recording, COMPARED)
    mean = recording.mean_pressure - errors[0] / np.sqrt(problem.samples)
    place, blood = operating_point(model, mean), model.blood
    pressure, flow = (resample(resample(wave, problem.samples), WAVE_SAMPLES) for wave in (true, recorded.flow))
    intensity = wave_intensity(pressure, flow, recording.period, *place, blood.inertia)
    truth = derived(model, mean) | {"I_R": float(intensity.reflection_coefficient)}
    return replace(problem, unknowns=again, compared=compared), truth


def lines(law, number, draws):
    """Analyze one animal; return its lines of the file."""
    rng = np.random.default_rng([zlib.crc32(law.encode()), number])
    before = time.process_time()
    how, problem = pilot(law, draws, number, rng)
    seen, truth = animal(problem, rng)
    found = posterior_of(seen, how)
    for name in QUANTITIES:
        drawn = found.draws(name)
        rank = (np.sum(drawn < truth[name]) + rng.random() * (1 + np.sum(drawn == truth[name]))) / (len(drawn) + 1)
        low, high = found.summary.loc[name, ["interval_low", "interval_high"]]
        yield [law, number, name, truth[name], rank, low, high, found.diagnostics.k_hat, len(drawn),
               time.process_time() - before]  # fmt: skip


def table(path):
    """Return ranks by fifths, how likely chance makes them as uneven, and intervals that hold, by law and quantity."""
    data = pd.read_csv(path)
    header = ("wall law", "animals", "quantity", "truths in each fifth of their draws", "p", "95 % hold", "50 % hold")
    rows = [f"| {' | '.join(header)} |", "|---" * len(header) + "|"]
    for law in LAWS:
        for name in QUANTITIES:
            part = data[(data["law"] == law) & (data["quantity"] == name)]
            if part.empty:
                continue
            fifths = np.histogram(part["rank"], 5, (0, 1))[0]
            held = int(part["truth"].between(part["low"], part["high"]).sum())
            half = int(part["rank"].between(0.25, 0.75).sum())
            least = int(binom.ppf(0.025, len(part), 0.95))
            cells = (law, len(part), name, " ".join(map(str, fifths)), f"{kstest(part['rank'], 'uniform').pvalue:.2f}",
                     f"{held} (≥ {least})", half)  # fmt: skip
            rows.append(f"| {' | '.join(map(str, cells))} |")
    return "\n".join(rows)


def main():
    """Analyze the animals that are not in the file yet, laws in turn, then print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--animals", type=int, default=200)
    parser.add_argument("--laws", nargs="*", default=list(LAWS), choices=list(LAWS))
    parser.add_argument("--draws", type=int, default=400)
    parser.add_argument("--docs", action="store_true")
    options = parser.parse_args()
    if not options.out.exists():
        options.out.write_text(",".join(FIELDS) + "\n", encoding="utf-8")
    done = set(pd.read_csv(options.out)[["law", "animal"]].itertuples(index=False, name=None))
    for number in range(options.animals):
        for law in options.laws:
            if (law, number) not in done:
                found = list(lines(law, number, options.draws))
                with options.out.open("a", newline="", encoding="utf-8") as file:
                    csv.writer(file).writerows(found)
    print(text := table(options.out))
    if options.docs:
        put(f"ranks, {pd.read_csv(options.out)['draws'].max()} draws", text, PAGE)


if __name__ == "__main__":
    main()
