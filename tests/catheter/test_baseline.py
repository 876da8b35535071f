"""The drift of a pressure: found beside breaths, removed or told, never taken from an animal that changes itself."""

import warnings
from dataclasses import fields, replace

import numpy as np
import pytest

from vasowave.base import InputError, Severity, VasowaveWarning
from vasowave.catheter import Disturbances, average_beats, synthetic_raw_recording
from vasowave.catheter.beats import cause
from vasowave.catheter.signals import Plateau, RawRecording, plateau_findings
from vasowave.pulse.cycle import Recording

PHASE = np.arange(512) / 512
SYSTOLE = np.clip((PHASE - 0.08) / 0.45, 0, 1)
SHAPE = np.sin(np.pi * np.clip((PHASE - 0.08) / 0.8, 0, 1)) ** 2 * np.exp(-1.2 * PHASE)
FLOW = 0.55 * np.sin(np.pi * SYSTOLE) ** 2 * (1 - 0.4 * SYSTOLE)
NONE = Disturbances(**{field.name: 0.0 for field in fields(Disturbances)})
USUAL = replace(Disturbances(), pressure_drift=0.0)


def recorded(seed, baseline=None, mean=15.43, duration=25.0, disturbances=USUAL, **settings) -> RawRecording:
    pressure = 16 * SHAPE
    cycle = Recording(pressure + mean - pressure.mean(), FLOW, 0.11)
    rng = np.random.default_rng(seed)
    asked = {"duration": duration, "heart_rate": 540.0, "disturbances": disturbances} | settings
    return synthetic_raw_recording(cycle, rng, baseline=baseline, **asked).raw


def average(raw, **options):
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", VasowaveWarning)
        made = average_beats(raw, **options)
    return made, [str(one.message) for one in caught]


@pytest.mark.parametrize(("drift", "lasts", "mean"), [(-4.0, 20.0, 29.39), (6.0, 25.0, 15.43)])
def test_the_mean_pressure_is_that_at_the_zero_and_the_drift_is_said(drift, lasts, mean):
    raw = recorded(1, lambda t: drift * t / lasts, mean, lasts)
    made, said = average(raw)
    assert made.recording.mean_pressure == pytest.approx(mean, abs=0.1)
    assert made.baseline.size == pytest.approx(drift, abs=0.15)
    assert made.baseline.removed
    assert not any(cause(beat.rejected) == "correlation" for beat in made.beats if beat.rejected)
    assert len(said) == 1
    assert f"drifts by {drift:+.0f}"[:13] in said[0]
    assert "removed" in said[0]
    assert any(str(note) in said[0] for note in made.recording.notes)


def test_a_drift_that_is_only_told_stays_in_the_average_with_its_size_there():
    raw = recorded(2, lambda t: 0.24 * t)
    made, said = average(raw, drift="warn")
    used = [beat.start for beat in made.beats if beat.averaged]
    here = 0.24 * np.mean(used)
    assert made.recording.mean_pressure == pytest.approx(15.43 + here, abs=0.15)
    assert not made.baseline.removed
    assert "left in; it counts as an error of the mean pressure" in said[0]
    assert made.recording.pressure_error[0] == pytest.approx(here, abs=0.15)
    assert average(raw)[0].recording.pressure_error[0] < 0.1  # once it is removed
    assert f"({made.baseline.drift_at(np.array(used)).mean():+.1f}"[:4] in said[0]


def test_the_zero_may_be_right_at_the_end():
    raw = recorded(3, lambda t: 3.0 * (t - 25.0) / 25.0)
    made, _ = average(raw, zero_time=25.0)
    assert made.recording.mean_pressure == pytest.approx(15.43, abs=0.1)
    assert made.baseline.size == pytest.approx(-3.0, abs=0.15)


def test_breaths_alone_are_no_drift():
    heavy = replace(USUAL, ventilation_pressure=3.0)
    for seed in range(2):
        made, said = average(recorded(seed, disturbances=heavy, duration=12.0))
        assert said == []
        assert abs(made.baseline.size) < 0.3


