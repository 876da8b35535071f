"""Grey levels that are not what they seem: clipped, bent, flat; and what the noise and the cannula make of them."""

import tracemalloc
import warnings
from dataclasses import replace

import numpy as np
import pytest

from phantom import embed, render
from vasowave.base import InputError, VasowaveWarning
from vasowave.lung import Line, Options, Tree, extract, grey_text, parse_grey
from vasowave.lung.lumen import Segmentation, levels_of, segment
from vasowave.lung.measure import GreyScale, corrected, grey_scale
from vasowave.lung.read import Volume
from vasowave.lung.witness import grey_look, saturation
from vasowave.pulse.network import Network

NETWORK = Network(("a", "b", "c"), np.array([-1, 0, 0]), np.array([0.4, 0.4, 0.3]), np.array([0.052, 0.04, 0.034]))


@pytest.fixture(scope="module")
def fork():
    rng = np.random.default_rng(11)
    embedding = embed(NETWORK, rng)
    return embedding, render(embedding, 150, 0.0085, rng)


def exported(volume, scale, bits=8):
    """The grey levels from the darkest to the brightest on another scale, as whole numbers."""
    low, high = np.percentile(volume.grey, 0.05), float(volume.grey.max())
    share = np.clip((volume.grey - low) / (high - low), 0, 1)
    return Volume(np.round((2**bits - 1) * scale(share)), volume.spacing, volume.origin)


def found_in(image, embedding, **more):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", VasowaveWarning)
        threshold = levels_of(corrected(image, more["grey"]) if "grey" in more else image).threshold
        root = embedding.cannula[0] + np.array([0.01, 0, 0])
        return extract(image, root=root.tolist(), threshold=threshold, **more)


def radius_errors(found):
    """Of the vessels, the longer daughter first."""
    order = [0, *sorted((1, 2), key=lambda row: -found.network.radius[row])]
    return found.network.radius[order] / NETWORK.radius - 1


@pytest.mark.validation
def test_a_linear_scale_is_found_linear_whatever_its_unit(fork):
    embedding, volume = fork
    for factor, bits in ((1.0, None), (40.0, 16)):
        image = Volume(volume.grey * factor, volume.spacing, volume.origin) if bits is None else exported(
            volume, lambda share: share, bits)  # fmt: skip
        found = found_in(image, embedding)
        scale = grey_scale(found.tree, image)
        assert abs(scale.bend) < 0.025
        assert not [one for one in found.doubts if one.finding.code.startswith("image.")]


@pytest.mark.parametrize(
    "bent",
    [
        pytest.param(lambda share: share**0.5, marks=pytest.mark.validation),
        pytest.param(lambda share: share**1.8, marks=pytest.mark.validation),
        lambda share: np.log1p(5 * share) / np.log(6),
    ],
)
def test_a_bent_scale_is_named_and_the_correction_that_noise_and_cannula_agree_on_gives_the_true_radii(fork, bent):
    embedding, volume = fork
    image = exported(volume, bent)
    first = found_in(image, embedding)
    assert np.abs(radius_errors(first)).max() > 0.03
    (doubt,) = (one for one in first.doubts if one.finding.code.startswith("image."))
    assert doubt.finding.code in ("image.bent-grey-scale", "image.flat-grey-scale")
    assert doubt.grade == "look"
    assert set(doubt.vessels) == set(first.network.name)
    assert "the cannula has its known diameter" in doubt.text
    pairs = parse_grey(doubt.text.partition("corrected, grey ")[2].partition(", the")[0])
    again = found_in(image, embedding, grey=pairs)
    np.testing.assert_allclose(radius_errors(again), 0, atol=0.025)
    assert not [one for one in again.doubts if one.finding.code.startswith("image.")]


@pytest.mark.validation
def test_a_cannula_that_contradicts_the_noise_is_offered_no_correction(fork):
    embedding, volume = fork
    image = exported(volume, lambda share: share**0.5)
    larger = Volume(image.grey, image.spacing * 1.06, image.origin)  # as if the file's voxel size were wrong
    found = found_in(larger, type(embedding)(NETWORK, embedding.lines, _grown(embedding.cannula, image, 1.06)))
    (doubt,) = (one for one in found.doubts if one.finding.code == "image.bent-grey-scale")
    assert "corrected" not in doubt.text
    assert "option 'grey'" in doubt.text


def _grown(points, image, factor):
    return (points - image.origin) * factor + image.origin


@pytest.mark.parametrize("share", [pytest.param(0.55, marks=pytest.mark.validation), 0.85])
def test_a_clipped_image_is_wrong_and_says_how_to_export_it(fork, share):
    embedding, volume = fork
    clipped = Volume(np.minimum(volume.grey, 12 + 88 * share), volume.spacing, volume.origin)
    found = found_in(exported(clipped, lambda level: level), embedding)
    assert found.doubts[0].finding.code == "image.clipped"
    assert found.doubts[0].grade == "wrong"
    assert "wider window" in found.doubts[0].text


