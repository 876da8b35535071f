"""Faults that all vessels of an image share: walls, kernels, filters, calcified walls, holders, wrong units."""

import numpy as np
import pytest
from scipy import ndimage

from vasowave import KnownErrors, Network, lung
from vasowave.base import VasowaveWarning
from vasowave.lung import Line, Tree, Volume
from vasowave.lung.lumen import segment, without_inclusions
from vasowave.lung.measure import measured_in
from vasowave.lung.witness import Grade, fault_doubts

VOXEL, SIZE = 0.002, np.array([64, 56, 56])
RADII = 7.0, 4.0  # voxels
CONTRAST = 150.0


def straight(*places):
    """Parallel vessels along z, the second beyond the first in name alone: y, x and radius of each, voxels."""
    z = np.arange(1.0, SIZE[0] - 1)
    lines = [
        Line(VOXEL * np.column_stack([z, np.full_like(z, y), np.full_like(z, x)]), np.full_like(z, VOXEL * radius))
        for y, x, radius in places
    ]
    return Tree(tuple(lines), np.arange(len(lines)) - 1)


TREE = straight((17.0, 17.0, RADII[0]), (42.0, 42.0, RADII[1]))


def drawn(wall=0.0, level=0.0, spots=False):
    """The share of agent in every voxel, by samples within them: vessels, walls of so many radii, calcified spots."""
    fine = (np.arange(SIZE[1] * 5) + 0.5) / 5 - 0.5
    y, x = np.meshgrid(fine, fine, indexing="ij")
    plane = np.zeros_like(y)
    for line in TREE.lines:
        away = np.hypot(y - line.points[0, 1] / VOXEL, x - line.points[0, 2] / VOXEL)
        radius = line.radius[0] / VOXEL
        plane = np.maximum(plane, np.where(away < radius, 1.0, np.where(away < (1 + wall) * radius, level, 0.0)))
    flat = plane.reshape(SIZE[1], 5, SIZE[2], 5).mean(axis=(1, 3))
    grey = np.repeat(flat[None], SIZE[0], axis=0)
    if spots:
        grey[20:40, 17:25, 22:25] = 1.7
    return 40 + CONTRAST * ndimage.gaussian_filter(grey, 0.8)


def noisy(grey, sd=6.0, blur=0.5):
    noise = ndimage.gaussian_filter(np.random.default_rng(5).normal(size=grey.shape), blur)
    return grey + sd * noise / noise.std()


def seen(grey):
    volume = Volume(grey.astype(np.float32), (VOXEL,) * 3, (0, 0, 0))
    measured = measured_in(TREE, volume)
    faults = fault_doubts(measured, volume, segment(volume, 100.0))
    doubts, common = [fault.doubt for fault in faults], max((fault.common_sd for fault in faults), default=0.0)
    return measured, {doubt.finding.code: doubt for doubt in doubts}, common


def off(measured):
    """How far radii are off, as a share."""
    return measured.network.radius / (VOXEL * np.array(RADII)) - 1


pytestmark = pytest.mark.filterwarnings("ignore::vasowave.base.VasowaveWarning")


def test_vessels_without_walls_have_no_fault_and_their_radii():
    measured, doubts, common = seen(noisy(drawn()))
    assert doubts == {}
    assert common == 0
    assert np.abs(off(measured)).max() < 0.01
    assert np.isnan(measured.grey.wall).all()


@pytest.mark.parametrize(("wall", "level"), [(0.3, 0.22), (0.25, 0.3), (0.3, 0.5)])
def test_a_wall_is_measured_and_no_part_of_the_lumen(wall, level):
    measured, doubts, common = seen(noisy(drawn(wall, level)))
    assert list(doubts) == ["image.walls"]
    assert doubts["image.walls"].grade == Grade.UNCERTAIN
    assert np.abs(off(measured)).max() < 0.02
    plain = off(measured).max() + 1
    assert plain / measured.grey.share.min() > 1.04  # what grey levels alone sum up
    np.testing.assert_allclose(measured.grey.wall, wall * VOXEL * np.array(RADII), rtol=0.15)
    assert 0 < common < 0.05


def test_a_wall_in_a_noisy_image_is_measured_though_one_blurred_step_is_nearly_as_likely():
    measured, doubts, common = seen(noisy(drawn(0.3, 0.25), 22.0))
    assert list(doubts) == ["image.walls"]
    assert (np.abs(off(measured)) < 2 * np.hypot(common, measured.grey.sd / measured.network.radius)).all()


def test_walls_that_an_image_cannot_show_are_a_common_error_and_named_where_they_may_be_thick():
    hidden = {}
    for blur in (0.8, 2.0):
        measured, doubts, common = seen(noisy(ndimage.gaussian_filter(drawn(0.2, 0.25), np.sqrt(blur**2 - 0.64)), 9.0))
        hidden[blur] = measured.grey.hidden_wall
    assert list(doubts) == ["image.hidden-walls"]
    assert common == hidden[2.0]
    assert (np.abs(off(measured)) < 2 * np.hypot(common, measured.grey.sd / measured.network.radius)).all()
    sharp, _, _ = seen(noisy(drawn(), 2.0))
    assert sharp.grey.hidden_wall < hidden[2.0]


