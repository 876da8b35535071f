"""Networks and centerlines: vasowave's tables and those of other programs, and corrections by hand."""

import json
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from fuzzing.forms import Form, Mutate
from fuzzing.mutations import (
    bombs,
    inside_zip,
    mutate_binary,
    mutate_markup,
    mutate_text,
    packed_zeros,
    with_header,
)
from vasowave.lung import Line, Tree
from vasowave.lung.exchange import read_centerlines, read_polydata, write_centerlines, write_swc
from vasowave.lung.revise import read_edits
from vasowave.pulse.network import COUNTED, Network, write_network
from vasowave.pulse.network_formats import read_network


def tree() -> Tree:
    """Return five vessels: a root, two daughters, two of the second one's; mm."""
    ends = np.array([[0, 0, 0], [9, 0, 0], [14, 5, 0], [14, -5, 0], [18, -5, 6], [18, -5, -6]], dtype=float)
    pairs, radii = [(0, 1), (1, 2), (1, 3), (3, 4), (3, 5)], (1.2, 0.8, 0.9, 0.6, 0.5)
    along = np.linspace(0, 1, 12)[:, None]
    lines = [
        Line(ends[a] + along * (ends[b] - ends[a]), np.full(12, r)) for (a, b), r in zip(pairs, radii, strict=True)
    ]
    return Tree(tuple(lines), np.array([-1, 0, 0, 2, 2]))


def network_table(path: Path, counted: bool = True) -> None:
    parent = [-1, 0, 0, 1, 1, 2, 2, 3, 3]
    sizes = np.linspace(1.0, 0.4, 9)
    write_network(
        Network(tuple(f"v{i}" for i in range(9)), np.array(parent), 0.4 * sizes, 0.05 * sizes, pressure=6.3), path
    )
    if not counted:
        lines = (line.rsplit(",", 2)[0] for line in path.read_text().splitlines())
        path.write_text("\n".join(lines) + "\n")
        assert not any(title in path.read_text() for title in COUNTED)


def loop_table(path: Path) -> None:
    """Write a vessel that divides into two, which meet again and divide once more."""
    nodes = [[0, 1], [1, 2], [1, 3], [2, 4], [3, 4], [4, 5], [4, 6]]
    sizes = np.linspace(1.0, 0.5, len(nodes))
    write_network(Network(tuple(f"v{i}" for i in range(7)), None, 0.4 * sizes, 0.05 * sizes, nodes=nodes), path)


def places_table(path: Path) -> None:
    """Write vessels by the places where they begin and end."""
    lines = tree().lines
    rows = (",".join(f"{value:.6g}" for value in (0.1 * np.linalg.norm(line.points[-1] - line.points[0]),
            0.1 * line.radius[0], *line.points[0], *line.points[-1])) for line in lines)  # fmt: skip
    path.write_text("length [cm],radius [cm],V1 x,V1 y,V1 z,V2 x,V2 y,V2 z\n" + "\n".join(rows) + "\n")


def vtk(path: Path, binary: bool) -> None:
    """Write what `write_centerlines` writes as a legacy file."""
    write_centerlines(tree(), path.with_suffix(".vtp"), unit=1.0)
    data = read_polydata(path.with_suffix(".vtp"))
    packed = np.concatenate([np.append(len(line), line) for line in data.lines])

    def block(values: np.ndarray, kind: str) -> bytes:
        if binary:
            return values.astype(kind).tobytes() + b"\n"
        return ("\n".join(" ".join(f"{v:.9g}" for v in row) for row in np.atleast_2d(values)) + "\n").encode()

    count = len(data.points)
    parts = [
        f"# vtk DataFile Version 3.0\nlines\n{'BINARY' if binary else 'ASCII'}\nDATASET POLYDATA\n".encode(),
        f"POINTS {count} double\n".encode(), block(data.points, ">f8"),
        f"LINES {len(data.lines)} {len(packed)}\n".encode(), block(packed, ">i4"),
        f"POINT_DATA {count}\nFIELD FieldData 1\nRadius 1 {count} double\n".encode(),
        block(data.fields["MaximumInscribedSphereRadius"][:, None], ">f8"),
    ]  # fmt: skip
    path.write_bytes(b"".join(parts))


