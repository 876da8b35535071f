import numpy as np
import pytest

from vasowave.analysis import compliance, fourier_series, impedance, wave_intensity
from vasowave.analysis.compliance import series_parallel
from vasowave.datasets import control_network
from vasowave.errors import InputError
from vasowave.model import Model
from vasowave.network import Network
from vasowave.outlets import Windkessel
from vasowave.walls import LinearWall, area

T, RHO, C, A0 = 0.11, 1.057 / 1333.22, 220.0, 0.0069
TIME = np.arange(512) * T / 512
PLUS = 15 + 5 * np.sin(2 * np.pi * TIME / T) + np.cos(6 * np.pi * TIME / T)


def test_two_waves_that_were_added_are_separated_again():
    minus = 0.4 * np.roll(PLUS, 60)
    u = (PLUS - minus) / (RHO * C)
    waves = wave_intensity(PLUS + minus, u * A0, T, A0, C, RHO)
    np.testing.assert_allclose(np.diff(waves.forward_pressure), np.diff(PLUS), atol=1e-11)
    assert waves.reflection_coefficient == pytest.approx(0.4, rel=1e-10)
    assert abs(waves.drift) < 1e-11
    rate = 2 * np.pi / T * (5 * np.cos(2 * np.pi * TIME / T) - 3 * np.sin(6 * np.pi * TIME / T))
    # Central differences err by (3 ω dt)²/6 = 2e-4 in the third harmonic, twice that in its square.
    expected = 1e-7 * 1333.22 * rate**2 / (RHO * C)
    np.testing.assert_allclose(waves.forward_intensity, expected, atol=1e-3 * expected.max())
    assert (waves.backward_intensity <= 0).all()


def test_a_negative_wave_speed_is_refused():
    with pytest.raises(InputError, match="wave speed"):
        wave_intensity(PLUS, PLUS, T, A0, -C, RHO)


def test_windkessel_waveforms_return_the_windkessel_impedance():
    omega = 2 * np.pi * np.arange(15) / T
    bed = Windkessel(np.array([10.0]), np.array([70.0]), np.array([0.002]))
    Z = bed.impedance(omega)[:, 0]
    Q = 0.3 / (1 + np.arange(15)) * np.exp(1j * np.arange(15))
    Q[0] = 0.3
    q, p = ((S[:, None] * np.exp(1j * omega[:, None] * TIME)).real.sum(0) for S in (Q, Z * Q))
    found = impedance(p, q, T, flow_noise=0.3 / 13.5)
    np.testing.assert_allclose(found.Z, Z, rtol=1e-10)
    assert found.at_noise.nonzero()[0].tolist() == [13, 14]
    np.testing.assert_allclose(fourier_series(q), Q, atol=1e-12)


def test_compliance_is_the_derivative_of_volume_and_follows_the_published_rule():
    network = control_network()
    model = Model(network, LinearWall(50.0), Windkessel(10.0, 90.0, 1e-4))
    found = compliance(model, 10.0)
    volume = [float((network.length * area(model.wall, p, network.area)).sum()) for p in (9.99, 10.01)]
    assert found.network_sum == pytest.approx((volume[1] - volume[0]) / 0.02, rel=1e-8)
    assert found.peripheral == pytest.approx(len(network.terminals) * 0.9e-4)
    assert found.time_constant() == pytest.approx(100 / len(network.terminals) * found.total())
    fork = Network(("p", "a", "b"), np.array([-1, 0, 0]), np.ones(3), np.full(3, 0.1))
    assert series_parallel(fork, np.array([3.0, 1.0, 2.0])) == pytest.approx(3 * 3 / 6)
