"""Whether a ventricle keeps up with its load: its elastance from one beat, beside that of the artery.

The pressure in the ventricle is ``E(t) (V - V0)``. The flow that leaves it says how V falls; the elastance rises and
falls as the normalized one of all hearts does (`model.ventricle.activation`), within priors of that shape. What is left
to find is the volume above V0 before ejection: the bigger it is, the less the pressure sags below what it would be
without ejection. E_es is the largest elastance, E_a the pressure at that time over the stroke volume.

The zero of the volume is nowhere measured, so that this leans on the shape: the interval allows for it. A gain of the
flow probe moves both elastances alike, and their ratio not at all.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from scipy.optimize import curve_fit, least_squares

from vasowave.base import units
from vasowave.base.errors import InputError
from vasowave.base.findings import Finding, look_kind, note_kind
from vasowave.pulse.cycle.cycle import Recording
from vasowave.pulse.cycle.ventricular import VentricularPressure
from vasowave.pulse.model.ventricle import FALL, RISE, Ventricle, raised

UNLIKE = look_kind(
    "ventricle.unlike",
    "{source}: the elastance of no usual heart makes this pressure from this flow: it is off by {percent:.1f} % of the "
    "pulse, where others leave 1 %. E_es and E_es/E_a may be far off",
    "Look whether pressure of the ventricle and flow belong to the same animal, and at the flow's zero.",
)
OTHER_RATE = look_kind(
    "ventricle.other-rate",
    "{source}: the ventricle was recorded at {own:.0f} beats/min, the artery at {other:.0f}",
    "Use beats of the same heart rate: elastance changes with it.",
)
BELOW = look_kind(
    "ventricle.below-artery",
    "{source}: the ventricle reaches {own:.1f} mmHg, the artery {other:.1f} mmHg",
    "Correct the zero or the unit of one of the two: what ejects is not below what it ejects into.",
)
NOT_COUPLED = look_kind(
    "ventricle.not-coupled", "elastances of ventricle and artery are not known: {why}", "Correct its file."
)
NO_SINGLE_BEAT = note_kind("ventricle.no-single-beat", "{source}: no sine fits its isovolumic parts")


@dataclass(frozen=True)
class CouplingRules:
    """What is looked for in a ventricle's pressure, and the priors of its isovolumic wave.

    Attributes
    ----------
    max_harmonics : int
        Harmonics in which landmarks are looked for.
    max_rise_share : float
        Share of a cycle in which the pressure rises, at most.
    begin_slope_share : float
        Share of the steepest rise at which contraction begins.
    filling_pulse_share : float
        Share of the pulse above the end of diastole at which filling may begin.
    opening_flow_share : float
        Share of the peak flow at which ejection begins.
    closing_flow_share : float
        Share of the peak flow at which it ends.
    independent_samples : int
        Samples a cycle that are worth as much as all.
    sample_error : float
        Error of a sample, as a share of the pulse, at least.
    shift_sd : float
        SD, in periods, of where contraction begins.
    flow_delay_sd : float
        SD, in periods, of the flow's place in time.
    rise_sd : float
        SD of the logarithm of the exponent of the rise.
    fall_sd : float
        SD of the logarithm of the exponent of the fall.
    width_sd : float
        SD of the logarithm of the ratio of the times of the shape.
    pressure_sd : float
        SD of the logarithm of the pressure before contraction.
    shape_sd : float
        SD of the logarithm of E_es by elastances of other shapes.
    volume_starts : tuple of float
        Starts of the logarithm of what stays in the ventricle over what leaves it; its prior has SD 1 about 0.
    max_misfit_share : float
        Share of the pulse: a misfit that no elastance explains.
    meaningless_misfit_share : float
        Share of the pulse from which the two are not of one heart.
    max_rate_difference : float
        Relative difference of heart rates.
    derivative_step : float
        Step of derivatives.
    """

    max_harmonics: int = 40
    max_rise_share: float = 0.4
    begin_slope_share: float = 0.08
    filling_pulse_share: float = 0.12
    opening_flow_share: float = 0.05
    closing_flow_share: float = 0.02
    independent_samples: int = 80
    sample_error: float = 0.01
    shift_sd: float = 0.02
    flow_delay_sd: float = 0.01
    rise_sd: float = 0.2
    fall_sd: float = 0.3
    width_sd: float = 0.1
    pressure_sd: float = 0.3
    shape_sd: float = 0.5
    volume_starts: tuple[float, float, float] = (-1.5, 0.0, 1.0)
    max_misfit_share: float = 0.02
    meaningless_misfit_share: float = 0.1
    max_rate_difference: float = 0.15
    derivative_step: float = 1e-4


RULES = CouplingRules()

_UNKNOWN_SCALES = (0.3, 0.5, 0.3, 1.0, 0.1, 1.0, 1.0, 1.0, 1.0)  # of the nine unknowns of a fit


@dataclass(frozen=True, eq=False)
class Coupling:
    """Elastances of ventricle and artery.

    Attributes
    ----------
    elastance : float
        E_es, largest elastance of the ventricle, mmHg/ml.
    load : float
        E_a, pressure at that time over the stroke volume, mmHg/ml.
    error : float
        SD of the logarithm of E_es, and of the ratio.
    stroke_volume : float
        ml.
    filled : float
        Volume above V0 before ejection, ml.
    single_beat : float
        E_es/E_a by the single-beat method: a sine through the isovolumic parts of the pressure (Brimioulle et al. 2003,
        doi 10.1152/ajpheart.01000.2002); NaN where none fits.
    time : array, shape (sample,)
        s from where contraction begins, as far as the ventricle is fitted.
    measured, fitted, isovolumic : array, shape (sample,)
        Pressure, mmHg; isovolumic: what the ventricle would reach if nothing left it.
    volume : array, shape (sample,)
        Above V0, ml.
    period : float
        s.
    filling_pressure : float
        Before contraction, mmHg.
    findings : tuple of Finding

    Examples
    --------
    >>> import numpy as np
    >>> import vasowave as vw
    >>> t = np.arange(256) / 256
    >>> flow = np.where((t > 0.1) & (t < 0.4), np.sin(np.pi * (t - 0.1) / 0.3), 0.0)
    >>> artery = vw.Recording(15 + 4 * np.sin(2 * np.pi * (t - 0.12)), flow, period=0.11)
    >>> inside = vw.VentricularPressure(3 + 27 * np.sin(np.pi * np.minimum(t / 0.5, 1)) ** 2, period=0.11)
    >>> vw.coupling(artery, inside).stroke_volume  # ml
    0.021...
    """

    elastance: float
    load: float
    error: float
    stroke_volume: float
    filled: float
    single_beat: float
    time: np.ndarray
    measured: np.ndarray
    fitted: np.ndarray
    isovolumic: np.ndarray
    volume: np.ndarray
    period: float
    filling_pressure: float
    findings: tuple[Finding, ...] = ()

    @property
    def ratio(self) -> float:
        """E_es/E_a: about 1.5 to 2 in a healthy right ventricle, below about 0.8 in one that fails."""
        return self.elastance / self.load

    @property
    def stroke_work(self) -> float:
        """Area of the loop of pressure and volume, mJ, with filling at `filling_pressure`."""
        ejected = np.trapezoid(self.measured, self.filled - self.volume)
        return float(units.MILLIWATT * (ejected - self.filling_pressure * self.stroke_volume))

    @cached_property
    def ventricle(self) -> Ventricle:
        """The ventricle, to drive a network with."""
        count = 512
        time = np.arange(count) * self.period / count
        pressure = np.interp(time, self.time, self.isovolumic, right=self.filling_pressure)
        pressure = np.maximum(pressure, self.filling_pressure)
        pressure[0] = self.filling_pressure  # it is filled before it contracts
        return Ventricle(pressure / self.filled, self.period, self.filling_pressure)

    def __repr__(self) -> str:
        return f"Coupling(E_es {self.elastance:.4g} mmHg/ml, E_a {self.load:.4g} mmHg/ml, E_es/E_a {self.ratio:.2f})"


@dataclass(frozen=True, eq=False)
class _Beat:
    """What is compared: the systole of the ventricle, and what has left it at any time."""

    time: np.ndarray  # s from the beginning of contraction
    pressure: np.ndarray
    smooth: np.ndarray
    steepest: tuple[int, int]  # samples of the steepest rise and fall
    shift: float  # s from the time of the flow to that of the ventricle
    ejection: np.ndarray  # times of the flow, s
    ejected: np.ndarray  # volume that has left at these times, ml
    resting: float  # mmHg before contraction
    weight: float  # of a sample, 1/mmHg

    @property
    def stroke(self) -> float:
        return float(self.ejected[-1])

    def gone(self, late: float) -> np.ndarray:
        """Return what has left the ventricle at the times of its pressure, if the flow comes `late` s later."""
        return np.interp(self.time, self.ejection + self.shift + late, self.ejected, left=0.0)


def coupled(recording: Recording, ventricle: VentricularPressure | None) -> tuple[Coupling | None, tuple[Finding, ...]]:
    """Return what `coupling` finds, if anything, and what is to be said of it."""
    if ventricle is None:
        return None, ()
    try:
        result = coupling(recording, ventricle)
    except InputError as error:
        return None, (NOT_COUPLED(why=str(error)),)
    return result, result.findings


def coupling(recording: Recording, ventricle: VentricularPressure) -> Coupling:
    """Return elastances of ventricle and artery from the ventricle's pressure and the flow into the artery.

    The two need not be recorded together: the valve opens where the ventricle's pressure passes that of the artery at
    the foot of its flow.

    Raises
    ------
    InputError
        A pressure without a contraction, or that does not rise to the artery's; a flow without ejection.

    Examples
    --------
    >>> import vasowave as vw
    >>> network, mouse = vw.control_network(), vw.virtual_mouse()
    >>> model = vw.Model(network, vw.LinearWall(60.0), vw.estimate_nominal(network, mouse).outlets)
    >>> heart = vw.Ventricle.from_peak(1400.0, rest=100.0, period=0.11, filling_pressure=4.0)
    >>> waves = vw.simulate(model, heart)
    >>> at_root = waves.sel(vessel=network.name[network.root], station="inlet")
    >>> recording = vw.Recording(at_root.pressure.values, at_root.flow.values, 0.11)
    >>> found = vw.coupling(recording, vw.VentricularPressure(waves.ventricular_pressure.values, 0.11))
    >>> bool(abs(np.log(found.elastance / 1400)) < 2 * found.error)
    True
    """
    beat = _beat(recording, ventricle)
    fit = min(
        (_fit(beat, ventricle.period, start) for start in RULES.volume_starts), key=lambda candidate: candidate.cost
    )
    waves = _parts(fit.x, beat, ventricle.period)
    misfit = float(np.sqrt(np.mean((waves.fitted - beat.pressure) ** 2))) / float(np.ptp(beat.smooth))
    covariance = np.linalg.pinv(fit.jac.T @ fit.jac) * max(misfit / RULES.sample_error, 1.0) ** 2
    neighbors = [
        fit.x + step for direction in RULES.derivative_step * np.eye(len(fit.x)) for step in (-direction, direction)
    ]
    ends = [_log_ratio(x, beat, ventricle.period) for x in neighbors]
    slope = np.diff(np.reshape(ends, (-1, 2)), axis=1).ravel() / (2 * RULES.derivative_step)
    load = waves.end_systolic / beat.stroke
    peak = _isovolumic_peak(beat)
    if misfit > RULES.meaningless_misfit_share:
        raise InputError(
            f"{ventricle.source}: no elastance makes this pressure from this flow (off by {100 * misfit:.0f} % of its "
            "pulse); is it one beat of a ventricle of this animal, and its time in s?"
        )
    findings = [] if misfit <= RULES.max_misfit_share else [UNLIKE(source=ventricle.source, percent=100 * misfit)]
    findings += [] if np.isfinite(peak) else [NO_SINGLE_BEAT(source=ventricle.source)]
    return Coupling(
        elastance=waves.peak / waves.filled,
        load=load,
        error=float(np.hypot(np.sqrt(slope @ covariance @ slope), RULES.shape_sd)),
        stroke_volume=beat.stroke,
        filled=waves.filled,
        single_beat=peak / waves.end_systolic - 1.0,
        time=beat.time,
        measured=beat.pressure,
        fitted=waves.fitted,
        isovolumic=waves.isovolumic,
        volume=waves.volume,
        period=ventricle.period,
        filling_pressure=waves.resting,
        findings=(*findings, *_doubts(recording, ventricle, beat)),
    )


@dataclass(frozen=True, eq=False)
class _Parts:
    """What parameters make of a beat; pressures mmHg, volumes ml."""

    fitted: np.ndarray
    isovolumic: np.ndarray
    volume: np.ndarray
    peak: float
    filled: float
    resting: float
    end_systolic: float


def _parts(x: np.ndarray, beat: _Beat, period: float) -> _Parts:
    """Return what nine parameters make of a beat.

    Logarithms of the isovolumic peak, of what stays over what leaves, and of the resting pressure; the beginning of
    contraction; the logarithm of the time of the peak; three of the shape; how late the flow is. Beginning, shape and
    lateness are in units of their priors' SD.
    """
    peak, stays, resting = np.exp(np.clip(x[:3], -12.0, 12.0))
    filled = beat.stroke * (1.0 + stays)
    shape = (RISE * np.exp(RULES.rise_sd * x[5]), FALL * np.exp(RULES.fall_sd * x[6]), np.exp(RULES.width_sd * x[7]))
    risen = raised((beat.time - x[3] * RULES.shift_sd * period) / np.exp(x[4]), *shape)
    isovolumic = resting + (peak - resting) * risen
    volume = filled - beat.gone(x[8] * RULES.flow_delay_sd * period)
    fitted = isovolumic * volume / filled
    at_peak = volume[int(np.argmax(isovolumic))]
    return _Parts(
        fitted, isovolumic, volume, float(peak), float(filled), float(resting), float(peak * at_peak / filled)
    )


def _fit(beat: _Beat, period: float, stays: float) -> Any:
    """Return SciPy's result: the parameters that make the pressure of a beat under the priors, from one start."""
    rises, falls = beat.steepest
    peak_at = max(0.5 * (beat.time[rises] + beat.time[falls]), 0.05 * period)
    resting = np.log(beat.resting)
    start = np.array([np.log(1.6 * beat.smooth.max()), stays, resting, 0.0, np.log(peak_at), 0.0, 0.0, 0.0, 0.0])

    def residuals(x: np.ndarray) -> np.ndarray:
        misses = (_parts(x, beat, period).fitted - beat.pressure) * beat.weight
        return np.concatenate([misses, x[[1, 3, 5, 6, 7, 8]], [(x[2] - resting) / RULES.pressure_sd]])

    return least_squares(residuals, start, x_scale=_UNKNOWN_SCALES)


