"""What is made of draws at the end of sampling: evidence, shares, effective draws, waves, by arithmetic on few "
"draws."""

from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest
from scipy.special import logsumexp

import vasowave as vw
from vasowave.calibration.parameters import parameter_space
from vasowave.inference import ensemble, mixture, reporting, rounds, wording
from vasowave.inference.priors import Priors
from vasowave.inference.unknowns import Unknowns
from vasowave.model.blood import Blood
from vasowave.model.nominal import estimate_nominal

RNG = np.random.default_rng(12)


def test_a_cloud_is_what_walkers_did_after_a_quarter_of_their_steps(monkeypatch):
    steps = [RNG.normal(size=(8, 3, 2)), RNG.normal(size=(8, 3, 2))]
    logs = [RNG.normal(size=(8, 3)), RNG.normal(size=(8, 3))]
    asked = []

    def moved(log, walkers, count, rng):
        asked.append((walkers[:, 0].tolist(), count))
        return SimpleNamespace(points=steps[len(asked) - 1], log_density=logs[len(asked) - 1])

    seen = []

    def log_integral(log, draws, values, rng):
        seen.append((draws, values))
        return 1.5, 0.2

    monkeypatch.setattr(mixture, "moved", moved)
    monkeypatch.setattr(mixture, "log_integral", log_integral)
    walkers = np.arange(12.0).reshape(6, 2)
    component = SimpleNamespace(surrogate=SimpleNamespace(log_drawn="log"), walkers=walkers)
    found = mixture._cloud(component, None)
    assert asked == [([0, 4, 8], 400), ([2, 6, 10], 400)]
    late = [one[2:].reshape(-1, 2) for one in steps]
    values = np.concatenate([one[2:].ravel() for one in logs])
    assert np.array_equal(found.halves[0], late[0])
    assert np.array_equal(found.halves[1], late[1])
    assert np.array_equal(seen[0][0], np.concatenate(late))
    assert np.array_equal(seen[0][1], values)
    assert (found.log_integral, found.error) == (1.5, 0.2)
    assert found.log_evidence == pytest.approx(1.5 + np.log(np.mean(np.exp(0.25 * values))))
    independent = 0.0
    for one in steps:
        scatter = one[2:].mean(axis=0).var(axis=0, ddof=1) / one[2:].reshape(-1, 2).var(axis=0)
        independent += 3 / scatter.mean()
    assert found.independent == pytest.approx(independent)


def test_what_was_explored_is_summed_over_components_by_their_probability():
    points = RNG.normal(size=(6, 2))
    outputs = RNG.normal(size=(6, 3))
    component, half = np.array([0, 0, 1, 1, 1, 0]), np.array([0, 1, 0, 1, 0, 1])
    density = RNG.normal(size=(2, 6))
    true = RNG.normal(size=6)
    drawn = mixture._Drawn(points, outputs, component, half, true, density)

    def surrogate(number):
        emulated = lambda points: np.tile(points[:, :1], 3) * (number + 1)  # noqa: E731
        return SimpleNamespace(log_likelihood=lambda points: points[:, 0] + number, emulator=emulated)

    components = [SimpleNamespace(surrogate=surrogate(n), halves={0, 1}, rounds=n + 3) for n in (0, 1)]
    clouds = [SimpleNamespace(error=0.3, independent=20.0), SimpleNamespace(error=0.1, independent=50.0)]
    weight = np.array([0.05, 0.1, 0.3, 0.2, 0.25, 0.1])
    weights = SimpleNamespace(log_weight=np.log(weight), effective=4.5)
    noise = SimpleNamespace(log_likelihood=lambda residuals: -0.5 * (residuals**2).sum(axis=1))
    target = rounds.Target(None, np.array([1.0, 2.0, 3.0]), noise, None)
    found = mixture._explored(target, components, clouds, [], drawn, weights)
    assert found.residuals == pytest.approx(target.measured - outputs)
    scale = np.where(component == 0, 1, 2)[:, np.newaxis]
    assert found.missed == pytest.approx(outputs - points[:, :1] * scale)
    shares = np.array([0.25, 0.75])
    assert found.effective == pytest.approx(1 / (1 / 4.5 + shares[0] ** 2 / 20 + shares[1] ** 2 / 50))
    ratio = true - logsumexp(density, axis=0)
    assert found.log_evidence == pytest.approx(np.log(np.mean(np.exp(ratio))))
    spread = np.std(np.exp(ratio - found.log_evidence)) / np.sqrt(6)
    assert found.log_evidence_error == pytest.approx(np.hypot(np.hypot(0.25 * 0.3, 0.75 * 0.1), spread))
    assert found.emulator is components[1].surrogate.emulator
    assert found.rounds == 7
    assert found.best_log_likelihood == pytest.approx(np.max(true - rounds.log_prior(points)))
    foretold = points[:, 0] + component
    assert found.log_error == pytest.approx(rounds.log_error(target, foretold, points, outputs, 0.8))


