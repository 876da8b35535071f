"""Headers of images written by hand: every size, type, unit and offset counts, and every refusal says its numbers."""

import bz2
import gzip
import struct
import zlib
from pathlib import Path

import numpy as np
import pytest

from vasowave.errors import InputError
from vasowave.imaging.read import payload
from vasowave.imaging.read.dicom import Slice, _require_one_series, _require_upright, _slice_distance
from vasowave.imaging.read.labels import in_mm, marks, on_grid_of
from vasowave.imaging.read.metaimage import require_whole_metaimage
from vasowave.imaging.read.nifti import require_whole_nifti
from vasowave.imaging.read.nrrd import _millimeters, require_whole_nrrd
from vasowave.imaging.read.payload import require_bytes, unpacked
from vasowave.imaging.read.volume import Volume, is_cubic, isotropic, part_of


def refusal(check, path, content, *more):
    """Return what a check says of a file with a content, without its path; empty if it lets it pass."""
    path.write_bytes(content)
    try:
        check(path, *more)
    except InputError as error:
        return str(error).partition(path.name)[2]
    return ""


def metaimage(more="", voxels=48, dim="2 3 4", kind="MET_SHORT", name="LOCAL", count=3):
    head = f"ObjectType = Image\nNDims = {count}\n{more}DimSize = {dim}\nElementType = {kind}\n"
    return f"{head}ElementDataFile = {name}\n".encode() + bytes(voxels)


DAMAGED = ": not an image that can be read: its header is damaged; export it again"


@pytest.mark.parametrize(
    ("kind", "width"),
    [("CHAR", 1), ("UCHAR", 1), ("SHORT", 2), ("USHORT", 2), ("INT", 4), ("UINT", 4), ("LONG", 4), ("ULONG", 4),
     ("LONG_LONG", 8), ("ULONG_LONG", 8), ("FLOAT", 4), ("DOUBLE", 8), ("FLOAT_ARRAY", 4)],
)  # fmt: skip
def test_a_metaimage_has_as_many_bytes_as_its_sizes_and_type_say(tmp_path, kind, width):
    path, count = tmp_path / "a.mha", 2 * 3 * 5 * width
    head = {"dim": "2 3 5", "kind": f"MET_{kind}"}
    assert refusal(require_whole_metaimage, path, metaimage(voxels=count, **head)) == ""
    said = refusal(require_whole_metaimage, path, metaimage(voxels=count - 1, **head))
    assert said == f": truncated, {count - 1} of {count} bytes of voxels; copy or export it again"
    said = refusal(require_whole_metaimage, path, metaimage(voxels=count + 1, **head))
    assert said.startswith(f": more voxels than the {count} bytes that its header announces; copy")


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (metaimage("ElementNumberOfChannels = 3\n", 144), ""),
        (metaimage("ElementNumberOfChannels = 3\n", 143), ": truncated, 143 of 144 bytes"),
        (metaimage("ElementNumberOfChannels = 0\n", 0), DAMAGED),
        (metaimage("HeaderSize = 7\n", 55), ""),
        (metaimage("HeaderSize = 7\n", 54), ": truncated, 47 of 48 bytes"),
        (metaimage("HeaderSize = -1\n", 60), ""),
        (metaimage("HeaderSize = -1\n", 48), ""),
        (metaimage("HeaderSize = -1\n", 47), ": truncated, 47 of 48 bytes"),
        (metaimage("HeaderSize = a\n"), DAMAGED),
        (metaimage("BinaryData = False\n", 5), ""),  # numbers in a text are counted by the library
        (metaimage("BinaryData = 1\n", 5), ": truncated, 5 of 48"),
        (metaimage("BinaryData = t\n", 5), ": truncated, 5 of 48"),
        (metaimage(count=2), DAMAGED),
        (metaimage(dim="2 0 4", voxels=0), DAMAGED),
        (metaimage(dim="2 1 4", voxels=16), ""),
        (metaimage(dim="", count=0, voxels=0), DAMAGED),
        (metaimage(kind="MET_STRING"), DAMAGED),
        (metaimage("TransformMatrix = 1.01 0 0 0 -1.01 0 0 0 1\n"), ""),
        (metaimage("TransformMatrix = 1 0 0 0 1.02 0 0 0 1\n"), DAMAGED),
        (metaimage("TransformMatrix = 1 0 0 0 -1.02 0 0 0 1\n"), DAMAGED),
        (metaimage("TransformMatrix = nan 0 0 0 1 0 0 0 1\n"), DAMAGED),
        (metaimage(name="LIST"), ": its voxels are spread over several files; save it as one"),
        (metaimage(name="slice%03d.raw 1 9 1"), ": its voxels are spread over several files; save it as one"),
        (metaimage(name="../a.raw"), ": names voxels outside its own folder (../a.raw); put that file"),
        (metaimage(name="/a.raw"), ": names voxels outside its own folder (/a.raw); put that file"),
        (metaimage(name="b.raw"), ": not an image that can be read: its voxels, "),
        (metaimage().replace(b"ElementDataFile", b"Element"), ": not an image that can be read: its header has no "),
        (metaimage().replace(b"= Image", b"= Tube"), ": not an image that can be read: its ObjectType is Tube"),
        (metaimage().replace(b"ObjectType = Image\n", b""), ""),
        (metaimage().replace(b"\n", b"\r\n"), ""),
        (metaimage().replace(b"LOCAL", b"local"), ""),
    ],
)  # fmt: skip
def test_what_a_metaimage_says_of_itself_agrees_or_is_refused(tmp_path, content, said):
    found = refusal(require_whole_metaimage, tmp_path / "a.mha", content)
    assert found.startswith(said)
    assert bool(found) == bool(said)


