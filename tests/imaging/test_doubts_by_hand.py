"""Witnesses of a tree of five vessels by hand: which vessels each doubt names, and from which number on."""

from dataclasses import replace
from statistics import NormalDist
from types import SimpleNamespace

import numpy as np
import pytest
from made_tree import forked_tree, straight

from vasowave.errors import InputError, VasowaveWarning
from vasowave.imaging.axes.skeleton import Skeleton
from vasowave.imaging.axes.tubes import _even, _tube_line
from vasowave.imaging.entrances import check_root
from vasowave.imaging.exchange.triangles import read_surface_points, write_stl
from vasowave.imaging.kept.stages import FOLDER, forget_stages
from vasowave.imaging.lumen.segmentation import Segmentation, _chosen, _holes, _pieces, reach_of, smoothed
from vasowave.imaging.lumen.surface import Surface
from vasowave.imaging.measure.cannula import cannula_radius
from vasowave.imaging.measure.evening import _median_slope, evened_sections
from vasowave.imaging.measure.measurement import measured_alone
from vasowave.imaging.measure.profiles import Profile
from vasowave.imaging.read.volume import Volume
from vasowave.imaging.tree import Line, Tree
from vasowave.imaging.witness import loops, witness
from vasowave.imaging.witness.doubts import Doubt, Grade, gravest, ranked, warn_of
from vasowave.imaging.witness.loops import Loop, _ring, euler_number, loop_count, loop_doubts, opening_threshold
from vasowave.imaging.witness.skeleton import Branches, Thinned, _branches, _keep_vessels, skeleton_branches
from vasowave.imaging.witness.topology import _beyond, _paired, topology_doubts

TREE = forked_tree()  # typical radii 0.10, 0.08, 0.05, 0.04, 0.03
SURE = np.ones(5, bool)


def measured(**changes):
    found = measured_alone(TREE)
    return replace(found, reliable=SURE, radius_sd=np.zeros(5), length_sd=np.zeros(5), **changes)


def rows(*which):
    return np.isin(np.arange(5), which)


def test_a_tree_is_shattered_if_more_than_half_of_its_vessels_are_too_short():
    assert witness._shattered(measured()) == []
    four = measured_alone(Tree((*TREE.lines[:4],), TREE.parent[:4]))
    half = replace(four, reliable=np.array([True, False, True, False]))
    assert witness._shattered(half) == []
    (doubt,) = witness._shattered(replace(measured(), reliable=rows(1, 3)))
    assert (doubt.vessels, doubt.about, doubt.grade) == (("1", "3", "5"), "topology", Grade.WRONG)
    assert str(doubt.finding).startswith("wrong: 3 of 5 vessels are too short between junctions")


def lumen(shape=(20, 250, 310), spacing=0.01, origin=(-0.1, -1.2, -0.05)):
    mask = np.zeros(shape, bool)
    return Segmentation(mask, mask.astype(float), np.zeros(3, int), spacing, np.array(origin), 50.0, 0.0, 1.0)


def test_a_vessel_ends_at_the_face_that_the_lumen_reaches_within_its_radius_and_two_voxels():
    """Vessels 4 and 5, of radii of 4 and 3 voxels, end at voxel 305 of 310 along x; 3, of 5, 20 voxels from y = 0."""
    seen = lumen()
    assert witness._cut(measured(), seen) == []
    seen.mask[5, 100, -1] = True  # the far face of x
    (doubt,) = witness._cut(measured(), seen)
    assert (doubt.vessels, doubt.about) == (("4", "5"), "length")
    assert doubt.places == pytest.approx(np.array([TREE.lines[row].points[20] for row in (3, 4)]))
    nearer = lumen(shape=(20, 250, 311))
    nearer.mask[5, 100, -1] = True
    assert [one.vessels for one in witness._cut(measured(), nearer)] == [("4",)]  # five voxels away
    low = lumen(origin=(-0.1, -1.0 - 0.069, -0.05))  # 3 ends 6.9 voxels from y = 0, with a radius of 5
    low.mask[0, 0, 100] = True  # near faces of z and y; z is 10 voxels away from all
    assert [one.vessels for one in witness._cut(measured(), low)] == [("3",)]
    low = lumen(origin=(-0.1, -1.0 - 0.0701, -0.05))
    low.mask[0, 0, 100] = True
    assert witness._cut(measured(), low) == []
    flat = lumen(origin=(-0.04, -1.2, -0.05))
    flat.mask[0, 100, 100] = True  # all ends lie 4 voxels from z = 0
    assert [one.vessels for one in witness._cut(measured(), flat)] == [("3", "4", "5")]


