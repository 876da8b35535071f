"""Whether an amplifier or a converter was at the end of its range: peaks that are cut off at one value."""

import numpy as np

from vasowave.findings import Finding, look_kind
from vasowave.recording.raw import RawRecording

_SHARE = 0.003  # of all samples that stand at the largest value
_PILED = 4.0  # times as many samples stand there as in the next step below; of a sine's peak 2.4 times
_NEAR, _FINEST = 0.05, 1e-4  # of the range: where the steps of a converter are looked for, and the finest of them
_RUN = 3  # samples one after the other at the top; fewer are those of a beat that was copied

SATURATED = look_kind(
    "recording.saturated",
    "{what}: {percent:.1f} % of the samples stand at its largest value, {value:.4g} {unit}: peaks are cut off there, "
    "by an amplifier or a converter at the end of its range",
    "Record it again with a wider range, or choose with `start` and `end` a stretch below it.",
)


def saturated(raw: RawRecording) -> list[Finding]:
    """Return a finding for each of pressure and flow whose peaks are cut off at one value."""
    found = []
    for what, unit, values in (("pressure", "mmHg", raw.pressure), ("flow", "ml/s", raw.flow)):
        share = _cut_off(values)
        if share:
            found.append(SATURATED(what=what, unit=unit, percent=100 * share, value=float(values.max())))
    return found


def _cut_off(values: np.ndarray) -> float:
    """Return the share of samples at the largest value; 0 if they are no more than a peak that is rounded has."""
    below = values.max() - values
    steps = np.diff(np.unique(below[below <= _NEAR * np.ptp(values)]))
    step = max(float(np.median(steps)) if len(steps) else 0.0, _FINEST * float(np.ptp(values)))
    top = below < 0.5 * step
    edges = np.flatnonzero(np.diff(np.concatenate([[0], top, [0]])))
    lasting = np.diff(edges.reshape(-1, 2), axis=1)  # of every run of samples at the top
    at_top, next_below = lasting[lasting >= _RUN].sum(), np.sum(~top & (below < 1.5 * step))
    share = float(at_top / len(values))
    return share if share > _SHARE and at_top > _PILED * next_below else 0.0
