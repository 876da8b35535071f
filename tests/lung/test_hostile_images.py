"""Images that would hang or crash a reader, fill the memory, name other files, or give other voxels without a word."""

import os
import re
import signal
import time

import numpy as np
import pytest

from fuzzing.images import dicom, itk_file, metaimage_bomb, nifti_bomb, volume
from vasowave.base import InputError
from vasowave.base.io import apart
from vasowave.lung.read import read_volume


def image(folder, name, packed=False):
    itk_file(name, packed)(folder)
    return folder / name


def change(path, old, new):
    content = path.read_bytes()
    assert content.count(old) == 1
    path.write_bytes(content.replace(old, new))
    return path


@pytest.mark.parametrize("name", ["v.mha", "v.mhd", "v.raw", "v.nrrd", "v.nhdr", "v.nii", "v.nii.gz"])
@pytest.mark.parametrize("packed", [False, True])
def test_a_sound_image_of_every_format_is_read_as_it_was_written(tmp_path, name, packed):
    path = image(tmp_path, name.replace(".raw", ".mhd"), packed)
    if name == "v.raw" and packed:
        pytest.skip("packed voxels are no .raw")
    found, sound = read_volume(path.with_name(name)), volume()
    np.testing.assert_array_equal(found.grey, sound.grey)
    np.testing.assert_allclose(found.spacing, sound.spacing, rtol=1e-6)
    np.testing.assert_allclose(found.origin, sound.origin, rtol=1e-6)


def test_a_transform_matrix_of_minus_1e308_does_not_hang(tmp_path):
    path = change(image(tmp_path, "v.mha"), b"TransformMatrix = 1 0", b"TransformMatrix = -1e308 0")
    with pytest.raises(InputError, match=r"v\.mha: .* its header is damaged"):
        read_volume(path)


def test_two_to_the_31_voxels_an_axis_take_no_memory(tmp_path):
    path = change(image(tmp_path, "v.mha"), b"DimSize = 11 10 9", b"DimSize = 2147483648 2147483648 2147483648")
    with pytest.raises(InputError, match=r"v\.mha: truncated, 1980 of 1980\d+ bytes"):
        read_volume(path)


@pytest.mark.parametrize("name", ["v.mhd", "v.nhdr"])
@pytest.mark.parametrize("place", ["{outside}", "../secret.raw"])
def test_a_header_that_names_voxels_outside_its_folder_is_refused(tmp_path, name, place):
    inside = tmp_path / "inside"
    inside.mkdir()
    path = image(inside, name)
    (inside / "v.raw").rename(tmp_path / "secret.raw")
    change(path, b"v.raw", place.format(outside=tmp_path / "secret.raw").encode())
    with pytest.raises(InputError, match="names voxels outside its own folder"):
        read_volume(path)
    os.symlink(tmp_path / "secret.raw", inside / "v.raw")  # whoever wants that says so with a link
    change(path, place.format(outside=tmp_path / "secret.raw").encode(), b"v.raw")
    assert read_volume(path).grey.shape == (9, 10, 11)


def test_a_pipe_or_a_device_is_no_image(tmp_path):
    os.mkfifo(tmp_path / "v.nrrd")
    with pytest.raises(InputError, match="is a pipe or a device"):
        read_volume(tmp_path / "v.nrrd")
    os.symlink("/dev/zero", tmp_path / "v.mha")
    with pytest.raises(InputError, match="is a pipe or a device"):
        read_volume(tmp_path / "v.mha")
    path = image(tmp_path, "w.mhd")
    (tmp_path / "w.raw").unlink()
    os.mkfifo(tmp_path / "w.raw")
    with pytest.raises(InputError, match=r"w\.mhd: .* is a pipe or a device"):
        read_volume(path)


def test_damage_in_a_packed_image_is_never_silent(tmp_path):
    path = image(tmp_path, "v.mha", packed=True)
    content = path.read_bytes()
    begin = content.index(b"LOCAL\n") + 6
    for at in range(begin, len(content), 5):
        path.write_bytes(content[:at] + bytes([content[at] ^ 0x10]) + content[at + 1 :])
        with pytest.raises(InputError, match=r"v\.mha: (truncated|more voxels)"):
            read_volume(path)


