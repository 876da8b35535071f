"""One recording that was exported twice, and two of one animal."""

from dataclasses import replace

import numpy as np
import pytest

from vasowave.datasets import virtual_mouse
from vasowave.datasets.raw import Disturbances, synthetic_raw_recording
from vasowave.recording.same_signal import Trace, are_of_one, trace_of


def made(seed, **more):
    rng = np.random.default_rng(seed)
    return synthetic_raw_recording(virtual_mouse(), rng, disturbances=replace(Disturbances(), **more)).raw


@pytest.mark.parametrize(
    "export",
    [
        lambda raw: replace(raw, **{name: getattr(raw, name)[517:] for name in ("pressure", "flow", "ecg")}),
        lambda raw: replace(raw, **{name: getattr(raw, name)[:-731] for name in ("pressure", "flow", "ecg")}),
        lambda raw: replace(raw, **{name: getattr(raw, name)[-4000:] for name in ("pressure", "flow", "ecg")}),
        lambda raw: replace(raw, pressure=np.round(raw.pressure, 1)),
        lambda raw: replace(raw, pressure=raw.pressure - 3.0),
    ],
    ids=["begins later", "ends earlier", "a fifth of it", "one decimal", "another zero"],
)
def test_what_was_cut_rounded_or_moved_is_still_one_recording(export):
    raw = made(3)
    assert are_of_one(trace_of(export(raw), 545.0), trace_of(raw, 545.0))
    assert are_of_one(trace_of(raw, 545.0), trace_of(export(raw), 545.0))


def test_stretches_of_one_recording_that_overlap_by_a_fifth_are_one():
    raw = made(6)
    first, later = (replace(raw, **{name: getattr(raw, name)[part] for name in ("pressure", "flow", "ecg")})
                    for part in (slice(None, 11000), slice(9000, None)))  # fmt: skip
    assert are_of_one(trace_of(first, 545.0), trace_of(later, 540.0))


def test_other_beats_are_another_recording():
    one, other, later = (trace_of(made(seed), 545.0) for seed in (3, 4, 5))
    assert not are_of_one(one, other)
    assert not are_of_one(later, other)
    raw = made(3)
    half = len(raw.pressure) // 2
    parts = [replace(raw, **{name: getattr(raw, name)[part] for name in ("pressure", "flow", "ecg")})
             for part in (slice(None, half), slice(half, None))]  # fmt: skip
    assert not are_of_one(*(trace_of(part, 545.0) for part in parts))  # of one animal, one after the other


def test_traces_of_other_rates_or_hearts_and_stretches_of_fewer_than_four_beats_are_not_compared():
    """Of 120 beats/min at 100 samples/s four beats are 200 samples."""
    pressure = np.random.default_rng(0).normal(size=1000).cumsum().astype(np.float32)
    whole = Trace(pressure, 100.0, 120.0)
    assert are_of_one(whole, whole)
    assert are_of_one(whole, replace_trace(whole, heart_rate=126.0))  # by a twentieth
    assert not are_of_one(whole, replace_trace(whole, heart_rate=126.1))
    assert not are_of_one(whole, replace_trace(whole, rate=100.1))
    assert are_of_one(whole, replace_trace(whole, pressure=pressure[300:500]))
    assert not are_of_one(whole, replace_trace(whole, pressure=pressure[300:499]))
    slow, slower = (replace_trace(whole, heart_rate=rate) for rate in (119.5, 119.0))
    assert are_of_one(slow, slow)  # four beats are 200.8 samples, and 200 are the longest stretch
    assert not are_of_one(slower, slower)  # 201.7


def replace_trace(one, **more):
    return Trace(**{"pressure": one.pressure, "rate": one.rate, "heart_rate": one.heart_rate, **more})
