"""Extractions that keep their stages: the same answer, less work, and nothing believed that is not whole or theirs."""

import numpy as np
import pytest

from vasowave.lung.kept import FOLDER, Stages, forget_stages, image_key, volume_key
from vasowave.lung.read import Volume, write_volume


@pytest.mark.parametrize("damage", [b"", b"\n", b"nothing\n", b"{}", b"00000000{}\n", b"\x80\x04K\x01."])
def test_what_is_no_stage_is_made_again(tmp_path, damage):
    (tmp_path / "stages").mkdir()
    (tmp_path / "stages" / "one.stage").write_bytes(damage)
    assert Stages(tmp_path).kept("one", "key", lambda: (1.5, np.arange(3.0)))[0] == 1.5


def test_any_flipped_bit_or_missing_byte_of_a_stage_is_noticed(tmp_path):
    value = (np.linspace(0, 1, 7), np.array([True, False, True]), "text", None, 0.1)
    stages = Stages(tmp_path)
    stages.kept("one", "key", lambda: value)
    stages.save()
    file = tmp_path / "stages" / "one.stage"
    whole = file.read_bytes()
    again = Stages(tmp_path).kept("one", "key", lambda: None)
    for one, other in zip(value, again, strict=True):
        np.testing.assert_array_equal(one, other)
    for place in range(0, 8 * len(whole), 7):
        broken = bytearray(whole)
        broken[place // 8] ^= 1 << place % 8
        file.write_bytes(broken)
        found = Stages(tmp_path).stored("one", "key")
        assert found == (), f"bit {place}"
    for count in range(0, len(whole), 5):
        file.write_bytes(whole[:count])
        assert Stages(tmp_path).stored("one", "key") == ()
    file.write_bytes(whole + b"x")
    assert Stages(tmp_path).stored("one", "key") == ()


def test_an_image_has_another_key_where_its_files_or_their_voxel_size_are_others(tmp_path):
    rng = np.random.default_rng(0)
    volume = Volume(rng.normal(size=(5, 5, 5)), np.ones(3), np.zeros(3))
    write_volume(volume, tmp_path / "a.nrrd")
    key = image_key(tmp_path / "a.nrrd", None)
    assert image_key(tmp_path / "a.nrrd", 0.1) != key
    series = tmp_path / "series"
    series.mkdir()
    (series / "1").write_bytes(b"one")
    one = image_key(series, None)
    (series / "2").write_bytes(b"two")
    assert len({key, one, image_key(series, None)}) == 3
    write_volume(volume, tmp_path / "b.mhd")  # whose voxels stand in another file
    assert image_key(tmp_path / "b.mhd", None) is None
    write_volume(volume, tmp_path / "b.mha")  # whose voxels stand in itself
    assert image_key(tmp_path / "b.mha", None) is not None
    assert volume_key(volume) != volume_key(Volume(volume.grey + 1, volume.spacing, volume.origin))


def test_stages_are_forgotten_with_their_folder_unless_something_else_lies_there(tmp_path):
    (tmp_path / FOLDER).mkdir()
    (tmp_path / FOLDER / "a.stage").write_bytes(b"x")
    (tmp_path / FOLDER / "mine.txt").write_bytes(b"x")
    forget_stages(tmp_path)
    assert [path.name for path in (tmp_path / FOLDER).iterdir()] == ["mine.txt"]
    (tmp_path / FOLDER / "mine.txt").unlink()
    forget_stages(tmp_path)
    assert not (tmp_path / FOLDER).exists()
