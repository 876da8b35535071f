"""How the tables of a cohort write their cells: symbols, mean ± SD, intervals, ranges."""

from collections.abc import Sequence

import numpy as np
import pandas as pd
import xarray as xr

from vasowave.report.wording import name_and_unit, number

_SUBSCRIPTS = {"_0": "₀", "_1": "₁", "_2": "₂", "cm2": "cm²"}


def symbols(trees: Sequence[xr.DataTree]) -> dict[str, str]:
    """Return the symbol of every quantity of the trees, as people write it."""
    found: dict[str, str] = {}
    for tree in trees:
        for node in tree.children.values():
            for name, value in node["quantities"].data_vars.items() if "quantities" in node.children else ():
                text = str(value.attrs.get("symbol", name))
                for plain, written in _SUBSCRIPTS.items():
                    text = text.replace(plain, written)
                found.setdefault(str(name), text)
    return found


def meanings(trees: Sequence[xr.DataTree]) -> dict[str, str]:
    """Return what every quantity of the trees is, with the paper's equation."""
    found: dict[str, str] = {}
    for tree in trees:
        for node in reversed(list(tree.children.values())):  # the models first: theirs is the general meaning
            for name, value in node["quantities"].data_vars.items() if "quantities" in node.children else ():
                equation = value.attrs.get("equation")
                where = "" if not equation else f" ({equation})" if "Table" in equation else f" (eq. {equation})"
                found.setdefault(str(name), f"{value.attrs.get('long_name', name)}{where}")
    return found


def who(tree: xr.DataTree) -> dict[str, object]:
    """Return the first two cells of a row about an animal."""
    return {"animal": str(tree.attrs["animal"]), "group": str(tree.attrs["group"])}


def names(trees: Sequence[xr.DataTree]) -> str:
    """Return the animals by name."""
    return ", ".join(str(tree.attrs["animal"]) for tree in trees)


def source_title(source: str) -> str:
    """Return how a heading calls a source of numbers."""
    return "Measured indices" if source == "measured" else f"{source.capitalize()} wall"


def with_unit(label: object, written: dict[str, str]) -> str:
    """Return the symbol of a column's quantity with its unit."""
    name, unit = name_and_unit(label)
    return f"{written.get(name, name)} [{unit}]" if unit else written.get(name, name)


def mean_sd(row: pd.Series) -> str:
    """Return mean ± SD of a row of `cohort.describe`."""
    return number(row["mean"]) + (f" ± {number(row['SD'], 2)}" if np.isfinite(row["SD"]) else "")


def median_iqr(row: pd.Series) -> str:
    """Return median and quartiles of a row of `cohort.describe`; of one animal its value."""
    if not np.isfinite(row["SD"]):
        return number(row["median"])
    return f"{number(row['median'])} [{number(row['Q1'])}, {number(row['Q3'])}]"


def interval(row: pd.Series, center: str, name: str) -> str:
    """Return an estimate with its interval from a row of `cohort.contrasts`."""
    return f"{number(row[center], 2)} [{number(row[f'{name} low'], 2)}, {number(row[f'{name} high'], 2)}]"


def span(values: np.ndarray, digits: int = 3) -> str:
    """Return the smallest and the largest value, once where they are the same."""
    low, high = number(float(values.min()), digits), number(float(values.max()), digits)
    return low if low == high else f"{low} to {high}"
