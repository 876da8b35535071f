"""What the workbench refuses, keeps, finds and writes, on the edge of each rule, without a server or a browser."""

import json
import os
from collections import OrderedDict
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr

from vasowave.errors import InputError
from vasowave.recording import BeatEdit, RawRecording, edits
from vasowave.recording.raw import SHORTEST
from vasowave.solver.result import Run
from vasowave.study.table import read_rows
from vasowave.study.template import new_study
from vasowave.workbench import actions, explorer, lungs, opening, recordings, studies, study_actions
from vasowave.workbench.access import LARGEST_ACTION, LARGEST_FILE, Guarded
from vasowave.workbench.actions import act
from vasowave.workbench.desk import Desk, unchanged
from vasowave.workbench.explorer import Explorer
from vasowave.workbench.recordings import Opened, Recordings, Trace, edits_file, mean_between, row_of
from vasowave.workbench.running import Runs
from vasowave.workbench.values import number, numbers
from vasowave.workbench.workplace import ACTIONS, Workplace


@pytest.fixture
def at(tmp_path):
    folder = tmp_path / "study"
    new_study(folder)
    lines = [
        "animal,group,network,recording,mine",
        "m1,CTL,networks/n.csv,recordings/a.csv,x",
        "M2,HPH,,recordings/b.csv,",
    ]
    (folder / "animals.csv").write_text("\n".join(lines) + "\n")
    for name in ("networks/n.csv", "networks/o.csv", "recordings/a.csv", "recordings/b.csv"):
        (folder / name).write_text("x")
    return Workplace(Desk(folder), Recordings(), Runs(), lungs.Lungs())


def asked(at, do, **more):
    return act(at, {"do": do, **more})


def cells(at, animal):
    return next(row for row in read_rows(at.desk.table).rows if row["animal"] == animal)


@pytest.mark.parametrize(
    ("message", "words"),
    [
        ([], "a message names what to do"),
        ({"do": 3}, "a message names what to do"),
        ({"do": "set-cell"}, r"there is no action 'set-cell' \(did you mean 'set-cells'\?\)"),
        ({"do": "x" * 90}, f"there is no action '{'x' * 80}'"),
        ({"do": "set-cells", "animal": "m9", "cells": {"group": "HPH"}}, "there is no animal 'm9' in animals.csv"),
        ({"do": "set-cells", "animal": "m1", "cells": {"grup": "HPH"}}, r"no column 'grup' \(did you mean 'group'\?\)"),
        ({"do": "set-cells", "animal": "m1", "cells": {"end [s]": "-1"}}, r"end \[s\]: -1 is not a positive number"),
        ({"do": "set-cells", "animal": "m1", "cells": {"animal": "m2"}}, "'m2': an animal has a name that no other"),
        ({"do": "set-cells", "animal": "m1", "cells": {"animal": ""}}, "'': an animal has a name that no other has"),
        ({"do": "set-cells", "animal": "m1", "cells": {"mine": "y"}, "was": {"mine": "z"}}, "m1: mine was changed"),
        ({"do": "use-network", "network": "networks/none.csv"}, "there is no file networks/none.csv in this study"),
        ({"do": "add-column", "title": " "}, "a column has a title"),
        ({"do": "add-column", "title": "GROUP"}, "'GROUP' is no column of your own"),
        ({"do": "add-column", "title": "mine"}, "mine: stands twice"),
        ({"do": "add-column", "title": "weight (g) at end"}, "cannot read the column title"),
        ({"do": "add-column", "title": "a;b"}, "a;b|columns where"),
        ({"do": "add-column", "title": "weight (g)"}, r"'weight \(g\)' would be read as 'weight \[g\]'; write it"),
        ({"do": "set-cells", "animal": "m1", "cells": {"animal": " m2\t"}}, "'m2': an animal has a name that no other"),
        ({"do": "remove-column", "title": "group"}, "no column 'group' of your own in animals.csv"),
        ({"do": "remove-column", "title": "yours"}, "no column 'yours' of your own in animals.csv"),
        ({"do": "remove-animal", "animal": "m3"}, "there is no animal 'm3' in animals.csv"),
        ({"do": "set-setting", "key": "a.b.c", "value": "1"}, "'a.b.c: 1' is no key with a value"),
        ({"do": "set-setting", "key": "title", "value": "a\nb"}, "is no key with a value"),
        ({"do": "edit-beats", "animal": "m1", "edits": [["move", 1.0, None]]}, "a beat is moved to a time, and"),
        ({"do": "edit-beats", "animal": "m1", "edits": [["keep", 1.0, 2.0]]}, "a beat is moved to a time, and"),
        ({"do": "undo"}, "there is nothing to undo"),
        ({"do": "redo"}, "there is nothing to do again"),
        ({"do": "edit-tree", "image": "i", "action": "move", "point": [1, 2, 3]}, "a move has a place to go to"),
        ({"do": "edit-tree", "image": "i", "action": "cut", "point": [1, 2, 3], "to": [1, 2, 3]}, "a move has a place"),
        ({"do": "edit-tree", "image": "i", "action": "radius", "point": [1, 2, 3]}, "a radius its size"),
        ({"do": "edit-tree", "image": "i", "action": "cut", "point": [1, 2, 3], "radius": 1.0}, "a radius its size"),
    ],
)  # fmt: skip
def test_what_cannot_be_done_is_told_and_changes_no_file(at, message, words):
    before = {path: path.read_bytes() for path in at.desk.folder.rglob("*") if path.is_file() and path.suffix}
    with pytest.raises(InputError, match=words):
        act(at, message)
    assert {path: path.read_bytes() for path in before} == before
    assert at.desk.done == []


