"""Generalized least squares: fit the parameters again under a noise model that knows how residuals are correlated."""

import threading
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from vasowave.base.errors import InputError, NumericalError
from vasowave.pulse.calibration.objective import Objective
from vasowave.pulse.calibration.parameters import ParameterLimits, ParameterSpace, parameter_space
from vasowave.pulse.calibration.result import CalibratedModel

Whiten = Callable[[np.ndarray], np.ndarray]
"""Maps pressure residuals (sample,) or their Jacobian (sample, parameter) to coordinates where the noise is white."""

_LIKELIHOOD_TOLERANCE = 1e-4  # of the log-likelihood: a hundredth of a standard error, far below what AICc can decide
_MAX_STEPS = 60  # of the optimizer; what has not ended by then is told


@dataclass(frozen=True, eq=False)
class Optimum:
    """Where a fit ended, under whatever noise model.

    Attributes
    ----------
    space : ParameterSpace
        The parameters and their bounds.
    x : array, shape (free,)
        Logarithms of the free parameters.
    residual : array, shape (sample,)
        Measured minus simulated pressure, mmHg.
    jacobian : array, shape (sample, free)
        Its derivative by the logarithms, mmHg.
    converged : bool
    message : str
        Why the search ended.
    simulations : int
    """

    space: ParameterSpace
    x: np.ndarray
    residual: np.ndarray
    jacobian: np.ndarray
    converged: bool
    message: str
    simulations: int

    @property
    def values(self) -> dict[str, float]:
        """All parameters by name, in their units."""
        return {name: float(v) for name, v in zip(self.space.names, self.space.values(self.x), strict=True)}


def least_squares_optimum(fit: CalibratedModel, workers: int = 1) -> Optimum:
    """Return the optimum that `calibrate` found, with the Jacobian there (one ensemble of simulations)."""
    objective = objective_of(fit, {}, workers)
    return _optimum(objective, _start(fit, objective.space), True, "as calibrated")


def reoptimize(
    fit: CalibratedModel,
    whiten: Whiten,
    *,
    start: np.ndarray | None = None,
    fixed: Mapping[str, float] | None = None,
    workers: int = 1,
) -> Optimum:
    """Minimize rᵀΣ⁻¹r instead of rᵀr (eqs. 14, 23), from the optimum of `fit`, within its bounds.

    Parameters
    ----------
    fit : CalibratedModel
    whiten : callable
        Of a noise model: residuals, shape (sample,) or (sample, free), times Σ^(-1/2).
    start : array, shape (free,), optional
        Logarithms to start from instead.
    fixed : mapping of str to float, optional
        Parameters to hold, beside those which the fit held.
    workers : int
        Threads for the columns of a Jacobian.

    Raises
    ------
    InputError
        A parameter that the wall does not have, or nothing left to fit.
    NumericalError
        If the start cannot be simulated.
    """
    objective = objective_of(fit, fixed or {}, workers)
    whiten = beside_sites(whiten, fit)
    low, high = objective.space.log_bounds
    begin = _start(fit, objective.space) if start is None else start
    inside = 1e-6 * (high - low)
    x, converged, message = _descend(objective, whiten, np.clip(begin, low + inside, high - inside))
    return _optimum(objective, x, converged, message)


def beside_sites(whiten: Whiten, fit: CalibratedModel) -> Whiten:
    """Return what whitens the residuals of a fit with further sites: these by the usual error of the model."""
    sites = fit.compared.sites
    if sites is None:
        return whiten
    count, scale = fit.N, sites.deviation
    return lambda values: np.concatenate([whiten(values[:count]), values[count:] / scale])


def _descend(objective: Objective, whiten: Whiten, start: np.ndarray) -> tuple[np.ndarray, bool, str]:
    """Minimize half the whitened sum of squares by sequential quadratic programming.

    Whitened residuals are large and the valley of the tangent law is curved, so that Gauss-Newton steps, which leave
    out the curvature of the model, creep; this method learns it. It moves in coordinates in which the first
    Gauss-Newton Hessian is the unit matrix, and bounds are linear constraints.
    """
    from scipy.optimize import minimize

    jacobian = whiten(objective.jacobian(start))
    to_x = np.linalg.pinv(np.linalg.qr(jacobian, mode="r"), rcond=1e-8)
    low, high = objective.space.log_bounds

    def value(z: np.ndarray) -> float:
        white = whiten(objective.residuals(start + to_x @ z))
        return 0.5 * float(white @ white)

    def slope(z: np.ndarray) -> np.ndarray:
        x = start + to_x @ z
        return to_x.T @ (whiten(objective.jacobian(x)).T @ whiten(objective.residuals(x)))

    sides = {"type": "ineq", "fun": lambda z: np.concatenate([start + to_x @ z - low, high - start - to_x @ z])}
    sides["jac"] = lambda z: np.concatenate([to_x, -to_x])
    options = {"ftol": _LIKELIHOOD_TOLERANCE, "maxiter": _MAX_STEPS}
    optimum = minimize(value, np.zeros(len(start)), jac=slope, method="SLSQP", constraints=sides, options=options)
    return np.clip(start + to_x @ optimum.x, low, high), bool(optimum.success), str(optimum.message)


def objective_of(fit: CalibratedModel, fixed: Mapping[str, float], workers: int) -> Objective:
    """Return the objective that a fit minimized, with some of its parameters held."""
    table = fit.parameters
    unknown = [name for name in fixed if name not in table.index]
    if unknown:
        raise InputError(f"the {fit.wall} wall has no parameter '{unknown[0]}'; it has: {', '.join(table.index)}")
    bounds = {str(name): (float(row["lower"]), float(row["upper"])) for name, row in table.iterrows()}
    held = {str(name): float(row["value"]) for name, row in table.iterrows() if not row["free"]}
    model, held = fit.model, held | dict(fixed)
    limits = ParameterLimits(bounds, held, viscous=bool(np.any(model.wall_viscosity)))
    space = parameter_space(type(model.wall), model.network, fit.nominal, model.blood, limits)
    return Objective(space, fit.compared, fit.numerics, workers, threading.Event())


def _start(fit: CalibratedModel, space: ParameterSpace) -> np.ndarray:
    return np.log(fit.parameters.loc[list(space.free_names), "value"].to_numpy(float))


def _optimum(objective: Objective, x: np.ndarray, converged: bool, message: str) -> Optimum:
    jacobian = objective.jacobian(x)
    residual = objective.residuals(x)
    if not np.isfinite(residual).all() or np.all(residual == residual[0]):
        raise NumericalError("the optimum cannot be simulated again; look at the fit")
    return Optimum(objective.space, x, residual, jacobian, converged, message, objective.simulations)
