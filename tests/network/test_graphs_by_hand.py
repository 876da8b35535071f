"""Networks at the edge of their rules: sizes, names, nodes, loops, shares of the flow and what is said of them."""

import numpy as np
import pytest

from vasowave.errors import InputError
from vasowave.network.graph import in_loops, meetings, numbered, parents, shares_by_conductance, steady_flows
from vasowave.network.network import MEASURED, POSSIBLE, Network, a_network, closes, image_pressure, measured_falls

SIZES = [0.75, 0.55, 0.35, 0.3], [0.047, 0.037, 0.026, 0.024]
TREE = Network(tuple("abcd"), [-1, 0, 0, 1], *SIZES)


def said(function, *given, **more):
    with pytest.raises(InputError) as error:
        function(*given, **more)
    return str(error.value)


def network(**changes):
    given = {"name": tuple("abcd"), "parent": [-1, 0, 0, 1], "length": SIZES[0], "radius": SIZES[1]} | changes
    return Network(**given)


(SHORT, LONG), (THIN, WIDE) = POSSIBLE["length"], POSSIBLE["radius"]


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"parent": None}, "network: give the row of each vessel's parent, or nodes"),
        ({"name": (), "parent": [], "length": [], "radius": []}, "the network has no vessels"),
        ({"parent": [-1, 0, 0]}, "network: 4 names but parent has shape (3,); give one value per vessel"),
        ({"length": [1.0, 1, 1]}, "network: 4 names but length has shape (3,); give one value per vessel"),
        ({"radius": [[1.0]]}, "network: 4 names but radius has shape (1, 1); give one value per vessel"),
        ({"parent": [-1, 0, 0, 1.5]}, "network: parents are whole numbers"),
        ({"parent": ["a", 0, 0, 1]}, "network: parents are numbers, one per vessel: the row of its parent, -1 at the"),
        ({"parent": [-1, 0, 0, 1e300]}, "network: parents are whole numbers"),
        ({"name": ("a", " ", "c", "d")}, "row 2: the vessel has no name"),
        ({"name": ("a", "b", " =c", "d")}, "row 3: ' =c' is no name of a vessel: a spreadsheet would run it; rename"),
        ({"name": ("a", "b", "c", "@d")}, "row 4: '@d' is no name of a vessel"),
        ({"name": ("a", "b\x07", "c", "d")}, "row 2: 'b?' is no name of a vessel"),
        ({"name": ("a", "b", "c", "b")}, "row 4: vessel 'b' is already defined in row 2; rename one"),
        ({"parent": [-1, 0, 4, 1]}, "row 3 (vessel 'c'): parent row 4 does not exist"),
        ({"parent": [-1, 0, 0, -2]}, "row 4 (vessel 'd'): parent row -2 does not exist"),
        ({"length": [1.0, 0, 1, 1]}, "row 2 (vessel 'b'): length 0 cm is not a positive number"),
        ({"length": [1.0, 1, np.nan, 1]}, "row 3 (vessel 'c'): length nan cm is not a positive number"),
        ({"radius": [0.1, np.inf, 0.1, 0.1]}, "row 2 (vessel 'b'): radius inf cm is not a positive number"),
        ({"length": [1.0, 1, 1, 1.01 * LONG]}, f"row 4 (vessel 'd'): length {1.01 * LONG:g} cm is no animal's"),
        ({"length": [1.0, 1, 1, 0.99 * SHORT]}, f"row 4 (vessel 'd'): length {0.99 * SHORT:g} cm is no animal's"),
        ({"radius": [0.1, 1.01 * WIDE, 0.1, 0.1]}, f"row 2 (vessel 'b'): radius {1.01 * WIDE:g} cm is no animal's"),
        ({"radius": [0.1, 0.99 * THIN, 0.1, 0.1]}, f"row 2 (vessel 'b'): radius {0.99 * THIN:g} cm is no animal's"),
        ({"parent": [1, 0, 0, 1]}, "row 1: no root; leave the parent of the vessel that carries the inflow empty"),
        ({"parent": [-1, 0, -1, 1]}, "2 vessels have no parent: 'a' (row 1), 'c' (row 3); one network has one root"),
        ({"parent": [-1, 0, 3, 2]}, "row 3 (vessel 'c'): not connected to the root, its parents form a cycle"),
        ({"pressure": -1.0}, "pressure of the image -1 mmHg: give the transmural pressure"),
        ({"pressure": 100.1}, "pressure of the image 100.1 mmHg: give"),
        ({"radius_sd": [0.1, 0.1]}, "network: radius_sd has shape (2,); give one value per vessel, NaN if unknown"),
        ({"radius_sd": [np.nan, 0.0, 1, 1]}, "row 2 (vessel 'b'): radius_sd 0 is not possible; a standard"),
        ({"taper_sd": [np.nan, 1.0, np.inf, 1]}, "row 3 (vessel 'c'): taper_sd inf is not possible"),
        ({"taper": [0.0, 0, 0, 0.161]}, "row 4 (vessel 'd'): taper 0.161 is not possible; a standard deviation"),
        ({"nodes": [[0, 1]]}, "network: 4 names but nodes have shape (1, 2); give two per vessel"),
        ({"nodes": [[0, 1], [1, 2], [1, 3], [2, 4]], "parent": [-1, 0, 1, 1]}, "network: parents are given that are"),
    ],
)  # fmt: skip
def test_a_network_that_cannot_be_is_refused_with_row_and_vessel(changes, words):
    assert said(network, **changes).startswith(words)


