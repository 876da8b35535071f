"""A quantity is declared in one place: it is computed, described and called from there."""

import numpy as np
import pytest

import vasowave as vw
from vasowave.base import Quantity
from vasowave.pulse import QUANTITIES, derived, described
from vasowave.pulse.model import LinearWall, Windkessel
from vasowave.study.animal import quantities_of


@pytest.fixture
def distensibility(monkeypatch):
    """Return the name of a quantity that is declared for a while: (1/A) dA/dp, which is 2/(β + p) of a linear wall."""

    def formula(point):
        p, root = point.mean, point.model.network.root
        area = point.model.area0[root] * point.wall.ratio_at(p, *point.wall)
        return point.model.area0[root] * point.wall.slope_at(p, *point.wall) / area

    quantity = Quantity("1/mmHg", "D", "distensibility of the root", "", "", formula, "wall", ("softer", "stiffer", ""))
    monkeypatch.setitem(QUANTITIES, "distensibility", quantity)
    return "distensibility"


def test_a_new_quantity_is_computed_and_described(distensibility):
    network, cycle = vw.control_network(), vw.virtual_mouse()
    model = vw.Model(network, LinearWall(60.0), vw.estimate_nominal(network, cycle).outlets)
    values = derived(model, 15.0, np.full(len(network), 8.0))
    assert values[distensibility] == pytest.approx(2 / (60 + 15))
    assert quantities_of(LinearWall, Windkessel)[distensibility].unit == "1/mmHg"
    assert described(distensibility).comparatives[0] == "softer"


def test_what_no_table_of_quantities_has_is_a_parameter_that_its_law_describes():
    assert described("gamma") == Quantity("", "", "")
    assert described("gamma").comparatives == ("higher", "lower", "")
