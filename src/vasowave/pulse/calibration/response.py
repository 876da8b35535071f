"""An unknown response of amplifier and catheter to the pressure: a fit estimates it beside the parameters.

It is of first order, with a lag, or of second order, with an inertia, too (`second_order`). For every response the
derivatives at the last optimum say where the parameters would go; the likeliest one is held while the parameters are
searched again, until it stays.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product
from typing import Any, NamedTuple

import numpy as np
from scipy.optimize import minimize

from vasowave.base.findings import Finding, note_kind
from vasowave.pulse.calibration.objective import Objective
from vasowave.pulse.calibration.optimization import FINAL_TOLERANCE, SearchEnd, search


@dataclass(frozen=True)
class ResponseRules:
    """How a response is looked for.

    Attributes
    ----------
    farthest : float
        What a response may be, SD of the prior.
    looked : float
        As far it is looked at first, likewise,
    apart : float
        at responses so far apart, likewise.
    small : float
        Difference of the responses of two searches, below which they are the same, likewise.
    searches : int
        At most.
    held : tuple of float
        Lags, likewise, from whose optima the search may begin, too: a large one is told from no other place, where
        the wall has bent to imitate it.
    rough : float
        Relative change of S at which these searches end.
    hopeless : float
        Ratio of S with a lag that is held to the best, from which longer ones are not looked at.
    """

    farthest: float = 8.0
    looked: float = 4.0
    apart: float = 0.5
    small: float = 0.01
    searches: int = 8
    held: tuple[float, ...] = (1.0, 3.0)
    rough: float = 1e-2
    hopeless: float = 3.0


RULES = ResponseRules()
_STEP_SD = 1e-3  # SD of the prior, of differences

LAG = note_kind(
    "fit.lag",
    "The lag of the pressure was fitted beside the parameters: {lag:.2g} ± {error:.2g} ms (assumed: 0 ± {prior:.2g} "
    "ms); a filter of first order has the cut-off frequency 1/(2π lag).",
)
INERTIA = note_kind(
    "fit.inertia",
    "The inertia of the catheter was fitted beside the parameters: {inertia:.2g} ± {error:.2g} ms² (assumed: 0 ± "
    "{prior:.2g} ms²); the natural frequency of a catheter is 1/(2π √inertia), its damping ratio lag/(2 √inertia).",
)


class Estimate(NamedTuple):
    """A number of the response: its estimate, the SD of its error, and the SD that it was assumed to have."""

    value: float
    error: float
    prior: float


RESPONSE = "pressure_lag", "pressure_inertia"
"""Names of the two numbers of a response, as of `KnownErrors`."""

Response = dict[str, Estimate]
"""What of the response was fitted, by name."""


def findings(response: Response) -> Iterator[Finding]:
    """Return what a reader must know of a response."""
    for name, (value, error, prior) in response.items():
        if name == "pressure_lag":
            yield LAG(lag=1e3 * value, error=1e3 * error, prior=1e3 * prior)
        else:
            yield INERTIA(inertia=1e6 * value, error=1e6 * error, prior=1e6 * prior)


def in_words(response: Response) -> str:
    """Return the estimates as words of a sentence, each after a comma."""
    return "".join(
        f", lag of the pressure {1e3 * estimate.value:.2g} ± {1e3 * estimate.error:.2g} ms"
        if name == "pressure_lag"
        else f", inertia of the catheter {1e6 * estimate.value:.2g} ± {1e6 * estimate.error:.2g} ms²"
        for name, estimate in response.items()
    )


def fit_response(
    objective: Objective,
    best: SearchEnd,
    start: np.ndarray,
    priors: Mapping[str, float],
    method: str,
    tolerance: float = FINAL_TOLERANCE,
    enough: float = np.inf,
) -> tuple[Objective, SearchEnd]:
    """Return the objective with the likeliest response, whose SD are `priors`, and its optimum.

    The search begins at `best`, without a response, or where one from `start` with a lag that is held ends, if that is
    likelier; each search from there ends where the relative change of S is below `tolerance`, or where it promises
    nothing below `enough` (mmHg²).
    """
    sd, responses = _spreads(priors), np.zeros((1, 2))
    likeliest = objective, best = _begin(objective, best, start, sd, method)
    for _ in range(RULES.searches):
        scores = _likeliest(objective, best.x, sd)
        *earlier, last = np.abs(scores - responses).max(axis=1)
        if earlier and min(earlier) < RULES.small:
            break  # two optima send the search to each other and back
        response = tuple((sd * scores).tolist())
        objective = objective.compared_with(replace(objective.compared, response=response))
        best = search(objective, best.x, method, tolerance, enough)
        likeliest = min(likeliest, (objective, best), key=lambda place: _unlikely(place[0], place[1], sd))
        if last < RULES.small:
            break
        responses = np.vstack([responses, scores])
    return likeliest


def _unlikely(objective: Objective, end: SearchEnd, sd: np.ndarray) -> float:
    """Return -2 of the logarithm of the likelihood of an optimum and of the prior of its response."""
    scores = np.divide(objective.compared.response, sd, out=np.zeros(2), where=sd > 0)
    return float((objective.compared.samples - len(end.x)) * np.log(end.S) + scores @ scores)


def _begin(
    objective: Objective, best: SearchEnd, start: np.ndarray, sd: np.ndarray, method: str
) -> tuple[Objective, SearchEnd]:
    """Return the likeliest of the optima without a response and with lags that are held, longer while that helps."""
    enough = np.inf
    for score in RULES.held if sd[0] else ():
        response = (float(sd[0] * score), 0.0)
        candidate = objective.compared_with(replace(objective.compared, response=response))
        end = search(candidate, start, method, RULES.rough, enough)
        if end.S > RULES.hopeless * best.S:
            break
        if _unlikely(candidate, end, sd) < _unlikely(objective, best, sd):
            objective, best, start, enough = candidate, end, end.x, end.S
    return objective, best


def response_columns(objective: Objective, x: np.ndarray, priors: Mapping[str, float]) -> np.ndarray:
    """Return the derivatives of the residuals at `x` by what is fitted of the response, in SD of its prior."""
    compared, current, columns = objective.compared, np.array(objective.compared.response), []
    pressure = replace(compared, response=(0.0, 0.0)).simulated(objective.at(x))
    for step in _STEP_SD * np.diag(_spreads(priors)):
        if step.any():
            upper, lower = (compared.behind(pressure, current + side * step) for side in (1, -1))
            columns.append((lower - upper) / (2 * _STEP_SD))
    return np.pad(np.transpose(columns), ((0, len(objective.residuals(x)) - compared.samples), (0, 0)))


def estimates(response: tuple[float, float], errors: Sequence[float], priors: Mapping[str, float]) -> Response:
    """Return what was fitted of a response by name; the errors are in SD of the prior."""
    values = dict(zip(RESPONSE, response, strict=True))
    return {
        name: Estimate(values[name], prior * float(error), prior)
        for (name, prior), error in zip(priors.items(), errors, strict=True)
    }


def _spreads(priors: Mapping[str, float]) -> np.ndarray:
    return np.array([priors.get(name, 0.0) for name in RESPONSE])


def _likeliest(objective: Objective, x: np.ndarray, sd: np.ndarray) -> np.ndarray:
    """Return the response, in SD of its priors, that leaves least where the parameters follow it."""
    compared = replace(objective.compared, response=(0.0, 0.0))
    plain = objective.compared_with(compared)
    residual, jacobian, count = plain.residuals(x), plain.jacobian(x), compared.samples

    def left(scores: np.ndarray) -> float:
        remainder, columns = residual.copy(), jacobian.copy()
        remainder[:count] = compared.measured - compared.behind(compared.measured - residual[:count], sd * scores)
        columns[:count] = compared.behind(jacobian[:count], sd * scores)
        remainder -= columns @ np.linalg.lstsq(columns, remainder)[0]
        return float(remainder @ remainder)

    span = np.arange(-RULES.looked, RULES.looked + RULES.apart, RULES.apart)
    looked = np.array(list(product(*(span if score else (0.0,) for score in sd))))
    remain, distance = np.array([left(score) for score in looked]), (looked**2).sum(axis=1)

    def least(noise: float) -> Any:
        first = looked[np.argmin(remain + noise * distance)]
        corners = first + 0.5 * RULES.apart * np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]])
        return minimize(
            lambda scores: left(scores) + noise * float(scores @ scores),
            first,
            method="Nelder-Mead",
            bounds=2 * [(-RULES.farthest, RULES.farthest)],
            options={"initial_simplex": corners, "xatol": 0.1 * RULES.small, "fatol": np.inf},
        )

    noise = least(0.0).fun / max(1, count - len(x) - np.count_nonzero(sd))
    return np.asarray(least(noise).x)
