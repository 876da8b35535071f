"""Headers of images that say too little, too much or something else: every refusal says its numbers."""

import bz2
import gzip
import struct
import zlib

import numpy as np
import pydicom
import pytest

from phantom import write_dicom_series
from vasowave.base import InputError
from vasowave.lung.read import Volume, isotropic, read_volume

VOXELS = np.arange(27, dtype="<i2").reshape(3, 3, 3)
CONTENT = VOXELS.tobytes()  # 54 bytes
DAMAGED = ": not an image that can be read: its header is damaged; export it again"
SPREAD = ": its voxels are spread over several files; save it as one"


def written(folder, name, content):
    (folder / name).write_bytes(content)
    return folder / name


def refusal(path):
    """Return what is said of a file that is refused, without its path."""
    with pytest.raises(InputError) as error:
        read_volume(path)
    return str(error.value).partition(path.name)[2]


def metaimage(more="", voxels=CONTENT, dim="3 3 3", kind="MET_SHORT", name="LOCAL", count=3, size="1 1 1"):
    head = f"ObjectType = Image\nNDims = {count}\nElementSpacing = {size}\n{more}DimSize = {dim}\n"
    return f"{head}ElementType = {kind}\nElementDataFile = {name}\n".encode() + voxels


def nrrd(more="", voxels=CONTENT, kind="short", sizes="3 3 3", encoding="raw", dimension=3, size="spacings: 1 1 1\n"):
    head = f"NRRD0004\n# a: b\ntype: {kind}\ndimension: {dimension}\nsizes: {sizes}\nencoding: {encoding}\n"
    return f"{head}endian: little\n{size}{more}\n".encode() + voxels


def nifti(version=1, order="<", dim=(3, 3, 3, 3, 1, 1, 1, 1), bits=16, sizes=(0.1, 0.2, 0.3), offset=None, unit=2):
    """A header after the standards: places of the number of bytes, type, sizes, voxels, offset, unit and sign."""
    header = bytearray(352 if version == 1 else 544)
    offset = len(header) if offset is None else offset
    places = {
        1: ((0, "i", [348]), (40, "8h", dim), (70, "2h", [4, bits]), (76, "4f", (1, *sizes)), (108, "f", [offset]),
            (123, "B", [unit]), (344, "4s", [b"n+1\0"])),
        2: ((0, "i", [540]), (4, "8s", [b"n+2\0\r\n\x1a\n"]), (12, "2h", [4, bits]), (16, "8q", dim),
            (104, "4d", (1, *sizes)), (168, "q", [offset]), (500, "i", [unit])),
    }  # fmt: skip
    for at, kind, values in places[version]:
        struct.pack_into(order + kind, header, at, *values)
    return bytes(header)


