"""Numbers, units, names and the cells of tables as people write them."""

import math
import re
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr

from vasowave.base.descriptions import ROUNDING
from vasowave.base.io.columns import split_unit
from vasowave.study.animal.result import AnimalResult
from vasowave.study.cohort.cohort import Cohort
from vasowave.study.cohort.simultaneous_intervals import DRAWS

LIMIT = 0.05
"""Of p, below which a difference is said to be shown."""
ERROR_OF_DRAWS = math.sqrt(LIMIT * (1 - LIMIT) / DRAWS)
"""Standard error that a p near `LIMIT` has because it is the share of so many draws."""
OF_FLOW = " of flow (its pulse counted as the pressure's)"
"""Behind a residual in mmHg where the flow was compared."""
UNLIMITED = "[no limits]"
"""In place of an interval that says nothing."""
Row = tuple[str, ...]
_END_AT_ONE = re.compile(r"(\[|, )1(?:\.0*)?([,\]])")
_SUPERSCRIPT = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def number(value: Any, digits: int = 3) -> str:
    """Return a value as people write it: significant digits, never an exponent where a small one is avoidable."""
    if isinstance(value, bool | np.bool_):
        return "yes" if value else "no"
    if isinstance(value, int | np.integer):
        return str(int(value))
    if not isinstance(value, float | np.floating):
        return "" if value is None else str(value)
    value = float(value)
    if not math.isfinite(value):
        return "–"
    if value != 0 and not 1e-4 <= abs(value) < 1e5:
        mantissa, exponent = f"{value:.{digits - 1}e}".split("e")
        return f"{mantissa}·10" + str(int(exponent)).translate(_SUPERSCRIPT)
    decimals = max(0, digits - 1 - math.floor(math.log10(abs(value)))) if value else 0
    return f"{value:.{decimals}f}"


def with_error(value: float, error: float) -> str:
    """Return ``value ± error`` to the error's two leading digits: ``0.180 ± 0.030``, ``77 ± 21``; never rounding."""
    if not (math.isfinite(error) and error > ROUNDING * abs(value)):
        return number(value)
    if not 1e-4 <= max(abs(value), error) < 1e5:
        power = math.floor(math.log10(max(abs(value), error)))
        tens = "10" + str(power).translate(_SUPERSCRIPT)
        return f"({with_error(value / 10.0**power, error / 10.0**power)})·{tens}"
    decimals = _decimals(error)
    return f"{value:.{decimals}f} ± {error:.{decimals}f}"


def with_interval(value: float, low: float, high: float) -> str:
    """Return ``value [low, high]`` to two leading digits of the nearer end's distance: ``2.86 [1.76, 3.93]``.

    Ends that differ by rounding alone are no interval. Where they differ by more than a factor of ten, each number has
    two digits of its own: ``0.22 [0.0032, 15]``.
    """
    distance = max(min(value - low, high - value), (high - low) / 10)  # at a bound one end is the value
    if not (math.isfinite(high - low) and distance > ROUNDING * abs(value)):
        return number(value)
    if 0 < 10 * low < high:
        return f"{number(value, 2)} [{number(low, 2)}, {number(high, 2)}]"
    if not 1e-4 <= max(abs(value), distance) < 1e5:  # a value near 0 is as large as its interval
        power = math.floor(math.log10(max(abs(value), distance)))
        scaled = (bound / 10.0**power for bound in (value, low, high))
        return f"{with_interval(*scaled)}·10{str(power).translate(_SUPERSCRIPT)}"
    decimals = _decimals(distance)
    return f"{value:.{decimals}f} [{low:.{decimals}f}, {high:.{decimals}f}]"


def value_text(value: xr.DataArray, with_unit: bool = True) -> str:
    """Return a stored number with its interval, if known, and its unit."""
    low, high = value.attrs.get("interval_low"), value.attrs.get("interval_high")
    size = number(float(value)) if low is None or high is None else with_interval(float(value), float(low), float(high))
    return f"{size} {unit(str(value.attrs.get('units', '1')))}".rstrip() if with_unit else size


def p_value(p: float) -> str:
    """Return ``0.023``, two digits, or ``> 0.99``; ``≤ 0.0001`` where no cohort drawn without effects is as different.

    Where two standard errors of so many draws reach 0.05, so that other draws may put p on its other side: ``≈ 0.049``.
    """
    smallest_p = 1 / (DRAWS + 1)
    if p < 1.5 * smallest_p:
        return f"≤ {smallest_p:.4f}"
    if p > 0.99:
        return "> 0.99"
    return f"{'≈ ' if undecided(p) else ''}{number(float(p), 2)}"


