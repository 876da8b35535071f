"""What stands for everything that enters the computation of one animal."""

import hashlib
import json
from collections.abc import Mapping
from functools import cache
from importlib.metadata import version
from pathlib import Path
from typing import Any

from vasowave.io.textfile import look

_NUMERICAL = ("numpy", "scipy", "numba", "xarray")
_NOT_NUMERICAL = ("cli", "report", "figures", "cohort")
"""Parts of the package that only show what was computed; a change there asks for no recomputation."""


@cache
def source_digest() -> str:
    """Return a fingerprint of the package's source and of the numerical libraries' versions."""
    root = Path(__file__).parents[1]
    digest = hashlib.sha256()
    for program in _NUMERICAL:
        digest.update(f"{program} {version(program)}\n".encode())
    for path in sorted(root.rglob("*")):
        inside = path.relative_to(root)
        if path.suffix in (".py", ".csv") and inside.parts[0] not in _NOT_NUMERICAL:
            digest.update(f"{inside.as_posix()}\n".encode())
            digest.update(path.read_bytes())
    return digest.hexdigest()


def fingerprint(what: Mapping[str, Any], files: Mapping[str, Path]) -> str:
    """Return a fingerprint of values, of the bytes of files, and of the program; never of a file's time.

    Parameters
    ----------
    what : mapping
        Anything that JSON can hold.
    files : mapping of str to Path
        The role of each file, and the file.

    Raises
    ------
    InputError
        A file cannot be read.
    """
    inputs = {
        "program": source_digest(),
        "what": what,
        "files": {role: look(path).sha256 for role, path in files.items()},
    }
    text = json.dumps(inputs, sort_keys=True, ensure_ascii=True, allow_nan=False)
    return hashlib.sha256(text.encode()).hexdigest()[:32]
