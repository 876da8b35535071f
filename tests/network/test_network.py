import warnings

import numpy as np
import pytest

import vasowave as vw
from vasowave.datasets import control_network, hypertensive_network
from vasowave.errors import InputError, VasowaveWarning
from vasowave.model.model import Model
from vasowave.model.outlets import Resistance
from vasowave.model.walls import LinearWall
from vasowave.network.network import Network
from vasowave.network.vessel_table import write_network
from vasowave.network_formats import read_network

HEADER = "name,parent,length [cm],radius [cm]\n"


def table(folder, rows, header=HEADER):
    path = folder / "network.csv"
    path.write_text(header + rows, encoding="utf-8")
    return path


@pytest.mark.parametrize(
    ("rows", "message"),
    [
        ("a,b,0.4,0.04\nb,a,0.4,0.04\n", r"network\.csv, line 2: no root"),
        ("a,,0.4,0.04\nb,,0.4,0.04\n", r"'a' \(.*line 2\), 'b' \(.*line 3\)"),
        ("a,,0.4,0.04\nb,c,0.4,0.04\nc,b,0.4,0.04\n", r"line 3 \(vessel 'b'\).*cycle"),
        ("trunk,,0.4,0.04\nb,trnk,0.4,0.04\n", r"line 3 .*'trnk'.*did you mean 'trunk'"),
        ("10,0,0.4,0.04\nb,10,0.4,0.04\n", r"line 2 .*parent '0' is not in the table; leave the root's parent empty"),
        ("1,,0.4,0.04\n2,1,0.4,0.04\n2,1,0.4,0.04\na,3,0.4,0.04\n", r"'3' is not in the table; '2' stands there twice"),
        ("a,,0.4,0.04\nb,a,0.4,0.04\nb,a,0.4,0.04\n", r"line 4: vessel 'b' is already defined in .*line 3"),
        ("a,,0.4,0.04\nb,a,0,0.04\n", r"line 3 \(vessel 'b'\): length 0 cm"),
        ("a,,0.4,0.04\nb,a,0.4,-0.04\n", r"line 3 \(vessel 'b'\): radius -0\.04 cm"),
        ("a,,0.4,0.04\nb,a,long,0.04\n", r"line 3, column 'length': 'long' is not a number"),
        ("# scan 6\n\na,,0.4,0.04\nb,a,0.4,-1\n", r"line 5 "),
    ],
    ids=[
        "no root",
        "two roots",
        "cycle",
        "unknown",
        "none by zero",
        "number given twice",
        "duplicate",
        "zero",
        "negative",
        "text",
        "comments",
    ],
)
def test_a_wrong_row_is_named_by_its_line(tmp_path, rows, message):
    with pytest.raises(InputError, match=message):
        read_network(table(tmp_path, rows))


def test_in_memory_errors_name_the_row():
    with pytest.raises(InputError, match=r"row 2 \(vessel 'b'\): radius nan cm"):
        Network(("a", "b"), [-1, 0], [1.0, 1.0], [0.1, np.nan])


@pytest.mark.parametrize(
    ("header", "message"),
    [
        ("name,parent,length [mmHg],radius [cm]\n", "column 'length'.*mmHg"),
        ("name,parent,length [cm],radius\n", "column 'radius' has no unit"),
        ("gefäß,eltern,länge,radius\n", r"no column 'name'; .*gefäß.*the titles name, parent, length \[cm\], radius"),
    ],
)
def test_a_missing_column_or_unit_or_a_wrong_one_is_an_error_naming_it(tmp_path, header, message):
    with pytest.raises(InputError, match=message):
        read_network(table(tmp_path, "a,,0.4,0.04\n", header))


def test_a_vessel_four_times_as_wide_as_its_parent_is_named_and_one_as_wide_is_not(tmp_path):
    header = "name,parent,length [cm],radius [cm]\n"
    with pytest.warns(VasowaveWarning, match=r"vessel 'b' is 4 times as wide as its parent \(0.16 cm after 0.04 cm\)"):
        read_network(table(tmp_path, "a,,0.4,0.04\nb,a,0.5,0.16\nc,a,0.4,0.04\n", header))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        read_network(table(tmp_path, "a,,0.4,0.04\nb,a,0.5,0.07\nc,a,0.4,0.04\n", header))


def test_a_radius_in_mm_that_is_declared_in_cm_warns(tmp_path):
    with pytest.warns(VasowaveWarning, match="radius"):
        read_network(table(tmp_path, "a,,0.41,0.47\n"))


def test_a_diameter_is_twice_the_radius(tmp_path):
    (tmp_path / "n.csv").write_text(
        "name,parent,length [mm],Diameter [mm]\nmain,,4,1\nleft,main,3,0.6\nright,main,3,0.5\n"
    )
    assert vw.read_network(tmp_path / "n.csv").radius.tolist() == pytest.approx([0.05, 0.03, 0.025])
    (tmp_path / "n.csv").write_text("name,parent,length [mm],diameter [mm],radius [mm]\nmain,,4,1,0.5\n")
    with pytest.raises(InputError, match="both 'radius' and 'diameter'"):
        vw.read_network(tmp_path / "n.csv")