@pytest.mark.parametrize("word", ["True", "1", "t", "TRUE"])
def test_packed_voxels_of_a_metaimage_are_unpacked_and_counted(tmp_path, word):
    head = metaimage(f"CompressedData = {word}\n", 0)
    path = tmp_path / "a.mha"
    assert refusal(require_whole_metaimage, path, head + zlib.compress(bytes(48))) == ""
    assert "truncated, 47 of 48" in refusal(require_whole_metaimage, path, head + zlib.compress(bytes(47)))
    assert "more voxels than the 48" in refusal(require_whole_metaimage, path, head + zlib.compress(bytes(49)))


def test_voxels_beside_the_header_of_a_metaimage_begin_at_the_start_of_their_file(tmp_path):
    (tmp_path / "b.raw").write_bytes(bytes(48))
    path = tmp_path / "a.mhd"
    assert refusal(require_whole_metaimage, path, metaimage(name="b.raw", voxels=0)) == ""
    (tmp_path / "b.raw").write_bytes(bytes(47))
    with pytest.raises(InputError, match=r"b\.raw: truncated, 47 of 48"):
        require_whole_metaimage(path)


@pytest.mark.parametrize("key", ["ElementSpacing", "ElementSize"])
def test_either_word_for_the_voxel_size_of_a_metaimage_will_do(tmp_path, key):
    path = tmp_path / "a.mha"
    assert refusal(require_whole_metaimage, path, metaimage(f"{key} = 1 1 1\n"), True) == ""
    assert refusal(require_whole_metaimage, path, metaimage()) == ""
    assert refusal(require_whole_metaimage, path, metaimage(), True).startswith(
        ": its header has no ElementSpacing, so"
    )


def nrrd(more="", voxels=48, kind="short", sizes="2 3 4", encoding="raw", dimension=3):
    head = f"NRRD0004\n# a: b\ntype: {kind}\ndimension: {dimension}\nsizes: {sizes}\nencoding: {encoding}\n{more}\n"
    return head.encode() + (bytes(voxels) if isinstance(voxels, int) else voxels)


