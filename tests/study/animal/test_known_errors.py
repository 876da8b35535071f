"""Errors that a lab says: what they move, checked by fits of recordings and networks without them."""

from dataclasses import replace

import numpy as np
import pytest

import vasowave as vw
from made_cohort import EXACT
from vasowave.pulse import derived
from vasowave.pulse.inference import Observed, columns, kinds
from vasowave.study.animal import Animal, AnimalResult, Settings, analyze, effects_on_fit
from vasowave.study.folder import COLUMNS, StudyFile, animal_settings

MOUSE = vw.virtual_mouse()
NETWORK = vw.Network(("1", "2", "3"), [-1, 0, 0], [0.4, 0.4, 0.5], [0.05, 0.035, 0.04], pressure=6.0)
ALL = {
    "radius_scale": 0.05, "length_scale": 0.05, "image_pressure": 0.3, "flow_gain": 0.07, "flow_delay": 0.001,
    "zero": 0.5, "flow_zero": 0.003, "pressure_lag": 0.0005, "pressure_inertia": 2e-7, "viscosity": 0.1,
    "flow_lag": 0.0005, "pressure_gain": 0.03,
}  # fmt: skip
SETTINGS = Settings(
    walls=("linear",), starts=1, model_selection=False, **{f"{name}_sd": sd for name, sd in ALL.items()}
)


BY_PRESSURE = ("flow_gain", "pressure_lag", "radius_scale")
"""Errors of the flow, of the pressure and of the image: the others move fits that a pressure enters alike."""


def fitted(seen, enters="flow"):
    return vw.calibrate(seen.network, seen.recording, "linear", starts=1, blood=seen.blood, enters=enters)


def quantities(values, model, mean):
    return {**values, **derived(model, mean)}


@pytest.fixture(scope="module")
def fit():
    return fitted(Observed(NETWORK, MOUSE, vw.Blood()))


@pytest.fixture(scope="module")
def effects(fit):
    by_pressure = fitted(Observed(NETWORK, MOUSE, vw.Blood()), "pressure")
    return {
        "flow": effects_on_fit(fit, SETTINGS, quantities).errors,
        "pressure": effects_on_fit(by_pressure, replace(SETTINGS, enters="pressure"), quantities).errors,
    }


@pytest.mark.parametrize(
    ("name", "enters"),
    [(name, "flow") for name in ALL]
    + [pytest.param(name, "pressure", marks=() if name in BY_PRESSURE else pytest.mark.validation) for name in ALL],
)
def test_what_an_error_moves_in_a_fit_is_what_a_fit_without_it_finds_elsewhere(effects, name, enters):
    one, seen = kinds()[name], Observed(NETWORK, MOUSE, vw.Blood())
    found, share = {}, 0.2  # of an SD, so that slopes hold
    for side in (-share, share):
        value = one.center(seen) * np.exp(side * ALL[name]) if one.positive else one.center(seen) + side * ALL[name]
        again = fitted(one.without(seen, value), enters)
        mean = again.recording.mean_pressure
        found[side] = derived(again.model, mean)
    for quantity in ("stiffness", "wave_speed", "R_T"):
        slope = np.log(found[share][quantity] / found[-share][quantity]) / (2 * share)
        # Least squares is linear in the errors within a few per cent of what an SD moves.
        assert effects[enters].loc[quantity, name] == pytest.approx(slope, rel=0.08, abs=2e-3), quantity


def test_the_resistance_moves_against_the_gain_of_the_probe(effects):
    assert effects["flow"].loc["R_T", "flow_gain"] == pytest.approx(-0.07, abs=0.02)


def test_intervals_and_shares_of_a_result_hold_the_errors_that_are_said():
    animal = Animal("mouse", "CTL", NETWORK, MOUSE, synthetic=True)
    plain = analyze(animal, replace(SETTINGS, **EXACT))
    told = analyze(animal, replace(SETTINGS, flow_zero_sd=0.0, pressure_gain_sd=0.0))
    R_T, exact = (one.laws["linear"].quantities["R_T"] for one in (told, plain))
    assert R_T.attrs["standard_error"] > exact.attrs["standard_error"]
    most = MOUSE.vascular_resistance * np.exp(1.96 * np.hypot(0.07, 0.5 / MOUSE.mean_pressure))
    assert exact.attrs["interval_high"] <= MOUSE.vascular_resistance  # vessels take pressure …
    assert R_T.attrs["interval_high"] >= 0.99 * min(most, R_T * np.exp(1.96 * R_T.attrs["standard_error"] / R_T))
    assert R_T.attrs["share_probe"] > 0.3
    assert "share_probe" not in exact.attrs
    measured = told.measured.quantities
    mPAP, CO = measured["mPAP"], measured["CO"]
    assert mPAP.attrs["standard_error"] == pytest.approx(0.5)
    assert mPAP.attrs["share_calibration"] == pytest.approx(1.0)
    assert CO.attrs["standard_error"] == pytest.approx(0.07 * float(CO))
    assert CO.attrs["share_probe"] == pytest.approx(1.0)
    both = np.hypot(0.07, 0.5 / float(mPAP)) * float(measured["PVR"])
    assert measured["PVR"].attrs["standard_error"] == pytest.approx(both)
    assert "standard_error" not in measured["HR"].attrs
    assert "standard_error" not in plain.measured.quantities["CO"].attrs


