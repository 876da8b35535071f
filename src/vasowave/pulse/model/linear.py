"""The network in the frequency domain, linearized about its mean pressure.

Every vessel is a transmission line with compliance dA/dp, inertance ρ/A and the friction of eq. 2; junctions join
admittances, outlets close the ends. A vessel whose radius or stiffness change along its way is a chain of such lines.

Where junctions share the total pressure H = p + ½ρu², the waves are those of H and q about the mean velocity u: lines
with ρ/A and dA/dp over 1 - u²/c², along which the flow carries waves by u/(c² - u²).

A viscous wall has the compliance dA/dp / (1 + iω τ) with τ = η/(2 √(A A0)) dA/dp; pressures are those of law and
viscosity together.
It needs no time stepping and shares no code with the solver, which starts from it and is tested against it.
"""

from dataclasses import dataclass
from functools import reduce
from typing import Any, NamedTuple

import numpy as np

from vasowave.pulse.cycle.cycle import Inflow
from vasowave.pulse.model import walls
from vasowave.pulse.model.model import Model
from vasowave.pulse.model.straight_trees import MEAN_ROUNDS, TreeMembers, retardation, solve_members
from vasowave.pulse.model.two_ports import TwoPort, driven_from_behind, input_impedances, joined, steady_means
from vasowave.pulse.model.ventricle import Driven, Ventricle

_PARTS = 6  # lines that a vessel makes where one changes along its way
_FASTEST = 0.8  # u²/c² of the mean flow, at most: beyond, no linear theory knows the waves
_UNHINDERED = 1e-4  # of ρL/(A T), the resistance that a vessel of a graph has at least
_LINES, _CLOSED = 20, 1e-12  # straight lines in the inflow, at most, and the share of a pressure they may miss
_OF_IMPEDANCE, _EJECTED = 12, 0.5  # harmonics, and share of its volume that a ventricle ejects: a guess of its flow
_GAUSS = 0.5 + np.array([-0.5, 0.5]) / np.sqrt(3.0)  # places in a line whose mean is right to third order


