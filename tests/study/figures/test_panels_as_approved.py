"""What panels are asked to draw, as agreed: values, looks and words before anything is laid out; see approval.py."""

import numpy as np
import pandas as pd
import pytest
import xarray as xr

from approval import approve, artists
from made_cohort import bare_law, bare_result
from vasowave.catheter import average_beats, synthetic_raw_recording
from vasowave.pulse.cycle import Recording
from vasowave.pulse.examples import published_table
from vasowave.pulse.network import Network
from vasowave.study.animal import FitPlots
from vasowave.study.cohort import Interval, contrasts, gathered
from vasowave.study.figures import (
    PANELS,
    draw_average,
    draw_raw,
    group_looks,
    importance_figure,
    plot_cells,
    plot_groups,
    plot_mean_waveform,
    plot_modulus,
    plot_network,
    plot_phase,
    plot_ratios,
    plot_vessel,
    sites_figure,
    source_looks,
    ventricle_figure,
)

pytestmark = pytest.mark.usefixtures("in_style")

SHARE = np.arange(64) / 64
PRESSURE = 15 + 5 * np.sin(2 * np.pi * SHARE)


def test_approved_a_network_with_two_inlets_and_a_loop(ax):
    """The vessel that closes the loop carries blood from its end to its beginning: its arrow is turned."""
    nodes = [[0, 2], [1, 2], [2, 3], [2, 4], [4, 3], [3, 5], [4, 6]]
    network = Network(tuple("abcdefg"), None, np.full(7, 0.3), np.array([5, 4, 3.1, 3, 0.3, 3, 1]) / 100, nodes=nodes)
    plot_network(ax, network, "#00a7c4", [f"tip {name}" for name in "abcdefg"])
    arrows = [text.arrow_patch.get_linewidth() for text in ax.texts if text.arrow_patch][:7]
    assert arrows == pytest.approx(np.maximum(0.5, 6.0 * network.radius / 0.05))
    approve("panel, network", artists(ax.figure))


CELLS = pd.DataFrame(
    [
        (f"{group}{mouse} {level}", f"{group}{mouse}", group, f"{group}, {level}", level, source, value)
        for place, group in enumerate(("CTL", "HPH"))
        for mouse in range(2)
        for later, level in enumerate(("before", "one hour later"))
        for law, source in enumerate(("linear", "tangent"))
        for value in [np.nan if (place, mouse, later) == (1, 1, 1) else 10.0 + 4 * place + mouse + 0.3 * later + law]
    ],
    columns=["animal", "subject", "group", "cell", "level", "source", "R [1]"],
)


@pytest.mark.parametrize("room", [10, 200])
def test_approved_levels_of_groups_by_the_room_for_their_names(ax, room):
    means = {("HPH, before", "linear"): Interval(14.5, 13.0, 16.0), ("CTL, before", "tangent"): Interval(11.5, 9, 13)}
    looks = group_looks(["CTL", "HPH"]), source_looks(["linear", "tangent"])
    plot_cells(ax, CELLS, "R [1]", "resistance [1]", looks, means, room)
    points = [line.get_ydata()[0] for line in ax.lines if line.get_marker() in ("o", "s")]
    assert sorted(points) == pytest.approx(sorted(CELLS["R [1]"].dropna()))
    assert ax.get_xticks() == pytest.approx([0, 1, 2.7, 3.7, 5.4, 6.4, 8.1, 9.1])
    approve(f"panel, levels in a room of {room}", artists(ax.figure))


def test_approved_groups_by_two_laws_with_means_and_p(ax):
    table = pd.DataFrame({"animal": list("abcdefgh"), "subject": list("aacdefgh"), "group": ["CTL"] * 4 + ["HPH"] * 4,
                          "source": ["linear", "tangent"] * 4, "x [1]": [3.0, 1, 2, np.nan, 8, 6, 7, 5]})  # fmt: skip
    means = {("CTL", "linear"): Interval(2.5, 2.0, 3.0), ("HPH", "tangent"): Interval(5.5, np.nan, np.nan)}
    plot_groups(ax, table, "x [1]", means=means, annotations={"HPH": "p = 0.03"}, named=False)
    plot_groups(ax.figure.add_subplot(122), table[["group", "x [1]"]], "x [1]", "named [1]")
    approve("panel, groups", artists(ax.figure))


def test_approved_importance_of_data_and_models(cohort_results):
    cohort = gathered(cohort_results)
    rows = [
        (name, source, group, 0.1 * place, 0.1 * place - 0.2, 0.1 * place + 0.3)
        for place, name in enumerate(("mPAP", "R_T", "beta"))
        for source in ("measured", "linear", "tangent")
        for group in ("CTL", "HPH")
    ]
    indices = pd.DataFrame(rows, columns=["quantity", "source", "group", "eta", "low", "high"])
    indices.loc[0, "low"] = indices.loc[0, "eta"] + 1e-13  # an end that rounding puts inside
    measured = indices["source"] == "measured"
    approve("panel, importance", [
        *artists(importance_figure(cohort, indices[measured], indices[~measured])),
        *artists(importance_figure(cohort, indices[measured], indices[:0])),
    ])  # fmt: skip


