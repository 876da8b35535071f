"""What further measurements would add, against Ohm's law, counts of beats, and posteriors with the measurement made."""

import numpy as np
import pytest

import vasowave as vw
from vasowave.pulse.calibration import calibrate
from vasowave.pulse.inference import expected_precision, posterior

TUBE = vw.Network(("1",), [-1], [0.4], [0.05])
TREE = vw.Network(("1", "2", "3"), [-1, 0, 0], [0.4, 0.3, 0.5], [0.05, 0.042, 0.036])
EXACT = {
    "flow_gain_sd": 0.0,
    "taper_sd": 0.0,
    "radius": 0.0,
    "length": 0.0,
    "radius_scale_sd": 0.0,
    "length_scale_sd": 0.0,
    "k_sd": 0.0,
}
MOUSE = vw.virtual_mouse()


def test_a_wedge_pressure_adds_to_the_resistance_what_ohms_law_says():
    """p - p_wedge = Q (R1 + R2): what is unknown of p and of p_wedge is unknown of R2, beside its prior."""
    search = vw.Search(fixed={"beta": 55.0, "r1": 1.0, "c1": 1.0}, pressure_harmonics=8)
    errors = np.append(0.0, np.full(256, 50.0))  # so that the mean alone tells
    recording, spread = vw.Recording(MOUSE.pressure, MOUSE.flow, MOUSE.period, pressure_error=errors), 5.0
    priors = vw.Priors(parameters={"r2": (1.0, 2.0)}, zero_sd=1.0, wedge=spread, discrepancy=(1e-4, 0.1), **EXACT)
    table = expected_precision(TUBE, recording, search=search, priors=priors).table
    row, resistance = table.loc["r2"], vw.estimate_nominal(TUBE, MOUSE).outlets.R2.item()
    drop = MOUSE.cardiac_output * resistance * row["value"]
    sds = [1 / np.hypot(1 / 2.0, drop / np.hypot(1.0, wedge)) for wedge in (spread, 0.5)]
    assert np.log(row["high"] / row["low"]) == pytest.approx(2 * 1.96 * sds[0], rel=0.03)
    assert row["wedge pressure"] == pytest.approx(sds[1] / sds[0], rel=0.03)


def test_four_times_the_beats_halve_what_their_scatter_leaves_open():
    errors = np.full(257, 0.5)
    recording = vw.Recording(MOUSE.pressure, MOUSE.flow, MOUSE.period, pressure_error=errors)
    priors = vw.Priors(parameters={"beta": (60.0, 2.0)}, zero_sd=0.0, discrepancy=(1e-4, 0.1), **EXACT)
    search = vw.Search(fixed={"r1": 1.0, "r2": 1.0, "c1": 1.0}, pressure_harmonics=8)
    table = expected_precision(TUBE, recording, search=search, priors=priors, start={"beta": 50.0}).table
    assert table.loc["beta", "4 × the beats"] == pytest.approx(0.5, abs=0.01)
    assert table.loc["beta", "wedge pressure"] == pytest.approx(1.0, abs=0.05)


def test_every_measurement_adds_something_or_nothing_and_all_of_them_most():
    search = vw.Search(starts=1, fixed={"r1": 1.0, "c1": 1.0}, pressure_harmonics=8)
    fit = calibrate(TREE, MOUSE, search=search)
    expected = expected_precision(TREE, MOUSE, vessels=("2", "3", "2"), start=fit.parameters["value"], search=search)
    factors = expected.table[[*expected.measurements]]
    assert expected.measurements[:3] == ("pressure in 2", "pressure in 3", "wedge pressure")
    once = expected_precision(TREE, MOUSE, vessels=("2", "3"), start=fit.parameters["value"], search=search)
    assert expected.table.equals(once.table)
    assert (factors.to_numpy() <= 1 + 1e-9).all()
    assert (factors["all of them"] <= factors.min(axis=1) + 1e-9).all()
    assert factors.loc["beta", "scale of the image"] < 0.95
    assert "wedge pressure × 0." in repr(expected)


@pytest.mark.parametrize(
    ("asked", "words"),
    [({"vessels": ("4",)}, "no vessel '4'.* there are: '1', '2', '3'"), ({"vessels": [2]}, "no vessel 2 .*mean '2'"),
     ({"vessels": 5}, "list of names"), ({"vessels": [["2"]]}, "list of names"), ({"beats": 1}, "2 or more"),
     ({"beats": "4"}, "whole number"), ({"beats": np.nan}, "whole number"), ({"beat": 2}, "beat")],
)  # fmt: skip
def test_what_cannot_be_measured_is_refused(asked, words):
    with pytest.raises(vw.errors.InputError, match=words):
        expected_precision(TREE, MOUSE, search=vw.Search(pressure_harmonics=8), **asked)


@pytest.mark.weekly
def test_posteriors_with_the_measurement_made_are_as_narrow_as_was_foretold():
    random, truth = np.random.default_rng(5), vw.estimate_nominal(TREE, MOUSE).outlets.scaled(1.3, 0.8, 0.9)
    waves = vw.simulate(vw.Model(TREE, vw.LinearWall(70.0), truth), MOUSE)
    inlet, second = (waves.pressure.sel(vessel=name, station=station).values
                     for name, station in (("1", "inlet"), ("3", "middle")))  # fmt: skip
    noisy = vw.Recording(inlet + 0.1 * random.normal(size=len(inlet)), MOUSE.flow, MOUSE.period)
    search = vw.Search(starts=2, pressure_harmonics=12)
    fit = calibrate(TREE, noisy, search=search)
    expected = expected_precision(TREE, noisy, vessels=("3",), start=fit.parameters["value"], search=search).table
    site = vw.Observation("pressure", "3", 0.1, waveform=second + 0.1 * random.normal(size=len(second)))
    made = {
        "pressure in 3": {"sites": (site,)},
        "wedge pressure": {"priors": vw.Priors(wedge=0.5)},
        "scale of the image": {"priors": vw.Priors(wedge=3.0, radius_scale_sd=0.0, length_scale_sd=0.0)},
    }

    def widths(**settings):
        arguments = {"fit": fit, "search": search, "draws": 200, "priors": vw.Priors(wedge=3.0)} | settings
        summary = posterior(TREE, noisy, **arguments).summary.loc[expected.index]
        return np.log(summary["interval_high"] / summary["interval_low"])

    now = widths()
    ratios = np.concatenate([widths(**settings) / now / expected[name] for name, settings in made.items()])
    assert np.mean(np.abs(ratios - 1) < 0.2) >= 0.8
