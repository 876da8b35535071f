"""The forest plot measured on the drawing: no animal is covered by an interval, another law or another animal."""

from itertools import combinations

import numpy as np
import pytest

from approval import approve, artists
from vasowave.study.figures import WIDE, Dot, ForestRow, Point, forest_figure, group_looks, source_looks, style
from vasowave.study.figures.forest import NARROW


def row(label, sizes, spread, rng, laws=("tangent", "power")):
    dots = [
        Dot(float(mean * np.exp(spread * rng.standard_normal())), group, f"{group} {place}", f"{group} {place}: 1")
        for (group, count), mean in zip(sizes.items(), (1.0, 1.6), strict=True)
        for place in range(count)
    ]
    beside = [Point(1.5, 1.1, 2.2, law, law) for law in laws]
    return ForestRow(
        "Pressure and flow", label, "1.6 [1.3, 2.0]", "0.01", Point(1.6, 1.3, 2.0, "linear", "effect"), beside, dots
    )


def marks(figure):
    """Return center and half size, points, of every marker of the middle panel, by its words, and every line."""
    figure.draw_without_rendering()
    ax = figure.axes[1] if len(figure.axes) > 1 else figure.axes[0]
    scale = 72 / figure.dpi
    found, lines = [], []
    for line in ax.get_lines():
        places = scale * ax.transData.transform(np.column_stack([line.get_xdata(), line.get_ydata()]))
        if line.get_marker() not in ("None", None, ""):
            half = line.get_markersize() / 2 * (np.sqrt(2) if line.get_marker() == "D" else 1.0)
            found.append((None, places[0], half, line))
        elif len(places) == 2 and places[0, 1] == places[1, 1]:
            lines.append(places)
    return found, lines


def covered(figure, animals):
    """Return how many animals' points lie under or on another mark or an interval."""
    found, lines = marks(figure)
    dots = [one for one in found if one[3].get_markersize() == 3.8]
    assert len(dots) == animals
    others = [one for one in found if one[3].get_markersize() != 3.8]
    count = 0
    for dot in dots:
        reach = 3.8 / 2
        by_marks = any(np.hypot(*(dot[1] - one[1])) < reach + one[2] - 0.3 for one in others)
        by_lines = any(
            abs(line[0, 1] - dot[1][1]) < reach and line[0, 0] - reach < dot[1][0] < line[1, 0] + reach
            for line in lines
        )
        count += by_marks or by_lines
    count += sum(np.hypot(*(a[1] - b[1])) < 0.9 * 3.8 for a, b in combinations(dots, 2))
    return count


@pytest.mark.parametrize(
    "sizes", [{"WT": 2, "HOX": 2}, {"WT": 3, "HOX": 2}, {"CTL": 7, "HPH": 5}, {"CTL": 12, "HPH": 4}]
)
@pytest.mark.parametrize("spread", [0.02, 0.15, 0.5])
@pytest.mark.parametrize("form", [WIDE, NARROW])
def test_every_animal_of_both_groups_stands_free(sizes, spread, form):
    rng = np.random.default_rng(3)
    rows = [
        row(label, sizes, spread, rng, laws) for label, laws in (("mPAP", ()), ("CO", ()), ("c", ("tangent", "power")))
    ]
    with style():
        figure = forest_figure(
            rows, group_looks(sizes), source_looks(["linear", "tangent", "power"]), "ratio", ("r", "p"), form
        )
        assert covered(figure, 3 * sum(sizes.values())) == 0


def test_animals_of_equal_value_stand_beside_each_other():
    dots = [Dot(1.6, group, f"{group} {place}", "") for group in ("WT", "HOX") for place in range(3)]
    alike = ForestRow("", "mPAP", "", "", Point(1.6, 1.6, 1.6, "linear"), [], dots)
    with style():
        figure = forest_figure([alike], group_looks(["WT", "HOX"]), source_looks(["linear"]), "ratio", ("r", "p"))
        assert covered(figure, 6) == 0


@pytest.mark.parametrize("form", [WIDE, NARROW])
def test_an_interval_that_leaves_the_axis_ends_in_an_arrow_and_no_other_does(form):
    wide = ForestRow("", "mPAP", "", "", Point(1.6, 1.3, 4.0, "linear"), [Point(9.0, 0.001, 900.0, "tangent")])
    looks = group_looks(["WT", "HOX"]), source_looks(["linear", "tangent"])
    with style():
        arrows = [
            [(one.get_marker(), one.get_xdata()[0]) for one in forest_figure([rows], *looks, "r", ("r", "p"), form)
             .axes[1 if form is WIDE else 0].get_lines() if one.get_marker() in ("<", ">")]
            for rows in (wide, wide._replace(further_points=()))
        ]  # fmt: skip
    assert arrows == [[("<", 0.02), (">", 50.0)], []]


def test_a_point_under_the_diamond_would_be_found(ax):
    ax.plot([1.6], [0.0], marker="D", markersize=6)
    ax.plot([1.6], [0.1], marker="o", markersize=3.8)
    ax.plot([1.3], [8.0], marker="o", markersize=3.8)
    ax.set_ylim(-10, 10)
    assert covered(ax.figure, 2) == 1


@pytest.mark.parametrize("form", [WIDE, NARROW])
@pytest.mark.parametrize(
    ("label", "effect", "columns"),
    [
        ("proximal resistance share a", "0.0028 [0.0012, 0.062]", ("ratio [95 %]", "p")),
        ("compliance of the beds C_p", "0.00267 [0.00112, 0.00562] ml/mmHg", ("value [95 %]", "")),
    ],
)
def test_no_words_cover_each_other_or_leave_the_drawing(form, label, effect, columns):
    rng = np.random.default_rng(3)
    one = row(label, {"CTL": 7, "HPH": 5}, 0.3, rng)._replace(effect=effect, aside="<0.0001" if columns[1] else "")
    with style():
        looks = group_looks(["CTL", "HPH"]), source_looks(["linear", "tangent", "power"])
        figure = forest_figure([one, one._replace(heading="Small vessels")], *looks, "ratio", columns, form)
        figure.draw_without_rendering()
        boxes = [text.get_window_extent() for ax in figure.axes for text in ax.texts if text.get_text()]
        sheet = figure.bbox
    assert len(boxes) >= 7
    assert all(sheet.x0 <= box.x0 and box.x1 <= sheet.x1 and sheet.y0 <= box.y0 and box.y1 <= sheet.y1 for box in boxes)
    assert [1 for a, b in combinations(boxes, 2) if a.overlaps(b)] == []


def test_approved_a_forest_in_both_widths_with_intervals_that_go_on_beyond_the_axis():
    rng = np.random.default_rng(5)
    rows = [row("mPAP", {"WT": 3, "HOX": 2}, 0.1, rng, laws=()), row("R_T", {"WT": 2, "HOX": 3}, 0.3, rng)]
    far = rows[1]._replace(point=Point(3.0, 0.001, 900.0, "linear", "effect"))
    looks = group_looks(["WT", "HOX"]), source_looks(["linear", "tangent", "power"])
    with style():
        drawn = [forest_figure([rows[0], far], *looks, "ratio [1]", ("r", "p"), form) for form in (WIDE, NARROW)]
        approve("forest", (line for one in drawn for line in artists(one)))
