"""What is said of an optimum, from tables made by hand."""

import numpy as np
import pandas as pd
import pytest

from vasowave.base import texts
from vasowave.pulse.calibration import ParameterSpread, fit_findings, parameter_space, parameter_table
from vasowave.pulse.examples import control_network, virtual_mouse
from vasowave.pulse.model import Blood, estimate_nominal

AGREE = pd.DataFrame({"agrees": [True, True]})
NONE = pd.DataFrame()


@pytest.fixture(scope="module")
def space():
    network = control_network()
    return parameter_space("linear", network, estimate_nominal(network, virtual_mouse()), Blood())


def spread(errors, assumed=False):
    return ParameterSpread(np.diag(np.square(errors)), np.array(errors), assumed)


def said(space, x, one, correlation=NONE, starts=AGREE):
    return texts(fit_findings(parameter_table(space, x, one), correlation, starts, one))


def test_a_parameter_is_determined_if_the_ends_of_its_interval_differ_by_at_most_a_factor_of_four(space):
    x = np.log(space.nominal)
    edge = np.log(4.0) / 2 / 1.959964
    one = spread([0.99 * edge, 1.01 * edge, 0.1, 0.1])
    table = parameter_table(space, x, one)
    assert table["determined"].tolist() == [True, False, True, True]
    assert said(space, x, one) == ["The data do not determine r1: its 95 % interval reaches from 0.497 to 2.01."]


@pytest.mark.parametrize(("end", "further"), [("lower", "smaller"), ("upper", "larger")])
def test_a_parameter_at_its_bound_is_said_to_want_beyond_that_bound(space, end, further):
    x = np.log(space.nominal)
    x[1] = np.log(getattr(space, end)[1])
    (line,) = said(space, x, spread([0.01] * 4))
    assert line.startswith("r1 = ")
    assert f"{end} bound: the best fit would be at a {further} value" in line


def test_an_assumption_that_decides_and_parameters_that_cannot_be_told_apart_are_named(space):
    names = list(space.names)
    correlation = pd.DataFrame(np.eye(4), index=names, columns=names)
    correlation.loc["beta", "r1"] = correlation.loc["r1", "beta"] = -0.97
    lines = said(space, np.log(space.nominal), spread([0.01] * 4, assumed=True), correlation)
    assert any("beta and r1 can hardly be told apart (correlation -0.970)" in line for line in lines)
    assert any("rests on the assumption" in line for line in lines)


def test_of_a_clean_optimum_nothing_is_said(space):
    assert said(space, np.log(space.nominal), spread([0.01] * 4)) == []
