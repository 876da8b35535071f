"""The primary comparison of a design: a mixed model of the logarithms of each quantity, its effects and covariates."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from vasowave.base.descriptions import LEVEL
from vasowave.base.errors import InputError
from vasowave.study.cohort.cohort import Cohort
from vasowave.study.cohort.contrast import Contrast
from vasowave.study.cohort.design import DRIFT, Layout, covariate_columns, laid_out
from vasowave.study.cohort.effects import ContrastLabel, CovariateEffect, DesignEffect, DesignEstimate, Untested
from vasowave.study.cohort.estimates import Values
from vasowave.study.cohort.mixed import MixedFit, Structure, fit_mixed
from vasowave.study.cohort.pooling import LogEstimate
from vasowave.study.cohort.simultaneous_intervals import NO_FAMILY, Fitted, animal_indices, joint
from vasowave.study.cohort.variables import Variable

_MIN_SPARE_ROWS = 3  # rows more than coefficients


class Modeled(NamedTuple):
    """One quantity with its model."""

    values: Values
    """Of the animals that all columns of the design know."""
    layout: Layout
    structure: Structure
    fit: MixedFit
    contrasts: list[Contrast]
    """Those that its animals can tell."""

    def weights(self, contrast: Contrast) -> np.ndarray:
        """Return what takes coefficients to the contrast."""
        return np.asarray(contrast.weights @ self.layout.means)

    def effect(self, contrast: Contrast) -> LogEstimate[float]:
        """Return the contrast with its error."""
        return self.fit.effect(self.weights(contrast))


def modeled(cohort: Cohort, values: Values | None) -> Modeled:
    """Fit the design's model to one quantity.

    Raises
    ------
    InputError
        No animal has it; its animals are too few for the design, or two of its terms cannot be told apart in them.
    """
    if values is None:
        raise InputError("no animal has it")
    members = {result.name: result.group for result in values.results}
    layout = laid_out(cohort.design, cohort.variables, members, list(cohort.groups))
    selected = np.array([result.name in layout.animals for result in values.results])
    present = [result for result, keep in zip(values.results, selected, strict=True) if keep]
    subset = replace(values, results=present, estimates=values.estimates.selected(selected))
    if not np.all(np.isfinite(subset.estimates.logs)):
        raise InputError("a value is not positive; a ratio needs positive values")
    if len(layout.animals) < layout.fixed.shape[1] + _MIN_SPARE_ROWS:
        raise InputError(f"{len(layout.animals)} animals have it, too few for the design")
    structure = Structure(layout.fixed, list(layout.random.values()), subset.estimates.covariance)
    residuals = (
        subset.estimates.logs - layout.fixed @ np.linalg.lstsq(layout.fixed, subset.estimates.logs, rcond=None)[0]
    )
    if np.abs(residuals).max() < 1e-9:
        raise InputError("the values hardly vary within a group; there is nothing to test")
    return Modeled(subset, layout, structure, fit_mixed(subset.estimates.logs, structure), list(layout.contrasts))


def occasions_apart(cohort: Cohort, values: Values | None) -> float:
    """Return the SD of one subject's logarithms between its recordings, without errors; 0 where nothing tells it."""
    if not cohort.design.subject:
        return 0.0
    try:
        model = modeled(cohort, values)
    except InputError:
        return 0.0
    if len(set(model.layout.subject)) == len(model.layout.subject):
        return 0.0
    labels = np.array(model.layout.subject)
    again = (labels[:, np.newaxis] == labels) & ~np.eye(len(labels), dtype=bool)
    return float(np.sqrt(sum(
        component * (np.trace(random) / len(labels) - random[again].mean())
        for name, component, random in zip(
            model.layout.random, model.fit.components, model.structure.random, strict=True
        )
        if name.startswith("animals") or name == DRIFT
    )))  # fmt: skip


