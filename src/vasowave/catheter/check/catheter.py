"""Fluid-filled catheters: a damped spring that lets some harmonics through too large, too small, and too late; filters.

Pressure at the transducer over pressure at the tip is 1 / (1 - (f/f_n)² + 2 i ζ f/f_n), with the natural frequency f_n
and the damping ratio ζ (Gardner, Anesthesiology 1981;54:227). The flow is measured by another instrument. At high
frequencies an artery's impedance tends to its characteristic one, a real constant, so that what the ratio of pressure
to flow does there as this response does, with a delay between the instruments, is suspected to be the catheter's.

Amplifiers and flow meters have filters, of first order 1 / (1 + i f/f_c) with the cut-off frequency f_c.
"""

from dataclasses import dataclass, replace
from typing import Any, Literal, NamedTuple

import numpy as np

from vasowave.base.cures import SetSetting
from vasowave.base.errors import InputError
from vasowave.base.findings import Finding, look_kind, note_kind
from vasowave.catheter.signals.noise_spectrum import ROLLS_OFF
from vasowave.pulse.cycle.cycle import Recording
from vasowave.pulse.cycle.harmonics import harmonic_errors
from vasowave.pulse.cycle.response import second_order
from vasowave.pulse.cycle.waveform import advance


@dataclass(frozen=True)
class CatheterRules:
    """What counts as the response of a catheter, and how much of it is taken out.

    Attributes
    ----------
    first_harmonic : int
        Below this harmonic reflections rule the impedance.
    min_harmonics : int
        Harmonics needed: a constant, a delay and a response have four unknowns, each harmonic tells two.
    max_misfit_ratio : float
        A response is suspected if it leaves less than this fraction of the misfit of a constant with a delay.
    max_damping : float
        It rings below this damping ratio.
    max_frequency_share : float
        Its natural frequency lies below this fraction of the highest frequency seen, so that both sides of the peak
        are.
    min_modulus_share : float
        Harmonics below this fraction of the first are too much at the mercy of errors.
    max_delay : float
        Largest delay between pressure and flow that is looked for, s.
    max_gain : float
        No harmonic is raised or lowered by more than this factor.
    """

    first_harmonic: int = 3
    min_harmonics: int = 6
    max_misfit_ratio: float = 0.25
    max_damping: float = 0.5
    max_frequency_share: float = 0.7
    min_modulus_share: float = 0.005
    max_delay: float = 0.008
    max_gain: float = 20.0


RULES = CatheterRules()


_RINGING_TEXT = (
    "the pressure looks as if its catheter rang at about {frequency:.0f} Hz (damping {damping:.2g}); if so, "
)
_FLUSH_QUESTION = (
    ". Was it flushed and free of bubbles? `catheter: [natural frequency, damping]` of a flush test corrects it"
)
_FLUSH_REMEDY = (
    "Give natural frequency and damping of a flush test; where there is none, allow for inertia and lag of the "
    "pressure as known errors."
)
_FLUSH = (
    SetSetting("Give the catheter", "catheter"),
    SetSetting("Allow for inertia", "pressure_inertia_sd"),
    SetSetting("Allow for a lag", "pressure_lag_sd"),
)
RINGS = look_kind(
    "recording.catheter-rings",
    f"{_RINGING_TEXT}the pulse pressure is {{true_pulse:.3g}} mmHg, not {{pulse:.3g}}{_FLUSH_QUESTION}",
    _FLUSH_REMEDY,
    *_FLUSH,
)
RINGS_BEYOND_REPAIR = look_kind(
    "recording.catheter-rings-beyond-repair",
    f"{_RINGING_TEXT}what it lost cannot be recovered{_FLUSH_QUESTION}",
    _FLUSH_REMEDY,
    *_FLUSH,
)
CORRECTED = note_kind(
    "recording.catheter-corrected",
    "the {signal} was corrected for a response of second order, {frequency:.3g} Hz and damping {damping:.2g}, up to "
    "harmonic {last}",
)
FILTER_CORRECTED = note_kind(
    "recording.filter-corrected",
    "the {signal} was corrected for a filter of first order at {cutoff:.3g} Hz, up to harmonic {last}",
)


DELAY_CORRECTED = note_kind(
    "recording.delay-corrected", "the {signal} was made {delay:.3g} ms earlier, by its given delay"
)


class Catheter(NamedTuple):
    """Natural frequency, Hz, and damping ratio of a catheter with its transducer."""

    natural_frequency: float
    damping: float

    def response(self, frequency: np.ndarray) -> np.ndarray:
        """Return recorded over true pressure at frequencies in Hz, complex."""
        time = 1.0 / (2 * np.pi * self.natural_frequency)
        return second_order(2 * self.damping * time, time**2, frequency)


class LowPass(NamedTuple):
    """Cut-off frequency, Hz, of a filter of first order, where it lets 0.71 of an amplitude through."""

    cutoff: float

    def response(self, frequency: np.ndarray) -> np.ndarray:
        """Return recorded over true signal at frequencies in Hz, complex."""
        return second_order(1.0 / (2 * np.pi * self.cutoff), 0.0, frequency)


