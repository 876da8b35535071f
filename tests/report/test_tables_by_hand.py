"""Tables and remarks of results that are made by hand: differences of laws, fits of flows, doubtful p, sites."""

from dataclasses import replace

import numpy as np
import pytest
import xarray as xr

from made_cohort import bare_law, bare_result, voting
from vasowave.cohort import gathered
from vasowave.cohort.primary import Assurance
from vasowave.cohort.votes import _price
from vasowave.report.sections.animals import _quality
from vasowave.report.sections.groups import _remarks
from vasowave.report.tables.models import misfit_table, preference_table
from vasowave.report.wording import number, with_interval


def test_laws_are_compared_over_all_animals_by_noise_model_with_what_parameters_cost(cohort_results):
    """Of each animal AICc of the tangent law less that of the linear one: 12, 14 and 16; its price is of one more."""
    open_ = {"linear": 0.0, "tangent": 1.0}
    results = [
        voting(one, {"ARMA": ({"linear": 0.0, "tangent": 12.0 + 2 * place}, 0), "se": (open_, 0)}, "ARMA")
        for place, one in enumerate(cohort_results[:3])
    ]
    table = preference_table(gathered(results), "linear")
    assert table.header[:3] == ("wall", "noise model", "animals")
    assert [row[:3] for row in table.rows] == [
        ("tangent", "likeliest of each animal", "3"), ("tangent", "ARMA", "3"), ("tangent", "se", "3")]  # fmt: skip
    reach = 4.302653 * 2 / np.sqrt(3)
    price = _price(5, 512) - _price(4, 512)
    own = 14 - price
    assert table.rows[0][3] == with_interval(14.0, 14 - reach, 14 + reach)
    assert table.rows[0][4] == number(price, 2)
    assert table.rows[0][5] == with_interval(own, own - reach, own + reach)
    assert table.rows[0][6:] == ("2.0", "linear")
    assert table.rows[2][7] == "open"


def test_misfits_have_shares_of_the_pulse_and_a_word_where_they_miss(cohort_results):
    table = misfit_table(gathered(cohort_results))
    first = cohort_results[0]
    pulse = float(first.measured.quantities["pPAP"])
    for row in table.rows[:2]:
        law = first.laws[row[2]]
        assert row[:2] == ("CTL 1", "CTL")
        assert float(row[3]) == pytest.approx(law.rmse, rel=0.05)
        assert row[5] == f"{100 * law.rmse / pulse:.1f} %"


def test_a_fit_of_the_flow_tells_what_is_left_of_the_flow():
    residual = ("time", np.array([0.03, -0.04]), {"units": "ml/s"})
    fit = xr.Dataset({"RMSE": 0.5, "S": 2.0, "N": 2, "flow_residual": residual}, attrs={"enters": "pressure"})
    one = bare_result(laws={"linear": bare_law("linear")})
    one = replace(one, measured=replace(one.measured, quantities=xr.Dataset({"pPAP": 10.0})))
    assert _quality(one, fit) == (
        "Fit: the flow differs from the measured one by 0.0354 ml/s (root mean square), 5.0 % of its pulse; "
        "S = 2.00 mmHg² over 2 samples."
    )
    assert _quality(one, fit.assign_attrs(enters="flow")).startswith(
        "Fit: the pressure differs from the measured one by 0.500 mmHg (root mean square), 5.0 % of the pulse pressure;"
    )


def test_p_that_come_too_often_are_remarked_with_their_rate():
    class Told:
        assurance = Assurance(0.083, 0.99, 3.2, 3)

    (block,) = _remarks(Told())
    assert "a factor of 3.2, and the smallest has 3 animals" in str(block)
    assert "in 8 % of cases instead of 5 %" in str(block)
    Told.assurance = Assurance(0.06, 0.99, 3.2, 3)
    assert _remarks(Told()) == []
    Told.assurance = None
    assert _remarks(Told()) == []