@pytest.mark.parametrize(
    ("name", "content"),
    [
        ("a.mha", metaimage("HeaderSize = -1\n", b"padding" + CONTENT)),
        ("a.mha", metaimage("TransformMatrix = 1 0 0 0 1 0 0 0 1\n")),
        ("a.nrrd", nrrd("byte skip: 6\n", bytes(6) + CONTENT)),
        ("a.nrrd", nrrd("byte skip: -1\n", b"padding" + CONTENT)),
        ("a.nrrd", nrrd(voxels=gzip.compress(CONTENT), encoding="gzip")),
        ("a.nrrd", nrrd(voxels=" ".join(map(str, VOXELS.ravel())).encode(), encoding="ascii")),
        ("a.nii", nifti() + CONTENT),
        ("a.nii", nifti(offset=368) + bytes(16) + CONTENT),
        ("a.nii", nifti(order=">") + VOXELS.astype(">i2").tobytes()),
        ("a.nii.gz", gzip.compress(nifti() + CONTENT)),
    ],
)
def test_a_header_that_was_made_after_its_description_gives_the_voxels(tmp_path, name, content):
    np.testing.assert_array_equal(np.sort(read_volume(written(tmp_path, name, content)).grey, axis=None), np.arange(27))


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (metaimage(voxels=CONTENT[:-1]), ": truncated, 53 of 54 bytes of voxels; copy or export it again"),
        (metaimage(voxels=CONTENT + b"x"), ": more voxels than the 54 bytes that its header announces; copy"),
        (metaimage(kind="MET_DOUBLE"), ": truncated, 54 of 216"),
        (metaimage("ElementNumberOfChannels = 3\n"), ": truncated, 54 of 162 bytes"),
        (metaimage("ElementNumberOfChannels = 0\n"), DAMAGED),
        (metaimage("HeaderSize = 7\n"), ": truncated, 47 of 54 bytes"),
        (metaimage("HeaderSize = -1\n", CONTENT[:-1]), ": truncated, 53 of 54 bytes"),
        (metaimage("HeaderSize = a\n"), DAMAGED),
        (metaimage("CompressedData = 1\n", zlib.compress(CONTENT[:-1])), ": truncated, 53 of 54"),
        (metaimage("CompressedData = t\n", zlib.compress(CONTENT + b"x")), ": more voxels than the 54"),
        (
            metaimage("CompressedData = True\n", zlib.compress(CONTENT)),
            ": not an image that can be read: its header has no Compressed",
        ),
        (
            metaimage("HeaderSize = 7\n", bytes(7) + CONTENT),
            ": not an image that can be read: its header names the length",
        ),
        (metaimage(count=2), DAMAGED),
        (metaimage(dim="3 0 3"), DAMAGED),
        (metaimage(kind="MET_STRING"), DAMAGED),
        (metaimage("TransformMatrix = nan 0 0 0 1 0 0 0 1\n"), DAMAGED),
        (metaimage(name="LIST"), SPREAD),
        (metaimage(name="b.raw"), ": not an image that can be read: its voxels, "),
        (metaimage().replace(b"ElementDataFile", b"Element"), ": not an image that can be read: its header has no "),
        (metaimage().replace(b"= Image", b"= Tube"), ": not an image that can be read: its ObjectType is Tube"),
        (metaimage().replace(b"ElementSpacing", b"Spacing"), ": its header has no ElementSpacing, so"),
    ],
)
def test_a_metaimage_that_contradicts_itself_is_refused(tmp_path, content, said):
    assert refusal(written(tmp_path, "a.mha", content)).startswith(said)


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (nrrd(kind="double"), ": truncated, 54 of 216"),
        (nrrd("byte skip: 6\n"), ": truncated, 48 of 54"),
        (nrrd("byte skip: -1\n", CONTENT[:-1]), ": truncated, 53 of 54"),
        (nrrd("byte skip: 5\n", gzip.compress(CONTENT), encoding="gzip"), ": truncated, 54 of 59"),
        (nrrd(voxels=bz2.compress(CONTENT + b"x"), encoding="bz2"), ": more voxels than the 54"),
        (nrrd("line skip: -1\n"), DAMAGED),
        (nrrd(dimension=4), DAMAGED),
        (nrrd(sizes="3 0 3"), DAMAGED),
        (nrrd(kind="block"), DAMAGED),
        (nrrd(encoding="lzma"), DAMAGED),
        (nrrd("data file: LIST\n"), ": its header names no files of voxels"),
        (nrrd("data file: v.%03d 1 9 0\n"), ": its header names no files of voxels"),
        (nrrd("data file: LIST\n../b\n"), ": names voxels outside its own folder"),
        (nrrd("data file: LIST\n../b\ndata file: v\n"), ": names voxels outside its own folder"),
        (b"NRRD0004\ntype: short\n", ": not an image that can be read: its header has no end; truncated?"),
        (b"NRRA0004\n\n", ": not an image that can be read: no NRRD file"),
        (nrrd(size="space directions: (1,0,0) none (0,0,1)\n"), ": its header has no (or not all) space directions"),
        (nrrd(size='spacings: 1 1 1\nunits: "sec" "sec" "sec"\n'), ': its header has lengths in "sec" "sec" "sec"'),
    ],
)
def test_an_nrrd_that_contradicts_itself_is_refused(tmp_path, content, said):
    assert refusal(written(tmp_path, "a.nrrd", content)).startswith(said)


