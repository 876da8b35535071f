"""Spikes are replaced and counted; what an artery, a valve, a step or noise makes is no spike."""

import numpy as np
import pytest

import vasowave as vw
from vasowave.base import VasowaveWarning
from vasowave.catheter import Disturbances, average_beats, synthetic_raw_recording
from vasowave.catheter.signals import RawRecording, despiked


def recorded(seed=3, rate=1000.0, **disturbances):
    rng = np.random.default_rng(seed)
    how = Disturbances(ventilation_pressure=0.0, pressure_drift=0.0, **disturbances)
    return synthetic_raw_recording(
        vw.virtual_mouse(), rng, duration=5.0, sampling_rate=rate, disturbances=how
    ).raw  # fmt: skip


def with_pressure(raw, pressure):
    return RawRecording(pressure, raw.flow, raw.sampling_rate, raw.ecg)


def test_spikes_are_counted_and_leave_mean_and_pulse_as_they_were_without_them():
    raw = recorded()
    pressure, flow = raw.pressure.copy(), raw.flow.copy()
    at = np.arange(40, len(pressure) - 40, 100)  # ten a second, in every part of the beat
    pressure[at] += 60.0
    pressure[at + 1] += 50.0
    flow[at + 31] -= 3.0
    with pytest.warns(VasowaveWarning, match="spikes in the pressure"):
        average = average_beats(RawRecording(pressure, flow, raw.sampling_rate, raw.ecg))
    clean = average_beats(raw)
    told = {one.code: dict(one.values) for one in average.findings if "spikes" in one.code}
    many, few = told["recording.many-spikes"], told["recording.spikes"]  # 2 % and 1 % of the samples
    assert (many["what"], many["count"], many["lasts"]) == ("pressure", len(at), pytest.approx(2.0 * len(at)))
    assert (few["what"], few["count"], few["lasts"]) == ("flow", len(at), pytest.approx(1.0 * len(at)))
    for name in ("pressure", "flow"):
        here, there = (getattr(one.recording, name) for one in (average, clean))
        # A line over two samples of an upstroke, and averages of 20 beats that need not be the same ones.
        assert here == pytest.approx(there, abs=0.03 * np.ptp(there)), name


@pytest.mark.parametrize("rate", [500.0, 1000.0, 4000.0])
@pytest.mark.parametrize(
    "laid_on",
    [
        lambda phase, time: 0.0 * phase,
        lambda phase, time: -3.0 * np.exp(-0.5 * ((phase - 0.5) * 0.11 / 0.002) ** 2),  # a sharp notch
        lambda phase, time: 3.0 * np.exp(-phase * 0.11 / 0.01) * np.sin(300 * np.pi * phase * 0.11),  # a whip
        lambda phase, time: np.where(time > 2.0, 25.0, 0.0),
        lambda phase, time: np.where((time > 2.0) & (time < 2.02), 25.0, 0.0),  # too long for a spike
        lambda phase, time: 3.0 * np.random.default_rng(1).standard_normal(len(time)),
    ],
)
def test_nothing_of_an_artery_or_a_transducer_is_replaced(rate, laid_on):
    raw = recorded(rate=rate)
    raw = with_pressure(raw, raw.pressure + laid_on(raw.time / 0.11 % 1.0, raw.time))
    clean, found = despiked(raw)
    assert clean is raw
    assert not found


def test_a_signal_that_moves_by_steps_of_its_converter_has_no_spikes():
    raw = recorded(rate=4000.0, pressure_noise=0.0)
    coarse = with_pressure(raw, np.round(raw.pressure / 0.5) * 0.5)
    assert not despiked(coarse)[1]


def test_stretches_beside_the_one_that_is_read_lose_their_spikes_too():
    raw = recorded()
    pressure = raw.pressure.copy()
    pressure[200] += 80.0
    clean, found = despiked(with_pressure(raw, pressure).between(2.0, 4.0))
    assert not found
    assert clean.beside[0].pressure.max() < raw.pressure.max() + 1.0