@pytest.mark.parametrize(("name", "bomb"), [("v.mha", metaimage_bomb), ("v.nii.gz", nifti_bomb)])
def test_an_image_that_unpacks_to_more_than_it_says_or_than_it_may_take_is_refused(tmp_path, monkeypatch, name, bomb):
    monkeypatch.setattr(apart, "MEMORY", 600 << 20)
    (tmp_path / name).write_bytes(bomb(1 << 29))
    with pytest.raises(InputError, match=r"more voxels than|takes more than 0\.6 GB"):
        read_volume(tmp_path / name)


def test_three_gigabytes_that_are_packed_into_three_megabytes_are_refused_before_they_are_unpacked(tmp_path):
    (tmp_path / "v.nii.gz").write_bytes(nifti_bomb(3 << 30))
    begin = time.process_time()
    with pytest.raises(InputError, match="no image is so even"):
        read_volume(tmp_path / "v.nii.gz")
    assert time.process_time() - begin < 1


@pytest.mark.parametrize("name", ["v.mha", "v.nrrd", "v.nii", "v.nii.gz", "v.mhd"])
@pytest.mark.parametrize("surplus", [-7, 3])
def test_missing_and_surplus_voxels_are_refused(tmp_path, name, surplus):
    path = image(tmp_path, name)
    victim = path.with_suffix(".raw") if name == "v.mhd" else path
    content = victim.read_bytes()
    victim.write_bytes(content[:surplus] if surplus < 0 else content + b"\1" * surplus)
    with pytest.raises(InputError, match=r"truncated|more voxels|not an image"):
        read_volume(path)


def test_a_dicom_slice_with_a_damaged_value_representation_is_named(tmp_path):
    dicom(tmp_path)
    path = tmp_path / "slice0004.dcm"
    change(path, b"\x20\x00\x37\x00DS", b"\x20\x00\x37\x00Z\x00")
    with pytest.raises(InputError, match=r"slice0004\.dcm: "):
        read_volume(tmp_path)


@pytest.mark.parametrize(("ending", "words"), [(signal.SIGSEGV, "ended the process"), (signal.SIGKILL, "did not end")])
def test_a_reader_that_dies_is_an_error_and_the_next_image_is_read(tmp_path, monkeypatch, ending, words):
    path = image(tmp_path, "v.mha")
    sound = read_volume(path)
    process = apart._HELPER._process
    asked = apart._asked

    def killed(*arguments):
        os.kill(process.pid, ending)
        process.wait()
        return asked(*arguments)

    monkeypatch.setattr(apart, "_asked", killed)
    with pytest.raises(InputError, match=words):
        read_volume(path)
    monkeypatch.undo()
    np.testing.assert_array_equal(read_volume(path).grey, sound.grey)


def test_a_reader_that_takes_too_long_is_ended(tmp_path, monkeypatch):
    path = image(tmp_path, "v.mha")
    read_volume(path)
    apart._HELPER._process.send_signal(signal.SIGSTOP)
    monkeypatch.setattr(apart, "SECONDS", 0.05)
    begin = time.monotonic()
    with pytest.raises(InputError, match="did not end"):
        read_volume(path)
    assert time.monotonic() - begin < 10


def without_line(path, key):
    """Take the line of the header that begins with a key out of a file."""
    path.write_bytes(re.sub(rb"(?m)^" + key + rb"[^\n]*\n", b"", path.read_bytes(), count=1))


def blanked(path, at, length):
    content = path.read_bytes()
    path.write_bytes(content[:at] + bytes(length) + content[at + length :])


UNSIZED = {
    "v.mha": lambda path: without_line(path, b"ElementSpacing"),
    "v.mhd": lambda path: without_line(path, b"ElementSpacing"),
    "v.nrrd": lambda path: without_line(path, b"space directions"),
    "v.nhdr": lambda path: without_line(path, b"space directions"),
    "v.nii": lambda path: blanked(path, 123, 1),  # xyzt_units: the size is there, its unit is not
    "w.nii": lambda path: blanked(path, 80, 4),  # pixdim[1]
}


@pytest.mark.parametrize("name", UNSIZED)
def test_a_voxel_size_that_is_not_there_is_asked_for_and_never_assumed(tmp_path, name):
    path = image(tmp_path, name)
    UNSIZED[name](path)
    with pytest.raises(InputError, match=r"size of its voxels is not known; give it in cm:"):
        read_volume(path)
    np.testing.assert_array_equal(read_volume(path, 0.01).spacing, np.full(3, 0.01))