def vtp_text(path: Path) -> None:
    """Write what `write_centerlines` writes with numbers as text."""
    write_centerlines(tree(), path, unit=1.0)
    data = read_polydata(path)

    def array(name: str, kind: str, values: np.ndarray, width: int = 1) -> str:
        numbers = "\n".join(" ".join(f"{v:.9g}" for v in row) for row in values.reshape(-1, width))
        head = f'<DataArray type="{kind}" Name="{name}" NumberOfComponents="{width}" format="ascii">'
        return f"{head}\n{numbers}\n</DataArray>"

    ends = np.cumsum([len(line) for line in data.lines])
    radius = data.fields["MaximumInscribedSphereRadius"]
    path.write_text(
        '<VTKFile type="PolyData"><PolyData>\n'
        f'<Piece NumberOfPoints="{len(data.points)}" NumberOfLines="{len(data.lines)}">\n'
        f"<PointData>{array('Radius', 'Float64', radius)}</PointData>\n"
        f"<Points>{array('Points', 'Float64', data.points, 3)}</Points>\n"
        f"<Lines>{array('connectivity', 'Int64', np.concatenate(data.lines))}\n"
        f"{array('offsets', 'Int64', ends)}</Lines>\n"
        "</Piece></PolyData></VTKFile>\n"
    )


def markups(path: Path) -> None:
    """Write a curve a vessel, as 3D Slicer does."""
    import json

    curves = [
        {
            "type": "Curve",
            "coordinateSystem": "LPS",
            "controlPoints": [{"position": point[::-1].tolist()} for point in line.points],
            "measurements": [{"name": "Radius", "controlPointValues": line.radius.tolist()}],
        }
        for line in tree().lines
    ]
    path.write_text(json.dumps({"markups": curves}, indent=1))


def tubes(path: Path) -> None:
    """Write a tube a vessel, as TubeTK does."""
    text = f"ObjectType = Scene\nNDims = 3\nNObjects = {len(tree())}\n"
    for line in tree().lines:
        text += f"ObjectType = Tube\nNDims = 3\nPointDim = x y z r\nNPoints = {len(line)}\nPoints = \n"
        rows = np.column_stack([line.points[:, ::-1], line.radius])
        text += "".join(" ".join(f"{v:.6f}" for v in row) + "\n" for row in rows)
    path.write_text(text)


def flat_table(path: Path) -> None:
    write_centerlines(tree(), path.with_suffix(".vtp"), unit=1.0)
    data = read_polydata(path.with_suffix(".vtp"))
    rows = np.column_stack([data.points, data.fields["MaximumInscribedSphereRadius"]])
    text = "\n".join(",".join(f"{v:.6f}" for v in rows[i]) for line in data.lines for i in line)
    path.write_text(f"x [mm],y [mm],z [mm],radius [mm]\n{text}\n")


def network_workbook(path: Path) -> None:
    import openpyxl

    network_table(path.with_suffix(".csv"))
    book = openpyxl.Workbook()
    for row in path.with_suffix(".csv").read_text().splitlines():
        book.active.append([float(cell) if _is_number(cell) else cell for cell in row.split(",")])
    book.save(path)