def test_sizes_pressures_and_tapers_at_their_limits_are_taken():
    found = network(length=[SHORT, LONG, 1, 1], radius=[THIN, WIDE, 0.1, 0.1], pressure=100.0)
    assert found.pressure == 100.0
    assert network(taper=[0, -0.13, 0, 0.159]).taper[3] == 0.159
    assert closes(np.array([0.0, -0.14, 0.0, 0.16]), TREE).tolist() == [False, True, False, True]
    assert image_pressure(0.0) == 0.0


def test_a_network_says_what_it_is():
    assert repr(TREE) == "Network(4 vessels, 2 terminals, root 'a' r0 0.047 cm, total length 1.95 cm)"
    page = network(pressure=5.0)._repr_html_()
    for words in ("4, 2 of them terminal", "radius 0.047 cm", "1.95 cm", "0.024 to 0.047 cm", "5 mmHg"):
        assert words in page
    assert "a pressure not known, taken for 0" in TREE._repr_html_()
    table = TREE.to_dataframe()
    assert table["parent"].tolist() == ["", "a", "a", "b"]
    assert table["length [cm]"].tolist() == SIZES[0]
    assert TREE.row("c") == 2
    assert said(TREE.row, "x").startswith("the network has no vessel 'x'")
    assert a_network(TREE) is TREE
    assert said(a_network, "n.csv") == "'n.csv' is the name of a file; read it first: vasowave.read_network('n.csv')"
    assert said(a_network, 3) == "int was given where a Network is needed"


def test_rows_nodes_and_shares_of_a_tree():
    assert (TREE.root, TREE.inlets.tolist(), TREE.terminals.tolist()) == (0, [0], [2, 3])
    assert TREE.start.tolist() == [0, 1, 1, 2]
    assert TREE.end.tolist() == [1, 2, 3, 4]
    assert TREE.daughters == ((1, 2), (3,), (), ())
    assert [rows.tolist() for rows in TREE.generations] == [[0], [1, 2], [3]]
    assert [(one.ending, one.beginning) for one in TREE.junctions] == [((0,), (1, 2)), ((1,), (3,))]
    b, c = 0.037**4 / 0.55, 0.026**4 / 0.35
    assert TREE.flow_fraction == pytest.approx([1, b / (b + c), c / (b + c), b / (b + c)])


def test_another_size_keeps_the_topology_and_nothing_measured():
    full = network(radius_sd=[0.01] * 4, taper=[0.01] * 4, pressure=5.0)
    other = full.resized(radius=2 * full.radius, pressure=7.0)
    assert (other.radius.tolist(), other.length.tolist()) == ((2 * full.radius).tolist(), SIZES[0])
    assert (other.pressure, other.name, other.parent.tolist()) == (7.0, full.name, [-1, 0, 0, 1])
    assert all(getattr(other, name) is None for name in MEASURED)
    assert full.resized(length=3 * full.length).pressure == 5.0
    assert "is no animal's" in said(full.resized, radius=1e4 * full.radius)
    assert said(full.resized, pressure=-1.0).startswith("pressure of the image -1 mmHg")


RING = [[0, 1], [1, 2], [1, 3], [2, 3], [3, 4]]


