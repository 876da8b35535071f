"""The compiled solution of straight trees: against the form in arrays, and against the same vessels as a graph.

A pressure behind the beds that varies by nothing takes the form in arrays, which asks nothing of the kernel.
"""

from dataclasses import dataclass

import numpy as np
import pytest
from scipy.optimize import least_squares

import vasowave as vw
from vasowave.pulse.calibration import (
    Coordinates,
    CorrectedNetwork,
    ParameterLimits,
    compared_part,
    descend,
    linear_spectra,
    parameter_space,
)
from vasowave.pulse.examples import control_network, virtual_mouse
from vasowave.pulse.model import (
    Blood,
    LinearWall,
    Model,
    Poiseuille,
    PowerWall,
    Resistance,
    TangentWall,
    VeinWall,
    estimate_nominal,
    find_bed,
    linear_solution,
    windkessels,
)
from vasowave.pulse.network import Network

FIELDS = ("mean_pressure", "input_impedance", "pressure", "flow", "retardation")
WALLS = LinearWall(60.0), TangentWall(8.0, 3.0), PowerWall(50.0, 2.0), VeinWall(90.0)


def random_tree(rng, count=17):
    """Vessels in any order, daughters before parents too, with up to three daughters each."""
    parents, daughters = [-1], np.zeros(count, dtype=int)
    for row in range(1, count):
        parents.append(int(rng.choice(np.flatnonzero(daughters[:row] < 3))))
        daughters[parents[-1]] += 1
    order = rng.permutation(count)
    place = np.argsort(order)
    parents = [-1 if parents[row] < 0 else int(place[parents[row]]) for row in order]
    radius = 0.05 * np.exp(0.4 * rng.standard_normal(count))
    names = tuple(map(str, range(count)))
    return Network(
        names, parents, np.exp(rng.uniform(-3.0, 0.5, count)), radius, pressure=float(rng.choice([0.0, 12.0]))
    )


def same(solution, other, share):
    for name in FIELDS:
        expected = getattr(other, name)
        np.testing.assert_allclose(getattr(solution, name), expected, 0, share * np.max(np.abs(expected)) + 1e-300)
    vessels = np.arange(len(solution.length))
    for middle, expected in zip(*(each.at(vessels, 0.5 * each.length) for each in (solution, other)), strict=True):
        np.testing.assert_allclose(middle, expected, 0, share * np.max(np.abs(expected)))


def models(seed):
    """One tree with all kinds of beds, blood, walls and pressures behind the beds."""
    rng = np.random.default_rng(seed)
    tree = random_tree(rng)
    behind = rng.uniform(0.0, 9.0, len(tree.terminals))
    tau, R = rng.uniform(0.05, 0.3), rng.uniform(40.0, 150.0)
    circuits = windkessels(tree, R, tau)
    spectrum = vw.ImpedanceSpectrum(circuits.impedance_at(9, 0.11))
    bare = Resistance(R / tree.flow_fraction[tree.terminals])
    for wall, beds, blood in zip(
        WALLS, (circuits, spectrum, bare, circuits), 3 * (Blood(),) + (Blood(friction=Poiseuille()),)
    ):
        yield Model(tree, wall, beds, blood, behind)
        yield Model(tree, wall, beds, blood, 4.0, wall_viscosity=rng.uniform(0.0, 2.0, len(tree)))


@pytest.mark.parametrize("seed", [41, 42, 43])
def test_the_kernel_says_what_arrays_say(seed):
    mouse = virtual_mouse()
    for model in models(seed):
        if isinstance(model.outlets, vw.ImpedanceSpectrum):  # which lets no wave through from behind
            continue
        in_arrays = model.changed(outlet_pulsation=np.zeros(16))
        same(linear_solution(model, mouse.inflow), linear_solution(in_arrays, mouse.inflow), 1e-9)


@pytest.mark.parametrize("seed", [51, 52])
def test_the_kernel_says_what_the_same_vessels_as_a_graph_say(seed):
    mouse = virtual_mouse()
    for model in models(seed):
        tree = model.network
        nodes = np.stack([tree.parent + 1, np.arange(len(tree)) + 1], axis=1)
        graph = Network(tree.name, None, tree.length, tree.radius, pressure=tree.pressure, nodes=nodes)
        order = [list(graph.terminals).index(row) for row in tree.terminals]
        assert order == sorted(order)
        same(
            linear_solution(model, mouse.inflow, 12),
            linear_solution(model.changed(network=graph), mouse.inflow, 12),
            1e-8,
        )


def test_a_pressure_that_drives_gives_the_flow_that_makes_it():
    for model in models(61):
        mouse = virtual_mouse()
        flowing = linear_solution(model, mouse.inflow, 8)
        at_inlet = flowing.over_cycle(flowing.pressure[:, model.network.root], 64)
        driven = linear_solution(model, vw.InletPressure(at_inlet, mouse.period), 8)
        root = model.network.root
        np.testing.assert_allclose(driven.flow[:, root], flowing.flow[:, root], 0, 1e-9 * np.abs(flowing.flow[0, root]))


@pytest.mark.parametrize(("bed", "viscous"), [("windkessel", False), ("rc", True), ("reflection", False)])
def test_starts_that_are_looked_at_together_go_where_each_alone_goes(bed, viscous):
    network, mouse = control_network(), virtual_mouse()
    nominal = estimate_nominal(network, mouse, Blood(), find_bed(bed))
    space = parameter_space("linear", network, nominal, Blood(), ParameterLimits(viscous=viscous))
    compared = compared_part(mouse, "signal")
    nominal_place = np.log(space.nominal[space.free])
    start = np.clip(nominal_place + np.random.default_rng(7).uniform(-0.4, 0.4, len(nominal_place)), *space.log_bounds)
    coordinates = Coordinates(space, mouse.mean_pressure)
    network_alone = CorrectedNetwork(coordinates, linear_spectra(space, compared), 0.0)
    (place,) = descend(network_alone.residuals, coordinates, start[np.newaxis], 1e6).x

    def missed(x):
        solution = linear_solution(space.model(space.values(x)), mouse.inflow, 12)
        spectrum = np.fft.rfft(mouse.pressure)[:13] / len(mouse.pressure) * np.where(np.arange(13) > 0, 2.0, 1.0)
        left = np.sqrt(np.where(np.arange(13) > 0, 0.5, 1.0)) * (spectrum - solution.pressure[:, network.root])
        return np.concatenate([left.real, left.imag])

    alone = least_squares(missed, start, bounds=space.log_bounds, ftol=1e-3, xtol=1e-3, max_nfev=15)
    assert np.sum(missed(place) ** 2) <= 1.02 * np.sum(missed(alone.x) ** 2)
    assert np.max(np.abs(start - place)) > 0.1


@dataclass
class HalvedFriction:
    """A friction that cannot be hashed, as a dataclass of a user's is."""

    def coefficients(self, viscosity, period):
        return tuple(0.5 * k for k in Poiseuille().coefficients(viscosity, period))


def test_a_friction_of_ones_own_that_cannot_be_hashed_is_that_of_half_the_viscosity():
    network, inflow = control_network(), virtual_mouse().inflow
    bloods = Blood(friction=HalvedFriction()), Blood(viscosity=0.5 * Blood().viscosity, friction=Poiseuille())
    beds = windkessels(network, 60.0, 0.1)
    same(*(linear_solution(Model(network, WALLS[0], beds, blood), inflow) for blood in bloods), 1e-12)