@pytest.mark.parametrize("other", ["J\u00f6rg  5", "Jo\u0308rg 5", "j\u00f6RG 5"])
def test_names_that_differ_in_blanks_accents_or_capitals_alone_are_one(at, other):
    at.desk.table.write_text(at.desk.table.read_text("utf-8").replace("M2", other), "utf-8")
    with pytest.raises(InputError, match="an animal has a name that no other has"):
        asked(at, "set-cells", animal="m1", cells={"animal": "J\u00f6rg 5"})


def test_what_is_set_stands_in_the_table_and_can_be_undone_and_done_again(at):
    assert asked(at, "set-cells", animal="m1", cells={"animal": "M1", "mine": " a  b "}) == "m1: animal M1, mine a b"
    assert cells(at, "M1")["mine"] == "a b"
    assert asked(at, "set-stretch", animal="M1", start=0.5) == "M1: start [s] 0.5, end [s] "
    assert asked(at, "set-stretch", animal="M1", start=0.123456789012, end=2.0).endswith(
        "start [s] 0.123456789, end [s] 2"
    )
    assert asked(at, "undo") == "undone: start [s], end [s] of M1"
    assert cells(at, "M1")["start [s]"] == "0.5"
    assert asked(at, "redo") == "done again: start [s], end [s] of M1"
    assert cells(at, "M1")["end [s]"] == "2"
    told = asked(at, "use-network", network="networks/o.csv")
    assert (told["animals"], told["said"]) == (["M2"], ["networks/o.csv is the network of: M2"])
    assert asked(at, "use-network", network="networks/n.csv")["said"] == [
        "networks/n.csv is the network of: no animal more"
    ]
    assert asked(at, "add-column", title=" sex  of it ") == "a column 'sex of it' of your own"
    assert asked(at, "remove-column", title="mine") == "column 'mine' removed"
    titles = read_rows(at.desk.table).titles
    assert "sex of it" in titles
    assert "mine" not in titles
    assert "group" in titles
    assert asked(at, "remove-animal", animal="M2") == "M2 removed from the table; its files stay"
    assert [row["animal"] for row in read_rows(at.desk.table).rows] == ["M1"]
    assert asked(at, "set-groups", groups=[" A ", "B"]) == "groups: A, B"
    assert asked(at, "set-setting", key="calibration.starts", value="7") == "calibration.starts: 7"
    assert "starts: 7" in at.desk.file.read_text()
    assert asked(at, "at-end", stop=True) == "a run stops when the workbench ends"
    assert at.runs.stops_with_us
    assert asked(at, "at-end", stop=False) == "a run goes on when the workbench ends"


def with_traces(at, pressure, flow):
    traces = {"pressure": Trace(np.asarray(pressure, float), 10.0), "flow": Trace(np.asarray(flow, float), 10.0)}
    at.recordings.opened = lambda row: SimpleNamespace(traces=traces)


def test_zero_and_gain_are_read_from_a_stretch(at):
    with_traces(at, [2.0] * 10 + [12.0] * 10, [0.5] * 20)
    assert asked(at, "set-zero", animal="m1", start=0.0, end=1.0) == "m1: zero [mmHg] 2"
    assert asked(at, "set-gain", animal="m1", signal="pressure", start=1.0, end=2.0, known=25.0).endswith(
        "gain [1] 2.5"
    )
    assert asked(at, "set-gain", animal="m1", signal="flow", start=1.0, end=2.0, known=0.25).endswith(
        "flow gain [1] 0.5"
    )
    with pytest.raises(InputError, match="the pressure that was read here, 0 above zero, is not above the zero"):
        asked(at, "set-gain", animal="m1", signal="pressure", start=0.0, end=1.0, known=25.0)
    assert asked(at, "set-gain", animal="m1", signal="flow", start=1.0, end=2.0) == "m1: flow gain [1] "
    assert asked(at, "set-gain", animal="m1", signal="pressure", known=2.0).endswith("pressure gain [1] ")
    assert asked(at, "set-zero", animal="m1", start=0.5) == "m1: zero [mmHg] "
    with_traces(at, [100.0] * 20, [1.0] * 20)
    asked(at, "set-zero", animal="m1", start=0.0, end=1.0)
    with_traces(at, [101.0] * 20, [1.0] * 20)  # a hundredth above the zero
    with pytest.raises(InputError, match="is not above the zero"):
        asked(at, "set-gain", animal="m1", signal="pressure", start=0.0, end=1.0, known=25.0)
    with_traces(at, [101.1] * 20, [1.0] * 20)
    assert asked(at, "set-gain", animal="m1", signal="pressure", start=0.0, end=1.0, known=11.0).endswith(" 10")


