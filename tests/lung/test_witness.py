"""The second witness: what it has to name, where a tree contradicts its lumen, and what it must leave alone."""

import warnings
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from made_phantom import NETWORK, phantom
from made_tree import forked_tree, straight
from vasowave.base import VasowaveWarning
from vasowave.lung import Line, Tree
from vasowave.lung.axes import fitted, settled, without_short_vessels
from vasowave.lung.lumen import Segmentation, segment, surface_points
from vasowave.lung.measure import measured_alone
from vasowave.lung.witness import (
    NOT_ROUND,
    SHATTER,
    UNSURE_LENGTH,
    Branches,
    Doubt,
    Grade,
    apart_doubts,
    crossing_doubts,
    doubts_about,
    gravest,
    ranked,
    skeleton_branches,
    surface_misfit,
    thinned,
    topology_doubts,
    warn_of,
)


@pytest.fixture(scope="module")
def seen():
    """The skeleton of the phantom's lumen, and the true tree with its cannula."""
    embedding, volume = phantom()
    lumen = segment(volume, 45, embedding.cannula[0])
    cannula = np.linspace(*embedding.cannula, 20)[:-1]
    axes = [np.concatenate([cannula, embedding.lines[0]]), *embedding.lines[1:]]
    lines = tuple(Line(axis, np.full(len(axis), r)) for axis, r in zip(axes, NETWORK.radius, strict=True))
    skeleton = skeleton_branches(thinned(lumen, embedding.cannula[0], surface_points(lumen)))
    return skeleton, Tree(lines, NETWORK.parent), lumen


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


def displaced(tree, share):
    """The tree whose junctions lie `share` radii of the parent nearer to the root, all daughters sharing the rest."""
    lines = list(tree.lines)
    for row in range(len(tree)):
        if row not in tree.terminals:
            at = int(np.searchsorted(lines[row].run, lines[row].length - share * lines[row].typical_radius))
            rest, lines[row] = lines[row][at:-1], lines[row][: at + 1]
            for daughter in tree.daughters(row):
                lines[daughter] = rest.then(lines[daughter])
    return tree.with_lines(lines)


@pytest.mark.validation
def test_junctions_that_begin_a_radius_off_end_where_the_vessels_were_joined_and_say_that_little_is_left_open(seen):
    _, tree, lumen = seen
    surface = surface_points(lumen)
    found = settled(fitted(displaced(tree, 1.2), surface, lumen.spacing, 1e-3), surface, lumen.spacing)
    for row in np.unique(tree.parent[tree.parent >= 0]):
        off = np.linalg.norm(found.tree.lines[row].points[-1] - tree.lines[row].points[-1])
        assert off < 0.25 * tree.lines[row].typical_radius
        assert off < 3 * found.place_sd[row]
        assert found.place_sd[row] < 0.3 * tree.lines[row].typical_radius
    assert np.all(found.place_sd[list(tree.terminals)] == 0)


def test_the_gravest_doubts_come_first_and_of_one_grade_those_with_most_of_the_flow():
    network = measured_alone(forked_tree()).network
    one, few, all_, wrong = (
        Doubt("length", kind(vessels=", ".join(names), **values), names)
        for kind, names, values in (
            (NOT_ROUND, ("4",), {}),
            (UNSURE_LENGTH, ("1",), {"share": 0.1, "deviations": 3.0}),
            (NOT_ROUND, ("2", "4", "3"), {}),
            (SHATTER, ("5",), {"short": 3}),
        )
    )
    found = ranked([few, one, all_, wrong], network)
    assert [doubt.vessels for doubt in found] == [("5",), ("2", "4", "3"), ("4",), ("1",)]
    assert found[1].flow == pytest.approx(1.0)  # vessel 4 lies beyond vessel 2, and its flow counts once
    assert found[2].flow == pytest.approx(network.flow_fraction[3])
    assert [doubt.grade for doubt in found] == [Grade.WRONG, Grade.LOOK, Grade.LOOK, Grade.UNCERTAIN]
    begins = [doubt.text.partition(": ")[0] for doubt in found]  # a look is what every warning asks for
    assert begins == ["wrong", "vessel(s) 2, 4, 3", "vessel(s) 4", "uncertain"]
    assert gravest(found, "4") is Grade.LOOK
    assert gravest(found, "6") is None
    with pytest.warns(VasowaveWarning) as told:
        warn_of(found * 2)
    said = [str(one.message) for one in told]
    assert said[0].startswith("wrong: ")
    assert len(said) == 6
    assert "extraction.json: 3 (0 wrong, 2 to look at, 1 uncertain" in said[-1]