def undecided(p: float) -> bool:
    """Whether other draws may put p on the other side of the limit: it is two of its standard errors away, or less."""
    return abs(p - LIMIT) < 2 * ERROR_OF_DRAWS


def probability(p: float) -> str:
    """Return ``p = 0.023``, ``p ≤ 0.0001`` or ``p ≈ 0.049``, as `p_value`."""
    size = p_value(p)
    return f"p {size}" if size[0] in "≤≈>" else f"p = {size}"


def ratio_with_interval(value: float, low: float, high: float) -> str:
    """Return ``2.10 [1.31, 3.37]``, or ``2.10 [no limits]``.

    An end that would be written as 1 gets the digits that show on which side of 1 it lies.
    """
    if unlimited(low, high):
        return f"{number(value)} {UNLIMITED}"
    text, nearest_end = with_interval(value, low, high), min(low, high, key=lambda end: abs(end - 1))
    for digits in range(3, 7):
        if not (match := _END_AT_ONE.search(text)):
            break
        text = f"{text[: match.start()]}{match[1]}{number(nearest_end, digits)}{match[2]}{text[match.end() :]}"
    return text


def unlimited(low: float, high: float) -> bool:
    """Whether the interval of a ratio reaches over a factor of a million, and so says nothing."""
    return high > 1e6 * low


def _decimals(error: float) -> int:
    """Return how many decimals show two leading digits of an error."""
    digits = 1 - math.floor(math.log10(error))
    if round(error, digits) >= 10.0 ** (2 - digits):  # 0.0996 is written 0.10
        digits -= 1
    return max(0, digits)


def unit(text: str) -> str:
    """Return a unit as people write it: cm2 becomes cm², that of a pure number nothing."""
    return "" if text == "1" else text.replace("cm2", "cm²").replace("mmHg2", "mmHg²").replace("s2", "s²")


def also_read(text: str) -> list[tuple[str, float]]:
    """Return units in which physiologists read a quantity beside its own, and how many of them are one of it."""
    return [("ml/min", 60.0)] if text == "ml/s" else []


def name_and_unit(label: object) -> tuple[str, str]:
    """Split the name of a column, ``"S [mmHg2]"``, into name and unit."""
    name, written = split_unit(str(label))
    return name, unit(written)


def column_label(label: object) -> str:
    """Return the name of a column as it stands in a header."""
    name, written = name_and_unit(label)
    return f"{name} [{written}]" if written else name


def table_rows(frame: pd.DataFrame, digits: int = 4) -> tuple[Row, list[Row]]:
    """Return header and rows of any table, numbers written as people do."""
    header = tuple(column_label(label) for label in frame.columns)
    return header, [tuple(number(value, digits) for value in row) for row in frame.itertuples(index=False)]


def friction_words(law: str, settings: Mapping[str, Any]) -> str:
    """Return a friction law and its settings in words: ``a boundary layer (local radius)``."""
    if law == "BoundaryLayer":
        radius = settings.get("reference_radius")
        return f"a boundary layer ({'local radius' if radius is None else f'fixed radius {number(radius)} cm'})"
    if law == "Poiseuille":
        return "Poiseuille flow"
    parameters = ", ".join(f"{key.replace('_', ' ')} {number(value)}" for key, value in settings.items())
    return {"PowerLaw": "a power-law profile"}.get(law, law) + (f" ({parameters})" if parameters else "")


def some_of(names: list[str], max_count: int) -> str:
    """Return the names as a list in words, or the first `max_count` and how many more there are, two at least."""
    surplus = len(names) - max_count
    return listed(names) if surplus <= 1 else f"{', '.join(names[:max_count])} and {surplus} more"


def listed(items: list[str]) -> str:
    """Return ``a, b and c``."""
    return " and ".join([", ".join(items[:-1]), items[-1]] if len(items) > 1 else items)


_SUBSCRIPTS = {"_0": "₀", "_1": "₁", "_2": "₂", "cm2": "cm²"}


def symbols(cohort: Cohort) -> dict[str, str]:
    """Return the symbol of every quantity of a cohort, as people write it."""
    written = {}
    for name, symbol in cohort.symbols.items():
        for plain, lowered in _SUBSCRIPTS.items():
            symbol = symbol.replace(plain, lowered)
        written[name] = symbol
    return written


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


def mean_sd(row: pd.Series, factor: float = 1.0) -> str:
    """Return mean ± SD of a row of `describe`, times a factor."""
    return with_error(factor * float(row["mean"]), factor * float(row["SD"]))


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
