"""Calibration recovers what it should, and says what it cannot."""

import numpy as np
import pytest

from small_tree import SMALL
from vasowave.base import InputError
from vasowave.pulse.calibration import Search, calibrate
from vasowave.pulse.cycle import Recording
from vasowave.pulse.examples import control_network, virtual_mouse
from vasowave.pulse.model import LinearWall, Model, Numerics, TangentWall, windkessels
from vasowave.pulse.solver import simulate

_TRUE = {"R_T": 76.0, "tau": 0.12, "a": 0.12}


def _noise_free(wall, inflow, viscosity=0.0, network=None):
    network = control_network() if network is None else network
    outlets = windkessels(network, _TRUE["R_T"], _TRUE["tau"], _TRUE["a"])
    model = Model(network, wall, outlets, wall_viscosity=viscosity)
    result = simulate(model, inflow, Numerics(samples=256, tolerance=1e-9))
    return Recording(result.pressure.values[:, network.root, 0], inflow.resampled(256), inflow.period)


@pytest.mark.parametrize(
    ("name", "wall"), [("linear", LinearWall(57.0)), ("tangent", TangentWall(9.0, 4.0))], ids=["linear", "tangent"]
)
def test_known_parameters_are_recovered_from_noise_free_data(inflow, name, wall):
    recording = _noise_free(wall, inflow)
    fit = calibrate(control_network(), recording, name, search=Search(starts=1), numerics=Numerics(tolerance=1e-8))
    for parameter, truth in zip(wall._fields, wall, strict=True):
        assert fit.parameters["value"][parameter] == pytest.approx(truth, rel=1e-4)
    assert fit.total_resistance == pytest.approx(_TRUE["R_T"], rel=1e-4)
    assert fit.resistance_ratio == pytest.approx(_TRUE["a"], rel=1e-4)
    outlets = fit.model.outlets
    np.testing.assert_allclose((outlets.R1 + outlets.R2) * outlets.C, _TRUE["tau"], rtol=1e-4)


def test_least_squares_and_sqp_find_the_same_optimum(inflow):
    recording = _noise_free(LinearWall(57.0), inflow)
    pressure = recording.pressure + 0.3 * np.sin(2 * np.pi * 3 * np.arange(256) / 256)
    noisy = Recording(pressure, recording.flow, recording.period)
    fits = [
        calibrate(control_network(), noisy, search=Search(starts=1, method=method))
        for method in ("least-squares", "sqp")
    ]
    assert fits[1].S == pytest.approx(fits[0].S, rel=1e-3)
    np.testing.assert_allclose(fits[1].parameters["value"], fits[0].parameters["value"], rtol=0.02)


def test_a_parameter_can_be_held_and_a_bound_is_reported(inflow):
    recording = _noise_free(LinearWall(57.0), inflow)
    search = Search(starts=1, fixed={"c1": 1.0}, bounds={"beta": (60.0, 90.0)})
    fit = calibrate(control_network(), recording, search=search)
    assert fit.parameters["value"]["c1"] == 1.0
    assert not fit.parameters["free"]["c1"]
    assert fit.parameters["at_bound"]["beta"]
    assert any("beta = 60 lies at its lower bound" in str(one) for one in fit.findings)


def test_a_search_that_was_stopped_says_so_before_all_else(inflow):
    def interrupted(*told):
        raise KeyboardInterrupt

    recording = _noise_free(LinearWall(57.0), inflow)
    fit = calibrate(control_network(), recording, search=Search(starts=1), progress=interrupted)
    assert str(fit.findings[0]) == "Interrupted: 1 of 1 starts had finished."
    assert len(fit.findings) > 1


@pytest.mark.parametrize(
    ("asked", "words"),
    [
        ({"fixed": {"betta": 1.0}}, r"no parameter 'betta' \(did you mean 'beta'\?\); it has: beta"),
        ({"fixed": {"wall_viscosity": 0.1}}, "no parameter 'wall_viscosity'"),  # elastic walls have none
        ({"fixed": {"beta": 0.0}}, "fixed.beta: 0 is too small; it must be above 0"),
        ({"fixed": {"beta": np.nan}}, "fixed.beta"),
        ({"fixed": dict.fromkeys(("beta", "r1", "r2", "c1"), 1.0)}, "every parameter is held fixed"),
        ({"bounds": {"beta": (0.0, 1.0)}}, "bounds.beta.0: 0 is too small; it must be above 0"),
        ({"bounds": {"beta": (3.0, 2.0)}}, "3 is not below 2"),
    ],
)
def test_parameters_that_cannot_be_held_or_bounded_so_are_refused(asked, words):
    with pytest.raises(InputError, match=words):
        calibrate(control_network(), virtual_mouse(), **asked)


@pytest.mark.parametrize(
    ("name", "wall"),
    [
        pytest.param("linear", LinearWall(57.0), marks=pytest.mark.weekly),
        pytest.param("tangent", TangentWall(9.0, 4.0), marks=pytest.mark.weekly),
    ],
)
def test_the_viscosity_of_the_walls_is_recovered_from_noise_free_data(inflow, name, wall):
    recording = _noise_free(wall, inflow, 0.3, SMALL)
    fit = calibrate(SMALL, recording, name, starts=1, viscous=True, numerics=Numerics(tolerance=1e-8))
    for parameter, truth in {**wall._asdict(), "wall_viscosity": 0.3}.items():
        assert fit.parameters["value"][parameter] == pytest.approx(truth, rel=1e-3)
    assert fit.resistance_ratio == pytest.approx(_TRUE["a"], rel=1e-3)
    np.testing.assert_allclose(fit.model.wall_viscosity, 0.3, rtol=1e-3)
