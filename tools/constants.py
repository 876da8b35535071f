"""List the numbers that were chosen: every constant of the package with its value and meaning, for docs/constants.md.

uv run python tools/constants.py           writes the page, as building the site does
"""

import ast
import dataclasses
import importlib
import inspect
import pkgutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

import vasowave

PAGE = Path(__file__).parents[1] / "docs" / "constants.md"
LONGEST = 8  # numbers of an array that are listed one by one
HEAD = "| module | {} | value | meaning |\n|---|---|---|---|\n"
ABOUT = """\
# Numbers that were chosen

Every constant that decides about an answer, by the module that uses it: thresholds, tolerances, sizes. Reasons stand in
[Decisions](decisions/index.md) and with the measurements in [Images](imaging.md). Units are cm, s, ml and mmHg where
nothing else is said. `tools/constants.py` makes this page when the site is built.
"""
ROOMS = (
    "catheter", "lung", "pulse.analysis", "pulse.calibration", "pulse.cycle", "pulse.inference", "pulse.model",
    "pulse.network", "pulse.noise", "pulse.selection", "pulse.solver", "study.animal", "study.cohort",
)  # fmt: skip
"""Packages whose numbers decide about an answer; those of the others decide how it is shown, read or kept."""


class Constant(NamedTuple):
    """A constant: its module, its name or names, its value as text and what the source says of it."""

    module: str
    name: str
    value: str
    meaning: str


def modules() -> Iterator[Any]:
    """Import and yield every module of the package."""
    for found in pkgutil.walk_packages(vasowave.__path__, "vasowave."):
        if not found.name.endswith("__main__"):
            yield importlib.import_module(found.name)


def _deciding() -> Iterator[Any]:
    rooms = tuple(f"vasowave.{room}." for room in ROOMS)
    return (module for module in modules() if f"{module.__name__}.".startswith(rooms))


def constants() -> Iterator[Constant]:
    """Yield every constant that holds numbers, in the order of the source."""
    for module in _deciding():
        text = Path(module.__file__ or "").read_text(encoding="utf-8")
        body = ast.parse(text).body
        for statement, after in zip(body, [*body[1:], None], strict=True):
            names = _names(statement)
            values = [_shown(getattr(module, name, None)) for name in names]
            if names and all(values):
                meaning = _meaning(text.splitlines(), statement, after)
                yield Constant(module.__name__, ", ".join(names), ", ".join(values), meaning)


def defaults() -> Iterator[Constant]:
    """Yield the numbers and answers to yes or no that stand where an argument or a field of a value is not given."""
    for module in _deciding():
        for name, taking in _taking(module):
            meanings = _attributes(taking)
            for argument in inspect.signature(taking).parameters.values():
                default = argument.default
                if value := str(default) if isinstance(default, bool) else _shown(default):
                    yield Constant(module.__name__, f"{name}: {argument.name}", value, meanings.get(argument.name, ""))


def _taking(module: Any) -> Iterator[tuple[str, Any]]:
    """Yield the functions of a module, its dataclasses and named tuples, and the methods of its classes."""

    def of(owner: Any, kind: Any) -> list[tuple[str, Any]]:
        return [(name, one) for name, one in inspect.getmembers(owner, kind) if one.__module__ == module.__name__]

    yield from of(module, inspect.isfunction)
    for name, kind in of(module, inspect.isclass):
        if dataclasses.is_dataclass(kind) or hasattr(kind, "_fields"):
            yield name, kind
        for inner, method in of(kind, inspect.isfunction):
            if not inner.startswith("__") or inner == "__call__":
                yield f"{name}.{inner}", method


def _attributes(kind: Any) -> dict[str, str]:
    """Return what the docstring of a class says of its attributes."""
    _, _, section = (inspect.getdoc(kind) or "").partition("Attributes\n----------\n")
    meanings: dict[str, str] = {}
    names: list[str] = []
    for line in section.split("\n\n")[0].splitlines():
        if line.startswith(" "):
            meanings |= {name: f"{meanings.get(name, '')} {line.strip()}".strip() for name in names}
        else:
            names = line.partition(" : ")[0].split(", ")
    return meanings


def _names(statement: ast.stmt) -> list[str]:
    """Return the upper-case names that a statement gives values to."""
    targets = statement.targets if isinstance(statement, ast.Assign) else [getattr(statement, "target", None)]
    first = targets[0]
    parts = first.elts if isinstance(first, ast.Tuple) else [first]
    names = [part.id for part in parts if isinstance(part, ast.Name)]
    return names if names and all(name.isupper() for name in names) else []


def _shown(value: Any) -> str:
    """Return numbers, alone or in tuples, tables and arrays, with the words between them; nothing for all else."""
    return _written(value) if _holds_number(value) else ""


def _holds_number(value: Any) -> bool:
    if isinstance(value, dict):
        value = tuple(value.values())
    if isinstance(value, tuple | list):
        return any(map(_holds_number, value))
    return isinstance(value, int | float | np.ndarray) and not isinstance(value, bool)


def _written(value: Any) -> str:
    if isinstance(value, dict):
        return "; ".join(f"{key}: {_written(one)}" for key, one in value.items())
    if isinstance(value, tuple | list):
        return f"({', '.join(map(_written, value))})"
    if isinstance(value, np.ndarray) and value.size > LONGEST:
        return f"{value.size} from {value.min():g} to {value.max():g}, mean {value.mean():g}"
    if isinstance(value, np.ndarray):
        return ", ".join(f"{one:g}" for one in value.ravel())
    return str(value) if isinstance(value, str | int | float) else "…"


def _meaning(lines: list[str], statement: ast.stmt, after: ast.stmt | None) -> str:
    """Return the docstring below a statement, or the comment at its end."""
    if isinstance(after, ast.Expr) and isinstance(after.value, ast.Constant) and isinstance(after.value.value, str):
        return " ".join(after.value.value.split())
    line = lines[(statement.end_lineno or 1) - 1].encode()[statement.end_col_offset :].decode()
    return line.partition("#")[2].strip().removeprefix("fmt: skip").strip()


def page() -> str:
    """Return the page of the documentation."""
    parts, last = [ABOUT], ""
    for one in constants():
        part = one.module.split(".")[1]
        if part != last:
            parts.append(f"\n## {part}\n\n" + HEAD.format("constant"))
        parts.append(_row(one, ".".join(one.module.split(".")[2:]) or part))
        last = part
    parts += ["\n## Where nothing is given\n\n" + HEAD.format("function: argument")]
    parts += [_row(one, one.module.partition(".")[2]) for one in defaults()]
    return "".join(parts)


def _row(one: Constant, module: str) -> str:
    cells = (f"`{module}`", f"`{one.name}`", f"`{one.value}`", one.meaning)
    return "| " + " | ".join(cell.replace("|", r"\|").replace("<", "&lt;") for cell in cells) + " |\n"


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
