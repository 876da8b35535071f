"""What `vasowave open` makes of a folder that is no study."""

import shutil

import pytest

from lab_files import recorded
from vasowave.errors import InputError
from vasowave.study.table import read_rows
from vasowave.workbench.opening import opened


def raw_files(folder, names):
    import scipy.io

    for seed, name in enumerate(names, 1):
        raw = recorded(seed, 14.0, duration=8.0)
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        signals = {one: getattr(raw, one).astype("f4") for one in ("pressure", "flow", "ecg")}
        scipy.io.savemat(folder / name, signals)


def test_a_folder_of_recordings_becomes_a_study_beside_it_and_stays_as_it_is(tmp_path):
    place = tmp_path / "march"
    raw_files(place, ["CTL/a.mat", "HPH/b.mat"])
    before = {one: one.read_bytes() for one in place.rglob("*.mat")}
    first = opened(place)
    assert first.folder == tmp_path / "march study"
    rows = read_rows(first.folder / "animals.csv").rows
    assert [(row["animal"], row["group"]) for row in rows] == [("a", "CTL"), ("b", "HPH")]
    assert {one: one.read_bytes() for one in place.rglob("*") if one.is_file()} == before
    table = (first.folder / "animals.csv").read_bytes()
    assert opened(place).folder == first.folder
    assert (first.folder / "animals.csv").read_bytes() == table


def test_a_folder_without_recordings_is_refused_and_nothing_is_written(tmp_path):
    place = tmp_path / "letters"
    place.mkdir()
    (place / "letter.docx").write_bytes(b"PK")
    with pytest.raises(InputError, match="holds no recordings"):
        opened(place)
    assert sorted(one.name for one in tmp_path.iterdir()) == ["letters"]


def test_a_folder_of_damaged_recordings_is_opened_and_says_what_is_wrong(tmp_path):
    place = tmp_path / "bad"
    place.mkdir()
    (place / "one.mat").write_bytes(b"no matlab")
    found = opened(place)
    assert any("one.mat" in line for line in found.said)
    shutil.rmtree(found.folder)
