"""Synthetic recordings whose every part is switched on alone."""

import numpy as np
import pytest

from vasowave.base import InputError
from vasowave.catheter import Disturbances, synthetic_raw_recording
from vasowave.pulse.cycle import Recording
from vasowave.pulse.examples import published_table

T = np.arange(64) / 64
CYCLE = Recording(12 + 4 * np.sin(2 * np.pi * T), 1 + 0.5 * np.cos(2 * np.pi * T), 0.1)
NONE = dict.fromkeys(Disturbances.__dataclass_fields__, 0.0) | {"breaths_per_minute": 60.0}


def made(seed=1, **more):
    quiet = Disturbances(**(NONE | more.pop("disturbances", {})))
    return synthetic_raw_recording(CYCLE, np.random.default_rng(seed), duration=2.0, sampling_rate=500.0,
                                   disturbances=quiet, **more)  # fmt: skip


def test_without_disturbances_every_beat_is_the_cycle_itself():
    found = made()
    raw = found.raw
    assert (len(raw.pressure), raw.sampling_rate) == (1000, 500.0)
    assert np.diff(found.beat_times) == pytest.approx(0.1)
    phase = (raw.time - found.beat_times[0]) / 0.1
    assert raw.pressure == pytest.approx(12 + 4 * np.sin(2 * np.pi * phase), abs=1e-3)
    assert raw.flow == pytest.approx(1 + 0.5 * np.cos(2 * np.pi * phase), abs=1e-3)
    assert 0 <= found.beat_times[0] < 0.1
    assert 1.9 - 1e-9 <= found.beat_times[-1] <= raw.time[-1]
    assert np.diff(made(heart_rate=300.0).beat_times) == pytest.approx(0.2)
    assert made(ecg=False).raw.ecg is None


def test_each_disturbance_adds_what_it_says():
    plain = made().raw
    drift = made(disturbances={"pressure_drift": 6.0}).raw
    assert drift.pressure - plain.pressure == pytest.approx(0.1 * plain.time)
    line = made(baseline=lambda time: 3 * time).raw
    assert line.pressure - plain.pressure == pytest.approx(3 * plain.time)
    late = made(flow_delay=0.01).raw
    assert late.flow[5:] == pytest.approx(plain.flow[:-5])
    assert np.array_equal(late.pressure, plain.pressure)
    breathing = made(disturbances={"ventilation_pressure": 2.0, "ventilation_flow": 0.25})
    swell = (breathing.raw.pressure - plain.pressure) / 2.0
    assert (swell.min(), swell.max()) == pytest.approx((0.0, 1.0), abs=1e-4)
    assert np.mean(swell > 0) == pytest.approx(0.4, abs=0.01)
    assert breathing.raw.flow == pytest.approx(plain.flow * (1 - 0.25 * swell))
    assert breathing.inspiration == pytest.approx(np.interp(breathing.beat_times, plain.time, swell), abs=1e-3)
    noisy = made(disturbances={"pressure_noise": 0.2, "flow_noise": 0.1}).raw
    assert np.std(noisy.pressure - plain.pressure) == pytest.approx(0.2, rel=0.1)
    assert np.std(noisy.flow - plain.flow) == pytest.approx(0.1, rel=0.1)
    uneven = made(disturbances={"length_variation": 0.02, "amplitude_variation": 0.05})
    assert np.std(np.diff(uneven.beat_times)) == pytest.approx(0.002, rel=0.5)
    for wrong in ({"duration": 0.0}, {"sampling_rate": 0.0}, {"heart_rate": -60.0}):
        with pytest.raises(InputError, match="duration, sampling_rate and heart_rate of a synthetic recording must be"):
            synthetic_raw_recording(CYCLE, np.random.default_rng(1), **wrong)


def test_a_table_that_was_not_published_is_refused_with_the_nearest_that_was():
    with pytest.raises(InputError, match=r"no published table 'nominla' .did you mean 'nominal'.*there are: "):
        published_table("nominla")
