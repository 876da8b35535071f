"""What the groups of a cohort show: described, compared, and the animal that stands for each."""

import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd

from vasowave.animal.datasets import split_unit
from vasowave.cohort.statistics import describe, importance_index, leave_one_out, pairwise_contrasts, several_groups
from vasowave.errors import InputError

INDICES = ("HR", "CO", "mPAP", "sPAP", "dPAP", "pPAP", "PVR")
"""The measured indices of Table 1, compared as one family."""

_PARAMETERS = ("R_T", "C_T", "C_v", "C_p", "tau", "I_R", "a")
STIFFNESS = {"linear": "beta", "tangent": "p1_over_gamma"}


def family(source: str) -> tuple[str, ...]:
    """Return the quantities of a source that are compared between groups: those of the paper's "ParAll_change"."""
    return INDICES if source == "measured" else (STIFFNESS.get(source, "stiffness"), *_PARAMETERS)


@dataclass(frozen=True, eq=False)
class Comparison:
    """The groups compared by one source of numbers; Holm runs over all its rows.

    Attributes
    ----------
    contrasts : DataFrame
        From `cohort.pairwise_contrasts`: one row per pair of groups and quantity.
    without_one : DataFrame
        From `cohort.leave_one_out` with the names of animals; empty where groups are too small.
    all_groups : DataFrame
        From `cohort.several_groups`; empty for two groups.
    left_out : dict of str to str
        Quantities and groups that could not be compared, and why.
    """

    contrasts: pd.DataFrame
    without_one: pd.DataFrame
    all_groups: pd.DataFrame
    left_out: dict[str, str]


def column(table: pd.DataFrame, name: str) -> str:
    """Return the column of a quantity, ``NAME [unit]``; empty if there is none."""
    return next((label for label in table.columns if split_unit(label)[0] == name), "")


def columns(table: pd.DataFrame, names: Sequence[str]) -> list[str]:
    """Return the columns of those quantities that there are."""
    return [label for name in names if (label := column(table, name))]


def rows_of(table: pd.DataFrame, source: str) -> pd.DataFrame:
    """Return the rows of one source, indexed by animal."""
    return table[table["source"] == source].set_index("animal")


def compare(table: pd.DataFrame, source: str) -> Comparison:
    """Compare all groups of two or more animals by the `family` of one source; the first group is the reference."""
    rows = rows_of(table, source)
    counts = rows["group"].value_counts(sort=False)
    left_out = {f"group {group}": "one animal has no scatter to compare with" for group in counts.index[counts < 2]}
    rows = rows[rows["group"].map(counts) >= 2]
    empty = pd.DataFrame()
    if rows["group"].nunique() < 2:
        return Comparison(empty, empty, empty, left_out)
    usable = []
    for label in columns(rows, family(source)):
        try:
            _strictly(pairwise_contrasts, rows, [label])
            usable.append(label)
        except InputError as error:
            left_out[label] = str(error)
    if not usable:
        return Comparison(empty, empty, empty, left_out)
    everyone = several_groups(rows, usable) if rows["group"].nunique() > 2 else empty
    return Comparison(pairwise_contrasts(rows, usable), _without_one(rows, usable), everyone, left_out)


def importance(table: pd.DataFrame, source: str, labels: dict[str, str]) -> pd.DataFrame:
    """Return η (eq. 20) of every group against the first, by quantity: ``quantity, source, group, eta``.

    Parameters
    ----------
    table : DataFrame
        From `cohort.cohort_table`, the reference group first.
    source : str
    labels : dict of str to str
        Name of the quantity to what it is called in the result.
    """
    rows, found = rows_of(table, source), []
    groups = rows["group"].unique().tolist()
    for label in columns(rows, tuple(labels)):
        means = rows.groupby("group", sort=False)[label].mean()
        for group in groups[1:]:
            eta = importance_index(means[groups[0]], means[group])
            if np.isfinite(eta):
                found.append((labels[split_unit(label)[0]], source, group, float(eta)))
    return pd.DataFrame(found, columns=["quantity", "source", "group", "eta"])


def described(table: pd.DataFrame, source: str, names: Sequence[str] | None = None) -> pd.DataFrame:
    """Return `cohort.describe` of one source, animals without the quantity left out; column ``source`` first."""
    rows = rows_of(table, source)
    labels = [label for label in table.columns if label not in ("animal", "group", "source")]
    parts = []
    for label in labels if names is None else columns(table, names):
        there = rows[np.isfinite(rows[label].astype(float))]
        if len(there):
            parts.append(describe(there, [label]))
    found = pd.concat(parts, ignore_index=True) if parts else pd.DataFrame(columns=["quantity", "group"])
    found.insert(0, "source", source)
    return found


def typical_animal(table: pd.DataFrame, group: str) -> str:
    """Return the animal of a group whose measured indices lie nearest to the group's medians, in their SDs."""
    rows = rows_of(table, "measured")
    rows = rows[rows["group"] == group]
    values = rows[columns(rows, INDICES)].to_numpy(float)
    scale = values.std(axis=0)
    away = (values - np.median(values, axis=0)) / np.where(scale > 0, scale, 1.0)
    return str(rows.index[int(np.argmin((away**2).sum(axis=1)))])


def _strictly(test: Callable[..., pd.DataFrame], *arguments: object) -> pd.DataFrame:
    """Return what a test finds; values without any scatter, on which it can only warn, are an `InputError`."""
    with warnings.catch_warnings():
        warnings.simplefilter("error", RuntimeWarning)
        try:
            return test(*arguments)
        except RuntimeWarning:
            raise InputError("the values hardly vary within the groups; there is nothing to test") from None


def _without_one(rows: pd.DataFrame, usable: list[str]) -> pd.DataFrame:
    """Leave out every animal in turn, for every pair of groups; Holm runs over the quantities of the pair."""
    groups = rows["group"].unique().tolist()
    parts = []
    for place, reference in enumerate(groups):
        for other in groups[place + 1 :]:
            labels = [label for label in usable if _can_lose_one(rows, label, reference, other)]
            if not labels:
                continue
            part = leave_one_out(rows, labels, reference, other)
            part.insert(0, "reference", reference)
            part.insert(1, "other", other)
            parts.append(part)
    return pd.concat(parts, ignore_index=True) if parts else pd.DataFrame()


def _can_lose_one(rows: pd.DataFrame, label: str, reference: str, other: str) -> bool:
    """Whether there is something to test without any one animal: not so with two, or with no scatter among the rest."""
    try:
        _strictly(leave_one_out, rows, [label], reference, other)
    except InputError:
        return False
    return True
