"""Starts that the linear model leads to one place are followed once, and none is lost by that."""

import numpy as np

import vasowave as vw
from vasowave import pulse
from vasowave.pulse.calibration import ParameterLimits, compared_part, parameter_space, screened
from vasowave.pulse.calibration import starts as starting
from vasowave.pulse.examples import control_network, virtual_mouse
from vasowave.pulse.model import Blood, estimate_nominal

NETWORK, MOUSE = control_network(), virtual_mouse()
COARSE = vw.Numerics(cell_size=0.3, tolerance=1e-6)


def posed(law, **fixed):
    space = parameter_space(law, NETWORK, estimate_nominal(NETWORK, MOUSE), Blood(), ParameterLimits(fixed=fixed))
    return space, compared_part(MOUSE, "signal"), starting.starting_points(space, 12, seed=3)


def test_starts_of_a_linear_wall_are_led_to_where_the_fit_ends():
    space, compared, starts = posed("linear")
    places, leads = screened(space, compared, starts)
    fit = pulse.calibrate(NETWORK, MOUSE, "linear", starts=1, numerics=COARSE)
    ended = np.log(fit.parameters["value"].to_numpy()[space.free])
    assert len(set(leads)) <= 3
    assert np.max(np.abs(places[0] - ended)) < 0.3
    assert np.max(np.abs(starts[5] - ended)) > 0.3


def test_every_start_has_its_row_and_says_by_which_one_it_was_stood_for():
    reached = []
    fit = pulse.calibrate(
        NETWORK, MOUSE, "linear", starts=8, numerics=COARSE, progress=lambda *one: reached.append(one)
    )
    assert len(fit.starts) == 8
    stood_for = fit.starts[fit.starts["message"].str.startswith("the linear model leads it")]
    assert len(stood_for) >= 4
    assert (stood_for["simulations"] == 0).all()
    assert stood_for["agrees"].all()
    assert reached[-1][:2] == (8, 8)


def test_starts_of_a_wall_that_stiffens_begin_where_they_are():
    fit = pulse.calibrate(NETWORK, MOUSE, "tangent", starts=2, numerics=COARSE)
    assert (fit.starts["simulations"] > 0).all()


def test_the_papers_method_begins_where_the_paper_begins():
    fit = pulse.calibrate(NETWORK, MOUSE, "linear", starts=2, method="sqp", numerics=COARSE)
    assert (fit.starts["simulations"] > 0).all()
