"""Variables of a MATLAB file, and clear words when the file cannot give them."""

import subprocess
import sys
import warnings
from pathlib import Path
from typing import Any

import numpy as np

from vasowave.errors import InputError

_SAVE_AGAIN = "in MATLAB, load it and write it again with: save('NAME.mat', '-v7')"
_HDF5 = b"\x89HDF\r\n\x1a\n"


def read_mat(path: str | Path) -> dict[str, Any]:
    """Return the variables of a ``.mat`` file (version 4 to 7) by name.

    Raises
    ------
    InputError
        File missing, of version 7.3, truncated, damaged, or not a MATLAB file.
    """
    from scipy.io import loadmat

    path = Path(path)
    try:
        with path.open("rb") as file:
            start = file.read(1024)
    except OSError as error:
        reason = "is a folder" if path.is_dir() else (error.strerror or "cannot be read").lower()
        raise InputError(f"{path}: {reason}") from None
    if _HDF5 in start or start.startswith(b"MATLAB 7.3"):
        raise InputError(f"{path}: a MATLAB file of version 7.3, which is not read; {_SAVE_AGAIN}")
    _try_in_another_process(path)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        variables = loadmat(path, chars_as_strings=True)
    return {name: value for name, value in variables.items() if not name.startswith("__")}


def _try_in_another_process(path: Path) -> None:
    """Raise `InputError` if reading `path` fails.

    SciPy's compiled reader can end the whole process on a damaged file, and raises a dozen unrelated kinds of error.
    """
    command = [sys.executable, "-W", "ignore", "-c", "import sys; from scipy.io import loadmat; loadmat(sys.argv[1])"]
    try:
        trial = subprocess.run([*command, str(path)], capture_output=True, timeout=120, check=False)
    except subprocess.TimeoutExpired:
        raise InputError(f"{path}: reading did not end; the file is damaged; {_SAVE_AGAIN}") from None
    if trial.returncode != 0:
        lines = trial.stderr.decode(errors="replace").strip().splitlines()
        what = lines[-1] if lines and trial.returncode > 0 else "its structure is damaged"
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
