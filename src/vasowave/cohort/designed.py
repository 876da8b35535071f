"""The primary comparison of a design: a mixed model of the logarithms of each quantity, its effects and covariates."""

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from vasowave.animal.result import AnimalResult
from vasowave.cohort.cohort import Cohort
from vasowave.cohort.contrast import Contrast
from vasowave.cohort.design import DRIFT, Layout, covariate_columns, laid_out
from vasowave.cohort.estimates import Estimates
from vasowave.cohort.mixed import Effect, MixedFit, Structure, fit_mixed
from vasowave.cohort.simultaneous import Fitted, Joint, joint
from vasowave.cohort.variables import Variable
from vasowave.descriptions import LEVEL
from vasowave.errors import InputError
from vasowave.quantities import question_of

_FEWEST = 3  # rows more than coefficients


class Values(NamedTuple):
    """One quantity of the animals that have it."""

    name: str
    source: str
    unit: str
    results: list[AnimalResult]
    known: Estimates


class Modeled(NamedTuple):
    """One quantity with its model.

    Attributes
    ----------
    values : Values
        Of the animals that all columns of the design know.
    layout : Layout
    structure : Structure
    fit : MixedFit
    contrasts : list of Contrast
        Those that its animals can tell.
    """

    values: Values
    layout: Layout
    structure: Structure
    fit: MixedFit
    contrasts: list[Contrast]

    def weights(self, contrast: Contrast) -> np.ndarray:
        """Return what takes coefficients to the contrast."""
        return np.asarray((contrast.second - contrast.first) @ self.layout.means)

    def effect(self, contrast: Contrast) -> Effect:
        """Return the contrast with its error."""
        return self.fit.effect(self.weights(contrast))


def modeled(cohort: Cohort, values: Values) -> Modeled:
    """Fit the design's model to one quantity.

    Raises
    ------
    InputError
        Its animals are too few for the design, or two of its terms cannot be told apart in them.
    """
    members = {result.name: result.group for result in values.results}
    layout = laid_out(cohort.design, cohort.variables, members, list(cohort.groups))
    kept = np.array([result.name in layout.animals for result in values.results])
    own = values._replace(results=[one for one, keep in zip(values.results, kept, strict=True) if keep],
                          known=values.known.of(kept))  # fmt: skip
    if not np.all(np.isfinite(own.known.logs)):
        raise InputError("a value is not positive; a ratio needs positive values")
    if len(layout.animals) < layout.fixed.shape[1] + _FEWEST:
        raise InputError(f"{len(layout.animals)} animals have it, too few for the design")
    structure = Structure(layout.fixed, list(layout.random.values()), own.known.covariance)
    left = own.known.logs - layout.fixed @ np.linalg.lstsq(layout.fixed, own.known.logs, rcond=None)[0]
    if np.abs(left).max() < 1e-9:
        raise InputError("the values hardly vary within a group; there is nothing to test")
    return Modeled(own, layout, structure, fit_mixed(own.known.logs, structure), list(layout.contrasts))


def occasions_apart(cohort: Cohort, values: Values | None) -> float:
    """Return the SD of one subject's logarithms between its recordings, without errors; 0 where nothing tells it."""
    if values is None or not cohort.design.subject:
        return 0.0
    try:
        one = modeled(cohort, values)
    except InputError:
        return 0.0
    if len(set(one.layout.subject)) == len(one.layout.subject):
        return 0.0
    labels = np.array(one.layout.subject)
    again = (labels[:, np.newaxis] == labels) & ~np.eye(len(labels), dtype=bool)
    return float(np.sqrt(sum(
        component * (np.trace(random) / len(labels) - random[again].mean())
        for name, component, random in zip(one.layout.random, one.fit.components, one.structure.random, strict=True)
        if name.startswith("animals") or name == DRIFT
    )))  # fmt: skip


def rows_of_design(found: Sequence[Modeled]) -> tuple[list[dict[str, object]], float]:
    """Return a row for every effect of every quantity, and the critical p of one row by itself.

    Effects that are not tested are outside the family, and each of their intervals holds by itself.
    """
    tested = [[not _image_unknown(one, contrast) for contrast in one.contrasts] for one in found]
    animals = {
        name: place for place, name in enumerate(dict.fromkeys(name for one in found for name in one.layout.animals))
    }
    models = [
        Fitted(one.fit, np.array([animals[name] for name in one.layout.animals]),
               np.array([one.weights(contrast) for contrast in one.contrasts])[own])
        for one, own in zip(found, tested, strict=True) if any(own)
    ]  # fmt: skip
    together = joint(models) if models else Joint(np.empty(0), 1 - LEVEL)
    p, alone = iter(together.p.tolist()), (np.nan, 1 - LEVEL)
    rows = [
        _row(one, contrast, *((next(p), together.critical) if asked else alone))
        for one, own in zip(found, tested, strict=True)
        for contrast, asked in zip(one.contrasts, own, strict=True)
    ]
    return rows, together.critical


