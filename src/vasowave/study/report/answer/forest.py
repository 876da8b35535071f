"""The rows of the forest plot: groups against each other with every animal, or one animal against its own data."""

from collections.abc import Mapping
from textwrap import wrap

import numpy as np
import pandas as pd

from vasowave.base.io.columns import split_unit
from vasowave.pulse.quantities import INDICES, question_of
from vasowave.study.animal.result import AnimalResult
from vasowave.study.cohort.cohort import Cohort
from vasowave.study.cohort.effects import ContrastEstimate, ContrastLabel, DesignEffect, Effect
from vasowave.study.cohort.primary import Family, Primary
from vasowave.study.cohort.table import column, rows_of
from vasowave.study.figures.forest import Dot, ForestRow, Point
from vasowave.study.figures.matplotlib_style import short
from vasowave.study.report.answer.effects import Called, labels, place_in_lead, plain
from vasowave.study.report.answer.marks import Mark, Marks, unmarked
from vasowave.study.report.wording import number, p_value, probability, ratio_with_interval, unit, value_text

_FROM_DATA = {"wave_speed": "up-slope of pressure and flow", "R_T": "mean pressure above the wedge's over mean flow",
              "tau": "diastolic decay"}  # fmt: skip
"""What the recording alone says of a quantity, at the same pressure and of the same part; others are not the same."""

_MAX_LETTERS = 38  # of a line above rows
_MAX_LABEL = 31  # letters of a quantity with its symbol


def group_rows(cohort: Cohort, primary: Primary, called: Called, mark: Mark = unmarked) -> list[ForestRow]:
    """Return one row for each quantity and group, every animal as a multiple of the reference group's mean."""
    # Questions stay together, whichever groups they are about; the effects of a design are asked one after the other.
    effects = sorted(primary.effects, key=place_in_lead(primary.effects))
    questions, contrasts = [*dict.fromkeys(effect.question for effect in effects)], labels(effects)
    several = len(contrasts) > 1

    def order(effect: Effect) -> tuple[int, int]:
        question, contrast = questions.index(effect.question), contrasts.index(str(effect.contrast))
        return (contrast, question) if isinstance(effect, DesignEffect) and several else (question, contrast)

    return [
        (drawn := _group_row(cohort, primary, effect, called, several))._replace(effect=drawn.effect + mark(effect))
        for effect in sorted(effects, key=order)
    ]


def _group_row(cohort: Cohort, primary: Primary, effect: Effect, called: Called, several: bool) -> ForestRow:
    name = effect.quantity
    size = ratio_with_interval(effect.ratio, effect.low, effect.high)
    p, p_tip = ("no p", "no p") if effect.untested else (p_value(effect.p), probability(effect.p))
    tip = f"{called(name)}: {effect.contrast} {size} ({effect.source}), {p_tip}"
    point = Point(effect.ratio, effect.low, effect.high, effect.source, tip)
    further = [
        _other_law(estimate, called)
        for estimate in primary.others
        if (estimate.contrast, estimate.quantity) == (effect.contrast, name)
    ]
    heading, dots = _heading(effect, several), animals_of(cohort, effect)
    return ForestRow(heading, _label(name, called), size, p, point, further, dots)


def _label(name: str, called: Called) -> str:
    """Return a quantity in words, with its symbol where there is room."""
    text = called(name)
    return text if len(text) <= _MAX_LABEL else plain(name, called)


def _heading(effect: Effect, several: bool) -> str:
    """Return what rows are about: the question, with the other group if there are several; of a design the effect."""
    if not several:
        return effect.question
    contrast = effect.contrast
    if not isinstance(effect, DesignEffect):
        return f"{effect.question}: {short(contrast.group, 20)}"
    sides = " / ".join(short(side, _MAX_LETTERS) for side in (contrast.group, contrast.reference) if side)
    text = f"ratio {contrast.change}: {sides}" if contrast.change else sides
    return "\n".join(wrap(text, _MAX_LETTERS, break_long_words=False))


def _other_law(estimate: ContrastEstimate, called: Called) -> Point:
    size = ratio_with_interval(estimate.ratio, estimate.low, estimate.high)
    tip = f"{called(estimate.quantity)}: {size} times ({estimate.source} wall)"
    return Point(estimate.ratio, estimate.low, estimate.high, estimate.source, tip)


def animal_rows(result: AnimalResult, law: str, family: Family, called: Called, marks: Marks) -> list[ForestRow]:
    """Return one row for each quantity of the model, as a multiple of the primary law's value."""
    data = result.laws[law].quantities
    names = dict.fromkeys(["R_T", *family.quantities])
    present = [name for name in names if name not in INDICES and name in data]
    questions = list(dict.fromkeys([*map(question_of, family.quantities), *map(question_of, present)]))
    present.sort(key=lambda name: questions.index(question_of(name)))
    rows = [(_animal_row(result, law, name, called), marks.of_quantity(name, [result])) for name in present]
    return [row._replace(effect=row.effect + mark) for row, mark in rows]


