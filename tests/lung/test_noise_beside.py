"""The error of a radius: noise that all sections of a vessel share, and sections that reach far enough."""

import numpy as np
import pytest
from test_topology import oblique_tube

from vasowave.lung import Line, Tree
from vasowave.lung.measure import DISC, RING, densitometry, signal_beside
from vasowave.lung.read import Volume

VOXEL, RADIUS = 0.01, 0.03


def beside(grey):
    """The SD of the mean signal of 30 sections of a vessel along x in the middle of `grey`."""
    run = np.arange(10, 40) * VOXEL
    middle = np.array(grey.shape[:2]) // 2 * VOXEL
    line = Line(np.column_stack([np.full(30, middle[0]), np.full(30, middle[1]), run]), np.full(30, RADIUS))
    return signal_beside(line, np.arange(30), RADIUS, Volume(grey, np.full(3, VOXEL), np.zeros(3)), line)


def test_noise_that_runs_along_a_vessel_is_not_averaged_away_over_its_sections():
    rng, drawn = np.random.default_rng(4), 12
    noise = rng.normal(0, 6, (drawn, 64, 64, 1))
    striped = [beside(np.repeat(one, 50, axis=2)) for one in noise]
    grained = [beside(rng.normal(0, 6, (64, 64, 50))) for _ in range(drawn)]
    # Of independent voxels: the disc's own noise, and that of the median of the ring, π/2 as much as of a mean.
    inner, outer = RADIUS / VOXEL + DISC, RADIUS / VOXEL + RING
    count, ring = np.pi * inner**2, np.pi * (outer**2 - inner**2)
    one_section = 6 * VOXEL**2 * np.sqrt(count + np.pi / 2 * count**2 / ring)
    assert np.mean(striped) == pytest.approx(one_section, rel=0.15)
    assert np.mean(grained) == pytest.approx(one_section / np.sqrt(15), rel=0.25)  # every second section of 30


def test_noise_beside_a_vessel_is_not_known_where_there_is_no_room():
    assert np.isnan(beside(np.random.default_rng(5).normal(0, 6, (16, 16, 50))))


@pytest.mark.parametrize("share", [0.8, 1.1])
def test_the_radius_by_grey_level_does_not_follow_the_inscribed_one_in_a_blurred_image(share):
    volume, points, _ = oblique_tube(RADIUS, VOXEL, np.random.default_rng(1), noise=0)
    inside = points[8:-8]
    found = []
    for inscribed in (RADIUS, share * RADIUS):
        tree = Tree((Line(inside, np.full(len(inside), inscribed)),), np.array([-1]))
        found.append(densitometry(tree, volume, np.array([inscribed])).radius[0])
    assert found[1] == pytest.approx(found[0], rel=0.005)
