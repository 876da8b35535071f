"""What people feed the command by mistake: each time one clear error or warning, and nothing half-written."""

import warnings

import numpy as np
import pydicom
import pytest
from scipy.spatial import cKDTree

from extract_command import run
from made_phantom import outlets_of, phantom, root_of
from phantom import write_dicom_series
from vasowave.base import InputError, VasowaveWarning
from vasowave.lung import Options, extract, written
from vasowave.lung.read import Volume, read_volume, write_volume


@pytest.fixture(scope="module")
def scan():
    return phantom()


@pytest.fixture(scope="module")
def image(scan, tmp_path_factory):
    path = tmp_path_factory.mktemp("image") / "image.nrrd"
    write_volume(scan[1], path)
    return path


def refused(message, tmp_path, *arguments):
    """Run, expect an InputError that holds `message`, and nothing where the result would be or beside it."""
    before = sorted(tmp_path.rglob("*"))
    result, _ = run(*arguments, "-o", tmp_path / "out")
    assert isinstance(result.exception, InputError), repr(result.exception) + result.output
    assert message in str(result.exception)
    assert sorted(tmp_path.rglob("*")) == before


@pytest.fixture
def series(scan, tmp_path):
    write_dicom_series(Volume(scan[1].grey[:8, :40, :40], scan[1].spacing, scan[1].origin), tmp_path / "dicom")
    return tmp_path / "dicom"


def test_two_series_in_one_folder(series, tmp_path):
    write_dicom_series(
        Volume(np.random.default_rng(0).normal(size=(4, 40, 40)), np.full(3, 0.01), np.zeros(3)), tmp_path / "b"
    )
    (tmp_path / "b" / "slice0002.dcm").rename(series / "zz.dcm")
    refused("more than one series", tmp_path, series, "--root", "0,0,0")


@pytest.mark.parametrize(("shift", "upright"), [(0.1, True), (0.2, False)])
def test_slices_of_a_tilted_gantry_are_refused_and_rounded_positions_are_not(series, tmp_path, shift, upright):
    """Eight slices, each a share of a voxel (0.05 mm and more) further to the side."""
    for place, file in enumerate(sorted(series.iterdir())):
        image = pydicom.dcmread(file)
        x, y, z = map(float, image.ImagePositionPatient)
        image.ImagePositionPatient = [x, y + shift * place * float(image.PixelSpacing[0]), z]
        image.save_as(file)
    if upright:
        assert read_volume(series).grey.shape == (8, 40, 40)
    else:
        said = "shifted sideways (slice0008.dcm by 1.4 voxels from slice0001.dcm)"
        refused(said, tmp_path, series, "--root", "0,0,0")


def test_a_text_file_among_the_slices(series, tmp_path):
    (series / "notes.txt").write_text("scanned on Monday")
    assert read_volume(series).grey.shape == (8, 40, 40)


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("v.nrrd", b"NRRD0004\ntype: flaot\n\n", "v.nrrd: not an image that can be read"),
        ("v.mhd", b"ObjectType = Image\nNDims = 3\nDimSize = 4 4 4\nElementDataFile = gone.raw\n", "v.mhd: not"),
        ("v.nii", b"NIFTI" * 200, "v.nii: not a NIfTI file"),
        ("v.tif", b"II*\0rubbish", "v.tif: not a readable TIFF stack"),
        ("v.raw", b"\0" * 64, "RAW says nothing about its size"),
        ("v.jpg", b"\xff\xd8\xff\xe0", "v.jpg: not an image that can be read"),
    ],
)  # fmt: skip
def test_a_header_that_cannot_be_read(tmp_path, name, content, message):
    (tmp_path / name).write_bytes(content)
    refused(message, tmp_path, tmp_path / name, "--root", "0,0,0")


def test_a_flat_picture(tmp_path):
    import SimpleITK

    SimpleITK.WriteImage(SimpleITK.GetImageFromArray(np.eye(9, dtype=np.float32)), str(tmp_path / "flat.nrrd"))
    refused("not a three-dimensional grey-level image", tmp_path, tmp_path / "flat.nrrd", "--root", "0,0,0")


