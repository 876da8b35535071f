"""What is said of a posterior, on the edge of each rule."""

import numpy as np
import pandas as pd
import pytest

from made_posterior import made_posterior
from vasowave.inference import findings, wording
from vasowave.inference.laws import _said
from vasowave.inference.result import Diagnostics
from vasowave.inference.reweighting import EQUAL, FEWEST_TAIL, UNTRUSTED, _pareto, _quantile, smoothed, trusted

RNG = np.random.default_rng(7)
SOURCES = ("recording", "calibration", "probe", "image", "model", "prior")


def told(apart=0.0, effective=1e9, shares=(1.0,), optimum=None, best=0.0):
    draws = {name: np.exp(np.tile([-1.0, 1.0], 50)) for name in findings._COMPARED}
    return [one.code for one in findings.findings(apart, effective, np.array(shares), optimum, best, draws)]


def optimum(log, distance=0.0):
    return findings.Optimum(log, {name: float(np.exp(distance)) for name in findings._COMPARED})


def test_halves_and_modes_are_told_beyond_their_limits():
    assert told(findings.HALVES) == []
    assert told(findings.HALVES * 1.001) == ["posterior.halves-differ"]
    assert told(np.inf) == ["posterior.half-empty"]
    few = findings._CHANCE * 2.0 / np.sqrt(4.0)
    assert findings.halves_limit(4.0) == max(findings.HALVES, few)
    assert findings.halves_limit(0.5) == max(findings.HALVES, 2 * findings._CHANCE)
    second = findings._SECOND
    assert told(shares=(1 - 0.99 * second, 0.99 * second)) == []
    assert told(shares=(1 - 1.01 * second, 1.01 * second)) == ["posterior.several-modes"]


def test_a_fit_far_away_or_likelier_is_told_with_its_side():
    assert told(optimum=optimum(0.0)) == []
    assert told(optimum=optimum(0.0, findings._FAR)) == []
    assert told(optimum=optimum(-1.0, 1.001 * findings._FAR)) == ["posterior.fit-elsewhere"]
    assert told(optimum=optimum(0.0, 1.001 * findings._FAR)) == ["posterior.fit-elsewhere"]
    assert told(optimum=optimum(findings._BETTER)) == []
    assert told(optimum=optimum(findings._BETTER + 0.01)) == ["posterior.fit-likelier"]


def meanings(contraction=0.5, score=0.0, low=1.0, high=2.0, prior_low=0.1, **shares):
    row = {"contraction": contraction, "interval_low": low, "interval_high": high, "prior_low": prior_low}
    summary = pd.DataFrame([row | dict.fromkeys(SOURCES, 0.0) | shares], index=["k"])

    class Known:
        meaning = "exponent"

    return [one.code for one in wording.meanings(summary, pd.Series({"k": score}), {"k": Known()})]


def test_unknowns_that_the_data_do_not_narrow_move_or_contradict_are_told_from_their_limits_on():
    assert meanings() == []
    assert meanings(0.1) == []
    silent, moved = meanings(0.099), meanings(0.099, 0.501)
    assert len(silent) == len(moved) == 1
    assert silent != moved
    assert meanings(0.099, 0.5) == silent
    assert meanings(-0.1) == silent
    assert meanings(-0.101) == moved
    assert meanings(score=2.0) == []
    assert len(meanings(score=2.001)) == 1
    assert meanings(high=4.0) == []
    assert len(meanings(high=4.001)) == 1
    assert meanings(high=4.001, prior_low=0.0) == []
    assert meanings(image=0.5) == []
    assert meanings(image=0.501) == ["posterior.mostly-image"]
    assert meanings(0.1, image=0.501) == ["posterior.mostly-image"]
    assert "posterior.mostly-image" not in meanings(0.099, image=0.501)


def test_draws_are_doubted_for_their_tail_and_their_number():
    one = Diagnostics(0.7, 100.0, 0.0, 0.1, 0.0, 0.1, 1, 1, 16, 400, 0.5)
    assert list(wording.trust(one)) == []
    assert len(list(wording.trust(one._replace(effective=99.9)))) == 1
    assert len(list(wording.trust(one._replace(k_hat=0.701)))) == 1
    assert trusted(UNTRUSTED, 0.0)
    assert not trusted(UNTRUSTED + 1e-9, EQUAL)
    assert trusted(9.0, EQUAL + 1e-9)
    assert one.agree
    assert not one._replace(halves_apart=findings.halves_limit(100.0) * 1.001).trusted


def test_the_tail_of_weights_has_the_shape_of_the_distribution_that_it_is_of():
    """Ratios of a Pareto distribution of index 2 have a tail of shape 1/2, those of a bounded one a negative shape."""
    heavy = smoothed(np.log(RNG.pareto(2.0, 20_000) + 1))
    assert heavy.k_hat == pytest.approx(0.5, abs=0.12)
    light = smoothed(np.log(RNG.uniform(0.5, 1.5, 20_000)))
    assert light.k_hat < 0.0
    for one in (heavy, light):
        weights = np.exp(one.log_weight)
        assert weights.sum() == pytest.approx(1.0)
        assert one.effective == pytest.approx(1 / (weights**2).sum())
    even = smoothed(np.zeros(100))
    assert even.k_hat == -np.inf
    assert even.effective == pytest.approx(100.0)
    assert even.trusted


def test_a_tail_needs_five_weights():
    log = RNG.normal(0, 1, 21)
    assert np.isfinite(smoothed(log).k_hat)  # a fifth of 21, rounded up, are five
    assert smoothed(log[:20]).k_hat == np.inf
    some = np.append(np.full(40, -np.inf), log[: FEWEST_TAIL + 1])
    assert np.isfinite(smoothed(some).k_hat)
    assert smoothed(some[:-1]).k_hat == np.inf


def test_quantiles_of_the_pareto_distribution_are_those_of_scipy():
    from scipy.stats import genpareto

    share = np.linspace(0.05, 0.95, 7)
    for k in (-0.3, 0.0, 1e-9, 0.4):
        assert _quantile(share, k, 2.0) == pytest.approx(genpareto.ppf(share, k, scale=2.0), rel=1e-6)
    sample = np.sort(genpareto.rvs(0.3, scale=2.0, size=4000, random_state=1))
    k, scale = _pareto(sample)
    assert (k, scale) == (pytest.approx(0.3, abs=0.06), pytest.approx(2.0, rel=0.06))
    assert _pareto(np.zeros(5)) == (-np.inf, 0.0)
    assert _pareto(np.array([-1.0, 1.0, 2.0]))[0] == -np.inf


@pytest.mark.parametrize(
    ("ratio", "amount", "clear"),
    [(999, "1e+03 times", True), (1001, "over 1000 times", True), (1.6, "1.6 times", False)],
)
def test_how_much_likelier_a_law_is(ratio, amount, clear):
    apart = np.log(ratio)
    pair = [made_posterior("linear", 0.0, 50.0, foretold=(0.0, 1.0, 0.0, 3.0)), made_posterior("power", -apart, 50.0)]
    said = _said(pair, np.array([1.0, 0.1]))
    assert f"is {amount} as likely under the linear law as under the power law" in said
    assert (": clearly likelier" in said) == clear
    assert ("above all harmonic 3-4" in said) == clear
    doubtful = made_posterior("power", -apart, 50.0, k_hat=2.0)
    assert "cannot be trusted" in _said([pair[0], doubtful], np.array([1.0, 0.1]))