def test_lengths_and_radii_are_named_from_their_limits_on():
    lengths, radii = measured().network.length, measured().network.radius
    deviations = NormalDist().inv_cdf(1 - 0.2 / 2 / 5)
    length_sd, radius_sd = 0.1 / 3 * lengths, 0.05 / deviations * radii
    edge = replace(measured(), length_sd=0.999 * length_sd, radius_sd=0.999 * radius_sd)
    assert witness._unsettled(edge) == []
    more = np.array([1.001, 0.9, 1.001, 0.9, 0.9])
    found = replace(measured(), length_sd=more * length_sd, radius_sd=more[::-1] * radius_sd, reliable=rows(0, 1, 2, 4))
    unsure, wide, short = witness._unsettled(found)
    assert (unsure.vessels, unsure.about, unsure.grade) == (("1", "3"), "length", Grade.UNCERTAIN)
    assert "the length is uncertain by more than 10% (3 SD)" in str(unsure.finding)
    assert (wide.vessels, wide.about) == (("3", "5"), "radius")
    assert f"by more than 5% ({deviations:.1f} SD)" in str(wide.finding)
    assert (short.vessels, short.about) == (("4",), "radius")
    unknown = replace(measured(), radius_sd=np.full(5, np.nan))
    assert [one.vessels for one in witness._unsettled(unknown)] == [("1", "2", "3", "4", "5")]


def test_a_junction_is_doubted_by_the_shortest_of_the_vessels_that_meet_there():
    """At the end of 1 meet lengths 1, 1.41 and 1.41: three SD of 0.033 cm; at the end of 2: 1.41, 1.41 and 1."""
    place = np.array([0.0333, 0.0334, 9.0, 9.0, 9.0])
    (doubt,) = witness._junctions(measured(), place)
    assert doubt.vessels == ("2", "4", "5")
    assert doubt.places == pytest.approx(TREE.lines[1].points[-1:])
    assert "(0.42 radii, 1 SD)" in str(doubt.finding)
    assert [one.vessels for one in witness._junctions(measured(), place[[1, 0, 2, 3, 4]])] == [("1", "2", "3")]


def test_lumens_that_are_not_round_or_not_filled_are_named():
    grey = SimpleNamespace(contrast=np.array([100.0, 70.0, 69.9, np.nan, 50.0]))
    found = witness._uneven(measured(grey=grey), np.array([0.06, 0.0601, np.nan, 0.5, 0.0]))
    assert [(one.about, one.vessels) for one in found] == [("length", ("2", "4")), ("radius", ("3", "5"))]
    assert "less than 70% of the root's contrast" in str(found[1].finding)
    assert witness._uneven(measured(), np.zeros(5)) == []
    assert witness._uneven(measured(grey=SimpleNamespace(contrast=np.ones(5))), np.zeros(5)) == []


def test_the_misfit_of_a_surface_is_the_median_gap_from_its_mean_along_the_vessel():
    """Points around a tube of 0.1 at 0.1 ± 0.01, alternating."""
    line = straight((0, 0, 0), (2, 0, 0), 0.1, 201)
    angle = np.linspace(0, 2 * np.pi, 16, endpoint=False)
    x, turn = np.meshgrid(np.linspace(0.0, 2.0, 201), angle, indexing="ij")
    radius = 0.1 + 0.01 * np.where(np.arange(16) % 2, 1, -1)
    surface = np.column_stack([(radius * np.cos(turn)).ravel(), (radius * np.sin(turn)).ravel(), x.ravel()])
    tree = Tree((line,), np.array([-1]))
    assert witness.surface_misfit(tree, np.array([0.1]), surface, 0.01) == pytest.approx([0.1], rel=1e-6)
    few = surface[(surface[:, 2] > 0.955) & (surface[:, 2] < 0.963)]
    assert len(few) == 16
    assert np.isnan(witness.surface_misfit(tree, np.array([0.1]), few, 0.01)).all()
    beside = np.concatenate([surface, surface + np.array([0.5, 0, 0])])  # farther than 3 radii and 3 voxels
    assert witness.surface_misfit(tree, np.array([0.1]), beside, 0.01) == pytest.approx([0.1], rel=1e-6)


