"""Arteries and veins that share their beds, against the whole chain as one: equations, frequency domain, balances."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import vasowave as vw
from vasowave.base import InputError
from vasowave.pulse.cycle import Inflow
from vasowave.pulse.model import Numerics, linear_solution

T = 0.11
NUMERICS = Numerics(samples=256)
COARSE = Numerics(samples=64)
STIFF = vw.LinearWall(8000.0)


def pulse(mean=0.16, count=256):
    t = np.arange(count) / count
    q = np.exp(-0.5 * ((t - 0.3) / 0.08) ** 2)
    return Inflow(mean * q / q.mean(), T)


def stub(name="s"):
    return vw.Network([name], [-1], [0.05], [0.3])


def vessel(name, radius=0.05, length=0.5):
    return vw.Network([name], [-1], [length], [radius])


def test_stubs_on_both_sides_of_a_bed_are_the_ordinary_differential_equation_of_the_chain():
    R1, R2, C = 8.0, 70.0, 1.2e-3
    Z, R, B, atrium = 2.0, 12.0, 8e-3, 5.0
    inflow = pulse()
    arteries = vw.Model(stub("a"), STIFF, vw.Windkessel([R1], [R2], [C]))
    veins = vw.Model(stub("v"), STIFF, vw.Windkessel([Z], [R], [B]), outlet_pressure=atrium)
    waves = vw.Circulation(arteries, veins, {"a": "v"}).simulate(inflow, NUMERICS)

    def flow(t):
        return np.interp(t % T, np.arange(257) / 256 * T, np.append(inflow.flow, inflow.flow[0]))

    def vein(state):
        return (state[1] + Z * state[0] / R2) / (1 + Z / R2)

    def change(t, state):
        through = (state[0] - vein(state)) / R2
        return [(flow(t) - through) / C, (through - (state[1] - atrium) / R) / B]

    times = 30 * T + np.arange(256) / 256 * T
    solved = solve_ivp(change, (0, 31 * T), [18.0, 8.0], t_eval=times, rtol=1e-8, max_step=T / 100)
    artery = solved.y[0] + R1 * flow(times)
    behind = vein(solved.y)
    assert np.ptp(behind) > 0.2
    assert np.max(np.abs(waves["arteries"].pressure.values[:, 0, 2] - artery)) < 0.005 * np.ptp(artery)
    assert np.max(np.abs(waves["veins"].pressure.values[:, 0, 0] - behind)) < 0.02 * np.ptp(behind)


def test_small_waves_meet_behind_a_bed_the_impedance_of_the_veins():
    """In the frequency domain the bed and the veins behind it are one impedance, which closes the arteries."""
    R1, R2, C = 8.0, 20.0, 4e-4
    walls = vw.LinearWall(57.0)
    vein = vw.Model(vessel("v", 0.06, 0.8), walls, vw.Resistance([3.0]), outlet_pressure=6.0)
    inflow = Inflow(0.16 + 0.02 * (pulse().flow / 0.16 - 1), T)
    count = 40
    Z_v = linear_solution(vein, Inflow(inflow.flow, T), count).input_impedance[:, 0]
    omega = 2 * np.pi / T * np.arange(count + 1)
    closing = R1 + 1 / (1j * omega * C + 1 / (R2 + Z_v))
    artery = vessel("a", 0.05, 0.7)
    whole = vw.Model(artery, walls, vw.ImpedanceSpectrum(closing[:, np.newaxis]), outlet_pressure=6.0)
    expected = vw.simulate(whole, inflow, NUMERICS).pressure.values[:, 0, 0]
    parts = vw.Circulation(vw.Model(artery, walls, vw.Windkessel([R1], [R2], [C])), vein, {"a": "v"})
    waves = parts.simulate(inflow, NUMERICS)
    found = waves["arteries"].pressure.values[:, 0, 0]
    assert np.ptp(waves["veins"].pressure.values[:, 0, 0]) > 0.05 * np.ptp(found)
    assert np.max(np.abs((found - found.mean()) - (expected - expected.mean()))) < 0.01 * np.ptp(expected)
    assert found.mean() == pytest.approx(expected.mean(), abs=0.05)


@pytest.fixture(scope="module")
def lung():
    """An artery that forks, two beds, and two veins that flow together into a third."""
    fork = vw.Network(["a", "b", "c"], [-1, 0, 0], [0.5, 0.6, 0.6], [0.05, 0.036, 0.036])
    arteries = vw.Model(fork, vw.TangentWall(9.0, 4.0), vw.Windkessel([14.0, 14.0], [110.0, 110.0], [6e-4, 6e-4]))
    joined = vw.Network(["x", "y", "z"], None, [0.6, 0.6, 0.5], [0.04, 0.04, 0.056], nodes=[[0, 2], [1, 2], [2, 3]])
    atrium = 1.5 * np.sin(2 * np.pi * np.arange(64) / 64)
    veins = vw.Model(joined, vw.LinearWall(40.0), vw.Resistance([4.0]), outlet_pressure=5.0, outlet_pulsation=atrium)
    return vw.Circulation(arteries, veins, {"b": "x", "c": "y"})


@pytest.fixture(scope="module")
def breathing(lung):
    """The waves of that lung."""
    return lung.simulate(pulse(), COARSE)


def test_what_enters_the_arteries_leaves_the_veins_and_every_bed_loses_what_ohms_law_says(lung, breathing):
    arteries, veins = breathing["arteries"], breathing["veins"]
    mean = pulse().flow.mean()
    assert float(veins.flow.sel(vessel="z", station="outlet").mean()) == pytest.approx(mean, rel=2e-4)
    for artery, vein in lung.drains.items():
        before, behind = arteries.sel(vessel=artery, station="outlet"), veins.sel(vessel=vein, station="inlet")
        assert float(before.flow.mean()) == pytest.approx(float(behind.flow.mean()), rel=2e-4)
        lost = float(before.pressure.mean() - behind.pressure.mean())
        assert lost == pytest.approx(124.0 * float(before.flow.mean()), rel=1e-3)
    np.testing.assert_allclose(*(veins.pressure.sel(vessel=one) for one in "xy"), atol=1e-6)


def test_a_beating_atrium_reaches_the_arteries_through_veins_and_beds(lung, breathing):
    still = vw.Circulation(lung.arteries, lung.veins.changed(outlet_pulsation=None), lung.drains)
    at_rest = still.simulate(pulse(), COARSE)["veins"].pressure
    assert np.ptp((breathing["veins"].pressure - at_rest).sel(vessel="x", station="inlet").values) > 1.0


def test_a_pressure_drives_arteries_and_veins_in_series():
    """Bed and veins resist alike, so that turns without the veins' answer would go to and fro for long."""
    arteries = vw.Model(stub("a"), STIFF, vw.Windkessel([2.0], [18.0], [1e-3]))
    veins = vw.Model(stub("v"), STIFF, vw.Resistance([20.0]), outlet_pressure=5.0)
    driven = vw.InletPressure(10 + pulse(8.0).flow, T)
    waves = vw.Circulation(arteries, veins, {"a": "v"}).simulate(driven, COARSE)
    mean = float(waves["veins"].flow.sel(station="outlet").mean())
    assert mean == pytest.approx((18.0 - 5.0) / 40.0, rel=1e-3)
    assert float(waves["arteries"].flow.sel(station="inlet").mean()) == pytest.approx(mean, rel=1e-3)


@pytest.mark.parametrize(
    ("drains", "message"),
    [
        ({"b": "x"}, "'c' drains nowhere"),
        ({"b": "x", "c": "x"}, "'y' is an inlet of the veins into which no bed drains"),
        ({"b": "x", "c": "z"}, "'z' is not an inlet of the veins"),
        ({"a": "x", "b": "x", "c": "y"}, "'a' is not a terminal artery"),
        ({"b": ["x", "y"], "c": "y"}, "one inlet of the veins for each terminal artery by their names"),
        ([("b", "x"), ("c", "y")], "one inlet of the veins for each terminal artery by their names"),
    ],
)
def test_a_bed_that_leads_nowhere_and_a_vein_without_blood_are_named(lung, drains, message):
    with pytest.raises(InputError, match=message):
        vw.Circulation(lung.arteries, lung.veins, drains)


def test_beds_that_are_no_circuits_are_refused(lung):
    beds = vw.estimate_nominal(lung.arteries.network, vw.virtual_mouse(), bed=vw.StructuredTree).outlets
    with pytest.raises(InputError, match="StructuredTree: what flows out of such beds is not known"):
        vw.Circulation(lung.arteries.changed(outlets=beds), lung.veins, lung.drains)
