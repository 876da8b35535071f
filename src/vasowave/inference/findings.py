"""What speaks against a posterior, or against the fit beside it: values with a code and numbers, not sentences."""

from collections.abc import Iterator, Mapping
from enum import StrEnum
from typing import NamedTuple

import numpy as np

HALVES = 0.5
"""Posterior SD by which the means of two independent halves of the draws may differ in any case."""

_CHANCE = 4.0  # standard errors of such a difference that are taken for chance
_SECOND = 0.05  # probability of all modes but the likeliest, from which they are worth a finding
_FAR = 3.0  # posterior SD between the fit's optimum and the posterior's mean
_BETTER = 4.0  # nats by which the fit's optimum may be likelier than the best draw, which is not quite the maximum
_COMPARED = ("wave_speed", "R_T")  # what fits and posteriors both determine


class Code(StrEnum):
    """What was found."""

    HALVES_DIFFER = "halves_differ"
    SEVERAL_MODES = "several_modes"
    FIT_ELSEWHERE = "fit_elsewhere"


class Finding(NamedTuple):
    """One finding.

    Attributes
    ----------
    code : Code
    numbers : dict of str to float
        ``halves_differ``: ``distance`` and the ``limit`` that it passes, posterior SD. ``several_modes``: ``modes`` and
        the ``share`` of the probability that the likeliest holds. ``fit_elsewhere``: ``distance``, the largest of wave
        speed and R_T between the fit's optimum and the posterior's mean, posterior SD, and ``nats``, by which the
        optimum's log-likelihood is above that of the best draw (negative: below).
    """

    code: Code
    numbers: dict[str, float]


class Optimum(NamedTuple):
    """The optimum of a fit: its log-likelihood (-inf if it cannot be simulated), and what follows from it."""

    log_likelihood: float
    quantities: Mapping[str, float]


def halves_limit(effective: float) -> float:
    """Return how far the means of two halves may be apart, posterior SD, by so many effective draws in all."""
    return max(HALVES, _CHANCE * 2.0 / float(np.sqrt(max(effective, 1.0))))


def findings(
    apart: float,
    effective: float,
    shares: np.ndarray,
    optimum: Optimum | None,
    best: float,
    draws: Mapping[str, np.ndarray],
) -> Iterator[Finding]:
    """Yield what was found.

    Parameters
    ----------
    apart, effective : float
        Distance of the halves, posterior SD, and effective number of draws.
    shares : array, shape (mode,)
        Probability of each mode.
    optimum : Optimum, optional
        Of the fit.
    best : float
        Log-likelihood of the best draw.
    draws : mapping
        Equally weighted draws of quantities by name.
    """
    if apart > halves_limit(effective):
        yield Finding(Code.HALVES_DIFFER, {"distance": apart, "limit": halves_limit(effective)})
    if 1.0 - shares.max() > _SECOND:
        yield Finding(Code.SEVERAL_MODES, {"modes": float(len(shares)), "share": float(shares.max())})
    if optimum is not None:
        logs = {name: np.log(draws[name]) for name in _COMPARED}
        distances = [abs(np.log(optimum.quantities[name]) - log.mean()) / log.std() for name, log in logs.items()]
        distance, nats = float(max(distances)), optimum.log_likelihood - best
        if distance > _FAR or nats > _BETTER:
            yield Finding(Code.FIT_ELSEWHERE, {"distance": distance, "nats": nats})
