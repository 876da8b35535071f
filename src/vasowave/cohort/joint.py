"""Intervals and p that hold for all contrasts of all quantities of a design at once."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from vasowave.cohort.mixed import Effect, MixedFit
from vasowave.cohort.simultaneous import DRAWS, LEVEL, correlation_of


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
        return [self.fit.effect(one) for one in self.contrasts]


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
    effects = [one.effects for one in models]
    critical, least = family(models, effects, draws, rng)
    own = np.array([effect.p for some in effects for effect in some])
    p = (1 + np.searchsorted(least, own, side="right")) / (draws + 1)
    return Joint(np.minimum(p, 1.0), critical)


def family(
    models: Sequence[Fitted], effects: Sequence[Sequence[Effect]], draws: int, rng: np.random.Generator
) -> tuple[float, np.ndarray]:
    """Return the critical p of one row, and the least p of every draw, sorted."""
    from scipy.special import chdtri, stdtr

    count = 1 + max(int(one.animals.max()) for one in models)
    residuals = np.zeros((count, len(models)))
    for place, one in enumerate(models):
        residuals[one.animals, place] = one.fit.residuals
    freedom = count - max(one.contrasts.shape[1] for one in models)
    root = np.linalg.cholesky(correlation_of(residuals, freedom))
    scores = rng.standard_normal((draws, count, len(models))) @ root.T
    least = np.ones(draws)
    for place, (one, some) in enumerate(zip(models, effects, strict=True)):
        errors = scores[:, one.animals, place] @ (one.contrasts @ one.fit.weights @ one.fit.root).T
        size = np.sqrt(np.einsum("ka,ab,kb->k", one.contrasts, one.fit.plain, one.contrasts))
        level = rng.random(draws)
        for k, effect in enumerate(some):
            scatter = np.sqrt(chdtri(effect.freedom, level) / effect.freedom) if np.isfinite(effect.freedom) else 1.0
            t = errors[:, k] / size[k] / scatter
            least = np.minimum(least, 2 * stdtr(effect.freedom, -np.abs(t)))
    least.sort()
    return float(least[int(np.ceil(LEVEL * (draws + 1))) - 2]), least
