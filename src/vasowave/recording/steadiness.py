"""Whether the animal stays the same while it is recorded: pulse and flow of its beats from the first to the last."""

import numpy as np

from vasowave.findings import Finding, look_kind

_CHANGES = 0.2
"""A pulse or a mean flow that changes by more than this share, between a quarter of the beats and another, is told."""

_FEWEST = 20  # beats: five in a quarter
_SURE = 4.0  # standard errors

UNSTEADY = look_kind(
    "recording.unsteady",
    "{what} changes by {percent:+.0f} % from the first quarter of the beats to the last; the average "
    "is that of {start:.3g} to {end:.3g} s",
    "Choose with `start` and `end` the stretch that stands for the animal; "
    "where the probe lost its contact, leave the rest out.",
)


def unsteady(pressure: np.ndarray, flow: np.ndarray, start: float, end: float) -> list[Finding]:
    """Return a finding for the pulse pressure and for the mean flow, where it changes in the course of a recording.

    Parameters
    ----------
    pressure, flow : float array, shape (beat, sample)
        The good beats in the order of time, mmHg and ml/s.
    start, end
        Between which instants beats are averaged, s.
    """
    courses = {"the pulse pressure": np.ptp(pressure, axis=1), "the mean flow": flow.mean(axis=1)}
    changes = {what: _change(values) for what, values in courses.items()}
    return [
        UNSTEADY(what=what, percent=100 * change, start=start, end=end)
        for what, change in changes.items() if abs(change) > _CHANGES
    ]  # fmt: skip


def _change(values: np.ndarray) -> float:
    """Return by what share of its first quarter's median a value changes until the last, 0 where that is not sure."""
    quarter = len(values) // 4
    if len(values) < _FEWEST or np.median(values[:quarter]) <= 0:
        return 0.0
    first, last = values[:quarter], values[-quarter:]
    change = np.median(last) - np.median(first)
    error = np.hypot(first.std(), last.std()) / np.sqrt(quarter)
    return float(change / np.median(first)) if abs(change) > _SURE * error else 0.0
