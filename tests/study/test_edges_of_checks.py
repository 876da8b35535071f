"""What is checked in a study, on the edge of each rule, and its words: cells, blood, physiology, pairs of animals."""

import math
import os
import zlib
from dataclasses import dataclass, replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest

from vasowave.animal.failure import Failure, Stage
from vasowave.cohort.design import Design
from vasowave.cohort.variables import Variable
from vasowave.datasets import published_table
from vasowave.datasets.virtual import virtual_mouse
from vasowave.errors import InputError
from vasowave.findings import NOWHERE, Place
from vasowave.settings import Setting
from vasowave.species import ANY_HEART_RATES, SPECIES, heart_rates_of
from vasowave.study import designing, engine, template
from vasowave.study.animals import _files, _group_sizes, _implied_kind, _number, read_animals, read_row
from vasowave.study.checking import _alike, _half_known, _known, _meant, _same_cycle
from vasowave.study.engine import _Run
from vasowave.study.executors import side_by_side
from vasowave.study.overview import AnimalRead, aligned, expected_seconds, overview_lines
from vasowave.study.physiology import BLOOD, blood_findings, physiology_findings
from vasowave.study.planning import published_spreads
from vasowave.study.problems import Problem, one_per_cause, refuse, unreadable
from vasowave.study.reading import _DEEPEST, parse_document, read_document
from vasowave.study.results import Results, StoredAnimal, _file_name
from vasowave.study.rows import COLUMNS, ERRORS, AnimalRow
from vasowave.study.settings import StudyFile
from vasowave.study.single_animal import _parameter
from vasowave.study.status import AnimalStatus, outdated, stage
from vasowave.study.store import piece_digest, read_journal
from vasowave.study.table import Rows, read_rows, written_rows

EMPTY = dict.fromkeys(COLUMNS, "")


def said_of(text, title="wedge [mmHg]"):
    told = []
    value = _number(text, title, lambda column, finding: told.append((column, str(finding))))
    return value, [words for column, words in told if column == title]


@pytest.mark.parametrize(
    ("text", "title", "value", "words"),
    [
        ("", "block", None, []),
        ("0", "wedge [mmHg]", 0.0, []),
        ("-0.1", "wedge [mmHg]", None, ["-0.1 is not a positive number"]),
        ("-3", "zero [mmHg]", -3.0, []),
        ("-1", "flow gain [1]", -1.0, []),
        (
            "1e-300",
            "flow gain [1]",
            None,
            ["'1e-300' is beyond any size that this can have; check its digits and its unit"],
        ),
        ("0", "flow gain [1]", None, ["a gain of 0 leaves no flow; leave the cell empty if it is not known"]),
        ("-0.01", "flow zero [ml/s]", -0.01, []),
        ("-0.004", "pressure delay [s]", -0.004, []),
        ("-inf", "zero [mmHg]", None, ["-inf is not a positive number"]),
        ("inf", "end [s]", None, ["inf is not a positive number"]),
        ("0", "end [s]", None, ["0 is not a positive number"]),
        ("0", "start [s]", 0.0, []),
        ("1e-11", "end [s]", 1e-11, []),
        ("2", "block", 2.0, []),
        ("2.5", "block", None, ["2.5 is not a positive whole number"]),
        ("0", "block", None, ["0 is not a positive whole number"]),
        ("2.5", "period [s]", 2.5, []),
        ("1,5", "end [s]", None, ["'1,5' is not a number; write a decimal point instead of a comma"]),
        ("-1,5", "end [s]", None, ["'-1,5' is not a number; write a decimal point instead of a comma"]),
        ("1,5,6", "end [s]", None, ["'1,5,6' is not a number"]),
        ("x", "end [s]", None, ["'x' is not a number"]),
    ],
)
def test_the_number_of_a_cell_has_a_lowest_value(text, title, value, words):
    assert said_of(text, title) == (value, words)


def test_the_kind_is_told_by_columns_that_one_kind_alone_has():
    assert _implied_kind(EMPTY) == ""
    assert _implied_kind({**EMPTY, "flow": "q.csv", "block": "2"}) == "cycle"
    assert _implied_kind({**EMPTY, "period [s]": "0.1"}) == "cycle"
    for title in ("pressure channel", "flow channel", "ecg channel", "block", "start [s]", "end [s]", "beat edits"):
        assert _implied_kind({**EMPTY, title: "1"}) == "raw"


@pytest.fixture
def folder(tmp_path):
    for name in ("net.csv", "p.csv", "q.csv"):
        (tmp_path / name).write_text("x")
    (tmp_path / "sub").mkdir()
    return tmp_path


def rowed(folder, **cells):
    whole = {"animal": "a", "group": "CTL", "network": "net.csv", "recording": "p.csv"}
    whole |= {name.replace("_", " "): text for name, text in cells.items()}
    row, wrong = read_row(whole, folder, ["CTL", "HPH"], lambda title: Place(part=title), 7)
    return row, [(one.place.part, str(one.finding)) for one in wrong]


