"""Networks with loops and several inlets: what joins again, and what nothing but symmetry says."""

import numpy as np
import pytest

import vasowave as vw
from vasowave.base import InputError
from vasowave.pulse.model import linear_solution

EXACT = vw.Numerics(tolerance=1e-11)
SAME = 1e-9  # mmHg, ml/s: two ways to the same numbers, each converged to 1e-11 mmHg
R = 0.047  # cm
JUNCTIONS = pytest.mark.parametrize("junctions", ["static", "total"])
FORKED = [[0, 1], [1, 2], [1, 3], [2, 4], [3, 5]]
"""Two branches, each of two vessels."""


def beds(count):
    return vw.Windkessel(*(np.full(count, value) for value in (10.0 * count, 60.0 * count, 1.5e-3 / count)))


def model(network, **parts):
    wall = parts.pop("wall", vw.LinearWall(60.0))
    return vw.Model(network, wall, beds(len(network.terminals)), parts.pop("blood", vw.Blood()), **parts)


def network(nodes, length, radius, names=None):
    return vw.Network(names or tuple(map(str, range(len(nodes)))), None, length, radius, nodes=nodes)


def ring(cross=0.02):
    """Return a ring that nothing makes symmetric: two branches, and a vessel across them."""
    return network([*FORKED, [2, 3]], [0.5, 0.6, 0.9, 0.5, 0.3, 0.4], [0.05, 0.035, 0.03, 0.03, 0.025, cross])


def largest(one):
    return float(np.max(np.abs(one)))


@JUNCTIONS
@pytest.mark.parametrize("wall", [vw.LinearWall(60.0), vw.TangentWall(9.0, 4.0)], ids=["linear", "tangent"])
@pytest.mark.parametrize("share", [0.5, 0.3])
def test_a_vessel_cut_into_parallel_ones_of_its_area_carries_the_same_waves(inflow, junctions, wall, share):
    """A0 in parts and one wave speed: without friction a slice of the flow does not know of the others."""
    parts = {"wall": wall, "blood": vw.Blood(viscosity=0.0), "junctions": junctions}
    length = [0.5, 0.6, 0.5]
    whole = vw.simulate(model(vw.Network(("i", "m", "o"), [-1, 0, 1], length, [R, R, R]), **parts), inflow, EXACT)
    radii = [R, R * share**0.5, R * (1 - share) ** 0.5, R]
    cut = network([[0, 1], [1, 2], [1, 2], [2, 3]], [0.5, 0.6, 0.6, 0.5], radii, ("i", "a", "b", "o"))
    halves = vw.simulate(model(cut, **parts), inflow, EXACT)
    for name in "io":
        assert largest(whole.pressure.sel(vessel=name) - halves.pressure.sel(vessel=name)) < SAME
    for name, part in (("a", share), ("b", 1 - share)):
        assert largest(whole.pressure.sel(vessel="m") - halves.pressure.sel(vessel=name)) < SAME
        assert largest(part * whole.flow.sel(vessel="m") - halves.flow.sel(vessel=name)) < SAME


@JUNCTIONS
def test_branches_that_meet_in_equal_states_are_those_that_do_not(inflow, junctions):
    """With friction: the ends of two equal branches have one state, so that joining them changes nothing."""
    sizes = [0.5, 0.6, 0.6, 0.5, 0.5], [0.05, 0.035, 0.035, 0.03, 0.03]
    met = network([[0, 1], [1, 2], [1, 2], [2, 4], [2, 5]], *sizes)
    apart, joined = (
        vw.simulate(model(one, junctions=junctions), inflow, EXACT) for one in (network(FORKED, *sizes), met)
    )
    for name in ("pressure", "flow", "area"):
        assert largest(apart[name] - joined[name]) < SAME


@JUNCTIONS
def test_no_blood_crosses_the_middle_of_a_ring_with_equal_sides(inflow, junctions):
    sides = network([*FORKED, [2, 3]], [0.5, 0.6, 0.6, 0.5, 0.5, 0.4], [0.05, 0.035, 0.035, 0.03, 0.03, 0.02])
    waves = vw.simulate(model(sides, junctions=junctions), inflow, EXACT)
    across = waves.flow.sel(vessel="5")
    assert largest(across.sel(station="middle")) < 1e-12
    assert largest(across.sel(station="inlet")) > 1e-3  # it fills, from both sides
    assert abs(sides.flow_fraction[5]) < 1e-14


@JUNCTIONS
def test_volume_is_kept_and_flows_balance_in_every_node_of_a_ring(inflow, junctions):
    waves = vw.simulate(model(ring(), junctions=junctions), inflow, EXACT)
    assert abs(waves.attrs["volume_error"]) < 1e-13
    q = waves.flow
    for ending, beginning in ring().junctions:
        into = sum(q.isel(vessel=row).sel(station="outlet") for row in ending)
        assert largest(into - sum(q.isel(vessel=row).sel(station="inlet") for row in beginning)) < 1e-13


def test_a_vessel_that_is_turned_around_only_turns_its_flow(inflow):
    turned = network([*FORKED, [3, 2]], ring().length, ring().radius)
    here, there = (vw.simulate(model(one), inflow, EXACT) for one in (ring(), turned))
    names = [str(row) for row in range(5)]
    assert largest(here.pressure.sel(vessel=names) - there.pressure.sel(vessel=names)) < SAME
    back = there.flow.sel(vessel="5").isel(station=slice(None, None, -1)).values
    assert largest(here.flow.sel(vessel="5").values + back) < SAME
    assert here.flow.sel(vessel="5").mean() * ring().flow_fraction[5] > 0  # both say which way blood runs


