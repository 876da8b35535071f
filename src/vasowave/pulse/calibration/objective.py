"""The objective S (eq. 14), its residuals and their Jacobian, by simulation.

What was measured at the inlet and enters the root, flow or pressure, has no residual, and that part of eq. 14 vanishes;
the other's remains (`Compared`). What was observed at further sites adds its own residuals (`Sites`).
"""

import threading
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from vasowave.base.errors import NumericalError
from vasowave.pulse.calibration.compared import Compared
from vasowave.pulse.calibration.parameters import IMPOSSIBLE_ERRORS, ParameterSpace, trial
from vasowave.pulse.cycle.cycle import Inflow, InletPressure
from vasowave.pulse.model.numerics import Numerics
from vasowave.pulse.solver.direction import Direction, direction_between
from vasowave.pulse.solver.places import Places, Waves, waves_at
from vasowave.pulse.solver.result import Run
from vasowave.pulse.solver.sensitivity import derivatives, pressure_derivatives
from vasowave.pulse.solver.simulation import simulate_run

_LOG_STEP = 1e-4  # in the logarithm of a parameter: the distance of two models between which a direction is drawn
_FAILED_RESIDUAL = 1e3  # mmHg; above all that was simulated, the residual of what cannot be: the search turns back


class Stopped(Exception):  # noqa: N818  a request, not an error
    """The search was asked to stop."""


@dataclass(eq=False)
class Objective:
    """Residuals of one search; its state is the last good simulation, from which the next one starts, and the best.

    Attributes
    ----------
    space : ParameterSpace
    compared : Compared
        What is compared, and what enters the root.
    numerics : Numerics
    workers : int
        Threads for the columns of the Jacobian.
    exactness : float
        Of the Jacobian, as a share of its values: searches need little.
    stop : Event
        Set from outside to end the search.
    best : (array, array) or None
        Logarithms and residuals of the least S so far, of the points inside the bounds.
    """

    space: ParameterSpace
    compared: Compared
    numerics: Numerics
    workers: int
    stop: threading.Event
    exactness: float = 1e-6
    simulations: int = 0
    last: Run | None = None
    best: tuple[np.ndarray, np.ndarray] | None = None
    _at: np.ndarray | None = field(default=None, repr=False)
    _waves: Waves | None = field(default=None, repr=False)
    _slopes: tuple[np.ndarray, Waves | None] | None = field(default=None, repr=False)
    _largest: float = field(default=0.0, repr=False)

    @cached_property
    def driven(self) -> Inflow | InletPressure:
        """What enters the root."""
        return self.compared.driven

    def compared_with(self, compared: Compared) -> "Objective":
        """Return the objective of the same models against other data."""
        return replace(self, compared=compared, best=None)

    def run(self, x: np.ndarray) -> Run:
        """Simulate at the logarithms `x` of the free parameters; raises `NumericalError` where that cannot be."""
        if self.stop.is_set():
            raise Stopped
        self.simulations += 1
        with trial():
            model = self.space.model(self.space.values(x))
            try:
                return simulate_run(model, self.driven, self.numerics, self.last)
            except IMPOSSIBLE_ERRORS:
                if self.last is None:
                    raise
                return simulate_run(model, self.driven, self.numerics, None)  # the neighbour may mislead

    def at(self, x: np.ndarray) -> Run:
        """Return the simulation at `x`, the last one if it was there; raises `NumericalError`."""
        if self.last is None or self._at is None or not np.array_equal(self._at, x):
            self.last, self._at, self._slopes = self.run(x), x.copy(), None
            self._waves = self._seen(self.last)
        return self.last

    def begin_from(self, run: Run) -> None:
        """Let the next simulation start from the state of another."""
        self.last, self._at = run, None

    def waves(self, x: np.ndarray) -> Waves | None:
        """Return the waves at the further sites at `x`; None where there are none."""
        self.at(x)
        return self._waves

    @cached_property
    def _places(self) -> Places | None:
        """Where waves are seen beside the pressure at the inlet: at sites, then at the inlet if flow is compared."""
        sites = self.compared.sites
        vessel, share = (np.zeros(0, int), np.zeros(0)) if sites is None else (sites.places.vessel, sites.places.share)
        if self.compared.what == "flow":
            vessel, share = np.append(vessel, self.space.network.root), np.append(share, 0.0)
        return Places(vessel, share) if len(vessel) else None

    def _seen(self, run: Run) -> Waves | None:
        with trial():
            return None if self._places is None else waves_at(run, self.driven, self._places)

    def can_be(self, x: np.ndarray) -> bool:
        """Whether there is a simulation at `x`."""
        try:
            self.at(x)
        except NumericalError:
            return False
        return True

    def residuals(self, x: np.ndarray) -> np.ndarray:
        """Measured minus simulated at the inlet, mmHg, shape (N,) (eq. 14); of a failed trial, too large.

        Those of further sites follow, scaled and balanced (`Sites`).
        """
        sites = self.compared.sites
        try:
            residual = self.compared.measured - self.compared.simulated(self.at(x))
            if sites is not None and self._waves is not None:
                at_sites = sites.balance @ (sites.measured - sites.coefficients(self._waves))
                residual = np.concatenate([residual, at_sites])
        except NumericalError:
            count = self.compared.samples + (0 if sites is None else len(sites.harmonic))
            return np.full(count, _FAILED_RESIDUAL + self._largest)
        self._largest = max(self._largest, float(np.max(np.abs(residual))))
        low, high = self.space.log_bounds
        inside = np.all((low <= x) & (x <= high))
        if inside and (self.best is None or residual @ residual < self.best[1] @ self.best[1]):
            self.best = x.copy(), residual
        return residual

    def jacobian(self, x: np.ndarray) -> np.ndarray:
        """Derivative of the residuals by the logarithms, shape (N, free); counted as one simulation, as it costs, once.

        Raises
        ------
        NumericalError
            It cannot be simulated there or nearby, or its derivatives are not numbers.
        """
        run = self.at(x)
        if self.stop.is_set():
            raise Stopped
        with trial():
            if self._slopes is None:
                self.simulations += 1
                self._slopes = self._derivatives(run, [self._direction(x, unit) for unit in np.eye(len(x))])
            jacobian = self._jacobian(*self._slopes)
        if not np.isfinite(jacobian).all():
            raise NumericalError("the derivatives of the pressure are not numbers: the wall is at the end of its law")
        return jacobian

    def _derivatives(self, run: Run, directions: list[Direction]) -> tuple[np.ndarray, Waves | None]:
        """Return the derivatives of what is compared at the inlet, at every step, and of the waves at the places."""
        options = self.numerics, self.exactness, self.workers
        if self._places is None or self._waves is None:
            return pressure_derivatives(run, self.driven, directions, *options), None
        inlet, waves = derivatives(run, self.driven, directions, options[0], (self._places, self._waves), *options[1:])
        return (self.compared.scale * waves.flow[:, :, -1] if self.compared.what == "flow" else inlet), waves

    def _jacobian(self, inlet: np.ndarray, waves: Waves | None) -> np.ndarray:
        at_inlet, sites = np.stack([self.compared.sampled(column) for column in inlet], axis=1), self.compared.sites
        if sites is None or waves is None or self._waves is None:
            return -at_inlet
        return -np.concatenate([at_inlet, sites.balance @ sites.jacobian(self._waves, waves)])

    def _direction(self, x: np.ndarray, unit: np.ndarray) -> Direction:
        before, after = (self.space.model(self.space.values(x + side * _LOG_STEP * unit)) for side in (-0.5, 0.5))
        return direction_between(before, after, _LOG_STEP)