def test_files_of_a_row_are_named_with_what_they_are(folder):
    os.mkfifo(folder / "pipe")
    for name, words in (
        ("sub", "'sub' is a folder"),
        ("pipe", "'pipe' is a pipe or a device; copy what it gives into a file"),
        ("nowhere/p.csv", "'nowhere/p.csv' does not exist, nor does its folder"),
        ("pp.csv", "'pp.csv' does not exist (did you mean 'p.csv'?)"),
        ("zzzzzz", "'zzzzzz' does not exist"),
    ):
        assert rowed(folder, recording=name) == (None, [("recording", words)])
        assert rowed(folder, sites=name) == (None, [("sites", words)])
    long = "v" * 300
    assert rowed(folder, ventricle=long)[1][0][1].startswith(f"'{long}' is no name of a file (")
    assert _files({**EMPTY, "network": "net.csv", "recording": "p.csv", "flow": "q.csv"}, "raw", folder, print) == [
        folder / "net.csv", folder / "p.csv"
    ]  # fmt: skip
    row = rowed(folder, flow="q.csv", beat_edits="", wedge_wave="q.csv")[0]
    assert [one.name for one in row.recordings] == ["p.csv", "q.csv"]
    assert (row.kind, row.wedge_wave, row.beat_edits, row.line) == ("cycle", folder / "q.csv", None, 7)


def test_words_of_a_row_are_those_that_are_known(folder):
    row, wrong = rowed(folder, kind="RAW", synthetic="Yes", shared_recording="no", **{"period [s]": "0.1"})
    assert (row.kind, row.synthetic, row.shared_recording, row.period) == ("raw", True, False, 0.1)
    assert wrong == [("period [s]", "has no meaning for an animal of kind 'raw' and is ignored")]
    row, wrong = rowed(folder, kind="cycle", block="2", shared_recording="YES", **{"end [s]": "3"})
    assert (row.kind, row.block, row.shared_recording, row.synthetic) == ("cycle", 2, True, False)
    assert [part for part, _ in wrong] == ["block", "end [s]"]
    assert rowed(folder, kind="cylce")[1] == [("kind", "'cylce' (did you mean 'cycle'?); write cycle or raw")]
    assert rowed(folder, synthetic="maybe")[1] == [("synthetic", "'maybe'; write yes or no")]
    assert rowed(folder, group="CTK")[1][0][1].endswith("(did you mean 'CTL'?); its groups: CTL, HPH")
    assert rowed(folder, group="")[1] == [("group", "the cell is empty")]
    assert [part for part, _ in rowed(folder, pressure_unit="mlHg", flow_unit="furlong")[1]] == [
        "pressure unit", "flow unit"
    ]  # fmt: skip
    assert rowed(folder)[0].kind == ""


def test_a_zero_before_and_after_is_their_mean_and_its_error_that_of_a_drift_between_them(folder):
    row = rowed(folder, **{"zero [mmHg]": "1", "zero after [mmHg]": "4"})[0]
    assert (row.zero, row.errors) == (2.5, {"zero_sd": pytest.approx(3 / math.sqrt(12))})
    row = rowed(folder, **{"zero after [mmHg]": "-3"})[0]
    assert (row.zero, row.errors["zero_sd"]) == (-1.5, pytest.approx(3 / math.sqrt(12)))
    assert row.calibration == (-1.5, 1.0, 1.0, 0.0)
    said = next(title for title, name in ERRORS.items() if name == "zero_sd")
    row = rowed(folder, **{"zero [mmHg]": "1", "zero after [mmHg]": "4", said: "0.25"})[0]
    assert row.errors == {"zero_sd": 0.25}
    row = rowed(folder, **{"pressure gain [1]": "1.5", "flow gain [1]": "0.5"})[0]
    assert row.calibration == (0.0, 1.5, 0.5, 0.0)


def test_animals_are_told_apart_by_more_than_capitals_and_groups_have_two(folder):
    table = folder / "animals.csv"
    table.write_text("animal,group,network,recording\nA,CTL,net.csv,p.csv\nb,CTL,net.csv,p.csv\na,HPH,net.csv,p.csv\n")
    rows, problems = read_animals(table, ["CTL", "HPH"])
    assert [str(one) for one in problems if one.error] == [
        f"{table}, line 4, column 'animal': 'a' stands in line 2 already; rename one; where one animal was measured "
        "twice, say so in a column of your own, and name that as the design's subject"
    ]
    assert len(rows) == len(problems) + 2 == 3
    sizes = [str(one.finding) for one in _group_sizes(table, rows, ["CTL", "HPH", "SU"])]
    assert sizes == [
        "group 'HPH' has one animal; a comparison needs two or more",
        "group 'SU' has no animal; a comparison needs two or more",
    ]
    table.write_text("animal,group,network,recording\n")
    assert str(read_animals(table, None)[1][0]).startswith(f"{table}: no animals yet; add one row")
    table.write_text("Animal,grup,network,recording,source,weight,WEIGHT,Network\nA,CTL,net.csv,p.csv,x,1,2,n\n")
    said = [str(one).removeprefix(f"{table}, ") for one in read_animals(table, None)[1]]
    assert said == [
        "header, column 'grup': unknown column (did you mean 'group'?); give it another name if it is one of your own",
        "header, column 'source': is the name of a column of the tables of results; rename it",
        "header, column 'weight': stands twice; keep one",
        "header, column 'network': stands twice; keep one",
        "header: no column 'group'",
    ]


