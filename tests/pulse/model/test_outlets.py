"""Beds against their differential equation, solved by SciPy, and against sums by hand."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import vasowave as vw
from vasowave.base import InputError
from vasowave.pulse.model import Circuit, CompliantBed, ReflectionCoefficient, Windkessel

R1, R2, C = np.array([12.0, 30.0]), np.array([90.0, 200.0]), np.array([1e-3, 4e-4])
CIRCUIT = Circuit(R1, R2, C)
OMEGA = 2 * np.pi / 0.11 * np.arange(4)


def test_the_impedance_is_pressure_over_flow_of_a_long_harmonic():
    """C dp/dt = q - p/R2 behind R1, driven by a cosine until the start is forgotten."""
    omega = OMEGA[1]
    for j in range(2):

        def fall(t, p, j=j):
            return (np.cos(omega * t) - p / R2[j]) / C[j]

        end = 12 * R2[j] * C[j]
        times = np.linspace(end, end + 0.11, 65)[:-1]
        solved = solve_ivp(fall, (0, times[-1]), [0.0], t_eval=times, rtol=1e-9, atol=1e-12).y[0]
        pressure = solved + R1[j] * np.cos(omega * times)
        measured = 2 * np.mean(pressure * np.exp(-1j * omega * times))
        assert CIRCUIT.impedance(np.array([[omega]]))[0, j] == pytest.approx(measured, rel=1e-4)


def test_a_pressure_behind_the_bed_passes_as_through_r2_into_c():
    """Where nothing flows in, C dp/dt = (p_behind - p)/R2."""
    omega, j = OMEGA[1], 1
    end = 12 * R2[j] * C[j]
    times = np.linspace(end, end + 0.11, 65)[:-1]
    solved = solve_ivp(lambda t, p: (np.cos(omega * t) - p) / (R2[j] * C[j]), (0, times[-1]), [0.0], t_eval=times,
                       rtol=1e-9, atol=1e-12).y[0]  # fmt: skip
    measured = 2 * np.mean(solved * np.exp(-1j * omega * times))
    assert CIRCUIT.passes(np.array([[omega]]))[0, j] == pytest.approx(measured, rel=1e-4)
    assert CIRCUIT.passes(np.zeros((1, 1)))[0] == pytest.approx(1.0)


@pytest.mark.parametrize(("harmonic", "value"), [(0, 0.0), (1, np.nan), (2, -1.0)])
def test_the_one_vessel_whose_impedance_cannot_be_is_named(harmonic, value):
    spectrum = np.full((3, 2), 100.0 + 0j)
    assert vw.ImpedanceSpectrum(spectrum).checked(("a", "b"))
    spectrum[harmonic, 1] = value
    with pytest.raises(InputError, match="vessel 'b': its impedance is not finite, or its resistance is not positive"):
        vw.ImpedanceSpectrum(spectrum).checked(("a", "b"))
    with pytest.raises(InputError, match=r"has shape \(3, 2\); it must be \(harmonics, 3\)"):
        vw.ImpedanceSpectrum(spectrum).checked(("a", "b", "c"))


def test_compliant_beds_of_other_totals_have_these_and_keep_what_was_not_named():
    """1/R_T = Σ 1/R, the times are R C; twice the resistance at the same times is half the compliance."""
    beds, shares = CompliantBed([150.0, 200.0, 100.0], [1e-3, 8e-4, 3e-3]), np.full(3, 1 / 3)
    total, times = 1 / (1 / 150 + 1 / 200 + 1 / 100), np.array([0.15, 0.16, 0.3])
    assert beds.total_resistance() == pytest.approx(total)
    higher = beds.with_totals(shares, {"R_T": 2 * total})
    np.testing.assert_allclose(higher.R, [300.0, 400.0, 200.0])
    np.testing.assert_allclose(higher.C, [5e-4, 4e-4, 1.5e-3])
    slower = beds.with_totals(shares, {"tau": 3 * 0.16})  # the middle one
    np.testing.assert_allclose(slower.R, [150.0, 200.0, 100.0])
    np.testing.assert_allclose(slower.time_constants(), 3 * times)


def test_windkessels_of_other_totals_are_shared_by_the_flow_as_the_paper_does():
    """R_i = R_T/q_i, R1 = a R, R2 = (1 - a) R, C = τ/R (eqs. 11, 13); the time R2 C is (1 - a) τ."""
    beds, shares = Windkessel([20.0, 30.0, 10.0], [80.0, 170.0, 90.0], [1e-3, 8e-4, 3e-3]), np.array([0.5, 0.3, 0.2])
    found = beds.with_totals(shares, {"R_T": 60.0, "a": 0.25, "tau": 0.12})
    np.testing.assert_allclose(found.R1, [30.0, 50.0, 75.0])
    np.testing.assert_allclose(found.R2, [90.0, 150.0, 225.0])
    np.testing.assert_allclose(found.C, [1e-3, 6e-4, 4e-4])
    kept, ratio = beds.with_totals(shares, {}), (0.2 + 0.15 + 0.1) / 3
    assert kept.total_resistance() == pytest.approx(1 / (1 / 100 + 1 / 200 + 1 / 100))
    np.testing.assert_allclose(kept.R1 / (kept.R1 + kept.R2), ratio)
    np.testing.assert_allclose(kept.time_constants(), 0.136)  # the median of 0.08, 0.136 and 0.27


def test_a_reflection_coefficient_is_that_of_a_wave_at_a_resistance():
    """At the end of a vessel of impedance Z a resistance R reflects (R - Z)/(R + Z) of a wave."""
    resistance = np.array([100.0, 400.0])
    beds = ReflectionCoefficient.nominal(resistance, 0.1)
    np.testing.assert_allclose(beds.R_t, (resistance - beds.Z_c) / (resistance + beds.Z_c))
    np.testing.assert_allclose(beds.circuit().proximal, resistance)
    assert beds.total_resistance() == pytest.approx(80.0)
    lower = beds.with_totals(np.full(2, 0.5), {"R_T": 40.0})
    np.testing.assert_allclose(lower.circuit().proximal, [50.0, 200.0])
    with pytest.raises(InputError, match=r"vessel 'b': R_t = -1; it lies between -1 and 1"):
        ReflectionCoefficient(beds.Z_c, np.array([0.99, -1.0])).checked(("a", "b"))
