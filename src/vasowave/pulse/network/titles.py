"""What programs call the columns of a table of vessels, and the units that their titles say."""

import re
from collections.abc import Sequence
from dataclasses import replace

from vasowave.base import units
from vasowave.base.errors import InputError
from vasowave.base.findings import Finding, note_kind
from vasowave.base.io.columns import Columns

SYNONYMS: dict[str, tuple[str, ...]] = {
    "name": ("name", "vessel", "vessel id", "vessel name", "segment", "segment id", "segment name", "branch",
             "branch id", "branch name", "id", "label", "edge", "edge id"),
    "parent": ("parent", "parent id", "parent name", "parent vessel", "parent vessel id", "parent segment",
               "parent segment id", "parent branch", "parent branch id", "mother", "mother id", "mother vessel",
               "mother segment", "father", "father id", "upstream vessel", "upstream segment"),
    "source": ("source", "source node", "from node", "start node", "begin node", "proximal node", "inlet node",
               "upstream node", "tail"),
    "target": ("target", "target node", "to node", "end node", "distal node", "outlet node", "downstream node", "head"),
    "node 1": ("node 1", "node1", "node1id", "node1 id", "node a", "node id src", "src", "vertex 1", "n1"),
    "node 2": ("node 2", "node2", "node2id", "node2 id", "node b", "node id dst", "dst", "vertex 2", "n2"),
    "length": ("length", "l", "branch length", "branch distance", "segment length", "vessel length", "edge length"),
    "radius": ("radius", "r", "r0", "mean radius", "radius mean", "avg radius", "average radius", "radius avg",
               "avgradiusavg", "vessel radius", "segment radius", "branch radius"),
    "diameter": ("diameter", "d", "d0", "mean diameter", "diameter mean", "avg diameter", "average diameter",
                 "diameter avg", "vessel diameter", "vessel d", "segment diameter", "branch diameter"),
    "area": ("area", "mean area", "cross sectional area", "cross section area", "cross section", "lumen area",
             "sectional area", "avgcrosssection"),
    "radius start": ("radius start", "start radius", "proximal radius", "inlet radius", "radius in"),
    "radius end": ("radius end", "end radius", "distal radius", "outlet radius", "radius out"),
    "diameter start": ("diameter start", "start diameter", "proximal diameter", "inlet diameter", "diameter in"),
    "diameter end": ("diameter end", "end diameter", "distal diameter", "outlet diameter", "diameter out"),
    "radius_sd": ("radius sd", "sd radius", "std radius", "radius std"),
    "taper_sd": ("taper sd",),
}  # fmt: skip
"""The titles that are known of each column, without unit, signs and capitals: nothing else is read as it.

Of pairs of nodes, ``from`` and ``to`` are the way of the blood, ``source`` and ``target`` are if they make one, and
``node 1`` and ``node 2`` are not.
"""

LENGTHS = ("length", "radius", "diameter", "radius start", "radius end", "diameter start", "diameter end")
TOPOLOGIES = (("parent",), ("from", "to"), ("source", "target"), ("node 1", "node 2"), ("daughters",))
"""The columns, one set of them, that say what joins vessels."""

UNDERSTOOD = note_kind("network.columns", "columns were read as {columns}")

_BY_TITLE = {title: name for name, titles in SYNONYMS.items() for title in titles}
_DAUGHTER = re.compile(r"((left|right|first|second) )?(daughter|child)( ?(id )?\d)?|daughters|children")
_VOXELS = ("px", "pixel", "pixels", "voxel", "voxels", "vox")
_NO_RADIUS = {
    "mean pixel value": "the mean of the image that skan was given; it is a radius if that was a map of distances, in "
    "the unit of its numbers"
}


def canonical_title(title: str) -> tuple[str, str]:
    """Return what a column is called here by its title without a unit in brackets, and the unit at the title's end."""
    words = plain_words(title).split()
    unit = words.pop() if len(words) > 1 and is_size_unit(words[-1]) else ""
    plain = " ".join(words)
    name = "daughters" if _DAUGHTER.fullmatch(plain) else _BY_TITLE.get(plain, "")
    return (name, unit) if name else (title, "")


def plain_words(title: str) -> str:
    """Return a title in lower case, its words with one blank between them and no other signs."""
    return " ".join(re.sub(r"[\W_]+", " ", title.casefold()).split())


def is_size_unit(text: str) -> bool:
    """Return whether a word is a unit of length or area."""
    return units.is_of(text, "length") or units.is_of(text, "area")


def understood(table: Columns) -> tuple[Columns, list[Finding]]:
    """Return a table whose columns are called as here, and how they were read where they were called otherwise.

    Voxels are no unit. Of several columns that may be the name, that is taken which holds the parents.
    """
    names, column_units = [], []
    for name, unit in zip(table.names, table.units, strict=True):
        canonical, ending = canonical_title(name)
        names.append(canonical)
        column_units.append("" if unit.casefold() in _VOXELS else unit or ending)
    _choose_name(table, names)
    if {"radius", "diameter"} & set(names):  # of which the area is another word
        names = [raw if name == "area" else name for name, raw in zip(names, table.names, strict=True)]
    renamed = replace(table, names=tuple(names), units=tuple(column_units))
    readings = [
        f"'{title.strip()}' → {name}{f' in {unit}' if unit else ''}"
        for title, name, unit in zip(table.titles, names, column_units, strict=True)
        if name in (*SYNONYMS, "from", "to", "daughters")
    ]
    return renamed, [UNDERSTOOD(columns=", ".join(readings))] if tuple(names) != table.names else []


def _choose_name(table: Columns, names: list[str]) -> None:
    """Leave one column that is the name: that which holds all parents, or the first by `SYNONYMS`."""
    candidates = [column for column, name in enumerate(names) if name == "name"]
    if len(candidates) < 2 or len({table.names[column] for column in candidates}) < len(candidates):
        return
    referring = [column for column, name in enumerate(names) if name in ("parent", "daughters")]
    references = {row[column] for row in table.cells for column in referring}
    order = SYNONYMS["name"]

    def rank(column: int) -> tuple[int, int]:
        plain = plain_words(table.names[column])
        missing = references - {row[column] for row in table.cells}
        return len(missing), order.index(plain) if plain in order else len(order)

    best = min(candidates, key=rank)
    for column in candidates:
        if column != best:
            names[column] = "second name" if table.names[column] == "name" else table.names[column]


def topology_of(names: Sequence[str]) -> tuple[str, ...]:
    """Return the columns that say what joins vessels; empty if there are none."""
    return next((titles for titles in TOPOLOGIES if set(titles) <= set(names)), ())


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