@pytest.mark.parametrize("name", BLOOD)
def test_blood_is_blood_up_to_its_limits(name):
    low, high, _, usual = BLOOD[name]
    fine = {"density": 1.057, "viscosity": 0.0462}
    for value, odd in ((low, 0), (high, 0), (low * 0.999, 1), (high * 1.001, 1), (usual, 0)):
        assert len(blood_findings(SimpleNamespace(**{**fine, name: value}))) == odd
    found = blood_findings(SimpleNamespace(density=5.0, viscosity=5.0))
    assert [dict(one.values)["quantity"] for one in found] == ["density", "viscosity"]
    assert str(found[0]) == "blood.density: 5 g/ml is no blood's (0.95 to 1.3, usual 1.057); is the unit right?"


UNITS = {"HR": "beats/min", "mPAP": "mmHg", "pPAP": "mmHg", "CO": "ml/s", "root radius": "cm"}
MOUSE = {"HR": 500.0, "mPAP": 15.0, "pPAP": 12.0, "CO": 0.2, "root radius": 0.05}


@pytest.mark.parametrize("name", UNITS)
def test_values_at_the_ends_of_a_range_are_plausible(name):
    low, high = getattr(SPECIES["mouse"], name.replace(" ", "_"))
    for value, odd in ((low, 0), (high, 0), (low * 0.999, 1), (high * 1.001, 1)):
        found = physiology_findings({**MOUSE, name: value}, 0.2, "mouse")
        assert len(found) == odd
    what = "a radius, not a diameter" if name == "root radius" else "one whole cycle"
    assert str(found[0]).partition("? ")[0].removesuffix("?") == (
        f"{name} {high * 1.001:.4g} {UNITS[name]} is implausible for a mouse ({low:g} to {high:g}); is the unit right, "
        f"and is it {what}"
    )


def test_a_decay_is_usual_up_to_its_limits_and_another_species_has_none():
    low, high = SPECIES["mouse"].tau
    assert [len(physiology_findings(MOUSE, tau, "mouse")) for tau in (low, high, low / 1.01, high * 1.01)] == [
        0,
        0,
        1,
        1,
    ]
    assert physiology_findings({}, 99.0, "other") == []
    assert heart_rates_of("mouse") == (250.0, 900.0)
    assert heart_rates_of("other") == ANY_HEART_RATES == (30.0, 900.0)


def test_values_that_fit_others_are_told_once_and_which_they_fit():
    dog_and_pig = {"HR": 80.0, "mPAP": 15.0, "pPAP": 12.0, "CO": 20.0, "root radius": 0.6}
    found = physiology_findings(dog_and_pig, 0.2, "mouse")
    assert len(found) == 1
    assert str(found[0]).startswith("HR 80 beats/min is implausible for a mouse (300 to 800);")
    assert " All of them fit a dog or a pig" in str(found[0])
    assert "write species: dog (vasowave fit: --species dog)" in str(found[0])
    assert len(physiology_findings({**dog_and_pig, "mPAP": 1500.0}, 0.2, "mouse")) == 4


def finding(place=NOWHERE, text="wrong"):
    return unreadable(InputError(text), place).finding


def test_one_cause_is_one_problem_with_the_lines_where_it_stands():
    same = [
        Problem(finding(Place("t.csv", line, animal=name))) for line, name in ((3, "a"), (5, "b"), (5, "b"), (9, "c"))
    ]
    (joined,) = one_per_cause(same)
    assert str(joined) == "t.csv, line 3 ('a'): wrong (the same in lines 5, 9)"
    assert joined.animals == ("a", "b", "c")
    assert str(one_per_cause(same[:2])[0]).endswith("wrong (the same in line 5)")
    assert str(one_per_cause(same[:1])[0]).endswith("wrong")
    others = [
        unreadable(InputError(f"{name}: bad"), Place("t.csv", line), [Path(name)])
        for line, name in ((2, "x.csv"), (4, "y.csv"))
    ]
    assert str(one_per_cause(others)[0]) == "t.csv, line 2: x.csv: bad (the same in line 4)"
    assert len(one_per_cause([*same, *others])) == 2


def test_errors_are_raised_one_in_its_words_and_several_in_lines():
    refuse([])
    with pytest.raises(InputError, match=r"^t.csv, line 3: wrong$"):
        refuse([Problem(finding(Place("t.csv", 3)))])
    with pytest.raises(InputError, match=r"^2 errors:\n  t.csv, line 3: wrong\n  u: else$"):
        refuse([Problem(finding(Place("t.csv", 3))), Problem(finding(Place("u"), "else"))])


