"""Loops of pressure and volume against ventricles of numbers elastance, and each number against a second way to it."""

import numpy as np
import pytest
from scipy.integrate import trapezoid
from scipy.stats import linregress

from made_ventricle import made_ventricles
from vasowave.base import InputError, units
from vasowave.pulse.analysis import VENTRICULAR, cut_loops, pressure_volume
from vasowave.pulse.cycle import PressureVolume


def recorded(made):
    return PressureVolume(made.pressure, made.volume, made.rate, made.name)


@pytest.fixture(scope="module")
def mouse():
    quiet = {"drift": 0.0, "breaths": 0.0, "noise": 0.004, "volume_noise": 0.008}
    (made,) = made_ventricles(np.random.default_rng(4), ("cosine",), ("mouse",), right=True, **quiet)
    return made


@pytest.fixture(scope="module")
def function(mouse):
    return pressure_volume(recorded(mouse))


def test_the_line_of_a_family_has_the_elastance_and_the_volume_that_were_put_in(mouse, function):
    elastance, zero = function.estimates["E_es"], function.estimates["V_0"]
    assert elastance.value == pytest.approx(mouse.elastance, rel=0.05)
    assert zero.value == pytest.approx(mouse.zero_volume, abs=0.1 * mouse.stroke_volume)
    assert elastance.low < elastance.value < elastance.high
    assert len(function.family) > 10
    assert 6 <= len(function.steady) <= 9


def test_stroke_work_is_the_pressure_over_the_change_of_volume_in_time(mouse, function):
    times = np.arange(len(mouse.time)) / mouse.rate
    for number in function.steady[:4]:
        loop = function.loops[number]
        inside = (times >= loop.start) & (times <= loop.start + loop.period)
        work = -trapezoid(mouse.clean_pressure[inside], mouse.clean_volume[inside]) * units.MILLIWATT
        assert loop.stroke_work == pytest.approx(work, rel=0.02)


def test_slopes_are_those_of_the_pressure_without_noise(mouse, function):
    slope = np.gradient(mouse.clean_pressure) * mouse.rate
    assert function.estimates["dp_dt_max"].value == pytest.approx(slope[: 6 * 120].max(), rel=0.05)
    assert function.estimates["dp_dt_min"].value == pytest.approx(slope[: 6 * 120].min(), rel=0.05)


def test_numbers_of_a_beat_follow_from_each_other(function):
    value = {name: estimate.value for name, estimate in function.estimates.items()}
    assert value["EF"] == pytest.approx(value["SV"] / value["EDV"], rel=0.02)
    assert value["E_a"] == pytest.approx(value["ESP"] / value["SV"], rel=0.02)
    assert value["coupling"] == pytest.approx(value["E_es"] / value["E_a"])
    table = function.table
    assert set(table.index) <= set(VENTRICULAR)
    assert (table["low"] <= table["value"]).all()
    assert (table["value"] <= table["high"]).all()
    assert list(function.beats["state"]).count("steady") == len(
        [n for n in function.steady if n not in function.family]
    )


def relaxing(tau, asymptote, rate=2000, period=0.2, beats=8):
    """Return loops whose pressure falls as an exponential from 0.08 to 0.16 s of each beat."""
    time = np.arange(0, beats * period, 1 / rate)
    phase = time % period
    top = 100.0
    up = asymptote + 8 + (top - asymptote - 8) * np.sin(np.clip(phase / 0.08, 0, 1) * np.pi / 2) ** 2
    down = asymptote + (top - asymptote) * np.exp(-np.clip(phase - 0.08, 0, None) / tau)
    pressure = np.where(phase < 0.08, up, down)
    volume = 0.03 + 0.01 * np.cos(2 * np.pi * (phase - 0.03) / period)
    return PressureVolume(pressure, volume, rate)


@pytest.mark.parametrize("tau", [0.015, 0.025])
def test_relaxation_towards_an_asymptote_has_its_time_constant_by_fit_and_by_slope(tau):
    loops = cut_loops(relaxing(tau, asymptote=-6.0)).loops
    for loop in loops[1:-1]:
        values = loop.values()
        assert values["tau_glantz"] == pytest.approx(tau, rel=0.05)
        # Another way to it: dp/dt is a line in p, whose slope is -1/tau.
        first = int(np.argmin(loop.slope))
        falling = slice(first + 8, first + 8 + int(tau * 2000))
        assert -1 / linregress(loop.pressure[falling], loop.slope[falling]).slope == pytest.approx(tau, rel=0.05)


