"""Whether the animal stays the same while it is recorded: pulse and flow of its beats from the first to the last."""

import numpy as np

from vasowave.findings import Finding, look_kind, note_kind

_CHANGES = 0.25
"""A pulse or a mean flow that changes by more than this share from one quarter of the beats to another is told."""

_APART = 0.05
"""Averaged beats whose pulse or mean flow is off that of all beats by more than this share are noted."""

_FEWEST = 20  # beats: five in a quarter
_SURE = 4.0  # standard errors

UNSTEADY = look_kind(
    "recording.unsteady",
    "{what} changes by {percent:+.0f} % from quarter {earlier} of the beats to quarter {later}; the average is that of "
    "{start:.3g} to {end:.3g} s",
    "Choose with `start` and `end` the stretch that stands for the animal; where the probe lost its contact, leave the "
    "rest out.",
)
APART = note_kind(
    "recording.average-apart", "{what} of the averaged beats is {percent:+.0f} % off that of all beats of the stretch"
)


def unsteady(pressure: np.ndarray, flow: np.ndarray, used: np.ndarray, start: float, end: float) -> list[Finding]:
    """Return findings where pulse pressure or mean flow change in the course of a recording.

    Parameters
    ----------
    pressure, flow : float array, shape (beat, sample)
        Beats of usual length and shape in the order of time, those of inspiration among them, mmHg and ml/s.
    used : bool array, shape (beat,)
        Which are averaged.
    start, end
        Between which instants they are, s.
    """
    courses = {"the pulse pressure": np.ptp(pressure, axis=1), "the mean flow": flow.mean(axis=1)}
    found = []
    for what, values in courses.items():
        if len(values) < _FEWEST or np.median(values) <= 0:
            continue
        change, earlier, later = _largest_change(values)
        if change:
            found.append(UNSTEADY(what=what, percent=100 * change, earlier=earlier, later=later, start=start, end=end))
        off = float(np.mean(values[used]) / np.mean(values) - 1.0) if used.any() else 0.0  # all kept by hand
        if abs(off) > _APART:
            found.append(APART(what=what, percent=100 * off))
    return found


def _largest_change(values: np.ndarray) -> tuple[float, int, int]:
    """Return the largest change of the median from a quarter to a later one that is told, and their numbers; 0 if none.

    Of a fall and the rise that takes it back, which are as large of the higher level, that is the fall.
    """
    quarters = np.array_split(values, 4)
    medians = np.array([np.median(one) for one in quarters])
    errors = np.array([one.std() / np.sqrt(len(one)) for one in quarters])
    changes = [
        (medians[j] / medians[i] - 1.0, i + 1, j + 1)
        for i in range(4) for j in range(i + 1, 4)
        if medians[i] > 0 and abs(medians[j] - medians[i]) > _SURE * np.hypot(errors[i], errors[j])
    ]  # fmt: skip
    told = [one for one in changes if abs(one[0]) > _CHANGES]
    return max(told, key=lambda one: round(abs(one[0]) / max(1.0, 1.0 + one[0]), 1), default=(0.0, 1, 4))
