"""Hum of the mains in a signal: a line of one frequency that keeps its phase, which beats do not."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from vasowave.base.cures import SetSetting
from vasowave.base.findings import Finding, look_kind


@dataclass(frozen=True)
class HumRules:
    """What counts as hum.

    Attributes
    ----------
    mains : tuple of float
        Frequencies of the mains, Hz; hum is looked for at their first two multiples, too.
    half_width : float
        Hz around them.
    stands_out : float
        A line is this many times as strong as what is around it.
    around : float
        Hz on both sides, with which a line is compared.
    alarm_share : float
        From this share of the signal's range on hum asks for a look.
    """

    mains: tuple[float, ...] = (50.0, 60.0)
    half_width: float = 0.4
    stands_out: float = 12.0
    around: float = 4.0
    alarm_share: float = 0.04


RULES = HumRules()

HUM = look_kind(
    "recording.hum",
    "the {what} hums at {frequency:.0f} Hz, {amplitude:.2g} {unit} up and down, as of the mains; beats were found "
    "without it, and it fades in the average of many",
    "Ground the amplifier; average more beats.",
    SetSetting("Average 40 beats", "averaging.beats", "40"),
)


class Hum(NamedTuple):
    """The hum of a signal: its course, shape (sample,), amplitude of its strongest line, frequency of that, Hz."""

    course: np.ndarray
    amplitude: float
    frequency: float


def hum_of(values: np.ndarray, sampling_rate: float, rules: HumRules = RULES) -> Hum:
    """Return the hum of a signal: lines at the mains' frequencies that stand out from what is around them."""
    count = len(values)
    window = np.hanning(count)
    spectrum = np.fft.rfft((values - values.mean()) * window) * 2.0 / window.sum()
    resolution = sampling_rate / count
    amplitude = np.abs(spectrum)
    course, strongest, strongest_frequency = np.zeros(count), 0.0, 0.0
    time = np.arange(count) / sampling_rate
    for line in sorted({multiple * mains for mains in rules.mains for multiple in (1, 2, 3)}):
        if line + rules.around > 0.45 * sampling_rate:
            continue
        first, last = (round((line + side * rules.half_width) / resolution) for side in (-1, 1))
        peak = first + int(np.argmax(amplitude[first : last + 1]))
        reach, margin = round(rules.around / resolution), 3 + round(rules.half_width / resolution)
        surroundings = np.concatenate(
            [amplitude[peak - reach : peak - margin], amplitude[peak + margin : peak + reach]]
        )
        if not len(surroundings) or amplitude[peak] < rules.stands_out * np.quantile(surroundings, 0.9):
            continue
        below, above = amplitude[peak - 1], amplitude[peak + 1]
        frequency = (peak + 0.5 * (above - below) / max(2 * amplitude[peak] - below - above, 1e-300)) * resolution
        turn = np.exp(-2j * np.pi * frequency * time)
        phasor = 2.0 * np.sum((values - values.mean()) * window * turn) / window.sum()
        course += (phasor * turn.conj()).real
        if abs(phasor) > strongest:
            strongest, strongest_frequency = float(abs(phasor)), frequency
    return Hum(course, strongest, strongest_frequency)


def hum_findings(
    pressure: np.ndarray, flow: np.ndarray, sampling_rate: float, rules: HumRules = RULES
) -> list[Finding]:  # fmt: skip
    """Return a finding for each signal, mmHg and ml/s, whose hum is a large part of its range."""
    findings = []
    for signal, unit, values in (("pressure", "mmHg", pressure), ("flow", "ml/s", flow)):
        hum = hum_of(values, sampling_rate, rules)
        if hum.amplitude > rules.alarm_share * float(np.ptp(values - hum.course)):
            findings.append(HUM(what=signal, frequency=hum.frequency, amplitude=hum.amplitude, unit=unit))
    return findings
