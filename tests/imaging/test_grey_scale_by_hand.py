"""Scales of grey, tapers and frames from numbers that are made by hand."""

import numpy as np
import pytest
from made_tree import straight

from vasowave.imaging import Volume
from vasowave.imaging.measure import grey_scale
from vasowave.imaging.measure.grey_scale import GreyScale, _rings, _smooth, corrected
from vasowave.imaging.measure.measurement import _fit
from vasowave.imaging.places import Frame
from vasowave.imaging.tree import Line, Tree

RNG = np.random.default_rng(12)
LEVEL = np.linspace(10.0, 110.0, 17)


def test_bend_and_flatness_of_a_scale():
    """A parabola 16 % above the line in the middle; noise that grows tenfold is ten times as steep there."""
    share = (LEVEL - 10) / 100
    one = GreyScale(LEVEL, LEVEL - 64 * share * (1 - share), np.full(17, 2.0))
    assert one.bend == pytest.approx(0.16)
    assert GreyScale(LEVEL, LEVEL + 64 * share * (1 - share), np.full(17, 2.0)).bend == pytest.approx(-0.16)
    assert one.flatness == pytest.approx(1.0)
    noise = 1.0 + share
    steep = GreyScale(LEVEL, LEVEL, noise)
    assert steep.flatness == pytest.approx(np.log(2), rel=2e-3)  # ∫ ds/(1 + s) over the unit interval
    assert GreyScale(LEVEL, LEVEL, noise[::-1]).flatness == pytest.approx(np.log(2), rel=2e-3)
    assert len(one.pairs) == grey_scale.KNOTS
    assert one.pairs[0] == (10.0, 10.0)
    assert one.pairs[4] == pytest.approx((60.0, 44.0))


def test_a_corrected_image_is_straight_between_pairs_and_beyond_them():
    grey = np.array([0.0, 5, 10, 15, 20, 30, 40]).repeat(27).reshape(7, 3, 9)
    pairs = ((10.0, 10.0), (20.0, 30.0), (30.0, 32.0))
    found = corrected(Volume(grey, np.ones(3), np.zeros(3)), pairs).grey[:, 0, 0]
    assert found == pytest.approx([-10.0, 0.0, 10.0, 20.0, 30.0, 32.0, 34.0])


def test_the_smooth_curve_is_a_cubic_that_outliers_hardly_move():
    level = RNG.uniform(0, 1, 300)
    value = 1 + level - 2 * level**2 + level**3
    at = np.linspace(0.0, 1.0, 9)
    expected = 1 + at - 2 * at**2 + at**3
    assert _smooth(level, value, np.ones(300), at) == pytest.approx(expected, abs=1e-9)
    spoiled = value + 0.01 * RNG.standard_normal(300)
    spoiled[::10] += 3.0
    assert _smooth(level, spoiled, np.ones(300), at) == pytest.approx(expected, abs=0.02)
    weight = np.where(level < 0.5, 1.0, 1e-9)
    half = np.where(level < 0.5, 2.0, 7.0)
    assert _smooth(level, half, weight, at)[:4] == pytest.approx(2.0, abs=1e-3)


def test_rings_show_the_noise_at_their_level():
    """A tube along x whose grey falls with the distance from its axis, and noise of 3 everywhere."""
    z, y, _ = np.indices((41, 41, 90))
    away = np.hypot(z - 20, y - 20)
    clean = 100.0 - 2.0 * away
    volume = Volume(clean + RNG.normal(0, 3.0, clean.shape), np.full(3, 0.01), np.zeros(3))
    points = np.column_stack([np.full(81, 0.2), np.full(81, 0.2), 0.01 * np.arange(5, 86)])
    tree = Tree((Line(points, np.full(81, 0.05)),), np.array([-1]))
    level, noise, count = _rings(tree, 0, (0.1, 0.7), volume)
    assert len(level) > 10
    assert np.median(noise) == pytest.approx(3.0 * 0.72, rel=0.1)  # of 1, 1/√2 and 1/2 between voxels
    assert level[0] == pytest.approx(100.0, abs=2.0)
    assert level[-1] == pytest.approx(100 - 2 * 9.5, abs=2.0)
    assert (np.diff(level) < 1.0).all()
    assert count.min() >= grey_scale.SAMPLES
    short = Tree((tree.lines[0][:20],), np.array([-1]))
    assert _rings(short, 0, (0.1, 0.12), volume).shape == (3, 0)
    crossed = Tree((tree.lines[0], Line(points + np.array([0.09, 0, 0]), np.full(81, 0.02))), np.array([-1, 0]))
    assert _rings(crossed, 0, (0.1, 0.7), volume)[2].sum() < count.sum()


def test_a_taper_is_the_slope_of_a_line_over_as_many_radii_as_fit():
    line = straight((0, 0, 0), (2, 0, 0), 0.1, 41)
    narrowing = Line(line.points, 0.2 - 0.05 * line.run)
    slope, error, first, last = _fit(narrowing, 0.2, 1.8)
    assert (slope, first, last) == pytest.approx((0.05, 0.2, 0.1))
    assert error == pytest.approx(0.0, abs=1e-9)
    rough = Line(line.points, narrowing.radius + 0.01 * RNG.standard_normal(41))
    slope, error, *_ = _fit(rough, 0.2, 1.8)
    free = (line.run > 0.2) & (line.run < 1.8)
    own, at = np.polyfit(line.run[free], rough.radius[free], 1)
    left = np.std(rough.radius[free] - at - own * line.run[free])
    independent = np.ptp(line.run[free]) / rough.typical_radius
    assert (slope, error) == pytest.approx((-own, left / (np.std(line.run[free]) * np.sqrt(independent))))
    assert np.isfinite(_fit(line, 0.49, 0.81)[0])  # 0.3 cm are three radii
    assert np.isnan(_fit(line, 0.51, 0.79)).all()
    few = straight((0, 0, 0), (2, 0, 0), 0.1, 6)
    assert np.isnan(_fit(few, 0.1, 1.9)).all()  # four points
    assert np.isfinite(_fit(straight((0, 0, 0), (2, 0, 0), 0.1, 7), 0.1, 1.9)[0])


def test_a_frame_turns_about_the_first_voxel_and_back():
    turn = np.array([[1.0, 0, 0], [0, 0, -1], [0, 1, 0]])
    frame = Frame(np.array([1.0, 2, 3]), turn)
    assert frame.world([1.0, 2, 3]) == pytest.approx([1, 2, 3])
    assert frame.world([1.0, 3, 3]) == pytest.approx([1, 2, 4])
    points = RNG.normal(0, 1, (4, 3))
    assert frame.own(frame.world(points)) == pytest.approx(points)
    plain = Frame(np.array([1.0, 2, 3]), np.eye(3))
    assert np.array_equal(plain.world(points), points)
