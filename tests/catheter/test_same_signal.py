"""One recording that was exported twice, and two of one animal."""

from dataclasses import replace

import numpy as np
import pytest

from vasowave.catheter import Disturbances, synthetic_raw_recording
from vasowave.catheter.signals import are_of_one, trace_of
from vasowave.pulse.examples import virtual_mouse


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
