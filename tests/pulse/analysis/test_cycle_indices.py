"""What one cycle tells without a model, against cycles whose ejection, slopes, notch and power are known."""

import numpy as np
import pytest

import vasowave as vw

MMHG_ML = 0.133322  # mJ
SPECIES = {"mouse": (0.11, 0.02), "rat": (0.17, 0.2), "pig": (0.7, 35.0), "human": (0.9, 75.0)}  # period s, stroke ml


def outflow(phase, ejection, rise, backflow):
    """A flow that rises as a sine until `rise`, falls as a cosine until `ejection`, and leaks back; peak 1."""
    falls = np.cos(np.pi / 2 * (phase - rise) / (ejection - rise))
    forward = np.where(phase < rise, np.sin(np.pi / 2 * phase / rise), np.where(phase < ejection, falls, 0.0))
    behind = phase - ejection
    leak = np.where((behind >= 0) & (behind < 0.08), np.sin(np.pi * behind / 0.08), 0.0)
    return forward - backflow * leak


def windkessel(flow, period, resistance, compliance, impedance):
    """Pressure over a three-element Windkessel, by its impedance."""
    angular = 2j * np.pi * np.fft.rfftfreq(len(flow), period / len(flow))
    return np.fft.irfft(
        np.fft.rfft(flow) * (impedance + resistance / (1 + angular * resistance * compliance)), len(flow)
    )


def cycle(flow, period, stroke, wave=0.07):
    """A recording of that flow, its pressure about 15 mmHg in the mean."""
    flow = flow * stroke / (flow.mean() * period)
    resistance = 15 / flow.mean()
    pressure = windkessel(flow, period, (1 - wave) * resistance, 0.25 * period / (wave * resistance), wave * resistance)
    return vw.Recording(pressure, flow, period)


@pytest.mark.parametrize("species", SPECIES)
def test_ejection_and_acceleration_last_as_long_as_they_do(species):
    random, (period, stroke) = np.random.default_rng(list(SPECIES).index(species)), SPECIES[species]
    for _ in range(25):
        ejection, start = random.uniform(0.3, 0.5), random.uniform(0, 1)
        rise = ejection * random.uniform(0.25, 0.5)
        flow = outflow((np.arange(256) / 256 - start) % 1, ejection, rise, random.choice([0.0, random.uniform(0, 0.2)]))
        values = vw.cycle_indices(cycle(flow, period, stroke)).values
        assert values["ejection_time"] == pytest.approx(ejection * period, abs=2 / 256 * period)
        assert values["acceleration_time"] == pytest.approx(rise * period, abs=2 / 256 * period)
        assert values["SV"] == pytest.approx(stroke, rel=1e-9)


def test_power_is_that_of_mean_and_harmonics():
    recording = cycle(outflow(np.arange(256) / 256, 0.4, 0.13, 0.1), *SPECIES["rat"])
    values = vw.cycle_indices(recording).values
    pressure, flow = (np.fft.rfft(signal) / 256 for signal in (recording.pressure, recording.flow))
    products = (pressure * flow.conj()).real
    assert values["steady_power"] == pytest.approx(MMHG_ML * products[0], rel=1e-5)
    assert values["oscillatory_power"] == pytest.approx(MMHG_ML * (2 * products[1:-1].sum() + products[-1]), rel=1e-4)
    assert values["power"] == pytest.approx(values["steady_power"] + values["oscillatory_power"])
    assert values["oscillatory_share"] == pytest.approx(values["oscillatory_power"] / values["power"])


def test_energies_of_waves_differ_by_what_oscillates_and_nothing_comes_back_from_a_matched_line():
    flow = cycle(outflow(np.arange(256) / 256, 0.4, 0.13, 0.1), *SPECIES["mouse"]).flow
    period = SPECIES["mouse"][0]
    matched = vw.Recording(9.0 + 15.0 * flow, flow, period)
    values = vw.cycle_indices(matched).values
    assert values["reflected_energy"] < 1e-6 * values["incident_energy"]
    assert values["incident_energy"] == pytest.approx(values["oscillatory_power"] * period)
    loaded = vw.cycle_indices(cycle(flow, *SPECIES["mouse"]), Z_c=20.0).values
    assert loaded["incident_energy"] - loaded["reflected_energy"] == pytest.approx(loaded["oscillatory_power"] * period)


def test_slopes_are_those_of_the_wave_and_not_of_its_samples():
    for count in (64, 500):
        angle = 2 * np.pi * np.arange(count) / count
        pressure = 12 + 4 * np.sin(angle) + 1.5 * np.sin(2 * angle + 0.4)
        fine = np.linspace(0, 2 * np.pi, 100_000)
        slope = 2 * np.pi / 0.2 * (4 * np.cos(fine) + 3 * np.cos(2 * fine + 0.4))
        values = vw.cycle_indices(vw.Recording(pressure, np.maximum(np.sin(angle), 0), 0.2)).values
        assert values["dp_dt_max"] == pytest.approx(slope.max(), rel=1e-3)
        assert values["dp_dt_min"] == pytest.approx(slope.min(), rel=1e-3)


