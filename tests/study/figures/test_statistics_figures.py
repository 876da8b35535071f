import io
from itertools import combinations

import matplotlib
import numpy as np
import pytest
import xarray as xr

matplotlib.use("Agg")
from matplotlib.figure import Figure

from made_cohort import made_results
from vasowave.pulse import analysis
from vasowave.pulse.cycle import Recording
from vasowave.pulse.examples import published_table
from vasowave.pulse.network import Network
from vasowave.study.animal import Station, autocorrelation, waves_dataset
from vasowave.study.cohort import Interval
from vasowave.study.figures import (
    CTL,
    HPH,
    group_looks,
    new_figure,
    plot_flow_loops,
    plot_groups,
    plot_modulus,
    plot_network,
    plot_phase,
    plot_separated_pressure,
    plot_waterfall,
    plot_wave_intensity,
    source_looks,
    style,
    thinned,
    unwrapped,
    wall_lines,
)

T, N = 0.11, 200
P = 15 + 5 * np.sin(2 * np.pi * np.arange(N) / N) + np.sin(6 * np.pi * np.arange(N) / N)
Q = 0.2 + np.roll(P - 15, 10) / 60


@pytest.fixture
def ax():
    figure = Figure()
    yield (axis := figure.add_subplot())
    assert "[" in axis.get_ylabel() or "[" in axis.get_yticklabels()[0].get_text()
    figure.savefig(io.BytesIO(), format="svg")


@pytest.fixture(scope="module")
def station():
    return Station(Recording(P, Q, T), 0.007, 200.0, "mean pressure")


def test_the_mean_loop_of_a_group_has_its_mean_pressure_and_flow_and_closes(ax):
    results = made_results({"CTL": 3})
    plot_flow_loops(ax, results, group_looks(["CTL"])["CTL"])
    assert len(ax.lines) == 4
    loop = ax.lines[-1].get_xydata()
    np.testing.assert_array_equal(loop[0], loop[-1])
    expected = [np.mean([float(one.recording[name].mean()) for one in results]) for name in ("flow", "pressure")]
    np.testing.assert_allclose(loop[:-1].mean(axis=0), expected, rtol=2e-3)


def test_wave_intensity_is_drawn_as_computed_and_its_largest_waves_are_named(ax, station):
    waves = waves_dataset(station, 8e-4)
    assert plot_wave_intensity(ax, waves) is ax
    np.testing.assert_array_equal(ax.lines[0].get_ydata(), waves["WI_plus"])
    np.testing.assert_array_equal(ax.lines[1].get_ydata(), waves["WI_minus"])
    named = analysis.named_waves(analysis.wave_intensity(P, Q, T, 0.007, 200.0, 8e-4), T)
    largest = analysis.largest_waves(named)
    assert sorted(text.get_text() for text in ax.texts) == sorted(largest.index)
    for text in ax.texts:
        assert text.xy[0] * T == pytest.approx(largest.loc[text.get_text(), "peak time [s]"])


def test_separated_pressures_are_drawn(ax, station):
    plot_separated_pressure(ax, waves_dataset(station, 8e-4))
    together, forward, backward = (line.get_ydata() for line in ax.lines)
    np.testing.assert_allclose(forward + backward - P[0], P)
    np.testing.assert_array_equal(together, P)


@pytest.mark.parametrize(("draw", "values"), [(plot_modulus, "modulus"), (plot_phase, "phase")])
def test_harmonics_at_noise_level_are_apart_and_grey(ax, draw, values):
    rng = np.random.default_rng(0)
    found = analysis.impedance(P + rng.normal(0, 0.01, N), Q + rng.normal(0, 1e-4, N), T, flow_noise=1e-3)
    columns = {
        "frequency": found.frequency,
        "modulus": found.modulus,
        "phase": found.phase,
        "reliable": ~found.at_noise,
    }
    spectrum = xr.Dataset({name: ("harmonic", values) for name, values in columns.items()})
    reliable = spectrum["reliable"].values.astype(bool)
    assert 0 < (~reliable).sum() < 15
    draw(ax, spectrum)
    good, noise = ax.lines[:2]
    for line, those in ((noise, ~reliable), (good, reliable)):
        turns = (line.get_ydata() - spectrum[values].values[those]) / (2 * np.pi)
        np.testing.assert_allclose(turns, np.round(turns) if values == "phase" else 0.0, atol=1e-12)
    assert noise.get_color() == "0.6"


