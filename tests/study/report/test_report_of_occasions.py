"""A report of animals that were recorded before and after: what it describes, whom it shows, whom it counts."""

import html
import json
import re
from dataclasses import replace

import numpy as np
import pytest
from scipy import stats

from approval import approve, artists
from made_cohort import crossed_cohort
from vasowave.study.cohort import Family, attribution_table, gathered, group_means, primary_comparison
from vasowave.study.figures import hemodynamics_figure, means_figure, style, waveforms_figure
from vasowave.study.report import caller, number, page, report_of
from vasowave.study.report.answer import (
    animals_of,
    attribution_answer,
    attribution_summary,
    change_table,
    decay,
    design_text,
    group_answer,
    group_rows,
)
from vasowave.study.report.sections import data, methods_section, primary_tables
from vasowave.study.results import attributed

FOUR = {"mPAP [mmHg]": "pressure [mmHg]", "CO [ml/s]": "flow [ml/s]", "R_T [mmHg s/ml]": "R_T [mmHg s/ml]"}
CELLS = ["Kontrolle Süd, vor", "Kontrolle Süd, nach", "Hypoxie Öst, vor", "Hypoxie Öst, nach"]


@pytest.fixture(scope="module")
def cohort():
    return attributed(crossed_cohort())


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


@pytest.mark.parametrize("levels", [("vor", "nach"), ("nach", "vor")])
def test_a_mean_stands_below_its_group_and_occasion_whichever_rows_come_first(levels):
    turned = crossed_cohort(levels=levels)
    for table in (data.hemodynamics(turned), *data.animals_table(turned)):
        (row,) = (row for row in table.rows if row[0].startswith("mPAP"))
        for cell, text in zip(table.header[1:], row[1:], strict=True):
            own = pressures(turned, *cell.partition(" (")[0].split(", "))
            assert float(text.split(" ± ")[0]) == pytest.approx(np.mean(own), rel=0.01), cell


def test_a_page_says_at_its_means_whether_the_design_made_them_and_gives_the_output_a_minute_too(cohort, text):
    assert "Measured, means by the design: mean pressure" in re.sub("<[^>]*>", "", text)
    (animals,) = data.animals_table(cohort)
    assert "Arithmetic means as measured; the answer compares geometric means by the design" in animals.note
    assert "PVR: mean pressure above 0 mmHg, assumed" in animals.note
    (output,) = (row[1:] for row in animals.rows if row[0] == "CO [ml/s]")
    for cell in output:
        second, minute = (float(text.split(" ± ")[0]) for text in cell.removesuffix(" ml/min)").split(" ("))
        assert minute == pytest.approx(60 * second, rel=0.01)


def test_a_resistance_above_wedge_pressures_says_which_they_were(cohort):
    wedged = [replace(result, recording=result.recording.assign(wedge_pressure=6.0 + place))
              for place, result in enumerate(cohort.results)]  # fmt: skip
    assert data.outflow(gathered(wedged)) == (
        f"PVR: mean pressure above the wedge pressure (6.00 to {number(5.0 + len(wedged))} mmHg) over mean flow."
    )
    assert f"; in 1 of {len(wedged)} recordings over 0 mmHg" in data.outflow(gathered([cohort.results[0], *wedged[1:]]))


def test_a_mean_beside_points_is_that_of_its_occasion(cohort):
    means = group_means(cohort, "measured", "mPAP")
    assert list(means) == CELLS
    own = pressures(cohort, "Hypoxie Öst", "nach")
    assert means["Hypoxie Öst, nach"].value == pytest.approx(np.exp(np.log(own).mean()), rel=1e-6)


def test_the_measured_decay_is_said_of_each_occasion(cohort):
    said = decay(cohort, "linear")
    assert all(f"s in {group} ({level})" in said for group, level in (cell.split(", ") for cell in CELLS))