def suspect_catheter(recording: Recording) -> Catheter | None:
    """Return natural frequency and damping if the cycle looks as if its catheter rang, None if not.

    A constant impedance with a delay, and that times a catheter's response, are fitted to pressure over flow from
    harmonic 3 to the last strong one. None also where too few harmonics are strong. What it returns is a suspicion:
    strong reflections and a slow flow probe can look alike; a flush test cannot be replaced. A damped catheter is not
    recognized: it looks like the reflections of an artery.
    """
    last = min(_last_strong(recording, signal) for signal in ("pressure", "flow"))
    if last - RULES.first_harmonic + 1 < RULES.min_harmonics:
        return None
    harmonics = np.arange(RULES.first_harmonic, last + 1)
    frequency = harmonics / recording.period
    pressure, flow = (np.fft.rfft(values)[harmonics] / len(values) for values in (recording.pressure, recording.flow))
    natural, damping = (
        grid.ravel()
        for grid in np.meshgrid(np.geomspace(0.5 * frequency[0], 1.2 * frequency[-1], 60), np.geomspace(0.05, 2.0, 30))
    )
    responses = Catheter(natural[:, None], damping[:, None]).response(frequency)  # type: ignore[arg-type]
    misfits = _misfit(pressure / flow, frequency, np.vstack([np.ones(len(frequency)), responses]))
    best = int(np.argmin(misfits[1:]))
    catheter = Catheter(float(natural[best]), float(damping[best]))
    inside = catheter.natural_frequency < RULES.max_frequency_share * frequency[-1]
    explains = misfits[1 + best] < RULES.max_misfit_ratio * misfits[0]
    return catheter if inside and explains and catheter.damping < RULES.max_damping else None


def ringing(catheter: Catheter, recording: Recording) -> Finding:
    """Return the finding that a catheter is suspected, with what it would mean for the pulse pressure."""
    parameters = {"frequency": catheter.natural_frequency, "damping": catheter.damping}
    try:
        true = float(np.ptp(correct_catheter(recording, catheter).pressure))
    except InputError:
        return RINGS_BEYOND_REPAIR(**parameters)
    return RINGS(**parameters, true_pulse=true, pulse=float(np.ptp(recording.pressure)))


def _last_strong(recording: Recording, signal: str) -> int:
    """Return the last harmonic that is as large as the model of a constant impedance may be asked to explain."""
    errors = harmonic_errors(recording, signal)
    strong = np.flatnonzero(errors.modulus[: errors.with_signal + 1] >= RULES.min_modulus_share * errors.modulus[1])
    return int(strong[-1]) if len(strong) else 0


def _misfit(impedance: np.ndarray, frequency: np.ndarray, responses: np.ndarray) -> np.ndarray:
    """Return the mean square of what a constant with the best delay leaves of log impedance over each response."""
    ratios = impedance / responses
    delays = np.linspace(-RULES.max_delay, RULES.max_delay, 65)
    turns = np.exp(2j * np.pi * delays[:, None] * frequency)
    angles = np.angle(ratios[:, None, :] * turns)
    return np.var(np.log(np.abs(ratios)), axis=1) + np.mean(angles**2, axis=2).min(axis=1)


def correct_catheter(
    recording: Recording, catheter: Catheter | LowPass, signal: Literal["pressure", "flow"] = "pressure"
) -> Recording:
    """Return the recording with a catheter's or a filter's response removed from the harmonics that carry signal.

    Parameters
    ----------
    recording : Recording
    catheter : Catheter or LowPass
        By a flush test, or as suspected; of an amplifier as its maker says. Nothing is corrected unless it is asked
        for; of a filter nothing is that it lets less than a twentieth through of.
    signal : {"pressure", "flow"}

    Raises
    ------
    InputError
        A frequency or damping that is not positive, or a response that would change a harmonic twentyfold.
    """
    if min(catheter) <= 0:
        quantity = "cut-off frequency" if isinstance(catheter, LowPass) else "natural frequency and damping"
        raise InputError(
            f"{recording.source}: {quantity} must be positive, got {', '.join(f'{x:g}' for x in catheter)}"
        )
    last = harmonic_errors(recording, signal).with_signal
    if isinstance(catheter, LowPass):
        last = min(last, int(catheter.cutoff * recording.period * np.sqrt(RULES.max_gain**2 - 1)))
    response = catheter.response(np.arange(last + 1) / recording.period)
    if np.abs(response).max() > RULES.max_gain or np.abs(response).min() < 1.0 / RULES.max_gain:
        raise InputError(
            f"{recording.source}: {catheter} lets harmonics up to {last} through {np.abs(response).min():.2g} to "
            f"{np.abs(response).max():.2g} times; what is lost cannot be recovered. Average fewer harmonics"
        )
    values, error = getattr(recording, signal), getattr(recording, f"{signal}_error")
    spectrum = np.fft.rfft(values)
    spectrum[: last + 1] /= response
    if isinstance(catheter, LowPass):
        note = FILTER_CORRECTED(signal=signal, cutoff=catheter.cutoff, last=last)
    else:
        note = CORRECTED(signal=signal, frequency=catheter.natural_frequency, damping=catheter.damping, last=last)
    changed: dict[str, Any] = {signal: np.fft.irfft(spectrum, len(values))}
    if error is not None:
        changed[f"{signal}_error"] = np.append(error[: last + 1] / np.abs(response), error[last + 1 :])
    notes = [
        finding
        for finding in recording.notes
        if (finding.code, *dict(finding.values).values())[:2] != (ROLLS_OFF.code, signal)
    ]
    return replace(recording, notes=(*notes, note), **changed)


def without_delays(recording: Recording, pressure: float = 0.0, flow: float = 0.0) -> Recording:
    """Return the recording with each signal as much earlier as it was recorded too late, s; negative: later.

    Raises
    ------
    InputError
        A delay of half a cycle or more.
    """
    for signal, delay in (("pressure", pressure), ("flow", flow)):
        if not abs(delay) < 0.5 * recording.period:
            raise InputError(
                f"{recording.source}: a {signal} delay of {delay:g} s is half a cycle or more; give it in s"
            )
        if delay:
            moved: dict[str, Any] = {signal: advance(getattr(recording, signal), delay / recording.period)}
            note = DELAY_CORRECTED(signal=signal, delay=1e3 * delay)
            recording = replace(recording, notes=(*recording.notes, note), **moved)
    return recording
