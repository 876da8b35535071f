"""Trees as other programs write them, made here with known lengths, radii and connections."""

import json
import math
import warnings

import numpy as np
import pytest

import vasowave as vw
from made_workbook import saved
from vasowave.base import InputError, VasowaveWarning

TREE = {"MPA": (None, 0.41, 0.047), "LPA": ("MPA", 0.44, 0.030), "RPA": ("MPA", 0.37, 0.035),
        "L1": ("LPA", 0.21, 0.020), "L2": ("LPA", 0.18, 0.022)}  # fmt: skip
"""Parent, length and radius of every vessel, cm."""
NODES = {"MPA": (1, 2), "LPA": (2, 3), "RPA": (2, 4), "L1": (3, 5), "L2": (3, 6)}


def written(path, header, row, comment=""):
    """Write a row a vessel: `row` takes the name, the parent, length and radius in cm, and the two nodes."""
    rows = [row(name, parent or "", length, radius, *NODES[name]) for name, (parent, length, radius) in TREE.items()]
    path.write_text("\n".join([comment + header, *rows, ""]), encoding="utf-8")
    return path


def shape(network, row=None):
    """Return length, radius and daughters of every vessel, whatever the vessels are called."""
    row = network.root if row is None else row
    below = sorted(shape(network, daughter) for daughter in network.daughters[row])
    return (round(float(network.length[row]), 6), round(float(network.radius[row]), 6), below)


def expected(name="MPA"):
    _, length, radius = TREE[name]
    return (length, radius, sorted(expected(child) for child, (parent, *_) in TREE.items() if parent == name))


def daughters(name):
    """Return the two cells that name the daughters of a vessel."""
    return ",".join(([child for child, (parent, *_) in TREE.items() if parent == name] + ["", ""])[:2])


