"""Tables of vessels, files of other programs and repairs, written by hand: which line and word each refusal names."""

import numpy as np
import pytest
from scipy.io import savemat

from vasowave.errors import InputError
from vasowave.network.network import Network
from vasowave.network.remarks import implausible_sizes, unknown_pressure, unlike_the_species
from vasowave.network.tidying import LOST, repaired, tidy
from vasowave.network.vessel_table import is_vessel_table, read_vessel_table, write_network
from vasowave.network_formats import read_network, scale_of
from vasowave.network_formats.first_blood import is_edges, read_edges
from vasowave.network_formats.ncsu import read_dimensions, read_mat_network
from vasowave.network_formats.svonesolver import is_input, read_input
from vasowave.species import SPECIES


def said(function, *given, **more):
    with pytest.raises(InputError) as error:
        function(*given, **more)
    return str(error.value)


def file(tmp_path, text, name="n.csv"):
    (tmp_path / name).write_text(text)
    return tmp_path / name


ROWS = "a,,1,0.1\nb,a,2,0.08\nc,a,3,0.06\n"


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("1,2\n3,4\n", ": no header; the first line must read: name, parent, length [cm], radius [cm]"),
        ("name,parent,length [cm]\na,,1\n", ": no column 'radius'; the header has: name, parent, length; such a table"),
        ("name,length [cm],radius [cm]\na,1,1\n", ": no column 'parent'"),
        ("name,parent,length [cm],radius [cm],diameter [cm]\na,,1,1,1\n", ": both 'radius' and 'diameter' say how"),
        ("name,parent,length [cm],radius [cm]\n# x\n\na,,1,0.1\nb,x,1,0.1\n", ", line 5 (vessel 'b'): parent 'x' is"),
        ("name,parent,length [cm],radius [cm]\na,root,1,0.1\n", ", line 2 (vessel 'a'): parent 'root' is not"),
        ("name,parent,length [cm],radius [cm]\na,,1,0.1\na,q,1,0.1\n", ", line 3 (vessel 'a'): parent 'q' is not"),
        ("name,parent,length [cm],radius [cm],radius end [cm],taper [1]\na,,1,0.1,0.1,0\n", ": both 'radius end' and"),
        ("name,from,to,parent,length [cm],radius [cm]\na,1,2,,1,0.1\n", ": both 'parent' and 'from', 'to' say what"),
        ("name,from,to,length [cm],radius [cm]\na,1,2,1,0.1\nb,2,,1,0.1\n", ", line 3 (vessel 'b'): no node in 'from'"),
        ("name,parent,length [cm],radius [cm],pressure [mmHg]\na,,1,0.1,5\nb,a,1,0.1,5\nc,a,1,0.1,6\n",
         ", line 4: pressure 6 mmHg, but 5 mmHg in the first row; all radii of a network"),
        ("name,parent,length [cm],radius [cm],pressure [mmHg]\na,,1,0.1,500\n", ", line 2: pressure of the image 500"),
        ("name,parent,length [cm],radius [cm]\na,,1,0.1\nb,a,0,0.1\n", ", line 3 (vessel 'b'): length 0 cm is not a"),
        ("name,parent,length [cm],radius [cm]\na,,1,0.1\nb,a,1,x\n", ", line 3, column 'radius': 'x' is not a number"),
    ],
)  # fmt: skip
def test_a_table_that_is_no_network_is_refused_with_its_line(tmp_path, text, words):
    assert said(read_vessel_table, file(tmp_path, text)).partition("n.csv")[2].startswith(words)


