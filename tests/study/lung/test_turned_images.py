"""Images that lie askew in the world: masks, surfaces, lines and places are where a viewer shows the vessels."""

import json
import locale
import warnings
from dataclasses import replace

import numpy as np
import pytest
import SimpleITK
from scipy.spatial.transform import Rotation

from vasowave.base import InputError, VasowaveWarning
from vasowave.lung import Options, extract, written
from vasowave.lung.exchange import read_centerlines
from vasowave.lung.read import Volume, read_labels, read_volume, write_volume
from vasowave.study.report import write_extraction

ROOT = np.array([6.0, 30.0, 25.0])  # voxels along z, y, x of the image
INWARD = np.array([2.0, 0.0, 0.0])
JUNCTION = np.array([30.0, 30.0, 25.0])
ENDS = np.array([[62.0, 12.0, 30.0], [60.0, 50.0, 18.0]])
SPACING = 0.01
FORMATS = ("nrrd", "nii.gz", "mha", "dicom")


def fork_image(longer=0):
    """A parent, `longer` by so many voxels, and two daughters: grey levels along z, y, x."""
    grid = np.stack(np.indices((72 + longer, 62, 48)), axis=-1).astype(float) - [longer, 0, 0]
    inside = np.zeros(grid.shape[:3])
    for begin, end, radius in (
        (ROOT - [longer, 0, 0], JUNCTION, 5.0),
        (JUNCTION, ENDS[0], 4.0),
        (JUNCTION, ENDS[1], 3.2),
    ):
        along = (end - begin) / np.linalg.norm(end - begin)
        at = (grid - begin) @ along
        held = np.clip(at, 0, np.linalg.norm(end - begin))  # round where vessels meet, flat where they end
        away = np.linalg.norm(grid - begin - held[..., None] * along, axis=-1)
        seen = at > 0 if end is JUNCTION else (grid - end) @ along < 0
        inside = np.maximum(inside, np.clip(radius - away + 0.5, 0, 1) * seen)
    return 12 + 88 * inside + np.random.default_rng(0).normal(0, 3, inside.shape)


def saved(grey, turn, kind, folder):
    """Write the image by SimpleITK, or as DICOM, turned by `turn` (x, y, z); return the file and its image."""
    image = SimpleITK.GetImageFromArray(np.round(grey).astype(np.int16))
    image.SetSpacing([10 * SPACING] * 3)
    image.SetOrigin([-12.5, 30.25, 7.75])
    image.SetDirection(turn.ravel().tolist())
    if kind != "dicom":
        path = folder / f"turned.{kind}"
        SimpleITK.WriteImage(image, str(path))
        return path, SimpleITK.ReadImage(str(path))
    path = folder / "turned"
    path.mkdir()
    before = locale.setlocale(locale.LC_ALL)
    writer = SimpleITK.ImageFileWriter()
    writer.KeepOriginalImageUIDOn()
    for z in range(image.GetSize()[2]):
        piece = image[:, :, z]
        place = image.TransformIndexToPhysicalPoint((0, 0, z))
        tags = {
            "0008|0060": "CT", "0020|000e": "1.2.3", "0020|000d": "1.2.4", "0020|0013": str(z),
            "0008|0018": f"1.2.3.{z}",
            "0020|0032": "\\".join(f"{one:.9g}" for one in place),
            "0020|0037": "\\".join(f"{one:.9g}" for one in turn.T[:2].ravel()),
        }  # fmt: skip
        for key, value in tags.items():
            piece.SetMetaData(key, value)
        writer.SetFileName(str(path / f"{z:03}.dcm"))
        writer.Execute(piece)
    locale.setlocale(locale.LC_ALL, before)  # the writer of DICOM leaves "C" behind, and with it ASCII for all texts
    return path, image


def seen_at(image, zyx):
    """Return where a viewer shows a voxel: x, y, z, cm."""
    return np.array(image.TransformContinuousIndexToPhysicalPoint([float(one) for one in zyx[::-1]])) / 10


def random_turn(seed):
    return Rotation.random(random_state=np.random.default_rng(seed)).as_matrix()


@pytest.fixture(
    scope="module",
    params=["nrrd", "nii.gz", *(pytest.param(one, marks=pytest.mark.validation) for one in ("mha", "dicom"))],
)
def turned(request, tmp_path_factory):
    """Folder of an extraction from an image turned by random angles, that image as SimpleITK reads it, and more."""
    folder = tmp_path_factory.mktemp(request.param.replace(".", ""))
    path, image = saved(fork_image(), random_turn(FORMATS.index(request.param)), request.param, folder)
    root, ends = seen_at(image, ROOT + INWARD), [seen_at(image, end)[::-1].tolist() for end in ENDS]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", VasowaveWarning)
        found = extract(path, Options(root[::-1].tolist(), ends, cannula=0))
    write_extraction(found, folder / "out")
    return folder / "out", image, found, path


