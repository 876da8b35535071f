"""The animals below an effect of the forest plot, each as the ratio that the effect is of."""

from collections.abc import Mapping

import numpy as np
import pandas as pd

from vasowave.cohort.cohort import Cohort
from vasowave.cohort.table import column, rows_of
from vasowave.figures.forest import Dot
from vasowave.io.columns import split_unit
from vasowave.report.wording import number, unit


def animals_of(cohort: Cohort, row: pd.Series) -> list[Dot]:
    """Return the animals of a row of the primary comparison; none where an effect is no ratio that one animal has.

    Of groups each animal over the mean of the reference, of several recordings of an animal their mean. Of occasions
    each animal's own ratio, and of what groups differ in it that over the mean ratio of the reference.
    """
    values, units = _values(cohort, row)
    what = row.get("what", "groups")
    if what == "groups":
        return _of_groups(cohort, row, values, units)
    if what in ("factor", "interaction") and cohort.design.occasion:
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
    own = values[[group[name] in (cohort.reference, row["other"]) for name in values.index]]
    logs = np.log(own).groupby(own.index.map(cohort.subjects), sort=False).mean()
    of = {cohort.subjects[name]: group[name] for name in own.index}
    center = logs[[of[animal] == cohort.reference for animal in logs.index]].mean()
    return [
        Dot(value, of[animal], animal, f"{animal}: {number(value * float(np.exp(center)))} {units}".rstrip())
        for animal, value in np.exp(logs - center).items()
    ]


def _of_occasions(cohort: Cohort, row: pd.Series, values: pd.Series) -> list[Dot]:
    ratios = _changes(cohort, row, values)
    group = {cohort.subjects[result.name]: result.group for result in cohort.results}
    center = 1.0
    if row["what"] == "interaction":
        ratios = {animal: one for animal, one in ratios.items() if group[animal] in (row["reference"], row["other"])}
        before = [np.log(one) for animal, one in ratios.items() if group[animal] == row["reference"]]
        if not before:
            return []
        center = float(np.exp(np.mean(before)))
    return [Dot(one / center, group[animal], animal, f"{animal}: {number(one)}") for animal, one in ratios.items()]


def _changes(cohort: Cohort, row: pd.Series, values: pd.Series) -> Mapping[str, float]:
    """Return the ratio between the two occasions of a row of every animal that has both."""
    second = cohort.second
    if second is None:
        return {}
    of: dict[str, dict[str, list[float]]] = {}
    for name, value in values.items():
        if name in second.levels:
            of.setdefault(cohort.subjects[str(name)], {}).setdefault(second.levels[str(name)], []).append(np.log(value))
    base, *others = second.order
    called = {level: (f"{second.name} {level}", f"{level}/{base}") for level in others}  # as factor, and as change
    later = next((level for level, names in called.items() if {row["other"], row["change"]} & {*names}), base)
    return {
        animal: float(np.exp(np.mean(own[later]) - np.mean(own[base])))
        for animal, own in of.items()
        if base in own and later in own
    }
