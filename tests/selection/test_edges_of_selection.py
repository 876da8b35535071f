"""How a wall stiffens, weights of laws, and what may be compared, by arithmetic and on the edge of each rule."""

import json
from dataclasses import replace

import numpy as np
import pytest
import xarray as xr

from made_fit import made_fit, made_recording
from vasowave.calibration.uncertainty import UNDETERMINED
from vasowave.errors import InputError
from vasowave.noise.models import CirculantNoise, DenseNoise
from vasowave.selection.averaging import averaged_draws, law_weights
from vasowave.selection.choices import answers
from vasowave.selection.compare import Comparing, _check_fits, _series, compare_models
from vasowave.selection.criteria import aicc, noise_bic, scored
from vasowave.selection.stiffening import profiled, stiffening

LINEAR, POWER = made_fit("linear"), made_fit("power")


def power(S=None, **changes):
    table = POWER.parameters.copy()
    for name, value in changes.items():
        table.loc["m", name] = value
    return replace(POWER, parameters=table, S=POWER.S if S is None else S)


def test_the_end_toward_the_linear_law_is_where_the_likelihood_leads():
    fit = power(S=100.0, value=1.7, standard_error=0.17, standard_error_correlated=0.34)
    linear = replace(LINEAR, S=110.0)
    _, found = profiled([linear, fit])
    row = found.parameters.loc["m"]
    at = POWER.model.wall.law().linear_at[1]
    free = 5
    deviance = (110 / 100 - 1) * (fit.N - free) * (0.1 / 0.2) ** 2
    assert row["interval_low"] == pytest.approx(1.7 * np.exp(-1.959964 * np.log(1.7 / at) / np.sqrt(deviance)))
    assert row["interval_high"] == fit.parameters.loc["m", "interval_high"]
    below = power(S=100.0, value=0.3, standard_error=0.03, standard_error_correlated=0.06)
    row = profiled([linear, below])[1].parameters.loc["m"]
    assert row["interval_high"] == pytest.approx(0.3 * np.exp(-1.959964 * np.log(0.3 / at) / np.sqrt(deviance)))
    assert row["interval_low"] == below.parameters.loc["m", "interval_low"]
    assert row["determined"] == (row["interval_high"] <= 4 * row["interval_low"])


@pytest.mark.parametrize(
    "kept",
    [
        power(S=100.0, free=False), power(S=100.0, at_bound=True), power(S=110.0), power(S=111.0),
        power(S=100.0, standard_error_correlated=np.nan), power(S=100.0, standard_error_correlated=0.0),
        power(S=100.0, value=0.5 * np.exp(0.099), standard_error_correlated=0.1 * 2 * np.exp(0.099)),
        replace(power(S=100.0), residual=np.zeros(5)),
    ],
)  # fmt: skip
def test_an_interval_stays_where_the_likelihood_leads_nowhere(kept):
    linear = replace(LINEAR, S=110.0, residual=kept.residual)
    assert profiled([linear, kept])[1] is kept


def test_other_laws_stay_as_they_are_and_findings_follow_the_interval():
    tangent = made_fit("tangent")
    assert profiled([tangent, POWER]) == [tangent, POWER]
    assert profiled([replace(LINEAR, S=1e9), tangent])[1] is tangent
    other = replace(LINEAR, residual=LINEAR.residual[:-1], S=1e9)
    assert profiled([other, POWER])[1] is POWER
    loose = power(S=100.0, determined=False, interval_low=0.1, interval_high=9.0)
    said = UNDETERMINED(parameter="m", low=0.1, high=9.0)
    found = profiled([replace(LINEAR, S=400.0), replace(loose, findings=(said,))])[1]
    assert said not in found.findings


def asked(value=1.7, low=1.2, high=2.5, at_bound=False, free=True, pressure=0.0):
    fit = power(value=value, interval_low=low, interval_high=high, at_bound=at_bound, free=free)
    network = replace(fit.model.network, pressure=pressure)
    return stiffening(replace(fit, model=fit.model.changed(network=network) if pressure else fit.model))


@pytest.mark.parametrize(
    ("low", "high", "at_bound", "verdict"),
    [
        (0.501, 2.0, False, "more"), (0.5, 2.0, False, "open"), (0.1, 0.499, False, "less"), (0.1, 0.5, False, "open"),
        (0.6, 2.0, True, "open"), (0.1, 0.2, True, "open"),
    ],
)  # fmt: skip
def test_a_wall_stiffens_more_or_less_where_its_interval_leaves_the_linear_law_out(low, high, at_bound, verdict):
    found = asked(low=low, high=high, at_bound=at_bound)
    assert found.attrs["verdict"] == verdict
    said = found.attrs["said"]
    assert f"m = 1.7 [{low:.2g}, {high:.2g}] (95 %), where 0.5 is the linear wall." in said
    assert ("The value lies at its bound" in said) is at_bound
    assert ("can look like this, and none of them" in said) is (verdict != "open")
    assert said.endswith("The pressure of the image is not known, and this answer hangs on it.")
    assert found["exponent"].attrs["interval_low"] == low
    assert found["exponent"].attrs["at_bound"] == int(at_bound)


def test_laws_without_such_a_parameter_and_held_ones_say_nothing():
    assert stiffening(LINEAR) is None
    assert asked(free=False) is None