def test_a_table_may_have_other_units_diameters_ends_and_empty_cells(tmp_path):
    text = "vessel;parent;l [mm];d [um];radius_end [mm];radius_sd [um];pressure [kPa]\n"
    text += "a;;10;2000;0,8;;1\nb;a;20;1600;;50;1\n"
    network, found = read_vessel_table(file(tmp_path, text))
    assert network.length == pytest.approx([1, 2])
    assert network.radius == pytest.approx([0.09, 0.08])
    assert network.taper == pytest.approx([0.02, np.nan], nan_ok=True)
    assert network.radius_sd == pytest.approx([np.nan, 0.005], nan_ok=True)
    assert network.pressure == pytest.approx(7.50062, rel=1e-5)
    (alone,) = found
    assert str(alone).startswith("1 vessel(s) with one daughter, where nothing divides ('a'); was a row lost?")
    assert is_vessel_table(tmp_path / "n.csv", b"x,Parent\n1,2\n")
    assert is_vessel_table(tmp_path / "n.csv", b"from,to\n1,2\n")
    assert not is_vessel_table(tmp_path / "n.csv", b"from,x\n1,2\n")


def test_numbers_of_vessels_and_ends_tell_lost_rows(tmp_path):
    head = "name,parent,length [cm],radius [cm],vessels,outlets\n"
    text = head + "a,,1,0.1,3,2\nb,a,2,0.08,4,2\nc,a,3,0.06,,3\n"
    _, found = read_vessel_table(file(tmp_path, text))
    assert [dict(one.values) for one in found] == [
        {"found": "3", "column": "vessels", "count": "4"}, {"found": "2", "column": "outlets", "count": "3"}
    ]  # fmt: skip
    chain = "name,parent,length [cm],radius [cm]\nv0,,1,0.1\n" + "".join(f"v{i},v{i - 1},1,0.1\n" for i in range(1, 8))
    (alone,) = read_vessel_table(file(tmp_path, chain))[1]
    assert "7 vessel(s)" in str(alone)
    assert "'v4', …" in str(alone)


def test_a_network_is_written_as_it_is_read(tmp_path):
    network = Network(("a", "b,c", "d"), [-1, 0, 0], [1 / 3, 2, 3], [0.1, 0.08, 0.06], pressure=2.5,
                      radius_sd=[0.01, np.nan, 0.02], taper=[0.01, 0, np.nan], taper_sd=[np.nan] * 3)  # fmt: skip
    write_network(network, tmp_path / "w.csv")
    lines = (tmp_path / "w.csv").read_text().splitlines()
    assert lines[0].startswith("name,parent,length [cm],radius [cm],radius_sd [cm],taper [")
    assert lines[0].endswith(",pressure [mmHg],vessels,outlets")
    assert lines[2].startswith('"b,c",a,2.0,0.08,,0.0,,2.5,3,2')
    back, found = read_vessel_table(tmp_path / "w.csv")
    assert found == []
    assert (back.name, back.pressure, back.length.tolist()) == (network.name, 2.5, network.length.tolist())
    assert back.radius_sd == pytest.approx(network.radius_sd, nan_ok=True)
    ring = Network(tuple("abcd"), None, [1.0, 2, 3, 4], [0.1, 0.08, 0.06, 0.09], nodes=[[0, 1], [1, 2], [1, 2], [2, 3]])
    write_network(ring, tmp_path / "r.csv")
    again, _ = read_vessel_table(tmp_path / "r.csv")
    assert again.nodes.tolist() == [[0, 1], [1, 2], [1, 2], [2, 3]]


@pytest.mark.parametrize(("unit", "scale"), [("mm", 0.1), ("0.0036 cm", 0.0036), (" 2um ", 2e-4), ("1e-3 m", 0.1)])
def test_a_unit_may_be_so_many_of_it(unit, scale):
    assert scale_of(unit) == pytest.approx(scale)