def test_the_mean_of_a_stretch_is_that_of_its_samples_without_those_that_are_missing():
    traces = {"flow": Trace(np.array([1.0, 2, 3, np.nan, 5, np.nan]), 10.0)}
    assert mean_between(traces, "flow", 0.1, 0.4) == 2.5
    assert mean_between(traces, "flow", -1.0, 0.2) == 1.5
    assert mean_between(traces, "flow", 0.4, 9.0) == 5.0
    for stretch in ((0.3, 0.4), (0.5, 0.6), (0.2, 0.2), (-2.0, -1.0)):
        with pytest.raises(InputError, match="there is no flow in this stretch"):
            mean_between(traces, "flow", *stretch)


def test_edits_of_beats_replace_those_within_a_millisecond(at):
    said = asked(at, "edit-beats", animal="m1", edits=[["reject", 1.0, None], ["move", 2.0, 2.1]])
    assert said == "2 edits in edits/m1.csv"
    assert cells(at, "m1")["beat edits"] == "edits/m1.csv"
    assert asked(at, "edit-beats", animal="m1", edits=[["keep", 1.0009, None]]) == "2 edits in edits/m1.csv"
    assert asked(at, "edit-beats", animal="m1", edits=[["keep", 1.0021, None]]) == "3 edits in edits/m1.csv"
    assert asked(at, "edit-beats", animal="m1", forget=[2.0005]) == "2 edits in edits/m1.csv"
    assert asked(at, "edit-beats", animal="m1", forget=[2.5]) == "2 edits in edits/m1.csv"
    kept = edits.read_edits(at.desk.folder / "edits/m1.csv")
    assert [(one.action, one.time, one.to) for one in kept] == [("keep", 1.0009, None), ("keep", 1.0021, None)]
    assert edits_file(at.desk, "m1").name == "m1 2.csv"
    (at.desk.folder / "edits/m1 2.csv").write_text("")
    assert edits_file(at.desk, "m1").name == "m1 3.csv"
    assert edits_file(at.desk, "M2").name == "M2.csv"
    assert BeatEdit("keep", 1.0).to is None


def test_lines_of_edits_of_a_tree_are_forgotten_by_number_and_text(at):
    path = at.desk.folder / "edits/lung.txt"
    path.parent.mkdir(exist_ok=True)
    path.write_text("a\nb\nc\n")
    assert asked(at, "forget-edit", image="lung", line=2, text="b") == "without 'b'"
    assert path.read_text() == "a\nc\n"
    assert asked(at, "forget-edit", image="lung", line=2, text="c") == "without 'c'"
    assert path.read_text() == "a\n"
    for line, text in ((1, "b"), (2, "a"), (3, "c")):
        with pytest.raises(InputError, match=r"lung.txt was changed elsewhere meanwhile"):
            asked(at, "forget-edit", image="lung", line=line, text=text)


@pytest.mark.parametrize(
    ("lines", "unit"),
    [
        ([], []), (["unit cm"], []), (["unit mm"], ["unit cm"]), (["unit mm", "unit cm # x"], []), (["unit mm x"], []),
        (["unit cm", "unit um # far"], ["unit cm"]), (["# unit mm"], []),
    ],
)  # fmt: skip
def test_places_are_in_cm_again_after_lines_in_another_unit(lines, unit):
    assert actions._unit_cm(lines) == unit


def test_an_edit_of_a_tree_is_a_line_and_a_root_replaces_the_root_before(at, monkeypatch):
    monkeypatch.setattr(actions, "_numbers", lambda at, image, point: " ".join(f"{one:g}" for one in point))
    again = []
    fake = SimpleNamespace(
        finds=lambda desk, image: "wishes", extracted=lambda desk, image, wishes: again.append(image)
    )
    at = at._replace(lungs=fake)

    def edited(action, *point, **more):
        said = asked(at, "edit-tree", image="lung", action=action, point=list(point), **more)
        return said, (at.desk.folder / "edits/lung.txt").read_text().splitlines()[1:], len(again)

    assert edited("root", 1, 2, 3) == ("root 1 2 3, in edits/lung.txt", ["root 1 2 3"], 0)
    assert edited("outlet", 4, 5, 6)[1:] == (["root 1 2 3", "outlet 4 5 6"], 0)
    assert edited("root", 7, 8, 9)[1:] == (["outlet 4 5 6", "root 7 8 9"], 0)
    assert edited("move", 1, 1, 1, to=[2, 2, 2])[1:] == (["outlet 4 5 6", "root 7 8 9", "move 1 1 1 2 2 2"], 1)
    assert edited("radius", 1, 1, 1, radius=0.0123456789)[1][-1] == "radius 1 1 1 0.0123457"


def raw(count, rate=1000.0, origin=0.0, beside=()):
    values = 10 + np.arange(count) / 1000
    return RawRecording(values, 0.1 * values, rate, origin=origin, beside=beside)


