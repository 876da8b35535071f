"""Contrasts, radii of sections, parts and sizes of a measured tree, from sections whose numbers are made."""

import warnings
from dataclasses import replace

import numpy as np
import pytest
from made_tree import forked_tree, straight

from vasowave.errors import InputError, VasowaveWarning
from vasowave.imaging.measure.contrast import BLUR, WIDE, _left, _line, blur_of, contrasts, own_contrast
from vasowave.imaging.measure.evening import Evened, evened_sections
from vasowave.imaging.measure.measurement import closes, filled_at, measured_alone, taper, with_errors
from vasowave.imaging.measure.profiles import Profile
from vasowave.imaging.measure.radii import (
    MODEL,
    WIDEST,
    WINDOW,
    Densitometry,
    _measured,
    _neighbors,
    _profile,
    _ways,
    densitometric_radius,
    windows,
)
from vasowave.imaging.revise.parts import (
    check_wishes,
    first_generations,
    largest_vessels,
    part_of,
    scaled,
    wanted_part,
    wider_than,
)
from vasowave.imaging.tree import Line, Tree

TREE = forked_tree()


def said(function, *given):
    with pytest.raises(InputError) as error:
        function(*given)
    return str(error.value)


def sections(signal, plateau=50.0, slope=1000.0, run=None, spread=(0.01, 0.005)):
    signal = np.asarray(signal, float)
    count = len(signal)
    run = np.linspace(0.1, 1.0, count) if run is None else np.asarray(run, float)
    return Profile(signal, np.full(count, plateau) if np.isscalar(plateau) else np.asarray(plateau, float),
                   np.array(spread), slope, run, np.arange(count), 0.1)  # fmt: skip


def test_blur_is_that_of_the_steepest_wall_of_a_wide_vessel():
    """A wall of contrast 50 that falls by 1000 a cm has an SD of 50/(1000 √(2π)) cm."""
    spacing = 0.01
    wide = np.array([1.01 * WIDE * spacing, 1.01 * WIDE * spacing, 0.99 * WIDE * spacing, 1.0, 1.0])
    profiles = [sections([1.0] * 4), sections([1.0] * 4, 80.0, 2000.0), sections([1.0] * 4, 1.0), None,
                sections([1.0] * 4, slope=0.0)]  # fmt: skip
    assert blur_of(profiles, wide, spacing) == pytest.approx(40 / (1000 * np.sqrt(2 * np.pi)))
    assert blur_of(profiles[2:], wide[2:], spacing) == pytest.approx(BLUR * spacing)


def test_a_vessels_own_contrast_is_what_blur_took_a_share_of():
    """A round vessel of r = 0.03 and contrast 80 with a blur of 0.02: the middle shows 1 - exp(-r²/2σ²) of it."""
    share = 1 - np.exp(-(0.03**2) / (2 * 0.02**2))
    assert _left(80 * np.pi * 0.03**2, 80.0, 0.02) == pytest.approx(share)
    assert _left(1e-9, 80.0, 0.02) == 0.05
    found, error = own_contrast(sections([80 * np.pi * 0.03**2] * 9, 80 * share), 0.02)
    assert found == pytest.approx(80.0, rel=2e-3)
    assert error > 0
    noisy = own_contrast(sections([80 * np.pi * 0.3**2] * 9, 80 + 3.0 * (-1.0) ** np.arange(9)), 0.02)[1]
    assert noisy == pytest.approx(
        np.hypot(np.std(3.0 * (-1.0) ** np.arange(9)) / np.sqrt(3), error_of_wide()), rel=1e-6
    )


def error_of_wide():
    """Return the error of the same contrast without noise, which the plateau of nine sections has a mean of."""
    mean = np.mean(80 + 3.0 * (-1.0) ** np.arange(9))
    return own_contrast(sections([80 * np.pi * 0.3**2] * 9, mean), 0.02)[1]


def test_contrasts_of_an_even_tree_are_one_and_of_thinning_agent_a_line():
    way = np.array([0.5, 1.0, 2.0, 3.0, 4.0, 5.0])
    same, sd = contrasts([sections([9.0] * 9, 80.0), None, *[sections([9.0] * 9, 80.0)] * 4], way, 0.02)
    assert same == pytest.approx(80.0)
    assert (sd > 0).all()
    falling = [sections([9.0] * 9, 100.0 - 10 * at) for at in way]
    falling[2] = None
    found, _ = contrasts(falling, way, 0.02)
    assert found == pytest.approx(100 - 10 * way, rel=0.01)
    nothing, _ = contrasts([None, sections([9.0] * 9, -1.0)], way[:2], 0.02)
    assert np.isnan(nothing).all()
    along, between = _line(np.array([5.0, 7.0]), np.array([0.1, 0.1]), np.array([0.0, 1.0]))
    assert along(np.array([9.0]))[0] == pytest.approx([6.0])
    assert between == pytest.approx(2.0 - 0.01, rel=1e-3)  # the variance of 5 and 7, less that of their errors


