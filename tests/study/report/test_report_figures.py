"""What the figures of one animal draw."""

from copy import deepcopy
from dataclasses import replace
from xml.etree import ElementTree

import numpy as np
import pytest
import xarray as xr

from made_cohort import bare_result, made_results
from made_fit import made_fit
from vasowave.pulse.examples import control_network
from vasowave.pulse.network import Network
from vasowave.study.animal import fitted_decay
from vasowave.study.cohort import gathered
from vasowave.study.figures import (
    ON_A_SHEET,
    fit_figure,
    layout,
    modeled,
    new_figure,
    nominal_figure,
    plot_pressure_area,
    sheet_figure,
    sheets,
    style,
    svg,
    vessels_figure,
)


@pytest.fixture(scope="module")
def cohort():
    return gathered(made_results({"sham": 1}))


@pytest.fixture(scope="module")
def result(cohort):
    return cohort.results[0]


def test_the_same_tree_gives_the_same_figure_to_the_last_byte(result):
    with style():
        one, other = fit_figure(result), fit_figure(result)
    assert svg(one) == svg(other)
    letters = "".join(ElementTree.fromstring(svg(one)).itertext())
    assert "pressure [mmHg]" in letters


def test_a_sheet_draws_every_animal_once_the_worst_fit_first(result):
    animals = []
    for number, error in enumerate((0.3, 0.9, 0.1)):
        one = replace(deepcopy(result), name=f"mouse {number}")
        for wall in ("linear", "tangent"):
            one.laws[wall].calibration["RMSE"].values = np.array(error)
        animals.append(one)
    assert [len(part) for part in sheets(animals * 20)] == [ON_A_SHEET, 12]
    (sheet,) = sheets(animals)
    drawing = sheet_figure(sheet, ["sham"])
    titles = [ax.get_title() for ax in drawing.axes if ax.lines]
    assert titles == [
        f"mouse {number}\nlin. {error:.2f}, tan. {error:.2f}" for number, error in ((1, 0.9), (0, 0.3), (2, 0.1))
    ]
    pressure = result.recording["pressure"].values
    time, drawn = drawing.axes[0].lines[0].get_data()
    there = np.interp(time, np.linspace(0, 1, len(pressure) + 1), np.append(pressure, pressure[0]))
    np.testing.assert_allclose(drawn, there, atol=1e-9)
    assert set(ElementTree.fromstring(svg(drawing)).itertext()) >= {"mouse 0", "mouse 1", "mouse 2"}


def test_the_fitted_decay_falls_by_e_in_one_time_constant(cohort, result):
    decay = nominal_figure(cohort).axes[1].get_lines()[1]
    time, pressure = decay.get_data()
    slope = np.log(pressure[0] / pressure[-1]) / (time[-1] - time[0])
    nominal = result.nominal
    assert 1 / slope == pytest.approx(float(nominal["tau"]), rel=1e-12)
    np.testing.assert_allclose(np.mean(np.log(pressure)), np.mean(np.log(nominal["decay_pressure"])), rtol=1e-12)


def test_a_decay_to_a_wedge_pressure_is_drawn_above_it():
    time = np.linspace(0.0, 0.1, 41)
    falling = 7.0 + 12.0 * np.exp(-time / 0.25)
    nominal = xr.Dataset({"tau": 0.25, "decay_time": ("decay", time), "decay_pressure": ("decay", falling)})
    above = bare_result(nominal=nominal, recording=xr.Dataset({"wedge_pressure": 7.0}))
    np.testing.assert_allclose(fitted_decay(above)[1], falling, rtol=1e-12)
    below = bare_result(
        nominal=nominal, recording=xr.Dataset({"wedge_pressure": 15.5})
    )  # it falls beneath: none is told
    drawn = fitted_decay(below)[1]
    np.testing.assert_allclose(drawn[0] / drawn[-1], np.exp(0.1 / 0.25), rtol=1e-12)
    np.testing.assert_allclose(np.mean(np.log(drawn)), np.mean(np.log(falling)), rtol=1e-12)


def test_the_thin_line_of_the_loop_is_the_wall_law_itself(result):
    ax = plot_pressure_area(new_figure(8, 8).subplots(), result)
    thin, thick = ax.get_lines()[:2]
    wall = made_fit("linear").model.wall
    beta = float(result.laws["linear"].quantities["beta"])
    ratio = thin.get_xdata() / control_network().area[0]
    np.testing.assert_allclose(thin.get_ydata(), wall.pressure_at(ratio, beta), rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(np.interp(thick.get_ydata(), *thin.get_data()[::-1]), thick.get_xdata(), rtol=1e-4)


def test_the_chosen_vessels_go_from_the_root_to_terminals_of_both_sides(result):
    network = control_network()
    chosen = modeled.main_vessels(network)
    assert chosen[:3] == ["1", "2", "3"]
    assert len(set(map(network.row, chosen)) & set(network.terminals.tolist())) == 2
    assert len(vessels_figure(result).axes) == 2 * len(chosen)


def test_no_two_vessels_of_the_diagram_lie_on_each_other():
    x, y = layout(control_network())
    assert len(set(zip(x.tolist(), y.tolist(), strict=True))) == len(control_network())


def test_of_more_than_two_daughters_of_the_root_the_two_with_most_flow_are_shown_with_their_ends():
    parent, radius = np.array([-1, 0, 0, 0, 1, 1, 2, 2]), np.array([0.05, 0.03, 0.02, 0.01, 0.02, 0.01, 0.015, 0.01])
    network = Network(tuple("abcdefgh"), parent, np.full(8, 0.3), radius)
    assert modeled.main_vessels(network, 5) == ["a", "b", "c", "e", "g"]
    assert modeled.main_vessels(network, 7) == list("abcdefgh")  # none is left out alone
