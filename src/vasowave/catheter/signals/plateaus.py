"""Stretches in which a signal stands still: a transducer open to air, or set to known pressures, or a wave cut off.

Peaks or troughs are cut off at one value where an amplifier or a converter was at the end of its range.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from vasowave.base.cures import STRETCH
from vasowave.base.findings import Finding, look_kind, note_kind
from vasowave.catheter.signals.raw import RawRecording


@dataclass(frozen=True)
class PlateauRules:
    """What counts as a plateau, as the atmosphere, and as a wave cut off.

    Attributes
    ----------
    min_seconds : float
        A plateau lasts at least this long, s: two beats of the slowest heart that is looked for.
    max_pulse_share : float
        In a plateau the pressure stays within this fraction of the recording's usual pulse.
    max_air_pressure : float
        A plateau nearer to zero than this, mmHg, is the atmosphere's: no pulmonary artery stands still there.
    max_zero_error : float
        A zero further off than this, mmHg, is warned about.
    max_flat_beats : float
        Beats; what stands still for longer, as in a flush, is no part of a wave.
    rest_share : float
        Share of the range: a flow that stands nearer to zero rests there.
    min_cut_share : float
        Share of all samples that stand at the largest value where a wave is cut off.
    min_cut_ratio : float
        So many times as many samples stand there as in the next step below; of a sine's peak 2.4 times.
    step_range_share : float
        Share of the range below the largest value in which the steps of a converter are looked for.
    min_step_share : float
        Share of the range that a step of a converter has at least.
    min_run_samples : int
        Samples one after the other at the top; fewer are those of a beat that was copied.
    """

    min_seconds: float = 0.4
    max_pulse_share: float = 0.15
    max_air_pressure: float = 5.0
    max_zero_error: float = 0.3
    max_flat_beats: float = 1.5
    rest_share: float = 0.02
    min_cut_share: float = 0.003
    min_cut_ratio: float = 4.0
    step_range_share: float = 0.05
    min_step_share: float = 1e-4
    min_run_samples: int = 3


RULES = PlateauRules()


_OPEN_TEXT = "the transducer was open to air from {start:.3g} to {end:.3g} s and read {level:+.2g} mmHg"
OPEN_TO_AIR = note_kind("recording.open-to-air", _OPEN_TEXT)
OFF_ZERO = look_kind(
    "recording.zero-off",
    f"{_OPEN_TEXT}: pressures are off by this zero offset and were not corrected",
    "Correct the zero of the pressure channel and export it again.",
)
ZERO_WITHIN = look_kind(
    "recording.zero-within",
    "the pressure stood at {level:+.2g} mmHg from {start:.3g} to {end:.3g} s, between beats: the transducer was open "
    "to air, or its signal was lost; the zero may be another one after that",
    "Compare the pressures before and after, and choose a stretch.",
    STRETCH,
)
CALIBRATION = note_kind(
    "recording.calibration-plateaus",
    "calibration plateaus, pressures that stand still: {levels}; compare them with what was applied",
)
SATURATED = look_kind(
    "recording.saturated",
    "{what}: {percent:.1f} % of the samples stand at its {end} value, {value:.4g} {unit}: {parts} are cut off there, "
    "by an amplifier or a converter at the end of its range",
    "Record it again with a wider range, or choose a stretch that is not cut off.",
    STRETCH,
)


class Plateau(NamedTuple):
    """A stretch without pulse: start and end, s, and the level, mmHg."""

    start: float
    end: float
    level: float


def find_plateaus(raw: RawRecording) -> tuple[Plateau, ...]:
    """Return the stretches of at least 0.4 s in which the pressure of a recording does not pulsate, in order."""
    recordings = (raw, *raw.beside)
    return tuple(
        sorted(
            _later(plateau, recording.origin)
            for recording in recordings
            for plateau in _still(recording.pressure, raw.sampling_rate)
        )
    )


def _later(plateau: Plateau, by: float) -> Plateau:
    return plateau._replace(start=plateau.start + by, end=plateau.end + by)


def _still(pressure: np.ndarray, rate: float) -> list[Plateau]:
    width = max(2, round(0.1 * rate))
    blocks = pressure[: len(pressure) // width * width].reshape(-1, width)
    ends = np.quantile(blocks, [0.1, 0.9], axis=1)
    two = max(2, int(np.ceil(0.24 * rate / width)))
    # A beat of the slowest heart fits into two or three blocks, so their common range is its pulse.
    low = np.lib.stride_tricks.sliding_window_view(ends[0], two).min(axis=1)
    high = np.lib.stride_tricks.sliding_window_view(ends[1], two).max(axis=1)
    still = high - low < RULES.max_pulse_share * np.quantile(high - low, 0.75)
    edges = np.flatnonzero(np.diff(np.concatenate([[0], still, [0]])))
    plateaus = []
    for first, last in zip(edges[::2], edges[1::2], strict=True):
        last += two - 1  # the last window reaches over these blocks
        if (last - first) * width >= RULES.min_seconds * rate:
            level = float(np.median(blocks[first:last]))
            plateaus.append(Plateau(first * width / rate, last * width / rate, level))
    return plateaus


def plateau_findings(
    plateaus: tuple[Plateau, ...], first_beat: float = np.inf, last_beat: float = -np.inf
) -> list[Finding]:
    """Return what plateaus are: zeros, right or off, before, after or between beats, and calibration pressures."""
    zeros = [plateau for plateau in plateaus if abs(plateau.level) < RULES.max_air_pressure]
    findings = []
    for plateau in zeros:
        within = ZERO_WITHIN if first_beat < plateau.start and plateau.end < last_beat else OPEN_TO_AIR
        findings.append((OFF_ZERO if abs(plateau.level) > RULES.max_zero_error else within)(**plateau._asdict()))
    calibrations = [plateau for plateau in plateaus if abs(plateau.level) >= RULES.max_air_pressure]
    if calibrations:
        levels = ", ".join(
            f"{plateau.level:.3g} mmHg ({plateau.start:.3g} to {plateau.end:.3g} s)" for plateau in calibrations
        )
        findings.append(CALIBRATION(levels=levels))
    return findings


def saturated(raw: RawRecording, plateaus: tuple[Plateau, ...], beat: float) -> list[Finding]:
    """Return a finding for each of pressure and flow whose peaks or troughs are cut off at one value.

    Plateaus that are longer than a `beat`, s, are no part of the wave.
    """
    time = raw.time
    wave = np.ones(len(time), dtype=bool)
    for plateau in plateaus:
        wave &= (
            (time < plateau.start) | (time > plateau.end) | (plateau.end - plateau.start < RULES.max_flat_beats * beat)
        )
    findings = []
    for signal, unit, values in (("pressure", "mmHg", raw.pressure[wave]), ("flow", "ml/s", raw.flow[wave])):
        for sign, end, extremes in ((1.0, "largest", "peaks"), (-1.0, "smallest", "troughs")):
            share, value = _cut_off(sign * values), sign * float(np.max(sign * values, initial=-np.inf))
            rests = signal == "flow" and sign < 0 and abs(value) < RULES.rest_share * np.ptp(values)
            if share and not rests:
                findings.append(
                    SATURATED(what=signal, unit=unit, percent=100 * share, value=value, end=end, parts=extremes)
                )
    return findings


def _cut_off(values: np.ndarray) -> float:
    """Return the share of samples at the largest value; 0 if they are no more than a peak that is rounded has."""
    if not len(values):
        return 0.0
    below = values.max() - values
    steps = np.diff(np.unique(below[below <= RULES.step_range_share * np.ptp(values)]))
    step = max(float(np.median(steps)) if len(steps) else 0.0, RULES.min_step_share * float(np.ptp(values)))
    top = below < 0.5 * step
    edges = np.flatnonzero(np.diff(np.concatenate([[0], top, [0]])))
    lasting = np.diff(edges.reshape(-1, 2), axis=1)  # of every run of samples at the top
    at_top, next_below = lasting[lasting >= RULES.min_run_samples].sum(), np.sum(~top & (below < 1.5 * step))
    share = float(at_top / len(values))
    return share if share > RULES.min_cut_share and at_top > RULES.min_cut_ratio * next_below else 0.0
