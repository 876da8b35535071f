"""A figure as a file; as SVG with letters that stay letters, and with marks by which a page works with it."""

import html
import io
import json
import re
from collections.abc import Iterator
from contextlib import contextmanager
from html import escape
from typing import TYPE_CHECKING, Any

from vasowave.base.stores import parsed
from vasowave.study.figures.matplotlib_style import style
from vasowave.study.figures.subscripts import as_mathtext, lowered

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_MARK = "mark:"
_FOUND = re.compile(rf"""<g id=(["']){_MARK}(.*?)\1>""")
_LETTERS = "abcdefghijklmnopqrstuvwxyz"
_NO_METADATA = {"Date": None, "Creator": None, "Format": None, "Type": None}


def mark(artist: "Artist", tip: str = "", animal: str = "", layer: str = "") -> None:
    """Give a part of a drawing words, the animal that it is of, and the layer that a page shows or hides as one."""
    _note(artist, {"tip": tip, "animal": animal, "layer": layer})


def readable(ax: "Axes") -> None:
    """Let values be read off a panel with linear axes, whose limits are final."""
    scale = {"x": ax.get_xlim(), "y": ax.get_ylim(), "labels": [ax.get_xlabel(), ax.get_ylabel()]}
    _note(ax.patch, {"scale": json.dumps(scale)})


def lettered(figure: "Figure") -> None:
    """Write a, b, c above the panels of a figure that has several."""
    panels = [ax for ax in figure.axes if ax.axison and ax.get_label() != "<colorbar>"]
    if not 1 < len(panels) <= len(_LETTERS):
        return
    for ax, letter in zip(panels, _LETTERS, strict=False):
        ax.annotate(letter, (0, 1), (-6, 4), "axes fraction", "offset points", ha="right", va="bottom",
                    fontweight="bold", annotation_clip=False)  # fmt: skip


def _note(artist: "Artist", content: dict[str, Any]) -> None:
    artist.set_gid(_MARK + json.dumps({key: value for key, value in content.items() if value}))


def _written(match: re.Match[str]) -> str:
    content = parsed(html.unescape(match[2]))
    tip = content.pop("tip", "")
    data = "".join(f' data-{key}="{html.escape(value)}"' for key, value in content.items())
    return f"<g{data}><title>{html.escape(tip)}</title>" if tip else f"<g{data}>"


def described(text: str, title: str, description: str) -> str:
    """Return SVG text that says to screen readers what it shows."""
    words = lowered(f"<title>{escape(title)}</title><desc>{escape(description)}</desc>")
    return re.sub(r"<svg\b[^>]*", lambda tag: f'{tag[0]} role="img"', text, count=1).replace(
        'role="img">', f'role="img">{words}', 1
    )


def svg(figure: "Figure") -> str:
    """Return the figure as SVG text with editable letters and no reference to anything outside."""
    text = io.StringIO()
    with style(), _placed(figure):
        figure.savefig(text, format="svg", metadata=_NO_METADATA)
    return lowered(_FOUND.sub(_written, text.getvalue()))


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
    with as_mathtext(figure):
        figure.savefig(content, format=kind, transparent=False)
    return content.getvalue()