@pytest.mark.parametrize(
    ("kinds", "width"),
    [
        (("signed char", "int8", "int8_t", "uchar", "unsigned char", "uint8", "uint8_t", "UCHAR"), 1),
        (("short", "short int", "signed short", "signed short int", "int16", "int16_t"), 2),
        (("ushort", "unsigned short", "unsigned short int", "uint16", "uint16_t"), 2),
        (("int", "signed int", "int32", "int32_t", "uint", "unsigned int", "uint32", "uint32_t", "float"), 4),
        (("longlong", "long long", "ulonglong", "unsigned long long", "int64", "uint64_t", "double"), 8),
    ],
)
def test_an_nrrd_has_as_many_bytes_as_its_sizes_and_type_say(tmp_path, kinds, width):
    path, count = tmp_path / "a.nrrd", 24 * width
    for kind in kinds:
        assert refusal(require_whole_nrrd, path, nrrd(voxels=count, kind=kind)) == ""
    assert f"truncated, {count - 1} of {count}" in refusal(
        require_whole_nrrd, path, nrrd(voxels=count - 1, kind=kinds[0])
    )


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (nrrd("byte skip: 6\n", 54), ""),
        (nrrd("byte skip: 6\n", 53), ": truncated, 47 of 48"),
        (nrrd("byte skip: -1\n", 54), ""),
        (nrrd("byte skip: -1\n", 47), ": truncated, 47 of 48"),
        (nrrd("line skip: 2\n", 3), ""),
        (nrrd("line skip: -1\n"), DAMAGED),
        (nrrd(dimension=4), DAMAGED),
        (nrrd(sizes="2 0 4"), DAMAGED),
        (nrrd(sizes="2 1 4", voxels=16), ""),
        (nrrd(sizes="", dimension=0), DAMAGED),
        (nrrd(kind="block"), DAMAGED),
        (nrrd(encoding="lzma"), DAMAGED),
        (nrrd(encoding="hex", voxels=3), ""),
        (nrrd(encoding="ascii", voxels=3), ""),
        (nrrd(encoding="gzip", voxels=gzip.compress(bytes(48))), ""),
        (nrrd(encoding="gz", voxels=gzip.compress(bytes(47))), ": truncated, 47 of 48"),
        (nrrd("byte skip: 5\n", gzip.compress(bytes(53)), encoding="gzip"), ""),
        (nrrd("byte skip: 5\n", gzip.compress(bytes(52)), encoding="gzip"), ": truncated, 52 of 53"),
        (nrrd("byte skip: -1\n", gzip.compress(bytes(48)), encoding="gzip"), ""),
        (nrrd(encoding="bzip2", voxels=bz2.compress(bytes(48))), ""),
        (nrrd(encoding="bz2", voxels=bz2.compress(bytes(49))), ": more voxels than the 48"),
        (nrrd("data file: LIST\n"), ": its voxels are spread over several files"),
        (nrrd("data file: a%d.raw 1 3 1\n"), ": its voxels are spread over several files"),
        (nrrd("data file: ../b.raw\n"), ": names voxels outside its own folder (../b.raw)"),
        (b"NRRD0004\ntype: short\n", ": not an image that can be read: its header has no end; truncated?"),
        (b"NRRA0004\n\n", ": not an image that can be read: no NRRD file"),
        (nrrd("byte skip: 6\n", 54).replace(b"\n", b"\r\n"), ""),
    ],
)
def test_what_an_nrrd_says_of_itself_agrees_or_is_refused(tmp_path, content, said):
    found = refusal(require_whole_nrrd, tmp_path / "a.nrrd", content)
    assert found.startswith(said)
    assert bool(found) == bool(said)


def test_voxels_beside_the_header_of_an_nrrd_begin_at_the_start_of_their_file(tmp_path):
    (tmp_path / "b.raw").write_bytes(bytes(48))
    assert refusal(require_whole_nrrd, tmp_path / "a.nhdr", nrrd("data file: b.raw\n", 0)) == ""


