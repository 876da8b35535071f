"""The ground that everything stands on: units, findings, settings, hints, species, locks and threads, on each edge."""

import errno
import gc
import json
import os
import warnings
from dataclasses import field
from pathlib import Path
from types import SimpleNamespace
from typing import Annotated, Literal

import numpy as np
import pytest
from annotated_types import Ge

from vasowave import descriptions, findings, quantities, units
from vasowave.errors import InputError, did_you_mean, of_file
from vasowave.findings import Finding, Place, Severity, as_json, from_json, shared, texts
from vasowave.notebook import card
from vasowave.provenance import provenance
from vasowave.runtime import kernels, memory, threads
from vasowave.runtime.kept import program
from vasowave.runtime.writing import put
from vasowave.settings import Example, Positive, Range, given_values, is_true, read_values, settings_class, settings_of
from vasowave.species import SPECIES

LENGTHS = {"cm": 1.0, "mm": 0.1, "um": 1e-4, "µm": 1e-4, "m": 100.0}
FACTORS = {
    "pressure": {"mbar": 0.7500638, "hPa": 0.7500638, "torr": 1.0, "mm Hg": 1.0},
    "flow": {"mm3/s": 1e-3, "l/s": 1e3, "l/min": 1000 / 60, "m3/s": 1e6},
    "length": LENGTHS,
    "slope": {"cm/cm": 1.0, "mm/mm": 1.0, "um/um": 1.0, "1": 1.0, "um/mm": 1e-3, "%": 0.01},
    "velocity": {"cm/s": 1.0, "mm/s": 0.1, "m/s": 100.0},
    "area": {"cm2": 1.0, "mm²": 0.01, "um2": 1e-8, "m2": 1e4},
    "time": {"min": 60.0, "us": 1e-6, "msec": 1e-3},
    "voltage": {"V": 1e3, "uV": 1e-3},
}


@pytest.mark.parametrize(("quantity", "unit"), [(one, unit) for one, known in FACTORS.items() for unit in known])
def test_units_are_what_they_are_in_cm_s_ml_and_mmhg(quantity, unit):
    assert units.factor(unit, quantity) == pytest.approx(FACTORS[quantity][unit], rel=1e-6)
    assert units.is_of(unit, quantity)
    assert units.is_unit(unit)


def test_one_mmhg_is_the_pressure_of_a_millimeter_of_mercury_and_what_is_no_unit_is_none():
    assert units.MMHG == pytest.approx(0.1 * 13.5951 * 980.665, rel=1e-4)
    assert units.ratios("diameter") == units.ratios("length")
    assert not units.is_of("", "slope")
    assert not units.is_of("mmHg", "flow")
    assert not units.is_unit("furlong")
    assert units.CANONICAL == {
        "pressure": "mmHg", "flow": "ml/s", "length": "cm", "time": "s", "slope": "cm/cm", "velocity": "cm/s",
        "area": "cm2", "voltage": "mV",
    }  # fmt: skip


def test_the_nearest_word_is_meant_where_six_tenths_of_it_agree():
    assert did_you_mean("LINAER", ["Linear", "tangent"]) == " (did you mean 'Linear'?)"
    assert did_you_mean("abcde", ["abcxy"]) == " (did you mean 'abcxy'?)"  # six letters of ten
    assert did_you_mean("abcdef", ["abcxyz"]) == ""
    with pytest.raises(InputError, match=r"^f.csv: wrong$"), of_file("f.csv"):
        raise InputError("wrong")


