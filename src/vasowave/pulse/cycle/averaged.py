"""An averaged cycle with the beats that it came from."""

import os
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from vasowave.base.accessors import Accessor
from vasowave.base.errors import InputError
from vasowave.base.findings import Finding
from vasowave.pulse.cycle.cycle import Recording
from vasowave.pulse.cycle.trend import Baseline

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Rejection = Finding | None
"""Why a beat may not be averaged; None for a good one."""


class Beat(NamedTuple):
    """One detected beat.

    Attributes
    ----------
    start, end : float
        s since the start of the recording.
    averaged : bool
        Whether it is part of the average.
    rejected : Finding or None
        Why it may not be averaged; None for a good beat.
    """

    start: float
    end: float
    averaged: bool
    rejected: Rejection = None


@dataclass(frozen=True, eq=False)
class EnsembleAverage:
    """The average of consecutive beats.

    Attributes
    ----------
    recording : Recording
        The averaged cycle; its notes say which beats it came from.
    pressure_sd, flow_sd : float array, shape (sample,)
        Standard deviation of the averaged beats around the cycle, mmHg and ml/s.
    beats : tuple of Beat
        Every detected beat, in order.
    fiducial : str
        ``ecg`` or ``pressure``: what the beats were aligned by.
    delay : float
        p-q delay: by how much the foot of the flow follows the foot of the pressure, s.
    delay_corrected : bool
        Whether the flow was advanced by `delay`.
    baseline : Baseline
        The diastolic level of every beat of the whole recording, its drift, and whether that was removed.
    beat_pressure, beat_flow : float array, shape (averaged beat, sample + 1)
        The beats that were averaged, each brought to the mean length, its end included, mmHg and ml/s.

    Examples
    --------
    >>> import vasowave as vw
    >>> import numpy as np
    >>> from vasowave.catheter.synthetic import synthetic_raw_recording
    >>> raw = synthetic_raw_recording(vw.virtual_mouse(), np.random.default_rng(1), duration=6.0).raw
    >>> average = vw.average_beats(raw, 10)
    >>> sum(beat.averaged for beat in average.beats)
    10
    """

    recording: Recording
    pressure_sd: np.ndarray
    flow_sd: np.ndarray
    beats: tuple[Beat, ...]
    fiducial: str
    delay: float
    delay_corrected: bool
    baseline: Baseline
    beat_pressure: np.ndarray
    beat_flow: np.ndarray

    @property
    def findings(self) -> tuple[Finding, ...]:
        """What was noticed of the recording and its beats."""
        return self.recording.notes

    @Accessor
    def plot(self, axes: "Sequence[Axes] | None" = None) -> np.ndarray:
        """Draw the averaged cycle with a band of one SD of the beats; returns two matplotlib axes."""
        raise NotImplementedError

    def __repr__(self) -> str:
        used = sum(beat.averaged for beat in self.beats)
        lost = sum(bool(beat.rejected) for beat in self.beats)
        return f"EnsembleAverage({used} of {len(self.beats)} beats, {lost} rejected, {self.recording!r})"


def one_cycle(recording: object) -> Recording:
    """Return the cycle of a recording or of an average; raise `InputError` for anything else, with what to do."""
    if isinstance(recording, Recording):
        return recording
    if isinstance(recording, EnsembleAverage):
        return recording.recording
    if hasattr(recording, "average"):
        raise InputError("a continuous recording was given where one cycle is needed; average its beats: raw.average()")
    if isinstance(recording, str | os.PathLike):
        raise InputError(
            f"'{recording}' is the name of a file; read it first: vasowave.read_recording (a cycle) or "
            "vasowave.read_raw_recording(...).average()"
        )
    raise InputError(f"{type(recording).__name__} was given where a Recording is needed")
