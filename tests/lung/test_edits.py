import warnings
from dataclasses import replace

import numpy as np
import pytest

from made_tree import forked_tree, straight
from vasowave.base import InputError, VasowaveWarning
from vasowave.lung import Tree
from vasowave.lung.measure import Densitometry, filled_at, measured_alone, network_of, taper, with_errors
from vasowave.lung.revise import (
    edited,
    first_generations,
    largest_vessels,
    outlets_of,
    part_of,
    read_edits,
    root_of,
    scaled,
    wider_than,
    with_radii,
)
from vasowave.pulse.network import Network


@pytest.fixture
def tree():
    return forked_tree()


def after(tree, tmp_path, text):
    file = tmp_path / "edits.txt"
    file.write_text(text + "\n")
    return edited(tree, read_edits(file))


def test_removing_one_of_two_sisters_lets_the_other_continue_the_parent(tree, tmp_path):
    found = after(tree, tmp_path, "remove 2.5 1 0   # vessel 5\n")
    np.testing.assert_array_equal(found.parent, [-1, 0, 0])
    assert sorted(network_of(found).length.round(9)) == sorted(np.round([1, np.sqrt(2), 2 * np.sqrt(2)], 9))
    long = found.lines[int(np.argmax(network_of(found).length))]
    np.testing.assert_allclose(long.points[[0, -1]], [[0, 0, 1], [0, 2, 3]], atol=1e-12)


def test_removing_a_vessel_takes_what_lies_beyond_it(tree, tmp_path):
    found = after(tree, tmp_path, "remove 1.5, 0.5, 0\n")
    np.testing.assert_array_equal(found.parent, [-1])  # 3 continues 1
    assert network_of(found).length[0] == pytest.approx(1 + np.sqrt(2))


def test_a_cut_shortens_the_vessel_and_takes_what_lies_beyond_it(tree, tmp_path):
    found = after(tree, tmp_path, "unit mm\ncut 15 5 0\n")
    np.testing.assert_array_equal(found.parent, [-1, 0, 0])
    np.testing.assert_allclose(found.lines[1].points[-1], [0, 0.5, 1.5], atol=1e-12)


def test_a_merged_vessel_leaves_one_junction_with_three_daughters(tree, tmp_path):
    found = after(tree, tmp_path, "merge 1.5 0.5 0\n")
    np.testing.assert_array_equal(found.parent, [-1, 0, 0, 0])


def test_edits_act_in_the_order_of_the_lines(tree, tmp_path):
    # After the merge 4 and 5 are daughters of 1, so removing 5 leaves a fork, and nothing is joined.
    found = after(tree, tmp_path, "merge 1.5 0.5 0\nremove 2.5 1 0\n")
    np.testing.assert_array_equal(found.parent, [-1, 0, 0])


def test_a_root_among_the_edits_is_read_in_its_unit(tmp_path):
    (tmp_path / "e.txt").write_text("# by hand\nunit mm\nroot 1 2 3\n")
    np.testing.assert_allclose(root_of(read_edits(tmp_path / "e.txt")), [0.3, 0.2, 0.1])


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("\nremvoe 1 2 3", r"line 2: unknown edit 'remvoe' \(did you mean 'remove'\?\)"),
        ("remove 1 2", "line 1: 'remove' takes three finite numbers x y z, not 1 2"),
        ("cut 1 2 nan", "line 1: 'cut' takes three finite numbers"),
        ("cut", "line 1: 'cut' takes three finite numbers x y z, not nothing"),
        ("unit furlong", "line 1: 'furlong' is not a unit of length"),
        ("root 1 2 3\nroot 1 2 3", "line 2: a second root"),
        ("remove 2.5 1 0\nremove 2.5 1 0.5", r"line 2: no vessel at 2\.5,1,0\.5 cm; the nearest axis passes"),
        ("remove 0.5 0 0", "line 1: this is the root"),
        ("merge 0.5 0 0", "line 1: 'merge' makes an inner vessel a point, but this is a root"),
        ("merge 2.5 1 0", "line 1: .* a terminal vessel; use 'remove'"),
        ("cut 0 0 0", "line 1: the place is where the vessel begins"),
        ("# by hand\nradius 1 2 3", "line 2: 'radius' takes "),
        ("radius 1 2 3 -1", "line 1: 'radius' takes "),
        ("move 1 2 3 4 5", "line 1: 'move' takes "),
        ("outlet 1 2", "line 1: 'outlet' takes "),
        ("unit", "line 1: 'unit' takes one word: cm, mm or um"),
    ],
)
def test_a_wrong_edit_is_named_with_its_line(tree, tmp_path, text, message):
    with pytest.raises(InputError, match=message):
        after(tree, tmp_path, text)


