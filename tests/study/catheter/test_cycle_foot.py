"""Where a cycle's upstroke begins, and cycles that begin there."""

import numpy as np
import pytest

from made_cohort import bare_result
from vasowave.pulse.analysis import impedance
from vasowave.pulse.cycle import Recording, amplitudes, cycle_foot, harmonic_error
from vasowave.study.animal import from_foot, impedance_error, recording_dataset

T, N = 0.11, 200
PHASE = np.arange(N) / N
PRESSURE = 12 + 9 * np.exp(-0.5 * ((PHASE - 0.35) / 0.08) ** 2)
FLOW = 0.02 + np.exp(-0.5 * ((PHASE - 0.33) / 0.07) ** 2)


@pytest.mark.parametrize("shift", [0, 37, 120, 199])
def test_wherever_a_cycle_was_cut_it_begins_at_its_foot_with_the_values_that_were_measured(shift):
    cut = Recording(np.roll(PRESSURE, shift), np.roll(FLOW, shift), T)
    result = bare_result(recording=recording_dataset(cut))
    share, pressure = from_foot(result, "pressure")
    assert np.all(np.diff(share) > 0)
    assert 0 <= share[0] < 1 / N + 1e-9
    assert share[-1] - share[0] == pytest.approx(1.0)
    assert sorted(pressure[:-1]) == sorted(PRESSURE)
    top = share[np.argmax(pressure)]
    assert top == pytest.approx(0.35 - cycle_foot(PRESSURE), abs=1 / N + 1e-9)
    assert 0.15 < top < 0.25  # the foot of this bell, two to three widths before its top
    flow_share, flow = from_foot(result, "flow")
    assert flow_share[np.argmax(flow)] - top == pytest.approx(-0.02, abs=1e-6)


def test_the_error_of_the_impedance_is_what_repeated_averages_scatter():
    rng, beats, found, told = np.random.default_rng(1), 25, [], []
    for _ in range(300):
        cuts = [values + size * rng.standard_normal((beats, N)) for values, size in ((PRESSURE, 0.3), (FLOW, 0.05))]
        means, errors = [cut.mean(axis=0) for cut in cuts], [harmonic_error(cut) for cut in cuts]
        one = Recording(*means, T, pressure_error=errors[0], flow_error=errors[1])
        Z = impedance(*means, T, 4)
        found.append(np.log(Z.Z))
        result = bare_result(recording=recording_dataset(one))
        result.measured.impedance["harmonic"] = ("harmonic", np.arange(5))
        told.append(impedance_error(result))
    scatter = np.std(np.array(found).real, axis=0)[1:]
    np.testing.assert_allclose(np.mean(told, axis=0)[1:], scatter, rtol=0.15)  # the SD of 300 is known to 4 %
    assert impedance_error(bare_result(recording=recording_dataset(Recording(PRESSURE, FLOW, T)))) is None
    assert amplitudes(PRESSURE)[0].real == pytest.approx(PRESSURE.mean())
