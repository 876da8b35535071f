"""The trend of the diastolic level over a recording, its steps, and what counts as one."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np


@dataclass(frozen=True)
class BaselineRules:
    """What counts as a drift, a step, a beginning apart.

    Attributes
    ----------
    min_size : float
        Baselines that move less than this, mmHg, are followed without a warning.
    sure : float
        A drift, a step, a change of pulse or what the first beats lie apart counts from this many standard errors on.
    low_share : float
        The part of the mean beat, its lowest, that is taken for the diastolic level.
    knot_seconds, knot_beats : float
        Distance of the knots of the trend, the longer of the two: about three breaths of a ventilated animal.
    reach : float
        A trend is carried on to the zero over this share of its own length, where no beats are.
    side_beats : int
        Beats on either side of a step by which it is judged.
    gap : float
        A window of beats that lasts this many times as long as usual has a gap in it.
    first_seconds : float
        The first so many s of a recording, or `side_beats`, do not say against all others where the zero was right.
    beyond : float
        The first beats lie apart from this many times what the first after any later beginning do.
    later : float
        Eight later beginnings: evenly from the end of the first beats to this part of all good ones.
    stands_out : float
        A step is this many times the usual height of what the same windows find elsewhere.
    max_steps : int
        Of the level in one recording.
    min_beats : int
        With fewer good beats no trend is followed.
    own_change : float
        The animal changes itself if pulse or flow changes by this fraction while the level moves.
    """

    min_size: float = 0.3
    sure: float = 4.0
    low_share: float = 0.15
    knot_seconds: float = 2.0
    knot_beats: float = 18.0
    reach: float = 0.25
    side_beats: int = 8
    gap: float = 1.5
    first_seconds: float = 2.0
    beyond: float = 1.5
    later: float = 0.4
    stands_out: float = 7.0
    max_steps: int = 8
    min_beats: int = 12
    own_change: float = 0.05


RULES = BaselineRules()


@dataclass(frozen=True)
class LevelStep:
    """A sudden shift of the level, complete within a beat.

    Attributes
    ----------
    time : float
        s since the start of the recording.
    height : float
        mmHg.
    """

    time: float
    height: float


@dataclass(frozen=True)
class Settling:
    """A level that begins apart from that of all beats that follow.

    Attributes
    ----------
    until : float
        The first beat that follows, s since the start of the recording.
    height : float
        How far apart the first beat lies, mmHg: small where beats after it are those that lie apart, by a flush.
    """

    until: float
    height: float

    @property
    def error(self) -> float:
        """What is unknown of the zero, mmHg: the first beat or all others show where it was right."""
        return abs(self.height) if abs(self.height) >= RULES.min_size else 0.0


@dataclass(frozen=True, eq=False)
class Baseline:
    """The trend of the diastolic level over a recording.

    Attributes
    ----------
    time : float array, shape (beat,)
        Middle of the diastolic part of the beats, s since the start of the recording; beats beside the stretch that is
        averaged are among them.
    level : float array, shape (beat,)
        Diastolic level of every beat, mmHg: the mean of the samples at which the median beat is lowest.
    trend : float array, shape (beat,)
        Drift, mmHg, steps included: 0 at the instant at which the zero of the transducer is taken to be right.
    steps : tuple of LevelStep
        Sudden shifts, in order.
    error : float
        Standard error of the drift from the zero to the end farthest from it, mmHg.
    zero : float
        The instant at which the zero is taken to be right, s: the one asked for, or the beat nearest to it if no beat
        is near.
    own : str
        Why the trend may be the animal's own, empty if pulse and flow stayed what they were.
    elsewhere : str
        Why only the stretch that is averaged was judged: what changes with the level beside it.
    removed : bool
        Whether the trend was subtracted before the beats were averaged.
    settling : Settling, optional
        How the first beats lie apart, if they do.
    persistence : float
        By how much errors of means of neighboring beats are larger than if each level knew nothing of the one before.
    errors : float array, shape (beat,), optional
        Standard error of the drift at every beat, mmHg.
    """

    time: np.ndarray
    level: np.ndarray
    trend: np.ndarray
    steps: tuple[LevelStep, ...]
    error: float
    zero: float
    own: str = ""
    elsewhere: str = ""
    removed: bool = False
    settling: Settling | None = None
    persistence: float = 1.0
    errors: np.ndarray | None = None

    @property
    def size(self) -> float:
        """How far the level moved: the largest drift from the zero, with its sign, mmHg."""
        return float(self.trend[np.argmax(np.abs(self.trend))])

    @property
    def sure(self) -> bool:
        """Whether the level moved by more than its scatter explains."""
        return bool(self.steps) or abs(self.size) > RULES.sure * self.error

    @property
    def alarming(self) -> bool:
        """Whether it moved so far that somebody should look at it."""
        return self.sure and abs(self.size) >= RULES.min_size

    @cached_property
    def _smooth(self) -> np.ndarray:
        """The trend without its steps, mmHg, shape (beat,)."""
        return self.trend - sum((s.height * (self.time >= s.time) for s in self.steps), np.zeros(1))

    def drift_at(self, time: np.ndarray) -> np.ndarray:
        """Return the drift at any times, s, in mmHg."""
        drift = np.interp(time, self.time, self._smooth)
        for step in self.steps:
            drift = drift + step.height * (np.asarray(time) >= step.time)
        return drift

    def mean_within(self, starts: np.ndarray, ends: np.ndarray, samples: int) -> np.ndarray:
        """Return the mean of the drift at so many even instants of each beat, both ends included, mmHg, shape (beat,).

        Within a beat the drift bends once, at the beat's own instant; its two lines are summed in closed form.
        """
        row = np.searchsorted(self.time, starts)
        slopes = np.concatenate([[0.0], np.diff(self._smooth) / np.diff(self.time), [0.0]])
        step, since = (ends - starts) / (samples - 1), starts - self.time[row]
        before = np.clip(np.ceil(-since / step), 0, samples)
        first, total = (count * since + step * count * (count - 1) / 2 for count in (before, samples))
        drift = self._smooth[row] + (slopes[row] * first + slopes[row + 1] * (total - first)) / samples
        for jump in self.steps:
            after = samples - np.clip(np.ceil((jump.time - starts) / step), 0, samples)
            drift = drift + jump.height * after / samples
        return drift

    def mean_drift(self, first: float, last: float) -> float:
        """Return the mean drift, mmHg, between two instants, s."""
        return float(np.mean(self.drift_at(np.linspace(first, last, 50))))

    def error_left(self, first: float, last: float) -> float:
        """Return how far off the baseline leaves the mean of the beats from first to last, mmHg.

        The size of a drift that stays in, since it may be the transducer's or the animal's, the error of one that was
        removed or not seen, and what the first beats lie apart, since they or the others show where the zero was right.
        """
        unseen = 0.0 if self.errors is None else float(np.mean(np.interp([first, last], self.time, self.errors)))
        stays = self.mean_drift(first, last) if self.sure and not self.removed else unseen
        return float(np.hypot(stays, self.settling.error if self.settling else 0.0))
