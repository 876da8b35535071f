"""Beats that are kept cut give the average that is made of the recording anew."""

from dataclasses import replace

import numpy as np
import pytest

from lab_files import recorded
from vasowave.catheter import average_beats, average_prepared
from vasowave.catheter.beats import Averaging, BeatEdit, prepare

pytestmark = pytest.mark.filterwarnings("ignore::vasowave.base.errors.VasowaveWarning")  # the level is made to move


@pytest.fixture(scope="module")
def raw():
    """Half a minute whose level drifts and steps."""
    made = recorded(4, 14.0, drift=1.5, duration=30.0)
    return replace(made, pressure=made.pressure + 1.2 * (made.time > 18.0))


def test_edits_of_beats_that_are_kept_cut_give_what_the_recording_read_anew_gives(raw):
    kept = prepare(raw, Averaging())
    found = [one for one in average_prepared(kept).beats if not one.rejected]
    edits = []
    for more in (
        BeatEdit("reject", found[6].start + 0.01), BeatEdit("move", found[9].start, found[9].start + 0.002),
        BeatEdit("move", found[2].start, found[2].start - 0.001), BeatEdit("keep", found[6].start + 0.01),
    ):  # fmt: skip
        edits.append(more)
        kept = kept.with_moves(edits)
        ours = average_prepared(kept, edits)
        anew = average_beats(raw, edits=edits)
        # The spline of the whole recording and that of 64 samples around a beat differ by round-off alone.
        for one, other in zip(_arrays(ours), _arrays(anew), strict=True):
            np.testing.assert_allclose(one, other, rtol=0, atol=1e-11)
        assert ours.beats == anew.beats
        assert ours.findings == anew.findings


def test_the_mean_drift_of_a_beat_is_the_mean_of_the_drift_at_its_samples(raw):
    average = average_beats(raw)
    starts, ends = (np.array([getattr(one, name) for one in average.beats]) for name in ("start", "end"))
    assert average.baseline.steps
    times = starts[:, None] + np.outer(ends - starts, np.linspace(0, 1, 257))
    there = average.baseline.drift_at(times).mean(axis=1)
    np.testing.assert_allclose(average.baseline.mean_within(starts, ends, 257), there, rtol=0, atol=1e-12)


def _arrays(average):
    return (average.recording.pressure, average.recording.flow, average.pressure_sd, average.flow_sd,
            average.baseline.level, [average.recording.period, average.delay])  # fmt: skip
