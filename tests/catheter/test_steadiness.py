"""A flow or a pulse that changes while the animal is recorded is told; one that stays, or scatters, is not."""

from dataclasses import replace

import numpy as np
import pytest

import vasowave as vw
from vasowave.catheter import synthetic_raw_recording
from vasowave.catheter.beats import Cuts, unsteady
from vasowave.catheter.signals import Plateau, RawRecording, saturated

pytestmark = pytest.mark.filterwarnings("ignore::vasowave.base.errors.VasowaveWarning")


def said(course, code="recording.unsteady") -> list[dict]:
    """Return what is said of a recording whose flow is multiplied by a course over 0 to 1 of its time."""
    raw = synthetic_raw_recording(vw.virtual_mouse(), np.random.default_rng(5), duration=12.0).raw
    flow = raw.flow * (1 + course(np.linspace(0, 1, len(raw.flow))))
    average = vw.average_beats(replace(raw, flow=flow), 10)
    return [dict(one.values) for one in average.findings if one.code == code]


def beats(pressure: np.ndarray, flow: np.ndarray) -> Cuts:
    """Return beats of 0.1 s, one after the other."""
    starts = 0.1 * np.arange(len(flow))
    return Cuts(starts, starts + 0.1, pressure, flow)


def test_a_flow_that_falls_by_two_fifths_is_told_with_its_size():
    (found,) = said(lambda time: -0.4 * time)
    assert found["what"] == "the mean flow"
    # between the middles of the first and the last quarter of the beats: 0.65 of 0.95 is left
    assert found["percent"] == pytest.approx(100 * (1 - 0.65 / 0.95), abs=4)
    assert found["high_start"] < 1.0
    assert found["low_end"] > 11.0


@pytest.mark.parametrize("middle", [0.15, 0.3, 0.375, 0.5, 0.62, 0.85])
@pytest.mark.parametrize("sag", [-0.5, -0.3])
def test_a_flow_that_sags_and_recovers_is_told_wherever_it_does(middle, sag):
    (found,) = said(lambda time: np.where(np.abs(time - middle) < 0.125, sag, 0.0))
    assert found["percent"] == pytest.approx(-100 * sag, abs=4)
    assert found["low"] == pytest.approx((1 + sag) * found["high"], rel=0.05)
    assert found["low_start"] < 12 * middle < found["low_end"]


@pytest.mark.parametrize("change", [0.0, -0.1, 0.1])
def test_of_an_animal_that_stays_the_same_nothing_is_said(change):
    assert said(lambda time: change * time) == []


def test_a_pulse_that_doubles_is_told_unless_beats_scatter_as_much_as_it_changes():
    rng, wave = np.random.default_rng(1), np.sin(np.linspace(0, np.pi, 51))
    size = np.repeat([1.0, 1.5, 2.0], [10, 20, 10])
    flow, all_used = np.ones((40, 51)), np.ones(40, bool)
    (found,) = unsteady(beats(size[:, None] * wave, flow), all_used, all_used, 1.0, 2.0)
    expected = {
        "what": "the pulse pressure", "unit": "mmHg", "percent": 50.0, "low": 1.0, "high": 2.0, "low_start": 0.0,
        "low_end": 1.0, "high_start": 2.6, "high_end": 3.6, "start": 1.0, "end": 2.0,
    }  # fmt: skip
    assert dict(found.values) == {key: pytest.approx(value) for key, value in expected.items()}
    scattering = size * rng.lognormal(0, 1.0, 40)
    assert unsteady(beats(scattering[:, None] * wave, flow), all_used, all_used, 1.0, 2.0) == []
    assert (
        unsteady(beats(size[:12, None] * wave, flow[:12]), all_used[:12], all_used[:12], 1.0, 2.0) == []
    )  # too few beats to tell


@pytest.mark.parametrize(("size", "told"), [(0.1, True), (0.03, False)])
def test_beats_that_alternate_are_told_with_the_size_of_it(size, told):
    rng, wave = np.random.default_rng(3), np.sin(np.linspace(0, np.pi, 51))
    pulse = (1 + 0.5 * size * (-1.0) ** np.arange(60)) * rng.normal(1.0, 0.01, 60)
    found = unsteady(beats(pulse[:, None] * wave, np.ones((60, 51))), *2 * [np.ones(60, bool)], 1.0, 2.0)
    alternating = [dict(one.values) for one in found if one.code == "recording.alternating"]
    assert alternating == ([{"what": "the pulse pressure", "percent": pytest.approx(100 * size, rel=0.1)}] * told)