def test_a_unit_behind_a_low_line_is_told_where_it_belongs(tmp_path):
    (tmp_path / "n.csv").write_text("name,parent,length_mm,radius_mm\nmain,,4,0.5\n")
    with pytest.raises(InputError, match=r"write 'length_mm' as 'length \[mm\]'"):
        vw.read_network(tmp_path / "n.csv")


def test_millimetres_are_converted_to_centimetres(tmp_path):
    network = read_network(table(tmp_path, "a,,4.1,0.47\n", "name,parent,length [mm],radius [mm]\n"))
    assert network.length[0] == pytest.approx(0.41, rel=1e-14)
    assert network.radius[0] == pytest.approx(0.047, rel=1e-14)


@pytest.mark.parametrize("published", [control_network, hypertensive_network])
def test_a_network_survives_csv_to_the_last_bit(tmp_path, published):
    before = published()
    write_network(before, tmp_path / "copy.csv")
    after = read_network(tmp_path / "copy.csv")
    assert after.name == before.name
    for field in ("parent", "length", "radius"):
        np.testing.assert_array_equal(getattr(after, field), getattr(before, field))


LOOP = [[0, 1], [1, 2], [1, 3], [2, 4], [3, 4], [4, 5]]


@pytest.mark.parametrize(
    ("topology", "old", "new", "said"),
    [
        ({"parent": [-1, 0, 0, 2, 2, 1]}, "v5,v1,", "v5,v2,", "4 outlets where the column 'outlets' says 3"),
        ({"nodes": LOOP}, "v4,3,", "v4,x,", "2 outlets where the column 'outlets' says 1"),
        ({"nodes": LOOP}, "v2,1,", "v2,7,", "2 inlets where the column 'inlets' says 1"),  # as many outlets as before
    ],
)
def test_a_vessel_that_begins_elsewhere_is_noticed_by_the_counts_of_ends(tmp_path, topology, old, new, said):
    names, path = tuple(f"v{row}" for row in range(6)), tmp_path / "n.csv"
    write_network(Network(names, **({"parent": None, "length": [0.4] * 6, "radius": [0.03] * 6} | topology)), path)
    read_network(path)  # without a word
    whole = path.read_text(encoding="utf-8")
    assert whole.count(old) == 1
    path.write_text(whole.replace(old, new), encoding="utf-8")
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        read_network(path)
    assert any(said in str(one.message) for one in caught)


@pytest.mark.parametrize("published", [control_network, hypertensive_network])
def test_the_published_networks_have_21_vessels_and_11_terminals_that_share_the_flow(published):
    network = published()
    assert len(network) == 21
    assert len(network.terminals) == 11
    assert network.flow_fraction[network.terminals].sum() == pytest.approx(1, rel=1e-12)


def test_flow_divides_at_a_junction_as_r4_over_length():
    network = Network(("b", "root", "c"), [1, -1, 1], [1.0, 2.0, 2.0], [0.2, 0.3, 0.1])
    # r^4/L: 16e-4 and 0.5e-4, so 32/33 and 1/33 of the flow
    np.testing.assert_allclose(network.flow_fraction, [32 / 33, 1, 1 / 33], rtol=1e-12)


def test_what_is_known_of_radii_and_tapers_comes_back_to_the_last_bit(tmp_path):
    known = {
        "radius_sd": [0.001, np.nan, 0.002],
        "taper": [0.0123456789, -0.02, np.nan],
        "taper_sd": [np.nan, 0.003, np.nan],
    }
    network = Network(("a", "b", "c"), [-1, 0, 0], [0.4, 0.3, 0.2], [0.04, 0.03, 0.03], pressure=6.3, **known)
    write_network(network, tmp_path / "network.csv")
    found = read_network(tmp_path / "network.csv")
    for field, values in known.items():
        np.testing.assert_array_equal(getattr(found, field), values)


def test_tapers_have_units_and_may_be_left_empty(tmp_path):
    header = "name,parent,length [mm],radius [mm],radius_sd [um],taper [um/mm]\n"
    found = read_network(table(tmp_path, "a,,4,0.4,12,30\nb,a,3,0.3,,\nc,a,3,0.3,7,-5\n", header))
    np.testing.assert_allclose(found.radius_sd, [12e-4, np.nan, 7e-4])
    np.testing.assert_allclose(found.taper, [0.03, np.nan, -0.005])
    assert found.taper_sd is None


