"""Checks of a cycle, observations, tables of sites, baselines and breaths: made numbers at the edge of each rule."""

from types import SimpleNamespace

import numpy as np
import pytest

import vasowave as vw
from vasowave.errors import InputError
from vasowave.recording import baseline as baselines
from vasowave.recording.baseline import Baseline, Settling, Step, baseline_findings
from vasowave.recording.beats import _align, _best_matches, _extremum, _of_one_size, _peaks, _vertex, find_beats, foot
from vasowave.recording.breaths import _bump, _columns, _fit, _transform, breathing
from vasowave.recording.catheter import Catheter, correct_catheter
from vasowave.recording.cuts import Cuts
from vasowave.recording.cycle import Inflow, InletPressure, Recording, resample, samples_needed
from vasowave.recording.describe import BlockDescription, ChannelDescription, FileDescription, _kind, kind_of
from vasowave.recording.ensemble import _beating, _mean_cycles, one_cycle
from vasowave.recording.harmonics import _floor, harmonic_errors
from vasowave.recording.observation import Observation
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
from vasowave.recording.raw import RawRecording
from vasowave.recording.read_sites import read_sites, site_files
from vasowave.recording.steadiness import _alternates, unsteady
from vasowave.recording.wedge import read_wedge

T = np.arange(64) / 64
SINE = np.sin(2 * np.pi * T)


def said(function, *given, **more):
    with pytest.raises(InputError) as error:
        function(*given, **more)
    return str(error.value)


@pytest.mark.parametrize(
    ("period", "words"),
    [
        (0.0, "x: period 0 s is not a positive number"),
        (-0.1, "x: period -0.1 s is not a positive number"),
        (np.inf, "x: period inf s is not a positive number"),
        (3.01, "x: period 3.01 s is 19.9 beats/min, which no heart has; is it in ms, or a continuous recording"),
    ],
)
def test_a_period_that_no_heart_has_is_refused(period, words):
    from vasowave.recording.plausibility import PERIODS

    assert said(check_period, period, "x").startswith(words)
    check_period(PERIODS[0], "x")
    check_period(PERIODS[1], "x")
    short = said(check_period, 0.99 * PERIODS[0], "x")
    assert "which no heart has; is the unit of time right, and is it one whole cycle? One cycle of" in short


def test_pressures_of_another_unit_or_place_are_refused_with_the_mean():
    low, high = 4.0, 150.0
    check_pressure(low + 0.3 * SINE, "x")
    check_pressure(high + 0.3 * SINE, "x")
    assert said(check_pressure, 1.001 * high + SINE, "x").startswith(
        f"x: mean pressure {1.001 * high:.4g} mmHg is too high"
    )
    kpa = said(check_pressure, 0.99 * low + 0.3 * SINE, "x")
    assert kpa.startswith(f"x: mean pressure {0.99 * low:.3g} mmHg looks like kPa ({0.99 * low:.3g} kPa = ")
    assert "--unit pressure=kPa" in kpa
    assert "is too low for an artery" in said(check_pressure, 0.99 * low / 7.5006 + 0.1 * SINE, "x")
    assert "is too low for an artery" in said(check_pressure, np.where(T < 0.3, 2.9 * low, 0.001 * low), "x")
    assert said(check_pressure, SINE - 0.1, "x").startswith("x: mean pressure -0.1 mmHg is not positive; correct the")
    assert said(check_pressure, np.full(64, 12.0), "x").startswith("x: the pressure is constant (12 mmHg); ")
    assert "is constant" in said(check_pressure, 12 + 5e-9 * SINE, "x")


def test_flows_that_do_not_run_forward_are_refused():
    check_flow(1 + 3 * SINE, "x")
    assert said(check_flow, np.ones(64), "x") == "x: the flow is constant (1 ml/s); is this the right column?"
    assert said(check_flow, SINE - 0.5, "x").startswith(
        "x: mean flow -0.5 ml/s; flow out of the heart is positive: turn"
    )
    turned = np.where(T < 0.1, -3.0, 1.0)
    assert said(check_flow, turned, "x").startswith("x: the largest flow is backward (-3 against 1 ml/s); flow out of")
    check_flow(np.where(T < 0.1, -1.0, 1.0), "x")


def codes(*given):
    """Return what is odd beside lags: no bed makes such a pressure of such a flow."""
    return {one.code.partition(".")[2] for one in odd_values(*given)} - {"late-pressure"}


def ejected(level=0.0, high=1.0):
    return np.where(T < 0.4, level + (high - level) * np.sin(np.pi * np.clip(T / 0.4, 0, 1)), level)


