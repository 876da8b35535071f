"""A model over a grid of values: each member is the model with that value; a stored fit is a model again."""

import numpy as np
import pytest

from vasowave.base import InputError, NumericalError
from vasowave.pulse.examples import control_network, virtual_mouse
from vasowave.pulse.model import LinearWall, Model, changed_model, windkessels
from vasowave.pulse.solver import simulate, sweep


@pytest.fixture(scope="module")
def model():
    network = control_network()
    return Model(network, LinearWall(57.0), windkessels(network, 76.0, 0.11, a=0.12))


def test_every_member_is_the_simulation_of_the_model_with_its_values(model):
    mouse = virtual_mouse()
    found = sweep(model, mouse, {"beta": [50.0, 70.0], "R_T": [70.0, 90.0, 110.0]}, samples=64)
    assert found.root_pressure.dims == ("beta", "R_T", "time")
    assert (found["R_T"].attrs["units"], found["beta"].attrs["units"]) == ("mmHg s/ml", "mmHg")
    np.testing.assert_allclose(found["time"], np.linspace(0, mouse.period, 64, endpoint=False), rtol=1e-12)
    one = changed_model(model, {"beta": 70.0, "R_T": 90.0})
    np.testing.assert_allclose(one.outlets.total_resistance(), 90.0)
    np.testing.assert_allclose(one.outlets.resistance_ratio(), model.outlets.resistance_ratio())
    np.testing.assert_allclose((one.outlets.R1 + one.outlets.R2) * one.outlets.C, 0.11)
    alone = simulate(one, mouse)
    member = found.sel(beta=70.0, R_T=90.0)
    middle = alone.pressure.sel(station="middle")
    np.testing.assert_allclose(member.mean_pressure, middle.mean("time"), rtol=1e-6)
    np.testing.assert_allclose(member.pulse_pressure, middle.max("time") - middle.min("time"), rtol=1e-6)


def test_a_combination_that_cannot_be_simulated_is_named_and_the_others_are_there(model):
    found = sweep(model, virtual_mouse(), {"beta": [57.0, 1e7]})
    assert found["failure"].values[0] == ""
    assert found["failure"].values[1] != ""
    assert np.all(np.isnan(found.root_pressure.values[1]))
    assert np.all(np.isfinite(found.root_pressure.values[0]))


@pytest.mark.parametrize(
    ("values", "words"),
    [({}, "nothing to sweep"), ({"bta": [1.0]}, "did you mean 'beta'"), ({"beta": [-1.0]}, "positive"),
     ({"a": [1.2]}, "below 1"), ({"beta": []}, "positive")],
)  # fmt: skip
def test_wrong_values_are_refused_before_anything_is_simulated(model, values, words):
    with pytest.raises(InputError, match=words):
        sweep(model, virtual_mouse(), values)


@pytest.mark.filterwarnings("ignore::RuntimeWarning")  # which no command shows
@pytest.mark.parametrize("values", [{"beta": 1e-300}, {"beta": 1e308}, {"R_T": 1e300}, {"beta": 1e150}])
def test_a_value_that_is_no_animals_fails_in_a_sentence_before_anything_is_simulated(model, inflow, values):
    with pytest.raises(NumericalError, match=r"too fast, too slow or too high for any number|steps a cycle") as failed:
        simulate(changed_model(model, values), inflow)
    assert len(str(failed.value)) < 500


def test_a_viscosity_of_zero_is_an_elastic_wall_and_a_negative_one_is_refused(model):
    assert changed_model(model, {"wall_viscosity": 0.0}).wall_viscosity == 0
    assert "wall viscosity 3 mmHg s" in repr(changed_model(model, {"wall_viscosity": 3.0}))
    with pytest.raises(InputError, match=r"wall_viscosity: give positive numbers, not -1$"):
        changed_model(model, {"wall_viscosity": -1.0})