@pytest.fixture
def network(tree):
    return network_of(tree)


def test_generations_count_from_the_root(network):
    np.testing.assert_array_equal(first_generations(network, 2), [0, 1, 2])
    with pytest.warns(VasowaveWarning, match="3 generations, not 9"):
        assert len(first_generations(network, 9)) == 5
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert len(first_generations(network, 3)) == 5  # exactly all


def test_the_largest_sub_tree_opens_the_widest_junction_first_and_keeps_junctions_whole():
    parent = np.array([-1, 0, 0, 1, 1, 2, 2])
    radius = np.array([1, 0.7, 0.8, 0.6, 0.5, 0.55, 0.1])
    network = Network(tuple("abcdefg"), parent, np.ones(7), radius)
    np.testing.assert_array_equal(largest_vessels(network, 5), [0, 1, 2, 3, 4])  # 0.6 is wider than 0.55
    with pytest.warns(VasowaveWarning, match="3 vessels are kept, not 4"):
        assert len(largest_vessels(network, 4)) == 3


def test_all_vessels_above_a_radius_keep_their_narrow_sisters(network):
    np.testing.assert_array_equal(wider_than(network, 0.07), [0, 1, 2])  # 3 (0.05) is the sister of 2 (0.08)
    np.testing.assert_array_equal(wider_than(network, 0.035), [0, 1, 2, 3, 4])
    with pytest.raises(InputError, match="nothing would be kept"):
        wider_than(network, 0.2)


def test_taper_is_the_fall_of_the_radius_along_the_free_stretch():
    line = straight((0, 0, 0), (1, 0, 0), 0.05, 201)
    line.radius[:] = 0.05 - 0.02 * np.linspace(0, 1, 201)
    line.radius[:5] = 0.08  # inside the junction, and not measured
    short = straight((1, 0, 0), (1.05, 0, 0), 0.03)
    found = taper(Tree((line, short), np.array([-1, 0])))
    assert found.slope[0] == pytest.approx(0.02, rel=1e-9)
    assert found.proximal[0] == pytest.approx(0.05, rel=1e-9)
    assert found.distal[0] == pytest.approx(0.03, rel=1e-9)
    assert np.isnan(found.slope[1])


def test_the_standard_error_of_the_taper_is_that_of_repeated_measurements():
    """Radii that wander over one radius of length: the stated error must be the spread of the slopes."""
    rng, slopes, errors = np.random.default_rng(0), [], []
    for _ in range(300):
        line = straight((0, 0, 0), (2, 0, 0), 0.05, 801)
        knots = rng.normal(0, 0.001, 41)
        line.radius[:] += np.interp(np.linspace(0, 40, 801), np.arange(41), knots)
        found = taper(Tree((line,), np.array([-1])))
        slopes.append(found.slope[0])
        errors.append(found.slope_se[0])
    assert np.mean(errors) == pytest.approx(np.std(slopes), rel=0.25)


def test_a_moved_junction_takes_its_three_vessels_along_and_leaves_their_other_ends(tree, tmp_path):
    found = after(tree, tmp_path, "move 1 0 0  1.1 0.2 0.05\n")
    np.testing.assert_array_equal(found.parent, tree.parent)
    for row, end in ((0, -1), (1, 0), (2, 0)):
        np.testing.assert_allclose(found.lines[row].points[end], [0.05, 0.2, 1.1], atol=1e-12)
        np.testing.assert_array_equal(found.lines[row].points[-1 - end], tree.lines[row].points[-1 - end])
    for row in (3, 4):
        np.testing.assert_array_equal(found.lines[row].points, tree.lines[row].points)


