"""Where the linear model leads the starts of a fit, at some microseconds an answer: alike ones are followed once.

The linear model in the frequency domain has the valleys of the objective; what it lacks is where exactly their floors
lie, and how a wall stiffens within the cycle. So it leads no starts of laws with a parameter for that.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares

from vasowave.base.errors import NumericalError
from vasowave.pulse.calibration.compared import Compared
from vasowave.pulse.calibration.parameters import ParameterSpace, trial
from vasowave.pulse.cycle.waveform import amplitudes
from vasowave.pulse.model.linear import linear_solution
from vasowave.pulse.model.outlets import BUILT_IN as BEDS
from vasowave.pulse.model.parameters import model_fields
from vasowave.pulse.model.straight_trees import TreeMembers, solve_members


@dataclass(frozen=True)
class ScreeningRules:
    """How starts are followed by the linear model before they are simulated.

    Attributes
    ----------
    max_harmonics : int
        Harmonics that the linear model compares, at most: above them little of a pulse is left.
    min_gain : float
        Relative gain of S below which a start stays where it is.
    max_steps : int
        Steps of one start.
    log_step : float
        Step of the differences, in the logarithms.
    failed_residual : float
        Residual of what cannot be, mmHg.
    max_log_difference : float
        Largest difference of a logarithm between starts that are followed once.
    """

    max_harmonics: int = 12
    min_gain: float = 1e-3
    max_steps: int = 15
    log_step: float = 1e-5
    failed_residual: float = 1e3
    max_log_difference: float = 0.15


RULES = ScreeningRules()


def knows(space: ParameterSpace) -> bool:
    """Whether the linear model knows all that the parameters of the wall do: their first is its stiffness."""
    return not set(space.names_of("wall")[1:]) & set(space.free_names)


def screened(
    space: ParameterSpace, compared: Compared, starts: Sequence[np.ndarray]
) -> tuple[list[np.ndarray], list[int]]:
    """Return where the linear model leads each start, and the number of the start that is followed for it.

    All are logarithms of the free parameters. Followed is, of starts that end alike, the first.
    """
    places = [led(space, compared, start) for start in starts]
    leads: list[int] = []
    for number, place in enumerate(places):
        alike = (
            lead for lead in dict.fromkeys(leads) if np.max(np.abs(places[lead] - place)) < RULES.max_log_difference
        )
        leads.append(next(alike, number))
    return places, leads


def led(space: ParameterSpace, compared: Compared, start: np.ndarray) -> np.ndarray:
    """Return where the linear model leads a start; the start itself where it leads nowhere."""
    residuals, (low, high) = linear_residuals(space, compared), space.log_bounds
    inside = 1e-6 * (high - low)

    def jacobian(x: np.ndarray) -> np.ndarray:
        steps = np.where(x + RULES.log_step > high, -RULES.log_step, RULES.log_step)
        base, *moved = residuals(np.vstack([x, x + np.diag(steps)]))
        return np.asarray((np.array(moved) - base).T / steps)

    fit = least_squares(
        lambda x: residuals(x[np.newaxis])[0],
        np.clip(start, low + inside, high - inside),
        jacobian,
        bounds=(low, high),
        ftol=RULES.min_gain,
        xtol=RULES.min_gain,
        max_nfev=RULES.max_steps,
    )
    return np.asarray(fit.x) if fit.cost < 0.5 * RULES.failed_residual**2 else start


def linear_residuals(space: ParameterSpace, compared: Compared) -> Callable[[np.ndarray], np.ndarray]:
    """Return a function of logarithms, shape (point, free): what the linear model misses of the harmonics, mmHg.

    The mean and √½ of each amplitude, so that the sum of squares is S/N (eq. 14).
    """
    count = min(compared.harmonics, RULES.max_harmonics) + 1
    measured, weights = amplitudes(compared.measured)[:count], np.sqrt(np.where(np.arange(count) > 0, 0.5, 1.0))
    spectrum = amplitudes(compared.recording.flow)[:count] if _are_plain(space, compared, count) else None

    def harmonics_at(x: np.ndarray) -> np.ndarray:
        try:
            with trial():
                model = space.model(space.values(x))
                return compared.of_linear(linear_solution(model, compared.driven, count - 1), model.network.root)
        except NumericalError:
            return np.full(count, np.nan)

    def residuals(points: np.ndarray) -> np.ndarray:
        period = compared.recording.period
        harmonics = None if spectrum is None else _pressure_harmonics(space, points, spectrum, period)
        if harmonics is None:
            harmonics = np.array([harmonics_at(x) for x in points])
        missed = weights * (measured - harmonics)
        values = np.hstack([missed.real, missed.imag])
        return np.where(np.isfinite(values).all(axis=1, keepdims=True), values, RULES.failed_residual)

    return residuals


def _are_plain(space: ParameterSpace, compared: Compared, count: int) -> bool:
    """Whether all models are straight trees with a flow that holds so many harmonics, and their beds circuits."""
    network = space.network
    plain = network.nodes is None and network.taper is None and space.outlet_pulsation is None
    enters = compared.what == "pressure" and len(compared.recording.flow) >= 2 * count
    return plain and enters and type(space.outlets) in BEDS


def _pressure_harmonics(
    space: ParameterSpace, points: np.ndarray, spectrum: np.ndarray, period: float
) -> np.ndarray | None:
    """Return harmonics of the pressure at the inlets of plain models, shape (point, harmonic), mmHg.

    NaN where a wall has no area. None where a law raises: each model is then to be looked at alone.
    """
    network = space.network
    values = np.tile(space.nominal, (len(points), 1))
    values[:, space.free] = np.exp(points)
    try:
        with trial():
            columns = dict(zip(space.names, values.T[..., np.newaxis], strict=True))
            fields = model_fields(columns, space.law, space.outlets)
            wall, viscosity = fields["wall"], np.atleast_2d(fields["wall_viscosity"])
            area0 = network.area / np.asarray(wall.ratio_at(network.pressure, *wall))
            omega = 2 * np.pi / period * np.arange(len(spectrum))[:, np.newaxis]
            end = np.ascontiguousarray(np.moveaxis(fields["outlets"].impedance(omega), 0, -1), dtype=complex)
            behind = np.full(len(network.terminals), float(space.outlet_pressure))
            members = TreeMembers(wall, np.where(area0 > 0, area0, np.nan), viscosity, end, behind)
            return solve_members(network, space.blood, members, spectrum, period)[2].pressure[:, network.root]
    except NumericalError:
        return None
