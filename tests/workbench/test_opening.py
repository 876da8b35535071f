"""What `vasowave open` makes of a folder that is not a study."""

import pytest

from lab_files import recorded
from vasowave.base import InputError
from vasowave.study.entering import read_rows
from vasowave.workbench import opened


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
    with pytest.raises(InputError, match=r"name a study, recordings, or an empty folder for a study: .*no file there"):
        opened(place)
    assert sorted(one.name for one in tmp_path.iterdir()) == ["letters"]


@pytest.mark.parametrize(("name", "content"), [("one.mat", b"no matlab"), ("notes.txt", b"weigh the mice on monday\n")])
@pytest.mark.parametrize("what", ["folder", "file"])
def test_files_that_are_no_recordings_are_refused_with_the_reason_and_leave_no_study(tmp_path, name, content, what):
    place = tmp_path / "bad"
    place.mkdir()
    (place / name).write_bytes(content)
    with pytest.raises(InputError, match=rf"no study can be made of it; .*no recording among these files:\n.*{name}"):
        opened(place if what == "folder" else place / name)
    assert [one.name for one in tmp_path.rglob("*")] == ["bad", name]


def test_a_place_that_is_not_there_is_refused_and_says_what_makes_a_study(tmp_path):
    with pytest.raises(InputError, match=r"there is no such folder; `vasowave new .*nowhere` makes a study there"):
        opened(tmp_path / "nowhere")
    assert list(tmp_path.iterdir()) == []


def test_a_recording_of_a_study_whose_table_has_another_name_opens_in_that_study(tmp_path):
    raw_files(tmp_path / "lab", ["CTL/a.mat", "HPH/b.mat"])
    study = opened(tmp_path / "lab").folder
    (study / "animals.csv").rename(study / "mice.csv")
    (study / "study.yaml").write_text("animals: mice.csv\n", encoding="utf-8")
    raw = study / "recordings" / "c.mat"
    (tmp_path / "lab" / "CTL" / "a.mat").rename(raw)
    table = (study / "mice.csv").read_text(encoding="utf-8")
    (study / "mice.csv").write_text(table.replace("../lab/CTL/a.mat", "recordings/c.mat"), encoding="utf-8")
    assert opened(raw)[:2] == (study, "#recording/a")
    assert not raw.with_name("c study").exists()


def test_a_folder_of_results_alone_opens_at_its_explorer_and_a_study_at_its_animals(tmp_path):
    (tmp_path / "results").mkdir()
    assert opened(tmp_path)[:2] == (tmp_path, "#explorer")
    (tmp_path / "study.yaml").touch()
    assert opened(tmp_path) == opened(tmp_path / "study.yaml") == (tmp_path, "", (), None)


def test_a_folder_of_slices_gets_a_study_beside_it_and_what_is_of_no_use_is_refused(tmp_path):
    scan = tmp_path / "my scan"
    scan.mkdir()
    (scan / "1").write_bytes(b"\0" * 128 + b"DICM")
    found = opened(scan)
    assert (found.folder.name, found.desk, found.image) == ("my scan study", "#lung/my%20scan", scan)
    (tmp_path / "x.doc").touch()
    with pytest.raises(InputError, match=r"x.doc: the workbench opens studies, fits, recordings and images"):
        opened(tmp_path / "x.doc")
    for name in ("none.csv", "none.nrrd"):
        with pytest.raises(InputError, match=f"{name}: there is no such file"):
            opened(tmp_path / name)
