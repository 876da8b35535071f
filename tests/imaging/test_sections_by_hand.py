"""What sections of vessels say, and what sticks out of tubes, from profiles and lines that are made by hand."""

import numpy as np
import pytest
from made_tree import forked_tree, straight
from scipy.stats import theilslopes

from vasowave.imaging.axes import protrusions, starts
from vasowave.imaging.measure.contrast import _line, blur_of, contrasts, own_contrast
from vasowave.imaging.measure.evening import _pooled, evened_sections, moderated
from vasowave.imaging.measure.profiles import Profile
from vasowave.imaging.tree import Line, Tree, clear_stretch, free_stretch

RNG = np.random.default_rng(8)


def profile(signal, plateau, slope=1.0, run=None, noise=1.0):
    signal, plateau = np.atleast_1d(np.asarray(signal, float)), np.atleast_1d(np.asarray(plateau, float))
    along = np.arange(len(signal)) * 0.01 if run is None else np.asarray(run, float)
    return Profile(signal, plateau, np.ones(2), slope, along, np.arange(len(signal)), noise)


def seen(contrast, radius, blur, count=12):
    """Sections of a round vessel behind a Gaussian blur: its axis shows 1 - exp(-r²/2σ²) of its contrast."""
    plateau = contrast * (1 - np.exp(-(radius**2) / (2 * blur**2)))
    return profile(np.full(count, np.pi * contrast * radius**2), np.full(count, plateau))


@pytest.mark.parametrize("radius", [1.5, 2.5, 4.0])
def test_a_vessel_shows_its_contrast_through_the_blur_and_is_the_surer_the_wider(radius):
    contrast, error = own_contrast(seen(100.0, radius, 0.9), 0.9)
    lost = np.exp(-(radius**2) / (2 * 0.9**2))
    assert contrast == pytest.approx(100.0, rel=1e-3)
    assert error == pytest.approx(np.hypot(lost, 0.01) * contrast, rel=2e-3)


def test_scatter_of_the_middle_counts_over_a_third_of_the_sections():
    one = seen(100.0, 9.0, 0.9, 12)
    scattered = profile(one.signal, one.plateau + np.tile([3.0, -3.0], 6))
    assert own_contrast(scattered, 0.9)[1] == pytest.approx(np.hypot(3 / np.sqrt(4), 1.0), rel=1e-6)
    few = profile(one.signal[:2], one.plateau[:2] + np.array([3.0, -3.0]))
    assert own_contrast(few, 0.9)[1] == pytest.approx(np.hypot(3.0, 1.0), rel=1e-6)


def test_a_middle_that_shows_next_to_nothing_is_taken_for_a_twentieth():
    contrast, error = own_contrast(profile([1e-9], [5.0]), 0.9)
    assert contrast == pytest.approx(100.0, rel=1e-4)
    assert error == pytest.approx(0.95 * contrast, rel=1e-3)


def test_blur_is_the_least_that_a_wide_vessel_shows_at_its_steepest():
    """A wall of contrast C falls by C/(σ√2π) at its steepest."""
    wall = [profile([1.0], [100.0], 100 / (sigma * np.sqrt(2 * np.pi))) for sigma in (2.0, 1.4, 0.7)]
    assert blur_of(wall, np.array([3.6, 3.6, 3.4]), 1.0) == pytest.approx(1.4)
    assert blur_of([*wall[:2], None, profile([1.0], [1.0], 0.0)], np.full(4, 0.36), 0.1) == pytest.approx(1.4)
    assert blur_of(wall, np.full(3, 3.5), 1.0) == 0.9
    assert blur_of(wall, np.full(3, 0.5), 0.2) == pytest.approx(0.18)


def test_vessels_of_one_contrast_have_the_mean_and_are_known_by_it():
    vessels = [seen(100.0, radius, 0.9) for radius in (3.0, 4.0, 5.0)]
    error = np.array([own_contrast(one, 0.9)[1] for one in vessels])
    found, sd = contrasts([*vessels, None], np.array([0.0, 1.0, 2.0, 3.0]), 0.9)
    assert found == pytest.approx(100.0, rel=1e-4)
    common = 1 / np.sum(1 / error**2)
    assert sd[:3] == pytest.approx(np.sqrt(1 / (1 / error**2 + 1 / common)), rel=1e-6)
    assert sd[3] == pytest.approx(np.sqrt(common), rel=1e-6)


