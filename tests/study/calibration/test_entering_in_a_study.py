"""What enters a model: the flow, the pressure, or the flow with its error; the other is compared: in a study."""

from dataclasses import replace

import numpy as np
import pytest

import vasowave as vw
from known_exactly import summary_without_errors
from vasowave import pulse
from vasowave.study.animal import stored_inflow

NETWORK = vw.Network(("1", "2", "3"), [-1, 0, 0], [0.4, 0.4, 0.5], [0.05, 0.035, 0.04], pressure=6.0)
MOUSE = vw.virtual_mouse()
WALLS = {"linear": vw.LinearWall(70.0), "tangent": vw.TangentWall(7.0, 3.0)}


def recorded(wall, **more):
    """Return a recording that the model itself made, and the model."""
    model = vw.Model(NETWORK, WALLS[wall], vw.estimate_nominal(NETWORK, MOUSE).outlets.scaled(1.2, 0.9, 1.3))
    waves = vw.simulate(model, MOUSE.inflow, vw.Numerics(samples=256)).sel(vessel="1", station="inlet")
    return vw.Recording(waves.pressure.values, waves.flow.values, MOUSE.period, **more), model


@pytest.mark.parametrize("enters", ["pressure", "both"])
def test_a_mean_flow_that_is_known_within_five_per_cent_leaves_the_resistance_so_open(enters):
    """R_T is all but the mean pressure over the mean flow."""
    flow_error = np.append(0.05 * MOUSE.cardiac_output, np.full(12, 1e-6))
    exact, _ = recorded("linear", pressure_error=np.full(13, 1e-4), flow_error=np.full(13, 1e-7))
    doubtful, _ = recorded("linear", pressure_error=np.full(13, 1e-4), flow_error=flow_error)
    reach = {}
    for name, recording in (("exact", exact), ("doubtful", doubtful)):
        fit = pulse.calibrate(NETWORK, recording, "linear", starts=1, enters=enters, pressure_harmonics=12)
        value, low, high = summary_without_errors(fit).loc["R_T", ["value", "low", "high"]].astype(float)
        reach[name] = np.log(value / low)
        most = np.log(high / (recording.mean_pressure / recording.cardiac_output))  # pressure over flow ends it above
        assert most <= 1.96 * (0.05 if name == "doubtful" else 0.0) + 1e-3
    total, beds = exact.mean_pressure / exact.cardiac_output, float(fit.total_resistance)
    assert reach["exact"] < 0.01
    assert reach["doubtful"] == pytest.approx(1.96 * 0.05 * total / beds, rel=0.15)


@pytest.mark.validation
def test_stored_results_of_a_pressure_that_entered_give_its_waves_again(tmp_path):
    recording, _ = recorded("linear")
    noisy = replace(recording, flow=recording.flow * 1.05)  # which nothing but the flow knows
    settings = vw.Settings(walls=("linear",), starts=1, enters="pressure", model_selection=False)
    result = vw.analyze(vw.Animal("m", "CTL", NETWORK, noisy), settings)
    law = result.laws["linear"]
    again = vw.simulate(vw.stored_model(result), stored_inflow(result), vw.Numerics(samples=256))
    pressure = again.pressure.sel(vessel="1", station="inlet").values
    assert np.max(np.abs(pressure - noisy.pressure)) < 0.05
    assert law.residual.attrs["units"] == "ml/s"
    assert law.residual.name == "flow_residual"
    fit = vw.calibrate(NETWORK, noisy, "linear", starts=1, enters="pressure")
    assert fit.plot.residuals().get_ylabel() == "residual flow [ml/s]"
    page = fit.report(tmp_path / "page").parent / "supplement.html"
    assert "the measured pressure entered at the inlet, and the flow was compared" in page.read_text(encoding="utf-8")
