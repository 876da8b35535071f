"""What speaks against a posterior, or against the fit beside it: values with a code and numbers."""

from collections.abc import Iterator, Mapping
from typing import NamedTuple

import numpy as np

from vasowave.base.findings import Finding, look_kind

MAX_HALF_DIFFERENCE = 0.5
"""Posterior SD by which the means of two independent halves of the draws may differ in any case."""

_CHANCE_SD = 4.0  # standard errors of such a difference that are taken for chance
_MIN_MODE_PROBABILITY = 0.05  # probability of all modes but the likeliest, from which they are worth a finding
_MAX_OPTIMUM_DISTANCE = 3.0  # posterior SD between the fit's optimum and the posterior's mean
_MAX_OPTIMUM_NATS = 4.0
"""Nats by which the fit's optimum may be likelier than the best draw, which is not quite the maximum."""
_COMPARED_QUANTITIES = ("wave_speed", "R_T")  # what fits and posteriors both determine
_MIN_COMPARED_SD = 1e-9  # SD of the logarithm of one that held parameters do not fix: rounding


_DOUBT_TEXT = "Do not believe these numbers: {}. There may be a mode that neither holds. {{remedy}}"
_RESTART_REMEDY = "Start from a fit with many starts, take another seed, or give narrower priors."
HALVES_DIFFER = look_kind(
    "posterior.halves-differ",
    _DOUBT_TEXT.format(
        "two independent halves of the search differ by {distance:.1f} posterior SD, where chance explains {limit:.1f}"
    ),
    _RESTART_REMEDY,
)
HALF_EMPTY = look_kind(
    "posterior.half-empty",
    _DOUBT_TEXT.format("one of two independent halves of the search found nothing"),
    _RESTART_REMEDY,
)
SEVERAL_MODES = look_kind(
    "posterior.several-modes",
    "The recording has {modes:.0f} separate explanations; the likeliest holds {share:.0%} of the probability, and "
    "intervals span all of them.",
    "Look at the draws: what the modes differ in is not determined.",
)
_DISTANCE_TEXT = "The fit's optimum lies {distance:.1f} posterior SD away (wave speed or R_T) and is "
FIT_LIKELIER = look_kind(
    "posterior.fit-likelier",
    f"{_DISTANCE_TEXT}likelier than every draw, by {{nats:.1f}} nats of the log-likelihood: the priors keep the "
    "posterior away from it. Either they or the fit are wrong for this animal.",
    "Question the priors (radii, pressure of the image, zero) and the bounds of the fit.",
)
FIT_ELSEWHERE = look_kind(
    "posterior.fit-elsewhere",
    f"{_DISTANCE_TEXT}less likely than the best draw, by {{nats:.1f}} nats of the log-likelihood: the fit ended "
    "elsewhere, or explains by the wall what may be geometry. {remedy}",
    "Fit again with more starts.",
)


class FitOptimum(NamedTuple):
    """The optimum of a fit: its log-likelihood (-inf if it cannot be simulated), and what follows from it."""

    log_likelihood: float
    quantities: Mapping[str, float]


def halves_limit(effective: float) -> float:
    """Return how far the means of two halves may be apart, posterior SD, by so many effective draws in all."""
    return max(MAX_HALF_DIFFERENCE, _CHANCE_SD * 2.0 / float(np.sqrt(max(effective, 1.0))))


def findings(
    halves_distance: float,
    effective: float,
    shares: np.ndarray,
    optimum: FitOptimum | None,
    best: float,
    draws: Mapping[str, np.ndarray],
) -> Iterator[Finding]:
    """Yield what was found.

    Parameters
    ----------
    halves_distance, effective : float
        Distance of the halves, posterior SD, and effective number of draws.
    shares : array, shape (mode,)
        Probability of each mode.
    optimum : FitOptimum, optional
        Of the fit.
    best : float
        Log-likelihood of the best draw.
    draws : mapping
        Equally weighted draws of quantities by name.
    """
    if halves_distance > halves_limit(effective):
        differ = HALVES_DIFFER(distance=halves_distance, limit=halves_limit(effective))
        yield differ if np.isfinite(halves_distance) else HALF_EMPTY()
    if 1.0 - shares.max() > _MIN_MODE_PROBABILITY:
        yield SEVERAL_MODES(modes=len(shares), share=float(shares.max()))
    if optimum is not None:
        logs = {name: np.log(draws[name]) for name in _COMPARED_QUANTITIES}
        distances = [
            float(abs(np.log(optimum.quantities[name]) - log.mean()) / log.std())
            for name, log in logs.items()
            if log.std() > _MIN_COMPARED_SD
        ]
        distance, nats = max(distances, default=0.0), optimum.log_likelihood - best
        if distance > _MAX_OPTIMUM_DISTANCE or nats > _MAX_OPTIMUM_NATS:
            away = FIT_LIKELIER if nats > 0 else FIT_ELSEWHERE
            yield away(distance=distance, nats=abs(nats))
