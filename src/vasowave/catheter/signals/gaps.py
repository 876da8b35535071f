"""Gaps in a recording, in seconds, and the longest stretch without one."""

from collections.abc import Iterable, Sequence
from typing import NamedTuple

import numpy as np

from vasowave.base.cures import Cure, stretch

_MAX_STRETCH = 20
"""Times may leap over this many times the samples there are; beyond that a clock is wrong."""

_MAX_LEAP_SHARE = 0.01
"""A larger share of leaping steps is another sampling rate, or a thinned-out export, and no recording with gaps."""

_MS_PER_S = 1000  # a stretch is proposed in whole milliseconds


class Span(NamedTuple):
    """A stretch of time: start and end, s since the start of the block."""

    start: float
    end: float


def gaps_in(values: np.ndarray, rate: float) -> tuple[Span, ...]:
    """Return the stretches in which samples are not finite."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], ~np.isfinite(values), [False]]).astype(np.int8)))
    return tuple(Span(first / rate, last / rate) for first, last in zip(edges[::2].tolist(), edges[1::2].tolist()))


def free_between(gaps: Iterable[Span], start: float, end: float) -> list[Span]:
    """Return the stretches from `start` to `end` that touch no gap, in order."""
    stretches, free = [], start
    for gap in [*sorted(gaps), Span(end, end)]:
        if min(gap.start, end) > free:
            stretches.append(Span(free, min(gap.start, end)))
        free = max(free, gap.end)
    return stretches


def longest_between(gaps: Iterable[Span], start: float, end: float) -> Span:
    """Return the longest stretch from `start` to `end` that touches no gap, in whole milliseconds."""
    stretches = [Span(start, start), *free_between(gaps, start, end)]
    longest = max(stretches, key=lambda stretch: stretch.end - stretch.start)
    first, last = np.ceil(longest.start * _MS_PER_S - 1e-6), np.floor(longest.end * _MS_PER_S + 1e-6)
    return Span(float(first) / _MS_PER_S + 0.0, float(max(first, last)) / _MS_PER_S)  # never -0


def describe_gaps(gaps: Sequence[Span], start: float, end: float, shortest: float) -> tuple[str, list[Cure]]:
    """Say where the gaps from `start` to `end` are, and what to read instead of all; `shortest` is of use, s."""
    spans = _joined(gap for gap in gaps if gap.end > start and gap.start < end)
    where = ", ".join(f"{gap.start:.5g} to {gap.end:.5g} s" for gap in spans[:3])
    suffix = f" and {len(spans) - 3} more" if len(spans) > 3 else ""
    message = f"no samples from {where}{suffix}"
    longest = longest_between(spans, start, end)
    if longest.end - longest.start < shortest:
        return f"{message}; no {shortest:g} s are without a gap", []
    start_text, end_text = (f"{time:g}" for time in longest)
    advice = f"the longest stretch without a gap is {start_text} to {end_text} s; take it"
    return f"{message}; {advice}", [stretch(start_text, end_text)]


def _joined(gaps: Iterable[Span]) -> list[Span]:
    """Return gaps in order, those that touch as one."""
    joined: list[Span] = []
    for gap in sorted(gaps):
        if joined and gap.start <= joined[-1].end:
            gap = Span(joined[-1].start, max(joined.pop().end, gap.end))
        joined.append(gap)
    return joined


def leaps_closed(time: np.ndarray) -> tuple[np.ndarray, np.ndarray] | None:
    """Return times without their leaps, and the place of every sample on an even axis that keeps the leaps.

    A pause or samples that an export left out make the times leap. None if they do not, or too often or too far for a
    recording with gaps.

    Parameters
    ----------
    time : float array, shape (sample,)
        s.

    Returns
    -------
    closed : float array, shape (sample,)
        s.
    place : int array, shape (sample,)
    """
    steps = np.diff(time)
    usual = float(np.median(steps)) if len(steps) else 0.0
    if not usual > 0:
        return None
    leaping = steps > 1.5 * usual
    counts = np.where(leaping, np.round(steps / usual), 1.0)
    if not 0 < leaping.sum() <= _MAX_LEAP_SHARE * len(steps) or not counts.sum() <= _MAX_STRETCH * len(time):
        return None
    closed = time.astype(float).copy()
    closed[1:] -= np.cumsum(np.where(leaping, steps - usual, 0.0))
    return closed, np.concatenate([[0], np.cumsum(counts).astype(np.int64)])


def with_gaps(values: np.ndarray, place: np.ndarray) -> np.ndarray:
    """Return samples at their places, NaN between."""
    spread = np.full(int(place[-1]) + 1, np.nan)
    spread[place] = values
    return spread