def test_a_unit_that_is_none_is_refused_and_asked_for_where_it_is_needed(tmp_path):
    assert said(scale_of, "3").startswith("unit '3': write a unit, as mm, or a number and a unit")
    assert said(scale_of, "0 mm") == "unit '0 mm': the number must be positive"
    path = file(tmp_path, "name,parent,length [cm],radius [cm]\n" + ROWS)
    assert said(read_network, path, "mm").endswith("says the unit of its lengths itself; leave out the unit 'mm'")
    for name, text in (
        ("Dimensions.txt", "4 0.5 0.5\n4 0.3 0.3\n3 0.4 0.4\n"),
        ("connectivity.txt", "0 1 2\n1 0 0\n2 0 0\n"),
    ):
        file(tmp_path, text, name)
    words = said(read_network, tmp_path / "Dimensions.txt")
    assert "a Dimensions.txt with connectivity.txt does not say the unit of its lengths; give it" in words
    assert read_network(tmp_path / "connectivity.txt", "mm").length == pytest.approx([0.4, 0.4, 0.3])


def dimensions(tmp_path, sizes, rows):
    file(tmp_path, rows, "connectivity.txt")
    return file(tmp_path, sizes, "Dimensions.txt")


def test_two_tables_hold_sizes_and_daughters(tmp_path):
    path = dimensions(tmp_path, "10,1.1,0.9\n20 0.8 0.8\n\n30 0.6 0.6\n", "1 0 0\n0 2 1\n2 0 0\n")
    network, found = read_dimensions(path, 0.1)
    assert (network.name, network.parent.tolist(), found) == (("0", "1", "2"), [-1, 0, 0], [])
    assert network.radius == pytest.approx([0.1, 0.08, 0.06])
    assert network.taper == pytest.approx([0.02, 0, 0])


@pytest.mark.parametrize(
    ("sizes", "rows", "words"),
    [
        ("1 1\n", "0 0\n", "Dimensions.txt, line 1: 2 numbers; every line needs 3"),
        ("1 1 1\n1 1 1 1\n", "0 0\n", "Dimensions.txt, line 2: 4 numbers; every line needs 3"),
        ("1 1 x\n", "0 0\n", "Dimensions.txt, line 1: '1 1 x' is not a row of numbers"),
        ("\n", "0 0\n", "Dimensions.txt: is empty"),
        ("1 1 1\n", "0 1\n1\n", "connectivity.txt, line 2: 1 numbers; every line needs as many"),
        ("1 1 1\n2 1 1\n", "0 1\n", "connectivity.txt: 1 rows for 2 vessels; every vessel has one row, which begins"),
        ("1 1 1\n2 1 1\n", "0 1\n2 0\n", "connectivity.txt: 2 rows for 2 vessels"),
        ("1 1 1\n2 1 1\n", "0 1\n1 5\n", "connectivity.txt, row 2 of what joins what: there is no vessel 5"),
        ("1 1 1\n2 0 0\n", "0 1\n1 0\n", "Dimensions.txt, line 2 (vessel '1'): radius 0 cm is not a positive number"),
    ],
)  # fmt: skip
def test_two_tables_that_do_not_agree_are_refused(tmp_path, sizes, rows, words):
    assert words in said(read_dimensions, dimensions(tmp_path, sizes, rows), 1.0)
    (tmp_path / "connectivity.txt").unlink()
    assert "connectivity.txt must lie beside it" in said(read_dimensions, tmp_path / "Dimensions.txt", 1.0)


