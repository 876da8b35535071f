"""Waves, impedances, compliances and drops of small made signals and trees, computed by hand."""

import numpy as np
import pytest

import vasowave as vw
from approval import approve, parts
from vasowave.analysis import coupling as coupling_module
from vasowave.analysis.compliance import Compliance, compliance, series_parallel
from vasowave.analysis.coupling import _ejection, _isovolumic_peak, _systole
from vasowave.analysis.impedance import InputImpedance, characteristic_impedances, fourier_series, impedance
from vasowave.analysis.operating import measured_operating_point, operating_point
from vasowave.analysis.tree import pressure_drop, wave_speeds
from vasowave.analysis.waves import WaveIntensity, largest_waves, named_waves, wave_intensity
from vasowave.errors import InputError
from vasowave.model.shape import Shape

T = np.arange(64) / 64
TREE = vw.Network(tuple("abcd"), [-1, 0, 0, 1], [1.0, 2.0, 0.5, 0.25], [0.1, 0.08, 0.06, 0.05])
BEDS = vw.Windkessel(np.array([10.0, 20.0]), np.array([40.0, 60.0]), np.array([2e-3, 1e-3]))
MODEL = vw.Model(TREE, vw.LinearWall(np.array([50.0, 60.0, 70.0, 80.0])), BEDS)
RHO = vw.Blood().inertia


def test_harmonics_are_amplitudes_and_phases_of_cosines():
    signal = 3.0 + 2.0 * np.cos(2 * np.pi * T + 0.5) + 0.25 * np.cos(6 * np.pi * T - 1.0)
    found = fourier_series(signal, 4)
    assert found == pytest.approx([3, 2 * np.exp(0.5j), 0, 0.25 * np.exp(-1j), 0], abs=1e-12)
    assert len(fourier_series(np.ones(30))) == 15
    assert len(fourier_series(np.ones(9), 4)) == 5
    for wrong in (np.ones(8), np.ones((9, 9)), np.append(np.ones(9), np.nan)):
        with pytest.raises(InputError, match=rf"^\({len(wrong)},.* samples cannot carry 4 harmonics; give one finite"):
            fourier_series(wrong, 4)


def test_an_impedance_is_a_ratio_at_each_frequency_and_small_flows_are_marked():
    pressure = 12 + 3 * np.cos(2 * np.pi * T) + 0.4 * np.cos(4 * np.pi * T)
    flow = 0.5 + 0.2 * np.cos(2 * np.pi * T + 0.7) + 0.1 * np.cos(4 * np.pi * T - 0.3)
    found = impedance(pressure, flow[::2], 0.125, 2, flow_noise=0.15)
    assert found.frequency.tolist() == [0, 8, 16]
    assert found.modulus == pytest.approx([24, 15, 4])
    assert found.phase == pytest.approx([0, -0.7, 0.3])
    assert found.at_noise.tolist() == [False, False, True]
    for period in (0.0, -1.0, np.inf, np.nan):
        with pytest.raises(InputError, match=f"^period {period:g} s is not a positive number"):
            impedance(pressure, flow, period, 2)
    with pytest.raises(InputError, match="flow harmonic 0 is zero; its impedance does not exist"):
        impedance(pressure, np.zeros(64), 0.1, 2)
    assert isinstance(found, InputImpedance)


def ejecting(rise=10, fall=20, count=64, Z=15.0):
    """Return a recording whose pressure follows its flow: up by `rise` equal steps, down by `fall`."""
    flow = np.concatenate(
        [np.arange(rise + 1) / rise, 1 - np.arange(1, fall + 1) / fall, np.zeros(count - rise - fall - 1)]
    )
    return vw.Recording(8.0 + Z * flow, flow + 0.0, 0.1, "made")