def test_a_table_is_written_with_the_columns_it_had_and_those_that_are_used():
    table = Rows(("# mine",), ("weight [g]", "animal"), ({"weight [g]": "20", "animal": "a"},))
    text = written_rows(table, [{"animal": "b", "recording": "r, s", "block": ""}, {"animal": "c", "end [s]": "3"}])
    assert text.splitlines() == [
        "# mine", "weight [g],animal,group,network,recording,end [s]", "20,a,,,,", ',b,,,"r, s",', ",c,,,,3"
    ]  # fmt: skip


def test_rows_are_read_with_titles_as_the_program_writes_them(tmp_path):
    path = tmp_path / "animals.csv"
    assert read_rows(path) == Rows((), (), ())
    path.write_text("# a\n")
    assert read_rows(path) == Rows(("# a",), (), ())
    path.write_text("# a\nANIMAL;Start [S];mine\n # b\n")
    assert read_rows(path) == Rows(("# a", " # b"), ("animal", "start [s]", "mine"), ())
    path.write_text("Animal,END [s],w [g]\nm,1,2\n")
    assert read_rows(path) == Rows((), ("animal", "end [s]", "w [g]"), ({"animal": "m", "end [s]": "1", "w [g]": "2"},))


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (True, "true"), (False, "false"), ([1, 2.0], "[1, 2]"), ((), "[]"), ({"a": 1, "b": [2]}, "{a: 1, b: [2]}"),
        (0.00001, "1.0e-05"), (1.5e-7, "1.5e-07"), (0.5, "0.5"), (2.0, "2"), ("a", "a"), (["a, b", "c"], '["a, b", c]'),
    ],
)  # fmt: skip
def test_values_are_written_as_yaml_reads_them(value, text):
    assert template.written(value) == text


def test_one_value_of_a_study_file_is_changed_and_the_rest_stays(tmp_path):
    path = tmp_path / "study.yaml"

    def changed(text, key, value):
        path.write_text(text)
        return template.with_value(path, key, value)

    assert changed("title: a  # mine\nspecies: rat\n", ("title",), "b") == "title: b  # mine\nspecies: rat\n"
    assert changed("title: a\n", ("species",), "rat") == "title: a\nspecies: rat\n"
    nested = "calibration:\n   starts: 3 # few\ntitle: a\n"
    assert changed(nested, ("calibration", "starts"), "4") == "calibration:\n   starts: 4 # few\ntitle: a\n"
    assert changed("calibration:\n  starts: 3\n", ("calibration", "beds"), "windkessel") == (
        "calibration:\n  beds: windkessel\n  starts: 3\n"
    )
    assert changed("title: a\n", ("report", "pdf"), "false") == "title: a\nreport:\n  pdf: false\n"
    with pytest.raises(InputError, match=r"'groups' is written over several lines; write there: groups: \[A, B\]$"):
        changed("groups:\n- CTL\n- HPH\n", ("groups",), "[A, B]")
    with pytest.raises(InputError, match=r"'report.pdf' is written over several|report.pdf"):
        changed("report: {pdf: true, law: linear}\n", ("report", "pdf"), "false")
    path.write_text("groups: [B]\n")
    assert template.with_groups(path, ["A", "C, D"]) == 'groups: [A, "C, D"]\n'


def test_keys_without_a_default_are_empty_and_examples_are_remarks():
    none = Setting(int, None, "What it is.", 3)
    assert template._key("k", none, "  ") == ["  k:", "  # k: 3"]
    assert template._key("k", none._replace(default=2, example=None), "") == ["k: 2"]
    assert (template._default(none), template._default(none._replace(default=0.5))) == ("empty", "`0.5`")
    comment = template._comment("word " * 30, "  ")
    assert len(comment) == 2
    assert comment[0] == "  # " + " ".join(["word"] * 20)


def read(name="m", **other):
    values = {"duration": 12.345, "beats": (80, 95), "heart_rate": 501.6, "mean_pressure": 15.26, "mean_flow": 0.2104}
    return AnimalRead(name, "CTL", 21, **{"kind": "raw", "drift": -1.26, **values, **other})


def test_what_was_read_is_a_table_where_it_fits_and_paragraphs_where_not():
    rows = [read(), read("mouse 12", kind="cycle", mean_flow=1.0)]
    assert rows[0].row() == ("m", "CTL", "21", "raw", "12.3", "80/95", "502", "15.3", "0.210", "-1.3")
    assert rows[1].row() == ("mouse 12", "CTL", "21", "cycle", "", "", "502", "15.3", "1.000", "")
    wide = overview_lines(rows, 200)
    widest = max(map(len, wide))
    assert wide[0].split() == ["animal", "group", "vessels", "kind", "length", "beats", "HR", "mPAP", "CO", "drift"]
    assert wide[1].split() == ["s", "used", "1/min", "mmHg", "ml/s", "mmHg"]
    assert wide[2] == "-" * widest
    assert len(wide) == 6
    assert wide[-1] == ""
    assert overview_lines(rows, widest) == wide
    narrow = overview_lines(rows, widest - 1)
    assert narrow[0].startswith("m (CTL): vessels 21, kind raw, length 12.3 s, beats 80/95, HR 502 1/min,")
    assert "  CO 1.000 ml/s" in overview_lines(rows, 20)
    assert max(map(len, overview_lines(rows, 20))) <= 20
    assert aligned([("a", "bb"), ("ccc", "d")], (0,)) == ["a    bb", "ccc   d"]