@pytest.mark.parametrize(
    ("more", "said"),
    [
        ("spacings: 1 1 1\n", ""),
        ("space directions: (1,0,0) (0,1,0) (0,0,1)\n", ""),
        ("spacings: 1 nan 1\n", ": its header has no (or not all) space directions or spacings, so"),
        ("space directions: (1,0,0) none (0,0,1)\n", ": its header has no (or not all) space directions or spacings,"),
        ("", ": its header has no (or not all) space directions or spacings, so"),
        (
            'spacings: 1 1 1\nunits: "sec" "sec" "sec"\n',
            ': its header has lengths in "sec" "sec" "sec", which is no unit of a length',
        ),
        ('spacings: 1 1 1\nunits: "mm" "um" "mm"\n', ': its header has lengths in "mm" "um" "mm", which'),
    ],
)
def test_the_voxels_of_an_nrrd_have_a_size_in_one_unit(tmp_path, more, said):
    found = refusal(require_whole_nrrd, tmp_path / "a.nrrd", nrrd(more), True)
    assert found.startswith(said)
    assert bool(found) == bool(said)
    assert refusal(require_whole_nrrd, tmp_path / "a.nrrd", nrrd(more)) == ""


@pytest.mark.parametrize(
    ("fields", "scale"),
    [
        ({"units": '"mm" "mm"'}, 1.0),
        ({"units": '"microns" ""'}, 1e-3),
        ({"units": '"micrometers" "um" "none"'}, 1e-3),
        ({"units": '"Centimetre"'}, 10.0),
        ({"units": '"meters"'}, 1e3),
        ({"units": '"seconds"'}, None),
        ({"units": '"mm" "cm"'}, None),
        ({"units": '"um"', "spaceunits": '"cm"'}, 1e-3),
        ({"units": '"um"', "spaceunits": '"cm"', "spacedirections": ""}, 10.0),
        ({"units": '"cm"', "spacedirections": ""}, 1.0),
        ({}, 1.0),
    ],
)
def test_lengths_of_an_nrrd_are_in_the_unit_of_what_states_them(fields, scale):
    assert _millimeters(fields) == (None if scale is None else pytest.approx(scale))


def nifti(version=1, order="<", dim=(3, 2, 3, 4, 1, 1, 1, 1), bits=16, sizes=(0.1, 0.2, 0.3), offset=None, unit=2):
    header = bytearray(352 if version == 1 else 544)
    offset = len(header) if offset is None else offset
    places = {1: ((0, "i", [348]), (40, "8h", dim), (72, "h", [bits]), (80, "3f", sizes), (108, "f", [offset]),
                  (123, "B", [unit])),
              2: ((0, "i", [540]), (14, "h", [bits]), (16, "8q", dim), (112, "3d", sizes), (168, "q", [offset]),
                  (500, "i", [unit]))}  # fmt: skip
    for at, kind, values in places[version]:
        struct.pack_into(order + kind, header, at, *values)
    return bytes(header)


@pytest.mark.parametrize("order", "<>")
@pytest.mark.parametrize("version", [1, 2])
def test_a_nifti_has_as_many_bytes_as_its_header_says(tmp_path, version, order):
    head = nifti(version, order)
    path = tmp_path / "a.nii"
    assert refusal(require_whole_nifti, path, head + bytes(48), True) == ""
    size = len(head) + 48
    assert refusal(require_whole_nifti, path, head + bytes(47)) == (
        f": truncated, {size - 1} of {size} bytes of voxels; copy or export it again"
    )
    moved = nifti(version, order, offset=len(head) + 16)
    assert f"truncated, {size} of {size + 16}" in refusal(require_whole_nifti, path, moved + bytes(48))
    packed = tmp_path / "b.nii.gz"
    assert refusal(require_whole_nifti, packed, gzip.compress(head + bytes(48))) == ""
    assert "more voxels than" in refusal(require_whole_nifti, packed, gzip.compress(head + bytes(49)))


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"dim": (0, 2, 3, 4, 1, 1, 1, 1)}, ": not a NIfTI file that can be read (its header announces no voxels)"),
        ({"dim": (8, 2, 3, 4, 1, 1, 1, 1)}, ": not a NIfTI file that can be read (its header announces no voxels)"),
        ({"dim": (3, 2, 0, 4, 1, 1, 1, 1)}, ": not a NIfTI file that can be read (its header announces no voxels)"),
        ({"bits": 0}, ": not a NIfTI file that can be read (its header announces no voxels)"),
        ({"offset": 347}, ": not a NIfTI file that can be read (its header announces no voxels)"),
        ({"dim": (7, 2, 3, 4, 1, 1, 1, 1)}, ""),
        ({"dim": (1, 24, 0, 0, 0, 0, 0, 0)}, ""),
        ({"dim": (3, 2, 3, 4, 0, 1, 1, 1)}, ""),
        ({"sizes": (0.1, 0, 0.3)}, ": its header leaves out a voxel's size (pixdim) or the unit (xyzt_units), so that"),
        ({"unit": 0}, ": its header leaves out a voxel's size"),
        ({"unit": 1}, ""),
        ({"unit": 3 + 8}, ""),
        ({"unit": 4}, ": its header leaves out a voxel's size"),
    ],
)
def test_what_a_nifti_says_of_itself_agrees_or_is_refused(tmp_path, changes, said):
    found = refusal(require_whole_nifti, tmp_path / "a.nii", nifti(**changes) + bytes(48), True)
    assert found.startswith(said)
    assert bool(found) == bool(said)