def read(path, unit=None):
    """Return a network and the codes of what was found in its file."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", VasowaveWarning)
        network = vw.read_network(path, unit)
    return network, {warning.message.finding.code for warning in caught}


TABLES = {
    "parents-and-diameters": ("Segment,Parent segment,Length (mm),Diameter (mm)",
                              lambda n, p, length, r, a, b: f"{n},{p},{10 * length},{20 * r}"),
    "neo4j": (":START_ID,:END_ID,length_um:float,radius_um:float,:TYPE",
              lambda n, p, length, r, a, b: f"{a},{b},{1e4 * length},{1e4 * r},VESSEL"),
    "signs": ("Ast-Nr;Mutterast;Länge [mm];Ø [µm]",
              lambda n, p, length, r, a, b: f"{n};{p};{10 * length};{2e4 * r}"),
    "decimal-commas": ("ID;Mother;Length [µm];Radius [µm]",
                       lambda n, p, length, r, a, b: f"{n};{p};{1e4 * length:.1f};{1e4 * r:.1f}".replace(".", ",")),
    "units-at-the-end-of-titles": ("vessel_id,parent_id,length_um,diameter_um",
                                   lambda n, p, length, r, a, b: f"{n},{p or -1},{1e4 * length},{2e4 * r}"),
    "mixed-units": ("branch,parent branch,Length (mm),Diameter (um)",
                    lambda n, p, length, r, a, b: f"{n},{p or 'NA'},{10 * length},{2e4 * r}"),
    "daughters": ("Vessel,Daughter 1,Daughter 2,Length (mm),Radius (mm)",
                  lambda n, p, length, r, a, b: f"{n},{daughters(n)},{10 * length},{10 * r}"),
    "source-and-target": ("source,target,length_mm,diameter_mm",
                          lambda n, p, length, r, a, b: f"{a},{b},{10 * length},{20 * r}"),
    "areas": ("Segment,Parent,Length (mm),Area (mm²)",
              lambda n, p, length, r, a, b: f"{n},{p},{10 * length},{100 * math.pi * r * r!r}"),
    "numbers-and-strokes": ("Vessel No.;Parent No.;Length/mm;Radius/mm",
                            lambda n, p, length, r, a, b: f"{n};{p};{10 * length};{10 * r}"),
    "words-without-blanks": ("segmentID,parentID,segmentLength_mm,segmentDiameter_mm",
                             lambda n, p, length, r, a, b: f"{n},{p or 0},{10 * length},{20 * r}"),
    "top-and-bottom": ("Artery,Parent,L (cm),r_top (cm),r_bot (cm)",
                       lambda n, p, length, r, a, b: f"{n},{p},{length},{1.05 * r},{0.95 * r}"),
    "units-in-words": ("edge_id,node_start,node_end,Length in microns,Radius in mm",
                       lambda n, p, length, r, a, b: f"{n},{a},{b},{1e4 * length},{10 * r}"),
    "two-diameters": ("name,parent,length_cm,proximal_diameter_cm,distal_diameter_cm",
                      lambda n, p, length, r, a, b: f"{n},{p},{length},{2.1 * r},{1.9 * r}"),
    "beginning-and-end-in-german": ("Gefäß,Elter,Länge (mm),Radius Anfang (mm),Radius Ende (mm)",
                                    lambda n, p, length, r, a, b: f"{n},{p},{10 * length},{10.5 * r},{9.5 * r}"),
    "initial-and-end": ("No.,Artery,Proximal node,Distal node,Length (cm),Initial radius (cm),End radius (cm)",
                        lambda n, p, length, r, a, b: f"{a}{b},{n},{a},{b},{length},{1.05 * r},{0.95 * r}"),
    "places-of-both-ends": ("Length (mm),Radius (mm),Start_R,Start_A,Start_S,End_R,End_A,End_S",
                            lambda n, p, length, r, a, b: f"{10 * length},{10 * r},{a}.0,0.5,1e-3,{b},0.50,0.001"),
    "places-with-numbers": ("x1,y1,z1,x2,y2,z2,length [mm],radius [mm]",
                            lambda n, p, length, r, a, b: f"{a},0,0,{b},0,0,{10 * length},{10 * r}"),
    "edges-the-other-way": ("node1,node2,length [mm],radius [mm]",
                            lambda n, p, length, r, a, b: f"{b},{a},{10 * length},{10 * r}"),
}  # fmt: skip


@pytest.mark.parametrize("form", TABLES)
def test_tables_of_other_programs_are_the_same_tree(tmp_path, form):
    network, codes = read(written(tmp_path / "tree.csv", *TABLES[form]))
    assert shape(network) == expected()
    assert "network.columns" in codes


def test_titles_in_a_comment_above_the_numbers_are_read(tmp_path):
    def row(name, parent, length, radius, first, last):
        return f"{first} {last} {10 * length} {10 * radius}"

    network, _ = read(written(tmp_path / "tree.txt", "source target length_mm radius_mm", row, "# "))
    assert shape(network) == expected()


def test_titles_of_ours_bring_no_finding_on_columns(tmp_path):
    vw.write_network(vw.control_network(), tmp_path / "ours.csv")
    assert not read(tmp_path / "ours.csv")[1]


def test_columns_without_a_unit_are_asked_for_it_and_read_in_the_unit_that_is_typed(tmp_path):
    path = written(
        tmp_path / "e.csv", "node1,node2,length,radius", lambda n, p, length, r, a, b: f"{a},{b},{10 * length},{10 * r}"
    )
    with pytest.raises(InputError, match=r"does not say the unit of its lengths"):
        vw.read_network(path)
    assert shape(read(path, "mm")[0]) == expected()
    with pytest.raises(InputError, match="says the unit of its lengths itself"):
        vw.read_network(written(tmp_path / "mm.csv", *TABLES["source-and-target"]), "um")


def test_areas_in_the_square_of_the_unit_that_is_typed_are_radii(tmp_path):
    path = written(tmp_path / "a.csv", "name,mother,length,cross-sectional area",
                   lambda n, p, length, r, a, b: f"{n},{p or 0},{10 * length},{100 * math.pi * r * r!r}")  # fmt: skip
    assert shape(read(path, "mm")[0]) == expected()


def test_a_count_of_voxels_is_no_unit(tmp_path):
    path = written(tmp_path / "e.csv", "source,target,length (px),radius (px)",
                   lambda n, p, length, r, a, b: f"{a},{b},{length / 0.004},{r / 0.004}")  # fmt: skip
    with pytest.raises(InputError, match="does not say the unit"):
        vw.read_network(path)
    assert shape(read(path, "0.004 cm")[0]) == expected()


def test_edges_without_a_direction_begin_at_the_widest_end_and_this_is_told(tmp_path):
    network, codes = read(written(tmp_path / "tree.csv", *TABLES["edges-the-other-way"]))
    assert "network.root-taken" in codes
    assert network.radius[network.root] == pytest.approx(0.047)


@pytest.mark.parametrize(
    ("more", "words"),
    [("5,6,2,0.2", "line 7: the edge from '5' to '6' closes a loop"), ("8,9,2,0.2", "2 trees that nothing joins")],
)
def test_edges_that_are_no_tree_are_refused_with_their_line(tmp_path, more, words):
    path = written(tmp_path / "tree.csv", *TABLES["source-and-target"])
    path.write_text(path.read_text(encoding="utf-8") + more + "\n", encoding="utf-8")
    with pytest.raises(InputError, match=words):
        vw.read_network(path)


@pytest.mark.parametrize("mark", ["-", "_"])
def test_the_mean_pixel_value_of_skan_is_no_radius(tmp_path, mark):
    titles = ["skeleton id", "node id src", "node id dst", "branch distance", "branch type", "mean pixel value"]
    path = written(tmp_path / "skan.csv", ",".join(title.replace(" ", mark) for title in titles),
                   lambda n, p, length, r, a, b: f"1,{a},{b},{length},1,{r}")  # fmt: skip
    with pytest.raises(InputError, match=f"mean{mark}pixel{mark}value.*is the mean of the image.*'radius"):
        vw.read_network(path)
    path.write_text(path.read_text().replace(titles[-1].replace(" ", mark), "radius"))
    assert shape(read(path, "cm")[0]) == expected()


def test_the_number_that_holds_the_parents_is_the_name_of_a_vessel(tmp_path):
    number = {name: row for row, name in enumerate(TREE, 1)}
    path = written(tmp_path / "t.csv", "Name,ID,Parent,Length (cm),Radius (cm)",
                   lambda n, p, length, r, a, b: f"{n},{number[n]},{number.get(p, 0)},{length},{r}")  # fmt: skip
    assert shape(read(path)[0]) == expected()


GRAPHML = """<?xml version="1.0" encoding="UTF-8"?>
<graphml xmlns="http://graphml.graphdrawing.org/xmlns">
<key id="a" for="edge" attr.name="{length}" attr.type="double"/><key id="b" for="edge" attr.name="{radius}"
 attr.type="double"/><graph edgedefault="{kind}">{nodes}{edges}</graph></graphml>"""


def graphml(path, kind, length, radius):
    edges = (
        f'<edge source="n{NODES[name][0]}" target="n{NODES[name][1]}"><data key="a">{10 * size}</data>'
        f'<data key="b">{10 * width}</data></edge>'
        for name, (_, size, width) in TREE.items()
    )
    nodes = "".join(f'<node id="n{node}"/>' for node in range(6, 0, -1))
    text = GRAPHML.format(length=length, radius=radius, kind=kind, nodes=nodes, edges="".join(edges))
    path.write_text(text, encoding="utf-8")
    return path


def test_graphml_says_its_unit_in_its_attributes_or_is_asked_for_it(tmp_path):
    named = graphml(tmp_path / "directed.graphml", "directed", "length_mm", "radius_mm")
    assert shape(read(named)[0]) == expected()
    bare = graphml(tmp_path / "bare.graphml", "undirected", "length", "radius_avg")
    with pytest.raises(InputError, match="file does not say the unit"):
        vw.read_network(bare)
    network, codes = read(bare, "mm")
    assert shape(network) == expected()
    assert "network.root-taken" in codes


def gml(path, size="length_mm", width="radius_mm"):
    nodes = "".join(f'  node [ id {node} label "n{node}" ]\n' for node in range(1, 7))
    ends = {name: f"source {NODES[name][0]} target {NODES[name][1]}" for name in TREE}
    edges = "".join(
        f"  edge [ {ends[name]} {size} {10 * length:.6g} {width} {10 * radius:.6g} ]\n"
        for name, (_, length, radius) in TREE.items()
    )
    path.write_text(f'Creator "igraph"\nVersion 1\ngraph\n[\n  directed 1\n{nodes}{edges}]\n', encoding="utf-8")
    return path


def node_link(path, key):
    links = [
        {
            "source": f"n{NODES[name][0]}",
            "target": f"n{NODES[name][1]}",
            "length_mm": 10 * length,
            "radius_mm": 10 * radius,
        }
        for name, (_, length, radius) in TREE.items()
    ]
    nodes = [{"id": f"n{node}"} for node in range(1, 7)]
    content = {"directed": True, "multigraph": False, "graph": {}, "nodes": nodes, key: links}
    path.write_text(json.dumps(content), encoding="utf-8")
    return path


def cytoscape(path):
    content = json.loads(node_link(path, "edges").read_text(encoding="utf-8"))
    elements = {kind: [{"data": entry} for entry in content[kind]] for kind in ("nodes", "edges")}
    path.write_text(json.dumps({"data": [], "directed": True, "elements": elements}), encoding="utf-8")
    return path


def test_gml_and_node_links_are_graphs_as_graphml_is(tmp_path):
    for path in (
        gml(tmp_path / "a.gml"),
        node_link(tmp_path / "a.json", "links"),
        node_link(tmp_path / "b.json", "edges"),
        cytoscape(tmp_path / "c.json"),
    ):
        assert shape(read(path)[0]) == expected()
    with pytest.raises(InputError, match="file does not say the unit"):
        vw.read_network(gml(tmp_path / "b.gml", "length", "radius"))


def nested(path, key="children", names=False):
    """Write a tree whose vessels hold their daughters, lengths in mm and radii in µm, or name them."""

    def vessel(name):
        _, length, radius = TREE[name]
        below = [daughter for daughter, (above, *_) in TREE.items() if above == name]
        sizes = {"id": name, "length": 10 * length, "radius": 1e4 * radius}
        return sizes | {key: below if names else [vessel(daughter) for daughter in below]}

    (root,) = (name for name, (mother, *_) in TREE.items() if not mother)
    units = {"length": "mm", "radius": "um"}
    path.write_text(json.dumps({"animal": "M7", "units": units, "tree": vessel(root)}), encoding="utf-8")
    return path


def test_a_tree_of_objects_within_objects_is_a_network(tmp_path):
    for key in ("children", "daughters", "branches"):
        assert shape(read(nested(tmp_path / "a.json", key))[0]) == expected()
    for fault, words in ((nested(tmp_path / "b.json", names=True), "a daughter is named where"),
                         (nested(tmp_path / "c.json"), "'offspring' of a vessel is not read")):  # fmt: skip
        text = fault.read_text(encoding="utf-8")
        fault.write_text(text if "named" in words else "offspring".join(text.rsplit("children", 1)), encoding="utf-8")
        with pytest.raises(InputError, match=words):
            vw.read_network(fault)


def test_the_sheet_of_vessels_is_found_behind_one_of_nodes(tmp_path):
    import openpyxl

    book = openpyxl.Workbook()
    book.active.append(["node", "x", "y", "z"])
    book.active.append([1, 0.0, 0.0, 0.0])
    sheet = book.create_sheet("Edges")
    sheet.append(["From node", "To node", "Length [µm]", "Mean radius [µm]"])
    for name, (_, length, radius) in TREE.items():
        sheet.append([*NODES[name], 1e4 * length, 1e4 * radius])
    book.save(tmp_path / "a.xlsx")
    assert shape(read(tmp_path / "a.xlsx")[0]) == expected()


@pytest.mark.parametrize(("name", "text", "words"), [
    ("a.dot", 'digraph lung {\n 1 -> 2 [length_mm=4];\n}\n', "a graph in DOT"),
    ("a.csv", '<?xml version="1.0"?>\n<neuroml id="l">\n</neuroml>\n', "XML of a form that is not read"),
])  # fmt: skip
def test_a_tree_in_a_language_of_others_is_called_what_it_is(tmp_path, name, text, words):
    (tmp_path / name).write_text(text, encoding="utf-8")
    with pytest.raises(InputError, match=words):
        vw.read_network(tmp_path / name)


def test_damaged_graphs_are_refused_in_words(tmp_path):
    for path in (gml(tmp_path / "a.gml"), node_link(tmp_path / "a.json", "links"), cytoscape(tmp_path / "b.json")):
        text = path.read_text(encoding="utf-8")
        for damaged in (text[: len(text) // 2], text.replace("source", "sauce", 1)):
            path.write_text(damaged, encoding="utf-8")
            with pytest.raises(InputError, match=path.name):
                vw.read_network(path)


def test_an_edge_of_gml_behind_the_end_of_its_graph_is_refused(tmp_path):
    path = gml(tmp_path / "a.gml")
    text = path.read_text(encoding="utf-8").rstrip()
    head, edge = text.removesuffix("]").rsplit("edge [", 1)
    path.write_text(f"{head}]\nedge [{edge}\n", encoding="utf-8")
    with pytest.raises(InputError, match="an edge stands outside the graph"):
        vw.read_network(path)


@pytest.mark.parametrize("cut", ["2", "2 "])
def test_a_list_of_edges_that_ends_within_a_name_is_refused(tmp_path, cut):
    edge = "{'length_mm': 4.1, 'radius_mm': 0.47}"
    (tmp_path / "a.edgelist").write_text(f"# of NetworkX\n1 2 {edge}\n2 3 {edge}\n{cut}", encoding="utf-8")
    with pytest.raises(InputError, match="a line is no edge; was the file cut off"):
        vw.read_network(tmp_path / "a.edgelist")


def test_an_attribute_of_gexf_that_nothing_declares_is_refused(tmp_path):
    import networkx

    networkx.write_gexf(networkx.DiGraph([(1, 2, {"length_mm": 4.0, "radius_mm": 0.4})]), tmp_path / "a.gexf")
    text = (tmp_path / "a.gexf").read_text(encoding="utf-8")
    (tmp_path / "a.gexf").write_text(text.replace('class="edge"', 'cl="edge"'), encoding="utf-8")
    with pytest.raises(InputError, match="not a graph, or damaged"):
        vw.read_network(tmp_path / "a.gexf")


@pytest.mark.parametrize("parent", ["Elterngefäß", "Muttergefäß", "Mutterast", "Segment parent", "Vaisseau père"])
def test_titles_of_other_languages_are_read(tmp_path, parent):
    path = written(tmp_path / "t.csv", f"Gefäß;{parent};Länge (mm);Durchmesser (mm)",
                   lambda n, p, long, r, *_: f"{n};{p};{10 * long:.2f};{20 * r:.3f}".replace(".", ","))  # fmt: skip
    assert shape(read(path)[0]) == expected()


@pytest.mark.parametrize(("scale", "offered"), [(1e4, ["um"]), (10, ["mm", "cm"])])
def test_a_table_without_a_unit_offers_those_that_make_its_root_an_artery(tmp_path, scale, offered):
    path = written(tmp_path / "t.csv", "name,parent,length,radius",
                   lambda n, p, long, r, *_: f"{n},{p},{scale * long:.5f},{scale * r:.5f}")  # fmt: skip
    with pytest.raises(InputError, match="does not say the unit") as caught:
        vw.read_network(path)
    assert [cure.text for cure in caught.value.cures][1:] == offered


def test_a_graph_with_an_edge_within_another_is_refused(tmp_path):
    edges = [f'<edge source="{a}" target="{b}">\n<data key="d0">4</data>\n<data key="d1">1</data>\n</edge>\n'
             for a, b in NODES.values()]  # fmt: skip
    keys = "".join(f'<key id="d{i}" for="edge" attr.name="{name}" attr.type="double"/>\n'
                   for i, name in enumerate(("length_mm", "radius_mm")))  # fmt: skip
    nodes = "".join(f'<node id="{i}"/>\n' for i in range(1, 7))
    head = f'<graphml xmlns="http://graphml.graphdrawing.org/xmlns">{keys}<graph edgedefault="directed">\n{nodes}'
    path = tmp_path / "t.graphml"
    path.write_text(f"{head}{''.join(edges)}</graph></graphml>")
    assert len(read(path)[0].name) == len(NODES)
    nested = edges[0].replace("</edge>", edges[1] + "</edge>")
    path.write_text(f"{head}{nested}{''.join(edges[2:])}</graph></graphml>")
    with pytest.raises(InputError, match="an edge stands within another"):
        vw.read_network(path)
    size = '<attr name="length_mm"><float>4</float></attr><attr name="radius_mm"><float>1</float></attr>'
    inner = f'<edge from="2" to="3">{size}</edge>'
    path.write_text(f'<gxl><graph edgemode="directed"><edge from="1" to="2">{inner}{size}</edge></graph></gxl>')
    with pytest.raises(InputError, match="an edge stands within another"):
        vw.read_network(path)


def test_a_skeleton_without_radii_says_what_its_intensity_is(tmp_path):
    row = ",".join(["{}"] * 4 + ["255"])
    path = written(tmp_path / "t.csv", "node 1,node 2,Branch length,Skeleton ID,average intensity (inner 3rd)",
                   lambda n, p, long, r, a, b: row.format(a, b, 10 * long, 1))  # fmt: skip
    with pytest.raises(InputError, match=r"'average intensity \(inner 3rd\)' is the mean of the image"):
        vw.read_network(path, "mm")


def test_a_table_may_have_a_caption_and_its_units_in_a_row(tmp_path):
    path = written(tmp_path / "t.csv", "Gefäß;Elterngefäß;Länge;Durchmesser",
                   lambda n, p, long, r, *_: f"{n};{p};{10 * long:.2f};{20 * r:.3f}")  # fmt: skip
    titles, rows = path.read_text(encoding="utf-8").split("\n", 1)
    path.write_text(f"Morphometrie Maus 12;;;\n;;;\n{titles}\n;;(mm);(mm)\n{rows}", encoding="utf-8")
    assert shape(read(path)[0]) == expected()


@pytest.mark.parametrize("damage", [lambda t: t[: len(t) // 2], lambda t: t.replace("<edge", "<ed"),
                                    lambda t: t.replace('key="b"', 'key="z"')])  # fmt: skip
def test_damaged_graphml_is_refused_in_words(tmp_path, damage):
    path = graphml(tmp_path / "a.graphml", "directed", "length_mm", "radius_mm")
    path.write_text(damage(path.read_text(encoding="utf-8")), encoding="utf-8")
    with pytest.raises(InputError, match=r"a\.graphml"):
        vw.read_network(path)


GXL_EDGE = (
    '<edge from="{a}" to="{b}"><attr name="length_mm"><float>{l}</float></attr><attr name="radius_mm">'
    "<float>{r}</float></attr></edge>"
)
EDGES_BY_OTHERS = {
    "gxl": ('<?xml version="1.0"?><gxl><graph id="g">{rows}</graph></gxl>', GXL_EDGE),
    "edges of networkx": ("# made by hand\n{rows}", "{a} {b} {{'length_mm': {l}, 'radius_mm': {r}}}\n"),
    "gml with its unit": ('graph [ directed 1 unit "mm" ' + "".join(f"node [ id {i} ] " for i in range(1, 7)) +
                          "{rows} ]", "edge [ source {a} target {b} length {l} radius {r} ] "),
    "gexf": ('<gexf xmlns="http://www.gexf.net/1.2draft" version="1.2"><graph defaultedgetype="directed"><attributes '
             'class="edge"><attribute id="0" title="length_mm" type="double"/><attribute id="1" title="radius_mm" '
             'type="double"/></attributes><nodes>' + "".join(f'<node id="{i}"/>' for i in range(1, 7)) +
             "</nodes><edges>{rows}</edges></graph></gexf>",
             '<edge id="{a}-{b}" source="{a}" target="{b}"><attvalues><attvalue for="0" value="{l}"/><attvalue for="1" '
             'value="{r}"/></attvalues></edge>'),
}  # fmt: skip


@pytest.mark.parametrize("form", EDGES_BY_OTHERS)
def test_graphs_of_vessels_are_read_in_every_language_of_graphs(tmp_path, form):
    whole, edge = EDGES_BY_OTHERS[form]
    rows = "".join(edge.format(a=NODES[name][0], b=NODES[name][1], l=10 * length, r=10 * radius)
                   for name, (_, length, radius) in TREE.items())  # fmt: skip
    (tmp_path / "tree").write_text(whole.format(rows=rows))
    assert shape(read(tmp_path / "tree")[0]) == expected()


PARALLEL = (("a", "b", 0.5), ("b", "c", 0.4), ("b", "d", 0.3), ("b", "d", 0.1))
"""Ends and radii in mm: two vessels run beside each other."""
LANGUAGES = {
    "graphml": lambda rows, kind: GRAPHML.format(
        length="length_mm", radius="radius_mm", kind=kind, nodes="".join(f'<node id="{node}"/>' for node in "abcd"),
        edges="".join(f'<edge source="{a}" target="{b}"><data key="a">4</data><data key="b">{r}</data></edge>'
                      for a, b, r in rows)),
    "gxl": lambda rows, kind: f'<gxl><graph id="g" edgemode="{kind}">' + "".join(
        GXL_EDGE.format(a=a, b=b, l=4, r=r) for a, b, r in rows) + "</graph></gxl>",
    "edges of networkx": lambda rows, kind: "".join(
        f"{a} {b} {{'length_mm': 4, 'radius_mm': {r}}}\n" for a, b, r in rows),
    "gml": lambda rows, kind: f"graph [ directed {kind == 'directed':d} " + "".join(
        f"node [ id {i} label \"{node}\" ] " for i, node in enumerate("abcd")) + "".join(
        f"edge [ source {'abcd'.index(a)} target {'abcd'.index(b)} length_mm 4 radius_mm {r} ] " for a, b, r in rows)
        + "]",
    "node links": lambda rows, kind: json.dumps({
        "directed": kind == "directed", "multigraph": False, "nodes": [{"id": node} for node in "abcd"],
        "links": [{"source": a, "target": b, "length_mm": 4, "radius_mm": r} for a, b, r in rows]}),
}  # fmt: skip


@pytest.mark.parametrize("kind", ["directed", "undirected"])
@pytest.mark.parametrize("language", LANGUAGES)
def test_vessels_between_the_same_nodes_are_no_single_vessel_in_any_language_of_graphs(tmp_path, language, kind):
    (tmp_path / "tree").write_text(LANGUAGES[language](PARALLEL, kind))
    with pytest.raises(InputError, match=r"edge 4: the edge from '[b1]' to '[d3]' closes a loop"):
        vw.read_network(tmp_path / "tree")
    (tmp_path / "tree").write_text(LANGUAGES[language](PARALLEL[:3], kind))
    assert len(read(tmp_path / "tree")[0].name) == 3


@pytest.mark.parametrize("offset", [0.0, 1e5])
def test_places_far_from_the_origin_join_the_same_vessels(tmp_path, offset):
    """Nodes 0.9 mm apart, as far away as 1e5 mm: to five digits all of them would be one."""
    place = {node: f"{offset + 0.9 * node:.4f},{offset:.4f},{offset - node**2:.4f}" for node in range(1, 7)}
    path = written(tmp_path / "a.csv", "x1,y1,z1,x2,y2,z2,length (mm),radius (mm)",
                   lambda n, p, length, r, a, b: f"{place[a]},{place[b]},{10 * length},{10 * r}")  # fmt: skip
    assert shape(read(path)[0]) == expected()


def spatial_graph(path, attribute, unit=""):
    """Write every vessel as five points along a quarter circle, in mm."""
    angle = np.linspace(0, np.pi / 2, 5)
    points, widths = [], []
    for _, length, radius in TREE.values():
        circle = 10 * length / (8 * np.sin(np.pi / 16))  # its four chords are as long as the vessel
        points += [(circle * np.cos(a), circle * np.sin(a), 0.0) for a in angle]
        widths += [9 * radius, *[10 * radius] * 3, 11 * radius]

    def lines(rows):
        return "".join(" ".join(map(str, np.atleast_1d(row).tolist())) + "\n" for row in rows)

    said = f'  Units {{ Coordinates "{unit}" }}\n' if unit else ""
    path.write_text(
        f"# AmiraMesh 3D ASCII 3.0\n\ndefine VERTEX 6\ndefine EDGE 5\ndefine POINT 25\n\nParameters {{\n{said}"
        '  ContentType "HxSpatialGraph"\n}\n\nVERTEX { float[3] VertexCoordinates } @1\n'
        "EDGE { int[2] EdgeConnectivity } @2\nEDGE { int NumEdgePoints } @3\n"
        f"POINT {{ float[3] EdgePointCoordinates }} @4\nPOINT {{ float {attribute} }} @5\n\n# Data section follows\n"
        f"@1\n{lines(np.zeros((6, 3)))}\n@2\n{lines(np.array(list(NODES.values())) - 1)}\n@3\n{lines([5] * 5)}\n"
        f"@4\n{lines(points)}\n@5\n{lines(widths)}"
    )
    return path


@pytest.mark.parametrize("attribute", ["thickness", "radius"])
def test_spatial_graphs_of_amira_are_measured_along_their_points(tmp_path, attribute):
    network, codes = read(spatial_graph(tmp_path / "g.am", attribute, "mm"))
    assert shape(network) == expected()
    assert {"network.columns", "network.root-taken"} <= codes
    bare = spatial_graph(tmp_path / "bare.am", attribute)
    with pytest.raises(InputError, match="this spatial graph of Amira does not say the unit"):
        vw.read_network(bare)
    assert shape(read(bare, "mm")[0]) == expected()


def spreadsheet(path, first="Node ID #1"):
    """Write every vessel as the three points of its edge, in um, on the sheets that Amira shows."""
    points, segments = (
        [["Point ID", "thickness", "X Coord", "Y Coord", "Z Coord"]],
        [["Segment ID", first, "Node ID #2", "Point IDs"]],
    )
    for number, (name, (_, length, radius)) in enumerate(TREE.items()):
        points += [[3 * number + i, 1e4 * radius, 5e3 * length * i, 0.0, 0.0] for i in range(3)]
        segments.append([number, *NODES[name], ",".join(str(3 * number + i) for i in range(3))])
    return saved(path, Nodes=[["Node ID"], *([i] for i in range(1, 7))], Points=points, Segments=segments)


def test_the_spreadsheet_of_a_spatial_graph_is_that_graph(tmp_path):
    assert shape(read(spreadsheet(tmp_path / "g.xlsx"), "um")[0]) == expected()
    with pytest.raises(InputError, match="no column 'node id #1'"):
        vw.read_network(spreadsheet(tmp_path / "b.xlsx", "Node"), "um")


@pytest.mark.parametrize(
    ("damage", "words"),
    [
        (lambda t: t[:-30], "finite numbers of thickness where 25 belong; was it cut off"),
        (lambda t: t.replace("ASCII", "BINARY-LITTLE-ENDIAN"), "saved in binary; save it as 'Amira ASCII'"),
        (lambda t: t.replace("thickness", "curvature"), "no radius, diameter or thickness"),
        (lambda t: t.replace("@3\n5", "@3\n4"), "do not fit"),
    ],
)
def test_spatial_graphs_that_cannot_be_read_say_why(tmp_path, damage, words):
    path = spatial_graph(tmp_path / "g.am", "thickness", "mm")
    path.write_text(damage(path.read_text()))
    with pytest.raises(InputError, match=words):
        vw.read_network(path)


@pytest.mark.parametrize("name", ["lines.vtp", "lines.swc", "lines.mrk.json"])
def test_centerlines_in_the_place_of_a_network_are_sent_to_their_command(tmp_path, name):
    (tmp_path / name).write_text("x")
    with pytest.raises(InputError, match=f"{name}: holds centerlines.*with their unit of length"):
        vw.read_network(tmp_path / name)


def test_branches_of_a_skeleton_without_widths_are_refused_for_that(tmp_path):
    header = " ,Skeleton ID,Branch length,V1 x,V1 y,V1 z,V2 x,V2 y,V2 z,Euclidean distance,average intensity"
    path = written(tmp_path / "a.csv", header,
                   lambda n, p, length, r, a, b: f"1,1,{length},{a},0,0,{b},0,0,{length},255")  # fmt: skip
    with pytest.raises(InputError, match="no column 'radius'"):
        vw.read_network(path)


OTHERS = {
    "a.xml": (
        '<?xml version="1.0"?>\n<gxl><graph id="g"><node id="n0"><attr name=" nodeType"><string> root node </string>'
        "</attr></node></graph></gxl>\n",
        "positions count voxels",
    ),
    "network.dat": (
        "a network\n100 100 100\n2   total number of segments\nSegName Type FromNode ToNode Diam Flow Hd\n"
        "1 5 1 2 30 1 0.45\n2 5 2 3 20 1 0.45\n3   number of nodes\nname x y z\n1 0 0 0\n2 9 0 0\n3 9 9 0\n",
        "Secomb's programs",
    ),
    "a.yml": ("proj_name: a\n\nnetwork:\n  - label: a\n    sn: 1\n    tn: 2\n", "export FILE --to tables"),
    "a.csv": (
        "Order,Number,Diameter (mm),Length (mm)\n1,512,0.02,0.2\n2,180,0.04,0.3\n",
        "does not say what joins vessels",
    ),
}


@pytest.mark.parametrize("name", OTHERS)
def test_what_is_no_table_of_vessels_is_refused_for_what_it_is(tmp_path, name):
    (tmp_path / name).write_text(OTHERS[name][0])
    with pytest.raises(InputError, match=OTHERS[name][1]):
        vw.read_network(tmp_path / name)
