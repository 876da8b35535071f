"""What of a recording a fit compares, and what the error of its measurement explains."""

from dataclasses import replace

import numpy as np
import pytest

from vasowave.base import InputError
from vasowave.pulse.calibration import Search, calibrate, compared_part
from vasowave.pulse.cycle import Recording, resample
from vasowave.pulse.examples import control_network, virtual_mouse

PHASE = 2 * np.pi * np.arange(256) / 256


def cycle(harmonics, ratio=0.7):
    waves = sum(ratio**k * np.cos(k * PHASE - 0.7 * k) for k in range(1, harmonics + 1))
    return Recording(15 + 4 * waves, 0.2 + 0.05 * waves, 0.11)


@pytest.mark.parametrize("wrong", [0, 7, 600, -3, 10.5, "some", True])
def test_other_choices_of_harmonics_are_refused(wrong):
    with pytest.raises(InputError, match="'signal', 'all', or a number of harmonics from 8"):
        Search(pressure_harmonics=wrong)


def test_a_cycle_that_kept_its_first_harmonics_is_compared_at_the_samples_that_carry_them():
    mouse = virtual_mouse()
    cut = Recording(resample(resample(mouse.pressure, 41), 512), mouse.flow, mouse.period)  # 20 harmonics
    assert compared_part(cut, "all").samples in (41, 42)
    assert compared_part(cut).samples <= 41


def test_the_discrepancy_is_what_the_residual_has_beyond_the_error():
    compared = compared_part(replace(cycle(9), pressure_error=np.full(129, 0.1)))
    t = 2 * np.pi * np.arange(compared.samples) / compared.samples
    table = compared.spectrum(0.5 * np.cos(3 * t) + 0.05 * np.sin(5 * t))
    assert table["residual_modulus"][3] == pytest.approx(0.5)
    assert table["discrepancy"][3] == pytest.approx(np.sqrt(0.25 - 2 * 0.01))
    assert table["discrepancy"][5] == 0
    assert table["measured_modulus"][2] == pytest.approx(4 * 0.49)


def test_a_simulation_is_compared_in_the_same_harmonics_as_the_recording():
    fit = calibrate(control_network(), virtual_mouse(), search=Search(starts=1, pressure_harmonics=8))
    inlet = fit.simulation["pressure"].sel(vessel="1", station="inlet").values
    spectra = [np.fft.rfft(one)[:9] / len(one) for one in (fit.recording.pressure, inlet)]
    expected = np.fft.irfft(17 * (spectra[0] - spectra[1]), 17)
    np.testing.assert_allclose(fit.residual, expected, atol=1e-5)  # both from 512 samples of the same cycles
    assert pytest.approx(fit.mean_square * 17) == fit.S
    assert fit.harmonics["residual_modulus"][0] == pytest.approx(abs(expected.mean()), abs=1e-5)
