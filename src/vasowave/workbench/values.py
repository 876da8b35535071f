"""Numbers as the page gets them: JSON knows none that is not finite."""

from math import isfinite


def number(value: float, digits: int = 6) -> float | None:
    """Return a number of so many digits, None where there is none."""
    return float(f"{value:.{digits}g}") if isfinite(value) else None
