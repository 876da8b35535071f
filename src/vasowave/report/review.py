"""The folder of one extraction: tables, centerlines, mask, surface, figures, and a page to review them."""

import csv
import hashlib
import json
from dataclasses import fields
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from vasowave.figures.gallery import write_figures
from vasowave.figures.network import plot_network
from vasowave.figures.projection import projection_figure
from vasowave.figures.style import new_figure, style
from vasowave.imaging.exchange import write_author_tables, write_centerlines, write_swc
from vasowave.imaging.extraction import write_extraction
from vasowave.imaging.places import written
from vasowave.imaging.request import Answer
from vasowave.imaging.surface import smooth_surface, write_mask, write_stl, write_surface_vtp
from vasowave.imaging.taper import Taper, taper
from vasowave.imaging.tree import Tree, free_length
from vasowave.imaging.volume import isotropic
from vasowave.provenance import provenance
from vasowave.report.page import embedded
from vasowave.report.summary import number
from vasowave.results import FIGURES, check_folder, replacing

if TYPE_CHECKING:
    from matplotlib.figure import Figure

PAGE = "review.html"
SETTINGS = "extraction.json"
MARKS = {PAGE: b'name="generator" content="vasowave'}
_CAPTIONS = {
    "projection": (
        "The image and the network",
        "Brightest voxel along each axis of the image (grey), outline of the lumen, and the vessels with their names.",
    ),
    "network": (
        "The network as a directed graph",
        "Each vessel with its share of the mean flow (eq. 11); width follows the radius, lengths are not to scale.",
    ),
}
_MOST_POINTS = 40  # of a vessel in the page's view


def check_extraction_folder(folder: Path) -> None:
    """Raise `InputError` unless `folder` is missing, empty, or an earlier extraction."""
    check_folder(Path(folder), MARKS)


