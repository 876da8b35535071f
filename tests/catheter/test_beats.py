"""Beats of synthetic recordings: every one found, the untidy ones rejected, and the cycle recovered from the rest."""

import warnings
from dataclasses import fields, replace

import numpy as np
import pytest

from vasowave.base import ANY_HEART_RATES, InputError, NumericalError, VasowaveWarning
from vasowave.catheter import Disturbances, SyntheticRecording, average_beats, synthetic_raw_recording
from vasowave.catheter.beats import cause, find_beats
from vasowave.catheter.signals import RawRecording
from vasowave.pulse.cycle import Recording

PHASE = np.arange(512) / 512
SYSTOLE = np.clip((PHASE - 0.08) / 0.45, 0, 1)
CYCLE = Recording(
    8.4
    + 10.5 * np.sin(np.pi * np.clip((PHASE - 0.08) / 0.8, 0, 1)) ** 2 * np.exp(-1.2 * PHASE) * 1.5
    + 0.3 * np.cos(2 * np.pi * PHASE),
    0.55 * np.sin(np.pi * SYSTOLE) ** 2 * (1 - 0.4 * SYSTOLE),
    0.11,
    "smooth synthetic cycle",
)
NONE = Disturbances(**{field.name: 0.0 for field in fields(Disturbances)})


def make(seed: int, disturbances: Disturbances | None = None, **settings) -> SyntheticRecording:
    rng = np.random.default_rng(seed)
    drawn = Disturbances(
        length_variation=rng.uniform(0.01, 0.04),
        breaths_per_minute=rng.uniform(60, 150),
        ventilation_pressure=rng.uniform(0, 3),
        pressure_drift=rng.uniform(-5, 5),
        pressure_noise=rng.uniform(0.05, 0.4),
        ecg_noise=rng.uniform(0.02, 0.15),
        mains=rng.uniform(0, 0.2),
        ecg_wander=rng.uniform(0, 1),
    )
    settings = {
        "heart_rate": rng.uniform(300, 800),
        "sampling_rate": float(rng.choice([1000, 2000, 4000])),
        "duration": 8.0,
    } | settings
    return synthetic_raw_recording(CYCLE, rng, disturbances=disturbances or drawn, **settings)


def misses_and_extras(found: np.ndarray, true: np.ndarray) -> tuple[int, int]:
    """Count against the true beats, except the first and last; a fifth of a beat is near, and each is found once."""
    near = 0.2 * np.median(np.diff(true))
    inner = true[1:-1]
    hits = [np.sum(np.abs(found - beat) <= near) for beat in inner]
    between = found[(found > inner[0] - near) & (found < inner[-1] + near)]
    misses = sum(hit == 0 for hit in hits)
    return misses, len(between) - (len(inner) - misses)


def count(seeds, fiducial) -> tuple[int, int, int]:
    misses = extras = beats = 0
    for seed in seeds:
        made = make(seed)
        found = find_beats(made.raw, fiducial)
        true = made.beat_times
        if fiducial == "pressure":
            # The foot follows the R wave by a constant time.
            nearest = found.times[np.argmin(np.abs(found.times[:, None] - true), axis=0)]
            true = true + np.median(nearest - true)
        missed, extra = misses_and_extras(found.times, true)
        misses, extras, beats = misses + missed, extras + extra, beats + len(true) - 2
    return misses, extras, beats


@pytest.mark.parametrize("fiducial", ["ecg", "pressure"])
def test_every_beat_is_found_once_at_300_to_800_per_minute(fiducial):
    misses, extras, beats = count(range(6), fiducial)
    assert beats > 350
    assert (misses, extras) == (0, 0)


@pytest.mark.validation
@pytest.mark.parametrize("fiducial", ["ecg", "pressure"])
def test_every_beat_of_250_recordings_is_found_once(fiducial):
    misses, extras, beats = count(range(1000, 1250), fiducial)
    assert beats > 15_000
    assert (misses, extras) == (0, 0)


def test_weak_r_waves_are_beats_where_one_is_missed_and_a_weak_wave_between_two_is_none():
    raw = make(3, replace(NONE, ecg_noise=0.01), heart_rate=545.0, sampling_rate=2000.0)
    beats, time = raw.beat_times, raw.raw.time
    height = np.ones(len(time))
    for beat in (beats[10], beats[25]):
        height[np.abs(time - beat) < 0.03] = 0.3
    between = 0.3 * np.exp(-0.5 * ((time - 0.5 * (beats[15] + beats[16])) / 0.001) ** 2)
    found = find_beats(replace(raw.raw, ecg=raw.raw.ecg * height + between), "ecg")
    assert misses_and_extras(found.times, beats) == (0, 0)


