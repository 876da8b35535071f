import json
import re
import string
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import pytest
from typer.testing import CliRunner

import finding_codes as pages
import vasowave as vw
from vasowave.base import (
    KINDS,
    OTHER,
    Finding,
    FindingKind,
    Place,
    Severity,
    VasowaveWarning,  # fmt: skip
    as_json,
    finding_of,
    from_json,
    kind,
    shared,
    texts,
    warn,
)
from vasowave.catheter import synthetic_raw_recording
from vasowave.cli import app
from vasowave.study.entering import check_study


@pytest.fixture
def some_kind():
    yield kind("test.too-warm", Severity.LOOK, "{degrees:.1f} °C in '{room}'", "Open a window.")
    KINDS.pop("test.too-warm", None)


def test_a_finding_is_its_code_and_values_and_writes_its_text_from_them(some_kind):
    found = some_kind(degrees=31.0, room="lab")
    assert found == Finding("test.too-warm", (("degrees", 31.0), ("room", "lab")))
    assert str(found) == "31.0 °C in 'lab'"
    assert found.severity is Severity.LOOK
    assert len({found, some_kind(degrees=31.0, room="lab"), some_kind(degrees=32.0, room="lab")}) == 2


def test_findings_come_back_from_json_as_they_were(some_kind):
    found = (some_kind(degrees=31.0, room="lab").at("raw/a.txt"), OTHER(text="odd"))
    assert from_json(as_json(found)) == found
    assert [row["text"] for row in json.loads(as_json(found))] == ["31.0 °C in 'lab'", "odd"]


def test_a_finding_of_a_code_that_is_not_known_keeps_its_code_severity_and_text(some_kind):
    stored = as_json([some_kind(degrees=31.0, room="lab")])
    KINDS.pop(some_kind.code)
    (found,) = from_json(stored)
    assert (found.code, found.severity, str(found)) == ("test.too-warm", Severity.LOOK, "31.0 °C in 'lab'")
    assert from_json(as_json([found])) == (found,)


def test_a_warning_carries_its_finding(some_kind):
    found = some_kind(degrees=31.0, room="lab").at("a.txt")
    with pytest.warns(VasowaveWarning, match=r"a\.txt: 31\.0 °C") as caught:
        warn(found, stacklevel=1)
    assert finding_of(caught[0].message) == found
    assert caught[0].filename == __file__
    assert finding_of("something else") == OTHER(text="something else")


def test_a_place_that_is_given_later_leaves_the_vessel_that_was_named(some_kind):
    found = some_kind(degrees=31.0, room="lab").at(vessel="seg7").placed(Place("animals.csv", 3, animal="one"))
    assert found.place == Place("animals.csv", 3, animal="one", vessel="seg7")


def test_file_names_in_a_finding_are_seen_from_a_folder(some_kind):
    found = some_kind(degrees=31.0, room="/study/a.txt").at("/study/a.txt").inside("/study/")
    assert (found.place.file, dict(found.values)["room"]) == ("a.txt", "a.txt")


def test_what_all_laws_say_is_said_once_and_the_rest_by_its_law(some_kind):
    one, two, three = (some_kind(degrees=degrees, room="lab") for degrees in (1.0, 2.0, 3.0))
    found = shared({"linear": [one, two], "tangent": [two, three]})
    assert [(dict(each.values)["degrees"], each.place.law) for each in found] == [
        (2.0, ""), (1.0, "linear"), (3.0, "tangent")
    ]  # fmt: skip
    assert texts(found)[1] == "linear wall: 1.0 °C in 'lab'. Open a window."
    assert from_json(as_json(found)) == tuple(found)


def test_codes_name_a_room_and_what_was_noticed_and_every_look_and_error_has_a_remedy():
    pages.load_all()
    for code, one in KINDS.items():
        assert re.fullmatch(r"other|[a-z]+\.[a-z-]+", code), code
        assert one.severity is Severity.NOTE or one.remedy, code
        assert all(field is None or field.isidentifier() for _, field, _, _ in string.Formatter().parse(one.text))


def odd_study(tmp_path):
    """A study of one animal whose recording drifts, is off its zero, and names channels that do not beat."""
    raw = synthetic_raw_recording(vw.virtual_mouse(), np.random.default_rng(8), duration=12.0).raw
    pressure = raw.pressure + 0.5 * raw.time
    pressure[:4000] = 0.8 + np.random.default_rng(1).normal(0, 0.05, 4000)
    rows = np.column_stack([raw.time, pressure, raw.flow])
    np.savetxt(tmp_path / "a.csv", rows, "%.6g", ",", header="time [s],pressure [mmHg],flow [ml/s]", comments="")
    vw.write_network(replace(vw.control_network(), pressure=6.3), tmp_path / "lung.csv")
    (tmp_path / "animals.csv").write_text("animal,group,network,recording\nm1,CTL,lung.csv,a.csv\n", "utf-8")
    (tmp_path / "study.yaml").write_text("groups: [CTL]\ncalibration: {walls: [linear], starts: 1}\n", "utf-8")
    return tmp_path / "study.yaml"


def say_nothing(monkeypatch):
    for code, one in KINDS.items():
        monkeypatch.setitem(KINDS, code, replace(one, text="no word of it", remedy=""))


def test_other_words_change_nothing_of_what_check_finds(tmp_path, monkeypatch):
    study = odd_study(tmp_path)

    def seen():
        problems = check_study(study).problems
        run = CliRunner().invoke(app, ["check", str(study)])
        return run.exit_code, run.output.splitlines()[-1], [
            (one.place, one.error, one.finding.code, one.same) for one in problems
        ]  # fmt: skip

    before = seen()
    assert before[:2] == (0, f"0 errors, {len(before[2])} warnings")
    assert {"baseline.drifts", "recording.zero-off"} <= {code for _, _, code, _ in before[2]}
    say_nothing(monkeypatch)
    assert "baseline" not in str(check_study(study).problems[0])
    assert seen() == before


def test_other_words_change_nothing_of_a_study(tmp_path, monkeypatch):
    def seen(folder):
        folder.mkdir()
        with ThreadPoolExecutor(1) as here:
            done = vw.run_study(vw.read_study(odd_study(folder)), executor=here)
        (result,) = vw.read_results(folder).in_order()
        beats = result.beats["cause"].values.tolist()
        found = [(one.code, one.severity, one.values, one.place) for one in result.findings]
        return done.computed, done.failures, float(result.laws["linear"].calibration["S"]), beats, found

    before = seen(tmp_path / "before")
    assert {"recording.zero-off", "fit.harmonics-with-signal"} <= {code for code, *_ in before[-1]}
    say_nothing(monkeypatch)
    assert seen(tmp_path / "after") == before


def test_a_finding_that_another_version_stored_with_other_values_keeps_its_text_and_severity(monkeypatch):
    now = FindingKind("test.asks-for-more", Severity.LOOK, "{what} stands at its {end} value. {remedy}", "Look.")
    monkeypatch.setitem(KINDS, now.code, now)
    (stored,) = json.loads(as_json([now(what="the flow", end="largest")]))
    stored |= {"text": "the flow stands at its largest value", "values": {"what": "the flow"}}
    (found,) = from_json(json.dumps([stored]))
    assert str(found) == "the flow stands at its largest value"
    assert (found.code, found.severity) == ("test.asks-for-more", Severity.LOOK)
    (again,) = from_json(as_json([found]))  # and stored once more
    assert again == found
    (same,) = from_json(as_json([now(what="the flow", end="largest")]))
    assert str(same) == "the flow stands at its largest value. Look."
