"""Rounds and reweighting on problems whose posterior is known, or that emcee can answer without an emulator."""

import numpy as np
import pytest
from scipy.optimize import minimize
from scipy.stats import ks_2samp, multivariate_normal, norm

from vasowave.pulse.inference import Discrepancy, Target, climb, explore, log_prior

SAMPLES, UNKNOWNS = 9, 3
J = np.random.default_rng(7).normal(0, 1, (SAMPLES, UNKNOWNS))
DATA = np.random.default_rng(8).normal(0, 1.5, SAMPLES)


def white(variance, amplitude=1e-6):
    """Noise without a discrepancy worth the name."""
    return Discrepancy(SAMPLES, (amplitude, 0.0), variance * np.eye(SAMPLES), np.zeros((SAMPLES, 1)))


def target(simulate, noise):
    return Target(simulate, DATA, noise, lambda points: points, simulate)


def linear(points):
    return points @ J.T


def bent(points):
    moved = points.copy()
    moved[:, 0] = np.exp(0.4 * points[:, 0]) + 0.3 * points[:, 1] ** 2
    return moved @ J.T


def explored_by(target, seed, draws=400):
    climbed = climb(target.simulate, target.measured, target.noise, np.zeros(UNKNOWNS))
    return explore(target, [climbed], np.random.default_rng(seed), draws)


def steep(points):
    return np.exp(np.clip(2.0 * points, -50, 50)) @ J.T


@pytest.mark.parametrize("start", [-2.0, -1.0, 0.0, 1.0])
def test_a_climb_never_ends_below_its_start_in_prior_and_likelihood_together(start):
    noise, here = white(1.0), np.full(UNKNOWNS, start)
    climbed = climb(steep, DATA, noise, here)

    def height(point):
        prior = multivariate_normal(np.zeros(UNKNOWNS)).logpdf(point)
        return prior + float(noise.log_likelihood(DATA - steep(point[np.newaxis])[0]))

    assert height(climbed.middle) >= height(here)
    found = minimize(lambda point: -height(point), climbed.middle, method="Nelder-Mead").x
    assert height(found) - height(climbed.middle) < 0.5  # the mode, as nearly as the rounds need it


def weighted(explored):
    return np.exp(explored.weights.log_weight)


def test_the_posterior_of_a_linear_problem_is_the_normal_one():
    explored = explored_by(target(linear, white(0.25)), 1, 1000)
    covariance = np.linalg.inv(J.T @ J / 0.25 + np.eye(UNKNOWNS))
    mean = covariance @ J.T @ DATA / 0.25
    found = weighted(explored) @ explored.points
    spread = np.cov(explored.points.T, aweights=weighted(explored))
    assert np.all(np.abs(found - mean) < 5 * np.sqrt(np.diag(covariance) / 1000))
    assert spread == pytest.approx(covariance, abs=0.2 * np.diag(covariance).max())
    assert explored.weights.trusted
    assert 500 < explored.effective < explored.weights.effective  # walkers remember


@pytest.mark.weekly
def test_means_scatter_around_the_exact_ones_as_the_effective_draws_say():
    covariance = np.linalg.inv(J.T @ J / 0.25 + np.eye(UNKNOWNS))
    mean = covariance @ J.T @ DATA / 0.25
    scores = []
    for seed in range(30):
        explored = explored_by(target(linear, white(0.25)), 100 + seed)
        away = weighted(explored) @ explored.points - mean
        scores.append(away / np.sqrt(np.diag(covariance) / explored.effective))
    assert 0.7 < np.mean(np.square(scores)) < 1.35  # 90 of them; by chance outside once in a hundred


def test_the_evidence_of_a_linear_problem_is_its_closed_form():
    explored = explored_by(target(linear, white(0.25)), 2, 400)
    expected = multivariate_normal(cov=J @ J.T + 0.25 * np.eye(SAMPLES)).logpdf(DATA)
    assert explored.log_evidence == pytest.approx(expected, abs=max(0.05, 5 * explored.log_evidence_error))


def test_without_data_the_posterior_is_the_prior():
    explored = explored_by(target(linear, white(1e8)), 3, 1000)
    found = weighted(explored) @ explored.points
    assert np.abs(found).max() < 0.16  # five standard errors of 1000 draws
    assert np.cov(explored.points.T, aweights=weighted(explored)) == pytest.approx(np.eye(UNKNOWNS), abs=0.25)


def test_a_bent_problem_has_the_posterior_that_emcee_finds_without_an_emulator():
    emcee = pytest.importorskip("emcee")
    noise = white(0.3, amplitude=0.5)
    explored = explored_by(target(bent, noise), 4, 1000)
    assert explored.weights.trusted

    def density(points):
        return noise.log_likelihood(DATA - bent(points)) + log_prior(points)

    direct = emcee.EnsembleSampler(60, UNKNOWNS, density, vectorize=True)
    direct.random_state = np.random.RandomState(5).get_state()
    direct.run_mcmc(0.1 * np.random.default_rng(6).standard_normal((60, UNKNOWNS)), 1200)
    theirs = direct.get_chain(discard=400, thin=60, flat=True)
    rows = np.random.default_rng(9).choice(1000, 600, p=weighted(explored))
    ours = explored.points[np.unique(rows)]
    for one, other in zip(ours.T, theirs.T, strict=True):
        assert ks_2samp(one, other).pvalue > 0.005