def test_a_voxel_size_wrong_by_a_factor_of_ten_shows_at_the_cannula(scan, image, tmp_path):
    embedding, volume = scan
    # The file's origin is kept, so places move with the voxels.
    far = [
        written(volume.origin + 10 * (np.asarray(place) - volume.origin))
        for place in (embedding.cannula[0], *(embedding.lines[row][-1] for row in (2, 3, 4)))
    ]
    outlets = [argument for place in far[1:] for argument in ("--outlet", place)]
    arguments = (image, "--voxel", "0.095", "--root", far[0], *outlets)
    refused("no mouse is like that", tmp_path, *arguments)
    refused("the voxel size is wrong", tmp_path, *arguments, "--species", "other")
    refused("write one positive number", tmp_path, image, "--voxel", "-1", "--root", far[0])


@pytest.mark.validation
def test_a_root_at_the_wrong_end(scan, image, tmp_path):
    embedding, _ = scan
    wrong = written(embedding.lines[2][-2])
    ends = [embedding.cannula[0] + [0.02, 0, 0], embedding.lines[3][-1], embedding.lines[4][-1]]
    outlets = [argument for place in ends for argument in ("--outlet", written(place))]
    refused("not at the cannula's outer end", tmp_path, image, "--root", wrong, *outlets)
    result, notes = run(
        image, "-o", tmp_path / "out", "--root", wrong, "--cannula", "0", "--species", "other", *outlets
    )
    assert result.exit_code == 0, repr(result.exception)
    assert any("is wider than the root" in note for note in notes), notes
    assert "is wider than the root" in (tmp_path / "out" / "review.html").read_text()


@pytest.mark.validation
def test_a_tree_that_touches_the_border_and_a_second_tree_beside_it(scan, tmp_path):
    embedding, volume = scan
    low = int((embedding.cannula[0, 0] + 0.05 - volume.origin[0]) / volume.spacing[0])
    grey = np.array(volume.grey[low:])
    tip = np.round((embedding.lines[4][-1] - volume.origin) / volume.spacing).astype(int)
    y, x = (10 if at > 70 else 120 for at in tip[1:])
    grey[20:90, y : y + 8, x : x + 8] = 100
    cut = Volume(grey, volume.spacing, volume.origin + np.array([low, 0, 0]) * volume.spacing)
    write_volume(cut, tmp_path / "cut.nrrd")
    root = written(np.array([cut.origin[0], *embedding.cannula[0, 1:]]))
    result, notes = run(tmp_path / "cut.nrrd", "-o", tmp_path / "out", "--root", root, *outlets_of(embedding))
    assert result.exit_code == 0, repr(result.exception)
    assert any("touches the border" in note for note in notes), notes
    result, notes = run(tmp_path / "cut.nrrd", "-o", tmp_path / "other")
    assert result.exit_code == 0, repr(result.exception)
    assert any("two separate trees" in note for note in notes), notes
    assert any("no root was given" in note for note in notes), notes


def test_every_outlet_that_is_not_at_the_lumen_is_named(scan, image, tmp_path):
    embedding, _ = scan
    far = ["--outlet", "0.5,0.5,-0.1", "--outlet", "-0.5,0.5,-0.1"]
    arguments = (image, "--root", root_of(embedding), *outlets_of(embedding), *far)
    refused("2 of 5 outlets (x,y,z, cm) do not lie at the lumen: 0.5,0.5,-0.1 (", tmp_path, *arguments)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--root", "1,2"], "'1,2' is not a place; write three numbers"),
        (["--root", "1,2,3 furlong"], "'furlong' is not a unit of length"),
        (["--root", "0.4,0.4,0"], "is not inside a vessel"),
        (["--threshold", "500"], "no voxel is brighter than 500"),
        (["--threshold", "1"], "more than half of the volume is brighter than 1"),
        (["--method", "magic"], "method: 'magic' is not known; choose from: threshold, level-set"),
        (["--scale", "ruler"], "scale: 'ruler' is not known"),
        (["--scale", "cannula", "--cannula", "0"], "needs a cannula of known diameter"),
        (["--generations", "2", "--vessels", "3"], "keep either"),
        (["--min-radius", "0.2"], "nothing would be kept"),
        (["--region", "0,0,0"], "region '0,0,0': no such file, and no box"),
        (["--mask", "gone.nrrd"], "gone.nrrd: no such file"),
        (["--edits", "gone.txt"], "gone.txt: the edits cannot be read"),
        (["--outlets", "gone.csv"], "gone.csv"),
    ],
)
def test_an_option_that_makes_no_sense(scan, image, tmp_path, arguments, message):
    root = [] if "--root" in arguments else ["--root", root_of(scan[0])]
    refused(message, tmp_path, image, *root, *arguments)