def design_effects(quantities: Sequence[Modeled]) -> tuple[list[DesignEffect], float]:
    """Return the effects on every quantity, and the critical p of one of them by itself."""
    tested = [[not _image_unknown(model, contrast) for contrast in model.contrasts] for model in quantities]
    animals = animal_indices([model.layout.animals for model in quantities])
    models = [
        Fitted(model.fit, indices, np.array([model.weights(contrast) for contrast in model.contrasts])[mask])
        for model, indices, mask in zip(quantities, animals, tested, strict=True) if any(mask)
    ]  # fmt: skip
    together = joint(models) if models else NO_FAMILY
    contrasts = [(model, contrast) for model in quantities for contrast in model.contrasts]
    statements = together.statements([is_tested for mask in tested for is_tested in mask])
    effects = [
        _effect(model, contrast, *statement) for (model, contrast), statement in zip(contrasts, statements, strict=True)
    ]
    return effects, together.critical


def design_estimates(models: Sequence[Modeled], critical: float) -> Iterator[DesignEstimate]:
    """Return the effects of further laws, without a test."""
    for model in models:
        for contrast in model.contrasts:
            ratio, low, high = model.effect(contrast).ratio(1 - critical / 2)
            yield DesignEstimate(
                contrast=contrast.label, quantity=model.values.name, source=model.values.source, ratio=ratio, low=low,
                high=high,
            )  # fmt: skip


def group_changes(models: Sequence[Modeled]) -> Iterator[DesignEstimate]:
    """Yield the change of each group by itself, where groups are compared by their changes, with its own 95 % interval.

    A change that a shared image may move by an error that is not known is left out.
    """
    for model in models:
        for contrast in _changes(model.contrasts):
            if not _image_unknown(model, contrast):
                ratio, low, high = model.effect(contrast).ratio(LEVEL / 2 + 0.5)
                yield DesignEstimate(
                    contrast=contrast.label, quantity=model.values.name, source=model.values.source, ratio=ratio,
                    low=low, high=high,
                )  # fmt: skip


def _changes(contrasts: Sequence[Contrast]) -> list[Contrast]:
    """Return the changes that interactions compare, each once."""
    sides = {
        ContrastLabel(group, "", "change", contrast.label.change): side
        for contrast in contrasts
        if contrast.label.kind == "interaction"
        for group, side in ((contrast.label.reference, contrast.first), (contrast.label.group, contrast.second))
    }
    return [Contrast(label, np.zeros_like(side), side) for label, side in sides.items()]


def _effect(model: Modeled, contrast: Contrast, p: float, critical: float) -> DesignEffect:
    fit, layout = model.effect(contrast), model.layout
    ratio, low, high = fit.ratio(1 - critical / 2)
    means = [np.nan, np.nan]
    if contrast.of_values or contrast.of_ratios:
        means = [
            float(np.exp(side @ layout.means @ model.fit.coefficients)) if layout.has_mean(side) else np.nan
            for side in (contrast.first, contrast.second)
        ]
    first, second = (
        {name for name, cell in zip(layout.subject, layout.cell, strict=True) if side[cell] != 0}
        for side in (contrast.first, contrast.second)
    )
    without, ratio_without = _influence(model, contrast, fit)
    return DesignEffect(
        contrast=contrast.label, quantity=model.values.name, source=model.values.source, n_reference=len(first),
        n_group=len(second), n_both=len(first & second), mean_reference=means[0], mean_group=means[1],
        unit=model.values.unit if contrast.of_values else "1", ratio=ratio, low=low, high=high,
        standard_error=fit.error, freedom=fit.freedom, p=p,
        untested=Untested.ONE_IMAGE if np.isnan(p) else Untested.NO, origin=model.values.estimates.origin,
        without=without, ratio_without=ratio_without,
    )  # fmt: skip


