"""The folder of one extraction, or of a network from another program's centerlines: tables, figures, page to review."""

import csv
import hashlib
import io
import json
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from vasowave.base.findings import texts
from vasowave.base.io.files import check_folder, make_folder, write_file, write_folder
from vasowave.base.software import provenance
from vasowave.lung.exchange.centerlines import write_centerlines
from vasowave.lung.exchange.swc import write_swc
from vasowave.lung.exchange.tables import write_author_tables, write_network_table, write_points
from vasowave.lung.exchange.triangles import write_stl, write_surface_vtp
from vasowave.lung.extraction import Extraction
from vasowave.lung.lumen.surface import smooth_surface, write_mask
from vasowave.lung.measure.measurement import Measurement, taper
from vasowave.lung.read.volume import isotropic
from vasowave.lung.tree import free_length
from vasowave.lung.witness.doubts import Doubt
from vasowave.pulse.network.network import Network
from vasowave.study.figures.look import projection_figure
from vasowave.study.figures.matplotlib_style import WIDEST, new_figure, style
from vasowave.study.figures.network import plot_network
from vasowave.study.report.review import render, settings_rows

if TYPE_CHECKING:
    from matplotlib.figure import Figure

PAGE = "review.html"
FIGURES = "figures"
SETTINGS, CENTERLINES = "extraction.json", "centerlines.json"
_TAPER = ("taper [cm/cm]", "taper_se [cm/cm]", "radius_proximal [cm]", "radius_distal [cm]")
_SHAPE = ("tortuosity", "length_sd [cm]", "contrast", "aspect", "wall [cm]")
_ENDS = tuple(f"{axis}_{end} [cm]" for end in ("proximal", "distal") for axis in "xyz")


def check_extraction_folder(folder: Path) -> None:
    """Raise `InputError` unless `folder` is missing, empty, or an earlier extraction."""
    check_folder(Path(folder), {PAGE: b'name="generator" content="vasowave'})


def write_extraction(extraction: Extraction, folder: Path) -> Path:
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
    figures = extraction_figures(extraction)
    origin = _provenance(extraction)
    drawings = {name: _picture(figure, "svg", {"Date": None}).decode() for name, figure in figures.items()}
    page = render(extraction, drawings, origin)
    with write_folder(folder) as fresh:
        write_network_files(extraction.measured, fresh, extraction.doubts)
        surface = smooth_surface(extraction.lumen)
        surface = replace(surface, points=extraction.image.frame.world(surface.points))
        write_mask(extraction.lumen, extraction.image, fresh / "mask.nrrd")
        write_surface_vtp(surface, fresh / "surface.vtp")
        write_stl(surface, fresh / "surface.stl")
        drawn = make_folder(fresh / FIGURES)
        for name, figure in figures.items():
            write_file(drawn / f"{name}.svg", drawings[name])
            write_file(drawn / f"{name}.png", _picture(figure, "png", {"Software": None}))
        stored = {
            "settings": dict(settings_rows(extraction)),
            "notes": texts(extraction.notes),
            "doubts": _stored_doubts(extraction),
            "provenance": origin,
        }
        write_file(fresh / SETTINGS, json.dumps(stored, indent=1, ensure_ascii=False) + "\n")
        write_file(fresh / PAGE, page)
    return folder / PAGE


def extraction_figures(extraction: Extraction) -> dict[str, "Figure"]:
    """Return the figures by name: projection, network."""
    network = extraction.network
    tree = extraction.tree.times(1 / extraction.factor).moved(extraction.image.frame.own)
    projection = projection_figure(isotropic(extraction.image), extraction.lumen, tree, network.name)
    with style():
        graph = network_figure(network)
        for figure in (projection, graph):  # drawn to several files: the layout is worked out once
            if engine := figure.get_layout_engine():
                engine.execute(figure)
            figure.set_layout_engine("none")
    return {"projection": projection, "network": graph}


def _picture(figure: "Figure", kind: str, made: dict[str, str | None]) -> bytes:
    content = io.BytesIO()
    with style():
        figure.savefig(content, format=kind, metadata=made)
    return content.getvalue()


