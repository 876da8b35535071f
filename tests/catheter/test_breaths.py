"""What returns with every breath is found, whatever the level it stands on and wherever the recording stops."""

import numpy as np
import pytest

from vasowave.catheter.baseline import breathing

HARMONICS = 4  # of a breath


@pytest.mark.parametrize("lasts", [5.0, 6.0])  # s: two and a half breaths, and three
def test_a_breath_has_mean_zero_also_where_the_recording_stops_within_one(lasts):
    time = np.arange(0.0, lasts, 0.1)
    breath = 2.0 * np.sin(2 * np.pi * 0.5 * time) + 0.5 * np.cos(4 * np.pi * 0.5 * time)
    found = breathing(time, 14.0 + breath, np.ones(len(time), dtype=bool))
    np.testing.assert_allclose(found, breath, atol=0.02)


def test_a_breath_is_the_wave_that_least_squares_finds_at_its_rate_and_spoiled_beats_do_not_count():
    """Uneven beats; its harmonics are fitted by NumPy's own solver, at the rate that leaves least."""
    rng = np.random.default_rng(7)
    time = np.cumsum(rng.normal(0.11, 0.004, 300))
    level = np.maximum(0.0, np.sin(2 * np.pi * 1.37 * time)) ** 3 + 0.1 * rng.standard_normal(300)
    used = rng.random(300) > 0.15
    here, values = time[used] - time[0], level[used] - level[used].mean()

    def waves(at, rate):
        phase = 2 * np.pi * rate * np.outer(at, np.arange(1, HARMONICS + 1))
        return np.hstack([np.ones((len(at), 1)), np.cos(phase), np.sin(phase)])

    rates = np.arange(1.30, 1.44, 2e-4)
    left = [np.linalg.lstsq(waves(here, rate), values, rcond=None)[1][0] for rate in rates]
    rate = rates[np.argmin(left)]
    found = np.linalg.lstsq(waves(here, rate), values, rcond=None)[0]
    expected = waves(time - time[0], rate)[:, 1:] @ found[1:]
    np.testing.assert_allclose(breathing(time, np.where(used, level, 50.0), used), expected, atol=0.01)


def test_levels_that_do_not_repeat_hold_no_breath():
    time = np.arange(0.0, 8.0, 0.1)
    level = np.random.default_rng(0).normal(14.0, 1.0, len(time))
    np.testing.assert_array_equal(breathing(time, level, np.ones(len(time), dtype=bool)), 0.0)


@pytest.mark.parametrize("seed", range(4))
def test_a_beat_out_of_step_is_no_breath_that_keeps_step_with_the_heart(seed):
    """Even beats, the first of which begins 4 ms late and stands nine standard deviations off."""
    time = 0.12 * np.arange(66)
    level = np.random.default_rng(seed).normal(14.4, 0.019, len(time))
    time[0] += 0.002
    level[0] += 0.17
    np.testing.assert_array_equal(breathing(time, level, np.ones(len(time), dtype=bool)), 0.0)