def test_outlets_inside_a_vessel_are_compared_as_given_and_the_vessels_to_them_are_not_doubted(seen):
    whole, tree, lumen = seen
    lines = list(tree.lines)
    for row in tree.terminals:
        lines[row] = lines[row][: len(lines[row]) // 3]
    short = tree.with_lines(lines)
    assert topology_doubts(short, whole, lumen.spacing, False) != []  # beside the whole skeleton they end too early
    ends = np.array([lines[row].points[-1] for row in tree.terminals])
    begin = tree.lines[0].points[0]
    given = skeleton_branches(thinned(lumen, begin, surface_points(lumen)), ends)
    assert topology_doubts(short, given, lumen.spacing, False) == []
    swapped = Tree((*lines[:2], lines[3], lines[2], lines[4]), tree.parent)  # other vessels joined are still seen
    assert topology_doubts(swapped, given, lumen.spacing, False) != []


def branches_of(tree):
    """The tree itself as a second tree of its lumen."""
    return Branches(
        np.array([line.points[0] for line in tree.lines]),
        np.array([line.points[-1] for line in tree.lines]),
        tree.parent,
        np.array([line.length for line in tree.lines]),
        np.array([line.typical_radius for line in tree.lines]),
    )


def sure(tree):
    """Measurements of a tree that leave nothing open."""
    none = np.zeros(len(tree))
    return replace(measured_alone(tree), reliable=none == 0, radius_sd=none, length_sd=none)


def away(*pieces):
    """A lumen of a hundred voxels that touches no face of the image near the made tree, and `pieces` apart from it."""
    mask = np.zeros((10, 10, 10), bool)
    mask[1:6, 1:6, 1:5] = True
    grey = np.where(mask, 100.0, 0.0)
    return Segmentation(mask, grey, np.zeros(3, int), 0.01, np.zeros(3), 50.0, 0.0, 1.0, tuple(pieces))


def said_of(code, measured, lumen=None, misfit=None, place_sd=None, second=None):
    """Return the doubts of one kind about a measured tree that its second tree agrees with, unless another is given."""
    none = np.zeros(len(measured.tree))
    found = doubts_about(
        measured,
        away() if lumen is None else lumen,
        branches_of(measured.tree if second is None else second),
        none if misfit is None else misfit,
        none if place_sd is None else place_sd,
        True,
    )
    return [one for one in found if one.finding.code == code]


def test_a_tree_that_everything_agrees_with_is_not_doubted():
    tree = forked_tree()
    none = np.zeros(5)
    assert doubts_about(sure(tree), away(), branches_of(tree), none, none, True) == ()


def test_a_junction_in_doubt_names_every_vessel_that_meets_there():
    tree = forked_tree()
    shortest = min(tree.lines[row].length for row in (1, 3, 4))
    (doubt,) = said_of("witness.junction", sure(tree), place_sd=np.array([0.0, 0.04 * shortest, 0.0, 0.0, 0.0]))
    assert doubt.vessels == ("2", "4", "5")
    assert doubt.grade is Grade.UNCERTAIN
    np.testing.assert_array_equal(doubt.places, tree.lines[1].points[-1:])


def test_lengths_and_radii_that_the_image_does_not_settle_are_named():
    tree = forked_tree()
    length_sd, radius_sd = 0.1 / 3 * sure(tree).network.length, 0.05 / 2 * sure(tree).network.radius
    shares = np.array([1.1, 0.9, 1.1, 0.9, 0.9])
    measured = replace(
        sure(tree), length_sd=shares * length_sd, radius_sd=shares[::-1] * radius_sd, reliable=np.arange(5) != 3
    )
    assert [one.vessels for one in said_of("witness.length", measured)] == [("1", "3")]
    assert [one.vessels for one in said_of("witness.radius", measured)] == [("3", "5")]
    assert [one.vessels for one in said_of("witness.short-for-radius", measured)] == [("4",)]


def test_a_vessel_that_is_not_round_one_that_is_uneven_and_one_that_is_partly_filled_are_named():
    tree, uneven = forked_tree(), np.array([0.0, 0.0, 0.0, 0.1, 0.0])
    grey = SimpleNamespace(contrast=np.array([100.0, 75.0, 65.0, np.nan, 50.0]), uneven=uneven)
    measured, misfit = replace(sure(tree), grey=grey), np.array([0.05, 0.07, np.nan, 0.5, 0.0])
    assert [one.vessels for one in said_of("witness.not-round", measured, misfit=misfit)] == [("2", "4")]
    assert [one.vessels for one in said_of("witness.partly-filled", measured)] == [("3", "5")]
    assert [one.vessels for one in said_of("witness.uneven-width", measured)] == [("4",)]


def test_the_misfit_of_a_surface_is_the_share_of_the_radius_by_which_it_waves():
    """Points around a tube of 0.1 cm at 0.11 and 0.09 cm in turn."""
    x, turn = np.meshgrid(np.linspace(0, 2, 201), np.linspace(0, 2 * np.pi, 16, endpoint=False), indexing="ij")
    radius = 0.1 + 0.01 * np.where(np.arange(16) % 2, 1, -1)
    surface = np.column_stack([(radius * np.cos(turn)).ravel(), (radius * np.sin(turn)).ravel(), x.ravel()])
    tree = Tree((straight((0, 0, 0), (2, 0, 0), 0.1, 201),), np.array([-1]))
    assert surface_misfit(tree, np.array([0.1]), surface, 0.01) == pytest.approx([0.1], rel=1e-6)


def test_a_short_vessel_between_two_junctions_is_doubted_as_far_as_its_length_is_uncertain():
    tree = forked_tree()
    assert said_of("witness.short-vessel", sure(tree)) == []
    measured = replace(sure(tree), length_sd=np.array([0.0, 0.44, 0.0, 0.0, 0.0]))  # of 1.41 cm: perhaps 0.09
    (doubt,) = said_of("witness.short-vessel", measured)
    assert doubt.vessels == ("2",)
    assert "perhaps shorter than 1.5 radii" in doubt.text


def comb(count):
    """A root and `count` daughters side by side, measured without an image."""
    x = np.linspace(0, 1, 40)[:, None]
    lines = [Line(np.array([0.0, row, 0]) + x * [0.0, 0, 1], np.full(40, 0.02)) for row in range(count + 1)]
    return sure(Tree(tuple(lines), np.append(-1, np.zeros(count, dtype=int))))


def test_the_same_uncertainty_of_radii_names_vessels_of_a_large_tree_and_not_those_of_a_small_one():
    small, large = (replace(one, radius_sd=0.018 * one.network.radius) for one in (comb(4), comb(60)))
    assert said_of("witness.radius", small) == []
    assert len(said_of("witness.radius", large)) == 1


def test_a_tree_most_of_whose_vessels_cannot_be_measured_is_doubted_as_a_whole():
    measured = comb(9)
    half, most = (replace(measured, reliable=np.arange(10) >= short) for short in (5, 6))
    assert said_of("witness.shattered", half, second=comb(4).tree) == []
    (doubt,) = said_of("witness.shattered", most, second=comb(4).tree)
    assert (doubt.about, doubt.grade) == ("topology", Grade.WRONG)
    assert len(doubt.vessels) == 6


def test_stumps_of_a_pruned_tree_are_no_ridges():
    stumps = replace(comb(9), reliable=np.arange(10) < 1)  # the stem is well measured, its daughters are short
    assert said_of("witness.shattered", stumps, second=comb(8).tree) == []


def test_of_a_tree_of_stumps_that_its_second_tree_mostly_has_only_what_that_lacks_is_looked_at():
    stumps = replace(comb(9), reliable=np.arange(10) >= 6)
    for second in (comb(9).tree, comb(8).tree):  # it may lack one: they are hardly longer than what it prunes
        assert said_of("witness.shattered", stumps, second=second) == []
    (doubt,) = said_of("witness.not-seen", stumps, second=comb(8).tree)
    assert (doubt.grade, len(doubt.vessels)) == (Grade.LOOK, 1)


def test_a_vessel_is_called_cut_only_where_the_lumen_reaches_the_border(seen):
    _, tree, lumen = seen
    assert said_of("witness.cut", sure(tree), lumen) == []
    low = np.argwhere(lumen.mask.any(axis=(0, 1)))[0, 0] + 12  # a face through the vessels
    part = replace(lumen, mask=lumen.mask[:, :, low:], origin=lumen.origin + np.array([0, 0, low * lumen.spacing]))
    lost = [row for row in tree.terminals if tree.lines[row].points[-1][2] < part.origin[2]]
    (doubt,) = said_of("witness.cut", sure(tree), part)
    assert set(doubt.vessels) == {str(row + 1) for row in lost}
    assert doubt.about == "length"


def piece(gap):
    """A straight piece of 0.5 cm, z y x, that begins `gap` beyond the wall at the end of vessel 5, at (3, 1, 0)."""
    return np.column_stack([np.zeros(25), np.ones(25), 3 + 0.03 + gap + np.linspace(0, 0.5, 25)])


def test_a_piece_apart_that_ends_near_a_vessel_may_belong_to_it_and_others_are_only_told():
    names = ("1", "2", "3", "4", "5")
    assert apart_doubts(forked_tree(), names, away()) == []
    near = 0.03 + 0.02  # a radius and two voxels
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        (doubt,) = apart_doubts(forked_tree(), names, away(piece(near)))
    assert (doubt.about, doubt.vessels) == ("topology", ("5",))
    values = dict(doubt.finding.values)
    assert (values["gap"], values["share"]) == pytest.approx((near, 0.25))
    past = np.column_stack([np.linspace(-0.4, 0.4, 41), np.ones(41), np.full(41, 3.05)])  # its middle is nearest
    with pytest.warns(VasowaveWarning, match=r"2 separate piece\(s\)"):
        assert apart_doubts(forked_tree(), names, away(piece(0.3), past)) == []


@pytest.mark.parametrize(("turn", "doubted"), [(10, [("2", "3")]), (90, [])])
def test_daughters_that_run_straight_into_one_another_are_doubted(turn, doubted):
    """Two daughters that leave a stem one opposite the other, but for `turn` degrees."""
    angle = np.radians(turn)
    stem, one = straight((0, -1, 0), (0, 0, 0), 0.05), straight((0, 0, 0), (2, 0, 0), 0.05, 81)
    other = straight((0, 0, 0), (-2 * np.cos(angle), 2 * np.sin(angle), 0), 0.05, 81)
    assert [one.vessels for one in crossing_doubts(Tree((stem, one, other), np.array([-1, 0, 0])))] == doubted