RANGES = {
    "mouse": ((250, 900), (300, 800), (7, 45), (4, 50), (0.05, 0.45), (0.02, 0.6), (0.02, 0.08)),
    "rat": ((150, 650), (200, 550), (8, 70), (5, 80), (0.4, 4), (0.02, 0.6), (0.05, 0.25)),
    "rabbit": ((80, 400), (110, 360), (7, 50), (3, 55), (1.5, 25), (0.03, 1.2), (0.12, 0.6)),
    "dog": ((30, 260), (40, 240), (7, 70), (4, 80), (8, 180), (0.05, 2.5), (0.35, 1.7)),
    "pig": ((35, 240), (45, 220), (8, 75), (4, 80), (10, 220), (0.05, 2.5), (0.4, 2.0)),
    "human": ((30, 200), (35, 180), (7, 100), (4, 120), (25, 300), (0.05, 2.5), (0.3, 2.5)),
}


@pytest.mark.parametrize("name", RANGES)
def test_ranges_of_species_are_those_of_the_documentation_and_grow_with_the_animal(name):
    one = SPECIES[name]
    assert (one.heart_rates, one.HR, one.mPAP, one.pPAP, one.CO, one.tau, one.root_radius) == RANGES[name]
    assert one.heart_rates[0] <= one.HR[0] < one.HR[1] <= one.heart_rates[1]


def test_a_parameter_scales_with_the_nominal_wall_where_it_is_a_pressure():
    def parameter(unit, paper=None):
        return descriptions.Parameter(unit, "s", "m", "e", 1.0, (0.5, 2.0), paper)

    assert [parameter(unit).scale(60.0) for unit in ("mmHg", "mmHg s", "1", "s")] == [60.0, 60.0, 1.0, 1.0]
    assert parameter("1", (0.1, 9.0)).limits(True) == (0.1, 9.0)
    assert parameter("1", (0.1, 9.0)).limits(False) == (0.5, 2.0)
    assert parameter("1").limits(True) == (0.5, 2.0)
    assert descriptions.TAILS == (0.025, 0.5, 0.975)
    assert pytest.approx(1.959964, abs=1e-6) == descriptions.NORMAL


class Beds:
    def __init__(self, ratio, compliance):
        self.ratio, self.compliance = ratio, compliance

    def resistance_ratio(self):
        return self.ratio

    def weighted_compliance(self):
        return np.array(self.compliance)


@pytest.mark.parametrize(
    ("ratio", "compliance", "absent"),
    [
        (0.3, [0.0, 1e-9], set()), (0, [1.0], {"a"}), (1, [1.0], {"a"}),
        (0.3, [0.0], {"C_p", "C_p_over_C_T", "C_p_over_C_T_plain"}),
        (1, [0.0], {"a", "C_p", "C_p_over_C_T", "C_p_over_C_T_plain"}),
    ],
)  # fmt: skip
def test_beds_without_a_division_or_a_compliance_lack_its_numbers(ratio, compliance, absent):
    assert quantities.lacking(Beds(ratio, compliance)) == absent
    assert quantities.question_of("R_T") == "Small vessels"
    assert quantities.question_of("nothing") == "nothing"


@pytest.fixture
def kind(monkeypatch):
    monkeypatch.setattr(findings, "KINDS", dict(findings.KINDS))
    return findings.look_kind("room.odd", "{animal}'s {name} is {value:g}; {remedy}", "mend it")


def test_a_place_is_written_with_what_is_known_of_it():
    assert str(Place("f", 3, "column 'x'", "m")) == "f, line 3, column 'x' ('m')"
    assert str(Place("f", 0, "header")) == "f, header"
    assert str(Place()) == ""


def test_a_finding_shows_eighty_letters_of_itself(kind):
    short, long = (kind(name="n" * count, value=1).at(animal="m") for count in (62, 63))
    assert len(str(short)) == 80
    assert repr(short) == f"Finding(room.odd: {short})"
    assert repr(long) == f"Finding(room.odd: {str(long)[:80]}...)"
    assert (short.room, short.severity) == ("room", Severity.LOOK)