def branches(shift=0.0, parent=(-1, 0, 0, 1, 1)):
    """Return the tree's own branches, all ends moved along x."""
    begin = np.array([line.points[0] for line in TREE.lines])
    end = np.array([line.points[-1] for line in TREE.lines]) + np.array([0, 0, shift])
    radius = np.array([line.typical_radius for line in TREE.lines])
    return Branches(begin, end, np.array(parent), np.array([line.length for line in TREE.lines]), radius)


def test_the_same_tree_is_no_doubt_and_ends_are_those_of_each_other_within_their_reach():
    assert topology_doubts(TREE, branches(), 0.01, True) == []
    tips = np.array([2, 3, 4])
    assert _paired(TREE, branches(), tips, 0.01) == {2: 2, 3: 3, 4: 4}
    from vasowave.imaging.witness.topology import NEAR

    reach = {row: NEAR[0] * TREE.lines[row].typical_radius + NEAR[1] * 0.01 for row in (2, 3, 4)}
    assert set(_paired(TREE, branches(0.999 * reach[4]), tips, 0.01)) == {2, 3, 4}
    assert set(_paired(TREE, branches(1.001 * reach[4]), tips, 0.01)) == {2, 3}


def test_ends_that_the_other_tree_has_not_and_junctions_of_another_order_are_named():
    from vasowave.imaging.witness.topology import LONG

    one = branches()
    without = Branches(one.begin[:4], one.end[:4], one.parent[:4], one.length[:4], one.radius[:4])
    lost, *_ = topology_doubts(TREE, without, 0.01, True)
    assert lost.vessels == ("5",)
    assert lost.places == pytest.approx(TREE.lines[4].points[-1:])
    more = Branches(
        np.vstack([one.begin, one.end[2]]), np.vstack([one.end, [[0.5, -1.0, 2.0]]]), np.append(one.parent, 0),
        np.append(one.length, 1.0), np.append(one.radius, 0.05),
    )  # fmt: skip
    (spare,) = topology_doubts(TREE, more, 0.01, True)
    assert spare.vessels == ("3",)
    assert spare.places.tolist() == [[0.5, -1.0, 2.0]]
    assert "1 " in str(spare.finding)
    assert "2,-1,0.5" in str(spare.finding)
    assert topology_doubts(TREE, more, 0.01, False) == []
    (other,) = topology_doubts(TREE, branches(parent=(-1, 0, 1, 1, 0)), 0.01, True)  # 3 and 4 beyond 2, 5 beside it
    assert other.vessels == ("2",)
    assert _beyond(TREE.parent, {2: 7, 3: 8}) == {
        0: frozenset({7, 8}), 1: frozenset({8}), 2: frozenset({7}), 3: frozenset({8}), 4: frozenset()
    }  # fmt: skip
    least = np.array([0.0, LONG * 0.08, 0, 0, 0])
    (short,) = topology_doubts(TREE, branches(), 0.01, True, least)
    assert short.vessels == ("2",)
    assert topology_doubts(TREE, branches(), 0.01, True, 1.001 * least) == []


def test_doubts_are_ranked_by_grade_and_by_the_flow_through_their_vessels():
    network = measured().network
    share = network.flow_fraction
    wrong = Doubt("topology", witness.SHATTER(short=3, vessels=5))
    cut = [Doubt("length", witness.CUT(vessels="x"), names) for names in (("5",), ("3", "4"), ("2", "4"), ("4", "5"))]
    unsure = Doubt("radius", witness.NO_RADIUS(vessels="x"), ("1",))
    found = ranked([unsure, *cut, wrong], network)
    assert [one.grade for one in found] == [Grade.WRONG, *4 * [Grade.LOOK], Grade.UNCERTAIN]
    assert [one.flow for one in found] == pytest.approx(
        [1.0, *sorted([share[4], share[2] + share[3], share[1], share[3] + share[4]], reverse=True), 1.0]
    )
    assert gravest([unsure, cut[0]], "1") is Grade.UNCERTAIN
    assert gravest([Doubt("radius", witness.NO_RADIUS(vessels="x"), ("5",)), cut[0]], "5") is Grade.LOOK
    assert gravest(found, "none") is None