def test_animals_are_shown_at_the_same_occasion_in_every_group(cohort, primary):
    assert [one.name[-3:] for one in cohort.shown.values()] == ["vor", "vor"]
    assert cohort.name("Hypoxie Öst").endswith("(Hypoxie Öst, time vor)")
    turned = crossed_cohort(levels=("nach", "vor"))  # 'vor' came first, wherever it stands
    assert [one.name.split()[-1] for one in turned.shown.values()] == ["vor", "vor"]
    other = crossed_cohort(levels=("zweite", "erste"))  # of other words the table's first
    assert [one.name.split()[-1] for one in other.shown.values()] == ["zweite", "zweite"]
    impedance = {one.name: one.caption for one in report_of(cohort, primary, Family()).drawings()}["Impedance"]
    assert impedance.endswith("Drawn are the recordings at time vor.")


def test_a_line_joins_the_recordings_of_one_animal(cohort):
    with style():
        figure = means_figure(cohort, {"R_T [mmHg s/ml]": "R_T [mmHg s/ml]"}, ["linear"], {})
    (ax,) = figure.axes
    joined = [line for line in ax.get_lines() if len(line.get_xdata()) == 2 and line.get_alpha() == 0.6]
    table = cohort.table[cohort.table["source"] == "linear"].set_index("animal")["R_T [mmHg s/ml]"]
    ends = {tuple(np.round(line.get_ydata(), 6)) for line in joined}
    mice = dict.fromkeys(cohort.subjects.values())
    assert ends == {(round(table[f"{mouse} vor"], 6), round(table[f"{mouse} nach"], 6)) for mouse in mice}
    assert [tick.get_text() for tick in ax.get_xticklabels()] == ["vor", "nach", "vor", "nach"]


def test_approved_the_figures_of_animals_before_and_after(cohort):
    with style():
        drawn = (waveforms_figure(cohort), hemodynamics_figure(cohort), means_figure(cohort, FOUR, ["measured"], {}))
        approve("occasions, figures", (line for one in drawn for line in artists(one)))


@pytest.fixture(scope="module")
def primary(cohort):
    return primary_comparison(cohort)


def rows_of(primary, quantity):
    return primary.table().set_index(["quantity", "what"]).loc[quantity]


def test_the_animal_left_out_is_left_out_whole(cohort, primary):
    """The model without a mouse and with the same variances: by dense algebra that knows nothing of the program's."""
    from vasowave.study.cohort import known_values, modeled

    row = rows_of(primary, "mPAP").loc["groups"]
    one = modeled(cohort, known_values(cohort, "measured", "mPAP", list(cohort.groups)))
    contrast = next(each for each in one.contrasts if each.label.kind == "groups")
    weights = np.linalg.inv(one.fit.root @ one.fit.root.T)
    moved = {}
    for mouse in dict.fromkeys(cohort.subjects.values()):
        out = [place for place, name in enumerate(one.layout.animals) if cohort.subjects[name] == mouse]
        assert len(out) == 2
        marked = np.zeros((len(one.layout.animals), 2))  # a mean of its own for each recording takes both out
        marked[out, [0, 1]] = 1.0
        fixed = np.hstack([one.layout.fixed, marked])
        found = np.linalg.solve(fixed.T @ weights @ fixed, fixed.T @ weights @ one.values.estimates.logs)
        moved[mouse] = float(one.weights(contrast) @ found[: one.layout.fixed.shape[1]])
    farthest = max(moved, key=lambda mouse: abs(moved[mouse] - np.log(row["ratio"])))
    assert row["without"] == farthest
    assert np.log(row["ratio without"]) == pytest.approx(moved[farthest], rel=1e-9)


def test_the_primary_table_counts_animals_and_says_which_stand_on_both_sides(cohort, primary):
    table = primary_tables(primary, {})[0]
    counts = {effect.contrast.kind: row[3] for effect, row in zip(primary.effects, table.rows, strict=True)}
    assert counts == {"groups": "3, 3", "factor": "6, each at both", "interaction": "3, 3"}
    assert "one animal, with all its recordings" in table.note


