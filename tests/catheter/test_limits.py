"""Every limit that a recording must keep, with a case on either side of it."""

import numpy as np
import pytest
from scipy import signal

from vasowave.base import InputError, units
from vasowave.catheter.check import check_closure, check_flow, check_period, check_pressure, odd_values, resting_flow
from vasowave.catheter.read import read_wedge
from vasowave.catheter.signals import RawRecording
from vasowave.pulse.cycle import Inflow, InletPressure, Observation, Recording, one_cycle, resample, samples_needed

SHARE = np.arange(200) / 200
WAVE = np.sin(2 * np.pi * SHARE)
PRESSURE, FLOW = 16 + 5 * WAVE, 0.2 + 0.25 * WAVE


def codes(pressure=PRESSURE, flow=FLOW, period=0.11):
    return [one.code for one in odd_values(pressure, flow, period)]


@pytest.mark.parametrize(
    ("period", "said"),
    [
        (0.0399, "here: period 0.0399 s is 1.5e\\+03 beats/min, which no heart has; is the unit of time right"),
        (3.01, "here: period 3.01 s is 19.9 beats/min, which no heart has; is it in ms"),
        (0.0, "here: period 0 s is not a positive number"),
        (-1.0, "period -1 s is not a positive number"),
        (np.inf, "period inf s is not a positive number"),
    ],
)
def test_a_period_that_no_heart_has_is_refused(period, said):
    for slowest_or_fastest in (0.04, 3.0):
        check_period(slowest_or_fastest, "here")
    with pytest.raises(InputError, match=said):
        check_period(period, "here")


def test_pressures_of_an_artery_lie_between_4_and_150_mmhg():
    check_pressure(WAVE + 4.0 - WAVE.mean() + 1e-9, "here")
    check_pressure(WAVE + 150.0 - WAVE.mean() - 1e-9, "here")
    with pytest.raises(InputError, match=r"mean pressure 3.9 mmHg looks like kPa \(3.9 kPa = 29.3 mmHg\)"):
        check_pressure(WAVE + 3.9, "here")
    with pytest.raises(InputError, match="mean pressure 151 mmHg is too high for an artery"):
        check_pressure(WAVE + 151.0, "here")
    for given, held, mean in (("kPa", "mmHg", 22.0), ("mmHg", "Pa", 16.0)):  # what was stated, and what the numbers are
        numbers = (WAVE + mean - WAVE.mean()) / units.factor(held, "pressure")
        with pytest.raises(InputError, match=rf"in {held} their mean is {mean:g} mmHg") as refused:
            check_pressure(numbers * units.factor(given, "pressure"), "here")
        assert refused.value.cures[0].cells == (("pressure unit", held),)
    with pytest.raises(InputError, match=r"mean pressure 0.5 mmHg is too low"):  # 3.75 mmHg if it were kPa
        check_pressure(0.1 * WAVE + 0.5, "here")
    with pytest.raises(InputError, match=r"mean pressure 0.6 mmHg looks like kPa"):  # 4.5 mmHg
        check_pressure(0.1 * WAVE + 0.6, "here")
    with pytest.raises(InputError, match="mean pressure -1 mmHg is not positive"):
        check_pressure(WAVE - 1.0, "here")
    with pytest.raises(InputError, match="the pressure is constant"):
        check_pressure(16 + 1e-9 * WAVE, "here")
    check_pressure(16 + 1e-7 * WAVE, "here")


def test_a_flow_leaves_the_heart_and_pulsates():
    check_flow(FLOW, "here")
    check_flow(np.array([-0.5, 0.5, 0.5, 0.5]), "here")  # as large backward as forward
    with pytest.raises(InputError, match=r"the largest flow is backward \(-0.51 against 0.5 ml/s\)"):
        check_flow(np.array([-0.51, 0.5, 0.5, 0.5]), "here")
    with pytest.raises(InputError, match="the flow is constant"):
        check_flow(np.full(4, 0.2), "here")
    with pytest.raises(InputError, match="mean flow 0 ml/s"):
        check_flow(np.array([0.5, -0.5]), "here")


def test_what_is_possible_and_odd_is_told_from_its_limit_on():
    assert codes() == []
    assert codes(pressure=75 - PRESSURE.mean() + PRESSURE) == []
    assert codes(pressure=75.1 - PRESSURE.mean() + PRESSURE) == ["recording.systemic-pressure"]
    assert codes(pressure=16 + 16 * WAVE) == []  # down to 0
    assert codes(pressure=15 + 16 * WAVE) == ["recording.pressure-below-zero"]
    for factor, odd in ((0.1001, False), (0.0999, True), (19.99, False), (20.1, True)):
        assert codes(flow=factor * FLOW) == ["recording.odd-flow"] * odd, factor
    assert codes(flow=20.1 * FLOW, period=0.25) == []  # a slow heart's may be any animal's


