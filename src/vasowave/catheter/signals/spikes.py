"""Spikes, as of electricity: what leaves a signal and is back within a few samples, faster than the animal ever is."""

from dataclasses import replace

import numpy as np

from vasowave.base.cures import STRETCH, Visit
from vasowave.base.findings import Finding, look_kind, note_kind
from vasowave.catheter.signals.raw import RawRecording

_MAX_SPIKE_S = 0.003  # duration of a spike
_MIN_STEEPNESS = 6.0
"""Height of a spike in steps that nine of ten do not exceed: without spikes the largest is 2.6, in noise, too."""
_MIN_HEIGHT_RANGE_SHARE = 0.25  # of the range in which nine of ten samples lie
_MAX_REPLACED_SHARE = 0.01  # of the samples; with more of them replaced it asks for a look

_TEXT = "{count} spikes in the {what}, {lasts:.3g} ms in all, were replaced by straight lines"
SPIKES = note_kind("recording.spikes", _TEXT)
MANY_SPIKES = look_kind(
    "recording.many-spikes",
    f"{_TEXT}: {{percent:.2g}} % of the samples",
    "Look at the signal, ground the amplifier, or choose a stretch with fewer.",
    Visit("recording"),
    STRETCH,
)


def despiked(raw: RawRecording) -> tuple[RawRecording, list[Finding]]:
    """Return a recording without the spikes of pressure and flow, and how many there were; itself if there are none."""
    findings, clean = [], {}
    for signal in ("pressure", "flow"):
        values: np.ndarray = getattr(raw, signal)
        bad = spikes(values, raw.sampling_rate)
        if not bad.any():
            continue
        good = np.flatnonzero(~bad)
        clean[signal] = np.interp(np.arange(len(values)), good, values[good])
        kind, percent = (MANY_SPIKES if bad.mean() > _MAX_REPLACED_SHARE else SPIKES), 100 * float(bad.mean())
        count = int(bad[0]) + int(np.sum(bad[1:] & ~bad[:-1]))
        findings.append(
            kind(what=signal, count=count, lasts=1e3 * float(bad.sum()) / raw.sampling_rate, percent=percent)
        )
    neighbours = tuple(despiked(stretch)[0] for stretch in raw.beside)
    changed = clean or any(new is not old for new, old in zip(neighbours, raw.beside, strict=True))
    return (replace(raw, **clean, beside=neighbours) if changed else raw), findings


def spikes(values: np.ndarray, sampling_rate: float) -> np.ndarray:
    """Return which samples of a signal are spikes, shape (sample,).

    A spike stands off the median around it, which an upstroke, a step and a notch that lasts longer do not.
    """
    from scipy.ndimage import median_filter

    steps = np.abs(np.diff(values))
    usual = float(np.ptp(np.quantile(values, (0.05, 0.95))))
    threshold = max(_MIN_STEEPNESS * float(np.quantile(steps, 0.9)), _MIN_HEIGHT_RANGE_SHARE * usual)
    if not np.any(steps > threshold):
        return np.zeros(len(values), dtype=bool)
    around = 2 * max(1, round(_MAX_SPIKE_S * sampling_rate)) + 1
    return np.abs(values - median_filter(values, around, mode="nearest")) > threshold