class UniformLines(NamedTuple):
    """One uniform line in every vessel.

    Attributes
    ----------
    propagation : complex array, shape (harmonic, vessel)
        Propagation constant γ, 1/cm.
    impedance : complex array, shape (harmonic, vessel)
        Characteristic impedance, mmHg s/ml.
    resistance : array, shape (vessel,)
        Steady resistance per length, mmHg s/ml/cm.
    carried : complex array, shape (harmonic, vessel)
        What the mean flow takes from γ of the waves that go with it, and adds to that of the others, 1/cm.
    """

    propagation: np.ndarray
    impedance: np.ndarray
    resistance: np.ndarray
    carried: np.ndarray | None

    def after(self, vessel: np.ndarray, x: np.ndarray, P: np.ndarray, Q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the spectra of pressure and flow x (cm) behind a place in vessels where they are P and Q."""
        cosh, sinh = _hyperbolic(self.propagation[:, vessel] * x)
        Z = self.impedance[:, vessel]
        p = P * cosh - Z * Q * sinh
        q = Q * cosh - P / Z * sinh
        if self.carried is not None:
            ahead = np.exp(self.carried[:, vessel] * x)
            p, q = p * ahead, q * ahead
        p[0], q[0] = P[0] - self.resistance[vessel] * x * Q[0], Q[0]
        return p, q

    def passage(self, length: np.ndarray) -> TwoPort:
        """Return what lines of these lengths (cm) do to waves."""
        cosh, sinh = _hyperbolic(self.propagation * length)
        across, along = self.impedance * sinh / cosh, sinh / cosh / self.impedance
        across[0], along[0] = self.resistance * length, 0.0  # a steady flow meets resistance alone
        if self.carried is not None:
            cosh = cosh * np.exp(-self.carried * length)
        return TwoPort(cosh, np.ones_like(cosh), across, along)


class Motion(NamedTuple):
    """What the mean velocity u makes of the static pressure P, at one place in every vessel: H = keeps P + dynamic Q.

    A node's pressure is transmission H + lost Q at the inlet of a vessel that has a loss.

    Attributes
    ----------
    keeps : array, shape (harmonic, vessel)
        1 - u²/c²; 1 for the mean.
    dynamic : array, shape (harmonic, vessel)
        ρu/A, mmHg s/ml; half of it for the mean.
    transmission, lost : array, shape (harmonic, vessel)
        1 and 0 without loss; the second mmHg s/ml.
    """

    keeps: np.ndarray
    dynamic: np.ndarray
    transmission: np.ndarray
    lost: np.ndarray

    def between(self, after: "Motion", share: np.ndarray, vessel: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return `keeps` and `dynamic` at a share of the way from here to another place in vessels (rows)."""
        keeps, dynamic = (
            (1 - share) * begin[:, vessel] + share * end[:, vessel] for begin, end in zip(self[:2], after[:2])
        )
        return keeps, dynamic


@dataclass(frozen=True, eq=False)
class LinearSolution:
    """Harmonics of pressure and flow in every vessel.

    Attributes
    ----------
    period : float
        s.
    mean_pressure : array, shape (vessel,)
        Mean pressure about which each vessel is linearized, mmHg.
    input_impedance : complex array, shape (harmonic, vessel)
        Impedance at each vessel's inlet, mmHg s/ml: pressure over flow of what the inflow makes, so that the mean
        counts from the pressure behind the outlets. Where no flow passes a vessel of a loop, it is infinite.
    pressure, flow : complex array, shape (harmonic, vessel)
        Spectra at the vessels' inlets (mmHg, ml/s): p(t) = Re Σ P_k exp(iω_k t), the mean at k = 0.
    lines : tuple of UniformLines
        What every vessel consists of, from its inlet on, in parts of the same length.
    length : array, shape (vessel,)
        cm.
    retardation : array, shape (vessel,)
        Time τ of viscous walls, s.
    motion : pair of Motion, optional
        At inlets and outlets, where junctions share the total pressure or flow loses any.
    """

    period: float
    mean_pressure: np.ndarray
    input_impedance: np.ndarray
    pressure: np.ndarray
    flow: np.ndarray
    lines: tuple[UniformLines, ...]
    length: np.ndarray
    retardation: np.ndarray
    motion: tuple[Motion, Motion] | None = None

    @property
    def resistance(self) -> np.ndarray:
        """Steady resistance per length, mmHg s/ml/cm, shape (vessel,)."""
        return np.asarray(sum(line.resistance for line in self.lines) / len(self.lines))

    def at(self, vessel: np.ndarray, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the spectra of pressure and flow at x (cm) into the vessels (rows), shape (harmonic, place)."""
        p, q = self.pressure[:, vessel], self.flow[:, vessel]
        if self.motion is not None:
            p = p * self.motion[0].keeps[:, vessel] + self.motion[0].dynamic[:, vessel] * q
        line_length = self.length[vessel] / len(self.lines)
        for k, line in enumerate(self.lines):
            from_start = x - k * line_length if k else x  # a place beyond an end lies on the line that is next to it
            within = from_start if k == len(self.lines) - 1 else np.minimum(from_start, line_length)
            p, q = line.after(vessel, within if k == 0 else np.maximum(within, 0.0), p, q)
        if self.motion is not None:
            keeps, dynamic = self.motion[0].between(self.motion[1], x / self.length[vessel], vessel)
            p = (p - dynamic * q) / keeps
        return p, q

    def of_law(self, pressure: np.ndarray, vessel: Any = slice(None)) -> np.ndarray:
        """Return the share of spectra of the pressure in vessels (rows) that is the law's, without viscosity."""
        if not np.any(self.retardation):
            return pressure
        omega = 2 * np.pi / self.period * np.arange(len(pressure))[:, np.newaxis]
        return np.asarray(pressure / (1.0 + 1j * omega * self.retardation[vessel]))

    def in_time(self, spectrum: np.ndarray, t: float | np.ndarray) -> np.ndarray:
        """Return the signals at time t (s) whose spectra stand on the first axis."""
        k = np.arange(len(spectrum))
        phase = np.exp(2j * np.pi / self.period * np.multiply.outer(np.asarray(t), k))
        return np.tensordot(phase, spectrum, axes=1).real

    def over_cycle(self, spectrum: np.ndarray, count: int) -> np.ndarray:
        """Return the signals at `count` evenly spaced times of the cycle, more than twice the harmonics."""
        halves = 0.5 * count * spectrum
        halves[0] *= 2.0
        return np.fft.irfft(halves, count, axis=0)


def linear_solution(model: Model, inflow: Driven, harmonics: int = 32) -> LinearSolution:
    """Solve the linearized network for the harmonics 0 … `harmonics` of the inflow, or of the pressure that drives.

    A ventricle, whose valve is not linear, ejects into three elements that stand for the network.
    """
    if isinstance(inflow, Ventricle):
        inflow = _ejected(model, inflow, harmonics)
    entering = inflow.into(model.network.inlet_names)
    spectrum = _spectrum(entering, min(harmonics, (len(entering) - 1) // 2) + 1)
    if inflow.of_pressure:
        return _driven_by_pressure(model, spectrum, inflow.period)
    return _about_mean(model, spectrum, inflow.period)


def _about_mean(model: Model, spectrum: np.ndarray, period: float) -> LinearSolution:
    """Return the solution about the mean state that this inflow makes, compiled where the kernel knows the model."""
    solution = _compiled(model, spectrum[:, 0], period) if _is_plain(model) else None
    return solution or _solve(model, spectrum, *_mean_state(model, spectrum[0].real, period), period)


def _is_plain(model: Model) -> bool:
    return (
        model.network.nodes is None and model.profile is None and not model.dynamic and model.outlet_pulsation is None
    )


def _compiled(model: Model, spectrum: np.ndarray, period: float) -> LinearSolution | None:
    """Return the solution of `straight_trees`; None where that is not finite."""
    wall = type(model.wall)(*(value[np.newaxis] for value in model.wall))
    viscosity = np.atleast_2d(np.asarray(model.wall_viscosity, dtype=float))
    end = np.ascontiguousarray(model.outlets.impedance_at(len(spectrum), period).T, dtype=complex)[np.newaxis]
    behind = np.asarray(model.outlet_pressure)
    members = TreeMembers(wall, model.area0[np.newaxis], viscosity, end, behind)
    mean_pressure, means, spectra = solve_members(model.network, model.blood, members, spectrum, period)
    if not np.all(np.isfinite(spectra)):
        return None
    propagation, impedance, Z_in, P, Q = (values[0].T for values in spectra)
    length = model.network.length
    line = UniformLines(propagation, impedance, means.fall[0] / length, None)
    delay = _retardation(model, model.wall, model.area0, mean_pressure[0])
    return LinearSolution(period, mean_pressure[0], Z_in, P, Q, (line,), length, delay)


def _spectrum(signal: np.ndarray, count: int) -> np.ndarray:
    """Return so many harmonics of signals, shape (sample, …), from the mean on; those that they do not hold are 0."""
    spectrum = np.zeros((count, signal.shape[1]), dtype=complex)
    values = np.fft.rfft(np.ascontiguousarray(signal.T))[:, : min(count, (len(signal) - 1) // 2 + 1)].T / len(signal)
    spectrum[: len(values)] = values
    spectrum[1:] *= 2
    return spectrum


def _ejected(model: Model, ventricle: Ventricle, harmonics: int) -> Inflow:
    """Return the flow of a ventricle into the network's resistance, compliance and characteristic impedance."""
    root, count = model.network.root, min(harmonics, _OF_IMPEDANCE) + 1
    ventricle.into(model.network.inlet_names)
    flow = np.zeros((count, 1), dtype=complex)
    flow[0] = _EJECTED * ventricle.filled / ventricle.period
    flow[1:] = flow[0]
    solution = _about_mean(model, flow, ventricle.period)
    impedance = solution.input_impedance[:, root]
    at_once = float(np.mean(np.abs(impedance[3:])))
    resistance = max(impedance[0].real - at_once, at_once)
    gives = abs((1.0 / (impedance[1] - at_once)).imag) * ventricle.period / (2 * np.pi)
    return ventricle.ejecting(at_once, resistance, gives, float(np.mean(model.outlet_pressure)))


def _driven_by_pressure(model: Model, pressure: np.ndarray, period: float) -> LinearSolution:
    """Return the solution whose inflow makes these harmonics of the pressure at the inlet, shape (harmonic, 1).

    The pressure is a straight line in the inflow, but for the mean flow's part in the state about which is linearized.
    """
    root = model.network.root
    behind, resistance = float(np.mean(model.outlet_pressure)), model.outlets.total_resistance()
    flow = np.zeros_like(pressure)
    flow[0] = (pressure[0].real - behind) / resistance
    for _ in range(_LINES):
        solution = _about_mean(model, flow, period)
        missed = pressure[:, 0] - solution.pressure[:, root]
        if np.max(np.abs(missed)) <= _CLOSED * np.max(np.abs(pressure)):
            break
        flow = flow + (missed / solution.input_impedance[:, root])[:, np.newaxis]
    return solution


def _mean_state(model: Model, inflow: np.ndarray, period: float) -> tuple[np.ndarray, np.ndarray]:
    """Mean pressure in the middle of every vessel (mmHg) and flow: areas fix friction, that the pressure, it areas."""
    network, blood = model.network, model.blood
    flows, bed = np.zeros(len(network)), model.outlets.impedance_at(1, period)[0].real
    entered = bed
    k0, k1 = blood.friction.coefficients(blood.viscosity, period)
    middle, segments = np.full(len(network), np.mean(model.outlet_pressure)), _parts(model)
    for _ in range(MEAN_ROUNDS):
        if model.dynamic:
            inlet, outlet = _motions(model, middle, flows, 1, period)
            entered = bed + outlet.dynamic[0, network.terminals]
        areas = [np.asarray(walls.area(wall, middle, area0)) for wall, area0 in segments]
        fall = _mean([blood.inertia * network.length * (k0 + k1 * np.sqrt(A)) / A**2 for A in areas])
        fall = fall + inlet.lost[0].real if model.dynamic else fall
        if network.nodes is not None:
            fall = np.maximum(fall, _least_resistance(model, areas, period))
        middle, flows = steady_means(network, fall, entered, inflow, np.asarray(model.outlet_pressure))
        if model.dynamic:
            middle = middle - 0.5 * (inlet.lost[0].real + inlet.dynamic[0] + outlet.dynamic[0]) * flows
    return middle, flows


def _least_resistance(model: Model, areas: list[np.ndarray], period: float) -> np.ndarray:
    """Resistance, mmHg s/ml, by which a steady flow divides between vessels without friction: as one that starts."""
    return _UNHINDERED / period * _mean([model.blood.inertia * model.network.length / A for A in areas])


def _motions(model: Model, pressure: np.ndarray, flow: np.ndarray, count: int, period: float) -> tuple[Motion, Motion]:
    """Return what mean pressure and flow of all vessels make of `count` harmonics at inlets and outlets."""
    rows, inertia = np.arange(len(model.network)), model.blood.inertia
    half = np.where(np.arange(count) > 0, 1.0, 0.5)[:, np.newaxis]
    omega = 2 * np.pi / period * np.arange(count)[:, np.newaxis]
    ends = []
    for share in (0.0, 1.0):
        wall, area0 = model.at(rows, np.full(len(rows), share))
        A = np.asarray(walls.area(wall, pressure, area0))
        u, c = flow / A, walls.wave_speed(wall, pressure, inertia)
        delay = _delay(model, wall, area0, pressure, omega)
        dynamic = inertia * u / A * model.total_pressure
        keeps = np.where(half < 1.0, 1.0, 1.0 - _slower((u / c) ** 2 / delay) * model.total_pressure)
        loss = np.where(model.network.parent < 0, 0.0, model.loss)
        viscous = np.where(model.network.parent < 0, 0.0, model.narrowing_drag(period))
        lost = (half * loss * inertia * np.abs(u) + viscous) / A / keeps
        by_area = (loss * u * np.abs(u) + viscous * u / inertia) / c**2
        transmission = np.where(half < 1.0, 1.0, 1.0 - by_area / delay / keeps)
        ends.append(Motion(keeps, half * dynamic, transmission, lost))
    return ends[0], ends[1]


def _parts(model: Model) -> list[tuple[Any, np.ndarray]]:
    """Return wall and A0 of all vessels at places along them: two in each of their lines, one if all are straight."""
    if not model.changing.any():
        return [(model.wall, model.area0)]
    rows = np.arange(len(model.network))
    shares = ((np.arange(_PARTS)[:, np.newaxis] + _GAUSS) / _PARTS).ravel()
    return [model.at(rows, np.full(len(rows), share)) for share in shares]


def _mean(values: list[np.ndarray]) -> np.ndarray:
    return np.asarray(sum(values[1:], start=values[0]) / len(values))


def _retardation(model: Model, wall: Any, area0: np.ndarray, pressure: np.ndarray) -> np.ndarray:
    """Time τ of the viscous walls, s, shape (vessel,), at the mean pressure."""
    A, C = walls.area(wall, pressure, area0), walls.area_compliance(wall, pressure, area0)
    return retardation(model.wall_viscosity, C, A, area0)


def _delay(model: Model, wall: Any, area0: np.ndarray, pressure: np.ndarray, omega: np.ndarray) -> Any:
    """What viscous walls divide their compliance by, 1 + iω τ, shape (harmonic, vessel); 1 where none is viscous."""
    if not np.any(model.wall_viscosity):
        return 1.0
    return 1.0 + 1j * omega * _retardation(model, wall, area0, pressure)


def _slower(ratio: np.ndarray) -> np.ndarray:
    """Return u²/c², or a smaller number where no linear theory knows the waves."""
    if np.iscomplexobj(ratio):
        return ratio * np.minimum(1.0, _FASTEST / np.maximum(np.abs(ratio), _FASTEST))
    return np.minimum(ratio, _FASTEST)


def _lines(
    model: Model, mean_pressure: np.ndarray, flow: np.ndarray, omega: np.ndarray, period: float
) -> tuple[UniformLines, ...]:
    inertia = model.blood.inertia
    k0, k1 = model.blood.friction.coefficients(model.blood.viscosity, period)
    lines, segments = [], _parts(model)
    step = 2 if len(segments) > 1 else 1
    for first in range(0, len(segments), step):
        series, shunt, resistance, carried = [], [], [], []
        for wall, area0 in segments[first : first + step]:
            A = np.asarray(walls.area(wall, mean_pressure, area0))
            drag = (k0 + k1 * np.sqrt(A)) / A
            C: Any = np.asarray(walls.area_compliance(wall, mean_pressure, area0))
            C = C / _delay(model, wall, area0, mean_pressure, omega)
            slowness: Any = np.zeros(len(A))  # u/c²
            keeps: Any = 1.0
            if model.total_pressure:
                slowness = inertia * flow * C / A**2
                keeps = 1.0 - _slower(slowness * flow / A)
            series.append(inertia / A * (1j * omega / keeps + drag))
            shunt.append(1j * omega * C / keeps)
            resistance.append(inertia / A * drag)
            carried.append(1j * omega * slowness / keeps)
        along, across = _mean(series), _mean(shunt)
        with np.errstate(divide="ignore", invalid="ignore"):
            Z_line = np.sqrt(along / across)
        Z_line[0] = 1.0  # has no meaning at zero frequency, where γ = 0 multiplies it
        with_flow = _mean(carried) if model.total_pressure else None
        lines.append(UniformLines(np.sqrt(along * across), Z_line, _mean(resistance), with_flow))
    return tuple(lines)


def _solve(
    model: Model, spectrum: np.ndarray, mean_pressure: np.ndarray, mean_flow: np.ndarray, period: float
) -> LinearSolution:
    network, motion = model.network, None
    omega = 2 * np.pi / period * np.arange(len(spectrum))[:, np.newaxis]
    lines = _lines(model, mean_pressure, mean_flow, omega, period)
    ports = reduce(TwoPort.then, (line.passage(network.length / len(lines)) for line in lines))
    end = model.outlets.impedance_at(len(spectrum), period)
    if model.dynamic:
        motion = _motions(model, mean_pressure, mean_flow, len(spectrum), period)
        end = motion[1].keeps[:, network.terminals] * end + motion[1].dynamic[:, network.terminals]
        transmission, lost = motion[0].transmission, motion[0].lost
        ports = ports._replace(
            turn=transmission * ports.turn + lost * ports.along, across=transmission * ports.across + lost
        )
    if network.nodes is None:
        Z_in, P, flow = _along_tree(model, ports, end, spectrum[:, 0])
    else:
        areas = [np.asarray(walls.area(wall, mean_pressure, area0)) for wall, area0 in _parts(model)]
        ports.across[0] = np.maximum(ports.across[0].real, _least_resistance(model, areas, period))
        P, flow = joined(network, ports, end, spectrum)
        with np.errstate(divide="ignore", invalid="ignore"):
            Z_in = P / flow
    behind = _behind(model, len(spectrum), period)
    if behind.any():
        n = len(behind)
        if motion is not None:
            behind = motion[1].keeps[:n, network.terminals] * behind
        back = driven_from_behind(network, TwoPort(*(term[:n] for term in ports)), end[:n], behind)
        P[:n], flow[:n] = P[:n] + back[0], flow[:n] + back[1]
    if motion is not None:
        keeps, dynamic = motion[0].keeps, motion[0].dynamic
        P = ((P - lost * flow) / transmission - dynamic * flow) / keeps
        with np.errstate(invalid="ignore"):  # infinite where no flow passes
            Z_in = ((Z_in - lost) / transmission - dynamic) / keeps
    delay = _retardation(model, model.wall, model.area0, mean_pressure)
    return LinearSolution(period, mean_pressure, Z_in, P, flow, lines, network.length, delay, motion)


def _along_tree(
    model: Model, ports: TwoPort, end: np.ndarray, spectrum: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return input impedance, pressure and flow at all inlets of a tree with nothing behind its beds."""
    network = model.network
    Z_in = input_impedances(network, end, ports)
    passed = (1.0 - ports.across / Z_in) / (ports.d * (ports.turn - ports.across * ports.along))
    P = np.empty_like(Z_in)
    P[:, network.root] = Z_in[:, network.root] * spectrum
    for rows in network.generations[1:]:
        parents = network.parent[rows]
        P[:, rows] = P[:, parents] * passed[:, parents]
    return Z_in, P, P / Z_in


def _behind(model: Model, count: int, period: float) -> np.ndarray:
    """Return harmonics of what stands before the beds of the pressures behind them, shape (harmonic, terminal), mmHg.

    Of steady ones the mean alone.
    """
    pulsation = model.pulsation_before_beds(period)
    if pulsation is None:
        return np.asarray(model.outlet_pressure, dtype=complex)[np.newaxis]
    return _spectrum(pulsation + model.outlet_pressure, count)


def _hyperbolic(x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Cosh x and sinh x of complex x, from one exponential."""
    grown = np.exp(x)
    decayed = 1.0 / grown
    return 0.5 * (grown + decayed), 0.5 * (grown - decayed)