def _animal_row(result: AnimalResult, law: str, name: str, called: Called) -> ForestRow:
    value = result.laws[law].answers[name]
    center = float(value)
    points = [_relative(result, wall, name, center, called) for wall in result.laws if wall != law]
    measured, waves = result.measured.quantities, result.measured.waves
    elsewhere = name == "wave_speed" and waves.attrs["area_and_wave_speed_at"] != "mean pressure"  # the paper's
    if name in _FROM_DATA and name in measured and not elsewhere:
        alone = float(measured[name])
        tip = f"{called(name)} from the recording alone ({_FROM_DATA[name]}): {value_text(measured[name])}"
        points.append(Point(alone / center, alone / center, alone / center, "data", tip))
    point = _relative(result, law, name, center, called)
    return ForestRow(question_of(name), _label(name, called), value_text(value), "", point, points)


def _relative(result: AnimalResult, wall: str, name: str, center: float, called: Called) -> Point:
    value = result.laws[wall].answers[name]
    low, high = (float(value.attrs.get(f"interval_{end}", value)) / center for end in ("low", "high"))
    return Point(float(value) / center, low, high, wall, f"{called(name)}: {value_text(value)} ({wall} wall)")


def animals_of(cohort: Cohort, effect: Effect) -> list[Dot]:
    """Return the animals of an effect of the primary comparison; none where no animal has such a ratio.

    Of groups each animal over the mean of the reference, of several recordings of an animal their mean. Of occasions
    each animal's own ratio, and of what groups differ in it that over the mean ratio of the reference.
    """
    rows = rows_of(cohort.table, effect.source)
    label = column(rows, effect.quantity)
    values, units = rows[label].astype(float), unit(split_unit(label)[1])
    values = values[np.isfinite(values) & (values > 0)]  # those that a ratio can be of
    if effect.contrast.kind == "groups":
        return _of_groups(cohort, effect.contrast, values, units)
    if effect.contrast.kind in ("factor", "interaction") and cohort.design.occasion:
        return _of_occasions(cohort, effect.contrast, values)
    return []


def _of_groups(cohort: Cohort, contrast: ContrastLabel, values: pd.Series, units: str) -> list[Dot]:
    group = {result.name: result.group for result in cohort.results}
    pair_values = values[[group[name] in (cohort.reference, contrast.group) for name in values.index]]
    logs = np.log(pair_values).groupby(pair_values.index.map(cohort.subjects), sort=False).mean()
    group_of = {cohort.subjects[name]: group[name] for name in pair_values.index}
    center = logs[[group_of[animal] == cohort.reference for animal in logs.index]].mean()
    return [
        Dot(value, group_of[animal], animal, f"{animal}: {number(value * float(np.exp(center)))} {units}".rstrip())
        for animal, value in np.exp(logs - center).items()
    ]


def _of_occasions(cohort: Cohort, contrast: ContrastLabel, values: pd.Series) -> list[Dot]:
    ratios = _changes(cohort, contrast, values)
    group = {cohort.subjects[result.name]: result.group for result in cohort.results}
    center = 1.0
    if contrast.kind == "interaction":
        ratios = {
            animal: ratio for animal, ratio in ratios.items() if group[animal] in (contrast.reference, contrast.group)
        }
        before = [np.log(ratio) for animal, ratio in ratios.items() if group[animal] == contrast.reference]
        if not before:
            return []
        center = float(np.exp(np.mean(before)))
    return [
        Dot(ratio / center, group[animal], animal, f"{animal}: {number(ratio)}") for animal, ratio in ratios.items()
    ]


def _changes(cohort: Cohort, contrast: ContrastLabel, values: pd.Series) -> Mapping[str, float]:
    """Return the ratio between the two occasions of a contrast of every animal that has both."""
    second = cohort.second
    if second is None:
        return {}
    logs_by_animal: dict[str, dict[str, list[float]]] = {}
    for name, value in values.items():
        if name in second.levels:
            logs = logs_by_animal.setdefault(cohort.subjects[str(name)], {})
            logs.setdefault(second.levels[str(name)], []).append(np.log(value))
    base, *later_levels = second.order
    # As factor, and as change.
    called = {level: (second.titled(level), f"{level}/{base}") for level in later_levels}
    later = next((level for level, names in called.items() if {contrast.group, contrast.change} & {*names}), base)
    return {
        animal: float(np.exp(np.mean(logs[later]) - np.mean(logs[base])))
        for animal, logs in logs_by_animal.items()
        if base in logs and later in logs
    }