def test_a_stretch_of_a_recording_in_memory_is_cut_and_another_is_read_again(monkeypatch):
    whole = raw(9000)
    opened = Opened({}, 1000.0, 9.0, whole, {})
    read = []
    monkeypatch.setattr(recordings, "read_stretch", lambda row: read.append(row) or "read")

    def stretch(start, end, opened=opened, calibration=(1.0, 2.0, 1.0)):
        return opened._stretch(SimpleNamespace(start=start, end=end, calibration=calibration))

    assert stretch(None, None).pressure == pytest.approx((whole.pressure - 1) * 2)
    part = stretch(2.0, 8.0)
    assert len(part.pressure) == 6000
    assert part.pressure[0] == pytest.approx((12 - 1) * 2)
    assert read == []
    for start, end in ((2.0, None), (None, 8.0), (8.0, 8.1)):
        assert stretch(start, end) == "read"
    assert stretch(None, None, Opened({}, 1000.0, 9.0, None, {})) == "read"
    short, long = SHORTEST + 0.0015, SHORTEST + 0.0016
    pieces = tuple(SimpleNamespace(duration=one) for one in (short, long))
    between = SimpleNamespace(beside=pieces, calibrated=lambda *how: between)
    monkeypatch.setattr(recordings, "replace", lambda part, notes, beside: seen.append(beside) or part)
    seen = []
    fake = SimpleNamespace(between=lambda start, end: between, notes=())
    stretch(2.0, 8.0, Opened({}, 1000.0, 9.0, fake, {}))
    assert [one.duration for one in seen[0]] == [long]


def test_traces_are_calibrated_as_the_row_says(at, monkeypatch):
    with_traces(at, np.arange(40.0), np.arange(40.0))
    row = SimpleNamespace(calibration=(3.0, 2.0, 0.5, 1.0))
    monkeypatch.setattr(recordings, "row_of", lambda desk, animal: (row, None))
    assert at.recordings.trace(at.desk, "m1", "pressure", 0.0, 0.4, 2).tolist() == [[-6, -2], [-4, 0]]
    assert at.recordings.trace(at.desk, "m1", "flow", 0.0, 0.4, 2).tolist() == [[-0.5, 0.5], [0, 1]]
    with pytest.raises(InputError, match="'ecg' is no signal of this recording; it has: pressure, flow"):
        at.recordings.trace(at.desk, "m1", "ecg", 0.0, 0.4, 2)
    for start, end, width in ((0, 1, 4001), (0, 1, 0), (1, 1, 5), (0, np.inf, 5)):
        with pytest.raises(InputError, match="a screen has 1 to 4000 pixels"):
            at.recordings.trace(at.desk, "m1", "flow", start, end, width)
    assert at.recordings.trace(at.desk, "m1", "flow", 0.0, 1.0, 4000).shape == (2, 4000)


def test_rows_are_found_also_where_half_of_them_is_known(at):
    assert row_of(at.desk, "m1")[0].recordings[0].name == "a.csv"
    assert row_of(at.desk, "M2")[0].recordings[0].name == "b.csv"
    with pytest.raises(InputError, match=r"there is no animal 'm9' in animals.csv"):
        row_of(at.desk, "m9")


def test_names_of_files_stay_inside_and_are_such_as_every_system_has(at):
    def place(name):
        return opening.place_of(at.desk, name).relative_to(at.desk.folder).as_posix()

    deep = "/".join("abcdefg") + "/x.csv"
    assert place(deep) == f"recordings/{deep}"
    assert place("a" * 116 + ".csv") == "recordings/" + "a" * 116 + ".csv"
    assert place("day/lung.nrrd") == "images/lung.nrrd"
    assert (at.desk.folder / "recordings/a/b").is_dir()
    for wrong in (
        "",
        "h/" + deep,
        "a" * 117 + ".csv",
        "../x.csv",
        "/x.csv",
        ".x.csv",
        "a/ b.csv",
        "a?.csv",
        "a\tb.csv",
    ):
        with pytest.raises(InputError, match="is no name of a file inside this study; rename it and drop it again"):
            place(wrong)
    with pytest.raises(InputError, match=r"^x.doc: files that are read end in \.\w"):
        place("day/x.doc")


def test_dropped_files_are_sorted_by_what_they_hold_and_none_is_replaced(at, tmp_path, monkeypatch):
    known = {"net": True, "bad": InputError("x")}

    def kind(path):
        found = known.get(path.read_text())
        if isinstance(found, InputError):
            raise found
        return found

    monkeypatch.setattr(opening, "NETWORKS", SimpleNamespace(known=kind, suffixes=(".csv",)))

    def sort(text, name):
        part = at.desk.folder / f"part{Path(name).suffix}"
        part.write_text(text)
        try:
            return opening.sorted_in(at.desk, part, at.desk.folder / "recordings" / name)
        finally:
            part.unlink(missing_ok=True)

    assert sort("net", "new.csv") == "networks/new.csv"
    assert sort("bad", "c.csv") == "recordings/c.csv"
    assert sort("bad", "c.csv") == "recordings/c.csv"
    assert sort("signal", "d.csv") == "recordings/d.csv"
    with pytest.raises(InputError, match=r"d.csv: the study has another file of this name; rename one of the two"):
        sort("other", "d.csv")
    assert (at.desk.folder / "recordings/d.csv").read_text() == "signal"
    monkeypatch.setattr(os, "link", lambda *places: (_ for _ in ()).throw(OSError("no links here")))
    assert sort("signal", "e.csv") == "recordings/e.csv"
    assert (at.desk.folder / "recordings/e.csv").read_text() == "signal"


