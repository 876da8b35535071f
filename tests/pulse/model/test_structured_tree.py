"""Structured trees against trees written out vessel by vessel, theory, and the program of the paper's authors."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from scipy.special import jv

import vasowave as vw
from vasowave.base import MMHG, InputError
from vasowave.pulse.model import Model, Numerics, linear_solution, relative_viscosity, unsteady
from vasowave.pulse.solver import simulate, simulate_run

INERTIA = 1.057 / MMHG


def tree(**values):
    given = {"root_radius": [0.018, 0.013], "length_ratio": 17.0, "stiffness": 60.0}
    return vw.StructuredTree.of_factors(0.88, 0.68, **given | values).checked(("a", "b"))


def written_out(radius, omega, beds, j=0, root=None):
    """Return impedance of a vessel and all behind it, every one for itself, with Bessel's functions."""
    of = {name: float(value[j]) for name, value in zip(beds._fields, beds, strict=True)}
    wide = of["dilation"] * radius
    area, length = np.pi * wide**2, of["length_ratio"] * radius
    stiffness = of["stiffness"] * (1 + of["stiffening"] * np.exp(-wide / of["stiffening_radius"]))
    viscosity = of["viscosity"] * (relative_viscosity(np.array(wide), of["hematocrit"]) if of["hematocrit"] else 1.0)
    load = 0.0
    if radius > of["smallest"]:
        load = 1 / sum(1 / written_out(share * radius, omega, beds, j) for share in (0.88, 0.68))
    if omega == 0:
        return load + 8 * np.pi * INERTIA * viscosity * length / area**2
    z = 1j**1.5 * wide * np.sqrt(omega / viscosity)
    series = 1j * omega * INERTIA / area / (1 - 2 * jv(1, z) / (z * jv(0, z)))
    shunt = 1j * omega * 2 * area / stiffness
    own, turn = np.sqrt(series / shunt), np.tanh(np.sqrt(series * shunt) * length)
    return (load + own * turn) / (1 + load / own * turn)


@pytest.mark.parametrize(
    "values", [{}, {"hematocrit": 0.45}, {"stiffening": 4.0}, {"dilation": 0.8}, {"smallest": [0.004, 0.008]}], ids=str
)
def test_the_impedance_is_that_of_all_vessels_written_out(values):
    beds = tree(**values)
    omega = np.array([0.0, 3.0, 57.0, 400.0, 3000.0])
    found = beds.impedance(omega)
    for j, radius in enumerate((0.018, 0.013)):
        expected = [written_out(radius, one, beds, j) for one in omega]
        np.testing.assert_allclose(found[:, j], expected, rtol=1e-6)
    np.testing.assert_allclose(beds.impedance(-omega), found.conj())


def test_the_factors_of_radii_are_those_of_exponent_and_asymmetry():
    beds = tree()
    exponent, asymmetry = float(beds.exponent[0]), float(beds.asymmetry[0])
    assert 0.88**exponent + 0.68**exponent == pytest.approx(1.0)
    assert asymmetry == pytest.approx((0.68 / 0.88) ** 2)
    usual = vw.StructuredTree([0.018], 17.0, 60.0).checked(("a",))
    assert usual.total_resistance() == pytest.approx(tree(root_radius=0.018).total_resistance() * 2, rel=2e-3)


def test_a_constricted_tree_has_the_fourth_power_of_resistance_and_the_square_of_compliance():
    wide, narrow = tree(), tree(dilation=0.8)
    assert narrow.total_resistance() == pytest.approx(wide.total_resistance() / 0.8**4)
    np.testing.assert_allclose(narrow.weighted_compliance(), 0.8**2 * wide.weighted_compliance())


def test_the_compliance_of_a_tree_is_the_volume_of_a_steady_flow_over_the_pressure_at_its_root():
    """Two generations, by hand: pressure falls evenly along every vessel."""
    beds = tree(smallest=0.0165)
    root, ends = 0.018, np.array([0.88, 0.68]) * 0.018
    resist = 8 * INERTIA * 0.0462 * 17.0 / np.pi / np.array([root, *ends]) ** 3
    stretch = 2 * np.pi * np.array([root, *ends]) ** 3 * 17.0 / 60.0
    behind = 1 / np.sum(1 / resist[1:])
    share = behind / (behind + resist[0])
    expected = stretch[0] * (1 + share) / 2 + share / 2 * stretch[1:].sum()
    assert beds.weighted_compliance()[0] == pytest.approx(expected)


def test_friction_is_steady_for_slow_waves_and_a_boundary_layer_for_fast_ones():
    assert unsteady(np.array([1e-4]))[0] == pytest.approx(1j * 1e-8 / 8, rel=1e-6)
    assert unsteady(np.array([1e6]))[0] == pytest.approx(1.0, rel=1e-3)
    w = np.array([0.01, 0.3, 2.0, 7.0, 40.0])
    z = 1j**1.5 * w
    np.testing.assert_allclose(unsteady(w), 1 - 2 * jv(1, z) / (z * jv(0, z)), rtol=1e-7)


