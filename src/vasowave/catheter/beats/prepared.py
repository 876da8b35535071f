"""How continuous recordings become one cycle (every setting), and what of it no decision on a beat changes.

What is prepared is kept, so that such a decision costs little.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated, Literal

import numpy as np
from annotated_types import Ge, Gt, Le

from vasowave.base.errors import InputError
from vasowave.base.findings import Finding
from vasowave.base.settings import Range, settings_class
from vasowave.base.species import SPECIES
from vasowave.catheter.beats.beats import Beats, find_beats
from vasowave.catheter.beats.cuts import Cuts, beats_beside, cut_again, cut_all, merged
from vasowave.catheter.beats.edits import BeatEdit, moved
from vasowave.catheter.beats.rejection import fewest, misshapen_beats
from vasowave.catheter.signals.damped import with_pulse
from vasowave.catheter.signals.hum import hum_findings
from vasowave.catheter.signals.noise_spectrum import noise_findings
from vasowave.catheter.signals.plateaus import Plateau, find_plateaus
from vasowave.catheter.signals.raw import RawRecording
from vasowave.catheter.signals.spikes import despiked
from vasowave.pulse.cycle.averaged import Rejection
from vasowave.pulse.cycle.cycle import MAX_SAMPLES, MIN_SAMPLES

MIN_BEAT_SAMPLES = 16
"""Samples of a beat, which carry seven harmonics."""


@settings_class
class Averaging:
    """From continuous recordings to one cycle. Only for animals of kind 'raw'.

    Examples
    --------
    >>> import vasowave as vw
    >>> vw.Averaging(beats=12, drift="warn").samples
    256
    """

    beats: Annotated[int, Ge(2)] = 20
    """Number of beats to average, 20 in the paper."""
    samples: Annotated[int, Ge(MIN_SAMPLES), Le(MAX_SAMPLES)] = 256
    """Samples of the cycle."""
    harmonics: Annotated[int, Ge(1)] | None = 20
    """Harmonics of the averaged cycle that are kept; None keeps all. What is above 20 is noise, which would push the
    largest and the smallest value (sPAP, dPAP) apart."""
    fiducial: Literal["ecg", "pressure"] | None = None
    """R wave, or foot of the pressure; by default the ECG where there is one that beats."""
    heart_rates: Range | None = None
    """Slowest and fastest heart rate to look for, beats/min; by default 250 to 900, in a study of rats 150 to 650."""
    length_tolerance: Annotated[float, Gt(0), Le(1)] = 0.1
    """A beat whose length differs by a larger fraction from the median of its neighbours is rejected."""
    least_correlation: Annotated[float, Ge(-1), Le(1)] = 0.9
    """A beat whose pressure or flow correlates less with the median beat is rejected."""
    reject_ventilation: bool = True
    """Whether a beat whose mean pressure stands off end-expiration is rejected, where the pressure rests at one end of
    the breath; else, and if false, whole breaths are averaged."""
    correct_delay: bool = False
    """Whether the flow is advanced by the p-q delay that the feet of both show. They tell it within a few percent of
    the cycle, which moves the stiffness by much; a delay that was measured is better."""
    drift: Literal["remove", "warn"] = "remove"
    """Whether the drift of the transducer and its steps are subtracted, or only told. A trend that comes with a change
    of pulse or flow may be the animal's own and is never subtracted. A drift that stays in counts as an error of the
    mean pressure, as large as it is in the averaged beats."""
    zero_time: Annotated[float, Ge(0)] | None = None
    """The instant at which the transducer's zero is taken to be right, s since the start of the recording: the start by
    default, since catheters are zeroed before they record. Without it, first beats (2 s or eight) whose level lies
    apart from that of all others are left out."""


@dataclass(frozen=True, eq=False)
class Prepared:
    """The beats of a recording, cut and compared with each other.

    Attributes
    ----------
    raw : RawRecording
    options : Averaging
    heartbeats : Beats
        As found.
    moves : tuple of BeatEdit
        Beginnings that a person moved.
    lost : tuple of Finding
        Which of them meet no beat.
    cut : Cuts
        All beats from their beginnings as moved.
    shapes : pair of float arrays, shape (sample,)
        The median beat of pressure, mmHg, and flow, ml/s.
    reasons : tuple of Finding or None
        Why the length or the shape of a beat is not that of the others.
    means : pair of float arrays, shape (beat,)
        Mean pressure, mmHg, and mean flow, ml/s, of every beat.
    all_cuts : Cuts
        The beats with those beside the stretch, in order; `cut` itself where there are none.
    in_cut : bool array, shape (beat of `all_cuts`,)
        Which of them are those of `cut`.
    plateaus : tuple of Plateau
    signs : tuple of Finding
        What the signals show of instruments.
    """

    raw: RawRecording
    options: Averaging
    heartbeats: Beats
    moves: tuple[BeatEdit, ...]
    lost: tuple[Finding, ...]
    cut: Cuts
    shapes: tuple[np.ndarray, np.ndarray]
    reasons: tuple[Rejection, ...]
    means: tuple[np.ndarray, np.ndarray]
    all_cuts: Cuts
    in_cut: np.ndarray
    plateaus: tuple[Plateau, ...]
    signs: tuple[Finding, ...]

    def with_moves(self, edits: Sequence[BeatEdit]) -> "Prepared":
        """Return the same for other moves among `edits`; beats whose ends stay are not cut again."""
        moves = tuple(edit for edit in edits if edit.to is not None)
        if moves == self.moves:
            return self
        times, lost = moved(self.heartbeats.times, moves)
        cut = cut_again(self.raw, self.cut, times)
        return _compared(self.raw, self.options, self.heartbeats, moves, lost, cut, (self.plateaus, self.signs))


def prepare(raw: RawRecording, options: Averaging, edits: Sequence[BeatEdit] = ()) -> Prepared:
    """Return the beats of a recording, begun where `edits` move them; raises as `average_beats`."""
    lasts = max(stretch.origin + stretch.duration for stretch in (raw, *raw.beside))
    if options.zero_time is not None and options.zero_time > lasts:
        raise InputError(f"zero_time={options.zero_time:g} s does not lie in the recording (0 to {lasts:.4g} s)")
    raw, spiked = despiked(with_pulse(raw, _rates(options)[0]))
    heartbeats = find_beats(raw, options.fiducial, _rates(options))
    if len(heartbeats.times) - 1 < fewest(options.beats):
        raise InputError(
            f"{raw.source}: {len(heartbeats.times) - 1} whole beats found, {options.beats} wanted; record longer or "
            "average fewer"
        )
    _check_rate(raw, heartbeats)
    cut = cut_all(raw, heartbeats.times, options.samples)
    signals = (raw.pressure, raw.flow, raw.sampling_rate)
    signs = (*spiked, *hum_findings(*signals), *noise_findings(*signals, heartbeats.times - raw.origin))
    observations = (find_plateaus(raw), signs)
    return _compared(raw, options, heartbeats, (), [], cut, observations).with_moves(edits)


def _check_rate(raw: RawRecording, heartbeats: Beats) -> None:
    """Refuse beats of too few samples for the harmonics of a wave."""
    count = raw.sampling_rate * 60.0 / heartbeats.heart_rate
    if count < MIN_BEAT_SAMPLES:
        raise InputError(
            f"{raw.source}: {raw.sampling_rate:g} samples/s are {count:.3g} a beat at {heartbeats.heart_rate:.0f} "
            f"beats/min; at least {MIN_BEAT_SAMPLES} are needed; export at the full rate"
        )


def _rates(options: Averaging) -> tuple[float, float]:
    return options.heart_rates or SPECIES["mouse"].heart_rates


def _compared(
    raw: RawRecording, options: Averaging, heartbeats: Beats, moves: tuple[BeatEdit, ...], lost: Sequence[Finding],
    cut: Cuts, observations: tuple[tuple[Plateau, ...], tuple[Finding, ...]],
) -> Prepared:  # fmt: skip
    limits = (options.length_tolerance, options.least_correlation)
    shapes = (np.median(cut.pressure, axis=0), np.median(cut.flow, axis=0))
    reasons = misshapen_beats(cut.ends - cut.starts, cut.pressure, cut.flow, *limits, shapes)
    all_cuts, in_cut = merged(cut, beats_beside(raw, shapes, heartbeats.fiducial, _rates(options), *limits))
    means = (cut.pressure.mean(axis=1), cut.flow.mean(axis=1))
    return Prepared(
        raw, options, heartbeats, moves, tuple(lost), cut, shapes, tuple(reasons), means, all_cuts, in_cut,
        *observations,
    )  # fmt: skip
