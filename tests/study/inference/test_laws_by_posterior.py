"""Wall laws weighed by the evidence of their posteriors: weights, averages, sentences, and the table of a report."""

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.stats import norm

from made_cohort import bare_law, bare_result
from made_posterior import made_posterior
from vasowave.base import InputError
from vasowave.pulse.inference import compare_laws
from vasowave.study.animal import AnimalResult, from_bytes, posterior_result, to_bytes
from vasowave.study.report.sections import laws_by_posterior


def test_a_law_weighs_as_its_evidence():
    found = compare_laws([made_posterior("linear", -10.0, 200), made_posterior("power", -10.0 + np.log(3), 300)])
    assert found["weight"].sel(wall=["linear", "power"]).values == pytest.approx([0.25, 0.75])


def test_averages_are_quantiles_of_the_mixture_of_the_laws():
    laws = [made_posterior("linear", 0.0, 200), made_posterior("power", np.log(3), 300)]
    one = compare_laws(laws).sel(quantity="wave_speed")
    mostly = norm(np.log(300), 0.1)
    for name, share in (("interval_low", 0.025), ("median", 0.5), ("interval_high", 0.975)):
        exact = brentq(lambda x, p=share: 0.25 * norm.cdf(x, np.log(200), 0.1) + mostly.cdf(x) * 0.75 - p, 4, 7)
        assert np.log(float(one[name])) == pytest.approx(exact, abs=0.03)  # 1000 draws
    apart = 0.25 * 0.75 * np.log(1.5) ** 2
    assert float(one["between_laws"]) == pytest.approx(apart / (apart + 0.01), abs=0.03)


def test_what_is_said_names_the_likelier_law_and_where_it_foretells_better():
    better = made_posterior("power", 4.0, 300, foretold=(0.0, 0.5, 0.2, 3.0))
    said = compare_laws([made_posterior("linear", 0.0, 200), better]).attrs["said"]
    assert "55 times as likely under the power law as under the linear law: clearly" in said
    assert "harmonic 3-4" in said
    little = compare_laws([made_posterior("linear", 0.0, 200), made_posterior("power", 1.0, 300)]).attrs["said"]
    assert "2.7 times" in little
    assert "not clearly" in little


def test_a_posterior_that_cannot_be_trusted_decides_nothing():
    poor = made_posterior("power", 40.0, 300, k_hat=1.2)
    said = compare_laws([made_posterior("linear", 0.0, 200), poor]).attrs["said"]
    assert "cannot be trusted" in said
    assert "times" not in said


def test_posteriors_that_cannot_be_compared_are_refused():
    linear = made_posterior("linear", 0.0, 200)
    with pytest.raises(InputError, match="two or more"):
        compare_laws([linear])
    with pytest.raises(InputError, match="two or more"):
        compare_laws([linear, linear])
    with pytest.raises(InputError, match="different harmonics"):
        compare_laws([linear, made_posterior("power", 0.0, 300, harmonics=17)])


def test_evidence_and_what_is_left_out_stand_in_the_results_and_in_the_report():
    laws = [made_posterior("linear", -3.0, 200), made_posterior("power", 0.0, 300, foretold=(0.1, 0.2, 0.3, 1.4))]
    power = bare_law("power", posterior=posterior_result(laws[1]))
    result = bare_result(laws={"power": power}, evidence=compare_laws(laws))
    again = AnimalResult.from_datatree(from_bytes(to_bytes(result.to_datatree())))
    assert again.laws["power"].posterior.table["left_out"].sel(block="3-4") == pytest.approx(1.4)
    table = laws_by_posterior(again.evidence)
    assert table.header[:3] == ("wall law", "log evidence", "probability")
    assert list(table.rows[1])[:3] == ["power", "0.0 ± 0.1", "0.95"]
    assert table.rows[1][3] == "0.1?"  # Pareto k of 0.9
    assert table.rows[1][-1] == "1.4"