def test_a_step_is_told_with_its_time_and_height_and_the_beats_at_it_are_not_averaged():
    raw = recorded(4, lambda t: np.where(t < 12.34, 0.0, 2.5))
    made, said = average(raw)
    (step,) = made.baseline.steps
    assert step.time == pytest.approx(12.34, abs=0.12)
    assert step.height == pytest.approx(2.5, abs=0.15)
    assert any("a step of +2.5 mmHg at 12.3" in one for one in said)
    at = next(beat for beat in made.beats if beat.start <= 12.34 < beat.end)
    assert at.rejected
    assert made.recording.mean_pressure == pytest.approx(15.43, abs=0.1)


def test_a_pressure_that_the_animal_raises_itself_is_left_as_it_is():
    raw = recorded(5)
    rise = 1.0 + 0.3 / (1.0 + np.exp(-(raw.time - 12.0)))  # within some four seconds, pulse and flow with it
    changed = replace(raw, pressure=raw.pressure * rise, flow=raw.flow * rise)
    made, said = average(changed)
    assert not made.baseline.removed
    assert "the pulse changes by +" in said[0]
    assert "the animal itself changes" in said[0]
    used = np.array([beat.start for beat in made.beats if beat.averaged])
    there = float(np.mean(np.interp(used, raw.time, rise)))
    assert made.recording.mean_pressure == pytest.approx(15.43 * there, rel=0.02)


def test_without_an_ecg_the_drift_is_found_as_well_and_the_fiducial_said():
    made, _ = average(recorded(6, lambda t: -0.1 * t, ecg=False))
    assert made.fiducial == "pressure"
    assert made.recording.mean_pressure == pytest.approx(15.43, abs=0.1)
    assert any("aligned by the foot of the pressure" in str(note) for note in made.recording.notes)


def test_an_ecg_that_does_not_beat_gives_way_to_the_pressure_aloud():
    raw = recorded(7)
    dead = replace(raw, ecg=np.random.default_rng(1).standard_normal(len(raw.pressure)))
    made, said = average(dead)
    assert made.fiducial == "pressure"
    assert any("the ECG does not beat" in one for one in said)


def test_a_zero_shown_at_the_start_is_read_and_told():
    raw = recorded(8)
    pressure = raw.pressure.copy()
    noise = np.random.default_rng(1).normal(0, 0.05, 4000)
    pressure[:4000] = 0.8 + noise
    made, said = average(replace(raw, pressure=pressure))
    assert any("the transducer was open to air from 0 to 2 s and read +0.8" in one for one in said)
    assert made.recording.mean_pressure == pytest.approx(15.43, abs=0.15)


@pytest.mark.parametrize(
    ("level", "said"), [(0.3, "open to air"), (-0.31, "zero offset"), (5.0, "calibration plateau")]
)
def test_a_plateau_is_air_to_5_mmHg_and_an_offset_beyond_a_third(level, said):
    (found,) = plateau_findings((Plateau(0.0, 1.0, level),))
    assert found.severity is (Severity.LOOK if said == "zero offset" else Severity.NOTE)
    assert said in str(found)
    assert ("not corrected" in str(found)) == (said == "zero offset")


def test_calibration_plateaus_are_told_with_their_levels():
    raw = recorded(9)
    pressure = raw.pressure.copy()
    rng = np.random.default_rng(2)
    for first, level in ((0, 0.0), (2000, 20.0), (4000, 40.0)):
        pressure[first : first + 2000] = level + rng.normal(0, 0.05, 2000)
    made, _ = average(replace(raw, pressure=pressure))
    (said,) = [str(note) for note in made.recording.notes if note.code == "recording.calibration-plateaus"]
    assert "20 mmHg (1 to 2 s), 40 mmHg (2 to 3 s)" in said
    assert any("open to air from 0 to 1 s and read" in str(note) for note in made.recording.notes)


