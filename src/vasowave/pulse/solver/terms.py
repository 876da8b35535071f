"""Physical terms beside pressure, inertia and drag, as values: composed by their classes before a kernel is compiled.

A term is a NamedTuple of arrays. Its methods are named after the places of a step at which they act, and take
``(step, n)``: the parts of a simulation (`scheme.StepArguments`) and the number of the half step. What a class lacks is
left out of the kernel. The tangent of a term is a NamedTuple, too, whose field ``base`` is the term; its methods take
``(step, tangent, n, d)``: also the parts of the linearized scheme (`scheme.Tangent`), and a direction.

Of a term are asked, in this order:

- ``begin`` before a cycle's first step,
- ``at_faces`` once the inner faces have their state at the half step,
- ``at_ends`` once the ends know the cells next to them, before their characteristics,
- ``before_nodes`` before the nodes are asked for their balance, and ``meet`` before each of its balances,
- ``after_nodes`` once all nodes are in balance,
- ``record`` once all faces have their state,
- ``in_cells`` once the cells have taken the fluxes of their faces,
- ``around_single`` once the slots around the only cell of a vessel continue its line;

and of its tangent

- ``linearize_ends`` once the ends know the derivatives of the cells next to them, before those of characteristics,
- ``linearize`` once the elastic scheme is linearized,
- ``change_faces``, ``change_ends`` and ``change_inflow`` once the changes of inner faces, of characteristics and of
  flows into nodes from without are known, in each direction,
- ``record_changes`` once all faces have their changes,
- ``change_cells`` and ``change_single`` as ``in_cells`` and ``around_single``.

A single term may replace how nodes are balanced: ``prepare``, ``solve``, ``worst``, ``moves``, ``change_nodes``.
"""

import sys
from collections.abc import Callable, Iterator
from functools import cache
from inspect import isfunction
from types import ModuleType
from typing import Any

from numba import njit

from vasowave.pulse.solver.cells import INLINED, JOINED

Kinds = tuple[type, ...]
"""The classes of the terms of a kernel, or of their tangents."""


def with_modules_of(kinds: Kinds, *modules: ModuleType) -> tuple[ModuleType, ...]:
    """Return the modules of which a kernel with terms of these kinds is compiled: those given, and the terms' own."""
    return tuple(dict.fromkeys((*modules, *(sys.modules[kind.__module__] for kind in kinds))))


@cache
def _compiled(method: Callable[..., Any]) -> Any:
    """Return a method, compiled once for all kernels in which it is called with the same types."""
    return njit(**JOINED)(method)


def _methods(name: str, kinds: Kinds) -> Iterator[tuple[int, bool, Any]]:
    """Go through the terms that have a method: their place, whether their base has it, and the method, compiled."""
    for place, kind in enumerate(kinds):
        of_base = not isfunction(getattr(kind, name, None))  # a field may have the name of a method
        method = getattr(kind.__annotations__.get("base") if of_base else kind, name, None)
        if isfunction(method):
            yield place, of_base, _compiled(method)


def _called(place: int, of_base: bool, method: Any) -> Callable[..., Any]:
    if of_base:
        return lambda terms, step, n: method(terms[place].base, step, n)
    return lambda terms, step, n: method(terms[place], step, n)


def _in_turn(first: Any, second: Any) -> Callable[..., Any]:
    def both(terms: Any, step: Any, n: Any) -> None:
        first(terms, step, n)
        second(terms, step, n)

    return both


def _change_called(place: int, method: Any) -> Callable[..., Any]:
    return lambda terms, step, tangent, n, d: method(terms[place], step, tangent, n, d)


def _changes_in_turn(first: Any, second: Any) -> Callable[..., Any]:
    def both(terms: Any, step: Any, tangent: Any, n: Any, d: Any) -> None:
        first(terms, step, tangent, n, d)
        second(terms, step, tangent, n, d)

    return both


def of_all(name: str, kinds: Kinds) -> Any:
    """Return a compiled function that calls the method `name` of all terms that have it, in their order."""
    composed = None
    for place in _methods(name, kinds):
        called = njit(**INLINED)(_called(*place))
        composed = called if composed is None else njit(**INLINED)(_in_turn(composed, called))
    return composed or njit(**INLINED)(lambda terms, step, n: None)


def of_one(name: str, kinds: Kinds, default: Any = None) -> Any:
    """Return a compiled function that calls the method of the last term that has it, else `default` if there is one."""
    chosen = list(_methods(name, kinds))
    call = _called(*chosen[-1]) if chosen else default
    return call and njit(**INLINED)(call)


def changes_of_all(name: str, kinds: Kinds) -> Any:
    """As `of_all`, for methods of tangents."""
    composed = None
    for place, _, method in _methods(name, kinds):
        called = njit(**INLINED)(_change_called(place, method))
        composed = called if composed is None else njit(**INLINED)(_changes_in_turn(composed, called))
    return composed or njit(**INLINED)(lambda terms, step, tangent, n, d: None)


def change_of_one(name: str, kinds: Kinds) -> Any:
    """As `of_one`, for methods of tangents."""
    chosen = list(_methods(name, kinds))
    return njit(**INLINED)(_change_called(chosen[-1][0], chosen[-1][2])) if chosen else None