def test_a_moved_outlet_and_a_moved_inlet_change_one_vessel_alone(tree, tmp_path):
    for row, end in ((4, -1), (0, 0)):
        old = tree.lines[row].points[end]
        x, y, z = old[::-1]
        found = after(tree, tmp_path, f"move {x} {y} {z} {x} {y} {z + 0.1}\n")
        np.testing.assert_allclose(found.lines[row].points[end], old + np.array([0.1, 0, 0]), atol=1e-12)
        assert [one for one in range(5) if not np.array_equal(found.lines[one].points, tree.lines[one].points)] == [row]


def test_a_move_that_is_longer_than_a_vessel_is_refused(tree, tmp_path):
    with pytest.raises(InputError, match=r"line 1: the move of 3 cm is longer than the shortest vessel .* \(1 cm\)"):
        after(tree, tmp_path, "move 1 0 0 1 0 3\n")


def test_a_radius_that_is_set_is_that_of_the_vessel_in_the_end(tree, tmp_path):
    """In the unit of the file; the vessel is looked for after the merge, which takes vessel 2 away."""
    file = tmp_path / "edits.txt"
    file.write_text("unit mm\nmerge 15 5 0\nradius 25 10 0 1.7\n")
    edits = read_edits(file)
    left = measured_alone(edited(tree, edits))
    found = with_radii(left, edits)
    changed = np.flatnonzero(found.network.radius != left.network.radius)
    assert found.network.radius[changed] == pytest.approx([0.17])
    np.testing.assert_allclose(found.tree.lines[changed[0]].points[-1], tree.lines[4].points[-1])
    assert found.reliable[changed].all()


def test_outlets_among_the_edits_are_places(tmp_path):
    (tmp_path / "e.txt").write_text("outlet 1 2 3\nunit mm\noutlet 10 20 35\n")
    np.testing.assert_allclose(outlets_of(read_edits(tmp_path / "e.txt")), [[3, 2, 1], [3.5, 2, 1]])
    assert outlets_of(()) is None


def measured(**changes):
    found = measured_alone(forked_tree())
    ones = np.ones(5)
    grey = Densitometry(0.1 * ones, 0.01 * ones, 50 * ones, ones, ones, np.array([0.01, 9, 0.02, 0, 0.0]),
                        np.array([0.001, 0.001, 0.0, 0.1, np.nan]), ones, 0.02 * ones, 0 * ones, 0.001)  # fmt: skip
    return replace(found, radius_sd=np.array([0.01, 0, np.nan, 0.02, 0.01]), grey=grey, **changes)


def test_a_network_knows_the_errors_and_tapers_that_were_measured():
    network = with_errors(measured()).network
    assert network.radius_sd == pytest.approx([0.01, np.nan, np.nan, 0.02, 0.01], nan_ok=True)
    assert network.taper == pytest.approx([0.01, np.nan, np.nan, 0, np.nan], nan_ok=True)  # 9 would close it
    assert network.taper_sd == pytest.approx([0.001, np.nan, np.nan, 0.1, np.nan], nan_ok=True)
    assert with_errors(replace(measured(), grey=None)).network.taper is None
    assert filled_at(measured(), 7.0).network.pressure == 7.0
    short = measured_alone(Tree((straight((0, 0, 0), (0.3, 0, 0), 0.1),), np.array([-1])))
    assert short.reliable.tolist() == [False]
    assert measured_alone(forked_tree(), np.arange(5.0)).length_sd.tolist() == [0, 1, 2, 3, 4]


def test_a_part_and_a_scaled_tree_take_everything_along():
    part = part_of(filled_at(measured(), 5.0), [0, 1, 3])
    assert (part.network.name, part.network.parent.tolist()) == (("1", "2", "4"), [-1, 0, 1])
    assert part.network.pressure == 5.0
    assert part.radius_sd == pytest.approx([0.01, 0, 0.02])
    assert part.grey.taper_sd == pytest.approx([0.001, 0.001, 0.1])
    assert part.tree.lines[2].points[-1].tolist() == [0, 2, 3]
    twice = scaled(measured(), 2.0)
    assert twice.network.length == pytest.approx(2 * measured().network.length)
    assert twice.radius_sd[0] == pytest.approx(0.02)
    assert twice.grey.radius[0] == pytest.approx(0.2)
    assert twice.grey.sd[0] == pytest.approx(0.02)
    assert twice.tree.lines[0].points[-1].tolist() == [0, 0, 2]
