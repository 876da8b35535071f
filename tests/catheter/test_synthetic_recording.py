"""Synthetic continuous recordings hold the cycle they were made from, and the truth they claim."""

from dataclasses import fields

import numpy as np
import pytest

from vasowave.base import InputError
from vasowave.catheter import Disturbances, synthetic_raw_recording
from vasowave.pulse.cycle import Recording, resample

PHASE = np.arange(256) / 256
CYCLE = Recording(
    13.4 + 5 * np.sin(2 * np.pi * PHASE - 1.2) + 1.2 * np.cos(4 * np.pi * PHASE),
    0.18 + 0.2 * np.sin(2 * np.pi * PHASE - 0.6) + 0.07 * np.sin(4 * np.pi * PHASE - 1.0),
    0.11,
)
NONE = Disturbances(**{field.name: 0.0 for field in fields(Disturbances)})


def rng(seed=1):
    return np.random.default_rng(seed)


def test_without_disturbances_every_beat_is_the_cycle():
    made = synthetic_raw_recording(CYCLE, rng(), disturbances=NONE, duration=2.0, sampling_rate=10_000)
    np.testing.assert_allclose(np.diff(made.beat_times), 0.11, rtol=1e-12)
    phase = (made.raw.time - made.beat_times[0]) / 0.11 % 1.0
    fine = resample(CYCLE.flow, 1 << 15)
    expected = fine[np.rint(phase * len(fine)).astype(int) % len(fine)]
    np.testing.assert_allclose(made.raw.flow, expected, atol=1e-4)


def test_the_heart_rate_asked_for_is_the_rate_of_the_beats_and_of_the_r_waves():
    made = synthetic_raw_recording(CYCLE, rng(), heart_rate=720, disturbances=NONE, duration=5.0)
    assert 60 / np.diff(made.beat_times).mean() == pytest.approx(720, rel=1e-9)
    at = np.rint(made.beat_times[1:-1] * made.raw.sampling_rate).astype(int)
    assert made.raw.ecg is not None
    assert np.all(made.raw.ecg[at] > 0.85)
    assert np.mean(made.raw.ecg > 0.6) < 0.05


def test_beat_lengths_and_noise_vary_as_much_as_asked():
    asked = Disturbances(length_variation=0.03, pressure_noise=0.2, ventilation_pressure=0, pressure_drift=0)
    made = synthetic_raw_recording(CYCLE, rng(), disturbances=asked, duration=60.0)
    assert np.std(np.diff(made.beat_times)) / 0.11 == pytest.approx(0.03, rel=0.1)
    # White noise: its differences have twice its variance; those of the cycle are far smaller at 2000 samples/s.
    assert np.std(np.diff(made.raw.pressure, 3)) / np.sqrt(20) == pytest.approx(0.2, rel=0.05)


def test_ventilation_lifts_pressure_and_lowers_flow_only_in_inspiration():
    quiet = synthetic_raw_recording(CYCLE, rng(), disturbances=NONE)
    asked = Disturbances(**{**vars(NONE), "breaths_per_minute": 60, "ventilation_pressure": 2, "ventilation_flow": 0.1})
    made = synthetic_raw_recording(CYCLE, rng(), disturbances=asked)
    lift = made.raw.pressure - quiet.raw.pressure
    assert lift.max() == pytest.approx(2.0, abs=1e-3)
    assert np.mean(lift > 1e-9) == pytest.approx(0.4, abs=0.01)
    assert np.all(made.raw.flow[lift < 1e-12] == quiet.raw.flow[lift < 1e-12])
    assert made.inspiration.max() <= 1


def test_a_late_flow_is_the_same_flow_later():
    straight = synthetic_raw_recording(CYCLE, rng(), disturbances=NONE)
    late = synthetic_raw_recording(CYCLE, rng(), disturbances=NONE, flow_delay=0.005)
    np.testing.assert_allclose(late.raw.flow[10:], straight.raw.flow[:-10], atol=1e-9)
    np.testing.assert_array_equal(late.raw.pressure, straight.raw.pressure)


def test_the_same_seed_makes_the_same_recording_and_another_another():
    first, again, other = (synthetic_raw_recording(CYCLE, rng(seed)) for seed in (1, 1, 2))
    np.testing.assert_array_equal(first.raw.pressure, again.raw.pressure)
    assert not np.array_equal(first.raw.pressure, other.raw.pressure)


def test_a_recording_of_no_length_is_refused():
    with pytest.raises(InputError, match="must be positive"):
        synthetic_raw_recording(CYCLE, rng(), duration=0)
