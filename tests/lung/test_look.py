"""The first look: what it proposes is what extracts, and what it shows is there."""

import warnings

import numpy as np
import pytest

import vasowave as vw
from made_phantom import phantom
from vasowave.base import InputError, VasowaveWarning
from vasowave.lung import histogram_of
from vasowave.lung.lumen import levels_of, segment
from vasowave.lung.read import Volume, write_volume
from vasowave.lung.witness import loops_after_closing, opening_threshold

CANNULA = 0.043


@pytest.fixture(scope="module")
def scan(tmp_path_factory):
    embedding, volume = phantom()
    path = tmp_path_factory.mktemp("look") / "mouse 6.nrrd"
    write_volume(volume, path)
    return path, embedding, volume


@pytest.fixture(scope="module")
def seen(scan):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", VasowaveWarning)
        return vw.look(scan[0])


def test_the_cannula_is_proposed_first_with_its_radius_and_at_its_end(scan, seen):
    _, embedding, volume = scan
    first, second = seen.entrances[:2]
    assert first.radius == pytest.approx(CANNULA, rel=0.03)
    assert np.linalg.norm(first.place - embedding.cannula[0]) < 3 * volume.spacing[0]
    assert second.radius < 0.85 * CANNULA
    assert seen.is_clear
    assert list(seen.entrances) == sorted(seen.entrances, key=lambda one: -one.radius)


def test_a_drawing_of_two_grey_levels_is_given_a_threshold_between_them():
    z, y, x = np.indices((90, 60, 30)) * 0.002
    side = np.where(z < 0.09, 0.0, 0.5 * (z - 0.09))  # a round vessel that divides
    axis = np.minimum(np.hypot(y - 0.06 - side, x - 0.03), np.hypot(y - 0.06 + side, x - 0.03))
    drawn = Volume(255.0 * ((axis < 0.011) & (z < 0.17)), (0.002,) * 3, (0.0, 0.0, 0.0))
    for bright in (1.0, 255.0):
        found = levels_of(Volume(drawn.grey * (bright / 255.0), drawn.spacing, drawn.origin))
        assert (found.background, found.lumen) == pytest.approx((0.0, bright), abs=0.02 * bright)


def test_whole_numbers_are_counted_in_bits(scan):
    _, _, volume = scan
    whole = Volume(np.clip(np.round(2 * volume.grey), 0, 255), volume.spacing, volume.origin)
    assert histogram_of(whole).bits == 8


def test_without_a_root_the_one_end_that_is_as_wide_as_the_cannula_is_taken(scan):
    _, embedding, volume = scan
    with pytest.warns(VasowaveWarning, match="no root was given: the blood enters at"):
        found = vw.extract(volume)
    assert len(found.network) == 5
    assert np.linalg.norm(found.root - embedding.cannula[0]) < 3 * volume.spacing[0]
    with pytest.raises(InputError, match=r"where does the blood enter.*\(radius 0\.04[234]\)"):
        vw.extract(volume, cannula=0)


@pytest.mark.parametrize("sizes", ["", "spacings: nan nan nan\n", "space directions: none none none\n"])
def test_a_first_look_asks_for_the_voxel_size_that_a_file_lacks_as_the_extraction_does(sizes, tmp_path):
    path = tmp_path / "lung.nrrd"
    head = f"NRRD0004\ntype: uint8\ndimension: 3\nsizes: 3 3 3\n{sizes}encoding: raw\n\n"
    path.write_bytes(head.encode() + bytes(range(27)))
    told = []
    for read in (vw.look, vw.extract):
        with pytest.raises(InputError, match="the size of its voxels is not known") as refused:
            read(path)
        told.append(str(refused.value))
    assert told[0] == told[1]


def ring(gap, noise=2.0):
    """A vessel that divides and joins again around a hole of `gap` voxels."""
    z, y, x = np.indices((30, 70, 90))
    half = gap / 2 + 5
    side = np.where(np.abs(x - 45) < 20, half * np.cos(np.pi * (x - 45) / 40), 0)
    tube = np.minimum(np.hypot(y - 35 - side, z - 15), np.hypot(y - 35 + side, z - 15)) < 5
    grey = 100 * (tube & (x > 3) & (x < 86)) + np.random.default_rng(0).normal(10, noise, z.shape)
    return Volume(grey, np.full(3, 0.01), np.zeros(3))


def test_a_gap_that_noise_could_make_is_told_from_a_ring_of_vessels():
    wide = segment(ring(20), 50)
    assert loops_after_closing(wide) == 1
    z, y, x = np.indices((30, 60, 60))
    holed = (np.hypot(y - 30, x - 30) < 12) & (np.abs(z - 15) < 10) & ~((np.abs(y - 30) < 2) & (np.abs(z - 15) < 2))
    grey = 100.0 * holed + np.random.default_rng(0).normal(10, 2, z.shape)
    assert loops_after_closing(segment(Volume(grey, np.full(3, 0.01), np.zeros(3)), 50)) == 0


def test_a_bridge_that_a_higher_threshold_cuts_is_answered_with_that_threshold():
    volume = ring(20)
    _, y, x = np.indices(volume.grey.shape)
    dim = (np.abs(x - 45) < 12) & (y > 35)
    grey = np.where(dim, 10 + 0.5 * (volume.grey - 10), volume.grey)
    bridged = Volume(grey, volume.spacing, volume.origin)
    level = opening_threshold(segment(bridged, 50))
    assert 55 < level < 75  # the bridge has 60
    with pytest.raises(InputError, match=f"raise the threshold to {level:.4g}, where none is left"):
        vw.extract(bridged, root=(0.15, 0.35, 0.05), threshold=50, cannula=0)
    assert opening_threshold(segment(volume, 50)) is None


def test_an_image_of_noise_alone_is_refused_before_its_loops_are_counted():
    grey = np.random.default_rng(5).normal(100.0, 20.0, (60, 50, 40))
    with pytest.raises(InputError, match="nothing stands out: the brightest piece lies 0"):
        vw.look(Volume(grey, (0.01,) * 3, (0.0, 0.0, 0.0)))
