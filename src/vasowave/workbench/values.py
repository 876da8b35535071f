"""Numbers as the page gets them: JSON knows none that is not finite."""

from collections.abc import Iterable
from math import isfinite


def number(value: float, digits: int = 6) -> float | None:
    """Return a number of so many digits, None where there is none."""
    return float(f"{value:.{digits}g}") if isfinite(value) else None


def numbers(values: Iterable[float]) -> list[float | None]:
    """Return each of some numbers likewise."""
    return [number(value) for value in values]