def test_characteristic_impedances_of_a_pressure_that_follows_the_flow_are_one_number():
    found = characteristic_impedances(ejecting(), (1, 4))
    assert found.iloc[:5].to_numpy() == pytest.approx(15.0)
    assert found.name == "Z_c [mmHg s/ml]"
    late = ejecting()
    late = vw.Recording(late.pressure + np.where(np.arange(64) == 3, 1.5, 0.0), late.flow, 0.1, "made")
    found = characteristic_impedances(late, (1, 4))
    dp, dq = (np.roll(one, -1) - np.roll(one, 1) for one in (late.pressure, late.flow))
    assert found["steepest rise"] == pytest.approx((1.5 + 2 * 15 * 0.1) / 0.2)
    assert found["sum of squares"] == pytest.approx(np.sqrt(np.sum(dp**2) / np.sum(dq**2)))
    assert found["95 % of peak flow"] == pytest.approx(15.0)
    part = slice(0, 11)  # from the last sample below 5 % of the peak to the first above 95 %
    q, p = late.flow[part], late.pressure[part]
    assert found["up-slope"] == pytest.approx(np.polyfit(q, p, 1)[0])
    Z = np.abs(np.fft.rfft(late.pressure)[2:5] / np.fft.rfft(late.flow)[2:5])
    assert characteristic_impedances(late, (2, 4))["high frequency"] == pytest.approx(Z.mean())
    Q = np.sort(2 * np.abs(np.fft.rfft(late.flow)[2:5]) / 64)
    one = characteristic_impedances(late, (2, 4), flow_noise=0.5 * (Q[1] + Q[2]))["high frequency"]
    assert one == pytest.approx(Z[np.argmax(np.abs(np.fft.rfft(late.flow)[2:5]))])
    assert np.isnan(characteristic_impedances(late, (2, 4), flow_noise=9.0)["high frequency"])


@pytest.mark.parametrize("harmonics", [(0, 4), (5, 4)])
def test_harmonics_begin_with_the_first_and_do_not_end_before_they_begin(harmonics):
    with pytest.raises(InputError, match=rf"harmonics \({harmonics[0]}, 4\): give the first and the last, from 1"):
        characteristic_impedances(ejecting(), harmonics)


def test_an_upstroke_of_two_samples_has_no_slope():
    with pytest.raises(InputError, match=r"made: no upstroke of flow \(from 5 to 95 % of its peak in 2 samples\)"):
        characteristic_impedances(ejecting(rise=1), (1, 4))
    assert characteristic_impedances(ejecting(rise=2), (4, 4))["up-slope"] == pytest.approx(15.0)


def test_waves_are_separated_and_integrated_as_their_definition_says():
    """Two stations at once, with an area and a speed for each."""
    p = 10 + np.array([[2.0], [1.0]]) * np.sin(2 * np.pi * T) + 0.5 * np.cos(6 * np.pi * T)
    q = 0.3 + np.array([[0.1], [0.2]]) * np.sin(2 * np.pi * T + 0.4)
    A, c = np.array([[0.01], [0.02]]), np.array([[200.0], [300.0]])
    found = wave_intensity(p, q, 0.128, A, c, RHO)
    u, acoustic = q / A, RHO * c
    plus = 0.5 * (p - p[:, :1] + acoustic * (u - u[:, :1]))
    assert found.forward_pressure == pytest.approx(plus + p[:, :1])
    assert found.backward_pressure == pytest.approx(p - plus)
    assert found.forward_velocity == pytest.approx(plus / acoustic + u[:, :1])
    assert found.backward_velocity == pytest.approx(u - plus / acoustic)
    assert found.drift == pytest.approx(0.0, abs=1e-12)
    minus = p - p[:, :1] - plus
    assert found.reflection_coefficient == pytest.approx(np.ptp(minus, axis=1) / np.ptp(plus, axis=1))

    def rate(values):
        return (np.roll(values, -1, 1) - np.roll(values, 1, 1)) / (2 * 0.128 / 64)

    watt = 133.322387 * 1e-6  # of mmHg ml/s, J/s
    assert found.forward_intensity == pytest.approx(watt * rate(plus) ** 2 / acoustic, rel=1e-5)
    assert found.backward_intensity == pytest.approx(-watt * rate(minus) ** 2 / acoustic, rel=1e-5)


