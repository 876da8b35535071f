"""A continuous recording of pressure, flow and ECG, before its beats are averaged."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from vasowave.base.accessors import Accessor
from vasowave.base.errors import InputError
from vasowave.base.findings import Finding, note_kind, texts
from vasowave.base.notebook import card
from vasowave.base.sites import PULMONARY
from vasowave.catheter.signals.channels import Comment
from vasowave.catheter.signals.gaps import Span, free_between
from vasowave.pulse.cycle.averaged import EnsembleAverage

if TYPE_CHECKING:
    from matplotlib.axes import Axes

MIN_RATE = 20.0
"""Samples per second that no heart's beats can do with less of; how many a beat has is told when beats are found."""

MIN_DURATION_S = 1.0
"""A shorter recording than this (s) holds too few beats to average."""


ZEROED = note_kind("recording.zeroed", "the given zero of {zero:+.3g} mmHg was subtracted from the pressure")
FLOW_ZEROED = note_kind("recording.flow-zeroed", "the given zero of {zero:+.3g} ml/s was subtracted from the flow")
GAINS = note_kind("recording.gains", "the {what} was multiplied by the given gain of {gain:.4g}")
STRETCH = note_kind("recording.stretch", "{start:g} to {end:g} s of the recording")


def check_rate(source: str, rate: float) -> None:
    """Raise `InputError` for samples too few a second to hold beats, as those of a table of means."""
    if not (np.isfinite(rate) and rate >= MIN_RATE):
        raise InputError(
            f"{source}: {rate:g} samples/s; at least {MIN_RATE:g} are needed of the slowest heart (1000 or more are "
            "usual); export the waves at their full rate, not their means, or name the unit of their times"
        )


class SensorCalibration(NamedTuple):
    """What instruments read at none, and the factors of what they read.

    Attributes
    ----------
    zero, flow_zero : float
        What is subtracted from the pressure, mmHg, and from the flow, ml/s.
    gain, flow_gain : float
        What pressure and flow are then multiplied by; -1 turns the flow of a probe mounted backward.

    Examples
    --------
    >>> import vasowave as vw
    >>> vw.SensorCalibration(zero=2.0, gain=1.1).corrected("pressure", 22.0)
    22.0
    """

    zero: float = 0.0
    gain: float = 1.0
    flow_gain: float = 1.0
    flow_zero: float = 0.0

    def corrected(self, signal: str, values: Any) -> Any:
        """Return what was read of the ``"pressure"`` or the ``"flow"``, counted from its zero and times its gain."""
        zero, gain = (self.zero, self.gain) if signal == "pressure" else (self.flow_zero, self.flow_gain)
        return (values - zero) * gain

    def notes(self) -> list[Finding]:
        """Return what zeros and gains did to a recording; nothing where they are 0 and 1."""
        notes = [ZEROED(zero=self.zero)] if self.zero else []
        notes += [FLOW_ZEROED(zero=self.flow_zero)] if self.flow_zero else []
        gains = ("pressure", self.gain), ("flow", self.flow_gain)
        return [*notes, *(GAINS(what=signal, gain=gain) for signal, gain in gains if gain != 1.0)]


AS_READ = SensorCalibration()


