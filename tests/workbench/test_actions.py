"""What the page does is in the files, can be undone, and never writes over what another hand wrote."""

import json
import os
import shutil
import threading
from contextlib import contextmanager
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.stateful import (
    RuleBasedStateMachine,
    initialize,
    invariant,
    precondition,
    rule,
    run_state_machine_as_test,
)

import vasowave as vw
from lab_files import SMALL
from vasowave.base import InputError, VasowaveWarning, sentence
from vasowave.base.io import write_files
from vasowave.pulse.network import write_network
from vasowave.study.entering import check_study, read_rows
from vasowave.study.folder import COLUMNS, read_settings
from vasowave.study.results import load_animal, read_stretch
from vasowave.study.running import inspect_study, read_study
from vasowave.workbench import Desk, Recordings, Trace, Workplace, act, checked, shown


def place(folder):
    return Workplace.around(Desk(folder))


def rows(folder):
    return {row["animal"]: row for row in read_rows(folder / "animals.csv").rows}


def texts(folder):
    return {path.relative_to(folder): path.read_bytes() for path in folder.rglob("*")
            if path.is_file() and path.suffix in (".csv", ".yaml") and "recordings" not in path.parts}  # fmt: skip


def do(at, what, **given):
    return act(at, {"do": what, **given})


def test_the_desk_says_what_check_says(study):
    (study / "animals.csv").write_text(
        (study / "animals.csv").read_text(encoding="utf-8").replace(",hypoxic,", ",hypoxc,", 1), encoding="utf-8"
    )
    found, said = check_study(study), checked(Desk(study))
    assert [one["text"] for one in said["problems"]] == [sentence(one.finding) for one in found.problems]
    assert {one["code"] for one in said["notes"]} == {one.finding.code for one in found.notes}
    assert {name: tuple(row) for name, row in said["read"].items()} == {one.animal: one.row() for one in found.read}
    at = next(one for one in said["problems"] if one["error"])
    assert (at["column"], at["animals"]) == ("group", ["mouse_h1"])


def test_the_page_shows_a_program_of_the_study_and_lets_it_run_as_it_was_shown(study, tmp_path):
    settings = (study / "study.yaml").read_text("utf-8").replace("walls: [linear]", "walls: [evil:Wall]")
    (study / "study.yaml").write_text(settings, "utf-8")
    text = f"import pathlib; pathlib.Path({str(tmp_path / 'ran')!r}).touch()"
    (study / "evil.py").write_text(text, "utf-8")
    at = place(study)
    (program,) = shown(at.desk)["programs"]
    assert (program["text"], program["path"]) == (text, str(study / "evil.py"))
    (study / "evil.py").write_text(f"{text}  # more", "utf-8")
    with pytest.raises(InputError, match="changed meanwhile"):
        do(at, "trust-programs", programs={program["name"]: program["sha256"]})
    (study / "evil.py").write_text(text, "utf-8")
    checked(at.desk)
    assert not (tmp_path / "ran").exists()
    do(at, "trust-programs", programs={program["name"]: program["sha256"]})
    assert shown(at.desk)["programs"] == []
    assert (tmp_path / "ran").exists()  # a study that is shown is checked, and a law that may run is tried


def test_a_recording_that_was_exported_anew_is_mended_by_the_same_click(study):
    at, known = place(study), rows(study)
    first = study / known["mouse_c1"]["recording"]
    text = first.read_text(encoding="utf-8")
    header = next(i for i, line in enumerate(text.splitlines()) if line.startswith("UnitName")) + 1
    lines = text.splitlines(keepends=True)
    (study / "recordings" / "again.txt").write_text(
        "".join([*lines[:header], *lines[header + 2000 :]]), encoding="utf-8"
    )
    do(at, "set-cells", animal="mouse_c2", cells={"recording": "recordings/again.txt"})
    (problem,) = (one for one in checked(at.desk)["problems"] if one["error"])
    assert problem["code"] == "check.same-signal"
    both_are_meant = problem["remedies"][0]
    assert both_are_meant["label"] == "Both are meant to share it"
    for one in both_are_meant["acts"]:
        act(at, one)
    assert [one for one in checked(at.desk)["problems"] if one["error"]] == []


