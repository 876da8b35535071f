"""The linear network that leads the starts of a fit, c: a tree of straight vessels, compiled, many members at once.

It need not be exact, since simulations correct it (`surrogate`). So the same tree leads fits of networks with tapers,
loops and pressures that pulsate behind their beds, which it does not know. The exact solution would take 30 times as
long.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from vasowave.base.errors import NumericalError
from vasowave.pulse.calibration.compared import Compared
from vasowave.pulse.calibration.parameters import ParameterSpace, trial
from vasowave.pulse.cycle.cycle import Recording
from vasowave.pulse.cycle.waveform import amplitudes
from vasowave.pulse.model.outlets import BUILT_IN as BEDS
from vasowave.pulse.model.parameters import model_fields
from vasowave.pulse.model.straight_trees import TreeMembers, solve_members
from vasowave.pulse.model.walls import WALL_VISCOSITY
from vasowave.pulse.network.network import Network


@dataclass(frozen=True)
class LinearTreeRules:
    """What the linear network gives.

    Attributes
    ----------
    max_harmonics : int
        Harmonics, at most: above them little of a pulse is left.
    bed_step : float
        Step of differences in the logarithms of the factors of beds.
    """

    max_harmonics: int = 12
    bed_step: float = 1e-3


RULES = LinearTreeRules()
Batch = Callable[[np.ndarray], np.ndarray]


def spectrum_of(residual: np.ndarray, samples: int) -> np.ndarray:
    """Return as many real numbers as the residual has, whose sum of squares is S/N: the mean, cosines and sines.

    Those of further sites stay as they are. `residual` has them on its first axis.
    """
    halves = np.fft.rfft(residual[:samples], axis=0) / samples
    scale = np.full(len(halves), np.sqrt(2.0))
    scale[0] = 1.0
    if samples % 2 == 0:
        scale[-1] = 1.0
    halves = (halves.T * scale).T
    return np.concatenate([halves.real, halves.imag, residual[samples:] / np.sqrt(samples)])


def linear_spectra(space: ParameterSpace, compared: Compared) -> Batch:
    """Return a function of logarithms, shape (point, free): what the linear network leaves, as `spectrum_of` has it.

    It is a tree of straight vessels before beds with steady pressures behind: what tapers, loops and pulsation change
    is left to the correction. Above the harmonics that it gives it leaves nothing. NaN where the network cannot be.
    """
    held = compared.samples // 2 + 1
    rows = 2 * held + (0 if compared.sites is None else len(compared.sites.harmonic))
    count = min((compared.samples - 1) // 2, RULES.max_harmonics) + 1
    scale = np.where(np.arange(count) > 0, np.sqrt(0.5), 1.0)
    measured, network = amplitudes(compared.measured)[:count], spanning_tree(space.network)
    impedances = _impedances(space, count, compared.recording.period)

    def harmonics_at(points: np.ndarray) -> np.ndarray:
        try:
            with trial():
                return _harmonics(_solved(space, network, points, compared.recording, impedances, count), compared)
        except NumericalError:  # a law that raises for some of them
            nothing = np.full((1, count), np.nan)
            return np.vstack([harmonics_at(point) for point in points[:, np.newaxis]]) if len(points) > 1 else nothing

    def spectra(points: np.ndarray) -> np.ndarray:
        missed = scale * (measured - harmonics_at(points))
        values = np.zeros((len(points), rows))
        values[:, :count], values[:, held : held + count] = missed.real, missed.imag
        return values

    return spectra


def spanning_tree(network: Network) -> Network:
    """Return the vessels on the shortest ways from the inlet to the beds; a tree as it is."""
    if network.nodes is None:
        return network
    rows: set[int] = set()
    for terminal in network.terminals:
        row = int(terminal)
        while row >= 0 and row not in rows:
            rows.add(row)
            row = int(network.parent[row])
    number = {row: place for place, row in enumerate(sorted(rows))}
    parents = [number.get(int(network.parent[row]), -1) for row in number]
    names, chosen = tuple(network.name[row] for row in number), list(number)
    return Network(names, parents, network.length[chosen], network.radius[chosen], pressure=network.pressure)


def _impedances(space: ParameterSpace, count: int, period: float) -> Batch:
    """Return a function of all parameters, shape (point, parameter): impedances, shape (point, terminal, harmonic).

    Of beds that are no circuits, and cost much, to first order in the logarithms about the nominal ones.
    """
    omega = 2 * np.pi / period * np.arange(count)[:, np.newaxis]

    def exact(values: np.ndarray) -> np.ndarray:
        columns = dict(zip(space.names, values.T[..., np.newaxis], strict=True))
        impedance = model_fields(columns, space.law, space.outlets)["outlets"].impedance(omega)
        return np.ascontiguousarray(np.moveaxis(impedance, 0, -1), dtype=complex)

    def impedance_of(values: np.ndarray) -> np.ndarray:
        return np.asarray(space.model(values).outlets.impedance_at(count, period)).T

    if type(space.outlets) in BEDS:
        return exact
    bed = [number for number, name in enumerate(space.names) if name.owner == "bed" and space.free[number]]
    nominal = space.nominal[bed]
    base = impedance_of(space.nominal)
    steps = [np.where(np.arange(len(space.names)) == number, np.exp(RULES.bed_step), 1.0) for number in bed]
    slopes = np.array([np.log(impedance_of(space.nominal * step) / base) / RULES.bed_step for step in steps])

    def expanded(values: np.ndarray) -> np.ndarray:
        return np.asarray(base * np.exp(np.tensordot(np.log(values[:, bed] / nominal), slopes, axes=1)))

    return expanded if bed else lambda values: np.tile(base, (len(values), 1, 1))


class _Inlet(NamedTuple):
    """Pressure (mmHg) and impedance at the inlet of many models, (point, harmonic), and its pressure without flow."""

    pressure: np.ndarray
    impedance: np.ndarray
    unmoved: np.ndarray


def _solved(
    space: ParameterSpace, network: Network, points: np.ndarray, recording: Recording, impedances: Batch, count: int
) -> _Inlet:
    """Return what the recorded flow makes of models; NaN where a wall has no area."""
    values = np.tile(space.nominal, (len(points), 1))
    values[:, space.free] = np.exp(points)
    columns = dict(zip(space.names, values.T[..., np.newaxis], strict=True))
    wall = space.law(*(columns[name] for name in space.names_of("wall")))
    viscosity = np.atleast_2d(columns.get(WALL_VISCOSITY, 0.0))
    area0 = network.area / np.asarray(wall.ratio_at(network.pressure, *wall))
    behind = np.full(len(network.terminals), float(space.outlet_pressure))
    members = TreeMembers(wall, np.where(area0 > 0, area0, np.nan), viscosity, impedances(values), behind)
    flow = _first(recording.flow, count)
    _, means, spectra = solve_members(network, space.blood, members, flow, recording.period)
    root = network.root
    return _Inlet(spectra.pressure[:, root], spectra.input_impedance[:, root], means.by_beds[:, root])


def _harmonics(inlet: _Inlet, compared: Compared) -> np.ndarray:
    """Return the harmonics of what is compared, shape (point, harmonic), mmHg."""
    if compared.what == "pressure":
        return inlet.pressure
    drives = np.tile(_first(compared.recording.pressure, inlet.pressure.shape[1]), (len(inlet.pressure), 1))
    drives[:, 0] -= inlet.unmoved
    return compared.scale * drives / inlet.impedance


def _first(signal: np.ndarray, count: int) -> np.ndarray:
    """Return so many amplitudes of a signal, the mean first; 0 where it holds no more."""
    held = amplitudes(signal)[: min(count, (len(signal) - 1) // 2 + 1)]
    return np.pad(held, (0, count - len(held)))
