"""The figures of the beats show what was detected, averaged and rejected."""

import matplotlib as mpl
import numpy as np
import pytest

from approval import PAPER, approve, figure
from made_cohort import bare_result
from vasowave.base import InputError, VasowaveWarning
from vasowave.catheter import Disturbances, average_beats, synthetic_raw_recording
from vasowave.pulse.cycle import Recording
from vasowave.study.animal import beats_dataset, recording_dataset
from vasowave.study.figures import plot_baseline, plot_detected_beats, plot_ensemble, svg

mpl.use("Agg")
PHASE = np.arange(256) / 256
CYCLE = Recording(13 + 5 * np.sin(2 * np.pi * PHASE - 1.5), 0.2 + 0.2 * np.sin(2 * np.pi * PHASE - 1.2), 0.11)


@pytest.fixture(scope="module")
def made():
    asked = Disturbances(ventilation_pressure=3)
    raw = synthetic_raw_recording(CYCLE, np.random.default_rng(1), disturbances=asked).raw
    average = average_beats(raw)
    recording = recording_dataset(average.recording).assign(
        pressure_sd=("time", average.pressure_sd), flow_sd=("flow_time", average.flow_sd)
    )
    return bare_result(beats=beats_dataset(average, raw), recording=recording)


@pytest.fixture
def ax():
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots()
    yield axes
    plt.close(figure)


@pytest.mark.parametrize("signal", ["pressure", "flow", "ecg"])
def test_every_averaged_and_every_rejected_beat_is_shaded(ax, made, signal):
    beats = made.beats
    assert plot_detected_beats(ax, beats, signal) is ax
    shown = (beats["onset"] + beats["length"] >= beats["trace_time"][0]) & (beats["onset"] <= beats["trace_time"][-1])
    assert (
        sum(len(one.get_paths()) for one in ax.collections)
        == int((shown & ((beats["kept"] == 1) | (beats["reason"] != ""))).sum())
        > 20
    )
    assert {text.get_text() for text in ax.get_legend().get_texts()} == {"averaged", "rejected", "detected"}
    assert "[" in ax.get_ylabel()
    assert ax.get_xlabel() == "time [s]"


def test_the_band_is_one_standard_deviation_wide(ax, made):
    assert plot_ensemble(ax, made, "flow") is ax
    edges = ax.collections[0].get_paths()[0].vertices
    at_start = edges[np.isclose(edges[:, 0], 0.0), 1]
    assert np.ptp(at_start) == pytest.approx(2 * float(made.recording["flow_sd"][0]))
    np.testing.assert_allclose(ax.lines[0].get_ydata(), made.recording["flow"])


def test_the_drift_is_drawn_through_the_levels_with_its_size(ax):
    raw = synthetic_raw_recording(CYCLE, np.random.default_rng(2), baseline=lambda t: -0.3 * t, duration=12.0).raw
    with pytest.warns(VasowaveWarning, match="drifts by"):
        average = average_beats(raw)
    found = average.baseline
    beats = beats_dataset(average, raw)
    with pytest.raises(InputError, match="levels of the beats are not known"):
        plot_baseline(ax, beats.drop_vars("drift"))
    assert plot_baseline(ax, beats) is ax
    said = [text.get_text() for text in ax.get_legend().get_texts()]
    assert any(one.startswith("drift -3.") and one.endswith("mmHg, removed") for one in said)
    approve("baseline", figure("baseline", svg(ax.figure)), PAPER, 2e-3)
    line = ax.lines[-1].get_ydata()
    assert line[-1] - line[0] == pytest.approx(-3.6, abs=0.25)
    assert abs(np.median(found.level - line)) < 0.2


def test_a_signal_that_is_not_there_is_refused(ax, made):
    with pytest.raises(InputError, match="no signal 'qrs'"):
        plot_detected_beats(ax, made.beats, "qrs")
    with pytest.raises(InputError, match="neither"):
        plot_ensemble(ax, made, "ecg")
    without = bare_result(recording=made.recording.drop_vars("flow_sd"))
    with pytest.raises(InputError, match="came averaged"):
        plot_ensemble(ax, without, "flow")
