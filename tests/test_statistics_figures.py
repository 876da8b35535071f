import io

import matplotlib
import numpy as np
import pytest

matplotlib.use("Agg")
from matplotlib.figure import Figure

from vasowave import analysis
from vasowave.cohort import contrasts
from vasowave.datasets import published_table
from vasowave.figures.groups import plot_groups, plot_ratios
from vasowave.figures.residuals import autocorrelation, plot_autocorrelation, plot_residuals
from vasowave.figures.spectra import plot_modulus, plot_phase
from vasowave.figures.waves import plot_separated_pressure, plot_wave_intensity

T, N = 0.11, 200
P = 15 + 5 * np.sin(2 * np.pi * np.arange(N) / N) + np.sin(6 * np.pi * np.arange(N) / N)
Q = 0.2 + np.roll(P - 15, 10) / 60


@pytest.fixture
def ax():
    figure = Figure()
    yield (axis := figure.add_subplot())
    assert "[" in axis.get_ylabel() or "[" in axis.get_yticklabels()[0].get_text()
    figure.savefig(io.BytesIO(), format="svg")


def test_wave_intensity_is_drawn_as_computed_and_its_waves_are_named(ax):
    waves = analysis.wave_intensity(P, Q, T, 0.007, 200.0, 8e-4)
    named = analysis.named_waves(waves, T)
    assert plot_wave_intensity(ax, waves, T, named) is ax
    np.testing.assert_array_equal(ax.lines[0].get_ydata(), waves.forward_intensity)
    np.testing.assert_array_equal(ax.lines[1].get_ydata(), waves.backward_intensity)
    assert [text.get_text() for text in ax.texts] == named["wave"].tolist()


def test_separated_pressures_are_drawn(ax):
    waves = analysis.wave_intensity(P, Q, T, 0.007, 200.0, 8e-4)
    plot_separated_pressure(ax, waves, T)
    np.testing.assert_allclose(ax.lines[0].get_ydata() + ax.lines[1].get_ydata() - P[0], P)


@pytest.mark.parametrize(("draw", "values"), [(plot_modulus, "modulus"), (plot_phase, "phase")])
def test_harmonics_at_noise_level_are_apart_and_grey(ax, draw, values):
    rng = np.random.default_rng(0)
    spectrum = analysis.impedance(P + rng.normal(0, 0.01, N), Q + rng.normal(0, 1e-4, N), T, flow_noise=1e-3)
    assert 0 < spectrum.at_noise.sum() < 15
    draw(ax, spectrum)
    good, noise = ax.lines[:2]
    np.testing.assert_array_equal(noise.get_ydata(), getattr(spectrum, values)[spectrum.at_noise])
    np.testing.assert_array_equal(good.get_ydata(), getattr(spectrum, values)[~spectrum.at_noise])
    assert noise.get_color() == "0.6"


def test_every_animal_stands_beside_its_box(ax):
    table = published_table("optimized_linear")
    plot_groups(ax, table, "beta [mmHg]")
    points = np.concatenate([line.get_ydata() for line in ax.lines if line.get_marker() == "o"])
    assert sorted(points) == sorted(table["beta [mmHg]"])
    assert [label.get_text() for label in ax.get_xticklabels()] == ["CTL (n = 7)", "HPH (n = 5)"]


def test_ratios_stand_with_their_intervals(ax):
    found = contrasts(published_table("optimized_linear"), ["beta [mmHg]", "S [mmHg2]"], "CTL", "HPH")
    plot_ratios(ax, found)
    bars = ax.containers[0].lines[2][0].get_segments()
    np.testing.assert_allclose([bar[:, 0] for bar in bars], found[["ratio low", "ratio high"]])


def test_the_autocorrelation_of_a_harmonic_is_its_cosine_and_both_plots_show_the_models(ax):
    r = np.sin(2 * np.pi * 3 * np.arange(N) / N)
    np.testing.assert_allclose(autocorrelation(r), np.cos(2 * np.pi * 3 * np.arange(N // 2 + 1) / N), atol=1e-12)
    plot_residuals(ax, {"linear": r, "tangent": 2 * r}, T)
    assert [line.get_linestyle() for line in ax.lines[:2]] == ["--", "-"]
    np.testing.assert_array_equal(ax.lines[1].get_ydata(), 2 * r)
    ax.clear()
    plot_autocorrelation(ax, {"linear": r}, T)
    np.testing.assert_allclose(ax.lines[0].get_ydata(), autocorrelation(r))
