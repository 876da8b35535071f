"""How large a difference is: importance index (eq. 20), Hedges' g."""

import numpy as np

from vasowave.descriptions import LEVEL
from vasowave.errors import InputError


def importance_index(reference: float, other: float) -> float:
    """Importance index η = (χ_other - χ_reference)/χ_reference (eq. 20); never below -1 for positive quantities."""
    return (other - reference) / reference


def importance_interval(reference: np.ndarray, other: np.ndarray, level: float = LEVEL) -> tuple[float, float]:
    """Return the interval of η of two groups' values: Fieller's, with Welch's degrees of freedom.

    NaN with fewer than two values in a group, without variation, or where the reference mean may be zero.
    """
    from scipy.special import stdtrit

    if min(len(reference), len(other)) < 2:
        return np.nan, np.nan
    mean, above = float(np.mean(reference)), float(np.mean(other))
    variances = [float(np.var(x, ddof=1)) / len(x) for x in (reference, other)]
    ratio = above / mean
    parts = ratio**2 * variances[0], variances[1]
    spread = parts[0] ** 2 / (len(reference) - 1) + parts[1] ** 2 / (len(other) - 1)
    if not spread > 0:
        return np.nan, np.nan
    t = stdtrit(sum(parts) ** 2 / spread, (1 + level) / 2)
    lead, rest = mean**2 - t**2 * variances[0], above**2 - t**2 * variances[1]
    if lead <= 0:
        return np.nan, np.nan
    root = np.sqrt((mean * above) ** 2 - lead * rest)
    low, high = sorted(((mean * above - root) / lead, (mean * above + root) / lead))
    return low - 1, high - 1


def hedges_g(x: np.ndarray, y: np.ndarray, level: float = LEVEL) -> tuple[float, float, float]:
    """Hedges' g of y against x with its interval, by inverting the noncentral t distribution (equal variances).

    Raises
    ------
    InputError
        Fewer than two values in a group, or no variation in either.
    """
    from scipy.optimize import brentq
    from scipy.special import gammaincinv, ndtr

    if min(len(x), len(y)) < 2:
        raise InputError("Hedges' g needs two values in each group")
    freedom = len(x) + len(y) - 2
    pooled = np.sqrt(((len(x) - 1) * x.var(ddof=1) + (len(y) - 1) * y.var(ddof=1)) / freedom)
    if not pooled > 0:
        raise InputError("Hedges' g needs variation within a group")
    scale = np.sqrt(1 / len(x) + 1 / len(y))
    t = float((y.mean() - x.mean()) / pooled / scale)

    # The noncentral t distribution, averaged over the pooled SD; SciPy's own is NaN far out in its tail.
    turn = (np.arange(400) + 0.5) * np.pi / 400  # quantiles that crowd towards 0 and 1, where the tails are
    sd = np.sqrt(2 * gammaincinv(freedom / 2, 0.5 * (1 - np.cos(turn))) / freedom)
    share = np.sin(turn) / np.sin(turn).sum()

    def center(tail: float) -> float:
        reach = 10 + 5 * abs(t)
        return float(brentq(lambda shift: (share * ndtr(t * sd - shift)).sum() - tail, t - reach, t + reach))

    correction = (1 - 3 / (4 * freedom - 1)) * scale
    return correction * t, correction * center((1 + level) / 2), correction * center((1 - level) / 2)
