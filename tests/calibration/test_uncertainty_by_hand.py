"""What a table of parameters and its findings say of covariances that are made by hand, on the edge of each rule."""

import numpy as np
import pandas as pd
import pytest

from vasowave.calibration import uncertainty
from vasowave.calibration.parameters import parameter_space
from vasowave.calibration.search import _Hopeless, _require_promise
from vasowave.calibration.uncertainty import Spread, correlations, fit_findings, parameter_table
from vasowave.datasets import control_network, virtual_mouse
from vasowave.model.blood import Blood
from vasowave.model.nominal import estimate_nominal

NETWORK, MOUSE = control_network(), virtual_mouse()
NEAR = uncertainty._NEAR_BOUND


@pytest.fixture(scope="module")
def space():
    return parameter_space("linear", NETWORK, estimate_nominal(NETWORK, MOUSE), Blood(), {}, {"c1": 1.2}, False)


def spread(errors, assumed=False):
    errors = np.asarray(errors, float)
    correlation = np.array([[1, 0.5, 0], [0.5, 1, -0.2], [0, -0.2, 1]])
    return Spread(correlation * np.outer(errors, errors), errors / 2, assumed)


def rows(space, x=None, errors=(0.1, 0.2, 0.3)):
    middle = np.mean(space.log_bounds, axis=0)
    return parameter_table(space, middle if x is None else x, spread(errors))


def test_intervals_are_normal_on_logarithms_and_held_parameters_have_none(space):
    table = rows(space)
    free = table[table["free"]]
    assert free["standard_error"].to_numpy() == pytest.approx(free["value"] * [0.05, 0.1, 0.15])
    assert free["standard_error_correlated"].to_numpy() == pytest.approx(free["value"] * [0.1, 0.2, 0.3])
    assert np.log(free["interval_high"] / free["value"]).to_numpy() == pytest.approx(
        1.959964 * np.array([0.1, 0.2, 0.3])
    )
    assert np.log(free["value"] / free["interval_low"]).to_numpy() == pytest.approx(
        1.959964 * np.array([0.1, 0.2, 0.3])
    )
    assert free["determined"].all()
    held = table.loc["c1"]
    assert (held["value"], held["free"], held["determined"], held["at_bound"]) == (1.2, False, False, False)
    assert np.isnan(held["standard_error"])
    assert correlations(space, spread((0.1, 0.2, 0.3))).to_numpy()[0] == pytest.approx([1.0, 0.5, 0.0])


def test_a_parameter_is_determined_whose_interval_is_no_wider_than_it_may_be(space):
    limit = np.log(uncertainty.WIDEST) / (2 * 1.959964)
    table = rows(space, errors=(0.999 * limit, 1.001 * limit, 1e9))
    assert table.loc[table["free"], "determined"].tolist() == [True, False, False]
    assert np.isfinite(table["interval_high"].dropna()).all()


def test_a_parameter_stands_at_its_bound_as_near_as_the_search_ends(space):
    low, high = space.log_bounds
    middle = (low + high) / 2
    for end, side in ((low, 1), (high, -1)):
        for factor, there in ((0.9, True), (1.1, False)):
            x = middle.copy()
            x[1] = end[1] + side * factor * NEAR
            table = rows(space, x)
            assert bool(table.loc[table["free"], "at_bound"].iloc[1]) == there
            assert not table.loc[table["free"], "at_bound"].iloc[[0, 2]].any()
            found = [one.code for one in uncertainty._at_bounds(table)]
            assert len(found) == 1 + there  # c1 is held
    x = middle.copy()
    x[0], x[2] = low[0], high[2]
    first, second, held = uncertainty._at_bounds(rows(space, x))
    assert first.code != second.code
    assert "c1 = 1.2" in str(held)


def test_what_a_reader_must_know_is_said_and_nothing_else(space):
    names = list(space.free_names)

    def codes(correlation=0.0, agree=3, assumed=False, errors=(0.1, 0.2, 0.3)):
        matrix = pd.DataFrame(np.eye(3), names, names)
        matrix.loc[names[0], names[1]] = matrix.loc[names[1], names[0]] = correlation
        given = pd.DataFrame({"agrees": [place < agree for place in range(3)]})
        return [one.code for one in fit_findings(rows(space, errors=errors), matrix, given, spread(errors, assumed))][
            1:
        ]

    assert codes() == []
    limit = uncertainty._INSEPARABLE
    assert codes(limit) == codes(-limit) == []
    assert len(codes(limit + 1e-6)) == len(codes(-limit - 1e-6)) == 1
    assert len(codes(agree=2)) == len(codes(assumed=True)) == len(codes(errors=(0.1, 0.2, 9.0))) == 1
    (told,) = uncertainty.undetermined(rows(space, errors=(0.1, 0.2, 9.0)))
    assert dict(told.values)["low"] == pytest.approx(rows(space, errors=(0.1, 0.2, 9.0)).loc[names[2], "interval_low"])


def test_a_search_is_hopeless_whose_linear_model_leaves_more_than_is_enough():
    J = np.array([[1.0, 0.0], [0.0, 1.0], [0.0, 0.0]])
    r = np.array([5.0, -3.0, 2.0])  # what no parameter takes: 2² = 4
    _require_promise(r, J, 4.0)
    _require_promise(r, J, np.inf)
    with pytest.raises(_Hopeless):
        _require_promise(r, J, 3.999)
