"""The page for Python users says what works: a test runs every line of it; the results of a study are a mapping."""

import inspect
import re
import shutil
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import xarray as xr

import vasowave as vw
from vasowave.base import InputError
from vasowave.catheter import synthetic_raw_recording, table_text
from vasowave.study.animal import to_bytes
from vasowave.study.cohort import gathered, primary_comparison
from vasowave.study.folder import StudyFile
from vasowave.study.results import ResultStore, write_results
from vasowave.study.running import report_study

PAGE = Path(__file__).parents[1] / "docs" / "python.md"
ROW = re.compile(r"^\| `(?P<typed>[^`]+)` \| (?P<here>works|`[^`]+`) \|", re.MULTILINE)


@pytest.fixture(scope="module")
def study(cohort_results, tmp_path_factory):
    """Return a folder with the results of 3 + 3 animals."""
    folder = tmp_path_factory.mktemp("door") / "study"
    store, pieces = ResultStore(folder / "results"), {}
    for number, one in enumerate(cohort_results):
        pieces[one.name, one.group] = store.keep(f"{number}", to_bytes(one.to_datatree()))
    write_results(folder / "results", pieces, {}, StudyFile(groups=["CTL", "HPH"], report={"pdf": False}))
    return folder


@pytest.fixture(scope="module")
def results(study):
    return vw.read_results(study)


@pytest.fixture(scope="module")
def comparison(results):
    return results.compare("HPH")


@pytest.mark.validation
def test_every_line_of_the_page_for_python_users_runs(study, tmp_path, monkeypatch):
    import matplotlib.pyplot as plt

    monkeypatch.chdir(tmp_path)
    mouse = vw.virtual_mouse()
    vw.write_network(vw.Network(("LPA", "a", "b"), [-1, 0, 0], [0.4, 0.3, 0.3], [0.045, 0.03, 0.03]), "ctl.csv")
    raw = synthetic_raw_recording(mouse, np.random.default_rng(3), duration=6.0).raw
    Path("ctl-1.csv").write_text(table_text(raw), encoding="utf-8")
    Path("study").symlink_to(study)
    names = {"vw": vw, "np": np, "xr": xr, "cycle": mouse.resampled(64)}  # few harmonics, which a posterior costs
    rows = list(ROW.finditer(PAGE.read_text(encoding="utf-8")))
    assert len(rows) >= 48
    for row in rows:
        line = row["typed"] if row["here"] == "works" else row["here"].strip("`")
        try:
            exec(line, names)  # a line of our own page
        except Exception as error:
            raise AssertionError(f"{PAGE.name}: {line}") from error
        plt.close("all")


def test_no_public_function_takes_more_than_seven_arguments():
    functions = {name: getattr(vw, name) for name in vw.__all__ if inspect.isfunction(getattr(vw, name))}
    assert len(functions) > 15
    many = {name: len(inspect.signature(one).parameters) for name, one in functions.items()}
    assert {name: count for name, count in many.items() if count > 7} == {}


def test_results_are_a_mapping_that_reads_a_file_when_it_is_asked_for(results, study, tmp_path):
    assert len(results) == 6
    assert list(results.keys()) == list(results) == [one.animal for one in results.animals]
    assert {name: one.name for name, one in results.items()} == {name: name for name in results}
    assert [one.group for one in results.values()] == [one.group for one in results.animals]
    assert results.get("nobody") is None
    assert "nobody" not in results
    copied = vw.read_results(shutil.copytree(study, tmp_path / "copy"))
    for file in (tmp_path / "copy").rglob("*.nc"):
        file.write_bytes(b"no result")
    first = next(iter(copied))
    assert first in copied
    with pytest.raises(vw.errors.InputError):
        copied[first]
    with pytest.raises(KeyError, match="no result of 'nobody'"):
        results["nobody"]


def test_results_show_themselves_as_a_short_table_that_says_what_can_be_typed_next(results):
    title, *rows = repr(results).splitlines()
    assert title == f"Study: {results.settings.title}"
    assert [row.split()[0] for row in rows] == ["CTL", "HPH", "wall", "next"]
    assert rows[0].split("  ")[-1] == "CTL 1, CTL 2 and CTL 3"
    assert rows[2].endswith("linear, tangent")
    for typed in rows[3].partition("next")[2].strip().split(", "):
        eval(typed, {"results": results})  # what we say can be typed


def test_an_animal_shows_its_numbers_in_a_terminal_and_in_a_notebook(results):
    result = results["CTL 1"]
    head, *rows = repr(result).splitlines()
    assert head == "AnimalResult('CTL 1', CTL)"
    assert [row.split()[0] for row in rows] == ["measured", *result.laws]
    value = result.table().set_index(["law", "quantity"]).loc[("measured", "mPAP"), "value"]
    assert f"mPAP {value:.4g} mmHg" in rows[0]
    assert all(f"mPAP {value:.4g} mmHg" in text for text in (repr(result), result._repr_html_()))
    assert "RMSE" in rows[1]
    law = result.laws["linear"]
    assert repr(law).startswith(f"LawResult('linear', stiffness {float(law.quantities['stiffness']):.4g} mmHg")
    assert f"{float(result.measured.quantities['CO']):.4g}" in result.measured._repr_html_()


