"""Pressure behind the vascular beds: it drives the flow less, and stretches the walls all the same: in a study."""

import json
from dataclasses import replace

import numpy as np
import pytest

import vasowave as vw
from vasowave.base import InputError
from vasowave.pulse.cycle import Inflow, Recording
from vasowave.pulse.model import Model
from vasowave.study.animal import stored_model, stored_recording
from vasowave.study.exchange import export_model

BEHIND, BETA = 8.0, 60.0


@pytest.fixture(scope="module")
def before_the_atrium():
    """Return a recording of a mouse with a linear wall whose left atrium has 8 mmHg, and its model."""
    network, mouse = vw.control_network(), vw.virtual_mouse()
    beds = vw.estimate_nominal(network, replace(mouse, wedge_pressure=0.0)).outlets
    model = Model(network, vw.LinearWall(BETA), beds, outlet_pressure=BEHIND)
    waves = vw.simulate(model, Inflow(mouse.flow, mouse.period)).sel(vessel=network.name[0], station="inlet")
    return Recording(waves["pressure"].values, mouse.flow, mouse.period, wedge_pressure=BEHIND), model


def test_results_keep_the_pressure_and_exports_write_it_or_refuse(before_the_atrium, tmp_path):
    recording, _ = before_the_atrium
    animal = vw.Animal("w", "CTL", vw.control_network(), recording, synthetic=True)
    result = vw.analyze(animal, vw.Settings(walls=("linear",), starts=1, model_selection=False))
    again = vw.AnimalResult.from_datatree(result.to_datatree())
    assert stored_recording(again).wedge_pressure == BEHIND
    assert set(np.asarray(stored_model(again).outlet_pressure)) == {BEHIND}
    assert float(again.measured.quantities["Z_0"]) > float(again.recording["PVR"])
    of_law = float(again.laws["linear"].quantities["PVR"])  # of the same pulse, over the same pressure
    assert of_law == pytest.approx(float(again.recording["PVR"]), rel=0.02)
    model = stored_model(again)
    export_model(model, recording.inflow, "svzerod", tmp_path / "zerod")
    written = json.loads((tmp_path / "zerod" / "svzerod.json").read_text("utf-8"))["boundary_conditions"]
    pressures = [one["bc_values"]["Pd"] for one in written if one["bc_type"] == "RCR"]
    np.testing.assert_allclose(pressures, len(model.network.terminals) * [BEHIND * 1333.22], rtol=1e-5)
    with pytest.raises(InputError, match="openBF knows no pressure behind its outlets"):
        export_model(model, recording.inflow, "openbf", tmp_path / "openbf")
