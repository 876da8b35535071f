"""Networks of the paper's authors and their groups: matrices in a MATLAB file, or two tables of plain numbers."""

from collections.abc import Callable
from pathlib import Path

import numpy as np

from vasowave.base.errors import InputError
from vasowave.base.findings import Finding
from vasowave.base.io.columns import number
from vasowave.base.io.matlab import is_mat, read_mat
from vasowave.base.io.textfile import read_lines
from vasowave.pulse.network.graph import numbered
from vasowave.pulse.network.network import Network
from vasowave.pulse.network.remarks import LEFT_OUT, UNKNOWN_VARIABLE, UNUSED
from vasowave.pulse.network_formats import NETWORKS, NetworkFormat, taper_of

DIMENSIONS, CONNECTIVITY = "dimensions.txt", "connectivity.txt"


def is_mat_network(path: Path, start: bytes) -> bool:
    """Return whether a file is one of MATLAB that holds a network."""
    return is_mat(path, start) and {"dim_mat", "ves_conn"} <= set(read_mat(path))


def read_mat_network(path: Path, scale: float) -> tuple[Network, list[Finding]]:
    """Read ``dim_mat`` (number, length, radius), ``ves_conn`` (number, daughters), and ``r_std`` if it is there."""
    variables = read_mat(path)
    missing = [name for name in ("dim_mat", "ves_conn") if name not in variables]
    if missing:
        names_in_file = ", ".join(variables) or "none"
        raise InputError(
            f"{path}: no variable {' and no '.join(missing)}; a network needs dim_mat (number, length, radius of every "
            f"vessel) and ves_conn (number of a vessel, those of its daughters). There are: {names_in_file}"
        )
    sizes, rows = _matrix(path, variables, "dim_mat", 3), _matrix(path, variables, "ves_conn", 2)
    numbers, length, radius = sizes[:, 0], scale * sizes[:, 1], scale * sizes[:, 2]
    spread = _spread(path, variables, len(numbers), scale)
    nodes = _nodes(path, numbers, rows)
    names = tuple(f"{number:g}" for number in numbers)
    where = _placed(f"{path}, dim_mat row")
    read = {"alpha", "beta", "lrr", "net3D", "term", "dim_mat", "ves_conn", "r_std"}
    surplus = variables["dim_mat"].shape[1] - 3
    unused = [f"the last {surplus} column(s) of dim_mat"] if surplus else []
    unused += ["net3D"] if np.size(variables.get("net3D", ())) else []
    tree_parameters = [name for name in variables if name in ("alpha", "beta", "lrr")]
    findings = [LEFT_OUT(what=f"{', '.join(tree_parameters)} (of structured trees)")] if tree_parameters else []
    findings += [UNUSED(what=", ".join(unused))] if unused else []
    findings += [UNKNOWN_VARIABLE(name=name) for name in variables if name not in read]
    return Network(names, None, length, radius, where, radius_sd=spread, nodes=nodes), findings


def is_dimensions(path: Path, start: bytes) -> bool:
    """Return whether a file is one of the pair of tables, by its name."""
    return path.name.lower() in (DIMENSIONS, CONNECTIVITY)


def read_dimensions(path: Path, scale: float) -> tuple[Network, list[Finding]]:
    """Read length and both radii of every vessel, and its number with those of its daughters, from two files."""
    siblings = {path_in_folder.name.lower(): path_in_folder for path_in_folder in path.parent.iterdir()}
    for name in (DIMENSIONS, CONNECTIVITY):
        if name not in siblings:
            raise InputError(f"{path}: {name} must lie beside it; one file holds the sizes, the other what joins what")
    sizes, rows = _table(siblings[DIMENSIONS], 3, 3), _table(siblings[CONNECTIVITY], 1, None)
    length, first, last = scale * sizes.T
    if len(rows) != len(sizes) or not np.array_equal(np.sort(rows[:, 0]), np.arange(len(rows))):
        raise InputError(
            f"{siblings[CONNECTIVITY]}: {len(rows)} rows for {len(sizes)} vessels; every vessel has one row, which "
            "begins with its number, counted from 0"
        )
    nodes = _nodes(siblings[CONNECTIVITY], np.arange(len(sizes), dtype=float), rows)
    where = _placed(f"{siblings[DIMENSIONS]}, line")
    names = tuple(str(number) for number in range(len(sizes)))
    taper = taper_of(first, last, length)
    return Network(names, None, length, 0.5 * (first + last), where, nodes=nodes, taper=taper), []


def _nodes(path: Path, numbers: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """Return the two nodes of every vessel; a daughter of number 0 or NaN is none.

    Vessels that one vessel leads to begin where it ends, and so do others that another of their parents leads to.
    """
    place = {float(number): row for row, number in enumerate(numbers)}
    if len(place) < len(numbers):
        raise InputError(f"{path}: a vessel's number stands twice; number the vessels anew")
    start, end = [("start", row) for row in range(len(numbers))], [("end", row) for row in range(len(numbers))]
    for line, (parent, *daughters) in enumerate(rows.tolist(), 1):
        for daughter in daughters:
            if not daughter or np.isnan(daughter):
                continue
            unknown = next((vessel for vessel in (parent, daughter) if vessel not in place), None)
            if unknown is not None:
                raise InputError(f"{path}, row {line} of what joins what: there is no vessel {unknown:g}")
            old, new = start[place[daughter]], end[place[parent]]
            start = [new if node == old else node for node in start]
            end = [new if node == old else node for node in end]
    return numbered(list(zip(start, end, strict=True)))


def _matrix(path: Path, variables: dict, name: str, columns: int) -> np.ndarray:
    values = np.asarray(variables[name])
    if values.dtype.kind not in "iuf" or values.ndim != 2 or values.shape[1] < columns:
        raise InputError(f"{path}: {name} must be a matrix of numbers with at least {columns} columns")
    return values.astype(float)


def _spread(path: Path, variables: dict, count: int, scale: float) -> np.ndarray | None:
    if "r_std" not in variables:
        return None
    values = np.asarray(variables["r_std"])
    if values.dtype.kind not in "iuf" or values.size != count:
        raise InputError(f"{path}: r_std must have one number for each of the {count} vessels")
    spread = scale * values.ravel().astype(float)
    return np.where(spread > 0, spread, np.nan)


def _table(path: Path, min_columns: int, max_columns: int | None) -> np.ndarray:
    """Return the numbers of a file, every line with as many as the first."""
    rows: list[list[float]] = []
    for block in read_lines(path):
        for line, text in enumerate(block.texts, block.first):
            if not text.strip():
                continue
            try:
                rows.append([number(word) for word in text.replace(",", " ").split()])
            except ValueError:
                raise InputError(f"{path}, line {line}: '{text.strip()[:40]}' is not a row of numbers") from None
            if len(rows[-1]) != len(rows[0]) or not min_columns <= len(rows[0]) <= (max_columns or len(rows[0])):
                raise InputError(
                    f"{path}, line {line}: {len(rows[-1])} numbers; every line needs {max_columns or 'as many'}"
                )
    if not rows:
        raise InputError(f"{path}: is empty")
    return np.array(rows)


def _placed(place: str) -> Callable[[int], str]:
    return lambda row: f"{place} {row + 1}"


NETWORKS.register(
    NetworkFormat(
        "dim_mat", "MATLAB file with dim_mat and ves_conn", (".mat",), is_mat_network, read_mat_network, False
    )
)
NETWORKS.register(
    NetworkFormat("dimensions", "Dimensions.txt with connectivity.txt", (), is_dimensions, read_dimensions, False)
)
