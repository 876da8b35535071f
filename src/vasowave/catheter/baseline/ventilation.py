"""End-expiration: the beats that stand at it, and how far the others are lifted by the breath.

A breath that repeats is known by its phase. A ventilator raises the pressure in inspiration, so that end-expiration is
the lower end of the breath, unless the pressure rests at the upper one. Breaths that do not repeat are known by their
plateau alone.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from vasowave.base.cures import AVERAGE_BREATHS
from vasowave.base.findings import Finding, look_kind, note_kind
from vasowave.catheter.baseline.breaths import Breath, find_breaths
from vasowave.catheter.beats.rhythm import of_rhythm
from vasowave.pulse.cycle.averaged import Rejection

_MAX_SHAPIRO = 5000  # levels, up to which the test of Shapiro and Wilk is accurate


@dataclass(frozen=True)
class VentilationRules:
    """What counts as end-expiration.

    Attributes
    ----------
    low_share : float
        Share of the breath's height above its end within which a beat stands at end-expiration.
    longer, much_longer : float
        The pressure rests at its lower end if it stays there this many times as long as at the upper one; at its upper
        end, if it stays there so much longer.
    smooth_share : float
        Share of a breath's power in its first harmonic from which on it is a sine, which rests nowhere.
    end_share : float
        Share of a breath, around its end, over which the level of that end is taken.
    outlier_sd : float
        A beat further off its level than this many SD is none of end-expiration.
    level_beats : int
        Beats over which the level is followed where no breath repeats: three breaths or more.
    no_breath : float
        Levels that differ by less than this share of the signal's mean show no breath.
    cut_samples : float
        By so many samples the lengths of beats may seem to differ, half of one too long or too short at either end, as
        samples and beats fall in and out of step; their means move along, which is no breath.
    tells, tells_of_flow : float
        A breath lower than this share of the mean pressure asks for no look, nor one that moves the mean flow by less
        than this share.
    locked : float
        Concentration of the beats' phases, 0 to 1, from which on breaths are locked to the beat.
    plateau_beats : float
        With so many beats a breath at one level, that is end-expiration, also of locked breaths.
    scatter_sd : float
        Without a breath, a beat further off the mean than this many SD is none of the usual ones.
    serial_sd, normal_p : float
        Levels are scatter if the ratio of von Neumann is off 2 by less than this many of its SD, and the p of a normal
        distribution above this.
    min_scatter_beats : int
        Of fewer beats neither is known.
    locked_error : float
        Share of the height of locked breaths by which the mean pressure may be off where fewer beats share a level.
    """

    low_share: float = 0.12
    longer: float = 1.5
    much_longer: float = 2.0
    smooth_share: float = 0.97
    end_share: float = 0.1
    outlier_sd: float = 2.5
    level_beats: int = 31
    no_breath: float = 0.01
    cut_samples: float = 2.0
    tells: float = 0.04
    tells_of_flow: float = 0.02
    locked: float = 0.9
    locked_error: float = 0.25
    plateau_beats: float = 1.8
    scatter_sd: float = 4.0
    serial_sd: float = 2.6
    normal_p: float = 0.01
    min_scatter_beats: int = 8


RULES = VentilationRules()

_VENTILATION = note_kind("beat.ventilation", "ventilation: mean {signal} {off:+.3g} {unit} from end-expiration")
_TURN_OFF = "If the animal breathes by itself, average over the breath."
NO_PLATEAU = look_kind(
    "recording.breath-without-plateau",
    "the pressure swings by {height:.2g} mmHg with each breath ({rate:.0f} a minute) and rests at neither end; the "
    "lower end was taken for end-expiration, as under a ventilator. If the animal breathes by itself, it is the upper "
    "end, and the mean pressure is {height:.2g} mmHg higher",
    _TURN_OFF,
    AVERAGE_BREATHS,
)
RESTS_HIGH = look_kind(
    "recording.breath-rests-high",
    "the pressure falls by {height:.2g} mmHg with each breath ({rate:.0f} a minute) and rests at the upper end, which "
    "was taken for end-expiration, as of an animal that breathes by itself. If a ventilator holds inspiration for "
    "longer than expiration, it is the lower end, and the mean pressure is {height:.2g} mmHg lower",
    _TURN_OFF,
    AVERAGE_BREATHS,
)
LOCKED = look_kind(
    "recording.breath-locked",
    "breaths keep step with the heart ({beats:.2g} beats a breath), so that what a breath of {height:.2g} mmHg "
    "does within a beat cannot be told from the beat; the mean pressure may be off by {error:.2g} mmHg",
    "Choose a stretch in which heart and ventilator do not keep step.",
)
_BOTH_MEANS = (
    "at end-expiration, as averaged, the mean pressure is {pressure:.3g} mmHg and the mean flow {flow:.3g} ml/s; over "
    "whole breaths they are {breath_pressure:.3g} mmHg ({pressure_percent:+.1f} %) and {breath_flow:.3g} ml/s "
    "({flow_percent:+.1f} %)"
)
BREATH_MOVES = note_kind("recording.breath-moves", _BOTH_MEANS)
BREATH_MOVES_FLOW = look_kind(
    "recording.breath-moves-flow",
    _BOTH_MEANS,
    "Pressures are compared at end-expiration, an output over whole breaths. If the output counts, average over the "
    "breath.",
    AVERAGE_BREATHS,
)


class Expiration(NamedTuple):
    """How the beats stand to end-expiration.

    Attributes
    ----------
    excess : float array, shape (beat,)
        How far the breath lifts the mean pressure of each beat above end-expiration, mmHg: what is to be subtracted.
    error : float
        What is unknown of it in the beats at end-expiration, mmHg.
    findings : tuple of Finding
    breath_moves : pair of float
        How far mean pressure, mmHg, and mean flow, ml/s, over whole breaths stand above those at end-expiration.
    """

    excess: np.ndarray
    error: float = 0.0
    findings: tuple[Finding, ...] = ()
    breath_moves: tuple[float, float] = (0.0, 0.0)

    def compared(self, pressure: float, flow: float, rules: VentilationRules = RULES) -> list[Finding]:
        """Return what is said of an average of such mean pressure, mmHg, and flow, ml/s: both over whole breaths.

        Pressures are by convention those at end-expiration, an output is one over the breath: it asks for a look.
        """
        moves = dict(zip(("pressure", "flow"), self.breath_moves, strict=True))
        shares = {"pressure": moves["pressure"] / pressure, "flow": moves["flow"] / flow}
        if max(map(abs, shares.values())) < rules.no_breath:
            return []
        kind = BREATH_MOVES_FLOW if abs(shares["flow"]) > rules.tells_of_flow else BREATH_MOVES
        finding = kind(
            pressure=pressure,
            flow=flow,
            breath_pressure=pressure + moves["pressure"],
            breath_flow=flow + moves["flow"],
            pressure_percent=100 * shares["pressure"],
            flow_percent=100 * shares["flow"],
        )
        return [finding]


def mark_inspiration(
    reasons: list[Rejection], starts: np.ndarray, ends: np.ndarray, means: tuple[np.ndarray, np.ndarray],
    shapes: tuple[np.ndarray, np.ndarray], sample: float = 0.0, rules: VentilationRules = RULES,
) -> Expiration:  # fmt: skip
    """Reject the beats whose mean pressure or flow stands off the end-expiratory level, and return that level.

    Parameters
    ----------
    reasons : list of Finding or None
        Are added to.
    starts, ends : float array, shape (beat,)
        Of the beats, s.
    means : pair of float arrays, shape (beat,)
        Mean pressure, mmHg, its drift removed, and mean flow, ml/s.
    shapes : pair of float arrays, shape (sample,)
        The usual beat of both.
    sample : float, optional
        Time between the samples of which they were cut, s.
    rules : VentilationRules, optional
    """
    lengths = ends - starts
    shaped = np.array([not reason for reason in reasons], dtype=bool)
    cut = rules.cut_samples * sample / float(np.median(lengths))
    expiration = _expiration(reasons, 0.5 * (starts + ends), lengths, means, shapes, cut, rules)
    expired = np.array([not reason for reason in reasons], dtype=bool)
    if not expired.any():
        return expiration
    pressure, flow = (
        np.average(mean[shaped], weights=lengths[shaped]) - np.average(lowered[expired], weights=lengths[expired])
        for mean, lowered in zip(means, (means[0] - expiration.excess, means[1]), strict=True)
    )
    return expiration._replace(breath_moves=(float(pressure), float(flow)))


def _expiration(
    reasons: list[Rejection], time: np.ndarray, lengths: np.ndarray, means: tuple[np.ndarray, np.ndarray],
    shapes: tuple[np.ndarray, np.ndarray], cut: float, rules: VentilationRules,
) -> Expiration:  # fmt: skip
    """Reject the beats of inspiration, and return how the others stand to end-expiration; see `mark_inspiration`."""
    good = np.array([not reason for reason in reasons], dtype=bool)
    breaths, led = _breaths(time, lengths, means, good, rules)
    means = (means[0] - led, means[1])
    if led.any() and not breaths:
        return Expiration(np.zeros(len(time)))
    if sum(len(breath.beats) for breath in breaths) < len(time):
        for name, mean, shape, unit in zip(("pressure", "flow"), means, shapes, ("mmHg", "ml/s"), strict=True):
            off, limit = _off_level(mean, rules)
            if _is_scatter(mean[good], rules):
                off, limit = mean - mean[good].mean(), rules.scatter_sd * float(mean[good].std())
            _mark(reasons, off, max(limit, _no_breath(shape, cut, rules)), name, unit)
        return Expiration(np.zeros(len(time)))
    expirations = [_end(breath, time, float(np.mean(means[0])), rules) for breath in breaths]
    off = np.concatenate([end.off for end in expirations])
    height = max(end.height for end in expirations)
    limit = max(rules.low_share * height, _no_breath(shapes[0], cut, rules))
    _mark(reasons, off, limit, "pressure", "mmHg")
    excess = np.concatenate([end.excess for end in expirations])
    used = np.array([not reason for reason in reasons], dtype=bool)
    lifted = float(np.mean((off - excess)[used])) if used.any() and not excess.any() else 0.0
    highest = max(expirations, key=lambda end: end.height)
    return Expiration(excess, float(np.hypot(highest.error, 0.5 * lifted)), highest.findings)


def _no_breath(shape: np.ndarray, cut: float, rules: VentilationRules) -> float:
    """Return by what levels may differ without a breath, where beats begin within `cut` of their length."""
    return max(rules.no_breath * float(abs(shape.mean())), cut * float(abs(shape.mean() - shape[0])))


def _breaths(
    time: np.ndarray, lengths: np.ndarray, means: tuple[np.ndarray, np.ndarray], good: np.ndarray,
    rules: VentilationRules,
) -> tuple[list[Breath], np.ndarray]:  # fmt: skip
    """Return the breaths, and what the rhythm makes of the mean pressures beside them, mmHg: zeros where there is none.

    A breath found where the rhythm is taken off is told from what the rhythm leaves by its height.
    """
    pressure, flow = means
    breath = np.zeros(len(time))
    breaths = find_breaths(time, pressure, good) if good.any() else []
    for stretch in breaths:
        breath[stretch.beats] = stretch.at(stretch.time)
    led = of_rhythm(pressure, flow, lengths, good, breath) if breaths else breath
    if led.any():
        height_limit = rules.tells * float(pressure.mean())
        candidates = find_breaths(time, pressure - led, good)
        breaths = [
            stretch for stretch in candidates if np.ptp(stretch.at(stretch.time[good[stretch.beats]])) > height_limit
        ]
    return breaths, led


class _EndExpiration(NamedTuple):
    """End-expiration of one stretch: how far beats are off it, what is subtracted, the breath's height, findings."""

    off: np.ndarray
    excess: np.ndarray
    height: float
    error: float
    findings: tuple[Finding, ...]


