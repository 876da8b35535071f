"""Intervals and p that hold for a whole family at once: the least p of cohorts drawn without an effect."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from vasowave.study.cohort.mixed import Effect, MixedFit
from vasowave.study.cohort.pooling import difference, pooled_means

LEVEL = 0.05
"""What the rows' p is compared with; their intervals are those of 1 minus this."""

DRAWS = 9_999
"""Cohorts drawn without an effect; no p is below one of this many and one."""

_MAX_NUMBERS = 2_000_000
"""Numbers in the largest array of one round of draws."""


class ComparedQuantity(NamedTuple):
    """One quantity of two groups.

    Attributes
    ----------
    quantity : int
        Which one; rows of the same quantity share the values of their common animals.
    animals : array of int, shape (animal,)
        Which animals of the cohort have it.
    in_second : array of bool, shape (animal,)
        Which of them belong to the second group.
    logs, errors : array, shape (animal,)
        Logarithms and their standard errors; 0 where nothing is known of the error.
    shared : float
        Standard error of the difference of the groups from what animals have in common.
    """

    quantity: int
    animals: np.ndarray
    in_second: np.ndarray
    logs: np.ndarray
    errors: np.ndarray
    shared: float


class Simultaneous(NamedTuple):
    """What holds for all rows at once.

    Attributes
    ----------
    p : array, shape (row,)
        How often, without an effect, any of the rows looks at least as different as this one.
    critical : float
        The p of one row by itself below which `p` is below `LEVEL`; intervals to 1 - `critical` hold all at once.
    rate : float
        Share of cohorts without an effect, normal and of these sizes, spreads and correlations, in which `p` of any row
        comes out below `LEVEL`; `LEVEL` if the method were exact.
    """

    p: np.ndarray
    critical: float
    rate: float


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
    observed, (once, twice, thrice) = _drawn(rows, draws, seed, 3)
    p = _corrected(observed.p[:, 0], once, twice)
    wrong = _corrected(once, twice, thrice) < LEVEL
    return Simultaneous(p, _critical(once, twice), float(wrong.mean()))


def critical_p(rows: Sequence[ComparedQuantity], draws: int, seed: int) -> float:
    """Return the p of one row below which the family's is below its level, as `simultaneous` does."""
    _, (once, twice) = _drawn(rows, draws, seed, 2)
    return _critical(once, twice)


