"""The single numbers of all animals as one table, the parts of it that a question is about, and their description."""

from collections.abc import Sequence

import numpy as np
import pandas as pd
import xarray as xr

from vasowave.base.errors import InputError
from vasowave.base.io.columns import split_unit
from vasowave.pulse.quantities import RECORDED
from vasowave.study.animal.result import AnimalResult


def cohort_table(results: Sequence[AnimalResult]) -> pd.DataFrame:
    """Return the single numbers of all animals: one row per animal and source (measured, and each wall law).

    Columns ``animal, group, source``, then one per quantity, ``NAME [unit]``; NaN where a source has no such quantity.

    Raises
    ------
    InputError
        Two animals of the same name, or a quantity in two units.
    """
    names = [result.name for result in results]
    for name in names:
        if names.count(name) > 1:
            raise InputError(f"two animals are called '{name}'; give every animal its own name")
    units: dict[str, str] = {}
    return pd.DataFrame(
        [
            {"animal": result.name, "group": result.group, "source": source}
            | _labelled(source_result.quantities, units, result.name)
            for result in results
            for source, source_result in result.sources.items()
        ]
    )


def _labelled(quantities: xr.Dataset, units: dict[str, str], animal: str) -> dict[str, float]:
    """Return the values by ``NAME [unit]``; `units` remembers the unit of every name."""
    row = {}
    for name, value in quantities.data_vars.items():
        unit = str(value.attrs.get("units", "1"))
        if units.setdefault(str(name), unit) != unit:
            raise InputError(f"'{name}' of animal '{animal}' is in {unit}, before in {units[str(name)]}")
        row[f"{name} [{unit}]"] = float(value)
    return row


def column(table: pd.DataFrame, name: str) -> str:
    """Return the column of a quantity, ``NAME [unit]``; empty if there is none, or these are no measured rows."""
    if name in RECORDED and not (table["source"] == "measured").all():
        return ""
    stored = RECORDED.get(name, name)
    return next((label for label in table.columns if split_unit(label)[0] == stored), "")


def columns(table: pd.DataFrame, names: Sequence[str]) -> list[str]:
    """Return the columns of those quantities that there are."""
    return [label for name in names if (label := column(table, name))]


def rows_of(table: pd.DataFrame, source: str) -> pd.DataFrame:
    """Return the rows of one source, indexed by animal."""
    return table[table["source"] == source].set_index("animal")


def values_of(table: pd.DataFrame, quantity: str, group: str) -> np.ndarray:
    """Return the values of one column in one group.

    Raises
    ------
    InputError
        The column is missing, the group has no animal, or a value is not finite.
    """
    if quantity not in table.columns or "group" not in table.columns:
        raise InputError(
            f"no column '{quantity}' or no column 'group'; there are: {', '.join(map(str, table.columns))}"
        )
    x = table.loc[table["group"] == group, quantity].to_numpy(dtype=float)
    if len(x) == 0 or not np.all(np.isfinite(x)):
        raise InputError(f"'{quantity}' of group '{group}' is empty or holds a value that is not finite")
    return x


def describe(table: pd.DataFrame, quantities: list[str]) -> pd.DataFrame:
    """Mean, SD, median and quartiles of every quantity in every group, in the unit of its column name.

    Parameters
    ----------
    table : DataFrame
        One row per animal, with a column ``group`` of any labels.
    quantities : list of str
        Columns to describe, named ``quantity [unit]``.

    Raises
    ------
    InputError
        A column that is missing or holds a value that is not finite.
    """
    rows = []
    for quantity in quantities:
        for label in table["group"].unique():
            x = values_of(table, quantity, label)
            q1, median, q3 = np.percentile(x, [25, 50, 75])
            sd = float(x.std(ddof=1)) if len(x) > 1 else float("nan")
            rows.append((quantity, label, len(x), x.mean(), sd, median, q1, q3))
    return pd.DataFrame(rows, columns=["quantity", "group", "n", "mean", "SD", "median", "Q1", "Q3"])


def described(table: pd.DataFrame, source: str, names: Sequence[str] | None = None) -> pd.DataFrame:
    """Return `describe` of one source, animals without the quantity left out; column ``source`` first.

    Parameters
    ----------
    table : DataFrame
        From `cohort_table`.
    source : str
    names : sequence of str, optional
        Of quantities; by default all.
    """
    rows = rows_of(table, source)
    labels = [label for label in rows.columns if label not in ("group", "source")]
    tables = [
        describe(finite_rows, [label])
        for label in (labels if names is None else columns(rows, names))
        if len(finite_rows := rows[np.isfinite(rows[label].astype(float))])
    ]
    description = pd.concat(tables, ignore_index=True) if tables else pd.DataFrame(columns=["quantity", "group"])
    description.insert(0, "source", source)
    return description