def spatial_graph_workbook(path: Path) -> None:
    """Write the sheets that Amira shows of a spatial graph: two vessels behind a first, three points each."""
    import openpyxl

    nodes = {1: (1, 2), 2: (2, 3), 3: (2, 4)}
    sheets = {
        "Nodes": [["Node ID"], *([node] for node in range(1, 5))],
        "Points": [
            ["Point ID", "thickness", "X Coord", "Y Coord", "Z Coord"],
            *([3 * vessel + i, 400.0 / vessel, 5e3 * i, 1e3 * vessel, 0.0] for vessel in nodes for i in range(3)),
        ],
        "Segments": [
            ["Segment ID", "Node ID #1", "Node ID #2", "Point IDs"],
            *([vessel, *ends, ",".join(str(3 * vessel + i) for i in range(3))] for vessel, ends in nodes.items()),
        ],
    }
    book = openpyxl.Workbook()
    book.remove(book.active)
    for title, rows in sheets.items():
        sheet = book.create_sheet(title)
        for row in rows:
            sheet.append(row)
    book.save(path)


def svonesolver_input(path: Path) -> None:
    """Write three segments that a joint joins."""
    lines = ["MODEL tree", "JOINT J 1 IN OUT", "JOINTINLET IN 1 0", "JOINTOUTLET OUT 2 1 2"]
    lines += [
        f"SEGMENT v{i} {i} {length} 50 {max(i - 1, 0)} {i + 1} {area} {0.9 * area:g} 0.0 WALL NONE 0.0 0 0 NOBOUND NONE"
        for i, (length, area) in enumerate([(8.6, 2.3), (8.5, 1.1), (7.5, 1.3)])
    ]
    path.write_text("\n".join([*lines, "MATERIAL WALL OLUFSEN 1.06 0.04 113324.0 1.0 2.0e7 -22.5 8.65e5", ""]))


def first_blood_table(path: Path) -> None:
    """Write three edges between nodes, and what the nodes are."""
    path.write_text(
        "type,ID,name,start_node,end_node,start_diameter[SI],end_diameter[SI],length[SI]\n"
        "vis,A1,aorta,H,n1,0.03,0.02,0.05\nvis,A2,left,n1,p1,0.012,0.012,0.20\nvis,A3,right,n1,p2,0.010,0.008,0.10\n"
        "type,ID,name,leak\nheart,H,0,\nnode,n1,0,5e11\nperif,p1,0,\nperif,p2,0,\n"
    )


def edge_list(path: Path) -> None:
    """Write edges whose order says no direction, with units at the ends of their titles."""
    rows = [(1, 2, 4.1, 0.94), (3, 2, 4.4, 0.6), (2, 4, 3.7, 0.7), (5, 4, 2.1, 0.5), (4, 6, 2.6, 0.44)]
    path.write_text("\n".join(["node1,node2,length_mm,diameter_mm", *(",".join(map(str, row)) for row in rows), ""]))


def graphml(path: Path) -> None:
    """Write the same edges, towards their ends, as GraphML or GEXF."""
    import networkx

    graph = networkx.DiGraph()
    for first, last, length, radius in [(1, 2, 4.1, 0.47), (2, 3, 4.4, 0.3), (2, 4, 3.7, 0.35)]:
        graph.add_edge(first, last, length_mm=length, radius_mm=radius)
    {".gexf": networkx.write_gexf}.get(path.suffix, networkx.write_graphml)(graph, path)


def gml(path: Path) -> None:
    """Write the same edges as GML."""
    sizes = [(1, 2, 4.1, 0.47), (2, 3, 4.4, 0.3), (2, 4, 3.7, 0.35)]
    nodes = "".join(f"  node [ id {i} ]\n" for i in range(1, 5))
    edges = "".join(f"  edge [ source {a} target {b} length_mm {x} radius_mm {r} ]\n" for a, b, x, r in sizes)
    path.write_text(f"graph [\n  directed 1\n{nodes}{edges}]\n")


def node_link(path: Path) -> None:
    """Write the same edges as JSON of NetworkX."""
    sizes = [(1, 2, 4.1, 0.47), (2, 3, 4.4, 0.3), (2, 4, 3.7, 0.35)]
    links = [{"source": a, "target": b, "length_mm": x, "radius_mm": r} for a, b, x, r in sizes]
    path.write_text(json.dumps({"directed": True, "nodes": [{"id": i} for i in range(1, 5)], "links": links}, indent=1))


