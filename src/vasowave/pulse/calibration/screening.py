"""Where the linear model leads the starts of a fit, at half a millisecond an answer: alike ones are followed once.

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
    place = np.clip(start, low + inside, high - inside)
    fit = least_squares(
        residuals,
        place,
        bounds=(low, high),
        diff_step=RULES.log_step,
        ftol=RULES.min_gain,
        xtol=RULES.min_gain,
        max_nfev=RULES.max_steps,
    )
    return np.asarray(fit.x) if fit.cost < 0.5 * RULES.failed_residual**2 else start


def linear_residuals(space: ParameterSpace, compared: Compared) -> Callable[[np.ndarray], np.ndarray]:
    """Return a function of logarithms: what the linear model misses of the harmonics of what is compared, mmHg.

    The mean and √½ of each amplitude, so that the sum of squares is S/N (eq. 14).
    """
    count = min(compared.harmonics, RULES.max_harmonics) + 1
    measured, weights = amplitudes(compared.measured)[:count], np.sqrt(np.where(np.arange(count) > 0, 0.5, 1.0))

    def residuals(x: np.ndarray) -> np.ndarray:
        try:
            with trial():
                model = space.model(space.values(x))
                solved = linear_solution(model, compared.driven, count - 1)
                missed = weights * (measured - compared.of_linear(solved, model.network.root))
        except NumericalError:
            return np.full(2 * count, RULES.failed_residual)
        values = np.concatenate([missed.real, missed.imag])
        return values if np.all(np.isfinite(values)) else np.full(2 * count, RULES.failed_residual)

    return residuals