def test_arguments_of_the_baseline_are_checked():
    raw = recorded(10)
    with pytest.raises(InputError, match="drift: 'no' is not known; choose from: remove, warn"):
        average_beats(raw, drift="no")
    with pytest.raises(InputError, match="zero_time=99 s does not lie"):
        average_beats(raw, zero_time=99)


def stretch(raw, *spans):
    """Return the recording as a file with gaps gives it: the first of the spans, the others beside it."""
    parts = [replace(raw.between(*span), beside=()) for span in spans]
    return replace(parts[0], beside=tuple(parts[1:]))


@pytest.mark.parametrize(
    ("drift", "lasts", "spans"),
    [
        (4.0, 40.0, [(11.8, 40.0), (0.0, 11.0)]),
        (6.0, 60.0, [(25.05, 60.0), (0.0, 25.0)]),
        (-3.0, 50.0, [(30.0, 50.0), (0.0, 18.0)]),
        (5.0, 50.0, [(18.0, 32.0), (0.0, 17.9), (32.2, 50.0)]),
    ],
)
def test_a_drift_before_a_gap_is_no_pressure_behind_it(drift, lasts, spans):
    raw = recorded(11, lambda t: drift * t / lasts, duration=lasts)
    made, said = average(stretch(raw, *spans))
    assert made.recording.mean_pressure == pytest.approx(15.43, abs=0.15)
    assert made.baseline.size == pytest.approx(drift, abs=0.25)
    assert not made.baseline.steps
    assert "from 0 to" in said[0]
    assert "right at 0 s" in said[0]
    assert all(spans[0][0] <= beat.start < beat.end <= spans[0][1] for beat in made.beats)
    assert len(made.baseline.time) > len(made.beats)


def test_a_stretch_that_is_chosen_keeps_the_zero_of_the_whole_recording():
    raw = recorded(12, lambda t: 5.0 * (1 - np.exp(-t / 15.0)), duration=40.0)
    whole, part = average(raw)[0], average(raw.between(24.0, 38.0))[0]
    assert part.recording.mean_pressure == pytest.approx(15.43, abs=0.2)
    assert part.recording.mean_pressure == pytest.approx(whole.recording.mean_pressure, abs=0.2)
    late = average(raw.between(24.0, 38.0), zero_time=38.0)[0]
    assert late.recording.mean_pressure == pytest.approx(15.43 + 5.0 * (1 - np.exp(-38.0 / 15.0)), abs=0.2)


def test_a_step_of_the_instrument_before_the_stretch_counts_and_no_beat_is_lost_by_it():
    raw = recorded(15, lambda t: np.where(t < 9.0, 0.0, 2.0), duration=30.0)
    made, said = average(raw.between(14.0, 28.0))
    assert made.recording.mean_pressure == pytest.approx(15.43, abs=0.15)
    assert any("a step of +2 mmHg at 8.9" in one for one in said)
    assert not any(beat.rejected is not None and beat.rejected.code == "beat.step" for beat in made.beats)


def test_where_the_animal_changes_beside_the_stretch_the_stretch_is_judged_alone():
    raw = recorded(16, duration=40.0)
    rise = 1.0 + 0.5 / (1.0 + np.exp(-(raw.time - 15.0)))  # of pulse and flow too
    changed = replace(raw, pressure=raw.pressure * rise, flow=raw.flow * rise)
    made, said = average(changed.between(25.0, 40.0))
    assert made.recording.mean_pressure == pytest.approx(15.43 * 1.5, abs=0.2)
    assert any("beside the stretch that is read" in one and "right at 25.1 s" in one for one in said)
    assert made.recording.pressure_error[0] < 0.2


def test_a_zero_far_from_all_beats_is_taken_at_the_nearest():
    raw = recorded(17, lambda t: 0.1 * t, duration=60.0)
    made, said = average(stretch(raw, (40.0, 60.0)))
    assert made.baseline.zero == pytest.approx(40.0, abs=0.3)
    assert made.recording.mean_pressure == pytest.approx(15.43 + 4.0, abs=0.2)
    assert "right at 40" in said[0]