def test_the_first_doubts_are_warned_of_and_the_rest_counted_by_grade():
    from vasowave.imaging.witness.doubts import FIRST

    each = [Doubt("length", witness.CUT(vessels="x"), ("5",)), Doubt("radius", witness.NO_RADIUS(vessels="x"), ("1",))]
    with pytest.warns(VasowaveWarning) as heard:
        warn_of((*FIRST * each[:1], *each, each[1]))
    assert len(heard) == FIRST + 1
    assert str(heard[-1].message).startswith("3 more doubts (0 wrong, 1 to look at, 2 uncertain as the SD says)")
    with pytest.warns(VasowaveWarning) as heard:
        warn_of((*FIRST * each[:1],))
    assert len(heard) == FIRST


def voxels(*points):
    mask = np.zeros((5, 6, 7), bool)
    mask[tuple(np.array(points).T)] = True
    return mask


SQUARE = [(2, y, x) for y in (1, 2, 3) for x in (1, 2, 3) if (y, x) != (2, 2)]


def test_rings_and_cavities_are_counted_by_corners_edges_faces_and_voxels():
    assert euler_number(voxels((2, 2, 2))) == 1
    assert euler_number(voxels((2, 2, 2), (2, 2, 4))) == 2
    assert euler_number(voxels((2, 2, 2), (3, 3, 3))) == 1  # corners touch
    assert euler_number(voxels(*SQUARE)) == 0
    assert euler_number(voxels(*SQUARE, (2, 2, 2))) == 1
    cube = np.ones((3, 3, 3), bool)
    cube[1, 1, 1] = False
    assert euler_number(cube) == 2
    assert loop_count(replace(lumen(), mask=voxels(*SQUARE))) == 1


def test_a_higher_threshold_opens_a_ring_that_is_dim_somewhere():
    """Background 0, wall 50: tried are 57.5, 65 and 75, as long as six tenths of the lumen stay."""
    mask = voxels(*SQUARE)
    grey = np.where(mask, 100.0, 0.0)
    grey[2, 1, 2] = 60.0
    seen = replace(lumen(), mask=mask, grey=grey)
    assert opening_threshold(seen) == 65.0
    grey[2, 1, 2] = 100.0
    assert opening_threshold(seen) is None
    grey[2, 1, 1:4] = grey[2, 3, 1] = 60.0  # four of eight would stay
    assert opening_threshold(seen) is None
    assert opening_threshold(replace(seen, grey=0 * grey)) is None


def test_a_ring_is_as_long_as_its_ways_to_where_they_meet():
    """A path of 0-1-2, on from 2 to 3 and 4, and back from 2 to 5 and 6; a link of 4 and 6 closes it."""
    above = np.array([-1, 0, 1, 2, 3, 2, 5])
    points = np.array([[0, 0, 0], [1, 0, 0], [2, 0, 0], [3, 0, 0], [4, 0, 0], [3, 1, 0], [4, 2, 0]], float)
    expected = 2.0 + np.sqrt(2) * 2 + 2.0
    assert _ring(4, 6, above, points) == pytest.approx(expected)
    assert _ring(6, 4, above, points) == pytest.approx(expected)
    assert _ring(2, 4, above, points) == pytest.approx(4.0)


def test_a_loop_names_the_vessels_within_two_radii_or_else_the_nearest():
    names = ("1", "2", "3", "4", "5")
    at = np.array([[0.0, 0.0, 1.0], [0.0, 5.0, 2.0], [0.0, -0.09, 0.5]])
    found = loop_doubts(TREE, names, at)
    assert [one.vessels for one in found] == [("1", "2", "3"), ("4",), ("1",)]
    assert found[1].places.tolist() == [[0.0, 5.0, 2.0]]
    assert loop_doubts(TREE, names, at[:0]) == []


