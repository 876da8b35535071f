"""Whether the power that a plan promises is found again in simulated studies, judged as real ones.

Run: python benchmarks/planning.py [--studies 500] [--draws 1999] [--docs]
"""

import argparse
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd

from robustness_page import put
from vasowave.study.cohort import (
    ComparedQuantity,
    Design,
    Fitted,
    Layout,
    Planning,
    Spread,
    Structure,
    Variable,
    difference,
    fit_mixed,
    joint,
    laid_out,
    plan_of,
    pooled_means,
    simultaneous,
)

SPREADS = [Spread("mPAP", (0.2, 0.3), 0.1), Spread("a", (0.5, 0.5), 0.3, 0.1), Spread("R_T", (0.3, 0.2))]
CORRELATION = 0.6 + 0.4 * np.eye(3)
PAGE = Path(__file__).parents[1] / "docs" / "comparisons.md"
ALIKE = 0.5  # correlation of the true values of a pair
TWICE = [Spread("mPAP", (0.15, 0.2), 0.1, within=0.15), Spread("a", (0.4, 0.4), 0.3, within=0.3),
         Spread("R_T", (0.3, 0.2), 0.0, within=0.1)]  # fmt: skip
"""Animals that differ from occasion to occasion."""
PAIRED = (
    (6, 1.5, "mice before and after", 1, ALIKE), (12, 1.3, "mice before and after", 1, ALIKE),
    (10, 1.5, "litters", 1, ALIKE), (12, 1.5, "mice before and after, two recordings each time", 2, ALIKE),
    (5, 1.7, "unseen: mice before and after, correlated by 0.2", 1, 0.2),
    (8, 1.4, "unseen: mice before and after, correlated by 0.8", 1, 0.8),
    (16, 1.3, "unseen: mice before and after, three recordings each time", 3, 0.3),
    (6, 1.7, "unseen: litters, correlated by 0.7", 1, 0.7), (14, 1.5, "unseen: litters, correlated by 0.2", 1, 0.2),
)  # fmt: skip
"""Pairs, ratio, what they are, recordings each time, correlation. Nothing was chosen on the unseen ones."""


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
            rows.append(ComparedQuantity(place, np.arange(2 * size), other, logs, errors, one.shared))
        critical = simultaneous(rows, draws, number).critical  # which no shift of a group changes
        for place, row in enumerate(rows):
            first, second = (pooled_means(row.logs[own], row.errors[own]) for own in (~other, other))
            moved = second._replace(value=second.value + np.log(effect))
            shown[place] += difference(first, moved, row.shared).p < critical
    return shown / studies


def layout(size: int, kind: str) -> Layout:
    """Return the layout of a study: mice before and after, or litters of which each group has one animal."""
    names = [str(row) for row in range(2 * size)]
    pair = {name: f"P{int(name) % size}" for name in names}
    if "litters" in kind:
        groups = {name: "B" if int(name) >= size else "A" for name in names}
        return laid_out(Design(blocks=("litter",)), {"litter": Variable.from_cells("litter", pair)}, groups, ["A", "B"])
    time = {name: "after" if int(name) >= size else "before" for name in names}
    variables = {"mouse": Variable.from_cells("mouse", pair), "time": Variable.from_cells("time", time)}
    return laid_out(Design(subject="mouse", occasion="time"), variables, dict.fromkeys(names, "A"), ["A"])


def found_in_pairs(
    size: int, effect: float, studies: int, draws: int, kind: str, occasions: int = 1, alike: float = ALIKE
) -> np.ndarray:
    """Return how often each quantity's effect is shown in simulated studies of pairs, judged by the design's model.

    Every animal is recorded so many times on each occasion, each time with an error of its own.
    """
    rng, root, shown = np.random.default_rng([size, occasions]), np.linalg.cholesky(CORRELATION), np.zeros(len(SPREADS))
    what, second = layout(size, kind), np.arange(2 * size) >= size
    (contrast,) = [(one.second - one.first) @ what.means for one in what.contrasts]
    for number in range(studies):
        common, own = (rng.standard_normal((count, len(SPREADS))) @ root.T for count in (size, 2 * size))
        scores = np.sqrt(alike) * np.tile(common, (2, 1)) + np.sqrt(1 - alike) * own
        again = rng.standard_normal((occasions, 2 * size, len(SPREADS))).mean(axis=0) @ root.T
        models = []
        for place, one in enumerate(SPREADS):
            logs = scores[:, place] * np.where(second, one.between[1], one.between[0]) + one.error * again[:, place]
            known = np.eye(2 * size) * one.error**2 / occasions
            fit = fit_mixed(logs, Structure(what.fixed, list(what.random.values()), known))
            models.append(Fitted(fit, np.arange(2 * size), contrast[np.newaxis]))
        critical = joint(models, draws, number).critical  # which no shift of all second values changes
        for place, model in enumerate(models):
            (found,) = model.effects
            shown[place] += replace(found, value=found.value + np.log(effect)).p < critical
    return shown / studies


