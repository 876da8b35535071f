import re
import warnings
from pathlib import Path

import numpy as np
import pytest
from scipy.io import savemat

import vasowave as vw
from vasowave.base import InputError, VasowaveWarning

DATA = Path(__file__).parents[4] / "shared/data"
needs_data = pytest.mark.skipif(not DATA.is_dir(), reason=f"no measured data at {DATA}")

SEGMENTS = """MODEL tree
NODE 0 0 0 0
JOINT J1 1 IN OUT
JOINTINLET IN 1 0
JOINTOUTLET OUT 2 1 2
SEGMENT main 0 17.5 50 0 1 5.0 1.6 0.0 MAT1 NONE 0.0 0 0 NOBOUND NONE
SEGMENT left 1 13.0 50 1 3 1.5 0.3 0.0 MAT1 NONE 0.0 0 0 RCR VALUES
SEGMENT right 2 12.0 50 1 2 1.5 1.5 0.0 MAT1 NONE 0.0 0 0 RCR VALUES
MATERIAL MAT1 OLUFSEN 1.06 0.04 113324.0 1.0 2.0e7 -22.5267 8.65e5
"""

EDGES = """type,ID,name,start_node,end_node,start_diameter[SI],end_diameter[SI],length[SI]
vis,A1,aorta,H,n1,0.03,0.02,0.05
vis,A2,left,n1,p1,0.012,0.012,0.20
vis,A3,right,n1,p2,0.010,0.008,0.10
type,ID,name,leak
heart,H,0,
node,n1,0,5e11
perif,p1,0,
perif,p2,0,
"""


def quiet(path, unit=None):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", VasowaveWarning)
        return vw.read_network(path, unit)


def matrices(tmp_path, **changes):
    values = {
        "dim_mat": np.array([[1, 40.0, 5.0], [2, 45.0, 3.0], [3, 37.0, 4.0]]),
        "ves_conn": np.array([[1, 2, 3]], dtype=np.uint8),
        "r_std": np.array([[0.5], [0.3], [0.0]]),
    } | changes
    savemat(tmp_path / "tree.mat", {name: value for name, value in values.items() if value is not None})
    return tmp_path / "tree.mat"


def test_matrices_of_matlab_become_a_network_in_the_unit_that_was_given(tmp_path):
    network = quiet(matrices(tmp_path), "0.01 cm")
    assert network.name == ("1", "2", "3")
    assert network.parent.tolist() == [-1, 0, 0]
    np.testing.assert_allclose(network.length, [0.4, 0.45, 0.37])
    np.testing.assert_allclose(network.radius, [0.05, 0.03, 0.04])
    np.testing.assert_allclose(network.radius_sd, [0.005, 0.003, np.nan])


@pytest.mark.parametrize(
    ("unit", "message"),
    [
        (None, r"does not say the unit"),
        ("furlong", "not a unit of length"),
        ("0 mm", "must be positive"),
        ("3", "write a unit"),
    ],
)
def test_a_wrong_unit_is_refused(tmp_path, unit, message):
    with pytest.raises(InputError, match=message):
        vw.read_network(matrices(tmp_path), unit)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"ves_conn": None}, "no variable ves_conn"),
        ({"ves_conn": np.array([[1, 2, 9]])}, "no vessel 9"),
        ({"ves_conn": np.array([[1, 2, 3], [2, 3, 0]])}, "vessel '2'.: ends in the node in which it begins"),
        ({"dim_mat": np.array([[1, 40.0], [2, 45.0]])}, "at least 3 columns"),
        ({"dim_mat": np.array([[1, 40.0, 5.0], [1, 45.0, 3.0], [3, 37.0, 4.0]])}, "stands twice"),
        ({"r_std": np.ones((2, 1))}, "one number for each"),
        ({"dim_mat": np.array([[1, 40.0, 5.0], [2, -45.0, 3.0], [3, 37.0, 4.0]])}, r"row 2 \(vessel '2'\): length"),
    ],
)
def test_a_slip_in_the_matrices_is_named(tmp_path, changes, message):
    with pytest.raises(InputError, match=message):
        vw.read_network(matrices(tmp_path, **changes), "mm")


def test_two_plain_tables_become_a_network_with_its_tapers(tmp_path):
    (tmp_path / "Dimensions.txt").write_text("2.87\t1.64\t1.64\n4.74\t1.55\t1.45\n6.23\t1.36\t1.2\n", "utf-8")
    (tmp_path / "connectivity.txt").write_text("0\t1\t2\t0\n1\t0\t0\t0\n2\t0\t0\t0\n", "utf-8")
    for name in ("Dimensions.txt", "connectivity.txt"):
        network = quiet(tmp_path / name, "cm")
        assert network.parent.tolist() == [-1, 0, 0]
        np.testing.assert_allclose(network.radius, [1.64, 1.5, 1.28])
        np.testing.assert_allclose(network.taper, [0.0, 0.1 / 4.74, 0.16 / 6.23])


