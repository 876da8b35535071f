"""End-expiration is found by the phase of the breath, and where that cannot be known, it is said."""

import warnings
from dataclasses import fields, replace

import numpy as np
import pytest

from vasowave.base import Severity, VasowaveWarning
from vasowave.catheter import Disturbances, RawRecording, average_beats, synthetic_raw_recording
from vasowave.pulse import virtual_mouse
from vasowave.pulse.cycle import Recording

PHASE = np.arange(256) / 256
BEAT = np.sin(np.pi * np.clip((PHASE - 0.08) / 0.8, 0, 1)) ** 2
CYCLE = Recording(12.0 + 14.0 * BEAT, 0.4 * BEAT, 0.11)
NONE = Disturbances(**{field.name: 0.0 for field in fields(Disturbances)})
QUIET = replace(NONE, length_variation=0.015, pressure_noise=0.1, ecg_noise=0.05)


def averaged(seed, breath, ecg=True, hum=0.0):
    """Return the average of a recording on which `breath`, mmHg over its phase, is laid, and the codes of its looks."""
    rng = np.random.default_rng(seed)
    rate = rng.uniform(1.2, 1.8)
    made = synthetic_raw_recording(
        CYCLE, rng, duration=15.0, disturbances=QUIET, sampling_rate=1000.0, ecg=ecg,
        baseline=lambda t: breath((rate * t + 0.3) % 1.0) + hum * np.sin(2 * np.pi * 50.0 * t),
    ).raw  # fmt: skip
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        average = average_beats(made)
    return average, [one.code for one in average.findings if one.severity is Severity.LOOK]


@pytest.mark.parametrize("seed", range(2))
def test_under_a_piston_that_rests_nowhere_the_mean_is_that_of_whole_breaths_and_this_is_said(seed):
    average, looks = averaged(seed, lambda phase: 2.0 - 2.0 * np.cos(2 * np.pi * phase))
    cycle = average.recording
    assert cycle.mean_pressure == pytest.approx(CYCLE.mean_pressure + 2.0, rel=0.01)
    assert abs(cycle.mean_pressure - CYCLE.mean_pressure - 2.0) < 2 * cycle.pressure_error[0]
    assert "recording.breath-without-plateau" in looks


def test_of_two_ends_at_which_the_pressure_rests_equally_long_neither_counts():
    average, looks = averaged(3, lambda phase: 4.0 * (phase < 0.5))
    assert average.recording.mean_pressure == pytest.approx(CYCLE.mean_pressure + 2.0, rel=0.015)
    assert "recording.breath-without-plateau" in looks


@pytest.mark.parametrize(("sign", "looks"), [(1.0, []), (-1.0, ["recording.breath-rests-high"])])
def test_a_pressure_that_rests_at_one_end_is_taken_there(sign, looks):
    hump = lambda phase: sign * 3.0 * np.where(phase < 0.35, np.sin(np.pi * phase / 0.35) ** 2, 0.0)  # noqa: E731
    average, seen = averaged(4, hump)
    assert average.recording.mean_pressure == pytest.approx(CYCLE.mean_pressure, rel=0.01)
    assert seen == looks


@pytest.mark.parametrize("seed", range(2))
def test_hum_neither_halves_the_heart_rate_nor_goes_unsaid(seed):
    average, looks = averaged(seed, lambda phase: 0.0 * phase, ecg=False, hum=2.0)
    assert average.recording.heart_rate == pytest.approx(60 / 0.11, rel=0.01)
    assert average.recording.mean_pressure == pytest.approx(CYCLE.mean_pressure, rel=0.02)
    assert "recording.hum" in looks


@pytest.mark.parametrize("seconds", [3.0, 6.0])
def test_beats_that_scatter_without_a_breath_are_not_rejected_for_ventilation(seconds):
    rejected = count = 0
    for seed in range(6):
        made = synthetic_raw_recording(
            CYCLE, np.random.default_rng(seed), duration=seconds, disturbances=replace(QUIET, pressure_noise=1.0),
            sampling_rate=1000.0,
        ).raw  # fmt: skip
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            beats = average_beats(made, 12).beats
        rejected += sum(beat.rejected is not None and beat.rejected.code == "beat.ventilation" for beat in beats)
        count += len(beats)
    assert rejected < 0.05 * count


@pytest.mark.parametrize(("beats_per_min", "rate"), [(560.0, 500.0), (440.0, 400.0), (350.0, 300.0)])
def test_steady_beats_that_fall_in_and_out_of_step_with_the_samples_have_no_breath(beats_per_min, rate):
    rejected = []
    for seed in range(3):
        made = synthetic_raw_recording(
            virtual_mouse(), np.random.default_rng(seed), duration=6.0, sampling_rate=rate,
            disturbances=replace(NONE, length_variation=0.003), heart_rate=beats_per_min,
        ).raw  # fmt: skip
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            rejected += [beat.rejected for beat in average_beats(made).beats]
    assert sum(reason is not None for reason in rejected) < 0.1 * len(rejected)