def test_what_all_laws_say_is_said_once_and_the_rest_by_its_law(kind):
    one, two, three = (kind(name=name, value=1) for name in "abc")
    found = shared({"linear": [one, two], "tangent": [two, three]})
    assert [(dict(each.values)["name"], each.place.law) for each in found] == [
        ("b", ""),
        ("a", "linear"),
        ("c", "tangent"),
    ]
    alone = shared({"linear": [one]})
    assert [each.place.law for each in alone] == ["linear"]
    assert shared({}) == []
    assert texts(found)[1] == "linear wall: 's a is 1; mend it"
    drawn = Finding("posterior.x").at(law="linear")
    findings.KINDS["posterior.x"] = findings.Kind("posterior.x", Severity.LOOK, "odd")
    assert texts([drawn]) == ["linear wall, posterior: odd"]
    back = from_json(as_json(found))
    assert back == tuple(found)
    assert json.loads(as_json(found))[1]["law"] == "linear"
    assert "law" not in json.loads(as_json(found))[0]


def test_a_warning_says_its_place_where_it_has_one_and_points_to_who_called(kind):
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        findings.warn(kind(name="a", value=1).at("f.csv", line=2), stacklevel=1)
        findings.warn(kind(name="b", value=1), stacklevel=1)
        warnings.warn("another", stacklevel=1)
    assert str(caught[0].message) == "f.csv, line 2: 's a is 1; mend it"
    assert str(caught[1].message) == "'s b is 1; mend it"
    assert {Path(one.filename).name for one in caught} == {Path(__file__).name}
    assert [one.code for one in findings.found_in(caught)] == ["room.odd", "room.odd"]


@settings_class
class Inner:
    """What stands within."""

    size: Annotated[float, Ge(0)] = 1.5
    """How large."""

    kind: Literal["plain", "odd"] = "plain"
    """Which kind."""


@settings_class
class Outer:
    """Settings of all."""

    count: Annotated[int, Ge(1), Example(7)] = 3
    """How many."""

    span: Range = (1.0, 2.0)
    share: Positive = 0.5
    on: bool = True
    names: tuple[str, ...] = ()
    by: dict[str, float] = field(default_factory=dict)
    inner: Inner = field(default_factory=Inner)


@pytest.mark.parametrize(
    ("values", "said"),
    [
        ({"count": 0}, "count: 0 is too small; at least 1"), ({"count": "x"}, "count: 'x' is not a whole number"),
        ({"count": 1.5}, "count: 1.5 is not a whole number"),
        ({"share": "1,5"}, "share: '1,5' is not a number; write a decimal point"),
        ({"share": "x"}, "share: 'x' is not a number"),
        ({"on": "maybe"}, "on: 'maybe' is neither true nor false"), ({"span": [2, 1]}, "span: 2 is not below 1"),
        ({"span": [1, 2, 3]}, "span: write a list of two numbers"),
        ({"span": [1]}, "span.1: write a list of two numbers"),
        ({"span": 3}, "span: write a list: [one, other]"), ({"names": 3}, "names: write a list"),
        ({"by": 3}, "by: write 'name: value'"),
        ({"inner": 3}, "inner: write its keys in indented lines"),
        ({"share": None}, "share: the value is empty; give one"),
        ({"inner": {"kind": "od"}}, "inner.kind: 'od' is not known (did you mean 'odd'?); choose from: plain, odd"),
        ({"inner": {"kind": None}}, "inner.kind: the value is empty; choose from: plain, odd"),
        ({"cuont": 1}, "unknown key 'cuont' (did you mean 'count'?); known here: count, span"),
        ({"size": 1}, "unknown key 'size' here; it belongs under 'inner:'; known"),
        ({"inner": {"share": 1}}, "unknown key 'share' here; it belongs to the top level, without indentation"),
    ],
)  # fmt: skip
def test_a_wrong_setting_is_told_by_its_key_and_what_to_write(values, said):
    found = read_values(Outer, values)
    assert str(found[0][2]).startswith(said)


