"""The rows of the forest plot: groups against each other with every animal, or one animal against its own data."""

from collections.abc import Mapping
from textwrap import wrap

import numpy as np
import pandas as pd

from vasowave.base.io.columns import split_unit
from vasowave.pulse.quantities import INDICES, question_of
from vasowave.study.animal.result import AnimalResult
from vasowave.study.cohort.cohort import Cohort
from vasowave.study.cohort.primary import Family, Primary
from vasowave.study.cohort.table import column, rows_of
from vasowave.study.figures.forest import Dot, ForestRow, Point
from vasowave.study.figures.matplotlib_style import short
from vasowave.study.report.answer.effects import Called, effect_of, plain
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
    order = {question: place for place, question in enumerate(primary.rows["question"].unique())}
    rows = primary.rows.assign(effect=[effect_of(row) for _, row in primary.rows.iterrows()])
    order |= {effect: place for place, effect in enumerate(rows["effect"].unique())}
    several = rows["effect"].nunique() > 1
    by = ["effect", "question"] if "what" in rows and several else ["question", "effect"]
    rows = rows.sort_values(by, key=lambda column: column.map(order), kind="stable")
    return [
        (drawn := _group_row(cohort, primary, row, called, several))._replace(effect=drawn.effect + mark(row))
        for _, row in rows.iterrows()
    ]


def _group_row(cohort: Cohort, primary: Primary, row: pd.Series, called: Called, several: bool) -> ForestRow:
    name, effect = str(row["quantity"]), effect_of(row)
    size = ratio_with_interval(row["ratio"], row["low"], row["high"])
    tip = f"{called(name)}: {effect} {size} ({row['source']}), {'no p' if row['untested'] else probability(row['p'])}"
    secondary = primary.others
    if len(secondary):
        same = [effect_of(law_row) == effect for _, law_row in secondary.iterrows()]
        secondary = secondary[np.array(same) & (secondary["quantity"] == name)]
    p = "no p" if row["untested"] else p_value(row["p"])
    point = Point(row["ratio"], row["low"], row["high"], str(row["source"]), tip)
    further = [_beside(law_row, called) for _, law_row in secondary.iterrows()]
    return ForestRow(_heading(row, several), _label(name, called), size, p, point, further, animals_of(cohort, row))


def _label(name: str, called: Called) -> str:
    """Return a quantity in words, with its symbol where there is room."""
    text = called(name)
    return text if len(text) <= _MAX_LABEL else plain(name, called)


def _heading(row: pd.Series, several: bool) -> str:
    """Return what rows are about: the question, with the other group if there are several; of a design the effect."""
    if not several:
        return str(row["question"])
    if "what" not in row:
        return f"{row['question']}: {short(str(row['other']), 20)}"
    sides = " / ".join(short(side, _MAX_LETTERS) for side in (str(row["other"]), str(row["reference"])) if side)
    text = f"{row['change']}: {sides}" if row.get("change") else sides
    return "\n".join(wrap(text, _MAX_LETTERS, break_long_words=False))


def _beside(row: pd.Series, called: Called) -> Point:
    size = ratio_with_interval(row["ratio"], row["low"], row["high"])
    tip = f"{called(row['quantity'])}: {size} times ({row['source']} wall)"
    return Point(row["ratio"], row["low"], row["high"], str(row["source"]), tip)


def animal_rows(result: AnimalResult, law: str, family: Family, called: Called, marks: Marks) -> list[ForestRow]:
    """Return one row for each quantity of the model, as a multiple of the primary law's value."""
    data = result.laws[law].quantities
    names = dict.fromkeys(["R_T", *family.quantities])
    present = [name for name in names if name not in INDICES and name in data]
    questions = list(dict.fromkeys([*map(question_of, family.quantities), *map(question_of, present)]))
    present.sort(key=lambda name: questions.index(question_of(name)))
    rows = [(_animal_row(result, law, name, called), marks.of(name, [result])) for name in present]
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


def animals_of(cohort: Cohort, row: pd.Series) -> list[Dot]:
    """Return the animals of a row of the primary comparison; none where an effect is no ratio that one animal has.

    Of groups each animal over the mean of the reference, of several recordings of an animal their mean. Of occasions
    each animal's own ratio, and of what groups differ in it that over the mean ratio of the reference.
    """
    values, units = _values(cohort, row)
    effect_kind = row.get("what", "groups")
    if effect_kind == "groups":
        return _of_groups(cohort, row, values, units)
    if effect_kind in ("factor", "interaction") and cohort.design.occasion:
        return _of_occasions(cohort, row, values)
    return []


def _values(cohort: Cohort, row: pd.Series) -> tuple[pd.Series, str]:
    """Return the values that a ratio can be of, by recording, and their unit."""
    rows = rows_of(cohort.table, str(row["source"]))
    label = column(rows, str(row["quantity"]))
    values = rows[label].astype(float)
    return values[np.isfinite(values) & (values > 0)], unit(split_unit(label)[1])


def _of_groups(cohort: Cohort, row: pd.Series, values: pd.Series, units: str) -> list[Dot]:
    group = {result.name: result.group for result in cohort.results}
    pair_values = values[[group[name] in (cohort.reference, row["other"]) for name in values.index]]
    logs = np.log(pair_values).groupby(pair_values.index.map(cohort.subjects), sort=False).mean()
    group_of = {cohort.subjects[name]: group[name] for name in pair_values.index}
    center = logs[[group_of[animal] == cohort.reference for animal in logs.index]].mean()
    return [
        Dot(value, group_of[animal], animal, f"{animal}: {number(value * float(np.exp(center)))} {units}".rstrip())
        for animal, value in np.exp(logs - center).items()
    ]


def _of_occasions(cohort: Cohort, row: pd.Series, values: pd.Series) -> list[Dot]:
    ratios = _changes(cohort, row, values)
    group = {cohort.subjects[result.name]: result.group for result in cohort.results}
    center = 1.0
    if row["what"] == "interaction":
        ratios = {
            animal: ratio for animal, ratio in ratios.items() if group[animal] in (row["reference"], row["other"])
        }
        before = [np.log(ratio) for animal, ratio in ratios.items() if group[animal] == row["reference"]]
        if not before:
            return []
        center = float(np.exp(np.mean(before)))
    return [
        Dot(ratio / center, group[animal], animal, f"{animal}: {number(ratio)}") for animal, ratio in ratios.items()
    ]


def _changes(cohort: Cohort, row: pd.Series, values: pd.Series) -> Mapping[str, float]:
    """Return the ratio between the two occasions of a row of every animal that has both."""
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
    called = {level: (f"{second.name} {level}", f"{level}/{base}") for level in later_levels}
    later = next((level for level, names in called.items() if {row["other"], row["change"]} & {*names}), base)
    return {
        animal: float(np.exp(np.mean(logs[later]) - np.mean(logs[base])))
        for animal, logs in logs_by_animal.items()
        if base in logs and later in logs
    }