@pytest.mark.parametrize(("level", "widening"), [(0.0, 0.0), (0.22, 0.023), (0.4, 0.041)])
def test_walls_that_only_blur_the_edges_are_taken_off_as_far_as_they_show_and_else_an_error_of_all_radii(
    level, widening
):
    radii, fine = np.array([8.0, 7.0, 6.0, 5.0, 4.0]), (np.arange(160 * 4) + 0.5) / 4 - 0.5
    middles = np.array([16.3, 49.1, 80.6, 110.2, 137.4])
    y, x = np.meshgrid(fine, fine[: 34 * 4], indexing="ij")
    plane = np.zeros_like(y)
    for middle, radius in zip(middles, radii, strict=True):
        away = np.hypot(y - middle, x - 16.6) / radius
        plane = np.maximum(plane, np.where(away < 1, 1.0, np.where(away < 1.1, level, 0.0)))
    grey = np.repeat(plane.reshape(160, 4, 34, 4).mean(axis=(1, 3))[None], 50, axis=0)
    volume = Volume(
        noisy(40 + CONTRAST * ndimage.gaussian_filter(grey, 0.8)).astype(np.float32), (VOXEL,) * 3, (0, 0, 0)
    )
    z = np.arange(1.0, 49)
    lines = [
        Line(
            VOXEL * np.column_stack([z, np.full_like(z, middle), np.full_like(z, 16.6)]),
            np.full_like(z, VOXEL * radius),
        )
        for middle, radius in zip(middles, radii, strict=True)
    ]
    measured = measured_in(Tree(tuple(lines), np.arange(5) - 1), volume)
    error = measured.network.radius / (VOXEL * radii) - 1
    assert -0.006 < np.median(error) < 0.8 * widening + 0.002
    assert (np.abs(error) < 2 * np.hypot(measured.grey.hidden_wall, 0.006)).all()


def test_the_shadow_of_a_kernel_is_named_and_radii_are_those_of_the_edges():
    grey = noisy(drawn(), 3.0)
    measured, doubts, _ = seen(grey + 1.2 * (grey - ndimage.gaussian_filter(grey, 1.3)))
    assert list(doubts) == ["image.sharpened"]
    assert np.abs(off(measured)).max() < 0.02


def test_noise_that_is_smoother_than_edges_is_that_of_a_filter():
    _, doubts, common = seen(ndimage.median_filter(noisy(drawn(), 14.0, 0.3), size=5))
    assert doubts["image.filtered"].grade == Grade.LOOK
    assert common > 0.05


def test_inclusions_that_were_filled_evenly_are_no_filter():
    grey = noisy(drawn(), 9.0)
    for z in range(8, 60, 9):
        grey[z : z + 5, 15:20, 15:20] -= CONTRAST
    volume = Volume(grey.astype(np.float32), (VOXEL,) * 3, (0, 0, 0))
    lumen = segment(volume, 100.0)
    filled = without_inclusions(volume, lumen.mask, lumen.corner, lumen.inclusions)
    codes = [fault.doubt.finding.code for fault in fault_doubts(measured_in(TREE, filled), filled, lumen)]
    assert codes == ["image.inclusions"]


def test_what_outshines_the_agent_names_its_vessel():
    _, doubts, _ = seen(noisy(drawn(spots=True)))
    assert doubts["image.brighter-than-agent"].vessels == ("1",)


@pytest.mark.parametrize(("rim", "begin"), [(True, 30), (True, 0), (False, 0)])
def test_a_thin_rim_along_half_or_all_of_a_vessel_makes_its_radius_uncertain_and_no_other(rim, begin):
    z, y, x = np.indices(SIZE)
    away = np.hypot(y - 42.0, x - 42.0) - RADII[1]
    half_moon = np.clip(1.3 - np.abs(away - 0.4), 0, 1) * (away > 0) * (x > 42) * (z > begin)
    measured, _, _ = seen(noisy(drawn() + rim * 1.6 * CONTRAST * ndimage.gaussian_filter(half_moon, 0.8)))
    assert (measured.grey.uneven > 0).tolist() == [False, rim]
    assert (measured.grey.sd[1] > 0.04 * measured.grey.radius[1]) == rim
    assert (np.abs(off(measured)) * measured.network.radius < 2 * measured.grey.sd).all()
    assert measured.grey.edge is None


