"""One search from one start, by bounded least squares or by sequential quadratic programming (SQP, the paper's)."""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from vasowave.base.errors import NumericalError
from vasowave.pulse.calibration.coordinates import Coordinates
from vasowave.pulse.calibration.objective import Objective

Array = Callable[[np.ndarray], np.ndarray]
Bounds = tuple[np.ndarray, np.ndarray]

FINAL_TOLERANCE = 1e-8  # the paper's, of the last search; the relative change of S and of the parameters
ROUGH_TOLERANCE = 1e-6  # of the searches before it, which only have to find the way
SAME_OPTIMUM_SHARE = 1e-3
"""Share by which the S of starts may differ that ended at the same optimum."""


@dataclass(frozen=True, eq=False)
class SearchEnd:
    """Where one search ended.

    Attributes
    ----------
    x : array, shape (free,)
        Logarithms of the free parameters.
    S : float
        Objective (eq. 14); infinite if the start could not be simulated.
    simulations : int
    converged : bool
    message : str
    residual : array, shape (N,)
        Measured minus simulated pressure there, mmHg; empty if the start could not be simulated.
    joined : bool
        It lies in the valley of the best optimum, by the linear network that simulations correct.
    """

    x: np.ndarray
    S: float
    simulations: int
    converged: bool
    message: str
    residual: np.ndarray = field(default_factory=lambda: np.empty(0))
    joined: bool = False


def search(objective: Objective, start: np.ndarray, method: str, tolerance: float = FINAL_TOLERANCE) -> SearchEnd:
    """Minimize S from the logarithms `start` of the free parameters, until its relative change is below `tolerance`."""
    try:
        objective.at(start)
    except NumericalError as error:
        return SearchEnd(start, np.inf, objective.simulations, False, f"the start cannot be simulated: {error}")
    first = objective.residuals(start)
    solve = _least_squares if method == "least-squares" else _sqp
    try:
        x, converged, message = solve(objective, start, tolerance)
        residual = objective.residuals(x)
    except NumericalError as error:  # no derivative: the search cannot go on from where it is
        x, residual = objective.best or (start, first)
        converged, message = False, str(error)
    return SearchEnd(x, float(residual @ residual), objective.simulations, converged, message, residual)


_END_REASONS = {
    0: "too many iterations",
    1: "the gradient is below the tolerance",
    2: "the change of S is below the tolerance",
    3: "the step is below the tolerance",
    4: "step and change of S are below the tolerance",
}


class _Jacobians:
    """The Jacobians along one least-squares search: none is simulated where the search ends and would not use it."""

    def __init__(self, residuals: Array, jacobian: Array, tolerance: float) -> None:
        self.residuals, self.jacobian, self.tolerance = residuals, jacobian, tolerance
        self._known: tuple[np.ndarray, np.ndarray, np.ndarray] | None = None

    def at(self, x: np.ndarray) -> np.ndarray:
        """Return the Jacobian at x; where the search ends, that of the place before."""
        r = self.residuals(x)
        if self._known is not None and self._ends(x, r):
            return self._known[2]
        J = self.jacobian(x)
        self._known = x, r, J
        return J

    def _ends(self, x: np.ndarray, r: np.ndarray) -> bool:
        """Whether the step to x ends the search: the rule of SciPy's `ftol`, a little stricter at bounds."""
        assert self._known is not None
        before, r_before, J = self._known
        S, foretold = r_before @ r_before, r_before + J @ (x - before)
        gain = S - r @ r
        return bool(gain < self.tolerance * S and gain > 0.25 * (S - foretold @ foretold))


Ended = tuple[np.ndarray, bool, str]


def _least_squares(objective: Objective, start: np.ndarray, tolerance: float) -> Ended:
    """Search in the coordinates that the data see; where that leads out of the bounds, again inside them."""
    low, high = objective.space.log_bounds
    try:
        x, optimum = _along_coordinates(objective, start, tolerance)
    except NumericalError:  # these coordinates end here; the logarithms may lead on
        x, optimum = start, None
    if optimum is None or not np.all((low <= x) & (x <= high)):
        span = 1e-6 * (high - low)
        begin = np.clip(x, low + span, high - span)
        if optimum is None or not objective.can_be(begin):
            begin = np.clip((objective.best or (start,))[0], low + span, high - span)
        along = _Jacobians(objective.residuals, objective.jacobian, tolerance)
        optimum = _trust_region(along, begin, (low, high))
        x = optimum.x
    return x, bool(optimum.success), _END_REASONS.get(optimum.status, str(optimum.message))


def _along_coordinates(objective: Objective, start: np.ndarray, tolerance: float) -> tuple[np.ndarray, Any]:
    """Return where a search in the coordinates that the data see ends, as logarithms, and its end.

    Raises
    ------
    NumericalError
        The start has no place in these coordinates, or they have no derivatives on the way.
    """
    coordinates = Coordinates(objective.space, objective.compared.recording.mean_pressure)
    place = coordinates.bounds
    inside = 1e-6 * (place[1] - place[0])
    along = _Jacobians(
        lambda z: objective.residuals(coordinates.logarithms(z)),
        lambda z: objective.jacobian(coordinates.logarithms(z)) @ coordinates.slopes(z),
        tolerance,
    )
    optimum = _trust_region(along, np.clip(coordinates.of(start), place[0] + inside, place[1] - inside), place)
    return coordinates.logarithms(optimum.x), optimum


def _trust_region(along: _Jacobians, start: np.ndarray, bounds: Bounds) -> Any:
    from scipy.optimize import least_squares

    return least_squares(
        along.residuals,
        start,
        along.at,
        bounds=bounds,
        method="trf",
        ftol=along.tolerance,
        xtol=along.tolerance,
        gtol=along.tolerance,
        max_nfev=100,
    )


def _sqp(objective: Objective, start: np.ndarray, tolerance: float) -> Ended:
    from scipy.optimize import Bounds as Sides
    from scipy.optimize import minimize

    first = float(np.sum(objective.residuals(start) ** 2)) or 1.0  # S is scaled to 1 at the start

    def scaled(x: np.ndarray) -> float:
        return float(np.sum(objective.residuals(x) ** 2)) / first

    def gradient(x: np.ndarray) -> np.ndarray:
        r, J = objective.residuals(x), objective.jacobian(x)
        return 2 * J.T @ r / first

    low, high = objective.space.log_bounds
    options = {"ftol": tolerance, "maxiter": 200}
    optimum = minimize(scaled, start, jac=gradient, method="SLSQP", bounds=Sides(low, high), options=options)
    return optimum.x, bool(optimum.success), str(optimum.message)
