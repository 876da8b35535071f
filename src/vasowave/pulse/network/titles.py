"""What programs call the columns of a table of vessels, and the units that their titles say."""

import math
import re
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from vasowave.base.errors import InputError
from vasowave.base.findings import Finding, note_kind
from vasowave.base.io.cells import is_numeric
from vasowave.base.io.columns import Columns
from vasowave.base.io.headings import ending_unit

SYNONYMS: dict[str, str] = {
    "parent": "parent mother father mutter elter eltern vorgänger vater parente padre madre père mère genitore",
    "daughter": "daughter daughters child children",
    "length": "length len l länge laenge longueur longitud lunghezza",
    "radius": "radius rad r r0 rayon radio raggio",
    "diameter": "diameter diam d d0 durchmesser ø ⌀ diamètre diametre diámetro diametro",
    "area": "area",
    "start": "start begin beginning initial anfang beginn proximal inlet in top",
    "end": "end ending final ende distal outlet out bottom bot",
    "node": "node vertex n",
    "": "vessel gefäss gefaess ast vaisseau vaso segment seg branch edge artery id no nr number index name label mean "
    "average avg inner lumen internal cross sectional section arc path curve centerline equivalent",
}
"""The words that are known of each part of a title; those of the last row say nothing more."""

_COLUMNS = {
    "parent": "parent", "upstream": "parent", "length": "length", "radius": "radius", "diameter": "diameter",
    "area": "area", "radius start": "radius start", "end radius": "radius end", "diameter start": "diameter start",
    "diameter end": "diameter end", "radius sd": "radius_sd", "sd taper": "taper_sd", "source": "source",
    "target": "target", "start": "source", "end": "target", "node start": "source", "end node": "target",
    "node parent": "source", "daughter node": "target",
    "node source": "source", "node target": "target", "from node": "from", "node to": "to", "src": "node 1",
    "node src": "node 1", "1 node": "node 1", "u": "node 1", "dst": "node 2", "dst node": "node 2",
    "2 node": "node 2", "v": "node 2",
}  # fmt: skip
"""What columns are called here, by the parts of their titles in the order of the alphabet.

Of pairs of nodes, ``from`` and ``to`` are the way of the blood, ``source`` and ``target`` are if they make one, and
``node 1`` and ``node 2`` are not.
"""

LENGTHS = ("length", "radius", "diameter", "radius start", "radius end", "diameter start", "diameter end")
TOPOLOGIES = (("parent",), ("from", "to"), ("source", "target"), ("node 1", "node 2"), ("daughters",))
"""The columns, one set of them, that say what joins vessels."""

UNDERSTOOD = note_kind("network.columns", "columns were read as {columns}")

_CONCEPTS = {word: concept for concept, words in SYNONYMS.items() for word in words.split()}
_NAMES = ("vessel", "gefäss", "gefaess", "ast", "vaisseau", "vaso", "segment", "branch", "edge", "artery", "id", "name",
          "label", "no", "nr")  # fmt: skip
_JOINED = "|".join(sorted((word for word in [*_CONCEPTS, "upstream"] if len(word) > 1), key=len, reverse=True))
_BRANCH_DISTANCE = ("branch distance", "branchdistance")  # skan's length along a branch
_VOXELS = ("px", "pixel", "pixels", "voxel", "voxels", "vox")
_NO_RADIUS = dict.fromkeys(
    ("mean pixel value", "average intensity"),  # of skan and AnalyzeSkeleton
    "the mean of the image along the skeleton; it is a radius if that was a map of distances, in the unit of its "
    "numbers",
)

_FARTHEST = 1e100  # in whatever unit: no place is farther
_SAME_PLACE = 1e-5
"""Share of the size of a tree within which two places are one: programs round them."""

_NO_END = {"direction", "dir", "axis", "normal", "tangent", "vector", "orientation", "center", "centre", "size"}
"""Words of a triple of columns that is no end of a vessel."""


def canonical_title(title: str) -> tuple[str, str]:
    """Return what a column is called here by its title without a unit in brackets, and the unit at the title's end."""
    name, unit = ending_unit(plain_words(title), ("length", "area"))
    words = name.split()
    if " ".join(words) in _BRANCH_DISTANCE:
        return "length", unit
    words = [piece for word in words for piece in _pieces(word)]
    concepts = sorted(concept for word in words if (concept := _CONCEPTS.get(word, word)))
    if "daughter" in concepts and set(concepts) <= {"daughter", "left", "right", "first", "second", "1", "2", "3"}:
        name = "daughters"
    else:
        name = _COLUMNS.get(" ".join(concepts), "")
    if not concepts and any(word in _NAMES for word in words):
        name = "name"
    return (name, unit) if name else (title, "")


def _pieces(word: str) -> list[str]:
    """Return the known words and numbers that a word is made of, as ``node1id``; itself, if it is not."""
    if word in _CONCEPTS or not re.fullmatch(rf"(?:{_JOINED}|\d+)+", word):
        return [word]
    return re.findall(rf"{_JOINED}|\d+", word)


def plain_words(title: str) -> str:
    """Return a title in lower case, its words with one blank between them and no other signs."""
    return " ".join(re.sub(r"[\W_]+", " ", title.casefold()).split())


def ends_by_places(names: Sequence[str]) -> list[list[int]]:
    """Return the columns of x, y and z (or r, a and s) of both ends of a vessel; nothing unless there are just two."""
    ends: dict[str, dict[str, int]] = {}
    for column, name in enumerate(names):
        words = plain_words(name)
        if match := re.fullmatch(r"(?P<end>.+) (?P<axis>[xyzras])|(?P<first>[xyz])(?P<number>\d)", words):
            end, axis = match["end"] or match["number"], match["axis"] or match["first"]
            ends.setdefault(end, {})[axis] = column
    complete = [[axes[axis] for axis in kind] for end, axes in ends.items() for kind in ("xyz", "ras")
                if set(axes) == {*kind} and not _NO_END & set(end.split())]  # fmt: skip
    return complete if len(complete) == 2 else []


