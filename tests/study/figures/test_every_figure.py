"""What a journal asks of every figure of the two documents: letters that can be read, units, nothing over another."""

import re
from itertools import combinations

import pytest

from made_cohort import crossed_cohort
from vasowave.base import InputError
from vasowave.study.cohort import gathered, primary_comparison
from vasowave.study.figures import (
    NARROW,
    WIDEST,
    Appearance,
    figure_bytes,
    lettered,
    new_figure,
    plot_autocorrelation,
    plot_flow,
    plot_residuals,
    style,
)
from vasowave.study.report import ReportSettings, report_of, supplement_of

pytestmark = pytest.mark.validation  # it draws everything twice

SMALLEST = 7.0  # pt
UNIT = re.compile(r"\[[^\]]+\]$")


@pytest.fixture(autouse=True)
def in_style():
    """Look at figures in their own style: ticks are chosen by the size of letters."""
    with style():
        yield


@pytest.fixture(scope="module")
def figures(cohort_results):
    """Return every figure of cohorts and of one animal by document and name, laid out and lettered."""
    found, asked = {}, ReportSettings()
    with style():
        cohorts = {"cohort": gathered(cohort_results, None), "animal": gathered(cohort_results[:1], None)}
        # Names that need room, before and after: four cells, three effects; and with two laws and five times.
        cohorts["occasions"] = crossed_cohort()
        words, names = ("before", "1 h", "2 h", "3 h", "4 h"), ("Überexprimiert und gefüttert", "Kontrolle")
        cohorts["laws"] = crossed_cohort(2, ("linear", "tangent"), words, names)
        for kind, cohort in cohorts.items():
            primary = primary_comparison(cohort, asked)
            for document in (report_of(cohort, primary, asked), supplement_of(cohort, primary)):
                for drawing in document.drawings():
                    if kind in ("occasions", "laws") and drawing.name.startswith(("fit-", "beats-")):
                        continue  # of one animal each, as above
                    figure = drawing.figure() if callable(drawing.figure) else drawing.figure
                    lettered(figure)
                    for _ in range(2):  # the first makes room, the second stands in it
                        figure.draw_without_rendering()
                    found[f"{kind}, {drawing.name}"] = figure
    return found


def words(figure):
    """Return the texts of a figure that are drawn, with their boxes, points."""
    drawn = [*figure.texts, *(text for legend in figure.legends for text in legend.get_texts())]
    for ax in figure.axes:
        drawn += [*ax.texts, ax.title, ax._left_title, ax._right_title]
        drawn += ax.get_legend().get_texts() if ax.get_legend() else []
        for axis in (ax.xaxis, ax.yaxis) if ax.axison else ():
            # Ticks beyond their axis are made, but not drawn.
            drawn += [axis.label, *(label for tick in axis._update_ticks() for label in (tick.label1, tick.label2))]
    scale = 72 / figure.dpi
    seen = [one for one in drawn if one.get_visible() and one.get_text().strip()]
    return [(one, [scale * value for value in ends(one)]) for one in seen]


def ends(text):
    """Return left, bottom, right and top of a text; a first line that is left free is none of it."""
    box = text.get_window_extent()
    return box.x0, box.y0, box.x1, box.y1 - (box.height / 2 if text.get_text().startswith("\n") else 0)


def test_no_letter_is_smaller_than_seven_points(figures):
    small = {(name, one.get_text(), one.get_fontsize()) for name, figure in figures.items() for one, _ in words(figure)
             if one.get_fontsize() < SMALLEST}  # fmt: skip
    assert small == set()


def test_every_figure_is_as_wide_as_one_or_two_columns(figures):
    widths = {name: round(2.54 * figure.get_figwidth(), 6) for name, figure in figures.items()}
    assert {name: width for name, width in widths.items() if width not in (NARROW, WIDEST)} == {}


def test_no_text_leaves_its_figure(figures):
    cut = set()
    for name, figure in figures.items():
        right, top = (72 * size for size in figure.get_size_inches())
        for one, (x0, y0, x1, y1) in words(figure):
            if min(x0, y0) < -1.0 or x1 > right + 1.0 or y1 > top + 1.0:  # boxes hold room around their letters
                cut.add((name, one.get_text()))
    assert cut == set()


def test_no_panel_is_empty(figures):
    empty = {(name, place) for name, figure in figures.items() for place, ax in enumerate(figure.axes)
             if ax.axison and not ax.has_data()}  # fmt: skip
    assert empty == set()


def test_every_axis_with_numbers_says_its_unit(figures):
    bare = set()
    for name, figure in figures.items():
        for ax in figure.axes:
            for axis in (ax.xaxis, ax.yaxis):
                numbers = [
                    one.get_text() for one in axis.get_ticklabels() if re.fullmatch(r"[−-]?[\d.]+", one.get_text())
                ]
                label = axis.get_label().get_text()
                if ax.axison and numbers and label and not UNIT.search(label):
                    bare.add((name, label))
    assert bare == set()


def test_no_text_lies_over_another(figures):
    over = set()
    for name, figure in figures.items():
        for (one, a), (other, b) in combinations(words(figure), 2):
            wide, high = min(a[2], b[2]) - max(a[0], b[0]), min(a[3], b[3]) - max(a[1], b[1])
            if wide > 1.0 and high > 2.0:  # points; boxes hold room below their letters
                over.add((name, one.get_text(), other.get_text()))
    assert over == set()


def test_legends_above_panels_that_stand_side_by_side_end_within_their_own(cohort_results):
    result = cohort_results[0]
    with style():
        figure = new_figure(17.4, 6.0)
        panels = figure.subplots(1, 3)
        for ax, draw in zip(panels, (plot_flow, plot_residuals, plot_autocorrelation), strict=True):
            draw(ax, result)
        figure.canvas.draw()
        for place, ax in enumerate(panels[1:], 1):
            ends = [*(one.get_window_extent().x0 for one in panels[place + 1 :]), figure.bbox.x1]
            assert ax.get_legend().get_window_extent().x1 < ends[0]


@pytest.mark.parametrize(
    ("panels", "said"),
    [((), "a figure needs a panel; there are: pressure, flow"),
     (("flow", "presure"), "there is no panel 'presure' (did you mean 'pressure'?); there are: pressure, flow")],
)  # fmt: skip
def test_a_figure_of_no_panel_and_one_of_an_unknown_panel_are_refused_with_the_panels_there_are(
    cohort_results, panels, said
):
    with pytest.raises(InputError, match=re.escape(said)):
        figure_bytes(cohort_results[0], panels, "svg", Appearance(width=170.0, height=60.0, font=8.0))