def test_two_equal_inlets_are_one_line_of_which_each_has_half(inflow):
    """Two inlets lead to two outlets through one node: by symmetry each pair is a line of its own."""
    line = vw.Network(("in", "out"), [-1, 0], [0.6, 0.8], [0.04, 0.035])
    crossed = network([[0, 2], [1, 2], [2, 3], [2, 4]], [0.6, 0.6, 0.8, 0.8], [0.04, 0.04, 0.035, 0.035])
    bed = vw.Windkessel(10.0, 60.0, 1.5e-3)
    one = vw.simulate(vw.Model(line, vw.LinearWall(60.0), bed), inflow, EXACT)
    twice = vw.Inflow(np.column_stack([inflow.flow, inflow.flow]), inflow.period)
    wall = vw.LinearWall(60.0)
    both = vw.simulate(vw.Model(crossed, wall, vw.Windkessel(*(np.full(2, part) for part in bed))), twice, EXACT)
    for names, mine in ((["0", "1"], "in"), (["2", "3"], "out")):
        assert largest(both.pressure.sel(vessel=names) - one.pressure.sel(vessel=mine)) < SAME
        assert largest(both.flow.sel(vessel=names) - one.flow.sel(vessel=mine)) < SAME
    assert abs(both.attrs["volume_error"]) < 1e-13


def test_inlets_with_their_own_waveforms_keep_volume_and_flow(inflow):
    two = network([[0, 2], [1, 2], [2, 3]], [0.6, 0.4, 0.8], [0.04, 0.03, 0.045])
    late = 0.4 * np.roll(inflow.flow, len(inflow.flow) // 3)
    waves = vw.simulate(model(two), vw.Inflow(np.column_stack([inflow.flow, late]), inflow.period), EXACT)
    mean = waves.flow.mean("time")
    assert abs(waves.attrs["volume_error"]) < 1e-13
    for vessel, flow in (("0", inflow.flow), ("1", late)):
        assert mean.sel(vessel=vessel, station="inlet") == pytest.approx(flow.mean(), abs=1e-12)
    assert mean.sel(vessel="2", station="outlet") == pytest.approx(inflow.flow.mean() + late.mean(), abs=1e-6)


def test_a_network_of_several_inlets_needs_as_many_inflows(inflow):
    two = network([[0, 2], [1, 2], [2, 3]], [0.6, 0.4, 0.8], [0.04, 0.03, 0.045])
    with pytest.raises(InputError, match=r"2 inlet\(s\) \('0', '1'\) and 1 inflow"):
        vw.simulate(model(two), inflow)


@JUNCTIONS
def test_small_waves_in_a_ring_are_those_of_the_linear_network(inflow, junctions):
    """Waves of a thousandth of the wall's strength around no mean: what is not linear is of the second order."""
    small = vw.Inflow(1e-5 * (inflow.flow - inflow.flow.mean()), inflow.period)
    one = model(ring(), junctions=junctions)
    numerics = vw.Numerics(cell_size=0.0125, tolerance=1e-12, samples=72)
    waves, linear = vw.simulate(one, small, numerics), linear_solution(one, small)
    for name, spectrum in (("pressure", linear.pressure), ("flow", linear.flow)):
        ours, theirs = waves[name].values[:, :, 0], linear.over_cycle(spectrum, 72)
        assert largest(ours - theirs) < 2e-3 * np.ptp(theirs)  # cells of 0.0125 cm and 32 harmonics


def test_the_mean_of_a_ring_is_that_of_resistors(inflow):
    """Poiseuille's law in stiff vessels: a network of resistors with its beds, solved by loops instead of nodes."""
    steady = vw.Inflow(np.full(64, 0.1), inflow.period)
    one = model(ring(), wall=vw.LinearWall(1e7), blood=vw.Blood(friction=vw.Poiseuille()))
    linear, flow = linear_solution(one, steady), 0.1
    r = linear.resistance * one.network.length
    ends = r[3] + 140.0, r[4] + 140.0
    # q1 through the first branch, x across the ring: the drops around both loops vanish.
    loops = np.array([[r[1] + r[2], r[5]], [ends[0] + ends[1], -(ends[0] + ends[1] + r[5])]])
    q1, across = np.linalg.solve(loops, [r[2] * flow, ends[1] * flow])
    np.testing.assert_allclose(
        linear.flow[0].real, [flow, q1, flow - q1, q1 - across, flow - q1 + across, across], rtol=1e-6, atol=1e-9
    )


def test_a_graph_that_is_a_tree_is_the_tree_to_the_last_digit(inflow):
    tree = vw.Network(("a", "b", "c"), [-1, 0, 0], [0.7, 0.5, 0.3], [0.05, 0.04, 0.03])
    same = network([[7, 3], [3, 9], [3, 1]], tree.length, tree.radius, tree.name)
    assert same.nodes is None
    waves = [vw.simulate(model(one), inflow).pressure.values for one in (tree, same)]
    assert np.array_equal(*waves)
