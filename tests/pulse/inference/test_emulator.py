"""The emulator: exact where it must be, honest about its error where it cannot be."""

import numpy as np
import pytest
from scipy.interpolate import RBFInterpolator

from vasowave.pulse.inference import fit_emulator


def same(points):
    return points


def cubic(points):
    x, y = points.T
    return np.stack([1 + x - 2 * y + x * y**2, 3 * y + 0.2 * x**3], axis=1)


def wavy(points):
    x, y = points.T
    return np.stack([np.sin(1.5 * x) + np.cos(y), np.exp(0.5 * x + 0.3 * y)], axis=1)


@pytest.fixture
def points():
    return np.random.default_rng(1).standard_normal((80, 2))


def test_a_cubic_is_learned_to_the_noise_that_is_allowed(points):
    emulator = fit_emulator(points, cubic(points), points, np.ones(2), same)
    fresh = np.random.default_rng(2).standard_normal((50, 2))
    assert np.abs(emulator(fresh) - cubic(fresh)).max() < 0.03  # a simulation may be off by 0.01 of the scale


def test_the_error_at_points_left_out_is_that_at_new_ones():
    points, fresh = (np.random.default_rng(seed).uniform(-2, 2, (count, 2)) for seed, count in ((2, 80), (3, 2000)))
    emulator = fit_emulator(points, wavy(points), points, np.ones(2), same)
    missed = np.sqrt(np.mean((emulator(fresh) - wavy(fresh)) ** 2, axis=0))
    assert np.all(emulator.error < 4 * missed)
    assert np.all(missed < 4 * emulator.error)


def test_the_jacobian_is_the_derivative(points):
    emulator = fit_emulator(points, cubic(points), points, np.ones(2), same)
    assert emulator.jacobian(np.zeros(2)) == pytest.approx(np.array([[1.0, -2.0], [0.0, 3.0]]), abs=0.05)


def test_what_bends_along_one_unknown_is_learned_from_far_along_the_others():
    points, fresh = (np.random.default_rng(seed).standard_normal((120, 4)) for seed in (5, 6))

    def bends(points):
        return np.sin(3 * points[:, :1]) + points[:, 1:2] * points[:, 2:3]

    chosen = fit_emulator(points, bends(points), points, np.ones(1), same)
    alike = RBFInterpolator(points, bends(points))  # to which all directions are one
    off, off_alike = (np.sqrt(np.mean((one(fresh) - bends(fresh)) ** 2)) for one in (chosen, alike))
    assert 2 * chosen.lengths[0] < chosen.lengths[1:].min()
    assert off < 0.5 * off_alike