def test_a_contrast_that_falls_along_the_way_is_told_where_a_vessel_shows_none():
    way = np.arange(6.0)
    value, error = 100 - 5 * way, np.full(6, 1.0)
    line, between = _line(value, error, way)
    at, known = line(np.array([10.0]))
    assert at == pytest.approx([50.0])
    assert between == 0
    spread = 1 / 6 + (10 - 2.5) ** 2 / np.sum((way - 2.5) ** 2)
    assert known == pytest.approx([np.sqrt(spread)])
    flat, _ = _line(value[:3], error[:3], way[:3])  # three tell no slope
    assert flat(np.array([10.0]))[0] == pytest.approx([95.0])
    unsure, _ = _line(value, np.full(6, 11.0), way)  # 5 is below two standard errors, 5.3
    assert unsure(np.array([10.0]))[0] == pytest.approx([87.5])


def test_what_vessels_differ_beyond_their_errors_makes_their_squares_as_many_as_their_freedom():
    """Paule and Mandel's own condition, around the weighted mean."""
    value, error = np.array([100.0, 120.0, 85.0]), np.array([2.0, 1.0, 3.0])
    _, between = _line(value, error, np.arange(3.0))
    weight = 1 / (error**2 + between)
    mean = weight @ value / weight.sum()
    assert weight @ (value - mean) ** 2 == pytest.approx(2.0, rel=1e-3)


def test_vessels_that_differ_are_believed_by_their_own_errors_and_the_trees_spread():
    vessels = [seen(contrast, 6.0, 0.9) for contrast in (80.0, 120.0, 100.0, 140.0)]
    own = np.array([own_contrast(one, 0.9) for one in vessels])
    way = np.zeros(4)
    found, sd = contrasts(vessels, way, 0.9)
    line, between = _line(own[:, 0], own[:, 1], way)
    trend, trend_error = line(way)
    prior = 1 / (between + trend_error**2)
    trusted = 1 / own[:, 1] ** 2
    assert found == pytest.approx((own[:, 0] * trusted + trend * prior) / (trusted + prior))
    assert sd == pytest.approx((trusted + prior) ** -0.5)
    lacking, _ = contrasts([None, profile([1.0], [-1.0])], np.zeros(2), 0.9)
    assert np.isnan(lacking).all()


def test_sections_of_a_vessel_that_narrows_are_carried_to_its_middle():
    run = np.linspace(0.2, 1.0, 9)
    width = 3.0 - 1.0 * run
    found = evened_sections(profile(width**2, np.ones(9), run=run), 0.9)
    assert np.sqrt(found.sections.signal) == pytest.approx(2.1)
    assert found.taper == pytest.approx(1 / 2.1)
    assert (found.error, found.taper_sd) == pytest.approx((0.0, 0.0), abs=1e-9)


def test_a_slope_counts_beyond_three_standard_errors_of_a_third_of_the_sections():
    """Against the slope of Theil and Sen by SciPy."""
    run = np.linspace(0.0, 1.0, 12)
    width = 3.0 - 0.8 * run + 0.05 * RNG.standard_normal(12)
    found = evened_sections(profile(width**2, np.ones(12), run=run), 0.7)
    slope = theilslopes(width, run)[0]
    rest = width - slope * run
    error = np.std(rest) / (np.std(run) * np.sqrt(12 / 3))
    at_middle = np.median(rest) + slope * 0.7
    assert (found.taper, found.taper_sd) == pytest.approx((-slope / at_middle, error / at_middle))
    kept = slope * (1 - (3 * error / slope) ** 2)
    line = np.median(width - kept * run) + kept * np.append(run, 0.7)
    assert found.sections.signal == pytest.approx(width**2 * (line[-1] / line[:-1]) ** 2)
    assert found.error == pytest.approx(0.2 * error / line[-1])
    level = 3.0 + 0.05 * RNG.standard_normal(12)
    same = evened_sections(profile(level**2, np.ones(12), run=run), 0.7)
    assert same.sections.signal == pytest.approx(level**2)


def test_few_sections_or_sections_at_one_place_are_left_as_they_are():
    run = np.linspace(0, 1, 5)
    one = profile((3 - run) ** 2, np.ones(5), run=run)
    assert evened_sections(one, 0.5).taper == pytest.approx(1 / 2.5)
    few = profile((3 - run[:4]) ** 2, np.ones(4), run=run[:4])
    for other in (few, profile(np.arange(1.0, 6), np.ones(5), run=np.ones(5))):
        found = evened_sections(other, 0.5)
        assert found.sections is other
        assert np.isnan(found.taper)
        assert found.error == 0
    beyond = evened_sections(one, 3.5)  # where the line has no width
    assert (beyond.sections is one, beyond.error) == (True, 0.0)


