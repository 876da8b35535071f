"""What of a recording a fit compares, and what the error of its measurement explains: in a study."""

from dataclasses import fields

import numpy as np
import pytest

from choices import answers_by_harmonics
from vasowave.base import InputError
from vasowave.catheter import Disturbances, average_beats, synthetic_raw_recording
from vasowave.catheter.read import read_recording
from vasowave.pulse.calibration import Search, compared_part
from vasowave.pulse.cycle import Recording
from vasowave.pulse.examples import control_network

pytestmark = pytest.mark.filterwarnings("ignore:.*the flow rests")  # waves of a few harmonics, which never do
PHASE = 2 * np.pi * np.arange(256) / 256


def cycle(harmonics, ratio=0.7):
    waves = sum(ratio**k * np.cos(k * PHASE - 0.7 * k) for k in range(1, harmonics + 1))
    return Recording(15 + 4 * waves, 0.2 + 0.05 * waves, 0.11)


def averaged(seed, noise, beats=40, true=None):
    none = {field.name: 0.0 for field in fields(Disturbances)}
    asked = Disturbances(**none | {"pressure_noise": noise, "flow_noise": 0.01, "ecg_noise": 0.01})
    raw = synthetic_raw_recording(
        true or cycle(9),
        np.random.default_rng(seed),
        duration=beats * 0.13 + 2,
        sampling_rate=4000.0,
        disturbances=asked,
    ).raw
    return average_beats(raw, beats=beats, harmonics=None, reject_ventilation=False).recording


def test_a_recording_is_compared_up_to_its_last_harmonic_with_signal():
    recording = averaged(1, 0.3)
    compared = compared_part(recording)
    assert (compared.harmonics, compared.samples, compared.choice) == (9, 19, "signal")
    # The compared samples are the true cycle's but for the averaged noise, 0.3 mmHg over the root of 40 beats.
    true = 15 + 4 * sum(0.7**k * np.cos(2 * np.pi * k * np.arange(19) / 19 - 0.7 * k) for k in range(1, 10))
    assert np.max(np.abs(compared.measured - true)) < 4 * 0.3 / np.sqrt(40)
    assert "harmonics 0 to 9" in str(compared.findings()[0])
    assert "scatter of the beats" in str(compared.findings()[0])


def test_a_number_or_all_can_be_asked_for_and_what_is_no_evidence_is_said():
    recording = averaged(1, 0.3)
    assert compared_part(recording, "all").samples == 256
    given = compared_part(recording, 30)
    assert (given.harmonics, given.samples, given.choice) == (30, 61, "given")
    assert "no evidence" in str(given.findings()[0])
    assert "no evidence" not in str(compared_part(recording, 8).findings()[0])
    with pytest.raises(InputError, match="hold 127 harmonics, 200 cannot"):
        compared_part(recording, 200)


def test_a_weak_recording_keeps_the_fewest_harmonics_and_says_so():
    compared = compared_part(averaged(2, 0.3, true=cycle(3)))
    assert compared.harmonics == 8
    assert "up to harmonic 3" in str(compared.findings()[0])


def test_the_error_power_is_the_mean_square_by_which_averages_scatter():
    averages = [compared_part(averaged(seed, 0.4), 12) for seed in range(12)]
    scatter = np.var([one.measured - one.measured.mean() for one in averages], axis=0, ddof=1)
    expected = np.mean([one.error_power()[1:].sum() for one in averages])
    # 24 coefficients with 11 degrees of freedom each: the mean square is known to √(2/264) = 9 %.
    assert np.mean(scatter) == pytest.approx(expected, rel=0.3)


@pytest.mark.weekly
def test_the_answer_of_mouse_c6_depends_on_harmonics_without_signal_and_this_is_tabled(shared):
    folder = shared / "mouse-c6"
    mouse = read_recording(folder / "pC6_512.dat", folder / "qC6_512.dat", period=0.11)
    table = answers_by_harmonics(
        control_network(), mouse, ("linear", "tangent"), (10, 20, "all"), search=Search(starts=2)
    )
    difference = table["AICc difference"].unstack()
    signed = difference["tangent"] - difference["linear"]
    assert abs(signed[10]) < 5  # undecided
    assert signed[20] > 20
    assert signed[255] > 100
    # What is fitted hardly moves: the power of the residual above harmonic 10 is 1/300 of all.
    for wall, most in (("linear", 0.001), ("tangent", 0.05)):
        speed = table.xs(wall, level="wall")["wave_speed [cm/s]"]
        assert speed.max() / speed.min() < 1 + most
