"""Tables of two beats or more that are given as one cycle: known by the harmonics that one beat would have."""

from dataclasses import dataclass

import numpy as np

from vasowave.base.findings import Finding, look_kind
from vasowave.catheter.check.plausibility import PERIOD_LIMITS
from vasowave.pulse.cycle.cycle import MIN_SAMPLES, resample


@dataclass(frozen=True)
class SeveralBeatsRules:
    """When a table holds n beats.

    Attributes
    ----------
    flow_share, pressure_share : float
        A table holds n beats if harmonics that n does not divide have less than this share of the power of either: of
        one beat they have more than half, and the most where the heart beats evenly.
    max_beats : int
        Beats that are looked for.
    harmonics : int
        That are compared; above there is noise.
    alternates : float
        Beats whose pulse differs by more than this share are told to do so.
    first_harmonics, least_share : int, float
        Of one beat the first of its harmonics have at least this share of the power; of many in a row they have none.
    """

    flow_share: float = 0.2
    pressure_share: float = 0.4
    max_beats: int = 8
    harmonics: int = 40
    alternates: float = 0.05
    first_harmonics: int = 8
    least_share: float = 0.3


RULES = SeveralBeatsRules()

_CUT_REMEDY = "Cut one cycle out, or give the whole recording as a continuous one (kind 'raw')."
SEVERAL = look_kind(
    "recording.several-beats",
    "the table holds {beats} beats, not one: their mean was taken, of {period:.4g} s ({rate:.0f} beats/min). {remedy}",
    _CUT_REMEDY,
)
SEVERAL_UNLIKE = look_kind(
    "recording.several-unlike-beats",
    "the table holds {beats} beats, not one, whose pulse differs by {percent:.0f} %: their mean was taken, of "
    "{period:.4g} s ({rate:.0f} beats/min). {remedy}",
    _CUT_REMEDY,
)


def beats_within(pressure: np.ndarray, flow: np.ndarray, period: float, rules: SeveralBeatsRules = RULES) -> int:
    """Return how many beats a cycle of pressure and flow that lasts a period, s, holds."""
    several = (
        beats
        for beats in range(rules.max_beats, 1, -1)
        if period / beats >= PERIOD_LIMITS[0]
        and _undivided(flow, beats, rules.harmonics) < rules.flow_share
        and _undivided(pressure, beats, rules.harmonics) < rules.pressure_share
    )
    return next(several, 1)


def many_beats(pressure: np.ndarray, flow: np.ndarray, rules: SeveralBeatsRules = RULES) -> int:
    """Return about how many beats stand in a row where they are more than `beats_within` looks for, else 0."""
    powers = [np.abs(np.fft.rfft(_level(values)))[1:] ** 2 for values in (pressure, flow)]
    shares = [power[: rules.first_harmonics].sum() / max(power.sum(), 1e-300) for power in powers]
    return 1 + min(int(np.argmax(power)) for power in powers) if max(shares) < rules.least_share else 0


def _undivided(values: np.ndarray, beats: int, harmonics: int) -> float:
    """Return the share of power in harmonics that `beats` does not divide; a straight drift is set apart."""
    power = np.abs(np.fft.rfft(_level(values)))[1 : harmonics + 1] ** 2
    return float(power[np.arange(1, len(power) + 1) % beats != 0].sum() / power.sum())


def _level(values: np.ndarray) -> np.ndarray:
    """Return a signal without the straight drift from its first sample to its last, of the same mean."""
    return values - (values[-1] - values[0]) * np.linspace(-0.5, 0.5, len(values))


def mean_beat(values: np.ndarray, beats: int) -> tuple[np.ndarray, float]:
    """Return the mean of equally long beats in a cycle, and how much their pulses differ, as a share of its pulse."""
    count = max(MIN_SAMPLES, -(-len(values) // beats))
    cycles = resample(_level(values), beats * count).reshape(beats, count)
    mean = cycles.mean(axis=0)
    return mean, float(np.ptp(np.ptp(cycles, axis=1)) / np.ptp(mean))


def several_finding(beats: int, period: float, unlike: float, rules: SeveralBeatsRules = RULES) -> Finding:
    """Return what is said of a table with several beats, of which one lasts `period`, s."""
    if unlike > rules.alternates:
        return SEVERAL_UNLIKE(beats=beats, percent=100 * unlike, period=period, rate=60 / period)
    return SEVERAL(beats=beats, period=period, rate=60 / period)
