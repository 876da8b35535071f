"""How often the primary comparison finds a difference where there is none, and how often one that is there.

Run: python benchmarks/false_positives.py TABLE [--cohorts 1000] [--draws 399] [--docs]

TABLE is one of `sizes`, `unseen`, `image`, `lungs`, `probe`, `power`. Cohorts of nine quantities are drawn at the level
of logarithms; nothing is simulated. The method was chosen among ten on six rows of `sizes` (normal, correlation 0.6);
the kinds of `unseen` were looked at once, after that.
"""

import argparse
import zlib
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np
from scipy import stats

from relabelings import family_p
from robustness_page import put
from vasowave.pulse.examples import published_table
from vasowave.study.cohort import (
    LEVEL,
    ComparedQuantity,
    Estimates,
    difference,
    holm,
    pooled_means,
    pooled_ratio,
    shared_error,
    simultaneous,
)

COUNT = 9  # quantities of a family
SIZES = (7, 5), (10, 5), (12, 4), (8, 8)
RATIOS = 2.0, 1.0, 1.5, 3.0, 0.5
MODELED = np.arange(COUNT) >= 3  # quantities that an image is behind
LARGE, SHIFT = (1, 4, 6), 2.0  # quantities that differ, and by how many SD of the reference
PAGE = Path(__file__).parents[1] / "docs" / "comparisons.md"
Scores = Callable[[np.random.Generator, int], np.ndarray]


class Cohort(NamedTuple):
    """Logarithms and errors of all animals, shape (animal, quantity), who is of the other group, shared errors."""

    logs: np.ndarray
    errors: np.ndarray
    other: np.ndarray
    shared: np.ndarray


class Found(NamedTuple):
    """Of one cohort: rows shown by each method, rows whose interval contradicts p, and the method's own account."""

    ours: np.ndarray
    holm: np.ndarray
    relabeled: bool
    contradictions: int
    rate: float


def alike(correlation: float) -> np.ndarray:
    """Return a matrix in which every pair of quantities is correlated the same."""
    return np.asarray(correlation + (1 - correlation) * np.eye(COUNT))


def scores(matrix: np.ndarray, kind: str = "normal") -> Scores:
    """Return a function that draws animals: mean 0, SD 1, correlated, of one kind of distribution."""
    root = np.linalg.cholesky(matrix)

    def draw(rng: np.random.Generator, count: int) -> np.ndarray:
        z = rng.standard_normal((count, len(root))) @ root.T
        if kind == "heavy":  # Student's t of three degrees, animal by animal
            return np.asarray(z / np.sqrt(rng.chisquare(3, (count, 1))))  # SD 1: t over the root of three
        if kind == "skewed":
            return np.asarray(stats.expon.ppf(stats.norm.cdf(z)) - 1)
        return z

    return draw


def drawn(rng: np.random.Generator, sizes: tuple[int, int], spread: np.ndarray, draws: tuple[Scores, Scores]) -> Cohort:
    """Return a cohort whose groups do not differ in their means; `spread` of shape (2, quantity)."""
    logs = np.vstack([draw(rng, n) * sd for n, sd, draw in zip(sizes, spread, draws, strict=True)])
    other = np.arange(sum(sizes)) >= sizes[0]
    return Cohort(logs, np.zeros_like(logs), other, np.zeros(COUNT))


def judged(one: Cohort, draws: int, seed: int, relabel: bool = False) -> Found:
    """Return what the methods say of a cohort."""
    rows, welch = [], []
    for quantity, logs in enumerate(one.logs.T):
        known = np.flatnonzero(np.isfinite(logs))
        errors, other = one.errors[known, quantity], one.other[known]
        rows.append(ComparedQuantity(quantity, known, other, logs[known], errors, one.shared[quantity]))
        groups = (pooled_means(logs[known][own], np.zeros(1)) for own in (~other, other))
        welch.append(float(difference(*groups).p))
    found = simultaneous(rows, draws, seed)
    contradictions = 0
    for row, p in zip(rows, found.p, strict=True):
        groups = [(row.logs[own], row.errors[own]) for own in (~row.in_second, row.in_second)]
        ratio = pooled_ratio(*groups, level=1 - found.critical, shared=row.shared)
        contradictions += (p < LEVEL) == (ratio.low <= 1 <= ratio.high)
    relabeled = relabel and bool(family_p(one.logs, one.other).min() < LEVEL)
    return Found(found.p < LEVEL, holm(np.array(welch)) < LEVEL, relabeled, contradictions, found.rate)


Draw = Callable[[np.random.Generator], Cohort]