def test_viscosity_by_radius_is_that_of_pries_in_vivo():
    """10 µm wide, hematocrit 0.45: 5.87 times that of plasma, where wide vessels have 3.2 times; worked by hand."""
    assert relative_viscosity(np.array([5e-4]), 0.45)[0] == pytest.approx(5.872 / 3.2, rel=1e-3)
    assert relative_viscosity(np.array([1.0]), 0.3)[0] == pytest.approx(1.0, rel=1e-3)


@pytest.mark.parametrize(
    ("values", "said"),
    [
        ({"asymmetry": 1.2}, "asymmetry = 1.2; .* at most 1"),
        ({"hematocrit": 1.0}, "hematocrit = 1; give a share"),
        ({"hematocrit": 0.45, "smallest": 1e-4}, "viscosity by hematocrit has no meaning"),
        ({"exponent": 60.0}, "different radii, more than 4000"),
        ({"length_ratio": -1.0}, "length_ratio = -1; it must be positive and finite"),
    ],
)
def test_trees_that_cannot_be_are_refused_by_the_name_of_their_vessel(values, said):
    given = {"root_radius": [0.018, 0.013], "length_ratio": 17.0, "stiffness": 60.0} | values
    with pytest.raises(InputError, match=f"vessel '[ab]': .*{said}"):
        vw.StructuredTree(**given).checked(("a", "b"))


def authors(shared, name, factors, values, slower):
    """Return model, inflow and the authors' waves; their trees stand at harmonics that are `slower` times too low."""
    folder = shared / "structured-trees"
    network_name, flow_name, period = name
    network = vw.read_network(folder / f"{network_name}_network.csv")
    inflow = vw.Inflow(np.loadtxt(folder / f"{flow_name}_inflow.txt")[:512], period)
    density, viscosity, elastic, conversion = (values[one] for one in ("density", "viscosity", "elastic", "mmHg"))
    stiffness = 4 / 3 * elastic / conversion
    told = {"viscosity": viscosity / density, "density": density * MMHG / conversion}
    trees = vw.StructuredTree.of_factors(
        *factors, root_radius=network.radius[network.terminals], stiffness=stiffness, **values["tree"], **told
    )
    spectrum = vw.ImpedanceSpectrum(trees.impedance(2 * np.pi / period / slower * np.arange(257)))
    blood = vw.Blood(told["density"], told["viscosity"], vw.PowerLaw(9.0))
    waves = pd.read_csv(folder / f"{flow_name}_target.csv")
    return Model(network, vw.LinearWall(stiffness), spectrum, blood), trees, inflow, waves


MOUSE = (
    ("st_C6", "st_C6", 0.11), (0.88, 0.68),
    {"density": 1.055, "viscosity": 0.049, "elastic": 6e4, "mmHg": 1332.22,
     "tree": {"length_ratio": 17.0, "smallest": 0.005, "hematocrit": 0.45}},
)  # fmt: skip
HUMAN = (
    ("wk3", "st25", 0.9), (0.82, 0.66),
    {"density": 1.057, "viscosity": 0.032, "elastic": 3e5, "mmHg": 1333.22,
     "tree": {"length_ratio": 30.0, "smallest": 0.005, "hematocrit": 0.45}},
)  # fmt: skip


def apart(pressure, theirs):
    """Return the least root mean square difference over shifts by up to 4 of 512 samples."""
    return min(np.sqrt(np.mean((np.roll(pressure, -shift)[::8] - theirs) ** 2)) for shift in range(-4, 5))


def test_the_mouse_with_trees_is_that_of_the_authors_program(shared):
    model, trees, inflow, theirs = authors(shared, *MOUSE, slower=100.0)
    waves = simulate(model, inflow, Numerics(cell_size=0.05, samples=512, tolerance=1e-6))["pressure"].values
    assert apart(waves[:, 0, 0], theirs["p_in_1"]) < 0.01
    for row, name in enumerate(model.network.name):
        for place, station in (("in", 0), ("out", 2)):
            assert apart(waves[:, row, station], theirs[f"p_{place}_{name}"]) < 0.02
    right = simulate(model.changed(outlets=trees), inflow, Numerics(cell_size=0.05, tolerance=1e-6))
    found = right["pressure"].values[:, 0, 0]
    said = [26.70, 36.51, 46.04]  # their trees at the right harmonics, by a convolution
    np.testing.assert_allclose([found.min(), found.mean(), found.max()], said, atol=0.02)


