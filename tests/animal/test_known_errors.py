"""Errors that a lab says: what they move, checked by fits of recordings and networks without them."""

from dataclasses import replace

import numpy as np
import pytest

import vasowave as vw
from vasowave.animal.animal import Animal, Settings
from vasowave.animal.known_errors import effects_on_fit
from vasowave.animal.pipeline import analyze
from vasowave.inference.known_errors import Seen, columns, kinds
from vasowave.quantities import derived
from vasowave.study.rows import COLUMNS
from vasowave.study.settings import StudyFile

MOUSE = vw.virtual_mouse()
NETWORK = vw.Network(("1", "2", "3"), [-1, 0, 0], [0.4, 0.4, 0.5], [0.05, 0.035, 0.04], pressure=6.0)
ALL = {
    "radius_scale": 0.05, "length_scale": 0.05, "image_pressure": 0.3, "flow_gain": 0.07, "flow_delay": 0.001,
    "zero": 0.5, "viscosity": 0.1,
}  # fmt: skip
SETTINGS = Settings(
    walls=("linear",), starts=1, model_selection=False, **{f"{name}_sd": sd for name, sd in ALL.items()}
)


def fitted(seen, enters="flow"):
    return vw.calibrate(seen.network, seen.recording, "linear", starts=1, blood=seen.blood, enters=enters)


def quantities(values, model, mean):
    return {**values, **derived(model, mean)}


@pytest.fixture(scope="module")
def fit():
    return fitted(Seen(NETWORK, MOUSE, vw.Blood()))


@pytest.fixture(scope="module")
def effects(fit):
    by_pressure = fitted(Seen(NETWORK, MOUSE, vw.Blood()), "pressure")
    return {
        "flow": effects_on_fit(fit, SETTINGS, quantities),
        "pressure": effects_on_fit(by_pressure, replace(SETTINGS, enters="pressure"), quantities),
    }


@pytest.mark.parametrize("enters", ["flow", "pressure"])
@pytest.mark.parametrize("name", ALL)
def test_what_an_error_moves_in_a_fit_is_what_a_fit_without_it_finds_elsewhere(effects, name, enters):
    one, seen = kinds()[name], Seen(NETWORK, MOUSE, vw.Blood())
    found, share = {}, 0.2  # of an SD, so that slopes hold
    for side in (-share, share):
        value = one.center(seen) * np.exp(side * ALL[name]) if one.positive else one.center(seen) + side * ALL[name]
        again = fitted(one.without(seen, value), enters)
        mean = again.recording.mean_pressure
        found[side] = derived(again.model, mean)
    for quantity in ("stiffness", "wave_speed", "R_T"):
        slope = np.log(found[share][quantity] / found[-share][quantity]) / (2 * share)
        # Least squares is linear in the errors within a few per cent of what an SD moves.
        assert effects[enters].loc[quantity, name] == pytest.approx(slope, rel=0.06, abs=2e-3), quantity


def test_the_resistance_moves_against_the_gain_of_the_probe(effects):
    assert effects["flow"].loc["R_T", "flow_gain"] == pytest.approx(-0.07, abs=0.02)


def test_intervals_and_shares_of_a_result_hold_the_errors_that_are_said():
    animal = Animal("mouse", "CTL", NETWORK, MOUSE, synthetic=True)
    plain = analyze(animal, replace(SETTINGS, **{f"{name}_sd": None for name in ALL}))
    told = analyze(animal, SETTINGS)
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


def test_an_error_that_is_not_told_is_taken_for_none_in_fits_and_for_usual_in_posteriors():
    assert Settings().said() == {}
    assert Settings().priors.sd("zero") == 0.5
    assert Settings(zero_sd=1.5).priors.sd("zero") == 1.5
    assert Settings(radius_scale_sd=0).priors.sd("radius_scale") == 0


def test_every_error_is_a_key_of_the_study_a_column_of_its_table_and_a_prior():
    for name, (title, _) in columns().items():
        assert name in vars(StudyFile())
        assert name in vars(vw.Priors())
        assert title in COLUMNS


def test_a_delayed_flow_comes_back_by_its_delay():
    later = kinds()["flow_delay"].without(Seen(NETWORK, MOUSE, vw.Blood()), 0.25 * MOUSE.period).recording
    count = len(MOUSE.flow)
    np.testing.assert_allclose(later.flow, np.roll(MOUSE.flow, -count // 4), atol=0.01)
