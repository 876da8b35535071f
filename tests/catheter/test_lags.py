"""A pressure that is late and clocks that run apart are told; beds, breaths and an animal that changes are neither."""

import warnings

import numpy as np
import pytest

from vasowave.base import NumericalError
from vasowave.catheter import average_beats
from vasowave.catheter.check import odd_values
from vasowave.catheter.signals import RawRecording

RATE, BEAT = 1000.0, 0.11
HARMONIC = np.arange(65)


def flow_spectrum():
    phase = np.arange(128) / 128
    flow = np.where(phase < 0.45, np.sin(np.pi * np.clip(phase / 0.45, 0, 1) ** 0.85) ** 2, 0.0)
    return np.fft.rfft(0.2 * flow / flow.mean())


def cycle(near, decay, lag):
    """Return pressure and flow before a bed of total resistance 100 mmHg s/ml; the pressure is late by `lag`."""
    bed = (100 - near) / (1 + 2j * np.pi * HARMONIC * decay) + near
    spectrum = flow_spectrum()
    return [np.fft.irfft(one) for one in (spectrum * bed * np.exp(-2j * np.pi * HARMONIC * lag), spectrum)]


@pytest.mark.parametrize("near", [0.0, 3.0, 10.0, 30.0])
@pytest.mark.parametrize("decay", [0.3, 1.0, 3.0])
def test_no_bed_makes_a_pressure_late_and_one_that_is_late_is_told_with_its_delay(near, decay):
    for lag in (0.0, 0.05, 0.07):
        found = [one for one in odd_values(*cycle(near, decay, lag), BEAT) if one.code == "recording.late-pressure"]
        assert len(found) == (lag > 0), lag
        if found:
            values = dict(found[0].values)
            assert values["percent"] == pytest.approx(100 * lag, abs=3.01)  # the least that fits; near beds look alike
            assert values["delay"] == pytest.approx(10 * BEAT * values["percent"])


def recorded(drift=0.0, lasts=20.0, decay=lambda time: 1.0 + 0.0 * time):
    """Return beats of pressure and flow; the flow falls behind by so much of the time that passes."""
    rng = np.random.default_rng(2)
    time = np.arange(0, lasts, 1 / RATE)
    spectrum = flow_spectrum()[:12] / 128
    turn = lambda at: np.exp(2j * np.pi * np.outer(at / BEAT, HARMONIC[:12]))  # noqa: E731
    bed = 10 + 90 / (1 + 2j * np.pi * HARMONIC[:12] * decay(time)[:, None])
    pressure, flow = (
        2 * (one @ spectrum).real - spectrum[0].real * first
        for one, first in ((turn(time) * bed, 100.0), (turn(time * (1 - drift)), 1.0))
    )
    breath = np.maximum(np.sin(2 * np.pi * 1.5 * time), 0.0)
    return RawRecording(
        pressure + breath + 0.1 * rng.standard_normal(len(time)),
        flow * (1 - 0.05 * breath) + 0.002 * rng.standard_normal(len(time)), RATE,
    )  # fmt: skip


def with_ecg(raw, drift):
    """Return a recording with R waves whose clock falls behind by so much of the time that passes."""
    waves = np.exp(-0.5 * (((raw.time * (1 - drift) / BEAT + 0.5) % 1.0 - 0.5) * BEAT / 0.0015) ** 2)
    ecg = waves + 0.03 * np.random.default_rng(3).standard_normal(len(waves))
    return RawRecording(raw.pressure, raw.flow, RATE, ecg)


def test_an_ecg_with_a_clock_of_its_own_is_told_or_named_where_its_beats_are_refused():
    assert told(with_ecg(recorded(), 0.0), "recording.clock-of-ecg") == []
    values = told(with_ecg(recorded(), 1e-3), "recording.clock-of-ecg")[0]
    assert values["percent"] == pytest.approx(-0.1, rel=0.1)
    with pytest.raises(NumericalError, match=r"after the R wave.*fiducial: pressure"):
        average_beats(with_ecg(recorded(), 1e-2))


def told(raw, code="recording.clocks-apart"):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        found = average_beats(raw).findings
    return [dict(one.values) for one in found if one.code == code]


@pytest.mark.parametrize("drift", [2e-4, -1e-3])
def test_a_flow_whose_clock_runs_apart_is_told_with_what_it_makes_over_the_recording(drift):
    values = told(recorded(drift))[0]
    assert values["percent"] == pytest.approx(100 * drift, rel=0.1)
    assert values["size"] == pytest.approx(1e3 * abs(drift) * values["lasts"], rel=0.1)
    assert values["later"] == ("later" if drift > 0 else "earlier")


def test_channels_of_two_animals_are_told_apart_in_numbers_that_are_written_out():
    with pytest.raises(NumericalError, match=r"the flow comes (1000|990|980) ms later .* or two animals"):
        average_beats(recorded(0.05))  # as of 500 and 475 beats/min: 5 % of 20 s


def test_one_clock_and_an_animal_whose_bed_changes_are_not_told():
    assert told(recorded()) == []
    assert told(recorded(decay=lambda time: 0.6 + 0.04 * time)) == []  # the first harmonic's delay alone changes
