"""The table of vessels: a network as CSV, one row a vessel, units in the header."""

import csv
import io
import warnings
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

from vasowave.columns import Columns, read_columns
from vasowave.errors import InputError, VasowaveWarning, did_you_mean
from vasowave.files import write_file
from vasowave.network import Network, image_pressure, implausible_sizes

_ALIASES = {"vessel": "name", "id": "name", "l": "length", "r0": "radius", "r": "radius"}
_NO_PARENT = ("0", "-1", "nan", "none", "na", "n/a", "-", "root")  # how other programs write that there is no parent


def read_network(path: str | Path) -> Network:
    """Read a network from CSV (or TSV) with the columns ``name, parent, length [cm], radius [cm], pressure [mmHg]``.

    The root's parent is empty. Sizes and pressure may be in any unit that the header names. The pressure is that of the
    image, the same in every row; without the column it is not known. Other columns are ignored.

    Raises
    ------
    InputError
        As `Network`, with the line of the file; also for a missing column, a missing unit, one of another quantity, or
        pressures that differ.

    Warns
    -----
    VasowaveWarning
        If the sizes look like another unit than the one stated.

    Examples
    --------
    >>> import vasowave as vw
    >>> from pathlib import Path
    >>> _ = Path("lung.csv").write_text("name,parent,length [mm],radius [mm]\\nmain,,4.1,0.47\\nleft,main,4.5,0.26\\n")
    >>> vw.read_network("lung.csv")
    Network(2 vessels, 1 terminals, root 'main' r0 0.047 cm, total length 0.86 cm)
    """
    table = read_columns(path, _ALIASES)
    if not table.names:
        raise InputError(f"{path}: no header; the first line must read: name,parent,length [cm],radius [cm]")
    names = [row[table.require("name")] for row in table.cells]
    parents = [row[table.require("parent")] for row in table.cells]
    length = table.numbers(table.require("length"), "length")
    radius = table.numbers(table.require("radius"), "length")

    def where(row: int) -> str:
        return f"{path}, line {table.lines[row]}"

    parent = np.array(_parent_rows(names, parents, where))
    network = Network(tuple(names), parent, length, radius, where, _pressure_in(table, where))
    for message in implausible_sizes(network):
        warnings.warn(f"{path}: {message}", VasowaveWarning, stacklevel=2)
    return network


def write_network(network: Network, path: str | Path) -> None:
    """Write `network` as CSV with units in the header; `read_network` reads it back to the last bit.

    Examples
    --------
    >>> import vasowave as vw
    >>> vw.write_network(vw.control_network(), "control.csv")
    >>> len(vw.read_network("control.csv"))
    21
    """
    known = ["pressure [mmHg]"] if network.pressure else []
    text = io.StringIO()
    writer = csv.writer(text)
    writer.writerow(["name", "parent", "length [cm]", "radius [cm]", *known])
    for row, name in enumerate(network.name):
        parent = network.name[network.parent[row]] if network.parent[row] >= 0 else ""
        sizes = [network.length[row], network.radius[row], *([network.pressure] if known else [])]
        writer.writerow([name, parent, *(repr(float(size)) for size in sizes)])
    write_file(Path(path), text.getvalue())


def _pressure_in(table: Columns, where: Callable[[int], str]) -> float:
    column = table.find("pressure")
    if column is None:
        return 0.0
    values = table.numbers(column, "pressure")
    other = np.flatnonzero(values != values[0])
    if len(other):
        raise InputError(
            f"{where(int(other[0]))}: pressure {values[other[0]]:g} mmHg, but {values[0]:g} mmHg in the first row; all "
            "radii of a network were measured at one pressure"
        )
    try:
        return image_pressure(float(values[0]))
    except InputError as error:
        raise InputError(f"{where(0)}: {error}") from None


def _parent_rows(names: Sequence[str], parents: Sequence[str], where: Callable[[int], str]) -> list[int]:
    rows = {name: row for row, name in enumerate(names)}
    numbers = []
    for row, parent in enumerate(parents):
        if parent and parent not in rows:
            hint = "; leave the root's parent empty" if parent.lower() in _NO_PARENT else did_you_mean(parent, rows)
            raise InputError(f"{where(row)} (vessel '{names[row]}'): parent '{parent}' is not in the table{hint}")
        numbers.append(rows[parent] if parent else -1)
    return numbers