def _end(breath: Breath, time: np.ndarray, mean: float, rules: VentilationRules) -> _EndExpiration:
    """Return the end-expiratory end of a breath: the lower one, or the upper one if the pressure rests there."""
    at_beats = breath.at(breath.time)
    beat = float(np.median(np.diff(breath.time)))
    course = breath.within_beats(beat)
    width = round(rules.end_share * len(course))
    level = np.convolve(np.concatenate([course, course[:width]]), np.full(width, 1 / width), "valid")
    height = float(np.ptp(level))
    beats = 1.0 / (breath.rate * beat)
    phases = breath.time * breath.rate * max(1, round(beats))
    locked = abs(np.mean(np.exp(2j * np.pi * phases))) > rules.locked
    means = at_beats if locked else breath.at(np.arange(200) / (200 * breath.rate))
    low, high = means.min(), means.max()
    reach = rules.low_share * (high - low)
    at_low, at_high = np.mean(means < low + reach), np.mean(means > high - reach)
    upper = at_high > rules.much_longer * at_low
    smooth = not (upper or locked) and breath.sine_share > rules.smooth_share
    values: dict[str, float] = {"height": height, "rate": 60 * breath.rate}
    findings = [RESTS_HIGH(**values)] if upper else [] if at_low > rules.longer * at_high else [NO_PLATEAU(**values)]
    in_doubt = locked and (at_high if upper else at_low) * beats < rules.plateau_beats
    error = rules.locked_error * height if in_doubt else 0.0
    if smooth:
        error = float(np.hypot(2.0 * breath.noise**0.5, level.min() - course.min()))
    if in_doubt:
        findings.append(LOCKED(beats=beats, height=height, error=error))
    off = at_beats - (high if upper else low)
    excess = at_beats - level.min() if smooth else np.zeros(len(off))
    return _EndExpiration(off, excess, height, error, tuple(findings if height > rules.tells * mean else ()))


