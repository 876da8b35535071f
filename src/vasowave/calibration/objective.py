"""The objective S (eq. 14), its residuals and their Jacobian, by simulation.

The measured flow is what enters the root, so the flow's part of eq. 14 vanishes and the pressure's part remains.
"""

import threading
from dataclasses import dataclass, field

import numpy as np

from vasowave.calibration.compared import Compared
from vasowave.calibration.parameters import Space
from vasowave.errors import NumericalError
from vasowave.recording import Inflow
from vasowave.solver.direction import Direction, direction_between
from vasowave.solver.result import Run
from vasowave.solver.sensitivity import pressure_derivatives
from vasowave.solver.simulate import Numerics, simulate_run

_APART = 1e-4  # in the logarithm of a parameter: the distance of two models between which a direction is drawn
_FAILED = 1e3  # mmHg, residual of a parameter set that cannot be simulated: the search turns back


class Stopped(Exception):  # noqa: N818  a request, not an error
    """The search was asked to stop."""


@dataclass(eq=False)
class Objective:
    """Residuals of one search; its state is the last good simulation, from which the next one starts.

    Attributes
    ----------
    space : Space
    compared : Compared
        The measured pressure, and the flow that enters the root.
    numerics : Numerics
    workers : int
        Threads for the columns of the Jacobian.
    exactness : float
        Of the Jacobian, as a share of its values: searches need little.
    stop : Event
        Set from outside to end the search.
    """

    space: Space
    compared: Compared
    numerics: Numerics
    workers: int
    stop: threading.Event
    exactness: float = 1e-6
    simulations: int = 0
    last: Run | None = None
    _at: np.ndarray | None = field(default=None, repr=False)

    @property
    def inflow(self) -> Inflow:
        """The measured flow."""
        return self.compared.recording.inflow

    def run(self, x: np.ndarray) -> Run:
        """Simulate at the logarithms `x` of the free parameters."""
        if self.stop.is_set():
            raise Stopped
        self.simulations += 1
        model = self.space.model(self.space.values(x))
        try:
            return simulate_run(model, self.inflow, self.numerics, self.last)
        except NumericalError:
            if self.last is None:
                raise
            return simulate_run(model, self.inflow, self.numerics, None)  # the neighbour may mislead

    def at(self, x: np.ndarray) -> Run:
        """Return the simulation at `x`, the last one if it was there; raises `NumericalError`."""
        if self.last is None or self._at is None or not np.array_equal(self._at, x):
            self.last, self._at = self.run(x), x.copy()
        return self.last

    def residuals(self, x: np.ndarray) -> np.ndarray:
        """Measured minus simulated pressure at the inlet, mmHg, shape (N,) (eq. 14)."""
        try:
            return self.compared.pressure - self.compared.simulated(self.at(x))
        except NumericalError:
            return np.full(self.compared.samples, _FAILED)

    def reached(self, start: np.ndarray) -> np.ndarray:
        """Return the logarithms that were simulated last, or `start` where none were."""
        return start if self._at is None else self._at

    def jacobian(self, x: np.ndarray) -> np.ndarray:
        """Derivative of the residuals by the logarithms, shape (N, free); counted as one simulation, as it costs."""
        run = self.at(x)
        if self.stop.is_set():
            raise Stopped
        self.simulations += 1
        directions = [self._direction(x, unit) for unit in np.eye(len(x))]
        derivatives = pressure_derivatives(run, self.inflow, directions, self.numerics, self.exactness, self.workers)
        return -np.stack([self.compared.sampled(column) for column in derivatives], axis=1)

    def _direction(self, x: np.ndarray, unit: np.ndarray) -> Direction:
        before, after = (self.space.model(self.space.values(x + side * _APART * unit)) for side in (-0.5, 0.5))
        return direction_between(before, after, _APART)