def _log_ratio(x: np.ndarray, beat: _Beat, period: float) -> float:
    """Return the logarithm of E_es/E_a: what leaves over what stays at the peak of the elastance."""
    waves = _parts(x, beat, period)
    return float(np.log(waves.peak / waves.filled * beat.stroke / waves.end_systolic))


def _beat(recording: Recording, ventricle: VentricularPressure) -> _Beat:
    """Return the systole of the ventricle with the flow out of it."""
    systole, ejection = _systole(ventricle), _ejection(recording)
    rising = systole.smooth[: int(np.argmax(systole.smooth)) + 1]
    if not rising[-1] >= max(ejection.pressure, 1e-9):
        raise InputError(
            f"{ventricle.source}: the ventricle reaches {rising[-1]:.1f} mmHg, less than the artery has when its flow "
            f"begins ({ejection.pressure:.1f} mmHg); correct the zero or the unit of one of the two"
        )
    count = len(ventricle.pressure)
    dt, share = ventricle.period / count, min(float(np.sqrt(RULES.independent_samples / count)), 1.0)
    return _Beat(
        time=np.arange(len(systole.smooth)) * dt,
        pressure=systole.pressure,
        smooth=systole.smooth,
        steepest=systole.steepest,
        shift=int(np.argmax(rising >= ejection.pressure)) * dt,
        ejection=ejection.time,
        ejected=ejection.ejected,
        resting=max(float(systole.smooth[0]), 0.5),
        weight=share / (RULES.sample_error * float(np.ptp(systole.smooth))),
    )