def test_waves_of_a_speed_that_changes_take_the_mean_of_two_neighbors():
    p, u, c = np.array([1.0, 3, 2, 4]), np.array([0.0, 1, 0, 2]), np.array([10.0, 20, 30, 40]) / RHO
    found = wave_intensity(p, u * 0.5, 0.1, 0.5, c, RHO)
    rises = 0.5 * (np.array([2, -1, 2, -3]) + np.array([15, 25, 35, 25]) * np.array([1, -1, 2, -2]))
    assert found.forward_pressure == pytest.approx(1 + np.array([0, *np.cumsum(rises)[:3]]))
    assert found.drift == pytest.approx(rises.sum())
    slower = 0.5 * (1 / np.array([10, 20, 30, 40]) + 1 / np.array([20, 30, 40, 10]))
    faster = 0.5 * (np.array([1, -1, 2, -2]) + slower * np.array([2, -1, 2, -3]))
    assert found.forward_velocity == pytest.approx(np.array([0, *np.cumsum(faster)[:3]]))


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"flow": np.ones(63)}, r"pressure has shape \(64,\), flow \(63,\); give both on the same times, at least 4"),
        ({"pressure": np.ones(3), "flow": np.ones(3)}, r"shape \(3,\), flow \(3,\); give both"),
        ({"pressure": 1.0, "flow": 1.0}, r"shape \(\), flow \(\); give both"),
        ({"area": np.ones(3)}, r"area or wave speed does not fit the shape \(64,\) of pressure"),
        ({"area": np.where(T == 0.5, 0.0, 1.0)}, "^area must be positive and finite everywhere"),
        ({"wave_speed": np.inf}, "^wave speed must be positive"),
        ({"inertia": -1.0}, "^density must be positive"),
        ({"period": 0.0}, "^period must be positive"),
        ({"pressure": np.where(T == 0.5, np.nan, 1.0)}, "pressure or flow holds a value that is not finite"),
        ({"flow": np.where(T == 0.5, np.inf, 1.0)}, "pressure or flow holds a value that is not finite"),
    ],
)
def test_waves_without_what_they_need_are_refused(changes, words):
    given = {"pressure": np.sin(T), "flow": np.sin(T), "period": 0.1, "area": 0.01, "wave_speed": 200.0, "inertia": RHO}
    with pytest.raises(InputError, match=words):
        wave_intensity(**(given | changes))


def of_one(forward, backward, drift=0.0):
    forward, backward = np.array(forward, float), np.array(backward, float)
    intensity = np.arange(1.0, forward.shape[-1] + 1) + 0 * forward
    return WaveIntensity(
        forward, backward, forward, backward, intensity, -2 * intensity, np.array(0.5), np.array(drift)
    )


def test_waves_have_names_begins_peaks_and_areas():
    """Eight samples of 0.1 s. The central differences of the forward wave: 0.5, 1.5, 1, 0, -1, -1.5, -0.5, 0."""
    found = named_waves(of_one([0, 1, 3, 3, 3, 1, 0, 0], np.zeros(8)), 0.8)
    assert found["wave"].tolist() == ["FCW", "FDW"]
    assert found["direction"].tolist() == ["forward", "forward"]
    assert found["kind"].tolist() == ["compression", "decompression"]
    assert found["start [s]"].to_numpy() == pytest.approx([0.0, 0.4])
    assert found["peak time [s]"].to_numpy() == pytest.approx([0.2, 0.6])
    assert found["duration [s]"].to_numpy() == pytest.approx([0.3, 0.3])
    assert found["peak [W/cm2/s2]"].to_numpy() == pytest.approx([3, 7])
    assert found["area [W/cm2/s]"].to_numpy() == pytest.approx([0.1 * 6, 0.1 * 18])
    assert found["pressure change [mmHg]"].to_numpy() == pytest.approx([3, -3])