def test_the_proposal_of_an_integral_has_the_mean_and_the_covariance_of_every_second_draw(monkeypatch):
    draws, seen = RNG.normal(size=(40, 2)) @ np.array([[1, 0.5], [0, 2]]), []

    class Seen(ensemble._StudentT):
        def draw(self, count, rng):
            seen.append((self.center, self.root, count))
            return super().draw(count, rng)

    monkeypatch.setattr(ensemble, "_StudentT", Seen)
    ensemble.log_integral(lambda one: -0.5 * (one**2).sum(axis=1), draws, -0.5 * (draws**2).sum(axis=1), RNG)
    center, root, count = seen[0]
    assert center == pytest.approx(draws[::2].mean(axis=0))
    assert root @ root.T == pytest.approx(np.cov(draws[::2].T) * 3 / 5)
    assert count == 20


def test_waves_of_a_flow_that_is_compared_are_told_in_ml_per_s():
    measured = np.array([3.0, 1.0, 2.0])
    problem = SimpleNamespace(
        samples=3, recording=SimpleNamespace(period=0.3), measured=measured, in_time=lambda one: one * 10,
        compared=SimpleNamespace(scale=4.0, what="flow", unit="ml/s"),
    )  # fmt: skip
    explored = SimpleNamespace(
        residuals=np.arange(6.0).reshape(2, 3), weights=SimpleNamespace(log_weight=np.log([0.25, 0.75]))
    )
    noise = SimpleNamespace(log_likelihood=lambda residuals: residuals.sum(axis=1))
    behind = SimpleNamespace(noise=np.full((2, 3), 0.5))
    rows = np.array([1, 0])
    values = {"R_T": np.array([1.0, 2.0])}
    tree = reporting._tree(problem, noise, explored, rows, behind, values, values, {"R_T": ("mmHg s/ml", "resistance")})
    simulated = (measured - explored.residuals[rows]) * 2.5
    predicted = tree["posterior_predictive"]
    assert predicted["simulated"].values[0] == pytest.approx(simulated)
    assert predicted["flow"].values[0] == pytest.approx(simulated + 1.25)
    assert tree["observed_data"]["flow"].values == pytest.approx(measured * 2.5)
    assert predicted["time"].values == pytest.approx([0.0, 0.1, 0.2])
    assert tree["log_likelihood"]["flow"].values.tolist() == [[12.0, 3.0]]
    assert np.exp(tree["sample_stats"]["log_weight"].values) == pytest.approx(np.array([[0.25, 0.75]]))
    assert tree["posterior"]["R_T"].attrs == {"units": "mmHg s/ml", "long_name": "resistance"}
    assert tree["posterior"]["draw"].values.tolist() == [0, 1]


@pytest.fixture(scope="module")
def unknowns():
    network, mouse = vw.control_network(), vw.virtual_mouse()
    nominal = estimate_nominal(network, mouse)
    space = parameter_space("linear", network, nominal, Blood(), {}, {}, False, True)
    return Unknowns(space, nominal, Priors(k_sd=0.5, wedge=2.0), mouse)


def test_smaller_vessels_are_stiffer_and_more_viscous_by_the_exponent_that_is_unknown(unknowns):
    names = list(unknowns.all)
    point = np.zeros(len(names))
    plain = unknowns.model(point)
    point[names.index("k")] = 0.8
    point[names.index("wedge")] = 1.5
    model = unknowns.model(point)
    ratio = (model.network.radius / model.network.radius[model.network.root]) ** -0.4
    assert model.wall.beta == pytest.approx(plain.wall.beta * ratio)
    assert model.wall_viscosity == pytest.approx(plain.wall_viscosity * ratio)
    assert np.ptp(ratio) > 0.1
    assert model.outlet_pressure == pytest.approx(unknowns.space.outlet_pressure + 3.0)
    wider = unknowns.posed(point, radii=np.full(len(model.network), 0.1), lengths=np.full(len(model.network), -0.2))[0]
    assert wider.network.radius == pytest.approx(model.network.radius * np.exp(0.1))
    assert wider.network.length == pytest.approx(model.network.length * np.exp(-0.2))
    only = unknowns.posed(point, radii=np.full(len(model.network), 0.1))[0]
    assert only.network.length == pytest.approx(model.network.length)


def test_an_interval_a_tenth_wider_than_the_priors_is_not_yet_wider():
    def said(contraction):
        row = {"contraction": contraction, "interval_low": 1.0, "interval_high": 1.5, "prior_low": 0.1}
        summary = pd.DataFrame([row | dict.fromkeys(wording.MOSTLY, 0.0)], index=["k"])
        found = wording.meanings(summary, pd.Series({"k": 0.9}), {"k": SimpleNamespace(meaning="exponent")})
        return next(str(one) for one in found)

    assert "the interval of k is wider" in said(-0.10001)
    assert "the middle of k lies 0.9 SD of the prior above its center" in said(-0.1)
