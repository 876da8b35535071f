"""vasowave: from one animal's vessels and one catheter recording to a calibrated, explained pulse-wave model."""

import sys

# `python -m vasowave` puts the current folder first, where no file is to be taken for a module (see __main__).
if sys.argv[:1] == ["-m"] and not sys.flags.safe_path and {"vasowave", "-mvasowave"} & set(sys.orig_argv):
    del sys.path[0]

import ast
from importlib import import_module
from pathlib import Path
from typing import Any

from vasowave import accessors


def _homes() -> dict[str, str]:
    """Return the module of every public name, as the stub beside this file says: types and names cannot disagree."""
    stub = ast.parse(Path(__file__).with_suffix(".pyi").read_text(encoding="utf-8"))
    lines = [line for line in stub.body if isinstance(line, ast.ImportFrom)]
    return {name.name: str(line.module) for line in lines for name in line.names}


def _register_methods() -> None:
    """Give the values of lower parts their methods that need upper ones."""
    from vasowave.door.methods import register_all

    register_all()


accessors.on_first_use(_register_methods)
_HOMES = _homes()
_MODULES = ("walls",)
__all__ = sorted(_HOMES)  # noqa: PLE0605  the stub lists them for editors


def __getattr__(name: str) -> Any:
    """Load what is asked for when it is asked for, so that importing the package costs nothing."""
    if name == "__version__":
        return import_module("importlib.metadata").version(__name__)
    if name not in _HOMES:
        raise AttributeError(f"module 'vasowave' has no attribute '{name}'; it has: {', '.join(__all__)}")
    if name in _MODULES:
        return import_module(f"{_HOMES[name]}.{name}")
    return getattr(import_module(_HOMES[name]), name)


def __dir__() -> list[str]:
    return [*__all__, "__version__"]
