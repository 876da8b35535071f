"""Beds against their differential equation, solved by SciPy, and against sums by hand."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import vasowave as vw
from vasowave.datasets import control_network
from vasowave.errors import InputError
from vasowave.model.blood import Blood
from vasowave.model.outlets import Circuit, CompliantBed, ReflectionCoefficient, Resistance, Site, Windkessel

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


def test_a_circuit_as_a_rational_function_is_the_same_impedance_also_without_a_capacitor():
    mixed = Circuit(R1, np.array([90.0, 0.0]), np.array([1e-3, 0.0]))
    for one in (CIRCUIT, mixed):
        found = one.rational()
        expected = one.impedance(OMEGA[:, np.newaxis])
        poles, residues = found.poles, found.residues
        by_parts = (
            found.direct + (residues / (1j * OMEGA[:, None, None] - poles)).sum(axis=-1) if poles.ndim == 2 else None
        )
        assert by_parts == pytest.approx(expected)


def test_totals_of_beds_are_sums_by_hand():
    beds = Windkessel(R1, R2, C)
    whole = R1 + R2
    assert beds.total_resistance() == pytest.approx(1 / np.sum(1 / whole))
    assert beds.resistance_ratio() == pytest.approx(np.mean(R1 / whole))
    assert beds.time_constants() == pytest.approx(R2 * C)
    assert beds.weighted_compliance() == pytest.approx(R2 / whole * C)
    assert beds.fast_resistance() == pytest.approx(R1)
    assert beds.knobs() == {"R_T": "mmHg s/ml", "a": "1", "tau": "s"}
    assert beds.impedance_at(4, 0.11) == pytest.approx(R1 + R2 / (1 + 1j * OMEGA[:, None] * R2 * C))
    assert beds.impedance(OMEGA[1]).shape == (2,)


def test_beds_of_other_totals_keep_the_rest():
    compliant = CompliantBed(R2, C)
    fractions = np.array([0.6, 0.4])
    stiffer = compliant.with_totals(fractions, {"R_T": 2 * compliant.total_resistance()})
    assert stiffer.total_resistance() == pytest.approx(2 * compliant.total_resistance())
    assert stiffer.time_constants() == pytest.approx(R2 * C)
    slower = compliant.with_totals(fractions, {"tau": 3 * float(np.median(R2 * C))})
    assert slower.time_constants() == pytest.approx(3 * R2 * C)
    assert slower.total_resistance() == pytest.approx(compliant.total_resistance())
    assert compliant.knobs() == {"R_T": "mmHg s/ml", "tau": "s"}
    bare = Resistance(R1)
    assert bare.knobs() == {"R_T": "mmHg s/ml"}
    assert np.asarray(bare.with_totals(fractions, {"R_T": 30.0}).R) == pytest.approx(R1 * 30 / bare.total_resistance())
    made = Windkessel(R1, R2, C).with_totals(fractions, {"R_T": 50.0, "a": 0.2, "tau": 0.1})
    whole = 50.0 / fractions
    assert (made.R1, made.R2) == (pytest.approx(0.2 * whole), pytest.approx(0.8 * whole))
    assert made.C == pytest.approx(0.1 / whole)


def test_fields_are_scaled_and_moved_one_by_one():
    beds = Windkessel(R1, R2, C).scaled(2.0, 3.0, 0.5)
    assert (beds.R1, beds.R2, beds.C) == (pytest.approx(2 * R1), pytest.approx(3 * R2), pytest.approx(C / 2))
    moved = Windkessel(R1, R2, C).moved(np.log([[2.0, 1.0], [1.0, 3.0], [1.0, 1.0]]))
    assert moved.R1 == pytest.approx([24.0, 30.0])
    assert moved.R2 == pytest.approx([90.0, 600.0])


def test_coefficients_of_a_network_reflect_so_that_the_beds_have_the_resistance():
    network, blood = control_network(), Blood()
    beds = ReflectionCoefficient.of(network, Site(80.0, 0.1, 50.0, blood))
    assert beds.total_resistance() == pytest.approx(80.0)
    ends = network.terminals
    speed = np.sqrt(50.0 / (2 * blood.inertia))  # (β/2ρ)^½
    assert np.asarray(beds.Z_c) == pytest.approx(blood.inertia * speed / network.area[ends])


def test_a_spectrum_is_what_it_was_given():
    Z = vw.Windkessel(R1, R2, C).impedance(2 * np.pi / 0.11 * np.arange(24))
    one = vw.ImpedanceSpectrum(Z)
    assert one.total_resistance() == pytest.approx(1 / np.sum(1 / (R1 + R2)))
    assert one.resistance_ratio() == pytest.approx(np.mean(R1 / (R1 + R2)), rel=1e-3)
    assert np.isnan(one.time_constants()).all()
    assert one.rational(0.11).direct == pytest.approx(R1, rel=1e-3)
    longer = one.impedance_at(30, 0.11)
    assert np.array_equal(longer[:24], Z)
    assert longer == pytest.approx(vw.Windkessel(R1, R2, C).impedance(2 * np.pi / 0.11 * np.arange(30)), rel=1e-3)
    with pytest.raises(InputError, match="names no capacitor"):
        one.weighted_compliance()
