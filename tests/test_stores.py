"""What the program stores is read strictly: whatever stands there, it is believed only where it is what was written."""

import ast
import json
import os
import warnings
from contextlib import suppress
from dataclasses import asdict, replace
from pathlib import Path

import numpy as np
import pytest

import fuzz
from fuzzing import stores as forms
from vasowave.base import LARGEST, STORES, InputError, VasowaveError, VasowaveWarning, from_json, parsed, parsed_as
from vasowave.catheter.read.formats import RECORDINGS
from vasowave.lung.read import VOLUMES
from vasowave.pulse.calibration import NOT_KEPT, Search, calibrate
from vasowave.pulse.examples import control_network, virtual_mouse
from vasowave.pulse.inference import NOT_KEPT as SIMULATIONS_NOT_KEPT
from vasowave.pulse.inference import Simulations
from vasowave.pulse.network_formats import NETWORKS
from vasowave.study.results import Journal, read_journal
from vasowave.study.running import RECORD, read_declared

SOURCE = Path(__file__).parents[1] / "src" / "vasowave"
BRACKETS = b"[" * 60_000

READ_ELSEWHERE = {
    "study/animal/law_result.py": "findings of a result, which its reader has read",
    "study/animal/result.py": "called by the reader of `study/animal/files.py`",
    "study/animal/stored.py": "of a result that is read",
    "base/findings.py": "findings inside other stores",
    "study/animal/pipeline.py": "its own settings, in memory",
    "study/figures/rendering.py": "its own drawing, in memory",
    "lung/exchange/markups.py": "a format of others, in the fuzzer as slicer's curves",
    "pulse/network_formats/svzerod.py": "a format of others, in the fuzzer as svZeroDSolver network",
    "lung/read/files.py": "what a helper that was started here found",
    "lung/read/hdf5.py": "a format of others, in the fuzzer as hdf5",
    "lung/read/raw.py": "a format of others, in the fuzzer as npy",
    "lung/read/zarr.py": "a format of others, in the fuzzer as zarr",
    "pulse/network_formats/graphml.py": "a format of others, in the fuzzer as node-link graph",
    "base/io/named_arrays.py": "formats of others, in the fuzzer as json, columns and numpy archive",
    "base/io/apart.py": "what a helper that was started here answers",
    "base/io/answers.py": "answers in the user's own folder; tests/base/io/test_answers.py damages them",
    "base/runtime/kernels.py": "compiled functions in the user's own folder; benchmarks/faults.py damages them",
    "pulse/selection/criteria.py": "a table of the package",
    "study/results/physiology.py": "findings of a result, which its reader has read",
    "study/running/programs.py": "the index of results, before anything of it is believed",
    "workbench/server.py": "messages, see tests/workbench/test_access.py",
}


READERS = {"parsed", "parsed_as", "from_json", "recall", "np.load", "netCDF4.Dataset", "pickle.loads"}


def reads(name):
    """Whether a module reads what was written before: JSON, sealed bytes, arrays or netCDF."""
    text = (SOURCE / name).read_text(encoding="utf-8")
    if not any(one in text for one in READERS):
        return False
    return any(isinstance(one, ast.Call) and ast.unparse(one.func) in READERS for one in ast.walk(ast.parse(text)))


def test_every_reader_of_what_was_stored_is_in_the_registry():
    modules = {path.relative_to(SOURCE).as_posix() for path in SOURCE.rglob("*.py")} - {"base/stores.py"}
    registered = {one.read.__module__.replace(".", "/").removeprefix("vasowave/") + ".py" for one in STORES.values()}
    assert {name for name in modules if reads(name)} - registered == set(READ_ELSEWHERE)


def test_json_is_read_by_the_strict_reader_alone():
    texts = {path.relative_to(SOURCE).as_posix(): path.read_text(encoding="utf-8") for path in SOURCE.rglob("*.py")}
    assert [name for name, text in texts.items() if "json.load" in text] == []


def test_every_store_and_every_format_is_in_the_fuzzer():
    assert set(forms.FORMS) == set(STORES)
    known = {"table": "table, commas", "mat": "cycle mat", "svonedsolver": "svOneDSolver network",
             "first blood": "FirstBlood network", "dimensions": "two tables of a network",
             "dim_mat": "matrices of a network", "tiff": "tif", "nifti": "nii", "metaimage": "mha",
             "graphml": "GraphML", "spatial graph": "spatial graph of Amira",
             "svzerod": "svZeroDSolver network", "workbook": "recording workbook", "named arrays": "numpy archive",
             "wfdb": "wfdb header"}  # fmt: skip
    without = {
        "foreign",
        "vessels",
        "GXL",
        "network.dat",
        "DOT",
        "openBF",
        "other image",
        "centerlines",
    }  # refused by name; whatever SimpleITK reads of no format here
    names = {one.name for registry in (RECORDINGS, NETWORKS, VOLUMES) for one in registry} - without
    assert {known.get(name, name) for name in names} <= set(fuzz.FORMS)


@pytest.mark.parametrize("name", STORES)
@pytest.mark.parametrize("content", [BRACKETS, b'{"a":' * 30_000, b"", b"null", b"\xff\xfe", b'"\\ud800"', b"9" * 400])
def test_nothing_that_stands_in_a_store_is_a_foreign_error_or_believed(tmp_path, name, content):
    form = forms.FORMS[name]
    form.write(tmp_path)
    sound = form.read(tmp_path / form.opened)
    next(tmp_path.glob(form.damaged)).write_bytes(content)
    became = fuzz.outcome(form, tmp_path, sound)
    assert became != "foreign"
    assert became == "refused" or not form.exact or name in ("journal of searches", "status of a run")  # nothing there


