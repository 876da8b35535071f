"""Files and folders appear whole or not at all."""

import os
import subprocess
import sys
import time
from pathlib import Path

import pytest

from vasowave.base import InputError
from vasowave.base.io import check_file, check_folder, made_inside, remove_parts, write_file, write_folder
from vasowave.base.runtime import PART, Part


def full(*arguments, **options):
    raise OSError(28, "No space left on device")


def fill(folder: Path, *names: str) -> None:
    with write_folder(folder) as fresh:
        for name in names:
            (fresh / name).write_text("new")


def content(folder: Path) -> dict[str, str]:
    return {path.name: path.read_text() for path in folder.rglob("*") if path.is_file()}


def test_a_folder_that_is_a_link_to_itself_is_refused_in_words(tmp_path):
    (tmp_path / "results").symlink_to("results")
    with pytest.raises(InputError, match=r"results: cannot be opened.*link to itself"):
        made_inside(tmp_path, "results")


def test_what_a_killed_program_left_of_a_folder_goes_at_once_and_what_is_being_filled_stays(tmp_path):
    program = (
        "import os, signal\nfrom pathlib import Path\nfrom vasowave.base.io.files import write_folder\n"
        f"with write_folder(Path({str(tmp_path)!r})) as fresh:\n"
        "    (fresh / 'a').write_text('half')\n    os.kill(os.getpid(), signal.SIGKILL)\n"
    )
    subprocess.run([sys.executable, "-c", program], check=False)
    assert len(list(tmp_path.glob(f"{PART}*"))) == 1
    check_folder(tmp_path, {"page.html": b"vasowave"})  # nothing but this stands there: the command may be given again
    with write_folder(tmp_path) as fresh:
        (fresh / "b").write_text("new")
        assert len(list(tmp_path.glob(f"{PART}*"))) == 1
        remove_parts(tmp_path, 3600.0)
        fill(tmp_path, "c")
        assert (fresh / "b").exists()
    assert content(tmp_path) == {"b": "new", "c": "new"}


def test_what_a_killed_program_left_of_a_file_goes_after_seconds_and_what_is_being_written_stays(tmp_path):
    (tmp_path / f"{PART}left.csv").write_text("half")
    with Part(tmp_path / "a.csv") as part:
        for path in tmp_path.iterdir():
            os.utime(path, (time.time() - 10, time.time() - 10))
        remove_parts(tmp_path, 3600.0)
        assert [path.name for path in tmp_path.iterdir()] == [part.path.name]
        part.take_place()
    assert [path.name for path in tmp_path.iterdir()] == ["a.csv"]


def test_a_file_that_cannot_be_finished_leaves_the_earlier_one_whole(tmp_path, monkeypatch):
    write_file(tmp_path / "table.csv", "old")
    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(InputError, match=r"table\.csv: no space left"):
        write_file(tmp_path / "table.csv", "new")
    assert [path.name for path in tmp_path.iterdir()] == ["table.csv"]
    assert (tmp_path / "table.csv").read_text() == "old"


@pytest.mark.parametrize(
    ("place", "reason"),
    [
        ("nowhere/x", "its folder does not exist"),
        ("file/x", "is a file"),
        ("folder", "it is a folder"),
        ("x" * 300, "too long"),
    ],
)
def test_why_a_file_cannot_be_written_is_said(tmp_path, place, reason):
    (tmp_path / "file").write_text("")
    (tmp_path / "folder").mkdir()
    with pytest.raises(InputError, match=reason):
        write_file(tmp_path / place, "text")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["file", "folder"]


