"""Lines through the corners of a family of loops, with the intervals of their slopes and of where they cross zero."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from vasowave.base import units
from vasowave.base.descriptions import LEVEL
from vasowave.base.findings import Finding, look_kind
from vasowave.pulse.analysis.loops import CutLoops, PressureVolumeLoop


@dataclass(frozen=True)
class FamilyLineRules:
    """When a line stands and when it is believed."""

    max_iterations: int = 50  # of the line through the end-systolic points
    tolerance: float = 1e-4  # change of V0, as a share of the stroke volume, from which that line stands
    max_relative_error: float = 0.25  # half width of the interval of E_es, as a share of it, that is still told as sure
    left_noise: float = 0.6  # of the volume's noise, in an end-systolic point, whose cubic and line smooth it
    bend_level: float = 0.999  # one-sided, of a bend of the end-systolic points


RULES = FamilyLineRules()

BENT = look_kind(
    "loops.end-systole-bends",
    "{source}: the end-systolic points lie on a bend: E_es is {low:.3g} at the lower and {high:.3g} mmHg/ml at the "
    "upper end, and V_0 lies outside of what was measured",
    "Compare animals over the same range of end-systolic pressures.",
)
UNSURE = look_kind(
    "loops.elastance-unsure",
    "{source}: E_es is known to ± {percent:.0f} % only: its {beats} points scatter, or lie close together",
    "Close the vena cava for longer, with the ventilator off, or name the stretch of the fall.",
)


class IntervalEstimate(NamedTuple):
    """A number with its 95 % interval, and the count of beats behind it; NaN where there is none."""

    value: float
    low: float
    high: float
    beats: int


class FittedLine(NamedTuple):
    """The slope of a line, and where it crosses zero: without end on a side where its slope may be 0."""

    slope: IntervalEstimate
    root: IntervalEstimate


def family_lines(cut: CutLoops, numbers: Sequence[int], source: str
                 ) -> tuple[dict[str, IntervalEstimate], list[Finding]]:  # fmt: skip
    """Return what the loops of a family tell, by the names of `VENTRICULAR`, and what is to be said of it."""
    loops, noise = [cut.loops[number] for number in numbers], cut.volume_noise
    systolic, volume, pressure = _end_systolic_line(loops, noise)
    findings, half = list[Finding](), 0.5 * (systolic.slope.high - systolic.slope.low) / systolic.slope.value
    if not 0 < half < RULES.max_relative_error:
        findings.append(UNSURE(source=source, percent=100 * abs(half), beats=len(loops)))
    if (bend := _bend(volume, pressure)) is not None:
        findings.append(BENT(source=source, low=bend[0], high=bend[1]))
    filled, resting = (np.array([values[0] for values in waves]) for waves in
                       ([loop.volume for loop in loops], [loop.pressure for loop in loops]))  # fmt: skip
    recruited = fit_line(filled, np.array([loop.stroke_work for loop in loops]) / units.MILLIWATT, noise)
    return {
        "E_es": systolic.slope,
        "V_0": systolic.root,
        "PRSW": recruited.slope,
        "V_w": recruited.root,
        "dp_dt_max_over_EDV": fit_line(filled, np.array([loop.slope.max() for loop in loops]), noise).slope,
        "diastolic_slope": fit_line(filled, resting, noise).slope,
        "diastolic_beta": _exponent(filled, resting),
    }, findings


def fit_line(x: np.ndarray, y: np.ndarray, x_noise: float = 0.0) -> FittedLine:
    """Return the line through points by least squares, with Fieller's interval of where it crosses zero.

    `x_noise` is the SD of an error of each x, which flattens such a line: it is taken off the variance of x.
    """
    from scipy.stats import t as student

    count, center, level = len(x), float(x.mean()), float(y.mean())
    square = float(np.sum((x - center) ** 2))
    spread = max(square - (count - 1) * x_noise**2, 0.5 * square)
    slope = float(np.sum((x - center) * (y - level))) / spread
    variance = float(np.sum((y - level - slope * (x - center)) ** 2)) / (count - 2)
    quantile = float(student.ppf(0.5 + LEVEL / 2, count - 2))
    half = quantile * float(np.sqrt(variance * square)) / spread
    a = slope**2 - half**2  # of Fieller's quadratic; not above 0 where the slope may be 0
    reach = np.sqrt(quantile**2 * variance / count * max(a, 0.0) + (level * half) ** 2)
    low, high = ((center - (slope * level + sign * reach) / a) if a > 0 else -sign * np.inf for sign in (1, -1))
    return FittedLine(
        IntervalEstimate(slope, slope - half, slope + half, count),
        IntervalEstimate(center - level / slope, float(low), float(high), count),
    )


def _end_systolic_line(loops: Sequence[PressureVolumeLoop], noise: float) -> tuple[FittedLine, np.ndarray, np.ndarray]:
    """Return the end-systolic line, and volumes and pressures of its points, which are taken anew with each V0."""
    zero: float | None = None
    for _ in range(RULES.max_iterations):
        volume, pressure = np.transpose([loop.end_systole(zero) for loop in loops])
        line = fit_line(volume, pressure, RULES.left_noise * noise)
        if zero is not None and abs(line.root.value - zero) < RULES.tolerance * loops[0].stroke_volume:
            break
        zero = line.root.value
    return line, volume, pressure


def _bend(volume: np.ndarray, pressure: np.ndarray) -> tuple[float, float] | None:
    """Return the slope at the lower and upper end of points that surely lie on a bend; None where they do not."""
    from scipy.stats import t as student

    columns, free = np.vander((volume - volume.mean()) / np.ptp(volume), 3), len(volume) - 3
    best = np.linalg.lstsq(columns, pressure)[0]
    variance = float(np.sum((pressure - columns @ best) ** 2)) / free
    error = np.sqrt(variance * np.linalg.pinv(columns.T @ columns)[0, 0])
    if not abs(best[0]) > student.ppf(RULES.bend_level, free) * error:
        return None
    low, high = (best[1] + 2 * best[0] * columns[[np.argmin(volume), np.argmax(volume)], 1]) / np.ptp(volume)
    return float(low), float(high)


def _exponent(volume: np.ndarray, pressure: np.ndarray) -> IntervalEstimate:
    """Return β of ``p = A exp(β V)`` by least squares of the pressure; NaN where no such curve goes through them."""
    from scipy.optimize import curve_fit
    from scipy.stats import t as student

    centered = volume - volume.mean()
    if not pressure.min() > 0:
        return IntervalEstimate(np.nan, np.nan, np.nan, len(volume))
    start = np.polyfit(centered, np.log(pressure), 1)[::-1]
    try:
        best, covariance = curve_fit(
            lambda x, level, beta: np.exp(level + beta * x), centered, pressure, start, maxfev=500
        )
    except RuntimeError:
        return IntervalEstimate(np.nan, np.nan, np.nan, len(volume))
    beta, half = float(best[1]), float(student.ppf(0.5 + LEVEL / 2, len(volume) - 2) * np.sqrt(covariance[1, 1]))
    return IntervalEstimate(beta, beta - half, beta + half, len(volume))