def vessel_rows(measured: Measurement) -> tuple[tuple[str, ...], list[tuple[Any, ...]]]:
    """Return header and rows of `vessels.csv`: what the network table does not say of each vessel."""
    network, tree = measured.network, measured.tree
    generation = np.zeros(len(network), dtype=int)
    for level, members in enumerate(network.generations, 1):
        generation[members] = level
    free, slopes = free_length(tree), taper(tree)
    unknown = np.full(len(network), np.nan)
    grey = measured.grey
    contrast, aspect, wall = (unknown,) * 3 if grey is None else (grey.contrast, grey.aspect, grey.wall)
    tapers = np.column_stack([slopes.slope, slopes.slope_se, slopes.proximal, slopes.distal])
    header = ("name", "generation", "flow_fraction", "free_length [cm]", *_SHAPE, *_TAPER, *_ENDS)
    rows: list[tuple[Any, ...]] = []
    for row, name in enumerate(network.name):
        ends = tree.lines[row].points[[0, -1], ::-1].ravel().tolist()
        shape = (tree.lines[row].tortuosity, measured.length_sd[row], contrast[row], aspect[row], wall[row])
        numbers = [network.flow_fraction[row], free[row], *shape, *tapers[row], *ends]
        rows.append((name, int(generation[row]), *map(float, numbers)))
    return header, rows


def write_network_files(measured: Measurement, folder: Path, doubts: Sequence[Doubt] = ()) -> None:
    """Write the tables and centerlines of `measured` into `folder`."""
    write_network_table(measured, folder / "network.csv", doubts)
    write_points(measured.tree, measured.network.name, folder / "centerlines.csv")
    header, rows = vessel_rows(measured)
    text = io.StringIO()
    csv.writer(text).writerows([header, *(["" if cell != cell else cell for cell in row] for row in rows)])
    write_file(folder / "vessels.csv", text.getvalue())
    write_author_tables(measured.network, folder / "connectivity.csv", folder / "dimensions.csv")
    write_centerlines(measured.tree, folder / "centerlines.vtp", unit=0.1)
    write_swc(measured.tree, folder / "centerlines.swc")


def network_figure(network: Network) -> "Figure":
    """Return the directed graph of `network`, large enough to read its labels."""
    height = min(60.0, max(5.0, 0.9 * len(network.terminals)))
    graph = new_figure(WIDEST, height)
    plot_network(graph.subplots(), network)
    return graph


def _stored_doubts(extraction: Extraction) -> list[dict[str, Any]]:
    """Return the doubts as they are stored, the gravest first; places are x, y, z in cm, in the world."""
    return [
        {
            "grade": doubt.grade.value,
            "flow": round(doubt.flow, 4),
            "about": doubt.about,
            "code": doubt.finding.code,
            "text": doubt.text,
            "vessels": doubt.vessels,
            "places [cm]": doubt.places[:, ::-1].tolist(),
        }
        for doubt in extraction.doubts
    ]


def _provenance(extraction: Extraction) -> dict[str, str]:
    options = extraction.options
    files = [extraction.source, options.mask, options.edits, options.region]
    origin = provenance([path for path in files if isinstance(path, Path) and path.is_file()])
    if extraction.source is not None and extraction.source.is_dir():
        digest = hashlib.sha256()
        for file in sorted(path for path in extraction.source.iterdir() if path.is_file()):
            digest.update(file.read_bytes())
        origin[f"sha256 of all files in {extraction.source.name}"] = digest.hexdigest()
    return origin


def check_centerlines_folder(folder: Path) -> None:
    """Raise `InputError` unless `folder` is missing, empty, or an earlier network of centerlines."""
    check_folder(Path(folder), {CENTERLINES: b'"vasowave"'})


def write_centerline_network(
    measured: Measurement, sources: Sequence[Path], settings: Mapping[str, str | float], folder: Path
) -> None:
    """Write the network, its tables, centerlines and graph into `folder`, whole or not at all.

    Parameters
    ----------
    measured : Measurement
        See `measure.measurement.measured_alone`.
    sources : sequence of Path
        The file it comes from, and the others that were read.
    settings : mapping
        How it was read, for the record.
    folder : Path

    Raises
    ------
    InputError
        The folder holds something else or cannot be written.
    """
    folder = Path(folder).resolve()
    check_centerlines_folder(folder)
    origin = provenance(list(sources))
    with write_folder(folder) as fresh:
        write_network_files(measured, fresh)
        drawn = make_folder(fresh / FIGURES)
        with style():
            figure = network_figure(measured.network)
        for kind, made in (("svg", "Date"), ("png", "Software")):
            write_file(drawn / f"network.{kind}", _picture(figure, kind, {made: None}))
        stored = {"file": sources[0].name, "settings": dict(settings), "provenance": origin}
        write_file(fresh / CENTERLINES, json.dumps(stored, indent=1, ensure_ascii=False) + "\n")
