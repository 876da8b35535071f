"""How often a design finds what is not there, where animals are not what its test takes them for."""

from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum
from typing import NamedTuple

import numpy as np

from vasowave.study.cohort.design import Layout


@dataclass(frozen=True)
class GuardRules:
    """The cohorts that are drawn to see how far a design can be relied on; `benchmarks/designs.py` tries its rates.

    Attributes
    ----------
    spread_ratios : tuple of float
        SD of the animals that vary more, over that of the others.
    respond : float
        Share of animals that respond.
    shift : float
        By how many SD of the others.
    block_share : float
        Of the variance that animals of one litter have in common, as in the tables of `docs/comparisons.md`.
    correlation : float
        Of the quantities, as in these tables.
    quantities : int
        Of a family, at most.
    cohorts : int
        Drawn of each kind: a rate of 0.1 has a standard error of 0.007.
    fewest : int
        Cohorts of large designs, where a rate of 0.1 has a standard error of 0.015.
    products : int
        Multiplications above which cohorts are fewer: half a second of a processor.
    tolerable : float
        Rate up to which nothing is said.
    enough : int
        Animals in the smallest cell from which on nothing is said: Welch's test has at most 0.065 with 30.
    level : float
        The rate that a study should have.
    """

    spread_ratios: tuple[float, ...] = (2.0, 3.0)
    respond: float = 0.3
    shift: float = 3.0
    block_share: float = 0.3
    correlation: float = 0.6
    quantities: int = 9
    cohorts: int = 2000
    fewest: int = 400
    products: int = 2_000_000_000
    tolerable: float = 0.06
    enough: int = 30
    level: float = 0.05


RULES = GuardRules()


class PopulationShape(StrEnum):
    """What animals may be like that few of them cannot show."""

    NORMAL = "normal"
    SKEWED = "skewed"
    """Logarithms as of an exponential distribution, with more spread in some cells."""
    RESPONDERS = "responders"
    """Some animals of some cells respond, and the others do not."""


class FalsePositives(NamedTuple):
    """What studies without an effect show all the same, if animals are of a shape that so few do not show."""

    shape: PopulationShape
    cells: tuple[str, ...]
    """Those that vary more, or whose animals respond in part."""
    rates: tuple[float, ...]
    """Share of studies in which any row has p < 0.05: for each of `GuardRules.spread_ratios`; of responders one."""


def doubts_of(layout: Layout, quantities: int, rules: GuardRules = RULES) -> tuple[FalsePositives, ...]:
    """Return the shapes of animals by which a design with so many quantities finds too much, with the worst cells.

    The values of the animals are not looked at. Cohorts without an effect are drawn with the cells, covariates,
    subjects and blocks at hand, and judged against normal ones.
    """
    counts = np.bincount(layout.cell)
    if not layout.contrasts or counts[counts > 0].min() >= rules.enough:
        return ()
    doubts = []
    for shape, ratios in ((PopulationShape.SKEWED, rules.spread_ratios), (PopulationShape.RESPONDERS, (1.0,))):
        side = _worst_side(layout, shape, max(ratios))
        rates = tuple(_Population.with_spread(layout, side, ratio, rules).rate(quantities, shape) for ratio in ratios)
        doubts.append(FalsePositives(shape, tuple(layout.cells[cell] for cell in side), rates))
    return tuple(doubt for doubt in doubts if max(doubt.rates) > rules.tolerable)


def rate_of_blocks(layout: Layout, levels: Sequence[str], quantities: int, rules: GuardRules = RULES) -> float:
    """Return the false positives of a design that does not know that animals of one level (their litter) are alike."""
    usual, share = _Population.with_spread(layout, (), 1.0, rules), rules.block_share
    effects = [effect._replace(size=effect.size * np.sqrt(1 - share)) for effect in usual.effects]
    litters = _RandomEffect(_numbers(levels), np.full(len(levels), np.sqrt(share)))
    return usual.rate(quantities, PopulationShape.NORMAL, [*effects, litters])


def _worst_side(layout: Layout, shape: PopulationShape, ratio: float) -> tuple[int, ...]:
    """Return the cells that make comparisons most skewed if they are unlike the others."""
    subject, through = _numbers(layout.subject), layout.means @ np.linalg.pinv(layout.fixed)
    sides = [
        side
        for contrast in layout.contrasts
        for side in ((contrast.second, contrast.first), (contrast.first, contrast.second))
    ]
    max_skewness, worst = 0.0, tuple[int, ...]()
    for cells in (np.flatnonzero(first > np.maximum(second, 0)) for first, second in sides):
        inside = np.isin(layout.cell, cells)
        unlike = np.append(inside, np.bincount(subject, inside) > 0) | (shape is PopulationShape.SKEWED)
        skewness = 0.0
        for contrast in layout.contrasts:
            sizes = contrast.weights @ through * np.where(inside, ratio, 1.0)
            # Of rows, and of the subjects that they are of.
            contributions = np.append(sizes, np.bincount(subject, sizes))
            skewness += float((contributions**3)[unlike].sum() ** 2 / (contributions**2).sum() ** 3)
        if inside.any() and skewness > 1.3 * max_skewness:  # of two nearly alike the first, which is not the reference
            max_skewness, worst = skewness, tuple(cells.tolist())
    return worst


class _RandomEffect(NamedTuple):
    """A random effect: its level and its SD in each row, and which levels are of another shape."""

    level: np.ndarray
    size: np.ndarray
    marked: np.ndarray = np.zeros(0, dtype=bool)