def test_a_mask_of_two_levels_and_a_made_image_without_noise_are_not_clipped():
    _, y, x = np.indices((30, 40, 40))
    tube = np.hypot(y - 20, x - 20) < 6
    for grey in (200.0 * tube, np.clip(6.5 - np.hypot(y - 20, x - 20), 0, 1) * 99.5):
        volume = Volume(grey, np.full(3, 0.01), np.zeros(3))
        lumen = Segmentation(tube, grey, np.zeros(3, int), 0.01, np.zeros(3), 45.0, 0.0, 0.0)
        assert saturation(volume, lumen)[0] == 0.0


def test_noise_that_is_not_there_shows_no_scale():
    _, y, x = np.indices((80, 40, 40))
    grey = np.clip(6.5 - np.hypot(y - 20, x - 20), 0, 1) * 100
    points = np.column_stack([np.arange(80.0), np.full(80, 20.0), np.full(80, 20.0)]) * 0.01
    tree = Tree((Line(points, np.full(80, 0.06)),), np.array([-1]))
    assert grey_scale(tree, Volume(grey, np.full(3, 0.01), np.zeros(3))) is None


def test_pairs_are_read_as_written_and_must_ascend():
    pairs = parse_grey("0:0,120:80,255:255")
    assert parse_grey(grey_text(pairs)) == pairs == Options(grey="0:0,120:80,255:255").grey
    for wrong in ("0:0", "0:0,120:80,100:90", "0:0,120:-1", "0:0,1:x"):
        with pytest.raises(InputError, match="ascending pairs measured:linear"):
            Options(grey=wrong)


def test_a_correction_is_straight_between_its_pairs_and_goes_on_beyond_them():
    grey = np.array([-10.0, 0, 60, 120, 255, 300]).reshape(1, 1, 6) * np.ones((3, 3, 1))
    out = corrected(Volume(grey, np.full(3, 0.01), np.zeros(3)), ((0, 0), (120, 80), (255, 255))).grey[0, 0]
    np.testing.assert_allclose(out, [-20 / 3, 0, 40, 80, 255, 255 + 45 * 175 / 135], rtol=1e-6)


def test_the_proposed_threshold_lies_between_background_and_lumen_in_any_unit(fork):
    _, volume = fork
    levels = levels_of(volume)
    assert levels.background == pytest.approx(12, abs=1)
    assert levels.lumen == pytest.approx(100, rel=0.05)
    larger = levels_of(Volume(300 * volume.grey - 5000, volume.spacing, volume.origin))
    assert larger.threshold == pytest.approx(300 * levels.threshold - 5000, rel=0.02)


@pytest.mark.validation
def test_a_threshold_that_cannot_be_is_answered_with_one_that_can(fork):
    _, volume = fork
    proposed = f"{levels_of(volume).threshold:g}"
    for wrong, what in ((-50.0, "raise"), (500.0, "lower")):
        with pytest.raises(InputError, match=f"{what} the threshold to about {proposed}"):
            segment(volume, wrong)


@pytest.mark.validation
def test_a_look_at_the_grey_scale_of_a_large_image_needs_less_memory_than_the_image(fork):
    embedding, volume = fork
    found = found_in(volume, embedding)
    wide = Volume(np.pad(volume.grey, 60, mode="edge"), volume.spacing, volume.origin - 60 * volume.spacing)
    outer, tip = embedding.cannula
    axis = outer + np.linspace(0, 1, 60)[:, None] * (tip - outer)
    cannula, lumen = Line(axis, np.full(60, 0.043)), found.lumen
    looks = {}
    for name, image, corner in (("small", volume, lumen.corner), ("wide", wide, np.array(lumen.corner) + 60)):
        tracemalloc.start()
        looks[name] = grey_look(found.tree, image, replace(lumen, corner=corner), cannula, 0.043)
        memory = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
    assert memory < wide.grey.nbytes
    assert looks["small"].contradicted == looks["wide"].contradicted
    assert looks["small"].scale.bend == pytest.approx(looks["wide"].scale.bend, abs=1e-5)


def test_bend_and_flatness_of_a_scale():
    """A parabola 16 % above the line in the middle; noise that grows tenfold is ten times as steep there."""
    level = np.linspace(10.0, 110.0, 17)
    share = (level - 10) / 100
    one = GreyScale(level, level - 64 * share * (1 - share), np.full(17, 2.0))
    assert one.bend == pytest.approx(0.16)
    assert GreyScale(level, level + 64 * share * (1 - share), np.full(17, 2.0)).bend == pytest.approx(-0.16)
    assert one.flatness == pytest.approx(1.0)
    noise = 1.0 + share
    steep = GreyScale(level, level, noise)
    assert steep.flatness == pytest.approx(np.log(2), rel=2e-3)  # ∫ ds/(1 + s) over the unit interval
    assert GreyScale(level, level, noise[::-1]).flatness == pytest.approx(np.log(2), rel=2e-3)
