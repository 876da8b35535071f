"""Where a result came from: versions of the programs that made it, and fingerprints of what they read."""

import hashlib
import platform
from collections.abc import Sequence
from datetime import UTC, datetime
from importlib.metadata import version
from pathlib import Path

from vasowave.errors import InputError
from vasowave.io.textfile import regular_file

_PROGRAMS = ("vasowave", "numpy", "scipy", "numba", "xarray", "netCDF4")


def provenance(inputs: Sequence[Path] = ()) -> dict[str, str]:
    """Return the date (UTC), the versions of the programs, and the SHA-256 of every input file.

    Raises
    ------
    InputError
        An input file cannot be read.
    """
    origin = {"created": datetime.now(UTC).isoformat(timespec="seconds"), "python": platform.python_version()}
    return origin | versions() | {f"sha256 of {Path(path).name}": sha256(Path(path)) for path in inputs}


def versions() -> dict[str, str]:
    """Return the versions of vasowave and of the programs that its numbers come from."""
    return {program: version(program) for program in _PROGRAMS}


def sha256(path: Path) -> str:
    """Return the SHA-256 of a file; `InputError` if it cannot be read."""
    path = regular_file(path)
    try:
        with path.open("rb") as file:
            return hashlib.file_digest(file, "sha256").hexdigest()
    except OSError as error:
        raise InputError(f"{path}: cannot be read for its SHA-256 ({error.strerror}); is it still there?") from None