class _Population(NamedTuple):
    """What animals are drawn from, and the test that they get."""

    effects: Sequence[_RandomEffect]
    test: "_Test"
    rules: GuardRules

    @classmethod
    def with_spread(cls, layout: Layout, side: Sequence[int], ratio: float, rules: GuardRules) -> "_Population":
        """Return animals of which those of some cells vary `ratio` times as much."""
        inside, subject = np.isin(layout.cell, side), _numbers(layout.subject)
        spread, block = np.where(inside, ratio, 1.0), rules.block_share / (1 - rules.block_share)
        effects = [_RandomEffect(np.arange(len(inside)), spread, inside)]
        if any(name.startswith("subjects") for name in layout.random):
            subject_inside = np.array([inside[subject == level].all() for level in range(1 + subject.max())])
            effects.append(_RandomEffect(subject, spread, subject_inside))
        components = []
        for name, random in layout.random.items():
            rows = np.diag(random) > 0
            of_animals = name.startswith(("animals", "subjects"))
            components.append(float(np.mean(spread[rows] ** 2)) if of_animals else block)
            if not of_animals:
                level = np.unique(random, axis=0, return_inverse=True)[1].ravel()
                effects.append(_RandomEffect(level, np.sqrt(block) * rows))
        return cls(effects, _Test.from_layout(layout, np.array(components)), rules)

    def rate(self, quantities: int, shape: PopulationShape, effects: Sequence[_RandomEffect] = ()) -> float:
        """Return the share of cohorts of a shape with a p as one in twenty of normal animals has it."""
        count = min(quantities, self.rules.quantities)
        usual, those = (
            self.test.least_p(self._cohorts(drawn_effects, count, population_shape))
            for drawn_effects, population_shape in (
                (self.effects, PopulationShape.NORMAL),
                (effects or self.effects, shape),
            )
        )
        return float(np.mean(those < np.quantile(usual, self.rules.level)))

    def _cohorts(self, effects: Sequence[_RandomEffect], quantities: int, shape: PopulationShape) -> np.ndarray:
        """Return values without an effect, shape (cohort, quantity, row)."""
        rng, rows, rules = np.random.default_rng(0), len(effects[0].level), self.rules
        products = quantities * rows**2 * len(self.test.forms)
        cohorts = min(rules.cohorts, max(rules.fewest, rules.products // products))
        root = np.linalg.cholesky(rules.correlation + (1 - rules.correlation) * np.eye(quantities))
        values = np.zeros((cohorts, quantities, rows))
        for effect in effects:
            scores = np.swapaxes(rng.standard_normal((len(values), 1 + effect.level.max(), quantities)) @ root.T, 1, 2)
            values += effect.size * _shaped(scores, shape, effect.marked, rules)[..., effect.level]
        return values


def _shaped(scores: np.ndarray, shape: PopulationShape, marked: np.ndarray, rules: GuardRules) -> np.ndarray:
    """Return normal scores, shape (..., level), as scores of mean 0 of another shape, by their quantiles."""
    from scipy.special import ndtr

    if shape is PopulationShape.SKEWED and len(marked):
        return np.asarray(-np.log(ndtr(-scores)) - 1)
    if shape is PopulationShape.RESPONDERS and marked.any():
        grid = np.linspace(-6, 6 + rules.shift, 2001)
        share = (1 - rules.respond) * ndtr(grid) + rules.respond * ndtr(grid - rules.shift)
        mixed = np.interp(ndtr(scores[..., marked]), share, grid) - rules.respond * rules.shift
        scores[..., marked] = mixed
    return scores


def _numbers(labels: Sequence[str]) -> np.ndarray:
    return np.unique(np.array(labels), return_inverse=True)[1]


class _Test(NamedTuple):
    """The test of a design as quadratic forms of its rows, so that many cohorts are judged at once.

    The variance of a contrast is linear in the variance components, which are estimated by MINQUE about values that are
    given: one step of restricted maximum likelihood from there. Exact for Welch's test.
    """

    weights: np.ndarray  # (contrast, row): what takes values to contrasts
    forms: np.ndarray  # (component, row, row): quadratic forms that are the components over the given ones
    component_variances: np.ndarray  # (contrast, component): variance of a contrast by each component as given
    spread: np.ndarray  # (component, component): covariance of the components over the given ones

    @classmethod
    def from_layout(cls, layout: Layout, components: np.ndarray) -> "_Test":
        random = np.array([*layout.random.values()])
        inverse = np.linalg.inv(np.tensordot(components, random, axes=1))
        weighted = inverse @ layout.fixed
        estimate = np.linalg.solve(layout.fixed.T @ weighted, weighted.T)
        projection = inverse - weighted @ estimate
        through = projection @ random @ projection
        uncertainty = np.linalg.pinv(0.5 * np.einsum("kij,lji->kl", through, random), hermitian=True)
        forms = 0.5 * np.tensordot(uncertainty, through, axes=1) / components[:, np.newaxis, np.newaxis]
        weights = np.array([contrast.weights @ layout.means for contrast in layout.contrasts]) @ estimate
        component_variances = np.einsum("ci,kij,cj->ck", weights, random, weights) * components
        return cls(weights, forms, component_variances, uncertainty / np.outer(components, components))

    def least_p(self, values: np.ndarray) -> np.ndarray:
        """Return the least p of all contrasts and quantities, of values of shape (cohort, quantity, row)."""
        from scipy.special import stdtr

        rows = values.reshape(-1, values.shape[-1])
        ratios = np.array([((rows @ form) * rows).sum(axis=-1) for form in self.forms]).T
        terms = np.maximum(ratios, 1e-6)[:, np.newaxis] * self.component_variances
        variance = terms.sum(axis=-1)
        freedom = 2 * variance**2 / ((terms @ self.spread) * terms).sum(axis=-1)
        p = 2 * stdtr(freedom, -np.abs(rows @ self.weights.T) / np.sqrt(variance))
        return np.asarray(p.reshape(len(values), -1).min(axis=1))
