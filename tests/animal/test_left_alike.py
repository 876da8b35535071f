"""What the models leave of the pressure, and what of it all animals have in common."""

import numpy as np
import pytest

from made_cohort import made_results
from vasowave.cohort import gathered
from vasowave.cohort.discrepancy import ALIKE, discrepancies, rayleigh
from vasowave.report.sections.models import left_alike


@pytest.fixture
def cohort():
    return gathered(made_results({"CTL": 4, "HPH": 3}, walls=("linear",)))


def plant(result, rng, harmonic, modulus):
    """Give the residual chance phases and, in one harmonic, one phase to the first of the measured pressure."""
    fit, pressure = result.laws["linear"].calibration, result.recording["pressure"].values
    begin, count = np.angle(np.fft.rfft(pressure)[1]), fit.sizes["harmonic"]
    samples = fit.sizes["time"]
    amplitudes = 0.1 * np.exp(2j * np.pi * rng.random(count))
    amplitudes[harmonic] = modulus * np.exp(1j * (0.4 + harmonic * begin))
    whole = np.zeros(samples // 2 + 1, dtype=complex)
    whole[:count] = amplitudes[: len(whole)] * samples / 2
    residual = np.fft.irfft(whole, samples)
    fit["pressure_residual"].values = residual
    fit["residual_modulus"].values = np.abs(np.fft.rfft(residual))[:count] * 2 / samples


def test_a_harmonic_that_is_left_with_one_phase_in_all_animals_is_found_and_no_other(cohort):
    rng = np.random.default_rng(2)
    for result in cohort.results:
        plant(result, rng, 3, 0.2)
    found = discrepancies(cohort, "linear")
    table = found.set_index("harmonic")
    assert table.index[table["alike"]].tolist() == [3]
    assert table.loc[3, "common [mmHg]"] == pytest.approx(0.2, rel=1e-9)
    assert table.loc[3, "share"] == pytest.approx(1.0, rel=1e-9)
    assert table.loc[2, "residual [mmHg]"] == pytest.approx(0.1, rel=1e-9)
    sentence = left_alike("linear", found, len(cohort.results))
    assert "harmonic 3 (0.2 mmHg)" in sentence
    assert "alike in all 7 animals" in sentence


def test_what_rounding_leaves_has_no_phase_that_animals_could_share(cohort):
    for result in cohort.results:
        plant(result, np.random.default_rng(2), 3, 0.2)  # all harmonics alike in all animals …
        fit = result.laws["linear"].calibration
        fit["pressure_residual"].values = 1e-12 * fit["pressure_residual"].values  # … of nothing
        fit["residual_modulus"].values = 1e-12 * fit["residual_modulus"].values
    table = discrepancies(cohort, "linear")
    assert not table["alike"].any()
    assert table["p"].isna().all()
    assert (table["residual [mmHg]"] == 0).all()


def test_where_a_cycle_begins_says_nothing_of_what_the_model_leaves(cohort):
    rng = np.random.default_rng(2)
    for result in cohort.results:
        plant(result, rng, 3, 0.2)
    before = discrepancies(cohort, "linear")
    result = cohort.results[0]
    pressure, residual = (
        result.recording["pressure"].values,
        result.laws["linear"].calibration["pressure_residual"].values,
    )
    quarter = [  # of the cycle, by the spectrum: the two have other samples
        np.fft.irfft(np.fft.rfft(x) * np.exp(0.5j * np.pi * np.arange(len(x) // 2 + 1)), len(x))
        for x in (pressure, residual)
    ]
    result.recording["pressure"].values, result.laws["linear"].calibration["pressure_residual"].values = quarter
    after = discrepancies(cohort, "linear")
    np.testing.assert_allclose(after["common [mmHg]"], before["common [mmHg]"], rtol=1e-6)


@pytest.mark.parametrize("animals", [5, 7, 20])
def test_chance_phases_are_called_alike_as_seldom_as_said(animals):
    p = rayleigh(2 * np.pi * np.random.default_rng(5).random((animals, 40_000)))
    for level in (ALIKE, ALIKE / 18):
        assert np.mean(p < level) < 1.15 * level + 3 * np.sqrt(level / 40_000)
    assert np.mean(p < ALIKE) > 0.8 * ALIKE


def test_four_animals_have_nothing_said_in_common():
    assert discrepancies(gathered(made_results({"CTL": 4}, walls=("linear",))), "linear").empty
