"""A report of animals that were recorded before and after: what it describes, whom it shows, whom it counts."""

import numpy as np
import pytest

from made_cohort import crossed_cohort, made_results
from vasowave.cohort import gathered
from vasowave.cohort.group_means import group_means
from vasowave.figures.style import style
from vasowave.report.answer.decay import decay
from vasowave.report.tables import data, groups, models

CELLS = ["Kontrolle Süd, vor", "Kontrolle Süd, nach", "Hypoxie Öst, vor", "Hypoxie Öst, nach"]


@pytest.fixture(scope="module")
def cohort():
    return crossed_cohort()


def pressures(cohort, group, level):
    return [float(one.measured.quantities["mPAP"]) for one in cohort.results
            if one.group == group and one.name.endswith(level)]  # fmt: skip


def test_before_and_after_are_described_apart(cohort):
    table = data.hemodynamics(cohort)
    assert list(table.header[1:]) == [f"{cell} (n = 3)" for cell in CELLS]
    rows = table.data[table.data["quantity"] == "mPAP [mmHg]"].set_index("group")
    for cell in CELLS:
        own = pressures(cohort, *cell.split(", "))
        assert rows.loc[cell, ["mean", "SD", "n"]].tolist() == pytest.approx([np.mean(own), np.std(own, ddof=1), 3])


def test_every_quantity_and_wave_has_a_row_for_each_group_and_occasion(cohort):
    described, waves = groups.groups(cohort), models.waves(cohort)
    assert described.header[2:4] == ("group, time", "n")
    assert [row[2:4] for row in described.rows[:4]] == [(cell, "3") for cell in CELLS]
    assert {row[2] for row in waves.rows} == set(CELLS)


def test_a_mean_beside_points_is_that_of_its_occasion(cohort):
    means = group_means(cohort, "measured", "mPAP")
    assert list(means) == CELLS
    own = pressures(cohort, "Hypoxie Öst", "nach")
    assert means["Hypoxie Öst, nach"].value == pytest.approx(np.exp(np.log(own).mean()), rel=1e-6)


def test_the_measured_decay_is_said_of_each_occasion(cohort):
    said = decay(cohort, "linear")
    assert all(f"s in {group} ({level})" in said for group, level in (cell.split(", ") for cell in CELLS))


def test_groups_without_a_second_column_are_described_as_they_were():
    plain = gathered(made_results({"CTL": 2, "HPH": 2}, walls=()))
    assert list(data.hemodynamics(plain).header[1:]) == ["CTL (n = 2)", "HPH (n = 2)"]
    assert not plain.crossed
    assert plain.described["group"].tolist() == plain.table["group"].tolist()


def test_animals_are_shown_at_the_same_occasion_in_every_group(cohort):
    assert [one.name[-3:] for one in cohort.shown.values()] == ["vor", "vor"]
    assert cohort.name("Hypoxie Öst").endswith("(Hypoxie Öst, time vor)")
    turned = crossed_cohort(levels=("nach", "vor"))
    assert [one.name.split()[-1] for one in turned.shown.values()] == ["nach", "nach"]


def test_a_line_joins_the_recordings_of_one_animal(cohort):
    from vasowave.figures.compared import means_figure

    with style():
        figure = means_figure(cohort, {"R_T [mmHg s/ml]": "R_T [mmHg s/ml]"}, ["linear"], {})
    (ax,) = figure.axes
    joined = [line for line in ax.get_lines() if len(line.get_xdata()) == 2 and line.get_alpha() == 0.6]
    table = cohort.table[cohort.table["source"] == "linear"].set_index("animal")["R_T [mmHg s/ml]"]
    ends = {tuple(np.round(line.get_ydata(), 6)) for line in joined}
    mice = dict.fromkeys(cohort.subjects.values())
    assert ends == {(round(table[f"{mouse} vor"], 6), round(table[f"{mouse} nach"], 6)) for mouse in mice}
    assert [tick.get_text() for tick in ax.get_xticklabels()] == ["vor", "nach", "vor", "nach"]
