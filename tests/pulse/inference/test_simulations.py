"""Simulations that are kept: what was computed is never computed again, and never mistaken for something else."""

from functools import partial

import numpy as np
import pytest

from vasowave.base import InputError
from vasowave.pulse.inference import Simulations

POINTS = np.random.default_rng(1).standard_normal((70, 3))


def double(points):
    return 2 * points


def killed_after(batches):
    left = [batches]

    def compute(points):
        left[0] -= 1
        if left[0] < 0:
            raise KeyboardInterrupt
        return 2 * points

    return compute


def test_a_killed_run_goes_on_with_what_it_had(tmp_path):
    path = tmp_path / "kept.npz"
    with pytest.raises(KeyboardInterrupt):
        Simulations(killed_after(2), path, "key")(POINTS)
    again = Simulations(double, path, "key")
    assert np.array_equal(again(POINTS), 2 * POINTS)
    assert again.computed == 70 - 2 * 32
    assert again.asked == 70


def test_failures_are_kept_too(tmp_path):
    path = tmp_path / "kept.npz"
    lost = partial(np.full_like, fill_value=np.nan)
    Simulations(lost, path, "key")(POINTS[:3])
    again = Simulations(lost, path, "key")
    assert np.isnan(again(POINTS[:3])).all()
    assert again.computed == 0


def test_simulations_of_another_problem_are_refused(tmp_path):
    path = tmp_path / "kept.npz"
    Simulations(double, path, "one")(POINTS[:3])
    with pytest.raises(InputError, match="another problem"):
        Simulations(double, path, "other")


@pytest.mark.parametrize("content", [b"", b"not a file of simulations", b"PK\x03\x04 cut off"])
def test_a_damaged_file_is_an_error_that_says_what_to_do(tmp_path, content):
    path = tmp_path / "kept.npz"
    path.write_bytes(content)
    with pytest.raises(InputError, match="remove it"):
        Simulations(double, path, "key")
