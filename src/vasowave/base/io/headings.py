"""Titles of a table and the units in them, below them, or listed above them."""

import csv
import re
from collections.abc import Sequence

from vasowave.base import units
from vasowave.base.io.cells import is_numeric
from vasowave.base.io.clocks import bare

_HEADING = re.compile(r"^\s*(?P<name>.*?)\s*(?:[\[(]\s*(?P<unit>[^\])\[(]*)[\])])?\s*$")
_BLANK_SEPARATED = re.compile(r"[^\s\[(]+(?:\s*[\[(][^\])]*[\])])?")
_CLOCK_UNIT = re.compile(r"[hmsdyaHMSDYT:.,/ -]*[:.][hmsHMS:.,/ -]*|date|time|ddd+", re.IGNORECASE)
_SIGNALS = ("pressure", "flow", "voltage", "velocity", "volume", "relative volume")
_TITLE_KEYS = ("signal", "signals", "channel", "channels", "tracename")
_UNIT_KEYS = ("vert_units", "units", "unit", "vunit")
_TIMES = ("t", "time", "timestamp", "elapsed_time")
_DOTTED = re.compile(r"[^\W\d_][\w.]*\.[\w.]*")  # R writes a dot for each sign that names may not have
_LISTED = re.compile(r'"columns?": ?\[([^\]]*)\]')  # OpenSignals writes JSON
_TYPED = re.compile(r"(?<=[^\s:]):(?:float|double|int|long|string)(?:\[\])?$")  # as Neo4j writes its columns
_GLUED = re.compile(r"^([mµu]?l)(?:p|per)?/?(s|sec|min)$", re.IGNORECASE)  # as names without a stroke have it
_NUMBERED = re.compile(r"#?\s*col(?:umn)?\.?:?\s*(\d+)\s*[:=,]\s*(.+)", re.IGNORECASE)


def with_unit_labels(titles: Sequence[str], above: Sequence[str], separator: str | None) -> list[str]:
    """Return titles with the units that LabVIEW writes above them, one for each column behind that of the times."""
    rows = (text.split(separator) for text in above if text.startswith("Y_Unit_Label"))
    labels = dict(enumerate(cell.strip() for cell in next(rows, [])))
    return [f"{title} [{labels[i]}]" if i and units.is_unit(labels.get(i, "")) and not has_unit(title) else title
            for i, title in enumerate(titles)]  # fmt: skip


def listed_titles(above: Sequence[str], named: Sequence[str], width: int) -> list[str]:
    """Return titles whose channels are listed line by line, title and unit in turn, below a number of channels."""
    count = next((i for i, text in enumerate(above) if re.fullmatch(r"\d+ channels?\W*", text.strip())), None)
    if count is None:
        return []
    channels = int(re.findall(r"\d+", above[count])[0])
    lines = [bare(text.rstrip(" \t;,")) for text in above[count + 1 : count + 1 + 2 * channels]]
    if len(lines) < 2 * channels or width not in (channels, channels + 1):
        return []
    titles = [f"{title} [{unit}]" for title, unit in zip(lines[::2], lines[1::2], strict=True)]
    return titles if width == channels else [f"time [{named[0] if named else ''}]", *titles]


def keyed_titles(above: Sequence[str], separator: str | None, width: int) -> list[str]:
    """Return titles that stand in a line behind a word for them, with units in another: of HIOKI and Yokogawa."""
    rows = [[bare(cell) for cell in csv_cells(text, separator)] for text in above] if separator else []
    keyed = {cells[0].casefold(): [cell for cell in cells[1:] if cell] for cells in rows if len(cells) > 1}
    titles, named = (next((keyed[key] for key in keys if key in keyed), []) for keys in (_TITLE_KEYS, _UNIT_KEYS))
    if len(titles) == width - 1 and keyed.get("horz_units"):
        titles, named = ["time", *titles], [*keyed["horz_units"][:1], *named]
    if "tracename" in keyed:  # the first cell of its rows is empty
        titles, named = ["", *titles], ["", *named]
    if len(titles) != width:
        return []
    named = named if len(named) == width else [""] * width
    return [f"{title} [{unit.lower() if unit == 'S' else unit}]" if unit and not has_unit(title) else title
            for title, unit in zip(titles, named, strict=True)]  # fmt: skip


def remarked_titles(remarks: Sequence[str], separator: str | None, width: int) -> list[str]:
    """Return titles that stand in lines which begin with ``#``: one a column, or all in the last of them."""
    numbered = [match[2].strip() for text in remarks if (match := _NUMBERED.match(text.strip()))]
    if len(numbered) == width:
        return numbered
    listed = [re.findall(r'"([^"]*)"', match[1]) for text in remarks if (match := _LISTED.search(text))]
    if len(listed) == 1 and len(listed[0]) in (width, width - 1):  # a mark may end its rows
        return listed[0]
    last = remarks[-1].lstrip("# ") if remarks else ""
    cells = split_titles(last) if separator is None else csv_cells(last, separator)
    return [cell.strip() for cell in cells] if len(cells) == width > 1 and not any(map(is_numeric, cells)) else []