def test_the_table_holds_every_stored_number_with_its_interval_and_unit_once(results):
    table = results.table()
    assert list(table.columns) == ["animal", "group", "law", "quantity", "value", "low", "high", "unit"]
    assert not table.duplicated(["animal", "law", "quantity"]).any()
    assert list(table.index) == list(range(len(table)))
    one = next(iter(results.values())).table()
    assert list(one.index) == list(range(len(one)))
    rows = table.set_index(["animal", "law", "quantity"])
    counted = 0
    for name, result in results.items():
        tree = result.to_datatree()
        for law in ("measured", "linear", "tangent"):
            stored = tree[f"{law}/quantities"].data_vars
            counted += len(stored)
            for quantity, value in stored.items():
                row = rows.loc[(name, law, quantity)]
                assert row["value"] == float(value)
                assert row["unit"] == value.attrs["units"]
                assert row["low"] == pytest.approx(value.attrs.get("interval_low", np.nan), nan_ok=True)
                assert row["high"] == pytest.approx(value.attrs.get("interval_high", np.nan), nan_ok=True)
    assert counted == len(table)


@pytest.mark.validation
def test_a_comparison_is_the_one_that_the_report_shows(results, study, undrawn):
    comparison = results.compare("HPH", "CTL")
    report_study(study)
    shown = pd.read_csv(study / "report" / "tables" / "Primary.csv")
    assert shown["quantity"].tolist() == comparison.table["quantity"].tolist()
    for name in ("ratio", "low", "high", "p"):
        assert shown[name].tolist() == pytest.approx(comparison.table[name].tolist(), rel=1e-12, nan_ok=True)
    cohort = gathered([results[name] for name in results], "CTL")
    alone = primary_comparison(cohort).table()
    assert comparison.table.drop(columns="estimates").equals(alone.drop(columns="estimates"))


SAVED = {
    "waves": ("pressure", "flow", "time from the foot"), "impedance": ("modulus", "[Hz]"),
    "loops": ("pressure [mmHg]", "flow [ml/s]"), "points": ("mPAP [mmHg]", "data: p", "n = "),
}  # fmt: skip
"""Words of the figures of groups."""


def test_groups_are_saved_as_waves_loops_impedance_points_and_numbers(comparison, tmp_path):
    for figure, words in SAVED.items():
        text = comparison.save(tmp_path / f"{figure}.svg", figure).read_text("utf-8")
        assert all(word in text for word in (*words, "CTL", "HPH"))
    table = pd.read_csv(comparison.save(tmp_path / "numbers.csv"))
    assert table["ratio"].tolist() == pytest.approx(comparison.table["ratio"].tolist(), rel=1e-12)
    with pytest.raises(InputError, match=r"no figure 'wave'.*waves"):
        comparison.save(tmp_path / "x.svg", "wave")


def test_a_comparison_says_itself_draws_itself_and_can_be_turned_round(results, comparison):
    turned = results.compare("CTL", "HPH")
    both = [one.table.set_index("quantity")["ratio"] for one in (comparison, turned)]
    assert (both[0] * both[1]).to_numpy() == pytest.approx(1.0, rel=1e-9)
    assert comparison.reference == "CTL"
    said = repr(comparison)
    assert "HPH" in said
    assert f"\nAnimals: HPH {sum(one.group == 'HPH' for one in results.animals)}, CTL " in said
    assert "HPH against CTL" in comparison._repr_html_()
    words = [text.get_text() for ax in comparison.forest().figure.axes for text in ax.texts]
    assert any("mPAP" in text for text in words)


@pytest.mark.parametrize(
    ("asked", "words"),
    [
        ({"group": "HHP"}, r"no group 'HHP' to compare with CTL \(did you mean 'HPH'\?\); there are: HPH"),
        ({"group": "CTL"}, "'CTL' is the reference itself; compare one of the others with it: HPH"),
        ({"group": "HPH", "reference": "x"}, "no animal is of the reference group 'x'"),
        ({"group": "HPH", "law": "linaer"}, r"primary law 'linaer' \(did you mean 'linear'\?\)"),
        ({"group": "HPH", "laws": "linear"}, r"no setting 'laws' \(did you mean 'law'\?\)"),
    ],
)
def test_a_slip_in_a_comparison_is_named(results, asked, words):
    with pytest.raises(vw.errors.InputError, match=words):
        results.compare(**asked)
