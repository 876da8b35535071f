"""Every limit that a recording must keep, with a case on either side of it."""

import numpy as np
import pytest
from scipy import signal

from vasowave.errors import InputError
from vasowave.recording import (
    Beats,
    Catheter,
    Inflow,
    Observation,
    RawRecording,
    Recording,
    correct_catheter,
    read_wedge,
)
from vasowave.recording.choosing import with_time
from vasowave.recording.cycle import InletPressure, resample, samples_needed
from vasowave.recording.plausibility import (
    check_closure,
    check_flow,
    check_period,
    check_pressure,
    moves_at_ends,
    odd_values,
    repeats_first,
    resting_flow,
)
from vasowave.recording.read_sites import site_files

SHARE = np.arange(200) / 200
WAVE = np.sin(2 * np.pi * SHARE)
PRESSURE, FLOW = 16 + 5 * WAVE, 0.2 + 0.25 * WAVE


def codes(pressure=PRESSURE, flow=FLOW, period=0.11):
    return [one.code for one in odd_values(pressure, flow, period)]


@pytest.mark.parametrize("period", [0.04, 3.0])
def test_the_slowest_and_the_fastest_heart_are_hearts(period):
    check_period(period, "here")


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
def test_other_periods_are_none(period, said):
    with pytest.raises(InputError, match=said):
        check_period(period, "here")


def test_pressures_of_an_artery_lie_between_4_and_150_mmhg():
    check_pressure(WAVE + 4.0 - WAVE.mean() + 1e-9, "here")
    check_pressure(WAVE + 150.0 - WAVE.mean() - 1e-9, "here")
    with pytest.raises(InputError, match=r"mean pressure 3.9 mmHg looks like kPa \(3.9 kPa = 29.3 mmHg\)"):
        check_pressure(WAVE + 3.9, "here")
    with pytest.raises(InputError, match="mean pressure 151 mmHg is too high for an artery"):
        check_pressure(WAVE + 151.0, "here")
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


def test_a_flow_that_rests_away_from_zero_is_told_from_a_fiftieth_to_a_half_of_its_mean():
    ejection = np.where(SHARE < 0.4, np.sin(np.pi * SHARE / 0.4), 0.0)
    for level, told in ((0.0, False), (0.015, False), (0.025, True), (-0.025, True), (0.45, True), (0.55, False)):
        flow = 0.2 * (level + (1 - level) * ejection / ejection.mean())  # rests at `level` of its mean
        assert resting_flow(flow) == pytest.approx(0.2 * level, abs=1e-12)
        found = [one for one in odd_values(PRESSURE, flow, 0.11) if one.code == "recording.flow-off-zero"]
        assert len(found) == told, level
        if found:
            values = dict(found[0].values)
            assert values["percent"] == pytest.approx(100 * level)
            assert values["mean"] == pytest.approx(0.2 * (1 - level))
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


def test_exchanged_signals_are_known_by_a_pressure_that_rests_at_zero_and_a_flow_that_does_not():
    ejection = np.where(SHARE < 0.4, np.sin(np.pi * SHARE / 0.4), 0.0)
    assert codes(ejection * 20, 0.2 + 0.1 * WAVE) == ["recording.exchanged"]
    low = 0.2 * 0.3 / (1 - 0.2)  # a flow between a fifth of its largest value, and just not
    steady = low + 0.3 * (1 + WAVE) / 2
    assert codes(ejection * 20, steady + 0.001)[0] == "recording.exchanged"
    assert "recording.exchanged" not in codes(ejection * 20, steady - 0.001)
    assert "recording.exchanged" not in codes(ejection * 20 + 3, 0.2 + 0.1 * WAVE)  # 15 % of its range above zero


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


def test_a_last_sample_repeats_the_first_to_a_millionth_and_by_no_chance_where_both_ends_move():
    assert repeats_first(np.array([0.0, 1.0, 0.999e-6]))
    assert not repeats_first(np.array([0.0, 1.0, 1.001e-6]))
    assert moves_at_ends(np.array([0.0, 0.11, 0.5, 0.51, 0.11, 0.0]))
    assert not moves_at_ends(np.array([0.0, 0.09, 0.5, 0.51, 0.11, 0.0]))  # 9 times its rounding, 0.01
    assert not moves_at_ends(np.array([0.0, 0.11, 0.5, 0.51, 0.09, 0.0]))


def test_the_only_column_in_a_unit_of_time_is_the_time_where_none_is_called_so():
    assert with_time(["t", "p"], ["ms", "mmHg"]) == ("time", "p")
    assert with_time(["p", "t"], ["mmHg", "s"]) == ("p", "time")
    assert with_time(["time", "t"], ["", "s"]) == ("time", "t")
    assert with_time(["t", "u"], ["s", "ms"]) == ("t", "u")


def test_the_heart_rate_is_that_of_the_median_interval():
    assert Beats(np.array([0.0, 0.1, 0.2, 0.3, 0.9]), "ecg").heart_rate == pytest.approx(600.0)