def test_places_are_opened_as_what_they_are(at, tmp_path):
    folder = at.desk.folder
    assert opening.opened(folder) == (folder, "", (), None)
    assert opening.opened(folder / "study.yaml") == (folder, "", (), None)
    assert opening.opened(folder / "recordings/a.csv") == (folder, "#recording/m1", (), None)
    fit = tmp_path / "fit"
    (fit / "results").mkdir(parents=True)
    assert opening.opened(fit).desk == "#explorer"
    empty = tmp_path / "empty"
    empty.mkdir()
    assert opening.opened(empty) == (empty, "", (), None)
    scan = tmp_path / "my scan"
    scan.mkdir()
    (scan / "1").write_bytes(b"\0" * 128 + b"DICM")
    found = opening.opened(scan)
    assert (found.folder.name, found.desk, found.image) == ("my scan study", "#lung/my%20scan", scan)
    assert found.notices[0].startswith("Its study, which holds what is found: ")
    assert not opening._slices(empty)
    inside = folder / "images"
    inside.mkdir()
    (inside / "lung.nii.gz").write_bytes(b"x")
    assert opening.opened(inside / "lung.nii.gz") == (folder, "#lung/lung", (), None)
    (folder / "far.nrrd").write_bytes(b"x")
    assert opening.opened(folder / "far.nrrd").image == folder / "far.nrrd"
    (tmp_path / "x.doc").write_text("")
    with pytest.raises(InputError, match=r"x.doc: the workbench opens studies, fits, recordings and images"):
        opening.opened(tmp_path / "x.doc")
    with pytest.raises(InputError, match=r"none.csv: there is no such file"):
        opening.opened(tmp_path / "none.csv")
    with pytest.raises(InputError, match=r"none.nrrd: there is no such file"):
        opening.opened(tmp_path / "none.nrrd")


def test_what_stands_in_a_study_already_is_not_put_into_it_again(at, tmp_path, monkeypatch):
    put = []
    monkeypatch.setattr(opening, "_put_into", lambda folder, place: put.append(place.name))
    monkeypatch.setattr(opening, "_is_study", lambda folder: True)
    monkeypatch.setattr(opening, "_animal", lambda folder, place: "m" if place.name == "known.csv" else "")
    for name in ("known.csv", "new.csv"):
        (tmp_path / name).write_text("x")
        opening.opened(tmp_path / name)
    assert put == ["new.csv"]
    monkeypatch.setattr(opening, "_is_study", lambda folder: False)
    opening.opened(tmp_path / "known.csv")
    assert put == ["new.csv", "known.csv"]


def test_images_are_known_by_their_endings_and_called_by_what_stands_before():
    assert [lungs.is_image(Path(name)) for name in ("a.nrrd", "A.NII.GZ", "a.nii", "a.csv", "a.gz")] == [True] * 3 + [
        False
    ] * 2
    assert [lungs.name_of(Path(name)) for name in ("a.b.nrrd", "a.nii.gz")] == ["a.b", "a"]


def test_an_image_is_made_smaller_by_means_of_whole_blocks():
    grey = np.arange(145 * 2 * 3, dtype=float).reshape(145, 2, 3)
    small, step = lungs.smaller(grey)
    assert (step, small.shape) == (2, (73, 1, 2))
    assert small[0, 0, 0] == pytest.approx(grey[:2, :2, :2].mean())
    assert small[-1, 0, 1] == pytest.approx(grey[-1, :, 2].mean())
    same, one = lungs.smaller(grey[:144])
    assert (one, same.shape, same.dtype) == (1, (144, 2, 3), np.float32)


def test_settings_of_an_extraction_come_back_and_damaged_ones_do_not(tmp_path):
    path = tmp_path / "settings.json"
    rows = {"threshold": "30", "cannula": "0.1", "pressure": "5", "species": "rat", "voxel": "0.01", "loops": "open"}
    path.write_text(json.dumps({"settings": rows}))
    assert lungs.stored_wishes(path) == lungs.Wishes(30.0, 0.1, 5.0, "rat", True, 0.01)
    path.write_text(json.dumps({"settings": rows | {"loops": "refuse", "voxel": "x"}}))
    assert lungs.stored_wishes(path) == lungs.Wishes()
    for text in ("", "[]", "{}", '{"settings": 3}'):
        path.write_text(text)
        assert lungs.stored_wishes(path) == lungs.Wishes()
    edits_of = tmp_path / "e.txt"
    made = lungs.options_of(lungs.Wishes(open_loops=True, cannula=0.2), edits_of)
    assert (made.loops, made.edits, made.cannula) == ("open", None, 0.2)
    edits_of.write_text("")
    made = lungs.options_of(lungs.Wishes(), edits_of)
    assert (made.loops, made.edits) == ("refuse", edits_of)