@pytest.mark.parametrize("name", STORES)
def test_a_pipe_in_the_place_of_a_store_is_not_waited_for(tmp_path, name):
    form = forms.FORMS[name]
    form.write(tmp_path)
    file = next(tmp_path.glob(form.damaged))
    file.unlink()
    os.mkfifo(file)
    with suppress(VasowaveError):
        form.read(tmp_path / form.opened)


@pytest.mark.parametrize("text", [BRACKETS, '"\\ud800"', "9" * 5000, "[1,]", '{"a"'])
def test_the_strict_reader_refuses_what_is_too_deep_half_a_letter_or_no_json(text):
    with pytest.raises(ValueError, match=r"."):
        parsed(text)


def test_the_strict_reader_keeps_every_bit_of_a_number_and_refuses_other_types():
    numbers = np.random.default_rng(0).integers(0, 2**64, 2000, dtype=np.uint64).view(float)
    numbers = numbers[np.isfinite(numbers)]
    assert np.array_equal(parsed(json.dumps(numbers.tolist())), numbers)
    for wrong in ('["1"]', "[null]", "[true]", "1", '{"0": 1}'):
        with pytest.raises(ValueError, match="should be a valid"):
            parsed_as(list[float], wrong)


def test_a_text_that_is_longer_than_any_store_is_refused_before_it_is_read(monkeypatch):
    monkeypatch.setattr("vasowave.base.stores.LARGEST", 10)
    with pytest.raises(ValueError, match="longer than"):
        parsed("[" + "1," * 10 + "1]")
    assert LARGEST >= 1 << 28


@pytest.mark.parametrize(
    "text", ['[{"code": "x"}]', '[{"code": "fit.interrupted", "severity": "note", "text": "t", "values": 5}]',
             '[{"code": "x", "severity": "grave", "text": "t", "values": {}}]',
             '[{"code": "x", "severity": "note", "text": "t", "values": {"a": [1]}}]', "{}", "[5]"],
)  # fmt: skip
def test_findings_that_cannot_be_said_are_refused_where_they_are_read(text):
    with pytest.raises(ValueError, match=r"."):
        from_json(text)


def test_a_journal_that_lies_under_another_animals_name_counts_for_nothing(tmp_path):
    forms.FORMS["journal of searches"].write(tmp_path)
    (path,) = tmp_path.glob("*.jsonl")
    assert len(read_journal(path)) == 5
    assert read_journal(path.rename(path.with_stem("another"))) == []


@pytest.fixture(scope="module")
def fitted(tmp_path_factory):
    """A fit, and the journal of its searches."""
    path = tmp_path_factory.mktemp("journal") / "key.jsonl"
    return path, *_fit(path)


def _fit(path):
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", VasowaveWarning)
        fit = calibrate(
            control_network(), virtual_mouse(), search=Search(starts=2), ends=Journal(path).searches("linear", 2)
        )
    return fit, [one.message.finding.code for one in caught]


def planted(path, tmp_path, change):
    journal = Journal(tmp_path / path.name)
    for one in read_journal(path):
        journal.write(replace(one, **change(one)))
    return journal.path


def test_a_journal_that_is_ours_is_believed_without_a_word(fitted, tmp_path):
    path, whole, _ = fitted
    again, said = _fit(planted(path, tmp_path, lambda one: {}))
    assert said == []
    assert again.starts.equals(whole.starts)
    assert np.array_equal(again.parameters["value"], whole.parameters["value"])


@pytest.mark.parametrize(
    "change",
    [
        lambda one: {"x": [1.7 * value for value in one.x]},
        lambda one: {"x": [value + np.log(1.01) for value in one.x]},  # parameters 1 % larger
        lambda one: {"residual": [0.1 * value for value in one.residual], "S": 0.01 * one.S},
        lambda one: {"S": 1e-9},
        lambda one: {"x": one.x[:-1]},
        lambda one: {"x": [float("nan")] * len(one.x)},
        lambda one: {"S": float("inf"), "message": "the start cannot be simulated", "residual": []},
    ],
    ids=["x 1.7", "1 %", "small residual", "small S", "shorter", "nan", "no start"],
)
def test_a_planted_journal_with_right_check_sums_changes_no_number_and_is_told(fitted, tmp_path, change):
    path, whole, _ = fitted
    again, said = _fit(planted(path, tmp_path, change))
    assert said == [NOT_KEPT.code]
    assert again.starts.equals(whole.starts)
    assert np.array_equal(again.parameters["value"], whole.parameters["value"])


POINTS = np.random.default_rng(0).standard_normal((60, 3))


def test_planted_simulations_of_a_posterior_are_made_anew_and_told(tmp_path):
    path = tmp_path / "s.npz"
    Simulations(lambda points: 1.7 * points, path, "problem")(POINTS)
    with pytest.warns(VasowaveWarning, match=r"simulations .* \(60\)") as caught:
        again = Simulations(lambda points: points, path, "problem")
    assert caught[0].message.finding.code == SIMULATIONS_NOT_KEPT.code
    assert np.array_equal(again(POINTS), POINTS)
    assert again.computed == len(POINTS)
    assert Simulations(lambda points: points, path, "problem").computed == 0


def test_a_record_of_what_was_declared_carries_a_check_sum_and_one_of_an_earlier_version_is_read(tmp_path):
    forms.FORMS["record of what was declared"].write(tmp_path)
    text = (tmp_path / RECORD).read_text()
    (tmp_path / RECORD).write_text(text.replace("2026-01-02", "2026-01-01"))
    with pytest.raises(InputError, match="SHA-256"):
        read_declared(tmp_path / RECORD)
    (tmp_path / RECORD).write_text(json.dumps([asdict(one) for one in forms.DECLARED]))
    assert read_declared(tmp_path / RECORD) == forms.DECLARED
