"""A figure as SVG: letters that stay letters, and nothing outside that it refers to."""

import io
import re
from collections.abc import Iterator
from contextlib import contextmanager
from html import escape
from typing import TYPE_CHECKING

from vasowave.figures.marks import with_marks
from vasowave.figures.style import style

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_NO_METADATA = {"Date": None, "Creator": None, "Format": None, "Type": None}


def described(text: str, title: str, description: str) -> str:
    """Return SVG text that says to screen readers what it shows."""
    words = f"<title>{escape(title)}</title><desc>{escape(description)}</desc>"
    return re.sub(r"<svg\b[^>]*", lambda tag: f'{tag[0]} role="img"', text, count=1).replace(
        'role="img">', f'role="img">{words}', 1
    )


def svg(figure: "Figure") -> str:
    """Return the figure as SVG text with editable letters and no reference to anything outside."""
    text = io.StringIO()
    with style(), _placed(figure):
        figure.savefig(text, format="svg", metadata=_NO_METADATA)
    return with_marks(text.getvalue())


@contextmanager
def _placed(figure: "Figure") -> Iterator[None]:
    """Make the layout and hold it: for a figure that still has to be laid out, matplotlib draws everything twice."""
    from matplotlib.backends.backend_svg import FigureCanvasSVG

    canvas, engine, dpi = figure.canvas, figure.get_layout_engine(), figure.dpi
    if engine is None or not figure.axes:
        yield
        return
    FigureCanvasSVG(figure)  # which measures letters as the file will have them
    figure.dpi = FigureCanvasSVG.fixed_dpi
    try:
        engine.execute(figure)
        figure.dpi = dpi
        figure.set_layout_engine(None)
        yield
    finally:
        figure.dpi = dpi
        figure.set_layout_engine(engine)
        figure.set_canvas(canvas)


def as_file(figure: "Figure", kind: str) -> bytes:
    """Return the figure as a file: svg, pdf or png."""
    if kind == "svg":
        return svg(figure).encode()
    content = io.BytesIO()
    figure.savefig(content, format=kind, transparent=False)
    return content.getvalue()