def test_values_that_are_possible_but_odd_are_told():
    flow = ejected()
    pressure = 12 + 4 * np.roll(SINE, 16)
    assert codes(pressure, flow, 0.3) == set()
    assert codes(pressure + 63.01, flow, 0.3) == {"systemic-pressure"}
    assert codes(pressure + 62.99, flow, 0.3) == set()
    assert codes(pressure - 8.01, flow, 0.3) == {"pressure-below-zero"}
    assert codes(pressure - 8.0 + 1e-9, flow, 0.3) == set()
    slowest, fastest = 0.02, 4.0
    mean = flow.mean()
    assert codes(pressure, flow * 1.01 * fastest / mean, 0.24) == {"odd-flow"}
    assert codes(pressure, flow * 0.99 * fastest / mean, 0.24) == set()
    assert codes(pressure, flow * 0.99 * slowest / mean, 0.24) == {"odd-flow"}
    assert codes(pressure, flow * 1.01 * fastest / mean, 0.25) == set()
    assert codes(8 * ejected() + 3, 1 + 0.3 * SINE, 0.3) == set()
    assert codes(8 * ejected() + 0.7, 1 + 0.3 * SINE, 0.3) == {"exchanged"}
    assert codes(8 * ejected() + 0.9, 1 + 0.3 * SINE, 0.3) == set()
    late = {"late-flow"}
    upstroke = 12 + 4 * ejected()
    assert codes(np.roll(upstroke, 5), np.roll(flow, 7), 0.3) == late
    assert codes(np.roll(upstroke, 5), np.roll(flow, 6), 0.3) == set()


def test_a_flow_rests_where_a_quarter_of_it_lies_together():
    assert resting_flow(ejected(level=-0.05)) == pytest.approx(-0.05)
    assert resting_flow(SINE) == 0.0
    told = {one.code: one for one in odd_values(12 + 4 * SINE, ejected(level=0.2), 0.3)}["recording.flow-off-zero"]
    mean = ejected(level=0.2).mean()
    values = dict(told.values)
    assert values["level"] == pytest.approx(0.2)
    assert values["percent"] == pytest.approx(20 / mean)
    assert values["mean"] == pytest.approx(mean - 0.2)


def test_what_does_not_close_is_told_or_refused_with_both_ends():
    ramp = np.concatenate([np.linspace(0, 100, 101), np.linspace(99, 10, 90)])
    (told,) = check_closure(np.append(ramp, [9.0, 8, 7, 6, 5, 4.5]), "flow", "x")
    assert str(told) == "flow ends 4.5 % of its range away from its start"
    words = said(check_closure, np.append(ramp, [9.0, 8, 7]), "flow", "x")
    assert words.startswith("x: the cycle of flow does not close: it ends at 7 and starts at 0 (7 % of its range)")
    assert check_closure(np.append(ramp, [9.0, 8, 7, 6, 5, 4, 3, 2]), "flow", "x") == []


def test_the_first_sample_again_is_told_from_one_that_is_near():
    assert repeats_first(np.array([0.0, 5, 10, 0.99e-5]))
    assert not repeats_first(np.array([0.0, 5, 10, 1.1e-5]))
    fine = np.array([0.0, 20, 40, 41, 21, 0])  # values 1 apart: moves of 20 are no chance
    assert moves_at_ends(fine)
    assert not moves_at_ends(np.array([0.0, 10, 40, 41, 21, 0]))  # ten roundings and no more
    assert not moves_at_ends(np.array([0.0, 20, 40, 41, 10, 0]))


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"quantity": "presure"}, "site: 'presure' cannot be observed (did you mean 'pressure'?); known are:"),
        ({"error": None}, "site: error is None; give the SD, a number"),
        ({"zero_sd": None}, "site: zero_sd is None; give the SD, a number"),
        ({"error": "x"}, "site: error is 'x'; give a number, or leave it out"),
        ({"gain_sd": np.nan}, "site: gain_sd is nan; give a number, or leave it out"),
        ({"place": 0.5, "cm": 1.0}, "a share of the length and a distance are given; give one of them"),
        ({"place": 1.01}, "place 1.01 lies outside the vessel; give a share from 0 to 1, or cm"),
        ({"place": -0.01}, "place -0.01 lies outside the vessel"),
        ({"cm": -0.1}, "-0.1 cm lies before the vessel"),
        ({"error": 0.0}, "error 0 is not valid; give a positive SD"),
        ({"zero_sd": -1.0}, "zero_sd -1 is not valid; give an SD of 0 mmHg or more"),
        ({"gain_sd": 2.1}, "gain_sd 2.1 is not valid; give a share from 0 to 2"),
        ({"gain_sd": -0.1}, "gain_sd -0.1 is not valid; give a share"),
        ({"mean": None}, "give a waveform, or at least one of mean, systolic, diastolic"),
        ({"waveform": 9 + SINE}, "give a waveform, or at least one of mean, systolic, diastolic"),
        ({"mean": None, "waveform": np.full(64, 3.0)}, "the waveform is the same number throughout; give a mean"),
        ({"systolic": 8.0}, "diastolic, mean and systolic must rise in this order; are two exchanged?"),
        ({"diastolic": 10.0}, "diastolic, mean and systolic must rise in this order"),
        ({"mean": None, "systolic": 8.0, "diastolic": 8.0}, "diastolic, mean and systolic must rise in this order"),
        ({"quantity": "flow", "mean": 0.0}, "nothing but 0 says nothing of its size"),
        ({"quantity": "area", "mean": -0.1}, "-0.1 cm2 is no vessel's; is its zero right?"),
        ({"quantity": "diameter", "mean": None, "waveform": SINE}, "-1 cm is no vessel's"),
    ],
)  # fmt: skip
def test_an_observation_that_cannot_be_is_refused(changes, words):
    given = {"quantity": "pressure", "vessel": "a", "error": 0.1, "mean": 9.0} | changes
    assert words in said(Observation, **given)


