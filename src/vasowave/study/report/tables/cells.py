"""The cells of a cohort's tables: symbols, mean ± SD, intervals, ranges."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr

from vasowave.study.animal.result import AnimalResult
from vasowave.study.cohort.cohort import Cohort
from vasowave.study.report.wording import name_and_unit, number, with_error, with_interval

_SUBSCRIPTS = {"_0": "₀", "_1": "₁", "_2": "₂", "cm2": "cm²"}


def symbols(cohort: Cohort) -> dict[str, str]:
    """Return the symbol of every quantity of a cohort, as people write it."""
    return {name: _symbol(plain) for name, plain in cohort.symbols.items()}


def _symbol(text: str) -> str:
    for plain, written in _SUBSCRIPTS.items():
        text = text.replace(plain, written)
    return text


def animal_cells(result: AnimalResult) -> dict[str, object]:
    """Return the first two cells of a row about an animal."""
    return {"animal": result.name, "group": result.group}


def named(results: Sequence[AnimalResult]) -> str:
    """Return the animals by name."""
    return ", ".join(result.name for result in results)


def nearest(cohort: Cohort) -> str:
    """Return which animal of each group is shown; where groups are crossed also at which occasion or level."""
    occasion = f" at {cohort.shown_at}" if cohort.shown_at else ""
    return f"the animal nearest to its group's medians{occasion}"


def source_title(source: str) -> str:
    """Return how a heading calls a source of numbers."""
    return "Measured indices" if source == "measured" else f"{source.capitalize()} wall"


def with_unit(label: object, written: dict[str, str]) -> str:
    """Return the symbol of a column's quantity with its unit."""
    name, unit = name_and_unit(label)
    return f"{written.get(name, name)} [{unit}]" if unit else written.get(name, name)


def mean_sd(row: pd.Series) -> str:
    """Return mean ± SD of a row of `describe`."""
    return with_error(float(row["mean"]), float(row["SD"]))


def median_iqr(row: pd.Series) -> str:
    """Return median and quartiles of a row of `describe`; of one animal its value."""
    if not np.isfinite(row["SD"]):
        return number(row["median"])
    return interval(row, "median", "Q1", "Q3")


def interval(row: Mapping[str, Any] | pd.Series | xr.Dataset, value: str, low: str, high: str) -> str:
    """Return a number with its interval from a row that has them by these names."""
    return with_interval(float(row[value]), float(row[low]), float(row[high]))


def span(values: np.ndarray, digits: int = 3) -> str:
    """Return the smallest and the largest value, once where they are the same."""
    low, high = number(float(values.min()), digits), number(float(values.max()), digits)
    return low if low == high else f"{low} to {high}"