def test_relaxation_towards_zero_has_one_time_constant_by_both_definitions():
    values = cut_loops(relaxing(0.02, asymptote=0.0)).loops[3].values()
    assert values["tau_weiss"] == pytest.approx(0.02, rel=0.05)
    assert values["tau_glantz"] == pytest.approx(0.02, rel=0.05)


def test_without_a_fall_of_the_preload_no_line_is_drawn_and_that_is_told():
    (made,) = made_ventricles(np.random.default_rng(6), ("cosine",), ("mouse",), closing=1.0, breaths=0.0, reflex=0.0)
    function = pressure_volume(recorded(made))
    assert not set(function.estimates) & {"E_es", "V_0", "PRSW", "coupling"}
    assert "loops.no-family" in [finding.code for finding in function.findings]
    assert function.estimates["SV"].value == pytest.approx(made.stroke_volume, rel=0.05)


def test_a_volume_whose_sign_is_turned_is_told(mouse):
    turned = PressureVolume(mouse.pressure, mouse.volume.max() + mouse.volume.min() - mouse.volume, mouse.rate)
    assert "loops.turn-backward" in [finding.code for finding in pressure_volume(turned).findings]


def test_a_volume_in_the_wrong_unit_is_told_by_the_heart_rate(mouse):
    thousandfold = PressureVolume(mouse.pressure, 1000 * mouse.volume, mouse.rate)
    assert "loops.unlikely-stroke" in [finding.code for finding in pressure_volume(thousandfold).findings]


def test_noise_of_the_volume_makes_no_stroke_larger():
    still = {"drift": 0.0, "breaths": 0.0, "rate": 500, "beats": (5, 1), "volume_noise": 0.02}
    made = made_ventricles(np.random.default_rng(5), ("gauss", "two hills"), ("rat", "human"), each=2, **still)
    off, fraction_off = [], []
    for case in made:
        loops = [loop.values() for loop in cut_loops(recorded(case)).loops[:3]]
        off += [numbers["SV"] / case.stroke_volume - 1 for numbers in loops]
        fraction = case.stroke_volume / case.clean_volume[case.time < 3 * case.period].max()
        fraction_off += [numbers["EF"] / fraction - 1 for numbers in loops]
    assert abs(np.mean(off)) < 0.01  # largest less smallest: 2 to 5 %
    assert abs(np.nanmean(fraction_off)) < 0.01


def test_the_end_of_systole_of_steady_beats_is_the_same_whether_the_preload_falls_later_or_not(mouse, function):
    steady = slice(0, int(5 * mouse.period * mouse.rate))
    alone = pressure_volume(PressureVolume(mouse.pressure[steady], mouse.volume[steady], mouse.rate))
    assert "E_es" not in alone.estimates
    for name in ("E_a", "ESP", "ESV"):
        assert alone.estimates[name].value == pytest.approx(function.estimates[name].value, rel=0.02)
    begins = function.loops[function.steady[1]].start
    beat = slice(int(begins * mouse.rate), int((begins + 0.6 * mouse.period) * mouse.rate))
    elastance = mouse.clean_pressure[beat] / (mouse.clean_volume[beat] - mouse.zero_volume)
    load = mouse.clean_pressure[beat][np.argmax(elastance)] / mouse.stroke_volume
    assert alone.estimates["E_a"].value == pytest.approx(load, rel=0.04)  # the corner is no further from the top


@pytest.mark.parametrize("share", [-0.06, 0.04])
def test_a_volume_that_comes_late_or_early_is_told_with_its_delay(mouse, share):
    delay = share * mouse.period
    moved = np.interp(mouse.time - delay, mouse.time, mouse.volume)
    findings = pressure_volume(PressureVolume(mouse.pressure, moved, mouse.rate)).findings
    (seconds,) = [dict(finding.values)["seconds"] for finding in findings if finding.code == "loops.volume-late"]
    assert seconds == pytest.approx(delay, abs=0.01 * mouse.period)


def test_a_volume_in_step_with_the_pressure_is_not_told():
    shapes = ("two hills", "gauss", "ramp")
    for case in made_ventricles(np.random.default_rng(8), shapes, ("mouse", "dog"), beats=(4, 1)):
        codes = {finding.code for finding in pressure_volume(recorded(case)).findings}
        assert not codes & {"loops.volume-late", "loops.not-in-step"}, case.name