def _joints(ends: Sequence[Sequence[Sequence[str]]]) -> list[list[str]]:
    """Return the names of the nodes at places, of both ends a list: those of one place have one, the first's cells.

    Places are one where they are closer than `_SAME_PLACE` of the size of the tree, wherever that stands; a node
    without a place has no name.
    """
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components
    from scipy.spatial import cKDTree

    texts = [cells for end in ends for cells in end]
    places = np.array([[_coordinate(cell) for cell in cells] for cells in texts])
    placed = np.flatnonzero((np.abs(places) < _FARTHEST).all(axis=1))  # a gap is not a place either
    if not len(placed):
        return [[""] * len(end) for end in ends]
    places = places[placed] - places[placed[0]]
    pairs = cKDTree(places).query_pairs(_SAME_PLACE * float(np.ptp(places, axis=0).max()), output_type="ndarray")
    joined = coo_array((np.ones(len(pairs)), tuple(pairs.T)), shape=2 * (len(placed),))
    joint = connected_components(joined, directed=False)[1]
    names = [""] * len(texts)
    first: dict[int, int] = {}
    for row, group in zip(placed.tolist(), joint.tolist(), strict=True):
        names[row] = " ".join(texts[first.setdefault(group, row)])
    return [names[: len(ends[0])], names[len(ends[0]) :]]


def _coordinate(cell: str) -> float:
    return float(cell.replace(",", ".")) if is_numeric(cell) else math.nan


def _with_nodes(table: Columns) -> Columns:
    """Return a table with nodes where its vessels begin and end, by the places of both that it says."""
    ends = ends_by_places(table.names)
    if not ends:
        return table
    nodes = _joints([[[row[i].strip() for i in end] for row in table.cells] for end in ends])
    added = [", ".join(table.titles[i].strip() for i in end) for end in ends]
    cells = tuple((*row, *pair) for row, pair in zip(table.cells, zip(*nodes, strict=True), strict=True))
    return replace(table, names=(*table.names, "node 1", "node 2"), units=(*table.units, "", ""), cells=cells,
                   titles=(*table.titles, *added))  # fmt: skip


def understood(table: Columns) -> tuple[Columns, list[Finding]]:
    """Return a table whose columns are called as here, and how they were read where they were called otherwise.

    Voxels are no unit. Of several columns that may be the name, that is taken which holds the parents.
    """
    titled, places = table.names, set[str]()
    if not topology_of([canonical_title(name)[0] for name in titled]):
        table, places = _with_nodes(table), {titled[i] for end in ends_by_places(titled) for i in end}
    names, column_units = [], []
    for name, unit in zip(table.names, table.units, strict=True):
        canonical, ending = canonical_title(name) if name not in places else (name, "")
        names.append(canonical)
        column_units.append("" if unit.casefold() in _VOXELS else unit or ending)
    _choose_name(table, names)
    if {"radius", "diameter"} & set(names):  # of which the area is another word
        names = [raw if name == "area" else name for name, raw in zip(names, table.names, strict=True)]
    renamed = replace(table, names=tuple(names), units=tuple(column_units))
    readings = [
        f"'{title.strip()}' → {name}{f' in {unit}' if unit else ''}"
        for title, name, unit in zip(table.titles, names, column_units, strict=True)
        if name in (*_COLUMNS.values(), "name", "from", "to", "daughters")
    ]
    return renamed, [UNDERSTOOD(columns=", ".join(readings))] if tuple(names) != titled else []


def _choose_name(table: Columns, names: list[str]) -> None:
    """Leave one column that is the name: that which holds all parents, or the first."""
    candidates = [column for column, name in enumerate(names) if name == "name"]
    if len(candidates) < 2 or len({table.names[column] for column in candidates}) < len(candidates):
        return
    referring = [column for column, name in enumerate(names) if name in ("parent", "daughters")]
    references = {row[column] for row in table.cells for column in referring}
    best = min(candidates, key=lambda column: len(references - {row[column] for row in table.cells}))
    for column in candidates:
        if column != best:
            names[column] = "second name" if table.names[column] == "name" else table.names[column]


def topology_of(names: Sequence[str]) -> tuple[str, ...]:
    """Return the columns that say what joins vessels; empty if there are none."""
    return next((titles for titles in TOPOLOGIES if set(titles) <= set(names)), ())


def is_size(title: str) -> bool:
    """Return whether a title is that of a length or a width of vessels."""
    return canonical_title(title)[0] in LENGTHS


def says_unit(table: Columns) -> bool:
    """Return whether any size of a table has a unit."""
    sizes = (*LENGTHS, "area", "radius_sd")
    return any(unit for name, unit in zip(table.names, table.units, strict=True) if name in sizes)


def require_width(table: Columns, titles: str) -> None:
    """Raise `InputError` unless a column says how wide vessels are, with what the other columns do not say."""
    if any(name in table.names for name in ("radius", "diameter", "area", "radius start", "diameter start")):
        return
    for name, title in zip(table.names, table.titles or table.names, strict=True):
        words = plain_words(name)
        if words in _NO_RADIUS:
            raise InputError(
                f"{table.source}: no column 'radius'; '{title.strip()}' is {_NO_RADIUS[words]}: then call the column "
                f"'radius [mm]', with that unit. The header has: {', '.join(table.titles)}"
            )
    table.require("radius", titles=titles)
