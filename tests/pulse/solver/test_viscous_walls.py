"""Viscous walls: theory of small waves, order, volume, energy, the elastic scheme, derivatives."""

import numpy as np
import pytest

import vasowave as vw
from vasowave.base import InputError
from vasowave.pulse.cycle import Inflow, InletPressure
from vasowave.pulse.model import Numerics, Shape, linear_solution, windkessels
from vasowave.pulse.solver import simulate_run

T = 0.11
WALLS = pytest.mark.parametrize(
    "wall",
    [
        pytest.param(vw.LinearWall(57.0), id="linear"),
        pytest.param(vw.TangentWall(9.0, 4.0), id="tangent", marks=pytest.mark.validation),  # has kernels of its own
    ],
)
GAMMAS = 1e-3, *(pytest.param(one, marks=pytest.mark.validation) for one in (1e-5, 1e-4, 1e-2, 1e-1))
"""Viscosity as tube laws have it, Γ/(A0 √A) ∂A/∂t, mmHg s cm: from hardly any to more than the stiffness."""


def of_gamma(model, gamma):
    return model.changed(wall_viscosity=2.0 * gamma / np.sqrt(model.area0))


def fork(wall, **parts):
    network = vw.Network(("a", "b", "c"), [-1, 0, 0], [0.75, 0.55, 0.08], [0.047, 0.037, 0.026])
    return vw.Model(network, wall, windkessels(network, 76.0, T, a=0.2), **parts)


def ring():
    """Return a network whose vessels meet again, with a vessel across."""
    nodes = [[0, 1], [1, 2], [1, 3], [2, 4], [3, 4], [2, 3], [4, 5]]
    sizes = [0.5, 0.6, 0.9, 0.5, 0.3, 0.08, 0.4], [0.05, 0.035, 0.03, 0.03, 0.025, 0.02, 0.04]
    network = vw.Network(tuple("abcdefg"), None, *sizes, nodes=nodes)
    return vw.Model(network, vw.LinearWall(60.0), vw.Windkessel(*(np.array([one]) for one in (10.0, 60.0, 1.5e-3))))


def pulse(values):
    return values - values.mean(axis=0)


@pytest.mark.parametrize("gamma", GAMMAS[:1] + GAMMAS[2:4])
def test_a_small_wave_in_a_long_tube_has_the_attenuation_and_the_phase_velocity_of_theory(gamma):
    """γ² = (iω + k) ρ/A · iωC/(1 + iωCΓ/(A √A)), from three places: P(x - d) + P(x + d) = 2 cosh(γd) P(x)."""
    length, beta, radius = 6.0, 60.0, 0.047
    network = vw.Network(("tube",), [-1], [length], [radius])
    beds = vw.Windkessel(*(np.array([one]) for one in (80.0, 20.0, 1e-3)))
    model = of_gamma(vw.Model(network, vw.LinearWall(beta), beds), gamma)
    t = np.arange(256) / 256
    wave = Inflow(1e-5 * np.exp(-0.5 * ((t - 0.3) / 0.03) ** 2), T)
    numerics = Numerics(samples=256, cell_size=0.0125, every_cell=True, tolerance=1e-10)
    waves = vw.simulate(model, wave, numerics).pressure.to_numpy()
    apart = 20
    harmonics = np.fft.rfft(waves, axis=0)[1:9]
    middle = waves.shape[1] // 2
    ratio = (harmonics[:, middle - apart] + harmonics[:, middle + apart]) / (2 * harmonics[:, middle])
    found = np.arccosh(ratio) / (apart * 0.0125)
    A, omega, rho = np.pi * radius**2, 2 * np.pi / T * np.arange(1, 9), model.blood.inertia
    k0, k1 = model.blood.friction.coefficients(model.blood.viscosity, T)
    C = 2 * A / beta
    series = rho / A * (1j * omega + (k0 + k1 * np.sqrt(A)) / A)
    expected = np.sqrt(series * 1j * omega * C / (1 + 1j * omega * C * gamma / (A * np.sqrt(A))))
    found = np.where(found.real < 0, -found, found)
    assert np.max(np.abs(found.real / expected.real - 1)) < 0.005
    assert np.max(np.abs(found.imag / expected.imag - 1)) < 0.005


@pytest.mark.parametrize("gamma", GAMMAS)
@pytest.mark.parametrize("shape", [None, "tapers and total pressure"])
def test_small_waves_in_a_network_are_those_of_the_frequency_domain_on_any_cells_and_steps(inflow, gamma, shape):
    network = vw.control_network()
    rng = np.random.default_rng(1)
    tapers = Shape(np.exp(0.05 * rng.standard_normal((21, 2)))) if shape else None
    beds = windkessels(network, 76.0, T, a=0.12)
    model = of_gamma(vw.Model(network, vw.LinearWall(57.0), beds, shape=tapers), gamma)
    tiny = Inflow(1e-3 * inflow.flow, T)
    solved = linear_solution(model, tiny, 64)
    expected = pulse(solved.over_cycle(solved.pressure, 512))
    for cells in ({}, {"cell_size": 0.2}, {"cell_size": 0.025}, {"steps_per_cycle": 4096}):
        run = simulate_run(model, tiny, Numerics(tolerance=1e-8, **cells))
        assert np.max(np.abs(pulse(run.pressure[:, 0]) - expected)) < 0.01 * np.ptp(expected), cells
        assert abs(run.volume_error) < 1e-11