def test_what_is_no_nifti_is_told_and_so_is_its_twin(tmp_path):
    path = tmp_path / "a.nii"
    assert "(its first number is neither 348 nor 540)" in refusal(require_whole_nifti, path, bytes(400))
    assert refusal(require_whole_nifti, path, nifti()[:100]) == ": truncated; copy or export it again"
    packed = tmp_path / "a.nii.gz"
    assert refusal(require_whole_nifti, packed, b"x").startswith(": a.nii lies beside it, and the reader may confuse")
    assert refusal(require_whole_nifti, path, nifti() + bytes(48)).startswith(": a.nii.gz lies beside it")


def test_bytes_are_unpacked_as_far_as_they_are_asked_for(tmp_path, monkeypatch):
    monkeypatch.setattr(payload, "_UNPACKED", 10)
    monkeypatch.setattr(payload, "_CHUNK", 7)
    content = np.random.default_rng(3).bytes(95)
    for packing, squeezed in (("zlib", zlib.compress(content)), ("gzip", gzip.compress(content)),
                              ("bzip2", bz2.compress(content))):  # fmt: skip
        path = tmp_path / packing
        path.write_bytes(b"head" + squeezed)
        assert b"".join(unpacked(path, 4, packing, 95)) == content
        pieces = list(unpacked(path, 4, packing, 40))
        assert max(map(len, pieces)) <= 10
        assert 40 < sum(map(len, pieces)) <= 50
        path.write_bytes(b"head" + squeezed[:-3])
        with pytest.raises(InputError, match="truncated or damaged"):
            require_bytes(path, 4, 95, packing)
    for packing, squeezed in (("gzip", gzip.compress), ("bzip2", bz2.compress)):  # two streams, and zeros behind
        path.write_bytes(squeezed(content[:50]) + squeezed(content[50:]))
        require_bytes(path, 0, 95, packing)
    path.write_bytes(gzip.compress(content) + bytes(9))
    require_bytes(path, 0, 95, "gzip")
    path.write_bytes(zlib.compress(content) + b"anything")
    require_bytes(path, 0, 95, "zlib")


def test_what_unpacks_to_two_gigabytes_and_to_200_times_its_size_is_refused(tmp_path, monkeypatch):
    path = tmp_path / "a"
    path.write_bytes(zlib.compress(bytes(3000)))
    monkeypatch.setattr(payload, "LARGE", 3000)
    require_bytes(path, 0, 3000, "zlib")
    monkeypatch.setattr(payload, "DENSE", 3001)
    with pytest.raises(InputError, match=r"truncated, 3000 of 3001"):
        require_bytes(path, 0, 3001, "zlib")
    monkeypatch.setattr(payload, "DENSE", 1)
    with pytest.raises(InputError, match=r"0\.0 GB of voxels in 0\.0 MB; no image is so even"):
        require_bytes(path, 0, 3001, "zlib")
    with pytest.raises(InputError, match=r"truncated, 0 of 5 bytes"):
        require_bytes(path, 10_000, 5)


def sliced(name="a", place=(0, 0, 0), spacing=(0.5, 0.25), **same):
    return Slice(name, {"SeriesInstanceUID": "1", "Rows": "4", "Columns": "5", "PixelSpacing": "x",
                        "ImageOrientationPatient": "y"} | same,
                 np.eye(3)[:2], np.array(place, float), np.array(spacing), np.zeros((4, 5)))  # fmt: skip


