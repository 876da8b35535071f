"""Marks by which a page works with a drawing: words that appear over a part, the animal it is of, the scale of a panel.

Marks travel as the ids of matplotlib's SVG and become titles and data attributes; a browser shows titles by itself.
"""

import html
import json
import re
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_MARK = "mark:"
_FOUND = re.compile(rf"""<g id=(["']){_MARK}(.*?)\1>""")
_LETTERS = "abcdefghijklmnopqrstuvwxyz"


def mark(artist: "Artist", tip: str = "", animal: str = "", layer: str = "") -> None:
    """Give a part of a drawing words, the animal that it is of, and the layer that a page shows or hides as one."""
    _note(artist, {"tip": tip, "animal": animal, "layer": layer})


def readable(ax: "Axes") -> None:
    """Let values be read off a panel with linear axes, whose limits are final."""
    scale = {"x": ax.get_xlim(), "y": ax.get_ylim(), "labels": [ax.get_xlabel(), ax.get_ylabel()]}
    _note(ax.patch, {"scale": json.dumps(scale)})


def with_marks(svg: str) -> str:
    """Return the drawing with its marks as titles and data attributes."""
    return _FOUND.sub(_written, svg)


def lettered(figure: "Figure") -> None:
    """Write a, b, c above the panels of a figure that has several."""
    panels = [ax for ax in figure.axes if ax.axison and ax.get_label() != "<colorbar>"]
    if not 1 < len(panels) <= len(_LETTERS):
        return
    for ax, letter in zip(panels, _LETTERS, strict=False):
        ax.annotate(letter, (0, 1), (-6, 4), "axes fraction", "offset points", ha="right", va="bottom",
                    fontweight="bold", annotation_clip=False)  # fmt: skip


def _note(artist: "Artist", said: dict[str, Any]) -> None:
    artist.set_gid(_MARK + json.dumps({key: value for key, value in said.items() if value}))


def _written(match: re.Match[str]) -> str:
    said = json.loads(html.unescape(match[2]))
    tip = said.pop("tip", "")
    data = "".join(f' data-{key}="{html.escape(value)}"' for key, value in said.items())
    return f"<g{data}><title>{html.escape(tip)}</title>" if tip else f"<g{data}>"
