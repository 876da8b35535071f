"""The solver against theory, conservation and itself."""

import weakref
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from approval import approve, values
from vasowave.base import NumericalError
from vasowave.pulse.cycle import Inflow
from vasowave.pulse.model import (
    Blood,
    BoundaryLayer,
    ImpedanceSpectrum,
    LinearWall,
    Model,
    Numerics,
    Poiseuille,
    PowerLaw,
    TangentWall,
    Windkessel,
    linear_solution,
    walls,
    windkessels,
)
from vasowave.pulse.network import Network
from vasowave.pulse.solver import simulate, simulate_runs


def _tube(length=2.0, radius=0.05):
    return Network(("tube",), np.array([-1]), np.array([length]), np.array([radius]))


def test_approved_the_waves_and_what_they_say_of_themselves(control, inflow):
    result = simulate(control, inflow)
    told = (f"{key}: {value}" for key, value in sorted(result.attrs.items()))
    waves = (f"{name}: {values(wave.sel(station=at).to_numpy())} at the {at}" for name, wave in result.data_vars.items()
             for at in wave["station"].values)  # fmt: skip
    approve(f"waves, {type(control.wall).__name__}", [*told, *waves], 1e-9)


def test_junction_flows_sum_to_zero(control, inflow):
    result = simulate(control, inflow)
    flow = result.flow.values
    for parent, daughters in enumerate(control.network.daughters):
        if daughters:
            excess = flow[:, parent, 2] - flow[:, list(daughters), 0].sum(axis=1)
            assert np.max(np.abs(excess)) < 1e-12 * np.max(np.abs(flow))


def test_junction_pressure_is_one_so_newton_has_converged(control, inflow):
    pressure = simulate(control, inflow).pressure.values
    for parent, daughters in enumerate(control.network.daughters):
        for daughter in daughters:
            np.testing.assert_allclose(pressure[:, parent, 2], pressure[:, daughter, 0], rtol=0, atol=1e-9)


def test_outlet_pressure_obeys_its_windkessel_ode(control, inflow):
    """R1, R2 and C act as eq. 7: the terminal waveforms satisfy P = Z Q harmonic by harmonic."""
    result = simulate(control, inflow, Numerics(samples=2048, tolerance=1e-9))
    terminals = control.network.terminals
    P = np.fft.rfft(result.pressure.values[:, terminals, 2], axis=0)[:15]
    Q = np.fft.rfft(result.flow.values[:, terminals, 2], axis=0)[:15]
    Z = control.outlets.impedance(2 * np.pi * np.arange(15) / inflow.period)
    np.testing.assert_allclose(P[:8], (Z * Q)[:8], rtol=1e-3)


@pytest.mark.filterwarnings("ignore:The answer depends on the grid")  # a soft wall's first cycle from rest steepens
@pytest.mark.parametrize("start", ["rest", "periodic"])
def test_volume_in_equals_volume_out_plus_stored_for_conservation(control, inflow, start):
    numerics = Numerics(cycles_from_rest=1) if start == "rest" else Numerics()
    assert abs(simulate(control, inflow, numerics).attrs["volume_error"]) < 1e-12


def test_volume_conservation_seen_from_outside(control, inflow):
    """Independent of the solver's own account: mean inflow equals mean outflow of all terminals when periodic."""
    result = simulate(control, inflow, Numerics(samples=2048, tolerance=1e-10))
    mean = result.flow.values.mean(axis=0)
    assert mean[control.network.terminals, 2].sum() == pytest.approx(inflow.flow.mean(), rel=1e-9)


def test_inflow_is_met_at_the_root_at_the_very_sample(control, inflow):
    result = simulate(control, inflow, Numerics(samples=256))
    np.testing.assert_allclose(result.flow.values[:, control.network.root, 0], inflow.flow, atol=1e-12)


@pytest.mark.parametrize("tau", [0.05, 0.11, 0.3])
def test_periodic_to_1e_8_mmhg_within_ten_cycles(control, inflow, tau):
    model = control.changed(outlets=windkessels(control.network, 76.0, tau, a=0.12))
    result = simulate(model, inflow, Numerics(tolerance=1e-8))
    assert result.attrs["converged"] == 1
    assert result.attrs["cycles"] <= 10


