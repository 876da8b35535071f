"""Sizes, places and words of drawings by arithmetic, and panels of few numbers as they were agreed."""

import json
from types import SimpleNamespace

import matplotlib
import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
import pytest
import xarray as xr

from approval import approve, artists
from made_cohort import bare_result
from vasowave.cohort.planning import Plan, Planning
from vasowave.errors import InputError
from vasowave.figures import fit, forest, groups, look, measured, modeled, network, panels, rendering, signals, sweep
from vasowave.figures import style as looks
from vasowave.figures.compared import planned_figure
from vasowave.figures.forest import NARROW, WIDE, Dot, ForestRow, Point
from vasowave.figures.rendering import svg
from vasowave.figures.style import new_figure, style
from vasowave.imaging.places import Frame
from vasowave.imaging.read.volume import Volume
from vasowave.network.network import Network

pytestmark = pytest.mark.usefixtures("in_style")


@pytest.mark.parametrize(
    ("low", "high", "ticks"),
    [
        (1.0, 7.9, [1, 2, 3, 5, 10]), (1.0, 8.0, [1, 2, 5, 10]), (0.5, 90.0, [0.5, 1, 2, 5, 10, 20, 50, 100]),
        (0.5, 100.0, [1, 10, 100]), (1.3, 2.6, [1, 2, 3]), (1.31, 2.3, [2]), (0.9, 1.1, [1.0]),
    ],
)  # fmt: skip
def test_ticks_of_ratios_are_as_many_as_their_range_has_room_for(low, high, ticks):
    assert looks.ratio_ticks(low, high) == pytest.approx(ticks)


def test_names_are_shortened_to_their_room():
    assert looks.short("a" * 22) == "a" * 22
    assert looks.short("a" * 23) == "a" * 21 + "…"
    assert looks.short("abcd", 3) == "ab…"


@pytest.mark.parametrize(
    ("letters", "width", "most", "columns"),
    [
        ([10, 10, 10], 3 * 78 / 72 * 2.54, 4, 3), ([10, 10, 10], 3 * 78 / 72 * 2.54 - 0.01, 4, 2), ([10] * 6, 99, 4, 4),
        ([10] * 6, 99, 2, 2), ([100], 1, 4, 1), ([100, 99], 1, 4, 1), ([10, 30, 10, 10], (162 + 78) / 72 * 2.54, 2, 2),
        ([10, 30, 10, 10], (162 + 78) / 72 * 2.54 - 0.01, 2, 1),
    ],
)  # fmt: skip
def test_columns_of_a_legend_are_as_wide_as_their_longest_words(letters, width, most, columns):
    assert looks.columns_that_fit(["x" * count for count in letters], width, most) == columns


def test_colors_are_darkened_and_stop_at_both_ends_of_the_scale():
    assert looks.darker("#804020", 0.0) == "#804020"
    assert looks.darker("#804020", 0.5) == "#402010"
    stops = looks.color_stops(3)
    assert (stops[0], stops[2]) == ([0, 34, 78], [254, 232, 56])
    assert len(stops) == 3


def test_groups_and_laws_have_looks_of_their_own_and_further_ones_in_turn():
    found = looks.group_looks(["HPH", "x", "CTL", "y", "x"])
    assert found == {"HPH": ("#d6259b", "s"), "x": ("#e69f00", "^"), "CTL": ("#00a7c4", "o"), "y": ("#0072b2", "D")}
    laws = looks.source_looks(["measured", "power", "linear", "own", "fourth.", "fifth"])
    assert [one.short for one in laws.values()] == ["data", "power", "lin.", "own", "four.", "fifth"]
    assert laws["power"].marker == laws["fifth"].marker == "s"
    lines = looks.wall_lines(["linear", "tangent"], "#804020")
    assert lines["linear"]["color"] == looks.darker("#804020", 0.45)
    assert [one["zorder"] for one in lines.values()] == [4, 3]
    assert looks.wall_lines(["linear"], "#804020", shaded=False)["linear"]["color"] == "#804020"
    assert looks.wave_line("forward", "#804020")["color"] == "#804020"
    assert looks.wave_line("backward", "#804020")["color"] == looks.darker("#804020", 0.45)


