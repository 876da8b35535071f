"""How often the interval of a pooled ratio holds the truth, and how wide it is beside Welch's.

Run: python benchmarks/pooling.py [--cohorts 1000] [--seed 5]

Cohorts are drawn at the level of estimates: nothing is simulated. The method (each group by itself, never less than
the errors alone) was chosen among eight on the kinds `CHOSEN_ON`; that each animal's error is the typical one of its
group was chosen on these and on the ratios 1 to 3 of `NATURAL`; the others were not looked at before.
"""

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from robustness_page import put
from vasowave.study.cohort import pooled_ratio, typical_errors

TRUE_RATIO = 2.6
PAGE = Path(__file__).parents[1] / "docs" / "comparisons.md"


class Kind(NamedTuple):
    """Animals of a group, how much they differ (reference, other), how well they are known, and what is said of it."""

    sizes: tuple[int, int] = (7, 5)
    spread: tuple[float, float] = (0.3, 0.3)
    error: float = 0.3
    said: float = 1.0
    degrees: int = 0
    heavy: bool = False
    image: float = 0.0  # error of the one image that all animals of a group share


CHOSEN_ON = {
    "animals alike in both groups": Kind(),
    "other group differs more": Kind(spread=(0.1, 0.5)),
    "animals do not differ": Kind(spread=(0.02, 0.02)),
    "errors from 5 degrees of freedom": Kind(error=0.2, degrees=5),
}
UNSEEN = {
    "errors said twice too large": Kind(said=2.0),
    "errors said half as large": Kind(said=0.5),
    "3 + 3 animals": Kind((3, 3)),
    "10 + 10 animals": Kind((10, 10)),
    "reference differs more": Kind(spread=(0.5, 0.1)),
    "some animals far off (t, 3 degrees)": Kind(heavy=True),
    "small errors": Kind(error=0.05),
    "errors from 3 degrees of freedom": Kind(degrees=3),
}
ONE_IMAGE = {
    "image 5 %, animals differ by 30 %": Kind(error=0.1, image=0.05),
    "image 10 %, animals differ by 10 %": Kind(spread=(0.1, 0.1), error=0.05, image=0.1),
    "image 10 %, animals do not differ": Kind(spread=(0.02, 0.02), error=0.1, image=0.1),
    "image 10 %, 3 + 3 animals": Kind((3, 3), (0.1, 0.1), 0.1, image=0.1),
}


def group(rng: np.random.Generator, kind: Kind, which: int) -> tuple[np.ndarray, np.ndarray]:
    """Return logarithms and what is said of their errors, of one group."""
    n = kind.sizes[which]
    error = kind.error * np.exp(0.8 * rng.standard_normal(n))
    own = rng.standard_t(3, n) / np.sqrt(3) if kind.heavy else rng.standard_normal(n)
    logs = which * np.log(TRUE_RATIO) + kind.spread[which] * own + error * rng.standard_normal(n)
    logs = logs + kind.image * rng.standard_normal()
    estimated = np.sqrt(rng.chisquare(kind.degrees, n) / kind.degrees) if kind.degrees else 1.0
    return logs, kind.said * error * estimated


def row(kind: Kind, cohorts: int, seed: int) -> tuple[float, ...]:
    """Return coverage by typical errors, by own errors and of Welch's interval, and median ends over their ratio."""
    rng, inside, width = np.random.default_rng(seed), [], []
    for _ in range(cohorts):
        groups = group(rng, kind, 0), group(rng, kind, 1)
        plain = tuple((logs, np.zeros(len(logs))) for logs, _ in groups)
        found = pooled_ratio(*typical(groups)), pooled_ratio(*groups), pooled_ratio(*plain)
        inside.append([one.low <= TRUE_RATIO <= one.high for one in found])
        width.append([np.log(one.high / one.low) / 2 for one in found])
    return (*np.mean(inside, axis=0), *np.exp(np.median(width, axis=0)))


def one_image(kind: Kind, cohorts: int, seed: int) -> tuple[float, ...]:
    """Return coverage: the image shared, the image as an error of each animal's own, Welch; and widths of the first."""
    rng, inside, width = np.random.default_rng(seed), [], []
    for _ in range(cohorts):
        groups = group(rng, kind, 0), group(rng, kind, 1)
        own = tuple((logs, np.hypot(errors, kind.image)) for logs, errors in groups)
        plain = tuple((logs, np.zeros(len(logs))) for logs, _ in groups)
        found = pooled_ratio(*groups, shared=np.sqrt(2) * kind.image), pooled_ratio(*own), pooled_ratio(*plain)
        inside.append([one.low <= TRUE_RATIO <= one.high for one in found])
        width.append([np.log(one.high / one.low) / 2 for one in found])
    return (*np.mean(inside, axis=0), *np.exp(np.median(width, axis=0)))


def typical(groups: Sequence[tuple[np.ndarray, np.ndarray]]) -> list[tuple[np.ndarray, np.ndarray]]:
    """Return groups with the errors that the primary comparison takes: the typical ones of each."""
    return [(logs, typical_errors(errors, [""] * len(errors))) for logs, errors in groups]