def test_eight_extractions_are_kept_and_the_last_asked_for_stays(at, tmp_path, monkeypatch):
    path = tmp_path / "lung.nrrd"
    path.write_bytes(b"x")
    made = []
    one = lungs.Lungs(path)

    def extract(path, options, say, kept):
        made.append(options.threshold)
        return SimpleNamespace(image=SimpleNamespace(frame=None))

    monkeypatch.setattr(lungs, "extract", extract)
    monkeypatch.setattr(lungs, "Stages", lambda folder, hold: None)
    for threshold in (*range(1, 9), 1, 9, 1, 2):
        one.extracted(at.desk, "lung", lungs.Wishes(threshold=float(threshold)))
    assert made == [*range(1, 10), 2]
    assert one.finds(at.desk, "lung").threshold == 2
    assert one.images(at.desk) == {"lung": path}
    with pytest.raises(InputError, match="there is no image 'x'; there are: lung"):
        one.image(at.desk, "x")
    with pytest.raises(InputError, match="there is no image 'x'; there are: none"):
        lungs.Lungs().image(at.desk, "x")
    assert lungs.Lungs().described(at.desk, "x") == {"images": [], "image": ""}
    with pytest.raises(InputError, match="another image was looked at meanwhile"):
        lungs.Lungs(path).own(at.desk, "lung", (1, 2, 3))
    assert lungs.Lungs(path).finds(at.desk, "lung") is None


def test_two_hundred_steps_are_remembered_and_a_step_without_a_change_is_none(at):
    file = at.desk.folder / "x.txt"
    for step in range(205):
        with at.desk.changing(f"step {step}", file) as change:
            change.write(file, str(step))
    with at.desk.changing("nothing", file):
        pass
    assert (len(at.desk.done), at.desk.done[0].name, at.desk.done[-1].name) == (200, "step 5", "step 204")
    at.desk.undo()
    assert (file.read_text(), len(at.desk.undone)) == ("203", 1)
    with at.desk.changing("other", file) as change:
        change.write(file, "y")
    assert at.desk.undone == []

    def broken():
        with at.desk.changing("broken", file) as change:
            change.write(file, "z")
            raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        broken()
    assert (file.read_text(), at.desk.done[-1].name) == ("y", "other")
    file.write_text("elsewhere")
    with pytest.raises(InputError, match=r"x.txt was changed elsewhere meanwhile; nothing was written"):
        at.desk.undo()


def test_what_was_seen_is_compared_with_what_is_there():
    unchanged("m1", {"a": "1", "b": ""}, {"a": "1"})
    with pytest.raises(InputError, match="m1: a, c was changed elsewhere meanwhile to '1'; look at it"):
        unchanged("m1", {"a": "2", "b": "3", "c": "x"}, {"a": "1", "b": "3"})


def test_names_inside_a_study_lead_nowhere_else(at):
    assert at.desk.inside("a/b.csv") == at.desk.folder / "a/b.csv"
    for wrong in ("..", "", ".", "../x", "/etc/x", "a\0b", "n" * 300 + "/../../.."):
        with pytest.raises(InputError, match="is no file inside this study"):
            at.desk.inside(wrong)
    (at.desk.folder / "loop").symlink_to("loop")
    with pytest.raises(InputError, match="'loop/x' is no file inside this study"):
        at.desk.inside("loop/x")


def test_the_mark_of_a_study_changes_with_each_of_its_files(at):
    marks = [at.desk.mark()]
    assert at.desk.mark() == marks[0]
    for name in ("results/index.json", "edits/a.csv", "animals.csv", "study.yaml", "results/other.json"):
        path = at.desk.folder / name
        path.parent.mkdir(exist_ok=True)
        path.write_text((path.read_text() if path.exists() else "") + "\n")
        marks.append(at.desk.mark())
    assert len(set(marks)) == 6
    assert len(marks[0]) == 16


def scope(method="GET", path="/key/x", **headers):
    given = {"host": "localhost:80"} | {name.replace("_", "-"): text for name, text in headers.items()}
    return {"method": method, "path": path, "headers": [(name.encode(), text.encode()) for name, text in given.items()]}