def test_a_cycle_is_closed_and_a_figure_has_its_size_in_cm():
    assert looks.closed(np.array([3, 4, 5])).tolist() == [3, 4, 5, 3]
    assert looks.closed_time(np.array([0.1, 0.2]), 0.5).tolist() == pytest.approx([0.1, 0.2, 0.6])
    figure = new_figure(12.7, 7.62)
    assert figure.get_size_inches() == pytest.approx([5, 3])
    ax = figure.subplots(1, 2)[0]
    ax.plot([1], [1], label="x" * 10)
    ax.plot([1], [1], label="x" * 10)
    looks.legend_above(ax, 2)
    assert ax.get_legend()._ncols == 2
    looks.legend_above(ax, 1)
    assert ax.get_legend()._ncols == 1
    ax.plot([1], [1], label="x" * 40)
    looks.legend_above(ax, 3)
    assert ax.get_legend()._ncols == 1


def test_signals_are_thinned_to_the_lowest_and_highest_of_each_part():
    time, values = np.arange(8.0), np.array([3.0, 1, 2, 5, 9, 7, 4, 8])
    assert signals.thinned(time, values, 4)[0] is time
    thin, kept = signals.thinned(time, values, 3)  # parts of three, three and two
    assert thin.tolist() == [0, 1, 3, 4, 6, 7]
    assert kept.tolist() == [3, 1, 5, 9, 4, 8]
    assert signals.thinned(time, np.ones(8), 2)[0].tolist() == [0, 4]


def beats_data(**attrs):
    return xr.Dataset(
        {
            "trace_time": ("t", np.arange(9.0)), "trace_pressure": ("t", np.array([0.0, 4, 1, 5, 2, 6, 3, 7, 4])),
            "onset": ("beat", [-1.5, 0.5, 2.5, 4.5, 9.5]), "length": ("beat", [2.0, 2.0, 2.0, 2.5, 2.0]),
            "kept": ("beat", [1, 1, 0, 0, 1]), "reason": ("beat", ["", "", "odd", "", ""]),
            "level": ("beat", [1.0, 2.0, 4.0, 3.0, 5.0]), "drift": ("beat", [0.0, 0.5, 1.0, 1.5, 2.0]),
        },
        attrs={"drift_size": 2.04, "drift_error": 0.26, "drift_removed": 1} | attrs,
    )  # fmt: skip


def test_beats_are_shaded_by_what_became_of_them_where_they_are_seen(ax):
    signals.plot_detected_beats(ax, beats_data())
    spans = {
        one.get_label(): [(path.vertices[0, 0], path.vertices[2, 0]) for path in one.get_paths()]
        for one in ax.collections
    }
    assert spans == {"averaged": [(-1.5, 0.5), (0.5, 2.5)], "rejected": [(2.5, 4.5)]}
    starts = ax.lines[-1]
    assert starts.get_xdata().tolist() == [0.5, 2.5, 4.5]
    assert starts.get_ydata().tolist() == [2.0, 3.0, 4.0]
    assert ax.get_xlim() == (0.0, 8.0)
    with pytest.raises(InputError, match="no signal 'flow' to draw"):
        signals.plot_detected_beats(ax, beats_data(), "flow")
    with pytest.raises(InputError, match="no signal 'time' to draw"):
        signals.plot_detected_beats(ax, beats_data().assign(trace_time=("t", np.arange(9.0))), "time")


def test_the_drift_runs_through_the_levels_of_all_beats_at_their_middles(ax):
    signals.plot_baseline(ax, beats_data())
    rejected, kept, line = ax.lines
    assert rejected.get_xdata().tolist() == [3.5, 5.75]
    assert kept.get_xdata().tolist() == [-0.5, 1.5, 10.5]
    assert kept.get_ydata().tolist() == [1.0, 2.0, 5.0]
    assert line.get_ydata().tolist() == [1.5, 2.0, 2.5, 3.0, 3.5]  # differences 1, 1.5, 3, 1.5 and 3: the middle is 1.5
    assert line.get_label() == "drift +2.0 ± 0.3 mmHg, removed"
    assert ax.get_xlim() == (0.0, 10.5)
    other = new_figure(8, 6).subplots()
    signals.plot_baseline(other, beats_data(drift_removed=0))
    assert other.lines[2].get_label().endswith(", left in")
    with pytest.raises(InputError, match="levels of the beats are not known"):
        signals.plot_baseline(other, beats_data().drop_vars("level"))