@pytest.mark.validation
def test_the_evidence_of_a_bent_problem_is_that_of_nested_sampling():
    """dynesty knows no emulator, no bridge and no weights: it integrates the likelihood over the prior."""
    dynesty = pytest.importorskip("dynesty")
    noise = white(0.3, amplitude=0.5)
    explored = explored_by(target(bent, noise), 15, 400)

    def likelihood(point):
        return float(noise.log_likelihood(DATA - bent(point[np.newaxis])[0]))

    nested = dynesty.NestedSampler(likelihood, norm.ppf, UNKNOWNS, nlive=150, rstate=np.random.default_rng(16))
    nested.run_nested(dlogz=0.05, print_progress=False)
    theirs = nested.results
    error = np.hypot(explored.log_evidence_error, theirs.logzerr[-1])
    assert error < 0.3
    assert explored.log_evidence == pytest.approx(theirs.logz[-1], abs=3 * error)


@pytest.mark.validation
def test_an_emulator_that_is_wrong_is_corrected_by_the_weights():
    """Its reach covers one mode only as far as simulations go; a kink inside it is nothing a polynomial can follow."""

    def kinked(points):
        return linear(points) + 0.4 * np.abs(points[:, :1])

    noise = white(0.25)
    explored = explored_by(target(kinked, noise), 10, 1000)
    grid = np.random.default_rng(11).standard_normal((200_000, UNKNOWNS))  # from the prior, weighted by the likelihood
    log = noise.log_likelihood(DATA - kinked(grid))
    exact = np.exp(log - log.max()) @ grid / np.exp(log - log.max()).sum()
    assert np.abs(weighted(explored) @ explored.points - exact).max() < 0.08


@pytest.mark.validation
def test_a_posterior_that_reaches_far_beyond_its_normal_approximation_is_not_cut_off():
    """Steep at the mode and flat beyond; weights cannot see what no draw reaches. Exact mean from the prior's draws."""

    def flattening(points):
        moved = points.copy()
        moved[:, 0] = 2 * np.arctan(4 * points[:, 0])
        return moved @ J.T

    data, noise = np.array([2.6, 0.0, 0.0]) @ J.T, white(0.15)
    grid = np.random.default_rng(11).standard_normal((400_000, UNKNOWNS))
    log = noise.log_likelihood(data - flattening(grid))
    exact = np.exp(log - log.max()) @ grid[:, 0] / np.exp(log - log.max()).sum()
    found = []
    for seed in (3, 4):
        climbed = climb(flattening, data, noise, np.zeros(UNKNOWNS))
        explored = explore(
            Target(flattening, data, noise, lambda points: points, flattening),
            [climbed],
            np.random.default_rng(seed),
            1000,
        )
        found.append(weighted(explored) @ explored.points[:, 0])
    assert np.mean(found) == pytest.approx(exact, abs=0.045)  # 1.06; five standard errors of 2000 draws


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_a_shelf_beside_a_steep_mode_is_drawn_to_its_end(seed):
    """The shelf is 2.5 nats lower than the mode, and long: weights do not tell that draws from the mode miss it."""

    def shelved(points):
        moved = points.copy()
        moved[:, 0] = np.exp(np.clip(4 * points[:, 0], -50, 20))
        return moved @ J.T / np.linalg.norm(J, axis=0)[0]

    data, noise = shelved(np.array([[np.log(0.9) / 4, 0, 0]]))[0], white(0.16)
    prior = np.random.default_rng(11).standard_normal((400_000, UNKNOWNS))
    likelihood = np.exp(-0.5 * ((data - shelved(prior)) ** 2).sum(axis=1) / 0.16)
    beyond = likelihood[prior[:, 0] < -0.8].sum() / likelihood.sum()
    climbed = climb(shelved, data, noise, np.zeros(UNKNOWNS))
    whole = Target(shelved, data, noise, lambda points: points, shelved)
    explored = explore(whole, [climbed], np.random.default_rng(seed))
    found = weighted(explored)[explored.points[:, 0] < -0.8].sum()
    assert beyond > 0.1
    assert found == pytest.approx(beyond, abs=0.06)  # three standard errors of 250 independent draws


def test_points_that_cannot_be_simulated_have_no_weight():
    def half(points):
        found = linear(points)
        found[points[:, 0] > 0.8] = np.nan
        return found

    explored = explored_by(target(half, white(2.0)), 12, 400)
    assert np.all(weighted(explored)[explored.points[:, 0] > 0.8] == 0.0)


def batches_of(simulate):
    """Return how many batches of 80 of 400 draws were simulated."""
    asked = []

    def counting(points):
        asked.append(len(points))
        return simulate(points)

    explored_by(target(counting, white(0.3)), 13)
    return asked.count(80)


def test_draws_that_the_emulator_foretells_are_not_simulated():
    assert batches_of(bent) == 1


@pytest.mark.validation
def test_draws_that_the_emulator_does_not_foretell_are_all_simulated():
    batches = batches_of(lambda points: linear(points) + 0.4 * np.sin(40 * points[:, :1]))
    assert batches in {5, 10, 15}  # all of one to three tries


def test_the_same_seed_gives_the_same_draws():
    first, second = (explored_by(target(bent, white(0.3)), 14, 40) for _ in range(2))
    assert np.array_equal(first.points, second.points)
    assert first.log_evidence == second.log_evidence
