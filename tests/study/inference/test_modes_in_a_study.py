"""Starts, modes and halves, on a problem of two modes whose posterior the prior's draws give, and on an animal."""

import pytest

from posterior_modes import animal
from vasowave.pulse import derived
from vasowave.pulse.inference import (
    posterior,
)


@pytest.mark.validation
def test_a_tangent_animal_far_from_nominal_is_found_from_nominal():
    """Nominal β is 13 mmHg. Of four steps from there alone came 625 [386, 1079] cm/s, with a Pareto k of 0.09."""
    network, recording, model = animal("low", 3)
    found = posterior(network, recording, "tangent", draws=200)  # of 40 the ends are single draws
    truth = derived(model, recording.mean_pressure)["wave_speed"]
    row = found.summary.loc["wave_speed"]
    assert truth == pytest.approx(220, abs=1)
    assert row["interval_low"] < truth < row["interval_high"] < 300
    assert found.diagnostics.trusted
