"""Ends of vessels and paths through a lumen, on bodies whose answers are known."""

import numpy as np
import pytest
from scipy.spatial import cKDTree

from vasowave.base import InputError
from vasowave.lung import Line
from vasowave.lung.axes import paths, to_the_surface
from vasowave.lung.lumen import Segmentation

RNG = np.random.default_rng(3)


def axis(length, radius=0.1, step=0.02, bend=0.0):
    x = np.arange(0, length + step / 2, step)
    points = np.column_stack([np.zeros(len(x)), np.zeros(len(x)), x])
    points[-3:, 1] += bend  # the path turns to the farthest corner
    return Line(points, np.full(len(x), radius))


def test_an_end_is_straight_ahead_where_the_surface_is_whatever_the_last_radius_of_the_path_does():
    """The surface's median distance from where the axis is kept, 0.9 cm along it: 0.18 cm."""
    side = 0.03 * RNG.uniform(-1, 1, (60, 2))
    far = 0.9 + 0.18 + 0.01 * RNG.uniform(-1, 1, 60)
    cap = np.column_stack([side, far])
    beside = np.column_stack(
        [np.full((60, 1), 0.06), side[:, :1], np.full(60, 0.92)]
    )  # aside by more than half a radius
    beyond = np.column_stack([side, np.full(60, 1.25)])  # farther than three radii
    line = to_the_surface(axis(1.0, bend=0.05), np.concatenate([cap, beside, beyond]))
    ahead = np.median(far[np.hypot(*side.T) < 0.05])
    assert line.points[-1] == pytest.approx([0, 0, ahead], abs=1e-9)
    assert np.abs(line.points[:, 1]).max() < 1e-12
    added = line.run > 0.9 + 1e-9
    assert np.diff(line.run[added]) == pytest.approx(0.02, abs=0.002)
    assert line.radius[added] == pytest.approx(np.minimum(0.1, ahead - line.run[added]), abs=1e-9)


def bent_lumen():
    """A tube of radius 3 voxels that goes along x and then along y, and a spur as wide that leaves it in the middle."""
    z, y, x = np.indices((15, 50, 60))
    first = (np.hypot(z - 7, y - 7) <= 3) & (x >= 4) & (x <= 48)
    second = (np.hypot(z - 7, x - 48) <= 3) & (y >= 7) & (y <= 44)
    spur = (np.hypot(z - 7, x - 24) <= 3) & (y >= 7) & (y <= 30)
    mask = first | second | spur
    grey = np.where(mask, 100.0, 0.0).astype(np.float32)
    return Segmentation(mask, grey, np.zeros(3, int), 0.01, np.zeros(3), 50.0, 0.0, 1.0)


@pytest.fixture(scope="module")
def ways():
    return paths.minimal_paths(bent_lumen(), 0.01 * np.array([7.0, 7.0, 4.0]))


def test_the_edges_of_a_plate_are_no_ends_of_vessels(ways):
    paths.require_slender(ways, 20 * paths.long_tips(ways))
    mask = np.zeros((11, 70, 70), dtype=bool)
    mask[3:8, 3:67, 3:67] = np.random.default_rng(1).random((64, 64)) > 0.02  # a sheet full of holes
    grey = np.where(mask, 100.0, 0.0).astype(np.float32)
    lumen = Segmentation(mask, grey, np.zeros(3, int), 0.01, np.zeros(3), 50.0, 0.0, 1.0)
    sheet = paths.minimal_paths(lumen, 0.01 * np.array([5.0, 35.0, 3.0]))
    with pytest.raises(InputError, match="as wide as a plate"):
        paths.require_slender(sheet, paths.long_tips(sheet))


def test_minimal_paths_keep_to_the_middle_and_know_how_far_it_is(ways):
    tip = int(cKDTree(ways.voxels).query([7, 44, 48])[1])
    way = paths.paths_to(ways, [tip])
    inner = (way.line.points[:, 2] > 0.08) & (way.line.points[:, 2] < 0.43)
    assert np.abs(way.line.points[inner, 1] - 0.07).max() < 0.0101  # a voxel of the middle
    assert np.abs(way.line.points[:, 0] - 0.07).max() < 0.0101
    # 44 voxels along x and 37 along y; the corner is cut by at most two radii.
    assert 81 - 2 * 3 * (2 - np.sqrt(2)) - 1 <= ways.travelled[tip] <= 81 + 2
    assert ways.points[ways.start] == pytest.approx([0.07, 0.07, 0.04])
    assert ways.travelled[ways.start] == 0


def test_long_tips_are_the_ends_of_the_tube_and_of_the_spur_and_nothing_else(ways):
    tips = ways.voxels[paths.long_tips(ways)]
    assert len(tips) == 2
    assert np.abs(tips[0] - [7, 44, 48]).max() <= 4
    assert np.abs(tips[1] - [7, 30, 24]).max() <= 4
