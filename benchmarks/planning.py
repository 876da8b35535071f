"""Whether the power that a plan promises is found again in simulated studies, judged as real ones.

Run: python benchmarks/planning.py [--studies 500] [--draws 1999]
"""

import argparse

import numpy as np

from vasowave.cohort.planning import Planning, Spread, plan_of
from vasowave.cohort.pooling import difference, pooled_means
from vasowave.cohort.simultaneous import Row, simultaneous

SPREADS = [Spread("mPAP", (0.2, 0.3), 0.1), Spread("a", (0.5, 0.5), 0.3, 0.1), Spread("R_T", (0.3, 0.2))]
CORRELATION = 0.6 + 0.4 * np.eye(3)


def found_again(size: int, effect: float, studies: int, draws: int) -> np.ndarray:
    """Return how often each quantity's effect is shown in simulated studies of two groups of one size."""
    rng, root, shown = np.random.default_rng(size), np.linalg.cholesky(CORRELATION), np.zeros(len(SPREADS))
    other = np.arange(2 * size) >= size
    for number in range(studies):
        scores = rng.standard_normal((2 * size, len(SPREADS))) @ root.T
        common = rng.standard_normal(len(SPREADS))
        rows = []
        for place, one in enumerate(SPREADS):
            spread = np.hypot(np.where(other, one.between[1], one.between[0]), one.error)
            logs, errors = scores[:, place] * spread + one.shared * common[place] * other, np.full(2 * size, one.error)
            rows.append(Row(place, np.arange(2 * size), other, logs, errors, one.shared))
        critical = simultaneous(rows, draws, number).critical  # which no shift of a group changes
        for place, row in enumerate(rows):
            first, second = (pooled_means(row.logs[own], row.errors[own]) for own in (~other, other))
            moved = second._replace(value=second.value + np.log(effect))
            shown[place] += difference(first, moved, row.shared).p < critical
    return shown / studies


def main() -> None:
    """Print promised power beside that of simulated studies."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--studies", type=int, default=500)
    parser.add_argument("--draws", type=int, default=1999)
    options = parser.parse_args()
    for size, effect in ((6, 1.8), (10, 1.5), (20, 1.5)):
        promised = plan_of(SPREADS, CORRELATION, "theory", Planning(effect=effect)).powers.loc[size]
        found = found_again(size, effect, options.studies, options.draws)
        for name, before, after in zip(promised.index, promised, found, strict=True):
            print(f"| {size} + {size}, ratio {effect:g}, {name} | {before:.3f} | {after:.3f} |", flush=True)


if __name__ == "__main__":
    main()
