"""Networks in the files of other programs and groups: one registry, one module a program.

A file is known by what it holds. What a network cannot hold of it (walls, beds, inflow) is said and left out.
"""

from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

from vasowave.errors import InputError
from vasowave.findings import Finding, warn
from vasowave.io.textfile import read_start, regular_file
from vasowave.network.network import Network
from vasowave.network.remarks import implausible_sizes
from vasowave.network.vessel_table import read_vessel_table
from vasowave.network_formats import first_blood, ncsu, svonesolver


class Format(NamedTuple):
    """How networks of one program are recognized and read.

    Attributes
    ----------
    name : str
    has_unit : bool
        Whether the files say in which unit their lengths are.
    recognizes : callable
        Tells from a file's path and its first bytes whether it is one.
    read : callable
        Returns the network, and what was left out; lengths times the number that it is given.
    """

    name: str
    has_unit: bool
    recognizes: Callable[[Path, bytes], bool]
    read: Callable[[Path, float], tuple[Network, list[Finding]]]


FORMATS = (
    Format("MATLAB file with dim_mat and ves_conn", False, ncsu.is_mat, ncsu.read_mat_network),
    Format("Dimensions.txt with connectivity.txt", False, ncsu.is_dimensions, ncsu.read_dimensions),
    Format("svOneDSolver input", True, svonesolver.is_input, svonesolver.read_input),
    Format("FirstBlood table of edges", True, first_blood.is_edges, first_blood.read_edges),
)
"""Every format but the table of vessels, which is taken where no other is recognized."""


def read_network(path: str | Path, unit: str | None = None) -> Network:
    """Read a network: a table of vessels, or a file of another program (`FORMATS`).

    Parameters
    ----------
    path : path
        A table (CSV, TSV, Excel) as of `read_vessel_table`; a MATLAB file with ``dim_mat`` and ``ves_conn``;
        ``Dimensions.txt`` or ``connectivity.txt``, which lie in one folder; the input of svOneDSolver; FirstBlood's
        table of edges.
    unit : str, optional
        Unit of lengths and radii (``mm``, or the edge of a voxel, ``0.0036 cm``), for files that do not say it.

    Raises
    ------
    InputError
        As `Network` and `read_vessel_table`; a file that does not say its unit, if none is given, and one that does,
        if one is; a network with loops.

    Warns
    -----
    VasowaveWarning
        What a network cannot hold of the file; sizes that look like another unit; see `read_vessel_table`.

    Examples
    --------
    >>> import vasowave as vw
    >>> from pathlib import Path
    >>> rows = ["name,parent,length [mm],radius [mm]", "main,,4.1,0.5", "left,main,4.5,0.3", "right,main,3.7,0.4", ""]
    >>> _ = Path("lung.csv").write_text("\\n".join(rows))
    >>> vw.read_network("lung.csv")
    Network(3 vessels, 2 terminals, root 'main' r0 0.05 cm, total length 1.23 cm)
    >>> _ = Path("Dimensions.txt").write_text("4.1 0.5 0.5\\n4.5 0.3 0.3\\n3.7 0.4 0.4\\n")
    >>> _ = Path("connectivity.txt").write_text("0 1 2 0\\n1 0 0 0\\n2 0 0 0\\n")
    >>> vw.read_network("Dimensions.txt", unit="mm")
    Network(3 vessels, 2 terminals, root '0' r0 0.05 cm, total length 1.23 cm)
    """
    path = regular_file(path)
    start = read_start(path)
    form = next((form for form in FORMATS if form.recognizes(path, start)), None)
    if form is None or form.has_unit:
        if unit is not None:
            raise InputError(f"{path}: says the unit of its lengths itself; leave out the unit '{unit}'")
        if form is None:
            return read_vessel_table(path)
    elif unit is None:
        raise InputError(
            f"{path}: a {form.name} does not say the unit of its lengths; give it, as mm or as the edge of a voxel: "
            "`vasowave tidy FILE --unit '0.0036 cm' -o network.csv`, or read_network(path, unit='mm')"
        )
    network, left_out = form.read(path, ncsu.scale_of(unit) if unit is not None else 1.0)
    for one in (*left_out, *implausible_sizes(network)):
        warn(one.at(str(path)))
    return network


__all__ = ["FORMATS", "Format", "read_network"]
