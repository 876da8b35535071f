"""Arteries and veins that share their vascular beds: what flows out of the beds of one enters the other.

Each side is a model of its own. The pressure at the inlets of the veins stands behind the beds of the arteries, and the
flow through the distal resistances enters the veins. The two are simulated in turn until that pressure stays. What the
veins answer to a change of it is known from their linear model, harmonic by harmonic, and taken into account: veins
resonate, and without that a turn would leave more than the one before.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, cast

import numpy as np
import xarray as xr

from vasowave.base.errors import InputError, NumericalError, did_you_mean
from vasowave.base.findings import warn
from vasowave.pulse.cycle.averaged import EnsembleAverage
from vasowave.pulse.cycle.cycle import Inflow, Recording
from vasowave.pulse.model.linear import linear_solution
from vasowave.pulse.model.model import Model
from vasowave.pulse.model.numerics import Numerics
from vasowave.pulse.model.outlets import Bed, Circuit
from vasowave.pulse.model.ventricle import Driven
from vasowave.pulse.solver.dataset import as_dataset
from vasowave.pulse.solver.result import Run
from vasowave.pulse.solver.simulation import driving, simulate_run

_CLOSE = 1e-3  # mmHg, change of the pressure behind the beds after which no turn follows
_TURNS = 40  # at most
_PUSH = 1e-4  # ml/s in every harmonic, by which the veins' impedances are found
_INLET, _OUTLET = 0, 2  # stations


@dataclass(frozen=True, eq=False)
class Circulation:
    """Arteries whose beds drain into veins.

    Attributes
    ----------
    arteries : Model
        Its beds are resistances or Windkessels; what it says of the pressure behind them is not used.
    veins : Model
        A network of one inlet or several, in the direction of the flow: confluences have several parents. What is
        behind its own outlets is the left (or right) atrium: ``outlet_pressure``, ``outlet_pulsation``.
    drains : mapping
        The inlet of the veins, by name, into which the bed of each terminal artery drains, by name. Several beds may
        drain into one.

    Raises
    ------
    InputError
        Beds that are no circuits, a terminal artery that drains nowhere, an inlet into which nothing drains, a name
        that is not there.

    Examples
    --------
    >>> import vasowave as vw
    >>> artery, vein = vw.Network(["a"], [-1], [0.4], [0.05]), vw.Network(["v"], [-1], [0.4], [0.05])
    >>> arteries = vw.Model(artery, vw.LinearWall(60.0), vw.Windkessel([8.0], [70.0], [1.5e-3]))
    >>> veins = vw.Model(vein, vw.LinearWall(60.0), vw.Resistance([10.0]), outlet_pressure=4.0)
    >>> waves = vw.Circulation(arteries, veins, {"a": "v"}).simulate(vw.virtual_mouse())
    >>> list(waves), waves["veins"].pressure.dims
    (['arteries', 'veins'], ('time', 'vessel', 'station'))
    """

    arteries: Model
    veins: Model
    drains: Mapping[str, str]

    def __post_init__(self) -> None:
        """Check that every bed leads from an artery to a vein."""
        if not isinstance(self.arteries.outlets, Bed) or self.arteries.outlets.circuit() is None:
            raise InputError(
                f"{type(self.arteries.outlets).__name__}: what flows out of such beds is not known; give the arteries "
                "resistances or Windkessels"
            )
        drain_names = [*self.drains, *self.drains.values()] if isinstance(self.drains, Mapping) else [None]
        if not all(isinstance(name, str) for name in drain_names):
            raise InputError("drains: give one inlet of the veins for each terminal artery by their names: {'a': 'v'}")
        terminals = [self.arteries.network.name[row] for row in self.arteries.network.terminals]
        inlets = list(self.veins.network.inlet_names)
        for kind, names, valid_names in (("a terminal artery", self.drains, terminals), ("an inlet of the veins",
                                   self.drains.values(), inlets)):  # fmt: skip
            for name in names:
                if name not in valid_names:
                    raise InputError(f"drains: '{name}' is not {kind}{did_you_mean(name, valid_names)}")
        for lacking, reason in (
            (set(terminals) - set(self.drains), "drains nowhere; name the inlet of the veins behind its bed"),
            (set(inlets) - set(self.drains.values()), "is an inlet of the veins into which no bed drains"),
        ):
            if lacking:
                raise InputError(f"drains: '{min(lacking)}' {reason}")

    def simulate(
        self, inflow: Driven | Recording | EnsembleAverage, numerics: Numerics | None = None
    ) -> dict[str, xr.Dataset]:
        """Simulate one cycle of the periodic state of both.

        Parameters
        ----------
        inflow : Inflow, Recording, EnsembleAverage, InletPressure or Ventricle
            What enters the arteries, as in `simulate`.
        numerics : Numerics, optional

        Returns
        -------
        dict of str to Dataset
            ``arteries`` and ``veins``, each as `simulate` returns it.

        Warns
        -----
        VasowaveWarning
            For every note of one of the two.

        Raises
        ------
        NumericalError
            As `simulate`, or if the pressure between the two does not settle.
        """
        driven = driving(inflow)
        numerics = numerics or Numerics()
        behind = np.full((numerics.samples, len(self.drains)), float(np.mean(self.veins.outlet_pressure)))
        change = np.inf
        for _ in range(_TURNS):
            arteries = simulate_run(self._before(behind), driven, numerics)
            veins = simulate_run(self.veins, self._drained(arteries, behind), numerics)
            entering_pressure = veins.pressure[:, _INLET][:, self._entered]
            before, change = change, float(np.max(np.abs(entering_pressure - behind)))
            if change < _CLOSE:
                for note in (*arteries.notes, *veins.notes):
                    warn(note)
                return {"arteries": as_dataset(arteries), "veins": as_dataset(veins)}
            if change > before:
                break
            behind = behind + self._answered(entering_pressure - behind, veins, driven.of_pressure)
        raise NumericalError(
            f"the pressure between arteries and veins does not settle: it changed by {change:.3g} mmHg in the last "
            "turn; check the walls of the veins and the resistances of the beds"
        )

    def _before(self, behind: np.ndarray) -> Model:
        """Return the arteries before a pressure, mmHg, shape (sample, terminal)."""
        mean = behind.mean(axis=0)
        return self.arteries.changed(outlet_pressure=mean, outlet_pulsation=behind - mean)

    def _drained(self, run: Run, behind: np.ndarray) -> Inflow:
        """Return what flows through the beds of the arteries into each inlet of the veins."""
        terminals = run.model.network.terminals
        pressure, flow = run.pressure[:, _OUTLET][:, terminals], run.stations[1][:, terminals, _OUTLET]
        through = _through(self._circuit, pressure, flow, behind)
        inlets = self.veins.network.inlets
        entering = [through[:, self._entered == inlet].sum(axis=1) for inlet in inlets]
        return Inflow(np.stack(entering, axis=1), run.period)

    def _answered(self, missed: np.ndarray, run: Run, of_pressure: bool) -> np.ndarray:
        """Return the change of the pressure behind the beds, mmHg, that makes up for what a turn missed.

        A bed lets out less where that pressure rises, by the distal resistance and the capacitor behind each other.
        """
        count = len(missed) // 2 + 1
        omega = 2 * np.pi / run.period * np.arange(count)[:, np.newaxis]
        circuit = self._circuit
        with np.errstate(divide="ignore", invalid="ignore"):
            lets = np.where(circuit.distal > 0, 1 / (circuit.distal + 1 / (1j * omega * circuit.compliance)),
                            1 / circuit.proximal)  # fmt: skip
        lets[0] = 1 / (circuit.proximal + circuit.distal) if of_pressure else 0.0  # a flow that enters comes out
        rows = np.searchsorted(self.veins.network.inlets, self._entered)
        answer = _impedances(run, count)[:, rows[:, np.newaxis], rows] * lets[:, np.newaxis]
        spectrum = np.fft.rfft(missed, axis=0)[..., np.newaxis]
        return np.fft.irfft(np.linalg.solve(np.eye(len(rows)) + answer, spectrum)[..., 0], len(missed), axis=0)

    @property
    def _circuit(self) -> Circuit:
        beds: Any = self.arteries.outlets
        return cast(Circuit, beds.circuit())

    @property
    def _entered(self) -> np.ndarray:
        """Row of the vein into which the bed of each terminal artery drains."""
        arteries, veins = self.arteries.network, self.veins.network
        return np.array([veins.row(self.drains[arteries.name[row]]) for row in arteries.terminals])


def _through(circuit: Circuit, pressure: np.ndarray, flow: np.ndarray, behind: np.ndarray) -> np.ndarray:
    """Return the flow out of circuits, ml/s, by pressure (mmHg) and flow (ml/s) before and pressure behind them."""
    of_capacitor = pressure - circuit.proximal * flow - behind
    return np.where(circuit.distal > 0, of_capacitor / np.where(circuit.distal > 0, circuit.distal, 1.0), flow)


def _impedances(run: Run, count: int) -> np.ndarray:
    """Return the pressure at each inlet of veins by the flow into each, mmHg s/ml, shape (harmonic, inlet, inlet)."""
    model, inlets = run.model.changed(outlet_pulsation=None), run.model.network.inlets
    flows = np.tile(run.stations[1][:, inlets, _INLET].mean(axis=0), (2 * count, 1))
    pushes = count * _PUSH * np.eye(len(inlets) + 1)[:, 1:]  # none, then one for each inlet: every harmonic alike
    solved = []
    for push in pushes:
        pushed = flows.copy()
        pushed[0] += push
        solved.append(linear_solution(model, Inflow(pushed, run.period), count - 1).pressure[:, inlets])
    answers = (np.stack(solved[1:], axis=2) - solved[0][:, :, np.newaxis]) / _PUSH
    answers[0] *= 2.0  # the mean rises by half of what the amplitudes are
    return answers
