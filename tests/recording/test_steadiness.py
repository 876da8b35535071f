"""A flow or a pulse that changes while the animal is recorded is told; one that stays, or scatters, is not."""

from dataclasses import replace

import numpy as np
import pytest

import vasowave as vw
from vasowave.datasets.raw import synthetic_raw_recording
from vasowave.recording.steadiness import unsteady

pytestmark = pytest.mark.filterwarnings("ignore::vasowave.errors.VasowaveWarning")


def said(course, code="recording.unsteady") -> list[dict]:
    """Return what is said of a recording whose flow is multiplied by a course over 0 to 1 of its time."""
    raw = synthetic_raw_recording(vw.virtual_mouse(), np.random.default_rng(5), duration=12.0).raw
    flow = raw.flow * (1 + course(np.linspace(0, 1, len(raw.flow))))
    average = vw.average_beats(replace(raw, flow=flow), 10)
    return [dict(one.values) for one in average.findings if one.code == code]


def test_a_flow_that_falls_by_two_fifths_is_told_with_its_size():
    (found,) = said(lambda time: -0.4 * time)
    assert (found["what"], found["earlier"], found["later"]) == ("the mean flow", 1, 4)
    # between the middles of first and last quarter: 0.65 of 0.95 is left
    assert found["percent"] == pytest.approx(100 * (0.65 / 0.95 - 1), abs=4)


def test_a_flow_that_sags_and_recovers_is_told_too():
    (found,) = said(lambda time: np.where(np.abs(time - 0.375) < 0.125, -0.5, 0.0))
    assert found["percent"] == pytest.approx(-50.0, abs=4)
    assert (found["earlier"], found["later"]) == (1, 2)


@pytest.mark.parametrize("change", [0.0, -0.1, 0.1])
def test_of_an_animal_that_stays_the_same_nothing_is_said(change):
    assert said(lambda time: change * time) == []


def test_a_pulse_that_doubles_is_told_unless_beats_scatter_as_much_as_it_changes():
    rng, wave = np.random.default_rng(1), np.sin(np.linspace(0, np.pi, 50))
    size = np.repeat([1.0, 1.5, 2.0], [10, 20, 10])
    flow, all_used = np.ones((40, 50)), np.ones(40, bool)
    (found,) = unsteady(size[:, None] * wave, flow, all_used, 1.0, 2.0)
    assert dict(found.values) == {
        "what": "the pulse pressure", "percent": pytest.approx(100.0), "earlier": 1, "later": 4, "start": 1.0,
        "end": 2.0,
    }  # fmt: skip
    scattering = size * rng.lognormal(0, 1.0, 40)
    assert unsteady(scattering[:, None] * wave, flow, all_used, 1.0, 2.0) == []
    assert unsteady(size[:12, None] * wave, flow[:12], all_used[:12], 1.0, 2.0) == []  # too few beats to tell


def test_the_share_by_which_averaged_beats_are_off_is_that_of_the_means():
    flow = np.repeat([[1.0], [1.25]], 20, axis=0) * np.ones(50)
    pressure = np.ones((40, 1)) * np.sin(np.linspace(0, np.pi, 50))
    used = np.arange(40) >= 30
    told = [dict(one.values) for one in unsteady(pressure, flow, used, 1.0, 2.0) if one.code.endswith("apart")]
    assert told == [{"what": "the mean flow", "percent": pytest.approx(100 * (1.25 / 1.125 - 1))}]
    assert not [one for one in unsteady(pressure, flow, np.zeros(40, bool), 1.0, 2.0) if one.code.endswith("apart")]
