"""The compiled loops of images against other ways to the same: SciPy's filters and labels, sums over all pairs."""

import numpy as np
import pytest
from scipy import ndimage

from vasowave.lung import ahead_of, encloses, in_tube, summed_on_pieces
from vasowave.lung.lumen import smoothed

RNG = np.random.default_rng(5)


@pytest.mark.parametrize(("width", "shape"), [(0.7, (5, 6, 7)), (1.5, (9, 4, 11)), (2.0, (3, 8, 2))])
def test_smoothing_is_that_of_scipy_to_the_last_bit(width, shape):
    """Also where the kernel is wider than the image, which goes on as its mirror image."""
    grey = RNG.normal(100.0, 30.0, shape).astype(np.float32)
    expected = ndimage.gaussian_filter(grey, width, mode="reflect", truncate=3.0, output=np.float32)
    assert np.array_equal(smoothed(grey, width), expected)


def test_what_is_enclosed_is_what_labels_of_the_rest_say():
    """A connected piece grown at random: it encloses something if what is not its own falls into several pieces."""
    told = []
    for seed in range(40):
        noise = np.random.default_rng(seed).random((6, 6, 6)) < 0.62
        labels, _ = ndimage.label(noise, np.ones((3, 3, 3)))
        largest = labels == 1 + np.argmax(np.bincount(labels.ravel())[1:])
        mask = np.pad(largest, 1)
        _, pieces = ndimage.label(~mask)
        assert encloses(mask) == (pieces > 1)
        told.append(pieces > 1)
    assert 10 < sum(told) < 40


def test_a_place_is_in_a_tube_if_its_nearest_point_reaches_it():
    points, reach = RNG.normal(0, 1.0, (30, 3)), RNG.uniform(0.1, 1.2, 30)
    middles = RNG.normal(0, 1.5, (12, 3))
    places = middles[:, None] + RNG.normal(0, 0.5, (12, 25, 3))
    gaps = np.linalg.norm(places[:, :, None] - points, axis=3)
    nearest = gaps.argmin(axis=2)
    expected = gaps.min(axis=2) < reach[nearest]
    assert 20 < expected.sum() < 250
    assert np.array_equal(in_tube(places, middles, points, reach), expected)


def test_points_ahead_lie_in_a_cylinder_that_begins_and_ends_where_it_says():
    points, place = RNG.uniform(-2, 2, (400, 3)), np.array([0.1, -0.2, 0.3])
    axis = np.array([1.0, 2.0, -2.0]) / 3
    ahead = (points - place) @ axis
    aside = np.linalg.norm(points - place - ahead[:, None] * axis, axis=1)
    expected = ahead[(ahead > 0) & (ahead < 1.2) & (aside < 0.9)]
    assert len(expected) > 10
    assert ahead_of(points, place, axis, 1.2, 0.9) == pytest.approx(expected)
    on_edges = np.array([[0.0, 0, 0], [0, 0, 1.2], [0, 0.9, 0.5], [0, 0.899, 0.5], [0, 0, 1.199]])
    found = ahead_of(on_edges, np.zeros(3), np.array([0.0, 0, 1]), 1.2, 0.9)
    assert found == pytest.approx([0.5, 1.199])


def test_sums_on_pieces_are_those_of_the_derivatives_of_each_gap():
    """A gap falls as a node moves along the normal, by its share, and as its radius grows, by the same."""
    count, places = 30, 5
    place, share = RNG.integers(0, places - 1, count), RNG.random(count)
    normal, gap, weight = RNG.normal(0, 1, (count, 3)), RNG.normal(0, 1, count), RNG.random(count)
    change = np.concatenate([-(1 - share)[:, None] * normal, -share[:, None] * normal,
                             -(1 - share)[:, None], -share[:, None]], axis=1)  # fmt: skip
    squares, pull = summed_on_pieces(place, normal, share, gap, weight, places)
    for one in range(places):
        own = place == one
        assert squares[one] == pytest.approx(np.einsum("f,fi,fj->ij", weight[own], change[own], change[own]), abs=1e-12)
        assert pull[one] == pytest.approx(-np.einsum("f,fi,f->i", weight[own], change[own], gap[own]), abs=1e-12)