def test_matrices_hold_numbers_sizes_and_daughters(tmp_path):
    sizes, rows = np.array([[7.0, 10, 1], [3, 20, 0.8], [5, 30, 0.6]]), np.array([[7.0, 3, 5], [3, 0, np.nan]])
    given = {
        "dim_mat": sizes,
        "ves_conn": rows,
        "r_std": np.array([0.1, 0.0, 0.2]),
        "alpha": 0.9,
        "lrr": 30.0,
        "odd": 1.0,
    }

    def read(**changes):
        savemat(tmp_path / "m.mat", {k: v for k, v in (given | changes).items() if v is not None})
        return read_mat_network(tmp_path / "m.mat", 0.1)

    network, (left, odd) = read()
    assert (network.name, network.parent.tolist()) == (("7", "3", "5"), [-1, 0, 0])
    assert network.radius_sd == pytest.approx([0.01, np.nan, 0.02], nan_ok=True)
    assert network.length == pytest.approx([1, 2, 3])
    assert str(left).startswith("alpha, lrr (of structured trees) are no part of a network")
    assert str(odd) == "the variable 'odd' is not known and was left out"
    assert read(alpha=None, lrr=None, odd=None, r_std=None)[1] == []
    for changes, words in (
        ({"dim_mat": None, "ves_conn": None}, "no variable dim_mat and no ves_conn; a network needs"),
        ({"dim_mat": np.ones((3, 2))}, "dim_mat must be a matrix of numbers with at least 3 columns"),
        ({"ves_conn": np.ones((3, 1))}, "ves_conn must be a matrix of numbers with at least 2 columns"),
        ({"r_std": np.ones(2)}, "r_std must have one number for each of the 3 vessels"),
        ({"ves_conn": np.array([[7.0, 3], [7, 9]])}, "row 2 of what joins what: there is no vessel 9"),
        ({"dim_mat": np.array([[7.0, 1, 1], [7, 1, 1]]), "r_std": None}, "a vessel's number stands twice"),
        ({"dim_mat": np.array([[7.0, 10, 1], [3, 0, 1], [5, 1, 1]])}, "dim_mat row 2 (vessel '3'): length 0 cm"),
    ):
        assert words in said(read, **changes)


EDGES = "type,ID,start_node,end_node,start_diameter[SI],end_diameter[SI],length[SI]\n"


def test_edges_between_nodes_are_vessels(tmp_path):
    text = EDGES + "vis,A1,n1,n2,0.002,0.0016,0.01\nvis_f,A2,n2,n3,0.001,0.001,0.02\nvis,A3,n2,n4,0.001,0.001,0.03\n"
    path = file(tmp_path, text + "\ntype,ID\nheart,n1\nnode,n2\nperif,n3\nperif,n4\n")
    network, (left,) = read_edges(path, 1.0)
    assert (network.name, network.parent.tolist()) == (("A1", "A2", "A3"), [-1, 0, 0])
    assert network.length == pytest.approx([1, 2, 3])
    assert network.radius == pytest.approx([0.09, 0.05, 0.05])
    assert network.taper == pytest.approx([0.02, 0, 0])
    assert str(left).startswith("rows of the types heart, node, perif, walls and beds are no part")
    assert str(read_edges(file(tmp_path, text), 1.0)[1][0]).startswith("walls and beds are no part")
    assert is_edges(path, EDGES.encode())
    assert not is_edges(path, EDGES.replace("ID", "name").encode())


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (EDGES.replace(",end_node", ""), ", line 1: no column 'end_node'; the columns of a table of edges are type,"),
        (EDGES + "vis,A1,n1,n2,0.002,0.0016\n", ", line 2: 6 cells for 7 columns"),
        (EDGES + "vas,A1,n1,n2,1,1,1\n", ", line 2: a row of type 'vas'; known are vis, vis_f, heart, node, perif"),
        (EDGES + "heart,n1\n", ": has no vessel (a row of type vis or vis_f)"),
        (EDGES + "vis,A1,n1,n2,0.002,x,0.01\n", ", line 2: 'x' is not a number"),
        (EDGES + "vis,A1,n1,n2,0.002,0.002,0.01\nperif,n2\nperif,n3\n", ": node 'n3' is a bed in which no vessel"),
        (EDGES + "vis,A1,n1,n2,0.002,0.002,0.01\nperif,n1\n", ": node 'n1' is a bed in which no vessel ends"),
        (EDGES + "vis,A1,n1,n2,0.002,0.002,0.01\n\nvis,A2,n2,n3,0.002,0.002,0\n", ", line 4 (vessel 'A2'): length 0"),
    ],
)  # fmt: skip
def test_edges_that_are_none_are_refused_with_their_line(tmp_path, text, words):
    assert said(read_edges, file(tmp_path, text), 1.0).partition("n.csv")[2].startswith(words)