def test_observations_at_the_limits_have_their_titles_pulses_and_gains():
    one = Observation("pressure", "a", 0.1, systolic=12.0, diastolic=9.0)
    assert (one.place, one.pulse, one.gain, one.numbers) == (0.5, 3.0, 0.0, {"systolic": 12.0, "diastolic": 9.0})
    assert repr(one) == "Observation(pressure in 'a', 0.5 of its length: systolic 12, diastolic 9 ± 0.1 mmHg)"
    wave = Observation("flow", "b", 0.01, cm=0.0, waveform=SINE, gain_sd=2.0)
    assert (wave.place, wave.pulse, wave.gain) == (None, pytest.approx(2.0), 2.0)
    assert repr(wave) == "Observation(flow in 'b', 0 cm from its inlet: -1 to 1, 64 samples, ± 0.01 ml/s)"
    assert Observation("area", "b", 0.01, place=1.0, mean=1.0).gain == 0.05
    assert Observation("pressure", "a", 0.1, place=0.0, mean=0.0, zero_sd=0.0).pulse is None
    assert Observation("flow", "a", 0.1, mean=0.0, systolic=1.0).numbers == {"mean": 0.0, "systolic": 1.0}
    assert Observation("flow", "a", 0.1, mean=3.0, systolic=3.0).pulse is None


HEAD = "quantity,vessel,place,mean,systolic,diastolic,unit,error,zero sd,gain sd [%]\n"


def sites(tmp_path, text):
    path = tmp_path / "s.csv"
    path.write_text(text)
    return path


def test_a_table_of_sites_has_units_places_and_waveforms(tmp_path):
    (tmp_path / "w.csv").write_text(
        "time [ms],flow [ul/s]\n" + "".join(f"{i},{100 + 10 * (i % 7)}\n" for i in range(64))
    )
    path = sites(
        tmp_path, "what,vessel,place [mm],file,mean,systolic,diastolic,unit,error,zero sd,gain sd\n"
        "pressure,a,5,,2,3,1,kPa,0.1,0.2,0.5\nFlow,b,,w.csv,,,,ul/s,10,,\n"
    )  # fmt: skip
    one, two = read_sites(path)
    kpa = 7.50062
    assert (one.cm, one.place) == (pytest.approx(0.5), None)
    assert (one.mean, one.systolic, one.diastolic) == pytest.approx((2 * kpa, 3 * kpa, kpa), rel=1e-5)
    assert (one.error, one.zero_sd, one.gain_sd) == pytest.approx((0.1 * kpa, 0.2 * kpa, 0.5), rel=1e-5)
    assert two.waveform == pytest.approx(0.1 + 0.01 * (np.arange(64) % 7))
    assert (two.error, two.zero_sd, two.gain_sd, two.period, two.place) == (
        pytest.approx(0.01), 0.5, None, pytest.approx(0.064), 0.5
    )  # fmt: skip
    assert site_files(path) == (tmp_path / "w.csv",)
    shares = read_sites(sites(tmp_path, HEAD + "diameter,a,0.25,0.5,,,mm,0.1,,4\n"))[0]
    assert (shares.place, shares.mean, shares.gain_sd) == (0.25, pytest.approx(0.05), pytest.approx(0.04))


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (HEAD + "presure,a,,9,,,mmHg,1,,\n", ", line 2: 'presure' cannot be observed (did you mean 'pressure'?);"),
        (HEAD + "pressure,a,,9,,,mmHg,1,,\nflow,a,,9,,,,1,,\n", ", line 3: the cell 'unit' is empty; the error has"),
        (HEAD + "pressure,a,,9,,,mmHg,,,\n", ", line 2: the cell 'error' is empty; give the SD of the error"),
        (HEAD + "pressure,a,x,9,,,mmHg,1,,\n", ", line 2: column 'place': 'x' is not a number"),
        (HEAD + "pressure,a,,9,,,ml/s,1,,\n", ", line 2: 'ml/s' is not a unit of pressure"),
        (HEAD.replace("mean", "maen") + "pressure,a,,9,,,mmHg,1,,\n", ": unknown column 'maen' (did you mean"),
        (HEAD.replace("mean", "mean [mmHg]") + "pressure,a,,9,,,mmHg,1,,\n", ", header, column 'mean [mmHg]': the"),
        ("quantity,vessel,error,file\npressure,a,1,\n", ": no column 'unit'"),
        ("quantity,vessel,unit,error,file\nflow,a,ml/s,1,w.csv\n", ", line 2: there is no file"),
    ],
)  # fmt: skip
def test_a_table_of_sites_is_refused_with_its_line(tmp_path, text, words):
    assert said(read_sites, sites(tmp_path, text)).partition("s.csv")[2].startswith(words)


