"""Terms of the scheme: how their methods compose, and what a ventricle's valve does, without compiling a cycle."""

from types import SimpleNamespace
from typing import NamedTuple

import numpy as np
import pytest
from numba import njit

from vasowave.pulse.solver import Heart, changes_of_all, of_all, of_one


class Adds(NamedTuple):
    """A term with one number."""

    amount: float

    def in_cells(self, step, n):
        step[n] += self.amount

    def solve(self, step, n):
        return self.amount > step[n]


class Doubles(NamedTuple):
    """A term without number."""

    times: float

    def in_cells(self, step, n):
        step[n] *= self.times


class AddsTangent(NamedTuple):
    """The tangent of a term."""

    base: Adds
    more: float

    def change_cells(self, step, tangent, n, d):
        tangent[d] += self.more * step[n]


def compiled(function, arguments):
    """Return what compiled code makes of a composed function, which Python cannot call."""

    def call(terms, step, n):
        return function(terms, step, n)

    def change(terms, step, tangent, n, d):
        function(terms, step, tangent, n, d)

    return njit(call if arguments == 3 else change)


@pytest.mark.parametrize(
    ("terms", "expected"),
    [
        ((Adds(2.0),), 3.0),
        ((Adds(2.0), Doubles(2.0)), 6.0),
        ((Doubles(2.0), Adds(2.0)), 4.0),
        ((AddsTangent(Adds(2.0), 5.0),), 3.0),
    ],
    ids=["one", "two", "in another order", "of the base of a tangent"],
)
def test_the_methods_of_terms_are_called_in_their_order_and_no_others(terms, expected):
    step = np.ones(1)
    for name in ("in_cells", "at_ends"):
        compiled(of_all(name, tuple(map(type, terms))), 3)(terms, step, 0)
    assert step[0] == expected


def test_the_change_of_a_tangent_is_added_in_its_direction():
    terms, changes = (AddsTangent(Adds(2.0), 5.0),), np.zeros(2)
    compiled(changes_of_all("change_cells", (AddsTangent,)), 5)(terms, np.full(1, 3.0), changes, 0, 1)
    assert changes.tolist() == [0.0, 15.0]


def test_a_term_may_replace_what_is_done_without_it():
    assert of_one("solve", (Doubles,)) is None
    assert compiled(of_one("solve", (Doubles, Adds)), 3)((Doubles(1.0), Adds(2.0)), np.ones(1), 0)


def test_a_valve_opens_above_the_pressure_of_its_node_and_closes_where_the_flow_turns():
    heart = Heart(0.04, 0.01, 1e-4, np.zeros(1), np.zeros(1))
    ends = SimpleNamespace(inlet=0, face=np.zeros(1, dtype=int))
    nodes = SimpleNamespace(
        source=np.ones(1), weight=np.ones(1), outlet=np.zeros(1), memory=np.zeros(1), pressure=np.full((4, 1), 5.0)
    )
    half = SimpleNamespace(nodes=nodes, faces=SimpleNamespace(flow=np.zeros(1)))
    step = SimpleNamespace(scheme=SimpleNamespace(ends=ends), half=half, inflow=np.array([[100.0], [200.0], [200.0]]))
    heart.begin(step, 0)
    heart.meet(step, 0)
    assert (nodes.weight[0], nodes.outlet[0], heart.moves(step, 0)) == (1.0, 0.0, False)  # 4 mmHg against 5
    assert heart.moves(step, 1)
    heart.meet(step, 1)
    assert (nodes.outlet[0], nodes.memory[0]) == (1.0, 200.0 * 0.04)
    half.faces.flow[0] = 0.5
    heart.after_nodes(step, 1)
    assert heart.volume[0] == 0.04 - 0.5e-4
    half.faces.flow[0] = -0.1
    assert heart.moves(step, 2)
