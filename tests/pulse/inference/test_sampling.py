"""The ensemble sampler and the evidence, against closed forms and direct draws."""

import numpy as np
import pytest
from scipy.stats import ks_2samp

from vasowave.pulse.inference import log_integral, sample, worth


def banana(points):
    """Log density of a bent valley; its integral is 2π · 0.5 · 1, its second marginal has mean 1."""
    return -0.5 * points[:, 0] ** 2 - 0.5 * ((points[:, 1] - points[:, 0] ** 2) / 0.5) ** 2


def drawn(density, rng, count=2, walkers=100, steps=2000):
    ensemble = sample(density, rng.standard_normal((walkers, count)), steps, rng, keep_every=20)
    half = len(ensemble.points) // 2
    return ensemble.points[half:].reshape(-1, count), ensemble.log_density[half:].ravel()


def test_draws_are_distributed_like_the_valley_drawn_directly():
    """Every hundredth step, more than twice as far apart as the walkers remember."""
    rng = np.random.default_rng(2)
    ours = sample(banana, rng.standard_normal((100, 2)), 3600, rng, keep_every=100).points[6:].reshape(-1, 2)
    across = rng.standard_normal(20_000)
    direct = np.column_stack([across, across**2 + 0.5 * rng.standard_normal(20_000)])
    for ours_one, theirs in zip(ours.T, direct.T, strict=True):
        assert ks_2samp(ours_one, theirs).pvalue > 0.01


def test_the_evidence_of_a_bent_valley_is_its_integral():
    rng = np.random.default_rng(5)
    points, values = drawn(banana, rng)
    found, error = log_integral(banana, points, values, rng)
    assert error < 0.05
    assert found == pytest.approx(np.log(2 * np.pi * 0.5), abs=4 * error)


@pytest.mark.parametrize("kept", [0.0, 0.5, 0.8])
def test_walkers_are_worth_the_fewer_draws_the_longer_they_remember(kept):
    """Autoregressive walkers: n (1 - φ)/(1 + φ) of n points are independent, of long chains."""
    rng, points = np.random.default_rng(7), [np.random.default_rng(8).standard_normal((200, 4))]
    for _ in range(399):
        points.append(kept * points[-1] + np.sqrt(1 - kept**2) * rng.standard_normal((200, 4)))
    assert worth(np.array(points)) == pytest.approx(400 * 200 * (1 - kept) / (1 + kept), rel=0.15)
