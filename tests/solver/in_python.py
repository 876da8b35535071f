"""Compiled kernels run as the Python that they are written in: every combination at once, and nothing to compile."""

from types import FunctionType
from typing import Any

from numba.core.dispatcher import Dispatcher

from vasowave.solver import cycle, laws, varied_cycle


def in_python(function: Any, known: dict[Any, Any] | None = None) -> Any:
    """Return a compiled function, and all that it calls, as plain functions of Python."""
    known = known if known is not None else {getattr(laws, name): _of_law(name) for name in _STUBS}
    source = function.py_func
    if source not in known:
        names = dict(source.__globals__)
        known[source] = FunctionType(source.__code__, names, source.__name__, source.__defaults__, source.__closure__)
        for name in source.__code__.co_names:
            value = names.get(name)
            if isinstance(value, Dispatcher):
                names[name] = in_python(value, known)
            elif isinstance(value, FunctionType) and value in known:
                names[name] = known[value]
    return known[source]


_STUBS = ("pressure_at", "ratio_at", "slope_at")


def _of_law(name: str) -> Any:
    return lambda wall, j, x: getattr(type(wall), name)(x, *(value[j] for value in wall))


def use_python(monkeypatch: Any) -> None:
    """Let every simulation of a test run its cycles in Python."""
    plain, varied = in_python(cycle._compiled()), in_python(varied_cycle._compiled())
    monkeypatch.setattr(cycle, "cycle_kernel", lambda law: plain)
    monkeypatch.setattr("vasowave.solver.varied_stepper.varied_cycle_kernel", lambda law: varied)