def test_the_mask_lies_over_the_image_for_another_reader(turned):
    folder, image, *_ = turned
    mask = SimpleITK.ReadImage(str(folder / "mask.nrrd"))
    there = SimpleITK.GetArrayFromImage(
        SimpleITK.Resample(mask, image, SimpleITK.Transform(), SimpleITK.sitkNearestNeighbor)
    )
    bright = SimpleITK.GetArrayFromImage(SimpleITK.SmoothingRecursiveGaussian(image, 0.06)) > 45
    overlap = 2 * (there & bright).sum() / (there.sum() + bright.sum())
    assert overlap >= 0.97


def test_lines_and_surface_run_where_the_vessels_are_in_the_world(turned):
    folder, image, *_ = turned
    inside = SimpleITK.GetArrayFromImage(image) > 45
    for file, unit in (("centerlines.vtp", 0.1), ("centerlines.swc", 1e-4)):
        line = read_centerlines(folder / file, unit, cut="identical").line
        voxels = [image.TransformPhysicalPointToIndex((10 * point[::-1]).tolist()) for point in line.points]
        hit = [inside[z, y, x] for x, y, z in voxels]
        assert np.mean(hit) >= 0.97
    corners = (
        np.fromfile(folder / "surface.stl", np.uint8)[84:].reshape(-1, 50)[:, 12:48].copy().view("<f4").reshape(-1, 3)
    )
    distance = SimpleITK.SignedMaurerDistanceMap(image > 45, squaredDistance=False, useImageSpacing=True)
    reach = [distance[image.TransformPhysicalPointToIndex(point.astype(float).tolist())] for point in corners[::97]]
    assert np.abs(reach).max() < 2.5 * 10 * SPACING
    assert np.mean(np.abs(reach)) < 10 * SPACING


def test_vessels_begin_and_end_at_the_places_of_the_viewer(turned):
    _, image, found, _ = turned
    ends = np.array([found.tree.lines[row].points[-1] for row in found.tree.terminals])
    for true in ENDS:
        assert np.linalg.norm(ends - seen_at(image, true)[::-1], axis=1).min() < 3 * SPACING
    junction = found.tree.lines[0].points[-1]
    assert np.linalg.norm(junction - seen_at(image, JUNCTION)[::-1]) < 0.7 * 5 * SPACING  # radii of the parent


@pytest.mark.parametrize("turned", ["mha"], indirect=True)
def test_an_edit_and_an_outlet_too_far_are_at_places_of_the_viewer(turned, tmp_path):
    _, image, found, path = turned
    middle = seen_at(image, 0.4 * JUNCTION + 0.6 * ENDS[1])
    edits = tmp_path / "edits.txt"
    edits.write_text("remove {} {} {}\n".format(*middle))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", VasowaveWarning)
        options = Options(found.root, [seen_at(image, end)[::-1] for end in ENDS], cannula=0, edits=edits)
        left = extract(path, options)
        assert len(left.network) == 1
        end = left.tree.lines[0].points[-1]
        assert np.linalg.norm(end - seen_at(image, ENDS[0])[::-1]) < 3 * SPACING
        far = seen_at(image, ENDS[0] + np.array([0.0, -11.0, 0.0]))
        with pytest.raises(InputError, match="do not lie at the lumen") as told:
            extract(path, replace(options, edits=None, outlets=[far[::-1]]))
    assert written(far[::-1]) in str(told.value)


def test_the_mask_is_taken_back_and_one_that_lies_otherwise_is_refused(turned, tmp_path):
    folder, *_, path = turned
    volume = read_volume(path)
    assert read_labels(folder / "mask.nrrd", volume).sum() > 1000
    straight = Volume(np.asarray(volume.grey), volume.spacing, volume.origin)
    write_volume(straight, tmp_path / "straight.nrrd")
    if not np.allclose(volume.axes, np.eye(3), atol=0.01):
        with pytest.raises(InputError, match="turned against the image"):
            read_labels(tmp_path / "straight.nrrd", volume)


def test_the_places_in_the_records_are_those_of_the_viewer(turned):
    folder, image, *_ = turned
    stored = json.loads((folder / "extraction.json").read_text())
    root = [float(one) for one in stored["settings"]["root used (x,y,z, cm)"].split(",")]
    np.testing.assert_allclose(root, seen_at(image, ROOT + INWARD), atol=1e-4)


@pytest.mark.parametrize("suffix", ["nrrd", "nii", "mha"])
def test_a_turned_volume_is_written_as_it_lies(suffix, tmp_path):
    axes = Rotation.from_euler("zyx", [20, -11, 33], degrees=True).as_matrix()
    grey = np.random.default_rng(0).normal(size=(5, 6, 7)).astype(np.float32)
    volume = Volume(grey, np.array([0.01, 0.02, 0.03]), np.array([1.0, 2.0, 3.0]), axes)
    write_volume(volume, tmp_path / f"v.{suffix}")
    again = read_volume(tmp_path / f"v.{suffix}")
    np.testing.assert_array_equal(again.grey, grey)
    np.testing.assert_allclose(again.axes, axes, atol=1e-6)  # NIfTI holds a quaternion of single precision
    image = SimpleITK.ReadImage(str(tmp_path / f"v.{suffix}"))
    np.testing.assert_allclose(
        volume.frame.world(np.add(volume.origin, [0.03, 0.04, 0.09]))[::-1], seen_at(image, [3, 2, 3]), atol=1e-6
    )
