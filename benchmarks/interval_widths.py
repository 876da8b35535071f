"""How often a fit's intervals hold the truth, by the spectrum of the noise, and how wide they are.

    python benchmarks/interval_widths.py [--draws 60] [--docs]

Four animals of `known_animals` are fitted once. Residuals are then drawn from a known spectrum through their
Jacobians, so that an interval costs no simulation; beside it stands the interval of one who knows the spectrum. All
kinds but the last three were in sight while the prior of `noise.spectrum` was chosen.
"""

import argparse
from pathlib import Path

import numpy as np

from interval_coverage import QUANTITIES
from known_animals import animal
from robustness_page import put
from vasowave.pulse.calibration import Search, calibrate, least_squares_optimum
from vasowave.pulse.examples import control_network
from vasowave.pulse.noise import fourier, harmonics, least_squares_covariance, likely_spectra
from vasowave.study.animal import derived_of

ANIMALS = (("linear", 0), ("linear", 3), ("tangent", 2), ("tangent", 4))
KINDS = {
    "exp(-k/2)": lambda k: np.exp(-k / 2),
    "(1 + (k/3)²)^-2.5": lambda k: (1 + (k / 3) ** 2) ** -2.5,
    "exp(-k)": lambda k: np.exp(-k),
    "exp(-k/4)": lambda k: np.exp(-k / 4),
    "exp(-k²/18)": lambda k: np.exp(-0.5 * (k / 3) ** 2),
    "(1 + k)^-2": lambda k: (1.0 + k) ** -2,
    "exp(-k/2), third harmonic five times as strong": lambda k: np.exp(-k / 2) * np.where(k == 3, 5, 1),
    "exp(-k/2), mean ten times weaker": lambda k: np.exp(-k / 2) * np.where(k == 0, 0.1, 1),
    "white": lambda k: np.ones(len(k)),
    "mean and first harmonic alone": lambda k: (k <= 1) + 0.0,
    "a hump at the fifth harmonic": lambda k: np.exp(-0.5 * ((k - 5) / 1.5) ** 2),
}
SD, ERROR, STEP = 0.4, 0.02, 1e-4  # mmHg, mmHg, in logarithms
PAGE = Path(__file__).parents[1] / "docs" / "virtual-cohort.md"


def problem(row, number):
    """Return the Jacobian of a fit, logarithmic widths of its bounds, slopes of the quantities, and the pulse, mmHg."""
    recording, _, wall = animal(row, number)
    fit = calibrate(control_network(), recording, wall, search=Search(starts=2))
    optimum = least_squares_optimum(fit)
    low, high = optimum.space.log_bounds
    diastolic = np.full(len(control_network()), recording.diastolic_pressure)

    def logs(x):
        values = dict(zip(optimum.space.names, optimum.space.values(x), strict=True))
        found = derived_of(fit, values, diastolic)
        return np.log([found[name] for name in QUANTITIES])

    slopes = [(logs(optimum.x + step) - logs(optimum.x - step)) / (2 * STEP) for step in STEP * np.eye(len(low))]
    return optimum.jacobian, high - low, np.transpose(slopes), recording.pulse_pressure


def one_draw(problem, power, rng):
    """Return for every quantity whether the interval holds the truth, and its width over the ideal one's."""
    J, ranges, slopes, pulse = problem
    k = harmonics(len(J))
    variance = power(k) * len(J) * SD**2 / power(k).sum()
    noise = fourier(np.eye(len(J))).T @ (np.sqrt(variance + ERROR**2) * rng.standard_normal(len(J)))
    inverse = np.linalg.pinv(J)
    moved = inverse @ noise
    spectra = likely_spectra(noise - J @ moved, J, pulse, np.full(len(J), ERROR**2))
    gain = slopes @ np.linalg.pinv(fourier(J))
    ideal = np.sqrt(gain**2 @ (variance + ERROR**2))
    found = np.sqrt(np.einsum("qi,ij,qj->q", slopes, least_squares_covariance(J, spectra, ranges), slopes))
    return np.abs(slopes @ moved) <= 1.959964 * found, found / ideal


def table(draws, seed):
    """Return the table of all kinds."""
    problems, rng = [problem(*one) for one in ANIMALS], np.random.default_rng(seed)
    lines = ["| spectrum of the noise | hold the truth | width / ideal |", "|---|---|---|"]
    for name, power in KINDS.items():
        held, width = zip(*[one_draw(one, power, rng) for _ in range(draws) for one in problems], strict=True)
        lines.append(f"| {name} | {np.mean(held):.3f} | {np.median(width):.2f} |")
    return "\n".join(lines)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--draws", type=int, default=60, help="of every animal and kind")
    parser.add_argument("--seed", type=int, default=3)
    parser.add_argument("--docs", action="store_true", help="put the table into docs/virtual-cohort.md")
    chosen = parser.parse_args()
    found = table(chosen.draws, chosen.seed)
    print(found)
    if chosen.docs:
        put("intervals", found, PAGE)


if __name__ == "__main__":
    main()