def test_r_waves_are_found_to_a_fifth_of_a_millisecond():
    made = make(3, sampling_rate=1000.0)
    found = find_beats(made.raw, "ecg").times
    error = found[np.argmin(np.abs(found[:, None] - made.beat_times[1:-1]), axis=0)] - made.beat_times[1:-1]
    assert np.abs(np.median(error)) < 2e-4
    assert np.std(error) < 2e-4


def index_errors(seeds, fiducial=None) -> np.ndarray:
    """Errors of the indices of Table 1 against the cycle itself, %, shape (recording, index)."""
    errors = []
    for seed in seeds:
        rng = np.random.default_rng(seed)
        rate = rng.uniform(450, 650)
        made = synthetic_raw_recording(CYCLE, rng, heart_rate=rate, duration=10.0)
        average = average_beats(made.raw, fiducial=fiducial)
        true = replace(CYCLE, period=60.0 / rate).indices()
        used = [beat.end - beat.start for beat in average.beats if beat.averaged]
        true["HR"] = 60.0 / float(np.mean(used))  # the rate of these very beats
        found = average.recording.indices()
        errors.append([100 * (found[name] / true[name] - 1) for name in true])
    return np.array(errors)


def test_r_waves_of_a_large_animal_are_found_alike_by_default_and_when_the_ecg_is_asked_for():
    """Of no species, so that rates of rodents are looked for, too: R waves that are ten times as long as theirs."""
    rng, time = np.random.default_rng(4), np.arange(20_000) / 1000
    true = np.arange(1, 40) * 0.5
    complexes = ((-0.02, 0.009, -0.15), (0.0, 0.011, 1.0), (0.026, 0.012, -0.35))  # Q, R, S: place, width, height
    waves = sum(h * np.exp(-0.5 * ((time - beat - at) / w) ** 2) for beat in true for at, w, h in complexes)
    flow = sum(np.exp(-0.5 * ((time - beat - 0.15) / 0.04) ** 2) for beat in true)
    raw = RawRecording(15 + 10 * flow, 80 * flow, 1000.0, waves + 0.02 * rng.standard_normal(len(time)))
    for fiducial in (None, "ecg"):
        found = find_beats(raw, fiducial, ANY_HEART_RATES)
        assert found.fiducial == "ecg"
        np.testing.assert_allclose(found.times, true, atol=2e-3)


def test_the_indices_of_the_average_are_those_of_the_cycle_within_one_percent():
    assert np.abs(index_errors(range(3))).max() < 1.0


@pytest.mark.weekly
@pytest.mark.filterwarnings("ignore:.*and rests at neither end")  # which some of these breaths do
@pytest.mark.parametrize(("fiducial", "first"), [("ecg", 2000), ("pressure", 2100)])
def test_the_indices_of_200_averages_are_those_of_the_cycle(fiducial, first):
    errors = np.abs(index_errors(range(first, first + 100), fiducial))
    # What is left of noise, drift and breaths now and then moves an extreme a little further.
    assert np.mean(errors < 1.0) > 0.99
    assert errors.max() < 2.0


def test_without_disturbances_the_average_is_the_cycle_and_nothing_scatters():
    made = make(1, NONE, heart_rate=545.4545, sampling_rate=4000.0)
    average = average_beats(made.raw, samples=512)
    np.testing.assert_allclose(average.recording.pressure, CYCLE.pressure, atol=0.02)
    np.testing.assert_allclose(average.recording.flow, CYCLE.flow, atol=2e-3)
    assert average.recording.period == pytest.approx(0.11, rel=1e-4)
    assert average.pressure_sd.max() < 0.05
    assert average.fiducial == "ecg"


def test_the_scatter_is_the_noise_that_was_added():
    noisy = replace(NONE, pressure_noise=0.4, flow_noise=0.02, ecg_noise=0.01)
    average = average_beats(make(2, noisy, sampling_rate=4000.0, duration=20.0).raw, beats=80, reject_ventilation=False)
    # Splines through white noise pass on about 0.8 of its SD between the samples and all of it on them.
    assert 0.7 * 0.4 < np.median(average.pressure_sd) < 1.05 * 0.4
    assert 0.7 * 0.02 < np.median(average.flow_sd) < 1.05 * 0.02


