"""A flow that a scanner gated lies beside the pressure to a part of a phase, and intervals say so."""

from dataclasses import replace

import vasowave as vw


def test_the_place_of_a_gated_flow_is_an_error_that_intervals_allow_for():
    plain = vw.virtual_mouse()
    gated = replace(plain, flow_delay_sd=0.02 * plain.period)
    settings = vw.Settings(walls=("linear",), starts=1, model_selection=False)
    network = vw.Network(("1", "2", "3"), [-1, 0, 0], [0.41, 0.45, 0.37], [0.047, 0.026, 0.037])
    results = [vw.analyze(vw.Animal("a", "g", network, cycle), settings) for cycle in (plain, gated)]
    errors = [{error.name: error.sd for error in result.assumed_errors} for result in results]
    assert errors[1] == errors[0] | {"flow_delay": gated.flow_delay_sd}
    spreads = [result.laws["linear"].quantities["beta"].attrs["standard_error"] for result in results]
    assert spreads[1] > 1.01 * spreads[0]


def test_what_the_lab_says_of_a_delay_counts_where_it_is_more():
    cycle = replace(vw.virtual_mouse(), flow_delay_sd=2e-3)
    assert vw.KnownErrors(flow_delay_sd=1e-3).allowing_for(cycle).flow_delay_sd == 2e-3
    assert vw.KnownErrors(flow_delay_sd=5e-3).allowing_for(cycle).flow_delay_sd == 5e-3
    exact = vw.KnownErrors()
    assert exact.allowing_for(vw.virtual_mouse()) is exact