def many(name: str, make: Draw, options: argparse.Namespace, relabel: bool = False) -> list[Found]:
    """Return what the methods say of many cohorts; a contradiction ends the program."""
    rng = np.random.default_rng([options.seed, zlib.crc32(name.encode())])
    found = [judged(make(rng), options.draws, number, relabel) for number in range(options.cohorts)]
    if wrong := sum(one.contradictions for one in found):
        raise SystemExit(f"{wrong} rows have an interval that contradicts their p")
    return found


def shares(found: list[Found]) -> tuple[float, float, float, float]:
    """Return how often any row was shown: ours, Welch with Holm, relabeled; and what the method says of itself."""
    any_row = np.mean([[one.ours.any(), one.holm.any(), one.relabeled] for one in found], axis=0)
    return (*any_row.tolist(), float(np.mean([one.rate for one in found])))


HEADER = ("this method", "by its own account", "Welch and Holm", "relabeled, Student's t")


def line(name: str, found: list[Found], relabel: bool) -> str:
    """Return one line of a table."""
    ours, welch, relabeled, rate = shares(found)
    return f"| {name} | {ours:.3f} | {rate:.3f} | {welch:.3f} | {f'{relabeled:.3f}' if relabel else '–'} |"


def header(first: str, names: tuple[str, ...]) -> list[str]:
    """Return the two lines above a table."""
    return [f"| {first} | {' | '.join(names)} |", "|---" * (1 + len(names)) + "|"]


def sizes_table(options: argparse.Namespace) -> list[str]:
    """Return false positives by sizes of the groups and ratio of their SD."""
    lines = header("animals, SD of the second group", HEADER)
    draw = scores(alike(0.6))
    for sizes in SIZES:
        if options.animals and options.animals != f"{sizes[0]}+{sizes[1]}":
            continue
        for ratio in RATIOS:
            spread = np.outer([1.0, ratio], np.ones(COUNT))
            relabel = sizes != (8, 8)  # whose relabelings are many
            name = f"{sizes[0]} + {sizes[1]}, × {ratio:g}"
            found = many(name, lambda rng: drawn(rng, sizes, spread, (draw, draw)), options, relabel)  # noqa: B023
            lines.append(line(name, found, relabel))
            print(lines[-1], flush=True)
    return lines


def published() -> tuple[np.ndarray, np.ndarray]:
    """Return spreads, shape (group, quantity), and correlation of the published linear optima, as printed."""
    table = published_table("optimized_linear")
    columns = [name for name in table.columns if table[name].dtype.kind == "f" and (table[name] > 0).all()]
    columns = [name for name in columns if np.log(table[name]).std() > 0][:COUNT]
    groups = [np.log(table.loc[table["group"] == group, columns].to_numpy(float)) for group in ("CTL", "HPH")]
    spread = np.array([one.std(axis=0, ddof=1) for one in groups])
    residuals = np.vstack([(one - one.mean(axis=0)) / sd for one, sd in zip(groups, spread, strict=True)])
    matrix = np.corrcoef(residuals.T)
    return spread, 0.98 * matrix + 0.02 * np.eye(len(matrix))