@pytest.mark.parametrize(
    ("begins", "left", "lasts"),
    [
        (lambda t: np.where(t < 0.5, 1.0, 0.0), 0.0, 12.0),
        (lambda t: np.where(t < 1.5, -1.0, 0.0), 0.0, 12.0),
        (lambda t: np.where(t < 1.5, -1.0, 0.0), 0.0, 40.0),
        (lambda t: 2.0 * np.exp(-t / 0.3), 0.0, 12.0),
        (lambda t: 2.0 * np.exp(-t), 2.0 * np.exp(-2.1), 12.0),  # what has not settled when the first beats end
    ],
)
def test_a_level_that_begins_elsewhere_says_nothing_of_the_zero(begins, left, lasts):
    raw = recorded(18, begins, duration=lasts)
    made, said = average(raw)
    assert made.recording.mean_pressure == pytest.approx(15.43 + left, abs=0.1)
    assert made.recording.pressure_error[0] > abs(made.baseline.settling.height) > 0.9
    assert "when a catheter settles" in said[0]
    assert not made.baseline.steps
    early = [cause(beat.rejected) for beat in made.beats if beat.start < 1.9]
    assert set(early) == {"settling"}


def test_a_zero_that_a_person_names_is_believed_whatever_follows_it():
    raw = recorded(19, lambda t: np.where(t < 1.5, -1.0, 0.0))
    made, _ = average(raw, zero_time=0.0)
    assert made.baseline.settling is None
    assert made.recording.mean_pressure == pytest.approx(15.43 - 1.0, abs=0.15)
    late, said = average(raw, zero_time=20.0)
    assert late.recording.mean_pressure == pytest.approx(15.43, abs=0.15)
    assert late.recording.pressure_error[0] < 0.1
    assert not any("settles" in one for one in said)


@pytest.mark.parametrize(("zero_time", "told"), [(10.0, True), (18.0, False)])
def test_a_zero_that_is_named_within_what_passes_is_told_with_what_it_moves_all_beats_by(zero_time, told):
    raw = recorded(24, lambda t: 4.0 * np.exp(-0.5 * (t - 10.0) ** 2), duration=20.0)
    made, said = average(raw, zero_time=zero_time)
    assert made.recording.mean_pressure == pytest.approx(15.43 + 4.0 * told, abs=0.3)
    assert any("mmHg above that of before and after, as when something passes" in text for text in said) == told


@pytest.mark.parametrize("drift", [lambda t: 0.1 * t, lambda t: 5.0 * (1 - np.exp(-t / 15.0)), lambda t: 0.0 * t])
def test_a_drift_from_the_start_on_is_no_level_that_settles(drift):
    for seed in range(20, 22):
        heavy = replace(USUAL, ventilation_pressure=3.0)
        assert average(recorded(seed, drift, disturbances=heavy))[0].baseline.settling is None


def test_a_flush_after_the_first_beats_leaves_the_zero_of_the_start():
    raw = recorded(25, lambda t: 0.1 * t + np.where((t > 0.4) & (t < 0.9), 40.0, 0.0))
    made, said = average(raw)
    assert made.recording.mean_pressure == pytest.approx(15.43, abs=0.1)
    assert made.baseline.zero == pytest.approx(0.0, abs=0.1)
    assert made.recording.pressure_error[0] < 0.1
    assert not any("settles" in one for one in said)
    assert all(beat.rejected for beat in made.beats if 0.3 < beat.start < 0.9)


def test_first_beats_that_are_a_large_part_of_all_are_no_level_that_begins_elsewhere():
    raw = recorded(18, lambda t: np.where(t < 0.5, 1.0, 0.0), duration=4.0)
    assert average(raw)[0].baseline.settling is None
    longer = recorded(18, lambda t: np.where(t < 0.5, 1.0, 0.0), duration=12.0)
    assert average(longer)[0].baseline.settling is not None