def test_an_error_that_is_not_told_is_the_usual_one_and_zero_says_that_there_is_none():
    assert {one.name: one.sd for one in Settings().assumed(NETWORK)} == {
        "radius_scale": 0.05, "length_scale": 0.05, "k": 0.5, "taper": 0.1, "image_pressure": 0.3, "flow_gain": 0.05,
        "zero": 0.5}  # fmt: skip
    assert all(one.sd == 0 and one.source == "lab" for one in Settings(**EXACT).assumed(NETWORK))
    assert Settings().priors.sd("zero") == 0.5
    assert Settings(zero_sd=1.5).priors.sd("zero") == 1.5
    assert Settings(radius_scale_sd=0).priors.sd("radius_scale") == 0


def test_usual_errors_widen_intervals_move_no_value_and_are_kept_with_the_result():
    animal, how = Animal("mouse", "CTL", NETWORK, MOUSE, synthetic=True), {"walls": ("linear",), "starts": 1}
    plain, usual = (analyze(animal, Settings(**how, **more)) for more in (EXACT, {}))
    for name, value in usual.laws["linear"].quantities.data_vars.items():
        exact = plain.laws["linear"].quantities[name]
        assert float(value) == float(exact), name
        if "standard_error" in exact.attrs:
            assert value.attrs["standard_error"] >= exact.attrs["standard_error"], name
    assert all(usual.laws["linear"].quantities[name].attrs["share_image"] > 0 for name in ("stiffness", "R_T", "I_R"))
    assert not any("standard_error" in one.attrs for one in usual.measured.quantities.data_vars.values())
    assert usual.assumed_errors == Settings().assumed(NETWORK)
    assert AnimalResult.from_datatree(usual.to_datatree()).assumed_errors == usual.assumed_errors


def test_the_papers_practice_assumes_no_error_that_the_lab_does_not_tell():
    errors = animal_settings(StudyFile(practice="paper", zero_sd=0.8)).assumed(NETWORK)
    assert {one.name: one.sd for one in errors if one.sd > 0} == {"zero": 0.8}


@pytest.mark.parametrize(
    "name", ["flow_gain", "radius_scale", pytest.param("image_pressure", marks=pytest.mark.validation)]
)
def test_what_an_error_moves_in_the_reflection_is_what_a_fit_without_it_finds_elsewhere(effects, name):
    one, seen, found = kinds()[name], Observed(NETWORK, MOUSE, vw.Blood()), []
    for side in (-0.2, 0.2):
        again = fitted(one.without(seen, one.center(seen) * np.exp(side * ALL[name])))
        found.append(float(again.result.laws["linear"].quantities["I_R"]))
    slope = np.log(found[1] / found[0]) / 0.4
    assert effects["flow"].loc["I_R", name] == pytest.approx(slope, rel=0.1, abs=4e-3)


def test_what_a_taper_moves_is_what_a_fit_of_straight_vessels_gets_wrong(fit):
    """Pressure of vessels that taper by 12 %, fitted by straight ones: true are those that it was made with."""
    fall, found = 0.12, {}
    for shape in (vw.Shape(), vw.Shape.falling(np.full(3, fall))):
        waves = vw.simulate(replace(fit.model, shape=shape), MOUSE.inflow, vw.Numerics(samples=512))
        pressure = waves["pressure"].to_numpy()[:, 0, 0]
        again = fitted(Observed(NETWORK, replace(MOUSE, pressure=pressure), vw.Blood()))
        found[shape.changes.any()] = derived(again.model, MOUSE.mean_pressure)
    effects = effects_on_fit(fit, replace(SETTINGS, taper_sd=fall), quantities).errors
    for quantity in ("stiffness", "wave_speed", "R_T"):
        wrong = np.log(found[True][quantity] / found[False][quantity])
        assert effects.loc[quantity, "taper"] == pytest.approx(-wrong, rel=0.1, abs=2e-3), quantity


def test_a_taper_at_which_the_flow_is_as_fast_as_its_waves_moves_what_smaller_ones_say(fit):
    """Vessels that lose 70 % of their radius cannot be simulated; by the line through those that lose 35 and 17.5 %."""
    smaller, half, whole = (
        effects_on_fit(fit, replace(SETTINGS, taper_sd=fall), quantities).errors for fall in (0.175, 0.35, 0.7)
    )
    for quantity in ("stiffness", "wave_speed", "R_T"):
        line = 3 * half.loc[quantity, "taper"] - 2 * smaller.loc[quantity, "taper"]
        # What a model's own radii add is not linear: within a tenth.
        assert whole.loc[quantity, "taper"] == pytest.approx(line, rel=0.1), quantity


def test_every_error_is_a_key_of_the_study_a_column_of_its_table_and_a_prior():
    for name, (title, _) in columns().items():
        assert name in vars(StudyFile())
        assert name in vars(vw.Priors())
        assert title in COLUMNS


def test_a_delayed_flow_comes_back_by_its_delay():
    later = kinds()["flow_delay"].without(Observed(NETWORK, MOUSE, vw.Blood()), 0.25 * MOUSE.period).recording
    count = len(MOUSE.flow)
    np.testing.assert_allclose(later.flow, np.roll(MOUSE.flow, -count // 4), atol=0.01)


def test_a_lag_that_is_fitted_is_an_error_no_more(effects):
    lagging = vw.calibrate(NETWORK, MOUSE, "linear", starts=1, pressure_lag_sd=ALL["pressure_lag"])
    found = effects_on_fit(lagging, SETTINGS, quantities).errors
    assert "pressure_lag" in effects["flow"].columns
    assert "pressure_lag" not in found.columns
    late = abs(found.loc["stiffness", "flow_delay"]), abs(effects["flow"].loc["stiffness", "flow_delay"])
    assert late[0] < 0.5 * late[1]  # the lag takes most of a delay