def _image_unknown(model: Modeled, contrast: Contrast) -> bool:
    """Return whether shared images may move the effect by an error that is not known, as `image_unknown`.

    Covariates make an effect vaguer, which takes nothing from what its image does: one image an animal is counted as
    without them. The recordings of one animal have one image, which is its own.
    """
    estimates, layout = model.values.estimates, model.layout
    if model.values.source == "measured" or estimates.image_error_known:
        return False
    weights = model.weights(contrast) @ model.fit.weights
    image, subject = estimates.label[0], np.unique(layout.subject, return_inverse=True)[1]
    several = np.bincount(np.unique([image, subject], axis=1)[0], minlength=image.max() + 1) > 1
    alone = (np.bincount(subject, weights) ** 2).sum()
    if contrast.of_values:
        sides = contrast.weights
        means = (sides / np.maximum(np.bincount(layout.cell, minlength=len(sides)), 1))[layout.cell]
        alone = min(alone, float((np.bincount(subject, means) ** 2).sum()))
    shared = (np.bincount(image, weights)[several] ** 2).sum()
    return bool(shared > alone + 1e-9 * (weights**2).sum())  # within subjects both are 0


def _influence(model: Modeled, contrast: Contrast, fit: LogEstimate[float]) -> tuple[str, float]:
    """Return the animal (all its recordings) whose absence moves the ratio most, and the ratio then.

    The variances stay as they are. An animal without which the effect is not told is not left out.
    """
    covariance, weights, fixed = model.fit.root @ model.fit.root.T, model.weights(contrast), model.layout.fixed
    contrast_without = {}
    for subject in dict.fromkeys(model.layout.subject):
        selected = np.array([name != subject for name in model.layout.subject])
        if np.linalg.matrix_rank(fixed[selected]) < fixed.shape[1]:
            continue
        weighted = np.linalg.solve(covariance[np.ix_(selected, selected)], fixed[selected]).T
        coefficients = np.linalg.solve(weighted @ fixed[selected], weighted @ model.values.estimates.logs[selected])
        contrast_without[subject] = float(weights @ coefficients)
    if not contrast_without:
        return "", np.nan
    farthest = max(contrast_without, key=lambda subject: abs(contrast_without[subject] - fit.value))
    return farthest, float(np.exp(contrast_without[farthest]))


def covariate_effects(cohort: Cohort, model: Modeled) -> Iterator[CovariateEffect]:
    """Yield the effect of every covariate on one quantity."""
    layout, covariates = model.layout, [cohort.variables[name] for name in cohort.design.covariates]
    columns = [covariate_columns(variable, layout.animals) for variable in covariates]
    coded = np.column_stack([column for block in columns for column in block] or [np.zeros(len(layout.animals))])
    if not any(columns) or np.linalg.matrix_rank(coded) < coded.shape[1]:
        return
    # What the fixed effects of an animal have beyond the mean of its cell is its covariates'.
    weights = np.linalg.lstsq(coded, layout.fixed - layout.means[layout.cell], rcond=None)[0]
    first = 0
    for variable, block in zip(covariates, columns, strict=True):
        for label, code in _codes(variable, len(block), layout.animals):
            contrast = np.zeros(coded.shape[1])
            contrast[first : first + len(block)] = code
            through = contrast @ weights
            if not np.isclose(np.linalg.norm(through), np.linalg.norm(contrast)):
                continue  # groups or other covariates say the same
            ratio, low, high = model.fit.effect(through).ratio(1 - (1 - LEVEL) / 2)
            yield CovariateEffect(
                quantity=model.values.name, source=model.values.source, covariate=label, ratio=ratio, low=low, high=high
            )
        first += len(block)


def _codes(variable: Variable, count: int, animals: Sequence[str]) -> Iterator[tuple[str, np.ndarray]]:
    """Return the effects of one covariate by what they are called, in the code of its columns."""
    if not count:
        return
    if variable.kind != "category":
        spread = float(np.std([variable.numbers[animal] for animal in animals]))
        unit = "days" if variable.kind == "date" else variable.unit
        yield f"{variable.name}, {spread:.3g} {unit}".rstrip() + " more", np.ones(1)
        return
    levels_present = {variable.levels[animal] for animal in animals}
    coded_levels = [level for level in variable.order[:-1] if level in levels_present]

    def code(level: str) -> np.ndarray:
        return np.array(
            [float(level == coded_level) - float(level == variable.order[-1]) for coded_level in coded_levels]
        )

    reference, *compared_levels = [level for level in variable.order if level in levels_present]
    for compared_level in compared_levels:
        yield f"{variable.name}: {compared_level} / {reference}", code(compared_level) - code(reference)