def test_the_time_is_shared_by_the_cores_that_animals_keep_busy():
    settings = StudyFile()
    laws, starts = len(settings.calibration.walls), settings.calibration.starts
    one = expected_seconds([read()], settings, 4)
    assert one == pytest.approx(0.4 * starts * laws)
    assert expected_seconds([read(), read(), read()], settings, 2) == pytest.approx(1.5 * one)
    assert expected_seconds([read(), read()], settings, 8) == pytest.approx(one)
    assert expected_seconds([], settings, 8) == 0.0
    posterior = replace(settings, inference="posterior")
    assert expected_seconds([read()], posterior, 1) == pytest.approx(one + 18 * laws)


def test_cycles_are_the_same_within_a_thousandth():
    cycle = virtual_mouse()

    def like(**changes):
        return _same_cycle(cycle, replace(cycle, **changes))

    tall, wide = float(np.ptp(cycle.pressure)), float(np.ptp(cycle.flow))
    bump = (np.arange(len(cycle.pressure)) == 7).astype(float)
    assert like()
    assert like(pressure=cycle.pressure + 0.00099 * tall * bump)
    assert not like(pressure=cycle.pressure + 0.00101 * tall * bump)
    assert like(flow=cycle.flow + 0.00099 * wide * bump)
    assert not like(flow=cycle.flow + 0.00101 * wide * bump)
    assert like(period=cycle.period * 1.00099)
    assert not like(period=cycle.period * 1.00102)
    assert not _same_cycle(cycle, replace(cycle, pressure=cycle.pressure[:-2], flow=cycle.flow[:-2]))


def animal_row(name, line, shared=False):
    return AnimalRow(name, "CTL", Path("n"), (Path(f"{name}.csv"),), line, shared_recording=shared)


def test_cycles_alike_are_found_among_all_pairs_and_told_of_the_later_row():
    cycle = virtual_mouse()
    study = SimpleNamespace(table=Path("t.csv"))
    lower = replace(cycle, pressure=cycle.pressure - 1)
    rows = [animal_row(name, line) for name, line in (("a", 2), ("b", 3), ("c", 4), ("d", 5))]
    found = list(_alike(study, [*zip(rows, (lower, cycle, lower, cycle), strict=True)]))
    assert [(one.place.line, one.also) for one in found] == [(4, ("c", "a")), (5, ("d", "b"))]
    assert str(found[0].finding).startswith("its averaged cycle is that of 'a' (line 2); remove one")
    shared = [animal_row("a", 2, True), animal_row("b", 3, True), animal_row("c", 4)]
    assert [_meant(shared[i], shared[j]) for i, j in ((0, 1), (0, 2), (2, 1))] == [True, False, False]
    assert len(list(_alike(study, [*zip(shared, [cycle] * 3, strict=True)]))) == 2


