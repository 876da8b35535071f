"""A model over a grid of values: each member is the model with that value; a stored fit is a model again."""

import numpy as np
import pytest

from approval import PAPER, approve, figure, values
from small_tree import SMALL
from vasowave.base import InputError
from vasowave.pulse.cycle import Recording
from vasowave.pulse.examples import control_network, virtual_mouse
from vasowave.pulse.model import LinearWall, Model, Numerics, windkessels
from vasowave.pulse.solver import simulate, sweep, sweep_table
from vasowave.study.animal import Animal, Settings, analyze, read_result, stored_model, stored_recording, write_result
from vasowave.study.figures import style, svg, sweep_figure


@pytest.fixture(scope="module")
def model():
    network = control_network()
    return Model(network, LinearWall(57.0), windkessels(network, 76.0, 0.11, a=0.12))


def test_approved_the_figure_and_the_table_of_a_sweep(model):
    found = sweep(model, virtual_mouse(), {"beta": [50.0, 60.0, 70.0], "R_T": [70.0, 90.0]}, samples=64)
    with style():
        drawn = {"two": svg(sweep_figure(found)), "one": svg(sweep_figure(found.isel(R_T=0, drop=True)))}
        for many in (found.isel(R_T=[0] * 6), found.expand_dims("tau")):
            with pytest.raises(InputError, match="one parameter, and a second of at most 5 values"):
                sweep_figure(many)
    table = sweep_table(found)
    columns = [f"{name}: {values(column.to_numpy())}" for name, column in table.items()]
    approve("sweep", [*(line for name, one in drawn.items() for line in figure(name, one)), *columns], PAPER)


def test_the_stored_fit_of_an_animal_is_its_model_again_to_the_last_bit():
    mouse = Animal("mouse 6", "CTL", control_network(), virtual_mouse(), synthetic=True)
    result = analyze(mouse, Settings(walls=("linear",), starts=1))
    model, cycle = stored_model(result), stored_recording(result)
    again = simulate(model, cycle).pressure.sel(station="inlet").isel(vessel=model.network.root)
    stored = result.laws["linear"].simulation["pressure"].sel(station="inlet").isel(vessel=model.network.root)
    assert np.array_equal(model.wall.beta, result.laws["linear"].calibration["beta"].values)
    assert float(abs(again.mean() - stored.mean())) < 1e-3
    with pytest.raises(InputError, match="there are: linear"):
        stored_model(result, "tangent")


@pytest.mark.validation  # derivatives by viscous walls are kernels of their own
def test_a_viscosity_is_swept_and_set_and_that_of_a_stored_fit_is_its_own(tmp_path, inflow):
    model = Model(SMALL, LinearWall(57.0), windkessels(SMALL, 76.0, 0.11, a=0.12))
    swept = sweep(model, inflow, {"wall_viscosity": [0.1, 0.5]}, samples=64)
    alone = simulate(model.changed(wall_viscosity=0.5), inflow)
    pulse = np.ptp(alone.pressure.sel(station="middle").to_numpy(), axis=0)
    np.testing.assert_allclose(swept.pulse_pressure.sel(wall_viscosity=0.5), pulse, rtol=1e-5)
    viscous = simulate(model.changed(wall_viscosity=0.3), inflow, Numerics(samples=256))
    cycle = Recording(viscous.pressure.to_numpy()[:, 0, 0], inflow.resampled(256), inflow.period)
    animal = Animal("1", "CTL", model.network, cycle)
    result = analyze(animal, Settings(walls=("linear",), starts=1, viscous=True))
    write_result(result, tmp_path / "1.nc")
    again = stored_model(read_result(tmp_path / "1.nc"))
    np.testing.assert_allclose(again.wall_viscosity, 0.3, rtol=1e-3)
    kept = result.laws["linear"]
    assert kept.quantities["wall_viscosity"].attrs["units"] == "mmHg s"
    waves = simulate(again, inflow, Numerics(samples=256)).pressure.to_numpy()[:, 0, 0]
    assert np.max(np.abs(waves - cycle.pressure)) < 0.02
