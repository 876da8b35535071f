"""Tubes of ITK and TubeTK (.tre): a header and a table of points for each vessel, those nearer to the root first."""

import re
from pathlib import Path

import numpy as np

from vasowave.base.errors import InputError
from vasowave.base.io.textfile import read_bytes
from vasowave.lung.axes.skeleton import Skeleton
from vasowave.lung.exchange.formats import LINES, LinesFormat
from vasowave.lung.exchange.markups import tree_of
from vasowave.lung.exchange.swc import require_radii
from vasowave.lung.tree import Line

_TUBE = re.compile(r"^ObjectType *= *Tube\b(.*?)^Points *=\s*?\n(.*?)(?=^ObjectType|\Z)", re.MULTILINE | re.DOTALL)
_FIELD = re.compile(r"^(\w+) *= *(.*?)\s*$", re.MULTILINE)


def read_tubes(path: Path, unit: float) -> Skeleton:
    """Return the tree of the tubes in a file of MetaIO whose unit of length is `unit`, cm, spacing included.

    Raises
    ------
    InputError
        No tube, one without numbers as text for x, y, z and r of as many points as it announces.
    """
    tubes = _TUBE.findall(read_bytes(path).decode("latin-1").replace("\r\n", "\n"))
    if not tubes:
        raise InputError(f"{path}: no tube whose points are text; save the tubes with BinaryData = False")
    try:
        lines = [_line(dict(_FIELD.findall(head)), rows, unit) for head, rows in tubes]
    except (ValueError, IndexError, KeyError) as error:
        raise InputError(f"{path}: not tubes of ITK or TubeTK, or damaged ({error}); save them again") from None
    for line in lines:
        require_radii(path, line)
    return tree_of(path, lines)


def _line(fields: dict[str, str], rows: str, unit: float) -> Line:
    """Return the points of one tube."""
    titles = fields["PointDim"].split()
    table = np.array([row.split() for row in rows.splitlines() if row.strip()], dtype=float)
    if len(table) != int(fields["NPoints"]) or len(table) < 2:
        raise ValueError(f"{len(table)} points of {fields['NPoints']}")
    spacing = np.array(fields.get("ElementSpacing", "1 1 1").split(), dtype=float)
    places = table[:, [titles.index(title) for title in "xyz"]] * spacing
    return Line(unit * places[:, ::-1], unit * spacing[0] * table[:, titles.index("r")])


LINES.register(LinesFormat("tubes", "tubes of TubeTK", (".tre",), None, lambda path, unit, cut: read_tubes(path, unit)))