@pytest.mark.parametrize(
    ("message", "words"),
    [
        ([], "a message names what to do"),
        ({"do": "set-cell"}, r"there is no action 'set-cell' \(did you mean 'set-cells'\?\)"),
        ({"do": "set-cells", "cells": {}}, "animal: there is no value; give one"),
        ({"do": "at-end"}, "stop: there is no value; give one"),
        ({"do": "set-zero", "animal": "mouse_c1", "at": 1}, "there is no setting 'at'"),
        ({"do": "set-cells", "animal": "m9", "cells": {"group": "A"}}, "there is no animal 'm9' in animals.csv"),
        ({"do": "set-cells", "animal": "mouse_c1", "cells": {"grup": "A"}}, r"did you mean 'group'\?"),
        ({"do": "set-cells", "animal": "mouse_c1", "cells": {"end [s]": "-1"}}, "-1 is not a positive number"),
        ({"do": "set-cells", "animal": "mouse_c1", "cells": {"animal": " MOUSE_c2\t"}}, "a name that no other has"),
        ({"do": "use-network", "network": "networks/none.csv"}, "there is no file networks/none.csv in this study"),
        ({"do": "add-column", "title": "weight (g)"}, r"would be read as 'weight \[g\]'; write it"),
        ({"do": "remove-column", "title": "group"}, "no column 'group' of your own in animals.csv"),
        ({"do": "remove-animal", "animal": "m3"}, "there is no animal 'm3' in animals.csv"),
        ({"do": "set-setting", "key": "title", "value": "a\nb"}, "is not a key with a value"),
        ({"do": "edit-beats", "animal": "mouse_c1", "edits": [["keep", 1.0, 2.0]]}, "a beat is moved to a time, and"),
        ({"do": "undo"}, "there is nothing to undo"),
        ({"do": "edit-tree", "image": "i", "action": "move", "point": [1, 2, 3]}, "a move has a place to go to"),
        ({"do": "edit-tree", "image": "i", "action": "radius", "point": [1, 2, 3]}, "a radius its size"),
    ],
)
def test_what_cannot_be_done_is_told_and_changes_no_file(tiny, message, words):
    before = texts(tiny)
    with pytest.raises(InputError, match=words):
        act(place(tiny), message)
    assert texts(tiny) == before


def test_edits_of_beats_replace_those_within_a_millisecond(tiny):
    at = place(tiny)
    do(at, "edit-beats", animal="mouse_c1", edits=[["reject", 1.0, None], ["move", 2.0, 2.1]])
    do(at, "edit-beats", animal="mouse_c1", edits=[["keep", 1.0009, None]])
    do(at, "edit-beats", animal="mouse_c1", edits=[["keep", 1.0021, None]], forget=[2.0005])
    kept = vw.read_edits(tiny / rows(tiny)["mouse_c1"]["beat edits"])
    assert [(one.action, one.time, one.to) for one in kept] == [("keep", 1.0009, None), ("keep", 1.0021, None)]


def test_the_mark_of_a_study_changes_with_each_of_its_files(tiny):
    desk = Desk(tiny)
    marks = [desk.mark()]
    assert desk.mark() == marks[0]
    for name in ("results/index.json", "edits/a.csv", "animals.csv", "study.yaml", "results/other.json"):
        path = tiny / name
        path.parent.mkdir(exist_ok=True)
        path.write_text((path.read_text(encoding="utf-8") if path.exists() else "") + "\n", encoding="utf-8")
        marks.append(desk.mark())
    assert len(set(marks)) == 6


