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

_OBJECT = re.compile(r"^ObjectType *= *", re.MULTILINE)
_POINTS = re.compile(r"^Points *= *\n", re.MULTILINE)
_FIELD = re.compile(r"^(\w+) *= *(.*?)\s*$", re.MULTILINE)


def read_tubes(path: Path, unit: float) -> Skeleton:
    """Return the tree of the tubes in a file of MetaIO; `InputError` unless all are text and as many as announced."""
    _, *objects = _OBJECT.split(read_bytes(path).decode("latin-1").replace("\r\n", "\n"))
    try:
        announced = dict(_FIELD.findall(objects[0])).get("NObjects", str(len(objects) - 1))
        lines = [_line(text, unit) for text in objects if not text.startswith(("Scene\n", "Group\n"))]
        if not lines or int(announced) != len(objects) - 1:
            raise ValueError(f"{len(objects) - 1} objects of {announced}")
    except (ValueError, IndexError, KeyError) as error:
        hint = "save them again, with BinaryData = False"
        raise InputError(f"{path}: not tubes of ITK or TubeTK as text, or damaged ({error}); {hint}") from None
    for line in lines:
        require_radii(path, line)
    return tree_of(path, lines)


def _line(text: str, unit: float) -> Line:
    """Return the points of one tube; `ValueError` unless it is one."""
    head, rows = _POINTS.split(text)
    fields = dict(_FIELD.findall(head))
    titles = fields["PointDim"].split()
    table = np.array([row.split() for row in rows.splitlines() if row.strip()], dtype=float)
    if not head.startswith("Tube\n") or len(table) != int(fields["NPoints"]) or len(table) < 2:
        raise ValueError(f"{len(table)} points of {fields['NPoints']} of {head.partition(chr(10))[0]}")
    spacing = np.array(fields.get("ElementSpacing", "1 1 1").split(), dtype=float)
    places = table[:, [titles.index(title) for title in "xyz"]] * spacing
    return Line(unit * places[:, ::-1], unit * spacing[0] * table[:, titles.index("r")])


LINES.register(LinesFormat("tubes", "tubes of TubeTK", (".tre",), None, lambda path, unit, cut: read_tubes(path, unit)))