@pytest.mark.parametrize("factor", [2.999, 3.001, 1 / 2.999, 1 / 3.001])
def test_known_values_may_differ_threefold(factor):
    nominal = SimpleNamespace(total_resistance=80.0, time_constant=0.16)
    row = replace(animal_row("a", 2), R_T=80 * factor, tau=0.16 * factor, C_T=0.002)
    odd = 2 if max(factor, 1 / factor) > 3 else 0
    found = _known(row, nominal)
    assert [dict(one.values)["name"] for one in found] == ["R_T", "tau"][:odd]
    assert all(dict(one.values)["factor"] == pytest.approx(max(factor, 1 / factor)) for one in found)
    alone = _known(replace(animal_row("a", 2), C_T=0.002 * factor), nominal)
    assert [dict(one.values)["expected"] for one in alone] == [pytest.approx(0.002)] * (odd // 2)
    assert _known(replace(animal_row("a", 2), R_T=40.0, C_T=0.004 * factor), nominal) == [] or odd


def test_rows_that_lack_a_network_or_group_are_read_all_the_same(tmp_path):
    def told(cells):
        (tmp_path / "animals.csv").write_text(f"animal,group,network,recording\n{cells}\n")
        study = SimpleNamespace(table=tmp_path / "animals.csv", folder=tmp_path, settings=StudyFile())
        return [one.place.animal for one in _half_known(study)]

    (tmp_path / "r.csv").write_text("time [s],nothing\n0,1\n")
    assert told("a,CTL,,r.csv") == ["a"]
    assert told("a,,n.csv,r.csv") == ["a"]
    assert told("a,,,r.csv") == ["a"]
    assert told("a,CTL,n.csv,r.csv") == []
    assert told("a,CTL,,") == []
    assert told("a,CTL,,none.csv") == []


def test_a_document_knows_the_nearest_place_of_what_is_asked():
    document = parse_document(b"a: 1\nb:\n  c: [2, 3]\n", "f")
    assert document.place(("b", "c", 1)) == Place("f", 3, "column 10")
    assert document.place(("b", "c"), key=True) == Place("f", 3, "column 3")
    assert document.place(("b", "x", "y")) == Place("f", 3, "column 3")
    assert document.place(("b", "x"), key=True) == Place("f", 2, "column 1")
    assert document.place(()) == Place("f", 1, "column 1")
    assert parse_document(b"", "f").place(("a",)) == Place("f")
    assert document.keys == {("a",), ("b",), ("b", "c")}


@pytest.mark.parametrize(
    ("raw", "said"),
    [
        (b"a: 1\n\nb: \xff", "f, line 3: not UTF-8 text; save the file as UTF-8"),
        (b"a: 1\n\tb: 2", "f, line 2, column 1: not valid YAML: found character '\\t' that cannot start any token "
            "(indent with blanks, not with tabs); look for a missing colon, quotation mark or indentation"),
        (b"a: 1\n\na: 2", "f, line 3, column 1: 'a' stands a second time (first in line 1); keep one"),
        (b"a: &x 1\nb: *x", "f, line 2, column 1: this is an alias; write the value out"),
        (b"- a", "f, line 1: expected lines of the form 'key: value'"),
        (b"? [1]\n: 2", "f, line 1, column 3: this cannot be a key; write 'key: value'"),
        (b"{a, b: 1}", "f, line 1, column 2: 'a' has no value; a name that holds a comma stands in quotation marks, "
                       '"HPH, drug": 1'),
    ],
)  # fmt: skip
def test_what_yaml_cannot_say_is_told_with_its_place(raw, said):
    told = [str(one) for one in parse_document(raw, "f").problems]
    assert told[0] == said


def test_values_that_say_nothing_are_none_unless_quoted_and_depth_has_an_end():
    values = parse_document(b"a: ~\nb: null\nc: '~'\nd:\ne: ''\nf: NULL\n", "f").values
    assert values == {"a": None, "b": None, "c": "~", "d": None, "e": "", "f": None}
    assert _DEEPEST == 20
    fine, deep = ("a: " + "[" * depth + "]" * depth for depth in (20, 21))
    assert parse_document(fine.encode(), "f").problems == []
    assert [str(one.finding) for one in parse_document(deep.encode(), "f").problems] == [
        "nested too deeply to be a study file"
    ]


def test_a_study_file_that_is_not_there_says_where_the_study_is(tmp_path):
    (tmp_path / "study.yaml").write_text("")
    inner = tmp_path / "a" / "b"
    inner.mkdir(parents=True)
    with pytest.raises(InputError, match=f"no such file or directory; the study is {tmp_path}$"):
        read_document(inner / "study.yaml")
    with pytest.raises(InputError, match=r"a: is a folder; `vasowave new FOLDER` makes a new study"):
        read_document(tmp_path / "a")


def results_of(*animals, failures=(), **settings):
    stored = tuple(StoredAnimal(name, group, f"animals/{name}.nc", "0") for name, group in animals)
    return Results(Path("s/results"), stored, tuple(failures), StudyFile(**settings), {"vasowave": "1"})


def test_an_animal_that_is_not_there_is_told_with_what_is():
    found = results_of(*((f"CTL {n}", "CTL") for n in range(1, 9)), ("HPH 1", "HPH"))
    with pytest.raises(
        KeyError, match=r"there is no result of 'TL' \(did you mean 'CTL 1', 'CTL 2', 'CTL 3', 'CTL 4',"
    ):
        found["TL"]
    with pytest.raises(
        KeyError, match=r"no result of 'hph 2' \(did you mean 'HPH 1'\?\); there are: CTL 1, .*CTL 6 and 3 more"
    ):
        found["hph 2"]
    lost = Failure("x", "CTL", "", Stage.COMPUTING, "burnt", 15.0)
    with pytest.raises(InputError, match=r"no result of 'x': .*burnt; there are: a$"):
        results_of(("a", "CTL"), failures=[lost]).file_of("x")
    assert ("a" in results_of(("a", "CTL"))) is True
    assert ("b" in results_of(("a", "CTL"))) is False
    assert len(found) == 9
    assert found.file_of("CTL 3") == Path("animals/CTL 3.nc")


def test_results_show_groups_laws_and_what_can_be_typed():
    lines = repr(results_of(("a", "CTL"), ("b", "CTL"), ("c", "HPH"))).splitlines()
    assert lines[0] == "Study: Pulmonary arteries of two groups"
    assert lines[1].split(maxsplit=1) == ["CTL", "2  a and b"]
    assert lines[2].split(maxsplit=1) == ["HPH", "1  c"]
    assert lines[3].startswith("  wall laws  ")
    assert lines[4].split(maxsplit=1) == ["next", "results['a'], results.table(), results.compare('HPH')"]
    assert len(lines) == 5
    assert repr(results_of(("a", "CTL"))).endswith("results['a'], results.table()")


def test_file_names_of_animals_have_eighty_bytes_and_plain_letters():
    assert _file_name("a/b:c") == "a_b_c"
    assert _file_name(" .ä. ") == "ä"
    assert _file_name("x" * 81) == "x" * 80
    assert _file_name("ä" * 41) == "ä" * 40
    assert _file_name("x" + "ä" * 40) == "x" + "ä" * 39


def test_states_are_words():
    assert stage("linear", (3, 20)) == "linear 3 of 20 searches"
    assert stage("linear posterior", (30, 0)) == "linear posterior 30 simulations"
    assert str(AnimalStatus("a", "begun", {"linear": (1, 4), "tangent": (0, 4)})) == (
        "linear 1 of 4 searches, tangent 0 of 4 searches"
    )
    assert str(AnimalStatus("a", "unreadable", {}, "no file")) == "unreadable: no file"
    failed = (Failure("a", "CTL", "linear", Stage.COMPUTING, "burnt"),)
    assert str(AnimalStatus("a", "done", {}, failures=failed)) == f"done; failed: {failed[0]}"
    assert str(AnimalStatus("a", "waiting", {})) == "waiting"


def test_settings_and_columns_that_say_something_else_are_named():
    def study(cells, **settings):
        columns = tuple(Variable.of(title, values) for title, values in cells.items())
        return SimpleNamespace(settings=StudyFile(**settings), variables=columns)

    before = study({"sex": {"a": "f"}, "w [g]": {"a": "1"}, "old": {"a": "x"}})
    now = study(
        {"sex": {"a": "m"}, "w [g]": {"a": "1"}, "new": {"a": "x"}}, title="other", design=Design(covariates=["sex"])
    )
    assert outdated(now, before) == (["title", "design"], ["sex", "old", "new"])
    assert outdated(before, before) == ([], [])


def test_a_parameter_is_told_with_its_unit_or_what_it_means():
    one = pd.DataFrame({"x": [1]}).to_xarray()
    said = {"parameter": "R1", "value": 0.123456, "unit": "1", "meaning": "of the bed", "free": True, "at_bound": False,
            "determined": True}  # fmt: skip
    assert _parameter(one.isel(index=0, drop=True).assign(said)) == "R1 0.1235 (of the bed)"
    assert _parameter(one.isel(index=0, drop=True).assign({**said, "unit": "mmHg"})) == "R1 0.1235 mmHg"


def test_the_time_left_is_known_once_one_has_ended(monkeypatch):
    clock = [100.0]
    monkeypatch.setattr(engine, "time", SimpleNamespace(monotonic=lambda: clock[0]))
    monkeypatch.setattr(engine, "cores", lambda: 2)
    told = []
    run = _Run(len, lambda job, piece: None, None, 5, told.append)
    run.at_once = 2
    assert run.left() is None
    a, b, c = (engine.Job(name, name, tuple) for name in "abc")
    run.began |= {"a": 100.0, "b": 104.0}
    clock[0] = 110.0
    run.tell(a, "computed")  # ten seconds each; b has run for six: four left, and three more by two
    assert (told[-1].done, told[-1].count, told[-1].left, told[-1].message) == (
        1,
        5,
        pytest.approx((4 + 3 * 10) / 2),
        "",
    )
    run.failed(c, "why")
    assert (told[-1].what, told[-1].message, told[-1].left) == ("failed", "why", pytest.approx((4 + 2 * 10) / 2))
    clock[0] = 120.0  # b has run longer than one does: nothing is left of it
    assert run.left() == pytest.approx(20 / 2)
    run.tell(b, "computed")
    assert run.lasted == [10.0, 16.0]
    assert run.left() == pytest.approx(2 * 13 / 2)
    run.at_once = 3  # more than there are cores, on a cluster: by the pace so far
    assert run.left() == pytest.approx(20 / 3 * 2)
    assert run.failures == {"c": "why"}


def test_few_animals_are_read_in_this_process():
    for workers, animals in ((1, 100), (4, 9)):
        with side_by_side(workers, animals) as each:
            assert each is map


def test_a_piece_carries_its_digest_and_lines_without_their_sum_are_no_entries(tmp_path):
    assert piece_digest(Path("a/key-part-abc.nc")) == "abc"
    path = tmp_path / "j.jsonl"
    assert read_journal(path) == []
    text = (
        '{"wall": "linear", "stage": "scout", "start": 0, "starts": 2, "x": [0.5], "S": 1.0, "simulations": 3, '
        '"converged": true, "message": "", "residual": [1.0], "joined": false}'
    )
    path.write_text(f"{zlib.crc32(f'j {text}'.encode()):08x} {text}\n00000000 {text}\n")
    assert [(one.wall, one.starts) for one in read_journal(path)] == [("linear", 2)]


def test_published_spreads_are_those_of_the_published_tables():
    spreads, correlation = published_spreads()
    assert [one.quantity for one in spreads] == ["mPAP", "CO", "stiffness", "R_T", "a"]
    assert np.array_equal(correlation, np.eye(5))
    table = published_table("hemodynamics").set_index("quantity")
    for one in spreads[:2]:
        row = table.loc[one.quantity]
        for place, group in enumerate(("CTL", "HPH")):
            share = float(row[f"{group} SD"]) / float(row[f"{group} mean"])
            assert one.between[place] == pytest.approx(math.sqrt(math.log(1 + share**2)))
    fitted = published_table("optimized_linear")
    for one, label in zip(spreads[2:], ("beta [mmHg]", "R_T [mmHg s/ml]", "a"), strict=True):
        for place, group in enumerate(("CTL", "HPH")):
            values = [math.log(float(v)) for v in fitted[fitted["group"] == group][label]]
            mean = sum(values) / len(values)
            sd = math.sqrt(sum((v - mean) ** 2 for v in values) / (len(values) - 1))
            assert one.between[place] == pytest.approx(sd)


@dataclass
class Planned:
    settings: StudyFile
    animals: tuple
    variables: tuple
    table: Path = Path("t.csv")
    layout: object = None


def planned(rows, columns, **design):
    animals = tuple(AnimalRow(name, group, Path("n"), (), line) for line, (name, group) in enumerate(rows, 2))
    variables = tuple(
        Variable.of(title, dict(zip([row[0] for row in rows], cells, strict=True))) for title, cells in columns.items()
    )
    return Planned(replace(StudyFile(), design=Design(**design)), animals, variables)


def test_an_animal_of_two_groups_is_told_with_its_lines():
    rows = [("a", "CTL"), ("b", "HPH"), ("c", "CTL"), ("d", "CTL"), ("e", "HPH")]
    study = planned(rows, {"mouse": ["m1", "m1", "m2", "m1", "m3"]}, subject="mouse")
    (found,) = designing.several_groups(study)
    assert str(found).startswith(
        "t.csv, line 3, column 'mouse': mouse 'm1' is in CTL (lines 2 and 5) and HPH (line 3): an animal is of one"
    )
    assert set(found.also) == {"a", "b", "d"}
    study.settings = replace(study.settings, design=Design(subject="mouse", crossover=True))
    assert designing.several_groups(study) == []


def test_words_that_vary_within_few_animals_are_told_of_those():
    rows = [(name, "CTL") for name in "abcdefg"]
    columns = {"mouse": ["1", "1", "2", "2", "3", "3", "4"], "sex": ["f", "m", "f", "f", "m", "m", "f"]}
    study = planned(rows, columns, subject="mouse", covariates=["sex"])
    (found,) = designing.subject_problems(study)
    assert str(found).startswith(
        "t.csv, line 2, column 'sex': mouse 1 has sex 'f' in line 2 and sex 'm' in line 3, where others have one word"
    )
    assert found.also == ("a", "b")
    half = planned(rows, {**columns, "sex": ["f", "m", "f", "f", "m", "m", "f"]}, subject="mouse", covariates=[])
    assert designing.subject_problems(half) == []
    several = {**columns, "sex": ["f", "m", "f", "m", "m", "m", "f"]}  # two of three: it is meant to vary
    assert designing.subject_problems(planned(rows, several, subject="mouse", covariates=["sex"])) == []


def test_animals_without_an_occasion_that_others_have_are_named():
    rows = [(name, "CTL" if name in "abcdef" else "HPH") for name in "abcdefghi"]
    columns = {
        "mouse": ["1", "1", "2", "2", "3", "4", "5", "6", "7"],
        "week": ["w1", "w2", "w1", "w2", "w1", "w1", "w1", "w1", "w1"],
    }
    study = planned(rows, columns, subject="mouse", occasion="week")
    (found,) = designing.subject_problems(study)
    assert str(found).startswith(
        "t.csv, line 6, column 'week': mouse 3, 4 have no recording at week 'w2', as others have;"
    )
    assert found.same == (7,)
    (one,) = designing.subject_problems(
        planned(rows[:5], {k: v[:5] for k, v in columns.items()}, subject="mouse", occasion="week")
    )
    assert "mouse 3 has no recording at week 'w2'" in str(one)
    few = {**columns, "week": ["w1", "w2", *["w1"] * 7]}  # one animal alone has the second
    assert designing.subject_problems(planned(rows, few, subject="mouse", occasion="week")) == []
    again = list(
        designing._odd_occasions(
            planned(
                rows[:4],
                {"mouse": ["1", "1", "1", "2"], "week": ["w1", "w1", "w2", "w1"]},
                subject="mouse",
                occasion="week",
            ),
            "mouse",
            "week",
        )
    )
    assert [str(each).partition(";")[0] for each in again] == [
        "t.csv, line 3, column 'week': mouse '1' stands at week w1 in lines 2 and 3: these recordings count as repeats "
        "of one occasion"
    ]
    once = list(
        designing._odd_occasions(
            planned(rows[:2], {"mouse": ["1", "2"], "week": ["w1", "w2"]}, subject="mouse", occasion="week"),
            "mouse",
            "week",
        )
    )
    assert [each.finding.code for each in once] == ["design.one-occasion"]
