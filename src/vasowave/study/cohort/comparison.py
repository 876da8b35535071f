"""The groups of a cohort by one source of numbers, measured or of one wall law: means with intervals, and compared."""

import warnings
from collections.abc import Callable
from dataclasses import dataclass
from itertools import combinations

import numpy as np
import pandas as pd

from vasowave.base.descriptions import LEVEL
from vasowave.base.errors import InputError
from vasowave.pulse.quantities import COMPARED, INDICES
from vasowave.study.cohort.cohort import Cohort
from vasowave.study.cohort.estimates import Estimates
from vasowave.study.cohort.independent import known_values
from vasowave.study.cohort.pooling import Interval, LogEstimate, pooled_mean
from vasowave.study.cohort.table import column, columns, rows_of
from vasowave.study.cohort.two_groups import (
    holm,
    importance_index,
    importance_interval,
    leave_one_out,
    pairwise_contrasts,
)


@dataclass(frozen=True, eq=False)
class SourceComparison:
    """The groups compared by one source of numbers; Holm runs over all its rows."""

    contrasts: pd.DataFrame
    """From `pairwise_contrasts`: one row per pair of groups and quantity."""
    without_one: pd.DataFrame
    """From `leave_one_out` with the names of animals; empty where groups are too small."""
    left_out: dict[str, str]
    """Quantities and groups that could not be compared, and why."""


def family(cohort: Cohort, source: str) -> tuple[str, ...]:
    """Return the quantities of a source that are compared between groups."""
    return INDICES if source == "measured" else (cohort.law(source).stiffness, *COMPARED)


def compare(cohort: Cohort, source: str) -> SourceComparison:
    """Compare all groups of two or more animals by the `family` of one source; the first group is the reference."""
    rows = rows_of(cohort.table, source)
    counts = rows["group"].value_counts(sort=False)
    left_out = {f"group {group}": "one animal has no scatter to compare with" for group in counts.index[counts < 2]}
    rows = rows[rows["group"].map(counts) >= 2]
    labels = columns(rows, family(cohort, source)) if rows["group"].nunique() > 1 else []
    results = {label: _tested(pairwise_contrasts, rows, [label]) for label in labels}
    left_out |= {label: result for label, result in results.items() if isinstance(result, str)}
    tables = {label: result for label, result in results.items() if not isinstance(result, str)}
    if not tables:
        return SourceComparison(pd.DataFrame(), pd.DataFrame(), left_out)
    table = pd.concat(tables.values()).sort_index(kind="stable", ignore_index=True)  # pair of groups by pair of groups
    table["p Holm"] = holm(table["p"].to_numpy())
    return SourceComparison(table, _without_one(rows, list(tables)), left_out)


def importance(cohort: Cohort, source: str, labels: dict[str, str]) -> pd.DataFrame:
    """Return η (eq. 20) of every group to the first and its interval: ``quantity, source, group, eta, low, high``.

    Parameters
    ----------
    cohort : Cohort
    source : str
    labels : dict of str to str
        Name of the quantity to what it is called in the result.
    """
    rows, reference = rows_of(cohort.table, source), cohort.reference
    compared_groups, indices = [group for group in cohort.groups if group != reference], []
    for name, called in labels.items():
        if label := column(rows, name):
            values = {group: rows[label][rows["group"] == group].dropna().to_numpy(float) for group in cohort.groups}
            means = {group: sample.mean() if len(sample) else np.nan for group, sample in values.items()}
            indices += [
                (called, source, compared_group, importance_index(means[reference], means[compared_group]),
                 *importance_interval(values[reference], values[compared_group]))
                for compared_group in compared_groups
            ]  # fmt: skip
    table = pd.DataFrame(indices, columns=["quantity", "source", "group", "eta", "low", "high"])
    return table[np.isfinite(table["eta"].astype(float))].reset_index(drop=True)


def _tested(test: Callable[..., pd.DataFrame], *arguments: object) -> pd.DataFrame | str:
    """Return the table of a test, or why it cannot be made; one that could only warn about its values cannot."""
    with warnings.catch_warnings():
        warnings.simplefilter("error", RuntimeWarning)
        try:
            return test(*arguments)
        except InputError as error:
            return str(error)
        except RuntimeWarning:
            return "the values hardly vary within the groups; there is nothing to test"


def _without_one(rows: pd.DataFrame, labels: list[str]) -> pd.DataFrame:
    """Leave out every animal in turn, for every pair of groups and quantity that leaves something to test."""
    tables = []
    for reference, group in combinations(rows["group"].unique().tolist(), 2):
        for label in sorted(labels):
            table = _tested(leave_one_out, rows, [label], reference, group)
            if not isinstance(table, str):
                tables.append(table)
                table.insert(0, "reference", reference)
                table.insert(1, "other", group)
    return pd.concat(tables, ignore_index=True) if tables else pd.DataFrame()


def group_means(cohort: Cohort, source: str, name: str) -> dict[str, Interval]:
    """Return the geometric mean of a quantity of a source in every cell that has it, each interval by itself.

    Cells are the groups, or groups at an occasion or level (`Cohort.cells`).

    Animals are weighted by how well each is known, and what they share (`Estimates.shared`) is not averaged away; of
    several recordings of one animal the mean counts.
    Cells with a value that is not positive are left out.
    """
    means = {}
    for label, cell in cohort.cells.items():
        values = known_values(cohort, source, name, [cell.group], cell.results)
        if values is not None and len(values.results) and np.all(np.isfinite(values.estimates.logs)):
            means[label] = pooled(
                values.estimates.by_animal([cohort.subjects[result.name] for result in values.results])
            )
    return means


def pooled(estimates: Estimates) -> Interval:
    """Return the geometric mean of animals with its interval of 95 % (Hartung and Knapp; Satterthwaite's t)."""
    if len(estimates.logs) < 2 or (not np.any(estimates.errors) and np.ptp(estimates.logs) < 1e-9):
        return Interval(float(np.exp(estimates.logs.mean())), np.nan, np.nan)
    mean = pooled_mean(estimates.logs, estimates.errors)
    common = float((estimates.covariance - np.diag(estimates.errors**2)).mean())
    variance = mean.error**2 + common
    freedom = mean.freedom * (variance / mean.error**2) ** 2
    return LogEstimate(mean.value, float(np.sqrt(variance)), freedom).ratio((1 + LEVEL) / 2)