def test_a_vessels_own_scatter_and_what_its_noise_lets_expect_weigh_by_their_numbers():
    """Six sections' worth of what all vessels show, beside as many as it has of its own."""
    own, expected, count = np.array([2.0, 9.0, np.nan]), np.array([1.0, 3.0, 2.0]), np.array([4.0, 12.0, 5.0])
    usual = np.median([2.0, 3.0]) * expected
    found = _pooled(own, expected, count)
    assert found[0] == pytest.approx(np.sqrt((6 * usual[0] ** 2 + 4 * 4) / 10))
    assert found[1] == pytest.approx(np.sqrt((6 * usual[1] ** 2 + 12 * 81) / 18))
    assert found[2] == pytest.approx(usual[2])
    assert np.isnan(_pooled(np.full(2, np.nan), np.ones(2), np.ones(2))).all()


def test_the_larger_of_the_errors_along_and_beside_a_vessel_counts():
    one = profile(100 + np.tile([2.0, -2.0, 0.0], 4), np.ones(12), noise=1.0)  # four independent sections
    scatter = np.std(one.signal) / np.sqrt(4)
    assert moderated([one], np.array([np.nan])) == pytest.approx([scatter])
    assert moderated([one], np.array([0.1])) == pytest.approx([scatter])
    assert moderated([one], np.array([5.0])) == pytest.approx([5.0])
    alone = moderated([profile([1.0, 2.0], [1.0, 1.0])], np.array([np.nan]))
    assert alone == pytest.approx([0.5])


def test_only_the_highest_of_tips_that_stand_close_is_a_vessel():
    points = np.array([[0.0, 0, 0], [0, 0, 1.0], [0, 0, 2.1], [0, 0, 9.0]])
    height, reach = np.array([1.0, 3.0, 2.0, 0.5]), np.array([1.0, 1.0, 1.0, 1.0])
    assert protrusions._highest([0, 1, 2, 3], points, height, reach) == [1, 2, 3]
    assert protrusions._highest([0, 1, 2, 3], points, height, np.array([1.0, 1.0, 1.2, 1.0])) == [1, 3]


def test_a_vessel_exceeds_its_tube_by_the_middle_of_at_least_ten_stations():
    assert protrusions._outline(np.append(np.full(19, -np.inf), np.full(19, 2.0))) == 0.0
    assert protrusions._outline(np.append(np.linspace(0, 4, 21), -np.inf)) == 2.0
    assert protrusions._outline(np.full(20, 1.5)) == 1.5


def test_heights_count_from_the_wall_of_the_nearest_vessel_prolonged_beyond_its_ends():
    line = Line(np.column_stack([np.zeros((61, 2)), 0.01 * np.arange(61)]), np.full(61, 0.05))
    tree = Tree((line,), np.array([-1]))
    places = np.array([[0.0, 0.08, 0.3], [0.02, 0.0, 0.2], [0.0, 0.0, 0.60 + 0.075], [0.0, 0.06, -0.05]])
    height, wide = protrusions.height_outside(tree, places, 0.01, 10.0)
    assert height == pytest.approx([3.0, -3.0, -5.0, 1.0], abs=1e-6)
    assert wide == pytest.approx(5.0)
    assert protrusions._stub_radius(Line(line.points, np.append(np.full(30, 9.0), np.full(31, 2.0)))) == 2.0


def test_arcs_and_short_axes_keep_their_places_and_bumps_go():
    arc = np.column_stack([np.arange(40.0), 0.01 * np.arange(40.0) ** 2, np.zeros(40)])
    assert protrusions._calm(arc) == pytest.approx(arc, abs=1e-6)
    bump = arc.copy()
    bump[20, 2] = 1.0
    assert np.abs(protrusions._calm(bump)[:, 2]).max() < 0.2
    assert protrusions._calm(arc[:3]) is not None
    rough = RNG.normal(0, 1, (4, 3))
    assert np.abs(np.diff(protrusions._calm(rough), 3, axis=0)).max() < np.abs(np.diff(rough, 3, axis=0)).max() / 1000