def test_a_file_of_a_site_says_the_unit_of_its_table(tmp_path):
    (tmp_path / "w.csv").write_text("time [s],flow [l/s]\n" + "".join(f"{i},{i % 7}\n" for i in range(64)))
    path = sites(tmp_path, "quantity,vessel,unit,error,file\nflow,a,ml/s,1,w.csv\n")
    assert "its header says l/s, the table of sites says ml/s; correct one of the two" in said(read_sites, path)
    assert site_files(sites(tmp_path, "quantity,file\nflow,none.csv\n")) == ()
    assert site_files(sites(tmp_path, "quantity,vessel\nflow,a\n")) == ()
    assert site_files(tmp_path / "none.csv") == ()


TIME = np.array([0.0, 1.0, 3.0, 6.0])
TREND = np.array([0.0, 1.0, 4.0, 2.5])
LINE = Baseline(TIME, TREND + 8, TREND, (Step(2.0, 2.0),), 0.5, 0.0)


def test_a_baseline_drifts_by_lines_between_beats_and_leaps_at_its_steps():
    """Without the step the trend is 0, 1, 2 and 0.5."""
    assert LINE.drift_at(np.array([0.0, 0.5, 1.9, 2.0, 3.0, 4.5, 9.0])) == pytest.approx(
        [0, 0.5, 1.45, 3.5, 4, 3.25, 2.5]
    )
    assert LINE.size == 4.0
    assert LINE.sure
    assert LINE.alarming
    assert LINE.mean_drift(0.0, 1.0) == pytest.approx(0.5)
    starts, ends = np.array([0.5, 2.2, 5.0]), np.array([2.5, 3.7, 6.5])
    times = starts[:, None] + (ends - starts)[:, None] * np.linspace(0, 1, 9)
    expected = LINE.drift_at(times)
    last = times > 6.0  # beyond the last beat the last level stays
    assert np.count_nonzero(last) > 0
    assert LINE.mean_within(starts[:2], ends[:2], 9) == pytest.approx(expected[:2].mean(axis=1))
    smooth = Baseline(TIME, TREND, TREND, (), 0.5, 0.0)
    assert smooth.mean_within(starts[:2], ends[:2], 9) == pytest.approx(smooth.drift_at(times[:2]).mean(axis=1))


def test_a_baseline_is_sure_beyond_its_errors_and_alarming_from_its_limit_on():
    def of(size, error, steps=()):
        return Baseline(TIME, TREND, np.array([0, 0, -size, 0.5 * size]), steps, error, 0.0)

    assert not of(3.0, 1.001 / baselines.RULES.sure * 3).sure
    assert of(3.0, 0.999 / baselines.RULES.sure * 3).sure
    assert of(0.0, 9.0, (Step(1.0, 0.1),)).sure
    assert of(baselines.RULES.min_size, 0.01).alarming
    assert not of(0.99 * baselines.RULES.min_size, 0.01).alarming
    assert not of(9.0, 99.0).alarming
    assert of(3.0, 0.1).size == -3.0


def test_the_error_that_a_baseline_leaves_is_its_drift_and_its_settling():
    steady = Baseline(TIME, TREND, TREND, (), 99.0, 0.0)
    assert steady.error_left(0.0, 1.0) == 0.0
    drifting = Baseline(TIME, TREND, TREND, (), 0.1, 0.0)
    assert drifting.error_left(0.0, 1.0) == pytest.approx(0.5)
    settled = Baseline(TIME, TREND, TREND, (), 0.1, 0.0, settling=Settling(1.0, 1.2))
    assert settled.error_left(0.0, 1.0) == pytest.approx(1.3)
    removed = Baseline(TIME, TREND, TREND, (), 0.1, 0.0, removed=True, settling=Settling(1.0, 1.2))
    assert removed.error_left(0.0, 1.0) == pytest.approx(1.2)


def test_what_is_said_of_a_baseline_has_its_times_and_sizes():
    drift, step = baseline_findings(LINE, 0.0, 1.0)
    words = str(drift)
    assert words.startswith("baseline: the diastolic level drifts by +4 ± 0.5 mmHg from 0 to 3 s, breaths set apart")
    assert "mmHg in the averaged beats); left in; it counts as an error of the mean" in words
    assert str(step).startswith("baseline: a step of +2 mmHg at 2 s within one beat")
    (steady,) = baseline_findings(Baseline(TIME, TREND, 0.1 * TREND, (), 9.0, 0.0), 0, 1)
    assert str(steady) == "baseline: the diastolic level is steady within 9 mmHg"
    (steady,) = baseline_findings(Baseline(TIME, TREND, TREND, (), 3.0, 0.0), 0, 1)
    assert "within 4 mmHg" in str(steady)
    more = Baseline(TIME, TREND, TREND, (), 0.1, 0.0, own="the flow changes", elsewhere="the pulse", removed=True,
                    settling=Settling(1.5, -0.7))  # fmt: skip
    beside, settles, drift = baseline_findings(more, 0.0, 1.0)
    assert "with it the pulse, as when the animal" in str(beside)
    assert "the level begins -0.7 mmHg off that of all beats after 1.5 s" in str(settles)
    assert "removed because with it the flow changes, as when the animal itself changes; average a shorter" in str(
        drift
    )
    assert "counts as an error" not in str(drift)
    little = Baseline(TIME, TREND, 0.01 * TREND, (), 0.001, 0.0)
    assert baseline_findings(little, 0, 1)[0].code == "baseline.drifts-little"