def _drawn(rows: Sequence[ComparedQuantity], draws: int, seed: int, depth: int) -> tuple["_World", np.ndarray]:
    """Return what was observed, and the least p of cohorts each drawn from the one before, sorted (depth, draws)."""
    rng = np.random.default_rng(seed)
    size = 1 + max(int(row.animals.max()) for row in rows), 1 + max(row.quantity for row in rows)
    observed = _World.seen(rows, [row.logs[np.newaxis] for row in rows], size)
    chunk = max(1, _MAX_NUMBERS // (50 * size[0]))
    chains = []
    for first in range(0, draws, chunk):
        world, chain = observed, []
        for _ in range(depth):
            world = _World.seen(rows, world.draw(rows, min(chunk, draws - first), rng), size)
            chain.append(world.least)
        chains.append(chain)
    return observed, np.sort(np.concatenate(chains, axis=1), axis=1)


def _corrected(p_values: np.ndarray, once: np.ndarray, twice: np.ndarray) -> np.ndarray:
    """Return p of the family from p of rows by themselves; `once` and `twice` are least p of drawn cohorts, sorted."""
    place = np.searchsorted(once, p_values, side="right")
    judged = np.append(twice, 1.0)[place]
    return np.asarray((1 + np.searchsorted(once, judged, side="right")) / (len(once) + 1)).clip(max=1.0)


def _critical(once: np.ndarray, twice: np.ndarray) -> float:
    """Return the p of a row by itself below which, and only below which, `_corrected` is below `LEVEL`."""
    max_count = int(np.ceil(LEVEL * (len(once) + 1))) - 1  # as many drawn cohorts, and this one, are too many
    place = int(np.searchsorted(twice, once[max_count - 1], side="left")) if max_count else 0
    return float(once[place - 1]) if place else 0.0


class _World(NamedTuple):
    """What one cohort or many say of themselves: p of each row by itself, and what they could have been drawn from."""

    p: np.ndarray  # shape (row, cohort)
    spreads: list[np.ndarray]  # of each row, shape (cohort, animal)
    root: np.ndarray  # of the correlation, shape (cohort, quantity, quantity)
    animals: int

    @property
    def least(self) -> np.ndarray:
        return np.asarray(self.p.min(axis=0))

    @classmethod
    def seen(cls, rows: Sequence[ComparedQuantity], logs: Sequence[np.ndarray], size: tuple[int, int]) -> "_World":
        """Return what is seen in cohorts whose rows have these values, each of shape (cohort, animal)."""
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
    """One quantity's model with the contrasts that are asked of it.

    Attributes
    ----------
    fit : MixedFit
    animals : array of int, shape (row,)
        Which animals of the cohort its rows are.
    contrasts : array, shape (contrast, coefficient)
    """

    fit: MixedFit
    animals: np.ndarray
    contrasts: np.ndarray

    @property
    def effects(self) -> list[Effect]:
        """The contrasts with their errors."""
        return [self.fit.effect(contrast) for contrast in self.contrasts]


class Joint(NamedTuple):
    """What holds for all rows at once: their p, and the p of one row by itself below which that is below `LEVEL`."""

    p: np.ndarray
    critical: float


def joint(models: Sequence[Fitted], draws: int = DRAWS, seed: int = 0) -> Joint:
    """Return p of every contrast of every quantity, and the level at which their intervals hold together.

    Each row by itself has the t and the degrees of freedom of Kenward and Roger. How small the least p of the family
    may be without an effect is counted in draws: the estimates' errors with the correlation that the design and the
    quantities give them (that of the models' residuals, shrunk towards none), each over a standard error that scatters
    by its degrees of freedom, alike for the contrasts of a quantity.
    """
    rng = np.random.default_rng(seed)
    effects = [model.effects for model in models]
    critical, smallest_p = _least_p(models, effects, draws, rng)
    p_values = np.array([effect.p for model_effects in effects for effect in model_effects])
    p = (1 + np.searchsorted(smallest_p, p_values, side="right")) / (draws + 1)
    return Joint(np.minimum(p, 1.0), critical)


def _least_p(
    models: Sequence[Fitted], effects: Sequence[Sequence[Effect]], draws: int, rng: np.random.Generator
) -> tuple[float, np.ndarray]:
    """Return the critical p of one row, and the least p of every draw, sorted."""
    from scipy.special import chdtri, stdtr

    count = 1 + max(int(model.animals.max()) for model in models)
    residuals = np.zeros((count, len(models)))
    for place, model in enumerate(models):
        residuals[model.animals, place] = model.fit.residuals
    freedom = count - max(model.contrasts.shape[1] for model in models)
    root = np.linalg.cholesky(correlation_of(residuals, freedom))
    scores = rng.standard_normal((draws, count, len(models))) @ root.T
    smallest_p = np.ones(draws)
    for place, (model, model_effects) in enumerate(zip(models, effects, strict=True)):
        errors = scores[:, model.animals, place] @ (model.contrasts @ model.fit.weights @ model.fit.root).T
        size = np.sqrt(np.einsum("ka,ab,kb->k", model.contrasts, model.fit.plain, model.contrasts))
        level = rng.random(draws)
        for k, effect in enumerate(model_effects):
            scatter = np.sqrt(chdtri(effect.freedom, level) / effect.freedom) if np.isfinite(effect.freedom) else 1.0
            t = errors[:, k] / size[k] / scatter
            smallest_p = np.minimum(smallest_p, 2 * stdtr(effect.freedom, -np.abs(t)))
    smallest_p.sort()
    return float(smallest_p[int(np.ceil(LEVEL * (draws + 1))) - 2]), smallest_p
