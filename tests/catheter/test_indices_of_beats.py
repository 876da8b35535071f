"""The spread of what a recording tells over its beats."""

from dataclasses import replace

import numpy as np
import pytest

import vasowave as vw
from vasowave.catheter import synthetic_raw_recording


def test_the_indices_of_beats_scatter_about_those_of_their_mean():
    raw = synthetic_raw_recording(vw.virtual_mouse(), np.random.default_rng(1), duration=6.0).raw
    average = vw.average_beats(raw, 12)
    beats, mean = vw.beat_indices(average), vw.cycle_indices(average).values
    assert len(beats) == 12
    for name in ("SV", "ejection_time", "power", "dp_dt_max", "E_a_artery"):
        assert beats[name].mean() == pytest.approx(mean[name], rel=0.05)
    starts = [beat.start for beat in average.beats if beat.averaged]
    assert list(beats.index) == starts
    ends = [beat.end for beat in average.beats if beat.averaged]
    np.testing.assert_allclose(beats["HR"], 60 / (np.array(ends) - starts))


@pytest.mark.filterwarnings("ignore::vasowave.base.VasowaveWarning")
def test_beats_that_are_advanced_do_not_ring_and_hold_the_wedge():
    raw = synthetic_raw_recording(vw.virtual_mouse(), np.random.default_rng(1), duration=6.0).raw
    time = np.arange(len(raw.flow)) / raw.sampling_rate
    breathing = replace(raw, flow=raw.flow + 0.3 * np.ptp(raw.flow) * np.sin(2 * np.pi * 1.3 * time))
    spreads = []
    for correct_delay in (False, True):
        average = vw.average_beats(breathing, 12, correct_delay=correct_delay, reject_ventilation=False)
        spreads.append(vw.beat_indices(average)["ejection_time"].std())
    assert spreads[1] < 2 * spreads[0] + 1e-4
    average = vw.average_beats(raw, 12)
    cycle = replace(average.recording, wedge_pressure=8.0)
    assert vw.beat_indices(average, cycle)["PVR"].mean() == pytest.approx(cycle.vascular_resistance, rel=0.05)
