"""Whether what a fit leaves looks like an instrument's: a filter or a delay of the pressure or of the flow.

An amplifier's filter of first order, 1 / (1 + iωτ), makes the upstroke soft and late, and a fit makes the arteries soft
instead. What it cannot imitate stays in the residual. A step towards τ and the free parameters shows it; where it does,
the linear theory fits both. Walls that are stiffer towards the periphery, and a law that is not the vessels', leave
the same.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.optimize import least_squares

from vasowave.base.cures import UNKNOWN, SetCells, SetSetting
from vasowave.base.findings import Finding, look_kind
from vasowave.pulse.calibration.compared import Compared
from vasowave.pulse.calibration.objective import Objective
from vasowave.pulse.calibration.optimization import SearchEnd
from vasowave.pulse.calibration.parameters import IMPOSSIBLE_ERRORS, ParameterSpace
from vasowave.pulse.calibration.response_search import response_of_linear_network
from vasowave.pulse.model.linear import linear_solution


@dataclass(frozen=True)
class InstrumentRules:
    """When an instrument becomes a finding.

    Attributes
    ----------
    harmonics : int
        So many are looked at.
    floor : float
        Residual that is looked at, mmHg: the error of the simulated pressure by its grid.
    step : float
        Share of the residual's sum of squares that a first step must explain, for a fit to be made.
    weak_share : float
        Share that the fit may leave.
    F : float
        Least variance ratio of what the instrument explains.
    evaluations : int
        Steps of the fit with a lag, at most.
    shortest : float
        Least lag τ that is told, share of the cycle over 2π: a filter at 16 times the heart's frequency. Images that
        are wrong by 5 % in every vessel look like filters of 25 to 45 times.
    longest : float
        Largest lag that is looked for, likewise.
    imitation_share : float
        Share of a lag that no parameter imitates, below which a first step would not show it.
    bound : float
        Distance of the logarithm of a parameter from its bound, below which it is at it.
    """

    harmonics: int = 20
    floor: float = 0.02
    step: float = 0.1
    weak_share: float = 0.5
    F: float = 30.0
    evaluations: int = 40
    shortest: float = 1 / 16
    longest: float = 1.0
    imitation_share: float = 0.25
    bound: float = 1e-3


RULES = InstrumentRules()
_FAILED_RESIDUAL = 1e3  # mmHg

LOW_PASS = look_kind(
    "fit.low-pass",
    "The {signal} looks filtered at about {cutoff:.0f} Hz (first order), or late by {delay:.2g} ms: then {parameter} "
    "would be about {value:.3g}, not {fitted:.3g} (explains {explained:.0f} % of the residual). Walls stiffer towards "
    "the periphery and another wall law look alike.",
    "Ask which filters amplifier and recorder have, and give their cut-off frequency; where nobody knows, allow for a "
    "lag of the pressure as a known error.",
    SetCells("Give the filter of the pressure", (("pressure cutoff [Hz]", UNKNOWN),)),
    SetCells("Give the filter of the flow", (("flow cutoff [Hz]", UNKNOWN),)),
    SetSetting("Allow for a lag", "pressure_lag_sd"),
)


class Lagged(NamedTuple):
    """A fit with a lag: logarithms of the parameters, lag as share of the cycle over 2π, and what it leaves, mmHg²."""

    x: np.ndarray
    lag: float
    cost: float


Response = Callable[[np.ndarray], np.ndarray]
"""Recorded over true pressure of a lag by its ωτ."""

_RESPONSES: dict[str, tuple[Response, Response]] = {
    "pressure": (lambda lag: 1 / (1 + 1j * lag), lambda lag: np.exp(-1j * lag)),
    "flow": (lambda lag: 1 + 1j * lag, lambda lag: np.exp(1j * lag)),
}  # a filter and a delay of each signal, as they stand in the pressure of a model that the recorded flow enters


def instrument_findings(
    objective: Objective, best: SearchEnd, jacobian: np.ndarray, start: np.ndarray
) -> list[Finding]:
    """Return a finding if a lag of one signal explains most of what a fit leaves at the inlet.

    The linear theory fits lag and parameters together. It does not know how a wall stiffens: of laws that do, the
    simulation is fitted again, with the lag, where a first step shows one, the parameters can imitate it,
    or one is at its bound.

    Parameters
    ----------
    objective : Objective
    best : SearchEnd
        The optimum.
    jacobian : array, shape (N, free)
        Derivatives of the residuals there.
    start : array, shape (free,)
        Where another search may begin.
    """
    space, compared, x = objective.space, objective.compared, best.x
    if compared.what == "flow" or not len(x):
        return []
    residual, jacobian = (values[: compared.samples] for values in (best.residual, jacobian))
    count = min(compared.harmonics, RULES.harmonics)
    measured, remainder = (_harmonics(values, count) for values in (compared.measured, residual))
    lagging = _real(-1j * np.arange(count + 1) * (measured - remainder))  # by a lag, in shares of the cycle over 2π
    basis = np.linalg.qr(np.stack([_real(_harmonics(column, count)) for column in jacobian.T], axis=1))[0]
    in_full = lagging @ lagging
    target, lagging = (values - basis @ (basis.T @ values) for values in (_real(remainder), lagging))
    step = float(target @ lagging / max(lagging @ lagging, 1e-300))
    total, shows = float(target @ target), step**2 * float(lagging @ lagging)
    if total < RULES.floor**2:
        return []
    shown, stiffness_only = shows >= RULES.step * total, _is_stiffness_only(space)
    if shown and (stiffness_only or step < 0):
        signal = "pressure" if step > 0 else "flow"
        filtered, delayed = (
            _with_lag(space, x, measured - remainder, measured, compared, response) for response in _RESPONSES[signal]
        )
        if findings := _told(objective, x, signal, filtered, delayed, total):
            return findings
    imitated = lagging @ lagging < RULES.imitation_share**2 * in_full
    low, high = space.log_bounds
    at_bound = np.minimum(x - low, high - x).min() < RULES.bound
    if stiffness_only or not (shown or imitated or at_bound):
        return []
    again = _simulated(objective, best, start, count)
    return _told(objective, x, "pressure", again, again, float(_real(remainder) @ _real(remainder)))


def _is_stiffness_only(space: ParameterSpace) -> bool:
    """Whether the linear theory knows all that the parameters of the wall do: their first is its stiffness."""
    return not set(space.names_of("wall")[1:]) & set(space.free_names)


def _told(
    objective: Objective, x: np.ndarray, signal: str, filtered: Lagged, delayed: Lagged, total: float
) -> list[Finding]:
    """Return the finding of a lag, by the fits with a filter and with a delay, if they leave little of `total`."""
    compared = objective.compared
    smallest = max(min(filtered.cost, delayed.cost), 1e-300)
    freedom = 2 * min(compared.harmonics, RULES.harmonics) - len(x)
    weak = smallest > RULES.weak_share * total or (total - smallest) / smallest * freedom < RULES.F
    if weak or filtered.lag < RULES.shortest:
        return []
    unit = compared.recording.period / (2 * np.pi)
    return [
        LOW_PASS(
            signal=signal,
            cutoff=float(1 / (2 * np.pi * unit * filtered.lag)),
            delay=float(1e3 * unit * delayed.lag),
            parameter=objective.space.free_names[0],
            value=float(np.exp(filtered.x[0])),
            fitted=float(np.exp(x[0])),
            explained=100 * (1 - smallest / total),
        )
    ]


def _simulated(objective: Objective, best: SearchEnd, start: np.ndarray, count: int) -> Lagged:
    """Return the fit of the simulation with a filter of the pressure; without one where no such fit can be."""
    unit = objective.compared.recording.period / (2 * np.pi)
    place = response_of_linear_network(objective, best, start, {"pressure_lag"})
    behind, again = (objective, best) if place is None else place[:2]
    spectrum = _real(_harmonics(again.residual[: objective.compared.samples], count))
    return Lagged(again.x, behind.compared.response[0] / unit, float(spectrum @ spectrum))


def _harmonics(values: np.ndarray, count: int) -> np.ndarray:
    return np.fft.rfft(values)[: count + 1] / len(values)


def _real(spectrum: np.ndarray) -> np.ndarray:
    """Return as many real numbers with the same sum of squares over a cycle."""
    return np.concatenate([spectrum.real[:1], np.sqrt(2) * spectrum.real[1:], np.sqrt(2) * spectrum.imag[1:]])


def _with_lag(
    space: ParameterSpace,
    x: np.ndarray,
    simulated: np.ndarray,
    measured: np.ndarray,
    compared: Compared,
    response: Response,
) -> Lagged:
    """Return the fit of parameters and lag by the linear theory."""
    count = len(measured) - 1

    def linear(point: np.ndarray) -> np.ndarray:
        model = space.model(space.values(point))
        spectrum = linear_solution(model, compared.driven, count).pressure[:, model.network.root]
        return np.append(spectrum[:1], 0.5 * spectrum[1:])

    def apart(point: np.ndarray) -> np.ndarray:
        try:
            pressure = simulated + linear(point[:-1]) - middle
        except IMPOSSIBLE_ERRORS:
            return np.full(2 * count + 1, _FAILED_RESIDUAL)
        return _real(measured - response(np.arange(count + 1) * np.exp(point[-1])) * pressure)

    with np.errstate(all="ignore"):
        middle = linear(x)
        low, high = space.log_bounds
        bounds = np.append(low - 1e-9, np.log(1e-3)), np.append(high + 1e-9, np.log(RULES.longest))
        optimum = least_squares(
            apart, np.append(x, np.log(0.15)), bounds=bounds, max_nfev=RULES.evaluations, x_scale=0.1
        )
    return Lagged(optimum.x[:-1], float(np.exp(optimum.x[-1])), 2 * float(optimum.cost))
