"""What returns with every breath is found, whatever the level it stands on and wherever the recording stops."""

import numpy as np
import pytest

from vasowave.recording.breaths import breathing


@pytest.mark.parametrize("lasts", [5.0, 6.0])  # s: two and a half breaths, and three
def test_a_breath_has_mean_zero_also_where_the_recording_stops_within_one(lasts):
    time = np.arange(0.0, lasts, 0.1)
    breath = 2.0 * np.sin(2 * np.pi * 0.5 * time) + 0.5 * np.cos(4 * np.pi * 0.5 * time)
    found = breathing(time, 14.0 + breath, np.ones(len(time), dtype=bool))
    np.testing.assert_allclose(found, breath, atol=0.02)


def test_levels_that_do_not_repeat_hold_no_breath():
    time = np.arange(0.0, 8.0, 0.1)
    level = np.random.default_rng(0).normal(14.0, 1.0, len(time))
    np.testing.assert_array_equal(breathing(time, level, np.ones(len(time), dtype=bool)), 0.0)