def test_the_radius_is_that_of_the_middle_half_of_the_sections():
    signal = np.pi * 100 * 0.04**2 * np.array([1.0, 1, 1, 1, 9, 0.1, 1, 1])
    assert densitometric_radius(sections(signal), 100.0) == pytest.approx(0.04)
    assert densitometric_radius(sections(np.array([1.0, 2, 4])), 1.0) == pytest.approx(np.sqrt((7 / 3) / np.pi))
    assert densitometric_radius(sections(-np.ones(8)), 1.0) == 0.0


def test_a_measured_radius_has_the_errors_of_scatter_contrast_evening_and_model():
    one = Evened(sections([np.pi * 100 * 0.04**2] * 8, 70.0), 0.02, 0.5, 0.1)
    scatter = 0.1 * np.pi * 100 * 0.04**2
    radius, sd, own, aspect, fall, fall_sd = _measured(one, scatter, 100.0, 6.0, 0.02)
    assert radius == pytest.approx(0.04)
    assert sd == pytest.approx(0.04 * np.sqrt(0.25 * (0.1**2 + 0.06**2) + 0.02**2 + MODEL**2))
    assert own == pytest.approx(70 / (100 * (1 - np.exp(-(0.04**2) / (2 * 0.02**2)))))
    assert aspect == pytest.approx(np.sqrt((0.005 - 0.0004) / (0.01 - 0.0004)))
    assert (fall, fall_sd) == pytest.approx((0.02, 0.004))
    assert np.isnan(_measured(one, scatter, 0.0, 6.0, 0.02)).all()
    assert np.isnan(_measured(None, scatter, 100.0, 6.0, 0.02)).all()
    thin = Evened(sections([1.0] * 8, 70.0, spread=(0.0001, 0.0001)), 0.0)
    assert np.isnan(_measured(thin, 0.1, 100.0, 6.0, 0.02)[3])


def test_windows_come_in_quarters_of_voxels_between_the_ball_and_what_is_widest():
    found = windows(np.array([0.051, np.nan, 0.03, 0.2]), np.array([0.04, 0.04, 0.04, 0.04]), 0.01)
    step = WINDOW * 0.01
    expected = [0.051, 0.04, 0.04, WIDEST * 0.04]
    assert found == pytest.approx([np.ceil(one / step - 1e-9) * step for one in expected])


def test_neighbors_are_the_vessels_whose_boxes_come_within_reach():
    found = _neighbors(TREE, np.full(5, 0.01))
    names = [[next(i for i, line in enumerate(TREE.lines) if line is one) for one in others] for others in found]
    assert names == [[1, 2], [0, 2, 3, 4], [0, 1], [1, 4], [1, 3]]
    assert len(_neighbors(TREE, np.full(5, 2.0))[2]) == 4
    assert _ways(TREE) == pytest.approx(
        [0.5, 1 + np.sqrt(0.5), 1 + np.sqrt(0.5), 1 + 1.5 * np.sqrt(2), 1.5 + np.sqrt(2)]
    )


def test_sections_are_looked_at_clear_of_junctions_and_ends():
    seen = []

    def look(line, free, window, volume, others):
        seen.append((line.run[free[0]], line.run[free[-1]], window, len(others)))

    _profile(TREE, 0, (0.1, 0.9), 0.1, 0.12, None, look, [])
    _profile(TREE, 2, (0.3, 1.364), 0.05, 0.06, None, look, [1, 2])
    (first, last, window, count), (begin, end, _, others) = seen
    step, slant = 1 / 40, np.sqrt(2) / 40
    assert (first, last) == pytest.approx((0.225, 0.825))  # beyond 0.15 + 0.05, before 1 - 0.15
    assert (first - step <= 0.2, last + step >= 0.85) == (True, True)
    assert (window, count, others) == (0.12, 0, 2)
    assert begin == pytest.approx(slant * np.ceil(0.3 / slant))
    assert end == pytest.approx(slant * np.floor((np.sqrt(2) - 0.065) / slant))


def measured(**changes):
    found = measured_alone(TREE)
    ones = np.ones(5)
    grey = Densitometry(0.1 * ones, 0.01 * ones, 50 * ones, ones, ones, np.array([0.01, 9, 0.02, 0, 0.0]),
                        np.array([0.001, 0.001, 0.0, 0.1, np.nan]))  # fmt: skip
    return replace(found, radius_sd=np.array([0.01, 0, np.nan, 0.02, 0.01]), grey=grey, **changes)


