"""What the posterior of an animal would be if the other animals of its study said what spectrum its discrepancy has.

    python benchmarks/shared_discrepancy.py FOLDER                 15 minutes of CPU: 108 posteriors, kept in the folder
    python benchmarks/shared_discrepancy.py FOLDER --docs          and the table into the docs

Simulated animals with a linear wall (`known_animals`) are put together to studies of six. The prior of the spectrum is
replaced by what the residuals of the other five say of theirs, and the draws of the sixth are weighted by what that
changes of their likelihood; nothing is simulated. The last way, which no study has, knows the true spectrum.
"""

import argparse
from pathlib import Path
from typing import NamedTuple

import numpy as np
from scipy.special import logsumexp

from known_animals import NOISE, SAMPLES, animal, image_of, noise_amplitude
from robustness_page import put
from vasowave.pulse import derived
from vasowave.pulse.inference import MAX_PARETO_K, Discrepancy, Sampling, Target, climb, explore, problem_of, smoothed
from vasowave.pulse.noise import harmonics
from vasowave.study.cohort import pooled_ratio

QUANTITIES = ("wave_speed", "R_T", "a", "C_p")
STUDY, DRAWS = 6, 400
TAILS = (0.025, 0.5, 0.975)
PAGE = Path(__file__).parents[1] / "docs" / "decisions" / "pulse.md"


class Kind(NamedTuple):
    """Row of `known_animals`, number of animals, spread of the logarithm of their noise, and what is said of them."""

    row: str
    animals: int
    spread: float
    said: str


KINDS = (
    Kind("linear", 60, 0.0, "noise of 0.4 mmHg in all"),
    Kind("linear", 24, 0.6, "noise of 0.4 mmHg ×÷ 1.8"),
    Kind("geometry", 24, 0.0, "noise of 0.4 mmHg, radii and lengths wrong"),
)


class Animal:
    """Draws of one animal, and how likely its residuals are under each spectrum (shape, amplitude)."""

    def __init__(self, kept):
        self.noise = Discrepancy(int(kept["samples"]), tuple(kept["amplitude"]), kept["measured"], kept["vessels"])
        self.log_weight, self.residuals = kept["log_weight"], kept["residuals"]
        self.truth, self.size = kept["truth"], float(kept["size"])
        self.values = np.log(kept["values"])
        self.log_prior = np.add.outer(self.noise._shapes[1], self.noise._amplitudes[1])
        self.by_spectrum = self.noise._by_node(self.residuals) - self.log_prior[:, np.newaxis]  # shape, draw, amplitude

    def log_likelihood(self, log_prior):
        """Return that of the draws' residuals with this prior of the spectrum."""
        return logsumexp(self.by_spectrum + log_prior[:, np.newaxis], axis=(0, 2))

    @property
    def probability(self):
        """Logarithm of that of each spectrum given this animal's recording."""
        whole = self.by_spectrum + self.log_prior[:, np.newaxis] - self.log_likelihood(self.log_prior)[:, np.newaxis]
        return logsumexp(whole + self.log_weight[:, np.newaxis], axis=1)

    def with_true_spectrum(self):
        """Return the likelihood of the draws' residuals as of one who knows the noise."""
        noise, power = self.noise, noise_amplitude() ** 2
        scale = self.size**2 * noise.samples / power[harmonics(SAMPLES)].sum()
        covariance = np.diag(scale * power[harmonics(noise.samples)])
        root = np.linalg.cholesky(covariance + noise.measured + noise.vessels @ noise.vessels.T)
        white = np.linalg.solve(root, self.residuals.T)
        return -0.5 * (white**2).sum(axis=0) - np.log(2 * np.pi) * noise.samples / 2 - np.log(np.diag(root)).sum()


def as_others(one, others):
    """Its spectrum is like that of one of the others."""
    return one.log_likelihood(logsumexp([other.probability for other in others], axis=0) - np.log(len(others)))


def as_all(one, others):
    """All animals have the very same spectrum."""
    log = one.log_prior + sum(other.probability - other.log_prior for other in others)
    return one.log_likelihood(log - logsumexp(log))


WAYS = {
    "its own recording (as it is)": lambda one, others: one.log_likelihood(one.log_prior),
    "like one of the others'": as_others,
    "the same in all": as_all,
    "known": lambda one, others: one.with_true_spectrum(),
}
"""How the likelihood of the residuals is found."""