def nested_tree(path: Path) -> None:
    """Write a vessel that holds its daughters, in mm."""
    ends = [{"name": name, "length": x, "radius": r} for name, x, r in (("left", 4.4, 0.3), ("right", 3.7, 0.35))]
    root = {"name": "main", "length": 4.1, "radius": 0.47, "children": ends}
    path.write_text(json.dumps({"unit": "mm", "tree": root}, indent=1))


def gxl(path: Path) -> None:
    """Write the same edges in the Graph eXchange Language."""
    sizes = [(1, 2, 4.1, 0.47), (2, 3, 4.4, 0.3), (2, 4, 3.7, 0.35)]
    edges = "".join(f'<edge from="{a}" to="{b}">\n<attr name="length_mm"><float>{x}</float></attr>\n'
                    f'<attr name="radius_mm"><float>{r}</float></attr>\n</edge>\n' for a, b, x, r in sizes)  # fmt: skip
    path.write_text(f'<?xml version="1.0"?>\n<gxl>\n<graph id="g" edgemode="directed">\n{edges}</graph>\n</gxl>\n')


def listed_edges(path: Path) -> None:
    """Write the same edges as NetworkX lists them."""
    sizes = [(1, 2, 4.1, 0.47), (2, 3, 4.4, 0.3), (2, 4, 3.7, 0.35)]
    path.write_text("".join(f"{a} {b} {{'length_mm': {x}, 'radius_mm': {r}}}\n" for a, b, x, r in sizes))


def spatial_graph(path: Path) -> None:
    """Write three edges of four points each as Amira does."""
    ends, nodes = tree().lines, [(0, 1), (1, 2), (1, 3)]
    points = np.concatenate([line.points[::3] for line in ends[:3]])
    radii = np.concatenate([line.radius[::3] for line in ends[:3]])
    arrays = [
        ("VERTEX", "float[3] VertexCoordinates", np.zeros((4, 3))),
        ("EDGE", "int[2] EdgeConnectivity", np.array(nodes)),
        ("EDGE", "int NumEdgePoints", np.full((3, 1), 4)),
        ("POINT", "float[3] EdgePointCoordinates", points),
        ("POINT", "float thickness", radii[:, None]),
    ]
    head = "# AmiraMesh 3D ASCII 3.0\ndefine VERTEX 4\ndefine EDGE 3\ndefine POINT 12\n"
    head += 'Parameters {\n  Units { Coordinates "mm" }\n  ContentType "HxSpatialGraph"\n}\n'
    head += "".join(f"{kind} {{ {name} }} @{place}\n" for place, (kind, name, _) in enumerate(arrays, 1))
    data = "".join(
        f"@{place}\n" + "".join(" ".join(f"{value:g}" for value in row) + "\n" for row in rows)
        for place, (_, _, rows) in enumerate(arrays, 1)
    )
    path.write_text(head + data)


def svzerod_circuit(path: Path) -> None:
    """Write three vessels of one junction with their beds."""
    import json

    vessels = [
        {"vessel_id": row, "vessel_name": f"b{row}", "vessel_length": length, "zero_d_element_type": "BloodVessel",
         "vessel_D": 0.1 - 0.02 * row, "zero_d_element_values": {"R_poiseuille": 20.0, "C": 1e-8, "L": 1.0},
         "boundary_conditions": {"outlet": f"OUT{row}"} if row else {"inlet": "INFLOW"}}
        for row, length in enumerate([0.4, 0.3, 0.2])
    ]  # fmt: skip
    beds = [{"bc_name": f"OUT{row}", "bc_type": "RCR", "bc_values": {"Rp": 1e5, "Rd": 1e6, "C": 1e-7, "Pd": 0.0}}
            for row in (1, 2)]  # fmt: skip
    flow = {"bc_name": "INFLOW", "bc_type": "FLOW", "bc_values": {"t": [0.0, 0.05, 0.1], "Q": [0.1, 0.3, 0.1]}}
    junction = {
        "junction_name": "J0",
        "junction_type": "NORMAL_JUNCTION",
        "inlet_vessels": [0],
        "outlet_vessels": [1, 2],
    }
    content = {"simulation_parameters": {"density": 1.06, "viscosity": 0.04}, "vessels": vessels,
               "junctions": [junction], "boundary_conditions": [flow, *beds]}  # fmt: skip
    path.write_text(json.dumps(content, indent=1))