def test_the_band_of_beats_is_one_sd_and_counts_the_averaged(ax):
    recording = xr.Dataset(
        {"pressure": ("time", [1.0, 2, 3]), "pressure_sd": ("time", [0.5, 0.25, 1.0])}, {"time": [0.0, 0.1, 0.2]},
        {"period": 0.3},
    )  # fmt: skip
    signals.plot_ensemble(ax, SimpleNamespace(recording=recording, beats=beats_data()))
    ends = ax.collections[0].get_paths()[0].vertices[:, 1]
    assert (ends.min(), ends.max()) == (0.5, 4.0)
    assert ax.lines[0].get_label() == "mean of 3 beats ± SD"
    assert ax.get_xlim() == (0.0, 0.3)
    with pytest.raises(InputError, match="'ecg' is neither 'pressure' nor 'flow'"):
        signals.plot_ensemble(ax, None, "ecg")
    for result in (SimpleNamespace(recording=recording, beats=None),
                   SimpleNamespace(recording=recording.drop_vars("pressure_sd"), beats=beats_data())):  # fmt: skip
        with pytest.raises(InputError, match="came averaged"):
            signals.plot_ensemble(ax, result)


def test_a_stretch_of_a_recording_is_drawn_from_its_first_to_its_last_sample():
    raw = SimpleNamespace(pressure=np.arange(10.0), flow=np.arange(10.0), ecg=None, duration=1.0, sampling_rate=10.0,
                          time=np.arange(10) / 10)  # fmt: skip

    def drawn(*stretch):
        axes = signals.draw_raw(raw, slice(*stretch))
        data = axes[0].lines[0].get_ydata().tolist(), axes[-1].get_xlim(), axes[-1].get_xlabel(), axes[0].get_xlabel()
        assert axes[0].figure.get_size_inches() * 2.54 == pytest.approx([12.0, 8.4])
        plt.close(axes[0].figure)
        return data

    assert drawn(0.2, 0.5) == ([2, 3, 4], (0.2, 0.5), "time [s]", "")
    assert drawn(None) == (list(np.arange(10.0)), (0.0, 1.0), "time [s]", "")
    assert drawn(0.24, 5.0)[0] == list(np.arange(2.0, 10.0))
    assert drawn(-1.0, 0.26)[0] == [0, 1, 2]


def point(value, low, high, source="linear"):
    return Point(value, low, high, source, f"tip {value}")


ROWS = [
    ForestRow("Pressure", "mPAP", "1.6 [1.3, 2.0]", "0.01", point(1.6, 1.3, 2.0), (),
        [Dot(1.0, "CTL", "a", "a"), Dot(1.001, "CTL", "b", "b"), Dot(1.7, "HPH", "c", "c")]),
    ForestRow("Pressure", "CO", "0.5", "", point(0.5, 0.01, 70.0),
        [point(0.7, 0.3, 2.0, "tangent"), point(0.9, 0.9, 0.9, "data")]),
    ForestRow("Two\nlines", "τ", "2.0", "no p", point(2.0, 1.0, np.inf), [point(1.5, 0.0, 3.0, "tangent")]),
]  # fmt: skip


def test_rows_of_a_forest_stand_below_each_other_by_what_they_hold():
    lanes = [forest._Lanes([1, 2, 3], 4), forest._Lanes([], 3), forest._Lanes([], 2)]
    first = -(4 + 0.5 + 1.8)
    second = first - (3 + 0.5 + 1.8) - (3.2 + 2.6)
    assert forest._places(ROWS, lanes, 0.0) == pytest.approx([0.0, first, second])
    assert forest._places(ROWS, lanes, 2.6)[1] == pytest.approx(first - 2.6)
    assert forest._places(ROWS[2:], lanes[2:], 0.0) == pytest.approx([-2.6])
    small = forest._Lanes([], 1)
    assert forest._places(ROWS[:2], [small, small], 0.0)[1] == pytest.approx(-3.6)


def test_a_forest_reaches_a_tenth_beyond_its_ends_and_no_farther_than_fifty_times():
    assert forest._limits(ROWS) == pytest.approx((0.02, 50.0))
    assert forest._limits([ROWS[0]]) == pytest.approx((1.0 / 1.1, 2.0 * 1.1))
    high = ForestRow("", "", "", "", point(2.0, 1.5, 3.0))
    assert forest._limits([high]) == pytest.approx((1 / 1.1, 3.3))
    low = ForestRow("", "", "", "", point(0.5, 0.4, 0.8))
    assert forest._limits([low]) == pytest.approx((0.4 / 1.1, 1.1))


def test_animals_share_lanes_where_they_do_not_touch():
    limits = (0.5, 2.0)
    length = 4.7 / 2.54 * 72 / np.log(4.0)
    apart = np.exp(3.8 / length)
    row = ForestRow("", "", "", "", point(1, 1, 1), [point(1, 1, 1)], [
        Dot(1.0, "A", "a", ""), Dot(apart * 1.0001, "A", "b", ""), Dot(apart * 0.999, "A", "c", ""),
        Dot(1.0, "B", "d", ""), Dot(1.0, "B", "e", ""),
    ])  # fmt: skip
    found = forest._lanes(row, limits, 4.7, 12)
    assert found.dots == [2, 2, 3, 4, 5]
    assert found.height == 6
    assert forest._lanes(row, limits, 4.7, 1) == ([2, 2, 2, 3, 3], 4)


