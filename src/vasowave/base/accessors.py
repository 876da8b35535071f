"""Methods that a part above gives to the values of a part below: a recording knows that it can be drawn, not how."""

import inspect
from collections.abc import Callable
from functools import update_wrapper
from typing import Any, Concatenate, Generic, ParamSpec, TypeVar, overload

Value = TypeVar("Value")
P = ParamSpec("P")
R = TypeVar("R")

_fill: list[Callable[[], None]] = []


def on_first_use(register_all: Callable[[], None]) -> None:
    """Set what registers the bodies of all accessors; it is called when the first of them is asked for."""
    _fill[:] = [register_all]


class Accessor(Generic[Value, P, R]):
    """A method whose name, types and meaning stand where it is declared, and whose body a part above registers.

    Examples
    --------
    >>> class Wave:
    ...     @Accessor
    ...     def plot(self, color: str = "black") -> str:
    ...         '''Draw the wave.'''
    ...         raise NotImplementedError
    >>> Wave.plot.register(lambda wave, color="black": f"drawn in {color}")
    >>> Wave().plot("blue")
    'drawn in blue'
    """

    def __init__(self, declared: Callable[Concatenate[Value, P], R]) -> None:
        self._body: Callable[Concatenate[Value, P], R] | None = None
        update_wrapper(self, declared)

    @property
    def __signature__(self) -> inspect.Signature:
        """Signature of the method as it is declared."""
        return inspect.signature(self.__wrapped__)  # type: ignore[attr-defined]

    def register(self, body: Callable[Concatenate[Value, P], R]) -> None:
        """Set the function that the method calls, with the value first."""
        self._body = body

    @overload
    def __get__(self, value: None, owner: Any) -> "Accessor[Value, P, R]": ...

    @overload
    def __get__(self, value: Value, owner: Any) -> Callable[P, R]: ...

    def __get__(self, value: Value | None, owner: Any = None) -> "Accessor[Value, P, R] | Callable[P, R]":
        """Return the method of a value, or the accessor of a class."""
        if value is None:
            return self

        def method(*args: P.args, **kwargs: P.kwargs) -> R:
            return self(value, *args, **kwargs)

        return update_wrapper(method, self)

    def __call__(self, value: Value, *args: P.args, **kwargs: P.kwargs) -> R:
        """Call the registered function."""
        if self._body is None and _fill:
            _fill[0]()  # again where it was interrupted
        if self._body is None:
            raise NotImplementedError(f"{self.__qualname__}: no part above is there to do it")  # type: ignore[attr-defined]
        return self._body(value, *args, **kwargs)
