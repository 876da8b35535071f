"""What images unlike the phantom need: vessels that bend, fade and narrow, frames of zeros, slices of any distance."""

import warnings
from dataclasses import fields, replace

import numpy as np
import pytest
from made_phantom import NETWORK, phantom
from test_tubes import VOXEL, walls
from typer import Context
from typer.main import get_command

from vasowave.cli import app
from vasowave.errors import InputError, VasowaveWarning
from vasowave.imaging import Options, Volume
from vasowave.imaging.axes.tubes import fitted
from vasowave.imaging.lumen.background import background_level, noise_level
from vasowave.imaging.lumen.segmentation import segment
from vasowave.imaging.lumen.surface import surface_points
from vasowave.imaging.measure.cannula import cannula_tip
from vasowave.imaging.measure.contrast import contrasts
from vasowave.imaging.measure.evening import evened_sections, moderated
from vasowave.imaging.measure.measurement import measured_alone
from vasowave.imaging.measure.profiles import Profile, profile
from vasowave.imaging.measure.radii import densitometric_radius
from vasowave.imaging.read.volume import isotropic
from vasowave.imaging.tree import Line, Tree
from vasowave.imaging.witness.crossings import crossing_doubts
from vasowave.imaging.witness.skeleton import skeleton_branches
from vasowave.imaging.witness.topology import topology_doubts
from vasowave.imaging.witness.witness import _cut, _shattered, _unsettled


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
        assert noise_level(Volume(values, np.full(3, 0.01), np.zeros(3))) == pytest.approx(6, rel=0.06)
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
    straight = replace(one, signal=np.pi * 0.034**2 * 88 * noise)
    np.testing.assert_array_equal(evened_sections(straight, 0.2).sections.signal, straight.signal)


def test_the_scatter_of_few_sections_is_not_believed_where_the_noise_of_the_image_says_otherwise():
    rng = np.random.default_rng(6)
    made = [replace(made_profile(88, 0.02, sections=12), signal=rng.normal(0.1, 0.01, 12)) for _ in range(200)]
    one_error = 0.01 / np.sqrt(12 / 3)  # neighboring sections are taken to share their noise
    alone = np.array([np.std(one.signal) / np.sqrt(12 / 3) for one in made])
    found = np.array(moderated(made))
    assert np.std(found) < 0.5 * np.std(alone)
    assert np.median(found) == pytest.approx(one_error, rel=0.1)
    uneven = replace(made[0], signal=rng.normal(0.1, 0.05, 12))  # a vessel that does differ along itself
    assert moderated([*made, uneven])[-1] > 2 * one_error
    assert np.isnan(moderated([None])).all()


@pytest.mark.parametrize("taper", [0.0, 0.15, 0.4])
def test_the_cannula_ends_at_the_step_also_where_the_root_narrows_beyond_its_radius(taper):
    run = np.arange(0, 0.7, 0.005)
    radius = np.where(run < 0.2, 0.043, 0.054 * (1 - taper * (run - 0.2) / 0.5))
    radius += np.random.default_rng(4).normal(0, 0.0006, len(run))
    line = Line(np.column_stack([run, 0 * run, 0 * run]), radius)
    assert run[cannula_tip(line, radius)] == pytest.approx(0.2, abs=0.011)
    with pytest.raises(InputError, match="no cannula found"):
        cannula_tip(line, np.linspace(0.054, 0.04, len(run)))


@pytest.fixture(scope="module")
def seen():
    """The skeleton of the phantom's lumen, and the true tree with its cannula."""
    embedding, volume = phantom()
    lumen = segment(volume, 45, embedding.cannula[0])
    cannula = np.linspace(*embedding.cannula, 20)[:-1]
    axes = [np.concatenate([cannula, embedding.lines[0]]), *embedding.lines[1:]]
    lines = tuple(Line(axis, np.full(len(axis), r)) for axis, r in zip(axes, NETWORK.radius, strict=True))
    return skeleton_branches(lumen, embedding.cannula[0], surface_points(lumen)), Tree(lines, NETWORK.parent), lumen


def test_the_witness_agrees_with_the_truth(seen):
    skeleton, tree, lumen = seen
    assert topology_doubts(tree, skeleton, lumen.spacing, True) == []


def test_the_witness_says_where_a_vessel_is_missing(seen):
    skeleton, tree, lumen = seen
    fewer = Tree(tree.lines[:4], tree.parent[:4])  # vessel 5 is gone
    (doubt,) = topology_doubts(fewer, skeleton, lumen.spacing, True)
    assert doubt.about == "topology"
    np.testing.assert_allclose(doubt.places[0], tree.lines[4].points[-1], atol=0.03)
    assert topology_doubts(fewer, skeleton, lumen.spacing, False) == []  # the user chose the outlets


