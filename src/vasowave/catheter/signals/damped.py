"""Stretches without a pulse, as of a wedged catheter or a probe that came off, and the stretch that has one."""

from dataclasses import dataclass

import numpy as np

from vasowave.base.cures import stretch
from vasowave.base.findings import look_kind
from vasowave.catheter.signals.gaps import Span, free_between, gaps_in, longest_between
from vasowave.catheter.signals.plateaus import find_plateaus
from vasowave.catheter.signals.raw import MIN_DURATION_S, RawRecording


@dataclass(frozen=True)
class DampedRules:
    """When a stretch has no pulse.

    Attributes
    ----------
    window_beats : float
        Beats of the slowest heart looked for, in which the range of a signal is its pulse here.
    typical_quantile : float
        Of the pulses: what is usual, whatever happens in fewer windows.
    low_share : float
        Of the usual pulse, below which there is none. A wedged balloon leaves less than a third.
    min_share : float
        Of the recording: less of it is left to the rejection of beats.
    max_zero : float
        mmHg; a transducer that rests below it was open to air, which tells its zero and is no damped pulse.
    """

    window_beats: float = 2.0
    typical_quantile: float = 0.8
    low_share: float = 0.35
    min_share: float = 0.15
    max_zero: float = 4.0


RULES = DampedRules()
DAMPED = look_kind(
    "recording.damped",
    "from {low_start:.4g} to {low_end:.4g} s the pulse of the {name} is below {percent:.0f} % of its usual one (a "
    "wedged or damped catheter, a probe that came off?); {start:g} to {end:g} s were used. "
    "{remedy}",
    "Choose that stretch yourself, or another.",
    stretch("{start:g}", "{end:g}"),
)


def with_pulse(raw: RawRecording, slowest: float, rules: DampedRules = RULES) -> RawRecording:
    """Return the longest stretch in which both signals pulsate, and a finding; the recording itself where all does.

    Parameters
    ----------
    raw : RawRecording
    slowest : float
        Heart rate, beats/min.
    """
    window = max(3, round(rules.window_beats * 60.0 / slowest * raw.sampling_rate))
    if 6 * window > len(raw.pressure):
        return raw
    spans = {
        name: _without_pulse(getattr(raw, name), raw.sampling_rate, window, rules) for name in ("pressure", "flow")
    }
    zeros = [plateau for plateau in find_plateaus(raw) if abs(plateau.level) < rules.max_zero]
    spans["pressure"] = [
        span for span in spans["pressure"] if not any(_shared(span, raw.origin, *p[:2]) for p in zeros)
    ]
    low = [span for of_signal in spans.values() for span in of_signal]
    free = free_between(low, 0.0, raw.duration)
    share = 1.0 - sum(span.end - span.start for span in free) / raw.duration
    longest = longest_between(low, 0.0, raw.duration)
    if share < rules.min_share or longest.end - longest.start < MIN_DURATION_S:
        return raw
    name = max(spans, key=lambda signal: sum(span.end - span.start for span in spans[signal]))
    worst = max(spans[name], key=lambda span: span.end - span.start)
    start, end = raw.origin + longest.start, raw.origin + longest.end
    finding = DAMPED(
        low_start=raw.origin + worst.start, low_end=raw.origin + worst.end, name=name, percent=100 * rules.low_share,
        start=start, end=end,
    )  # fmt: skip
    return raw.alone(start, end, finding)


def _shared(span: Span, origin: float, start: float, end: float) -> bool:
    """Whether a stretch is mostly that from `start` to `end`, s since the start of the recording."""
    common = min(span.end + origin, end) - max(span.start + origin, start)
    return common > 0.5 * (span.end - span.start)


def _without_pulse(values: np.ndarray, rate: float, window: int, rules: DampedRules) -> list[Span]:
    """Return the stretches in which a signal has less than its usual pulse, widened by half a window."""
    from scipy.ndimage import maximum_filter1d, minimum_filter1d

    pulse = maximum_filter1d(values, window) - minimum_filter1d(values, window)
    usual = float(np.quantile(pulse, rules.typical_quantile))
    spans = gaps_in(np.where(pulse < rules.low_share * usual, np.nan, 1.0), rate)
    half = 0.5 * window / rate
    return [Span(max(span.start - half, 0.0), min(span.end + half, len(values) / rate)) for span in spans]
