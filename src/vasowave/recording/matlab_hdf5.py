"""Variables of a MATLAB file of version 7.3: HDF5 behind a header of 512 bytes, every matrix stored by its columns."""

from pathlib import Path
from typing import Any

import numpy as np


def read_mat_hdf5(path: str | Path) -> dict[str, Any]:
    """Return the matrices of numbers and of characters by name, shaped as in MATLAB; cells and structures are left out.

    Characters come as SciPy gives those of earlier versions: one text a row. HDF5 is read through netCDF's library.

    Raises
    ------
    OSError, RuntimeError
        As that library does, of a damaged file; it may also end the process.
    """
    from netCDF4 import Dataset

    variables: dict[str, Any] = {}
    with Dataset(path) as file:
        for name, variable in file.variables.items():
            kind = variable.getncattr("MATLAB_class") if "MATLAB_class" in variable.ncattrs() else ""
            if "MATLAB_empty" in variable.ncattrs():
                variables[name] = np.empty((0, 0))
            elif getattr(variable.dtype, "kind", "") in "iufb" and variable.dtype is not str:
                values = np.asarray(variable[...]).T
                variables[name] = _texts(values) if kind == "char" else values
    return variables


def _texts(codes: np.ndarray) -> np.ndarray:
    """Return the rows of a matrix of UTF-16 codes as texts."""
    rows = np.atleast_2d(codes).astype("<u2")
    return np.array([row.tobytes().decode("utf-16-le", errors="replace") for row in rows])
