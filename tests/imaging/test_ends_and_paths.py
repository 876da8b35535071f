"""Ends of vessels, paths through a lumen and what holds tubes straight, on bodies whose answers are known."""

import numpy as np
import pytest
from scipy.spatial import cKDTree

from vasowave.errors import InputError
from vasowave.imaging.axes import paths
from vasowave.imaging.axes.feet import Feet, Tubes
from vasowave.imaging.axes.junctions import to_the_surface, with_ends_at_half_grey
from vasowave.imaging.axes.tubes import _own_wall, differences, strengths
from vasowave.imaging.lumen.segmentation import Segmentation
from vasowave.imaging.sections import across, carried, disc, medians, sampled, tangents
from vasowave.imaging.tree import Line, Tree

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


def test_an_end_without_three_points_of_surface_ahead_stays():
    line = axis(1.0)
    cap = np.array([[0.0, 0.0, 1.05], [0.0, 0.01, 1.05]])
    assert to_the_surface(line, cap) is line
    assert to_the_surface(line, np.vstack([cap, [[0.01, 0.0, 1.05]]])) is not line
    short = axis(0.04)
    assert to_the_surface(short, np.tile(cap, (3, 1))) is short


def cylinder(end, width=1.0, shape=(25, 25, 70), spacing=0.01, grey=100.0, background=20.0):
    """A lumen of radius 6 voxels along x whose grey falls over `width` voxels, to half at voxel `end`."""
    z, y, x = np.indices(shape)
    across_ = 1 / (1 + np.exp((np.hypot(z - 12, y - 12) - 6) / 0.5))
    along = 1 / (1 + np.exp((x - end) / width))
    level = background + (grey - background) * across_ * along
    return Segmentation(
        level > 60, level.astype(np.float32), np.zeros(3, int), spacing, np.zeros(3), 60.0, background, 1.0
    )


@pytest.mark.parametrize(("end", "moved"), [(50.3, 50.3), (48.6, 48.6), (52.7, 50.0), (46.0, 50.0)])
def test_an_end_moves_to_half_the_grey_of_its_own_vessel_by_two_voxels_at_most(end, moved):
    x = np.arange(10, 50.5, 1.0)
    line = Line(0.01 * np.column_stack([np.full(len(x), 12.0), np.full(len(x), 12.0), x]), np.full(len(x), 0.06))
    (found,) = with_ends_at_half_grey(Tree((line,), np.array([-1])), cylinder(end)).lines
    assert found.points[-1][2] / 0.01 == pytest.approx(moved, abs=0.1)
    assert (np.diff(found.run) > 0).all()


def test_differences_along_a_vessel_vanish_on_arcs_of_nodes_and_on_straight_radii():
    """Third differences of places are those of NumPy; of radii there are second and first ones, of fixed weights."""
    tubes = Tubes(RNG.normal(0, 1, (9, 3)), RNG.random(10), np.array([0, 1, 2, 3, 4, 4, 5, 6, 7, 8]),
                  np.array([0, 5, 10]), np.array([-1, 0]))  # fmt: skip
    kept = differences(tubes)
    values = kept.of(tubes.state)
    nodes = [tubes.nodes[tubes.place_nodes[:5]], tubes.nodes[tubes.place_nodes[5:]]]
    own = [tubes.radius[:5], tubes.radius[5:]]
    for vessel in range(2):
        of = kept.vessel == vessel
        places = np.isnan(kept.weight)
        assert sorted(values[of & places]) == pytest.approx(sorted(np.diff(nodes[vessel], 3, axis=0).ravel()))
        assert sorted(values[of & (kept.weight == 20.0)]) == pytest.approx(sorted(np.diff(own[vessel], 2)))
        assert sorted(values[of & (kept.weight == 0.05)]) == pytest.approx(sorted(np.diff(own[vessel])))
    assert len(values) == 2 * (2 * 3 + 3 + 4)
    spans = kept.window[:, 1] - kept.window[:, 0]
    assert np.array_equal(spans, np.where(np.isnan(kept.weight), 3, np.where(kept.weight == 20.0, 2, 1)))


def feet(place, share, vessel):
    count = len(place)
    return Feet(np.zeros(count), np.zeros((count, 3)), np.asarray(place), np.asarray(share, float), np.asarray(vessel),
                np.zeros(0, int))  # fmt: skip


def test_a_node_has_its_wall_by_the_points_on_it_over_radius_and_length():
    """Nodes 2 apart of radius 1, ends with half the length; 60 % of the nodes have less than what counts as all."""
    nodes = np.column_stack([np.zeros((5, 2)), 2.0 * np.arange(5)])
    tubes = Tubes(nodes, np.array([1.0, 1.0, 2.0, 1.0, 1.0]), np.arange(5), np.array([0, 5]), np.array([-1]))
    points = feet([0] * 4 + [1] * 4 + [2] * 8 + [3] * 2, [0.25] * 4 + [0.5] * 4 + [0.5] * 8 + [0.0] * 2, [0] * 18)
    count = np.array([3.0, 1 + 2, 2 + 4, 4 + 2, 0])
    density = count / (tubes.radius * np.array([1.0, 2, 2, 2, 1]))
    assert _own_wall(tubes, points) == pytest.approx(np.clip(density / np.quantile(density, 0.6), 0, 1))
    kept = differences(tubes)
    seen = _own_wall(tubes, points)
    bending = 4.0 + (0.35 - 4.0) * np.array([seen[:4].min(), seen[1:].min()])
    found = strengths(tubes, points, kept, 0.1)
    assert found[np.isnan(kept.weight)] == pytest.approx(np.tile(bending, 3) * 4)  # 18 / 5 points a node: at least 4
    assert found[kept.weight == 20.0] == pytest.approx(80.0)
    noisy = strengths(tubes, points, kept, 0.27)  # 1.5 times the limit: 0.35 · 1.5⁴
    bending = 4.0 + (0.35 * 1.5**4 - 4.0) * np.array([seen[:4].min(), seen[1:].min()])
    assert noisy[np.isnan(kept.weight)] == pytest.approx(np.tile(bending, 3) * 4)
    flooded = strengths(tubes, points, kept, 9.0)
    assert flooded[np.isnan(kept.weight)] == pytest.approx(16.0)


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