@pytest.fixture(scope="module")
def text(cohort, primary):
    with style():
        return page(report_of(cohort, primary, Family()), {})


def test_the_page_marks_animals_and_counts_recordings(cohort, text):
    assert "All 12 recordings were made by a model" in text
    assert re.findall(r'data-pick="([^"]*)"', text) == ["Süd 1", "Süd 2", "Süd 3", "Öst 1", "Öst 2", "Öst 3"]
    (known,) = re.findall(r"data-animals='([^']*)'", text)
    assert json.loads(html.unescape(known)) == cohort.subjects


def test_a_page_of_animals_recorded_once_names_no_recordings(cohort_answer):
    assert "data-animals=" not in cohort_answer
    assert "All 6 animals were made by a model" in cohort_answer


def test_levels_of_a_block_are_named_as_levels(cohort):
    blocked = replace(cohort, design=replace(cohort.design, blocks=("litter",)))
    assert "animals of one litter (of 3: B, C and D) may be alike" in design_text(blocked)


def test_a_contrast_of_ones_own_is_defined_where_it_is_named(cohort):
    weights = {"Hypoxie Öst, vor": -1, "Hypoxie Öst, nach": 0.5, "Kontrolle Süd, nach": 0.5}
    own = replace(cohort, design=replace(cohort.design, contrasts={"rescue": weights}))
    defined = (
        "of means on logarithms: rescue = 0.5 · 'Hypoxie Öst, nach' + 0.5 · 'Kontrolle Süd, nach' − 'Hypoxie Öst, vor'"
    )
    assert defined in design_text(own)
    methods = methods_section(own, primary_comparison(own, Family(quantities=("mPAP", "CO"))), {})
    assert any(defined in block.text for block in methods.blocks)


def test_points_of_the_forest_are_the_ratios_that_its_rows_are_of(cohort, primary):
    mPAP = {one.name: float(one.measured.quantities["mPAP"]) for one in cohort.results}
    rows = {effect.contrast.kind: animals_of(cohort, effect) for effect in primary.effects if effect.quantity == "mPAP"}
    changes = {mouse: mPAP[f"{mouse} nach"] / mPAP[f"{mouse} vor"] for mouse in dict.fromkeys(cohort.subjects.values())}
    assert {dot.animal: dot.value for dot in rows["factor"]} == pytest.approx(changes)
    center = np.exp(np.mean([np.log(changes[f"Süd {number}"]) for number in (1, 2, 3)]))
    assert {dot.animal: dot.value for dot in rows["interaction"]} == pytest.approx(
        {mouse: one / center for mouse, one in changes.items()}
    )
    level = {mouse: np.sqrt(mPAP[f"{mouse} vor"] * mPAP[f"{mouse} nach"]) for mouse in changes}
    middle = np.exp(np.mean([np.log(level[f"Süd {number}"]) for number in (1, 2, 3)]))
    assert {dot.animal: dot.value for dot in rows["groups"]} == pytest.approx(
        {mouse: one / middle for mouse, one in level.items()}
    )
    # Each row's effect lies among its animals, whose mean it is where nothing is adjusted.
    for what, row in rows_of(primary, "mPAP").iterrows():
        own = [dot.value for dot in rows[what] if what == "factor" or dot.group == "Hypoxie Öst"]
        assert min(own) < row["ratio"] < max(own)