def test_settings_are_taken_by_name_from_each_other_and_know_their_meaning():
    assert given_values(Outer, None, {"count": 5}).count == 5
    assert given_values(Outer, Outer(count=4), {"share": 0.25}) == Outer(count=4, share=0.25)
    with pytest.raises(InputError, match="3 is no Outer; give its settings by name: count, span"):
        given_values(Outer, 3, {})
    with pytest.raises(
        InputError, match=r"there is no setting 'cont' \(did you mean 'count'\?\); choose from: count, span"
    ):
        Outer(cont=1)
    known = settings_of(Outer)
    assert (known["count"].meaning, known["count"].example, known["count"].default) == ("How many.", 7, 3)
    assert known["inner"].section is Inner
    assert known["count"].section is None
    assert (known["by"].default, known["share"].example) == ({}, None)
    assert [is_true(one) for one in ("yes", True, "no", "x", 1, None)] == [True, True, False, False, True, False]


def test_a_card_of_a_notebook_escapes_its_words():
    assert card("a & b", {"x": "<1>"}, ["n<"]) == (
        "<div><strong>a &amp; b</strong><table><tr><td style=\"text-align:left\">x</td><td "
        "style=\"text-align:left\">&lt;1&gt;"
        "</td></tr></table><ul><li>n&lt;</li></ul></div>"
    )  # fmt: skip
    assert "<ul>" not in card("a", {})


def test_provenance_says_versions_and_files(tmp_path):
    (tmp_path / "x.csv").write_text("a")
    found = provenance([tmp_path / "x.csv"])
    assert found["sha256 of x.csv"].startswith("ca978112ca1bbdca")
    assert {"created", "python", "vasowave", "numpy"} <= set(found)


@pytest.mark.parametrize(("text", "count"), [("3", 3), ("0", 8), ("", 8), ("x", 8), ("-1", 8), ("1", 1)])
def test_threads_are_as_many_as_are_asked_for_or_cores(monkeypatch, text, count):
    monkeypatch.setattr(threads, "cores", lambda: 8)
    monkeypatch.setenv(threads.VARIABLE, text)
    assert threads.threads() == count


def test_cores_are_those_that_this_process_may_use(monkeypatch):
    monkeypatch.setattr(os, "sched_getaffinity", lambda process: {0, 2, 5} if process == 0 else set(), raising=False)
    assert threads.cores() == 3
    monkeypatch.delattr(os, "sched_getaffinity")
    for known, count in ((6, 6), (None, 1)):
        monkeypatch.setattr(os, "cpu_count", lambda known=known: known)
        assert threads.cores() == count
    for name in (*threads._LIBRARIES, threads.VARIABLE):
        monkeypatch.setenv(name, "to be put back")
        monkeypatch.delenv(name)
    monkeypatch.setenv("OMP_NUM_THREADS", "4")
    threads.spare_threads()
    assert [os.environ[name] for name in threads._LIBRARIES] == ["4", "1", "1", "1"]
    threads.limit_threads(3)
    assert [os.environ[name] for name in threads._LIBRARIES] == ["1", "1", "1", "1"]
    assert os.environ[threads.VARIABLE] == "3"


def test_a_lack_of_memory_is_known_by_its_kind_its_words_and_what_caused_it():
    def caused(error, cause):
        error.__cause__ = cause
        return error

    assert memory.is_starved(MemoryError())
    assert memory.is_starved(OSError(errno.ENOMEM, "x"))
    assert not memory.is_starved(OSError(errno.ENOSPC, "x"))
    assert not memory.is_starved(ValueError("x"))
    assert memory.is_starved(ValueError("Can't start new thread"))
    assert memory.is_starved(caused(ValueError("x"), MemoryError()))
    assert not memory.is_starved(None)
    before = gc.get_threshold()
    with memory.seldom_collected():
        assert gc.get_threshold() == (70 * before[0], *before[1:])
    assert gc.get_threshold() == before


