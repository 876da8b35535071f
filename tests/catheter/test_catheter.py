"""Catheters that ring: recognized behind waves of an independent solver, undone on request, not seen where none is."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from vasowave.base import InputError
from vasowave.catheter.check import Catheter, LowPass, correct_catheter, suspect_catheter, without_delays
from vasowave.catheter.read import read_recording
from vasowave.pulse.cycle import Recording

DATA = Path(__file__).parents[2] / ".." / "shared" / "data"
PHASE = 2 * np.pi * np.arange(512) / 512
WAVES = sum(0.75**k * np.cos(k * PHASE - 0.9 * k) for k in range(1, 15))
CYCLE = Recording(16 + 4 * WAVES, 0.2 + 0.1 * WAVES, 0.11)

needs_data = pytest.mark.skipif(not DATA.exists(), reason="needs shared/data beside the project")


def through(recording: Recording, catheter: Catheter | LowPass) -> Recording:
    frequency = np.arange(len(recording.pressure) // 2 + 1) / recording.period
    spectrum = np.fft.rfft(recording.pressure) * catheter.response(frequency)
    pressure = np.fft.irfft(spectrum, len(recording.pressure))
    return Recording(pressure, recording.flow, recording.period)


def solved(law: str, vessel: int) -> Recording:
    path = DATA / "reference-c6" / law / "waveforms.csv"
    table = np.genfromtxt(path, delimiter=",", names=True)[:-1]
    return Recording(table[f"p{vessel}_in_mmHg"], table[f"q{vessel}_in_mls"], 0.11)


def test_the_response_is_that_of_a_damped_spring():
    step, catheter = 1e-5, Catheter(40.0, 0.2)
    omega = 2 * np.pi * 40.0
    drive = 2 * np.pi * 25.0
    place = speed = 0.0
    recorded = []
    for n in range(100_000):  # m x'' + c x' + k x = k p, integrated; after 1 s the start is forgotten
        speed += step * (omega**2 * (np.cos(drive * n * step) - place) - 2 * 0.2 * omega * speed)
        place += step * speed
        recorded.append(place)
    late = np.arange(60_000, 100_000)
    measured = 2 * np.mean(np.array(recorded)[late] * np.exp(-1j * drive * late * step))
    assert catheter.response(np.array(25.0)) == pytest.approx(measured, rel=0.01)


@needs_data
@pytest.mark.parametrize("law", ["boundary-layer-friction", "constant-friction"])
@pytest.mark.parametrize("vessel", [1, 2, 3])
def test_no_catheter_is_suspected_behind_solved_waves(law, vessel):
    assert suspect_catheter(solved(law, vessel)) is None


@needs_data
def test_no_catheter_is_suspected_in_the_measured_mouse():
    folder = DATA / "mouse-c6"
    assert suspect_catheter(read_recording(folder / "pC6_1024.dat", folder / "qC6_1024.dat", period=0.11)) is None


@needs_data
@pytest.mark.parametrize("frequency", [50.0, 65.0])
@pytest.mark.parametrize("damping", [0.15, 0.25])
def test_a_catheter_that_rings_in_the_main_artery_is_recognized_by_frequency_and_damping(frequency, damping):
    found = suspect_catheter(through(solved("constant-friction", 1), Catheter(frequency, damping)))
    assert found is not None
    assert found.natural_frequency == pytest.approx(frequency, rel=0.2)
    assert found.damping == pytest.approx(damping, abs=0.15)


def test_a_known_catheter_is_undone_on_request():
    catheter = Catheter(50.0, 0.2)
    distorted = through(CYCLE, catheter)
    assert abs(distorted.pulse_pressure / CYCLE.pulse_pressure - 1) > 0.1
    corrected = correct_catheter(distorted, catheter)
    np.testing.assert_allclose(corrected.pressure, CYCLE.pressure, atol=0.05)
    assert corrected.mean_pressure == pytest.approx(CYCLE.mean_pressure, abs=1e-9)
    assert any("corrected for a response of second order, 50 Hz" in str(note) for note in corrected.notes)


def test_what_a_catheter_lost_is_not_invented():
    with pytest.raises(InputError, match="what is lost cannot be recovered"):
        correct_catheter(CYCLE, Catheter(5.0, 0.5))
    with pytest.raises(InputError, match="must be positive"):
        correct_catheter(CYCLE, Catheter(50.0, 0.0))


def test_a_filter_of_first_order_lets_through_what_a_resistor_and_a_capacitor_do():
    step, cutoff, drive = 1e-5, 40.0, 2 * np.pi * 25.0
    time, charge, recorded = step * np.arange(40_000), 0.0, []
    for moment in time:
        charge += step * 2 * np.pi * cutoff * (np.cos(drive * moment) - charge)
        recorded.append(charge)
    late = time >= 0.2
    measured = 2 * np.mean(np.array(recorded)[late] * np.exp(-1j * drive * (time[late] + step)))
    assert LowPass(cutoff).response(np.array(25.0)) == pytest.approx(measured, rel=0.01)


@pytest.mark.parametrize("signal", ["pressure", "flow"])
def test_a_known_filter_is_undone_in_its_own_signal_alone_and_errors_grow_with_what_it_lost(signal):
    errors = {"pressure_error": np.full(257, 1e-3), "flow_error": np.full(257, 1e-5)}
    whole, filtered = Recording(CYCLE.pressure, CYCLE.flow, CYCLE.period, **errors), LowPass(50.0)
    frequency = np.arange(257) / CYCLE.period
    spectrum = np.fft.rfft(getattr(whole, signal)) * filtered.response(frequency)
    seen = replace(whole, **{signal: np.fft.irfft(spectrum, 512)})
    corrected = correct_catheter(seen, filtered, signal)
    for name in ("pressure", "flow"):
        np.testing.assert_allclose(getattr(corrected, name), getattr(CYCLE, name), atol=1e-6)
    growth = getattr(corrected, f"{signal}_error")[1:15] / getattr(whole, f"{signal}_error")[1:15]
    np.testing.assert_allclose(growth, np.sqrt(1 + (frequency[1:15] / 50.0) ** 2))
    assert any(
        f"the {signal} was corrected for a filter of first order at 50 Hz" in str(one) for one in corrected.notes
    )


def test_a_harmonic_of_which_a_filter_let_less_than_a_twentieth_through_is_left_as_it_is():
    seen = through(CYCLE, LowPass(2.0))
    before, after = (np.fft.rfft(one.pressure) for one in (seen, correct_catheter(seen, LowPass(2.0))))
    harmonic = np.arange(15)
    lets = 1 / np.hypot(1, harmonic / CYCLE.period / 2.0)
    np.testing.assert_allclose(np.abs(after[:15] / before[:15]), np.where(lets < 1 / 20, 1.0, 1 / lets), rtol=1e-6)
    with pytest.raises(InputError, match="must be positive"):
        correct_catheter(CYCLE, LowPass(0.0))


@pytest.mark.parametrize("signal", ["pressure", "flow"])
def test_a_given_delay_of_a_signal_is_taken_off_and_told(signal):
    late = replace(CYCLE, **{signal: np.roll(getattr(CYCLE, signal), 16)})
    seen = without_delays(late, **{signal: 16 / 512 * CYCLE.period})
    for name in ("pressure", "flow"):
        np.testing.assert_allclose(getattr(seen, name), getattr(CYCLE, name), atol=1e-9)
    assert [str(one) for one in seen.notes] == [f"the {signal} was made 3.44 ms earlier, by its given delay"]


def test_a_delay_in_milliseconds_is_refused():
    with pytest.raises(InputError, match="flow delay of 4 s is half a cycle or more"):
        without_delays(CYCLE, flow=4.0)
