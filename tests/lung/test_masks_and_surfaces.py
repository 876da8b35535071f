import numpy as np
import pytest
import SimpleITK

from vasowave.base import InputError
from vasowave.lung import Options, given
from vasowave.lung.lumen import (
    EditedMask,
    Within,
    box_region,
    full_mask,
    level_set,
    segment,
    smooth_surface,
    write_mask,
)
from vasowave.lung.read import Volume, isotropic, marks, on_grid_of, read_labels, read_volume, write_volume


def enclosed_volume(surface):
    """Return the volume inside a closed surface, cm³: positive if its triangles face outward."""
    a, b, c = (surface.points[surface.triangles[:, k], ::-1] for k in range(3))
    return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6)


def tube(noise=4.0, radius=5.0, seed=0):
    """A rounded tube along x in 40 × 44 × 60 voxels of 0.01 cm, away from the border."""
    z, y, x = np.indices((40, 44, 60))
    axis = np.clip(x, 12, 48)
    distance = np.sqrt((z - 19.3) ** 2 + (y - 22.6) ** 2 + (x - axis) ** 2) - radius
    grey = 12 + 88 * np.clip(0.5 - distance, 0, 1) + np.random.default_rng(seed).normal(0, noise, distance.shape)
    return Volume(grey, np.full(3, 0.01), np.array([1.0, 2.0, 3.0]))


def test_the_surface_encloses_the_volume_of_the_tube_and_faces_outward():
    lumen = segment(tube(noise=0.01), 56)
    true = np.pi * 0.05**2 * 0.36 + 4 / 3 * np.pi * 0.05**3
    assert enclosed_volume(smooth_surface(lumen)) == pytest.approx(true, rel=0.02)  # smoothing pulls a curved wall in


def test_smoothing_flattens_noise_and_keeps_the_volume():
    lumen = segment(tube(noise=15), 56)
    rough, smooth = smooth_surface(lumen, 0), smooth_surface(lumen, 10)

    def tilt(surface):
        """Mean angle between the triangles along the tube and its true surface."""
        a, b, c = (surface.points[surface.triangles[:, k]] for k in range(3))
        middle, normal = (a + b + c) / 3, np.cross(c - a, b - a)
        along = (middle[:, 2] > 3.15) & (middle[:, 2] < 3.45)
        radial = (middle - [1.193, 2.226, 0])[along] * [1, 1, 0]
        cosine = (radial * normal[along]).sum(1) / np.linalg.norm(radial, axis=1)
        return np.arccos(cosine / np.linalg.norm(normal[along], axis=1)).mean()

    assert tilt(smooth) < 0.8 * tilt(rough)
    assert enclosed_volume(smooth) == pytest.approx(enclosed_volume(rough), rel=0.01)


def test_a_written_mask_reads_back_and_as_lumen_gives_the_same_voxels(tmp_path):
    image = tube()
    lumen = segment(image, 45)
    write_mask(lumen, image, tmp_path / "m.nrrd")
    labels = read_labels(tmp_path / "m.nrrd", image)
    assert labels.sum() == lumen.mask.sum()
    again = EditedMask(labels > 0, image, 45)(image, 45, np.array([1.193, 2.226, 3.3]))
    np.testing.assert_array_equal(full_mask(again, image), full_mask(lumen, image))
    np.testing.assert_allclose(again.grey, lumen.grey)


def test_what_was_painted_over_the_mask_overrules_the_threshold():
    image = tube()
    mask = full_mask(segment(image, 45), image)
    mask[:, :, :20] = False  # erased
    mask[19, 22, 40:58] = True  # a thread drawn through the background
    found = full_mask(EditedMask(mask, image, 45)(image, 45, np.array([1.193, 2.226, 3.3])), image)
    np.testing.assert_array_equal(found, mask)
    wider = full_mask(EditedMask(mask, image, 45)(image, 36, np.array([1.193, 2.226, 3.3])), image)
    assert wider.sum() > mask.sum()
    assert not wider[:, :, :17].any()


def test_a_mask_serves_a_part_of_its_image_too():
    image = tube()
    mask = full_mask(segment(image, 45), image)
    mask[:, :, :20] = False
    part = Volume(image.grey[4:, 5:, 6:], image.spacing, image.origin + 0.01 * np.array([4, 5, 6]))
    found = EditedMask(mask, image, 45)(part, 45, np.array([1.193, 2.226, 3.3]))
    np.testing.assert_array_equal(full_mask(found, image), mask)


def test_a_mask_of_an_anisotropic_image_goes_to_the_cubes_and_back(tmp_path):
    fine = tube(noise=1)
    image = Volume(fine.grey[::2], np.array([0.02, 0.01, 0.01]), fine.origin)
    volume = isotropic(image)
    lumen = segment(volume, 56)
    write_mask(lumen, image, tmp_path / "m.nii.gz")
    labels = read_labels(tmp_path / "m.nii.gz", image)
    back = on_grid_of(labels, image, volume)
    assert back.shape == volume.grey.shape
    assert (back > 0).sum() == pytest.approx(lumen.mask.sum(), rel=0.1)