def test_refused_loops_are_named_up_to_six_with_places_and_lengths(monkeypatch):
    rings = [Loop(np.array([1.0, 2, 3]) + i, 0.5 - 0.05 * i, 0.01) for i in range(7)]
    monkeypatch.setattr(loops, "loops_of", lambda lumen: rings)
    monkeypatch.setattr(loops, "loop_count", lambda lumen: 8)
    with pytest.raises(InputError) as error:
        loops.told_loops(replace(lumen(), mask=voxels(*SQUARE)), "refuse", False, False)
    said = str(error.value)
    assert said.startswith(
        "the lumen closes 8 loop(s), thinnest at (x,y,z, cm) 3,2,1 (ring of 0.5 cm); 4,3,2 (ring of "
    )
    assert "8,7,6 (ring of 0.25 cm); and 1 more: vessels touch" in said
    monkeypatch.setattr(loops, "loops_of", lambda lumen: rings[:6])
    with pytest.warns(VasowaveWarning) as heard:
        places = loops.told_loops(replace(lumen(), mask=voxels(*SQUARE)), "open", False, False)
    assert "more: vessels" not in str(heard[0].message)
    assert places.tolist() == [one.place.tolist() for one in rings[:6]]


def test_branches_of_a_skeleton_begin_and_end_where_it_forks():
    """A stem of three points from the root at x = 0, where it forks into a long way and a spur."""
    places = np.array([[0, 0, x] for x in range(7)] + [[0, y, 2] for y in (1, 2)], float)
    above = np.array([-9, 0, 1, 2, 3, 4, 5, 2, 7])
    way = np.array([0, 1, 2, 3, 4, 5, 6, 3, 4.0])
    depth = np.array([1, 1, 2, 1, 1, 1, 0.5, 1, 1.0])
    skeleton = Thinned(places, depth, way, above, 0, 0.1)
    whole = _branches(skeleton, np.ones(9, bool))
    by_end = {tuple(end): row for row, end in enumerate(whole.end.tolist())}
    stem, long, spur = by_end[0, 0, 2], by_end[0, 0, 6], by_end[0, 2, 2]
    assert whole.parent[[stem, long, spur]].tolist() == [-1, stem, stem]
    assert whole.length[[stem, long, spur]].tolist() == [2, 4, 2]
    assert whole.radius[[stem, long, spur]].tolist() == [2, 2, 2]
    assert whole.begin[long].tolist() == [0, 0, 2]
    given = skeleton_branches(skeleton, np.array([[0, 0, 5.2], [0, 1.9, 2]]))
    assert sorted(given.length.tolist()) == [2, 2, 3]
    only = skeleton_branches(skeleton, np.array([[0, 0, 5.2]]))
    assert (only.length.tolist(), only.parent.tolist()) == ([5], [-1])


def test_spurs_that_noise_reaches_are_left_out():
    from vasowave.imaging.witness.skeleton import SPUR

    def kept(reach):
        places = np.array([[0, 0, x] for x in range(9)] + [[0, 0.5 * reach, 4], [0, reach, 4]], float)
        above = np.array([-9, 0, 1, 2, 3, 4, 5, 6, 7, 4, 9])
        way = np.append(np.arange(9.0), [4 + 0.5 * reach, 4 + reach])
        found = np.zeros(11, bool)
        found[0] = True
        _keep_vessels(Thinned(places, np.full(11, 0.6), way, above, 0, 0.1), found)
        return found.tolist()

    limit = SPUR[0] * 0.6 + SPUR[1] * 0.1
    assert kept(0.999 * limit) == [True] * 9 + [False] * 2
    assert kept(1.001 * limit) == [True] * 11


