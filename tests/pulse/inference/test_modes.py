"""Starts, modes and halves, on a problem of two modes whose posterior the prior's draws give, and on an animal."""

from dataclasses import replace

import numpy as np
import pytest

from vasowave.base import NumericalError
from vasowave.pulse.inference import (
    FIT_ELSEWHERE,
    FIT_LIKELIER,
    HALVES_DIFFER,
    SEVERAL_MODES,
    Discrepancy,
    FitOptimum,
    Target,
    climb,
    explore,
    find_modes,
    findings,
    halves_limit,
    screened,
    separate,
)

SAMPLES, UNKNOWNS = 9, 3
J = np.random.default_rng(7).normal(0, 1, (SAMPLES, UNKNOWNS))
NOISE = Discrepancy(SAMPLES, (1e-6, 0.0), 0.25 * np.eye(SAMPLES), np.zeros((SAMPLES, 1)))


def folded(points):
    """Outputs that a point shares, nearly, with another one on the other side of 0."""
    moved = points.copy()
    moved[:, 0] = points[:, 0] ** 2 + 0.15 * points[:, 0]
    return moved @ J.T


DATA = folded(np.array([[1.5, 0.3, -0.2]]))[0]
TARGET = Target(folded, DATA, NOISE, lambda points: points, folded)
ONE, OTHER = np.array([1.4, 0.0, 0.0]), np.array([-1.4, 0.0, 0.0])


@pytest.fixture(scope="module")
def exact():
    """Probability of the side above 0, and log evidence, by a grid whose steps are a third of the narrowest width."""
    axes = [np.linspace(-reach, reach, count) for reach, count in ((2.6, 201), (2.0, 100), (2.0, 100))]
    points = np.stack([axis.ravel() for axis in np.meshgrid(*axes, indexing="ij")], axis=1)
    square = ((DATA - folded(points)) ** 2).sum(axis=1) / 0.25 + (points**2).sum(axis=1)
    weight = np.exp(-0.5 * square) * np.prod([axis[1] - axis[0] for axis in axes])
    constant = -0.5 * (SAMPLES * np.log(2 * np.pi * 0.25) + UNKNOWNS * np.log(2 * np.pi))
    return weight[points[:, 0] > 0].sum() / weight.sum(), float(np.log(weight.sum()) + constant)


def test_two_modes_are_found_and_drawn_from_as_often_as_they_are_likely(exact):
    share, evidence = exact
    assert 0.2 < share < 0.8  # both matter
    modes = find_modes(folded, folded, DATA, NOISE, [], screened(folded, UNKNOWNS, 0))
    assert sorted(np.sign(mode.middle[0]) for mode in modes) == [-1.0, 1.0]
    explored = explore(TARGET, modes, np.random.default_rng(2), 1000)
    found = np.exp(explored.weights.log_weight)[explored.points[:, 0] > 0].sum()
    assert found == pytest.approx(share, abs=0.05)  # three standard errors of 1000 draws
    assert explored.log_evidence == pytest.approx(evidence, abs=max(0.05, 5 * explored.log_evidence_error))
    assert explored.weights.trusted
    assert explored.halves_distance < halves_limit(explored.effective)


def test_halves_that_each_know_one_mode_are_far_apart():
    one, other = (climb(folded, DATA, NOISE, start) for start in (ONE, OTHER))
    modes = [replace(one, halves=frozenset({0})), replace(other, halves=frozenset({1}))]
    blind = replace(TARGET, linear=lambda points: np.full((len(points), SAMPLES), np.nan))  # else each finds both
    explored = explore(blind, modes, np.random.default_rng(3), 400)
    assert explored.halves_distance > 1.5  # the whole has both: SD of about 1.5, means 3 apart
    assert explored.weights.trusted  # k cannot see it
    said = list(findings(explored.halves_distance, explored.effective, explored.shares, None, 0.0, {}))
    assert [finding.code for finding in said] == [HALVES_DIFFER.code, SEVERAL_MODES.code]