def test_a_wave_across_the_end_of_the_cycle_is_one_and_small_ones_are_left_out():
    """Backward: rises from sample 6 across the end to 1, falls from 2 to 5; forward: a hundredth of that."""
    backward = [3.0, 4, 4, 3, 2, 1, 1, 2]
    found = named_waves(of_one(0.01 * np.array([0, 1, 2, 3, 4, 3, 2, 1]), backward), 0.8, smallest=0.02)
    assert found["wave"].tolist() == ["BDW", "BCW"]
    assert found["start [s]"].to_numpy() == pytest.approx([0.2, 0.6])
    assert found["duration [s]"].to_numpy() == pytest.approx([0.4, 0.4])
    assert found["peak time [s]"].to_numpy() == pytest.approx([0.5, 0.7])
    assert found["peak [W/cm2/s2]"].to_numpy() == pytest.approx([-12, -16])
    assert found["area [W/cm2/s]"].to_numpy() == pytest.approx([-0.2 * 18, -0.2 * (7 + 8 + 1 + 2)])
    assert found["pressure change [mmHg]"].to_numpy() == pytest.approx([-3, 3])
    everything = named_waves(of_one(0.01 * np.array([0, 1, 2, 3, 4, 3, 2, 1]), backward), 0.8, smallest=0.0)
    assert sorted(everything["wave"]) == ["BCW", "BDW", "FCW", "FDW"]
    kept = named_waves(of_one(0.0625 * np.array(backward), backward), 0.8, smallest=0.0625)  # exactly the share is kept
    assert len(kept) == 4


def test_a_drift_goes_on_in_the_next_cycle():
    rising = named_waves(of_one(np.arange(8.0), -np.arange(8.0), drift=8.0), 0.8)
    assert sorted(rising["wave"]) == ["BDW", "FCW"]
    assert rising["duration [s]"].to_numpy() == pytest.approx(0.8)
    assert rising["start [s]"].to_numpy() == pytest.approx(0.0)
    assert rising["pressure change [mmHg]"].abs().to_numpy() == pytest.approx(8.0)
    assert len(named_waves(of_one(np.zeros(8), np.zeros(8)), 0.8)) == 0


def test_of_each_kind_of_wave_the_largest_is_taken_in_their_own_order():
    """Two backward compressions, of which that with the larger area is taken."""
    found = largest_waves(named_waves(of_one([0, 1, 3, 3, 3, 1, 0, 0], [0, 1, 0, 0, 1, 0, 0, 0]), 0.8))
    assert found.index.tolist() == ["FCW", "FDW", "BCW", "BDW"]
    assert found.loc["BCW", "start [s]"] == pytest.approx(0.3)


@pytest.mark.parametrize(("period", "smallest"), [(0.0, 0.05), (np.inf, 0.05), (0.8, 1.0), (0.8, -0.1)])
def test_waves_of_one_station_are_named_by_a_period_and_a_share(period, smallest):
    with pytest.raises(
        InputError, match=f"period {period:g} s must be positive, smallest {smallest:g} between 0 and 1"
    ):
        named_waves(of_one(T, T), period, smallest)
    with pytest.raises(InputError, match=r"waves of shape \(2, 8\): name those of one station at a time"):
        named_waves(of_one(np.zeros((2, 8)), np.zeros((2, 8)), 0.0), 0.8)


def test_speeds_distances_and_reflections_of_a_tree():
    """Linear walls: A = A0 (1 + p/β)², c² = β/(2ρ) (1 + p/β)."""
    pressure = np.array([8.0, 9.0, 10.0, 11.0])
    found = wave_speeds(MODEL, pressure)
    beta, stretch = MODEL.wall.beta, 1 + pressure / MODEL.wall.beta
    c = np.sqrt(beta / (2 * RHO) * stretch)
    A = np.pi * TREE.radius**2 * stretch**2
    Y = A / (RHO * c)
    assert found["wave speed [cm/s]"].to_numpy() == pytest.approx(c)
    assert found["radius [cm]"].to_numpy() == pytest.approx(TREE.radius * stretch)
    assert found["Z_c [mmHg s/ml]"].to_numpy() == pytest.approx(1 / Y)
    assert found["generation"].tolist() == [0, 1, 1, 2]
    assert found["distance [cm]"].to_numpy() == pytest.approx([1.0, 3.0, 1.5, 3.25])
    assert found["arrival [s]"].to_numpy() == pytest.approx(
        [1 / c[0], 1 / c[0] + 2 / c[1], 1 / c[0] + 0.5 / c[2], 1 / c[0] + 2 / c[1] + 0.25 / c[3]]
    )
    beds = dict(zip(TREE.terminals, BEDS.R1, strict=True))
    expected = [
        (Y[0] - Y[1] - Y[2]) / (Y[0] + Y[1] + Y[2]), (Y[1] - Y[3]) / (Y[1] + Y[3]),
        *((beds[row] - 1 / Y[row]) / (beds[row] + 1 / Y[row]) for row in (2, 3)),
    ]  # fmt: skip
    assert found["reflection"].to_numpy() == pytest.approx(expected)
    assert wave_speeds(MODEL, 8.0)["wave speed [cm/s]"].iloc[0] == pytest.approx(c[0])


