"""Sizes of a network, places in it and stretches of a cycle, on the edge of each rule."""

import numpy as np
import pytest

import vasowave as vw
from vasowave.calibration.sites import places_of
from vasowave.errors import InputError
from vasowave.model.nominal import time_constant, upstroke
from vasowave.network.remarks import _WIDER, implausible_sizes
from vasowave.network.tidying import _NAMED, repaired
from vasowave.recording.wedge import SAME_PERIOD


def line(*sizes):
    radius, length = np.transpose(sizes)
    return vw.Network(tuple("abcdef"[: len(radius)]), np.arange(len(radius)) - 1, length, radius)


def codes(network):
    return [one.code.rpartition(".")[2] for one in implausible_sizes(network)]


@pytest.mark.parametrize(("ratio", "odd"), [(1.5, False), (1.49, True), (150.0, False), (150.1, True)])
def test_vessels_are_one_and_a_half_to_150_times_as_long_as_wide(ratio, odd):
    assert (len(codes(line((0.0625, 0.0625 * ratio)))) == 1) == odd


@pytest.mark.parametrize(("radius", "odd"), [(0.004, False), (0.0039, True), (2.0, False), (2.01, True)])
def test_a_root_is_as_wide_as_some_animals(radius, odd):
    assert (len(codes(line((radius, 16 * radius)))) == 1) == odd


def test_a_daughter_hardly_exceeds_its_parent():
    assert codes(line((0.0625, 1.0), (0.0625 * _WIDER, 1.0))) == []
    assert len(codes(line((0.0625, 1.0), (0.0626 * _WIDER, 1.0)))) == 1


def test_repairs_are_named_up_to_a_number():
    assert repaired(vw.control_network())[1] == []
    network = vw.control_network()
    parents = np.append(network.parent, np.repeat(network.terminals, 1)[: _NAMED + 1])
    extra = len(parents) - len(network)
    longer = vw.Network(
        (*network.name, *(f"x{i}" for i in range(extra))), parents,
        np.append(network.length, np.full(extra, 1e-4)), np.append(network.radius, network.radius[parents[-extra:]]),
    )  # fmt: skip
    found, (told,) = repaired(longer)
    assert len(found) < len(longer)
    assert ("more" in str(told)) == (extra > _NAMED)


def test_sites_lie_in_a_vessel_and_have_the_period_of_the_recording():
    network = line((0.05, 0.5), (0.04, 0.25))
    wave = 1 + np.sin(np.pi * np.arange(64) / 32)

    def at(period=0.1, **place):
        return places_of([vw.Observation("flow", "b", 0.1, waveform=wave, period=period, **place)], network, 0.1)

    assert (at(cm=0.25).vessel.tolist(), at(cm=0.25).share.tolist()) == ([1], [1.0])
    with pytest.raises(InputError, match=r"the vessel is 0.25 cm long; the place lies beyond it"):
        at(cm=0.2501)
    at(period=0.1 * (1 + 0.99 * SAME_PERIOD))
    for factor in (1 + 1.01 * SAME_PERIOD, 1 - 1.01 * SAME_PERIOD):
        with pytest.raises(InputError, match="its cycle lasts"):
            at(period=0.1 * factor)
    with pytest.raises(InputError, match="has no vessel 'z'"):
        places_of([vw.Observation("flow", "z", 0.1, mean=1.0)], network, 0.1)
    with pytest.raises(InputError, match="is no site"):
        places_of(["b"], network, 0.1)


def test_a_time_constant_is_that_of_an_exponential_of_four_samples_and_more():
    time = np.arange(8) / 100
    assert time_constant(time, 9 * np.exp(-time / 0.07)) == pytest.approx(0.07)
    assert time_constant(time[:4], 9 * np.exp(-time[:4] / 0.07)) == pytest.approx(0.07)
    for wrong in ((time[:3], np.exp(-time[:3])), (time, np.append(np.exp(-time[1:]), 0.0))):
        with pytest.raises(InputError, match="no diastolic decay of positive pressure"):
            time_constant(*wrong)
    for rising in (np.exp(time), np.ones(8)):
        with pytest.raises(InputError, match="does not fall after ejection"):
            time_constant(time, rising + 0.0)


def test_an_upstroke_reaches_from_five_to_ninety_five_percent_of_the_peak():
    share = np.arange(100) / 100
    flow = np.where(share < 0.4, np.minimum(share / 0.2, np.maximum(2 - share / 0.2, 0.0)), 0.0)
    recording = vw.Recording(10 + 5 * flow, flow, 0.1)
    q, p = upstroke(recording)
    assert (q[0], q[-1]) == (pytest.approx(0.05), pytest.approx(0.95))
    assert p == pytest.approx(10 + 5 * q)
    assert np.diff(q) == pytest.approx(0.05)


def test_waves_need_four_samples_and_positive_properties():
    p, q = 10 + np.sin(np.arange(4.0)), 0.2 + 0.1 * np.sin(np.arange(4.0))
    vw.wave_intensity(p, q, 0.1, 0.007, 200.0, 8e-4)
    with pytest.raises(InputError, match="at least 4"):
        vw.wave_intensity(p[:3], q[:3], 0.1, 0.007, 200.0, 8e-4)
    for place, name in enumerate(("period", "area", "wave speed", "density")):
        given = [0.1, 0.007, 200.0, 8e-4]
        given[place] = 0.0
        with pytest.raises(InputError, match=f"{name} must be positive"):
            vw.wave_intensity(p, q, *given)
