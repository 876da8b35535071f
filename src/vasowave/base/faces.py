"""Faces of packages: the stub `__init__.pyi` names what a package offers, and each name is loaded when asked for."""

import ast
import sys
from collections.abc import Callable
from functools import cache
from importlib import import_module
from pathlib import Path
from threading import Lock
from typing import Any

PARSING = Lock()
"""Held while source is parsed: in Python 3.11 two threads that do so at a time disturb each other's count of depth."""


def attach_face(package: str) -> tuple[Callable[[str], Any], Callable[[], list[str]]]:
    """Return `__getattr__` and `__dir__` of a package, as its stub says: types and names cannot disagree.

    Every line of the stub is ``from module import name as name``; a name may be a module itself. Importing the package
    loads nothing of them.
    """

    @cache
    def homes() -> dict[str, str]:
        """Return the module of every name."""
        stub = Path(str(sys.modules[package].__file__)).with_suffix(".pyi")
        text = stub.read_text("utf-8")
        with PARSING:
            lines = [line for line in ast.parse(text).body if isinstance(line, ast.ImportFrom)]
        return {name.name: str(line.module) for line in lines for name in line.names}

    def load(name: str) -> Any:
        if name == "__all__":
            return sorted(homes())
        if name.startswith("__"):  # asked for by Python itself
            raise AttributeError(name)
        if name not in homes():
            from vasowave.base.errors import did_you_mean

            hint = did_you_mean(name, homes()) or f"; dir({package}) lists what it has"
            raise AttributeError(f"module '{package}' has no attribute '{name}'{hint}")
        module = import_module(homes()[name])
        return getattr(module, name) if hasattr(module, name) else import_module(f"{homes()[name]}.{name}")

    return load, lambda: sorted(homes())