@dataclass(frozen=True, eq=False)
class RawRecording:
    """Continuous pressure and flow, and the ECG if there is one, sampled together.

    Attributes
    ----------
    pressure : float array, shape (sample,)
        mmHg.
    flow : float array, shape (sample,)
        ml/s.
    sampling_rate : float
        Samples per second.
    ecg : float array, shape (sample,), or None
        mV (any scale if the file names no unit: only its shape is used).
    source : str
        Where the recording came from.
    notes : tuple of Finding
        What was noticed or assumed while it was read.
    comments : tuple of Comment
        Remarks of the experimenter; times are those of `time`, s.
    origin : float
        Time of the first sample, s: where a stretch was cut out of a longer recording.
    beside : tuple of RawRecording
        The other stretches of the same recording, without a gap in themselves. Their beats are not averaged, but they
        show the drift of the pressure since it was zeroed.
    site : str
        The artery, see `SiteName`.
    flow_delay_sd : float
        SD of the place of a gated flow beside the pressure, s.

    Raises
    ------
    InputError
        Signals of different length, a gap, less than a second, a rate that no heart's waves can do with.

    Examples
    --------
    >>> import vasowave as vw
    >>> import numpy as np
    >>> from vasowave.catheter.synthetic import synthetic_raw_recording
    >>> raw = synthetic_raw_recording(vw.virtual_mouse(), np.random.default_rng(1), duration=6.0).raw
    >>> raw.duration, raw.ecg is not None
    (6.0, True)
    """

    pressure: np.ndarray
    flow: np.ndarray
    sampling_rate: float
    ecg: np.ndarray | None = None
    source: str = "made in memory"
    notes: tuple[Finding, ...] = ()
    comments: tuple[Comment, ...] = ()
    origin: float = 0.0
    beside: tuple["RawRecording", ...] = ()
    site: str = PULMONARY
    flow_delay_sd: float = 0.0

    def __post_init__(self) -> None:
        """Check the values and freeze the arrays."""
        rate = float(self.sampling_rate)
        check_rate(self.source, rate)
        object.__setattr__(self, "sampling_rate", rate)
        for name in ("pressure", "flow", "ecg"):
            values = getattr(self, name)
            if values is not None:
                object.__setattr__(self, name, self._frozen(name, values))
        if self.duration < MIN_DURATION_S:
            raise InputError(
                f"{self.source}: {self.duration:.3g} s; at least {MIN_DURATION_S:g} s are needed to average beats"
            )

    def _frozen(self, name: str, values: object) -> np.ndarray:
        array = np.array(values, dtype=np.float64)
        if array.ndim != 1 or len(array) != len(self.pressure):
            raise InputError(f"{self.source}: {name} has {array.size} samples, pressure {len(self.pressure)}")
        gaps = np.flatnonzero(~np.isfinite(array))
        if len(gaps):
            raise InputError(f"{self.source}: {name} has a gap at {self.time[gaps[0]]:.4f} s; choose a stretch without")
        array.setflags(write=False)
        return array

    def __repr__(self) -> str:
        ecg = "with" if self.ecg is not None else "without"
        return f"RawRecording({self.duration:.4g} s at {self.sampling_rate:g} samples/s, {ecg} ECG, {self.source})"

    def _repr_html_(self) -> str:
        facts = {
            "length": f"{self.duration:.4g} s at {self.sampling_rate:g} samples/s",
            "pressure": f"{self.pressure.min():.1f} to {self.pressure.max():.1f} mmHg",
            "flow": f"{self.flow.min():.3g} to {self.flow.max():.3g} ml/s",
            "ECG": "yes" if self.ecg is not None else "no; beats are found in the pressure",
            "comments": f"{len(self.comments)}",
            "source": self.source,
        }
        return card("Continuous recording", facts, texts(self.notes))

    @property
    def time(self) -> np.ndarray:
        """Times of the samples since the start of the whole recording, s, shape (sample,)."""
        return self.origin + np.arange(len(self.pressure)) / self.sampling_rate

    @property
    def every_comment(self) -> tuple[Comment, ...]:
        """Comments of the stretch and of those beside it."""
        return tuple(comment for stretch in (self, *self.beside) for comment in stretch.comments)

    @property
    def duration(self) -> float:
        """Length, s."""
        return len(self.pressure) / self.sampling_rate

    @Accessor
    def plot(self, stretch: slice = slice(None), axes: "Sequence[Axes] | None" = None) -> np.ndarray:
        """Draw all signals between two times (s), ``raw.plot(slice(10, 12))``; returns one matplotlib axes a signal."""
        raise NotImplementedError

    @Accessor
    def average(self, beats: int | None = None, **settings: Any) -> EnsembleAverage:
        """Return the average of consecutive beats; the settings are those of `Averaging`, by name."""
        raise NotImplementedError

    def between(self, start: float, end: float) -> "RawRecording":
        """Return the stretch from `start` to `end` (s); its times stay those of the whole recording.

        What is before and after it still shows the drift of the pressure.

        Raises
        ------
        InputError
            If the stretch does not lie in the recording or is shorter than a second.
        """
        extent = Span(self.origin, self.origin + self.duration)
        if not extent.start - 1e-9 <= start < end <= extent.end + 1e-9:
            raise InputError(
                f"{self.source}: {start:g} to {end:g} s does not lie in the recording ({extent.start:.4g} to "
                f"{extent.end:.4g} s)"
            )
        spans = [span for span in free_between([Span(start, end)], *extent) if span.end - span.start >= MIN_DURATION_S]
        neighbours = (*self.beside, *(self._cut(*span) for span in spans))
        stretch = replace(self._cut(start, end), notes=(*self.notes, STRETCH(start=start, end=end)))
        return replace(stretch, beside=tuple(sorted(neighbours, key=lambda recording: recording.origin)))

    def alone(self, start: float, end: float, finding: Finding) -> "RawRecording":
        """Return the stretch from `start` to `end` (s) without what is beside it, which is no part of the same."""
        return replace(self._cut(start, end), notes=(*self.notes, finding))

    def calibrated(
        self, zero: float = 0.0, gain: float = 1.0, flow_gain: float = 1.0, flow_zero: float = 0.0
    ) -> "RawRecording":
        """Return the recording counted from what the instruments read at none (mmHg, ml/s), and times gains."""
        calibration = SensorCalibration(zero, gain, flow_gain, flow_zero)
        if calibration == AS_READ:
            return self
        neighbours = tuple(stretch.calibrated(*calibration) for stretch in self.beside)
        notes = (*self.notes, *calibration.notes())
        pressure, flow = calibration.corrected("pressure", self.pressure), calibration.corrected("flow", self.flow)
        return replace(self, pressure=pressure, flow=flow, beside=neighbours, notes=notes)

    def _cut(self, start: float, end: float) -> "RawRecording":
        """Return a stretch alone."""
        first, last = (round((time - self.origin) * self.sampling_rate) for time in (start, end))
        origin = self.origin + first / self.sampling_rate
        comments = tuple(c for c in self.comments if origin <= c.time <= self.origin + last / self.sampling_rate)
        return replace(
            self,
            pressure=self.pressure[first:last],
            flow=self.flow[first:last],
            ecg=None if self.ecg is None else self.ecg[first:last],
            comments=comments,
            origin=origin,
            beside=(),
        )
