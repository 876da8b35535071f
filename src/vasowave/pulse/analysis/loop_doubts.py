"""What is odd about steady loops of pressure and volume: sign, size, zero and time of the volume, and the pressure."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from vasowave.base.cures import SetCells
from vasowave.base.findings import Finding, look_kind, note_kind
from vasowave.pulse.analysis.family_lines import IntervalEstimate
from vasowave.pulse.analysis.loops import PressureVolumeLoop
from vasowave.pulse.analysis.volume_lag import volume_lag


@dataclass(frozen=True)
class LoopDoubtRules:
    """When steady loops are looked at."""

    human_stroke: float = 70.0  # ml at 70 beats/min
    stroke_exponent: float = -4.15  # of the stroke volume over the heart rate: 0.02 ml at 500 beats/min, as mice have
    max_stroke_factor: float = 50.0  # that a stroke volume may be larger or smaller
    filled_at_rise: float = 0.7  # of the stroke volume, at least, in the ventricle where the pressure rises steepest
    filled_at_fall: float = 0.3  # at most, where it falls steepest
    max_filled_pressure: float = 50.0  # mmHg at the end of diastole, which failing hearts do not pass
    max_pressure: float = 350.0  # mmHg


RULES = LoopDoubtRules()

TURNED = look_kind(
    "loops.turn-backward",
    "{source}: the loops turn clockwise: the ventricle would take work from the blood",
    "Look whether the volume's sign is right, and whether it comes at the time of the pressure.",
)
UNLIKELY = look_kind(
    "loops.unlikely-stroke",
    "{source}: a stroke volume of {stroke:.3g} ml at {rate:.0f} beats/min; others eject about {usual:.2g} ml",
    "Look at the volume's unit and at its calibration.",
)
NOT_ABSOLUTE = look_kind(
    "loops.volume-below-zero",
    "{source}: the volume falls to {lowest:.3g} ml: its zero is not the ventricle's, so there is no ejection fraction, "
    "and EDV, ESV, V_0 and V_w are counted from elsewhere",
    "Calibrate the volume: its offset, and the parallel volume.",
)
UNLIKELY_PRESSURE = look_kind(
    "loops.unlikely-pressure",
    "{source}: a pressure of {filled:.3g} mmHg at the end of diastole and of {peak:.3g} mmHg at most is that of no "
    "ventricle",
    "Look at the pressure's unit and zero, and whether pressure and volume are exchanged.",
)
NOT_IN_STEP = look_kind(
    "loops.not-in-step",
    "{source}: where the pressure rises and falls most steeply the ventricle is filled to {rising:.0f} and "
    "{falling:.0f} % of its stroke, and should be nearly full and nearly empty: E_es and work may be far off",
    "Look whether the volume comes later or earlier than the pressure.",
)
LATE_VOLUME = look_kind(
    "loops.volume-late",
    "{source}: the volume comes about {lag:.2g} ms {late} than the pressure ({percent:.2g} % of a beat): ejection "
    "begins {ejection:+.2g} ms after the steepest rise, filling {filling:+.2g} ms after the pressure is down. 3 % of "
    "a beat move E_es by 5 % and the work by up to 9 %, 9 % by 16 and 50 %",
    "Find out the delays of both instruments and give their difference; this estimate is good to 1 % of a beat in "
    "most hearts, to 5 % in all that were tried.",
    SetCells("Give the delay", (("volume delay [s]", "{seconds:.4f}"),)),
)
NO_RELAXATION = note_kind(
    "loops.no-relaxation",
    "{source}: only {weiss} (Weiss) and {glantz} (Glantz) of {beats} steady beats have a time constant of relaxation: "
    "in others the fall of the pressure is too short, reaches zero, or is no exponential",
)


def doubts_of_loops(
    estimates: Mapping[str, IntervalEstimate], loops: Sequence[PressureVolumeLoop], source: str, volume_delay: float
) -> list[Finding]:
    """Return what is odd about the steady beats, whose volume was made earlier by a delay, s, and their numbers."""
    stroke, rate, findings = estimates["SV"].value, estimates["HR"].value, list[Finding]()
    usual = RULES.human_stroke * (rate / 70.0) ** RULES.stroke_exponent
    if not 1 / RULES.max_stroke_factor < stroke / usual < RULES.max_stroke_factor:
        findings.append(UNLIKELY(source=source, stroke=stroke, rate=rate, usual=usual))
    filled_pressure, peak = estimates["EDP"].value, max(float(loop.pressure.max()) for loop in loops)
    if filled_pressure > RULES.max_filled_pressure or peak > RULES.max_pressure:
        findings.append(UNLIKELY_PRESSURE(source=source, filled=filled_pressure, peak=peak))
    lowest = min(float(loop.volume.min()) for loop in loops)
    if not lowest > 0:
        findings.append(NOT_ABSOLUTE(source=source, lowest=lowest))
    findings += _out_of_step(loops, source, volume_delay)
    weiss, glantz = estimates["tau_weiss"].beats, estimates["tau_glantz"].beats
    if min(weiss, glantz) < len(loops):
        findings.append(NO_RELAXATION(source=source, weiss=weiss, glantz=glantz, beats=len(loops)))
    if estimates["stroke_work"].value < 0:
        findings.append(TURNED(source=source))
    return findings


def _out_of_step(loops: Sequence[PressureVolumeLoop], source: str, volume_delay: float) -> list[Finding]:
    """Return by how much the volume is late or early, or that it is at another time than the pressure."""
    lag = volume_lag(loops)
    if lag.sure:
        beat = 1e3 * float(np.mean([loop.period for loop in loops]))
        ejection, filling = beat * lag.ejection, beat * lag.filling
        late = "later" if lag.mean > 0 else "earlier"
        return [LATE_VOLUME(source=source, lag=abs(beat * lag.mean), late=late, percent=abs(100 * lag.mean),
                            ejection=ejection, filling=filling,
                            seconds=volume_delay + 1e-3 * beat * lag.mean)]  # fmt: skip
    filled = [
        (loop.volume[[np.argmax(loop.slope), np.argmin(loop.slope)]] - loop.volume.min()) / np.ptp(loop.volume)
        for loop in loops
    ]
    rising, falling = (float(share) for share in np.median(filled, axis=0))
    if rising < RULES.filled_at_rise or falling > RULES.filled_at_fall:
        return [NOT_IN_STEP(source=source, rising=100 * rising, falling=100 * falling)]
    return []