@pytest.mark.parametrize(("rate", "breaths"), [(450.0, 70.0), (750.0, 50.0)])
def test_means_over_whole_breaths_are_said_beside_those_at_end_expiration_and_averaged_if_asked(rate, breaths):
    asked = replace(QUIET, breaths_per_minute=breaths, ventilation_pressure=3.0, ventilation_flow=0.2)
    raw = synthetic_raw_recording(
        CYCLE, np.random.default_rng(11), duration=12.0, disturbances=asked, heart_rate=rate, sampling_rate=1000.0
    ).raw
    with pytest.warns(VasowaveWarning) as told:
        expired = average_beats(raw).recording
    (looks,) = [warning.message.finding for warning in told]  # none asks for a stretch without breaths
    assert "[reject_ventilation=False]" in str(told[0].message)
    whole = average_beats(raw, reject_ventilation=False).recording
    said = dict(looks.values)
    for pressure, flow in ((said["breath_pressure"], said["breath_flow"]), (whole.mean_pressure, whole.flow.mean())):
        assert pressure == pytest.approx(raw.pressure.mean(), rel=0.004)  # the first and the last beat are cut off
        assert flow == pytest.approx(raw.flow.mean(), rel=0.01)
    assert expired.flow.mean() > 1.025 * raw.flow.mean()
    assert expired.mean_pressure == pytest.approx(CYCLE.mean_pressure, rel=0.01)


def test_of_breaths_that_move_no_mean_nothing_is_said():
    average, _ = averaged(5, lambda phase: 0.0 * phase)
    assert not [finding for finding in average.findings if finding.code.startswith("recording.breath")]


def breathing_rat(heart, breaths, ecg, share=0.05, seconds=10.0, rate=1000.0, seed=77):
    """Return ten seconds of a Windkessel by formula, pressure and flow of which a breath lifts by a share, and truths.

    Every beat is as long as the next, so that heart and breath may show each other's overtones.
    """
    rng, n, f = np.random.default_rng(seed), 4096, heart / 60
    flow = np.where(np.arange(n) / n < 0.4, np.sin(np.pi * np.minimum(np.arange(n) / n / 0.4, 1)), 0.0) ** 1.3
    impedance = 2.4 + 19.0 / (1 + 2j * np.pi * f * np.arange(n // 2 + 1) * 0.22)
    pressure = 6.0 + np.fft.irfft(np.fft.rfft(1.25 * flow / flow.mean()) * impedance, n)
    t = np.arange(int(seconds * rate)) / rate
    phase, breath = (t * f + rng.random()) % 1, 1 + share * np.sin(2 * np.pi * breaths / 60 * t + 6 * rng.random())
    signals = [
        np.interp(phase, np.arange(n) / n, values, period=1) * breath
        + 0.005 * values.mean() * rng.standard_normal(len(t))
        for values in (pressure, 1.25 * flow / flow.mean())
    ]
    r_wave = np.exp(-((((phase + 0.47) % 1 - 0.5) / 0.012) ** 2)) + 0.01 * rng.standard_normal(len(t))
    return RawRecording(*signals, rate, r_wave if ecg else None), 2 * share * pressure.mean(), pressure.mean()


@pytest.mark.parametrize("ecg", [True, False])
@pytest.mark.parametrize(("heart", "breaths"), [(302, 72), (340, 72), (371, 64), (455, 101)])
def test_a_breath_is_as_high_and_fast_as_it_is_with_and_without_an_ecg(heart, breaths, ecg):
    raw, height, mean = breathing_rat(heart, breaths, ecg)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        average = average_beats(raw)
    (told,) = (one for one in average.findings if one.code == "recording.breath-without-plateau")
    assert dict(told.values)["rate"] == pytest.approx(breaths, abs=1.0)
    assert dict(told.values)["height"] == pytest.approx(height, rel=0.15)
    assert average.recording.mean_pressure == pytest.approx(mean, rel=0.01)


def uneven_breaths(rng, time, per_second):
    """Return the phase, 0 to 1, of breaths whose lengths scatter by a tenth."""
    lengths = (1.0 + 0.1 * np.clip(rng.standard_normal(int(2 * per_second * time[-1]) + 20), -2.5, 2.5)) / per_second
    ends = np.cumsum(lengths) - rng.random() / per_second
    breath = np.searchsorted(ends, time, side="right")
    return np.clip(1.0 - (ends[breath] - time) / lengths[breath], 0.0, 1.0)


@pytest.mark.parametrize("seed", range(2))
@pytest.mark.parametrize(("shape", "end"), [("sine", 2.0), ("dips", 0.0), ("humps", 0.0)])
def test_before_and_after_a_drug_are_averaged_at_one_part_of_breaths_whose_lengths_scatter(shape, end, seed):
    course = {
        "sine": lambda phase: 2.0 - 2.0 * np.cos(2 * np.pi * phase),
        "humps": lambda phase: 4.0 * np.where(phase < 0.4, np.sin(np.pi * phase / 0.4) ** 2, 0.0),
    }
    course["dips"] = lambda phase: -course["humps"](phase)
    rng = np.random.default_rng(seed)
    means = []
    for fall in (1.0, 0.88):
        cycle = replace(CYCLE, pressure=fall * CYCLE.pressure)
        raw = synthetic_raw_recording(
            cycle, rng, duration=12.0, heart_rate=360.0, sampling_rate=500.0, disturbances=QUIET,
            baseline=lambda t: course[shape](uneven_breaths(rng, t, 1.2)),
        ).raw  # fmt: skip
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            means.append(average_beats(raw).recording.mean_pressure - end)
    # of beats at the end of expiration up to 12 % of the breath's height counts
    assert means == pytest.approx([CYCLE.mean_pressure, 0.88 * CYCLE.mean_pressure], rel=0.035)
    assert means[1] / means[0] == pytest.approx(0.88, abs=0.03)