def beside(found: Sequence[Modeled], critical: float) -> Iterator[dict[str, object]]:
    """Return the effects of further laws, without a test."""
    for one in found:
        for contrast in one.contrasts:
            value, low, high = one.effect(contrast).ratio(critical)
            yield {
                "reference": contrast.reference, "other": contrast.other, "change": contrast.change,
                "within": contrast.within, "quantity": one.values.name, "source": one.values.source, "ratio": value,
                "low": low, "high": high,
            }  # fmt: skip


def _row(one: Modeled, contrast: Contrast, p: float, critical: float) -> dict[str, object]:
    effect, layout = one.effect(contrast), one.layout
    value, low, high = effect.ratio(critical)
    means = [np.nan, np.nan]
    if contrast.of_values or contrast.of_ratios:
        means = [
            float(np.exp(side @ layout.means @ one.fit.coefficients)) if layout.has_mean(side) else np.nan
            for side in (contrast.first, contrast.second)
        ]
    first, second = (_subjects(layout, side) for side in (contrast.first, contrast.second))
    row = {
        "reference": contrast.reference, "other": contrast.other, "question": question_of(one.values.name),
        "quantity": one.values.name, "source": one.values.source, "n reference": len(first), "n other": len(second),
        "n both": len(first & second),
        "mean reference": means[0], "mean other": means[1],
        "unit": one.values.unit if contrast.of_values else "1", "ratio": value, "low": low, "high": high,
        "standard error": effect.error, "df": effect.freedom, "p": p,
        "untested": "one image" if np.isnan(p) else "", "smallest p": np.nan,
        "apart": False, "estimates": one.values.known.origin, "what": contrast.what,
        "change": contrast.change, "within": contrast.within,
    }  # fmt: skip
    return row | _influence(one, contrast, effect)


def _subjects(layout: Layout, side: np.ndarray) -> set[str]:
    """Return the subjects that stand in the cells that a side is made of."""
    return {name for name, cell in zip(layout.subject, layout.cell, strict=True) if side[cell] != 0}


def _image_unknown(one: Modeled, contrast: Contrast) -> bool:
    """Return whether shared images may move the effect by an error that is not known, as `image_unknown`.

    Covariates make an effect vaguer, which takes nothing from what its image does: one image an animal is counted as
    without them. The recordings of one animal have one image, which is its own.
    """
    known, layout = one.values.known, one.layout
    if one.values.source == "measured" or known.told:
        return False
    weights = one.weights(contrast) @ one.fit.weights
    image, subject = known.label[0], np.unique(layout.subject, return_inverse=True)[1]
    several = np.bincount(np.unique([image, subject], axis=1)[0], minlength=image.max() + 1) > 1
    alone = (np.bincount(subject, weights) ** 2).sum()
    if contrast.of_values:
        sides = contrast.second - contrast.first
        means = (sides / np.maximum(np.bincount(layout.cell, minlength=len(sides)), 1))[layout.cell]
        alone = min(alone, float((np.bincount(subject, means) ** 2).sum()))
    shared = (np.bincount(image, weights)[several] ** 2).sum()
    return bool(shared > alone + 1e-9 * (weights**2).sum())  # within subjects both are 0


def _influence(one: Modeled, contrast: Contrast, effect: Effect) -> dict[str, object]:
    """Return the animal (all its recordings) whose absence moves the ratio most, and the ratio then.

    The variances stay as they are. An animal without which the effect is not told is not left out.
    """
    covariance, weights, fixed = one.fit.root @ one.fit.root.T, one.weights(contrast), one.layout.fixed
    left = {}
    for subject in dict.fromkeys(one.layout.subject):
        kept = np.array([name != subject for name in one.layout.subject])
        if np.linalg.matrix_rank(fixed[kept]) < fixed.shape[1]:
            continue
        seen = np.linalg.solve(covariance[np.ix_(kept, kept)], fixed[kept]).T
        coefficients = np.linalg.solve(seen @ fixed[kept], seen @ one.values.known.logs[kept])
        left[subject] = float(weights @ coefficients)
    if not left:
        return {"without": "", "ratio without": np.nan}
    farthest = max(left, key=lambda subject: abs(left[subject] - effect.value))
    return {"without": farthest, "ratio without": float(np.exp(left[farthest]))}


def covariate_effects(cohort: Cohort, models: Sequence[Modeled]) -> list[dict[str, object]]:
    """Return the effect of every covariate on every quantity, with its interval of 95 % by itself and no test.

    ``quantity, source, covariate, ratio, low, high``: of categories each level over the first, of numbers and dates the
    ratio for one standard deviation.
    """
    return [row for one in models for row in _of(cohort, one)]


def _of(cohort: Cohort, one: Modeled) -> Iterator[dict[str, object]]:
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
            ratio, low, high = one.fit.effect(through).ratio(1 - LEVEL)
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
