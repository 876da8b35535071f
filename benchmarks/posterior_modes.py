"""Do posteriors of tangent animals lie in the right mode? Trees of seven vessels whose walls are far from nominal.

    python benchmarks/posterior_modes.py --out found.csv --kinds spread --animals 20      about 12 s of CPU each
    python benchmarks/posterior_modes.py --out found.csv --animals 0 --docs      table of what is there, into the docs

Every animal is analyzed from nominal, without a fit. Then a search begins at its truth: its mode is to be no more than
two nats of the log posterior density above the mode nearest the posterior's best draw. Each animal is a line in the
file as soon as it is done; a run that was stopped goes on where it was.
"""

import argparse
import csv
import time
import warnings
import zlib
from pathlib import Path

import numpy as np
import pandas as pd

from known_animals import NOISE, SAMPLES, WHITE, heart, smooth_noise
from robustness_page import put
from vasowave.base import FindingKind, NumericalError, VasowaveWarning
from vasowave.pulse import derived
from vasowave.pulse.cycle import Recording
from vasowave.pulse.inference import Posterior, Sampling, climb, posterior, problem_of
from vasowave.pulse.inference import diagnostics as against
from vasowave.pulse.model import Model, Numerics, TangentWall, windkessels
from vasowave.pulse.network import Network
from vasowave.pulse.noise import fourier
from vasowave.pulse.solver import simulate

OTHER_STEPS = 0.05, 0.01, 0.2, 0.1  # of the differences of further climbs, in SD of the prior
KINDS = {
    "spread": ((3.0, 25.0), (0.7, 6.0)),
    "soft": ((4.0, 10.0), (0.5, 1.5)),
    "stiff": ((10.0, 40.0), (0.7, 3.0)),
    "low": ((5.0, 15.0), (1.5, 6.0)),
}
"""Ranges of p1 (mmHg) and γ of the true walls; where γ is large the nominal stiffness is far too low, as in `low` 3."""
PAGE = Path(__file__).parents[1] / "docs" / "wall-laws.md"
AGAINST = {one.code for one in vars(against).values() if isinstance(one, FindingKind)}
"""Codes of what speaks against a posterior or a fit; other findings say what the numbers mean."""
NATS = 2.0  # by which a trusted posterior may lie below the mode that a search from the truth finds


def _against(found: Posterior) -> str:
    return " ".join(one.code for one in found.findings if one.code in AGAINST)


def tree(rng):
    """Return a tree of seven vessels: every daughter 0.6 to 0.8 times as wide as its mother."""
    parent = np.array([-1, 0, 0, 1, 1, 2, 2])
    radius = np.full(7, 0.047 * np.exp(0.1 * rng.standard_normal()))
    for row in range(1, 7):
        radius[row] = radius[parent[row]] * rng.uniform(0.6, 0.8)
    return Network(tuple("abcdefg"), parent, rng.uniform(0.15, 0.6, 7), radius)


def animal(kind, number):
    """Return the network, the recording and the true model of an animal; walls that cannot be are drawn anew."""
    rng = np.random.default_rng([zlib.crc32(kind.encode()), number])
    pressures, scales = KINDS[kind]
    while True:
        network, inflow = tree(rng), heart(rng)
        wall = TangentWall(*(float(np.exp(rng.uniform(*np.log(ends)))) for ends in (pressures, scales)))
        R_T, tau = 76.0 * np.exp(0.2 * rng.standard_normal()), 0.12 * np.exp(0.2 * rng.standard_normal())
        model = Model(network, wall, windkessels(network, R_T, tau, rng.uniform(0.06, 0.25)))
        try:
            waves = simulate(model, inflow, Numerics(samples=SAMPLES))["pressure"].to_numpy()
        except NumericalError:
            continue
        pressure = waves[:, network.root, 0] + NOISE * smooth_noise(rng) + WHITE * rng.standard_normal(SAMPLES)
        return network, Recording(pressure, inflow.flow, inflow.period), model


def scores_of(model, unknowns):
    """Return the scores of a true model, whose image is right."""
    nominal = windkessels(model.network, unknowns.nominal.total_resistance, unknowns.nominal.time_constant)
    values = {name: float(np.mean(one)) for name, one in zip(model.wall._fields, model.wall, strict=True)}
    factors = zip(unknowns.space.names[len(values) :], model.outlets, nominal, strict=True)
    return unknowns.scores(values | {name: float(np.mean(own / usual)) for name, own, usual in factors})