def test_a_radius_at_the_outlet_is_a_taper_about_the_middle(tmp_path):
    header = "name,parent,length [mm],radius [mm],radius end [um]\n"
    found = read_network(table(tmp_path, "a,,4,0.5,300\nb,a,3,0.3,\nc,a,2,0.2,300\n", header))
    np.testing.assert_allclose(found.radius, [0.04, 0.03, 0.025])
    np.testing.assert_allclose(found.taper, [0.05, np.nan, -0.05])
    inlet, outlet = (Model(found, LinearWall(60.0), Resistance([1.0, 1.0])).at([0, 1, 2], share)[1] for share in (0, 1))
    np.testing.assert_allclose(np.sqrt(inlet / np.pi), [0.05, 0.03, 0.02])
    np.testing.assert_allclose(np.sqrt(outlet / np.pi), [0.03, 0.03, 0.03])


@pytest.mark.parametrize(
    ("header", "row", "message"),
    [
        ("radius end [cm]", "0", r"line 2 \(vessel 'a'\): taper 0\.1 is not possible"),
        ("radius end [cm],taper [cm/cm]", "0.03,0.01", "both 'radius end' and 'taper'"),
        ("radius end", "0.03", "column 'radius end' has no unit"),
    ],
)
def test_an_outlet_that_is_none_is_refused(tmp_path, header, row, message):
    with pytest.raises(InputError, match=message):
        read_network(table(tmp_path, f"a,,0.4,0.04,{row}\n", f"name,parent,length [cm],radius [cm],{header}\n"))


@pytest.mark.parametrize(
    ("row", "message"),
    [
        ("b,a,0.4,0.03,0.2,0.01", r"line 3 \(vessel 'b'\): taper 0\.2 is not possible"),  # 0.04 at one end, -0.01
        ("b,a,0.4,0.03,0.02,0", r"line 3 \(vessel 'b'\): taper_sd 0 is not possible"),
        ("b,a,0.4,0.03,steep,0.01", r"line 3, column 'taper': 'steep' is not a number"),
    ],
)
def test_an_impossible_taper_is_named_by_its_line(tmp_path, row, message):
    header = "name,parent,length [cm],radius [cm],taper [cm/cm],taper_sd [cm/cm]\n"
    with pytest.raises(InputError, match=message):
        read_network(table(tmp_path, f"a,,0.4,0.04,,\n{row}\n", header))


def test_the_pressure_of_a_table_is_that_of_all_its_rows_or_refused_with_the_row_that_differs(tmp_path):
    head = "name,parent,length [cm],radius [cm],pressure [mmHg]\n"
    (tmp_path / "one.csv").write_text(head + "a,,0.4,0.04,6.3\n")
    assert read_network(tmp_path / "one.csv").pressure == 6.3
    (tmp_path / "two.csv").write_text(head + "a,,0.4,0.04,6.3\nb,a,0.4,0.03,6.3\nc,a,0.4,0.03,6.4\n")
    with pytest.raises(InputError, match=r"line 4.*: pressure 6\.4 mmHg, but 6\.3 mmHg in the first row"):
        read_network(tmp_path / "two.csv")


@pytest.mark.parametrize(
    ("field", "value", "said"),
    [("radius", 1e-200, "1e-200"), ("radius", 5e-6, "5e-06"), ("radius", 20.0, "20"), ("length", 4e8, "4e\\+08")],
)
def test_a_size_that_no_animal_has_is_refused_with_its_row(field, value, said):
    sizes = {"length": [0.4, 0.4], "radius": [0.05, 0.04]}
    sizes[field][1] = value
    with pytest.raises(InputError, match=rf"row 2 \(vessel 'b'\): {field} {said} cm is no animal's.*unit"):
        Network(("a", "b"), [-1, 0], **sizes)


@pytest.mark.parametrize(("length", "radius"), [(1e-4, 1e-4), (600.0, 11.5)])
def test_an_arteriole_of_a_micrometer_and_a_whales_aorta_are_networks(length, radius):
    assert len(Network(("a",), [-1], [length], [radius])) == 1


@pytest.mark.parametrize(
    ("nodes", "why"),
    [(None, "give the row of each vessel's parent, or nodes"), ([[0, 1], [1, 2.7]], "whole numbers"),
     ([["heart", "lung"], ["lung", "out"]], "nodes are numbers")],
)  # fmt: skip
def test_a_network_in_memory_needs_parents_or_nodes_that_are_numbers(nodes, why):
    with pytest.raises(InputError, match=why):
        vw.Network(("a", "b"), None, [1.0, 1.0], [0.1, 0.1], nodes=nodes)


@pytest.mark.parametrize(
    ("parents", "why"),
    [([-1, 0.7], "parents are whole numbers"), ([np.nan, 0], "parents are whole numbers"),
     ([-1, 1e308], "parents are whole numbers"), (["", "a"], "parents are numbers, one per vessel: the row of")],
)  # fmt: skip
@pytest.mark.filterwarnings("error")
def test_parents_that_are_no_rows_are_refused_and_not_rounded(parents, why):
    with pytest.raises(InputError, match=why):
        vw.Network(("a", "b"), parents, [1.0, 1.0], [0.1, 0.1])
