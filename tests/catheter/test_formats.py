"""What a file is, is known in one place, found once and remembered; nobody parses a file twice for one command."""

import os
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from threading import Barrier

import numpy as np
import pytest
from scipy.io import savemat

from vasowave.base import InputError
from vasowave.base.io import Format, Registry, look, read_mat, remembered
from vasowave.catheter.read.formats import RECORDINGS
from vasowave.pulse.network_formats import NETWORKS


def aged(path):
    """Return a path whose file was written long ago, so that what is found in it may be remembered."""
    os.utime(path, (1.6e9, 1.6e9))
    return path


# A format of one's own


def test_the_newest_format_of_a_name_counts_and_content_counts_before_the_suffix(tmp_path):
    registry = Registry[Format]("vasowave.catheter.read.formats", "rest")
    registry.register(Format("rest", "rest", (".txt",), lambda path, start: False, lambda path: "rest"))
    registry.register(Format("a", "a", (".a",), lambda path, start: start.startswith(b"A"), lambda path: "old"))
    registry.register(Format("a", "a", (".a",), lambda path, start: start.startswith(b"A"), lambda path: "new"))
    found = {}
    for name, content in (("x.txt", "A"), ("x.a", "B"), ("x.foo", "B")):
        (tmp_path / name).write_text(content)
        form = registry.of(tmp_path / name)
        found[name] = (form.name, form.read(tmp_path / name))
    assert found == {"x.txt": ("a", "new"), "x.a": ("a", "new"), "x.foo": ("rest", "rest")}
    assert registry.suffixes == (".a", ".txt")


def test_a_matlab_file_is_a_network_or_a_recording_by_its_variables(tmp_path):
    savemat(tmp_path / "net.mat", {"dim_mat": np.eye(3), "ves_conn": np.zeros((3, 3))})
    savemat(tmp_path / "rec.mat", {"p": np.ones(9)})
    assert NETWORKS.known(tmp_path / "net.mat").name == "dim_mat"
    assert NETWORKS.known(tmp_path / "rec.mat") is None
    assert RECORDINGS.of(tmp_path / "rec.mat").name == "mat"


# What was found is remembered for as long as the file stays as it is


def test_a_file_that_changes_is_read_again_and_one_that_does_not_is_not(tmp_path):
    path = tmp_path / "f.csv"
    path.write_text("p [mmHg]\n1\n2\n")
    young = look(path)
    assert look(path) is not young  # it may still change within the resolution of its time
    old = look(aged(path))
    assert look(path) is old
    path.write_text("p [mmHg]\n1\n3\n")  # as long as before
    aged(path)
    assert look(path).sha256 != old.sha256
    path.unlink()
    with pytest.raises(InputError, match="no such file"):
        look(path)


def test_two_files_are_read_at_the_same_time_and_one_file_once(tmp_path):
    both, reads = Barrier(2), []

    @remembered.remembered
    def read(path):
        reads.append(path)
        both.wait(timeout=10.0)  # broken if one had to wait for the other
        return path.name

    paths = [tmp_path / "one", tmp_path / "other"]
    for path in paths:
        path.write_text("")
        aged(path)
    with ThreadPoolExecutor(4) as pool:
        assert list(pool.map(read, [*paths, *paths])) == ["one", "other"] * 2
    assert sorted(reads) == paths


def test_what_is_remembered_of_a_matlab_file_cannot_be_changed(tmp_path):
    savemat(tmp_path / "a.mat", {"p": np.arange(60.0)})
    found = read_mat(aged(tmp_path / "a.mat"))
    assert read_mat(tmp_path / "a.mat") is found  # parsed once
    with pytest.raises(ValueError, match="read-only"):
        found["p"][0] = 1.0


# Opens of a file between a command and the first simulation


def test_a_format_that_is_registered_before_any_file_was_read_comes_first_and_keeps_its_name(tmp_path):
    """In a fresh process, as a user's script: ours are found later, and neither replace it nor are asked before it."""
    program = (
        "from vasowave.catheter.read.formats import RECORDINGS, RecordingFormat\n"
        "def read(path, rate=None, progress=None): return []\n"
        "for name in ('table', 'toy'):\n"
        "    RECORDINGS.register(RecordingFormat(name, 'of a lab', ('.txt',), None, read))\n"
        "print(RECORDINGS['table'].title, RECORDINGS.of('data.txt').name, len(list(RECORDINGS)) > 4)\n"
    )
    (tmp_path / "data.txt").write_text("no recording at all\n", "utf-8")
    done = subprocess.run([sys.executable, "-c", program], cwd=tmp_path, check=True, capture_output=True, text=True)
    assert done.stdout.split("\n")[0] == "of a lab toy True"


def test_a_load_that_failed_is_tried_again(tmp_path, monkeypatch):
    """A module of formats for which the memory does not suffice the first time."""
    package = tmp_path / "formats_of_a_lab"
    package.mkdir()
    (package / "__init__.py").write_text("")
    (package / "one.py").write_text(
        "from pathlib import Path\nagain = Path(__file__).with_name('again')\n"
        "if not again.exists():\n    again.touch()\n    raise MemoryError\n"
    )
    monkeypatch.syspath_prepend(tmp_path)
    own = Registry("formats_of_a_lab", "table")
    with pytest.raises(MemoryError):
        list(own)
    assert "formats_of_a_lab.one" not in sys.modules
    list(own)
    assert "formats_of_a_lab.one" in sys.modules