class _Systole(NamedTuple):
    pressure: np.ndarray  # mmHg, from where contraction begins to where filling may
    smooth: np.ndarray
    steepest: tuple[int, int]  # samples of the steepest rise and fall


class _Ejection(NamedTuple):
    time: np.ndarray  # s from the foot of the flow
    ejected: np.ndarray  # ml that have left until then
    pressure: float  # mmHg in the artery at the foot


def _systole(ventricle: VentricularPressure) -> _Systole:
    """Return the pressure of a ventricle from where contraction begins to where filling may."""
    smooth, count = _smoothed(ventricle.pressure), len(ventricle.pressure)
    rise = np.gradient(np.tile(smooth, 3))[count : 2 * count]
    steepest = int(np.argmax(rise))
    before = (steepest - np.arange(int(RULES.max_rise_share * count))) % count
    begins = max(RULES.begin_slope_share * rise[steepest], float(rise[before].min()) + 1e-12)
    slow = rise[before] < begins  # filling may raise it, too
    begin = steepest - int(np.argmax(slow))
    falls = int(np.argmin(rise[(steepest + np.arange(int(0.7 * count))) % count])) + steepest - begin
    rolled = np.roll(smooth, -begin)
    relaxed = rolled[falls:] <= rolled[0] + RULES.filling_pulse_share * (rolled.max() - rolled[0])
    if begin == steepest or not np.any(relaxed):
        raise InputError(f"{ventricle.source}: no contraction and relaxation are seen; is it one cycle of a ventricle?")
    last = falls + int(np.argmax(relaxed))
    pressure = np.roll(ventricle.pressure, -begin)
    return _Systole(pressure[: last + 1], rolled[: last + 1], (steepest - begin, falls))


