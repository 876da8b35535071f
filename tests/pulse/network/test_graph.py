"""Networks whose vessels join again: their tables, their shares of the flow, their repairs, and what is refused."""

import numpy as np
import pytest

import vasowave as vw
from vasowave.base import InputError
from vasowave.pulse.network import in_loops

TABLE = """name,from,to,length [mm],radius [mm]
main,heart,a,4.1,0.47
left,a,b,4.45,0.26
right,a,c,3.72,0.37
bridge,b,c,2.0,0.15
lung 1,b,bed 1,1.8,0.2
lung 2,c,bed 2,2.4,0.25
"""


@pytest.fixture
def circle(tmp_path):
    (tmp_path / "circle.csv").write_text(TABLE, "utf-8")
    return vw.read_network(tmp_path / "circle.csv")


def test_a_table_of_nodes_says_where_vessels_meet(circle):
    assert circle.nodes.tolist() == [[0, 1], [1, 2], [1, 3], [2, 3], [2, 4], [3, 5]]
    assert circle.junctions == (((0,), (1, 2)), ((1,), (3, 4)), ((2, 3), (5,)))
    assert (circle.root, circle.terminals.tolist(), circle.parent.tolist()) == (0, [4, 5], [-1, 0, 0, 1, 1, 2])
    assert in_loops(circle.start, circle.end).tolist() == [False, True, True, True, False, False]


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("bridge,b,c", "bridge,b,b", r"line 5 \(vessel 'bridge'\): ends in the node in which it begins"),
        ("bridge,b,c", "bridge,,c", r"line 5 \(vessel 'bridge'\): no node in 'from' or 'to'"),
        ("lung 2,c,bed 2", "lung 2,c,bed 1", "line 6: 'lung 1' and 'lung 2' end in a node where none begins"),
        ("right,a,c", "right,heart,c", "line 2: 'main' and 'right' begin in a node where none ends"),
        ("main,heart,a", "main,b,a", "line 2: no vessel begins in a node of its own, where blood could enter"),
        ("lung 1,b,bed 1", "lung 1,x,bed 1", "line 6: vessel 'lung 1' and what follows it never meet"),
    ],
)
def test_what_no_graph_can_be_is_an_error_that_names_the_line(tmp_path, old, new, message):
    (tmp_path / "circle.csv").write_text(TABLE.replace(old, new), "utf-8")
    with pytest.raises(InputError, match=message):
        vw.read_network(tmp_path / "circle.csv")


@pytest.mark.filterwarnings("ignore::vasowave.base.errors.VasowaveWarning")  # of a single daughter
def test_a_vessel_that_is_drawn_towards_the_others_is_one_more_inlet(tmp_path):
    (tmp_path / "circle.csv").write_text(TABLE.replace("lung 1,b,bed 1", "lung 1,bed 1,c"), "utf-8")
    assert vw.read_network(tmp_path / "circle.csv").inlets.tolist() == [0, 4]


def test_rings_that_no_blood_reaches_or_leaves_are_refused():
    def of(nodes):
        return vw.Network(tuple("abcdef"[: len(nodes)]), None, [1.0] * len(nodes), [0.1] * len(nodes), nodes=nodes)

    with pytest.raises(InputError, match=r"vessel 'd'\): leads to no vessel that ends in a bed"):
        of([[0, 1], [1, 2], [2, 5], [2, 3], [3, 4], [4, 3]])
    with pytest.raises(InputError, match=r"vessel 'c'\): not reached from an inlet"):
        of([[0, 1], [1, 2], [3, 4], [4, 3], [3, 1]])


def test_shares_in_a_loop_are_those_of_resistors_and_what_follows_divides_anew(circle):
    """By Kirchhoff's laws for the loop with its two exits, whose ends share one pressure; then eq. 11 as ever."""
    g = circle.radius**4 / circle.length
    a, b, c = np.linalg.solve(
        [[g[1] + g[2], -g[1], -g[2]], [-g[1], g[1] + g[3] + g[4], -g[3]], [-g[2], -g[3], g[2] + g[3] + g[5]]],
        [1.0, 0.0, 0.0],
    )
    expected = [1.0, g[1] * (a - b), g[2] * (a - c), g[3] * (b - c), g[4] * b, g[5] * c]
    np.testing.assert_allclose(circle.flow_fraction, expected, rtol=1e-12)
    more = vw.Network((*circle.name, "x", "y"), None, np.append(circle.length, [0.2, 0.3]),
                      np.append(circle.radius, [0.02, 0.03]),
                      nodes=np.vstack([circle.nodes, [[5, 6], [5, 7]]]))  # fmt: skip
    split = more.radius[6:] ** 4 / more.length[6:]
    np.testing.assert_allclose(more.flow_fraction[6:], expected[5] * split / split.sum(), rtol=1e-12)


def test_a_vessel_behind_a_loop_that_is_cut_in_pieces_takes_the_flow_that_it_took_whole(circle):
    quarters = circle.length[5] * np.array([0.25, 0.5, 0.25])
    pieces = vw.Network((*circle.name, "f2", "f3"), None, np.append(circle.length[:5], quarters),
                        np.append(circle.radius, [circle.radius[5]] * 2),
                        nodes=np.vstack([circle.nodes, [[5, 6], [6, 7]]]))  # fmt: skip
    np.testing.assert_allclose(pieces.flow_fraction[:6], circle.flow_fraction, rtol=1e-12)
    np.testing.assert_allclose(pieces.flow_fraction[6:], circle.flow_fraction[5], rtol=1e-12)


def test_repairs_keep_loops_and_never_make_a_vessel_end_where_it_begins(circle):
    """A bridge that is too short may not be merged: others end where it does. One that leads on alone is."""
    long = vw.tidy(circle)
    assert not long.repairs
    assert long.network.nodes is not None
    length = circle.length.copy()
    length[1] = 1e-3  # 'left': its daughters start where it did
    short = vw.tidy(vw.Network(circle.name, None, length, circle.radius, nodes=circle.nodes))
    assert [(one.code, one.vessel) for one in short.repairs] == [("merged", "left")]
    assert short.network.nodes.tolist() == [[0, 1], [1, 3], [1, 3], [1, 4], [3, 5]]
    length = circle.length.copy()
    length[3] = 1e-3
    bridge = vw.tidy(vw.Network(circle.name, None, length, circle.radius, nodes=circle.nodes))
    assert [(one.code, one.vessel) for one in bridge.repairs] == [("lengthened", "bridge")]
