"""The rows of the forest plot: groups against each other, or one animal against its own data."""

import numpy as np
import pandas as pd

from vasowave.animal.result import AnimalResult
from vasowave.cohort.cohort import Cohort
from vasowave.cohort.primary import Family, Primary
from vasowave.cohort.table import column, rows_of
from vasowave.figures.forest import Dot, Point, Row
from vasowave.figures.style import short
from vasowave.io.columns import split_unit
from vasowave.quantities import INDICES, question_of
from vasowave.report.answer.groups import Called, effect_of
from vasowave.report.wording import number, p_value, probability, ratio_with_interval, unit, value_text

_FROM_DATA = {"wave_speed": "up-slope of pressure and flow", "R_T": "mean pressure above the wedge's over mean flow",
              "tau": "diastolic decay"}  # fmt: skip
"""What the recording alone says of a quantity, at the same pressure and of the same part; others are not the same."""


def group_rows(cohort: Cohort, primary: Primary, called: Called) -> list[Row]:
    """Return one row for each quantity and group, every animal as a multiple of the reference group's mean."""
    # Questions stay together, whichever groups they are about.
    order = {question: place for place, question in enumerate(primary.rows["question"].unique())}
    rows = primary.rows.assign(effect=[effect_of(row) for _, row in primary.rows.iterrows()])
    order |= {effect: place for place, effect in enumerate(rows["effect"].unique())}
    several = rows["effect"].nunique() > 1
    rows = rows.sort_values(["question", "effect"], key=lambda one: one.map(order), kind="stable")
    return [_group_row(cohort, primary, row, called, several) for _, row in rows.iterrows()]


def _group_row(cohort: Cohort, primary: Primary, row: pd.Series, called: Called, several: bool) -> Row:
    name, other = str(row["quantity"]), str(row["other"])
    size = ratio_with_interval(row["ratio"], row["low"], row["high"])
    designed = "what" in row
    effect = effect_of(row)
    heading = (
        f"{row['question']}{f': {short(effect if designed else other, 30 if designed else 20)}' if several else ''}"
    )
    tip = f"{called(name)}: {effect} {size} ({row['source']}), {'no p' if row['untested'] else probability(row['p'])}"
    beside = primary.others
    if len(beside):
        same = [effect_of(one) == effect for _, one in beside.iterrows()]
        beside = beside[np.array(same) & (beside["quantity"] == name)]
    p = "no p" if row["untested"] else p_value(row["p"])
    point = Point(row["ratio"], row["low"], row["high"], str(row["source"]), tip)
    dots = _dots(cohort, str(row["source"]), name, other) if row.get("what", "groups") == "groups" else []
    return Row(heading, called(name), size, p, point, [_beside(one, called) for _, one in beside.iterrows()], dots)


def _beside(one: pd.Series, called: Called) -> Point:
    size = ratio_with_interval(one["ratio"], one["low"], one["high"])
    tip = f"{called(one['quantity'])}: {size} times ({one['source']} wall)"
    return Point(one["ratio"], one["low"], one["high"], str(one["source"]), tip)


def _dots(cohort: Cohort, source: str, name: str, other: str) -> list[Dot]:
    rows = rows_of(cohort.table, source)
    label = column(rows, name)
    units = unit(split_unit(label)[1])
    values = rows[label].astype(float)
    values = values[np.isfinite(values) & (values > 0) & rows["group"].isin([cohort.reference, other])]
    center = float(np.exp(np.log(values[rows["group"] == cohort.reference]).mean()))
    return [
        Dot(value / center, group, animal, f"{animal}: {number(value)} {units}".rstrip())
        for animal, group, value in zip(
            map(str, values.index), rows["group"][values.index], values.tolist(), strict=True
        )
    ]


def animal_rows(result: AnimalResult, law: str, family: Family, called: Called) -> list[Row]:
    """Return one row for each quantity of the model, as a multiple of the primary law's value."""
    data = result.laws[law].quantities
    names = dict.fromkeys(["R_T", *family.quantities])
    there = [name for name in names if name not in INDICES and name in data]
    questions = list(dict.fromkeys([*map(question_of, family.quantities), *map(question_of, there)]))
    there.sort(key=lambda name: questions.index(question_of(name)))
    return [_animal_row(result, law, name, called) for name in there]


def _animal_row(result: AnimalResult, law: str, name: str, called: Called) -> Row:
    value = result.laws[law].quantities[name]
    center = float(value)
    beside = [_relative(result, wall, name, center, called) for wall in result.laws if wall != law]
    measured, waves = result.measured.quantities, result.measured.waves
    elsewhere = name == "wave_speed" and waves.attrs["area_and_wave_speed_at"] != "mean pressure"  # the paper's
    if name in _FROM_DATA and name in measured and not elsewhere:
        alone = float(measured[name])
        tip = f"{called(name)} from the recording alone ({_FROM_DATA[name]}): {value_text(measured[name])}"
        beside.append(Point(alone / center, alone / center, alone / center, "data", tip))
    point = _relative(result, law, name, center, called)
    return Row(question_of(name), called(name), value_text(value), "", point, beside)


def _relative(result: AnimalResult, wall: str, name: str, center: float, called: Called) -> Point:
    value = result.laws[wall].quantities[name]
    low, high = (float(value.attrs.get(f"interval_{end}", value)) / center for end in ("low", "high"))
    return Point(float(value) / center, low, high, wall, f"{called(name)}: {value_text(value)} ({wall} wall)")