def is_titled_in(title: str, quantity: str) -> bool:
    """Whether a title says a unit of a quantity."""
    heading = split_title(title)
    return heading is not None and heading[1] is not None and units.is_of(heading[1], quantity)


def with_unit_row(titles: Sequence[str], below: str, separator: str | None) -> list[str] | None:
    """Return column titles with the units of the line below them, None if that line names no units or they do."""
    pieces = below.split() if separator is None and len(below.split()) == len(titles) else split_titles(below)
    cells = [cell.strip(" []()\"'") for cell in (below.split(separator) if separator else pieces)]
    cells += [""] * (len(titles) - len(cells))
    named = [cell for cell in cells if cell not in ("", "-")]
    united = [cell for cell in named if units.is_unit(cell) or _CLOCK_UNIT.fullmatch(cell)]
    mostly = 2 * len(united) > len(named)
    if len(cells) != len(titles) or not mostly or any(map(is_numeric, named)):
        return None
    if any(has_unit(title) and cell in named for title, cell in zip(titles, cells, strict=True)):
        return None
    return [f"{title} [{unit}]" if unit in named and not _CLOCK_UNIT.fullmatch(unit) else title
            for title, unit in zip(titles, cells, strict=True)]  # fmt: skip


def split_title(title: str) -> tuple[str, str | None] | None:
    """Return name and unit of ``name [unit]``, ``name (unit)``, ``name/unit``, ``name, unit``, ``name_mmHg`` or, as R
    writes brackets, ``name..mmHg.``; None if it is none.

    A stroke, as standards of quantities write it, or a comma is one between name and unit only where a unit follows it.
    Of two brackets the last holds the unit.
    """
    match = _HEADING.match(_TYPED.sub("", title))
    if match is None or title.count("[") != title.count("]") or title.count("(") != title.count(")"):
        return None
    name, unit = match["name"], match["unit"]
    if unit is not None:
        return name.removesuffix("/").strip(), unit
    behind_comma = name.rpartition(",")
    pairs = [behind_comma] if units.is_unit(behind_comma[2].strip()) else [name.partition("/")]
    for prefix, mark, right in pairs:
        if mark and prefix.strip() and not units.is_unit(prefix.strip()) and units.is_unit(right.strip()):
            return prefix.strip(), right.strip()
    plain = re.sub(r"\.+", "_", name) if _DOTTED.fullmatch(name) else name
    underlined = plain.strip("_") if " " not in name else name  # MATLAB writes 'PAP (mmHg)' as PAP_mmHg_
    quantities = ("pressure", "flow", "time") if underlined.lower().rpartition("_")[0] in _TIMES else _SIGNALS
    written, ending = ending_unit(underlined, quantities, "_")
    return (written, ending) if ending else (name, None)


def ending_unit(title: str, quantities: Sequence[str], mark: str = " ") -> tuple[str, str]:
    """Return a title without the unit of one of some quantities that its last words are, and that unit.

    Words stand between marks, and those of a ratio, too: ``flow_ml_s``, ``flow_L_per_min``, ``radius in mm``.
    ``pa`` is no pascal, but the pulmonary artery.
    """
    words = title.split(mark)
    if len(words) > 3 and words[-2].lower() == "per":
        words = [*words[:-2], words[-1]]
    for count in (2, 1):
        unit, before = _GLUED.sub(r"\1/\2", "/".join(words[-count:])), words[:-count]
        if unit == "pa" or unit == "PA" or not any(before):
            continue
        if any(units.is_of(unit, quantity) for quantity in quantities) and unit.lower() != "v":
            return mark.join(before[:-1] if before[-1] == "in" and len(before) > 1 else before), unit
    return title, ""


def has_unit(title: str) -> bool:
    """Whether a title says a unit of any quantity."""
    heading = split_title(title)
    return heading is not None and heading[1] is not None and units.is_unit(heading[1])


def split_titles(first: str) -> list[str]:
    """Return the titles of a table that is separated by blanks: they hold blanks too ("pressure [mmHg]")."""
    return _BLANK_SEPARATED.findall(first)


def csv_cells(text: str, separator: str) -> list[str]:
    """Return the cells of a line of titles, quotation marks minded where they can be."""
    try:
        return [cell for row in csv.reader([text], delimiter=separator, strict=True) for cell in row]
    except csv.Error:
        return text.split(separator)