def test_slopes_are_nearer_to_the_truth_where_the_errors_of_harmonics_are_known():
    random, angle = np.random.default_rng(7), 2 * np.pi * np.arange(256) / 256
    pressure = 12 + 4 * np.sin(angle) + 1.5 * np.sin(2 * angle + 0.4) + 0.4 * np.sin(3 * angle)
    slope = 2 * np.pi / 0.2 * (4 * np.cos(angle) + 3 * np.cos(2 * angle + 0.4) + 1.2 * np.cos(3 * angle)).max()
    flow, noise = np.maximum(np.sin(angle), 0), 0.06
    errors = np.full(129, noise * np.sqrt(2 / 256))
    off = []
    for _ in range(16):
        noisy = pressure + noise * random.standard_normal(256)
        cycles = [vw.Recording(noisy, flow, 0.2, pressure_error=known) for known in (errors, 0 * errors)]
        off.append([vw.cycle_indices(cycle).values["dp_dt_max"] / slope - 1 for cycle in cycles])
    known, unknown = np.sqrt(np.mean(np.square(off), axis=0))
    assert known < 0.7 * unknown


def test_the_notch_is_the_valley_before_the_dicrotic_wave_and_absent_without_it():
    phase = np.arange(400) / 400
    flow = outflow((phase - 0.1) % 1, 0.35, 0.12, 0.1)

    def pressure(phase, dicrotic):
        wave = 20 * np.exp(-0.5 * ((phase - 0.28) / 0.09) ** 2)
        return 10 + wave + dicrotic * np.exp(-0.5 * ((phase - 0.55) / 0.035) ** 2)

    fine = pressure(np.linspace(0.4, 0.55, 10_000), 4.0)
    values, absent = vw.cycle_indices(vw.Recording(pressure(phase, 4.0), flow, 0.8))
    assert values["notch"] == pytest.approx(fine.min(), rel=0.01)
    assert [finding.code for finding in absent] == []
    values, absent = vw.cycle_indices(vw.Recording(pressure(phase, 0.0), flow, 0.8))
    assert "notch" not in values
    assert [finding.code for finding in absent] == ["cycle.no-notch"]


def test_the_pressure_after_the_peak_of_the_flow_is_its_augmentation():
    phase = np.arange(400) / 400
    flow = np.exp(-0.5 * ((phase - 0.3) / 0.06) ** 2)
    for shift, sign in ((0.08, 1), (-0.05, -1)):
        pressure = 10 + 8 * np.exp(-0.5 * ((phase - 0.3 - shift) / 0.1) ** 2)
        before = 1 - np.exp(-0.5 * (shift / 0.1) ** 2)
        values = vw.cycle_indices(vw.Recording(pressure, flow, 0.8)).values
        assert values["augmentation"] == pytest.approx(sign * before / (1 - np.exp(-0.5 * (0.62 / 0.1) ** 2)), abs=0.01)


def test_a_steady_flow_has_no_ejection_and_one_backward_is_refused():
    angle = 2 * np.pi * np.arange(128) / 128
    values, absent = vw.cycle_indices(vw.Recording(10 + np.sin(angle), np.ones(128), 0.8))
    assert {"cycle.no-ejection", "cycle.no-upstroke"} <= {finding.code for finding in absent}
    assert "ejection_time" not in values
    backward = vw.Recording(10 + np.sin(angle), -np.maximum(np.sin(angle), 0), 0.8)
    with pytest.raises(vw.errors.InputError, match="are its sign and its zero right"):
        vw.cycle_indices(backward)


def test_stroke_work_is_that_of_the_loop():
    network, mouse = vw.control_network(), vw.virtual_mouse()
    model = vw.Model(network, vw.LinearWall(60.0), vw.estimate_nominal(network, mouse).outlets)
    heart = vw.Ventricle.from_peak(1400.0, rest=100.0, period=0.11, filling_pressure=4.0)
    waves = vw.simulate(model, heart)
    inlet = waves.sel(vessel=network.name[network.root], station="inlet")
    recording = vw.Recording(inlet.pressure.values, inlet.flow.values, 0.11)
    coupling = vw.coupling(recording, vw.VentricularPressure(waves.ventricular_pressure.values, 0.11))
    ejected = 0.11 * np.mean(waves.ventricular_pressure.values * inlet.flow.values)
    work = MMHG_ML * (ejected - coupling.filling_pressure * coupling.stroke_volume)
    assert coupling.stroke_work == pytest.approx(work, rel=0.02)
