"""The second witness: what it has to name, where a tree contradicts its lumen, and what it must leave alone."""

from dataclasses import replace

import numpy as np
import pytest
from made_phantom import NETWORK, phantom
from made_tree import forked_tree

from vasowave.imaging.axes import vessels
from vasowave.imaging.axes.junctions import with_earlier_junctions, with_later_junctions, without_short_vessels
from vasowave.imaging.axes.vessels import begun_elsewhere, in_another_lumen
from vasowave.imaging.lumen.segmentation import segment
from vasowave.imaging.lumen.surface import surface_points
from vasowave.imaging.measure.measurement import measured_alone
from vasowave.imaging.tree import Line, Tree
from vasowave.imaging.witness.crossings import crossing_doubts
from vasowave.imaging.witness.skeleton import Branches, skeleton_branches
from vasowave.imaging.witness.topology import topology_doubts
from vasowave.imaging.witness.witness import _cut, _shattered, _unsettled


@pytest.fixture(scope="module")
def seen():
    """The skeleton of the phantom's lumen, and the true tree with its cannula."""
    embedding, volume = phantom()
    lumen = segment(volume, 45, embedding.cannula[0])
    cannula = np.linspace(*embedding.cannula, 20)[:-1]
    axes = [np.concatenate([cannula, embedding.lines[0]]), *embedding.lines[1:]]
    lines = tuple(Line(axis, np.full(len(axis), r)) for axis, r in zip(axes, NETWORK.radius, strict=True))
    return skeleton_branches(lumen, embedding.cannula[0], surface_points(lumen)), Tree(lines, NETWORK.parent), lumen


def test_the_witness_agrees_with_the_truth(seen):
    skeleton, tree, lumen = seen
    assert topology_doubts(tree, skeleton, lumen.spacing, True) == []


def test_the_witness_says_where_a_vessel_is_missing(seen):
    skeleton, tree, lumen = seen
    fewer = Tree(tree.lines[:4], tree.parent[:4])  # vessel 5 is gone
    (doubt,) = topology_doubts(fewer, skeleton, lumen.spacing, True)
    assert doubt.about == "topology"
    np.testing.assert_allclose(doubt.places[0], tree.lines[4].points[-1], atol=0.03)
    assert topology_doubts(fewer, skeleton, lumen.spacing, False) == []  # the user chose the outlets


