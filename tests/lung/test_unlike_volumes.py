"""What images unlike the phantom need: vessels that bend, fade and narrow, frames of zeros, slices of any distance."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter1d
from test_tubes import VOXEL, walls

from vasowave.base import InputError
from vasowave.lung import Line, Tree
from vasowave.lung.axes import fitted
from vasowave.lung.lumen import background_and_noise, background_level
from vasowave.lung.measure import (
    Profile,
    cannula,
    cannula_tip,
    contrasts,
    densitometric_radius,
    evened_sections,
    moderated,
    own_contrast,
    profile,
    tip_sd,
)
from vasowave.lung.read import Volume, isotropic


def test_slices_of_any_distance_become_cubes_that_keep_every_grey_level_in_its_place():
    rng = np.random.default_rng(0)
    for ratio in [*rng.uniform(1.002, 4, 200), 1.5 / 0.879]:
        spacing = np.array([ratio, 1.0, 1.0]) * 0.0879
        shape = (int(rng.integers(5, 40)), 6, 7)
        z, y, x = (np.arange(count) * h for count, h in zip(shape, spacing, strict=True))
        grey = 3 * z[:, None, None] - y[:, None] + 2 * x  # linear interpolation has no error on a plane
        cubes = isotropic(Volume(grey, spacing, np.array([1.0, 2, 3])))
        assert np.ptp(cubes.spacing) == 0
        at = [np.arange(count) * cubes.spacing[0] for count in cubes.grey.shape]
        expected = 3 * at[0][:, None, None] - at[1][:, None] + 2 * at[2]
        np.testing.assert_allclose(cubes.grey, expected, atol=2e-5 * np.abs(expected).max())
        assert at[0][-1] > z[-1] - cubes.spacing[0]


def test_a_frame_of_zeros_and_a_cupped_background_change_neither_background_nor_noise():
    rng = np.random.default_rng(1)
    grey = rng.normal(12, 6, (60, 60, 60)).astype(np.float32)
    framed = np.pad(grey, 30)
    y, x = np.indices((60, 60)) - 29.5
    cupped = grey + 30 * (np.hypot(y, x) / 42).astype(np.float32) ** 2
    for values in (grey, framed, cupped):
        assert background_and_noise(Volume(values, np.full(3, 0.01), np.zeros(3)))[1] == pytest.approx(6, rel=0.06)
    assert background_level(Volume(framed, np.full(3, 0.01), np.zeros(3))) == pytest.approx(12, abs=0.5)


def test_an_axis_that_bends_within_three_radii_is_followed_where_its_wall_is_its_own():
    radius, run = 0.04, np.linspace(0, 0.8, 161)
    wave = 0.4 * radius * np.sin(2 * np.pi * run / (5 * radius))
    axis = Line(np.column_stack([0 * run, wave, run]), np.full(161, radius))
    surface = walls([axis], [radius], np.random.default_rng(0), 0.2)
    straight = Line(axis.points * [1, 0, 1], axis.radius)
    found = fitted(Tree((straight,), np.array([-1])), surface, VOXEL, 0.18).lines[0]
    middle = found.points[(found.points[:, 2] > 0.1) & (found.points[:, 2] < 0.7)]
    off = middle[:, 1] - np.interp(middle[:, 2], run, wave)
    assert np.abs(off).max() < 0.2 * VOXEL  # the wave is 1.6 voxels high
    assert found.length == pytest.approx(axis.length, rel=0.01)


def made_profile(contrast, radius, noise=0.0, blur=0.009, sections=30, rng=None):
    """Sections of a round vessel in a blurred image, from the formulas of a blurred disc."""
    grain = np.zeros(sections) if rng is None else rng.normal(0, noise, sections)
    left = 1 - np.exp(-(radius**2) / (2 * blur**2))
    return Profile(
        np.full(sections, np.pi * radius**2 * contrast),
        contrast * left + grain,
        np.full(2, radius**2 / 4 + blur**2),
        0.0,
        np.arange(sections) * VOXEL,
        np.arange(sections),
    )


@pytest.mark.parametrize("fading", [0.0, 0.4])
def test_contrast_that_falls_along_the_tree_is_followed_down_to_vessels_too_thin_to_show_it(fading):
    rng = np.random.default_rng(2)
    way = np.linspace(0.2, 2.0, 12)
    true = 88 * (1 - fading * way / 2)
    radius = np.where(np.arange(12) % 3 == 2, 0.012, 0.04)  # every third is hardly wider than the blur
    made = [made_profile(c, r, 2.0, rng=rng) for c, r in zip(true, radius, strict=True)]
    found, error = contrasts(made, way, 0.009)
    np.testing.assert_allclose(found, true, rtol=0.02)
    assert (np.abs(found - true) < 4 * error).all()
    measured = [densitometric_radius(one, c) for one, c in zip(made, found, strict=True)]
    np.testing.assert_allclose(measured, radius, rtol=0.01)


def test_a_vessel_that_is_partly_filled_is_believed_by_itself():
    rng = np.random.default_rng(3)
    true = np.full(11, 88.0)
    true[[4, 7]] = 55.0, 60.0
    found, _ = contrasts([made_profile(c, 0.04, 2.0, rng=rng) for c in true], np.linspace(0, 2, 11), 0.009)
    np.testing.assert_allclose(found, true, rtol=0.04)


def test_the_aspect_of_an_oval_section_and_the_radius_of_its_area_are_measured():
    _, y, x = np.indices((40, 48, 48)).astype(float)
    a, b = 0.07, 0.05
    rho = np.hypot((y - 24) / (100 * a), (x - 24) / (100 * b))
    grey = 12 + 88 * np.clip(0.5 - (rho - 1) * 100 * np.sqrt(a * b), 0, 1)
    run = np.arange(5, 35) * VOXEL
    line = Line(np.column_stack([run, np.full(30, 0.24), np.full(30, 0.24)]), np.full(30, b))
    one = profile(line, np.arange(30), 0.06, Volume(grey, np.full(3, VOXEL), np.zeros(3)))
    assert densitometric_radius(one, 88.0) == pytest.approx(np.sqrt(a * b), rel=0.01)
    assert np.sqrt(one.spread[1] / one.spread[0]) == pytest.approx(b / a, rel=0.03)


def test_a_vessel_that_narrows_has_the_mean_radius_of_all_of_it_and_no_scatter_from_narrowing():
    rng, run = np.random.default_rng(5), np.linspace(0.12, 0.36, 30)  # clear from 0.12 of 0.4 cm on
    radius = 0.04 * (1 - 0.3 * run / 0.4)
    noise = 1 + 0.04 * rng.standard_normal(30)
    one = replace(made_profile(88, 0.04), signal=np.pi * radius**2 * 88 * noise, run=run)
    evened = evened_sections(one, 0.2)
    assert densitometric_radius(one, 88) < 0.97 * 0.034
    assert densitometric_radius(evened.sections, 88) == pytest.approx(0.034, rel=0.015)
    assert np.std(evened.sections.signal) < 0.5 * np.std(one.signal)
    assert 0 < evened.error < 0.01
    steepness = 0.04 * 0.3 / 0.4 / 0.034  # fall of the radius over the radius in the middle, 1/cm
    assert evened.taper == pytest.approx(steepness, abs=2 * evened.taper_sd)
    assert 0.02 < evened.taper_sd / steepness < 0.2
    straight = replace(one, signal=np.pi * 0.034**2 * 88 * noise)
    np.testing.assert_array_equal(evened_sections(straight, 0.2).sections.signal, straight.signal)


def test_the_errors_of_tapers_of_few_sections_hold_none():
    rng, scores = np.random.default_rng(7), []
    for _ in range(300):
        noise = gaussian_filter1d(rng.standard_normal(60), 0.85)[20:32]  # three share their noise
        sections = replace(made_profile(88, 0.04, sections=12), signal=88 * np.pi * 0.04**2 * (1 + 0.04 * noise))
        evened = evened_sections(sections, 6 * VOXEL)
        scores.append(evened.taper / evened.taper_sd)
    assert np.mean(np.abs(scores) < 2) > 0.91  # by the scatter about the line as it is, 0.85
    assert 0.85 < np.std(scores) < 1.2


def test_the_scatter_of_few_sections_is_not_believed_where_the_noise_of_the_image_says_otherwise():
    rng = np.random.default_rng(6)
    made = [replace(made_profile(88, 0.02, sections=12), signal=rng.normal(0.1, 0.01, 12)) for _ in range(200)]
    one_error = 0.01 / np.sqrt(12 / 3)  # neighboring sections are taken to share their noise
    alone = np.array([np.std(one.signal) / np.sqrt(12 / 3) for one in made])
    unknown = np.full(200, np.nan)
    found = moderated(made, unknown)
    assert np.std(found) < 0.5 * np.std(alone)
    assert np.median(found) == pytest.approx(one_error, rel=0.1)
    uneven = replace(made[0], signal=rng.normal(0.1, 0.05, 12))  # a vessel that does differ along itself
    assert moderated([*made, uneven], np.append(unknown, np.nan))[-1] > 2 * one_error
    assert np.isnan(moderated([None], np.array([np.nan]))).all()


def test_noise_that_sections_have_in_common_counts_where_it_is_larger_than_their_scatter():
    rng = np.random.default_rng(7)
    made = [replace(made_profile(88, 0.02, sections=12), signal=rng.normal(0.1, 0.01, 12)) for _ in range(40)]
    alone = moderated(made, np.full(40, np.nan))
    np.testing.assert_array_equal(moderated(made, np.full(40, 1e-4)), alone)
    np.testing.assert_allclose(moderated(made, np.full(40, 0.02)), 0.02)


@pytest.mark.parametrize("taper", [0.0, 0.15, 0.4])
def test_the_cannula_ends_at_the_step_also_where_the_root_narrows_beyond_its_radius(taper):
    run = np.arange(0, 0.7, 0.005)
    radius = np.where(run < 0.2, 0.043, 0.054 * (1 - taper * (run - 0.2) / 0.5))
    radius += np.random.default_rng(4).normal(0, 0.0006, len(run))
    line = Line(np.column_stack([run, 0 * run, 0 * run]), radius)
    assert run[cannula_tip(line, radius)] == pytest.approx(0.2, abs=0.011)
    with pytest.raises(InputError, match="no cannula found"):
        cannula_tip(line, np.linspace(0.054, 0.04, len(run)))


@pytest.mark.parametrize("noise", [0.001, pytest.param(0.0025, marks=pytest.mark.validation)])
def test_the_sd_of_the_cannulas_end_is_the_scatter_of_where_noise_puts_it(noise, monkeypatch):
    rng, voxel = np.random.default_rng(9), 0.005
    run = np.arange(0, 0.7, voxel)
    line = Line(np.column_stack([run, 0 * run, 0 * run]), np.full(len(run), 0.045))
    volume = Volume(np.arange(27.0).reshape(3, 3, 3), np.full(3, voxel), np.zeros(3))
    tips, told = [], []
    for _ in range(60):
        blurred = gaussian_filter1d(rng.standard_normal(len(run)), cannula.BLUR)
        radius = np.where(run < 0.2, 0.043, 0.047) + noise * blurred / blurred.std()
        monkeypatch.setattr(cannula, "section_radii", lambda line, volume, radius=radius: radius)
        try:
            tip = cannula_tip(line, radius)
        except InputError:  # the noise hides the step, which is told
            continue
        tips.append(run[tip])
        told.append(tip_sd(line[: tip + 1], line[tip:], volume))
    assert len(tips) > 50
    errors = np.array(tips) - 0.2
    assert np.sqrt(np.mean(errors**2)) < 1.5 * np.sqrt(np.mean(np.square(told))) < 4 * np.sqrt(np.mean(errors**2))
    assert np.mean(np.abs(errors) < 2 * np.array(told) + voxel) > 0.85


@pytest.mark.parametrize("radius", [1.5, 2.5, 4.0])
def test_a_vessel_shows_its_contrast_through_the_blur_and_is_the_surer_the_wider(radius):
    contrast, error = own_contrast(made_profile(100.0, radius, blur=0.9), 0.9)
    lost = np.exp(-(radius**2) / (2 * 0.9**2))
    assert contrast == pytest.approx(100.0, rel=1e-3)
    assert error == pytest.approx(np.hypot(lost, 0.01) * contrast, rel=2e-3)