@pytest.mark.parametrize("wall", [LinearWall(60.0), TangentWall(20.0, 5.0)], ids=["linear", "tangent"])
def test_order_of_accuracy_is_two_through_junctions_and_outlets(inflow, wall):
    """Three grids, each twice as fine: the differences shrink by four, for p and q at every node."""
    network = Network(("a", "b", "c"), np.array([-1, 0, 0]), np.array([0.8, 0.6, 0.4]), np.array([0.047, 0.037, 0.026]))
    model = Model(network, wall, windkessels(network, 76.0, 0.11))
    runs = []
    for level in range(3):
        numerics = Numerics(cell_size=0.05 / 2**level, samples=256, steps_per_cycle=1024 * 2**level, tolerance=1e-9)
        runs.append(simulate(model, inflow, numerics))
    for quantity in ("pressure", "flow"):
        coarse, middle, fine = (run[quantity].values[:, :, [0, 2]] for run in runs)
        order = np.log2(np.sqrt(np.mean((coarse - middle) ** 2)) / np.sqrt(np.mean((middle - fine) ** 2)))
        assert order >= 1.9, (quantity, order)


def test_default_grid_is_within_a_twentieth_mmhg_of_one_eight_times_finer(control, inflow):
    default = simulate(control, inflow, Numerics(tolerance=1e-6))
    fine = simulate(control, inflow, Numerics(cell_size=0.1 / 8, tolerance=1e-6))
    assert np.max(np.abs(default.pressure.values - fine.pressure.values)) < 0.05


@pytest.mark.parametrize("wall", [LinearWall(57.0), TangentWall(7.0, 2.8)], ids=["linear", "tangent"])
@pytest.mark.parametrize("friction", [BoundaryLayer(), BoundaryLayer(0.07), Poiseuille(), PowerLaw(9.0)], ids=str)
def test_steady_flow_obeys_the_ordinary_differential_equation(wall, friction):
    """Steady momentum, integrated by SciPy: dp/dx (A/ρ - q²/A² dA/dp) = -(k0 + k1 √A) q/A."""
    network, q, period = _tube(), 0.15, 0.11
    blood = Blood(friction=friction)
    k0, k1 = friction.coefficients(blood.viscosity, period)
    A0 = network.area[0]

    def slope(x, p):
        A, dA = walls.area(wall, p, A0), walls.area_compliance(wall, p, A0)
        return -(k0 + k1 * np.sqrt(A)) * q / A / (A / blood.inertia - q**2 / A**2 * dA)

    model = Model(network, wall, Windkessel(10.0, 70.0, 0.0005), blood)
    numerics = Numerics(cell_size=0.02, samples=64, tolerance=1e-9)
    result = simulate(model, Inflow(np.full(64, q), period), numerics)
    p_in, p_out = result.pressure.values[0, 0, 0], result.pressure.values[0, 0, 2]
    assert p_out == pytest.approx(q * 80.0, rel=1e-7)
    middle, exact = solve_ivp(slope, (0, 2.0), [p_in], t_eval=[1.0, 2.0], rtol=1e-10, atol=1e-10).y[0]
    assert p_in - p_out == pytest.approx(p_in - exact, rel=1e-4)
    assert p_in - result.pressure.values[0, 0, 1] == pytest.approx(p_in - middle, rel=5e-4)
    cells = simulate(model, Inflow(np.full(64, q), period), replace(numerics, every_cell=True))
    along = solve_ivp(slope, (0, 2.0), [p_in], t_eval=cells.position.values, rtol=1e-10, atol=1e-10).y[0]
    drop_of_a_cell = (p_in - p_out) / len(along)  # friction that is missing at an end shifts its cell by half of this
    np.testing.assert_allclose(cells.pressure.values[0], along, atol=0.02 * drop_of_a_cell)


@pytest.mark.parametrize("wall", [LinearWall(57.0), TangentWall(7.0, 1.6)], ids=["linear", "tangent"])
def test_small_amplitude_impedance_agrees_with_the_linear_network(wall):
    from vasowave.pulse.examples import control_network

    network = control_network()
    model = Model(network, wall, windkessels(network, 76.0, 0.11, a=0.12))
    t = np.arange(256) / 256
    q = np.exp(-0.5 * ((t - 0.2) / 0.015) ** 2)  # short enough to carry 14 harmonics
    tiny = Inflow(1e-5 * q / q.mean(), 0.11)
    result = simulate(model, tiny, Numerics(cell_size=0.025, samples=1024, tolerance=1e-12))
    P, Q = (np.fft.rfft(result[name].values[:, network.root, 0])[:15] for name in ("pressure", "flow"))
    theory = linear_solution(model, tiny).input_impedance[:15, network.root]
    np.testing.assert_allclose(np.abs(P / Q), np.abs(theory), rtol=0.005)
    assert np.max(np.abs(np.angle(P / Q / theory))) < 0.005