SEGMENT = "SEGMENT {0} {1} {2} 50 {3} {4} {5} {5} 0.0 MAT1 NONE 0.0 0 0 NOBOUND NONE\n"
CARDS = "MODEL m\n# x\nMATERIAL MAT1 OLUFSEN 1\n" + "".join(
    SEGMENT.format(name, row, row + 1, row, row + 1, 0.01 * np.pi) for row, name in enumerate("abc")
)
JOINTS = (
    "JOINT J1 1 IN0 OUT0\nJOINTINLET IN0 1 0\nJOINTOUTLET OUT0 2 1 2\nDATATABLE d\n0.0 1.0\nENDDATATABLE\n"
)  # fmt: skip


def test_segments_are_joined_by_joints_or_else_by_nodes(tmp_path):
    network, (left,) = read_input(file(tmp_path, CARDS + JOINTS, "a.in"), 1.0)
    assert (network.name, network.parent.tolist()) == (("a", "b", "c"), [-1, 0, 0])
    assert network.length == pytest.approx([1, 2, 3])
    assert network.radius == pytest.approx(0.1)
    assert str(left) == "walls, inflow and beds are no part of a network and were left out"
    chain, _ = read_input(file(tmp_path, CARDS, "a.in"), 1.0)
    assert chain.parent.tolist() == [-1, 0, 1]
    taper, found = read_input(file(tmp_path, f"SEGMENT a 0 2 5 0 1 {0.04 * np.pi} {0.01 * np.pi}\n", "a.in"), 1.0)
    assert (taper.taper.tolist(), taper.radius.tolist(), found) == ([pytest.approx(0.05)], [pytest.approx(0.15)], [])
    assert is_input(tmp_path / "a.IN", b"NODE 1")
    assert not is_input(tmp_path / "a.txt", b"NODE 1")
    assert not is_input(tmp_path / "a.in", b"x")


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("MODEL m\n", ": has no SEGMENT; is it an input of svOneDSolver?"),
        ("MODEL m\nSEGMNT a\n", ", line 2: 'SEGMNT' is no card of svOneDSolver; write the file again"),
        ("SEGMENT a 0 1 5 0 1 0.1\n", ", line 1: a SEGMENT of 7 words; name, number, length, elements"),
        ("SEGMENT a 0.5 1 5 0 1 0.1 0.1\n", ", line 1: '0.5' is not a whole number"),
        ("SEGMENT a 0 x 5 0 1 0.1 0.1\n", ", line 1: 'x' is not a number"),
        ("SEGMENT a 0 1 5 0 1 0.1 0\n", ", line 1: segment 'a' has areas 0.1 and 0 cm²"),
        ("SEGMENT a 0 1 5 0 1 0 0.1\n", ", line 1: segment 'a' has areas 0 and 0.1 cm²"),
        ("SEGMENT a 0 1 5 0 inf 0.1 0.1\n", ", line 1: 'inf' is not a whole number"),
        (CARDS + "JOINT J1 1 IN0\n", ", line 7: the line ends too early; write the file again"),
        (CARDS + JOINTS.replace("OUT0 2 1 2", "OUT0 3 1 2"), ", line 9: JOINTOUTLET says 3 segments and lists 2"),
        (CARDS + JOINTS.replace("OUT0 2 1 2", "OUT0 2 1 9"), ": the joint of IN0 and OUT0 needs known segments that"),
        (CARDS + JOINTS.replace("IN0 1 0\n", "IN0 0\n"), ": the joint of IN0 and OUT0 needs known segments that end"),
        (CARDS + JOINTS + "JOINT J2 1 IN1 OUT1\nJOINTINLET IN1 1 0\nJOINTOUTLET OUT1 1 2\n", ": segment 0 ends in two"),
    ],
)  # fmt: skip
def test_an_input_that_is_damaged_is_refused_with_its_line(tmp_path, text, words):
    assert said(read_input, file(tmp_path, text, "a.in"), 1.0).partition("a.in")[2].startswith(words)


