"""Impedances as rational functions: what they keep, that no bed gives off energy, and the steps that follow."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from vasowave.base import InputError
from vasowave.pulse.model import ImpedanceSpectrum, Windkessel, fitted

HARMONICS = 2 * np.pi / 0.11 * np.arange(40)


def resonant(omega, factor=1.0):
    """A tube of two sections, open at the end, behind a resistance: peaks that no relaxation has."""
    s = 1j * omega
    return 20.0 + factor * 130.0 / (1 + 0.09 * s) + 4e4 * (s + 40.0) / ((s + 40.0) ** 2 + 700.0**2)


@pytest.mark.parametrize("count", [3, 20, 200])
@pytest.mark.parametrize("time_constant", [0.005, 0.1, 3.0])
def test_a_windkessel_is_found_again_however_many_harmonics_are_given(count, time_constant):
    beds = Windkessel(*np.array([[20.0, 0.5], [130.0, 50.0], [time_constant / 130, time_constant / 20]]))
    spectrum = ImpedanceSpectrum(beds.impedance_at(count, 0.11))
    found = spectrum.rational(0.11)
    np.testing.assert_allclose(found.direct, beds.R1, rtol=1e-6)
    np.testing.assert_allclose(-1 / found.poles[:, 0].real, beds.R2 * beds.C, rtol=1e-6)
    np.testing.assert_allclose(1 / found.residues[:, 0].real, beds.C, rtol=1e-6)
    beyond = 2 * np.pi / 0.11 * 10.0 * count
    np.testing.assert_allclose(found.impedance(1j * beyond), beds.impedance(beyond), rtol=1e-6)


def test_peaks_of_a_bed_are_met_and_its_resistance_is_kept():
    Z = resonant(HARMONICS)
    found = fitted(HARMONICS, Z)
    np.testing.assert_allclose(found.impedance(1j * HARMONICS)[:, 0], Z, rtol=1e-4)
    assert found.impedance(np.array(0.0))[0] == pytest.approx(Z[0].real, rel=1e-12)
    assert np.any(found.poles.imag > 0)
    assert np.all(found.poles.real < 0)


@pytest.mark.parametrize("seed", range(20))
def test_no_frequency_gives_off_energy_whatever_was_measured(seed):
    rng = np.random.default_rng(seed)
    s, sharp, at = 1j * HARMONICS, rng.uniform(20, 60), HARMONICS[rng.integers(5, 26)]
    Z = 20 + 130 / (1 + 0.09 * s) - rng.uniform(3, 5) * 20 * sharp * (s + sharp) / ((s + sharp) ** 2 + at**2)
    assert Z.real.min() < -5  # what was measured has a dip below zero, and noise on top
    Z = Z * (1 + 1e-3 * rng.standard_normal(len(Z)) + 1e-3j * rng.standard_normal(len(Z)))
    Z[0] = abs(Z[0])
    found = fitted(HARMONICS, Z)
    everywhere = np.sort(np.concatenate([np.linspace(0.0, 4e3, 40001), np.geomspace(1e-2, 1e9, 20001)]))
    assert found.impedance(1j * everywhere).real.min() > -1e-6 * Z[0].real
    assert found.direct[0] >= 0
    assert found.impedance(np.array(0.0))[0] == pytest.approx(Z[0].real, rel=1e-6)
    assert np.all(found.poles.real < 0)


def test_a_spectrum_that_no_bed_has_is_refused_by_the_name_of_its_vessel():
    Z = np.stack([resonant(HARMONICS), resonant(HARMONICS)], axis=1)
    assert ImpedanceSpectrum(Z).checked(("a", "b"))
    Z[1:-1, 1] = -Z[1:-1, 1]
    with pytest.raises(InputError, match=r"vessel 'b': no passive bed has this impedance, whose real part is -462"):
        ImpedanceSpectrum(Z).checked(("a", "b"))


def test_a_phase_of_the_other_sign_is_named_as_such():
    Z = resonant(HARMONICS)[:, np.newaxis].conj()
    with pytest.raises(InputError, match=r"vessel 'a': the sign of this impedance's phase looks turned.* 0\.0 % with"):
        ImpedanceSpectrum(Z).checked(("a",))


def tube(harmonics, quarter, load, loss=0.15):
    """Impedance of a tube of Z_c = 20 with a load, whose length is a quarter of the wave of a harmonic."""
    s = 1j * np.arange(harmonics + 1)
    series, shunt = s + loss, np.where(s == 0, 1e-300, s)
    across = 20.0 * np.sqrt(series / shunt)
    turned = np.tanh(0.5 * np.pi / quarter * np.sqrt(series * shunt))
    Z = across * (load + across * turned) / (across + load * turned)
    Z[0] = load + 20.0 * loss * 0.5 * np.pi / quarter  # its steady resistance
    return Z


@pytest.mark.parametrize(("quarter", "load"), [(1.7, 60.0), (2.3, 20.0), (4.0, 400.0), (3.1, 6000.0)])
def test_a_tube_before_its_load_is_stepped_with_all_its_resonances(quarter, load):
    Z = tube(64, quarter, load)
    bed = ImpedanceSpectrum(Z[:, np.newaxis]).checked(("a",))
    met = bed.rational(2 * np.pi).impedance(1j * np.arange(65))[:, 0]
    worst = np.max(np.abs(met - Z)[1:11] / np.abs(Z)[1:11])
    assert worst == pytest.approx(bed.misfit(0.11)[0], rel=1e-9)
    assert worst < 0.005


def test_a_nearly_closed_tube_of_many_resonances_is_not_refused_and_gives_off_no_energy():
    Z = tube(64, 1.1, 2000.0)
    bed = ImpedanceSpectrum(Z[:, np.newaxis]).checked(("a",))
    met = bed.rational(2 * np.pi).impedance(1j * np.arange(65))[:, 0]
    assert np.max(np.abs(met - Z)[1:11] / np.abs(Z)[1:11]) < 0.05
    assert bed.rational(2 * np.pi).impedance(1j * np.linspace(0.0, 300.0, 30001)).real.min() > -1e-6 * Z[0].real


def test_the_error_of_a_spectrum_is_that_of_its_rational_function():
    assert ImpedanceSpectrum(resonant(HARMONICS)[:, np.newaxis]).error[0] < 1e-4
    noise = 1 + 0.05 * np.random.default_rng(0).standard_normal(len(HARMONICS))
    assert 0.01 < ImpedanceSpectrum((resonant(HARMONICS) * noise)[:, np.newaxis]).error[0] < 0.1


def test_a_step_is_the_solution_of_the_differential_equations():
    beds = fitted(HARMONICS, resonant(HARMONICS))
    flow, time = 0.7, 0.003
    left, gained = beds.over(time)
    start = np.array([3.0 + 1.0j, 2.0, -1.0 + 0.5j, 0.5][: beds.poles.shape[1]] + [0j] * (beds.poles.shape[1] - 4))

    def change(_, x):
        return beds.poles[0] * x + beds.residues[0] * flow

    expected = solve_ivp(change, (0, time), start.astype(complex), rtol=1e-10, atol=1e-10).y[:, -1]
    np.testing.assert_allclose(left[0] * start + gained[0] * flow, expected, rtol=1e-6, atol=1e-7)


def test_the_modes_of_a_periodic_flow_are_those_to_which_steps_lead():
    beds = fitted(HARMONICS, resonant(HARMONICS))
    count, period = 4000, 0.11
    t = np.arange(count) * period / count
    flow = 0.3 + np.cos(2 * np.pi * t / period - 0.4) + 0.5 * np.sin(6 * np.pi * t / period)
    left, gained = beds.over(period / count)
    x = np.zeros_like(left)
    for q in np.tile(flow, 12):
        x = left * x + gained * q
    spectrum = np.fft.rfft(flow)[:5, np.newaxis] / count
    spectrum[1:] *= 2
    np.testing.assert_allclose(x, beds.waves(spectrum, period, -0.5 * period / count), atol=1e-3 * np.abs(x).max())
