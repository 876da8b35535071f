"""Drawings as files, and lines that are drawn through what was measured."""

from dataclasses import replace
from xml.etree import ElementTree

import matplotlib as mpl
import numpy as np
import pytest
import xarray as xr

from made_cohort import bare_result
from vasowave.study.animal import FitPlots
from vasowave.study.cohort import gathered, primary_comparison
from vasowave.study.figures import (
    as_file,
    lettered,
    mark,
    new_figure,
    plot_decay,
    plot_upstroke,
    ratio_ticks,
    style,
    svg,
)
from vasowave.study.report import ReportSettings, supplement_of


@pytest.mark.parametrize(
    ("low", "high", "ticks"),
    [(1.0, 7.9, [1, 2, 3, 5, 10]), (0.5, 90.0, [0.5, 1, 2, 5, 10, 20, 50, 100]), (0.5, 100.0, [1, 10, 100]),
     (0.9, 1.1, [1.0])],
)  # fmt: skip
def test_ticks_of_ratios_are_as_many_as_their_range_has_room_for(low, high, ticks):
    assert ratio_ticks(low, high) == pytest.approx(ticks)


def test_a_figure_has_its_size_in_cm_and_letters_where_it_has_several_panels(in_style):
    figure = new_figure(12.7, 7.62)
    assert figure.get_size_inches() == pytest.approx([5, 3])
    first, second, hidden = figure.subplots(1, 3)
    hidden.set_axis_off()
    lettered(figure)
    assert [[one.get_text() for one in ax.texts] for ax in (first, second, hidden)] == [["a"], ["b"], []]
    alone = new_figure(8, 6)
    alone.subplots()
    lettered(alone)
    assert len(alone.axes[0].texts) == 0


def test_marks_become_titles_and_data_of_the_drawing_and_stay_text(ax):
    (line,) = ax.plot([0, 1], [0, 1])
    mark(line, "a <b>", "m1", "power wall")
    assert '<g data-animal="m1" data-layer="power wall"><title>a &lt;b&gt;</title>' in svg(ax.figure)
    assert as_file(ax.figure, "png")[:4] == b"\x89PNG"


@pytest.mark.parametrize(("last", "cycles"), [(0.07, 1), (0.12, 2)])
def test_the_line_of_the_upstroke_and_the_decay_stand_over_the_measured_cycle(in_style, last, cycles):
    """The line goes through the mean of the upstroke with the characteristic impedance as its slope."""
    nominal = xr.Dataset({
        "upstroke_flow": ("u", [0.1, 0.3]), "upstroke_pressure": ("u", [10.0, 20.0]), "Z_c": 40.0, "tau": 0.123456,
        "decay_time": ("d", [0.05, last]), "decay_pressure": ("d", [15.0, 9.0]),
    })  # fmt: skip
    time = np.arange(4) * 0.025
    signals = {"pressure": ("time", [10.0, 20, 16, 12]), "flow": ("flow_time", [0.0, 0.4, 0.2, 0.0])}
    recording = xr.Dataset(signals, {"time": time, "flow_time": time}, {"period": 0.1})
    result = bare_result(recording=recording, nominal=nominal)
    upstroke, decay = new_figure(17, 6).subplots(1, 2)
    plot_upstroke(upstroke, result)
    line = upstroke.lines[2]
    assert line.get_ydata() == pytest.approx(15 + 40 * (line.get_xdata() - 0.2))
    assert line.get_label() == "Z_c = 40 mmHg s/ml"
    plot_decay(decay, result)
    assert decay.lines[0].get_ydata().tolist() == [10, 20, 16, 12] * cycles + [10]
    assert decay.lines[1].get_label() == "τ = 0.123 s"


def test_a_file_of_settings_that_matplotlib_found_in_a_study_neither_runs_latex_nor_changes_a_figure():
    def drawn():
        with style():
            figure = new_figure(8, 5)
            figure.subplots().set_xlabel(r"$\beta$ [mmHg]")
            return svg(figure)

    expected = drawn()
    with mpl.rc_context({"text.usetex": True, "text.latex.preamble": r"\input{evil}", "font.size": 40}):
        assert drawn() == expected


def test_panels_are_saved_side_by_side_in_the_size_of_the_report(cohort_results, tmp_path):
    path = FitPlots(cohort_results[0]).save(tmp_path / "panels.svg", ["pressure", "impedance"])
    root = ElementTree.fromstring(path.read_text("utf-8"))
    assert float(root.get("width").removesuffix("pt")) == pytest.approx(170.0 / 25.4 * 72, rel=1e-4)
    assert float(root.get("height").removesuffix("pt")) == pytest.approx(60.0 / 25.4 * 72, rel=1e-4)


def test_intervals_of_a_posterior_stand_at_the_shear_and_strain_of_every_vessel(cohort_results, in_style):
    law = cohort_results[0].laws["linear"]
    ends = {f"{name}_{end}": factor * law.vessels[name] for name in ("mean_shear", "strain")
            for end, factor in (("low", 0.8), ("high", 1.3))}  # fmt: skip
    result = replace(cohort_results[0], laws={"linear": replace(law, vessels=law.vessels.assign(ends))})
    cohort = gathered([result])
    supplement = supplement_of(cohort, primary_comparison(cohort, ReportSettings()))
    (tree,) = (drawing for drawing in supplement.drawings() if drawing.name == "Tree")
    assert "95 % intervals" in tree.caption
    counts = [sum(len(lines.get_segments()) for lines in ax.collections) for ax in tree.figure.axes]
    assert counts == [0, 0, len(result.network), len(result.network)]