@pytest.mark.parametrize("pressure", [np.ones(3), np.nan, np.array([1.0, 2, np.inf, 3])])
def test_speeds_need_one_pressure_or_one_a_vessel(pressure):
    with pytest.raises(InputError, match="pressure must be one finite number or 4 of them"):
        wave_speeds(MODEL, pressure)
    with pytest.raises(InputError, match="pressure must be one finite number or 4 of them"):
        compliance(MODEL, pressure)


def test_a_collapsed_vessel_is_named_with_the_pressure():
    with pytest.raises(InputError, match="vessel 'b' is collapsed at -60 mmHg; no wave travels"):
        wave_speeds(MODEL, np.array([5.0, -60.0, -59.0, 5.0]))


def test_drops_of_pressure_to_the_ends():
    inlet = np.array([10.0, 20.0, 12.0, 8.0])
    ends = np.array([[9.0, 8.0], [14.0, 21.0], [13.0, 9.0], [8.5, 7.0]])
    found = pressure_drop(TREE, inlet, ends)
    assert found.index.tolist() == [TREE.name[row] for row in TREE.terminals]
    distance = {"c": 1.5, "d": 3.25}
    away = [distance[name] for name in found.index]
    assert found["distance [cm]"].to_numpy() == pytest.approx(away)
    assert found["mean drop [mmHg]"].to_numpy() == pytest.approx([12.5 - 11.125, 12.5 - 11.25])
    assert found["systolic drop [mmHg]"].to_numpy() == pytest.approx([6, -1])
    assert found["diastolic drop [mmHg]"].to_numpy() == pytest.approx([-0.5, 1])
    assert found["largest drop [mmHg]"].to_numpy() == pytest.approx([6, 3])
    assert found["mean gradient [mmHg/cm]"].to_numpy() == pytest.approx([1.375 / away[0], 1.25 / away[1]])
    for p, e in ((inlet[:3], ends), (inlet, ends[:, :1]), (inlet[:0], ends[:0]), (np.ones((4, 1)), ends)):
        with pytest.raises(InputError, match=r"inlet has shape .*, outlets .*; give \(time,\) and \(time, 2\)"):
            pressure_drop(TREE, p, e)
    for p, e in ((np.where(inlet == 8, np.nan, inlet), ends), (inlet, np.where(ends == 9, np.inf, ends))):
        with pytest.raises(InputError, match="a pressure is not finite"):
            pressure_drop(TREE, p, e)


def test_compliances_add_up_as_their_rules_say():
    """Of a linear wall dA/dp is 2 A0/β (1 + p/β); the rule: a with (b with d) and c beside each other."""
    found = compliance(MODEL, 6.0)
    beta = MODEL.wall.beta
    each = TREE.length * 2 * np.pi * TREE.radius**2 / beta * (1 + 6.0 / beta)
    assert found.vessel == pytest.approx(each)
    assert found.network_sum == pytest.approx(each.sum())
    below = each[1] * each[3] / (each[1] + each[3]) + each[2]
    assert found.network_published == pytest.approx(each[0] * below / (each[0] + below))
    R_T = 1 / (1 / 50 + 1 / 80)
    assert found.resistance == pytest.approx(R_T)
    assert found.peripheral == pytest.approx(float(BEDS.weighted_compliance().sum()))
    some = Compliance(each, 2.0, 5.0, 3.0, 7.0)
    assert (some.total(), some.total(published=False)) == (5.0, 8.0)
    assert (some.peripheral_share(), some.peripheral_share(False)) == (0.6, 0.375)
    assert (some.time_constant(), some.time_constant(False)) == (35.0, 56.0)