def test_a_folder_that_holds_something_else_is_not_touched(image, tmp_path):
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "thesis.txt").write_text("mine")
    refused("not empty and not a vasowave result", tmp_path, image, "--root", "0,0,0")


@pytest.mark.validation
def test_a_region_cuts_the_tree_off_in_the_command(scan, image, tmp_path):
    embedding, volume = scan
    low, high = volume.origin.copy(), volume.origin + (np.array(volume.grey.shape) - 1) * volume.spacing
    high[0] = embedding.lines[0][-1, 0] - 0.1  # before the first junction
    box = f"{written(low)}:{written(high)}"
    result, _ = run(image, "-o", tmp_path / "out", "--root", root_of(embedding), "--region", box)
    assert result.exit_code == 0, repr(result.exception)
    assert len((tmp_path / "out" / "network.csv").read_text().splitlines()) == 2


@pytest.mark.parametrize(
    ("lengths", "cm"),
    [
        ("spacings: 0.1 0.1 0.1", 0.01),
        ('spacings: 0.01 0.01 0.01\nunits: "cm" "cm" "cm"', 0.01),
        ('spacings: 100 100 100\nunits: "microns" "microns" "microns"', 0.01),
        ('space: left-posterior-superior\nspace directions: (0.01,0,0) (0,0.01,0) (0,0,0.01)\nspace origin: (1,2,3)\n'
         'space units: "cm" "cm" "cm"', 0.01),
        ('space: left-posterior-superior\nspace directions: (0.1,0,0) (0,0.1,0) (0,0,0.1)\nspace origin: (10,20,30)\n'
         'space units: "mm" "mm" "mm"', 0.01),
    ],
)  # fmt: skip
def test_an_nrrd_file_has_lengths_in_the_unit_that_it_names(tmp_path, lengths, cm):
    path = nrrd(tmp_path, lengths)
    volume = read_volume(path)
    np.testing.assert_allclose(volume.spacing, cm)
    if "origin" in lengths:
        np.testing.assert_allclose(volume.origin, [3, 2, 1])


def test_an_nrrd_file_with_lengths_in_no_unit_of_a_length_is_refused_unless_its_voxels_are_given(tmp_path):
    for units in ('"furlong" "furlong" "furlong"', '"mm" "mm" "cm"'):
        path = nrrd(tmp_path, f"spacings: 0.01 0.01 0.01\nunits: {units}")
        with pytest.raises(InputError, match="which is not a unit of a length, so that the size of its voxels"):
            read_volume(path)
        np.testing.assert_allclose(read_volume(path, 0.02).spacing, 0.02)


def nrrd(folder, lengths):
    """Write a volume whose header has these lines about lengths."""
    path = folder / "lung.nrrd"
    head = f"NRRD0005\ntype: uint8\ndimension: 3\nsizes: 5 6 7\nencoding: raw\nendian: little\n{lengths}\n\n"
    path.write_bytes(head.encode() + bytes(range(210)))
    return path


def test_what_a_bubble_cuts_off_is_a_doubt_of_the_vessel_before_it_and_what_runs_beside_is_none(scan):
    """Two thirds of vessel 4 of five lie behind a bubble wider than itself; a wire runs beside another vessel."""
    embedding, volume = scan
    line = embedding.lines[3]
    at, radius = line[len(line) // 3], 0.045
    places = volume.origin + np.indices(volume.grey.shape).reshape(3, -1).T * volume.spacing
    grey = np.array(volume.grey)
    grey.reshape(-1)[np.linalg.norm(places - at, axis=1) < radius] = grey.min()
    beside = embedding.lines[4][len(embedding.lines[4]) // 3 :] + np.array([0.0, -0.085, 0.0])
    wire = cKDTree(beside).query(places)[0] < 0.02
    grey.reshape(-1)[wire] = 100
    root = embedding.cannula[0] + np.array([0.02, 0, 0])
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", VasowaveWarning)
        found = extract(Volume(grey, volume.spacing, volume.origin), Options(root.tolist()))
    (doubt,) = (one for one in found.doubts if one.finding.code == "witness.separate-piece")
    assert len(found.lumen.apart) == 2
    (note,) = (one for one in found.notes if one.code == "image.separate-pieces")
    assert dict(note.values)["count"] == 1
    assert (doubt.about, doubt.grade) == ("topology", "look")
    assert np.linalg.norm(doubt.places[0] - at) < 2 * radius
    (row,) = (found.network.name.index(name) for name in doubt.vessels)
    assert cKDTree(found.tree.lines[row].points).query(at)[0] < 2.5 * radius