def test_errors_of_corrected_harmonics_are_divided_by_what_the_catheter_let_through():
    pressure = 16 + sum(np.cos(2 * np.pi * k * SHARE) / k for k in range(1, 6))
    errors = np.full(101, 0.01)
    recording, catheter = Recording(pressure, FLOW, 0.11, pressure_error=errors), Catheter(60.0, 0.2)
    corrected = correct_catheter(recording, catheter)
    last = 5
    let_through = np.abs(catheter.response(np.arange(last + 1) / 0.11))
    assert corrected.pressure_error[: last + 1] == pytest.approx(0.01 / let_through)
    assert corrected.pressure_error[last + 1 :] == pytest.approx(0.01)
    spectrum = np.abs(np.fft.rfft(corrected.pressure))[1 : last + 1] / 100
    assert spectrum == pytest.approx(1 / np.arange(1, 6) / let_through[1:])
    with pytest.raises(InputError, match="must be positive"):
        correct_catheter(recording, Catheter(0.0, 0.2))
    with pytest.raises(InputError, match="must be positive"):
        correct_catheter(recording, Catheter(60.0, 0.0))


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


def test_a_recording_of_two_rates_is_one_table_of_the_longer_signal():
    table = Recording(PRESSURE, FLOW[::4], 0.11).to_dataframe()
    assert list(table.columns) == ["pressure [mmHg]", "flow [ml/s]"]
    assert table.index.name == "time [s]"
    assert table.index.to_numpy() == pytest.approx(0.11 * SHARE)
    assert table["flow [ml/s]"].to_numpy() == pytest.approx(FLOW)


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
    with pytest.raises(InputError, match=r"249.9 samples/s"):
        RawRecording(np.tile(PRESSURE, 10), np.tile(FLOW, 10), 249.9)
    assert RawRecording(np.tile(PRESSURE, 10), np.tile(FLOW, 10), 250.0).duration == 8.0


def test_the_pulse_of_what_was_observed_is_known_of_a_waveform_and_of_two_ends():
    assert Observation("pressure", "1", 0.1, waveform=PRESSURE).pulse == pytest.approx(10.0)
    assert Observation("flow", "1", 0.1, systolic=0.9, diastolic=0.2).pulse == pytest.approx(0.7)
    assert Observation("flow", "1", 0.1, systolic=0.9, mean=0.2).pulse is None
    assert (Observation("pressure", "1", 0.1, mean=16).gain, Observation("flow", "1", 0.1, mean=1).gain) == (0.0, 0.05)


@pytest.mark.parametrize(
    ("more", "said"),
    [
        ({"mean": 1.0, "place": 1.01}, "place 1.01 lies outside"),
        ({"mean": 1.0, "place": -0.01}, "place -0.01 lies outside"),
        ({"mean": 1.0, "cm": -0.1}, "-0.1 cm lies before the vessel"),
        ({"mean": 1.0, "cm": 0.1, "place": 0.5}, "give one of them"),
        ({"mean": 1.0, "error": 0.0}, "error 0 is not valid"),
        ({"mean": 1.0, "zero_sd": -0.1}, "zero_sd -0.1 is not valid"),
        ({"mean": 1.0, "gain_sd": 2.01}, "gain_sd 2.01 is not valid"),
        ({"mean": 1.0, "gain_sd": -0.01}, "gain_sd -0.01 is not valid"),
        ({}, "give a waveform, or at least one of"),
        ({"mean": 1.0, "waveform": PRESSURE}, "give a waveform, or at least one of"),
        ({"systolic": 1.0, "mean": 1.1}, "must rise in this order"),
        ({"systolic": 1.0, "diastolic": 1.0, "mean": 1.0}, "must rise in this order"),
        ({"diastolic": 1.0, "mean": 0.9}, "must rise in this order"),
        ({"mean": 0.0}, "says nothing of its size"),
        ({"waveform": np.ones(64)}, "the same number throughout"),
        ({"quantity": "diameter", "mean": -0.1}, "-0.1 cm is no vessel's"),
        ({"quantity": "area", "waveform": 0.1 + 0.1 * np.sin(np.pi * np.arange(64) / 32)}, "0 cm2 is no vessel's"),
    ],
)
def test_no_observation_is_made_beyond_a_limit(more, said):
    with pytest.raises(InputError, match=said):
        Observation(**({"quantity": "flow", "vessel": "1", "error": 0.1} | more))


@pytest.mark.parametrize(
    "more",
    [
        {"mean": 1.0, "place": 0.0},
        {"mean": 1.0, "place": 1.0},
        {"mean": 1.0, "cm": 0.0},
        {"mean": 1.0, "zero_sd": 0.0},
        {"mean": 1.0, "gain_sd": 2.0},
        {"mean": 1.0, "gain_sd": 0.0},
        {"mean": 0.0, "quantity": "pressure"},
        {"mean": 1.0, "systolic": 1.0, "diastolic": 0.0},
    ],
)
def test_the_limit_itself_may_be_observed(more):
    one = Observation(**({"quantity": "flow", "vessel": "1", "error": 0.1} | more))
    assert one.place == more.get("place", None if "cm" in more else 0.5)


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


def test_waveforms_that_a_table_of_sites_names_are_those_that_are_there(tmp_path):
    (tmp_path / "one.csv").write_text("x")
    (tmp_path / "sites.csv").write_text("quantity,vessel,file,error\nflow,1,one.csv,1\nflow,2,,1\nflow,3,none.csv,1\n")
    assert site_files(tmp_path / "sites.csv") == (tmp_path / "one.csv",)
    (tmp_path / "other.csv").write_text("quantity,vessel,mean,error\nflow,1,3,1\n")
    assert site_files(tmp_path / "other.csv") == ()
    assert site_files(tmp_path / "absent.csv") == ()


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
