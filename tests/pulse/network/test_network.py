import warnings

import numpy as np
import pytest

from vasowave.base import InputError, VasowaveWarning
from vasowave.pulse.examples import control_network, hypertensive_network
from vasowave.pulse.model import LinearWall, Model, Resistance
from vasowave.pulse.network import Network, write_network
from vasowave.pulse.network_formats import read_network

HEADER = "name,parent,length [cm],radius [cm]\n"


TAPERED = "name,parent,length [cm],radius [cm],taper [cm/cm],taper_sd [cm/cm]\na,,0.4,0.04,,\n"
PRESSED = "name,parent,length [cm],radius [cm],pressure [mmHg]\n"
ENDED = "name,parent,length [cm],radius [cm],radius end [cm]"


def table(folder, rows, header=HEADER):
    path = folder / "network.csv"
    path.write_text(header + rows, encoding="utf-8")
    return path


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (HEADER + "a,b,0.4,0.04\nb,a,0.4,0.04\n", r"network\.csv, line 2: no root"),
        (HEADER + "a,,0.4,0.04\nb,,0.4,0.04\n", r"'a' \(.*line 2\), 'b' \(.*line 3\)"),
        (HEADER + "a,,0.4,0.04\nb,c,0.4,0.04\nc,b,0.4,0.04\n", r"line 3 \(vessel 'b'\).*cycle"),
        (HEADER + "trunk,,0.4,0.04\nb,trnk,0.4,0.04\n", r"line 3 .*'trnk'.*did you mean 'trunk'"),
        (HEADER + "10,7,0.4,0.04\nb,10,0.4,0.04\n", r"line 2 .*parent '7' is not in the table"),
        (HEADER + "1,,0.4,0.04\n2,1,0.4,0.04\n2,1,0.4,0.04\na,3,0.4,0.04\n", r"'3' is not .*; '2' stands there twice"),
        (HEADER + "a,,0.4,0.04\nb,a,0.4,0.04\nb,a,0.4,0.04\n", r"line 4: vessel 'b' is already defined in .*line 3"),
        (HEADER + "a,,0.4,0.04\nb,a,0,0.04\n", r"line 3 \(vessel 'b'\): length 0 cm"),
        (HEADER + "a,,0.4,0.04\nb,a,long,0.04\n", r"line 3, column 'length': 'long' is not a number"),
        (HEADER + "# scan 6\n\na,,0.4,0.04\nb,a,0.4,-1\n", r"line 5 \(vessel 'b'\): radius -1 cm"),
        ("1,2\n3,4\n", r"no header; the first line must read: name, parent, length \[cm\], radius \[cm\]"),
        ("name,parent,length [mmHg],radius [cm]\na,,1,1\n", "column 'length'.*mmHg"),
        ("name,parent,length [cm],radius\na,,1,1\n", "column 'radius' has no unit"),
        ("name,parent,length_mm,radius_mmHg\na,,4,1\n", "'mmHg' is not a unit of length"),
        ("gefäß,vorfahr,länge,radius\na,,1,1\n", r"no column .parent.; .*vorfahr.*titles name, parent, length \[cm\]"),
        ("name,parent,length [mm],diameter [mm],radius [mm]\na,,4,1,0.5\n", "both 'radius' and 'diameter'"),
        ("name,from,to,parent,length [cm],radius [cm]\na,1,2,,1,0.1\n", "both 'parent' and 'from', 'to' say"),
        (TAPERED + "b,a,0.4,0.03,0.2,0.01\n", r"line 3 \(vessel 'b'\): taper 0\.2 is not possible"),
        (TAPERED + "b,a,0.4,0.03,0.02,0\n", r"line 3 \(vessel 'b'\): taper_sd 0 is not possible"),
        (ENDED + "\na,,0.4,0.04,0\n", r"line 2 \(vessel 'a'\): taper 0\.1 is not possible"),
        (ENDED + ",taper [cm/cm]\na,,0.4,0.04,0.03,0.01\n", "both 'radius end' and 'taper'"),
        (PRESSED + "a,,0.4,0.04,6.3\nb,a,0.4,0.03,6.4\n", r"line 3.*: pressure 6\.4 mmHg, but 6\.3 mmHg in the first"),
        (PRESSED + "a,,0.4,0.04,500\n", "line 2: pressure of the image 500"),
    ],
)  # fmt: skip
def test_a_table_that_is_no_network_is_refused_with_its_line(tmp_path, text, message):
    with pytest.raises(InputError, match=message):
        read_network(table(tmp_path, text, ""))