def test_the_page_says_which_parts_made_the_change_and_they_add_up(cohort):
    [(question, text)] = attribution_answer(cohort)
    assert question == "What made the change?"
    assert "Hypoxie Öst, vor to nach (n = 3): mean pressure -" in text
    summary, undone = attribution_summary(cohort)
    assert [row[1] for row in undone.rows] == 2 * ["heart of vor", "walls of vor", "beds of vor"]
    heads = [row[0] for row in summary.rows]
    assert heads[-1] == "Change of Hypoxie Öst less that of Kontrolle Süd, in mmHg, not as a ratio"
    assert len(heads) == 6
    assert "Hypoxie Öst, vor to nach (n = 3)" in heads
    assert summary.header == ("group", "quantity", "change", "heart", "walls", "beds")
    table = attribution_table(cohort.changes)
    assert len(table) == 6 * 8
    parts = table.columns[8:]
    np.testing.assert_allclose(table[parts].sum(axis=1), table["change"], rtol=1e-9, atol=1e-12)
    fitted = {one.name: one.laws["linear"].simulated("pressure", one.root).values for one in cohort.results}
    row = table.set_index(["before", "quantity"]).loc[("Süd 1 vor", "pPAP")]
    assert row["value after"] - row["value before"] == pytest.approx(
        np.ptp(fitted["Süd 1 nach"]) - np.ptp(fitted["Süd 1 vor"]), rel=0.05
    )
    made = cohort.changes[0].means("mPAP")
    of_group = table[(table["group"] == "Kontrolle Süd") & (table["quantity"] == "mPAP")]
    assert made.loc["beds", "mean"] == pytest.approx(of_group["beds"].mean())
    assert made.loc["beds", "high"] == pytest.approx(stats.ttest_1samp(of_group["beds"], 0).confidence_interval().high)


def test_where_followed_groups_are_shown_to_change_unlike_their_averages_do_not_lead(cohort):
    undecided = primary_comparison(cohort, Family(quantities=("mPAP",)))
    assert "on average over" in lead_of(cohort, undecided)
    shown = replace(undecided, effects=tuple(
        replace(effect, p=0.001, ratio=0.7, low=0.6, high=0.8) if effect.contrast.kind == "interaction" else effect
        for effect in undecided.effects
    ))  # fmt: skip
    lead = lead_of(cohort, shown)
    assert lead.startswith("Changed more in Hypoxie Öst than in Kontrolle Süd from vor to nach: mean pressure (× 0.7")
    assert "on average over" not in lead
    said = dict(group_answer(shown, caller(cohort)).questions)["Pressure and flow"]
    assert re.search(r"mPAP × \S+ in Kontrolle Süd, × \S+ in Hypoxie Öst \(", said)


def test_the_change_of_each_group_stands_below_the_lead_and_is_that_of_its_animals(cohort, primary):
    (table,) = change_table(primary, caller(cohort))
    assert table.header == ("quantity", "Kontrolle Süd, nach/vor", "Hypoxie Öst, nach/vor")
    pressures_row = next(row for row in table.rows if row[0] == "mean pressure")
    for group, text in zip(("Kontrolle Süd", "Hypoxie Öst"), pressures_row[1:], strict=True):
        logs = [np.log(pressures(cohort, group, level)).mean() for level in ("vor", "nach")]
        assert float(text.split(" ")[0]) == pytest.approx(np.exp(logs[1] - logs[0]), abs=0.001)
    assert any(change.low <= 1 <= change.high for change in primary.changes)  # and rows that show nothing are left out
    assert len(table.rows) < len({change.quantity for change in primary.changes})
    alone = primary_comparison(crossed_cohort(), Family(quantities=("mPAP",)))
    assert [change.contrast.group for change in alone.changes] == ["Kontrolle Süd", "Hypoxie Öst"]


def test_the_figure_of_followed_groups_begins_with_how_they_changed(cohort, primary):
    headings = [row.heading for row in group_rows(cohort, primary, caller(cohort))]
    assert headings[0].startswith("ratio nach/vor")
    assert [heading.startswith("ratio nach/vor") for heading in headings] == sorted(
        (heading.startswith("ratio nach/vor") for heading in headings), reverse=True
    )


def lead_of(cohort, primary):
    """Return the sentences that answer the question of a study."""
    return group_answer(primary, caller(cohort)).items()[0][1]
