"""A filter of an amplifier is told by the noise that beats do not repeat, and nothing else is taken for one."""

import warnings
from dataclasses import fields, replace

import numpy as np
import pytest
from scipy.signal import butter, lfilter, sosfilt, sosfilt_zi

from vasowave.base import Severity
from vasowave.catheter import Disturbances, average_beats, synthetic_raw_recording
from vasowave.catheter.check import LowPass, correct_catheter
from vasowave.pulse.cycle import Recording

PHASE = np.arange(256) / 256
BEAT = np.sin(np.pi * np.clip((PHASE - 0.08) / 0.8, 0, 1)) ** 2
CYCLE = Recording(12.0 + 14.0 * BEAT, 0.4 * BEAT, 0.11)
NONE = Disturbances(**{field.name: 0.0 for field in fields(Disturbances)})
QUIET = replace(NONE, length_variation=0.015, ecg_noise=0.05)
RATE = 2000.0
CODE = "recording.noise-rolls-off"


def raw_of(seed, changed):
    """Return a recording of 12 s whose pressure is `changed`, with the generator of its noise."""
    rng = np.random.default_rng(seed)
    made = synthetic_raw_recording(CYCLE, rng, duration=12.0, disturbances=QUIET, sampling_rate=RATE).raw
    flow = made.flow + 0.002 * rng.standard_normal(len(made.flow))
    return replace(made, pressure=changed(made.pressure, rng), flow=flow)


def findings(raw):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        average = average_beats(raw)
    return average.recording, [one for one in average.findings if one.code == CODE]


def filtered(cutoff, order, noise=0.2):
    """Return a change of the pressure: noise, mmHg, then an analog filter (8 times as many samples), then 14 bits."""

    def changed(pressure, rng):
        fine = np.repeat(pressure, 8) + noise * np.sqrt(8) * rng.standard_normal(8 * len(pressure))
        sections = butter(order, cutoff, fs=8 * RATE, output="sos")
        return rounded(sosfilt(sections, fine, zi=sosfilt_zi(sections) * fine[0])[0][::8], 0.01)

    return changed


def white(pressure, rng, noise=0.2):
    return pressure + noise * rng.standard_normal(len(pressure))


def mains(count):
    return sum(np.sin(2 * np.pi * 50 * k * np.arange(count) / RATE) / k for k in (1, 3, 5))


def rounded(values, step):
    return step * np.round(values / step)


def red(memory):
    """Return a change of the pressure: fluctuations of 0.5 mmHg with a memory in s, and a converter's noise."""

    def changed(pressure, rng):
        left = np.exp(-1 / (RATE * memory))
        driven = 0.5 * np.sqrt(1 - left**2) * rng.standard_normal(len(pressure))
        values = lfilter([1.0], [1.0, -left], driven)
        return pressure + values + 0.02 * rng.standard_normal(len(pressure))

    return changed


@pytest.mark.parametrize(("cutoff", "order"), [(50.0, 1), (100.0, 1), (200.0, 1), (100.0, 2)])
def test_a_filter_of_the_pressure_is_told_with_its_cutoff_and_order(cutoff, order):
    _, (found,) = findings(raw_of(1, filtered(cutoff, order)))
    said = dict(found.values)
    assert (said["what"], said["order"], found.severity) == ("pressure", order, Severity.LOOK)
    assert said["cutoff"] == pytest.approx(cutoff, rel=0.3)  # what a spectrum of a hundred beats tells


KINDS = {
    "white noise": white,
    "converter of few bits": lambda pressure, rng: rounded(pressure, 0.2),
    "noise and few bits": lambda pressure, rng: rounded(white(pressure, rng, 0.05), 0.2),
    "memory of 50 ms": red(0.05),
    "memory of 20 ms": red(0.02),
    "mean of five": lambda pressure, rng: np.convolve(white(pressure, rng), np.ones(5) / 5, "same"),
    "interpolated": lambda pressure, rng: np.interp(
        np.arange(len(pressure)), np.arange(0, len(pressure), 2), white(pressure, rng)[::2]
    ),
    "held": lambda pressure, rng: np.repeat(white(pressure, rng)[::4], 4)[: len(pressure)],
    "hum": lambda pressure, rng: white(pressure, rng, 0.05) + mains(len(pressure)),
}  # fmt: skip


@pytest.mark.parametrize("kind", KINDS)
def test_nothing_else_is_taken_for_a_filter(kind):
    assert findings(raw_of(2, KINDS[kind]))[1] == []


def test_a_given_cutoff_answers_the_question():
    cycle, found = findings(raw_of(1, filtered(100.0, 1)))
    assert found
    codes = [one.code for one in correct_catheter(cycle, LowPass(100.0)).notes]
    assert CODE not in codes
    assert "recording.filter-corrected" in codes
    assert CODE in [one.code for one in correct_catheter(cycle, LowPass(100.0), "flow").notes]
