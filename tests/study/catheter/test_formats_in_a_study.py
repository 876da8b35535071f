"""What a file is, is known in one place, found once and remembered; nobody parses a file twice for one command."""

import json
import os
import sys
from collections import Counter

import numpy as np
import pytest
from scipy.io import savemat

import vasowave as vw
from lab_files import SMALL, exported, recorded
from vasowave.catheter.read import kind_of, read_raw_recording
from vasowave.catheter.read.formats import RECORDINGS, RecordingFormat
from vasowave.catheter.signals import Block, Channel
from vasowave.pulse.examples import virtual_mouse
from vasowave.pulse.network import write_network
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


# What was found is remembered for as long as the file stays as it is


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
