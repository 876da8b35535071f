"""Single steps of sampling by arithmetic: emulator, densities, modes, weights, shares, on few and unequal numbers."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest
from scipy import stats
from scipy.special import logsumexp

import vasowave as vw
from vasowave.errors import NumericalError
from vasowave.inference import emulator, ensemble, mixture, mode, reporting, rounds, starts, wording
from vasowave.inference.discrepancy import Discrepancy
from vasowave.inference.emulator import Emulator, fit_emulator
from vasowave.inference.mode import Climbed, climb
from vasowave.inference.posterior import Sampling, problem_of
from vasowave.inference.reweighting import Weights
from vasowave.inference.rounds import Component, Surrogate, Target, log_error, log_prior, simulated_at
from vasowave.inference.unknowns import Unknown
from vasowave.noise.spectrum import harmonics

RNG = np.random.default_rng(9)
SAMPLES = 7


def test_features_are_all_products_of_at_most_three():
    local = np.array([[2.0, 3.0], [-1.0, 0.5]])
    expected = [[1, x, y, x * x, x * y, y * y, x**3, x * x * y, x * y * y, y**3] for x, y in local]
    assert emulator.features(local) == pytest.approx(np.array(expected))
    assert emulator._degrees(2).tolist() == [0, 1, 1, 2, 2, 2, 3, 3, 3, 3]
    assert emulator._degrees(1).tolist() == [0, 1, 2, 3]


def test_nearness_falls_with_the_square_of_the_distance_in_lengths():
    found = emulator._near(np.array([[1.0, 2.0]]), np.array([[1.0, 2.0], [3.0, 2.0], [1.0, 5.0]]), np.array([2.0, 3.0]))
    assert found[0] == pytest.approx([1.0, np.exp(-0.5), np.exp(-0.5)])


@pytest.mark.parametrize("decay", [0.3, 0.1])
def test_a_regression_foretells_each_point_from_all_others(decay):
    local, target, lengths = RNG.normal(size=(8, 2)), RNG.normal(size=(8, 3)), np.array([2.0, 1.5])
    size = 30 * decay ** emulator._degrees(2)
    terms = emulator.features(local) * size
    covariance = terms @ terms.T + emulator._near(local, local, lengths) + 1e-4 * np.eye(8)
    weights, coefficients, error = emulator._regression(local, target, decay, lengths)
    assert covariance @ weights == pytest.approx(target, abs=1e-6)
    assert coefficients == pytest.approx(size[:, np.newaxis] * (terms.T @ weights))
    missed = []
    for row in range(8):
        rest = np.arange(8) != row
        foretold = covariance[row, rest] @ np.linalg.solve(covariance[np.ix_(rest, rest)], target[rest])
        missed.append(target[row] - foretold)
    assert error == pytest.approx(np.sqrt(np.mean(np.square(missed), axis=0)), rel=1e-4)


def test_an_emulator_goes_through_what_it_learned_in_its_own_coordinates(monkeypatch):
    points = RNG.normal(size=(14, 2)) * [1.0, 3.0] + [2.0, -1.0]
    outputs = np.column_stack([points[:, 0] ** 2, np.sin(points[:, 1])])
    asked = []

    def chosen(local, target, lengths):
        asked.append((local, target, lengths))
        return np.array([2.0, 1.7])

    monkeypatch.setattr(emulator, "_chosen", chosen)
    scale = np.array([2.0, 0.5])
    found = fit_emulator(points, outputs, points[:9], scale, lambda one: one)
    assert found.center == pytest.approx(points[:9].mean(axis=0))
    local = found.local(points[:9])
    assert np.cov(local.T) == pytest.approx(np.eye(2), abs=1e-6)
    assert asked[0][0] == pytest.approx(found.local(points))
    assert asked[0][1] == pytest.approx((outputs - outputs.mean(axis=0)) / scale)
    assert asked[0][2].tolist() == [2.5, 2.5]
    assert found(points) == pytest.approx(outputs, abs=0.2)
    by_hand = found.base + emulator.features(local) @ found.coefficients
    by_hand = by_hand + emulator._near(local, found.local_points, found.lengths) @ found.weights
    assert found.at(local) == pytest.approx(by_hand)
    fits = [emulator._regression(found.local_points, asked[0][1], decay, np.array([2.0, 1.7])) for decay in (0.3, 0.1)]
    best = min(fits, key=lambda one: (one[2] ** 2).sum())
    assert found.error == pytest.approx(best[2] * scale)
    assert found.reach == pytest.approx(max(np.hypot(*one) for one in found.local_points))
    here = points[3]
    slopes = [(found(here[np.newaxis] + h) - found(here[np.newaxis] - h))[0] / 2e-3 for h in 1e-3 * np.eye(2)]
    assert found.jacobian(here) == pytest.approx(np.array(slopes).T)
    fit_emulator(points, outputs, points, scale, lambda one: one, np.array([3.0, 4.0]))
    assert asked[1][2].tolist() == [3.0, 4.0]
    many = RNG.normal(size=(510, 1))
    fit_emulator(many, many, many, np.ones(1), lambda one: one)
    assert len(asked[2][0]) == 500
    assert asked[2][1][-1] == pytest.approx(many[-1] - many.mean())


def test_lengths_move_while_that_is_worth_it_and_stay_within_their_limits(monkeypatch):
    def error(best, tried):
        """Return an error that is least at some lengths, and a percent more a doubling away from them."""
        return np.sqrt(1 + 0.02 * np.abs(np.log2(tried / best)).sum())

    def settled(best, begin):
        seen = []

        def regression(local, target, decay, lengths):
            seen.append(lengths)
            assert decay == 0.1
            return None, None, np.array([error(best, lengths)])

        monkeypatch.setattr(emulator, "_regression", regression)
        return emulator._chosen(None, None, np.array(begin)), seen

    lengths, seen = settled(np.array([2.5 * 1.7**2, 2.5]), [2.5, 2.5])
    assert lengths == pytest.approx([2.5 * 1.7**2, 2.5])
    assert seen[1] == pytest.approx([1.5, 2.5])
    assert settled(np.array([0.01, 2.5]), [2.5, 2.5])[0] == pytest.approx([0.9, 2.5])  # 0.54 is too short
    assert settled(np.array([900.0, 2.5]), [2.5, 2.5])[0] == pytest.approx([2.5 * 1.7**4, 2.5])


def test_the_proposal_of_an_integral_is_students_distribution():
    root = np.linalg.cholesky(np.array([[2.0, 0.3], [0.3, 0.5]]))
    one = ensemble._StudentT(np.array([1.0, -2.0]), root)
    points = RNG.normal(size=(5, 2))
    exact = stats.multivariate_t(one.center, root @ root.T, df=5)
    assert one.log_density(points) == pytest.approx(exact.logpdf(points))
    drawn = one.draw(40_000, np.random.default_rng(1))
    assert np.median(drawn, axis=0) == pytest.approx(one.center, abs=0.03)
    assert np.cov(drawn.T) == pytest.approx(5 / 3 * root @ root.T, rel=0.15)
    ours, theirs = np.array([1.0, 3.0]), np.array([0.5, 2.0, 4.0])
    top = np.mean([0.5 / 2.5, 2 / 4, 4 / 6])
    assert ensemble._bridge(ours, theirs, 2.0) == pytest.approx(top / np.mean([1 / 3, 1 / 5]))


def test_the_integral_of_a_known_density_is_found_with_its_error():
    draws = RNG.normal(2.0, 3.0, (4000, 1))

    def log(points):
        return 1.5 - 0.5 * ((points[:, 0] - 2) / 3) ** 2

    value, error = ensemble.log_integral(log, draws, log(draws), np.random.default_rng(2))
    assert value == pytest.approx(1.5 + np.log(3 * np.sqrt(2 * np.pi)), abs=4 * error)
    assert 0.001 < error < 0.02


def test_walkers_are_kept_every_few_steps_and_moves_counted():
    calls = []

    def flat(points):
        calls.append(len(points))
        return np.zeros(len(points))

    found = ensemble.sample(flat, RNG.normal(size=(8, 2)), 9, np.random.default_rng(0), keep_every=3)
    assert found.points.shape == (3, 8, 2)
    assert found.log_density.shape == (3, 8)
    assert calls == [8, *[4] * 18]
    assert 0.9 < found.accepted <= 1.0
    walkers = 1.0 + np.arange(4.0)[:, np.newaxis]
    log = lambda x: np.where(x[:, 0] > 0, 0.0, -np.inf)  # noqa: E731
    wall = ensemble.sample(log, walkers, 300, np.random.default_rng(0), 1)
    assert wall.points.min() > 0
    assert wall.accepted < 1.0


class Quadratic:
    """A likelihood of independent normal residuals in place of a discrepancy."""

    passed = None

    def __init__(self, sd=1.0, count=3):
        self.sd, self.measured, self.vessels = sd, np.zeros((count, count)), np.zeros((count, 1))

    def log_likelihood(self, residuals):
        return -0.5 * (residuals**2).sum(axis=-1) / self.sd**2

    def variance(self, residuals):
        return np.full(residuals.shape[-1], self.sd**2)

    def narrowed(self, near):
        return self


def test_a_prior_is_normal_and_outputs_that_are_none_have_no_likelihood():
    points = RNG.normal(size=(3, 2))
    assert log_prior(points) == pytest.approx(stats.multivariate_normal(np.zeros(2)).logpdf(points))
    target = Target(None, np.array([1.0, 2.0]), Quadratic(2.0), None)
    outputs = np.array([[1.0, 0.0], [np.nan, 1.0], [2.0, 2.0]])
    assert target.log_likelihood(outputs) == pytest.approx([-0.5, -np.inf, -0.125])


def test_models_that_cannot_be_simulated_may_be_half():
    def target(bad):
        outputs = np.ones((4, 2))
        outputs[:bad, 0] = np.nan
        return Target(lambda points: outputs, None, None, None)

    assert len(simulated_at(target(2), np.zeros((4, 1)))) == 4
    with pytest.raises(NumericalError, match="most models near the mode cannot be simulated"):
        simulated_at(target(3), np.zeros((4, 1)))
    points, outputs = rounds._joined(
        np.zeros((1, 2)), np.zeros((1, 2)), np.ones((2, 2)), np.array([[np.nan, 1], [3, 4]])
    )
    assert (points.tolist(), outputs.tolist()) == ([[0, 0], [1, 1]], [[0, 0], [3, 4]])


def test_the_error_of_an_emulator_is_the_scatter_of_what_it_misses_weighted_by_what_is_drawn():
    target = Target(None, np.zeros(1), Quadratic(), None)
    outputs, points = np.array([[1.0], [2.0], [np.nan], [0.5]]), np.array([[0.1], [0.2], [0.3], [1.0]])
    foretold = np.array([-0.4, -2.5, 0.0, -0.2])
    good = [0, 1, 3]
    true = -0.5 * outputs[good, 0] ** 2
    height = true + log_prior(points[good])
    weight = np.exp(0.4 * (height - height.max()))
    missed = true - foretold[good]
    mean = (weight * missed).sum() / weight.sum()
    expected = np.sqrt((weight * (missed - mean) ** 2).sum() / weight.sum())
    assert log_error(target, foretold, points, outputs, 0.6) == pytest.approx(expected)


class Straight(Emulator):
    """An emulator that says what is linear, in coordinates of its own."""


def straight(reach=2.0):
    known = np.array([[0.0, 0.0], [reach, 0.0]])
    zeros = np.zeros((10, 2))
    zeros[1, 0] = zeros[2, 1] = 1.0
    return Straight(
        lambda one: one, np.zeros(2), np.eye(2), known, np.zeros(2), np.zeros((2, 2)), zeros, np.ones(2), np.zeros(2)
    )


def test_a_surrogate_ends_a_third_beyond_what_it_learned_and_is_flattened():
    one = Surrogate(straight(), np.zeros(2), Quadratic())
    points = np.array([[1.0, 1.0], [2.59, 0.0], [2.61, 0.0]])
    whole = -0.5 * (points**2).sum(axis=1) + log_prior(points)
    assert one.log_likelihood(points) == pytest.approx(-0.5 * (points**2).sum(axis=1))
    assert one.log_posterior(points) == pytest.approx([whole[0], whole[1], -np.inf])
    assert one.log_learned(points)[:2] == pytest.approx(0.6 * whole[:2])
    assert one.log_drawn(points)[:2] == pytest.approx(0.8 * whole[:2])


def climbed(middle=(0.0, 0.0), height=0.0, halves=(0,), output=(0.0, 0.0), root=None):
    middle = np.asarray(middle, float)
    root = np.eye(2) if root is None else root
    return Climbed(
        np.zeros((3, 2)), np.zeros((3, 2)), middle, np.asarray(output, float), root, height, frozenset(halves)
    )


def test_a_mode_holds_what_lies_on_its_normal_slope():
    one = climbed(root=np.diag([2.0, 1.0]), height=5.0)
    edge = 2 * 0.999 * np.sqrt(4)
    assert one.holds(np.array([edge, 0.0]), 5.0)
    assert not one.holds(np.array([edge * 1.01, 0.0]), 5.0)
    assert one.holds(np.array([2.0, 0.0]), 5 - 0.5 - 2.99)
    assert not one.holds(np.array([2.0, 0.0]), 5 - 0.5 - 3.01)
    noise = Quadratic()
    assert climbed((1.0, 2.0), output=(3.0, 0.0), root=np.diag([2.0, 3.0])).log_evidence(
        noise, np.zeros(2)
    ) == pytest.approx(-4.5 - 2.5 + np.log(6))


def test_a_component_covers_a_mode_within_its_walkers_that_it_foretells():
    walkers = np.array([[1.0, 0], [-1, 0], [0, 1], [0, -1]]) * np.sqrt(1.5)  # covariance of one
    one = Component(
        Surrogate(straight(5.0), np.zeros(2), Quadratic()),
        np.zeros((0, 2)),
        np.zeros((0, 2)),
        walkers,
        frozenset((0,)),
        1,
    )
    target = Target(None, np.zeros(2), Quadratic(), None)
    assert one.covers(climbed((1.99, 0.0), output=(1.99, 0.0)), target)
    assert not one.covers(climbed((2.01, 0.0), output=(2.01, 0.0)), target)
    far = np.sqrt(1.99**2 + 2 * 1.99)
    assert one.covers(climbed((1.99, 0.0), output=(far, 0.0)), target)
    assert not one.covers(climbed((1.99, 0.0), output=(np.sqrt(1.99**2 + 4.02), 0.0)), target)
    assert one.found_by(frozenset((1,))).halves == {0, 1}


def test_hopeless_modes_are_not_explored_and_no_more_than_three(monkeypatch):
    learned = []

    def learn(target, one, rng):
        learned.append(float(one.middle[0]))
        if one.height < 0:
            raise NumericalError("no")
        return SimpleNamespace(
            covers=lambda mode, target: mode.middle[0] == one.middle[0], found_by=lambda halves: "joined"
        )

    monkeypatch.setattr(mixture, "learn", learn)
    target = SimpleNamespace(noise=Quadratic(), measured=np.zeros(2))

    def components(*middles, height=0.0):
        learned.clear()
        return mixture._components(target, [climbed((one, 0.0), height) for one in middles], None)

    limit = np.sqrt(2 * 7.0)
    components(0.0, limit * 0.999, limit * 1.001)
    assert learned == [0.0, pytest.approx(limit * 0.999)]
    assert components(0.0, 0.0) == ["joined"]
    components(0.0, 0.1, 0.2, 0.3)
    assert learned == [0.0, 0.1, 0.2]
    with pytest.raises(NumericalError, match=r"^no$"):
        components(0.0, height=-1.0)
    likely = {"a": 10.0, "b": 3.0, "c": 2.999}
    clouds = {name: SimpleNamespace(log_evidence=log) for name, log in likely.items()}
    monkeypatch.setattr(mixture, "_cloud", lambda one, rng: clouds[one])
    assert mixture._likely(["a", "b", "c"], None) == (["a", "b"], [clouds["a"], clouds["b"]])


def test_draws_are_shared_among_components_by_their_evidence(monkeypatch):
    monkeypatch.setattr(mixture, "simulated_at", lambda target, points: points)
    target = SimpleNamespace(log_likelihood=lambda outputs: np.full(len(outputs), -1.0))
    halves = tuple(RNG.normal(size=(300, 2)) for _ in range(2))
    clouds = [mixture._Cloud(halves, 1.0, 0.5, 0.0, log) for log in (0.0, np.log(0.25), -50.0)]
    component = SimpleNamespace(surrogate=SimpleNamespace(log_drawn=lambda points: np.full(len(points), 2.0)))
    found = mixture._drawn(target, [component] * 3, clouds, 400, np.random.default_rng(0))
    shares = np.array([0.8, 0.2, 0.1]) / 1.1
    counts = np.round(400 * shares / 2).astype(int)
    assert [int(((found.component == i) & (found.half == half)).sum()) for i in range(3) for half in (0, 1)] == [
        counts[0], counts[0], counts[1], counts[1], counts[2], counts[2]
    ]  # fmt: skip
    assert found.log_true == pytest.approx(-1.0 + log_prior(found.points))
    assert found.log_density[:, 0] == pytest.approx(1.5 + np.log(counts / counts.sum()))
    rows = np.arange(3)
    assert found.log_ratio([0, 2], rows) == pytest.approx(
        found.log_true[:3] - logsumexp(found.log_density[[0, 2]][:, :3], axis=0)
    )


def test_what_is_taught_anew_is_what_was_drawn_of_a_component(monkeypatch):
    seen = []
    monkeypatch.setattr(
        mixture, "taught", lambda target, component, points, outputs: seen.append((points.tolist(), outputs.tolist()))
    )
    drawn = mixture._Drawn(
        np.arange(4.0)[:, np.newaxis], np.arange(10.0, 14)[:, np.newaxis], np.array([0, 1, 0, 1]), None, None, None
    )
    mixture._retaught(None, None, drawn, 1)
    assert seen == [([[1], [3]], [[11], [13]])]


def test_halves_are_as_far_apart_as_their_means_in_standard_deviations():
    points = np.array([[0.0], [2.0], [4.0], [6.0]])
    drawn = mixture._Drawn(
        points, points, np.array([0, 0, 1, 1]), np.array([0, 1, 0, 1]), np.zeros(4), np.zeros((2, 4))
    )
    weight = np.full(4, 0.25)
    both = [SimpleNamespace(halves={0, 1})] * 2
    sd = np.sqrt(5.0)
    assert mixture._apart(both, [], drawn, weight) == pytest.approx(2 / sd)  # means 2 and 4 of halves, 3 of all
    first = [SimpleNamespace(halves={0}), SimpleNamespace(halves={1})]
    assert mixture._apart(first, [], drawn, weight) == pytest.approx(6 / sd)  # the first half drew 0, the second 6
    alone = [SimpleNamespace(halves={0}), SimpleNamespace(halves={0})]
    other = [SimpleNamespace(halves={1}, middle=np.array([9.0]))]
    assert mixture._apart(alone, other, drawn, weight) == pytest.approx((9 - 2) / sd)
    assert mixture._apart(alone, [], drawn, weight) == np.inf


def test_a_step_uphill_is_halved_until_it_rises():
    asked = []

    def simulate(points):
        asked.append(points[0, 0])
        return points if points[0, 0] < 3 else np.full_like(points, np.nan)

    noise, here = Quadratic(), np.array([1.0, 0.0])
    height = mode._height(noise, np.zeros(2), here, here)
    assert height == -1.0
    better = mode._better(simulate, np.zeros(2), noise, here, height, np.array([-1.5, 0.0]))
    assert asked == [-1.5, -0.25]
    assert (better[0].tolist(), better[2]) == ([-0.25, 0.0], pytest.approx(-0.0625))
    asked.clear()
    assert mode._better(simulate, np.zeros(2), noise, here, height, np.array([5.0, 0.0])) is None
    assert asked == pytest.approx([5.0, 3.0, 1.8, 1.2])


def test_a_climb_of_a_linear_problem_ends_at_its_posterior():
    J = np.array([[2.0, 0.5], [0.0, 1.0], [1.0, -1.0]])
    measured = np.array([3.0, 1.0, 0.5])
    calls = []

    def simulate(points):
        calls.append(len(points))
        return points @ J.T

    found = climb(simulate, measured, Quadratic(), np.array([1.0, 1.0]))
    covariance = np.linalg.inv(J.T @ J + np.eye(2))
    assert found.middle == pytest.approx(covariance @ J.T @ measured, abs=1e-6)
    assert found.root @ found.root.T == pytest.approx(covariance, rel=1e-6)
    assert len(found.points) == len(found.outputs)
    with pytest.raises(NumericalError, match="the start cannot be simulated"):
        climb(lambda points: np.full((len(points), 3), np.nan), measured, Quadratic(), np.zeros(2))


def test_modes_that_hold_each_other_are_one_and_the_higher_stays():
    low, high, away = climbed((0.5, 0.0), 1.0, (0,)), climbed((0.0, 0.0), 2.0, (1,)), climbed((9.0, 0.0), 0.0)
    (joined,) = starts._merged([low], high)
    assert (joined.height, joined.halves) == (2.0, {0, 1})
    (kept,) = starts._merged([high], low)
    assert (kept.height, kept.halves) == (2.0, {0, 1})
    assert starts._merged([low], away) == [low, away]
    found = starts._merged([away, low], replace(high, halves=frozenset((0,))))
    assert [one.height for one in found] == [0.0, 2.0]


def test_starts_of_halves_are_drawn_apart_and_the_best_and_the_farthest_good_one_are_climbed():
    first, second = starts.screened(lambda points: 2 * points, 3, 5)
    assert (first.points.shape, second.points.shape) == ((200, 3), (200, 3))
    assert np.array_equal(first.points, np.random.default_rng([5, 2]).standard_normal((200, 3)))
    assert np.array_equal(second.points, np.random.default_rng([5, 3]).standard_normal((200, 3)))
    assert np.array_equal(first.outputs, 2 * first.points)
    points = np.array([[0.9, 0.0], [1.1, 0.1], [-3.0, 0.0], *[[5.0 + n, 0] for n in range(9)], [np.nan, 0.0]])
    best, far = starts._chosen(
        lambda one: one, np.array([2.0, 0.0]), Quadratic(count=2), starts.Screened(points, points)
    )
    assert best == pytest.approx([1.0, 0.0], abs=1e-3)
    assert far.tolist() == [10.0, 0.0]  # the tenth best


def test_resampling_takes_each_draw_as_often_as_it_weighs():
    weights = np.log(np.array([0.5, 0.25, 0.25]) * np.array([1, 1, 1]))
    rows = reporting._resampled(np.append(weights, -np.inf), np.random.default_rng(3))
    assert np.bincount(rows, minlength=4).tolist() == [2, 1, 1, 0]
    many = reporting._resampled(np.log(np.arange(1.0, 101) / 5050), np.random.default_rng(3))
    counts = np.bincount(many, minlength=100)
    assert np.abs(counts - 100 * np.arange(1, 101) / 5050).max() < 1
    assert sorted(many.tolist()) != many.tolist()
    assert reporting._block_name(np.array([3, 3])) == "3"
    assert reporting._block_name(np.array([4, 6, 5])) == "4-6"


def test_a_summary_compares_draws_with_the_prior_on_logarithms_where_both_are_positive():
    draws, prior = np.exp(RNG.normal(1, 0.2, 999)), np.exp(RNG.normal(1, 0.5, 2000))
    values = {"a": draws, "b": draws - 2.0, "c": np.ones(9)}
    before = {"a": np.append(prior, np.nan), "b": prior - 2.0, "c": np.ones(4)}
    units = dict.fromkeys("abc", ("mmHg", "meaning"))
    found = reporting._summary(values, before, units)
    ordered = np.sort(draws)
    low, middle, high = (ordered[int(share * 1000) - 1] for share in (0.025, 0.5, 0.975))
    assert found.loc["a", ["interval_low", "median", "interval_high"]].tolist() == pytest.approx([low, middle, high])
    assert found.loc["a", ["prior_low", "prior_high"]].tolist() == pytest.approx(
        np.quantile(prior, [0.025, 0.975]).tolist()
    )
    assert found.loc["a", "contraction"] == pytest.approx(1 - np.var(np.log(draws)) / np.var(np.log(prior)))
    assert found.loc["b", "contraction"] == pytest.approx(1 - np.var(draws) / np.var(prior))
    assert np.isnan(found.loc["c", "contraction"])
    assert found.loc["a", "unit"] == "mmHg"


def test_shares_of_a_variance_are_those_of_its_sources():
    """Two unknowns, one of the image and one of the recording, three harmonics: dense algebra."""
    jacobian, slopes = (
        np.array([[1.0, 0.2], [0.0, 2.0], [0.5, 0.5]]),
        pd.DataFrame([[1.0, 0.0], [0.3, 2.0]], index=["x", "y"]),
    )
    of_model = np.array([0.1, 0.5, 0.2])
    vessels = np.array([[0.5], [0.1], [0.0]])
    noise = SimpleNamespace(measured=np.diag([0.3, 0.2, 0.4]), vessels=vessels, variance=lambda residuals: of_model)
    found = reporting.variance_shares(slopes, ["image", "recording"], jacobian, noise, None)
    parts = {"recording": noise.measured, "image": noise.vessels @ noise.vessels.T, "model": np.diag([0.1, 0.5, 0.2])}
    total = sum(parts.values())
    K = np.linalg.inv(np.eye(2) + jacobian.T @ np.linalg.solve(total, jacobian)) @ jacobian.T @ np.linalg.inv(total)
    left = np.eye(2) - K @ jacobian
    G = slopes.to_numpy()
    variances = {name: np.diag(G @ K @ part @ K.T @ G.T) for name, part in parts.items()}
    variances["image"] = variances["image"] + (G @ left[:, 0]) ** 2
    variances["prior"] = (G @ left[:, 1]) ** 2
    whole = sum(variances.values())
    for name, variance in variances.items():
        assert found[name].to_numpy() == pytest.approx(variance / whole), name
    assert found[["probe", "calibration"]].to_numpy() == pytest.approx(0.0)
    zero = np.array([0.4, 0.0, 0.0])
    more = reporting.variance_shares(slopes.assign(zero=0.5), ["image", "recording"], jacobian, noise, None, zero)
    assert (more["calibration"] > 0).all()
    assert more.sum(axis=1).to_numpy() == pytest.approx(1.0)


def test_findings_list_names_and_say_on_which_side_of_its_center_an_unknown_moved():
    assert wording._listed(["a"]) == "a"
    assert wording._listed(["a", "b", "c"]) == "a, b and c"
    assert (wording._side(0.1), wording._side(-0.1)) == ("above", "below")
    row = {
        "contraction": [0.05, -0.2, 0.05, 0.5],
        "interval_low": 1.0,
        "interval_high": [1.5, 1.5, 1.5, 9.0],
        "prior_low": 0.1,
    }
    summary = pd.DataFrame(row | dict.fromkeys(wording.MOSTLY, 0.0), index=["k", "m", "n", "R"])
    unknowns = dict.fromkeys(["k", "m", "n", "R"], SimpleNamespace(meaning="exponent"))
    scores = pd.Series({"k": -0.6, "m": 0.1, "n": 0.0, "R": -2.5})
    said = [str(one) for one in wording.meanings(summary, scores, unknowns)]
    assert said[0].find("n") >= 0
    assert (
        "the middle of k lies 0.6 SD of the prior below its center and the interval of m is wider than that" in said[1]
    )
    assert "9" in said[2]
    assert "2.5" in said[3]
    assert "below" in said[3]
    assert len(said) == 4


def test_an_unknown_has_the_value_of_its_score():
    positive = Unknown("mmHg", "x", 2.0, 0.5, True, "image")
    assert positive.value(np.array([-2.0, 0.0, 1.0])) == pytest.approx([2 / np.e, 2.0, 2 * np.exp(0.5)])
    assert replace_positive(positive).value(np.array([-2.0, 1.0])) == pytest.approx([1.0, 2.5])


def replace_positive(one):
    return one._replace(positive=False)


@pytest.fixture(scope="module")
def entering():
    how = Sampling(search=vw.Search(enters="both"))
    return problem_of(vw.control_network(), vw.virtual_mouse(), "linear", how)


def test_the_error_that_a_flow_passes_on_counts_by_its_harmonics_in_cosines_and_sines(entering):
    passed = entering.compared.passed_on
    k = harmonics(entering.samples)
    noise = entering.discrepancy()
    variance, power = noise.passed.variance, noise.passed.power
    n = entering.samples
    assert variance[0] == pytest.approx(n * passed.of_harmonic[0] ** 2)
    assert power[0] == pytest.approx(2 * n * passed.modulus[0] ** 2)
    assert variance[1:] == pytest.approx(0.5 * n * passed.of_harmonic[k[1:]] ** 2)
    assert power[1:] == pytest.approx(0.5 * n * passed.modulus[k[1:]] ** 2)
    residual = np.full(n, 0.1)
    near = noise.near(residual)
    assert near.passed.total == pytest.approx(noise.variance(residual[np.newaxis]) + noise._known)
    plain = replace(noise, passed=None)
    assert plain.near(residual) is plain
    assert noise._known == pytest.approx(np.diag(noise.measured) + (noise.vessels**2).sum(axis=1))


def test_a_discrepancy_is_widened_in_squares_and_narrowed_to_what_matters():
    noise = Discrepancy(SAMPLES, (0.3, 0.7), 0.05 * np.eye(SAMPLES), np.zeros((SAMPLES, 1)))
    wide = noise.widened(0.4)
    assert wide.amplitude == (pytest.approx(0.5), 0.7)
    assert wide.log_likelihood(np.full((1, SAMPLES), 0.2)) == pytest.approx(
        replace(noise, amplitude=(0.5, 0.7)).log_likelihood(np.full((1, SAMPLES), 0.2))
    )
    residuals = np.full((3, SAMPLES), 0.5)
    small = noise.narrowed(residuals)
    assert small.log_likelihood(residuals) == pytest.approx(noise.log_likelihood(residuals), abs=0.2)
    log = noise._by_node(residuals)
    share = np.exp(log - log.max(axis=(0, 2), keepdims=True)).max(axis=1)
    assert small.selected[0].tolist() == (share.max(axis=1) > 0.01).tolist()
    assert small.selected[1].tolist() == (share.max(axis=0) > 0.01).tolist()
    assert 0 < small.selected[1].sum() < len(small.selected[1])
    assert isinstance(Weights(np.zeros(1), 0.0, 1.0).trusted, bool)
