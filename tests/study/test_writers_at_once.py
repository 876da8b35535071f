"""Several hands write into one study at once, and nothing that was confirmed is lost."""

import threading
from concurrent.futures import ThreadPoolExecutor

import pytest
from small_study import write_cycle

from vasowave.base import InputError
from vasowave.pulse.cycle import Recording
from vasowave.pulse.examples import virtual_mouse
from vasowave.study.entering import add_files, adding, read_rows
from vasowave.study.folder import read_settings, too_long
from vasowave.study.running import declare, read_declared, read_study


@pytest.fixture
def study(make_study, tmp_path):
    """A study of one animal, and recordings of three others."""
    folder, mouse = make_study(animals=1), virtual_mouse()
    (tmp_path / "new" / "CTL").mkdir(parents=True)
    for number in range(3):
        other = Recording(mouse.pressure + number + 1.0, mouse.flow, mouse.period)
        write_cycle(tmp_path / "new" / "CTL" / f"rat {number}.csv", other)
    return folder


def animals(folder):
    return [row["animal"] for row in read_rows(folder / "animals.csv").rows]


def test_three_that_add_at_once_end_with_three_rows(study, tmp_path):
    files = sorted((tmp_path / "new" / "CTL").iterdir())
    together = threading.Barrier(3)

    def add(file):
        together.wait(30)
        return add_files(study, [file]).rows

    with ThreadPoolExecutor(3) as threads:
        rows = list(threads.map(add, files))
    assert [len(one) for one in rows] == [1, 1, 1]
    assert animals(study)[0] == "mouse 0"
    assert sorted(animals(study)[1:]) == ["rat 0", "rat 1", "rat 2"]


def test_what_another_hand_wrote_while_files_were_read_stays_and_a_person_is_asked_once(study, tmp_path, monkeypatch):
    asked, table = [], study / "animals.csv"

    def ask(question, proposal):
        asked.append(question)
        table.write_text(table.read_text().replace("mouse 0,CTL", "mouse 0 (old),CTL"))
        return proposal

    (tmp_path / "new" / "CTL").rename(tmp_path / "new" / "sham")
    (tmp_path / "new" / "banded").mkdir()
    (tmp_path / "new" / "sham" / "rat 2.csv").rename(tmp_path / "new" / "banded" / "rat 2.csv")
    add_files(study, [tmp_path / "new"], ask=ask)
    assert animals(study)[0] == "mouse 0 (old)"
    assert sorted(animals(study)[1:]) == ["rat 0", "rat 1", "rat 2"]
    assert len(asked) == 1


def test_a_save_between_the_last_look_and_the_writing_is_not_written_over(study, tmp_path, monkeypatch):
    table, write_files = study / "animals.csv", adding.write_files

    def write_after_an_editor(contents, seen):
        table.write_text("# mine\n" + table.read_text())
        write_files(contents, seen)

    monkeypatch.setattr(adding, "write_files", write_after_an_editor)
    with pytest.raises(InputError, match=r"animals\.csv was changed elsewhere meanwhile; nothing was written"):
        add_files(study, [tmp_path / "new"])
    assert table.read_text().startswith("# mine\n")
    assert animals(study) == ["mouse 0"]


def test_two_that_declare_at_once_write_one_record(study):
    plan = read_study(study)
    with ThreadPoolExecutor(2) as threads:
        list(threads.map(lambda _: declare(plan), range(4)))
    assert len(read_declared(study / "declared.json")) == 1


@pytest.mark.parametrize("name", ["../animals.csv", "/tmp/animals.csv", "linked/animals.csv"])
def test_a_table_outside_of_the_study_is_refused_at_once_with_what_to_do(study, tmp_path, name):
    (study / "linked").symlink_to(tmp_path)
    (study / "animals.csv").rename(tmp_path / "animals.csv")
    text = (study / "study.yaml").read_text()
    (study / "study.yaml").write_text(f"animals: {name}\n{text}")
    settings, document = read_settings(study / "study.yaml")
    assert settings is None
    (problem,) = document.problems
    assert str(problem).endswith(
        f"'{name}' lies outside of the study, where nothing is written; copy the table into the study's folder and "
        "name the copy here"
    )
    assert problem.place.line == 1
    with pytest.raises(InputError, match="lies outside of the study"):
        add_files(study, [tmp_path / "new"])


def test_a_path_that_leaves_no_room_for_results_is_told_with_its_length(tmp_path):
    deep = tmp_path
    while len(str(deep)) < 3800:
        deep = deep / ("y" * 40)
    assert too_long(deep) is None
    deep = deep / ("z" * (3900 - 1 - len(str(deep))))
    assert too_long(deep) == len(str(deep))