def test_a_prolonged_tube_has_a_radius_and_a_half_more():
    axis, radius = np.column_stack([np.zeros((9, 2)), np.arange(9.0)]), np.full(9, 4.0)
    longer, wide = protrusions._prolonged(axis, radius, 1.0)
    assert longer[:, 2].tolist() == list(range(16))  # 6 steps and one, to be sure
    assert wide.tolist() == [4.0] * 16


def fork():
    """A parent along x, 2 cm, and two daughters of 1 cm from its end; radii 0.1, points 0.05 cm apart."""
    return (straight((0, 0, 0), (2, 0, 0), 0.1, 41), straight((2, 0, 0), (2.8, 0.6, 0), 0.1, 21),
            straight((2, 0, 0), (2.8, -0.6, 0), 0.05, 21))  # fmt: skip


def test_arms_reach_five_radii_and_at_most_three_fifths_of_their_vessel():
    tree = Tree(fork(), np.array([-1, 0, 0]))
    assert starts._cuts(tree, [0, 1, 2]) == [slice(30, 41), slice(0, 10), slice(0, 10)]  # half a cm each
    short = Tree((straight((0, 0, 0), (0.5, 0, 0), 0.1, 11), *fork()[1:]), np.array([-1, 0, 0]))
    assert starts._cuts(short, [0, 1, 2])[0] == slice(4, 11)  # 0.3 cm of 0.5
    few = Tree((straight((0, 0, 0), (2, 0, 0), 0.1, 5), straight((2, 0, 0), (3, 0, 0), 0.1, 5)), np.array([-1, 0]))
    assert starts._cuts(few, [0, 1]) == [slice(0, 5), slice(0, 5)]


def test_a_junction_nearer_to_the_root_gives_the_stretch_beyond_to_the_daughters():
    parent, one, other = starts._earlier(fork(), 0.1)
    assert parent.length == pytest.approx(1.85)  # one and a half radii before
    assert one.length == pytest.approx(1.15)
    assert one.points[0] == pytest.approx(parent.points[-1])
    assert (len(one), len(other)) == (24, 24)
    far, *_ = starts._earlier(fork(), 9.0)
    assert far.length == pytest.approx(1.2)  # two fifths of the arm


def test_a_junction_along_a_daughter_takes_its_beginning_and_leads_the_sisters_to_it():
    parent, one, other = starts._later(fork(), 1, 0.1)
    assert parent.length == pytest.approx(2.15)
    assert one.length == pytest.approx(0.85)
    assert other.points[0] == pytest.approx(parent.points[-1])
    assert other.points[-1] == pytest.approx(fork()[2].points[-1])
    kept = fork()[2].run >= 0.15
    assert other.points[-kept.sum() :] == pytest.approx(fork()[2].points[kept])
    gap = np.linalg.norm(fork()[2].points[kept][0] - parent.points[-1])
    assert len(other) - kept.sum() == max(2, int(gap / 0.05))
    far = starts._later(fork(), 1, 9.0)
    assert far[0].length == pytest.approx(2.425, abs=0.026)  # two fifths of the arm, to the next point


def test_halves_of_two_lines_join_where_they_are_nearest():
    begin, end = fork()[0], Line(fork()[0].points + np.array([0, 0.01, 0]), np.full(41, 0.2))
    joined = starts._halves(begin, end)
    assert np.array_equal(joined.points[:21], begin.points[:21])
    assert np.array_equal(joined.points[21:], end.points[21:])
    assert starts._halves(begin, begin) is begin


def test_free_stretches_leave_balls_ends_and_the_tubes_of_sisters():
    tree = forked_tree()
    assert free_stretch(tree.lines[0], False) == pytest.approx((0.1, 0.9))
    narrowing = Line(tree.lines[0].points, np.linspace(0.3, 0.03, 41))
    assert free_stretch(narrowing, False) == pytest.approx((0.3, 0.97))
    assert free_stretch(narrowing, True) == pytest.approx((0.3, 1 - np.median(narrowing.radius[13:])))
    free = free_stretch(tree.lines[2], True)
    begin, end = clear_stretch(tree, 2, free)  # at right angles to a sister of 0.08: nearer than 0.08 + 0.025
    run = tree.lines[2].run
    assert begin == pytest.approx(run[run >= 0.105][0], abs=1e-9)
    assert end == free[1]
    beside = Tree((tree.lines[0], tree.lines[1], tree.lines[1]), np.array([-1, 0, 0]))
    assert clear_stretch(beside, 1, (0.0, 1.0))[0] == pytest.approx(tree.lines[1].length / 2)