@pytest.mark.parametrize(
    ("asks", "status"),
    [
        (scope(), None), (scope(path="/key"), 404), (scope(path="/kez/x"), 404), (scope(path="//x"), 404),
        (scope(host="localhost"), 421), (scope(host="127.0.0.1:80"), None), (scope(method="POST"), 403),
        (scope(method="POST", origin="http://localhost:80"), None), (scope(origin="http://127.0.0.1:80"), 403),
        (scope(method="HEAD"), None), (scope(sec_fetch_site="same-origin"), None),
        (scope(sec_fetch_site="cross-site"), 403),
        (scope(content_length=str(LARGEST_ACTION)), None), (scope(content_length=str(LARGEST_ACTION + 1)), 413),
        (scope("PUT", origin="http://localhost:80", content_length=str(LARGEST_FILE)), None),
        (scope("PUT", origin="http://localhost:80", content_length=str(LARGEST_FILE + 1)), 413),
        (scope(content_length="x"), None),
    ],
)  # fmt: skip
def test_the_door_opens_to_its_own_page_alone(asks, status):
    headers = {}
    for name, value in asks["headers"]:
        headers.setdefault(name, []).append(value)
    guarded = Guarded(None, "key", 80)
    refused = guarded._from_elsewhere(headers) or guarded._refused(asks, headers)
    assert (refused and refused[0]) == status
    if status == 413:
        assert refused[1] == f"This is too large: at most {4096 if asks['method'] == 'PUT' else 4} MiB."


def test_numbers_of_the_page_are_finite_or_nothing():
    assert number(1.23456789) == 1.23457
    assert number(1.23456789, 3) == 1.23
    assert number(float("inf")) is None
    assert numbers([1.0, float("nan")]) == [1.0, None]


def test_remedies_are_what_the_finding_can_be_mended_by():
    def remedies(code, animals=("m1", "m2"), column="", room="x"):
        finding = SimpleNamespace(code=code, room=room)
        return studies._remedies(SimpleNamespace(finding=finding, animals=animals), column)

    twice = remedies(studies.TWICE[0])
    assert [one["label"] for one in twice] == ["Both are meant to share it", "Remove m1"]
    assert [one["animal"] for one in twice[0]["acts"]] == ["m1", "m2"]
    assert twice[1]["acts"] == [{"do": "remove-animal", "animal": "m1"}]
    (few,) = remedies("check.few-starts")
    assert few["label"] == "20 starts"
    assert few["acts"] == [{"do": "set-setting", "key": "calibration.starts", "value": "20"}]
    (empty,) = remedies("animals.ignored", column="block")
    assert [one["cells"] for one in empty["acts"]] == [{"block": ""}] * 2
    assert remedies("animals.ignored") == []
    assert remedies("recording.late", room="recording") == [{"label": "Look at the recording", "open": "m1"}]
    assert remedies("recording.late", (), room="recording") == []


def test_a_desk_without_a_study_shows_what_may_be_chosen(tmp_path):
    told = studies.shown(Desk(tmp_path))
    assert told == {
        "study": False, "folder": str(tmp_path), "species": ["mouse", "rat", "rabbit", "dog", "pig", "human", "other"]
    }  # fmt: skip
    assert studies.outdated(Desk(tmp_path)) == []


def test_draws_of_a_posterior_are_a_hundred_at_most_evenly_chosen():
    drawn = xr.Dataset({"R": (("chain", "draw"), np.arange(402.0).reshape(2, 201)), "other": ("draw", np.ones(201))})
    told = xr.Dataset({"simulated": (("chain", "draw", "time"), np.arange(804.0).reshape(2, 201, 2))})
    found = explorer.posterior_draws(SimpleNamespace(groups={"posterior": drawn, "posterior_predictive": told}))
    assert found["count"] == 100
    assert set(found["values"]) == {"R"}
    assert (found["values"]["R"][0], found["values"]["R"][1], found["values"]["R"][-1]) == (0, 4, 401)
    assert found["curves"][1] == {"pressure": [8, 9]}
    flow = explorer.posterior_draws(
        SimpleNamespace(groups={"posterior": drawn, "posterior_predictive": told.assign(flow=1)})
    )
    assert set(flow["curves"][0]) == {"flow"}
    bare = explorer.posterior_draws(SimpleNamespace(groups={"posterior": drawn.isel(draw=slice(3))}))
    assert (bare["count"], bare["curves"][0], bare["values"]["R"]) == (6, {}, [0, 1, 2, 201, 202, 203])


def test_eight_fits_are_kept_in_memory(at, tmp_path, monkeypatch):
    made = []
    path = tmp_path / "x.nc"
    path.write_bytes(b"")
    monkeypatch.setattr(explorer, "_file", lambda desk, animal: path)
    monkeypatch.setattr(explorer, "stored_model", lambda result, law: made.append(law))
    monkeypatch.setattr(explorer, "stored_recording", lambda result: None)
    one = explorer.Explorer()
    desk = SimpleNamespace(stored=lambda: {"m": "result"})
    for law in "abcdefghaia":
        one.fitted(desk, "m", law)
    assert "".join(made) == "abcdefghi"
    one.fitted(desk, "m", "b")
    assert "".join(made) == "abcdefghib"
    assert isinstance(one._fitted, OrderedDict)


def test_the_misfit_of_a_curve_is_the_root_mean_square_of_what_is_left():
    t = np.arange(64) / 64
    recording = SimpleNamespace(pressure=10 + np.sin(2 * np.pi * t), flow=np.ones(64))
    assert explorer._misfit(10 + np.sin(2 * np.pi * np.arange(128) / 128), recording) == pytest.approx(0.0, abs=1e-9)
    assert explorer._misfit(np.full(32, 10.0), recording) == pytest.approx(np.sqrt(0.5))
    few = SimpleNamespace(
        pressure=np.cos(2 * np.pi * np.arange(7) / 7) + 6, flow=2 * np.cos(2 * np.pi * np.arange(7) / 7) + 3
    )
    assert explorer._modulus(few)[:2] == pytest.approx([2.0, 0.5])
    assert len(explorer._modulus(few)) == 4
    assert len(explorer._modulus(SimpleNamespace(pressure=t, flow=t))) == 11


