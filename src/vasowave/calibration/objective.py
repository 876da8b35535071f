"""The objective S (eq. 14), its residuals and their Jacobian, by simulation.

The measured flow is what enters the root, so the flow's part of eq. 14 vanishes and the pressure's part remains.
"""

import threading
from dataclasses import dataclass, field, replace

import numpy as np

from vasowave.calibration.compared import Compared
from vasowave.calibration.parameters import Space
from vasowave.errors import NumericalError, VasowaveError
from vasowave.recording import Inflow
from vasowave.solver.result import Run
from vasowave.solver.simulate import Numerics, simulate_run, simulate_runs

_STEP = 1e3  # finite difference in the logarithm of a parameter, over the tolerance in mmHg …
_STEPS = (1e-4, 1e-2)  # … within these: far above round-off, far below curvature
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
    stop : Event
        Set from outside to end the search.
    """

    space: Space
    compared: Compared
    numerics: Numerics
    workers: int
    stop: threading.Event
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

    def residuals(self, x: np.ndarray) -> np.ndarray:
        """Measured minus simulated pressure at the inlet, mmHg, shape (N,) (eq. 14)."""
        try:
            run = self.run(x)
        except NumericalError:
            return np.full(self.compared.samples, _FAILED)
        self.last, self._at = run, x.copy()
        return self._residuals(run)

    def reached(self, start: np.ndarray) -> np.ndarray:
        """Return the logarithms that were simulated last, or `start` where none were."""
        return start if self._at is None else self._at

    def jacobian(self, x: np.ndarray) -> np.ndarray:
        """Derivative of the residuals by the logarithms, shape (N, free), from one ensemble of simulations."""
        if self._at is None or not np.array_equal(self._at, x):
            self.residuals(x)
        base = self.last
        if base is None or self._at is None or not np.array_equal(self._at, x):
            raise NumericalError("the parameters at which a derivative is asked cannot be simulated")
        here = self._residuals(base)
        numerics = replace(self.numerics, steps_per_cycle=base.steps)
        step = min(max(_STEP * self.numerics.tolerance, _STEPS[0]), _STEPS[1])
        columns = self._columns(x, step, base, numerics)
        for i, column in enumerate(columns):
            if column is None:
                columns[i] = self._beyond_the_edge(x, i, step, base, numerics, here)
        return np.stack([(column - here) / step for column in columns if column is not None], axis=1)

    def _beyond_the_edge(
        self, x: np.ndarray, i: int, step: float, base: Run, numerics: Numerics, here: np.ndarray
    ) -> np.ndarray:
        """Residuals a whole step ahead, from the other side or from shorter steps: ahead, nothing can be simulated."""
        for part in (-1.0, 0.1, -0.1):
            found = self._columns(x, part * step, base, numerics, only=i)[0]
            if found is not None:
                return here + (found - here) / part
        raise NumericalError(
            f"the derivative by '{self.space.free_names[i]}' cannot be found: beside its present value no "
            "model can be simulated; fix this parameter, or draw its bounds closer"
        )

    def _columns(
        self, x: np.ndarray, step: float, base: Run, numerics: Numerics, only: int | None = None
    ) -> list[np.ndarray | None]:
        if self.stop.is_set():
            raise Stopped
        moved = [x + step * unit for i, unit in enumerate(np.eye(len(x))) if only is None or i == only]
        models = [self.space.model(self.space.values(y)) for y in moved]
        self.simulations += len(models)
        runs = simulate_runs(models, self.inflow, numerics, base, workers=self.workers)
        return [None if isinstance(run, VasowaveError) else self._residuals(run) for run in runs]

    def _residuals(self, run: Run) -> np.ndarray:
        return self.compared.pressure - self.compared.simulated(run)
