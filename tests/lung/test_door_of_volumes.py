"""Volumes of scanners and programs: landmarks lie where they are, and the size of a voxel is told or asked for."""

import base64
import json
import shutil
import struct
import warnings
import zlib

import numpy as np
import pytest

import wrapped_volumes as wrapped
from vasowave.base import InputError, VasowaveWarning
from vasowave.lung import Volume, extract, look, parse_voxel, read_volume, voxel_text
from vasowave.lung.read import read_labels


def opened(path, spacing=None):
    """Return a volume and the codes of what was told of it."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        volume = read_volume(path, spacing)
    assert all(issubclass(warning.category, VasowaveWarning) for warning in caught)
    return volume, [warning.message.finding.code for warning in caught]


def assert_landmarks(volume, size):
    """The four brightest voxels lie as those of the phantom do, in the world, from the first of them."""
    brightest = np.argsort(volume.grey, axis=None)[::-1][: len(wrapped.LANDMARKS)]
    indices = np.column_stack(np.unravel_index(brightest, volume.grey.shape))
    places = volume.frame.world(indices * volume.spacing + volume.origin)
    expected = np.array(list(wrapped.LANDMARKS)) * size
    np.testing.assert_allclose(places - places[0], expected - expected[0], rtol=1e-3, atol=1e-7)


@pytest.mark.parametrize("name", wrapped.WRAPPINGS)
def test_a_volume_is_read_with_the_size_that_its_files_say(tmp_path, name):
    write, size = wrapped.WRAPPINGS[name]
    volume, codes = opened(write(tmp_path))
    assert_landmarks(volume, size)
    assert (codes, bool(volume.provenance)) == ([], True)


def analyze(folder, words=b""):
    """Write a header of Analyze 7.5 with sizes of voxels, and the unit in letters, beside 16-bit voxels."""
    header = bytearray(348)
    fields = {40: ("<4h", [3, wrapped.NX, wrapped.NY, wrapped.NZ]), 70: ("<2h", [4, 16]),
              80: ("<3f", [10 * edge for edge in wrapped.SIZE[::-1]]), 0: ("<i", [348])}  # fmt: skip
    for place, (form, values) in fields.items():
        struct.pack_into(form, header, place, *values)
    header[56 : 56 + len(words)] = words
    (folder / "a.img").write_bytes(wrapped.GREY.astype("<i2").tobytes())
    (folder / "a.hdr").write_bytes(bytes(header))
    return folder / "a.hdr"


def test_a_header_of_analyze_says_its_unit_in_letters(tmp_path):
    volume, codes = opened(analyze(tmp_path, b"mm"))
    np.testing.assert_allclose(volume.spacing, wrapped.SIZE, rtol=1e-6)
    assert not codes


def inveon_without(line):
    """Return what writes a header of Inveon and its voxels without a line."""

    def write(folder):
        voxels = wrapped.inveon(folder)
        header = folder / f"{voxels.name}.hdr"
        header.write_text(header.read_text().replace(line, ""))
        return voxels

    return write


UNSIZED = {
    "Analyze without unit": analyze,
    "Inveon without one axis": inveon_without("pixel_size_z 0.05\n"),
    "pictures": wrapped.pictures,
    "an array": wrapped.numpy_array,
    "an array of MATLAB": wrapped.matlab_array,
    "a TIFF": wrapped.tiff,
    "pixels": lambda folder: wrapped.tiff(folder, **wrapped.imagej("pixel", 1)),
    "NIfTI without unit": lambda folder: wrapped.nifti(folder, unit=0),
    "NIfTI of two sizes": lambda folder: wrapped.nifti(folder, sform=1.5 * wrapped.QFORM),
    "Amira without unit": lambda folder: wrapped.amira(folder, unit=""),
    "MetaImage of unknown unit": lambda folder: wrapped.metaimage(folder, "DistanceUnits = ?\n"),
}


@pytest.mark.parametrize("name", UNSIZED)
def test_where_no_file_says_the_size_it_is_asked_for_and_three_numbers_are_taken(tmp_path, name):
    path = UNSIZED[name](tmp_path)
    with pytest.raises(InputError, match=r"is not known; give it in cm: one number, or x,y,z\nvoxel="):
        read_volume(path)
    volume, codes = opened(path, wrapped.SIZE)
    np.testing.assert_array_equal(volume.spacing, wrapped.SIZE)
    assert codes in ([], ["image.two-frames"])


@pytest.mark.parametrize(("typed", "codes"), [(wrapped.SIZE, []), (0.002, ["image.voxel-typed"])])
def test_a_size_that_is_typed_against_the_files_own_is_told(tmp_path, typed, codes):
    path = wrapped.imagej_millimeters(tmp_path)
    volume, told = opened(path, typed)
    assert told == codes
    np.testing.assert_array_equal(volume.spacing, np.broadcast_to(typed, 3))


def test_what_is_stored_with_black_and_white_exchanged_is_inverted_and_told(tmp_path):
    folders = [tmp_path / name for name in ("dicom", "stack", "slices")]
    for folder in folders:
        folder.mkdir()
    white = {"PhotometricInterpretation": "MONOCHROME1", "BitsStored": 8, "HighBit": 7}
    wrapped.dicom_slices(folders[0], 255 - wrapped.GREY, **white)
    stack = wrapped.tiff(folders[1], 255 - wrapped.GREY, photometric="miniswhite")
    for path, size in ((folders[0], None), (stack, wrapped.SIZE)):
        volume, codes = opened(path, size)
        assert codes == ["image.inverted"]
        assert_landmarks(volume, wrapped.SIZE)
        np.testing.assert_array_equal(volume.grey, wrapped.GREY)
    with pytest.raises(InputError, match="a mask whose lowest label is white"):
        read_labels(stack, volume, wrapped.SIZE)


def test_transforms_that_differ_are_told(tmp_path):
    assert opened(wrapped.nifti(tmp_path, sform=wrapped.QFORM * [[-1], [1], [1]]))[1] == ["image.two-frames"]


def removed(folder, name):
    (folder / name).unlink()


def renamed(folder, name, new):
    (folder / name).rename(folder / new)


SPOILED = {
    "a slice is missing": (lambda folder: removed(folder, "slice_004.png"), "slices are missing between slice_003.png"),
    "a number twice": (lambda folder: renamed(folder, "slice_009.png", "slice_8.png"), "one number for slice_008.png"),
    "two stacks": (lambda folder: wrapped.pictures(folder, "b%d.png"), "more than one stack of slices"),
    "another size": (lambda folder: wrapped.pictures(folder, grey=wrapped.GREY[:1, :5], first=10), "differ in size"),
    "two numbers": (lambda folder: renamed(folder, "slice_001.png", "slice_001_2.png"), "slices are missing"),
    "a volume beside": (wrapped.metaimage_in_a_folder, r"holds more than one image: volumes \(a.mhd\); slices"),
    "a series beside": (wrapped.dicom_slices, "holds more than one image: DICOM files"),
    "a picture that is none": (
        lambda folder: wrapped.put(folder, "slice_003.png", b"\x89PNG"),
        "no.* readable picture",
    ),
    "a store": (wrapped.zarr, r"OME-Zarr 0\.5.*which is not read; save it as OME-TIFF"),
}


@pytest.mark.parametrize("name", SPOILED)
def test_a_folder_that_is_not_one_whole_image_is_refused_by_the_names_in_it(tmp_path, name):
    spoil, said = SPOILED[name]
    wrapped.pictures(tmp_path)
    spoil(tmp_path)
    with pytest.raises(InputError, match=said):
        read_volume(tmp_path, wrapped.SIZE)


def test_the_only_folder_with_an_image_below_is_read_and_of_several_one_is_asked_for(tmp_path):
    inner = tmp_path / "DICOM" / "PA000001" / "SE000001"
    inner.mkdir(parents=True)
    wrapped.put(tmp_path, "README.TXT", "of a PACS")
    wrapped.dicom_slices(inner)
    for slice_file in inner.iterdir():
        slice_file.rename(inner / slice_file.stem)  # scanners write no ending
    assert_landmarks(opened(tmp_path)[0], wrapped.SIZE)
    shutil.copytree(inner, tmp_path / "DICOM" / "PA000001" / "SE000002")
    with pytest.raises(InputError, match=r"several folders with images: .*SE000001, .*SE000002; give one"):
        read_volume(tmp_path)


def test_a_store_of_several_images_asks_for_one_of_them(tmp_path):
    store = wrapped.ome_zarr(tmp_path)
    shutil.copytree(store, tmp_path / "lab" / "0")
    shutil.copytree(store, tmp_path / "lab" / "1")
    wrapped.put(tmp_path / "lab", ".zgroup", '{"zarr_format": 2}')
    with pytest.raises(InputError, match=r"holds 2 images \(0, 1\); give one of these folders"):
        read_volume(tmp_path / "lab")
    assert read_volume(tmp_path / "lab" / "1").grey.shape == wrapped.GREY.shape
    described = json.loads((store / ".zattrs").read_text("utf-8"))
    wrapped.put(store, ".zattrs", json.dumps({"multiscales": 2 * described["multiscales"]}))
    with pytest.raises(InputError, match="describes 2 images"):
        read_volume(store)


def test_a_log_that_counts_other_slices_and_files_that_are_no_slices_are_told(tmp_path):
    wrapped.skyscan(tmp_path)
    removed(tmp_path, "lung__rec00000109.bmp")
    wrapped.pictures(tmp_path, "preview%d.bmp", wrapped.GREY[:1])
    assert opened(tmp_path)[1] == ["image.left-out", "image.slices-cropped"]


@pytest.mark.parametrize(("apart", "codes"), [(2, []), (1, ["image.slices-step"])])
def test_slices_that_a_log_says_lie_two_voxels_apart_do_and_numbers_that_count_them_otherwise_are_told(
    tmp_path, apart, codes
):
    last = f"Last Section={100 + 2 * (len(wrapped.GREY) - 1)}"
    log = wrapped.NRECON.replace("Last Section=109", last) + "Section to Section Step=2\r\n"
    wrapped.put(tmp_path, "lung__rec.log", log)
    for number, level in enumerate(wrapped.GREY):
        wrapped.pictures(tmp_path, "lung__rec%08d.bmp", [level], first=100 + apart * number)
    volume, found = opened(tmp_path)
    np.testing.assert_allclose(volume.spacing, [0.004, 0.002, 0.002])
    assert "Step' of 2" in volume.provenance
    assert found == codes


def test_texts_that_name_two_sizes_are_refused(tmp_path):
    wrapped.zeiss_slices(tmp_path)
    wrapped.put(tmp_path, "notes.txt", "Voxel size: 25 um\n")
    with pytest.raises(InputError, match=r"name two sizes of a voxel .*20, 20, 20 and 25, 25, 25|25, 25, 25 and 20"):
        read_volume(tmp_path)


def test_a_vox_volume_is_read_and_the_unit_of_its_scale_is_asked_for(tmp_path):
    head = f"Vox1999a\nVolumeCount 1\n##\f\n##\nVolumeSize {wrapped.NX} {wrapped.NY} {wrapped.NZ}\nVoxelSize 16\n"
    head += "VolumeScale 0.002 0.003 0.005\nEndian B\nField 0 (Position 0 Size 16)\n##\f\n"
    path = wrapped.put(tmp_path, "a.vox", head.encode() + wrapped.GREY.astype(">u2").tobytes())
    with pytest.raises(InputError, match=r"a VolumeScale of 0.002 0.003 0.005 without a unit, so that the size"):
        read_volume(path)
    np.testing.assert_array_equal(read_volume(path, wrapped.SIZE).grey, wrapped.GREY)
    path.write_bytes(path.read_bytes()[:-2])
    with pytest.raises(InputError, match="truncated"):
        read_volume(path, wrapped.SIZE)


def test_frames_of_paravision_are_not_taken_for_a_volume(tmp_path):
    path = wrapped.paravision(tmp_path)
    text = (tmp_path / "visu_pars").read_text("latin-1")
    (tmp_path / "visu_pars").write_text(text.replace("FrameCount=1", "FrameCount=2"), "latin-1")
    with pytest.raises(InputError, match="not one volume of three axes by its visu_pars; export it as DICOM"):
        read_volume(path)


@pytest.mark.parametrize(
    "name", ["paravision", "scanco", "vff", "vgstudio", "amira_bytes", "amira_packed", "hdf5", "nikon"]
)
def test_a_volume_that_was_cut_is_refused(tmp_path, name):
    path = wrapped.WRAPPINGS[name][0](tmp_path)
    path.write_bytes(path.read_bytes()[:-700])
    with pytest.raises(InputError, match=r"truncated|damaged|not clear"):
        read_volume(path)


def test_a_voxel_size_is_written_as_it_is_read():
    assert parse_voxel("0.002") == 0.002
    assert parse_voxel("20, 30, 50 um") == pytest.approx(tuple(wrapped.SIZE))
    assert parse_voxel(voxel_text(wrapped.SIZE)) == pytest.approx(tuple(wrapped.SIZE))
    for text in ("", "0", "1,2", "a", "1,2,3 s", "-1,2,3"):
        with pytest.raises(InputError):
            parse_voxel(text)


@pytest.mark.parametrize("first_look", [look, lambda volume, **options: extract(volume, root=(0, 0, 0), **options)])
def test_an_image_that_no_animal_of_the_species_has_is_refused_at_the_first_look(first_look):
    tube = 100.0 * (np.hypot(*(np.indices((20, 20, 20))[1:] - 9.5)) < 4) + np.indices((20, 20, 20))[0]
    volume = Volume(tube, np.full(3, 1.0), np.zeros(3))  # µm taken for mm taken for cm
    with pytest.raises(InputError, match=r"measures 20 × 20 × 20 cm .* no mouse is like that; .*\nvoxel="):
        first_look(volume, species="mouse")


def test_an_image_that_needs_more_memory_than_there_is_is_refused_before_anything_is_computed():
    grey = np.indices((40, 40, 40))[0]
    with pytest.raises(InputError, match=r"2.56e\+10 voxels .* takes about 115 GB of memory, and this machine has"):
        look(Volume(grey, np.array([4, 1e-5, 1e-5]), np.zeros(3)), species="other")


@pytest.mark.validation
@pytest.mark.parametrize(("slices", "turned"), [(700, True), (2200, False)])
def test_voxels_in_a_file_of_their_own_may_be_long(tmp_path, slices, turned):
    """One image is read in another process, the other stays on the disk."""
    more = "TransformMatrix = 0 1 0 1 0 0 0 0 1\n" if turned else ""
    header = wrapped.metaimage(tmp_path, more, "0.02 0.02 0.02")
    header.write_text(header.read_text().replace("18 14 10", f"1000 1000 {slices}"))
    with (tmp_path / "a.raw").open("r+b") as file:
        file.truncate(1000 * 1000 * slices)  # sparse
    volume = read_volume(header)
    assert volume.grey.shape == (slices, 1000, 1000)
    assert np.array_equal(np.sort(volume.grey[0], axis=None)[-4:], [160, 180, 200, 220])


@pytest.mark.parametrize("lost", ["s1", "a byte"])
def test_a_slab_of_an_nrrd_that_is_lost_or_cut_is_no_image(tmp_path, lost):
    header = wrapped.nrrd_of_two_slabs(tmp_path)
    (tmp_path / "s1").unlink() if lost == "s1" else (tmp_path / "s1").write_bytes(wrapped.GREY[5:].tobytes()[:-1])
    with pytest.raises(InputError, match="s1"):
        read_volume(header)


def vti(folder, order="<", form="appended", cells=False, packed=False, header="UInt64"):
    """Write an image of VTK as its own documentation describes it; by cell an edge has a point more."""
    levels = wrapped.GREY.astype(f"{order}u2").tobytes()
    count = np.dtype(order + {"UInt32": "u4", "UInt64": "u8"}[header])
    block = zlib.compress(levels)
    head = np.array([1, len(levels), 0, len(block)] if packed else [len(levels)], count).tobytes()
    content = head + (block if packed else levels)
    extent = " ".join(f"5 {5 + size - (not cells)}" for size in wrapped.GREY.shape[::-1])
    text = {"appended": "", "binary": base64.b64encode(content).decode(),
            "ascii": " ".join(map(str, wrapped.GREY.ravel()))}[form]  # fmt: skip
    array = f'<DataArray type="UInt16" Name="grey" format="{form}" offset="0">{text}</DataArray>'
    kind, packer = "CellData" if cells else "PointData", ' compressor="vtkZLibDataCompressor"' if packed else ""
    text = (
        f'<?xml version="1.0"?>\n<VTKFile type="ImageData" byte_order="{"Big" if order == ">" else "Little"}Endian" '
        f'header_type="{header}"{packer}>\n<ImageData WholeExtent="{extent}" Spacing="0.02 0.03 0.05">\n'
        f'<Piece Extent="{extent}"><{kind}>{array}</{kind}></Piece></ImageData>\n<AppendedData encoding="raw">\n_'
    )
    return wrapped.put(folder, "a.vti", text.encode() + content + b"\n</AppendedData></VTKFile>")


@pytest.mark.parametrize("form", [{}, {"order": ">", "cells": True, "header": "UInt32"}, {"form": "binary"},
                                  {"form": "ascii"}, {"packed": True}])  # fmt: skip
def test_an_image_of_vtk_asks_for_its_unit_alone(tmp_path, form):
    path = vti(tmp_path, **form)
    with pytest.raises(InputError, match=r"VTK names no unit of its Spacing \(0.02, 0.03, 0.05\)"):
        read_volume(path)
    volume, codes = opened(path, wrapped.SIZE)
    np.testing.assert_array_equal(volume.grey, wrapped.GREY)
    assert not codes


def test_an_extent_in_paravision_that_reco_contradicts_is_refused(tmp_path):
    path = wrapped.paravision(tmp_path)
    edges = 0.1 * np.array([0.02, 0.03, 0.05]) * wrapped.GREY.shape[::-1]
    wrapped.put(tmp_path, "reco", f"##$RECO_fov=( 3 )\n{edges[1]} {edges[0]} {edges[2]}\n##END=\n")
    np.testing.assert_allclose(read_volume(path).spacing, wrapped.SIZE)
    wrapped.put(tmp_path, "reco", f"##$RECO_fov=( 3 )\n{edges[1]} {1.1 * edges[0]} {edges[2]}\n##END=\n")
    with pytest.raises(InputError, match="reco one of"):
        read_volume(path)


def test_a_matlab_file_of_two_images_or_none_asks_for_one(tmp_path):
    from scipy.io import savemat

    savemat(tmp_path / "a.mat", {"lung": wrapped.GREY, "mask": wrapped.GREY})
    with pytest.raises(InputError, match=r"not one array of three axes, rows, columns and slices \(lung, mask\)"):
        read_volume(tmp_path / "a.mat", 0.002)
    (tmp_path / "b.mat").write_bytes(b"no file of MATLAB")
    with pytest.raises(InputError, match="not a MATLAB file"):
        read_volume(tmp_path / "b.mat", 0.002)


@pytest.mark.parametrize(("name", "words"), [("a.czi", "Zeiss ZEN.*Fiji"), ("a.TXM", "Xradia.*DICOM"),
                                             ("a.mnc", "MINC.*mnc2nii")])  # fmt: skip
def test_an_image_that_its_program_alone_opens_is_refused_with_the_export_that_helps(tmp_path, name, words):
    (tmp_path / name).write_bytes(b"something\0")
    with pytest.raises(InputError, match=words):
        read_volume(tmp_path / name)
