"""A figure as SVG: letters that stay letters, and nothing outside that it refers to."""

import io
from typing import TYPE_CHECKING

from vasowave.figures.marks import with_marks
from vasowave.figures.style import style

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_NO_METADATA = {"Date": None, "Creator": None, "Format": None, "Type": None}


def svg(figure: "Figure") -> str:
    """Return the figure as SVG text with editable letters and no reference to anything outside."""
    text = io.StringIO()
    with style():
        figure.savefig(text, format="svg", metadata=_NO_METADATA)
    return with_marks(text.getvalue())
