"""The conventions of the junction's place: lengths move from daughters to parents, as another program has them."""

import warnings
from pathlib import Path

import numpy as np
import pytest

from vasowave.base import VasowaveWarning
from vasowave.lung import Line, Options, Tree, extract
from vasowave.lung.exchange import read_centerlines, read_polydata
from vasowave.lung.measure import measured_alone, network_of
from vasowave.lung.revise import with_junctions_at

AORTA = Path(__file__).parents[2] / ".." / "shared" / "data" / "vmtk-aorta"
TURNED = np.array([1.0, -1.0, -1.0])
"""VMTK's lines count x and y the other way than DICOM does."""


def straight(start, end, radius, step=0.002):
    count = max(3, int(np.linalg.norm(np.subtract(end, start)) / step) + 1)
    return Line(np.linspace(start, end, count), np.full(count, radius))


@pytest.fixture
def fork():
    """A parent of 1 cm; daughters of 1.0 and 0.8 cm, 60 degrees apart, radii 0.06 and 0.04 cm."""
    away = np.array([[0, np.cos(a), np.sin(a)] for a in np.radians([-25, 35])])
    lines = (straight([0, -1, 0], [0, 0, 0], 0.08), straight([0, 0, 0], away[0], 0.06))
    return Tree((*lines, straight([0, 0, 0], 0.8 * away[1], 0.04)), np.array([-1, 0, 0]))


@pytest.mark.parametrize(("junction", "share"), [("tube", 0.5), ("vmtk", 1.0)])
def test_straight_daughters_part_where_trigonometry_says(fork, junction, share):
    before = measured_alone(fork)
    after = with_junctions_at(before, junction)
    sine = np.sin(np.radians(60))
    shared = share * np.array([0.04, 0.06]) / sine  # each leaves the tube of the other
    np.testing.assert_allclose(after.network.length[1:], [1.0 - shared[0], 0.8 - shared[1]], atol=1e-4)
    assert after.network.length[0] == pytest.approx(1 + shared.mean(), abs=1e-4)
    np.testing.assert_array_equal(after.network.radius, before.network.radius)


def test_the_mean_way_to_the_ends_stays(fork):
    before, after = (with_junctions_at(measured_alone(fork), junction) for junction in ("axes", "vmtk"))
    ways = [one.network.length[0] + one.network.length[1:].mean() for one in (before, after)]
    assert ways[0] == pytest.approx(ways[1], rel=1e-12)
    np.testing.assert_array_equal(before.network.length, network_of(fork).length)


def test_a_vessel_in_its_sisters_tube_keeps_half_its_length(fork):
    beside = np.add(fork.lines[1].points[:60], [0.0, 0.0, 0.01])
    tree = Tree((*fork.lines[:2], Line(beside, np.full(60, 0.03))), fork.parent)
    before, after = (with_junctions_at(measured_alone(tree), junction) for junction in ("axes", "vmtk"))
    assert after.network.length[2] == pytest.approx(0.5 * before.network.length[2])


@pytest.fixture(scope="module")
def aorta():
    """Extractions of VMTK's own test image by each convention, from the ends of VMTK's own lines."""
    if not AORTA.exists():
        pytest.skip("the aorta of VMTK's tests is not beside the project")
    lines = read_centerlines(AORTA / "aorta-centerline.vtp", unit=0.1)
    root, seed = lines.lines[0].points[[0, len(lines.lines[0]) // 2]] * TURNED
    ends = [(lines.lines[row].points[-1] * TURNED).tolist() for row in lines.terminals]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", VasowaveWarning)
        options = Options(root.tolist(), ends, 1000.0, seed.tolist(), cannula=0.0, species="human", loops="open")
        return extract(AORTA / "aorta.mha", options).measured, network_of(lines)


@pytest.mark.validation
def test_a_human_aorta_is_as_long_as_vmtks_lines_that_are_cut_by_the_same_rule(aorta):
    ours, theirs = aorta
    found = with_junctions_at(ours, "tube").network
    np.testing.assert_allclose(found.length, theirs.length, rtol=0.05)  # the aim
    np.testing.assert_allclose(found.radius[:2], theirs.radius[:2], rtol=0.07)
    assert abs(ours.network.length[0] / theirs.length[0] - 1) > 0.2  # the convention matters


@pytest.mark.validation
@pytest.mark.xfail(strict=True, reason="one iliac artery is 8.5 % wider: blur draws contours inward (docs/imaging.md)")
def test_both_iliac_arteries_of_a_human_are_as_wide_as_vmtks(aorta):
    ours, theirs = aorta
    np.testing.assert_allclose(ours.network.radius, theirs.radius, rtol=0.07)


@pytest.mark.validation
def test_a_human_aorta_is_as_long_as_what_vmtks_branch_extractor_makes_of_it(aorta):
    """Its parent and the group of the bifurcation are one vessel here; 7 %, for the ends were found anew."""
    ours, _ = aorta
    data = read_polydata(AORTA / "aorta-centerline-branches.vtp")
    length = np.array([0.1 * np.linalg.norm(np.diff(data.points[line], axis=0), axis=1).sum() for line in data.lines])
    groups = {group: length[data.cells["GroupIds"] == group].mean() for group in range(4)}
    found = with_junctions_at(ours, "vmtk").network
    np.testing.assert_allclose(found.length, [groups[0] + groups[1], groups[2], groups[3]], rtol=0.07)
