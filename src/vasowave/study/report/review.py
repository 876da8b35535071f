"""The page to review one extraction: the tree in space, projections, graph, vessels, settings, and proposed edits."""

import base64
import json
from dataclasses import fields
from typing import NamedTuple

import numpy as np

from vasowave.base.findings import texts
from vasowave.base.io.textfile import read_lines
from vasowave.lung.extraction import Extraction
from vasowave.lung.measure.measurement import taper
from vasowave.lung.options import grey_text
from vasowave.lung.places import voxel_text, written
from vasowave.lung.witness.doubts import Grade, gravest
from vasowave.lung.witness.witness import UNEVEN
from vasowave.study.report.html import templates

_CAPTIONS = {
    "projection": (
        "The image and the network",
        "Brightest voxel along each axis of the image (grey), outline of the lumen, and the vessels, named where there "
        "are at most 60.",
    ),
    "network": (
        "The network as a directed graph",
        "Each vessel with its share of the mean flow (eq. 11); width follows the radius, lengths are not to scale.",
    ),
}
_MOST_POINTS = 40  # of a vessel in the page's view


class Proposals(NamedTuple):
    """Edits that are proposed; none is made unless a person takes it up."""

    edits: list[str]
    """Lines of a file of edits, each a comment: why, then the edit."""
    outlets: np.ndarray
    """Ends that only the second tree of the lumen has, z, y, x, cm, in the world. Shape (outlet, 3)."""


