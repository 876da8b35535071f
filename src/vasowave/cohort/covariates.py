"""The effects of covariates in the model of a design: what groups are adjusted for is an effect, too."""

from collections.abc import Iterator, Sequence

import numpy as np

from vasowave.cohort.cohort import Cohort
from vasowave.cohort.design import covariate_columns
from vasowave.cohort.designed import Modeled
from vasowave.cohort.variables import Variable
from vasowave.descriptions import LEVEL


def covariate_effects(cohort: Cohort, models: Sequence[Modeled]) -> list[dict[str, object]]:
    """Return the effect of every covariate on every quantity, with its interval of 95 % by itself and no test.

    ``quantity, source, covariate, ratio, low, high``: of categories each level over the first, of numbers and dates the
    ratio for one standard deviation.
    """
    return [row for one in models for row in _of(cohort, one)]


def _of(cohort: Cohort, one: Modeled) -> Iterator[dict[str, object]]:
    from scipy.special import stdtrit

    layout, known = one.layout, [cohort.variables[name] for name in cohort.design.covariates]
    columns = [covariate_columns(variable, layout.animals) for variable in known]
    coded = np.column_stack([column for own in columns for column in own] or [np.zeros(len(layout.animals))])
    if not any(columns) or np.linalg.matrix_rank(coded) < coded.shape[1]:
        return
    # What the fixed effects of an animal have beyond the mean of its cell is its covariates'.
    weights = np.linalg.lstsq(coded, layout.fixed - layout.means[layout.cell], rcond=None)[0]
    first = 0
    for variable, own in zip(known, columns, strict=True):
        for label, code in _codes(variable, len(own), layout.animals):
            contrast = np.zeros(coded.shape[1])
            contrast[first : first + len(own)] = code
            through = contrast @ weights
            if not np.isclose(np.linalg.norm(through), np.linalg.norm(contrast)):
                continue  # groups or other covariates say the same
            effect = one.fit.effect(through)
            reach = float(stdtrit(effect.freedom, (1 + LEVEL) / 2)) * effect.error
            ratio, low, high = np.exp([effect.value, effect.value - reach, effect.value + reach]).tolist()
            yield {
                "quantity": one.values.name, "source": one.values.source, "covariate": label, "ratio": ratio,
                "low": low, "high": high,
            }  # fmt: skip
        first += len(own)


def _codes(variable: Variable, count: int, animals: Sequence[str]) -> Iterator[tuple[str, np.ndarray]]:
    """Return the effects of one covariate by what they are called, in the code of its columns."""
    if not count:
        return
    if variable.kind != "category":
        spread = float(np.std([variable.numbers[animal] for animal in animals]))
        unit = "days" if variable.kind == "date" else variable.unit
        yield f"{variable.name}, {spread:.3g} {unit}".rstrip() + " more", np.ones(1)
        return
    there = {variable.levels[animal] for animal in animals}
    kept = [level for level in variable.order[:-1] if level in there]

    def code(level: str) -> np.ndarray:
        return np.array([float(level == one) - float(level == variable.order[-1]) for one in kept])

    reference, *others = [level for level in variable.order if level in there]
    for other in others:
        yield f"{variable.name}: {other} / {reference}", code(other) - code(reference)
