"""Rows of one animal and of a table, and what stands behind a bed, on the edge of each rule."""

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import vasowave as vw
from vasowave.errors import InputError
from vasowave.study.loading import _wedged
from vasowave.study.single_animal import _check_place, one_row, option_of
from vasowave.study.table import Known, seen_from
from vasowave.study.template import write_virtual_study

CYCLE = vw.virtual_mouse()


@pytest.fixture
def files(tmp_path):
    network = tmp_path / "net.csv"
    vw.write_network(vw.control_network(), network)
    for name in ("p.csv", "q.csv", "r.csv"):
        (tmp_path / name).write_text("pressure [mmHg]\n1\n")
    return network, [tmp_path / name for name in ("p.csv", "q.csv", "r.csv")]


def test_an_animal_has_one_file_or_pressure_and_flow(files):
    network, recordings = files
    assert [one.name for one in one_row(network, recordings[:1], "m", "CTL", {}).recordings] == ["p.csv"]
    assert [one.name for one in one_row(network, recordings[:2], "m", "CTL", {}).recordings] == ["p.csv", "q.csv"]
    with pytest.raises(InputError, match="3 files given; a recording is one file"):
        one_row(network, recordings, "m", "CTL", {})
    with pytest.raises(InputError, match=r"none.csv: there is no such file"):
        one_row(network, [network.with_name("none.csv")], "m", "CTL", {})
    with pytest.raises(InputError, match=r"net.csv holds vessels, .*p.csv does not: the network comes first"):
        one_row(recordings[0], [recordings[1], network], "m", "CTL", {})


def test_options_stand_for_columns():
    assert option_of("flow unit").part == "--unit flow"
    assert option_of("pressure channel").part == "--channel pressure"
    assert option_of("start [s]").part == "--start"
    assert option_of("beat edits").part == "--beat-edits"


def test_a_fit_takes_an_empty_folder_or_its_own(tmp_path):
    _check_place(tmp_path / "new")
    file = tmp_path / "file"
    file.write_text("x")
    with pytest.raises(InputError, match="is a file; give the name of a folder"):
        _check_place(file)
    study = tmp_path / "study"
    study.mkdir()
    (study / "study.yaml").write_text("")
    with pytest.raises(InputError, match="is a study; add the animal"):
        _check_place(study)
    earlier = tmp_path / "earlier"
    earlier.mkdir()
    (earlier / "results.nc").write_text("")
    with pytest.raises(InputError, match="of an earlier version"):
        _check_place(earlier)
    other = tmp_path / "other" / "results"
    other.mkdir(parents=True)
    _check_place(other.parent)  # empty
    (other / "notes.txt").write_text("")
    with pytest.raises(InputError, match="is not empty and not a vasowave result"):
        _check_place(other.parent)
    (other / "cache").mkdir()
    _check_place(other.parent)


def test_the_pressure_behind_the_beds_is_the_given_mean_or_that_of_its_wave(tmp_path):
    time = np.arange(101) / 100 * CYCLE.period
    wave = 5 + np.sin(2 * np.pi * time / CYCLE.period)
    path = tmp_path / "la.csv"
    np.savetxt(path, np.c_[time, wave], "%.9f", ",", header="time [s],pressure [mmHg]", comments="")

    def found(wedge, file):
        one, notes = _wedged(CYCLE, SimpleNamespace(wedge=wedge, wedge_wave=file))
        return one.wedge_pressure, one.wedge_pulsation, [note.code for note in notes]

    assert found(None, None)[::2] == (0.0, [])
    mean, pulsation, notes = found(4.0, None)
    assert (mean, pulsation, len(notes)) == (4.0, None, 1)
    mean, pulsation, notes = found(None, path)
    assert mean == pytest.approx(5.0, abs=1e-6)
    assert np.ptp(pulsation) == pytest.approx(2.0, abs=1e-2)
    assert len(notes) == 2
    assert len(found(5.99, path)[2]) == 2
    assert len(found(6.01, path)[2]) == 3  # more than a millimeter of mercury apart
    assert len(found(3.99, path)[2]) == 3
    assert found(0.0, path)[0] == 0.0


def test_a_recording_that_was_moved_is_known_by_its_name_and_its_bytes(tmp_path):
    for name in ("here.txt", "twin.txt"):
        (tmp_path / name).write_text("same")
    (tmp_path / "new").mkdir()
    for name in ("gone.txt", "flow.txt", "third.txt"):
        (tmp_path / "new" / name).write_text(name)
    rows = [{"animal": "a", "recording": "here.txt"}, {"animal": "b", "recording": "old/gone.txt", "flow": "old/f.txt"}]
    known = Known(tmp_path, rows)

    def recorded(*names):
        return SimpleNamespace(files=[tmp_path / name for name in names])

    assert known.row_of(recorded("here.txt")) is rows[0]
    assert known.row_of(recorded("new/third.txt")) is None
    assert known.row_of(recorded("new/gone.txt", "new/flow.txt")) is rows[1]
    assert rows[1] == {"animal": "b", "recording": "new/gone.txt", "flow": "new/flow.txt"}
    assert known.row_of(recorded("new/gone.txt")) is None  # it has been found
    assert known.twin_of(recorded("twin.txt")) == "a"
    assert known.twin_of(recorded("new/third.txt")) == ""
    assert known.twin_of(recorded("new/third.txt")) == "third.txt"
    assert seen_from(tmp_path, Path(tmp_path / "new" / "flow.txt")) == "new/flow.txt"


def test_a_demo_goes_into_a_folder_that_is_empty_or_its_own(tmp_path):
    file = tmp_path / "file"
    file.write_text("x")
    with pytest.raises(InputError, match="is a file"):
        write_virtual_study(file)
    full = tmp_path / "full"
    full.mkdir()
    (full / "notes.txt").write_text("x")
    with pytest.raises(InputError, match="is not empty and not the study of virtual mice"):
        write_virtual_study(full)