def test_sizes_of_another_unit_or_a_slip_are_remarked_at_their_limits():
    def codes(length, radius):
        found = implausible_sizes(Network(tuple("abc"), [-1, 0, 0], length, radius))
        return [one.code.partition(".")[2] for one in found]

    assert codes([1.0, 1, 1], [0.1, 0.05, 0.06]) == []
    assert codes([0.151, 0.151, 0.151], [0.1, 0.1, 0.1]) == []
    assert len(codes([0.149, 0.149, 0.149], [0.1, 0.1, 0.1])) == 1
    assert len(codes([15.1, 15.1, 15.1], [0.1, 0.1, 0.1])) == 1
    assert codes([0.1, 0.1, 0.1], [0.004, 0.003, 0.003]) == []
    assert len(codes([0.1, 0.1, 0.1], [0.0039, 0.003, 0.003])) == 1
    assert codes([9.0, 9, 9], [2.0, 1, 1]) == []
    assert len(codes([9.0, 9, 9], [2.01, 1, 1])) == 1
    (wide,) = implausible_sizes(Network(tuple("abc"), [-1, 0, 0], [1.0, 1, 1], [0.03, 0.05, 0.2]))
    assert "vessel 'c' is 6.7 times as wide as its parent (0.2 cm after 0.03 cm)" in str(wide)
    assert [one.code for one in unknown_pressure(Network(("a",), [-1], [1.0], [0.1]))] == ["network.pressure-unknown"]
    assert unknown_pressure(Network(("a",), [-1], [1.0], [0.1], pressure=1.0)) == []


def test_a_root_that_no_animal_of_the_species_has_says_which_unit_would_be_right():
    low, high = SPECIES["mouse"].root_radius

    def words(radius, unit=None, species="mouse"):
        return unlike_the_species(Network(("a",), [-1], [20 * radius], [radius]), species, unit)

    assert words(low) == words(high) == ""
    assert words(9.9 * high, species="other") == ""
    assert "the voxel size is wrong, probably by a factor of" in words(1.01 * high)
    assert "the voxel size is wrong" in words(0.99 * low)
    assert "the unit is probably mm" in words(10 * 0.5 * (low + high), 1.0)
    assert "the numbers are probably voxels; give the size of one in cm as the unit" in words(100 * high, 1.0)
    assert f"{low / (2 * high):.2g} to {high / (2 * high):.2g}" in words(2 * high)


def test_a_short_vessel_hands_its_resistance_and_compliance_to_its_daughters():
    whole = Network(
        tuple("xabcde"), [-1, 0, 1, 2, 2, 0], [1.0, 1.0, 0.005, 0.5, 0.4, 1.0], [0.2, 0.1, 0.08, 0.05, 0.06, 0.1]
    )
    found = tidy(whole)
    assert [one.code for one in found.repairs] == ["joined"]
    (joined,) = found.repairs
    assert str(joined) == "nothing divides between 'a' and 'b' (0.005 cm); both are 'a' now"
    R, C = 1 / 0.1**4 + 0.005 / 0.08**4, 0.1**2 + 0.005 * 0.08**2
    radius = (C / R) ** (1 / 6)
    assert found.network.radius[1] == pytest.approx(radius)
    assert found.network.length[1] == pytest.approx(C / radius**2)
    assert (found.added_volume, tidy(whole, 0.0, alike=-1.0).repairs) == (0.0, ())
    fork = Network(
        tuple("abcdef"), [-1, 0, 0, 1, 1, 0], [1.0, 0.005, 1, 0.5, 0.4, 1], [0.2, 0.08, 0.1, 0.05, 0.06, 0.1]
    )
    (merged,) = tidy(fork).repairs
    assert (merged.code, merged.into, merged.shortest) == ("merged", "d", pytest.approx(0.02))
    after = tidy(fork).network
    g = np.array([0.05**4 / 0.5, 0.06**4 / 0.4])
    for name, share, length, r in (("d", g[0] / g.sum(), 0.5, 0.05), ("e", g[1] / g.sum(), 0.4, 0.06)):
        row = after.row(name)
        R, C = length / r**4 + 0.005 / 0.08**4 / share, length * r**2 + 0.005 * 0.08**2 * share
        assert after.length[row] / after.radius[row] ** 4 == pytest.approx(R)
        assert after.length[row] * after.radius[row] ** 2 == pytest.approx(C)
    assert after.parent.tolist() == [-1, 0, 0, 0, 0]
    assert said(tidy, fork, -0.1) == "the shortest vessel, -0.1 radii, must be a number of at least 0"
    assert said(tidy, fork, np.nan).startswith("the shortest vessel, nan radii")


