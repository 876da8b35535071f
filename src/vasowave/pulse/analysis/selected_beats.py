"""Beats of a recording of loops: those that are alike, those of a stretch, those over which the preload falls."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from vasowave.base.errors import InputError
from vasowave.pulse.analysis.loops import PressureVolumeLoop


@dataclass(frozen=True)
class SelectionRules:
    """Which beats are extra ones, and which are a family."""

    max_period_difference: float = 0.2  # from the median of the beats around, as a share: else an extra beat
    max_stroke_ratio: float = 1.6  # of the stroke volume to that of the beats around
    steady_share: float = 0.1  # of the whole fall, from which a beat belongs to it


RULES = SelectionRules()


def usable_beats(loops: Sequence[PressureVolumeLoop]) -> list[int]:
    """Return the beats that are neither extra ones nor follow them: period and stroke are like those around."""
    from scipy.ndimage import median_filter

    periods = np.array([loop.period for loop in loops])
    strokes = np.array([loop.stroke_volume for loop in loops])
    strokes = np.maximum(strokes, 1e-6 * strokes.max())
    usual, typical = (median_filter(values, 7, mode="nearest") for values in (periods, strokes))
    alike = np.abs(periods / usual - 1) <= RULES.max_period_difference
    alike &= np.abs(np.log(strokes / typical)) <= np.log(RULES.max_stroke_ratio)
    return [int(number) for number in np.flatnonzero(alike)] or list(range(len(loops)))


def beats_within(loops: Sequence[PressureVolumeLoop], usable: Sequence[int], stretch: tuple[float, float], source: str
           ) -> list[int]:  # fmt: skip
    """Return the beats of a stretch, s."""
    numbers = [n for n in usable if stretch[0] <= loops[n].start and loops[n].start + loops[n].period <= stretch[1]]
    if not numbers:
        raise InputError(f"{source}: no whole beat lies between {stretch[0]:g} and {stretch[1]:g} s; the beats lie "
                         f"between {loops[0].start:.4g} and {loops[-1].start + loops[-1].period:.4g} s")  # fmt: skip
    return numbers


def falling_beats(loops: Sequence[PressureVolumeLoop], usable: Sequence[int]) -> list[int]:
    """Return the beats over which the end-diastolic volume falls farthest."""
    filled = np.array([loops[number].volume[0] for number in usable])
    lowest_after = np.minimum.accumulate(filled[::-1])[::-1]
    high = int(np.argmax(filled - lowest_after))
    low = high + int(np.argmin(filled[high:]))
    level = filled[high] - RULES.steady_share * (filled[high] - filled[low])
    above = np.flatnonzero(filled[:low] >= level)
    return list(usable[int(above[-1]) if len(above) else high : low + 1])
