"""Groups described: mean, SD, median and quartiles of every quantity."""

from collections.abc import Sequence

import numpy as np
import pandas as pd

from vasowave.cohort.table import columns, rows_of, values_of


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
    every = [label for label in rows.columns if label not in ("group", "source")]
    parts = [
        describe(there, [label])
        for label in (every if names is None else columns(rows, names))
        if len(there := rows[np.isfinite(rows[label].astype(float))])
    ]
    whole = pd.concat(parts, ignore_index=True) if parts else pd.DataFrame(columns=["quantity", "group"])
    whole.insert(0, "source", source)
    return whole