def test_a_clot_in_the_middle_of_a_vessel_makes_its_radius_uncertain():
    z, y, x = np.indices(SIZE)
    clot = (np.hypot(y - 42.0, x - 42.0) < 0.45 * RADII[1]) & (z > 22) & (z < 38)
    measured, _, _ = seen(noisy(drawn() - 0.75 * CONTRAST * ndimage.gaussian_filter(clot.astype(float), 0.8)))
    assert (measured.grey.uneven > 0).tolist() == [False, True]
    assert (np.abs(off(measured)) * measured.network.radius < 2 * measured.grey.sd).all()


def test_an_oval_vessel_beside_its_axis_has_no_rim():
    _, y, x = np.indices(SIZE)
    oval = np.clip(0.5 - (np.hypot((y - 17.3) / 8.0, (x - 17.0) / 6.0) - 1) * 7, 0, 1)
    measured, _, _ = seen(noisy(40 + CONTRAST * ndimage.gaussian_filter(oval, 0.8)))
    assert measured.grey.uneven[0] == 0


def test_a_rim_that_outshines_the_agent_is_no_double_edge():
    z, y, x = np.indices(SIZE)
    away, share = np.hypot(y - 17.0, x - 17.0), drawn() - 40
    rim = np.clip(1.5 - np.abs(away - 6.5), 0, 1) * (x > 18) * (z > 10) * (z < 56)
    grey = 40 + share + CONTRAST * ndimage.gaussian_filter(rim, 0.8)
    _, doubts, common = seen(noisy(grey, 9.0))
    assert doubts["image.brighter-than-agent"].vessels == ("1",)
    assert "image.doubled-edges" not in doubts
    assert common < 0.05


def test_fits_and_posteriors_take_a_common_error_that_is_larger_than_usual():
    network = Network(("1",), [-1], [1.0], [0.05], radius_scale_sd=[0.1])
    assumed = {error.name: error for error in KnownErrors().assumed(network)}
    assert (assumed["radius_scale"].sd, assumed["radius_scale"].source) == (0.1, "image")
    assert KnownErrors().sd("radius_scale", network) == 0.1
    assert KnownErrors().sd("radius_scale", Network(("1",), [-1], [1.0], [0.05], radius_scale_sd=[0.01])) == 0.05
    assert KnownErrors(radius_scale_sd=0.02).sd("radius_scale", network) == 0.02


def test_where_the_largest_piece_does_not_branch_the_tree_is_taken():
    z, y, x = np.indices((70, 70, 70))
    grey = np.where(np.hypot(y - 60, x - 60) < 6, 90.0, 0.0)  # a rod, larger than the tree
    stem = (np.hypot(y - 20, x - 30) < 2.5) & (z < 20)
    twigs = [(np.hypot(y - row, x - column) < 2) & (z >= 20) for row in (8, 20, 32) for column in (20, 32, 44)]
    plate = (np.abs(z - 20) < 2) & (np.abs(y - 20) < 14) & (np.abs(x - 32) < 14)
    grey[stem | plate | np.any(twigs, axis=0)] = 100.0
    with pytest.warns(VasowaveWarning, match="does not branch"):
        lumen = segment(Volume(grey, (VOXEL,) * 3, (0, 0, 0)), 50.0)
    assert lumen.mask[:, lumen.mask.shape[1] // 2].any()
    assert lumen.origin[1] < 10 * VOXEL


def test_a_holder_many_times_as_large_as_the_tree_is_not_taken_for_it():
    z, y, x = np.indices((70, 70, 70))
    grey = np.where(np.abs(np.hypot(y - 35, x - 35) - 33) < 3, 90.0, 0.0)  # 14 times the voxels of the tree
    stem = (np.hypot(y - 35, x - 35) < 2.5) & (z < 20)
    twigs = [np.hypot(y - 35 - dy * (z - 20), x - 35 - dx * (z - 20)) < 2 for dy, dx in
             ((0.4, 0.0), (-0.4, 0.0), (0.0, 0.4), (0.0, -0.4))]  # fmt: skip
    tree = stem | (np.any(twigs, axis=0) & (z >= 20) & (z < 60))
    grey[tree] = 100.0
    with pytest.warns(VasowaveWarning, match="does not branch"):
        lumen = segment(Volume(grey, (VOXEL,) * 3, (0, 0, 0)), 50.0)
    assert lumen.mask.sum() < 1.3 * tree.sum()


def test_the_first_look_says_by_what_factor_the_voxels_are_wrong():
    z, y, x = np.indices((60, 40, 40))
    grey = np.random.default_rng(0).normal(20, 5, z.shape) + 100 * (np.hypot(y - 20, x - 20) < 5)
    right, wrong = (lung.look(Volume(grey, (spacing,) * 3, (0, 0, 0)), cannula=0) for spacing in (0.008, 0.04))
    assert "image.unlike-species" not in [finding.code for finding in right.findings]
    (finding,) = (finding for finding in wrong.findings if finding.code == "image.unlike-species")
    assert "by a factor of" in str(finding)
