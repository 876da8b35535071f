"""A report of three wall laws, told from what the results say of them; and of results that say less."""

import re
from copy import deepcopy
from pathlib import Path

import pandas as pd
import pytest

import vasowave
from made_cohort import made_results
from vasowave.study.cohort import compare, gathered, primary_comparison
from vasowave.study.figures import new_figure, plot_pressure_area
from vasowave.study.report import write_report
from vasowave.study.report.sections import methods_section

ROOMS = ("study/cohort", "study/figures", "study/report")


@pytest.fixture(scope="module")
def results():
    return made_results({"CTL": 2, "HPH": 2}, walls=("linear", "tangent", "power"))


@pytest.mark.validation
def test_a_third_law_has_its_words_values_and_lines(results, tmp_path):
    page = write_report(results[:1], tmp_path / "three", pdf=False).with_name("supplement.html")
    assert "the power wall law (p = β/(2m) ((A/A₀)^m − 1))" in page.read_text(encoding="utf-8")
    table = pd.read_csv(page.parent / "tables" / "Parameters-power.csv")
    assert [label.split(" [")[0] for label in table.columns[2:6]] == ["beta", "m", "stiffness", "wave_speed"]
    assert table["m [1]"].tolist() == [float(results[0].laws["power"].quantities["m"])]
    drawn = (page.parent / "figures" / "fit-1.svg").read_text(encoding="utf-8")
    assert len(set(re.findall(r"stroke-dasharray: ([^;\"]+)", drawn))) == 2
    assert "power wall" in drawn


def test_every_law_is_compared_by_the_stiffness_that_it_names(results):
    cohort = gathered(results)
    first = {wall: compare(cohort, wall).contrasts["quantity"].iloc[0] for wall in cohort.walls}
    assert first == {"linear": "beta [mmHg]", "tangent": "p1_over_gamma [mmHg]", "power": "stiffness [mmHg]"}


def test_trees_that_say_nothing_of_their_laws_are_told_drawn_and_compared_all_the_same(results):
    silent = [deepcopy(result) for result in results]
    for result in silent:
        for wall in ("linear", "tangent", "power"):
            for key in ("title", "formula", "equation", "stiffness"):
                del result.laws[wall].calibration.attrs[key]
            for name in ("law_pressure", "law_area"):
                del result.laws[wall].vessels[name]
    cohort = gathered(silent)
    model = methods_section(cohort, primary_comparison(cohort), {}).blocks[1].text
    assert "the linear wall law, the tangent wall law and the power wall law" in model
    assert compare(cohort, "tangent").contrasts["quantity"].iloc[0] == "stiffness [mmHg]"
    assert len(plot_pressure_area(new_figure(8, 8).subplots(), silent[0]).get_lines()) == 3 + 1


def test_no_room_of_the_report_knows_a_wall_law_by_name():
    for room in ROOMS:
        for path in (Path(vasowave.__file__).parent / room).rglob("*.py"):
            named = re.findall(r"[\"'](?:linear|tangent|power)[\"']", path.read_text(encoding="utf-8"))
            assert not named or path.name == "matplotlib_style.py", f"{path}: {named}"
