"""What was said of files is said again only for as long as nothing on which it rests has changed."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import vasowave
from vasowave.base.io import answer_to, basis_of, keep_answer

QUESTION = ("check", "study")


@pytest.fixture
def files(tmp_path, monkeypatch):
    """A folder of two files, of the first of which something was said."""
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))
    folder = tmp_path / "lab"
    folder.mkdir()
    for name in ("a.csv", "b.csv", "ours"):
        (folder / name).write_text("1,2,3\n", "utf-8")
    keep_answer(QUESTION, basis_of([folder / "a.csv", folder / "c.csv"], [folder], ["ours"]), ["12 mmHg"])
    return folder


def same_times(file, text):
    """Write as many letters into a file, and give it back its time."""
    about = file.stat()
    file.write_text(text, "utf-8")
    os.utime(file, ns=(about.st_atime_ns, about.st_mtime_ns))


def elsewhere(folder):
    shutil.copytree(folder, folder.with_name("copy"))
    shutil.rmtree(folder)
    folder.with_name("copy").rename(folder)


CHANGES = {
    "content": lambda folder: same_times(folder / "a.csv", "1,2,4\n"),
    "content of a neighbor": lambda folder: same_times(folder / "b.csv", "1,2,4\n"),
    "a file that was not there": lambda folder: (folder / "c.csv").write_text("", "utf-8"),
    "another neighbor": lambda folder: (folder / "d.csv").write_text("", "utf-8"),
    "a neighbor less": lambda folder: (folder / "b.csv").unlink(),
    "a file less": lambda folder: (folder / "a.csv").unlink(),
    "a neighbor's name": lambda folder: (folder / "b.csv").rename(folder / "e.csv"),
    "a folder less": shutil.rmtree,
    "another folder": elsewhere,
}


def test_what_rests_on_the_same_files_is_said_again(files):
    (files / "ours").write_text("another", "utf-8")
    assert answer_to(QUESTION) == ["12 mmHg"]
    assert answer_to(("check", "another")) is None


@pytest.mark.parametrize("change", CHANGES.values(), ids=CHANGES)
def test_a_change_is_noticed_whatever_times_files_bear(files, change):
    assert answer_to(QUESTION) is not None
    change(files)
    assert answer_to(QUESTION) is None


def test_the_content_of_a_file_counts_without_its_folder(files):
    question = ("check", "content alone")
    keep_answer(question, basis_of([files / "a.csv"], []), ["said"])
    (files / "b.csv").write_text("another", "utf-8")
    assert answer_to(question) == ["said"]
    same_times(files / "a.csv", "1,2,4\n")
    assert answer_to(question) is None


def test_another_library_says_it_anew(files, monkeypatch):
    (files.parent / "site" / "numpy-0.0.dist-info").mkdir(parents=True)
    monkeypatch.syspath_prepend(files.parent / "site")
    assert answer_to(QUESTION) is None


def test_another_program_says_it_anew(files):
    program = files.parent / "program"
    package = Path(vasowave.__file__).parent
    shutil.copytree(package, program / "vasowave", ignore=shutil.ignore_patterns("__pycache__"))
    ask = f"import vasowave; from vasowave.base.io import answer_to; print(answer_to({QUESTION}), vasowave.__file__)"

    def asked():
        command = [sys.executable, "-c", f"import sys; sys.path = {[str(program), *sys.path]}; {ask}"]
        done = subprocess.run(command, capture_output=True, text=True, check=True)
        return done.stdout.replace(str(program), "").strip()

    assert asked() == "['12 mmHg'] /vasowave/__init__.py"
    with (program / "vasowave" / "base" / "units.py").open("a", encoding="utf-8") as file:
        file.write("# another version\n")
    assert asked() == "None /vasowave/__init__.py"


@pytest.mark.parametrize("damage", [lambda text: text[:-1], lambda text: text.replace(b"12", b"21"), lambda text: b""])
def test_a_damaged_answer_is_none(files, damage):
    (file,) = (files.parent / "state" / "vasowave" / "answers").iterdir()
    assert file.stat().st_mode & 0o77 == 0
    file.write_bytes(damage(file.read_bytes()))
    assert answer_to(QUESTION) is None


def test_where_nothing_can_be_kept_nothing_is(files, monkeypatch):
    monkeypatch.setenv("XDG_STATE_HOME", str(files / "a.csv"))
    keep_answer(QUESTION, basis_of([], []), ["12 mmHg"])
    assert answer_to(QUESTION) is None