def test_every_animal_stands_beside_the_mean_of_its_group_with_its_interval_n_and_p(ax):
    table = published_table("optimized_linear")
    means = {("CTL", "measured"): Interval(60.0, 50.0, 70.0), ("HPH", "measured"): Interval(120.0, np.nan, np.nan)}
    plot_groups(ax, table, "beta [mmHg]", means=means, annotations={"HPH": "p = 0.01"})
    drawn = [bar.lines[0].get_ydata()[0] for bar in ax.containers]
    assert drawn == [60.0, 120.0]
    np.testing.assert_allclose(ax.containers[0].lines[2][0].get_segments()[0][:, 1], [50, 70])
    assert not ax.containers[1].lines[2]  # one of which nothing is known has no interval
    assert [text.get_text() for text in ax.texts] == ["p = 0.01"]
    points = np.concatenate([line.get_ydata() for line in ax.lines if line.get_marker() in ("o", "s")])
    assert sorted(points) == sorted(table["beta [mmHg]"])
    assert [label.get_text() for label in ax.get_xticklabels()] == ["CTL\nn = 7", "HPH\nn = 5"]


def test_the_autocorrelation_of_a_harmonic_is_its_cosine():
    r = np.sin(2 * np.pi * 3 * np.arange(N) / N)
    np.testing.assert_allclose(autocorrelation(r), np.cos(2 * np.pi * 3 * np.arange(N // 2 + 1) / N), atol=1e-12)


def test_groups_of_any_label_get_colors_and_markers_of_their_own():
    looks = group_looks(["HPH", "sham", "banded", "CTL", "sham"])
    assert list(looks) == ["HPH", "sham", "banded", "CTL"]
    assert (looks["CTL"].color, looks["HPH"].color) == (CTL, HPH)
    assert len({look.color for look in looks.values()}) == len({look.marker for look in looks.values()}) == 4


def test_walls_of_any_name_differ_in_grey_and_the_papers_two_keep_its_lines():
    walls = ["linear", "tangent", "power", "of_my_own", "mine_too"]
    lines = wall_lines(walls)
    assert (lines["linear"]["linestyle"], lines["tangent"]["linestyle"]) == ((0, (5, 2)), "solid")
    assert len({str(line["linestyle"]) for line in lines.values()}) == len(walls)
    assert len({look.hatch for look in source_looks(walls).values()}) == len(walls)
    assert all(look.short for look in source_looks(["measured", *walls]).values())


def test_a_thinned_trace_keeps_its_highest_spike_and_its_order():
    values = np.zeros(50_000)
    values[31_234] = 7.0
    time, kept = thinned(np.arange(50_000.0), values, 200)
    assert len(kept) <= 400
    assert time[np.argmax(kept)] == 31_234
    assert np.all(np.diff(time) > 0)


def test_a_waterfall_rises_from_one(ax):
    starts = xr.Dataset({"start_S": ("start", [4.0, 2.0, np.inf, 2.0])})
    plot_waterfall(ax, starts)
    np.testing.assert_array_equal(ax.lines[0].get_ydata(), [1.0, 1.0, 2.0])


def test_the_phase_of_a_delay_falls_on_a_line_and_a_noisy_harmonic_joins_it():
    line = -0.9 * np.arange(12)
    wrapped = np.angle(np.exp(1j * line))
    wrapped[7] += 0.4
    reliable = np.arange(12) != 7
    found = unwrapped(np.angle(np.exp(1j * wrapped)), reliable)
    np.testing.assert_allclose(found[reliable], line[reliable], atol=1e-12)
    assert found[7] == pytest.approx(line[7] + 0.4)


@pytest.mark.parametrize("name", ["v", "left_lower_lobe_artery"])
@pytest.mark.parametrize("generations", [3, 14])
def test_labels_of_a_network_never_touch_each_other(name, generations):
    parent = [-1] + [row // 2 * 2 for row in range(2 * generations)]  # a trunk that gives off a side branch each time
    names = tuple(f"{name}{row}" for row in range(len(parent)))
    network = Network(names, np.array(parent), np.full(len(parent), 0.1), np.full(len(parent), 0.02))
    with style():
        figure = new_figure(8.5, 2 + 0.8 * generations)
        drawn = plot_network(figure.subplots(), network)
        for _ in range(2):
            figure.draw_without_rendering()
    boxes = [text.get_window_extent() for text in drawn.texts if text.get_text()]
    assert len(boxes) >= 4
    assert not any(one.overlaps(other) for one, other in combinations(boxes, 2))
    assert {"inlet", "radius; arrows: flow"} <= {text.get_text() for text in drawn.texts}