def test_a_volume_that_has_another_zero_is_told(mouse):
    below = pressure_volume(PressureVolume(mouse.pressure, mouse.volume - 0.03, mouse.rate))
    assert "loops.volume-below-zero" in [finding.code for finding in below.findings]
    assert "EF" not in below.estimates


def test_a_pressure_below_zero_and_a_volume_that_stays_are_refused(mouse):
    with pytest.raises(InputError, match="stays below 0"):
        pressure_volume(PressureVolume(mouse.pressure - 200, mouse.volume, mouse.rate))
    still = np.where(np.arange(len(mouse.volume)) < 5, 0.03, 0.02)
    with pytest.raises(InputError, match="does not change within beats"):
        pressure_volume(PressureVolume(mouse.pressure, still, mouse.rate))


def test_stretches_may_be_named(mouse, function):
    first, last = (function.loops[number].start for number in (function.family[8], function.family[-1]))
    named = pressure_volume(recorded(mouse), family=(first - 0.01, last + 1.0), steady=(0.0, first))
    assert named.estimates["E_es"].value == pytest.approx(function.estimates["E_es"].value, rel=0.1)
    with pytest.raises(InputError, match="no whole beat lies between"):
        pressure_volume(recorded(mouse), family=(900.0, 910.0))


def test_what_does_not_beat_and_what_is_sampled_too_coarsely_is_refused(mouse):
    noise = np.random.default_rng(1).standard_normal(3000)
    with pytest.raises(InputError, match="does not beat"):
        pressure_volume(PressureVolume(noise, noise**2, 1000))
    with pytest.raises(InputError, match="samples a beat"):
        pressure_volume(PressureVolume(mouse.pressure[::20], mouse.volume[::20], mouse.rate / 20))
    for pressure, volume in ((np.ones(100), noise[:100]), (noise[:100], np.full(100, np.nan)), (noise, noise[:50])):
        with pytest.raises(InputError):
            PressureVolume(pressure, volume, 1000)


@pytest.mark.validation
def test_ventricles_of_other_shapes_and_species_have_their_elastance():
    shapes, kinds = ("gauss", "ramp"), ("mouse", "rat", "dog", "human")
    made = made_ventricles(np.random.default_rng(2029), shapes, kinds, each=2, drift=0.005)
    functions = [pressure_volume(recorded(case)) for case in made]
    estimates = [function.estimates for function in functions]
    off = [abs(numbers["E_es"].value / case.elastance - 1) for numbers, case in zip(estimates, made, strict=True)]
    aside = [abs(numbers["V_0"].value - case.zero_volume) / case.stroke_volume
             for numbers, case in zip(estimates, made, strict=True)]  # fmt: skip
    held = [
        numbers["E_es"].low < case.elastance < numbers["E_es"].high
        for numbers, case in zip(estimates, made, strict=True)
    ]
    assert np.mean(held) >= 0.8  # of intervals at 95 %
    assert np.sum(np.array(off) < 0.05) >= 0.8 * len(made)
    assert np.sum(np.array(aside) < 0.10) >= 0.9 * len(made)


def test_an_extra_beat_is_left_out(mouse, function):
    first = int(function.loops[3].start * mouse.rate)
    gone = slice(first + int(0.5 * mouse.period * mouse.rate), first + int(0.9 * mouse.period * mouse.rate))
    early = pressure_volume(PressureVolume(np.delete(mouse.pressure, gone), np.delete(mouse.volume, gone), mouse.rate))
    assert "loops.beats-left-out" in [finding.code for finding in early.findings]
    assert early.estimates["E_es"].value == pytest.approx(function.estimates["E_es"].value, rel=0.1)


def test_what_is_no_recording_and_a_stretch_of_one_time_are_refused(mouse):
    with pytest.raises(InputError, match="of a file: read_loops"):
        pressure_volume("loops.csv")
    with pytest.raises(InputError, match="give two times"):
        pressure_volume(recorded(mouse), steady=(0.5,))


def test_a_pressure_that_no_ventricle_has_is_told(mouse):
    tenfold = pressure_volume(PressureVolume(10 * mouse.pressure, mouse.volume, mouse.rate))
    assert "loops.unlikely-pressure" in [finding.code for finding in tenfold.findings]
    assert "loops.unlikely-pressure" not in [finding.code for finding in pressure_volume(recorded(mouse)).findings]