def test_what_is_set_reads_the_same_for_every_other_command(study):
    at = place(study)
    do(at, "set-cells", animal="mouse_c1", cells={"wedge [mmHg]": "4", "animal": "Maus Ä"})
    do(at, "set-stretch", animal="Maus Ä", start=1.25, end=7.5)
    do(at, "set-cells", animal="mouse_c2", cells={"network": ""})
    assert at.recordings.described(at.desk, "mouse_c2")["error"] == ""  # its signals are there to look at
    do(at, "undo")
    do(at, "set-setting", key="averaging.drift", value="warn")
    do(at, "set-setting", key="calibration.starts", value="3")
    known = read_study(study)
    (row,) = (one for one in known.animals if one.animal == "Maus Ä")
    assert (row.wedge, row.start, row.end) == (4.0, 1.25, 7.5)
    assert (known.settings.averaging.drift, known.settings.calibration.starts) == ("warn", 3)


def test_comments_and_everything_else_in_study_yaml_stay(study):
    at, path = place(study), study / "study.yaml"
    path.write_text(
        path.read_text(encoding="utf-8").replace("  starts: 1\n", "  starts: 1 # of a colleague\n"), encoding="utf-8"
    )
    before = path.read_text(encoding="utf-8").splitlines()
    do(at, "set-setting", key="calibration.starts", value="7")
    after = path.read_text(encoding="utf-8").splitlines()
    changed = [pair for pair in zip(before, after, strict=True) if pair[0] != pair[1]]
    assert changed == [("  starts: 1 # of a colleague", "  starts: 7 # of a colleague")]


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("groups: [A]\n", "  starts: 5"),
        ("groups: [A]\ncalibration:\n  walls: [linear]\n", "  starts: 5"),
        ("calibration: {walls: [linear]}\ngroups: [A]\n", None),
    ],
)
def test_a_key_that_is_not_there_is_written_where_it_belongs_or_refused(tmp_path, text, said):
    (tmp_path / "study.yaml").write_text(text, encoding="utf-8")
    at = place(tmp_path)
    if said is None:
        with pytest.raises(InputError, match="several lines"):
            do(at, "set-setting", key="calibration.starts", value="5")
        assert (tmp_path / "study.yaml").read_text(encoding="utf-8") == text
    else:
        do(at, "set-setting", key="calibration.starts", value="5")
        assert said in (tmp_path / "study.yaml").read_text(encoding="utf-8").splitlines()
        assert read_settings(tmp_path / "study.yaml")[0].calibration.starts == 5


def test_a_beat_that_is_rejected_is_so_for_a_run_too(study):
    at = place(study)
    before = at.recordings.described(at.desk, "mouse_c1")
    k = before["beats"]["averaged"][3]
    middle = 0.5 * (before["beats"]["starts"][k] + before["beats"]["starts"][k + 1])
    do(at, "edit-beats", animal="mouse_c1", edits=[["reject", middle, None]])
    after = at.recordings.described(at.desk, "mouse_c1")
    assert after["beats"]["rejected"][k] == "rejected by hand"
    known = read_study(study)
    animal = load_animal(known.animals[0], known.settings, study)
    assert after["pressure"] == pytest.approx(animal.recording.pressure, rel=1e-5)
    assert after["indices"]["mPAP"] == pytest.approx(animal.recording.mean_pressure, rel=1e-5)
    assert after["pressure"] != before["pressure"]
    do(at, "edit-beats", animal="mouse_c1", forget=[middle])
    assert at.recordings.described(at.desk, "mouse_c1")["pressure"] == before["pressure"]


def test_the_zero_is_the_mean_of_the_stretch_and_counts_from_the_transducer_again(study):
    at = place(study)
    raw = vw.read_raw_recording(study / rows(study)["mouse_c1"]["recording"])
    mean = raw.pressure[(raw.time >= 2.0) & (raw.time < 3.0)].mean()
    for _ in range(2):  # a second time changes nothing, although the signals are shown above the zero by then
        do(at, "set-zero", animal="mouse_c1", start=2.0, end=3.0)
        assert float(rows(study)["mouse_c1"]["zero [mmHg]"]) == pytest.approx(mean, rel=1e-3)
    do(at, "set-zero", animal="mouse_c1")
    assert rows(study)["mouse_c1"]["zero [mmHg]"] == ""