def _mark(reasons: list[Rejection], off: np.ndarray, limit: float, signal: str, unit: str) -> None:
    for i in np.flatnonzero(np.abs(off) > limit):
        reasons[i] = reasons[i] or _VENTILATION(signal=signal, off=float(off[i]), unit=unit)


def _off_level(means: np.ndarray, rules: VentilationRules) -> tuple[np.ndarray, float]:
    """Return how far each beat's mean stands off the end-expiratory level nearby, and what is too far.

    At end-expiration the level is a plateau, so its beats are the narrowest interval that holds a quarter of all; the
    rest of the plateau is judged by their scatter. Then the level is followed through the plateau's beats alone.
    """
    from scipy.ndimage import median_filter

    indices = np.arange(len(means))
    plateau = indices
    for _ in range(3):
        followed = median_filter(means[plateau], min(rules.level_beats, len(plateau)), mode="reflect")
        level = means - np.interp(indices, plateau, followed)
        middle, spread = _narrowest_quarter(level)
        plateau = np.flatnonzero(np.abs(level - middle) <= rules.outlier_sd * spread)
    return level - middle, rules.outlier_sd * spread


def _is_scatter(means: np.ndarray, rules: VentilationRules) -> bool:
    """Whether levels are those of beats without a breath: normal (Shapiro & Wilk 1965), and none tells the next
    (von Neumann 1941).
    """
    from scipy.stats import shapiro

    count = len(means)
    if count < rules.min_scatter_beats or not np.ptp(means) > 0:
        return False
    ratio = float(np.mean(np.diff(means) ** 2) / np.var(means))
    if abs(ratio - 2.0) > rules.serial_sd * 2.0 / count**0.5:
        return False
    thinned = means[:: -(-count // _MAX_SHAPIRO)]
    return float(shapiro(thinned).pvalue) > rules.normal_p


def _narrowest_quarter(level: np.ndarray) -> tuple[float, float]:
    """Return the middle of the narrowest interval with a quarter of the values, and the SD of a normal so narrow."""
    ordered = np.sort(level)
    count = max(2, (len(ordered) + 3) // 4)
    widths = ordered[count - 1 :] - ordered[: len(ordered) - count + 1]
    first = int(np.argmin(widths))
    middle = 0.5 * (ordered[first] + ordered[first + count - 1])
    return float(middle), 0.5 * float(widths[first]) / 0.319