def test_windkessels_given_by_their_impedance_are_windkessels(control, inflow):
    steps = 2048
    omega = 2 * np.pi / inflow.period * np.arange(steps // 2 + 1)
    spectrum = ImpedanceSpectrum(control.outlets.impedance(omega))
    numerics = Numerics(samples=512, steps_per_cycle=steps, tolerance=1e-7)
    ode = simulate(control, inflow, numerics)
    by_impedance = simulate(control.changed(outlets=spectrum), inflow, numerics)
    assert np.max(np.abs(ode.pressure.values - by_impedance.pressure.values)) < 1e-6


def test_rows_in_any_order_give_the_same_waveforms(control, inflow):
    network = control.network
    order = np.random.default_rng(1).permutation(len(network))
    back = np.argsort(order)
    parent = np.array([back[p] if p >= 0 else -1 for p in network.parent[order]])
    names = tuple(network.name[i] for i in order)
    shuffled = Network(names, parent, network.length[order], network.radius[order])
    wall = type(control.wall)(*(value[order] for value in control.wall))
    model = Model(shuffled, wall, windkessels(shuffled, 76.0, 0.11, a=0.12))
    a, b = (simulate(m, inflow, Numerics(tolerance=1e-9)) for m in (control, model))
    np.testing.assert_allclose(b.pressure.sel(vessel=list(network.name)).values, a.pressure.values, atol=1e-6)


def test_an_ensemble_returns_its_members_and_reports_the_one_that_failed(control, inflow):
    stiff = control.changed(wall=type(control.wall)(100 * control.wall[0], *control.wall[1:]))
    numerics = Numerics(steps_per_cycle=1536)  # enough for one, far too few for the other
    result = simulate([control, stiff, control], inflow, numerics)
    assert list(result.failure.values != "") == [False, True, False]
    assert np.isnan(result.pressure.values[1]).all()
    assert "Courant number" in str(result.failure.values[1])
    alone = simulate(control, inflow, numerics)
    np.testing.assert_array_equal(result.pressure.values[2], alone.pressure.values)
    with pytest.raises(NumericalError, match="all 2 members failed; the first: "):
        simulate([stiff, stiff], inflow, numerics)


def test_the_runs_of_an_ensemble_are_not_in_memory_together(inflow):
    """A run of the sickest animals' posteriors holds ten megabytes, and there are hundreds."""
    models = [Model(_tube(), LinearWall(beta), Windkessel(10.0, 60.0, 0.001)) for beta in (50.0, 60.0, 70.0, 80.0)]
    alive, most = [], 0
    for run in simulate_runs(models, inflow, Numerics(), workers=1):
        alive.append(weakref.ref(run))
        most = max(most, sum(one() is not None for one in alive))
    assert len(alive) == 4
    assert most <= 2  # the one before goes when this one comes


def test_too_large_a_step_is_an_error_that_names_vessel_and_remedy(control, inflow):
    with pytest.raises(NumericalError, match=r"vessel '\d+' .*Courant number .*raise steps_per_cycle from 256 to \d+"):
        simulate(control, inflow, Numerics(samples=256, steps_per_cycle=256))


def test_a_cycle_that_does_not_converge_is_an_error(control, inflow):
    with pytest.raises(NumericalError, match="not periodic after 2 cycles"):
        simulate(control, inflow, Numerics(most_cycles=2, tolerance=1e-9))


@pytest.mark.parametrize("wall", [LinearWall(57.0), TangentWall(7.0, 1.0)], ids=["linear", "tangent"])
def test_a_wall_that_collapses_is_an_error_that_names_vessel_and_time(inflow, wall):
    model = Model(_tube(), wall, Windkessel(10.0, 60.0, 0.001))
    with pytest.raises(NumericalError, match=r"vessel 'tube'.*t = "):
        simulate(model, Inflow(-20 * inflow.flow, inflow.period), Numerics(samples=64))
