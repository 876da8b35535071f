"""Small answers of a cohort, on the edge of each: cells, missing animals, sizes that have a power, misfits."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr

from made_cohort import bare_result
from vasowave.cohort import Variable
from vasowave.cohort.cohort import cells_of, common_level
from vasowave.cohort.declared import Declaration
from vasowave.cohort.missing import Missing, Standing
from vasowave.cohort.planning import _SIZES, _needed
from vasowave.cohort.primary import Assurance
from vasowave.cohort.votes import _cycle_error, is_lone, misfits


def animals(*names):
    return [bare_result(name) for name in names]


def test_recordings_stand_in_cells_of_group_and_level_and_of_unknown_ones_last():
    second = Variable.of("time", {"a": "before", "b": "after", "c": "before"})
    groups = {"CTL": animals("a", "b"), "HPH": animals("c", "d")}
    cells = cells_of(groups, second)
    assert {label: (cell.group, cell.level, [one.name for one in cell.results]) for label, cell in cells.items()} == {
        "CTL, before": ("CTL", "before", ["a"]), "CTL, after": ("CTL", "after", ["b"]),
        "HPH, before": ("HPH", "before", ["c"]), "HPH, time not known": ("HPH", "time not known", ["d"])}  # fmt: skip
    assert list(cells_of(groups, None)) == ["CTL", "HPH"]
    assert common_level(groups, second) == "before"
    assert common_level({"CTL": animals("b"), "HPH": animals("c")}, second) == ""
    assert common_level(groups, None) == ""


@pytest.mark.parametrize(
    ("missing", "others", "standing"),
    [
        ((30.0, 31.0), (20.0, 29.9), Standing.ABOVE),
        ((30.0, 31.0), (20.0, 30.0), Standing.HIGHER),
        ((10.0, 11.0), (11.1, 20.0), Standing.BELOW),
        ((10.0, 11.0), (11.0, 20.0), Standing.LOWER),
        ((10.0, 30.0), (15.0, 18.0, 40.0), Standing.HIGHER),
        ((10.0, 26.0), (15.0, 18.0, 40.0), Standing.LOWER),  # as high as the median is not higher
        ((30.0,), (20.0,), Standing.UNKNOWN),
        ((30.0, 31.0), (), Standing.UNKNOWN),
    ],
)
def test_where_missing_animals_stand_among_the_others(missing, others, standing):
    assert Missing("HPH", ("a", "b"), (), 5, missing, others).standing is standing


def test_the_size_that_has_a_power_lies_between_those_that_were_tried():
    powers = np.linspace(0.1, 0.9, len(_SIZES))
    steady = np.full(len(_SIZES), 0.85)
    never = np.full(len(_SIZES), 0.79)
    first, last = _SIZES[0], _SIZES[-1]
    found = _needed(np.stack([powers, steady, never], axis=1), 0.8)
    by_line = np.interp(0.8, powers, _SIZES)
    assert found[0] == np.ceil(by_line)
    assert found[1] == first
    assert np.isnan(found[2])
    assert _needed(np.stack([powers], axis=1), 0.9) == [last]
    dented = powers.copy()
    dented[-1] = 0.5  # chance: a larger study has no less power
    assert _needed(dented[:, None], float(powers[-2])) == [_SIZES[-2]]


def test_a_family_is_doubtful_above_six_percent():
    told = Assurance(0.06, 0.99, 1.0, 3)
    assert not told.doubtful
    assert replace(told, rate=0.0601).doubtful


def fitted(rmse, strained=()):
    laws = {
        name: SimpleNamespace(calibration={"RMSE": value}, overstrained=strained_by if name in strained else None)
        for name, value in rmse.items()
    }
    result = bare_result(recording=xr.Dataset({"pressure_sd": ("time", [3.0, 4.0])}))
    beats = xr.Dataset({"kept": ("beat", [1, 1, 0, 1, 1])})
    measured = replace(result.measured, quantities=xr.Dataset({"pPAP": 10.0}))
    return replace(result, laws=laws, beats=beats, measured=measured)


strained_by = SimpleNamespace(values=(("percent", 33.0),))


def test_the_error_of_a_cycle_is_the_scatter_of_its_beats_over_the_root_of_their_number():
    assert _cycle_error(fitted({})) == pytest.approx(np.sqrt(12.5 / 4))
    assert np.isnan(_cycle_error(replace(fitted({}), beats=None)))
    assert np.isnan(_cycle_error(bare_result()))


def test_a_law_misses_its_data_beyond_twice_the_best_or_a_tenth_of_the_pulse_and_the_error_of_the_cycle():
    error = np.sqrt(12.5 / 4)  # 1.77 mmHg
    rows = misfits([fitted({"a": 1.8, "b": 3.7, "c": 1.7})]).set_index("wall")
    assert rows["error"].tolist() == pytest.approx([error] * 3)
    assert rows["share"].tolist() == pytest.approx([0.18, 0.37, 0.17])
    assert rows["over best"].tolist() == pytest.approx([1.8 / 1.7, 3.7 / 1.7, 1.0])
    assert rows["missed"].tolist() == [True, True, False]  # the last leaves less than the beats scatter
    small = bare_result()
    given = replace(fitted({"a": 1.0, "b": 2.0, "c": 2.1}), recording=small.recording)
    half = replace(given, measured=replace(given.measured, quantities=xr.Dataset({"pPAP": 30.0})))
    assert misfits([half])["missed"].tolist() == [False, False, True]
    assert misfits([given])["missed"].tolist() == [False, True, True]  # a tenth of the pulse itself is none
    odd = misfits([replace(fitted({"a": 0.5, "b": 2.0}, strained=("a",)), recording=small.recording)])
    assert odd["over best"].tolist() == pytest.approx([0.25, 1.0])
    assert odd["growth"].tolist() == pytest.approx([33.0, np.nan], nan_ok=True)


@pytest.mark.parametrize(("agree", "lone"), [([1, 0, 0], True), ([1, 1, 0], False), ([1, 0], False), ([1], False)])
def test_a_start_is_lone_among_three_and_more(agree, lone):
    assert is_lone(xr.Dataset({"start_agrees": ("start", agree)})) is lone


def test_declarations_tell_what_changed_and_in_which_rows():
    rows = {"a": {"group": "CTL", "sex": "f"}, "b": {"group": "HPH"}}
    first = Declaration("1", False, {"law": "linear", "animals": rows})
    more = {"a": {"group": "CTL", "sex": "f", "age": "3"}, "b": {"group": "HPH"}}
    same = Declaration("2", False, {"law": "linear", "animals": more, "family": 1})
    assert same.changes(first) == []
    assert same.first_said(first) == ["family"]
    later = Declaration("3", True, {"law": "tangent", "animals": {"a": {"group": "HPH", "sex": "f"}, "c": {}}})
    assert later.changes(first) == ["law", "animals"]
    told = later.rows(first)
    assert (told.added, told.dropped, told.changed) == (("c",), ("b",), (("a", "group", "CTL", "HPH"),))
    silent = Declaration("0", False, {"law": "linear"})
    assert later.rows(silent) == ((), (), ())
    assert silent.changes(first) == []