def test_segments_of_svonedsolver_become_a_network(tmp_path):
    (tmp_path / "tree.in").write_text(SEGMENTS, "utf-8")
    with pytest.warns(VasowaveWarning, match="walls, beds are no part of a network"):
        network = vw.read_network(tmp_path / "tree.in")
    assert network.name == ("main", "left", "right")
    assert network.parent.tolist() == [-1, 0, 0]
    first, last = np.sqrt(5.0 / np.pi), np.sqrt(1.6 / np.pi)
    assert network.radius[0] == pytest.approx((first + last) / 2)
    assert network.taper[0] == pytest.approx((first - last) / 17.5)
    np.testing.assert_allclose(network.length, [17.5, 13.0, 12.0])


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("17.5", "long", "line 6: 'long' is not a number"),
        ("JOINTINLET IN 1 0", "JOINTINLET IN 2 0 1", "segment 1 ends in two joints|ends in the node"),
        ("OUT 2 1 2", "OUT 21 2", "line 5: JOINTOUTLET says 21 segments and lists 1"),
        ("SEGMENT left", "SEGMEN left", "line 7: 'SEGMEN' is no card"),
        ("OUT 2 1 2", "OUT 2 1 7", "needs known segments that begin in it"),
        ("SEGMENT", "# SEGMENT", "has no SEGMENT"),
        ("50 0 1 5.0 1.6 0.0 MAT1 NONE 0.0 0 0 NOBOUND NONE", "50", "a SEGMENT of 4 words"),
        ("5.0 1.6", "-5.0 1.6", "has areas -5"),
    ],
)
def test_a_slip_in_segments_is_named_with_its_line(tmp_path, old, new, message):
    (tmp_path / "tree.in").write_text(SEGMENTS.replace(old, new), "utf-8")
    with pytest.raises(InputError, match=message):
        vw.read_network(tmp_path / "tree.in")


def test_a_table_of_edges_in_meters_becomes_a_network_in_centimeters(tmp_path):
    (tmp_path / "arterial.csv").write_text(EDGES, "utf-8")
    network = quiet(tmp_path / "arterial.csv")
    assert network.name == ("A1", "A2", "A3")
    assert network.parent.tolist() == [-1, 0, 0]
    np.testing.assert_allclose(network.length, [5.0, 20.0, 10.0])
    np.testing.assert_allclose(network.radius, [1.25, 0.6, 0.45])
    np.testing.assert_allclose(network.taper, [0.1, 0.0, 0.01])


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("vis,A3,right,n1,p2,0.010,0.008,0.10\n", "", "node 'p2' is a bed in which no vessel ends"),
        ("perif,p2,0,\n", "", "node 'p2' has no vessel or bed behind it"),
        ("vis,A3", "v,A3", "line 4: a row of type 'v'; known are vis, vis_f, heart, node, perif"),
        ("length[SI]", "le gth[SI] length[SI]", r"line 1: no column 'length\[SI\]'"),
    ],
)
def test_an_edge_that_is_missing_or_damaged_is_seen_by_its_nodes(tmp_path, old, new, message):
    (tmp_path / "arterial.csv").write_text(EDGES.replace(old, new), "utf-8")
    with pytest.raises(InputError, match=message):
        vw.read_network(tmp_path / "arterial.csv")


@needs_data
@pytest.mark.parametrize(
    ("file", "unit", "vessels", "terminals"),
    [
        ("other-formats/PP_C1_p1.mat", "0.0036 cm", 135, 68),
        ("other-formats/Dimensions.txt", "cm", 3, 2),
        ("other-formats/05_bifurcation_RCR.in", None, 3, 2),
        ("benchmarks/xiao2014_cases_svOneD_tests/Left_coronary_inlet_pressure_wave_outlet_coronary.in", None, 86, 6),
    ],
)
def test_files_of_other_groups_are_read(file, unit, vessels, terminals):
    network = quiet(DATA / file, unit)
    assert (len(network), len(network.terminals)) == (vessels, terminals)


@needs_data
@pytest.mark.parametrize("file", ["other-formats", "benchmarks/reymond103_first_blood/Abel_ref2"])
def test_a_circle_of_willis_keeps_its_loops(file):
    """Edges - nodes + 1 loops of a connected graph: the ring, and three by the four arteries that lead to it."""
    network = quiet(DATA / file / "arterial.csv")
    nodes = len(np.unique([network.start, network.end]))
    assert (len(network), len(network.terminals), len(network) - nodes + 1) == (103, 47, 4)
    assert network.flow_fraction[network.terminals].sum() == pytest.approx(1.0)


def test_a_unit_beside_a_file_that_says_its_own_and_one_of_two_tables_alone_are_refused(tmp_path):
    (tmp_path / "tree.in").write_text(SEGMENTS, "utf-8")
    with pytest.raises(InputError, match="says the unit of its lengths itself"):
        vw.read_network(tmp_path / "tree.in", "mm")
    (tmp_path / "Dimensions.txt").write_text("2.87 1.64 1.64\n", "utf-8")
    with pytest.raises(InputError, match=r"connectivity\.txt must lie beside it"):
        vw.read_network(tmp_path / "Dimensions.txt", "cm")


@pytest.mark.parametrize(
    ("name", "text", "words"),
    [
        ("a.csv", EDGES.replace("length[SI]\n", "length[SI],k1[SI]\n").replace("0.05\n", "0.05,3\n")
         .replace("0.20\n", "0.20,\n").replace("0.10\n", "0.10,\n"), r"column 'k1\[SI\]': given and not used"),
        ("a.in", SEGMENTS.replace("MAT1 NONE", "MAT1 STENOSIS", 1), "STENOSIS of SEGMENT main: given and not used"),
        ("a.csv", "name,parent,length [cm],radius [cm],tapr [cm/cm]\n1,,1,0.1,0.01\n",
         r"column 'tapr' \(did you mean 'taper'\?\): given and not used"),
    ],
)  # fmt: skip
def test_whatever_a_file_gives_and_no_network_takes_is_listed(tmp_path, name, text, words):
    (tmp_path / name).write_text(text, "utf-8")
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        vw.read_network(tmp_path / name)
    assert any(re.search(words, str(one.message)) for one in told)