def test_a_network_knows_the_errors_and_tapers_that_were_measured():
    network = with_errors(measured()).network
    assert network.radius_sd == pytest.approx([0.01, np.nan, np.nan, 0.02, 0.01], nan_ok=True)
    assert network.taper == pytest.approx([0.01, np.nan, np.nan, 0, np.nan], nan_ok=True)  # 9 would close it
    assert network.taper_sd == pytest.approx([0.001, np.nan, np.nan, 0.1, np.nan], nan_ok=True)
    assert with_errors(replace(measured(), grey=None)).network.taper is None
    assert filled_at(measured(), 7.0).network.pressure == 7.0
    assert closes(np.array([9.0, 0, 0, 0, 0]), network).tolist() == [True, False, False, False, False]
    short = measured_alone(Tree((straight((0, 0, 0), (0.3, 0, 0), 0.1),), np.array([-1])))
    assert short.reliable.tolist() == [False]
    assert measured_alone(TREE, np.arange(5.0)).length_sd.tolist() == [0, 1, 2, 3, 4]


def test_tapers_of_a_tree_are_those_of_its_lines():
    lines = [Line(line.points, line.radius * (1 - 0.2 * line.run)) for line in TREE.lines]
    found = taper(TREE.with_lines(lines))
    assert found.slope == pytest.approx([0.02, 0.016, 0.01, 0.008, 0.006])
    assert found.proximal == pytest.approx([0.1, 0.08, 0.05, 0.04, 0.03])
    assert found.distal[0] == pytest.approx(0.08)


def test_parts_of_a_tree_keep_whole_junctions():
    network = measured().network
    assert first_generations(network, 1).tolist() == [0]
    assert first_generations(network, 2).tolist() == [0, 1, 2]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert len(first_generations(network, 3)) == 5
    with pytest.warns(VasowaveWarning, match="3 generations"):
        assert len(first_generations(network, 4)) == 5
    assert largest_vessels(network, 1).tolist() == [0]
    assert largest_vessels(network, 3).tolist() == [0, 1, 2]
    assert largest_vessels(network, 5).tolist() == [0, 1, 2, 3, 4]
    with pytest.warns(VasowaveWarning, match="3 vessels are kept, not 4"):
        assert largest_vessels(network, 4).tolist() == [0, 1, 2]
    assert wider_than(network, 0.1).tolist() == [0]
    assert wider_than(network, 0.08).tolist() == [0, 1, 2]
    assert wider_than(network, 0.04).tolist() == [0, 1, 2, 3, 4]
    assert wider_than(network, 0.041).tolist() == [0, 1, 2]
    assert said(wider_than, network, 0.101) == "the root's radius is 0.1 cm, below 0.101: nothing would be kept"
    assert said(first_generations, network, 0).startswith("0 generations; at least the root is needed")
    assert said(largest_vessels, network, 0).startswith("0 vessels; at least the root is needed")


def test_a_part_and_a_scaled_tree_take_everything_along():
    part = part_of(filled_at(measured(), 5.0), [0, 1, 3])
    assert (part.network.name, part.network.parent.tolist()) == (("1", "2", "4"), [-1, 0, 1])
    assert part.network.pressure == 5.0
    assert part.radius_sd == pytest.approx([0.01, 0, 0.02])
    assert part.grey.taper_sd == pytest.approx([0.001, 0.001, 0.1])
    assert part.tree.lines[2] is TREE.lines[3]
    twice = scaled(measured(), 2.0)
    assert twice.network.length == pytest.approx(2 * measured().network.length)
    assert twice.radius_sd[0] == pytest.approx(0.02)
    assert twice.grey.radius[0] == pytest.approx(0.2)
    assert twice.grey.sd[0] == pytest.approx(0.02)
    assert twice.tree.lines[0].points[-1].tolist() == [0, 0, 2]
    assert len(wanted_part(measured(), 2, None, None).network) == 3
    assert len(wanted_part(measured(), None, 3, None).network) == 3
    assert len(wanted_part(measured(), None, None, 0.04).network) == 5
    assert len(wanted_part(measured(), None, None, None).network) == 5
    check_wishes(2, None, None)
    for wishes in ((2, 3, None), (None, 3, 0.1), (2, None, 0.1)):
        assert said(check_wishes, *wishes)


def test_sections_without_a_run_or_too_few_are_left_as_they_are():
    from vasowave.imaging.measure.evening import FEWEST

    few = sections(np.linspace(4, 1, FEWEST - 1) ** 2)
    assert evened_sections(few, 0.5).sections is few
    enough = evened_sections(sections(np.linspace(4, 1, FEWEST) ** 2), 0.55)
    assert enough.sections.signal == pytest.approx(np.full(FEWEST, 2.5**2))
    assert enough.error == pytest.approx(0.0, abs=1e-9)
