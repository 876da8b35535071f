"""Nominal parameters: what the recording and the network say before any fit (section 2.5, eqs. 8 to 13)."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from vasowave.base.errors import InputError
from vasowave.base.findings import Finding, look_kind, note_kind
from vasowave.pulse.cycle.cycle import Recording
from vasowave.pulse.model.blood import Blood
from vasowave.pulse.model.outlets import RESISTANCE_RATIO, Bed, Site, Windkessel
from vasowave.pulse.network.network import Network

NO_ARTERY = look_kind(
    "nominal.no-artery",
    "The nominal stiffness {beta:.3g} mmHg is not that of an artery ({low:g} to {high:g} mmHg): it grows with the "
    "fourth power of the root's radius; are the radii in cm and the flow in ml/s, and do network and recording belong "
    "to the same animal?",
    "Correct the unit of radii or flow, or the pairing of network and recording.",
)
NEVER_STOPS = note_kind(
    "nominal.flow-never-stops",
    "The flow never falls below {percent:.0f} % of its peak: nominal values count from its lowest value, and are where "
    "the search starts, no more.",
)
NO_UPSTROKE = look_kind(
    "nominal.no-upstroke",
    "{source}: pressure does not rise with flow during ejection (slope {slope:.3g} mmHg s/ml): the search starts from "
    "the impedance of the higher harmonics.",
    "Look whether pressure and flow are aligned in time.",
)
NO_DECAY = look_kind(
    "nominal.no-decay",
    "{source}: no pressure above the one behind the beds decays after ejection: the search starts from the time in "
    "which the volume of a pulse makes its pressure.",
    "Look whether pressure and flow are aligned in time, and at the wedge pressure.",
)
_HIGHER = slice(3, 9)  # harmonics whose impedance is about the characteristic one
_STIFFNESSES = (2.0, 2000.0)  # mmHg, between which every artery's β lies: the paper's mice have 10 to 200
_LEAST = 0.2  # share of β + p that a nominal β keeps
_ONSET = 0.05  # ejection has begun when the flow passes this share of its peak
_DECAY = 0.9  # share of the fall from the end of ejection that is fitted: its end belongs to the next contraction
_UPSTROKE = 0.95  # the up-slope method ends at this share of the peak flow


@dataclass(frozen=True, eq=False)
class Nominal:
    """Parameters estimated directly from one recording and one network.

    Attributes
    ----------
    characteristic_impedance : float
        Z_c, mmHg s/ml, slope of p against q during the flow's upstroke (eq. 8).
    beta : float
        β0, mmHg (eq. 9, at the pressure of the network's image).
    total_resistance : float
        R_T0 = (mean pressure - wedge pressure)/mean flow, mmHg s/ml.
    time_constant : float
        τ0 of the diastolic pressure decay, s (eq. 12).
    outlets : Windkessel or other Bed
        Those of every terminal (eqs. 11, 13).
    outlet_pressure : float
        Mean pressure behind them, mmHg: the recording's wedge pressure.
    outlet_pulsation : array, shape (sample,), optional
        What it does about its mean over the cycle, mmHg.
    upstroke : tuple of array
        Flow (ml/s) and pressure (mmHg) of the samples behind Z_c.
    decay : tuple of array
        Time (s) and pressure (mmHg) of the samples behind τ0.
    findings : tuple of Finding
        What the recording does not show, so that the search starts from something rougher.

    Examples
    --------
    >>> import vasowave as vw
    >>> nominal = vw.estimate_nominal(vw.control_network(), vw.virtual_mouse())
    >>> nominal.wall(vw.LinearWall).beta == nominal.beta
    True
    """

    characteristic_impedance: float
    beta: float
    total_resistance: float
    time_constant: float
    outlets: Any
    outlet_pressure: float
    outlet_pulsation: np.ndarray | None
    upstroke: tuple[np.ndarray, np.ndarray]
    decay: tuple[np.ndarray, np.ndarray]
    findings: tuple[Finding, ...] = ()

    def wall(self, law: Any) -> Any:
        """Return a wall law (its class) at its nominal parameters: β0, or p1 = β0/π and γ = 2 (eq. 10)."""
        return law(*(parameter.nominal * parameter.scale(self.beta) for parameter in law.law().parameters))

    def __repr__(self) -> str:
        return (
            f"Nominal(Z_c {self.characteristic_impedance:.4g} mmHg s/ml, beta0 {self.beta:.4g} mmHg, "
            f"R_T0 {self.total_resistance:.4g} mmHg s/ml, tau0 {self.time_constant:.3g} s)"
        )


def estimate_nominal(
    network: Network, recording: Recording, blood: Blood | None = None, bed: type[Bed] = Windkessel
) -> Nominal:
    """Estimate wall stiffness and outlets from one recording (eqs. 8 to 13), roughly where it shows less.

    Raises
    ------
    InputError
        Pressure or flow of the recording does not change.

    Examples
    --------
    >>> import vasowave as vw
    >>> vw.estimate_nominal(vw.control_network(), vw.virtual_mouse())
    Nominal(Z_c ... mmHg s/ml, beta0 ... mmHg, R_T0 ... mmHg s/ml, tau0 ... s)
    """
    blood = blood or Blood()
    flow, pressure = upstroke(recording)
    Z_c, findings = characteristic_impedance(flow, pressure), []
    if not Z_c > 0:
        findings.append(NO_UPSTROKE(source=recording.source, slope=Z_c))
        Z_c = _impedance_of_higher_harmonics(recording)
    time, falling = diastole(recording)
    try:
        tau = time_constant(time, falling - recording.wedge_pressure, recording.source)
    except InputError:
        findings.append(NO_DECAY(source=recording.source))
        tau = _filling_time(recording)
    R_T = recording.vascular_resistance
    beta = stiffness(Z_c, float(network.area[network.root]), blood, network.pressure)
    return Nominal(
        characteristic_impedance=Z_c,
        beta=beta,
        total_resistance=R_T,
        time_constant=tau,
        outlets=bed.of(network, Site(R_T, tau, beta, blood)),
        outlet_pressure=recording.wedge_pressure,
        outlet_pulsation=recording.wedge_pulsation,
        upstroke=(flow, pressure),
        decay=(time, falling),
        findings=tuple(findings),
    )


def _impedance_of_higher_harmonics(recording: Recording) -> float:
    """Median modulus of the input impedance at harmonics 3 to 8, mmHg s/ml."""
    count = max(len(recording.pressure), len(recording.flow))
    even = recording.resampled(count)
    P, Q = (np.abs(np.fft.rfft(values))[_HIGHER] for values in (even.pressure, even.flow))
    significant = Q > 1e-6 * np.abs(even.flow).max()
    if not (significant.any() and np.any(P > 0)):
        raise InputError(f"{recording.source}: pressure or flow hardly changes; give one cardiac cycle of both")
    return float(np.median(P[significant] / Q[significant]))


def _filling_time(recording: Recording) -> float:
    """R_T C, s, with the compliance that the volume above the mean flow fills to the pulse pressure."""
    flow = recording.flow
    volume = 0.5 * recording.period * float(np.mean(np.abs(flow - flow.mean())))
    return recording.vascular_resistance * volume / recording.pulse_pressure


def oddities(nominal: Nominal, flow: np.ndarray) -> list[Finding]:
    """Return what the recording did not show, which nominal values no artery has, and whether a `flow` never stops."""
    low, high = _STIFFNESSES
    findings = [*nominal.findings]
    findings += [] if low <= nominal.beta <= high else [NO_ARTERY(beta=nominal.beta, low=low, high=high)]
    share = float(flow.min() / flow.max())
    return findings + [NEVER_STOPS(percent=100 * share)] * (share > _ONSET)


def upstroke(recording: Recording) -> tuple[np.ndarray, np.ndarray]:
    """Return flow and pressure from the onset of ejection to 95 % of peak flow.

    Ejection begins at 5 % of peak flow. In a vessel whose flow never falls that far, as in many arteries away from the
    heart, it begins where the flow has risen by 5 % of the way from its lowest value to its peak.
    """
    count = max(len(recording.pressure), len(recording.flow))
    even = recording.resampled(count)
    q, p = even.flow, even.pressure
    peak = int(np.argmax(q))
    q, p = np.roll(q, -peak - 1), np.roll(p, -peak - 1)  # the peak is now the last sample
    start = int(np.flatnonzero(q <= _onset(q))[-1])
    stop = start + int(np.argmax(q[start:] >= _UPSTROKE * q[-1])) + 1
    return q[start:stop], p[start:stop]


def _onset(flow: np.ndarray) -> float:
    """Flow at which ejection begins and ends, ml/s."""
    low, high = float(flow.min()), float(flow.max())
    return _ONSET * high if low < _ONSET * high else low + _ONSET * (high - low)


def characteristic_impedance(flow: np.ndarray, pressure: np.ndarray) -> float:
    """Characteristic impedance Z_c = ρ c0/A0, mmHg s/ml (eq. 8): the least-squares slope of pressure against flow."""
    return float(np.polyfit(flow, pressure, 1)[0])


def stiffness(Z_c: float, area: float, blood: Blood, pressure: float = 0.0) -> float:
    """Stiffness β = 2 (A Z_c)²/ρ - p, mmHg, of a vessel with area A (cm²) at `pressure` p (mmHg); eq. 9 where p = 0.

    The wave speed of the linear law is √((β + p)/(2ρ)). Where the pressure leaves next to nothing, a fifth of the first
    term is returned: it is only where a fit begins.
    """
    together = 2.0 * (area * Z_c) ** 2 / blood.inertia
    return max(together - pressure, _LEAST * together)


def diastole(recording: Recording) -> tuple[np.ndarray, np.ndarray]:
    """Return time (s) and pressure (mmHg) of the decay after ejection.

    Ejection ends where the flow first falls below that at which it begins (`upstroke`). Of the time from there to the
    lowest pressure the first 90 % are returned.
    """
    count = max(len(recording.pressure), len(recording.flow))
    even = recording.resampled(count)
    peak = int(np.argmax(even.flow))
    q, p = np.roll(even.flow, -peak), np.roll(even.pressure, -peak)
    end_of_ejection = int(np.argmax(q <= _onset(q)))
    stop = end_of_ejection + round(_DECAY * int(np.argmin(p[end_of_ejection:]))) + 1
    time = (np.arange(count) + peak) * (recording.period / count)
    return time[end_of_ejection:stop], p[end_of_ejection:stop]


def time_constant(time: np.ndarray, pressure: np.ndarray, source: str = "recording") -> float:
    """Time constant τ, s, of p(t) = p(t_d) exp(-(t - t_d)/τ) (eq. 12), by a log-linear least-squares fit.

    `pressure` is that above the pressure behind the beds, to which it falls, mmHg.
    """
    if len(time) < 4 or pressure.min() <= 0:
        raise InputError(
            f"{source}: no diastolic decay of positive pressure after ejection; check the cycle and the wedge pressure"
        )
    slope = float(np.polyfit(time, np.log(pressure), 1)[0])
    if slope >= 0:
        raise InputError(f"{source}: pressure does not fall after ejection; check that pressure and flow are aligned")
    return -1.0 / slope


def windkessels(network: Network, R_T: float, tau: float, a: float = RESISTANCE_RATIO) -> Windkessel:
    """Windkessels of all terminals: R_T,j = R_T / flow fraction (eq. 11), R1 = a R_T,j, C = τ/R_T,j (eq. 13)."""
    return Windkessel.nominal(R_T / network.flow_fraction[network.terminals], tau, a)
