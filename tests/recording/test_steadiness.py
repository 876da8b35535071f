"""A flow or a pulse that changes while the animal is recorded is told; one that stays, or scatters, is not."""

from dataclasses import replace

import numpy as np
import pytest

import vasowave as vw
from vasowave.datasets.raw import synthetic_raw_recording
from vasowave.recording.steadiness import unsteady

pytestmark = pytest.mark.filterwarnings("ignore::vasowave.errors.VasowaveWarning")


def said(change: float) -> list[dict]:
    """Return what is said of a recording whose flow changes by a share, evenly from its start to its end."""
    raw = synthetic_raw_recording(vw.virtual_mouse(), np.random.default_rng(5), duration=12.0).raw
    flow = raw.flow * (1 + change * np.linspace(0, 1, len(raw.flow)))
    average = vw.average_beats(replace(raw, flow=flow), 10)
    return [dict(one.values) for one in average.findings if one.code == "recording.unsteady"]


def test_a_flow_that_falls_by_two_fifths_is_told_with_its_size():
    (found,) = said(-0.4)
    assert found["what"] == "the mean flow"
    # between the middles of first and last quarter: 0.65 of 0.95 is left
    assert found["percent"] == pytest.approx(100 * (0.65 / 0.95 - 1), abs=4)


@pytest.mark.parametrize("change", [0.0, -0.1, 0.1])
def test_of_an_animal_that_stays_the_same_nothing_is_said(change):
    assert said(change) == []


def test_a_pulse_that_doubles_is_told_unless_beats_scatter_as_much_as_it_changes():
    rng, wave = np.random.default_rng(1), np.sin(np.linspace(0, np.pi, 50))
    size = np.repeat([1.0, 1.5, 2.0], [10, 20, 10])
    flow = np.ones((40, 50))
    (found,) = unsteady(size[:, None] * wave, flow, 1.0, 2.0)
    assert dict(found.values) == {
        "what": "the pulse pressure",
        "percent": pytest.approx(100.0),
        "start": 1.0,
        "end": 2.0,
    }
    scattering = size * rng.lognormal(0, 1.0, 40)
    assert unsteady(scattering[:, None] * wave, flow, 1.0, 2.0) == []
    assert unsteady(size[:12, None] * wave, flow[:12], 1.0, 2.0) == []  # too few beats to tell
