"""What a file is, is known in one place, found once and remembered; nobody parses a file twice for one command."""

import json
import os
import subprocess
import sys
from collections import Counter
from concurrent.futures import ThreadPoolExecutor
from threading import Barrier

import numpy as np
import pytest
from scipy.io import savemat

import vasowave as vw
from lab_files import SMALL, exported, recorded
from vasowave.base import InputError
from vasowave.base.io import Format, Registry, look, read_mat, remembered
from vasowave.catheter.read import kind_of, read_raw_recording
from vasowave.catheter.read.formats import RECORDINGS, RecordingFormat
from vasowave.catheter.signals import Block, Channel
from vasowave.pulse.examples import virtual_mouse
from vasowave.pulse.network import write_network
from vasowave.pulse.network_formats import NETWORKS
from vasowave.study.entering import add_files, check_study


def aged(path):
    """Return a path whose file was written long ago, so that what is found in it may be remembered."""
    os.utime(path, (1.6e9, 1.6e9))
    return path


# A format of one's own


def read_toy(path, rate=None, progress=None):
    """Read {"rate": 1000, "P [mmHg]": [...], "Q [ml/s]": [...]}: the whole of a new format."""
    content = json.loads(path.read_text(encoding="utf-8"))
    rate = content.pop("rate")
    titles = [(*title.rstrip("]").split(" ["), np.array(values)) for title, values in content.items()]
    return [Block(tuple(Channel(t, unit, values, rate, f"{path}, '{t}'") for t, unit, values in titles))]


@pytest.fixture
def toy():
    RECORDINGS.register(
        RecordingFormat("toy", "toy of a lab", (".toy",), lambda path, start: start.startswith(b'{"rate"'), read_toy)
    )
    yield
    RECORDINGS.remove("toy")


def write_toy(path, pressure, flow, rate):
    content = {"rate": rate, "P [mmHg]": pressure.tolist(), "Q [ml/s]": flow.tolist()}
    path.write_text(json.dumps(content), encoding="utf-8")
    return path


def test_a_format_that_is_registered_in_one_place_serves_every_door(tmp_path, toy):
    mouse, raw = virtual_mouse(), recorded(3, 15.0)
    lab = tmp_path / "lab"
    lab.mkdir()
    cycle = write_toy(lab / "M1.toy", mouse.pressure, mouse.flow, len(mouse.flow) / mouse.period)
    long = write_toy(lab / "M2.toy", raw.pressure, raw.flow, raw.sampling_rate)
    write_network(SMALL, lab / "lung.csv")
    (lab / "unknown.foo").write_text("nothing")

    again = vw.read_recording(cycle)
    np.testing.assert_array_equal(again.pressure, mouse.pressure)
    assert again.period == pytest.approx(mouse.period, rel=1e-12)
    np.testing.assert_array_equal(read_raw_recording(long).flow, raw.flow)
    assert [kind_of([path]) for path in (cycle, long)] == ["cycle", "raw"]
    assert str(vw.describe_recording(long)).startswith("toy of a lab, continuous: ")

    study = tmp_path / "study"
    study.mkdir()
    (study / "study.yaml").write_text("groups: [CTL]\ncalibration: {walls: [linear], starts: 1}\n")
    added = add_files(study, [lab], group="CTL")
    assert [row["recording"] for row in added.rows] == ["../lab/M1.toy", "../lab/M2.toy"]
    checked = check_study(study)
    assert not [problem for problem in checked.problems if problem.error]
    assert len(checked.read) == 2


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


class Opens:
    """Counts what is opened while it listens; the hook of an interpreter cannot be taken away again."""

    def __init__(self):
        self.count, self.listening = Counter(), False
        sys.addaudithook(self.heard)

    def heard(self, event, given):
        if self.listening and event == "open" and isinstance(given[0], str):
            self.count[os.path.basename(given[0])] += 1


OPENS = Opens()


@pytest.fixture
def opens():
    OPENS.count.clear()
    OPENS.listening = True
    yield OPENS.count
    OPENS.listening = False


@pytest.fixture
def every_format(tmp_path):
    """Return a study of one animal a format, none of whose kinds stands in the table."""
    write_network(SMALL, tmp_path / "lung.csv")
    raw = recorded(2, 15.0)
    units = {"pressure_unit": "mmHg", "flow_unit": "ml/s"}
    savemat(tmp_path / "long.mat", {"time": raw.time, "pressure": raw.pressure, "flow": raw.flow, **units})
    (tmp_path / "text.txt").write_text(exported(recorded(3, 15.0)), encoding="utf-8")
    raw, mouse = recorded(4, 15.0), virtual_mouse()
    for name, source in (("long.csv", raw), ("cycle.csv", mouse)):
        columns = np.column_stack([source.time, source.pressure, source.flow])
        header = "time [s],pressure [mmHg],flow [ml/s]"
        np.savetxt(tmp_path / name, columns, fmt="%.9g", delimiter=",", header=header, comments="")
    names = ("long.mat", "text.txt", "long.csv", "cycle.csv")
    rows = "".join(f"{name.replace('.', ' ')},CTL,lung.csv,{name}\n" for name in names)
    (tmp_path / "animals.csv").write_text("animal,group,network,recording\n" + rows)
    (tmp_path / "study.yaml").write_text("groups: [CTL]\ncalibration: {walls: [linear], starts: 1}\n")
    for path in tmp_path.iterdir():
        aged(path)
    return tmp_path, (*names, "lung.csv")


def test_every_file_is_opened_twice_at_most_before_the_first_simulation(every_format, opens):
    """Once here, to look at it, and once to read it, which of a MATLAB file another process does."""
    folder, names = every_format
    checked = check_study(folder)
    assert not [problem for problem in checked.problems if problem.error]
    assert len(checked.read) == 4
    counts = {name: opens[name] for name in names}
    assert all(1 <= count <= (1 if name.endswith(".mat") else 2) for name, count in counts.items()), counts


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