@pytest.mark.parametrize(("distance", "shares"), [(8.0, [0.25, 0.75]), (3.0, [1.0])])
def test_components_that_overlap_are_one_mode(distance, shares):
    """Normal densities with a quarter and three quarters of the draws, so many SD apart."""
    x = np.random.default_rng(6).standard_normal(2000) + np.where(np.arange(2000) < 500, 0.0, distance)
    density = np.log([[0.25], [0.75]]) - 0.5 * (x - np.array([[0.0], [distance]])) ** 2
    assert separate(density, np.full(2000, 1 / 2000)) == pytest.approx(shares, abs=0.01)


def test_a_half_whose_modes_are_hopeless_is_far_from_the_other():
    best = replace(climb(folded, DATA, NOISE, ONE), halves=frozenset({0}))
    beside = np.array([3.5, 2.0, 2.0])
    stuck = replace(best, middle=beside, output=folded(beside[np.newaxis])[0], halves=frozenset({1}))
    explored = explore(TARGET, [best, stuck], np.random.default_rng(4), 100)
    assert explored.halves_distance > 5
    assert len(explored.shares) == 1


def test_a_mode_that_lies_in_anothers_draws_is_not_explored_twice():
    mode = replace(climb(folded, DATA, NOISE, ONE), halves=frozenset({0}))
    near = mode.middle + 0.5 * mode.root[:, 0]
    again = replace(mode, middle=near, output=folded(near[np.newaxis])[0], halves=frozenset({1}))
    explored = explore(TARGET, [mode, again], np.random.default_rng(5), 200)
    assert len(explored.shares) == 1
    assert explored.halves_distance < halves_limit(explored.effective)  # both halves found it


def test_a_start_that_cannot_be_simulated_is_a_failed_start_and_not_the_end():
    def above(points):
        return np.where(points[:, :1] < -0.5, np.nan, folded(points))

    def nowhere(points):
        return np.full((len(points), SAMPLES), np.nan)

    modes = find_modes(above, folded, DATA, NOISE, [OTHER], screened(folded, UNKNOWNS, 0))
    assert [np.sign(mode.middle[0]) for mode in modes] == [1.0]
    with pytest.raises(NumericalError, match="start"):
        find_modes(nowhere, folded, DATA, NOISE, [], screened(folded, UNKNOWNS, 0))


def test_a_fit_elsewhere_is_a_finding_with_distance_and_nats():
    draws = {name: np.exp(np.random.default_rng(1).normal(np.log(mean), 0.1, 1000)) for name, mean in
             (("wave_speed", 250.0), ("R_T", 76.0))}  # fmt: skip

    def said(speed, log):
        fit = FitOptimum(log, {"wave_speed": speed, "R_T": 76.0})
        return list(findings(0.1, 300.0, np.ones(1), fit, 20.0, draws))

    assert said(270.0, 19.0) == []
    away = said(250.0 * np.exp(0.5), 17.0)
    assert [one.code for one in away] == [FIT_ELSEWHERE.code]
    assert dict(away[0].values) == {"distance": pytest.approx(5.0, abs=0.3), "nats": pytest.approx(3.0)}
    assert "less likely than the best draw, by 3.0 nats" in str(away[0])
    likelier = said(250.0, 30.0)
    assert likelier[0].code == FIT_LIKELIER.code
    assert dict(likelier[0].values)["nats"] == pytest.approx(10.0)
    assert "likelier than every draw, by 10.0 nats" in str(likelier[0])


def test_a_quantity_that_held_parameters_fix_is_not_compared_with_the_fit():
    """Its draws do not scatter, so that no distance can be told in their SD."""
    speed = np.exp(np.random.default_rng(8).standard_normal(100))
    optimum = FitOptimum(0.0, {"wave_speed": 1.0, "R_T": 76.0})
    draws = {"wave_speed": speed, "R_T": np.full(100, 76.0)}
    assert list(findings(0.0, 400.0, np.ones(1), optimum, 0.0, draws)) == []
    (away,) = findings(
        0.0, 400.0, np.ones(1), optimum._replace(quantities={"wave_speed": 50.0, "R_T": 76.0}), 0.0, draws
    )
    assert away.code == FIT_ELSEWHERE.code