def drawn(kind, number):
    """Return what is kept of the posterior of one animal."""
    size = NOISE * np.exp(kind.spread * np.random.default_rng([7, number]).standard_normal())
    recording, model, wall = animal(kind.row, number, size)
    problem = problem_of(image_of(kind.row), recording, wall, Sampling(workers=1))
    climbed = climb(problem.simulate, problem.measured, problem.discrepancy(), np.zeros(len(problem.unknowns.all)))
    noise = problem.discrepancy(problem.vessels(climbed.middle))
    found = explore(
        Target(problem.simulate, problem.measured, noise, problem.seen, problem.linear),
        [climbed],
        np.random.default_rng(0),
        DRAWS,
    )
    good = np.isfinite(found.residuals).all(axis=1)
    mean, points = recording.mean_pressure, found.points[good]
    values = [[derived(problem.unknowns.model(point), mean)[name] for name in QUANTITIES] for point in points]
    truth = derived(model, mean)
    return {
        "residuals": found.residuals[good], "log_weight": found.weights.log_weight[good], "values": values,
        "truth": [truth[name] for name in QUANTITIES], "measured": noise.measured, "vessels": noise.vessels,
        "samples": noise.samples, "amplitude": noise.amplitude, "size": size,
    }  # fmt: skip


def animals_of(kind, folder):
    """Yield the animals of a kind; those that are not in the folder are drawn first."""
    for number in range(kind.animals):
        path = folder / f"{kind.row} {kind.spread:g} {number}.npz"
        if not path.exists():
            np.savez(path, **drawn(kind, number))
            print(path.name, flush=True)
        with np.load(path) as kept:
            yield Animal(kept)


def estimate(one, log_likelihood):
    """Return interval and median, mean and SD of the logarithm of every quantity (in columns), and Pareto k."""
    own = one.log_likelihood(one.log_prior)
    weights = smoothed(one.log_weight + log_likelihood - own)
    share = np.exp(weights.log_weight)
    ends = [np.quantile(column, TAILS, method="inverted_cdf", weights=share) for column in one.values.T]
    mean = share @ one.values
    return np.array([*np.transpose(ends), mean, np.sqrt(share @ (one.values - mean) ** 2)]), weights.k_hat


def lines(kind, animals):
    """Yield the lines of one kind."""
    studies = [animals[first : first + STUDY] for first in range(0, len(animals), STUDY)]
    usual = None
    for said, way in WAYS.items():
        pairs = [(one, [other for other in study if other is not one]) for study in studies for one in study]
        found = [estimate(one, way(one, others)) for one, others in pairs]
        (low, _, high, mean, deviation), k_hat = np.stack([one for one, _ in found], axis=1), [k for _, k in found]
        truth = np.log([one.truth for one, _ in pairs])
        inside, half = ((low <= truth) & (truth <= high)).sum(axis=0), 0.5 * (high - low)
        ratio, error = pooled(mean, deviation)
        usual = usual or (half, error)
        table = inside, np.median(half / usual[0], axis=0), np.median(error / usual[1], axis=0), ratio
        cells = [f"{n}; {x:.2f}; {y:.2f}, {m}" for n, x, y, m in zip(*table, strict=True)]
        lost = int(np.sum(np.array(k_hat) > MAX_PARETO_K))
        yield f"| {kind.said} | {len(animals)} | {said} | {' | '.join(cells)} | {lost} |"


def pooled(mean, deviation):
    """Return of the ratio of three animals over three, which is 1: how often it is held, and half widths by study."""
    held, halves = np.zeros(len(QUANTITIES), int), []
    for first in range(0, len(mean), STUDY):
        one, other = slice(first, first + STUDY // 2), slice(first + STUDY // 2, first + STUDY)
        found = [
            pooled_ratio((mean[one, q], deviation[one, q]), (mean[other, q], deviation[other, q]))
            for q in range(len(QUANTITIES))
        ]
        held += [ratio.low <= 1 <= ratio.high for ratio in found]
        halves.append([0.5 * np.log(ratio.high / ratio.low) for ratio in found])
    return held, np.array(halves)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path, help="where posteriors are kept")
    parser.add_argument("--docs", action="store_true", help="put the table into docs/decisions/pulse.md")
    chosen = parser.parse_args()
    chosen.folder.mkdir(parents=True, exist_ok=True)
    table = [f"| animals | number | spectrum | {' | '.join(QUANTITIES)} | k > {MAX_PARETO_K:g} |", "|---" * 8 + "|"]
    for kind in KINDS:
        table += lines(kind, list(animals_of(kind, chosen.folder)))
    print("\n".join(table))
    if chosen.docs:
        put("shared discrepancy", "\n".join(table), PAGE)


if __name__ == "__main__":
    main()
