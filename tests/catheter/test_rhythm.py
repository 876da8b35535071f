"""A pressure that follows the rhythm of the heart is no breath, and beats that the average leaves out are counted."""

import warnings
from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lfilter

from vasowave.base import NumericalError, Severity
from vasowave.catheter import average_beats
from vasowave.catheter.signals import RawRecording

RATE, BEAT, STROKE, RESISTANCE, DECAY = 1000.0, 0.11, 0.022, 100.0, 0.1


def heart(seed, lengths, strokes=None, breath=None, seconds=16.0):
    """Return a recording of a heart before a Windkessel, and true mean pressure, mean flow and heart rate.

    `lengths` and `strokes` are those of the usual beat; `breath`, mmHg over time, is laid on.
    """
    rng = np.random.default_rng(seed)
    count = round(1.5 * seconds / BEAT)
    number = np.arange(count)
    of_beats = BEAT * lengths(number) * (1 + 0.015 * np.clip(rng.standard_normal(count), -3, 3))
    of_beats, starts = of_beats[:-1], np.cumsum(of_beats)[:-1] - 2.0
    time = np.arange(-2.0, seconds, 1 / RATE)
    flow, ecg = np.zeros(len(time)), 0.02 * rng.standard_normal(len(time))
    for start, stroke in zip(starts, np.ones(count) if strokes is None else strokes(number)):
        share = (time - start - 0.01) / 0.05
        flow += np.where((share > 0) & (share < 1), stroke * STROKE / 0.05 * 2 * np.sin(np.pi * share) ** 2, 0.0)
        ecg += np.exp(-0.5 * ((time - start) / 0.0015) ** 2)
    kept = np.exp(-1 / (RATE * DECAY))
    pressure = 8.0 * flow + lfilter([RESISTANCE * (1 - kept)], [1, -kept], flow)
    here = time >= 0
    inside = starts[(starts > 0) & (starts < seconds)]
    whole = (time >= inside[0]) & (time < inside[-1])
    truth = (pressure[whole].mean(), flow[whole].mean(), 60 * (len(inside) - 1) / np.ptp(inside))
    heard = pressure + 0.1 * rng.standard_normal(len(time)) + (0.0 if breath is None else breath(time))
    return RawRecording(heard[here], flow[here], RATE, ecg[here]), truth


def averaged(raw):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        average = average_beats(raw)
    cycle = average.recording
    looks = {one.code: one for one in average.findings if one.severity is Severity.LOOK}
    return (cycle.mean_pressure, cycle.cardiac_output, cycle.heart_rate), looks


def sinus(share):
    return lambda number: 1 + share * np.sin(2 * np.pi * 1.1 * BEAT * number)


@pytest.mark.parametrize("seed", range(2))
def test_a_heart_rate_that_swings_with_the_breath_is_averaged_over_it_and_its_beats_are_no_breaths(seed):
    raw, truth = heart(seed, sinus(0.08))
    seen, looks = averaged(raw)
    assert seen == pytest.approx(truth, rel=0.02)
    assert not [code for code in looks if "breath" in code or "rejected" in code]


def test_a_ventilator_beside_a_heart_rate_that_swings_is_found_and_whole_breaths_count():
    raw, truth = heart(4, sinus(0.05), breath=lambda time: 2.0 - 2.0 * np.cos(2 * np.pi * 1.5 * time))
    (pressure, *others), looks = averaged(raw)
    assert (pressure - 2.0, *others) == pytest.approx(truth, rel=0.03)
    assert "recording.breath-without-plateau" in looks


@pytest.mark.parametrize(
    ("lengths", "strokes"),
    [
        (lambda number: np.where(number % 3 == 2, 2.0, 1.0), lambda number: np.ones(len(number))),
        (lambda number: np.ones(len(number)), lambda number: np.where(number % 4 == 3, 0.0, 1.0)),
    ],
    ids=["block of 4:3", "every fourth beat empty"],
)
def test_dropped_beats_are_counted_in_flow_pressure_and_rate_and_are_no_breath(lengths, strokes):
    raw, truth = heart(5, lengths, strokes)
    seen, looks = averaged(raw)
    assert seen[1] > 1.2 * truth[1]  # the usual beats alone
    numbers = dict(looks["recording.unusual-beats"].values)
    assert (numbers["pressure"], numbers["flow"], numbers["rate"]) == pytest.approx(truth, rel=0.02)
    assert not [code for code in looks if "breath" in code]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        cycle = average_beats(raw).recording
    for value, error, true in ((seen[0], cycle.pressure_error[0], truth[0]), (seen[1], cycle.flow_error[0], truth[1])):
        assert abs(value - true) < 2.0 * error < 3.0 * abs(value - true)  # stated, and not much more


@pytest.mark.parametrize("ecg", [True, False])
def test_beats_that_alternate_in_length_are_averaged_by_the_time_that_they_last_and_their_shape_is_no_animal_s(ecg):
    raw, truth = heart(6, lambda n: np.where(n % 2, 1.3, 0.7), lambda n: np.where(n % 2, 0.6, 1.2))
    seen, looks = averaged(raw if ecg else replace(raw, ecg=None))
    assert seen == pytest.approx(truth, rel=0.01)
    assert "recording.over-rhythm" in looks


def test_beats_that_are_unlike_in_shape_are_no_rhythm_and_refused():
    raw, _ = heart(6, lambda n: np.ones(len(n)))
    rng = np.random.default_rng(1)
    noisy = np.interp(
        raw.time, raw.time[::40], raw.flow.mean() * (1.0 + 3.0 * rng.standard_normal(len(raw.time[::40])))
    )
    with pytest.raises(NumericalError, match="for correlation"):
        average_beats(replace(raw, flow=noisy))


def test_two_seconds_of_a_steady_heart_without_a_breath_are_averaged_without_a_word_of_breaths():
    told = 0
    for seed in range(6):
        raw, truth = heart(seed, lambda n: np.ones(len(n)), seconds=6.0)
        seen, looks = averaged(RawRecording(raw.pressure[:2200], raw.flow[:2200], RATE, raw.ecg[:2200]))
        assert seen == pytest.approx(truth, rel=0.02)
        told += "recording.over-breaths" in looks
    assert told == 0
