"""The stored form of a study: one file an animal and an index that says what each must be."""

import json
from dataclasses import replace

import pytest
import xarray as xr

from made_cohort import bare_result
from vasowave.base import InputError
from vasowave.study.animal import Failure, Stage, to_bytes
from vasowave.study.cohort import gathered
from vasowave.study.folder import StudyFile
from vasowave.study.report import write_report
from vasowave.study.results import INDEX, ResultStore, read_results, write_results
from vasowave.study.results.results import _digest
from vasowave.study.running import report_study

LOST = Failure("CTL 9", "CTL", "", Stage.COMPUTING, "why", 21.5)
NAMES = ["CTL 1", "Å é", "x" * 300, "A"]


@pytest.fixture
def stored(tmp_path):
    """Return a folder with the results of a few animals, each a result of one number."""
    folder = tmp_path / "results"
    store = ResultStore(folder)
    pieces = {}
    for number, name in enumerate(NAMES):
        key = f"key{number}"
        result = bare_result(name, recording=xr.Dataset({"x": float(number)}), origin={"key": key})
        pieces[name, "CTL"] = store.keep(key, to_bytes(result.to_datatree()))
    write_results(folder, pieces, [LOST], StudyFile())
    return folder


def test_every_animal_comes_back_by_its_name_whatever_the_name(stored):
    results = read_results(stored)
    assert list(results) == NAMES
    assert [float(results[name].recording["x"]) for name in NAMES] == [0, 1, 2, 3]
    assert [results[name].name for name in NAMES] == NAMES
    assert results.failures == (LOST,)
    assert results.lost == (LOST,)
    assert len(list((stored / "animals").iterdir())) == len(NAMES)


def test_the_report_of_an_animal_that_is_not_there_names_some_that_are(stored):
    with pytest.raises(InputError, match=r"no result of 'nobody'; there are: CTL 1, Å é, x{300} and A$"):
        report_study(stored, animal="nobody")
    store, result = ResultStore(stored), bare_result().to_datatree()
    pieces = {(f"mouse {number}", "CTL"): store.keep(f"{number}", to_bytes(result)) for number in range(9)}
    write_results(stored, pieces, {}, StudyFile())
    with pytest.raises(InputError, match=r"there are: mouse 0, .*mouse 5 and 3 more$"):
        report_study(stored, animal="nobody")


def test_a_file_that_changed_or_is_gone_is_refused_and_the_others_are_read(stored):
    results = read_results(stored)
    first, second = (stored / one.file for one in results.animals[:2])
    first.write_bytes(first.read_bytes()[:-1] + b"x")
    second.unlink()
    with pytest.raises(InputError, match="damaged or changed"):
        results[NAMES[0]]
    with pytest.raises(InputError, match="there is no such file"):
        results[NAMES[1]]
    assert float(results["A"].recording["x"]) == 3


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda text: text[:-20], "damaged"),
        (lambda text: text.replace("CTL 9", "CTL 8"), "does not match its SHA-256"),
        (lambda text: text.replace("vasowave study 3", "vasowave study 4"), "of another version"),
        (lambda text: json.dumps([]), "damaged"),
    ],
)
def test_an_index_that_is_not_as_it_was_written_is_refused(stored, change, words):
    index = stored / INDEX
    index.write_text(change(index.read_text(encoding="utf-8")), encoding="utf-8")
    with pytest.raises(InputError, match=words):
        read_results(stored)


def test_results_of_the_version_before_are_refused_with_what_to_do(tmp_path):
    (tmp_path / "results.nc").write_bytes(b"")
    with pytest.raises(
        InputError, match=r"results\.nc: of an earlier version of vasowave.*run the study or the fit again"
    ):
        read_results(tmp_path)