def test_the_compliance_of_a_tapering_vessel_is_simpsons_mean():
    """Of a radius that falls by a straight line, Simpson's rule is exact: the mean of (1.2 - 0.4 x)²."""
    shape = Shape(np.array([[1.2, 0.8], [1.0, 1.0], [1.0, 1.0], [1.0, 1.0]]))
    found = compliance(MODEL.changed(shape=shape), 6.0).vessel / compliance(MODEL, 6.0).vessel
    assert found == pytest.approx([(1.2**2 + 1.2 * 0.8 + 0.8**2) / 3, 1, 1, 1])


def test_compliances_of_a_ring_are_joined_as_conductances():
    """Two equal ways from the inlet's vessel to the outlet's: each of two compliances in series."""
    nodes = [[0, 1], [1, 2], [2, 4], [1, 3], [3, 4], [4, 5]]
    ring = vw.Network(tuple("abcdef"), None, np.ones(6), 0.1 * np.ones(6), nodes=nodes)
    assert series_parallel(ring, np.array([4.0, 2, 2, 2, 2, 4])) == pytest.approx(1 / (1 / 4 + 1 / 2 + 1 / 4))


def test_the_area_at_a_pressure_goes_with_the_impedance_that_was_measured():
    """A linear wall of β = 60 with its image at 3 mmHg: A Z_c/ρ is the speed there, and β comes back."""
    beta, image, p, A0 = 60.0, 3.0, 15.0, 0.01
    there = A0 * (1 + p / beta) ** 2
    c = np.sqrt(beta / (2 * RHO) * (1 + p / beta))
    found = measured_operating_point(RHO * c / there, A0 * (1 + image / beta) ** 2, RHO, p, image)
    assert found == pytest.approx((there, c))
    soft = measured_operating_point(1e-15, A0, RHO, p)  # softer than the softest that is tried
    assert soft.area == pytest.approx(A0 * ((1e-6 + p) / 1e-6) ** 2)
    rigid = measured_operating_point(1e9, A0, RHO, p)
    assert rigid.area == pytest.approx(A0, rel=1e-5)
    assert rigid.wave_speed == pytest.approx(rigid.area * 1e9 / RHO)
    at_root = operating_point(MODEL, 8.0)
    assert at_root == pytest.approx((np.pi * 0.01 * 1.16**2, np.sqrt(50 / (2 * RHO) * 1.16)))


@pytest.mark.parametrize("place", range(5))
def test_an_operating_point_of_nothing_is_refused(place):
    given = [15.0, 0.01, RHO, 15.0, 3.0]
    given[place] = -1.0 if place == 4 else 0.0
    with pytest.raises(InputError, match=r"Z_c .* mmHg s/ml, area .* cm², density .*, pressure .* mmHg: all"):
        measured_operating_point(*given)
    assert measured_operating_point(15.0, 0.01, RHO, 15.0, 0.0).area > 0.01


def test_ejection_lasts_from_the_foot_of_the_flow_to_where_it_is_shut():
    """A flow of a triangle from sample 10 over 30 to 50 of 100; the artery's pressure is its time in ms."""
    flow = np.interp(np.arange(100), [10, 30, 50], [0, 1, 0], left=0, right=0)
    found = _ejection(vw.Recording(10 + 5 * np.sin(2 * np.pi * np.arange(100) / 100), flow, 0.1, "made"))
    foot = 30 - int(np.argmax(flow[30::-1] <= coupling_module._OPEN))
    end = 30 + int(np.argmax(flow[30:] <= coupling_module._SHUT))
    assert len(found.ejected) == end - foot + 1
    assert found.ejected == pytest.approx(np.concatenate([[0], np.cumsum(flow[foot:end])]) * 1e-3)
    assert found.time == pytest.approx((np.arange(end - foot + 1) - 0.5) * 1e-3)
    assert found.pressure == pytest.approx(10 + 5 * np.sin(2 * np.pi * foot / 100))
    with pytest.raises(InputError, match="made: the flow has no beginning and end of ejection; is its zero right"):
        _ejection(vw.Recording(np.ones(100) * 10, 2 + flow, 0.1, "made"))