def test_the_witness_names_a_vessel_that_is_not_there_and_a_junction_that_joins_others(seen):
    skeleton, tree, lumen = seen
    start = tree.lines[2].points[len(tree.lines[2]) // 2]
    invented = Line(start + np.linspace(0, 1, 20)[:, None] * [0.0, 0.0, 0.2], np.full(20, 0.03))
    more = Tree((*tree.lines, invented), np.append(tree.parent, 2))
    assert "6" in {name for doubt in topology_doubts(more, skeleton, lumen.spacing, True) for name in doubt.vessels}
    # Vessels 3 and 4 exchange their parents: all ends are right, and what lies beyond vessel 2 is not.
    lines = (*tree.lines[:2], tree.lines[3], tree.lines[2], tree.lines[4])
    swapped = Tree(lines, tree.parent)
    doubts = topology_doubts(swapped, skeleton, lumen.spacing, True)
    assert any("joins other vessels" in doubt.text and doubt.vessels == ("2",) for doubt in doubts)


def test_a_vessel_that_passes_straight_through_a_junction_is_doubted_and_daughters_are_not(seen):
    _, tree, _ = seen
    assert crossing_doubts(tree) == []
    touch = tree.lines[2].points[len(tree.lines[2]) // 2]
    way = np.array([0.1, 0.2, 0.0])
    halves = [Line(touch + np.linspace(0, side, 20)[:, None] * way, np.full(20, 0.02)) for side in (1, -1)]
    (doubt,) = crossing_doubts(Tree((*tree.lines, *halves), np.append(tree.parent, [2, 2])))
    assert doubt.vessels == ("6", "7")


def test_a_vessel_that_crosses_is_doubted_though_its_halves_first_bend_toward_what_they_cross(seen):
    _, tree, _ = seen
    middle = len(tree.lines[2]) // 2
    touch, along = tree.lines[2].points[middle], tree.lines[2].points[middle + 3] - tree.lines[2].points[middle - 3]
    across = np.cross(along, [1.0, 0.3, 0.2])
    across /= np.linalg.norm(across)
    beside = 0.06 * np.cross(along, across) / np.linalg.norm(along)
    bend = np.minimum(np.linspace(0, 8, 40), 1)  # to the crossing axis, in the ball of the junction; then along it
    radius = np.maximum(0.06 * (1 - bend), 0.02)
    ways = [bend[:, None] * beside + np.linspace(0, side, 40)[:, None] * across for side in (0.3, -0.3)]
    halves = [Line(touch + way, radius) for way in ways]
    doubts = crossing_doubts(Tree((*tree.lines, *halves), np.append(tree.parent, [2, 2])))
    assert ("6", "7") in [doubt.vessels for doubt in doubts]


def comb(count):
    """A root and `count` daughters side by side, measured without an image."""
    x = np.linspace(0, 1, 40)[:, None]
    lines = [Line(np.array([0.0, row, 0]) + x * [0.0, 0, 1], np.full(40, 0.02)) for row in range(count + 1)]
    return measured_alone(Tree(tuple(lines), np.append(-1, np.zeros(count, dtype=int))))


def test_the_same_uncertainty_of_radii_names_vessels_of_a_large_tree_and_not_those_of_a_small_one():
    def about(measured):
        known = replace(measured, radius_sd=0.018 * measured.network.radius, length_sd=0 * measured.network.radius)
        return [doubt.about for doubt in _unsettled(replace(known, reliable=np.ones(len(known.tree), dtype=bool)))]

    assert about(comb(4)) == []
    assert about(comb(60)) == ["radius"]


def test_a_tree_most_of_whose_vessels_cannot_be_measured_is_doubted_as_a_whole():
    measured = comb(9)
    assert _shattered(replace(measured, reliable=np.arange(10) >= 5)) == []
    (doubt,) = _shattered(replace(measured, reliable=np.arange(10) >= 6))
    assert doubt.about == "topology"
    assert len(doubt.vessels) == 6


def test_a_vessel_is_called_cut_only_where_the_lumen_reaches_the_border(seen):
    _, tree, lumen = seen
    whole = measured_alone(tree)
    assert _cut(whole, lumen) == []
    low = np.argwhere(lumen.mask.any(axis=(0, 1)))[0, 0] + 12  # a face through the vessels
    part = replace(lumen, mask=lumen.mask[:, :, low:], origin=lumen.origin + np.array([0, 0, low * lumen.spacing]))
    lost = [row for row in tree.terminals if tree.lines[row].points[-1][2] < part.origin[2]]
    (doubt,) = _cut(whole, part)
    assert set(doubt.vessels) == {str(row + 1) for row in lost}
    assert doubt.about == "length"


def test_every_setting_is_an_option_of_the_command_with_the_same_default():
    command = get_command(app)
    _, extract, _ = command.resolve_command(Context(command), ["extract"])
    options = {one.name: one for one in extract.params}
    for entry in fields(Options):
        assert options[entry.name].help
        assert options[entry.name].default is None  # then the setting's own default holds, which the help shows
        assert str(entry.default) in str(options[entry.name].show_default) or entry.default is None


def test_an_unknown_choice_is_refused_with_those_there_are_and_loops_are_refused_unless_asked_for():
    with pytest.raises(InputError, match="method: unknown 'magic'; choose from"):
        Options(method="magic")
    with warnings.catch_warnings():
        warnings.simplefilter("error", VasowaveWarning)
        assert Options().loops == "refuse"