def test_beats_of_inspiration_are_rejected_and_those_of_expiration_averaged():
    asked = replace(Disturbances(), ventilation_pressure=3.0, breaths_per_minute=80)
    made = make(4, asked, heart_rate=540, duration=10.0)
    average = average_beats(made.raw)
    bounds = np.array([(beat.start, beat.end) for beat in average.beats])
    nearest = np.argmin(np.abs(made.beat_times[:, None, None] - bounds), axis=0)
    height = made.inspiration[nearest].mean(axis=1)
    kept = np.array([beat.averaged for beat in average.beats])
    blown = np.array([bool(beat.rejected and cause(beat.rejected) == "ventilation") for beat in average.beats])
    assert kept.sum() == 20
    assert blown[height > 0.5].all()
    assert height[kept].max() < 0.25
    without = average_beats(made.raw, reject_ventilation=False)
    assert without.recording.mean_pressure > average.recording.mean_pressure + 0.3


def test_an_early_beat_is_rejected_for_its_length_and_an_artefact_for_its_shape():
    made = make(5, replace(NONE, ecg_noise=0.01), heart_rate=500, sampling_rate=2000.0, duration=6.0)
    pressure = made.raw.pressure.copy()
    hurt = int((made.beat_times[20] + 0.02) * 2000)
    pressure[hurt : hurt + 60] += 40 * np.hanning(60)
    # Cutting 40 ms out of one beat makes it a short one.
    gone = int(made.beat_times[30] * 2000) + 120
    keep = np.r_[0:gone, gone + 80 : len(pressure)]
    raw = RawRecording(pressure[keep], made.raw.flow[keep], 2000.0, made.raw.ecg[keep])
    reasons = [str(beat.rejected) for beat in average_beats(raw, reject_ventilation=False).beats if beat.rejected]
    assert len(reasons) == 2
    assert reasons[0].startswith("correlation of pressure")
    assert reasons[1].startswith("length 80.")


@pytest.mark.parametrize("late", [-0.003, 0.002, 0.005])
def test_the_delay_between_pressure_and_flow_is_estimated_and_removed_only_when_asked(late):
    straight = average_beats(make(6, NONE, heart_rate=545, sampling_rate=2000.0).raw)
    raw = make(6, NONE, heart_rate=545, sampling_rate=2000.0, flow_delay=late).raw
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always", VasowaveWarning)
        average = average_beats(raw)
    said = ["ms after that of the pressure" in str(one.message) for one in told]
    assert said == [True] * (average.delay > 0.025 * average.recording.period)
    assert average.delay - straight.delay == pytest.approx(late, abs=2e-4)
    assert not average.delay_corrected
    corrected = average_beats(raw, correct_delay=True)
    assert corrected.delay_corrected
    assert not [one for one in corrected.recording.notes if one.code == "recording.late-flow"]
    assert not [one for one in straight.recording.notes if one.code == "recording.late-flow"]
    aligned = average_beats(make(6, NONE, heart_rate=545, sampling_rate=2000.0).raw, correct_delay=True)
    np.testing.assert_allclose(corrected.recording.flow, aligned.recording.flow, atol=0.02)


def test_smoothing_removes_the_harmonics_it_names_and_no_others():
    raw = make(12, Disturbances()).raw
    smooth, all_of_it = average_beats(raw, harmonics=9), average_beats(raw, harmonics=None)
    few, many = (np.fft.rfft(average.recording.pressure) for average in (smooth, all_of_it))
    np.testing.assert_allclose(few[:10], many[:10], atol=1e-9)
    assert np.abs(few[10:]).max() < 1e-9 < np.abs(many[10:]).max()
    assert any("above 9" in str(note) for note in smooth.recording.notes)


def test_the_average_closes():
    made = make(7, replace(Disturbances(), pressure_drift=60.0))
    with pytest.warns(VasowaveWarning, match=r"drifts by \+7.9 .* from 0 to") as told:
        pressure = average_beats(made.raw, drift="warn").recording.pressure
    assert {one.filename for one in told} == {__file__}  # a warning points at the line that asked
    assert abs(pressure[0] - pressure[-1]) <= 1.5 * np.abs(np.diff(pressure)).max()


