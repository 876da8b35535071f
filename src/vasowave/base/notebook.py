"""Values in a notebook: a small card of HTML."""

from collections.abc import Iterable, Mapping
from html import escape


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