@pytest.mark.parametrize("beats_in_a_breath", [2.5, 3.3, 4.0, 7.0, 20.0])
def test_neither_breaths_nor_chance_are_taken_for_beats_that_alternate(beats_in_a_breath):
    rng, wave = np.random.default_rng(4), np.sin(np.linspace(0, np.pi, 51))
    breath = 1 + 0.2 * np.sin(2 * np.pi * np.arange(200) / beats_in_a_breath)
    for pulse in (breath, rng.normal(1.0, 0.2, 200)):
        found = unsteady(beats(pulse[:, None] * wave, np.ones((200, 51))), *2 * [np.ones(200, bool)], 1.0, 2.0)
        assert "recording.alternating" not in [one.code for one in found]


WAVE = np.sin(2 * np.pi * np.arange(8000) / 109.37) ** 2


@pytest.mark.parametrize(
    "values",
    [
        10 + 15 * WAVE,
        10 + 15 * np.tile(WAVE[:80], 100),
        np.round(2 * (10 + 15 * WAVE)) / 2,  # a converter with steps of 0.5 mmHg
        np.round(10 + 15 * WAVE + 0.4 * np.sin(np.arange(8000) / 300), 2),
        10 + 15 * WAVE + np.random.default_rng(2).normal(0, 0.3, 8000),
        np.round(10 + 15 * WAVE + np.random.default_rng(2).normal(0, 0.3, 8000), 1),
    ],
    ids=["sine", "one beat again and again", "coarse steps", "breathing", "noise", "noise in steps"],
)
def test_a_peak_that_is_cut_off_is_told_and_one_that_is_round_is_not(values):
    """Cut at nine tenths of its range, before or after noise of a converter that rounds."""
    raw = RawRecording(values, 0.1 * WAVE, 1000.0)
    assert saturated(raw, (), 0.11) == []
    top = values.min() + 0.9 * np.ptp(values)
    (found,) = (dict(one.values) for one in saturated(replace(raw, pressure=np.minimum(values, top)), (), 0.11))
    assert (found["what"], found["value"]) == ("pressure", pytest.approx(top))
    assert found["percent"] == pytest.approx(100 * np.mean(values >= top), rel=0.2)  # runs of one or two do not count
    (of_flow,) = (dict(one.values) for one in saturated(replace(raw, flow=np.minimum(0.1 * WAVE, 0.09)), (), 0.11))
    assert of_flow["what"] == "flow"
    (upside_down,) = (dict(one.values) for one in saturated(replace(raw, pressure=-np.minimum(values, top)), (), 0.11))
    assert upside_down["value"] == pytest.approx(-top)
    assert (upside_down["end"], upside_down["parts"]) == ("smallest", "troughs")
    assert upside_down["percent"] == pytest.approx(found["percent"])


def test_a_flow_that_rests_at_zero_and_a_pressure_that_is_held_for_longer_than_a_beat_are_not_cut_off():
    flow = np.maximum(0.1 * np.sin(2 * np.pi * np.arange(8000) / 109.37), 0.0)
    raw = RawRecording(10 + 15 * WAVE, flow, 1000.0)
    assert saturated(raw, (), 0.11) == []
    (of_flow,) = (dict(one.values) for one in saturated(replace(raw, flow=np.maximum(flow - 0.05, -0.02)), (), 0.11))
    assert (of_flow["what"], of_flow["parts"], of_flow["value"]) == ("flow", "troughs", pytest.approx(-0.02))
    held = raw.pressure.copy()
    held[3000:3500] = 60.0
    flush = (Plateau(3.0, 3.5, 60.0),)
    assert saturated(replace(raw, pressure=held), flush, 0.11) == []
    assert len(saturated(replace(raw, pressure=held), flush, 0.5)) == 1  # it may be the flat part of a slow beat
    assert len(saturated(replace(raw, pressure=held), (), 0.11)) == 1
