"""The exponent that answers the wall question, and quantities averaged over wall laws by their weights."""

from dataclasses import replace

import numpy as np
import pytest
from scipy import stats

from made_fit import made_fit
from small_tree import SMALL
from vasowave.pulse.calibration import Search, calibrate, profile_likelihood
from vasowave.pulse.cycle import Recording
from vasowave.pulse.examples import virtual_mouse
from vasowave.pulse.model import Model, Numerics, PowerWall, windkessels
from vasowave.pulse.selection import Comparing, averaged, compare_models, law_weights, profiled, stiffening
from vasowave.pulse.solver import simulate


def with_exponent(value, low, high, at_bound=False):
    fit = made_fit("power")
    table = fit.parameters.copy()
    table.loc["m", ["value", "interval_low", "interval_high", "at_bound"]] = [value, low, high, at_bound]
    return replace(fit, parameters=table)


@pytest.mark.parametrize(
    ("numbers", "verdict", "words"),
    [
        ((2.0, 0.9, 4.0), "more", "stiffens with pressure more than the linear law"),
        ((0.2, 0.1, 0.4), "less", "less than the linear law"),
        ((2.0, 0.3, 13.0), "open", "does not tell"),
        ((50.0, 20.0, 90.0, True), "open", "at its bound"),
    ],
)
def test_the_exponents_interval_answers_the_wall_question(numbers, verdict, words):
    found = stiffening(with_exponent(*numbers))
    assert found.attrs["verdict"] == verdict
    assert words in found.attrs["said"]
    assert "pressure of the image is not known" in found.attrs["said"]
    assert ("taper" in found.attrs["said"]) == (verdict != "open")
    assert float(found["exponent"]) == numbers[0]


def test_laws_without_an_exponent_and_a_held_exponent_say_nothing():
    assert stiffening(made_fit("linear")) is None
    assert stiffening(made_fit("tangent")) is None
    held = made_fit("power")
    table = held.parameters.copy()
    table.loc["m", "free"] = False
    assert stiffening(replace(held, parameters=table)) is None


def linear_with(S):
    return replace(made_fit("linear"), S=S)


@pytest.mark.parametrize("verdict", ["more", "open"])
def test_the_interval_excludes_the_linear_law_where_the_likelihood_does(verdict):
    """The deviance of the linear law is its S over the variance, by the squares of the two standard errors."""
    power = with_exponent(2.0, 0.9, 4.0)
    row, free = power.parameters.loc["m"], int(power.parameters["free"].sum())
    scale = power.S / (power.N - free) * (row["standard_error_correlated"] / row["standard_error"]) ** 2
    limit = stats.chi2.ppf(0.95, 1)
    factor = {"more": 1.01, "open": 0.99}[verdict]
    linear, profile = profiled([linear_with(power.S + factor * limit * scale), power])
    assert linear.parameters.equals(made_fit("linear").parameters)
    found = stiffening(profile)
    assert found.attrs["verdict"] == verdict
    assert found["exponent"].attrs["interval_low"] == pytest.approx(0.5 * 4.0 ** (1 - factor**-0.5), rel=1e-6)
    assert found["exponent"].attrs["interval_high"] == 4.0


def test_without_a_linear_fit_that_is_worse_or_at_a_bound_an_interval_stays():
    power, stopped = with_exponent(2.0, 0.9, 4.0), with_exponent(2.0, 0.9, 4.0, at_bound=True)
    for fits in ([power], [linear_with(0.5 * power.S), power], [linear_with(9 * power.S), stopped]):
        assert profiled(fits)[-1].parameters.equals(fits[-1].parameters)


@pytest.mark.validation
def test_the_linear_law_is_the_point_of_the_exponents_profile_at_one_half():
    network, mouse = replace(SMALL, pressure=6.3), virtual_mouse()
    model = Model(network, PowerWall(15.0, 3.0), windkessels(network, 76.0, 0.12, 0.12))
    inlet = simulate(model, mouse, Numerics(samples=256, tolerance=1e-8))["pressure"].sel(vessel="1", station="inlet")
    noise = 0.1 * np.random.default_rng(2).standard_normal(256)
    recording = Recording(inlet.values + noise, mouse.resampled(256).flow, mouse.period)
    linear, power = (calibrate(network, recording, wall, search=Search(starts=2)) for wall in ("linear", "power"))
    m, free = power.parameters["value"]["m"], int(power.parameters["free"].sum())
    profile = profile_likelihood(power, "m", points=4, span=float(np.log(m / 0.5)))
    at_half = float(profile["deviance"].values[np.abs(profile["m"].values - 0.5).argmin()])
    assert float(np.abs(profile["m"] - 0.5).min()) < 1e-6
    assert (linear.S / power.S - 1) * (power.N - free) == pytest.approx(at_half, rel=0.02)


@pytest.mark.validation
@pytest.mark.parametrize("true", [0.5, 3.0])
def test_the_exponent_of_a_simulated_animal_is_found(true):
    network, mouse = replace(SMALL, pressure=6.3), virtual_mouse()
    model = Model(network, PowerWall(45.0 if true == 0.5 else 15.0, true), windkessels(network, 76.0, 0.12, 0.12))
    inlet = simulate(model, mouse, Numerics(samples=256, tolerance=1e-8))["pressure"].sel(vessel="1", station="inlet")
    recording = Recording(inlet.values, mouse.resampled(256).flow, mouse.period)
    found = stiffening(calibrate(network, recording, "power", search=Search(starts=1)))
    assert float(found["exponent"]) == pytest.approx(true, rel=0.01)
    assert found.attrs["verdict"] == ("open" if true == 0.5 else "more")


def test_equal_answers_of_all_laws_are_the_average_and_its_interval_their_own():
    found = averaged([60.0, 60.0, 60.0], [0.1, 0.1, 0.1], [0.2, 0.5, 0.3])
    reach = 1.959964 * 0.1
    assert found == pytest.approx((60.0, 60 * np.exp(-reach), 60 * np.exp(reach), 0.0))


def test_the_interval_over_laws_is_that_of_draws_from_their_mixture():
    values, errors, weights = [200.0, 390.0, 260.0], [0.1, 0.3, 0.05], [0.5, 0.2, 0.3]
    rng = np.random.default_rng(1)
    laws = rng.choice(3, 400_000, p=weights)
    draws = np.log(values)[laws] + np.array(errors)[laws] * rng.standard_normal(400_000)
    found = averaged(values, errors, weights)
    assert np.log([found.low, found.high]) == pytest.approx(np.quantile(draws, [0.025, 0.975]), abs=0.01)
    assert np.log(found.value) == pytest.approx(np.median(draws), abs=0.003)
    between = np.var(np.repeat(np.log(values), [5, 2, 3]))
    assert found.between == pytest.approx(between / (between + np.dot(weights, np.square(errors))))


def three_fits():
    return [made_fit(wall) for wall in ("linear", "tangent", "power")]


def test_weights_are_those_of_the_differences_of_aicc_and_sum_to_one():
    selection = compare_models(three_fits(), Comparing(covariances=("circulant", "independent")))
    weights = law_weights(selection)
    np.testing.assert_allclose(weights.sum("wall"), 1)
    assert str(weights["covariance"].values[0]) == selection.attrs["preferred_covariance"]
    table = selection.to_dataframe().query("covariance == 'independent'").set_index("wall")
    one = weights.sel(covariance="independent")
    ratio = float(one.sel(wall="linear") / one.sel(wall="tangent"))
    expected = -0.5 * (table["AICc"]["linear"] - table["AICc"]["tangent"])
    assert np.log(ratio) == pytest.approx(expected, abs=1e-6)