def test_depth_is_the_distance_to_the_surface(ways):
    inner = int(cKDTree(ways.voxels).query([7, 7, 14])[1])
    assert ways.depth[inner] == pytest.approx(np.hypot(2.5, 1.0))  # the nearest wall of a disc of voxels


def test_the_neighbors_of_a_voxel_are_the_26_around_it_with_their_distances():
    voxels = np.argwhere(np.ones((3, 3, 3), bool))
    cost, length = paths._neighbors(voxels, np.full(27, 2.0))
    middle = 13
    gaps = np.linalg.norm(voxels - voxels[middle], axis=1)
    row = length[[middle]].toarray()[0]
    assert np.delete(row, middle) == pytest.approx(np.delete(gaps, middle))
    assert length.nnz == 2 * (54 + 72 + 32)  # faces, edges and corners of 3 x 3 x 3 voxels
    assert cost[[middle]].toarray()[0] == pytest.approx(row / 2.0**8)
    low, _ = paths._neighbors(voxels, np.full(27, 0.05))
    assert low[[middle]].toarray()[0] == pytest.approx(row / 0.2**8)  # nothing is shallower than a fifth of a voxel


def test_long_tips_are_the_ends_of_the_tube_and_of_the_spur_and_nothing_else(ways):
    tips = ways.voxels[paths.long_tips(ways)]
    assert len(tips) == 2
    assert np.abs(tips[0] - [7, 44, 48]).max() <= 4
    assert np.abs(tips[1] - [7, 30, 24]).max() <= 4


def test_an_outlet_away_from_the_lumen_or_on_the_way_to_another_is_named(ways):
    ends = 0.01 * np.array([[7.0, 44, 48], [7, 30, 24]])
    assert len(paths.outlet_tips(ways, ends)) == 2
    paths.outlet_tips(ways, 0.01 * np.array([[7.0, 49.0, 48]]))  # five voxels beyond
    with pytest.raises(InputError, match=r"outlet .* was not reached: 6 voxels from the lumen"):
        paths.outlet_tips(ways, 0.01 * np.array([[7.0, 50.0, 48]]))
    middle = ways.points[ways.above[paths.outlet_tips(ways, ends[:1])[0]]]
    with pytest.raises(InputError, match="the vessel goes on to another outlet"):
        paths.outlet_tips(ways, np.array([ends[0], middle]))
    with pytest.raises(InputError, match="the vessel goes on to another outlet"):
        paths.outlet_tips(ways, np.array([ends[0], ends[0]]))
    with pytest.raises(InputError, match=r"root .* was not reached"):
        paths.minimal_paths(bent_lumen(), 0.01 * np.array([7.0, 7.0, -3.0]))


def test_the_end_of_a_vessel_is_two_radii_of_the_widest_ball_near_it(ways):
    tip = int(cKDTree(ways.voxels).query([7, 44, 48])[1])
    inside = paths.end_around(ways, tip)
    away = np.linalg.norm(ways.voxels - ways.voxels[tip], axis=1)
    wide = ways.depth[away <= 1.5 * ways.depth].max(initial=ways.depth[tip])
    assert np.array_equal(inside, away < 2 * wide)


def test_directions_discs_and_medians_of_sections():
    points = np.column_stack([np.zeros(9), np.arange(9.0), np.arange(9.0) ** 2])
    found = tangents(points)
    for row in range(9):
        along = points[min(row + 3, 8)] - points[max(row - 3, 0)]
        assert found[row] == pytest.approx(along / np.linalg.norm(along))
    u, v = across(found)
    for pair in (u * found, v * found, u * v):
        assert pair.sum(axis=1) == pytest.approx(0.0, abs=1e-12)
    assert np.linalg.norm(u, axis=1) == pytest.approx(1.0)
    kept, _ = carried(found)
    turns = np.arccos(np.clip((kept[1:] * kept[:-1]).sum(axis=1), -1, 1))
    bends = np.arccos(np.clip((found[1:] * found[:-1]).sum(axis=1), -1, 1))
    assert (turns <= bends + 1e-6).all()
    grid = disc(1.0, 0.5)
    assert len(grid) == 13  # of the grid of half a radius, its edge too
    assert np.hypot(*grid.T).max() == 1.0
    values, chosen = RNG.normal(0, 1, (6, 8)), RNG.random((6, 8)) < 0.6
    chosen[:, 0] = True
    assert medians(values, chosen) == pytest.approx(
        [np.median(row[own]) for row, own in zip(values, chosen, strict=True)]
    )
    grey = RNG.random((3, 3, 3)).astype(np.float32)
    places = np.array([[0.1, 0.1, 0.15]])
    assert sampled(grey, places, np.zeros(3), 0.1) == pytest.approx([(grey[1, 1, 1] + grey[1, 1, 2]) / 2])