def test_a_second_point_of_calibration_sets_the_gain_and_a_run_reads_the_same(study):
    """From what was read in two stretches, by hand; zero and gain stand in the table and hold for every command."""
    at = place(study)
    raw = vw.read_raw_recording(study / rows(study)["mouse_c1"]["recording"])
    read = [raw.pressure[(raw.time >= start) & (raw.time < start + 1)].mean() for start in (2.0, 5.0)]
    before = at.recordings.described(at.desk, "mouse_c1")
    do(at, "set-zero", animal="mouse_c1", start=5.0, end=6.0)
    with pytest.raises(InputError, match="not above the zero"):
        do(at, "set-gain", animal="mouse_c1", signal="pressure", start=5.0, end=6.0, known=20.0)
    do(at, "set-cells", animal="mouse_c1", cells={"zero [mmHg]": "-6.0"})
    do(at, "set-gain", animal="mouse_c1", signal="pressure", start=5.0, end=6.0, known=30.0)
    do(at, "set-gain", animal="mouse_c1", signal="flow", start=2.0, end=3.0, known=0.5)
    gain = 30.0 / (read[1] + 6.0)
    assert float(rows(study)["mouse_c1"]["pressure gain [1]"]) == pytest.approx(gain, rel=1e-5)
    known = read_study(study)
    animal = load_animal(known.animals[0], known.settings, study)
    after = at.recordings.described(at.desk, "mouse_c1")
    assert after["indices"]["mPAP"] == pytest.approx(animal.recording.mean_pressure, rel=1e-5)
    assert after["indices"]["mPAP"] == pytest.approx((before["indices"]["mPAP"] + 6.0) * gain, rel=0.01)
    flow_gain = 0.5 / raw.flow[(raw.time >= 2.0) & (raw.time < 3.0)].mean()
    assert after["indices"]["CO"] == pytest.approx(before["indices"]["CO"] * flow_gain, rel=0.01)
    low, high = at.recordings.trace(at.desk, "mouse_c1", "pressure", 5.0, 6.0, 1000)
    assert (0.5 * (low + high)).mean() == pytest.approx(30.0, rel=1e-3)  # the desk shows what it averages
    for signal in ("pressure", "flow"):
        do(at, "set-gain", animal="mouse_c1", signal=signal)
    do(at, "set-zero", animal="mouse_c1")
    assert at.recordings.described(at.desk, "mouse_c1")["pressure"] == before["pressure"]


def test_a_network_is_chosen_for_all_animals_that_have_none_in_one_step(study):
    at, before = place(study), rows(study)
    write_network(SMALL, study / "networks" / "other.csv")
    for animal in ("mouse_c2", "mouse_h3"):
        do(at, "set-cells", animal=animal, cells={"network": ""})
    lacking = texts(study)
    assert do(at, "use-network", network="networks/other.csv")["animals"] == ["mouse_c2", "mouse_h3"]
    networks = {name: row["network"] for name, row in rows(study).items()}
    assert networks == {name: row["network"] for name, row in before.items()} | dict.fromkeys(
        ("mouse_c2", "mouse_h3"), "networks/other.csv"
    )
    do(at, "undo")
    assert texts(study) == lacking
    with pytest.raises(InputError, match="no file"):
        do(at, "use-network", network="networks/none.csv")


def test_what_was_written_by_another_hand_meanwhile_is_not_written_over(study):
    at = place(study)
    seen = rows(study)["mouse_c1"]["group"]
    path = study / "animals.csv"
    path.write_text(path.read_text(encoding="utf-8").replace("mouse_c1,control", "mouse_c1,hypoxic"), encoding="utf-8")
    with pytest.raises(InputError, match="changed elsewhere"):
        do(at, "set-cells", animal="mouse_c1", cells={"group": "control"}, was={"group": seen})
    do(at, "set-cells", animal="mouse_c1", cells={"wedge [mmHg]": "3"}, was={"wedge [mmHg]": ""})
    assert (rows(study)["mouse_c1"]["group"], rows(study)["mouse_c1"]["wedge [mmHg]"]) == ("hypoxic", "3")