def _ejection(recording: Recording) -> _Ejection:
    """Return what leaves the ventricle from the foot of the flow to its end."""
    count, dt = len(recording.flow), recording.period / len(recording.flow)
    peak, middle = int(np.argmax(recording.flow)), len(recording.flow) // 2
    flow = np.roll(recording.flow, middle - peak)
    foot = middle - int(np.argmax(flow[middle::-1] <= RULES.opening_flow_share * flow[middle]))
    end = middle + int(np.argmax(flow[middle:] <= RULES.closing_flow_share * flow[middle]))
    if foot == middle or end == middle:
        raise InputError(f"{recording.source}: the flow has no beginning and end of ejection; is its zero right?")
    ejected = np.concatenate([[0.0], np.cumsum(flow[foot:end])]) * dt
    foot_time = (foot + peak - middle) % count * dt
    pressure = float(np.interp(foot_time, recording.time, recording.pressure, period=recording.period))
    return _Ejection((np.arange(len(ejected)) - 0.5) * dt, ejected, pressure)


def _smoothed(pressure: np.ndarray) -> np.ndarray:
    spectrum = np.fft.rfft(pressure)
    spectrum[RULES.max_harmonics :] = 0
    return np.fft.irfft(spectrum, len(pressure))


def _isovolumic_peak(beat: _Beat) -> float:
    """Return the peak of a sine through contraction before ejection and relaxation after it, mmHg; NaN if none fits."""
    rises, falls = beat.steepest
    rows = np.concatenate([np.arange(rises + 1), np.arange(falls, len(beat.time))])
    time, pressure = beat.time[rows], beat.smooth[rows]

    def sine(t: np.ndarray, mean: float, size: float, rate: float, phase: float) -> np.ndarray:
        return np.asarray(mean + size * np.sin(rate * t + phase))

    pulse = float(np.ptp(beat.smooth))
    start = (pressure.min() + pulse, 1.2 * pulse, 1.2 * np.pi / float(time[-1]), -0.8)
    try:
        (mean, size, *_), _ = curve_fit(sine, time, pressure, start, maxfev=4000)
    except RuntimeError:
        return float("nan")
    peak = float(mean + abs(size))
    return peak if beat.smooth.max() < peak < 10 * beat.smooth.max() else float("nan")


def _doubts(recording: Recording, ventricle: VentricularPressure, beat: _Beat) -> list[Finding]:
    """Return in what the two recordings do not go together."""
    findings = []
    if abs(ventricle.period / recording.period - 1.0) > RULES.max_rate_difference:
        findings.append(OTHER_RATE(source=ventricle.source, own=60 / ventricle.period, other=recording.heart_rate))
    if beat.smooth.max() < recording.systolic_pressure - 0.1 * recording.pulse_pressure:
        findings.append(BELOW(source=ventricle.source, own=beat.smooth.max(), other=recording.systolic_pressure))
    return findings
