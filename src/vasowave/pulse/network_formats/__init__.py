"""The formats of networks: one module a program or group, which registers what it reads; a further one needs no more.

A file is known by what it holds. What a network cannot hold of it (walls, beds, inflow) is said and left out.
"""

import re
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import NoReturn

import numpy as np

from vasowave.base.cures import SetOption, Tidy
from vasowave.base.errors import InputError
from vasowave.base.findings import Finding, warn
from vasowave.base.io.columns import Columns, number
from vasowave.base.io.formats import Format, Registry
from vasowave.base.io.spreadsheet import WORKBOOKS
from vasowave.base.io.textfile import regular_file
from vasowave.base.units import factor
from vasowave.pulse.network.network import Network
from vasowave.pulse.network.remarks import implausible_sizes, long_vessels
from vasowave.pulse.network.titles import says_unit
from vasowave.pulse.network.vessel_table import is_vessel_table, network_of, recognized, vessel_columns

_LINES = (".vtp", ".vtk", ".swc", ".mrk.json", ".tre")
_AMOUNT = re.compile(r"\s*(?P<number>[\d.]+(?:e-?\d+)?)?\s*(?P<unit>[^\d\s].*?)\s*", re.IGNORECASE)


@dataclass(frozen=True)
class NetworkFormat(Format):
    """How networks of one kind are known and read.

    Attributes
    ----------
    read : callable
        Takes a path and what lengths are multiplied by. Returns the network, and what of it was left out or is odd.
    has_unit : bool or callable
        Whether the files say in which unit their lengths are, or what tells it of a path.
    """

    has_unit: bool | Callable[[Path], bool] = True

    def says_unit(self, path: Path) -> bool:
        """Return whether a file says the unit of its lengths."""
        return self.has_unit if isinstance(self.has_unit, bool) else self.has_unit(path)


UNIT = SetOption("Give the unit of its lengths", "unit")

NETWORKS = Registry[NetworkFormat](__name__, "table")
"""Every format of networks."""


def table_format(
    name: str, title: str, suffixes: tuple[str, ...], sniff: Callable[[Path, bytes], bool],
    columns_of: Callable[[Path], Columns], remarks: tuple[Finding, ...] = (),
) -> NetworkFormat:  # fmt: skip
    """Return the format of files whose content is a table of vessels, which `columns_of` a path returns."""

    def read(path: Path, scale: float) -> tuple[Network, list[Finding]]:
        network, findings = network_of(columns_of(path), None if has_unit(path) else scale)
        return network, [*findings, *remarks]

    def has_unit(path: Path) -> bool:
        return says_unit(recognized(columns_of(path))[0])

    return NetworkFormat(name, title, suffixes, sniff, read, has_unit)


NETWORKS.register(
    table_format(
        "table", "table of vessels", (".csv", ".tsv", ".txt", ".dat", *WORKBOOKS), is_vessel_table, vessel_columns
    )
)


def _refused(
    name: str, title: str, mark: re.Pattern[bytes] | None, words: str, cures: tuple[Tidy, ...] = ()
) -> NetworkFormat:
    """Return a format whose files are refused for what they are, by a mark in them or as lines by their names."""

    def sniff(path: Path, start: bytes) -> bool:
        return bool(mark.search(start)) if mark else path.name.lower().endswith(_LINES)

    def refuse(path: Path, scale: float | None = None) -> NoReturn:
        raise InputError(f"{path}: {words}", cures)

    return NetworkFormat(name, title, (), sniff, refuse, refuse)


NETWORKS.register(_refused("centerlines", "centerlines", None, "holds centerlines, of which a network is made first, "
                           "with their unit of length", (Tidy("centerlines"),)))  # fmt: skip
for _name, _mark, _words in (
    ("GXL", rb"<gxl[\s\S]*\bnodeType\b", "a tree in GXL, as VascuSynth writes it: its positions count voxels, its "
     "radii have the unit of the voxel width, and neither says which. Write a table from,to,length [mm],radius [mm]"),
    ("network.dat", rb"total number of segments[\s\S]*?seg ?name", "a network as Secomb's programs read it: segments "
     "between nodes, then the places of these, in um. Write a table from,to,length [um],diameter [um]"),
    ("DOT", rb"\A\s*(?:strict\s+)?(?:di)?graph\b[^{\[]*\{[^{}]*?--?>?", "a graph in DOT: write it as GraphML "
     "(networkx.write_graphml), or as a table from,to,length [mm],radius [mm]"),
    ("openBF", rb"^network:[^:]*:[^:]*\bsn:", "a model of openBF, of which tables are made first: vasowave export FILE "
     "--to tables -o FOLDER. Then give the network in that folder"),
):  # fmt: skip
    NETWORKS.register(_refused(_name, _name, re.compile(_mark, re.MULTILINE | re.IGNORECASE), _words))


