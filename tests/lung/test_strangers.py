"""What is not a vessel: dark inclusions within the lumen, tubes and plates that hang together with it."""

import warnings

import numpy as np
import pytest
from scipy import ndimage

from vasowave import lung
from vasowave.lung import Line, Tree, Volume
from vasowave.lung.lumen import EditedMask, dark_inclusions, segment, without_inclusions, without_strangers
from vasowave.lung.measure import measured_in

pytestmark = pytest.mark.filterwarnings("ignore::vasowave.base.VasowaveWarning")
VOXEL, SIZE = 0.002, (60, 48, 48)
Z, Y, X = np.indices(SIZE).astype(float)
MIDDLE, RADIUS = 20.0, 6.0
TUBE = (np.hypot(Y - MIDDLE, X - MIDDLE) < RADIUS) & (Z > 3)


def clot(offset=2.0, size=3.6):
    """A dark body within the tube, near its wall, or reaching out of it."""
    return (np.hypot(Y - MIDDLE - offset, X - MIDDLE) < size) & (abs(Z - 30) < 9)


def scan(*bright, dark=None):
    """A scan of what is bright, blurred, with noise."""
    agent = np.any(bright, axis=0) & (True if dark is None else ~dark)
    noise = np.random.default_rng(4).normal(0, 4, SIZE)
    return Volume(
        (40 + 150 * ndimage.gaussian_filter(agent.astype(float), 0.8) + noise).astype(np.float32),
        (VOXEL,) * 3,
        (0, 0, 0),
    )


def at(*voxel):
    return VOXEL * np.array(voxel)


def findings(make):
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        made = make()
    return made, [entry.message.finding.code for entry in caught]


def radius_in(volume):
    """The densitometric radius of the tube, voxels."""
    z = np.arange(5.0, 58)
    line = Line(
        VOXEL * np.column_stack([z, np.full_like(z, MIDDLE), np.full_like(z, MIDDLE)]), np.full_like(z, VOXEL * 6)
    )
    return measured_in(Tree((line,), np.array([-1])), volume).network.radius[0] / VOXEL


@pytest.mark.parametrize("offset", [0.0, 2.0])
def test_a_clot_near_the_wall_is_closed(offset):
    volume = scan(TUBE, dark=clot(offset))
    lumen = segment(volume, 100.0)
    inside = np.zeros(SIZE, dtype=bool)
    inside[tuple((lumen.inclusions + lumen.corner).T)] = True
    assert (inside & clot(offset, 2.6)).sum() > 0.9 * clot(offset, 2.6).sum()
    assert not (inside & (np.hypot(Y - MIDDLE, X - MIDDLE) > RADIUS + 1)).any()


def test_radii_are_those_of_the_lumen_with_its_clot():
    volume, whole = scan(TUBE, dark=clot()), radius_in(scan(TUBE))
    lumen = segment(volume, 100.0)
    mended = without_inclusions(volume, lumen.mask, lumen.corner, lumen.inclusions)
    assert radius_in(mended) == pytest.approx(whole, rel=0.01)
    assert abs(radius_in(volume) / whole - 1) > 0.03
    assert (mended.grey >= volume.grey).all()


def test_clefts_between_vessels_are_no_inclusions():
    fork = (np.hypot(Y - MIDDLE - 0.45 * np.maximum(Z - 20, 0), X - MIDDLE) < 5) | TUBE
    beside = (np.hypot(Y - MIDDLE - 2 * RADIUS - 2, X - MIDDLE) < RADIUS) & (Z > 3)
    third = (np.hypot(Y - MIDDLE - RADIUS - 1, X - MIDDLE - np.sqrt(3) * (RADIUS + 1)) < RADIUS) & (Z > 3)
    spread = 0.35 * np.maximum(Z - 20, 0)
    ways = [np.hypot(Y - MIDDLE - spread * np.cos(a), X - MIDDLE - spread * np.sin(a)) < 4.5 for a in (0.1, 2.2, 4.3)]
    trifurcation = (np.any(ways, axis=0) & (Z > 18)) | (TUBE & (Z < 22))
    away = 0.36 * np.maximum(Z - 20, 0)
    four = [
        np.hypot(Y - MIDDLE - away * np.cos(a), X - MIDDLE - away * np.sin(a)) < 5 for a in np.arange(4) * 1.57 + 0.2
    ]
    node = (np.any(four, axis=0) & (Z > 18)) | (TUBE & (Z < 22))
    for mask in (TUBE, fork, TUBE | beside, TUBE | beside | third, trifurcation, node):
        assert len(dark_inclusions(mask, np.argwhere(mask))) == 0


def test_a_hole_of_a_mask_that_was_drawn_stays_open_to_where_it_was_cut():
    volume = scan(TUBE)
    mask = TUBE & ~clot(4.0)
    lumen = EditedMask(mask, volume, 100.0)(volume, 100.0, None)
    assert len(lumen.inclusions) == 0
    assert lumen.mask.sum() == pytest.approx(mask.sum(), rel=0.01)


