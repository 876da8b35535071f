from pathlib import Path

import numpy as np
import pytest

from vasowave.base import InputError
from vasowave.pulse import analysis
from vasowave.pulse.cycle import Recording
from vasowave.pulse.examples import control_network
from vasowave.pulse.model import Blood, ImpedanceSpectrum, LinearWall, Model, TangentWall, Windkessel
from vasowave.pulse.network import Network

T, RHO, C, A0, N = 0.11, Blood().inertia, 220.0, 0.0069, 1000
TIME = np.arange(N) * T / N
DATA = Path(__file__).parents[3] / ".." / "shared" / "data" / "mouse-c6"


def pulse(start, length, height):
    """A pressure that rises and falls once, as (1 - cos)/2, on the closed cycle."""
    phase = np.mod(TIME - start, T) / length
    return np.where(phase < 1, 0.5 * height * (1 - np.cos(2 * np.pi * phase)), 0.0)


def two_pulses(start):
    plus, minus = pulse(start, 0.04, 8.0), pulse(start + 0.03, 0.04, 2.0)
    waves = analysis.wave_intensity(10 + plus + minus, A0 * (plus - minus) / (RHO * C), T, A0, C, RHO)
    return analysis.named_waves(waves, T)


@pytest.mark.parametrize("start", [0.01, 0.1, 0.085])
def test_two_pulses_are_four_waves_wherever_the_cycle_is_cut(start):
    found = two_pulses(start).set_index("wave")
    assert sorted(found.index) == ["BCW", "BDW", "FCW", "FDW"]
    # A pulse of height H and length L has dp₊/dt = πH/L sin(2πt/L); WI₊ = (dp₊/dt)²/ρc, half of its peak on average.
    for wave, at, height in (("FCW", 0.01, 8.0), ("FDW", 0.03, 8.0), ("BCW", 0.04, 2.0), ("BDW", 0.06, 2.0)):
        sign = 1 if wave[0] == "F" else -1
        peak = sign * 1333.22e-7 * (np.pi * height / 0.04) ** 2 / (RHO * C)
        assert found.loc[wave, "peak [W/cm2/s2]"] == pytest.approx(peak, rel=1e-3)
        assert found.loc[wave, "area [W/cm2/s]"] == pytest.approx(peak * 0.02 / 2, rel=1e-3)
        assert found.loc[wave, "pressure change [mmHg]"] == pytest.approx(
            height * (1 if wave[1] == "C" else -1), rel=1e-3
        )
        away = np.mod(found.loc[wave, "peak time [s]"] - start - at + T / 2, T) - T / 2
        assert abs(away) <= T / N
        assert found.loc[wave, "duration [s]"] == pytest.approx(0.02, abs=3 * T / N)


def test_waves_below_the_smallest_share_are_left_out_and_the_largest_of_each_kind_is_kept():
    p = 10 + pulse(0.0, 0.04, 8.0) + pulse(0.06, 0.02, 0.3)
    waves = analysis.wave_intensity(p, A0 * (p - 10) / (RHO * C), T, A0, C, RHO)
    assert analysis.named_waves(waves, T)["wave"].tolist() == ["FCW", "FDW"]
    every = analysis.named_waves(waves, T, smallest=1e-3)
    assert every["wave"].tolist() == ["FCW", "FDW", "FCW", "FDW"]
    assert analysis.largest_waves(every)["pressure change [mmHg]"].round(1).tolist() == [8.0, -8.0]


def test_the_waves_of_a_varying_wave_speed_add_up_to_the_drift():
    plus = pulse(0.0, 0.08, 8.0)
    speed = C * (1 + 0.02 * plus)
    waves = analysis.wave_intensity(10 + plus, A0 * np.roll(plus, 40) / (RHO * C), T, A0, speed, RHO)
    found = analysis.named_waves(waves, T, smallest=0).groupby("direction")["pressure change [mmHg]"].sum()
    assert abs(waves.drift) > 0.1
    assert found["forward"] == pytest.approx(waves.drift)
    assert found["backward"] == pytest.approx(-waves.drift)