def test_the_piece_that_is_taken_is_the_largest_or_that_of_the_seed():
    bright = np.zeros((6, 30, 30), bool)
    bright[1:3, 2:12, 2:22] = True  # 400 voxels
    bright[4, 2:12, 2:12] = True  # 100
    bright[4, 20, 20] = True
    volume = Volume(bright + 0.0, np.full(3, 0.1), np.array([1.0, 0, 0]))
    with pytest.warns(VasowaveWarning, match=r"two separate trees \(400 and 100 voxels\): took the larger"):
        voxels, others = _pieces(volume, bright, None)
    assert len(voxels) == 400
    assert [len(one) for one in others] == [100]
    voxels, others = _pieces(volume, bright, np.array([1.4, 0.2, 0.2]))
    assert (len(voxels), [len(one) for one in others]) == (100, [400])
    voxels, others = _pieces(volume, bright, np.array([1.4, 2.04, 1.96]))
    assert (len(voxels), sorted(len(one) for one in others)) == (1, [100, 400])
    with pytest.raises(InputError, match=r"the point 0.2,0.2,1.5 cm \(x,y,z\) is not inside a vessel"):
        _pieces(volume, bright, np.array([1.5, 0.2, 0.2]))
    with pytest.raises(InputError, match="the lumen is empty; check the mask"):
        _pieces(volume, bright & False, None)
    labels = np.repeat([0, 1], [100, 10])
    assert _chosen(volume, np.zeros((110, 3)), labels, None) == 0  # a tenth is no second tree


def test_what_a_piece_encloses_is_filled():
    cube = np.ones((5, 5, 5), bool)
    cube[2, 2, 2] = cube[1, 3, 3] = False
    cube[0, 2, 2] = False  # open to a face
    found = _holes(cube)
    assert np.argwhere(found).tolist() == [[1, 3, 3], [2, 2, 2]]
    assert not _holes(np.ones((3, 3, 3), bool)).any()


def test_smoothing_is_gauss_as_far_as_three_deviations_beyond_the_mirrored_faces():
    from scipy.ndimage import gaussian_filter

    grey = np.random.default_rng(2).normal(size=(9, 6, 7)).astype(np.float32)
    for width in (0.5, 0.83, 1.3):
        assert reach_of(width) == int(3 * width + 0.5)
        assert smoothed(grey, width) == pytest.approx(
            gaussian_filter(grey, width, mode="reflect", truncate=3.0), abs=2e-6
        )


def sections(run, signal):
    count = len(run)
    return Profile(np.asarray(signal, float), np.ones(count), np.ones(2), 1.0, np.asarray(run, float),
                   np.arange(count), 0.1)  # fmt: skip


def test_sections_are_carried_to_the_middle_along_their_slope():
    run = np.linspace(0.1, 1.1, 21)
    width = 2.0 - 0.5 * run
    found = evened_sections(sections(run, width**2), 0.8)
    assert found.sections.signal == pytest.approx(1.6**2)
    assert found.taper == pytest.approx(0.5 / 1.6)
    assert _median_slope(np.array([0, 0, 1, 3.0]), np.array([1, 5, 4, 7.0])) == pytest.approx(
        np.median([3, 2, -1, 2 / 3, 1.5])
    )
    crossing = evened_sections(sections(run, (0.55 - 0.5 * run) ** 2), 1.2)  # its radius would be below zero there
    assert crossing.sections.signal == pytest.approx((0.55 - 0.5 * run) ** 2)
    assert evened_sections(sections(np.full(21, 0.3), width**2), 0.8).sections.signal == pytest.approx(width**2)


def test_curves_are_cut_into_even_steps_and_a_point_stays_one():
    way = _even(np.array([[0.0, 0, 0], [0, 0, 1], [0, 0, 2.5]]), 0.5)
    assert way[:, 2] == pytest.approx(np.linspace(0, 2.5, 6))
    assert len(_even(np.array([[0.0, 0, 0], [0, 0, 1]]), 0.9)) == 4  # three steps at least
    assert _even(np.array([[1.0, 2, 3], [1, 2, 3]]), 0.5).tolist() == [[1, 2, 3], [1, 2, 3]]
    line = _tube_line(np.array([[0.0, 0, 0], [0, 0, 10], [0, 0, 20]]), np.array([2.0, 4, 3]), 0.1)
    assert line.length == pytest.approx(2.0)
    assert np.interp([0.0, 0.5, 1.0, 2.0], line.run, line.radius) == pytest.approx([0.2, 0.3, 0.4, 0.3])