def matlab_matrices(path: Path) -> None:
    """Write sizes and joints of three vessels as matrices."""
    from scipy.io import savemat

    sizes = np.array([[1, 40.0, 5.0], [2, 45.0, 3.0], [3, 37.0, 4.0]])
    savemat(path, {"dim_mat": sizes, "ves_conn": np.array([[1, 2, 3]]), "r_std": np.full((3, 1), 0.3)})


def two_tables(path: Path) -> None:
    """Write sizes, and beside them what joins what."""
    path.write_text("4.1 0.5 0.5\n4.5 0.3 0.3\n3.7 0.4 0.3\n")
    path.with_name("connectivity.txt").write_text("0 1 2 0\n1 0 0 0\n2 0 0 0\n")


def _is_number(cell: str) -> bool:
    return cell.replace(".", "", 1).isdecimal()


def edits(path: Path) -> None:
    path.write_text("unit mm\nroot 0.1 0.2 0.3\nremove 14.0 6.2 7.7\ncut 3.1 5.2 9.5\nmerge 4.5 6.1 8.8\n")


def bomb(size: int) -> bytes:
    """Return a .vtp whose points say that they take 24 kB and unpack to `size`."""
    import base64

    packed = packed_zeros(size, 15)
    head = np.array([1, 24000, 24000, len(packed)], "<u8").tobytes()
    text = base64.b64encode(head).decode() + base64.b64encode(packed).decode()
    return (
        '<VTKFile type="PolyData" byte_order="LittleEndian" header_type="UInt64" compressor="vtkZLibDataCompressor">'
        '<PolyData><Piece NumberOfPoints="1000" NumberOfLines="1"><Points><DataArray type="Float64" Name="Points" '
        f'NumberOfComponents="3" format="binary">{text}</DataArray></Points><Lines/></Piece></PolyData></VTKFile>'
    ).encode()


def _shape(parent: list[int], row: int = -1) -> tuple:
    """Return the tree below a row as tuples in tuples, in whatever order its vessels stand."""
    return tuple(sorted(_shape(parent, below) for below, above in enumerate(parent) if above == row))


def _structure(network: Network) -> tuple:
    """Return what does not change with the order of the vessels."""
    if network.nodes is None:
        return _shape(list(network.parent))
    begins, ends = np.array(network.nodes).T
    count = max(begins.max(), ends.max()) + 1
    met = np.column_stack([np.bincount(begins, minlength=count), np.bincount(ends, minlength=count)])
    return tuple(sorted((*met[a].tolist(), *met[b].tolist()) for a, b in network.nodes))


_OF_SOUND_FILES = ("no part of a network", "columns were read", "blood is taken")