@pytest.mark.parametrize(
    ("count", "beside", "sides", "lanes"),
    [(12, 0, 2, 12), (13, 0, 2, 4), (13, 1, 2, 4), (30, 0, 1, 2), (60, 2, 2, 1), (20, 0, 1, 5)],
)
def test_many_rows_have_fewer_lanes_so_that_they_fit_a_page(count, beside, sides, lanes):
    dots = [Dot(1.0, f"g{side}", "", "") for side in range(sides)]
    rows = [ForestRow("", "", "", "", point(1, 1, 1), [point(1, 1, 1)] * beside, dots)] * count
    assert forest._most_lanes(rows) == lanes
    assert forest._most_lanes([ROWS[1]] * 13) >= 1


@pytest.mark.parametrize("form", [WIDE, NARROW], ids=["wide", "narrow"])
def test_approved_a_forest_of_every_kind_of_mark(form):
    groups_, sources = looks.group_looks(["CTL", "HPH"]), looks.source_looks(["linear", "tangent", "data"])
    drawn = [
        forest.forest_figure(ROWS, groups_, sources, "ratio [1]", columns, form)
        for columns in (("ratio", "p"), ("value", ""))
    ]
    approve(f"panel, forest {'wide' if form is WIDE else 'narrow'}", (line for one in drawn for line in artists(one)))


def test_starts_are_drawn_in_their_order_over_the_best(ax):
    data = xr.Dataset({"start_S": ("start", [3.0, np.inf, 2.0, np.nan, 2.5])})
    modeled.plot_waterfall(ax, data, color="#123456")
    line = ax.lines[0]
    assert (line.get_xdata().tolist(), line.get_ydata().tolist()) == ([1, 2, 3], [1.0, 1.25, 1.5])
    assert (line.get_color(), line.get_marker(), line.get_markersize()) == ("#123456", "o", 3)


def waterfalls(*S, single=False):
    laws = {
        wall: SimpleNamespace(calibration=xr.Dataset({"start_S": ("start", list(S))})) for wall in ("linear", "tangent")
    }
    results = [SimpleNamespace(laws=laws), SimpleNamespace(laws={"linear": laws["linear"]})]
    cohort = SimpleNamespace(walls=["linear", "tangent"], groups={"CTL": results, "HPH": results}, single=single)
    return modeled.waterfall_figure(cohort).axes


def test_a_wide_range_of_starts_is_logarithmic_and_a_small_one_shows_that_it_is_small():
    first, second = waterfalls(2.0, 2.0, 2.01)
    assert first.get_ylim() == pytest.approx((1 - 0.04 * 0.02, 1.02))
    assert (len(first.lines), len(second.lines)) == (4, 2)
    assert [line.get_label() for line in first.lines][::2] == ["CTL", "HPH"]
    assert (first.get_yscale(), second.get_ylabel(), first.get_title("left")) == ("linear", "", "linear wall")
    wide = waterfalls(2.0, 5.0, 9.0, single=True)
    assert wide[0].get_yscale() == "log"
    assert wide[0].get_legend() is None
    assert wide[0].yaxis.get_major_formatter()(2.0, 0) == "2"
    assert waterfalls(2.0, 4.0, 5.5)[0].get_yscale() == "linear"


WAVES = xr.Dataset(
    {
        "normalized_time": ("t", [0.0, 0.25, 0.5, 0.75]), "pressure": ("t", [1.0, 3, 2, 1]),
        "p_plus": ("t", [0.5, 2, 1, 0.5]), "p_minus": ("t", [0.5, 1.0, 1, 0.5]),
        "WI_plus": ("t", [0.0, 4, 1, 0]), "WI_minus": ("t", [0.0, -2, -1, 0]),
        "wave_name": ("wave", ["FCW", "BCW", "FCW"]), "wave_area": ("wave", [1.0, -3.0, 2.0]),
        "wave_time": ("wave", [0.02, 0.03, 0.04]), "wave_peak": ("wave", [4.0, -2.0, 1.0]),
    },
    attrs={"period": 0.1},
)  # fmt: skip