def best_draw(found, problem):
    """Return the scores of the draw with the highest posterior density."""
    draws = {name: found.draws(name) for name in problem.unknowns.all}
    points = np.array(
        [
            problem.unknowns.scores({name: one[i] for name, one in draws.items()})
            for i in range(len(next(iter(draws.values()))))
        ]
    )
    missed = found.data["observed_data"]["pressure"] - found.data["posterior_predictive"]["simulated"]
    residuals = np.array(
        [fourier(one) for one in missed.transpose("chain", "draw", "time").to_numpy().reshape(len(points), -1)]
    )
    return points[np.argmax(problem.discrepancy().log_likelihood(residuals) - 0.5 * (points**2).sum(axis=1))]


def climbed_on(problem, top):
    """Return the end of further climbs: near the law's pole one ends on a ridge that other differences lead along."""
    for step in 2 * OTHER_STEPS:
        again = climb(problem.simulate, problem.measured, problem.discrepancy(), top.middle, step=step)
        top = max(top, again, key=lambda one: one.height)
    return top


FIELDS = (
    "kind", "animal", "p1", "gamma", "truth", "low", "median", "high", "k_hat", "apart", "modes", "trusted", "findings",
    "log_evidence", "simulations", "cpu", "below",
)  # fmt: skip


def line(kind, number, draws):
    """Analyze one animal; return its line of the file."""
    network, recording, model = animal(kind, number)
    begun = time.process_time()
    found = posterior(network, recording, "tangent", draws=draws, workers=1)
    cpu, table, said = time.process_time() - begun, found.summary.loc["wave_speed"], found.diagnostics
    problem = problem_of(network, recording, "tangent", Sampling(workers=1))
    starts = scores_of(model, problem.unknowns), best_draw(found, problem)
    tops = [climb(problem.simulate, problem.measured, problem.discrepancy(), one) for one in starts]
    if abs(tops[0].height - tops[1].height) > NATS / 2:
        tops = [climbed_on(problem, one) for one in tops]
    heights = [one.height for one in tops]
    truth = derived(model, recording.mean_pressure)["wave_speed"]
    wall = [float(np.mean(one)) for one in model.wall]
    return [
        kind, number, *wall, truth, table["interval_low"], table["median"], table["interval_high"], said.k_hat,
        said.halves_apart, said.modes, said.trusted, _against(found), said.log_evidence,
        said.simulations, round(cpu, 1), heights[0] - heights[1],
    ]  # fmt: skip


def table(path):
    """Return the table of what is in the file."""
    data = pd.read_csv(path, keep_default_na=False).astype({"trusted": str})
    data["held"] = data["truth"].between(data["low"], data["high"])
    data["lower"], data["poor"] = data["below"] > NATS, data["trusted"] != "True"
    lines = [
        "| true walls | animals | wave speed held | half width, % | more than 2 nats below the truth's mode: all, and "
        "without a finding | not trusted | several modes | simulations, median (most) | CPU, s |",
        "|---|---|---|---|---|---|---|---|---|",
    ]
    for kind, own in [*data.groupby("kind", sort=False), ("all", data)]:
        half = 50 * np.log(own["high"] / own["low"]).median()
        silent = int((own["lower"] & (own["findings"] == "")).sum())
        cells = [
            kind, len(own), own["held"].sum(), f"{half:.0f}", f"{own['lower'].sum()}, {silent}", own["poor"].sum(),
            (own["modes"] > 1).sum(), f"{own['simulations'].median():.0f} ({own['simulations'].max()})",
            f"{own['cpu'].median():.0f}",
        ]  # fmt: skip
        lines.append(f"| {' | '.join(map(str, cells))} |")
    return "\n".join(lines)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=Path, required=True, help="file of results, one line an animal")
    parser.add_argument("--kinds", nargs="*", default=list(KINDS), choices=list(KINDS))
    parser.add_argument("--animals", type=int, default=10, help="of every kind")
    parser.add_argument("--first", type=int, default=100, help="number of the first; those below 100 chose constants")
    parser.add_argument("--draws", type=int, default=200)
    parser.add_argument("--docs", action="store_true", help="put the table into docs/wall-laws.md")
    chosen = parser.parse_args()
    warnings.simplefilter("ignore", VasowaveWarning)
    if not chosen.out.exists():
        with chosen.out.open("w", newline="") as file:
            csv.writer(file).writerow(FIELDS)
    done = set(pd.read_csv(chosen.out)[["kind", "animal"]].itertuples(index=False, name=None))
    for number in range(chosen.first, chosen.first + chosen.animals):
        for kind in [one for one in chosen.kinds if (one, number) not in done]:
            row = line(kind, number, chosen.draws)
            with chosen.out.open("a", newline="") as file:
                csv.writer(file).writerow(row)
            print(*row, flush=True)
    print(table(chosen.out))
    if chosen.docs:
        put("modes", table(chosen.out), PAGE)


if __name__ == "__main__":
    main()
