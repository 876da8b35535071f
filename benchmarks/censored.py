"""How often the pooled exponent's interval holds the truth when searches stop at a bound, and when these are left out.

Choices were made on normal animals; skewed ones, heavy tails and errors told too small were looked at afterwards.

    uv run python benchmarks/censored.py 200
"""

import sys

import numpy as np
from scipy import stats

from vasowave.study.cohort import pooled_censored

KINDS = {
    "normal": lambda n, rng: rng.standard_normal(n),
    "tail away from the bound": lambda n, rng: rng.exponential(size=n) - 1,
    "tail beyond the bound": lambda n, rng: 1 - rng.exponential(size=n),
    "Student's t, 4 degrees": lambda n, rng: rng.standard_t(4, n) / np.sqrt(2),
    "errors told 0.7 of what they are": lambda n, rng: rng.standard_normal(n),
}
SPREADS = ((0.4, 0.1), (0.1, 0.4), (0.3, 0.3))
"""SD of the animals, and median of their errors, of logarithms."""


def drawn(kind, count, spread, error, rng):
    """Return estimates whose true mean is 0, and the errors that are told of them."""
    errors = error * np.exp(0.4 * rng.standard_normal(count))
    told = 0.7 * errors if kind.startswith("errors") else errors
    return spread * KINDS[kind](count, rng) + errors * rng.standard_normal(count), told


def coverage(kind, count, share, spread, error, cohorts, rng):
    """Return how often the truth is held with animals beyond the bound, and without them; two inside at least."""
    bound = np.quantile(drawn(kind, 200_000, spread, error, rng)[0], share) if share else -np.inf
    held, without = [], []
    for _ in range(cohorts):
        values, errors = drawn(kind, count, spread, error, rng)
        beyond = np.where(values <= bound, -1, 0)
        inside = values[beyond == 0]
        if len(inside) < 2:
            continue
        found = pooled_censored(np.maximum(values, bound), errors, beyond)
        held.append(found.low <= 0 <= found.high)
        student = stats.ttest_1samp(inside, 0).confidence_interval(0.95)
        without.append(student.low <= 0 <= student.high)
    return np.mean(held), np.mean(without)


def main():
    """Print one row for each kind, number of animals and share at the bound."""
    cohorts, rng = int(sys.argv[1]) if len(sys.argv) > 1 else 200, np.random.default_rng(1)
    for kind in KINDS:
        for count in (3, 5, 8, 12):
            for share in (0.0, 0.25, 0.5, 0.7):
                rows = [coverage(kind, count, share, *sizes, cohorts, rng) for sizes in SPREADS]
                print(kind, count, share, "; ".join(f"{held:.3f}, left out {out:.3f}" for held, out in rows))


if __name__ == "__main__":
    main()