@WALLS
@pytest.mark.parametrize(
    "case",
    ["static", "total pressure", "ring", "pressure inlet"]
    + [pytest.param(one, marks=pytest.mark.validation) for one in ("ventricle", "pulsation behind")],
)
def test_walls_of_hardly_any_viscosity_are_elastic(inflow, wall, case):
    """The elastic nodes are solved one by one and share no line with those of viscous walls."""
    parts = {}
    if case == "total pressure":
        parts = {"shape": Shape(np.array([[1.05, 0.95], [1.0, 0.9], [1.0, 1.1]])), "loss": 0.8}
    if case == "pulsation behind":
        parts = {"outlet_pulsation": 2.0 * np.sin(2 * np.pi * np.arange(64) / 64)}
    model = ring().changed(wall=wall) if case == "ring" else fork(wall, **parts)
    driven = vw.Ventricle.from_peak(1400.0, 100.0, T, 4.0) if case == "ventricle" else inflow
    numerics = Numerics(samples=64, steps_per_cycle=2048, tolerance=1e-9)
    if case == "pressure inlet":
        driven = InletPressure(simulate_run(model, inflow, numerics).inlet_pressure(2048), T)
    elastic = simulate_run(model, driven, numerics)
    viscous = simulate_run(model.changed(wall_viscosity=1e-9), driven, numerics)
    assert np.max(np.abs(viscous.pressure - elastic.pressure)) < 1e-6
    assert np.max(np.abs(viscous.stations[1] - elastic.stations[1])) < 1e-7
    none = simulate_run(model.changed(wall_viscosity=0.0), driven, numerics)
    about_its_mean = 1e-13 if case == "pulsation behind" else 0.0  # which is taken anew, to the last bit or two
    assert np.abs(none.recorded - elastic.recorded).max() <= about_its_mean


@WALLS
@pytest.mark.parametrize("eta", [0.15, *(pytest.param(one, marks=pytest.mark.validation) for one in (0.01, 1.0))])
def test_the_error_of_small_waves_falls_with_the_square_of_the_cells_and_that_of_the_pulse_is_small(inflow, wall, eta):
    """The characteristic meets ψ of the cell at the end: of the pulse's own bending, half a cell is left of it."""
    network = vw.Network(("a", "b", "c"), [-1, 0, 0], [0.8, 0.4, 0.2], [0.047, 0.037, 0.026])
    model = vw.Model(network, wall, windkessels(network, 76.0, T, a=0.2), wall_viscosity=eta)

    def apart(driven, longest=0.1):
        def pressure(halvings):
            cells = {"cell_size": longest / 2**halvings, "steps_per_cycle": 1024 * 2**halvings}
            return simulate_run(model, driven, Numerics(samples=256, tolerance=1e-9, **cells)).pressure[:, ::2]

        coarse, middle, fine = map(pressure, range(3))
        return np.max(np.abs(coarse - middle)), np.max(np.abs(middle - fine))

    before, after = apart(Inflow(1e-3 * inflow.flow, T), 0.05)
    assert np.log2(before / after) > 1.8
    before, after = apart(inflow)
    assert before < 0.02
    assert np.log2(before / after) > 0.95


def test_the_loop_of_pressure_and_area_has_the_area_of_theory():
    """∮ p dA = Σ π k² ω φ |A_k|², φ = η/(2 √(A A0)): the elastic part of a small wave encloses none."""
    eta = 0.1
    model = fork(vw.LinearWall(57.0), wall_viscosity=eta)
    t = np.arange(256) / 256
    tiny = Inflow(1e-4 * (1 + np.cos(2 * np.pi * t) + 0.5 * np.sin(4 * np.pi * t)), T)
    run = vw.simulate(model, tiny, Numerics(samples=256, steps_per_cycle=4096, every_cell=True, tolerance=1e-10))
    p, A = run.pressure.to_numpy(), run.area.to_numpy()
    k = np.arange(129)[:, np.newaxis]
    spectrum = np.fft.rfft(A, axis=0)
    rate = np.fft.irfft(spectrum * 2j * np.pi * k / T, 256, axis=0)
    amplitude = 2 * np.abs(spectrum) / 256
    rows = [model.network.row(name) for name in run.vessel.to_numpy()]
    phi = eta / (2 * np.sqrt(A.mean(axis=0) * model.area0[rows]))
    expected = np.sum(np.pi * k**2 * 2 * np.pi / T * phi * amplitude**2, axis=0)
    assert np.max(np.abs(np.mean(p * rate, axis=0) * T / expected - 1)) < 0.002


def test_small_waves_in_a_ring_are_those_of_the_frequency_domain(inflow):
    model, tiny = ring().changed(wall_viscosity=0.2), Inflow(1e-3 * inflow.flow, T)
    solved = linear_solution(model, tiny, 64)
    expected = pulse(solved.over_cycle(solved.pressure, 512))
    run = simulate_run(model, tiny, Numerics(cell_size=0.05, tolerance=1e-8))
    assert np.max(np.abs(pulse(run.pressure[:, 0]) - expected)) < 0.01 * np.ptp(expected)


def test_viscosity_that_is_none_is_refused_and_names_the_vessel():
    with pytest.raises(InputError, match="vessel 'b': wall_viscosity -1 is not valid"):
        fork(vw.LinearWall(57.0), wall_viscosity=[0.1, -1.0, 0.1])
    with pytest.raises(InputError, match="one for each of the 3 vessels"):
        fork(vw.LinearWall(57.0), wall_viscosity=[0.1, 0.1])