NO_VOXELS = ": not a NIfTI file that can be read (its header announces no voxels)"
NO_SIZE = ": its header leaves out a voxel's size (pixdim) or the unit (xyzt_units), so that"


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (nifti(dim=(0, 3, 3, 3, 1, 1, 1, 1)) + CONTENT, NO_VOXELS),
        (nifti(dim=(3, 3, 0, 3, 1, 1, 1, 1)) + CONTENT, NO_VOXELS),
        (nifti(bits=0) + CONTENT, NO_VOXELS),
        (nifti(offset=347) + CONTENT, NO_VOXELS),
        (nifti(sizes=(0.1, 0, 0.3)) + CONTENT, NO_SIZE),
        (nifti(2, unit=0) + CONTENT, NO_SIZE),
        (nifti(unit=4) + CONTENT, NO_SIZE),
        (nifti() + CONTENT[:-1], ": truncated, 405 of 406 bytes of voxels; copy or export it again"),
        (nifti(2, ">") + CONTENT[:-1], ": truncated, 597 of 598"),
        (nifti()[:100], ": truncated; copy or export it again"),
        (bytes(400), ": not a NIfTI file that can be read (its first number is neither 348 nor 540)"),
    ],
)
def test_a_nifti_that_contradicts_itself_is_refused(tmp_path, content, said):
    assert refusal(written(tmp_path, "a.nii", content)).startswith(said)


def test_a_packed_nifti_that_was_cut_or_has_a_twin_is_refused(tmp_path):
    packed = written(tmp_path, "a.nii.gz", gzip.compress(nifti() + CONTENT[:-4]))
    assert refusal(packed).startswith(": truncated")
    written(tmp_path, "a.nii", nifti() + CONTENT)
    assert refusal(packed).startswith(": a.nii lies beside it, and the reader may confuse")


@pytest.mark.parametrize(
    ("height", "said"),
    [
        ([0, 1, 2.5, 3.5], ""),  # one and a half usual distances at most
        ([0, 1, 2.6, 3.6], ": 1 slices missing between slice0002.dcm and slice0003.dcm; export the series again"),
        ([0, 1, 2, 6], ": 3 slices missing between slice0003.dcm and slice0004.dcm; export"),
        ([0, 1, 1.4, 2.4], ": slice0002.dcm and slice0003.dcm lie at the same place; remove one"),
    ],
)
def test_slices_stand_at_even_distances(tmp_path, height, said):
    folder = tmp_path / "series"
    write_dicom_series(Volume(np.arange(36.0).reshape(4, 3, 3), np.full(3, 0.1), np.zeros(3)), folder)
    for place, file in zip(height, sorted(folder.iterdir()), strict=True):
        image = pydicom.dcmread(file)
        image.ImagePositionPatient = [0, 0, place]
        image.save_as(file)
    if said:
        assert refusal(folder).startswith(said)
    else:
        assert read_volume(folder).spacing[0] == pytest.approx(0.1 * height[-1] / 3)


GREY = np.arange(3 * 4 * 5.0).reshape(3, 4, 5)
SIZES, PLACE = np.array([0.03, 0.02, 0.01]), np.array([1.0, 2.0, 3.0])


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"grey": GREY[:2]}, "shape (2, 4, 5); a stack of at least 3 x 3 x 3"),
        ({"grey": GREY[None]}, "shape (1, 3, 4, 5); a stack"),
        ({"spacing": np.ones(2)}, "spacing [1. 1.] cm; give three positive numbers"),
        ({"spacing": np.array([1, 0, 1.0])}, "spacing [1. 0. 1.] cm; give three positive"),
        ({"spacing": np.array([1, 5.1, 1])}, "spacing [1.  5.1 1. ] cm; voxels of an animal measure 1e-06 to 5 cm"),
        ({"origin": np.array([0, np.nan, 0])}, "cm; give three finite"),
        ({"axes": np.eye(3) * 1.02}, "give three perpendicular directions of length 1"),
        ({"grey": np.where(GREY == 7, np.nan, GREY)}, "grey levels that are not finite"),
        ({"grey": np.full((3, 3, 3), 2.5)}, "every voxel has grey level 2.5; is this the right file?"),
    ],
)
def test_a_volume_is_refused_by_what_is_wrong_with_it(changes, said):
    given = {"grey": GREY, "spacing": SIZES, "origin": PLACE} | changes
    with pytest.raises(InputError) as error:
        Volume(**given)
    assert said in str(error.value)


@pytest.mark.parametrize("sizes", [(4.9, 4.9, 1e-6), (0.01, 4.9, 1e-6), (0.02, 0.02, 3.8e-7 * 2.7)])
def test_a_slip_of_a_unit_asks_for_no_memory(sizes):
    """7e14, 1e12 and 9.3e9 cubes, told before one of them is made."""
    with pytest.raises(InputError, match=r"e\+\d+ cubes of 1(\.03)?e-06 cm.*is the unit right\? Otherwise resample"):
        isotropic(Volume(GREY, np.array(sizes), PLACE))
