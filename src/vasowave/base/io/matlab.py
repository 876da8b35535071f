"""Variables of a MATLAB file, and clear words when the file cannot give them."""

import warnings
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from vasowave.base.errors import InputError
from vasowave.base.io.apart import ReaderAnswer, read_apart
from vasowave.base.io.remembered import remembered
from vasowave.base.io.textfile import look, read_bytes

_MAX_CELLS = 1024  # of a cell array, whose structures are looked into
_SAVE_AGAIN = "in MATLAB, load it and write it again with: save('NAME.mat', '-v7')"
_HDF5 = b"\x89HDF\r\n\x1a\n"


def is_mat(path: Path, start: bytes) -> bool:
    """Whether a file is one of MATLAB."""
    return path.suffix.lower() == ".mat" or start.startswith(b"MATLAB ")


@remembered
def read_mat(path: str | Path) -> dict[str, np.ndarray]:
    """Return the variables of a ``.mat`` file (version 4 to 7.3) by name.

    Matrices of numbers, and texts, one a row or cell; what else there is has its name and no value. The file is read in
    another process: SciPy's and HDF5's compiled readers can end the whole process on a damaged file, and a compressed
    variable of a few kilobytes can inflate to any size.

    Raises
    ------
    InputError
        File missing, truncated, damaged, or not a MATLAB file.
    """
    names, arrays = read_apart(reader_of(Path(path)), Path(path), "a MATLAB file", _SAVE_AGAIN)
    values = iter(arrays)
    for array in arrays:
        array.setflags(write=False)
    return {name: next(values) if has_value else np.empty(0, object) for name, has_value in names}


def reader_of(path: Path) -> Callable[[Path], ReaderAnswer]:
    """Return what reads a file of its version; it may raise anything, or end the process."""
    start = look(path).start[:1024]
    return variables_of_7_3 if _HDF5 in start or start.startswith(b"MATLAB 7.3") else variables_before


def variables_before(path: Path) -> ReaderAnswer:
    """Return the variables of versions before 7.3; any exception of SciPy, or the end of the process."""
    from scipy.io import loadmat

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        variables = loadmat(path, chars_as_strings=True)
    return _answer({name: value for name, value in variables.items() if not name.startswith("__")})


def variables_of_7_3(path: Path) -> ReaderAnswer:
    """Return the matrices in HDF5 behind a header of 512 bytes, every one stored by its columns; cells are left out."""
    from netCDF4 import Dataset

    variables: dict[str, Any] = {}
    with Dataset("in memory", memory=read_bytes(path)) as file:  # by its name the library opens it three times
        for name, variable in _held(file):
            kind = variable.getncattr("MATLAB_class") if "MATLAB_class" in variable.ncattrs() else ""
            if "MATLAB_empty" in variable.ncattrs():
                variables[name] = np.empty((0, 0))
            elif getattr(variable.dtype, "kind", "") in "iufb" and variable.dtype is not str:
                values = np.asarray(variable[...]).T
                variables[name] = _texts(values) if kind == "char" else values
    return _answer(variables)


def _held(group: Any, place: str = "", depth: int = 3) -> Iterator[tuple[str, Any]]:
    """Go through the variables of a file and the fields of its structures, each by its name: ``rec.PAP.data``."""
    yield from ((f"{place}{name}", variable) for name, variable in group.variables.items())
    for name, inner in group.groups.items() if depth else ():
        if not name.startswith("#"):  # what cells refer to
            yield from _held(inner, f"{place}{name}.", depth - 1)


def _answer(variables: Mapping[str, Any]) -> ReaderAnswer:
    """Return names, each with whether it has a value, and the values."""
    arrays = {name: np.asarray(value) for name, value in variables.items()}
    for name, value in list(arrays.items()):
        inside = _fields(name, value)
        arrays |= inside
        for field, structure in inside.items():  # of a structure in a structure
            arrays |= _fields(field, structure)
    arrays = {name: _texts_of_cells(value) for name, value in arrays.items()}
    has_value = {name: value.dtype.kind in "biufcU" for name, value in arrays.items()}
    return ReaderAnswer(list(has_value.items()), [value for name, value in arrays.items() if has_value[name]])


def _fields(name: str, value: np.ndarray) -> dict[str, np.ndarray]:
    """Return the fields of a structure, or of those in a cell array, by names as ``channels(2).data``."""
    cells = [np.asarray(cell) for cell in value.ravel()[:_MAX_CELLS]] if value.dtype.kind == "O" else []
    structures = {f"{name}({i})": cell for i, cell in enumerate(cells, 1)} if cells else {name: value}
    return {
        f"{place}.{field}": np.asarray(structure[field].ravel()[0])
        for place, structure in structures.items()
        if structure.dtype.names and structure.size == 1
        for field in structure.dtype.names
    }


def _texts_of_cells(value: np.ndarray) -> np.ndarray:
    """Return a cell array of texts as an array of them; any other value as it is."""
    cells = [np.asarray(cell) for cell in value.ravel()[:_MAX_CELLS]] if value.dtype.kind == "O" else []
    is_text = all(cell.dtype.kind == "U" and cell.size <= 1 for cell in cells)
    return np.array([str(cell.ravel()[0]) if cell.size else "" for cell in cells]) if cells and is_text else value


def _texts(codes: np.ndarray) -> np.ndarray:
    """Return the rows of a matrix of UTF-16 codes as texts."""
    rows = np.atleast_2d(codes).astype("<u2")
    return np.array([row.tobytes().decode("utf-16-le", errors="replace") for row in rows])


def vector(value: Any, where: str) -> np.ndarray:
    """Return a real numeric MATLAB row or column as floats, shape (sample,); `InputError` for anything else."""
    array = np.asarray(value) if isinstance(value, np.ndarray) else None
    if array is None or array.dtype.kind not in "iufb":
        raise InputError(f"{where} is not a vector of real numbers")
    if array.size != max(array.shape, default=0):
        raise InputError(f"{where} has size {' × '.join(map(str, array.shape))}; it must be one row or one column")
    return array.ravel().astype(np.float64, copy=False)


def text(value: Any) -> str:
    """Return a MATLAB character array as one string, empty if it is none."""
    array = np.asarray(value)
    return str(array.ravel()[0]).strip() if array.size and array.dtype.kind == "U" else ""