def test_a_human_tree_of_three_vessels_is_that_of_the_authors_program(shared):
    model, _, inflow, theirs = authors(shared, *HUMAN, slower=10.0)
    waves = simulate(model, inflow, Numerics(cell_size=0.2, samples=512, tolerance=1e-6))["pressure"].values
    assert apart(waves[:, 0, 0], theirs["p_in_a"]) < 0.05  # they put asymptotes in place of Bessel functions


def wide(radius=(0.25,), **values):
    """Trees so wide and short that they reflect: of a human, down to 1 mm."""
    said = {"length_ratio": 50.0, "stiffness": 300.0, "smallest": 0.1, "viscosity": 0.0303} | values
    return vw.StructuredTree.of_factors(0.82, 0.66, root_radius=list(radius), **said)


@pytest.mark.parametrize("values", [{}, {"viscosity": 0.0462, "radius": (0.9, 1.1), "length_ratio": 30.0}])
def test_trees_that_reflect_get_as_many_poles_as_their_impedance_needs(values):
    beds, period = wide(**values), 0.9
    omega = 2 * np.pi / period * np.arange(1, 11)
    Z = beds.impedance(omega)
    met = beds.rational(period).impedance(1j * omega)
    np.testing.assert_allclose(met, Z, atol=0, rtol=0.008)
    worst = np.max(np.abs(met - Z) / np.abs(Z), axis=0)
    np.testing.assert_allclose(beds.misfit(period), worst, rtol=1e-9)


def test_small_waves_before_a_tree_that_reflects_are_those_of_its_impedance():
    network, period = vw.Network(("a",), [-1], [2.0], [0.25]), 0.9
    t = 2 * np.pi * np.arange(512) / 512
    inflow = vw.Inflow(1e-3 * (1.0 + np.cos(t) + 0.5 * np.sin(3 * t) + 0.2 * np.cos(7 * t)), period)
    model = Model(network, vw.LinearWall(300.0), wide())
    waves = simulate(model, inflow, Numerics(cell_size=0.1, samples=512, tolerance=1e-9))["pressure"].values[:, 0, 0]
    theory = linear_solution(model, inflow, 32)  # with the impedance of the tree itself
    expected = theory.over_cycle(theory.pressure, 512)[:, 0]
    assert np.sqrt(np.mean((waves - expected) ** 2)) < 0.003 * np.ptp(expected)


def test_a_bed_that_is_not_met_is_told_from_half_a_percent_on():
    network = vw.Network(("a",), [-1], [2.0], [0.05])
    inflow = vw.Inflow(0.1 + 0.1 * np.cos(np.arange(64) * np.pi / 32), 0.11)
    Z = vw.Windkessel([20.0], [130.0], [1e-3]).impedance_at(20, 0.11)
    noise = 1.0 + 0.03 * np.random.default_rng(1).standard_normal(Z.shape) * (np.arange(20) > 0)[:, np.newaxis]
    bed = vw.ImpedanceSpectrum(Z * noise)
    run = simulate_run(Model(network, vw.LinearWall(60.0), bed), inflow, Numerics())
    (told,) = [one for one in run.notes if one.code == "solver.bed-approximated"]
    percent = dict(told.values)["percent"]
    assert percent == pytest.approx(100 * bed.misfit(0.11)[0])
    assert 1.0 < percent < 20.0
    clean = simulate_run(Model(network, vw.LinearWall(60.0), vw.ImpedanceSpectrum(Z)), inflow, Numerics())
    assert not any(one.code == "solver.bed-approximated" for one in clean.notes)


@pytest.mark.parametrize("fine", [False, pytest.param(True, marks=pytest.mark.validation)])
def test_the_number_of_harmonics_of_a_spectrum_does_not_matter(control, inflow, fine):
    numerics = Numerics(cell_size=0.1, tolerance=1e-6) if fine else Numerics()
    network = control.network
    trees = vw.StructuredTree(network.radius[network.terminals], 6.0, 60.0, hematocrit=0.45)
    expected = simulate(control.changed(outlets=trees), inflow, numerics)["pressure"].values
    for count in (17, 65, 257, 2049) if fine else (17, 257):
        spectrum = vw.ImpedanceSpectrum(trees.impedance_at(count, inflow.period))
        found = simulate(control.changed(outlets=spectrum), inflow, numerics)["pressure"].values
        assert np.abs(found - expected).max() < 0.01


def test_trees_may_differ_from_terminal_to_terminal(control, inflow):
    network = control.network
    radii = network.radius[network.terminals]
    alike = vw.StructuredTree(radii, 6.0, 60.0)
    narrow = replace(alike, dilation=np.where(np.arange(len(radii)) == 0, 0.6, 1.0))
    flows = [
        simulate(control.changed(outlets=one), inflow)["flow"].values[:, network.terminals, 2].mean(axis=0)
        for one in (alike, narrow)
    ]
    assert flows[1][0] < 0.3 * flows[0][0]
    assert np.all(flows[1][1:] > flows[0][1:])