@pytest.mark.filterwarnings("ignore::vasowave.base.errors.VasowaveWarning")  # of a single daughter
def test_a_table_may_have_other_units_diameters_ends_and_empty_cells(tmp_path):
    text = "vessel;parent;l [mm];d [um];radius_end [mm];radius_sd [um];pressure [kPa]\n"
    found = read_network(table(tmp_path, text + "a;;10;2000;0,8;;1\nb;a;20;1600;;50;1\n", ""))
    assert found.length == pytest.approx([1, 2])
    assert found.radius == pytest.approx([0.09, 0.08])
    assert found.taper == pytest.approx([0.02, np.nan], nan_ok=True)
    assert found.radius_sd == pytest.approx([np.nan, 0.005], nan_ok=True)
    assert found.pressure == pytest.approx(7.50062, rel=1e-5)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"parent": None}, "give the row of each vessel's parent, or nodes"),
        ({"parent": [-1, 0.7]}, "parents are whole numbers"),
        ({"parent": [np.nan, 0]}, "parents are whole numbers"),
        ({"parent": ["", "a"]}, "parents are numbers, one per vessel: the row of"),
        ({"parent": None, "nodes": [[0, 1], [1, 2.7]]}, "whole numbers"),
        ({"parent": None, "nodes": [["heart", "lung"], ["lung", "out"]]}, "nodes are numbers"),
        ({"parent": [-1]}, r"2 names but parent has shape \(1,\); give one value per vessel"),
        ({"name": ("a", " ")}, "row 2: the vessel has no name"),
        ({"name": ("a", " =c")}, "row 2: ' =c' is not a name of a vessel: a spreadsheet would run it; rename"),
        ({"name": ("@d", "b")}, "row 1: '@d' is not a name of a vessel"),
        ({"radius": [0.05, np.nan]}, r"row 2 \(vessel 'b'\): radius nan cm"),
        ({"radius": [0.05, 5e-6]}, r"row 2 \(vessel 'b'\): radius 5e-06 cm is no animal's.*unit"),
        ({"length": [0.4, 4e8]}, r"row 2 \(vessel 'b'\): length 4e\+08 cm is no animal's.*unit"),
    ],
)
@pytest.mark.filterwarnings("error")
def test_a_network_in_memory_that_cannot_be_is_refused_with_row_and_vessel(changes, words):
    given = {"name": ("a", "b"), "parent": [-1, 0], "length": [0.4, 0.4], "radius": [0.05, 0.04]}
    with pytest.raises(InputError, match=words):
        Network(**(given | changes))


@pytest.mark.parametrize(("length", "radius"), [(1e-4, 1e-4), (600.0, 11.5)], ids=["arteriole", "whale's aorta"])
def test_the_smallest_and_the_largest_vessels_of_animals_are_networks(length, radius):
    assert len(Network(("a",), [-1], [length], [radius])) == 1


def test_a_network_says_what_it_is():
    tree = Network(tuple("abcd"), [-1, 0, 0, 1], [0.75, 0.55, 0.35, 0.3], [0.047, 0.037, 0.026, 0.024], pressure=5.0)
    assert repr(tree) == "Network(4 vessels, 2 terminals, root 'a' r0 0.047 cm, total length 1.95 cm)"
    assert tree.to_dataframe()["parent"].tolist() == ["", "a", "a", "b"]
    with pytest.raises(InputError, match="the network has no vessel 'x'"):
        tree.row("x")


@pytest.mark.parametrize(("vessel", "factor", "named"), [(3, 10.0, True), (16, 10.0, True), (3, 2.0, False)])
def test_a_vessel_that_is_ten_times_too_long_is_named_and_twice_is_not(tmp_path, vessel, factor, named):
    network = control_network()
    length = network.length.copy()
    length[vessel] *= factor
    write_network(network.resized(length=length), tmp_path / "network.csv")
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        read_network(tmp_path / "network.csv")
    texts = [str(warning.message) for warning in caught if "radii long" in str(warning.message)]
    assert [f"vessel '{network.name[vessel]}'" in text for text in texts] == [True] * named


def test_a_vessel_four_times_as_wide_as_its_parent_is_named_and_one_as_wide_is_not(tmp_path):
    header = "name,parent,length [cm],radius [cm]\n"
    with pytest.warns(VasowaveWarning, match=r"vessel 'b' is 4 times as wide as its parent \(0.16 cm after 0.04 cm\)"):
        read_network(table(tmp_path, "a,,0.4,0.04\nb,a,0.5,0.16\nc,a,0.4,0.04\n", header))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        read_network(table(tmp_path, "a,,0.4,0.04\nb,a,0.5,0.07\nc,a,0.4,0.04\n", header))


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


def test_a_vessel_that_is_cut_in_pieces_takes_the_flow_that_it_took_whole():
    whole = Network(("root", "b", "c"), [-1, 0, 0], [1.0, 2.0, 2.0], [0.3, 0.2, 0.1])
    lengths, radii = [0.4, 1.0, 0.1, 2.0, 1.5], [0.1, 0.3, 0.1, 0.2, 0.1]
    pieces = Network(("c3", "root", "c1", "b", "c2"), [4, -1, 1, 1, 2], lengths, radii)
    np.testing.assert_allclose(pieces.flow_fraction, whole.flow_fraction[[2, 0, 2, 1, 2]], rtol=1e-12)
    wider = Network(("root", "b", "c1", "c2"), [-1, 0, 0, 2], [1.0, 2.0, 1.0, 1.0], [0.3, 0.2, 0.2, 0.1])
    conductance = 0.2**4 / 2.0, 1.0 / (1.0 / 0.2**4 + 1.0 / 0.1**4)
    np.testing.assert_allclose(wider.flow_fraction[1:3], np.divide(conductance, sum(conductance)), rtol=1e-12)


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


def test_a_radius_at_the_outlet_is_a_taper_about_the_middle(tmp_path):
    header = "name,parent,length [mm],radius [mm],radius end [um]\n"
    found = read_network(table(tmp_path, "a,,4,0.5,300\nb,a,3,0.3,\nc,a,2,0.2,300\n", header))
    np.testing.assert_allclose(found.radius, [0.04, 0.03, 0.025])
    np.testing.assert_allclose(found.taper, [0.05, np.nan, -0.05])
    inlet, outlet = (Model(found, LinearWall(60.0), Resistance([1.0, 1.0])).at([0, 1, 2], share)[1] for share in (0, 1))
    np.testing.assert_allclose(np.sqrt(inlet / np.pi), [0.05, 0.03, 0.02])
    np.testing.assert_allclose(np.sqrt(outlet / np.pi), [0.03, 0.03, 0.03])