class Natural(NamedTuple):
    """Groups whose values, or their inverses, are known to an error that is constant in their unit.

    The reference mean is 1; a value below a twentieth of it is drawn again.
    """

    ratio: float
    spread: float = 0.3
    error: float = 0.3
    inverse: bool = False
    sizes: tuple[int, int] = (7, 5)


NATURAL = {
    **{f"ratio {ratio:g}": Natural(ratio) for ratio in (1, 2, 3)},
    **{f"ratio {ratio:g}, errors of 0.4": Natural(ratio, error=0.4) for ratio in (1, 2, 3)},
    "unseen: inverse of ratio 3": Natural(3, inverse=True),
    "unseen: ratio 3, animals differ by 50 %": Natural(3, spread=0.5),
    "unseen: ratio 3, animals differ by 10 %": Natural(3, spread=0.1),
    "unseen: ratio 1/2": Natural(0.5, error=0.15),
    "unseen: ratio 3, 12 + 12 animals": Natural(3, sizes=(12, 12)),
    "unseen: ratio 3, 4 + 4 animals": Natural(3, sizes=(4, 4)),
}


def natural_groups(rng: np.random.Generator, kind: Natural) -> list[tuple[np.ndarray, np.ndarray]]:
    """Return logarithms and their errors of both groups."""
    groups = []
    for which, count in enumerate(kind.sizes):
        true = kind.ratio**which * np.exp(kind.spread * rng.standard_normal(count))
        seen = true + kind.error * rng.standard_normal(count)
        while (low := seen < 0.05).any():
            seen[low] = true[low] + kind.error * rng.standard_normal(low.sum())
        groups.append(((-1 if kind.inverse else 1) * np.log(seen), kind.error / seen))
    return groups


def weights_table(options: argparse.Namespace) -> str:
    """Return misses and median of the ratio: weights by own errors, by the group's typical error, and Welch's."""
    lines = [
        "| errors constant in the unit | own errors: misses | median | typical errors: misses | median | Welch: misses "
        "| median | × ÷ of the three |",
        "|---" * 8 + "|",
    ]
    for name, kind in NATURAL.items():
        rng, truth = np.random.default_rng(options.seed), kind.ratio ** (-1 if kind.inverse else 1)
        found = []
        for _ in range(options.cohorts):
            own = natural_groups(rng, kind)
            plain = [(logs, 0 * errors) for logs, errors in own]
            found.append([pooled_ratio(*groups)[:3] for groups in (own, typical(own), plain)])
        values = np.array(found)  # (cohort, method, value and ends)
        misses = 1 - np.mean((values[..., 1] <= truth) & (truth <= values[..., 2]), axis=0)
        median, width = np.median(values[..., 0], axis=0), np.sqrt(np.median(values[..., 2] / values[..., 1], axis=0))
        cells = " | ".join(f"{miss:.3f} | {middle:.2f}" for miss, middle in zip(misses, median, strict=True))
        lines.append(f"| {name} | {cells} | {', '.join(f'{one:.2f}' for one in width)} |")
    return "\n".join(lines)


def pooling_table(options: argparse.Namespace) -> str:
    """Return the table of the kinds whose animals have errors of their own only."""
    lines = [
        "| cohorts | typical errors: holds the truth | own errors | Welch | × ÷ of the three |",
        "|---|---|---|---|---|",
    ]
    for title, kinds in (("chosen on", CHOSEN_ON), ("unseen", UNSEEN)):
        for name, kind in kinds.items():
            held, widths = np.split(np.array(row(kind, options.cohorts, options.seed)), 2)
            cells = " | ".join(f"{one:.3f}" for one in held)
            lines.append(f"| {title}: {name} | {cells} | {', '.join(f'{one:.2f}' for one in widths)} |")
    return "\n".join(lines)


def image_table(options: argparse.Namespace) -> str:
    """Return the table of the kinds whose groups have one image each."""
    lines = [
        "| one image for each group | error of the image shared | as if each animal's own | Welch | × ÷ of the three |",
        "|---|---|---|---|---|",
    ]
    for name, kind in ONE_IMAGE.items():
        shared, own, welch, *widths = one_image(kind, options.cohorts, options.seed)
        sizes = ", ".join(f"{width:.2f}" for width in widths)
        lines.append(f"| {name} | {shared:.3f} | {own:.3f} | {welch:.3f} | {sizes} |")
    return "\n".join(lines)


def main() -> None:
    """Print the tables, or put them into the page."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--cohorts", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=5)
    parser.add_argument("--docs", action="store_true", help="put the tables into docs/comparisons.md")
    options = parser.parse_args()
    for name, make in (("pooling", pooling_table), ("weights", weights_table), ("one image", image_table)):
        table = make(options)
        print(table, flush=True)
        if options.docs:
            put(name, table, PAGE)


if __name__ == "__main__":
    main()
