"""The origin of a result: versions of the programs that made it, and fingerprints of what they read."""

import platform
from collections.abc import Sequence
from datetime import UTC, datetime
from importlib.metadata import version
from pathlib import Path

from vasowave.base.io.textfile import look

_PROGRAMS = ("vasowave", "numpy", "scipy", "numba", "xarray", "netCDF4")


def provenance(inputs: Sequence[Path] = ()) -> dict[str, str]:
    """Return the date (UTC), the versions of the programs, and the SHA-256 of every input file.

    Raises
    ------
    InputError
        An input file cannot be read.
    """
    origin = {"created": datetime.now(UTC).isoformat(timespec="seconds"), "python": platform.python_version()}
    return origin | versions() | {f"sha256 of {Path(path).name}": look(path).sha256 for path in inputs}


def versions() -> dict[str, str]:
    """Return the versions of vasowave and of the programs that its numbers come from."""
    return {program: version(program) for program in _PROGRAMS}