def found_twice(size: int, effect: float, studies: int, draws: int) -> np.ndarray:
    """Return how often effects are shown in studies of two groups whose animals are recorded on two occasions each.

    Both recordings are rows of the table; the design names the subject, and its model judges them.
    """
    rng, root, shown = np.random.default_rng([size, 2]), np.linalg.cholesky(CORRELATION), np.zeros(len(TWICE))
    names = [str(row) for row in range(4 * size)]
    animal = {name: f"M{int(name) % (2 * size)}" for name in names}
    groups = {name: "B" if int(name) % (2 * size) >= size else "A" for name in names}
    what = laid_out(Design(subject="mouse"), {"mouse": Variable.from_cells("mouse", animal)}, groups, ["A", "B"])
    second = np.tile(np.arange(2 * size) >= size, 2)
    (contrast,) = [(one.second - one.first) @ what.means for one in what.contrasts]
    for number in range(studies):
        own, apart, again = (
            rng.standard_normal((count, len(TWICE))) @ root.T for count in (2 * size, *(4 * size,) * 2)
        )
        models = []
        for place, one in enumerate(TWICE):
            logs = np.tile(own[:, place], 2) * np.where(second, one.between[1], one.between[0])
            logs = logs + one.within * apart[:, place] + one.error * again[:, place]
            known = np.eye(4 * size) * one.error**2
            fit = fit_mixed(logs, Structure(what.fixed, list(what.random.values()), known))
            models.append(Fitted(fit, np.arange(4 * size), contrast[np.newaxis]))
        critical = joint(models, draws, number).critical
        for place, model in enumerate(models):
            (found,) = model.effects
            shown[place] += replace(found, value=found.value + np.log(effect)).p < critical
    return shown / studies


def _rows(what: str, effect: float, promised: pd.Series, found: np.ndarray) -> list[str]:
    return [f"| {what}, ratio {effect:g}, {name} | {before:.3f} | {after:.3f} |"
            for name, before, after in zip(promised.index, promised, found, strict=True)]  # fmt: skip


def lines(studies: int, draws: int) -> list[str]:
    """Return the table of promised power beside that of simulated studies."""
    table = ["| studies | promised power | found again |", "|---|---|---|"]
    for size, effect in ((6, 1.8), (10, 1.5), (20, 1.5)):
        promised = plan_of(SPREADS, CORRELATION, "theory", Planning(effect=effect)).powers.loc[size]
        found = found_again(size, effect, studies, draws)
        table += _rows(f"{size} + {size}", effect, promised, found)
    for size, effect in ((6, 1.8), (12, 1.5)):
        promised = plan_of(TWICE, CORRELATION, "theory", Planning(effect=effect, occasions=2)).powers.loc[size]
        table += _rows(f"{size} + {size}, a second occasion of each", effect, promised,
                       found_twice(size, effect, studies, draws))  # fmt: skip
    for size, effect, kind, occasions, alike in PAIRED:
        asked = Planning(effect=effect, pairs=alike, occasions=occasions, littermates="litters" in kind)
        promised = plan_of(SPREADS, CORRELATION, "theory", asked).powers.loc[size]
        what = f"unseen: {size} {kind[8:]}" if kind.startswith("unseen") else f"{size} {kind}"
        table += _rows(what, effect, promised, found_in_pairs(size, effect, studies, draws, kind, occasions, alike))
    return table


def main() -> None:
    """Print promised power beside that of simulated studies."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--studies", type=int, default=500)
    parser.add_argument("--draws", type=int, default=1999)
    parser.add_argument("--docs", action="store_true", help="put the table into docs/comparisons.md")
    options = parser.parse_args()
    table = "\n".join(lines(options.studies, options.draws))
    print(table)
    if options.docs:
        put("planning", table, PAGE)


if __name__ == "__main__":
    main()