@pytest.mark.parametrize("least", [0.01, 0.5], ids=["stops", "never stops"])
def test_every_estimator_of_characteristic_impedance_is_exact_without_reflections(least):
    q = least + pulse(0.01, 0.05, 0.5)
    found = analysis.characteristic_impedances(Recording(8.0 + 31.0 * q, q, T), harmonics=(2, 4))
    np.testing.assert_allclose(found, 31.0, rtol=1e-9)
    assert len(found) == 6


def test_in_front_of_a_windkessel_high_frequencies_see_r1_and_only_noise_gives_no_number():
    bed = Windkessel(np.array([30.0]), np.array([70.0]), np.array([0.002]))
    q = 0.01 + pulse(0.01, 0.05, 0.5)
    Z = bed.impedance(2 * np.pi * np.arange(N // 2 + 1) / T)[:, 0]
    p = np.fft.irfft(Z * np.fft.rfft(q), N)
    found = analysis.characteristic_impedances(Recording(p, q, T))
    assert found["high frequency"] == pytest.approx(np.abs(Z[4:11]).mean())
    noisy = analysis.characteristic_impedances(Recording(p, q, T), flow_noise=10.0)
    assert np.isnan(noisy["high frequency"])


def test_the_first_half_of_the_upstroke_tells_z_c_before_a_compliance_fills():
    bed = Windkessel(np.array([30.0]), np.array([270.0]), np.array([0.0005]))
    q = 0.01 + pulse(0.01, 0.05, 0.5)
    Z = bed.impedance(2 * np.pi * np.arange(N // 2 + 1) / T)[:, 0]
    found = analysis.characteristic_impedances(Recording(np.fft.irfft(Z * np.fft.rfft(q), N), q, T))
    assert found["up-slope"] > 1.25 * 30.0
    assert found["first half"] == pytest.approx(30.0, rel=0.2)
    assert abs(found["first half"] - 30.0) < 0.6 * abs(found["up-slope"] - 30.0)


def test_the_upslope_of_the_measured_mouse_is_the_one_behind_its_published_stiffness():
    if not DATA.exists():
        pytest.skip(f"no measured data at {DATA.resolve().name} beside the project")
    p, q = (np.loadtxt(DATA / f"{name}C6_512.dat")[:-1] for name in "pq")
    found = analysis.characteristic_impedances(Recording(p, q, T))
    area0 = np.pi * 0.047**2
    assert 2 * (area0 * found["up-slope"]) ** 2 / RHO == pytest.approx(26.0, rel=0.02)
    assert found.between(5, 60).all()


def test_a_matched_junction_reflects_nothing_and_a_wave_arrives_after_length_over_speed():
    network = Network(
        ("p", "a", "b"),
        np.array([-1, 0, 0]),
        np.array([2.0, 1.0, 3.0]),
        np.array([0.1, 0.1, 0.1]) / [1, 2**0.5, 2**0.5],
    )
    c = np.sqrt(50 / (2 * RHO))
    Z_c = RHO * c / network.area
    model = Model(network, LinearWall(50.0), Windkessel(Z_c[1:], 90.0, 1e-4))
    found = analysis.wave_speeds(model, 0.0)
    np.testing.assert_allclose(found["wave speed [cm/s]"], c)  # eq. 33
    np.testing.assert_allclose(found["arrival [s]"], np.array([2, 3, 5]) / c)
    np.testing.assert_allclose(found["reflection"], 0, atol=1e-12)
    assert found["generation"].tolist() == [0, 1, 1]
    closed = model.changed(outlets=Windkessel(1e9, 90.0, 1e-4))
    assert analysis.wave_speeds(closed, 0.0)["reflection"].tolist() == pytest.approx([0, 1, 1], abs=1e-6)
    other = model.changed(outlets=ImpedanceSpectrum(np.full((3, 2), 50.0 + 0j)))
    expected = (50.0 - Z_c[1:]) / (50.0 + Z_c[1:])  # what a spectrum is to the fastest changes is found with it
    np.testing.assert_allclose(analysis.wave_speeds(other, 0.0)["reflection"][1:], expected)


def test_the_wave_speed_is_the_bramwell_hill_speed_of_the_wall_law():
    model = Model(control_network(), TangentWall(7.0, 2.0), Windkessel(10.0, 90.0, 1e-4))
    found = analysis.wave_speeds(model, 12.0)
    A = np.pi * found["radius [cm]"].to_numpy() ** 2
    above, below = (np.pi * analysis.wave_speeds(model, 12 + d)["radius [cm]"].to_numpy() ** 2 for d in (1e-3, -1e-3))
    np.testing.assert_allclose(found["wave speed [cm/s]"], np.sqrt(A / RHO * 2e-3 / (above - below)), rtol=1e-6)
    np.testing.assert_allclose(found["Z_c [mmHg s/ml]"], RHO * found["wave speed [cm/s]"] / A)
    with pytest.raises(InputError, match="finite"):
        analysis.wave_speeds(model, np.nan)


def test_the_drop_to_each_terminal_is_measured_over_its_own_path():
    network = Network(("p", "a", "b"), np.array([-1, 0, 0]), np.array([2.0, 1.0, 3.0]), np.full(3, 0.1))
    p = 15 + 5 * np.sin(2 * np.pi * TIME / T)
    ends = np.stack([p - 1.5, 13 + 6 * np.sin(2 * np.pi * TIME / T)], axis=1)
    found = analysis.pressure_drop(network, p, ends)
    assert found["distance [cm]"].tolist() == [3.0, 5.0]
    np.testing.assert_allclose(found["mean drop [mmHg]"], [1.5, 2.0])
    np.testing.assert_allclose(found["systolic drop [mmHg]"], [1.5, 1.0])
    np.testing.assert_allclose(found["diastolic drop [mmHg]"], [1.5, 3.0])
    np.testing.assert_allclose(found["largest drop [mmHg]"], [1.5, 3.0])
    np.testing.assert_allclose(found["mean gradient [mmHg/cm]"], [0.5, 0.4])
    with pytest.raises(InputError, match="outlets"):
        analysis.pressure_drop(network, p, ends[:, :1])


def test_a_vessel_that_is_collapsed_is_named_with_its_pressure():
    beds = Windkessel(*(np.ones(1) for _ in range(3)))
    model = Model(Network(("1", "2"), [-1, 0], [1.0, 1.0], [0.05, 0.04]), LinearWall(60.0), beds)
    with pytest.raises(InputError, match="vessel '2' is collapsed at -500 mmHg"):
        analysis.wave_speeds(model, np.array([10.0, -500.0]))


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"flow": np.ones(63)}, r"pressure has shape \(64,\), flow \(63,\); give both on the same times, at least 4"),
        ({"pressure": np.ones(3), "flow": np.ones(3)}, r"shape \(3,\), flow \(3,\); give both"),
        ({"area": np.ones(3)}, r"area or wave speed does not fit the shape \(64,\) of pressure"),
        ({"wave_speed": -C}, "^wave speed must be positive"),
        ({"period": 0.0}, "^period must be positive"),
        ({"pressure": np.full(64, np.nan)}, "pressure or flow holds a value that is not finite"),
    ],
)
def test_waves_without_what_they_need_are_refused(changes, words):
    signal = np.sin(np.arange(64))
    given = {"pressure": signal, "flow": signal, "period": T, "area": A0, "wave_speed": C, "inertia": RHO}
    with pytest.raises(InputError, match=words):
        analysis.wave_intensity(**(given | changes))


def test_waves_are_named_at_one_station_by_a_period_and_a_share():
    p = np.tile(10 + pulse(0, 0.04, 8.0), (2, 1))
    with pytest.raises(InputError, match="one station"):
        analysis.named_waves(analysis.wave_intensity(p, p, T, A0, C, RHO), T)
    with pytest.raises(InputError, match="period 0 s must be positive, smallest 1 between 0 and 1"):
        analysis.named_waves(analysis.wave_intensity(p[0], p[0], T, A0, C, RHO), 0.0, 1.0)


def test_characteristic_impedances_need_harmonics_from_the_first_and_an_upstroke():
    q = 0.01 + pulse(0.01, 0.05, 0.5)
    for harmonics in ((0, 4), (5, 4)):
        with pytest.raises(InputError, match="give the first and the last, from 1"):
            analysis.characteristic_impedances(Recording(8.0 + 31.0 * q, q, T), harmonics)
    sudden = np.where(np.arange(64) < 9, 1.0, 0.0)
    with pytest.raises(InputError, match="made: no upstroke of flow"):
        analysis.characteristic_impedances(Recording(8.0 + sudden, sudden, T, "made"), (1, 4))