def read_network(path: str | Path, unit: str | None = None) -> Network:
    """Read a network: a table of vessels, or a file of another program (`NETWORKS`).

    Parameters
    ----------
    path : path
        A table (CSV, TSV, the first sheet of vessels in a workbook) as of `network_of`, by the titles that `SYNONYMS`
        lists; a graph (GraphML, GML, GXL, NetworkX's JSON or list of edges); a tree in JSON, each vessel with its
        ``children``; a spatial graph of Amira or Avizo (ASCII); a MATLAB file with ``dim_mat`` and
        ``ves_conn``; ``Dimensions.txt`` or ``connectivity.txt``, which lie in one folder; the input of svOneDSolver or
        svZeroDSolver; FirstBlood's table of edges.
    unit : str, optional
        Unit of lengths and radii (``mm``, or the edge of a voxel, ``0.0036 cm``), for files that do not say it.

    Raises
    ------
    InputError
        As `Network` and `network_of`; a file that does not say its unit, if none is given, and one that does,
        if one is; edges without a direction that close a loop.

    Warns
    -----
    VasowaveWarning
        How columns with other titles were read; where blood is taken to enter edges without a direction; what a network
        cannot hold of the file; sizes that look like another unit; see `network_of`.

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
    form = NETWORKS.of(path)
    has_unit = form.says_unit(path)
    if has_unit and unit is not None:
        raise InputError(f"{path}: says the unit of its lengths itself; leave out the unit '{unit}'")
    if not has_unit and unit is None:
        raise unit_wanted(path, form)
    network, findings = form.read(path, scale_of(unit) if unit is not None else 1.0)
    for finding in (*findings, *implausible_sizes(network), *long_vessels(network)):
        warn(finding.at(str(path)))
    return network


def taper_of(first: np.ndarray, last: np.ndarray, length: np.ndarray) -> np.ndarray | None:
    """Return the taper of vessels by the radii of their two ends, None if none tapers."""
    with np.errstate(invalid="ignore", divide="ignore"):  # a length that is none, which `Network` refuses
        taper = (first - last) / length
    return taper if np.any(taper) else None


def number_in(path: Path, line: int, text: str) -> float:
    """Return the number that a word of a file is; `InputError` with its line if it is none."""
    try:
        return number(text)
    except ValueError:
        raise InputError(f"{path}, line {line}: '{text[:40]}' is not a number") from None


def unit_wanted(path: Path, form: NetworkFormat) -> InputError:
    """Return the error that a file does not name its unit, with those of which its root would be an artery."""
    return InputError(
        f"{path}: this {form.title} does not say the unit of its lengths; give it, as mm or as 0.0036 cm for the "
        "edge of a voxel, and write it as a table of vessels",
        [UNIT, *(SetOption(f"The root's radius is {cm:.3g} cm", UNIT.name, unit) for unit, cm in _roots(path, form))],
    )


def _roots(path: Path, form: NetworkFormat) -> Iterator[tuple[str, float]]:
    """Go through the units that make the sizes of a file those of arteries, with the root's radius, cm."""
    for unit in ("um", "mm", "cm"):
        with suppress(InputError):
            network = form.read(path, scale_of(unit))[0]
            if not implausible_sizes(network):
                yield unit, float(network.radius[network.root])


def scale_of(unit: str) -> float:
    """Return the number that turns lengths in a unit, or in so many of it (``0.0036 cm``), into cm."""
    match = _AMOUNT.fullmatch(unit)
    if not match:
        raise InputError(f"unit '{unit}': write a unit, as mm, or a number and a unit, as 0.0036 cm")
    scale = float(match["number"] or 1.0) * factor(match["unit"], "length")
    if not (np.isfinite(scale) and scale > 0):
        raise InputError(f"unit '{unit}': the number must be positive")
    return scale