def proposals(extraction: Extraction) -> Proposals:
    """Return what would answer the doubts about the topology.

    A doubted end may be removed and a doubted inner vessel merged into a point; a place where the tree has neither is
    an end that it lacks.
    """
    tree, names = extraction.tree.times(1 / extraction.factor), extraction.network.name
    ends = np.array([line.points[-1] for line in tree.lines])
    edits: list[str] = []
    outlets: list[np.ndarray] = []
    for doubt in (candidate for candidate in extraction.doubts if candidate.about == "topology"):
        lines = []
        for place in doubt.places:
            row = int(np.argmin(np.linalg.norm(ends - place, axis=1)))
            if not np.allclose(ends[row], place, atol=1e-9) or names[row] not in doubt.vessels:
                outlets.append(place)
                continue
            action = "remove" if row in tree.terminals else "merge"
            point = ends[row] if action == "remove" else tree.lines[row].points[len(tree.lines[row]) // 2]
            lines.append(f"# {action} {written(point).replace(',', ' ')}   # vessel {names[row]}")
        fresh = [line for line in lines if line not in edits]
        reason = doubt.text if len(doubt.text) < 110 else f"{doubt.text[:108]} …"
        edits += [f"# {reason}", *fresh] if fresh else []
    return Proposals(edits, np.array(outlets).reshape(-1, 3))


def render(extraction: Extraction, drawings: dict[str, str], origin: dict[str, str]) -> str:
    """Return the page as HTML text with view and numbers inside; it needs no network.

    Parameters
    ----------
    extraction : Extraction
    drawings : dict of str
        The figures by name, as SVG text.
    origin : dict of str
        Provenance.
    """
    environment = templates()
    suggested = proposals(extraction)
    network = extraction.network
    scale = "not measured"
    if extraction.options.cannula:
        scale = f"{100 * (extraction.scale - 1):+.1f} %"
    return environment.get_template("review.html").render(
        source=_source(extraction),
        sentence=f"{len(network)} vessels, {len(network.terminals)} of them terminal, in {len(network.generations)} "
        f"generations; total length {_number(network.length.sum())} cm; root {network.name[network.root]} with "
        f"a radius of {_number(network.radius[network.root])} cm. Scale of the cannula against the file: {scale}"
        f"{', applied' if extraction.options.scale == 'cannula' else ''}.",
        notes=texts(extraction.notes),
        doubts=[(doubt.grade.value, f"{100 * doubt.flow:.0f} %", doubt.text) for doubt in extraction.doubts],
        actions=("remove", "cut", "merge", "root"),
        edits=_edits_text(extraction),
        proposals=suggested.edits,
        missing=len(suggested.outlets),
        figures=[
            {
                "name": name,
                "title": _CAPTIONS[name][0],
                "caption": _CAPTIONS[name][1],
                "svg": base64.b64encode(drawing.encode()).decode(),
            }
            for name, drawing in drawings.items()
        ],
        table_caption="Radius: densitometric, or inscribed where the vessel is too short (not reliable). SD: over "
        "thresholds of 0.8, 1 and 1.2 times the chosen one, and of the grey levels. Misfit: how far half of the "
        "lumen's surface lies from a round tube at least, in percent of the radius; it is doubted above "
        f"{100 * UNEVEN:g}. Aspect: small over large half axis of the section. Taper: fall of the radius per length. "
        "Doubted: the gravest grade, and what it is about; orange: wrong or to be looked at. Both estimators of the "
        "radius stand in network.csv.",
        table=_page_table(extraction),
        settings=settings_rows(extraction),
        provenance=origin,
        tree=_tree_data(extraction, suggested.outlets),
    )


def _number(value: float, digits: int = 3) -> str:
    return f"{float(value):.{digits}g}" if np.isfinite(value) else "–"


def _page_table(extraction: Extraction) -> tuple[tuple[str, ...], list[tuple[str, ...]]]:
    """Return header and rows; the last cell says what is doubted."""
    network, measured = extraction.network, extraction.measured
    slopes = taper(measured.tree)
    aspect = np.full(len(network), np.nan) if measured.grey is None else measured.grey.aspect
    header = ("vessel", "parent", "length [cm]", "SD [cm]", "radius [cm]", "SD [cm]", "reliable", "misfit [%]",
              "aspect", "tortuosity", "taper [cm/cm]", "flow [%]", "doubted")  # fmt: skip
    rows: list[tuple[str, ...]] = []
    for row, name in enumerate(network.name):
        parent = network.name[network.parent[row]] if network.parent[row] >= 0 else "–"
        rows.append(
            (name, parent, _number(network.length[row]), _number(measured.length_sd[row], 2),
             _number(network.radius[row]),
             _number(measured.radius_sd[row], 2), "yes" if measured.reliable[row] else "no",
             _number(100 * extraction.misfit[row], 2), _number(aspect[row], 2),
             _number(measured.tree.lines[row].tortuosity, 4), _number(slopes.slope[row], 2),
             _number(100 * network.flow_fraction[row]),
             _doubted(extraction, name))
        )  # fmt: skip
    return header, rows


def _doubted(extraction: Extraction, vessel: str) -> str:
    """Return the gravest grade of the doubts about a vessel, and what they are about; empty without one."""
    grade = gravest(extraction.doubts, vessel)
    about = sorted({doubt.about for doubt in extraction.doubts if vessel in doubt.vessels})
    return "" if grade is None else f"{grade.value}: {', '.join(about)}"


def _edits_text(extraction: Extraction) -> str:
    """Return the edits that were applied, as they stand in their file, so that new ones come after them."""
    path = extraction.options.edits
    return "" if path is None else "\n".join(text for block in read_lines(path) for text in block.texts).strip() + "\n"


def _source(extraction: Extraction) -> str:
    return "an image that was given as such" if extraction.source is None else str(extraction.source)


def _tree_data(extraction: Extraction, ends: np.ndarray) -> str:
    network, vessels = extraction.network, []
    terminals = set(network.terminals.tolist())
    for row, line in enumerate(extraction.tree.lines):
        indices = np.unique(np.linspace(0, len(line) - 1, min(len(line), _MOST_POINTS)).round().astype(int))
        points = np.round(np.column_stack([line.points[indices, ::-1], line.radius[indices]]), 5).tolist()
        sizes = {"radius": _number(network.radius[row]), "length": _number(network.length[row])}
        name = network.name[row]
        sizes["doubts"] = "; ".join(doubt.text for doubt in extraction.doubts if name in doubt.vessels)
        marked = gravest(extraction.doubts, name) in (Grade.WRONG, Grade.LOOK)
        vessels.append({"name": name, "terminal": row in terminals, "points": points, "marked": marked, **sizes})
    # A name may hold "</script>".
    root = np.round(extraction.factor * extraction.root[::-1], 5).tolist()
    doubted = [doubt.places[:, ::-1] for doubt in extraction.doubts if doubt.about == "topology"]
    marks = [place for doubt_places in doubted for place in np.round(extraction.factor * doubt_places, 5).tolist()]
    missing = np.round(extraction.factor * ends[:, ::-1], 5).tolist()
    data = {"factor": extraction.factor, "root": root, "vessels": vessels, "doubts": marks, "missing": missing}
    return json.dumps(data).replace("<", "\\u003c")


def settings_rows(extraction: Extraction) -> list[tuple[str, str]]:
    """Return what the user asked for, by name, as text."""
    rows = [
        ("image", _source(extraction)),
        ("root used (x,y,z, cm)", written(extraction.root)),
        ("scale factor", f"{extraction.factor:.5g}"),
    ]
    if extraction.image.provenance:
        rows.append(("voxel size by", extraction.image.provenance))
    for entry in fields(extraction.options):
        value = getattr(extraction.options, entry.name)
        if value is None or entry.name == "root":
            continue
        if entry.name == "grey":
            value = grey_text(value)
        elif entry.name == "voxel":
            value = voxel_text(value)
        elif isinstance(value, tuple | list | np.ndarray):
            value = "; ".join(written(point) for point in np.atleast_2d(value))
        rows.append((entry.name.replace("_", " "), str(value)))
    return rows