def test_a_clock_counts_what_lies_within_once(monkeypatch):
    now = [10.0]
    monkeypatch.setattr(kernels, "time", SimpleNamespace(monotonic=lambda: now[0]))
    one = kernels._Clock()
    one.start()
    now[0] = 12.0
    one.start()
    now[0] = 13.0
    one.stop()
    assert one.seconds == 0.0
    now[0] = 15.0
    one.stop()
    one.start()
    now[0] = 15.5
    one.stop()
    assert one.seconds == 5.5


def test_kernels_that_were_not_used_for_a_month_go(tmp_path, monkeypatch):
    for name, age in (("kernels-old", 30.001), ("kernels-new", 29.999), ("other", 99.0)):
        (tmp_path / name).mkdir()
        os.utime(tmp_path / name, (0, 1e9 - age * 86400))
    monkeypatch.setattr(kernels, "time", SimpleNamespace(time=lambda: 1e9))
    kernels._tidy(tmp_path)
    assert sorted(one.name for one in tmp_path.iterdir()) == ["kernels-new", "other"]


def test_kernels_are_kept_where_the_system_keeps_such_things(monkeypatch, tmp_path):
    def places(system, **variables):
        monkeypatch.setattr(kernels.platform, "system", lambda: system)
        monkeypatch.setattr(kernels.numba, "config", SimpleNamespace())
        for name in ("LOCALAPPDATA", "XDG_CACHE_HOME"):
            monkeypatch.setenv(name, variables.get(name, ""))
        monkeypatch.setenv("HOME", str(tmp_path))
        return [str(one.relative_to(tmp_path)) for one in kernels._places()]

    assert places("Linux") == [".cache/vasowave"]
    assert places("Linux", XDG_CACHE_HOME=str(tmp_path / "x"), LOCALAPPDATA=str(tmp_path / "y")) == ["x/vasowave"]
    assert places("Darwin") == ["Library/Caches/vasowave"]
    assert places("Windows") == ["AppData/Local/vasowave"]
    assert places("Windows", LOCALAPPDATA=str(tmp_path / "y")) == ["y/vasowave"]
    assert places("Linux", XDG_CACHE_HOME="relative") == []


def test_a_lock_that_another_holds_is_waited_for_as_long_as_patience_lasts(monkeypatch, tmp_path):
    now, asked = [0.0], []

    def lock(number):
        asked.append(number)
        if len(asked) < taken:
            raise BlockingIOError

    monkeypatch.setattr(kernels, "lock_open_file", lock)
    monkeypatch.setattr(
        kernels, "time", SimpleNamespace(monotonic=lambda: now[0], sleep=lambda s: now.__setitem__(0, now[0] + s))
    )
    taken = 5
    with kernels._waited_for(tmp_path / "a.lock") as held:
        assert not held.closed
    assert (len(asked), now[0]) == (5, pytest.approx(0.4))
    taken, now[0] = 10**6, 0.0
    assert kernels._waited_for(tmp_path / "a.lock") is None
    assert 300 <= now[0] < 301
    monkeypatch.setattr(kernels, "lock_open_file", lambda number: (_ for _ in ()).throw(OSError()))
    assert kernels._waited_for(tmp_path / "a.lock") is None
    assert kernels._waited_for(tmp_path / "none" / "a.lock") is None


def test_what_is_put_has_its_mode_and_a_part_of_the_program_its_own_digest(tmp_path):
    put(tmp_path / "x", [b"ab", np.array([99], np.uint8)], 0o600)
    assert (tmp_path / "x").read_bytes() == b"abc"
    assert (tmp_path / "x").stat().st_mode & 0o777 == 0o600
    put(tmp_path / "y", [b""], 0o644)
    assert (tmp_path / "y").stat().st_mode & 0o777 == 0o644
    assert [one.name for one in sorted(tmp_path.iterdir())] == ["x", "y"]
    assert program("runtime") != program("runtime", ("kept.py",))
