from dataclasses import replace

import numpy as np
import pytest

from vasowave.pulse.analysis import (
    largest_waves,
    named_waves,
    operating_point,
    wave_intensity,
)
from vasowave.pulse.cycle import Recording
from vasowave.pulse.examples import control_network, virtual_mouse
from vasowave.pulse.model import (
    LinearWall,
    Model,
    Numerics,
    area,
    estimate_nominal,
    windkessels,
)
from vasowave.pulse.solver import simulate
from vasowave.study.animal import measured_station, waves_dataset


def simulated_inlet(network, wall, seen_at):
    """Return a recording of a model, the model, and its network as an image at another pressure shows it."""
    model = Model(network, wall, windkessels(network, 76.0, 0.12, 0.12))
    mouse = virtual_mouse()
    inlet = simulate(model, mouse, Numerics(samples=512, tolerance=1e-6)).sel(vessel="1", station="inlet")
    radius = np.sqrt(area(model.wall, seen_at, model.area0) / np.pi)
    return (
        Recording(inlet["pressure"].values, mouse.flow, mouse.period),
        model,
        replace(network, radius=radius, pressure=seen_at),
    )


def test_waves_of_the_measurement_are_those_of_the_model_that_made_it():
    recording, model, image = simulated_inlet(control_network(), LinearWall(57.0), 6.3)
    nominal, rho = estimate_nominal(image, recording), model.blood.inertia

    def waves(measured, what):
        station = measured_station(measured, image, nominal, rho, what)
        found = waves_dataset(station, rho)
        return found, float(np.abs(found["wave_area"]).values[found["wave_name"].values == "FCW"].max())

    true = wave_intensity(recording.pressure, recording.flow, recording.period,
                          *operating_point(model, recording.mean_pressure), rho)  # fmt: skip
    expected = largest_waves(named_waves(true, recording.period)).loc["FCW", "area [W/cm2/s]"]
    right, at_mean = waves(recording, "mean pressure")
    paper, at_rest = waves(recording, "paper")
    assert at_mean == pytest.approx(expected, rel=0.03)
    assert at_rest > 1.2 * expected  # seen filled, hence nearer; with the radii at rest it is 1.6 times as much
    assert right.attrs["area_and_wave_speed_at"] == "mean pressure"
    assert paper.attrs["area_and_wave_speed_at"] == "zero pressure"