def test_a_cannula_that_is_too_short_to_be_measured_is_refused():
    volume = Volume(np.random.default_rng(1).normal(100, 1, (30, 30, 30)), np.full(3, 0.01), np.zeros(3))
    line = straight((0.1, 0.1, 0.1), (0.13, 0.1, 0.1), 0.05, 11)
    with pytest.raises(InputError, match=r"the cannula shows only 0\.03 cm, too little to measure its radius"):
        cannula_radius(line, volume)


def test_a_root_is_checked_against_the_cannula_and_a_wider_vessel_is_told():
    network = replace(measured().network, radius=np.array([0.05, 0.04, 0.0576, 0.03, 0.02]))
    with pytest.warns(VasowaveWarning, match=r"vessel 3 \(radius 0\.0576 cm\) is wider") as heard:
        check_root(network, 1.0, 0.06, "mouse")
    assert len(heard) == 1
    check_root(replace(network, radius=np.array([0.05, 0.04, 0.05749, 0.03, 0.02])), 1.0, 0.06, "mouse")
    from vasowave.imaging.entrances import SCALE_LIMIT

    check_root(replace(network, radius=np.full(5, 0.05)), 0.999 * (1 + SCALE_LIMIT), 0.06, "mouse")
    with pytest.raises(InputError, match=r"the cannula measures 0\.04 cm instead of 0\.06 \(radius\): the voxel size"):
        check_root(network, 1.5, 0.06, "mouse")


def test_stages_are_forgotten_with_their_folder_unless_something_else_lies_there(tmp_path):
    from vasowave.imaging.kept.stages import _SUFFIX

    (tmp_path / FOLDER).mkdir()
    (tmp_path / FOLDER / f"a{_SUFFIX}").write_bytes(b"x")
    (tmp_path / FOLDER / "mine.txt").write_bytes(b"x")
    forget_stages(tmp_path)
    assert [path.name for path in (tmp_path / FOLDER).iterdir()] == ["mine.txt"]
    (tmp_path / FOLDER / "mine.txt").unlink()
    forget_stages(tmp_path)
    assert not (tmp_path / FOLDER).exists()


def test_a_binary_stl_has_normals_and_corners_in_mm(tmp_path):
    """Two triangles, corners z y x in cm."""
    surface = Surface(np.array([[0.0, 0, 0], [0, 0, 1], [0, 2, 0], [3, 0, 0]]), np.array([[0, 1, 2], [0, 2, 3]]))
    write_stl(surface, tmp_path / "a.stl")
    raw = (tmp_path / "a.stl").read_bytes()
    assert raw[:9] == b"lumen, mm"
    assert int.from_bytes(raw[80:84], "little") == 2
    assert len(raw) == 84 + 100
    numbers = np.frombuffer(raw[84:132], "<f4").reshape(4, 3)
    assert numbers.tolist() == [[0, 0, 1], [0, 0, 0], [10, 0, 0], [0, 20, 0]]
    numbers = np.frombuffer(raw[134:182], "<f4").reshape(4, 3)
    assert numbers.tolist() == [[1, 0, 0], [0, 0, 0], [0, 20, 0], [0, 0, 30]]
    with pytest.raises(InputError, match="6 corners, or one that is not finite; is this the vessels' surface"):
        read_surface_points(tmp_path / "a.stl", 0.1)


def test_the_corners_of_a_surface_are_read_once_each_in_cm(tmp_path):
    corners = np.random.default_rng(4).normal(0, 1, (50, 3))
    triangles = np.random.default_rng(5).integers(0, 50, (40, 3))
    text = "solid x\n" + "".join(
        "facet normal 0 0 1\nouter loop\n" + "".join(f"vertex {x:.6f} {y:.6f} {z:.6f}\n" for x, y, z in corners[row])
        + "endloop\nendfacet\n" for row in triangles
    ) + "endsolid x\n"  # fmt: skip
    (tmp_path / "b.stl").write_text(text)
    found = read_surface_points(tmp_path / "b.stl", 0.1)
    expected = 0.1 * np.unique(np.round(corners[np.unique(triangles)], 6), axis=0)[:, ::-1]
    assert found == pytest.approx(expected)
    for damaged in (text[:-20], text.replace("solid x", "body x", 1), text.replace("vertex 0", "vertex O", 1)):
        (tmp_path / "c.stl").write_text(damaged)
        with pytest.raises(InputError, match=r"c\.stl: (not a whole STL file|.* corners)"):
            read_surface_points(tmp_path / "c.stl", 0.1)