def test_approved_mean_waveforms_with_their_band(ax, cohort_results):
    plot_mean_waveform(ax, cohort_results[:1], "pressure", group_looks(["CTL"])["CTL"])
    assert not ax.lines  # one animal has no mean
    plot_mean_waveform(ax, cohort_results[:3], "pressure", group_looks(["CTL"])["CTL"])
    approve("panel, mean waveform", artists(ax.figure))


def test_approved_spectra_with_errors(ax):
    frequency = np.arange(5) * 9.0
    spectrum = xr.Dataset({
        "frequency": ("harmonic", frequency), "modulus": ("harmonic", [80.0, 12, 6, 9, 7]),
        "phase": ("harmonic", [0.0, -1.1, -3.0, 2.9, 0.3]), "reliable": ("harmonic", [True, True, True, True, False]),
    })  # fmt: skip
    plot_modulus(ax, spectrum, np.array([0.01, 0.02, 0.05, 0.1, 0.2]), markersize=2)
    plot_phase(ax.figure.add_subplot(122), spectrum, np.array([0.01, 0.02, 0.05, 0.1, 0.2]))
    assert ax.figure.axes[1].lines[0].get_ydata() == pytest.approx([0.0, -1.1, -3.0, 2.9 - 2 * np.pi])
    approve("panel, spectra", artists(ax.figure))


def test_approved_a_ventricle():
    share = np.arange(33) / 32
    shape = np.sin(np.pi * share) ** 2
    data = xr.Dataset({
        "time": ("time", 0.05 * share), "pressure": ("time", 25 * shape), "fitted_pressure": ("time", 24 * shape),
        "isovolumic_pressure": ("time", 60 * np.sin(np.pi * share**1.3)), "volume": ("time", 0.04 - 0.02 * share),
        "stroke_volume": 0.02,
    })  # fmt: skip
    figure = ventricle_figure(data)
    ventricle, artery = figure.axes[1].lines[1:3]
    assert ventricle.get_xdata() == pytest.approx([0, 40])  # µl
    assert artery.get_xdata() == pytest.approx([40, 20])
    approve("panel, ventricle", artists(figure))


@pytest.mark.parametrize("count", [1, 3])
def test_approved_further_sites(count):
    time = np.arange(8) / 80
    nothing = np.full(8, np.nan)
    sites = xr.Dataset(
        {
            "time": (("site", "time"), np.tile(time, (3, 1))),
            "measured": (("site", "time"), np.stack([nothing, 10 + time, nothing])),
            "predicted": (("site", "time"), np.stack([time, 11 + time, 5 * time])),
            "simulated": (("site", "time"), np.stack([2 * time, 10.5 + time, 4 * time])),
            "observed": ("site", ["flow", "pressure", "area"]),
            "unit": ("site", ["ml/s", "mmHg", "cm2"]),
            **{name: ("site", row) for name, row in (("mean", [0.1, np.nan, np.nan]), ("systolic", [0.3, np.nan, 0.4]),
                                                      ("diastolic", [np.nan] * 3))},
        },
        coords={"site": ["flow in '2'", "pressure in '3', of a name that is far longer than a title", "area in '4'"]},
    )  # fmt: skip
    laws = {wall: bare_law(wall, sites=sites.isel(site=slice(count))) for wall in ("linear", "tangent")}
    recording = xr.Dataset(attrs={"period": 0.1})
    approve(f"panel, sites {count}", artists(sites_figure(bare_result(recording=recording, laws=laws))))


def test_approved_a_raw_recording_and_its_average():
    cycle = Recording(PRESSURE, 0.2 + 0.06 * (PRESSURE - 15), 0.11)
    raw = synthetic_raw_recording(cycle, np.random.default_rng(1), duration=6.0).raw
    panels = draw_raw(raw, slice(1, 1.5))
    first = panels[0].lines[0]
    assert first.get_xdata()[0] == pytest.approx(1.0)
    assert first.get_ydata()[0] == raw.pressure[round(raw.sampling_rate)]
    average = draw_average(average_beats(raw, 10))
    approve("panel, raw", [*artists(panels[0].figure), *artists(average[0].figure)], relative=2e-3)


@pytest.mark.parametrize("name", PANELS)
def test_approved_the_panels_of_a_fit(ax, cohort_results, name):
    getattr(FitPlots(cohort_results[4], "#d6259b", shaded=name != "flow"), name)(ax)
    approve(f"panel, fit's {name}", artists(ax.figure))


def test_approved_a_vessel_of_a_fit(ax, cohort_results):
    plot_vessel(ax, cohort_results[4], cohort_results[4].root, "pressure", "#00a7c4")
    plot_vessel(ax.figure.add_subplot(122), cohort_results[4], "3", "flow", "#00a7c4")
    approve("panel, vessel", artists(ax.figure))


def test_approved_ratios_of_published_groups(ax):
    plot_ratios(ax, contrasts(published_table("optimized_linear"), ["beta [mmHg]", "S [mmHg2]"], "CTL", "HPH"))
    approve("panel, ratios", artists(ax.figure))
