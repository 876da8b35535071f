"""Importance weights, smoothed by the tail they belong to, and what their tail says (PSIS).

Vehtari, Simpson, Gelman, Yao & Gabry, J. Mach. Learn. Res. 25 (2024), 72: the largest weights are replaced by quantiles
of a generalized Pareto distribution, whose shape k tells whether weighted means can be trusted. Its fit is that of
Zhang & Stephens, Technometrics 51 (2009), 316.
"""

from typing import NamedTuple

import numpy as np

MIN_TAIL_DRAWS = 5  # with fewer weights in the tail no distribution is fitted


MAX_PARETO_K = 0.7
"""Pareto k above which weighted means need not converge."""

EQUAL_WEIGHT_SHARE = 0.9
"""Share of the draws that are effective above which weights differ too little for the shape of their tail to matter."""


def trusted(k_hat: float, share: float) -> bool:
    """Whether weighted draws may be believed, from Pareto k and the share of effective draws."""
    return k_hat <= MAX_PARETO_K or share > EQUAL_WEIGHT_SHARE


class ImportanceWeights(NamedTuple):
    """Logarithms of weights that add up to 1, the shape k of their tail, and the effective number of draws."""

    log_weight: np.ndarray
    k_hat: float
    effective: float

    @property
    def trusted(self) -> bool:
        """Whether the draws may be believed."""
        return trusted(self.k_hat, self.effective / len(self.log_weight))


def smoothed(log_ratio: np.ndarray) -> ImportanceWeights:
    """Return Pareto-smoothed weights from logarithms of density ratios, shape (draw,); -inf is a weight of 0."""
    log = log_ratio - np.max(log_ratio)
    count = len(log)
    tail = min(int(np.ceil(min(0.2 * count, 3 * np.sqrt(count)))), int(np.isfinite(log).sum()) - 1)
    k_hat = np.inf
    if tail >= MIN_TAIL_DRAWS:
        order = np.argsort(log)
        cut, largest = log[order[-tail - 1]], order[-tail:]
        k_hat, scale = _pareto(np.exp(log[largest]) - np.exp(cut))
        if np.isfinite(k_hat):
            even = (np.arange(tail) + 0.5) / tail
            log[largest] = np.log(_quantile(even, k_hat, scale) + np.exp(cut))
            log = np.minimum(log, 0.0)
    log -= np.log(np.exp(log - log.max()).sum()) + log.max()
    return ImportanceWeights(log, float(k_hat), float(1 / np.exp(2 * log).sum()))


def _pareto(excess: np.ndarray) -> tuple[float, float]:
    """Return shape and scale of the generalized Pareto distribution behind sorted positive excesses."""
    count = len(excess)
    if excess[-1] <= 1e-12 or excess[0] < 0:  # equal weights have no tail
        return -np.inf, 0.0
    grid = 30 + int(np.sqrt(count))
    quartile = max(excess[int(count / 4 + 0.5) - 1], 1e-300)
    b = 1 / excess[-1] + (1 - np.sqrt(grid / (np.arange(1, grid + 1) - 0.5))) / (3 * quartile)
    shape = np.log1p(-b[:, np.newaxis] * excess).mean(axis=1)
    with np.errstate(invalid="ignore", divide="ignore"):
        likelihood = count * (np.log(-b / shape) - shape - 1)
    likelihood = np.where(np.isfinite(likelihood), likelihood, -np.inf)
    weight = np.exp(likelihood - likelihood.max())
    mean = float(weight @ b / weight.sum())
    k = float(np.log1p(-mean * excess).mean())
    return (count * k + 10 * 0.5) / (count + 10), -k / mean  # a weak prior towards 0.5 steadies few excesses


def _quantile(share: np.ndarray, k: float, scale: float) -> np.ndarray:
    if abs(k) < 1e-8:
        return -scale * np.log1p(-share)
    return scale * np.expm1(-k * np.log1p(-share)) / k
