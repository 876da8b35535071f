"""Numbers as the page gets them: JSON knows none that is not finite."""

from collections.abc import Iterable
from math import isfinite

from vasowave.pulse.quantities import INDICES, QUANTITIES

INDEX_UNITS = {name: QUANTITIES[name].unit for name in INDICES} | {"HR": "1/min"}
"""Units of the indices on the desks; the heart rate's is that of the table of animals."""


def number(value: float, digits: int = 6) -> float | None:
    """Return a number of so many digits, None where there is none."""
    return float(f"{value:.{digits}g}") if isfinite(value) else None


def numbers(values: Iterable[float]) -> list[float | None]:
    """Return each of some numbers likewise."""
    return [number(value) for value in values]