ROD = np.hypot(Y - MIDDLE, X - MIDDLE - 16.0) < 11.0
PLATE = abs(Z - 52.0) < 1.6


@pytest.mark.parametrize("stranger", [ROD, PLATE])
def test_what_leaves_the_image_and_is_no_vessel_is_cut_off_and_named(stranger):
    volume = scan((np.hypot(Y - MIDDLE, X - MIDDLE) < RADIUS) & (Z > 3) & (Z < 56), stranger)
    lumen = segment(volume, 100.0, at(10, 20, 20))
    cut, codes = findings(lambda: without_strangers(lumen, SIZE, at(4, 20, 20)))
    assert codes == ["image.stranger"]
    middle = tuple(np.round((at(30, 20, 20) - cut.origin) / VOXEL).astype(int))
    assert cut.mask[middle]
    assert cut.mask.sum() < 1.05 * TUBE.sum()
    assert (cut.grey[~cut.mask] <= 100.0).all()


def test_a_plate_that_ends_within_the_image_is_cut_off_too():
    plate = (abs(Z - 54.0) < 2) & (np.hypot(Y - 24, X - 24) < 20)
    lumen = segment(scan(TUBE & (Z < 53), plate), 100.0, at(10, 20, 20))
    cut, codes = findings(lambda: without_strangers(lumen, SIZE, at(4, 20, 20)))
    assert codes == ["image.stranger"]
    assert lumen.mask.sum() > 1.3 * cut.mask.sum()
    assert 0.8 * (TUBE & (Z < 53)).sum() < cut.mask.sum() < 1.05 * (TUBE & (Z < 53)).sum()


def test_a_plate_within_the_image_on_which_the_root_stands_is_named_and_left():
    plate = (abs(Z - 20.0) < 2) & (np.hypot(Y - 26, X - 26) < 21)
    lumen = segment(scan((np.hypot(Y - 8, X - 8) < 3) & (Z > 3) & (Z < 56), plate), 100.0)
    cut, codes = findings(lambda: without_strangers(lumen, SIZE, at(20, 26, 26)))
    assert codes == ["image.stranger-left"]
    assert cut is lumen


def test_a_flat_vessel_is_no_plate():
    flat = (((Y - 24) / 9.0) ** 2 + ((X - 24) / 3.5) ** 2 < 1) & (Z > 3) & (Z < 56)
    lumen = segment(scan(flat), 100.0)
    assert without_strangers(lumen, SIZE, at(6, 24, 24)) is lumen


def test_a_rod_far_from_the_root_cuts_no_wide_vessel_between():
    """An artery widens behind the cannula to more than the rod's middle is deep; it does not leave the image."""
    artery = (np.hypot(Y - MIDDLE, X - MIDDLE) < np.where(Z < 15, 4.0, 6.0)) & (Z > 3) & (Z < 45)
    rod = np.hypot(Z - 52.0, X - MIDDLE) < 7.0
    lumen = segment(scan(artery | ((np.hypot(Y - MIDDLE, X - MIDDLE) < 3) & (Z > 40)), rod), 100.0)
    cut, codes = findings(lambda: without_strangers(lumen, SIZE, at(8, 20, 20)))
    assert codes == ["image.stranger"]
    assert (cut.mask.sum() - artery.sum()) / artery.sum() > -0.1


def test_a_vessel_that_leaves_the_image_is_no_stranger():
    lumen = segment(scan(np.hypot(Y - MIDDLE, X - MIDDLE) < RADIUS), 100.0)
    same, codes = findings(lambda: without_strangers(lumen, SIZE, at(4, 20, 20)))
    assert same is lumen
    assert codes == []


def test_an_extraction_names_the_vessel_with_a_clot():
    volume = scan(TUBE & (Z < 57), dark=clot())
    extraction = lung.extract(volume, root=tuple(at(4, 20, 20)), threshold=100, species="other", cannula=0)
    assert len(extraction.network) == 1
    assert "image.inclusions" in [doubt.finding.code for doubt in extraction.doubts]


def test_a_first_look_measures_the_lumen_with_its_clot():
    vessel = (np.hypot(Y - MIDDLE, X - MIDDLE) < RADIUS) & (Z > 3) & (Z < 57)
    whole = lung.look(scan(vessel), 100, species="other", cannula=0).measured.network.radius[0]
    clotted = lung.look(scan(vessel, dark=clot()), 100, species="other", cannula=0)
    assert clotted.measured.network.radius[0] == pytest.approx(whole, rel=0.01)


def test_a_stranger_that_lies_at_the_root_is_told_and_left():
    lumen = segment(scan(PLATE | (TUBE & (Z < 56))), 100.0)
    same, codes = findings(lambda: without_strangers(lumen, SIZE, at(52, 20, 36)))
    assert same is lumen
    assert codes == ["image.stranger-left"]