def test_undo_puts_back_the_bytes_and_refuses_where_another_hand_wrote(study):
    at, path = place(study), study / "animals.csv"
    before = texts(study)
    do(at, "edit-beats", animal="mouse_c1", edits=[["reject", 3.0, None]])
    do(at, "remove-animal", animal="mouse_c2")
    do(at, "undo")
    do(at, "undo")
    assert texts(study) == before
    do(at, "redo")
    path.write_bytes(path.read_bytes() + b"# a remark\n")
    now = texts(study)
    with pytest.raises(InputError, match="changed elsewhere"):
        do(at, "undo")
    assert texts(study) == now


def test_a_disk_that_is_full_by_the_second_file_changes_neither(study, monkeypatch):
    written = []

    def full_by_the_second(contents, seen):
        written.append(contents)
        if len(written) == 2:
            raise InputError("no space left")
        write_files(contents, seen)

    at, before = place(study), texts(study)
    monkeypatch.setattr("vasowave.workbench.desk.write_files", full_by_the_second)
    with pytest.raises(InputError, match="no space"):
        do(at, "edit-beats", animal="mouse_c1", edits=[["reject", 3.0, None]])
    assert texts(study) == before


def test_two_workbenches_of_one_study_lose_nothing_of_each_other(study):
    """Two users write into other cells of the same table, ten times each at once."""
    places = [place(study), place(study)]

    def write(at, title):
        for k in range(10):
            do(at, "set-cells", animal="mouse_c1", cells={title: str(k)})

    threads = [
        threading.Thread(target=write, args=one) for one in zip(places, ["wedge [mmHg]", "zero [mmHg]"], strict=True)
    ]
    for one in threads:
        one.start()
    for one in threads:
        one.join()
    row = rows(study)["mouse_c1"]
    assert (row["wedge [mmHg]"], row["zero [mmHg]"]) == ("9", "9")


@pytest.mark.parametrize("text", ["groups: [A\n", "a: &x 1\n", "\xff", "groups: 5\nanimals: ../../etc/passwd\n"])
def test_a_study_that_another_hand_broke_is_shown_with_what_is_wrong(study, text):
    (study / "study.yaml").write_text(text, encoding="latin-1")
    told = shown(Desk(study))
    assert any(one["error"] for one in told["problems"])
    json.dumps(told, allow_nan=False)


# One signal at the width of a screen


