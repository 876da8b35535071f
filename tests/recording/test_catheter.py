"""Catheters that ring: recognized behind waves of an independent solver, undone on request, not seen where none is."""

from pathlib import Path

import numpy as np
import pytest

from vasowave.errors import InputError
from vasowave.recording import Catheter, Recording, correct_catheter, read_recording, suspect_catheter

DATA = Path(__file__).parents[2] / ".." / "shared" / "data"
PHASE = 2 * np.pi * np.arange(512) / 512
WAVES = sum(0.75**k * np.cos(k * PHASE - 0.9 * k) for k in range(1, 15))
CYCLE = Recording(16 + 4 * WAVES, 0.2 + 0.1 * WAVES, 0.11)

needs_data = pytest.mark.skipif(not DATA.exists(), reason="needs shared/data beside the project")


def through(recording: Recording, catheter: Catheter) -> Recording:
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
    assert any("corrected for a catheter of 50 Hz" in str(note) for note in corrected.notes)


def test_what_a_catheter_lost_is_not_invented():
    with pytest.raises(InputError, match="what is lost cannot be recovered"):
        correct_catheter(CYCLE, Catheter(5.0, 0.5))
    with pytest.raises(InputError, match="must be positive"):
        correct_catheter(CYCLE, Catheter(50.0, 0.0))