def test_weights_of_laws_fall_with_half_their_difference():
    table = xr.Dataset({
        "covariance": ("candidate", ["white", "white", "red", "red", "bad", "bad"]),
        "wall": ("candidate", ["linear", "tangent"] * 3),
        "AICc_difference": ("candidate", [0.0, 3.0, 2.0, 0.0, 0.0, 9.0]),
        "discarded": ("candidate", [0.0, 0.0, 0.0, 0.0, 1.0, 1.0]),
    })  # fmt: skip
    found = law_weights(table)
    assert found["covariance"].values.tolist() == ["white", "red"]
    assert found.values == pytest.approx(
        np.array([[1, np.exp(-1.5)], [np.exp(-1), 1]]) / [[1 + np.exp(-1.5)], [1 + np.exp(-1)]]
    )
    with pytest.raises(InputError, match="every noise model of the comparison is discarded"):
        law_weights(table.isel(candidate=[4, 5]))


def test_draws_of_laws_are_joined_by_their_weights():
    found = averaged_draws([np.full(10, 1.0), np.full(1000, 4.0)], np.array([0.6, 0.4]))
    assert (found.low, found.value, found.high) == pytest.approx((1.0, 1.0, 4.0))
    assert found.between == 1.0
    spread = averaged_draws([np.exp([0.0, 2.0]), np.exp([3.0, 3.0])], np.array([0.5, 0.5]))
    assert spread.between == pytest.approx(1.0 / (1.0 + 0.5))


def test_a_noise_model_is_judged_with_the_hyperparameters_that_were_fitted():
    rows = [
        {"loglik": -10.0, "N": 60, "covariance": "white", "hyperparameters": json.dumps({"a": 1, "b": 2, "c": 3})}
    ] * 2
    assert noise_bic(rows) == pytest.approx(40 + 3 * np.log(120))
    arma = [one | {"covariance": "ARMA"} for one in rows]  # orders are none
    assert noise_bic(arma) == pytest.approx(40 + 1 * np.log(120))
    residuals = {"b": np.array([1.0, -1, 2, 0.5, 0, 0, 0, 0, 0]), "a": np.array([0.5, 1, 0, 0, 0, 0, 0, 0, 0])}
    noise = DenseNoise(np.eye(9), 0.25, {"x": 1.0})
    found = scored(residuals, {"a": 3, "b": 2}, noise)
    log = {name: -0.5 * (9 * np.log(2 * np.pi) + r @ r) for name, r in residuals.items()}
    scores = {"a": aicc(log["a"], 3, 9), "b": aicc(log["b"], 2, 9)}
    assert [row["wall"] for row in found] == sorted(scores, key=scores.get)
    assert found[0]["lambda"] == 0.25
    assert found[1]["AICc_difference"] == pytest.approx(abs(scores["a"] - scores["b"]))
    assert np.isnan(scored(residuals, {"a": 3, "b": 2}, CirculantNoise(np.ones(5), 9, {}))[0]["lambda"])


def test_fits_are_compared_that_follow_the_same_cycle():
    tangent = made_fit("tangent")
    _check_fits([LINEAR, tangent])
    for fits in ([], [LINEAR], [LINEAR, LINEAR], [LINEAR, tangent, tangent]):
        with pytest.raises(InputError, match=r"a comparison needs fits of different wall laws; given: (none|linear)"):
            _check_fits(fits)
    shifted = made_recording()
    for other in (
        replace(tangent, residual=tangent.residual[:-1]),
        replace(tangent, compared=replace(tangent.compared, recording=replace(shifted, period=0.2))),
        replace(tangent, compared=replace(tangent.compared, recording=replace(shifted, pressure=shifted.pressure + 1))),
    ):
        with pytest.raises(InputError, match="the tangent wall was fitted to another recording, or to other harmonics"):
            _check_fits([LINEAR, other])
    with pytest.raises(InputError, match=r"have shape \(15,\)"):
        _series({"a": np.ones(15), "b": np.ones(15)}, {"a": 1, "b": 1}, 0.1)
    assert _series({"a": np.ones(16), "b": np.ones(16)}, {"a": 1, "b": 1}, 0.1).shape == (2, 16)
    with pytest.raises(InputError, match="have shape"):
        _series({"a": np.ones((16, 1)), "b": np.ones((16, 1))}, {"a": 1, "b": 1}, 0.1)
    with pytest.raises(InputError, match="n_parameters of a"):
        _series({"a": np.ones(16), "b": np.ones(16)}, {"a": 1}, 0.1)


def test_covariances_are_tried_one_after_the_other_and_told():
    heard = []
    found = compare_models(
        [LINEAR, made_fit("tangent")], Comparing(("independent", "circulant"), seed=3), samples=64,
        progress=lambda *told: heard.append(told),
    )  # fmt: skip
    assert heard == [(1, 2, "independent"), (2, 2, "circulant")]
    assert set(found["N"].values) == {64.0}
    assert set(found["D"].values) == {4.0, 5.0}
    assert found.attrs["seed"] == 3
    assert set(
        compare_models([LINEAR, made_fit("tangent")], Comparing(("independent",)), samples=None)["N"].values
    ) == {128.0}


def test_answers_of_several_fits_have_their_differences_beside_them():
    table = answers([LINEAR, made_fit("tangent")], "independent")
    assert list(table.index) == ["linear", "tangent"]
    assert table.columns.tolist()[:4] == ["N", "S [mmHg2]", "mean square [mmHg2]", "AICc difference"]
    assert table["AICc difference"].min() == 0.0
    assert "AICc difference" not in answers([LINEAR])