def test_the_largest_wave_of_each_kind_is_named_at_its_peak(ax):
    modeled.plot_wave_intensity(ax, WAVES)
    said = [(one.get_text(), one.xy, one.get_position(), one.get_va()) for one in ax.texts]
    assert said == [
        ("BCW", pytest.approx((0.3, -2.0)), (0, -3), "top"),
        ("FCW", pytest.approx((0.4, 1.0)), (0, 3), "bottom"),
    ]
    assert [line.get_ydata()[1] for line in ax.lines[:2]] == [4, -2]
    assert ax.margins() == (0.02, 0.18)
    assert ax.get_xlim() == (0, 1)
    other = new_figure(8, 6).subplots()
    modeled.plot_separated_pressure(other, WAVES, "#123456")
    assert [line.get_ydata()[1] for line in other.lines] == [3, 2, 1]
    assert [line.get_label() for line in other.lines] == ["pressure", "forward", "backward"]


def test_the_vessels_that_are_shown_are_those_with_most_flow_from_the_root_to_the_ends():
    names = tuple("abcdefghi")
    parent = [-1, 0, 0, 1, 1, 2, 2, 3, 3]
    radius = np.array([9, 7, 6, 6, 2, 5, 1, 5.5, 1.0]) / 100
    whole = Network(names, parent, np.full(9, 0.3), radius)
    flow = whole.flow_fraction
    assert flow[7] > flow[8]
    chosen = modeled.main_vessels(whole, 5)
    assert chosen[0] == "a"
    assert {"b", "c", "h", "f"} == set(chosen[1:])
    assert len(modeled.main_vessels(whole, 8)) == 9  # one more alone is shown, too
    assert len(modeled.main_vessels(whole, 7)) == 7
    assert modeled._main_path(whole, 1) == [1, 3, 7]


@pytest.mark.parametrize(
    ("value", "rounded"),
    [(0.05, 0.05), (0.049, 0.02), (0.019, 0.01), (0.02, 0.02), (1.0, 1.0), (7.0, 5.0), (10.0, 10.0)],
)
def test_radii_of_the_key_are_round(value, rounded):
    assert network._rounded(value) == pytest.approx(rounded)


def test_daughters_spread_by_their_area_around_their_parent():
    whole = Network(tuple("abcd"), [-1, 0, 0, 0], np.full(4, 1.0), np.array([4, 3, 2, 1.0]))
    area = np.array([9.0, 4, 1])
    even = np.array([-0.5, 0, 0.5])
    expected = np.radians(75) * (even - (even * area).sum() / 14)
    assert network._angles(whole, 0) == pytest.approx(expected)
    assert network._angles(whole, 1).tolist() == []
    line = Network(tuple("ab"), [-1, 0], np.array([2.0, 3.0]), np.array([2.0, 1.0]))
    assert network._angles(line, 0).tolist() == [0.0]
    axes = network.axes_in_space(line)
    assert axes.tolist() == [[[0, 0, 0], [0, 0, 2]], [[0, 0, 2], [0, 0, 5]]]
    x, y = network.layout(whole)
    assert (x.tolist(), y.tolist()) == ([0, 1, 1, 1], [-1.0, 0.0, -1.0, -2.0])


@pytest.mark.parametrize(
    ("phase", "words"),
    [(0, "0"), (1, "π/2"), (-1, "−π/2"), (2, "π"), (-2, "−π"), (3, "3π/2"), (-3, "−3π/2"), (4, "2π"), (-4, "−2π")],
)
def test_phases_are_written_in_halves_of_pi(phase, words):
    assert fit._halves(phase * np.pi / 2) == words


def test_phases_are_unwrapped_by_the_reliable_ones():
    phase = np.array([3.0, -3.0, 0.5, -2.5])
    good = np.array([True, True, False, True])
    found = fit.unwrapped(phase, good)
    assert found[[0, 1, 3]] == pytest.approx([3.0, 2 * np.pi - 3, 2 * np.pi - 2.5])
    assert found[2] == pytest.approx(
        0.5 + 2 * np.pi * round((found[1] + found[3]) / 2 / (2 * np.pi) - 0.5 / (2 * np.pi))
    )
    assert fit.unwrapped(phase, np.zeros(4, bool)) is not phase
    assert fit.unwrapped(phase, np.zeros(4, bool)).tolist() == phase.tolist()