def test_an_animal_changes_itself_from_a_twentieth_of_pulse_or_flow_on():
    trend = np.linspace(0, -2.0, 40)
    pulse = np.sin(np.linspace(0, 2 * np.pi, 30))

    def told(by_pulse, by_flow):
        share = np.linspace(0, 1, 40)[:, None]
        pressure = 10 + trend[:, None] + (1 + by_pulse * share) * pulse
        flow = (1 + by_flow * share) * np.ones((40, 30))
        return baselines._own_change(pressure, flow, trend)

    assert told(0.0, 0.0) == ""
    assert told(0.11, -0.2) == "the pulse changes by +10 % and the flow changes by -22 %"
    assert told(0.04, 0.0) == ""
    assert told(0.06, 0.0) == "the pulse changes by +6 %"


def test_with_too_few_beats_no_trend_is_followed():
    cuts = Cuts(np.arange(11.0), np.arange(1.0, 12), np.tile(SINE, (11, 1)), np.tile(SINE, (11, 1)))
    found = baselines.find_baseline(cuts, SINE, np.ones(11, bool), None)
    assert found.time == pytest.approx(np.arange(11) + 0.5)
    assert found.level == pytest.approx(-1.0)
    assert (found.error, found.zero, found.trend.tolist()) == (np.inf, 0.0, [0.0] * 11)


def test_a_zero_is_carried_on_over_a_quarter_of_what_is_known():
    known = np.linspace(10.0, 30.0, 50)
    assert baselines._known_zero(5.0, known) == 5.0
    assert baselines._known_zero(4.9, known) == 10.0
    assert baselines._known_zero(35.0, known) == 35.0
    assert baselines._known_zero(35.1, known) == 30.0


def test_breaths_are_what_returns_and_nothing_where_nothing_does():
    time = np.arange(400) * 0.1
    wave = 0.8 * np.sin(2 * np.pi * 1.3 * time) + 0.2 * np.cos(4 * np.pi * 1.3 * time)
    noise = 0.05 * np.random.default_rng(3).standard_normal(400)
    assert breathing(time, wave + noise, np.ones(400, bool)) == pytest.approx(wave, abs=0.05)
    assert not breathing(time, noise, np.ones(400, bool)).any()
    some = np.arange(400) % 3 > 0
    spoiled = np.where(some, wave, 50.0)
    assert breathing(time, spoiled, some) == pytest.approx(wave, abs=0.05)