@pytest.mark.parametrize(
    ("shape", "spacing", "origin", "value", "message"),
    [
        ((40, 44, 59), 0.01, (1, 2, 3), 1, r"59 × 44 × 40 voxels, the image 60 × 44 × 40"),
        ((40, 44, 60), 0.1, (1, 2, 3), 1, r"voxels measure 1, 1, 1 mm \(x, y, z\), the image's 0\.1, 0\.1, 0\.1"),
        ((40, 44, 60), 0.01, (1, 2, 3.1), 1, r"begins at 31, 20, 10 mm .* the image at 30, 20, 10"),
        ((40, 44, 60), 0.01, (1, 2, 3), 0.5, "this is an image, not a mask"),
    ],
)
def test_a_mask_that_does_not_fit_the_image_is_refused(tmp_path, shape, spacing, origin, value, message):
    grey = np.zeros(shape)
    grey[20, 20, 20] = value
    write_volume(Volume(grey, np.full(3, spacing), np.array(origin)), tmp_path / "m.nrrd")
    with pytest.raises(InputError, match=message):
        read_labels(tmp_path / "m.nrrd", tube())


def test_labels_above_one_mark_root_and_outlets():
    image = tube()
    labels = np.zeros(image.grey.shape, dtype=int)
    labels[18:21, 22:25, 10:50] = 1
    labels[18:21, 22:25, 10:13] = 2
    labels[19, 23, 49] = 5
    found = marks(labels, image)
    assert sorted(found) == [2, 5]
    np.testing.assert_allclose(found[2], [1.19, 2.23, 3.11])
    np.testing.assert_allclose(found[5], [1.19, 2.23, 3.49])


def test_nothing_outside_the_region_is_lumen():
    image = tube()
    box = box_region(image, np.array([1.0, 2.0, 3.25]), np.array([1.4, 2.5, 3.0]))
    found = full_mask(Within(box, image)(image, 45, np.array([1.193, 2.226, 3.2])), image)
    assert found[:, :, :25].any()
    assert not found[:, :, 27:].any()
    with pytest.raises(InputError, match=r"the image spans 30, 20, 10 to 35\.9, 24\.3, 13\.9 mm"):
        box_region(image, np.array([9.0, 9, 9]), np.array([10.0, 10, 10]))


def test_the_active_contour_finds_the_tube_and_drops_spurs_that_the_threshold_keeps():
    image = tube(noise=12, radius=5.0)
    grey = image.grey.copy()
    grey[19:21, 22:24, 50:58] = 100  # a spur two voxels wide
    image = Volume(grey, image.spacing, image.origin)
    seed = np.array([1.193, 2.226, 3.3])
    plain, smooth = full_mask(segment(image, 45, seed), image), full_mask(level_set(image, 45, seed), image)
    true = tube(noise=0).grey > 56
    assert 2 * (smooth & true).sum() / (smooth.sum() + true.sum()) > 0.93
    assert plain[:, :, 56].any()
    assert not smooth[:, :, 56].any()


def test_a_raw_file_is_read_through_the_header_beside_it(tmp_path):
    image = tube()
    for name in ("a.mhd", "b.nhdr"):
        write_volume(image, tmp_path / name)
        np.testing.assert_array_equal(read_volume((tmp_path / name).with_suffix(".raw")).grey, image.grey)
    (tmp_path / "a.mhd").unlink()
    with pytest.raises(InputError, match=r"RAW says nothing about its size; put its header beside it: a\.mhd"):
        read_volume(tmp_path / "a.raw")


def test_axes_that_a_file_flips_and_turns_are_turned_back(tmp_path):
    image = tube()
    upright = SimpleITK.GetImageFromArray(np.asarray(image.grey))
    upright.SetSpacing((0.1, 0.1, 0.1))
    upright.SetOrigin((30, 20, 10))
    SimpleITK.WriteImage(SimpleITK.DICOMOrient(upright, "RSA"), str(tmp_path / "turned.nrrd"))
    again = read_volume(tmp_path / "turned.nrrd")
    np.testing.assert_array_equal(again.grey, image.grey)
    np.testing.assert_allclose(again.origin, image.origin)


def test_oblique_axes_are_kept_and_the_grey_levels_are_not_resampled(tmp_path):
    image = SimpleITK.GetImageFromArray(np.asarray(tube().grey))
    c, s = np.cos(0.3), np.sin(0.3)
    image.SetDirection((c, -s, 0, s, c, 0, 0, 0, 1))
    SimpleITK.WriteImage(image, str(tmp_path / "oblique.nrrd"))
    found = read_volume(tmp_path / "oblique.nrrd")
    np.testing.assert_array_equal(found.grey, tube().grey)
    np.testing.assert_allclose(found.axes[::-1, ::-1], [[c, -s, 0], [s, c, 0], [0, 0, 1]], atol=1e-12)


def test_a_region_and_a_mask_may_be_files_and_the_lumen_lies_in_both(tmp_path):
    image = tube()
    region, mask = np.zeros(image.grey.shape), full_mask(segment(image, 45), image).astype(float)
    region[:, :, :30], mask[:, :, :20] = 1, 0
    for name, labels in (("region", region), ("mask", mask)):
        write_volume(Volume(labels, image.spacing, image.origin), tmp_path / f"{name}.nrrd")

    def seen(seed, **files):
        segmenter = given(image, image, Options(**files)).segmenter
        return np.flatnonzero(full_mask(segmenter(image, 45, seed), image).any(axis=(0, 1)))[[0, -1]].tolist()

    whole, middle = seen(None), np.array([1.193, 2.226, 3.25])
    assert seen(middle, region=tmp_path / "region.nrrd") == [whole[0], 29]
    assert seen(middle, mask=tmp_path / "mask.nrrd", region=tmp_path / "region.nrrd") == [20, 29]