def test_ends_that_are_too_short_are_lengthened_and_the_volume_is_told():
    network = Network(tuple("abc"), [-1, 0, 0], [1.0, 0.001, 1.0], [0.1, 0.08, 0.06])
    found = tidy(network)
    (one,) = found.repairs
    assert (one.code, one.length, one.radius, one.shortest) == ("lengthened", 0.001, 0.08, pytest.approx(0.02))
    assert found.network.length[1] == pytest.approx(0.02)
    before = 0.01 + 0.001 * 0.0064 + 0.0036
    assert found.added_volume == pytest.approx(0.019 * 0.0064 / before)
    adds = f"{100 * found.added_volume:.2g}"
    assert found.summary().endswith(f"were repaired (1 lengthened, which adds {adds} % of its volume)")
    assert found.added_volume < LOST
    fixed, (told,) = repaired(network)
    assert fixed.length[1] == pytest.approx(0.02)
    assert str(told).startswith("1 vessels of the network were repaired (1 lengthened")
    wide = Network(tuple("abc"), [-1, 0, 0], [1.0, 0.001, 1.0], [0.1, 0.2, 0.06])
    same, (told,) = repaired(wide)
    assert same is wide
    assert "repairing them would add" in str(told)
    fine = Network(tuple("ab"), [-1, 0], [1.0, 1.0], [0.1, 0.1])
    assert repaired(fine) == (fine, [])
    many = Network(tuple("abcdefg"), [-1, *[0] * 6], [9.0, *[0.001] * 6], [0.5, *[0.05] * 6])
    assert str(repaired(many)[1][0]).count(";") >= 5
    assert "and 2 more" in str(repaired(many)[1][0])


def test_whatever_a_file_gives_and_no_network_takes_is_listed(tmp_path):
    more = EDGES.replace("length[SI]\n", "length[SI],k1[SI],k2[SI]\n") + "vis,A1,n1,n2,0.002,0.002,0.01,3,\n"
    _, (columns, _) = read_edges(file(tmp_path, more), 1.0)
    assert str(columns) == "columns k1[SI]: given and not used, as no part of a network"
    loss = "SEGMENT a 0 2 5 0 1 0.04 0.04 0.0 MAT1 STENOSIS 0.0 0 0 NOBOUND NONE\n"
    _, (found,) = read_input(file(tmp_path, loss, "a.in"), 1.0)
    assert str(found).startswith("STENOSIS of SEGMENT a: given and not used")
    table = "name,parent,length [cm],radius [cm],tapr [cm/cm],doubts,empty\n1,,1,0.1,0.01,x,\n2,1,1,0.1,0.01,,\n"
    _, (first, *_) = read_vessel_table(file(tmp_path, table + "3,1,1,0.1,0,,\n"))
    assert str(first).startswith("column 'tapr' (did you mean 'taper'?): given and not used")