@settings(max_examples=60, deadline=None)
@given(st.data())
def test_every_pixel_shows_the_lowest_and_highest_sample_in_it(data):
    """Against all samples, one by one; what is beside a pixel may be taken in up to the size of the pairs."""
    count = data.draw(st.integers(300, 40_000))
    values = np.random.default_rng(count).normal(size=count).astype(np.float32)
    gap = data.draw(st.integers(0, count - 1))
    values[gap : gap + data.draw(st.integers(0, 200))] = np.nan
    start = data.draw(st.floats(-2, count / 1000 - 0.01))
    end = start + data.draw(st.floats(0.005, count / 1000 + 2))
    width = data.draw(st.integers(1, 1500))
    low, high = Trace(values, 1000.0).between(start, end, width)
    edges = np.linspace(start, end, width + 1) * 1000.0
    each = (edges[1] - edges[0]) / 2
    for k in {0, width // 2, width - 1, data.draw(st.integers(0, width - 1))}:
        inside = values[max(0, int(np.ceil(edges[k]))) : max(0, int(np.ceil(edges[k + 1])))]
        near = values[max(0, int(np.floor(edges[k] - each - 2))) : max(0, int(np.ceil(edges[k + 1] + each + 2)))]
        if np.isfinite(inside).any():
            assert low[k] <= np.nanmin(inside)
            assert high[k] >= np.nanmax(inside)
        if np.isfinite(low[k]):
            assert low[k] >= np.nanmin(near)
            assert high[k] <= np.nanmax(near)


# Any sequence of actions


class AnySequence(RuleBasedStateMachine):
    """Actions in any order beside a model of the study that is a few dictionaries; undo restores it."""

    folder = None  # of the study that every sequence begins with

    @initialize()
    def begin(self):
        shutil.rmtree(self.folder.parent / "run", ignore_errors=True)
        self.study = shutil.copytree(self.folder, self.folder.parent / "run", copy_function=os.link)
        for name in ("animals.csv", "study.yaml"):  # what changes is this sequence's own
            (self.study / name).unlink()
            shutil.copy(self.folder / name, self.study / name)
        self.at = place(self.study)
        self.table = {name: dict(row) for name, row in rows(self.study).items()}
        self.edits = {name: {} for name in self.table}
        self.starts, self.groups, self.own, self.past, self.future = 1, ["control", "hypoxic"], [], [], []

    def kept(self):
        table = {name: dict(row) for name, row in self.table.items()}
        edits = {name: dict(one) for name, one in self.edits.items()}
        return table, edits, self.starts, list(self.groups), list(self.own)

    @contextmanager
    def step(self, what, **given):
        """Do something; what the model is changed to within can be undone."""
        before = self.kept()
        do(self.at, what, **given)
        yield
        if self.kept() != before:
            self.past.append(before)
            self.future = []

    def refused(self, what, **given):
        with pytest.raises(InputError):
            do(self.at, what, **given)

    def one(self, data):
        return data.draw(st.sampled_from(sorted(self.table)))

    @precondition(lambda self: self.table)
    @rule(data=st.data())
    def cell(self, data):
        may = dict.fromkeys(("wedge [mmHg]", "zero [mmHg]", "start [s]"), ("", "1", "2.5", "3"))
        may |= {"group": ("", "control", *self.groups)} | dict.fromkeys(self.own, ("", "f", "23.5", "<b>", '"a, b"'))
        name, title = self.one(data), data.draw(st.sampled_from(list(may)))
        text = data.draw(st.sampled_from(may[title]))
        with self.step("set-cells", animal=name, cells={title: text}, was={title: self.table[name].get(title, "")}):
            self.table[name] = {key: one for key, one in (self.table[name] | {title: text}).items() if one}

    @precondition(lambda self: self.table)
    @rule(data=st.data(), other=st.sampled_from(["mouse_c1", "Maus Ä", "<b>", "x,y", "=1+1"]))
    def rename(self, data, other):
        name = self.one(data)
        if "<" in other or "=" in other or other.casefold() in {one.casefold() for one in self.table if one != name}:
            self.refused("set-cells", animal=name, cells={"animal": other})
            return
        with self.step("set-cells", animal=name, cells={"animal": other}):
            self.table = {(other if one == name else one): row for one, row in self.table.items()}
            self.edits = {(other if one == name else one): row for one, row in self.edits.items()}
            self.table[other]["animal"] = other

    @precondition(lambda self: self.table)
    @rule(data=st.data(), time=st.integers(1, 4), action=st.sampled_from(["reject", "keep", "move"]))
    def beat(self, data, time, action):
        name = self.one(data)
        own = self.table[name].get("beat edits")
        to = time + 0.01 if action == "move" else None
        with self.step("edit-beats", animal=name, edits=[[action, float(time), to]]):
            self.edits[name][float(time)] = action
            self.table[name]["beat edits"] = rows(self.study)[name]["beat edits"]
        assert own in (None, self.table[name]["beat edits"])

    @precondition(lambda self: any(self.edits.values()))
    @rule(data=st.data())
    def forget(self, data):
        name = data.draw(st.sampled_from(sorted(one for one, edits in self.edits.items() if edits)))
        time = data.draw(st.sampled_from(sorted(self.edits[name])))
        with self.step("edit-beats", animal=name, forget=[time]):
            del self.edits[name][time]

    @precondition(lambda self: len(self.table) > 2)
    @rule(data=st.data())
    def remove(self, data):
        name = self.one(data)
        with self.step("remove-animal", animal=name):
            del self.table[name], self.edits[name]

    @rule(count=st.integers(-1, 30))
    def setting(self, count):
        if count < 1:
            self.refused("set-setting", key="calibration.starts", value=str(count))
            return
        with self.step("set-setting", key="calibration.starts", value=str(count)):
            self.starts = count

    @rule(extra=st.sampled_from([[], ["sham"], ["sham", "sham"]]))
    def label(self, extra):
        wished = ["control", "hypoxic", *extra]
        if len(set(wished)) < len(wished):
            self.refused("set-groups", groups=wished)
            return
        with self.step("set-groups", groups=wished):
            self.groups = wished

    @rule(title=st.sampled_from(["sex", "weight [g]", "wedg [mmHg]", "Group", "value"]))
    def column(self, title):
        if title in self.own or title in ("wedg [mmHg]", "Group", "value"):  # twice, a slip, taken, of the results
            self.refused("add-column", title=title)
            return
        with self.step("add-column", title=title):
            self.own.append(title)

    @rule(title=st.sampled_from(["sex", "weight [g]", "group"]))
    def without_column(self, title):
        if title not in self.own:
            self.refused("remove-column", title=title)
            return
        with self.step("remove-column", title=title):
            self.own.remove(title)
            for row in self.table.values():
                row.pop(title, None)

    @rule(what=st.sampled_from(["undo", "redo"]))
    def back_and_forth(self, what):
        there, here = (self.past, self.future) if what == "undo" else (self.future, self.past)
        if not there:
            self.refused(what)
            return
        do(self.at, what)
        here.append(self.kept())
        self.table, self.edits, self.starts, self.groups, self.own = there.pop()

    @invariant()
    def the_files_hold_what_the_model_says(self):
        if not hasattr(self, "study"):
            return
        found = rows(self.study)
        assert list(found) == list(self.table)
        for name, row in self.table.items():
            assert {title: text for title, text in found[name].items() if text} == {
                title: text for title, text in row.items() if text
            }
            file = row.get("beat edits")
            there = {one.time: one.action for one in vw.read_edits(self.study / file)} if file else {}
            assert there == self.edits[name]
        assert [title for title in read_rows(self.study / "animals.csv").titles if title not in COLUMNS] == self.own
        known = inspect_study(self.study)[0].settings
        assert (known.calibration.starts, known.groups) == (self.starts, self.groups)
        assert not list(self.study.rglob(".vasowave-part-*"))


def sequences(folder, count, length):
    machine = type("Sequences", (AnySequence,), {"folder": folder})
    run_state_machine_as_test(machine, settings=settings(max_examples=count, stateful_step_count=length, deadline=None))


@pytest.fixture
def tiny(tmp_path):
    """A study whose recordings are never read: its table is what matters."""
    folder = tmp_path / "tiny"
    (folder / "recordings").mkdir(parents=True)
    write_network(SMALL, folder / "lung.csv")
    lines = ["animal,group,network,recording,kind"]
    for name, group in (("mouse_c1", "control"), ("mouse_c2", "control"), ("mouse_h1", "hypoxic")):
        (folder / "recordings" / f"{name}.txt").write_text(
            "time [s]\tpressure [mmHg]\tflow [ml/s]\n0\t1\t1\n", encoding="utf-8"
        )
        lines.append(f"{name},{group},lung.csv,recordings/{name}.txt,raw")
    (folder / "animals.csv").write_text("\n".join([*lines, ""]), encoding="utf-8")
    (folder / "study.yaml").write_text("groups: [control, hypoxic]\ncalibration:\n  starts: 1\n", encoding="utf-8")
    return folder


def test_any_sequence_of_actions_leaves_the_files_as_the_model_says(tiny):
    sequences(tiny, 4, 12)


@pytest.mark.weekly
def test_five_hundred_sequences_of_thirty_actions_leave_the_files_as_the_model_says(tiny):
    sequences(tiny, 500, 30)


def test_a_stretch_out_of_memory_is_the_stretch_that_is_read(study):
    """`vasowave run` reads the file; the desk cuts the stretch out of the recording that it has."""
    recordings = Recordings()
    plan = read_study(study)
    for start, end in ((None, None), (1.0, 7.0), (0.4, 8.9), (2.5, 7.25)):
        row = replace(plan.animals[0], start=start, end=end)
        ours, read = recordings.opened(row, plan).beats(row, plan, ()).raw, read_stretch(row)
        pairs = zip((ours, *ours.beside), (read, *read.beside), strict=True)
        assert all(np.array_equal(one.pressure, other.pressure) and np.array_equal(one.flow, other.flow)
                   and one.origin == other.origin for one, other in pairs)  # fmt: skip
        assert ours.notes == read.notes
    row = replace(plan.animals[0], start=2.0, end=99.0)
    with pytest.raises(InputError, match="does not lie in"):
        recordings.opened(row, plan).beats(row, plan, ())


def test_groups_that_are_typed_after_the_drop_are_brought_to_the_animals_whose_files_hold_them(study):
    at, before = place(study), texts(study)
    assert "by the names of their files: mouse_c1" in do(at, "set-groups", groups=["sham=control", "hypoxic"])
    assert read_settings(study / "study.yaml")[0].groups == ["sham", "hypoxic"]
    groups = {name: row["group"] for name, row in rows(study).items()}
    assert set(groups.values()) == {"sham", "hypoxic"}
    assert all((label == "sham") == name.startswith("mouse_c") for name, label in groups.items())
    do(at, "set-cells", animal="mouse_c1", cells={"group": "hypoxic"})
    do(at, "set-groups", groups=["hypoxic", "sham"])
    assert rows(study)["mouse_c1"]["group"] == "hypoxic"  # what a person said of an animal stays
    for _ in range(3):
        do(at, "undo")
    assert texts(study) == before


def test_a_recording_whose_channels_nobody_knows_is_drawn_by_its_titles_and_averaged_once_they_are_named(study):
    path = study / rows(study)["mouse_c1"]["recording"]
    raw, text = vw.read_raw_recording(path), path.read_text("utf-8")
    path.write_text(text.replace("Pressure 1\tFlow PA\tLead II", "A\tB\tC"), "utf-8")
    at = place(study)
    described = at.recordings.described(at.desk, "mouse_c1")
    assert (described["signals"], "beats" in described) == (["A [mmHg]", "B [ul/s]", "C [mV]"], False)
    assert "name" in described["error"]
    low, high = at.recordings.trace(at.desk, "mouse_c1", "A [mmHg]", 0.0, raw.duration, 1)[:, 0]
    assert (low, high) == pytest.approx((raw.pressure.min(), raw.pressure.max()), rel=1e-3)
    titles = {"pressure channel": "A", "flow channel": "B", "ecg channel": "C"}
    do(at, "set-cells", animal="mouse_c1", cells=titles, was={})
    described = at.recordings.described(at.desk, "mouse_c1")
    assert (described["error"], described["signals"][:2]) == ("", ["pressure", "flow"])


def test_the_desk_shows_comments_and_what_lies_beyond_a_drug_and_averages_as_a_run_does(study):
    path = study / rows(study)["mouse_c1"]["recording"]
    lines = path.read_text("utf-8").split("\n")
    first = next(i for i, line in enumerate(lines) if line[:1].isdigit())
    lines[first + 7000] += "\t#* sildenafil 1 mg/kg"
    path.write_text("\n".join(lines), "utf-8")
    at = place(study)
    described = at.recordings.described(at.desk, "mouse_c1")
    assert [7.0, "sildenafil 1 mg/kg"] in described["comments"]
    assert (described["duration"], described["to"]) == pytest.approx((9.0, 7.0), abs=2e-3)
    assert np.isfinite(at.recordings.trace(at.desk, "mouse_c1", "flow", 7.5, 8.5, 100)).all()
    with pytest.warns(VasowaveWarning):
        run = vw.average_beats(vw.read_raw_recording(path)).recording
    assert described["pressure"] == pytest.approx(list(run.pressure), rel=1e-5)