def test_actions_take_what_their_functions_take():
    assert set(ACTIONS) >= {"new-study", "add-files", "set-cells", "undo", "write-lung", "at-end"}
    assert study_actions.Name is actions.Name


@pytest.mark.parametrize(("count", "every"), [(5, 1), (32, 1), (63, 1), (64, 2), (65, 2), (96, 3)])
def test_the_middle_of_every_vessel_is_shown_at_some_instants(monkeypatch, count, every):
    pressure = np.arange(count * 3 * 2, dtype=float).reshape(count, 3, 2)
    flow = np.arange(count * 2 * 3, dtype=float).reshape(count, 2, 3) / 7
    run = SimpleNamespace(pressure=pressure, stations=(None, flow), notes=["odd"])
    wall = SimpleNamespace()
    model = SimpleNamespace(wall=wall, blood=SimpleNamespace(inertia=1.06))
    recording = SimpleNamespace(period=0.11, inflow="in")
    asked = []
    monkeypatch.setattr(Explorer, "fitted", lambda self, desk, animal, law: (None, "old", recording))
    monkeypatch.setattr(explorer, "_require_near", lambda old, values: None)
    monkeypatch.setattr(explorer, "changed_model", lambda old, values: asked.append((old, values)) or model)
    monkeypatch.setattr(explorer, "simulate_run", lambda one, inflow, numerics: asked.append((one, inflow)) or run)
    monkeypatch.setattr(explorer, "waves_of", lambda *_: ({"flow": [1.0]}, {"mPAP": 20.0, "none": np.nan}))
    monkeypatch.setattr(explorer.walls, "wave_speed", lambda wall, mean, inertia: mean * inertia)
    shown = Explorer().simulated(None, "a", "linear", {"R1": 2.0})
    assert asked == [("old", {"R1": 2.0}), (model, "in")]
    middle, through = pressure[:, 1], flow[:, :, 1]
    assert shown["vessels"]["mean pressure [mmHg]"] == pytest.approx(middle.mean(axis=0).tolist(), rel=1e-5)
    assert shown["vessels"]["pulse pressure [mmHg]"] == pytest.approx(np.ptp(middle, axis=0).tolist())
    assert shown["vessels"]["mean flow [ml/s]"] == pytest.approx(through.mean(axis=0).tolist(), rel=1e-5)
    assert shown["vessels"]["wave speed [cm/s]"] == pytest.approx((middle.mean(axis=0) * 1.06).tolist(), rel=1e-5)
    assert shown["frames"]["pressure [mmHg]"] == np.round(middle[::every], 3).tolist()
    assert shown["frames"]["flow [ml/s]"] == np.round(through[::every], 5).tolist()
    assert (shown["period"], shown["notes"], shown["flow"]) == (0.11, ["odd"], [1.0])
    assert shown["indices"] == {"mPAP": 20.0, "none": None}


@pytest.mark.parametrize("failed", [0, 1, 2, 3])
def test_a_band_is_drawn_where_most_models_of_the_errors_can_be_simulated(monkeypatch, failed):
    models = list(range(4))
    runs = [Run.__new__(Run) if place >= failed else ValueError() for place in models]
    names = list(explorer.BANDS)
    law = SimpleNamespace(calibration="errors", posterior=None)
    result = SimpleNamespace(laws={"linear": law})
    monkeypatch.setattr(Explorer, "fitted", lambda self, desk, animal, law: (result, "m", SimpleNamespace(inflow="in")))
    monkeypatch.setattr(explorer, "stored_law", lambda result, law: ("linear", law))
    monkeypatch.setattr(explorer, "models_around", lambda model, calibration: models)
    monkeypatch.setattr(explorer, "simulate_runs", lambda models, inflow, numerics: runs)
    monkeypatch.setattr(
        explorer, "waves_of", lambda run, drawn, recording: ({name: [drawn, 10.0 * drawn] for name in names}, {})
    )
    monkeypatch.setattr(explorer, "drawn_about_fit", lambda good: [drawn for drawn, _ in good])
    monkeypatch.setattr(explorer, "posterior_draws", lambda posterior: [posterior])
    found = Explorer().band(None, "a", "linear")
    kept = models[failed:] if failed < 2 else []
    assert found["draws"] == kept
    assert list(found["band"]) == (names if kept else [])
    for low, high in found["band"].values():
        ends = np.percentile(np.array(kept, float), (2.5, 97.5))
        assert (low, high) == (pytest.approx([ends[0], 10 * ends[0]]), pytest.approx([ends[1], 10 * ends[1]]))
    law.posterior = "own"
    assert Explorer().band(None, "a", "linear")["draws"] == ["own"]