@pytest.mark.parametrize(
    ("height", "said"),
    [
        ([0, 1, 2.4, 3], ""),
        ([0, 1, 2.5, 3.5], ""),  # one and a half usual distances at most
        ([0, 1, 2.51, 3.51], "x: 1 slices missing between b and c; export the series again"),
        ([0, 1, 2, 6, 7], "x: 3 slices missing between c and d; export"),
        ([0, 1, 1.5, 2.5], ""),
        ([0, 1, 1.49, 2.49], "x: b and c lie at the same place; remove one"),
        ([0, 0, 0, 1], "x: a and b lie at the same place; remove one"),
    ],
)
def test_slices_stand_at_even_distances(height, said):
    def distance():
        return _slice_distance(Path("x"), np.array(height), list("abcde")[: len(height)])

    if said:
        with pytest.raises(InputError) as error:
            distance()
        assert str(error.value).startswith(said)
    else:
        assert distance() == pytest.approx((height[-1] - height[0]) / (len(height) - 1))


def test_the_last_slice_stands_above_the_first_within_a_voxel():
    """Rows are 0.5 mm apart, columns 0.25 mm: along a row, a voxel is a column's."""
    _require_upright(Path("x"), sliced(), sliced("b", (0.25, 0.5, 7)))
    for place, voxels in (((0.26, 0, 7), "1.0"), ((0, -0.6, 7), "1.2"), ((0.5, 0.5, 7), "2.0")):
        with pytest.raises(InputError, match=rf"shifted sideways \(b by {voxels} voxels from a\)"):
            _require_upright(Path("x"), sliced(), sliced("b", place))


@pytest.mark.parametrize("key", ["SeriesInstanceUID", "Rows", "Columns", "PixelSpacing", "ImageOrientationPatient"])
def test_slices_of_one_series_have_everything_in_common(key):
    _require_one_series(Path("x"), [sliced("a"), sliced("b"), sliced("c")])
    with pytest.raises(InputError, match=f"x: more than one series: a and c differ in {key}; put each"):
        _require_one_series(Path("x"), [sliced("a"), sliced("b"), sliced("c", **{key: "z"})])


GREY = np.arange(3 * 4 * 5.0).reshape(3, 4, 5)
SIZES, PLACE = np.array([0.03, 0.02, 0.01]), np.array([1.0, 2.0, 3.0])


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"grey": GREY[:2]}, "shape (2, 4, 5); a stack of at least 3 x 3 x 3"),
        ({"grey": GREY[:, :2]}, "shape (3, 2, 5); a stack"),
        ({"grey": GREY[0]}, "shape (4, 5); a stack"),
        ({"grey": GREY[None]}, "shape (1, 3, 4, 5); a stack"),
        ({"spacing": np.ones(2)}, "spacing [1. 1.] cm; give three positive numbers"),
        ({"spacing": np.array([1, 0, 1.0])}, "spacing [1. 0. 1.] cm; give three positive"),
        ({"spacing": np.array([1, np.inf, 1])}, "spacing [ 1. inf  1.] cm; give three positive"),
        ({"spacing": np.array([1, 5.1, 1])}, "spacing [1.  5.1 1. ] cm; voxels of an animal measure 1e-06 to 5 cm"),
        ({"spacing": np.array([1, 9e-7, 1])}, "cm; voxels of an animal measure"),
        ({"origin": np.zeros(2)}, "origin [0. 0.] cm; give three finite"),
        ({"axes": np.eye(3) * 1.02}, "give three perpendicular directions of length 1"),
        ({"axes": np.eye(3)[:2]}, "give three perpendicular directions"),
        ({"grey": np.where(GREY == 7, np.inf, GREY)}, "grey levels that are not finite"),
        ({"grey": np.where(GREY == 7, np.nan, GREY)}, "grey levels that are not finite"),
        ({"grey": np.full((3, 3, 3), 2.5)}, "every voxel has grey level 2.5; is this the right file?"),
    ],
)
def test_a_volume_is_refused_by_what_is_wrong_with_it(changes, said):
    given = {"grey": GREY, "spacing": SIZES, "origin": PLACE} | changes
    with pytest.raises(InputError) as error:
        Volume(**given)
    assert said in str(error.value)