def test_panels_of_a_sheet_have_128_points_of_their_cycle():
    share, kept = fit._thinned(np.arange(400.0))
    assert len(share) == 128
    assert (share[0], share[-1], kept[-1]) == (0, 1, 0)
    share, kept = fit._thinned(np.arange(3.0))
    assert share == pytest.approx([0, 1 / 3, 2 / 3, 1])
    laws = {"linear": SimpleNamespace(rmse=1.0)}
    results = [SimpleNamespace(laws=laws, name=n) for n in range(50)] + [SimpleNamespace(laws={}, name="none")]
    assert [len(one) for one in fit.sheets(results)] == [48, 2]


def cohort_of(groups_, single=False, **more):
    return SimpleNamespace(groups=groups_, single=single, **more)


@pytest.mark.parametrize(
    ("single", "rows", "columns", "size", "shape"),
    [
        (True, 4, 1, (17.4, 10.0), (4, 1)), (True, 3, 1, (17.4, 20 * 2 / 3), (4, 1)), (True, 1, 1, (8.5, 20.0), (1, 1)),
        (False, 3, 1, (8.5, 20.0), (3, 1)), (False, 3, 2, (17.4, 20.0), (3, 2)),
    ],
)  # fmt: skip
def test_panels_of_one_animal_stand_side_by_side(single, rows, columns, size, shape):
    figure, axes = panels.grid(cohort_of({}, single), rows, 20.0, columns)
    assert figure.get_size_inches() * 2.54 == pytest.approx(size)
    assert axes.shape == shape


def test_names_above_columns_are_broken_where_they_are_long():
    cohort = cohort_of({"CTL": [], "HPH": []}, shown={"CTL": SimpleNamespace(name="m" * 30)}, name=lambda group: name)
    name = "m" * 30 + " " + "x" * 13
    assert panels.name_above(cohort, "CTL") == name
    name = "m" * 30 + " " + "x" * 14
    assert panels.name_above(cohort, "CTL") == "m" * 30 + "\n" + "x" * 14


def test_titles_of_columns_name_group_level_count_and_who_is_black():
    def title(level, most, shown="m1"):
        cohort = SimpleNamespace(cells={"L": ("CTL", level, [])}, count=lambda label: "n = 3")
        return measured._title(cohort, "L", shown, most)

    assert title("", 24) == "CTL (n = 3); black: m1"
    assert title("", 21) == "CTL\nn = 3\nblack: m1"
    assert title("before", 24) == "CTL\nbefore (n = 3)\nblack: m1"
    assert title("before", 24, "") == "CTL\nbefore (n = 3)"


def test_panels_of_beats_fill_their_page_in_cm():
    room = measured._beats_room(16.4, 4)
    panel = (16.4 - 1.0 - 0.8 - 3 * 1.6) / 4
    half = (17.4 - 1.8 - 0.2 - 1.9) / 2
    assert room == pytest.approx({
        "left": 1.8 / 17.4, "right": 1 - 0.2 / 17.4, "bottom": 1 / 16.4, "top": 1 - 0.8 / 16.4, "hspace": 1.6 / panel,
        "wspace": 1.9 / half,
    })  # fmt: skip


def nominal_result(decay_time):
    nominal = xr.Dataset({
        "upstroke_flow": ("u", [0.1, 0.3]), "upstroke_pressure": ("u", [10.0, 20.0]), "Z_c": 40.0, "tau": 0.123456,
        "decay_time": ("d", decay_time), "decay_pressure": ("d", np.linspace(15, 9, len(decay_time))),
    })  # fmt: skip
    time = np.arange(4) * 0.025
    recording = xr.Dataset(
        {"pressure": ("time", [10.0, 20, 16, 12]), "flow": ("flow_time", [0.0, 0.4, 0.2, 0.0])},
        {"time": time, "flow_time": time}, {"period": 0.1},
    )  # fmt: skip
    return bare_result(recording=recording, nominal=nominal)


def test_the_line_of_the_upstroke_and_the_decay_stand_over_the_measured_cycle():
    axes = new_figure(17, 6).subplots(1, 3)
    measured.plot_upstroke(axes[0], nominal_result([0.05, 0.07]))
    loop, dots, line = axes[0].lines
    assert loop.get_xdata()[0] == pytest.approx(loop.get_xdata()[-1])
    assert dots.get_xdata().tolist() == [0.1, 0.3]
    flow = loop.get_xdata()
    assert line.get_xdata().tolist() == [flow.min(), flow.max()]
    assert line.get_ydata() == pytest.approx(15 + 40 * (line.get_xdata() - 0.2))
    assert line.get_label() == "Z_c = 40 mmHg s/ml"
    measured.plot_decay(axes[1], nominal_result([0.05, 0.07]))
    cycle, decay = axes[1].lines
    assert cycle.get_xdata() == pytest.approx([0, 0.025, 0.05, 0.075, 0.1])
    assert decay.get_label() == "τ = 0.123 s"
    assert axes[1].get_xlim() == pytest.approx((0.0, 0.1))
    measured.plot_decay(axes[2], nominal_result([0.05, 0.12]))
    twice = axes[2].lines[0]
    assert twice.get_xdata() == pytest.approx([0, 0.025, 0.05, 0.075, 0.1, 0.125, 0.15, 0.175, 0.2])
    assert twice.get_ydata().tolist() == [10, 20, 16, 12] * 2 + [10]
    assert axes[2].get_xlim() == pytest.approx((0.0, 0.12 + 0.005))