def test_the_file_of_one_animal_in_place_of_anothers_is_refused(stored):
    index = json.loads((stored / "index.json").read_text("utf-8"))
    one, other = index["animals"][0], index["animals"][3]
    one["file"], one["sha256"] = other["file"], other["sha256"]
    index.pop("sha256")
    (stored / "index.json").write_text(json.dumps(index | {"sha256": _digest(index)}), "utf-8")
    with pytest.raises(InputError, match=r"holds the result of 'A', not of 'CTL 1'"):
        read_results(stored)["CTL 1"]


def test_an_index_that_is_nested_without_end_is_damaged(stored):
    (stored / "index.json").write_text('{"form": ' + "[" * 100_000, "utf-8")
    with pytest.raises(InputError, match=r"index\.json: damaged"):
        read_results(stored)


def test_files_of_animals_that_are_no_longer_there_go(stored):
    one = {("A", "CTL"): ResultStore(stored).find("key3")}
    write_results(stored, one, {}, StudyFile())
    assert [path.name[:2] for path in (stored / "animals").iterdir()] == ["A-"]
    assert list(read_results(stored)) == ["A"]


def test_the_group_that_the_study_names_first_is_the_reference_and_stands_first(tmp_path):
    store, pieces = ResultStore(tmp_path / "results"), {}
    for name, group in (("a", "CTL"), ("b", "HPH"), ("c", "CTL"), ("d", "HPH")):
        pieces[name, group] = store.keep(name, to_bytes(bare_result(name, group).to_datatree()))
    write_results(tmp_path / "results", pieces, {}, StudyFile(groups=["HPH", "CTL"]))
    stored = read_results(tmp_path)
    assert [one.name for one in stored.in_order()] == ["b", "d", "a", "c"]
    with pytest.raises(InputError, match="'HPH' is the reference itself"):
        stored.compare("HPH")


def test_light_results_hold_the_inlets_and_everything_else_and_what_is_shown_is_whole(cohort_results):
    light = [one.at_inlets() for one in cohort_results]
    for one, little in zip(cohort_results, light, strict=True):
        assert little.laws["linear"].simulation.nbytes < 0.1 * one.laws["linear"].simulation.nbytes
        assert little.laws["linear"].simulation.attrs == one.laws["linear"].simulation.attrs
        for quantity in ("pressure", "flow"):
            inlet = (law.laws["linear"].simulated(quantity, one.root) for law in (little, one))
            assert next(inlet).identical(next(inlet))
        assert little.laws["linear"].calibration is one.laws["linear"].calibration
        assert little.recording is one.recording
        assert little.measured is one.measured
    whole = {one.name: one for one in cohort_results}
    shown = gathered(light, full_result=whole.__getitem__).shown
    assert {group: whole[one.name] is one for group, one in shown.items()} == {"CTL": True, "HPH": True}


@pytest.mark.weekly
def test_a_report_made_in_processes_is_the_one_made_here(cohort_results, tmp_path):
    settings = StudyFile(groups=["CTL", "HPH"], report={"pdf": False})
    for workers in (1, 2):
        folder = tmp_path / str(workers)
        store, pieces = ResultStore(folder / "results"), {}
        for number in range(20):
            one = replace(cohort_results[number % len(cohort_results)], name=f"mouse {number}")
            pieces[one.name, one.group] = store.keep(f"{number}", to_bytes(one.to_datatree()))
        write_results(folder / "results", pieces, {}, settings)
        report_study(folder, workers=workers)
    here, there = (tmp_path / name / "report" / "figures" for name in ("1", "2"))
    trees = list(read_results(tmp_path / "1").in_order())
    write_report(trees, tmp_path / "whole", pdf=False, reference="CTL")
    wanted = tmp_path / "whole" / "figures"
    assert all(one.read_bytes() == (here / one.name).read_bytes() for one in wanted.iterdir())
    names = sorted(one.name for one in here.iterdir())
    assert names == sorted(one.name for one in there.iterdir())
    assert len(names) > 20
    assert all((here / name).read_bytes() == (there / name).read_bytes() for name in names)