def _without_beds(path: Path, unit: str | None) -> Network:
    """Read a network; that walls and beds of a sound file are left out is no sign of damage."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        network = read_network(path, unit)
    for one in caught:
        if not any(text in str(one.message) for text in _OF_SOUND_FILES):
            warnings.warn(one.message, one.category, stacklevel=2)
    return network


def _circuit_model(path: Path) -> Any:
    """Read a model of svZeroDSolver; that its walls are linear is no sign of damage."""
    from vasowave.study.exchange import read_svzerod  # where the lung is tried alone there is no study

    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        model = read_svzerod(path)[0]
    for one in caught:
        if "walls are linear" not in str(one.message):
            warnings.warn(one.message, one.category, stacklevel=2)
    return model


def _network(
    write: Callable, name: str = "n.csv", mutate: Mutate = mutate_text, text: bool = True, unit: str | None = None
) -> Form:
    return Form(
        lambda folder: write(folder / name), name, name, mutate, lambda path: _without_beds(path, unit),
        _structure, lambda found: [found.name, found.length, found.radius], text=text,
    )  # fmt: skip


def _lines(name: str, write: Callable, mutate: Mutate, text: bool) -> Form:
    return Form(
        lambda folder: write(folder / name), name, name, mutate, lambda path: read_centerlines(path, 0.1),
        lambda found: _shape(list(found.parent)),
        lambda found: [np.column_stack([line.points, line.radius]) for line in found.lines], text=text,
    )  # fmt: skip


def edits_form() -> Form:
    def places(found: Any) -> list[np.ndarray]:
        return [edit.point for edit in found]

    return Form(
        lambda folder: edits(folder / "e.txt"), "e.txt", "e.txt", mutate_text, read_edits,
        lambda found: [edit.action for edit in found], places,  # a list of wishes cannot know that one is missing
    )  # fmt: skip


FORMS = {
    "network table": _network(network_table),
    "network table of others": _network(lambda path: network_table(path, counted=False)),
    "network table of places": _network(places_table),
    "network table with a loop": _network(loop_table),
    "network workbook": _network(network_workbook, "n.xlsx", inside_zip(mutate_markup, "sheet1.xml")),
    "svOneDSolver network": _network(svonesolver_input, "n.in"),
    "FirstBlood network": _network(first_blood_table, "n.csv"),
    "edge list": _network(edge_list),
    "GraphML": _network(graphml, "n.graphml"),
    "GEXF": _network(graphml, "n.gexf"),
    "GML": _network(gml, "n.gml"),
    "GXL": _network(gxl, "n.gxl"),
    "list of edges": _network(listed_edges, "n.edgelist"),
    "node-link JSON": _network(node_link, "n.json"),
    "tree in JSON": _network(nested_tree, "n.json"),
    "spatial graph of Amira": _network(spatial_graph, "n.am"),
    "spatial graph table": _network(
        spatial_graph_workbook, "n.xlsx", inside_zip(mutate_markup, "sheet2.xml"), unit="um"
    ),
    "svZeroDSolver network": _network(svzerod_circuit, "n.json"),
    "svZeroDSolver model": Form(
        lambda folder: svzerod_circuit(folder / "m.json"),
        "m.json",
        "m.json",
        mutate_text,
        _circuit_model,
        lambda model: _structure(model.network),
        lambda model: [model.network.length, model.network.radius, *map(np.asarray, model.outlets)],
        text=True,
    ),
    "matrices of a network": _network(matlab_matrices, "n.mat", mutate_binary, text=False, unit="mm"),
    "two tables of a network": _network(two_tables, "Dimensions.txt", unit="mm"),
    "vtp": _lines("c.vtp", lambda path: write_centerlines(tree(), path, unit=1.0), bombs(bomb, mutate_binary), False),
    "vtp, numbers as text": _lines("c.vtp", vtp_text, mutate_text, True),
    "vtk": _lines("c.vtk", lambda path: vtk(path, True), with_header(b"double\n"), False),
    "vtk, numbers as text": _lines("c.vtk", lambda path: vtk(path, False), mutate_text, True),
    "swc": _lines("c.swc", lambda path: write_swc(tree().times(0.1), path), mutate_text, True),
    "slicer's curves": _lines("c.mrk.json", markups, mutate_text, True),
    "tubes": _lines("c.tre", tubes, mutate_text, True),
    "flat table": _lines("c.csv", flat_table, mutate_text, True),
}
