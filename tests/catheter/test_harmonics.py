"""The errors of harmonics: known noise is found again, and the signal ends where it was made to end."""

from dataclasses import fields, replace
from pathlib import Path

import numpy as np
import pytest

from vasowave.base import InputError
from vasowave.catheter import Disturbances, average_beats, synthetic_raw_recording
from vasowave.catheter.read import read_recording
from vasowave.pulse.cycle import Recording, harmonic_errors

MOUSE = Path(__file__).parents[2] / ".." / "shared" / "data" / "mouse-c6"
pytestmark = pytest.mark.filterwarnings("ignore:.*the flow rests")  # waves of a few harmonics, which never do
PHASE = 2 * np.pi * np.arange(512) / 512
NONE = Disturbances(**{field.name: 0.0 for field in fields(Disturbances)})


def cycle(harmonics: int, ratio: float = 0.7) -> Recording:
    """A cycle whose harmonics fall off by a ratio and end."""
    waves = sum(ratio**k * np.cos(k * PHASE - 0.7 * k) for k in range(1, harmonics + 1))
    return Recording(20 + 4 * waves, 0.2 + 0.05 * waves, 0.11)


def averaged(seed, true, noise, beats=60):
    asked = replace(NONE, pressure_noise=noise, flow_noise=0.01, ecg_noise=0.01)
    raw = synthetic_raw_recording(
        true, np.random.default_rng(seed), duration=beats * 0.13 + 2, sampling_rate=4000.0, disturbances=asked
    ).raw
    return average_beats(raw, beats=beats, harmonics=None, reject_ventilation=False)


def test_the_error_of_each_harmonic_is_the_noise_that_was_added():
    noise, beats = 0.4, 60
    errors = harmonic_errors(averaged(1, cycle(8), noise, beats))
    assert errors.source == "beats"
    # 440 samples a beat: an amplitude is 2/N of a sum, each of its two components has the variance 2 σ²/N.
    expected = noise * np.sqrt(2.0 / (440 * beats))
    # 60 beats give each of 25 harmonics to 1/sqrt(2*59), their mean to a fifth of that; jitter of beats adds below.
    assert np.mean(errors.error[10:35]) == pytest.approx(expected, rel=0.06)
    # The mean carries besides what is unknown of the baseline: less than a thirtieth of the noise.
    assert 0.7 * expected / np.sqrt(2) < errors.error[0] < noise / 30


def test_the_errors_cover_what_the_harmonics_are_wrong_by():
    true = np.abs(np.fft.rfft(cycle(8).pressure))[10:30] * 2 / 512
    ratios = []
    for seed in range(8):
        errors = harmonic_errors(averaged(seed, cycle(8), 0.4, 30))
        ratios.append((errors.modulus[10:30] ** 2 - true**2) / (2 * errors.error[10:30] ** 2))
    # Where there is no signal, a squared modulus is the squared error of both components.
    assert np.mean(ratios) == pytest.approx(1.0, abs=0.2)


@pytest.mark.parametrize("last", [4, 14])
def test_the_signal_ends_where_it_was_made_to_end(last):
    found = [harmonic_errors(averaged(seed, cycle(last, 0.8), 0.2)).with_signal for seed in range(2)]
    assert all(last <= one <= last + 1 for one in found)


def test_a_weak_harmonic_among_strong_ones_does_not_end_the_signal():
    gap = cycle(8)
    spectrum = np.fft.rfft(gap.pressure)
    spectrum[4] = 0
    found = averaged(3, replace(gap, pressure=np.fft.irfft(spectrum)), 0.2)
    assert harmonic_errors(found).with_signal == 8


def test_noise_alone_is_seldom_taken_for_a_harmonic():
    rng = np.random.default_rng(5)
    found = []
    for _ in range(200):
        noisy = cycle(8).pressure + 0.1 * rng.standard_normal(512)
        found.append(harmonic_errors(replace(cycle(8), pressure=noisy)).with_signal)
    assert min(found) >= 8
    assert np.mean(np.array(found) > 8) < 0.05


def test_a_rounded_cycle_file_has_at_least_the_error_of_its_rounding():
    errors = harmonic_errors(replace(cycle(8), pressure=np.round(cycle(8).pressure, 1)))
    assert errors.source == "file"
    assert errors.error[5] >= 0.1 / np.sqrt(12) * np.sqrt(2 / 512) * 0.99
    assert errors.with_signal == 8


def test_another_signal_is_refused():
    with pytest.raises(InputError, match="neither 'pressure' nor 'flow'"):
        harmonic_errors(cycle(8), "ecg")


@pytest.mark.skipif(not MOUSE.exists(), reason="needs shared/data/mouse-c6 beside the project")
def test_the_measured_mouse_has_little_above_harmonic_ten_and_nothing_above_twenty():
    recording = read_recording(MOUSE / "pC6_1024.dat", MOUSE / "qC6_1024.dat", period=0.11)
    errors = harmonic_errors(recording)
    assert errors.modulus[11:].max() < 0.014  # mmHg
    other = read_recording(MOUSE / "pC6_512.dat", MOUSE / "qC6_512.dat", period=0.11)
    # The same record at two samplings: it ends where its own flat spectrum begins, not where its file ends.
    assert harmonic_errors(other).with_signal == errors.with_signal
    assert 10 < errors.with_signal < 20