def test_ratios_stand_from_above_with_their_intervals(ax):
    table = pd.DataFrame({"quantity": ["a", "b", "c"], "ratio": [2.0, 0.5, 1.0], "ratio low": [1.5, 0.4, 0.9],
                          "ratio high": [3.0, 0.6, 1.2]})  # fmt: skip
    groups.plot_ratios(ax, table)
    assert [one.get_text() for one in ax.get_yticklabels()] == ["a", "b", "c"]
    assert ax.get_yticks().tolist() == [2, 1, 0]
    assert ax.get_ylim() == (-0.7, 2.7)
    segments = ax.collections[0].get_segments()
    assert [one[:, 0].tolist() for one in segments] == [
        pytest.approx([1.5, 3.0]),
        pytest.approx([0.4, 0.6]),
        pytest.approx([0.9, 1.2]),
    ]
    assert ax.get_xticks().tolist() == pytest.approx([0.5, 1, 2, 3])


def test_letters_stand_at_panels_where_there_are_several():
    figure = new_figure(8, 6)
    first, second, hidden = figure.subplots(1, 3)
    hidden.set_axis_off()
    rendering.lettered(figure)
    assert [[one.get_text() for one in ax.texts] for ax in (first, second, hidden)] == [["a"], ["b"], []]
    alone = new_figure(8, 6)
    alone.subplots()
    rendering.lettered(alone)
    assert len(alone.axes[0].texts) == 0
    many = new_figure(20, 20)
    many.subplots(1, 27)
    rendering.lettered(many)
    assert len(many.axes[0].texts) == 0


def test_marks_become_titles_and_data_of_the_drawing(ax):
    (line,) = ax.plot([0, 1], [0, 1])
    rendering.mark(line, "a <b>", "m1", "power wall")
    drawn = rendering.svg(ax.figure)
    assert '<g data-animal="m1" data-layer="power wall"><title>a &lt;b&gt;</title>' in drawn
    rendering.readable(ax)
    note = json.loads(ax.patch.get_gid().removeprefix("mark:"))
    assert json.loads(note["scale"])["labels"] == ["", ""]
    assert rendering.described('<svg width="1">x</svg>', "T&", "d").startswith(
        '<svg width="1" role="img"><title>T&amp;</title><desc>d</desc>x'
    )
    assert rendering.as_file(ax.figure, "png")[:4] == b"\x89PNG"
    assert ax.figure.get_layout_engine() is not None


def test_a_plan_is_drawn_over_the_numbers_of_animals():
    powers = pd.DataFrame({f"q{n}": [0.1 * n, 0.9] for n in range(6)}, pd.Index([3, 60], name="animals"))

    def drawn(**settings):
        return planned_figure(Plan(Planning(effect=1.5, power=0.7, **settings), (), "x", powers, powers)).axes[0]

    ax = drawn()
    assert ax.lines[0].get_ydata()[0] == 0.7
    dashes = [line.get_linestyle() for line in ax.lines[1:]]
    assert len(dashes) == 6
    assert [line.get_label() for line in ax.lines[1:]] == list(powers)
    colors = looks.color_stops(7)
    assert ax.lines[3].get_color() == pytest.approx(tuple(part / 255 for part in colors[2]))
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("animals of each group [1]", "power to show a ratio of 1.5 [1]")
    assert drawn(pairs=0.5).get_xlabel() == "pairs [1]"
    assert ax.get_ylim() == (0, 1.02)
    assert [one.get_text() for one in ax.get_xticklabels()] == ["3", "5", "10", "20", "40", "60"]


def swept(second=None):
    shape = {"beta": 2} if second is None else {"beta": 2, "R": second}
    dims = (*shape, "time")
    sizes = (*shape.values(), 3)
    return xr.Dataset(
        {"root_pressure": (dims, np.arange(float(np.prod(sizes))).reshape(sizes)),
         "mach": (tuple(shape), np.ones(sizes[:-1]))},
        {"beta": ("beta", [40.0, 60.0], {"units": "mmHg"}), "time": [0.0, 0.1, 0.2]}
        | ({} if second is None else {"R": ("R", np.arange(1.0, second + 1))}),
    )  # fmt: skip