def test_systole_lasts_from_where_contraction_begins_to_where_filling_may():
    count = 256
    time = np.arange(count) / count
    wave = 3 + 25 * np.sin(np.pi * np.clip((time - 0.3) / 0.5, 0, 1)) ** 2
    found = _systole(vw.VentricularPressure(wave, 0.11))
    begin = (int(np.argmax(wave == wave.max())) - int(np.argmax(found.smooth))) % count
    assert begin / count == pytest.approx(0.3, abs=0.03)
    assert len(found.pressure) / count == pytest.approx(0.5, abs=0.06)
    rises, falls = found.steepest
    assert ((begin + rises) / count, (begin + falls) / count) == pytest.approx((0.425, 0.675), abs=0.01)
    assert np.array_equal(found.pressure, np.roll(wave, -begin)[: len(found.pressure)])


def test_a_flow_that_no_ventricle_of_this_pressure_makes_is_refused(monkeypatch):
    """Hardly any two signals are further apart than a tenth of the pulse: here the limit is none."""
    t = np.arange(256) / 256
    flow = np.where((t > 0.1) & (t < 0.4), np.sin(np.pi * np.clip((t - 0.1) / 0.3, 0, 1)), 0.0)
    artery = vw.Recording(15 + 4 * np.sin(2 * np.pi * (t - 0.12)), flow, period=0.11)
    inside = vw.VentricularPressure(3 + 27 * np.sin(np.pi * np.minimum(t / 0.5, 1)) ** 2, period=0.11)
    found, _ = coupling_module.coupled(artery, inside)
    misfit = np.sqrt(np.mean((found.fitted - found.measured) ** 2)) / 27
    assert coupling_module.coupled(artery, None) == (None, ())
    monkeypatch.setattr(coupling_module, "_MEANINGLESS", 0.0)
    with pytest.raises(InputError, match=rf"from this flow \(off by {100 * misfit:.0f} % of its pulse\)"):
        vw.coupling(artery, inside)
    found, (told,) = coupling_module.coupled(artery, inside)
    assert found is None
    assert "no elastance makes this pressure" in str(told)


def test_a_sine_through_the_isovolumic_parts_has_the_peak_of_theirs():
    t = np.arange(101) / 100
    whole = 2 + 40 * (1 + np.sin(2 * np.pi * t - np.pi / 2)) / 2

    class Beat:
        time, smooth, steepest = t, np.minimum(whole, 28.0), (30, 70)

    assert _isovolumic_peak(Beat) == pytest.approx(42.0, rel=5e-3)
    Beat.smooth = np.minimum(whole, 43.0) + 1e-9
    Beat.smooth[50] = 43.0
    assert np.isnan(_isovolumic_peak(Beat))  # below what is measured


def test_approved_couplings_of_a_ventricle_and_its_artery():
    """Of one beat, with its error by the slopes of the fit, and of one that lasts longer than the artery's."""
    t = np.arange(256) / 256
    flow = np.where((t > 0.1) & (t < 0.4), np.sin(np.pi * np.clip((t - 0.1) / 0.3, 0, 1)), 0.0)
    artery = vw.Recording(15 + 4 * np.sin(2 * np.pi * (t - 0.12)), flow, period=0.11)
    lines = []
    for period, most in ((0.11, 30.0), (0.13, 15.0)):
        inside = vw.VentricularPressure(3 + (most - 3) * np.sin(np.pi * np.minimum(t / 0.5, 1)) ** 2, period=period)
        found = vw.coupling(artery, inside)
        lines += parts(f"period {period}", found)
        lines += [str(one) for one in found.findings]
        lines += parts(f"period {period}, ventricle", found.ventricle)
        lines.append(repr(found))
    approve("coupling", lines, 1e-9, 1e-3)
