"""Shear at the wall against Womersley's profile resolved across the tube; what reaches beds against what enters."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from scipy.linalg import solve_banded

import vasowave as vw


def resolved(radius, angular, blood, points=2000):
    """Complex shear (Pa) and flow (ml/s) in a rigid tube under a pressure that oscillates, by rings across the tube."""
    edges = radius * (1 - (1 - np.linspace(0, 1, points + 1)) ** 2)  # fine at the wall
    middle, ring = 0.5 * (edges[1:] + edges[:-1]), np.pi * np.diff(edges**2)
    viscosity = blood.density * blood.viscosity
    inner = 2 * np.pi * edges[1:-1] * viscosity / np.diff(middle)
    to_wall = 2 * np.pi * radius * viscosity / (radius - middle[-1])
    bands = np.zeros((3, points), dtype=complex)
    bands[1] = 1j * angular * blood.density * ring
    bands[1, :-1] += inner
    bands[1, 1:] += inner
    bands[1, -1] += to_wall
    bands[0, 1:] = bands[2, :-1] = -inner
    velocity = solve_banded((1, 1), bands, ring.astype(complex))
    return 0.1 * viscosity * velocity[-1] / (radius - middle[-1]), ring @ velocity


@pytest.mark.parametrize("womersley", [0.5, 1.7, 6.0, 20.0])
def test_shear_is_that_of_the_resolved_profile(womersley):
    blood, period, count = vw.Blood(), 0.5, 64
    radius = womersley * np.sqrt(blood.viscosity * period / (2 * np.pi))
    shear, flow = resolved(radius, 2 * np.pi / period, blood)
    turn = np.exp(2j * np.pi * np.arange(count) / count)
    computed = vw.wall_shear((flow * turn).real, np.full(count, np.pi * radius**2), period, blood)
    np.testing.assert_allclose(computed, (shear * turn).real, atol=0.005 * abs(shear))


def test_a_steady_flow_has_the_shear_of_poiseuille():
    blood = vw.Blood()
    radius, flow = 0.05, 0.3
    shear = vw.wall_shear(np.full((32, 2), flow), np.full((32, 2), np.pi * radius**2), 0.2, blood)
    np.testing.assert_allclose(shear, 0.1 * 4 * blood.density * blood.viscosity * flow / (np.pi * radius**3))


@pytest.fixture(scope="module")
def simulated():
    network, mouse = vw.control_network(), vw.virtual_mouse()
    model = vw.Model(network, vw.LinearWall(60.0), vw.estimate_nominal(network, mouse).outlets)
    return model, vw.simulate(model, mouse)


def test_what_reaches_the_beds_is_what_enters(simulated):
    model, waves = simulated
    loads, network = vw.vessel_loads(model, waves), model.network
    entering = float(waves.flow.sel(vessel=network.name[network.root], station="inlet").mean())
    assert loads["mean flow [ml/s]"].iloc[network.terminals].sum() == pytest.approx(entering, rel=1e-6)
    root = network.name[network.root]
    regions = [network.name[row] for row in network.daughters[network.root]]
    parts = vw.regional_loads(network, loads, regions)
    assert parts["share [1]"].sum() == pytest.approx(1, rel=1e-6)
    assert parts["beds"].sum() == len(network.terminals)
    (whole,) = vw.regional_loads(network, loads, [root]).to_dict("records")
    assert whole["pulse power [mW]"] == pytest.approx(parts["pulse power [mW]"].sum())
    assert (loads["pulse power [mW]"].iloc[network.terminals] > 0).all()


def test_beds_get_what_enters_to_round_off_where_the_state_repeats_as_closely(simulated):
    model, _ = simulated
    inflow, off = vw.virtual_mouse().inflow, []
    for tolerance in (1e-2, 1e-6, 1e-10):
        waves = vw.simulate(model, inflow, vw.Numerics(tolerance=tolerance))
        reaching = vw.vessel_loads(model, waves)["mean flow [ml/s]"].iloc[model.network.terminals].sum()
        off.append(abs(reaching / inflow.flow.mean() - 1))
    assert off[0] > 100 * off[1]
    assert off[2] < 1e-14


def test_strain_and_transit_follow_from_area_and_flow(simulated):
    model, waves = simulated
    loads = vw.vessel_loads(model, waves)
    middle = waves.sel(station="middle", vessel="3")
    radius = np.sqrt(middle.area / np.pi)
    assert loads["strain [1]"]["3"] == pytest.approx(float((radius.max() - radius.min()) / radius.mean()))
    velocity = float(middle.flow.mean() / middle.area.mean())
    assert loads["transit time [s]"]["3"] == pytest.approx(model.network.length[2] / velocity)
    assert (loads["oscillatory shear [1]"].between(0, 0.5)).all()


def test_other_vessels_and_regions_that_there_are_not_are_refused(simulated):
    model, waves = simulated
    loads = vw.vessel_loads(model, waves)
    with pytest.raises(vw.errors.InputError, match="no vessel 'left lobe'"):
        vw.regional_loads(model.network, loads, ["left lobe"])
    with pytest.raises(vw.errors.InputError, match="simulate the model first"):
        vw.vessel_loads(model, waves.isel(vessel=slice(0, 3)))
    with pytest.raises(vw.errors.InputError, match="must have one shape"):
        vw.wall_shear(np.ones(8), np.ones(9), 0.1)


COUNT = 79  # draws, of which the second and the last but one are the ends of 95 %
STIFFNESS, RESISTANCE = 150.0, 80.0  # mmHg, mmHg s/ml


def tube(radius):
    """A short tube before a bed, and what flows into it."""
    network, mouse = vw.Network(("1",), [-1], [0.2], [radius]), vw.virtual_mouse()
    beds = vw.Windkessel(np.array([20.0]), np.array([RESISTANCE - 20.0]), np.array([1e-3]))
    return vw.Model(network, vw.LinearWall(STIFFNESS), beds), mouse.inflow


def uncertain(drawn):
    model, inflow = drawn[0]
    return vw.UncertainModel(model, inflow, pd.DataFrame(), pd.DataFrame(), model.outlets, tuple(drawn))


def test_the_interval_of_shear_is_that_of_the_radius_through_the_profile_of_womersley():
    radii = np.random.default_rng(1).permutation(0.05 * np.exp(0.05 * np.linspace(-2, 2, COUNT)))
    told = []
    intervals = vw.load_intervals(uncertain([tube(radius) for radius in radii]), progress=lambda *x: told.append(x))
    inflow = tube(0.05)[1]
    flow = inflow.flow.mean()
    areas = np.pi * np.sort(radii)[[-2, 1]] ** 2 * (1 + RESISTANCE * flow / STIFFNESS) ** 2  # at the mean pressure
    shears = [vw.wall_shear(inflow.flow, np.full(len(inflow.flow), area), inflow.period) for area in areas]
    for name, of_wave in (("mean shear", np.mean), ("peak shear", lambda shear: np.abs(shear).max())):
        ends = [intervals.loc["1", f"{name} {end} [Pa]"] for end in ("low", "high")]
        np.testing.assert_allclose(ends, [of_wave(shear) for shear in shears], rtol=0.02)  # its area is not constant
    np.testing.assert_allclose(intervals[["mean flow low [ml/s]", "mean flow high [ml/s]"]], [[flow, flow]], rtol=1e-5)
    assert told[-1] == (COUNT - 1, 100)


def test_the_interval_of_a_posterior_without_width_is_its_model():
    drawn = [tube(0.05)] * 40
    intervals, loads = vw.load_intervals(uncertain(drawn)), vw.vessel_loads(drawn[0][0], vw.simulate(*drawn[0]))
    for end in ("low", "high"):
        values = intervals[[column for column in intervals if f" {end} [" in column]]
        np.testing.assert_allclose(values, loads, rtol=1e-6)


def test_intervals_without_a_posterior_or_of_few_draws_are_refused():
    fit = uncertain([tube(0.05)] * 3)
    with pytest.raises(vw.errors.InputError, match="need 40 draws, of which 3"):
        vw.load_intervals(fit)
    with pytest.raises(vw.errors.InputError, match="inference: posterior"):
        vw.load_intervals(replace(fit, drawn=()))