def write_answer(found: Answer, folder: Path) -> Path:
    """Write everything about an extraction into `folder`, whole or not at all, and return the page's path.

    An earlier extraction in it is replaced; files of other origin stay. Lengths are cm in tables; mask, surface and
    ``centerlines.vtp`` are in mm, as imaging programs expect, ``centerlines.swc`` in µm.

    Raises
    ------
    InputError
        The folder holds something else or cannot be written.
    """
    folder = Path(folder).resolve()
    check_extraction_folder(folder)
    figures = extraction_figures(found)
    origin = _provenance(found)
    page = render(found, figures, origin)
    with replacing(folder, MARKS) as fresh:
        _write_network(found, fresh)
        surface = smooth_surface(found.lumen)
        write_mask(found.lumen, found.image, fresh / "mask.nrrd")
        write_surface_vtp(surface, fresh / "surface.vtp")
        write_stl(surface, fresh / "surface.stl")
        write_figures(figures, fresh / FIGURES)
        stored = {"settings": dict(_settings(found)), "notes": found.notes, "provenance": origin}
        (fresh / SETTINGS).write_text(json.dumps(stored, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
        (fresh / PAGE).write_text(page, encoding="utf-8")
    return folder / PAGE


def extraction_figures(found: Answer) -> dict[str, "Figure"]:
    """Return the figures by name: projection, network."""
    network = found.extraction.network
    tree = _in_image(found)
    projection = projection_figure(isotropic(found.image), found.lumen, tree, network.name)
    with style():
        height = min(60.0, max(5.0, 0.9 * len(network.terminals)))
        graph = new_figure(min(60.0, max(12.0, 2.6 * len(network.generations))), height)
        plot_network(graph.subplots(), network)
        for figure in (projection, graph):  # drawn to several files: the layout is worked out once
            figure.draw_without_rendering()
            figure.set_layout_engine("none")
    return {"projection": projection, "network": graph}


def render(found: Answer, figures: dict[str, "Figure"], origin: dict[str, str]) -> str:
    """Return the page as HTML text with figures, view and numbers inside; it needs no network."""
    from jinja2 import Environment, PackageLoader, StrictUndefined

    environment = Environment(
        loader=PackageLoader("vasowave.report"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    source, *_ = environment.loader.get_source(environment, "tree3d.js")  # type: ignore[union-attr]
    network = found.extraction.network
    scale = "not measured"
    if found.request.cannula_radius is not None:
        scale = f"{100 * (found.extraction.scale - 1):+.1f} %"
    return environment.get_template("review.html").render(
        source=str(found.request.image),
        sentence=f"{len(network)} vessels, {len(network.terminals)} of them terminal, in {len(network.generations)} "
        f"generations; total length {number(float(network.length.sum()))} cm; root {network.name[network.root]} with "
        f"a radius of {number(float(network.radius[network.root]))} cm. Scale of the cannula against the file: {scale}"
        f"{', applied' if found.request.scale == 'cannula' else ''}.",
        notes=found.notes,
        actions=("remove", "cut", "merge", "root"),
        figures=[
            {"name": name, "svg": embedded(figure, name), "title": _CAPTIONS[name][0], "caption": _CAPTIONS[name][1]}
            for name, figure in figures.items()
        ],
        table_caption="Radius: densitometric, or inscribed where the vessel is too short. SD: over thresholds of 0.8, "
        "1 and 1.2 times the chosen one. Taper: fall of the radius per length, with its standard error.",
        table=_page_table(found),
        settings=_settings(found),
        provenance=origin,
        tree=_tree_data(found),
        script=source,
    )


def vessel_rows(found: Answer) -> tuple[tuple[str, ...], list[tuple[Any, ...]]]:
    """Return header and rows of `vessels.csv`: what the network table does not say of each vessel."""
    network, tree = found.extraction.network, found.extraction.tree
    generation = np.zeros(len(network), dtype=int)
    for level, members in enumerate(network.generations, 1):
        generation[members] = level
    slopes, free = taper(tree), free_length(tree)
    header = ("name", "generation", "flow_fraction", "free_length [cm]", *_TAPER, *_ENDS)
    rows: list[tuple[Any, ...]] = []
    for row, name in enumerate(network.name):
        ends = tree.lines[row][[0, -1], 2::-1].ravel().tolist()
        numbers = [network.flow_fraction[row], free[row], *_tapers(slopes, row), *ends]
        rows.append((name, int(generation[row]), *map(float, numbers)))
    return header, rows


_TAPER = ("taper [cm/cm]", "taper_se [cm/cm]", "radius_proximal [cm]", "radius_distal [cm]")
_ENDS = tuple(f"{axis}_{end} [cm]" for end in ("proximal", "distal") for axis in "xyz")


def _tapers(slopes: Taper, row: int) -> list[float]:
    return [values[row] for values in (slopes.slope, slopes.slope_se, slopes.proximal, slopes.distal)]


def _write_network(found: Answer, folder: Path) -> None:
    write_extraction(found.extraction, folder / "tables")
    for table in (folder / "tables").iterdir():
        table.rename(folder / table.name)
    (folder / "tables").rmdir()
    header, rows = vessel_rows(found)
    with (folder / "vessels.csv").open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(header)
        writer.writerows(["" if cell != cell else cell for cell in row] for row in rows)
    network, tree = found.extraction.network, found.extraction.tree
    write_author_tables(network, folder / "connectivity.csv", folder / "dimensions.csv")
    write_centerlines(tree, folder / "centerlines.vtp", unit=0.1)
    write_swc(tree, folder / "centerlines.swc")


def _in_image(found: Answer) -> Tree:
    """Return the tree in the image's coordinates, before the cannula's scale."""
    tree = found.extraction.tree
    return Tree(tuple(line / found.factor for line in tree.lines), tree.parent)


def _page_table(found: Answer) -> tuple[tuple[str, ...], list[tuple[str, ...]]]:
    network, one = found.extraction.network, found.extraction
    slopes = taper(one.tree)
    header = ("vessel", "parent", "length [cm]", "radius [cm]", "SD [cm]", "inscribed [cm]", "densitometric [cm]",
              "reliable", "taper [cm/cm]", "±", "flow [%]")  # fmt: skip
    rows = []
    for row, name in enumerate(network.name):
        parent = network.name[network.parent[row]] if network.parent[row] >= 0 else "–"
        sizes = (network.length, network.radius, one.radius_sd, one.inscribed, one.densitometric)
        rows.append(
            (name, parent, *(number(float(values[row])) for values in sizes), number(bool(one.reliable[row])),
             *(number(float(value), 2) for value in (slopes.slope[row], slopes.slope_se[row])),
             number(100 * float(network.flow_fraction[row])))
        )  # fmt: skip
    return header, rows


def _tree_data(found: Answer) -> str:
    network, vessels = found.extraction.network, []
    terminals = set(network.terminals.tolist())
    for row, line in enumerate(found.extraction.tree.lines):
        few = np.unique(np.linspace(0, len(line) - 1, min(len(line), _MOST_POINTS)).round().astype(int))
        points = np.round(line[few][:, [2, 1, 0, 3]], 5).tolist()
        sizes = {"radius": number(float(network.radius[row])), "length": number(float(network.length[row]))}
        vessels.append({"name": network.name[row], "terminal": row in terminals, "points": points, **sizes})
    # A name may hold "</script>".
    root = np.round(found.factor * found.root[::-1], 5).tolist()
    return json.dumps({"factor": found.factor, "root": root, "vessels": vessels}).replace("<", "\\u003c")


def _settings(found: Answer) -> list[tuple[str, str]]:
    request = found.request
    rows = [("root used (x,y,z, cm)", written(found.root)), ("scale factor", f"{found.factor:.5g}")]
    for entry in fields(request):
        value = getattr(request, entry.name)
        if value is None or entry.name == "root":
            continue
        if isinstance(value, tuple | list | np.ndarray):
            value = "; ".join(written(point) for point in np.atleast_2d(value))
        rows.append((entry.name.replace("_", " "), str(value)))
    return rows


def _provenance(found: Answer) -> dict[str, str]:
    request = found.request
    given = [request.image, request.mask, request.edits, request.region]
    files = [path for path in given if isinstance(path, Path) and path.is_file()]
    origin = provenance(files)
    if request.image.is_dir():
        digest = hashlib.sha256()
        for file in sorted(path for path in request.image.iterdir() if path.is_file()):
            digest.update(file.read_bytes())
        origin[f"sha256 of all files in {request.image.name}"] = digest.hexdigest()
    return origin