def test_a_volume_lets_its_limits_pass_and_keeps_small_whole_numbers():
    one = Volume(GREY[:, :3, :3], np.array([1e-6, 5.0, 1.0]), PLACE, np.eye(3) * 1.004)
    assert one.grey.dtype == np.float32
    for kind, kept in (
        ("u1", "u1"),
        ("i2", "i2"),
        (">i2", "=i2"),
        ("i4", "f4"),
        ("f8", "f4"),
        ("f2", "f4"),
        ("?", "f4"),
    ):
        found = Volume((GREY > 3).astype(kind), SIZES, PLACE).grey
        assert found.dtype == np.dtype(kept)
        assert found.sum() == 56


def test_part_of_a_volume_lies_where_it_lay():
    part = part_of(Volume(GREY, SIZES, PLACE), np.array([-2, 1, 2]), np.array([3, 4, 9]))
    assert np.array_equal(part.grey, GREY[:, 1:4, 2:])
    assert part.origin == pytest.approx([1.0, 2.02, 3.02])


def test_cubes_have_the_smallest_side_and_grey_levels_between_the_neighbors():
    """Sides of 0.03, 0.02 and 0.01: 2 · 3 + 1 planes, 3 · 2 + 1 rows, and the 5 columns there are."""
    volume = Volume(GREY, SIZES, PLACE)
    assert not is_cubic(volume)
    cubes = isotropic(volume)
    assert cubes.grey.shape == (7, 7, 5)
    assert cubes.spacing == pytest.approx(0.01)
    z, y, x = np.indices((7, 7, 5))
    assert cubes.grey == pytest.approx(20 * z / 3 + 5 * y / 2 + x, abs=1e-4)
    assert cubes.origin == pytest.approx(PLACE)
    nearly = Volume(GREY, np.array([0.01, 0.010009, 0.01]), PLACE)
    assert isotropic(nearly) is nearly
    assert isotropic(Volume(GREY, np.array([0.01, 0.010011, 0.01]), PLACE)).grey.shape == (3, 4, 5)


@pytest.mark.parametrize("sizes", [(4.9, 4.9, 1e-6), (0.01, 4.9, 1e-6), (0.02, 0.02, 3.8e-7 * 2.7)])
def test_a_slip_of_a_unit_asks_for_no_memory(sizes):
    """7e14, 1e12 and 9.3e9 cubes, told before one of them is made."""
    with pytest.raises(InputError, match=r"e\+\d+ cubes of 1(\.03)?e-06 cm.*is the unit right\? Otherwise resample"):
        isotropic(Volume(GREY, np.array(sizes), PLACE))


def test_labels_go_to_the_nearest_voxel_of_another_grid():
    image = Volume(GREY, SIZES, PLACE)
    cubes = isotropic(image)
    labels = GREY.astype(int)
    found = on_grid_of(labels, image, cubes)
    assert np.array_equal(found[:, ::2], labels[[0, 0, 1, 1, 1, 2, 2]])  # every second row lies between two
    beyond = Volume(GREY, SIZES, PLACE - SIZES * [1, 0, 2])
    assert np.array_equal(on_grid_of(labels, image, beyond), labels[np.ix_([0, 0, 1], range(4), [0, 0, 0, 1, 2])])


def test_marks_stand_at_the_middle_of_their_labels():
    labels = np.zeros((3, 4, 5), int)
    labels[0, 1, 1:4], labels[2, 3, 4], labels[1] = 2, 5, 1
    found = marks(labels, Volume(GREY, SIZES, PLACE))
    assert set(found) == {2, 5}
    assert found[2] == pytest.approx([1.0, 2.02, 3.02])
    assert found[5] == pytest.approx([1.06, 2.06, 3.04])
    assert marks(np.minimum(labels, 1), Volume(GREY, SIZES, PLACE)) == {}
    assert in_mm(np.array([1.0, 2.02, 0.30004])) == "3, 20.2, 10"
