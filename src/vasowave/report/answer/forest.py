"""The rows of the forest plot: groups against each other, or one animal against its own data."""

from textwrap import wrap

import numpy as np
import pandas as pd

from vasowave.animal.result import AnimalResult
from vasowave.cohort.cohort import Cohort
from vasowave.cohort.primary import Family, Primary
from vasowave.figures.forest import Point, Row
from vasowave.figures.style import short
from vasowave.quantities import INDICES, question_of
from vasowave.report.answer.dots import animals_of
from vasowave.report.answer.groups import Called, effect_of
from vasowave.report.wording import p_value, probability, ratio_with_interval, value_text

_FROM_DATA = {"wave_speed": "up-slope of pressure and flow", "R_T": "mean pressure above the wedge's over mean flow",
              "tau": "diastolic decay"}  # fmt: skip
"""What the recording alone says of a quantity, at the same pressure and of the same part; others are not the same."""

_MAX_LETTERS = 38  # of a line above rows


def group_rows(cohort: Cohort, primary: Primary, called: Called) -> list[Row]:
    """Return one row for each quantity and group, every animal as a multiple of the reference group's mean."""
    # Questions stay together, whichever groups they are about; the effects of a design are asked one after the other.
    order = {question: place for place, question in enumerate(primary.rows["question"].unique())}
    rows = primary.rows.assign(effect=[effect_of(row) for _, row in primary.rows.iterrows()])
    order |= {effect: place for place, effect in enumerate(rows["effect"].unique())}
    several = rows["effect"].nunique() > 1
    by = ["effect", "question"] if "what" in rows and several else ["question", "effect"]
    rows = rows.sort_values(by, key=lambda one: one.map(order), kind="stable")
    return [_group_row(cohort, primary, row, called, several) for _, row in rows.iterrows()]


def _group_row(cohort: Cohort, primary: Primary, row: pd.Series, called: Called, several: bool) -> Row:
    name, effect = str(row["quantity"]), effect_of(row)
    size = ratio_with_interval(row["ratio"], row["low"], row["high"])
    tip = f"{called(name)}: {effect} {size} ({row['source']}), {'no p' if row['untested'] else probability(row['p'])}"
    beside = primary.others
    if len(beside):
        same = [effect_of(one) == effect for _, one in beside.iterrows()]
        beside = beside[np.array(same) & (beside["quantity"] == name)]
    p = "no p" if row["untested"] else p_value(row["p"])
    point = Point(row["ratio"], row["low"], row["high"], str(row["source"]), tip)
    further = [_beside(one, called) for _, one in beside.iterrows()]
    return Row(_heading(row, several), called(name), size, p, point, further, animals_of(cohort, row))


def _heading(row: pd.Series, several: bool) -> str:
    """Return what rows are about: the question, with the other group if there are several; of a design the effect."""
    if not several:
        return str(row["question"])
    if "what" not in row:
        return f"{row['question']}: {short(str(row['other']), 20)}"
    sides = " / ".join(short(side, _MAX_LETTERS) for side in (str(row["other"]), str(row["reference"])) if side)
    said = f"{row['change']}: {sides}" if row.get("change") else sides
    return "\n".join(wrap(said, _MAX_LETTERS, break_long_words=False))


def _beside(one: pd.Series, called: Called) -> Point:
    size = ratio_with_interval(one["ratio"], one["low"], one["high"])
    tip = f"{called(one['quantity'])}: {size} times ({one['source']} wall)"
    return Point(one["ratio"], one["low"], one["high"], str(one["source"]), tip)


def animal_rows(result: AnimalResult, law: str, family: Family, called: Called) -> list[Row]:
    """Return one row for each quantity of the model, as a multiple of the primary law's value."""
    data = result.laws[law].quantities
    names = dict.fromkeys(["R_T", *family.quantities])
    there = [name for name in names if name not in INDICES and name in data]
    questions = list(dict.fromkeys([*map(question_of, family.quantities), *map(question_of, there)]))
    there.sort(key=lambda name: questions.index(question_of(name)))
    return [_animal_row(result, law, name, called) for name in there]


def _animal_row(result: AnimalResult, law: str, name: str, called: Called) -> Row:
    value = result.laws[law].answers[name]
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
    value = result.laws[wall].answers[name]
    low, high = (float(value.attrs.get(f"interval_{end}", value)) / center for end in ("low", "high"))
    return Point(float(value) / center, low, high, wall, f"{called(name)}: {value_text(value)} ({wall} wall)")