def test_a_flow_that_rests_away_from_zero_is_told_from_a_fiftieth_of_its_mean_and_elsewhere_up_to_a_half():
    ejection = np.where(SHARE < 0.4, np.sin(np.pi * SHARE / 0.4), 0.0)
    for level, told in ((0.0, False), (0.015, False), (0.025, True), (-0.025, True), (0.45, True), (0.55, True)):
        flow = 0.2 * (level + (1 - level) * ejection / ejection.mean())  # rests at `level` of its mean
        assert resting_flow(flow) == pytest.approx(0.2 * level, abs=1e-12)
        found = [one for one in odd_values(PRESSURE, flow, 0.11) if one.code == "recording.flow-off-zero"]
        assert len(found) == told, level
        if found:
            values = dict(found[0].values)
            assert values["percent"] == pytest.approx(100 * level)
            assert values["mean"] == pytest.approx(0.2 * (1 - level))
        elsewhere = odd_values(PRESSURE, flow, 0.11, "carotid")  # where blood flows all the time
        assert ("recording.flow-off-zero" in [one.code for one in elsewhere]) == (told and level < 0.5)
    assert resting_flow(FLOW) == 0.0  # a sine rests nowhere


def test_a_flow_that_begins_late_is_told_from_2_5_percent_of_the_cycle():
    time = np.arange(800) / 800

    def pulse(delay):
        return np.exp(-0.5 * ((time - 0.4 - delay) / 0.06) ** 2)

    for delay, told in ((0.0, 0), (0.02, 0), (0.03, 1), (-0.05, 0)):
        found = odd_values(12 + 8 * pulse(0.0), 0.01 + pulse(delay), 0.11)
        assert [one.code for one in found].count("recording.late-flow") == told, delay
    values = dict(odd_values(12 + 8 * pulse(0.0), 0.01 + pulse(0.05), 0.11)[-1].values)
    assert values["percent"] == pytest.approx(5.0, abs=0.15)
    assert values["delay"] == pytest.approx(5.5, abs=0.16)  # ms


def test_a_cycle_closes_up_to_a_twentieth_of_its_range_beyond_its_largest_step():
    slope = np.linspace(0.0, 1.0, 101)
    values = np.concatenate([slope, slope[::-1]])  # steps of 0.01

    def opened(jump):
        return np.append(values[:-1], jump)  # the last sample is `jump` above the first

    assert check_closure(opened(0.015), "p", "here") == []
    (told,) = check_closure(np.r_[values[:-4], 0.04, 0.035], "p", "here")
    assert dict(told.values)["percent"] == pytest.approx(3.5)
    assert check_closure(np.r_[values[:-6], 0.05, 0.055], "p", "here")
    with pytest.raises(InputError, match=r"it ends at 0.07 and starts at 0 \(7 % of its range\)"):
        check_closure(values[:-7], "p", "here")


def test_a_cycle_knows_its_indices():
    cycle = Recording(12 + 4 * WAVE, 0.2 + 0.1 * WAVE[::2], 0.12, wedge_pressure=4.0)
    assert cycle.indices() == pytest.approx(
        {"HR": 500, "CO": 0.2, "mPAP": 12, "sPAP": 16, "dPAP": 8, "pPAP": 8, "PVR": 40}
    )
    assert cycle.input_resistance == pytest.approx(60)


@pytest.mark.parametrize("errors", [[[1.0]], [], [1.0, -1.0], [np.nan]])
def test_errors_that_are_not_one_for_each_harmonic_are_refused(errors):
    with pytest.raises(InputError, match="flow_error: give one standard error for each harmonic, the mean's first"):
        Recording(PRESSURE, FLOW, 0.11, flow_error=errors)


def test_one_cycle_is_taken_of_what_has_one():
    cycle = Recording(PRESSURE, FLOW, 0.11)
    assert one_cycle(cycle) is cycle
    with pytest.raises(InputError, match=r"average its beats: raw\.average\(\)"):
        one_cycle(RawRecording(np.ones(500), np.ones(500), 300.0))
    with pytest.raises(InputError, match=r"'a\.csv' is the name of a file; read it first"):
        one_cycle("a.csv")


def test_flows_go_into_as_many_inlets_and_a_pressure_into_one():
    both = Inflow(np.c_[FLOW, 2 * FLOW], 0.11)
    assert np.array_equal(both.into(["a", "b"]), np.c_[FLOW, 2 * FLOW])
    names = ["a", "b", "c", "d", "e", "f"]
    with pytest.raises(InputError, match=r"has 6 inlet\(s\) \('a', 'b', 'c', 'd', 'e'\) and 2 inflow"):
        both.into(names)
    pressure = InletPressure(PRESSURE, 0.11)
    assert pressure.into(["a"]).shape == (200, 1)
    with pytest.raises(InputError, match=r"has 6 inlets \('a', 'b', 'c', 'd', 'e'\): a pressure drives one"):
        pressure.into(names)