def test_the_species_at_whose_rates_a_recording_beats_is_offered():
    time = np.arange(0, 30, 1 / 500)
    beat = np.where(time * 110 / 60 % 1 < 0.35, np.sin(np.pi / 0.35 * (time * 110 / 60 % 1)), 0.0)
    raw = RawRecording(12 + 12 * beat, 80 * beat, 500.0)
    with pytest.raises(NumericalError) as refused:
        find_beats(raw)
    offered = [cure.text for cure in refused.value.cures if cure.key == "species"]
    assert "pig" in offered
    assert not {"mouse", "rat"} & {*offered}
    assert len(find_beats(raw, heart_rates=(35.0, 240.0)).times) >= 53


def test_noise_without_beats_is_refused():
    rng = np.random.default_rng(1)
    raw = RawRecording(14 + rng.standard_normal(8000), 0.2 + rng.standard_normal(8000), 1000.0)
    with pytest.raises(NumericalError, match="does not repeat between 250 and 900"):
        find_beats(raw)


def test_arguments_that_cannot_be_met_are_told():
    raw = make(8, NONE, ecg=False).raw
    for rates in ((0, 900), (900, 900)):
        with pytest.raises(InputError, match="give the slowest and the fastest"):
            find_beats(raw, heart_rates=rates)
    with pytest.raises(InputError, match="8 s hold fewer than three beats at 20 beats/min"):
        find_beats(raw, heart_rates=(10, 20))
    with pytest.raises(InputError, match="no ECG; use fiducial='pressure'"):
        find_beats(raw, "ecg")
    with pytest.raises(InputError, match="neither 'ecg' nor"):
        find_beats(raw, "flow")
    with pytest.raises(InputError, match="whole beats found, 500 wanted"):
        average_beats(raw, beats=500)
    with pytest.raises(InputError, match="beats: 1 is too small; at least 2"):
        average_beats(raw, beats=1)
    with pytest.raises(NumericalError, match=r"good beats of \d+, 20 wanted \(rejected: \d+ for correlation"):
        average_beats(raw, least_correlation=1.0)


def test_a_recording_of_mostly_inspiration_warns_of_the_breath_and_asks_for_no_quieter_stretch():
    made = make(10, Disturbances(breaths_per_minute=160), heart_rate=300.0, duration=20.0)
    with pytest.warns(VasowaveWarning) as told:
        average_beats(made.raw)
    assert {one.message.finding.code for one in told} == {"recording.breath-without-plateau"}


@pytest.mark.parametrize(("heart", "width"), [(300, 5.6), (450, 5.6), (320, 8.0)])
def test_a_broad_r_wave_under_noise_is_where_it_is_and_as_often(heart, width):
    """Its own frequencies lie below those of a narrow one, in which noise hides it."""
    rng, t = np.random.default_rng(heart), np.arange(12_000) / 1000.0
    phase = (t * heart / 60 + 0.3) % 1
    complex_ = np.exp(-0.5 * ((phase - 0.5) * 60e3 / heart / width) ** 2) + 0.03 * rng.standard_normal(len(t))
    signal = np.maximum(0.0, np.sin(2 * np.pi * (phase - 0.55)))
    beats = find_beats(RawRecording(10 + 10 * signal, signal, 1000.0, complex_), "ecg", (180, 900)).times
    late = (beats * heart / 60 + 0.3) % 1 - 0.5
    assert len(beats) == pytest.approx(12 * heart / 60, abs=1.1)
    assert np.quantile(np.abs(late - np.median(late)) * 60 / heart, 0.9) < 0.001


@pytest.mark.parametrize(("heart", "width"), [(280, 4.5), (320, 5.6), (400, 5.6), (550, 4.5), (620, 3.0)])
def test_a_broad_r_wave_is_marked_at_one_place_in_every_beat(heart, width):
    """Either slope of it may be the strongest: marks that take turns are ten milliseconds apart."""
    rng, t = np.random.default_rng(heart), np.arange(8000) / 1000.0
    phase = (t * heart / 60 + 0.3) % 1
    complex_ = np.exp(-0.5 * ((phase - 0.5) * 60e3 / heart / width) ** 2) + 0.01 * rng.standard_normal(len(t))
    signal = np.maximum(0.0, np.sin(2 * np.pi * phase))
    beats = find_beats(RawRecording(10 + 10 * signal, signal, 1000.0, complex_), "ecg", (180, 900)).times
    assert np.std(np.diff(beats)) < 0.0005
