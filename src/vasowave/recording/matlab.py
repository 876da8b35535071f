"""Variables of a MATLAB file, and clear words when the file cannot give them."""

import os
import subprocess
import sys
import warnings
from pathlib import Path
from typing import Any

import numpy as np

from vasowave.errors import InputError
from vasowave.io.textfile import read_start, regular_file
from vasowave.recording.matlab_hdf5 import read_mat_hdf5

_SAVE_AGAIN = "in MATLAB, load it and write it again with: save('NAME.mat', '-v7')"
_MEMORY = 1 << 30  # bytes of addresses that the trial may take beside the file
_SECONDS = 15
"""What reading may take beside what grows with the file: bytes, and s of the processor; a busy machine waits longer."""

_TRIAL = """
import sys
try:
    import resource
    resource.setrlimit(resource.RLIMIT_AS, (int(sys.argv[2]),) * 2)
    resource.setrlimit(resource.RLIMIT_CPU, (int(sys.argv[3]),) * 2)
except (ImportError, ValueError, OSError):
    pass
if sys.argv[4] == "hdf5":
    from vasowave.recording.matlab_hdf5 import read_mat_hdf5
    read_mat_hdf5(sys.argv[1])
else:
    from scipy.io import loadmat
    loadmat(sys.argv[1])
"""
_HDF5 = b"\x89HDF\r\n\x1a\n"


def read_mat(path: str | Path) -> dict[str, Any]:
    """Return the variables of a ``.mat`` file (version 4 to 7.3) by name; of 7.3 matrices of numbers and characters.

    Raises
    ------
    InputError
        File missing, truncated, damaged, or not a MATLAB file.
    """
    from scipy.io import loadmat

    path = regular_file(path)
    start = read_start(path, 1024)
    if _HDF5 in start or start.startswith(b"MATLAB 7.3"):
        _try_in_another_process(path, "hdf5")
        return read_mat_hdf5(path)
    _try_in_another_process(path)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        variables = loadmat(path, chars_as_strings=True)
    return {name: value for name, value in variables.items() if not name.startswith("__")}


def _try_in_another_process(path: Path, form: str = "") -> None:
    """Raise `InputError` if reading `path` fails, does not end, or takes far more memory than the file is long.

    SciPy's and HDF5's compiled readers can end the whole process on a damaged file, and raise a dozen unrelated kinds
    of error; a compressed variable of a few kilobytes can inflate to any size.
    """
    size = path.stat().st_size
    seconds = int(_SECONDS + size / 2e7)
    limits = [str(_MEMORY + 4 * size), str(seconds)]
    command = [sys.executable, "-P", "-W", "ignore", "-c", _TRIAL, str(path), *limits, form]
    alone = dict.fromkeys(("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"), "1")
    try:
        trial = subprocess.run(command, capture_output=True, timeout=8 * seconds, check=False, env=os.environ | alone)
    except subprocess.TimeoutExpired:
        raise InputError(f"{path}: reading did not end; the file is damaged; {_SAVE_AGAIN}") from None
    if trial.returncode != 0:
        lines = trial.stderr.decode(errors="replace").strip().splitlines()
        what = lines[-1] if lines and trial.returncode > 0 else "its structure is damaged"
        if what.startswith("MemoryError") or "Unable to allocate" in what:
            what = "it asks for far more memory than the file is long"
        raise InputError(f"{path}: truncated, damaged, or not a MATLAB file ({what}); {_SAVE_AGAIN}")


def vector(value: Any, where: str) -> np.ndarray:
    """Return a real numeric MATLAB row or column as floats, shape (sample,); `InputError` for anything else."""
    array = np.asarray(value) if isinstance(value, np.ndarray) else None
    if array is None or array.dtype.kind not in "iufb":
        raise InputError(f"{where} is not a vector of real numbers")
    if array.size != max(array.shape, default=0):
        raise InputError(f"{where} has size {' × '.join(map(str, array.shape))}; it must be one row or one column")
    return array.ravel().astype(np.float64)


def text(value: Any) -> str:
    """Return a MATLAB character array as one string, empty if it is none."""
    array = np.asarray(value)
    return str(array.ravel()[0]).strip() if array.size and array.dtype.kind == "U" else ""
