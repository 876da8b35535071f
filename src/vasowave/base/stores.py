"""What this program writes and reads again: the list of all such stores, and the one reader of their JSON.

Nothing that is stored is believed for where it lies: it may come from elsewhere, be damaged, or be of something else.
Each reader therefore compares a check sum, and what the content says that it belongs to.
"""

from collections.abc import Callable
from functools import cache
from typing import Any, NamedTuple, TypeVar

from pydantic_core import from_json

LARGEST = 1 << 28
"""Bytes: no text that is stored is longer; the index of 1 000 animals takes a hundredth."""

T = TypeVar("T")
Read = TypeVar("Read", bound=Callable[..., Any])


class FileKind(NamedTuple):
    """One kind of file: what it is called, the names of its files, and who reads it."""

    name: str
    files: str
    read: Callable[..., Any]


STORES: dict[str, FileKind] = {}
"""By name; each module that reads one adds it when it is imported."""


def stored(name: str, files: str) -> Callable[[Read], Read]:
    """Let a function be the reader of a store, which `tools/fuzz.py` then tries."""

    def register(read: Read) -> Read:
        STORES[name] = FileKind(name, files, read)
        return read

    return register


def parsed(text: str | bytes) -> Any:
    """Return what a text of JSON says.

    Raises
    ------
    ValueError
        It is no JSON, is longer than `LARGEST`, nests deeper than 200 levels, or holds half a letter (a surrogate).
    """
    _require_short(text)
    return from_json(text)


def parsed_as(kind: type[T], text: str | bytes) -> T:
    """Return a value of a kind (a dataclass, a list of them), every field of its type; raises as `parsed`."""
    _require_short(text)
    from pydantic import ValidationError

    annotation: Any = kind
    try:
        return _adapter(annotation).validate_json(text, strict=True)
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        raise ValueError(": ".join([*map(str, first["loc"]), first["msg"]])) from None


def _require_short(text: str | bytes) -> None:
    if len(text) > LARGEST:
        raise ValueError(f"longer than {LARGEST >> 20} MiB")


@cache
def _adapter(kind: Any) -> Any:
    from pydantic import ConfigDict, TypeAdapter

    return TypeAdapter(kind, config=None if hasattr(kind, "__dataclass_fields__") else ConfigDict(extra="forbid"))
