"""End-expiration: the beats that stand at it, and how far the others are lifted by the breath.

Animals rest at the end of expiration, so it is the end of the breath at which the pressure stays for longer: the lower
one under a ventilator, the upper one of many that breathe by themselves. Where it stays at neither, no end is known to
be that of expiration, and no beat is left out: means over whole breaths are alike in all recordings. A breath that
repeats is known by its phase, breaths that do not by the levels of the beats.
"""

from dataclasses import dataclass
from typing import Literal, NamedTuple

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
    longer : float
        The pressure rests at an end if it is this many times as long in that third of the breath's height.
    end_share : float
        Share of a breath over which the level of an end is taken.
    explained : float
        Share of the variance of levels that breaths explain which repeat.
    outlier_sd : float
        A beat further off its level than this many SD is none of end-expiration.
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
        With fewer beats a breath at its end, locked breaths are not known to rest there.
    scatter_sd : float
        Without a breath, a beat further off the mean than this many SD is none of the usual ones.
    serial_sd, normal_p : float
        Levels are scatter if the ratio of von Neumann is off 2 by less than this many of its SD, and the p of a normal
        distribution above this.
    min_scatter_beats : int
        Of fewer beats neither is known.
    """

    low_share: float = 0.12
    longer: float = 1.5
    end_share: float = 0.1
    explained: float = 0.85
    outlier_sd: float = 2.5
    no_breath: float = 0.01
    cut_samples: float = 2.0
    tells: float = 0.04
    tells_of_flow: float = 0.02
    locked: float = 0.9
    plateau_beats: float = 2.5
    scatter_sd: float = 4.0
    serial_sd: float = 2.6
    normal_p: float = 0.01
    min_scatter_beats: int = 8


RULES = VentilationRules()

_VENTILATION = note_kind("beat.ventilation", "ventilation: mean pressure {off:+.3g} mmHg from end-expiration")
_RANGE = 2.0, 98.0  # percentiles between which levels are counted
_BREATHS = "If recordings are compared, average all of them over the breath."
NO_PLATEAU = look_kind(
    "recording.breath-without-plateau",
    "the pressure swings by {height:.2g} mmHg with each breath ({rate:.0f} a minute) and rests at neither end, so that "
    "neither is known to be end-expiration: whole breaths are averaged. Under a ventilator end-expiration is up to "
    "{half:.2g} mmHg lower, in an animal that breathes by itself as much higher",
    _BREATHS,
    AVERAGE_BREATHS,
)
RESTS_HIGH = look_kind(
    "recording.breath-rests-high",
    "the pressure falls by {height:.2g} mmHg with each breath ({rate:.0f} a minute) and rests at the upper end, which "
    "was taken for end-expiration, as of an animal that breathes by itself. If a ventilator holds inspiration for "
    "longer than expiration, it is the lower end, and the mean pressure is {height:.2g} mmHg lower",
    _BREATHS,
    AVERAGE_BREATHS,
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


Rest = Literal["", "lower", "upper", "neither"]
"""The end of the breath at which the pressure rests; empty where there is no breath."""


class Expiration(NamedTuple):
    """How the beats stand to end-expiration.

    Attributes
    ----------
    rests : str
        At which end of the breath the pressure rests; over whole breaths is averaged where at neither.
    error : float
        What is unknown of the mean pressure of beats at end-expiration, mmHg.
    findings : tuple of Finding
    breath_moves : pair of float
        How far mean pressure, mmHg, and mean flow, ml/s, over whole breaths stand above those at end-expiration.
    """

    rests: Rest = ""
    error: float = 0.0
    findings: tuple[Finding, ...] = ()
    breath_moves: tuple[float, float] = (0.0, 0.0)

    def compared(self, pressure: float, flow: float, rules: VentilationRules = RULES) -> list[Finding]:
        """Return what is said of an average of such mean pressure, mmHg, and flow, ml/s: both over whole breaths.

        Pressures are by convention those at end-expiration, an output is one over the breath: it asks for a look.
        """
        moves = self.breath_moves[0] / pressure, self.breath_moves[1] / flow
        if max(map(abs, moves)) < rules.no_breath:
            return []
        kind = BREATH_MOVES_FLOW if abs(moves[1]) > rules.tells_of_flow else BREATH_MOVES
        return [kind(pressure=pressure, breath_pressure=pressure * (1 + moves[0]), pressure_percent=100 * moves[0],
                     flow=flow, breath_flow=flow * (1 + moves[1]), flow_percent=100 * moves[1])]  # fmt: skip


def mark_inspiration(
    reasons: list[Rejection], starts: np.ndarray, ends: np.ndarray, means: tuple[np.ndarray, np.ndarray],
    shapes: tuple[np.ndarray, np.ndarray], sample: float = 0.0, rules: VentilationRules = RULES,
) -> Expiration:  # fmt: skip
    """Reject the beats whose mean pressure stands off end-expiration, and return at which end that is.

    Times are in s; `means` are those of the beats' pressure, its drift removed, and flow, `shapes` their usual beats;
    `sample` is the time between samples. `reasons` are added to.
    """
    lengths, time, shape = ends - starts, 0.5 * (starts + ends), shapes[0]
    good = np.array([not reason for reason in reasons], dtype=bool)
    breaths, led = _breaths(time, lengths, means, good, rules)
    if (led.any() and not breaths) or not good.any():
        return Expiration()
    levels, cut = means[0] - led, rules.cut_samples * sample / float(np.median(lengths))
    no_breath = max(rules.no_breath * abs(shape.mean()), cut * abs(shape.mean() - shape[0]))
    if _repeats(breaths, levels, good, no_breath, rules):
        expiration = _by_phase(reasons, breaths, float(levels.mean()), no_breath, rules)
    else:
        expiration = _by_level(reasons, time, levels, no_breath, rules)
    expired = np.array([not reason for reason in reasons], dtype=bool)
    if not expired.any():
        return expiration
    pressure, flow = (
        float(np.average(mean[good], weights=lengths[good]) - np.average(mean[expired], weights=lengths[expired]))
        for mean in means
    )
    return expiration._replace(breath_moves=(pressure, flow))


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


def _repeats(
    breaths: list[Breath], means: np.ndarray, good: np.ndarray, no_breath: float, rules: VentilationRules
) -> bool:
    """Whether the phase of a beat tells where in the breath it stands: little is left of levels, or nothing that
    returns (Box & Pierce 1970).
    """
    if sum(len(breath.beats) for breath in breaths) < len(means):
        return False
    fitted = np.concatenate([breath.at(breath.time) + means[breath.beats].mean() for breath in breaths])
    residual = (means - fitted)[good] - (means - fitted)[good].mean()
    lags = min(round(1.0 / (breaths[0].rate * np.median(np.diff(breaths[0].time)))), len(residual) // 2)
    power = max(float(residual @ residual), 1e-300)
    returns = [float(residual[lag:] @ residual[:-lag]) / power for lag in range(1, lags + 1)]
    is_noise = len(residual) * np.sum(np.square(returns)) < lags + rules.scatter_sd * (2.0 * lags) ** 0.5
    return bool(is_noise or residual.std() < max(no_breath, (1.0 - rules.explained) ** 0.5 * float(means[good].std())))


def _rests(stretches: list[np.ndarray], rules: VentilationRules) -> Rest:
    """Return the end at which levels rest: most of all stretches lie in the third of their range at that end."""
    low, high = 0.0, 0.0
    for levels in stretches:
        bottom, top = np.percentile(levels, _RANGE)
        low += np.mean(levels < bottom + (top - bottom) / 3)
        high += np.mean(levels > top - (top - bottom) / 3)
    return "lower" if low > rules.longer * high else "upper" if high > rules.longer * low else "neither"


def _doubts(rests: Rest, height: float, rate: float, limit: float) -> tuple[Finding, ...]:
    """Return what is said of breaths higher than a limit, mmHg, so many a second."""
    if rests in ("", "lower") or height <= limit:
        return ()
    if rests == "upper":
        return (RESTS_HIGH(height=height, rate=60 * rate),)
    return (NO_PLATEAU(height=height, rate=60 * rate, half=0.5 * height),)


def _course(breath: Breath, rules: VentilationRules) -> tuple[np.ndarray, float, float]:
    """Return levels over a breath, mmHg, its height were beats short, and beats a breath where both keep step, else 0.

    Of breaths that keep step only what the beats show is known.
    """
    beat = float(np.median(np.diff(breath.time)))
    phases = breath.time * breath.rate * max(1, round(1.0 / (breath.rate * beat)))
    locked = abs(np.mean(np.exp(2j * np.pi * phases))) > rules.locked
    levels = breath.at(breath.time if locked else np.arange(200) / (200 * breath.rate))
    course = breath.within_beats(beat)
    width = round(rules.end_share * len(course))
    ends = np.convolve(np.append(course, course[:width]), np.full(width, 1 / width), "valid")
    return levels, float(np.ptp(ends)), locked / (breath.rate * beat)


def _by_phase(
    reasons: list[Rejection], breaths: list[Breath], mean: float, no_breath: float, rules: VentilationRules
) -> Expiration:
    """Reject the beats that stand off the end at which breaths that repeat rest; none if they rest at neither."""
    courses = [_course(breath, rules) for breath in breaths]
    rests = _rests([levels for levels, *_ in courses], rules)
    height, beats, rate = max((height, beats, breath.rate) for breath, (_, height, beats) in zip(breaths, courses))
    off = np.concatenate([breath.at(breath.time) - (levels.max() if rests == "upper" else levels.min())
                          for breath, (levels, *_) in zip(breaths, courses, strict=True)])  # fmt: skip
    reach = rules.low_share * height
    if beats and np.mean(np.abs(off) < reach) * beats < rules.plateau_beats:
        rests = "neither"
    findings = _doubts(rests, height, rate, rules.tells * mean)
    if rests == "neither":
        return Expiration(rests, findings=findings)
    used = _mark(reasons, off, max(reach, no_breath))
    return Expiration(rests, 0.5 * abs(float(off[used].mean())) if used.any() else 0.0, findings)


def _mark(reasons: list[Rejection], off: np.ndarray, limit: float) -> np.ndarray:
    """Reject beats further off than a limit; return which are left."""
    for i in np.flatnonzero(np.abs(off) > limit):
        reasons[i] = reasons[i] or _VENTILATION(off=float(off[i]))
    return np.array([not reason for reason in reasons])


def _by_level(
    reasons: list[Rejection], time: np.ndarray, means: np.ndarray, no_breath: float, rules: VentilationRules
) -> Expiration:
    """Reject the beats off the level at which breaths that do not repeat rest, or off that of all beats.

    End-expiration is a plateau: of the half of the levels at that end the narrowest interval with a quarter of all.
    """
    levels = means[[not reason for reason in reasons]]
    low, high = np.percentile(levels, _RANGE)
    breathes = high - low > 2.0 * no_breath and not _is_scatter(levels, rules)
    rests = _rests([levels], rules) if breathes else ""
    if rests in ("lower", "upper"):
        ordered, count = np.sort(levels), max(2, (len(levels) + 3) // 4)
        half = ordered[len(levels) // 2 :] if rests == "upper" else ordered[: (len(levels) + 1) // 2]
        widths = half[count - 1 :] - half[: len(half) - count + 1]
        first = int(np.argmin(widths))
        middle = 0.5 * float(half[first] + half[first + count - 1])
        limit = rules.outlier_sd * 0.5 * float(widths[first]) / 0.319  # times the SD of a normal as narrow
    else:
        middle = float(np.median(levels))
        limit = rules.scatter_sd * 1.48 * float(np.median(np.abs(levels - middle)))  # times the SD of a normal
    off = means - middle
    used = _mark(reasons, off, max(limit, no_breath)) if rests != "neither" else np.zeros(len(off), dtype=bool)
    error = 0.5 * abs(float(off[used].mean())) if rests and used.any() else 0.0
    sides = np.digitize(levels, [low + (high - low) / 3, high - (high - low) / 3])
    rate = float(np.sum(np.diff(sides[sides != 1]) > 0) / np.ptp(time))
    return Expiration(rests, error, _doubts(rests, float(high - low), rate, rules.tells * float(levels.mean())))


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
