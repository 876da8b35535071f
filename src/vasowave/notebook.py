"""Values in a notebook: a small card of HTML, and the door to what draws and analyzes them."""

from collections.abc import Iterable, Mapping
from html import escape
from importlib import import_module
from typing import Any


def card(title: str, facts: Mapping[str, object], notes: Iterable[str] = ()) -> str:
    """Return a title, a table of facts and a list of notes as HTML; every text is escaped."""
    rows = "".join(
        f'<tr><td style="text-align:left">{escape(str(name))}</td>'
        f'<td style="text-align:left">{escape(str(fact))}</td></tr>'
        for name, fact in facts.items()
    )
    items = "".join(f"<li>{escape(note)}</li>" for note in notes)
    listed = f"<ul>{items}</ul>" if items else ""
    return f"<div><strong>{escape(title)}</strong><table>{rows}</table>{listed}</div>"


def upstairs(place: str) -> Any:
    """Return a function of an upper floor, ``module:name``: a value's method finds it when it is called.

    So ``network.plot()`` draws although nothing below imports what draws.
    """
    module, _, name = place.partition(":")
    return getattr(import_module(f"vasowave.{module}"), name)