def test_lines_of_one_point_are_no_skeleton():
    assert len(Skeleton(Line(np.zeros((1, 3)), np.ones(1)), np.array([-1])).line) == 1


def test_ways_out_of_a_ring_depend_on_what_closes_it(monkeypatch):
    def ways(gaps, level, level_set):
        monkeypatch.setattr(loops, "loops_after_closing", lambda lumen: 5 - gaps)
        monkeypatch.setattr(loops, "opening_threshold", lambda lumen: level)
        return loops._ways(lumen(), 5, level_set)

    assert ways(3, 65.0, True) == (
        "3 of them close with gaps of 6 voxels, as noise makes them: try the method 'level-set', "
        "raise the threshold to 65, where none is left, cut them in the mask"
    )
    assert ways(0, None, True) == "cut them in the mask, try the method 'level-set'"
    assert ways(3, None, False) == "cut them in the mask"
    assert ways(0, 65.0, False) == "raise the threshold to 65, where none is left, cut them in the mask"


def test_a_hole_of_one_voxel_is_one_that_closing_fills():
    mask = np.zeros((20, 20, 20), bool)
    mask[8:11, 4:16, 4:16] = True
    mask[8:11, 9:10, 9:10] = False  # a hole of one voxel
    assert loops.loops_after_closing(replace(lumen(), mask=mask)) == 0
    assert loop_count(replace(lumen(), mask=mask)) == 1


def test_a_vessel_is_in_a_lumen_that_holds_most_of_its_clear_stretch():
    from vasowave.imaging.measure.spread import _around, _in_lumen

    seen = lumen(shape=(21, 340, 340), origin=(-0.1, -1.2, -0.1))
    z, y, x = np.indices(seen.mask.shape) * 0.01 + np.array([-0.1, -1.2, -0.1])[:, None, None, None]
    seen.mask[:] = (x < 1.2) & (np.abs(y) < 0.3)
    assert _in_lumen(TREE, seen).tolist() == [True, False, False, False, False]
    seen.mask[:] = y > 0.45
    assert _in_lumen(TREE, seen).tolist() == [False, True, False, True, True]
    volume = Volume(seen.mask.astype("u1") + (z > 0), np.full(3, 0.01), seen.origin)
    part = _around(volume, Tree(TREE.lines[:1], np.array([-1])), np.zeros(3))
    reach = int(2 * 0.1 / 0.01 + 10)
    assert part.grey.shape == (21, 2 * reach + 1, 10 + 100 + reach + 1)
    assert part.origin == pytest.approx([-0.1, -0.3, -0.1])


def test_a_region_and_a_mask_are_files_too(tmp_path):
    from vasowave.imaging.given import _segmenter
    from vasowave.imaging.lumen.masks import EditedMask, Within
    from vasowave.imaging.options import Options
    from vasowave.imaging.read.itk import write_volume

    shape = (6, 7, 8)
    image = Volume(np.arange(336.0).reshape(shape), np.full(3, 0.01), np.zeros(3))
    region = np.zeros(shape, "u1")
    region[1:4, 2:5, 3:6] = 1
    write_volume(replace(image, grey=region), tmp_path / "region.nrrd")
    labels = np.zeros(shape, int)
    labels[:, :3] = 2
    found = _segmenter(Options(region=tmp_path / "region.nrrd"), image, image, labels)
    assert isinstance(found, EditedMask)
    assert np.array_equal(found.mask, (region > 0) & (labels > 0))
    within = _segmenter(Options(region=tmp_path / "region.nrrd"), image, image, None)
    assert isinstance(within, Within)
    assert np.array_equal(within.region, region > 0)
    box = _segmenter(Options(region=(np.array([0.01, 0.02, 0.03]), np.array([0.03, 0.04, 0.05]))), image, image, None)
    assert np.array_equal(box.region, region > 0)
    assert np.array_equal(_segmenter(Options(), image, image, labels).mask, labels > 0)