def test_a_tree_by_its_nodes_is_a_tree_and_a_ring_is_none():
    tree = network(parent=None, nodes=[[9, 5], [5, 7], [5, 2], [7, 1]])
    assert (tree.parent.tolist(), tree.nodes) == ([-1, 0, 0, 1], None)
    ring = Network(tuple("abcde"), None, [1.0] * 5, [0.1] * 5, nodes=RING)
    assert ring.parent.tolist() == [-1, 0, 0, 1, 2]
    assert ring.terminals.tolist() == [4]
    assert ring.topology() == {"from": list("01123"), "to": list("12334")}
    assert in_loops(ring.start, ring.end).tolist() == [False, True, True, True, False]
    assert [(one.ending, one.beginning) for one in ring.junctions] == [((0,), (1, 2)), ((1,), (3,)), ((2, 3), (4,))]
    assert numbered([("x", "y"), ("y", "z"), ("x", "z")]).tolist() == [[0, 1], [1, 2], [0, 2]]
    met = meetings(np.array([0, 1]), np.array([1, 2]))
    assert list(met) == [1, 2, 0]
    assert (met[1].ending, met[1].beginning, met[0].ending, met[2].beginning) == ((0,), (1,), (), ())


def test_flows_divide_between_the_ways_of_a_ring_as_their_conductances():
    start, end = np.array(RING).T
    conductance = np.array([3.0, 2.0, 1.0, 2.0, 5.0])
    found = shares_by_conductance(start, end, conductance)
    assert found == pytest.approx([1, 0.5, 0.5, 0.5, 1])  # two in series are one of 1
    bridge = np.array([[0, 1], [1, 2], [1, 3], [2, 3], [2, 4], [3, 5]]).T
    g = np.array([9.0, 2.0, 1.0, 3.0, 4.0, 5.0])
    shares = shares_by_conductance(*bridge, g)
    p = np.linalg.solve([[3.0, -2, -1], [-2, 9, -3], [-1, -3, 9]], [1, 0, 0])
    expected = [1, 2 * (p[0] - p[1]), p[0] - p[2], 3 * (p[1] - p[2]), 4 * p[1], 5 * p[2]]
    assert shares == pytest.approx(expected)
    two = np.array([[0, 2], [1, 2], [2, 3], [2, 4]]).T
    assert shares_by_conductance(*two, np.array([1.0, 3.0, 2.0, 6.0])) == pytest.approx([0.25, 0.75, 0.25, 0.75])
    steady = steady_flows(*np.array(RING).T, conductance)
    assert steady[0] == pytest.approx(1 / (1 / 3 + 1 / 2 + 1 / 5))
    assert steady[[1, 2, 3, 4]] == pytest.approx(steady[0] * np.array([0.5, 0.5, 0.5, 1]))


@pytest.mark.parametrize(
    ("nodes", "words"),
    [
        ([[0, 1], [1, 1]], "row 2 (vessel 'b'): ends in the node in which it begins"),
        ([[0, 1], [1, 0]], "row 1: no vessel begins in a node of its own, where blood could enter; the vessels form a"),
        ([[0, 1], [1, 2], [2, 1]], "row 1: no vessel ends in a node of its own, where blood could leave; the vessels"),
        ([[0, 1], [0, 2], [1, 3], [2, 4]], "row 1: 'a' and 'b' begin in a node where none ends; let one vessel lead"),
        ([[0, 2], [1, 2], [3, 4]], "row 1: 'a' and 'b' end in a node where none begins; let them lead to one vessel"),
        ([[0, 1], [1, 2], [3, 4], [4, 3], [4, 5]], "row 3 (vessel 'c'): not reached from an inlet along the vessels"),
        ([[0, 1], [1, 2], [1, 3], [3, 4], [4, 3]], "row 3 (vessel 'c'): leads to no vessel that ends in a bed; turn"),
        ([[0, 1], [2, 3]], "row 2: vessel 'b' and what follows it never meet the vessels behind 'a'; give each"),
    ],
)  # fmt: skip
def test_nodes_at_which_no_blood_can_pass_are_refused(nodes, words):
    names = tuple("abcdefg"[: len(nodes)])
    assert said(parents, names, np.array(nodes), lambda row: f"row {row + 1}").startswith(words)


def test_a_taper_that_was_measured_is_drawn_towards_none_by_its_error():
    """Shares: 0.02 · 0.75/0.047 = 0.3191 of SD 0.1596 beside a prior of 0.3."""
    found = network(taper=[0.02, np.nan, 0.01, 0.0], taper_sd=[0.01, 0.01, np.nan, 0.01])
    falls, sd = measured_falls(found, 0.3)
    share, own = 0.02 * 0.75 / 0.047, 0.01 * 0.75 / 0.047
    weight = 0.09 / (0.09 + own**2)
    assert falls[0] == pytest.approx(weight * share)
    assert sd[0] == pytest.approx(0.3 * np.sqrt(1 - weight))
    assert falls[1] == 0.0
    assert falls[2] == pytest.approx(0.01 * 0.35 / 0.026)
    assert falls[3] == 0.0
