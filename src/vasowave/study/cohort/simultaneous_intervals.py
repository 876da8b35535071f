"""Intervals and p that hold for a whole family at once: the least p of cohorts drawn without an effect."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from vasowave.base.descriptions import LEVEL as COVERAGE
from vasowave.study.cohort.mixed import MixedFit
from vasowave.study.cohort.pooling import LogEstimate, difference, pooled_means

LEVEL = 0.05
"""What the rows' p is compared with; their intervals are those of 1 minus this."""

DRAWS = 9_999
"""Cohorts drawn without an effect; no p is below one of this many and one."""

_MAX_NUMBERS = 2_000_000
"""Numbers in the largest array of one round of draws."""


class ComparedQuantity(NamedTuple):
    """One quantity of two groups."""

    quantity: int
    """Which one; rows of the same quantity share the values of their common animals."""
    animals: np.ndarray
    """Which animals of the cohort have it. Int, shape (animal,)."""
    in_second: np.ndarray
    """Which of them belong to the second group. Bool, shape (animal,)."""
    logs: np.ndarray
    errors: np.ndarray
    """Logarithms and their standard errors; 0 where nothing is known of the error. Shape (animal,)."""
    shared: float
    """Standard error of the difference of the groups from what animals have in common."""


class Simultaneous(NamedTuple):
    """What holds for all rows at once."""

    p: np.ndarray
    """How often, without an effect, any of the rows looks at least as different as this one. Shape (row,)."""
    critical: float
    """The p of one row by itself below which `p` is below `LEVEL`; intervals to 1 - `critical` hold all at once."""
    rate: float = np.nan
    """Share of cohorts without an effect, normal and of these sizes, spreads and correlations, in which `p` of any row
    comes out below `LEVEL`; `LEVEL` if the method were exact. NaN of models, where it is not counted."""

    def statements(self, tested: Sequence[bool]) -> list[tuple[float, float]]:
        """Return p of each effect and the share in which its interval by itself misses.

        Effects that are not tested are outside the family: they have no p, and each interval holds by itself.
        """
        p_values = iter(self.p.tolist())
        return [(next(p_values), self.critical) if is_tested else (np.nan, 1 - COVERAGE) for is_tested in tested]


NO_FAMILY = Simultaneous(np.empty(0), 1 - COVERAGE)
"""Where no effect is tested."""


def simultaneous(rows: Sequence[ComparedQuantity], draws: int = DRAWS, seed: int = 0) -> Simultaneous:
    """Return p of a family of ratios, and the level at which their intervals hold together.

    Each row by itself has Welch's p, or where errors are known that of the pooled means of Hartung and Knapp. Cohorts
    without an effect are drawn from normal distributions, with each group's own spreads, the animals' own errors and
    the correlation of the quantities within animals, and go through the same computation. The least p of the rows of a
    drawn cohort tells how small a p of the family must be (a parametric bootstrap of a prepivoted statistic: Beran
    1988; Krishnamoorthy, Lu and Mathew 2007). The correlation is that of the residuals of all groups, shrunk towards
    none (Schäfer and Strimmer 2005), which errs towards a larger p.

    Spreads and correlations are estimates. So from each drawn cohort another one is drawn, from what that cohort says
    of itself: how these are judged by the first corrects p (the fast double bootstrap of Davidson and MacKinnon 2007).
    A third one, drawn from the second, tells how often the corrected p is still wrong.

    Parameters
    ----------
    rows : sequence of ComparedQuantity
        Each with two animals or more in both groups, whose values vary.
    draws, seed : int
    """
    observed, (level_1, level_2, level_3) = _drawn(rows, draws, seed, 3)
    p = _double_bootstrap_p(observed.p[:, 0], level_1, level_2)
    wrong = _double_bootstrap_p(level_1, level_2, level_3) < LEVEL
    return Simultaneous(p, _double_bootstrap_critical(level_1, level_2), float(wrong.mean()))


def critical_p(rows: Sequence[ComparedQuantity], draws: int, seed: int) -> float:
    """Return the p of one row below which the family's is below its level, as `simultaneous` does."""
    _, (level_1, level_2) = _drawn(rows, draws, seed, 2)
    return _double_bootstrap_critical(level_1, level_2)