def test_the_quick_transform_is_the_sum_of_waves():
    rng = np.random.default_rng(4)
    time, values = np.sort(rng.uniform(0, 9, 60)), rng.normal(size=60)
    found = _transform(time, values, 0.7, 0.013, 41)
    expected = np.array([np.sum(values * np.exp(2j * np.pi * f * time)) for f in 0.7 + 0.013 * np.arange(41)])
    assert found == pytest.approx(expected, abs=1e-9)
    assert _bump(np.array([0.0, 1.0, 2.0]))[0] == 1.0
    columns = _columns(time, 0.9)
    assert columns[:, 1] == pytest.approx(np.cos(2 * np.pi * 0.9 * time))
    assert columns[:, -1] == pytest.approx(np.sin(2 * np.pi * (columns.shape[1] // 2) * 0.9 * time))
    coefficients = np.arange(columns.shape[1]) + 0.5
    assert _fit(time, columns @ coefficients, 0.9) == pytest.approx(coefficients, abs=1e-6)


def test_a_vertex_lies_between_its_neighbors():
    at = np.array([-1, 0, 1.0])
    assert _vertex(3 - (at - 0.2) ** 2) == pytest.approx(0.2)
    assert _vertex(np.array([0.0, 1, 5])) == -0.5
    assert _vertex(np.array([1.0, 1, 1])) == 0.0
    wave = np.zeros(11)
    wave[6:9] = -(3 - (at - 0.25) ** 2)
    assert _extremum(wave) == pytest.approx(2.25)
    wave = np.zeros(11)
    wave[0] = 9.0
    assert _extremum(wave) == -5.0


def test_the_foot_is_where_the_tangent_meets_the_lowest_level():
    values = np.concatenate([[3.0, 2.0, 2.0], 2 + 1.5 * np.arange(1, 7), [11.5, 11.4]])
    assert foot(values, 5) == pytest.approx(2.0)
    assert foot(np.full(9, 4.0), 4) == 1.0  # nothing rises: the first place that is looked at


def test_beats_are_matched_to_their_mean_shape_between_samples():
    t = np.arange(1000.0)
    starts = np.array([103.3, 201.7, 298.0, 404.5, 499.2, 601.6, 702.1, 800.9, 895.5])
    shape = sum(np.exp(-0.5 * ((t - start) / 4) ** 2) for start in starts)
    times, template = _align(shape, np.rint(starts + 2).astype(int), 12)
    apart = times - starts
    assert apart == pytest.approx(np.full(9, apart.mean()), abs=0.05)
    assert len(template) == 25
    centres = np.array([5, 103, 990])
    found = _best_matches(shape, np.exp(-0.5 * (np.arange(-12, 13) / 4) ** 2), centres, 12)
    assert found[[0, 2]].tolist() == [5, 990]
    assert found[1] == pytest.approx(103.3, abs=0.02)


def test_weak_beats_count_where_one_is_missed():
    strength = np.zeros(1000)
    strength[50::100] = 10.0
    strength[350] = 2.0  # weak, where a beat is expected
    strength[520] = 2.0  # weak, beside a beat
    strength[650] = 1.4  # below 15 %
    assert _peaks(strength, 100.0).tolist() == [50, 150, 250, 350, 450, 550, 750, 850, 950]
    assert _peaks(np.zeros(50), 10.0).tolist() == []


def test_heart_rates_of_rodents_and_large_animals_are_looked_for_apart():
    from vasowave.recording.beats import _LARGE, _RODENT

    assert _of_one_size((_LARGE - 1, _RODENT)) == [(_LARGE, _RODENT), (_LARGE - 1, _LARGE)]
    assert _of_one_size((_LARGE, _RODENT)) == [(_LARGE, _RODENT)]
    assert _of_one_size((_LARGE - 1, _RODENT - 1)) == [(_LARGE - 1, _RODENT - 1)]


@pytest.mark.parametrize(
    ("more", "words"),
    [
        ({"heart_rates": (0, 900)}, "heart_rates=(0, 900): give the slowest and the fastest"),
        ({"heart_rates": (900, 900)}, "heart_rates=(900, 900): give the slowest and the fastest"),
        ({"heart_rates": (20, 90)}, "made in memory: 2 s hold fewer than three beats at 90 beats/min"),
        ({"fiducial": "flow"}, "fiducial 'flow' is neither 'ecg' nor 'pressure'"),
        ({"fiducial": "ecg"}, "made in memory: no ECG; use fiducial='pressure'"),
    ],
)
def test_beats_are_looked_for_as_they_can_be(more, words):
    raw = RawRecording(10 + np.sin(np.arange(1000) / 9), np.ones(1000), 500.0)
    assert said(find_beats, raw, **more).startswith(words)


def test_a_catheter_answers_as_an_oscillator_of_second_order():
    catheter = Catheter(50.0, 0.25)
    assert catheter.response(np.array([0.0, 25.0, 50.0])) == pytest.approx([1, 1 / (0.75 + 0.25j), 1 / 0.5j])
    cycle = Recording(12 + 4 * SINE + np.sin(4 * np.pi * T), 1 + 0.5 * SINE, 0.1, pressure_error=np.full(20, 0.1))
    back = correct_catheter(cycle, catheter)
    response = catheter.response(np.arange(3) / 0.1)
    found, before = np.fft.rfft(back.pressure)[:3], np.fft.rfft(cycle.pressure)[:3]
    assert found == pytest.approx(before / response)
    assert back.pressure_error[:3] == pytest.approx(0.1 / np.abs(response))
    assert back.pressure_error[3:] == pytest.approx(np.full(17, 0.1))
    assert str(back.notes[-1]).endswith("a response of second order, 50 Hz and damping 0.25, up to harmonic 2")
    for wrong in (Catheter(0.0, 0.25), Catheter(50.0, 0.0)):
        assert "natural frequency and damping must be positive" in said(correct_catheter, cycle, wrong)
    assert "lets harmonics up to 2 through 1 to 25 times" in said(correct_catheter, cycle, Catheter(20.0, 0.02))
    assert "through 0.01 to 1 times" in said(correct_catheter, cycle, Catheter(2.0, 0.1))


def test_harmonics_of_beats_have_the_errors_that_are_known():
    cycle = Recording(12 + 4 * SINE, 1 + 0.5 * SINE, 0.1, pressure_error=np.full(5, 0.1))
    found = harmonic_errors(cycle)
    assert (found.source, found.modulus[:2].tolist(), len(found.error)) == ("beats", pytest.approx([12, 4]), 5)
    flow = harmonic_errors(cycle, "flow")
    assert flow.source == "file"
    assert flow.error[0] == pytest.approx(flow.error[1] / np.sqrt(2))
    rounded = harmonic_errors(Recording(np.round(12 + 4 * SINE, 1), 1 + 0.5 * SINE, 0.1)).error[1]
    assert rounded >= 0.1 / np.sqrt(12) * np.sqrt(2 / 64)
    assert "signal 'area' is neither 'pressure' nor 'flow'" in said(harmonic_errors, cycle, "area")
    assert _floor(np.full(33, 0.2)) == pytest.approx(0.2 / np.sqrt(2))


def test_resampling_keeps_a_wave_and_folds_the_last_harmonic():
    wave = 3 + np.cos(2 * np.pi * T) + 0.5 * np.sin(6 * np.pi * T)
    more = np.arange(96) / 96
    assert resample(wave, 96) == pytest.approx(3 + np.cos(2 * np.pi * more) + 0.5 * np.sin(6 * np.pi * more))
    fewer = np.arange(20) / 20
    assert resample(wave, 20) == pytest.approx(3 + np.cos(2 * np.pi * fewer) + 0.5 * np.sin(6 * np.pi * fewer))
    edge = np.array([1.0, -1, 1, -1])
    assert resample(edge, 8) == pytest.approx(np.cos(np.pi * np.arange(8) / 2))
    both = resample(np.column_stack([wave, 2 * wave]), 40)
    assert both.shape == (40, 2)
    assert both[:, 1] == pytest.approx(2 * both[:, 0])
    assert resample(resample(edge, 8), 4) == pytest.approx(edge)
    assert resample(np.array([1.0, 2, 3]), 6)[::2] == pytest.approx([1, 2, 3])
    assert samples_needed(wave) == 7
    assert samples_needed(np.cos(np.pi * np.arange(16))) == 16


def test_a_cycle_knows_its_indices():
    pressure, flow = 12 + 4 * SINE, np.full(32, 0.2) + 0.1 * SINE[::2]
    cycle = Recording(pressure, flow, 0.12, wedge_pressure=4.0)
    assert cycle.indices() == pytest.approx(
        {"HR": 500, "CO": 0.2, "mPAP": 12, "sPAP": 16, "dPAP": 8, "pPAP": 8, "PVR": 40}
    )
    assert cycle.input_resistance == pytest.approx(60)
    assert cycle.time[:2] == pytest.approx([0, 0.12 / 64])
    frame = cycle.to_dataframe()
    assert len(frame) == 64
    assert frame.index[1] == pytest.approx(0.12 / 64)
    assert frame["flow [ml/s]"].to_numpy()[::2] == pytest.approx(flow)
    assert "a wedge pressure of 12 mmHg is not below the mean pressure, 12 mmHg" in said(
        Recording, pressure, flow, 0.12, wedge_pressure=12.0
    )
    beating = Recording(pressure, flow, 0.12, wedge_pulsation=3 + SINE)
    assert beating.wedge_pulsation == pytest.approx(SINE)
    for errors in ([[1.0]], [], [1.0, -1.0], [np.nan]):
        words = said(Recording, pressure, flow, 0.12, flow_error=errors)
        assert words.startswith("flow_error: give one standard error for each harmonic, the mean's first")
    for period in (0.0, np.nan, -1.0):
        assert f"period {period:g} s is not a positive number" in said(Recording, pressure, flow, period)


def test_inflows_and_pressures_belong_to_inlets():
    flow = Inflow(np.column_stack([SINE, 2 + SINE]), 0.1)
    assert flow.into(["a", "b"]).shape == (64, 2)
    assert said(flow.into, ["a"]).startswith("the network has 1 inlet(s) ('a') and 2 inflow(s) are given; give Inflow")
    six = said(Inflow(SINE, 0.1).into, list("abcdef"))
    assert six.startswith("the network has 6 inlet(s) ('a', 'b', 'c', 'd', 'e') and 1 inflow(s)")
    driven = InletPressure(9 + SINE, 0.1)
    assert driven.into(["a"]).shape == (64, 1)
    assert said(driven.into, list("abcdef")).startswith(
        "the network has 6 inlets ('a', 'b', 'c', 'd', 'e'): a pressure"
    )


def test_a_file_is_described_by_its_longest_block():
    def block(samples, rate=100.0, quantity="pressure"):
        channels = (ChannelDescription("P", "mmHg", quantity), ChannelDescription("", "", ""))
        return BlockDescription(rate, samples / rate, samples, channels)

    one = FileDescription("f", "edf", "raw", (block(500), block(1234)))
    assert str(one).startswith("EDF, continuous: 12.34 s at 100 samples/s, the longest of 2 blocks; P [mmHg],")
    two = FileDescription("f", "table", "", (block(500, np.nan),))
    assert str(two) == "table, cycle or continuous: 500 samples without times; P [mmHg], (untitled) [no unit]"
    from vasowave.recording.plausibility import PERIODS

    longest = round(100 * PERIODS[1])
    assert _kind([block(10), block(longest)]) == "cycle"
    assert _kind([block(10), block(longest + 1)]) == "raw"
    assert _kind([block(10), block(10, quantity="ecg")]) == "raw"
    assert _kind([block(10, np.nan)]) == ""


def test_the_kind_of_a_recording_is_that_of_its_only_file(tmp_path):
    path = tmp_path / "a.csv"
    path.write_text("time [s],pressure [mmHg]\n" + "".join(f"{i / 10},{i % 9}\n" for i in range(50)))
    assert kind_of([path]) == "raw"
    assert kind_of([path, path]) == "cycle"
    assert kind_of([tmp_path / "none.csv"]) == "cycle"


def test_one_cycle_is_taken_of_what_has_one():
    cycle = Recording(12 + 4 * SINE, 1 + 0.5 * SINE, 0.1)
    assert one_cycle(cycle) is cycle
    assert one_cycle(vw.virtual_mouse()).period > 0
    assert "average its beats: raw.average()" in said(one_cycle, RawRecording(np.ones(500), np.ones(500), 300.0))
    assert said(one_cycle, "a.csv").startswith("'a.csv' is the name of a file; read it first")
    assert said(one_cycle, 3) == "int was given where a Recording is needed"


def test_means_of_beats_are_closed_and_beats_beside_count_for_where_it_beats():
    steps = {"pressure": np.array([[1.0, 2, 3, 2, 2], [1, 4, 5, 4, 2]])}
    (cycle,), (note,) = _mean_cycles(steps, None)
    assert len(cycle) == 4
    assert cycle == pytest.approx([1.5, 3.25, 4, 2.75])
    assert dict(note.values)["name"] == "pressure"
    line = SimpleNamespace(time=np.array([1.0, 5.0, 6.0, 9.5]))
    starts = np.array([4.8, 5.8, 6.8])
    assert _beating(line, starts, ["bad", None, None]) == (1.0, 9.5)
    near = SimpleNamespace(time=np.array([5.0, 6.0, 7.0]))
    assert _beating(near, starts, ["bad", None, None]) == (5.8, 6.8)


def courses(flow, pulse):
    starts = np.arange(len(flow)) * 0.1
    shape = np.array([0.0, 1.0])
    return Cuts(starts, starts + 0.1, np.outer(pulse, shape), np.outer(flow, np.ones(2)))


def test_what_changes_in_the_course_of_a_recording_is_told_with_levels_and_times():
    flow = np.where(np.arange(200) < 100, 1.0, 2.0)
    found = unsteady(courses(flow, np.full(200, 8.0)), np.arange(200) < 20, 0.0, 2.0)
    changed, apart = found
    values = dict(changed.values)
    assert (values["what"], values["low"], values["high"], values["percent"]) == ("the mean flow", 1.0, 2.0, 50.0)
    assert values["low_start"] == pytest.approx(0.0)
    assert values["high_end"] <= 20.0
    assert (values["start"], values["end"]) == (0.0, 2.0)
    assert dict(apart.values)["percent"] == pytest.approx(100 * (1 / 1.5 - 1))
    assert unsteady(courses(np.ones(200), np.full(200, 8.0)), np.ones(200, bool), 0, 1) == []
    assert unsteady(courses(flow[:3], flow[:3]), np.ones(3, bool), 0, 1) == []
    (alone,) = unsteady(courses(flow, np.full(200, 8.0)), np.zeros(200, bool), 0, 1)
    assert alone.code == changed.code


def test_beats_alternate_where_every_second_is_larger():
    values = 10 + 0.3 * (-1.0) ** np.arange(50)
    (told,) = _alternates(values, "the pulse pressure")
    assert dict(told.values) == {"what": "the pulse pressure", "percent": pytest.approx(6.0, rel=0.04)}
    assert _alternates(10 + 0.2 * (-1.0) ** np.arange(50), "x") == []
    assert _alternates(10 + np.arange(50.0), "x") == []


@pytest.mark.parametrize(
    ("rows", "words"),
    [
        ("".join(f"{0.0021 * i:.4f},{8 + 2 * np.sin(2 * np.pi * i / 50)}\n" for i in range(50)), "its cycle lasts"),
        ("".join(f"{0.002 * i:.3f},{-3 + 2.1 * np.sin(2 * np.pi * i / 50)}\n" for i in range(50)), "falls to -5.1"),
        ("".join(f"{0.002 * i:.3f},{8 + 0.1 * i}\n" for i in range(50)), "does not close"),
    ],
)  # fmt: skip
def test_a_pressure_behind_the_beds_that_cannot_be_is_refused(tmp_path, rows, words):
    (tmp_path / "w.csv").write_text("time [s],LA [mmHg]\n" + rows)
    assert words in said(read_wedge, tmp_path / "w.csv", 0.1)


def test_a_pressure_behind_the_beds_has_a_mean_and_a_pulsation(tmp_path):
    wave = 8 + 2 * np.sin(2 * np.pi * np.arange(50) / 50)
    (tmp_path / "w.csv").write_text("pcwp\n" + "".join(f"{one:.6f}\n" for one in wave))
    found = read_wedge(tmp_path / "w.csv", 0.1)
    assert found.mean == pytest.approx(8.0)
    assert found.pulsation == pytest.approx(wave - 8, abs=1e-6)
    (assumed,) = found.findings
    assert "is assumed to be in mmHg; w.csv names no unit" in str(assumed)