def test_the_witness_names_a_vessel_that_is_not_there_and_a_junction_that_joins_others(seen):
    skeleton, tree, lumen = seen
    start = tree.lines[2].points[len(tree.lines[2]) // 2]
    invented = Line(start + np.linspace(0, 1, 20)[:, None] * [0.0, 0.0, 0.2], np.full(20, 0.03))
    more = Tree((*tree.lines, invented), np.append(tree.parent, 2))
    assert "6" in {name for doubt in topology_doubts(more, skeleton, lumen.spacing, True) for name in doubt.vessels}
    # Vessels 3 and 4 exchange their parents: all ends are right, and what lies beyond vessel 2 is not.
    lines = (*tree.lines[:2], tree.lines[3], tree.lines[2], tree.lines[4])
    swapped = Tree(lines, tree.parent)
    doubts = topology_doubts(swapped, skeleton, lumen.spacing, True)
    assert any("joins other vessels" in doubt.text and doubt.vessels == ("2",) for doubt in doubts)


def test_a_vessel_that_passes_straight_through_a_junction_is_doubted_and_daughters_are_not(seen):
    _, tree, _ = seen
    assert crossing_doubts(tree) == []
    touch = tree.lines[2].points[len(tree.lines[2]) // 2]
    way = np.array([0.1, 0.2, 0.0])
    halves = [Line(touch + np.linspace(0, side, 20)[:, None] * way, np.full(20, 0.02)) for side in (1, -1)]
    (doubt,) = crossing_doubts(Tree((*tree.lines, *halves), np.append(tree.parent, [2, 2])))
    assert doubt.vessels == ("6", "7")


def test_a_vessel_that_crosses_is_doubted_though_its_halves_first_bend_toward_what_they_cross(seen):
    _, tree, _ = seen
    middle = len(tree.lines[2]) // 2
    touch, along = tree.lines[2].points[middle], tree.lines[2].points[middle + 3] - tree.lines[2].points[middle - 3]
    across = np.cross(along, [1.0, 0.3, 0.2])
    across /= np.linalg.norm(across)
    beside = 0.06 * np.cross(along, across) / np.linalg.norm(along)
    bend = np.minimum(np.linspace(0, 8, 40), 1)  # to the crossing axis, in the ball of the junction; then along it
    radius = np.maximum(0.06 * (1 - bend), 0.02)
    ways = [bend[:, None] * beside + np.linspace(0, side, 40)[:, None] * across for side in (0.3, -0.3)]
    halves = [Line(touch + way, radius) for way in ways]
    doubts = crossing_doubts(Tree((*tree.lines, *halves), np.append(tree.parent, [2, 2])))
    assert ("6", "7") in [doubt.vessels for doubt in doubts]


def test_an_inner_vessel_shorter_than_its_junction_is_none_and_one_hardly_longer_is_doubted(seen):
    skeleton, tree, lumen = seen
    assert without_short_vessels(tree) is tree

    def with_stub(length):
        """Vessel 1 goes on for `length` before vessel 3 leaves it: its junction is two."""
        end, way = tree.lines[0].points[-1], tree.lines[0].points[-1] - tree.lines[0].points[-2]
        points = end + np.linspace(0, length, 6)[:, None] * way / np.linalg.norm(way)
        stub = Line(points, np.full(6, tree.lines[0].radius[-1]))
        parent = tree.parent.copy()
        parent[2] = len(tree)
        return Tree((*tree.lines, stub), np.append(parent, 0))

    radius = float(tree.lines[0].radius[-1])
    assert len(without_short_vessels(with_stub(0.5 * radius))) == len(tree)
    longer = with_stub(1.2 * radius)
    assert len(without_short_vessels(longer)) == len(tree) + 1
    doubts = topology_doubts(longer, skeleton, lumen.spacing, True)
    assert any("may be one" in doubt.text and doubt.vessels == ("6",) for doubt in doubts)


@pytest.mark.validation
def test_vessels_whose_meeting_the_surface_decides_meet_there_again_wherever_the_fit_begins(seen):
    _, tree, lumen = seen
    fit = in_another_lumen(tree, lumen)
    moved = with_earlier_junctions(fit)
    again = begun_elsewhere(fit, lumen, surface_points(lumen))
    for row in np.unique(tree.parent[tree.parent >= 0]):
        end = fit.lines[row].points[-1]
        assert np.linalg.norm(moved.lines[row].points[-1] - end) > fit.lines[row].typical_radius
        assert np.linalg.norm(again.lines[row].points[-1] - end) < 0.5 * lumen.spacing


def test_where_one_of_two_junctions_stays_the_vessel_between_them_reaches_from_there_to_where_its_daughters_begin(
    seen, monkeypatch
):
    _, tree, lumen = seen
    moved = with_earlier_junctions(tree)
    monkeypatch.setattr(vessels, "fitted", lambda begun, *rest: begun)
    monkeypatch.setattr(vessels, "_refitted", lambda begun, *rest: begun)
    monkeypatch.setattr(vessels, "_fits", lambda again, *rest: np.where(np.arange(len(again)) == 0, 2.0, 0.5))
    again = begun_elsewhere(tree, lumen, surface_points(lumen))
    (inner,) = [row for row in range(1, len(tree)) if row not in tree.terminals]
    for kept, row in ((tree, 0), (moved, inner)):
        places = [again.lines[daughter].points[0] for daughter in tree.daughters(row)]
        np.testing.assert_allclose(places, [kept.lines[row].points[-1]] * len(places))
        np.testing.assert_allclose(again.lines[row].points[-1], kept.lines[row].points[-1])
    assert again.lines[inner].length == pytest.approx(
        np.linalg.norm(moved.lines[inner].points[-1] - tree.lines[inner].points[0]), rel=0.05
    )


def test_later_junctions_lie_on_the_widest_daughter_and_all_begin_there():
    tree = forked_tree()
    later = with_later_junctions(tree)
    for row, widest, ahead in ((0, 1, 0.15), (1, 3, 0.12)):  # 1.5 radii
        begins = [later.lines[daughter].points[0] for daughter in tree.daughters(row)]
        np.testing.assert_allclose(begins, [later.lines[row].points[-1]] * 2)
        along = tree.lines[widest]
        off = np.linalg.norm(later.lines[row].points[-1] - along.points[0])
        assert off == pytest.approx(ahead, abs=along.run[1])
        assert np.linalg.norm(along.points - begins[0], axis=1).min() < 1e-9
    for row in tree.terminals:
        np.testing.assert_array_equal(later.lines[row].points[-1], tree.lines[row].points[-1])


def test_a_short_vessel_between_two_junctions_is_doubted_as_far_as_its_length_is_uncertain():
    tree = forked_tree()
    skeleton = Branches(
        np.array([line.points[0] for line in tree.lines]),
        np.array([line.points[-1] for line in tree.lines]),
        tree.parent,
        np.array([line.length for line in tree.lines]),
        np.array([line.typical_radius for line in tree.lines]),
    )
    least = np.array([line.length for line in tree.lines])
    assert topology_doubts(tree, skeleton, 0.01, True, least) == []
    least[1] = 0.11  # of 1.41 cm, radius 0.08
    (doubt,) = topology_doubts(tree, skeleton, 0.01, True, least)
    assert doubt.vessels == ("2",)
    assert "perhaps shorter than 1.5 radii" in doubt.text


def comb(count):
    """A root and `count` daughters side by side, measured without an image."""
    x = np.linspace(0, 1, 40)[:, None]
    lines = [Line(np.array([0.0, row, 0]) + x * [0.0, 0, 1], np.full(40, 0.02)) for row in range(count + 1)]
    return measured_alone(Tree(tuple(lines), np.append(-1, np.zeros(count, dtype=int))))


def test_the_same_uncertainty_of_radii_names_vessels_of_a_large_tree_and_not_those_of_a_small_one():
    def about(measured):
        known = replace(measured, radius_sd=0.018 * measured.network.radius, length_sd=0 * measured.network.radius)
        return [doubt.about for doubt in _unsettled(replace(known, reliable=np.ones(len(known.tree), dtype=bool)))]

    assert about(comb(4)) == []
    assert about(comb(60)) == ["radius"]


def test_a_tree_most_of_whose_vessels_cannot_be_measured_is_doubted_as_a_whole():
    measured = comb(9)
    assert _shattered(replace(measured, reliable=np.arange(10) >= 5)) == []
    (doubt,) = _shattered(replace(measured, reliable=np.arange(10) >= 6))
    assert doubt.about == "topology"
    assert len(doubt.vessels) == 6


def test_a_vessel_is_called_cut_only_where_the_lumen_reaches_the_border(seen):
    _, tree, lumen = seen
    whole = measured_alone(tree)
    assert _cut(whole, lumen) == []
    low = np.argwhere(lumen.mask.any(axis=(0, 1)))[0, 0] + 12  # a face through the vessels
    part = replace(lumen, mask=lumen.mask[:, :, low:], origin=lumen.origin + np.array([0, 0, low * lumen.spacing]))
    lost = [row for row in tree.terminals if tree.lines[row].points[-1][2] < part.origin[2]]
    (doubt,) = _cut(whole, part)
    assert set(doubt.vessels) == {str(row + 1) for row in lost}
    assert doubt.about == "length"
