"""Numbers, units and tables as people write them."""

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd

from vasowave.columns import split_unit

Row = tuple[str, ...]
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


def unit(text: str) -> str:
    """Return a unit as people write it: cm2 becomes cm², that of a pure number nothing."""
    return "" if text == "1" else text.replace("cm2", "cm²").replace("mmHg2", "mmHg²").replace("s2", "s²")


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
    own = ", ".join(f"{key.replace('_', ' ')} {number(value)}" for key, value in settings.items())
    return {"PowerLaw": "a power-law profile"}.get(law, law) + (f" ({own})" if own else "")


def listed(items: list[str]) -> str:
    """Return ``a, b and c``."""
    return " and ".join([", ".join(items[:-1]), items[-1]] if len(items) > 1 else items)