def test_what_pulsates_behind_the_beds_has_no_mean_and_lies_below_the_mean_pressure():
    one = Recording(PRESSURE, FLOW, 0.11, wedge_pressure=15.9, wedge_pulsation=3 + WAVE)
    assert one.wedge_pulsation == pytest.approx(WAVE)
    for wedge in (16.0, 17.0):
        with pytest.raises(InputError, match="is not below the mean pressure"):
            Recording(PRESSURE + (16 - PRESSURE.mean()), FLOW, 0.11, wedge_pressure=wedge + 1e-9)


@pytest.mark.parametrize("kind", [lambda values: Recording(values, FLOW, 0.11), lambda values: Inflow(values, 0.11),
                                  lambda values: Observation("flow", "1", 0.01, waveform=values)])  # fmt: skip
def test_the_first_sample_that_is_no_number_is_named(kind):
    values = PRESSURE.copy()
    values[[6, 9]] = np.nan, np.inf
    with pytest.raises(InputError, match="sample 7 is nan; fill the gap first"):
        kind(values)


def test_a_gap_in_a_raw_recording_is_named_by_its_time():
    values = np.tile(PRESSURE, 10)
    values[[250, 300]] = np.nan
    with pytest.raises(InputError, match=r"flow has a gap at 0.2500 s"):
        RawRecording(np.tile(PRESSURE, 10), values, 1000.0)
    with pytest.raises(InputError, match=r"19.9 samples/s"):
        RawRecording(np.tile(PRESSURE, 10), np.tile(FLOW, 10), 19.9)
    assert RawRecording(np.tile(PRESSURE, 10), np.tile(FLOW, 10), 20.0).duration == 100.0


def wedge_file(path, count, mean=8.0, swing=2.0, unit=" [mmHg]", step=0.001):
    time = np.arange(count) * step
    rows = np.c_[time, mean + swing * np.sin(2 * np.pi * time / (count * step))]
    np.savetxt(path, rows, "%.6f", ",", header=f"time [s],pressure{unit}", comments="")
    return path


def test_a_wedge_of_nearly_the_recordings_period_is_taken_without_its_mean(tmp_path):
    wedge = read_wedge(wedge_file(tmp_path / "la.csv", 101), 0.1)  # 1 % longer
    assert wedge.mean == pytest.approx(8.0, abs=1e-6)
    assert wedge.pulsation.max() == pytest.approx(2.0, abs=2e-3)
    assert wedge.findings == ()
    assert [one.code for one in read_wedge(wedge_file(tmp_path / "b.csv", 101, unit=""), 0.1).findings] == [
        "recording.assumed-unit"
    ]


@pytest.mark.parametrize(("count", "taken"), [(97, False), (99, True), (101, True), (103, False)])
def test_periods_may_differ_by_2_percent(tmp_path, count, taken):
    path = wedge_file(tmp_path / "la.csv", count)
    if taken:
        read_wedge(path, 0.1)
    else:
        with pytest.raises(InputError, match=f"its cycle lasts {count / 1000:g} s and that of the recording 0.1 s"):
            read_wedge(path, 0.1)


def test_no_atrium_lies_below_minus_five(tmp_path):
    read_wedge(wedge_file(tmp_path / "a.csv", 100, -2.9), 0.1)
    with pytest.raises(InputError, match=r"falls to -5.1 mmHg"):
        read_wedge(wedge_file(tmp_path / "b.csv", 100, -3.1), 0.1)


@pytest.mark.parametrize("here", [8, 9, 16, 33])
@pytest.mark.parametrize("count", [8, 9, 12, 16, 41])
def test_resampling_is_that_of_scipy_for_even_and_odd_numbers_up_and_down(here, count):
    values = np.random.default_rng(here).normal(0, 1, (here, 2))
    assert resample(values, count) == pytest.approx(signal.resample(values, count), abs=1e-12)
    assert resample(values[:, 0], count) == pytest.approx(signal.resample(values[:, 0], count), abs=1e-12)


def test_samples_that_carry_all_harmonics_are_two_for_each_and_one():
    assert samples_needed(16 + sum(np.cos(2 * np.pi * k * SHARE) for k in range(1, 21))) == 41
    assert samples_needed(16 + np.cos(2 * np.pi * SHARE)) == 3
    assert samples_needed(np.random.default_rng(1).normal(0, 1, 40)) == 40