def test_a_link_is_replaced_and_what_it_leads_to_stays(tmp_path):
    outside, folder = tmp_path / "outside", tmp_path / "folder"
    outside.mkdir()
    folder.mkdir()
    (outside / "mine.txt").write_text("mine")
    (folder / "table.csv").symlink_to(outside / "mine.txt")
    (folder / "figures").symlink_to(outside)
    write_file(folder / "table.csv", "table")
    with write_folder(folder) as fresh:
        (fresh / "figures").mkdir()
        (fresh / "figures" / "mine.txt").write_text("figure")
    assert content(outside) == {"mine.txt": "mine"}
    assert not (folder / "figures").is_symlink()
    assert (folder / "figures" / "mine.txt").read_text() == "figure"
    (folder / "results").symlink_to(outside)
    with pytest.raises(InputError, match="a link that leads out of"):
        made_inside(folder, "results")


def test_a_folder_replaces_what_it_brings_and_keeps_the_rest(tmp_path):
    folder = tmp_path / "report"
    (folder / "figures").mkdir(parents=True)
    (folder / "figures" / "old.svg").write_text("old")
    (folder / "notes.txt").write_text("mine")
    with write_folder(folder) as fresh:
        (fresh / "figures").mkdir()
        (fresh / "figures" / "new.svg").write_text("new")
        (fresh / "report.html").write_text("page")
    assert content(folder) == {"new.svg": "new", "notes.txt": "mine", "report.html": "page"}
    assert list(folder.glob(".*")) == []


@pytest.mark.parametrize("failing", [1, 2, 3, 4])
def test_a_folder_whose_move_fails_at_any_step_is_as_it_was(tmp_path, monkeypatch, failing):
    folder = tmp_path / "report"
    folder.mkdir()
    for name in ("a.csv", "page.html"):
        (folder / name).write_text("old")
    steps, replace = iter(range(1, 99)), os.replace

    def fail_once(source, target):
        if next(steps) == failing:
            full()
        replace(source, target)

    monkeypatch.setattr(os, "replace", fail_once)
    with pytest.raises(InputError, match="no space left"):
        fill(folder, "a.csv", "b.csv", "page.html")
    assert content(folder) == {"a.csv": "old", "page.html": "old"}
    assert list(folder.glob(".*")) == []


def test_an_error_while_a_folder_is_filled_leaves_nothing(tmp_path):
    with pytest.raises(InputError, match="its folder does not exist"):
        fill(tmp_path / "new", "half", "no folder/page.html")
    assert list(tmp_path.iterdir()) == []


def test_the_page_comes_last(tmp_path):
    program = (
        "import sys\nfrom pathlib import Path\nfrom vasowave.base.io.files import write_folder\n"
        "def heard(event, given):\n    event == 'os.rename' and print(Path(given[1]).name)\n"
        f"with write_folder(Path({str(tmp_path)!r}) / 'report') as fresh:\n"
        "    for name in ('a.html', 'tables', 'z.csv'):\n        (fresh / name).write_text('')\n"
        "    sys.addaudithook(heard)\n"
    )
    done = subprocess.run([sys.executable, "-c", program], check=True, capture_output=True, text=True)
    assert done.stdout.split() == ["tables", "z.csv", "a.html"]


def test_a_folder_with_other_work_is_refused_and_left_alone(tmp_path):
    (tmp_path / "thesis.tex").write_text("ten years")
    with pytest.raises(InputError, match="not a vasowave result"):
        check_folder(tmp_path, {"page.html": b"vasowave"})
    (tmp_path / "page.html").write_text("made by vasowave")
    check_folder(tmp_path, {"page.html": b"vasowave"})
    with pytest.raises(InputError, match="is a file"):
        check_folder(tmp_path / "page.html", {})


def test_the_name_of_a_file_to_be_written_is_checked_before_anything_is_computed(tmp_path):
    check_file(tmp_path / "y.CSV", ".csv")
    for path, suffixes, words in (
        (tmp_path, (), "is a folder; give the name of a file"),
        (tmp_path / "x" / "y.csv", (), "there is no folder"),
        (tmp_path / "y.txt", (".csv", ".tsv"), r"the name of this file ends in \.csv or \.tsv"),
    ):
        with pytest.raises(InputError, match=words):
            check_file(path, *suffixes)