def test_a_sweep_is_drawn_over_one_parameter_and_a_few_values_of_a_second():
    waves, levels = sweep.sweep_figure(swept()).axes
    assert [line.get_label() for line in waves.lines] == ["beta 40 mmHg", "beta 60 mmHg"]
    assert waves.lines[1].get_xdata().tolist() == [0, 100, 200]
    assert [line.get_ydata().tolist() for line in levels.lines] == [[2, 5], [1, 4], [0, 3]]
    assert [line.get_label() for line in levels.lines] == ["systolic", "mean", "diastolic"]
    assert levels.get_xlabel() == "beta [mmHg]"
    waves, levels = sweep.sweep_figure(swept(5)).axes
    assert len(waves.lines) == 10
    assert len(levels.lines) == 15
    labels = [line.get_label() for line in levels.lines if not line.get_label().startswith("_")]
    assert labels == ["systolic", *(f"mean, R {n}" for n in range(1, 6)), "diastolic"]
    assert levels.lines[6].get_ydata().tolist() == [4, 19]
    with pytest.raises(InputError, match="a second of at most 5 values"):
        sweep.sweep_figure(swept(6))
    with pytest.raises(InputError, match="a plot shows one parameter"):
        sweep.sweep_figure(swept(2).expand_dims("third", axis=0))


def test_an_image_is_seen_along_its_axes_in_a_page_of_its_shape():
    grey = np.zeros((4, 6, 10))
    grey[1:3, 2:4, 3:8] = 100.0
    volume = Volume(grey, np.array([0.2, 0.2, 0.2]), np.array([1.0, 2.0, 3.0]))
    lumen = SimpleNamespace(mask=grey[:, 1:5, 2:9] > 50, origin=np.array([1.0, 2.2, 3.4]), spacing=0.2)
    place = SimpleNamespace(place=np.array([1.2, 2.4, 3.6]))
    seen = SimpleNamespace(
        image=SimpleNamespace(frame=Frame(volume.origin, np.eye(3))), lumen=lumen, entrances=[place] * 5, loops=[place],
        levels=SimpleNamespace(background=3.0),
    )  # fmt: skip
    whole = np.array([4, 6, 10]) / 10
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(look, "isotropic", lambda image: volume)
        wide, tall = look.projections_figure(seen), look.projections_figure(seen, wide=False)
    z, y, x = whole
    assert wide.get_size_inches() * 2.54 == pytest.approx([17.4, 12.4 * max(z, y) / (2 * x + y) + 2.5])
    assert tall.get_size_inches() * 2.54 == pytest.approx([8.5, 6 * z / x + 6 * z / y + 6 * y / x + 5])
    first = wide.axes[0]  # along y
    assert first.get_title("left") == "along y"
    assert (first.get_xlim(), first.get_ylim()) == (pytest.approx((2.9, 4.9)), pytest.approx((0.9, 1.7)))
    squares = [line for line in first.lines if line.get_marker() == "s"]
    assert [line.get_xydata()[0].tolist() for line in squares] == [[3.6, 1.2]] * 4
    (ring,) = [line for line in first.lines if line.get_marker() == "o"]
    assert (ring.get_xydata()[0].tolist(), ring.get_markersize()) == ([3.6, 1.2], 7)
    assert [one.get_text() for one in first.texts] == ["1", "2", "3", "4"]
    assert first.images[0].get_clim()[0] == 3.0
    assert [ax.get_title("left") for ax in wide.axes] == ["along y", "along x", "along z"]
    low, high = look._box(
        volume, SimpleNamespace(mask=np.ones((2, 2, 5)), origin=np.array([1.2, 2.6, 3.2]), spacing=0.2)
    )
    assert (low.tolist(), high.tolist()) == ([0, 2, 0], [4, 6, 7])


def test_a_file_of_settings_that_matplotlib_found_in_a_study_neither_runs_latex_nor_changes_a_figure():
    def drawn():
        with style():
            figure = new_figure(8, 5)
            figure.subplots().set_xlabel(r"$\beta$ [mmHg]")
            return svg(figure)

    expected = drawn()
    with matplotlib.rc_context({"text.usetex": True, "text.latex.preamble": r"\input{evil}", "font.size": 40}):
        assert drawn() == expected