def unseen() -> dict[str, Callable[[np.random.Generator, tuple[int, int]], Cohort]]:
    """Return the kinds of cohorts that nothing was chosen on; SD of the second group twice that of the first."""
    twice = np.outer([1.0, 2.0], np.ones(COUNT))
    blocks = np.where(np.equal.outer(np.arange(COUNT) // 3, np.arange(COUNT) // 3), 0.8, 0.1) + 0.2 * np.eye(COUNT)
    measured, correlation = published()
    usual = 2 * (scores(alike(0.6)),)
    kinds: dict[str, tuple[np.ndarray, Scores, Scores]] = {
        "no correlation": (twice, *2 * (scores(alike(0.0)),)),
        "correlation 0.9": (twice, *2 * (scores(alike(0.9)),)),
        "three blocks of 0.9": (twice, *2 * (scores(blocks),)),
        "correlation 0.8 in the first group only": (twice, scores(alike(0.8)), scores(alike(0.0))),
        "SD times 1/3 to 3, quantity by quantity": (np.array([np.ones(COUNT), np.geomspace(1 / 3, 3, COUNT)]), *usual),
        "heavy tails (t, 3 degrees)": (twice, *2 * (scores(alike(0.6), "heavy"),)),
        "skewed (exponential logarithms)": (twice, *2 * (scores(alike(0.6), "skewed"),)),
        "spreads and correlation of the paper's linear optima": (measured, *2 * (scores(correlation),)),
    }

    def plain(kind: tuple[np.ndarray, Scores, Scores]) -> Callable[[np.random.Generator, tuple[int, int]], Cohort]:
        return lambda rng, sizes: drawn(rng, sizes, kind[0], kind[1:])

    def gaps(rng: np.random.Generator, sizes: tuple[int, int]) -> Cohort:
        one = drawn(rng, sizes, twice, usual)
        lost = rng.random(one.logs.shape) < 0.2
        lost[[0, 1, sizes[0], sizes[0] + 1]] = False  # two animals of each group have everything
        return one._replace(logs=np.where(lost, np.nan, one.logs))

    def known(rng: np.random.Generator, sizes: tuple[int, int]) -> Cohort:
        one = drawn(rng, sizes, 0.3 * twice, usual)
        errors = 0.3 * np.exp(0.8 * rng.standard_normal((sum(sizes), 1))) * MODELED
        return one._replace(logs=one.logs + errors * rng.standard_normal(one.logs.shape), errors=errors)

    return {name: plain(kind) for name, kind in kinds.items()} | {
        "a fifth of the values missing": gaps,
        "six quantities with errors that differ by animal": known,
    }


def unseen_table(options: argparse.Namespace) -> list[str]:
    """Return false positives of kinds that nothing was chosen on."""
    lines = header("unseen", ("7 + 5", "by its own account", "12 + 4", "by its own account"))
    for name, make in unseen().items():
        found = [shares(many(name, lambda rng: make(rng, sizes), options)) for sizes in ((7, 5), (12, 4))]  # noqa: B023
        lines.append(f"| {name} | {' | '.join(f'{one[0]:.3f} | {one[3]:.3f}' for one in found)} |")
        print(lines[-1], flush=True)
    return lines


def image_table(options: argparse.Namespace) -> list[str]:
    """Return false positives where each group has one image, whose error moves six quantities of all its animals."""
    lines = header("one image for each group, 7 + 5", HEADER)
    for name, image, spread in (("5 %, animals differ by 10 %", 0.05, 0.1), ("10 %, animals differ by 10 %", 0.1, 0.1)):

        def make(rng: np.random.Generator, image: float = image, spread: float = spread) -> Cohort:
            draw = scores(alike(0.6))
            one = drawn(rng, (7, 5), np.full((2, COUNT), spread), (draw, draw))
            errors = np.broadcast_to(0.05 * MODELED, one.logs.shape)
            wrong = image * rng.standard_normal(2)[one.other.astype(int), np.newaxis] * MODELED
            noisy = one.logs + errors * rng.standard_normal(one.logs.shape) + wrong
            return Cohort(noisy, errors, one.other, np.sqrt(2) * image * MODELED)

        lines.append(line(name, many(name, make, options, True), True))
        print(lines[-1], flush=True)
    return lines


SLOPES = np.array([0.0, 0.0, 0.0, 2.5, 1.05, -0.7, -0.4, 2.0, 0.2])
"""Of the nine quantities over all radii, as fits of the demo have them: stiffness, wave speed, C_p, τ, a, I_R."""
LUNG_SIZES = (7, 5), (12, 12), (4, 4)
LUNG_KINDS = {  # SD of lungs in truth, what is told of it, SD of the animals
    "lungs differ by 10 %, not told": (0.1, 0.0, 0.25),
    "lungs differ by 10 %, told": (0.1, 0.1, 0.25),
    "lungs differ by 15 %, told": (0.15, 0.15, 0.25),
    "unseen: lungs differ by 10 %, animals by 10 %, told": (0.1, 0.1, 0.1),
    "unseen: lungs differ by 13 %, 9 % told": (0.13, 0.09, 0.25),
    "unseen: lungs alike, none told": (0.0, 0.0, 0.25),
    "unseen: lungs alike, 9 % told": (0.0, 0.09, 0.25),
}


def lungs_table(options: argparse.Namespace) -> list[str]:
    """Return false positives and power where one lung of each group is imaged, whose animals have lungs of their own.

    Images are 5 % wrong, which is told. Power is how often the stiffness and the measured third quantity, which
    differ by a factor of 1.8 and 1.5, are shown.
    """
    sizes = [f"{one} + {other}" for one, other in LUNG_SIZES]
    lines = header(
        "one imaged lung for each group",
        tuple(f"{size}: {what}" for size in sizes for what in ("false positives", "stiffness", "measured")),
    )
    effect = np.zeros(COUNT)
    effect[2:4] = np.log([1.5, 1.8])
    for name, (true, told, spread) in LUNG_KINDS.items():
        if options.kind not in name:
            continue
        cells = []
        for size in LUNG_SIZES:

            def make(
                rng: np.random.Generator, effect: np.ndarray | float, size: tuple[int, int] = size,
                true: float = true, told: float = told, spread: float = spread,
            ) -> Cohort:  # fmt: skip
                draw = scores(alike(0.6))
                one = drawn(rng, size, np.full((2, COUNT), spread), (draw, draw))
                errors = np.broadcast_to(0.1 * MODELED, one.logs.shape)
                wrong = np.hypot(true, 0.05) * rng.standard_normal(2)[one.other.astype(int), np.newaxis] * SLOPES
                noisy = one.logs + errors * rng.standard_normal(one.logs.shape) + wrong + np.outer(one.other, effect)
                return Cohort(noisy, errors, one.other, np.sqrt(2) * np.hypot(told, 0.05) * np.abs(SLOPES))

            nothing = many(name, lambda rng: make(rng, 0.0), options)
            fewer = argparse.Namespace(**vars(options) | {"cohorts": options.cohorts // 4})
            something = np.mean([one.ours for one in many(name, lambda rng: make(rng, effect), fewer)], axis=0)
            cells += [shares(nothing)[0], something[3], something[2]]
        lines.append(f"| {name} | {' | '.join(f'{cell:.3f}' for cell in cells)} |")
        print(lines[-1], flush=True)
    return lines


PROBES = {
    "one probe for each group": "AAAAAAABBBBB",
    "two probes, 4 and 1 of the animals with the first": "AAAABBBABBBB",
    "one probe for all": "AAAAAAAAAAAA",
}


def probe_table(options: argparse.Namespace) -> list[str]:
    """Return false positives where a probe's gain, 7 % wrong, moves six quantities of the animals that it measured."""
    lines = header("gain 7 %, animals differ by 10 %, 7 + 5", HEADER)
    for name, word in PROBES.items():
        probe = np.array([ord(letter) - ord("A") for letter in word])

        def make(rng: np.random.Generator, probe: np.ndarray = probe) -> Cohort:
            draw = scores(alike(0.6))
            one = drawn(rng, (7, 5), np.full((2, COUNT), 0.1), (draw, draw))
            gain = 0.07 * rng.standard_normal(2)[probe]
            none = np.zeros((3, len(probe)))
            known = Estimates(
                none[0], none[0], none + 0.07 * np.eye(3)[:, [1]], none.astype(int) + probe, "fit", True, none[0]
            )
            error = shared_error(known, one.other) * MODELED
            return one._replace(logs=one.logs + np.outer(gain, MODELED), shared=error)

        lines.append(line(name, many(name, make, options, True), True))
        print(lines[-1], flush=True)
    return lines


def power_table(options: argparse.Namespace) -> list[str]:
    """Return how often a quantity that differs is shown, and how often any other is."""
    lines = header(
        "7 + 5, three of nine differ by 2 SD", ("this method", "Welch and Holm", "others, this", "others, Welch")
    )
    for correlation, ratio in ((0.6, 1.0), (0.6, 2.0), (0.0, 1.0), (0.9, 1.0)):

        def make(rng: np.random.Generator, correlation: float = correlation, ratio: float = ratio) -> Cohort:
            draw = scores(alike(correlation))
            one = drawn(rng, (7, 5), np.outer([1.0, ratio], np.ones(COUNT)), (draw, draw))
            return one._replace(logs=one.logs + SHIFT * np.outer(one.other, np.isin(np.arange(COUNT), LARGE)))

        name = f"correlation {correlation:g}, SD × {ratio:g}"
        found = many(name, make, options)
        large = np.isin(np.arange(COUNT), LARGE)
        ours, welch = (np.array([getattr(one, which) for one in found]) for which in ("ours", "holm"))
        lines.append(f"| {name} | {ours[:, large].mean():.3f} | "
                     f"{welch[:, large].mean():.3f} | {ours[:, ~large].any(axis=1).mean():.3f} | "
                     f"{welch[:, ~large].any(axis=1).mean():.3f} |")  # fmt: skip
        print(lines[-1], flush=True)
    return lines


TABLES = {
    "sizes": sizes_table,
    "unseen": unseen_table,
    "image": image_table,
    "lungs": lungs_table,
    "probe": probe_table,
    "power": power_table,
}


def main() -> None:
    """Print a table, or put it into the page."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("table", choices=TABLES)
    parser.add_argument("--cohorts", type=int, default=1000)
    parser.add_argument("--draws", type=int, default=399)
    parser.add_argument("--animals", help="of `sizes`, these only: 12+4")
    parser.add_argument("--kind", default="", help="of `lungs`, only kinds whose name holds this")
    parser.add_argument("--seed", type=int, default=24)
    parser.add_argument("--docs", action="store_true", help="put the table into docs/comparisons.md")
    options = parser.parse_args()
    text = "\n".join(TABLES[options.table](options))
    if options.docs:
        put(f"false positives: {options.table}", text, PAGE)


if __name__ == "__main__":
    main()