def _drawn(rows: Sequence[ComparedQuantity], draws: int, seed: int, depth: int) -> tuple["_NullCohorts", np.ndarray]:
    """Return what was observed, and the least p of cohorts each drawn from the one before, sorted (depth, draws)."""
    rng = np.random.default_rng(seed)
    size = 1 + max(int(row.animals.max()) for row in rows), 1 + max(row.quantity for row in rows)
    observed = _NullCohorts.from_logs(rows, [row.logs[np.newaxis] for row in rows], size)
    chunk = max(1, _MAX_NUMBERS // (50 * size[0]))
    chains = []
    for first in range(0, draws, chunk):
        cohorts, chain = observed, []
        for _ in range(depth):
            cohorts = _NullCohorts.from_logs(rows, cohorts.draw(rows, min(chunk, draws - first), rng), size)
            chain.append(cohorts.least_p)
        chains.append(chain)
    return observed, np.sort(np.concatenate(chains, axis=1), axis=1)


def _bootstrap_p(p_values: np.ndarray, least_p: np.ndarray) -> np.ndarray:
    """Return p of the family from p of rows by themselves; `least_p` are the least p of drawn cohorts, sorted."""
    return np.asarray((1 + np.searchsorted(least_p, p_values, side="right")) / (len(least_p) + 1)).clip(max=1.0)


def _bootstrap_critical(least_p: np.ndarray) -> float:
    """Return the p of a row by itself below which, and only below which, `_bootstrap_p` is below `LEVEL`."""
    max_count = int(np.ceil(LEVEL * (len(least_p) + 1))) - 1  # as many drawn cohorts, and this one, are too many
    return float(least_p[max_count - 1]) if max_count else 0.0


def _double_bootstrap_p(p_values: np.ndarray, level_1: np.ndarray, level_2: np.ndarray) -> np.ndarray:
    """Return p of the family, corrected by the least p of the cohorts of both levels of the bootstrap, sorted."""
    return _bootstrap_p(np.append(level_2, 1.0)[np.searchsorted(level_1, p_values, side="right")], level_1)


def _double_bootstrap_critical(level_1: np.ndarray, level_2: np.ndarray) -> float:
    """Return the p of a row by itself below which, and only below which, `_double_bootstrap_p` is below `LEVEL`."""
    place = int(np.searchsorted(level_2, _bootstrap_critical(level_1), side="left"))
    return float(level_1[place - 1]) if place else 0.0


class _NullCohorts(NamedTuple):
    """One cohort or many: p of each row by itself, and the parameters from which further ones are drawn."""

    p: np.ndarray  # shape (row, cohort)
    spreads: list[np.ndarray]  # of each row, shape (cohort, animal)
    root: np.ndarray  # of the correlation, shape (cohort, quantity, quantity)
    animals: int

    @property
    def least_p(self) -> np.ndarray:
        return np.asarray(self.p.min(axis=0))

    @classmethod
    def from_logs(
        cls, rows: Sequence[ComparedQuantity], logs: Sequence[np.ndarray], size: tuple[int, int]
    ) -> "_NullCohorts":
        """Return cohorts whose rows have these values, each of shape (cohort, animal)."""
        residuals = np.zeros((len(logs[0]), *size))
        p, spreads = [], []
        for row, values in zip(rows, logs, strict=True):
            first, second = (
                pooled_means(values[:, mask], row.errors[mask]) for mask in (~row.in_second, row.in_second)
            )
            group_index = row.in_second.astype(int)
            center = np.stack([first.value, second.value], axis=-1)[:, group_index]
            between = np.stack([first.between, second.between], axis=-1)[:, group_index]
            spreads.append(np.hypot(between, row.errors))
            residuals[:, row.animals, row.quantity] = (values - center) / spreads[-1]
            p.append(difference(first, second, row.shared).p)
        groups = 1 + int(np.bincount([row.quantity for row in rows]).max())  # a quantity has a row for each pair
        return cls(np.array(p), spreads, np.linalg.cholesky(correlation_of(residuals, size[0] - groups)), size[0])

    def draw(self, rows: Sequence[ComparedQuantity], count: int, rng: np.random.Generator) -> list[np.ndarray]:
        """Return the values of `count` cohorts without an effect, of each row, shape (cohort, animal)."""
        scores = rng.standard_normal((count, self.animals, self.root.shape[-1])) @ np.swapaxes(self.root, -1, -2)
        common = rng.standard_normal((len(rows), count, 1))
        return [
            scores[:, row.animals, row.quantity] * spread + row.shared * shared_score * row.in_second
            for row, spread, shared_score in zip(rows, self.spreads, common, strict=True)
        ]


def animal_indices(members: Sequence[Sequence[str]]) -> list[np.ndarray]:
    """Return for the names of the animals of each row which animals of the cohort they are."""
    indices = {name: index for index, name in enumerate(dict.fromkeys(name for names in members for name in names))}
    return [np.array([indices[name] for name in names]) for names in members]


def correlation_of(residuals: np.ndarray, freedom: int) -> np.ndarray:
    """Return the correlation of the quantities, shrunk as far as its own errors ask for; a missing residual is 0."""
    length = np.sqrt((residuals**2).sum(axis=-2))
    scaled = residuals / length[..., np.newaxis, :]
    correlation = np.swapaxes(scaled, -1, -2) @ scaled
    off_diagonal = ~np.eye(correlation.shape[-1], dtype=bool)
    error = ((1 - correlation**2) ** 2)[..., off_diagonal].sum(axis=-1) / max(freedom - 1, 1)
    signal = (correlation**2)[..., off_diagonal].sum(axis=-1)
    shrunk = np.minimum(1.0, error / np.maximum(signal, 1e-12))[..., np.newaxis, np.newaxis]
    same = np.eye(correlation.shape[-1])
    return np.asarray((1 - shrunk) * correlation * off_diagonal + (1 + 1e-9) * same)  # a hair more, for the root's sake


class Fitted(NamedTuple):
    """One quantity's model with the contrasts that are asked of it."""

    fit: MixedFit
    animals: np.ndarray
    """Which animals of the cohort its rows are. Int, shape (row,)."""
    contrasts: np.ndarray
    """Shape (contrast, coefficient)."""

    @property
    def effects(self) -> list[LogEstimate[float]]:
        """The contrasts with their errors."""
        return [self.fit.effect(contrast) for contrast in self.contrasts]


def joint(models: Sequence[Fitted], draws: int = DRAWS, seed: int = 0) -> Simultaneous:
    """Return p of every contrast of every quantity, and the level at which their intervals hold together.

    Each row by itself has the t and the degrees of freedom of Kenward and Roger. How small the least p of the family
    may be without an effect is counted in draws: the estimates' errors with the correlation that the design and the
    quantities give them (that of the models' residuals, shrunk towards none), each over a standard error that scatters
    by its degrees of freedom, alike for the contrasts of a quantity.
    """
    estimates = [model.effects for model in models]
    least_p = _least_p(models, estimates, draws, np.random.default_rng(seed))
    p_values = np.array([estimate.p for of_model in estimates for estimate in of_model])
    return Simultaneous(_bootstrap_p(p_values, least_p), _bootstrap_critical(least_p))


def _least_p(
    models: Sequence[Fitted], estimates: Sequence[Sequence[LogEstimate[float]]], draws: int, rng: np.random.Generator
) -> np.ndarray:
    """Return the least p of every draw, sorted."""
    from scipy.special import chdtri, stdtr

    count = 1 + max(int(model.animals.max()) for model in models)
    residuals = np.zeros((count, len(models)))
    for place, model in enumerate(models):
        residuals[model.animals, place] = model.fit.residuals
    residual_freedom = count - max(model.contrasts.shape[1] for model in models)
    root = np.linalg.cholesky(correlation_of(residuals, residual_freedom))
    scores = rng.standard_normal((draws, count, len(models))) @ root.T
    least_p = np.ones(draws)
    for place, (model, of_model) in enumerate(zip(models, estimates, strict=True)):
        errors = scores[:, model.animals, place] @ (model.contrasts @ model.fit.weights @ model.fit.root).T
        size = np.sqrt(np.einsum("ka,ab,kb->k", model.contrasts, model.fit.plain, model.contrasts))
        level = rng.random(draws)
        for k, estimate in enumerate(of_model):
            freedom = estimate.freedom
            scatter = np.sqrt(chdtri(freedom, level) / freedom) if np.isfinite(freedom) else 1.0
            least_p = np.minimum(least_p, 2 * stdtr(freedom, -np.abs(errors[:, k] / size[k] / scatter)))
    least_p.sort()
    return least_p
