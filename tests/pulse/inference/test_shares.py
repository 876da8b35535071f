"""Where the variance comes from, against drawn estimates."""

import numpy as np
import pandas as pd
import pytest

from vasowave.pulse.inference import Discrepancy, variance_shares

SAMPLES = 7
RNG = np.random.default_rng(1)
J = RNG.normal(0, 1, (SAMPLES, 3))
VESSELS = RNG.normal(0, 0.3, (SAMPLES, 2))
SOURCES = ["recording", "image", "model"]
SLOPES = pd.DataFrame([[1.0, 0.5, 0.0], [0.2, 0.0, 1.0]], index=["one", "other"])


def shares(measured=0.2, vessels=VESSELS):
    noise = Discrepancy(SAMPLES, (0.4, 0.0), measured * np.eye(SAMPLES), vessels)
    return variance_shares(SLOPES, SOURCES, J, noise, np.zeros((1, SAMPLES))), noise


def test_shares_are_the_variances_of_errors_that_are_drawn_one_source_at_a_time():
    found, noise = shares()
    discrepancy = np.diag(noise.variance(np.zeros((1, SAMPLES))))
    total = noise.measured + VESSELS @ VESSELS.T + discrepancy
    rng, draws = np.random.default_rng(2), 40_000
    expected = {}
    for name in found.columns:
        x = np.zeros((draws, 3))
        place = {"prior": 0, "image": 1, "model": 2}.get(name)
        if place is not None:
            x[:, place] = rng.standard_normal(draws)
        covariance = {"recording": noise.measured, "image": VESSELS @ VESSELS.T, "model": discrepancy}.get(name)
        data = x @ J.T
        if covariance is not None:
            data = data + rng.multivariate_normal(np.zeros(SAMPLES), covariance, draws)
        gain = np.linalg.inv(J.T @ np.linalg.solve(total, J) + np.eye(3)) @ J.T @ np.linalg.inv(total)
        expected[name] = ((x - data @ gain.T) @ SLOPES.to_numpy().T).var(axis=0)
    table = pd.DataFrame(expected, index=SLOPES.index)
    table = table.div(table.sum(axis=1), axis=0)
    assert found.to_numpy() == pytest.approx(table.to_numpy(), abs=0.01)


def test_what_single_vessels_move_directly_has_the_share_that_it_had_were_they_unknowns():
    slopes = pd.DataFrame(np.hstack([SLOPES, [[0.7, -0.4], [0.0, 0.9]]]), index=SLOPES.index)
    noise, unknowns = shares()[1], shares(vessels=np.zeros((SAMPLES, 1)))[1]
    found = variance_shares(slopes, SOURCES, J, noise, np.zeros((1, SAMPLES)))
    residuals = np.zeros((1, SAMPLES))
    drawn = variance_shares(slopes, [*SOURCES, "image", "image"], np.hstack([J, VESSELS]), unknowns, residuals)
    assert found["image"].to_numpy() == pytest.approx(drawn["image"].to_numpy(), abs=0.02)
    assert (found["image"] > shares()[0]["image"] + 0.02).all()
