"""What the Figure desk makes: chosen panels at a size in mm, and the line of Python that draws the same again."""

import threading
from dataclasses import field
from typing import Annotated, Any, Literal

from annotated_types import Ge, Le, MaxLen, MinLen

from vasowave.base.errors import InputError
from vasowave.base.settings import Check, settings_class
from vasowave.study.figures.fit import PANELS
from vasowave.study.figures.fitted import Appearance, checked_panel, figure_bytes
from vasowave.study.figures.matplotlib_style import CTL
from vasowave.study.report.answer.comparison import GROUP_FIGURES
from vasowave.study.results.results import Results
from vasowave.workbench.desk import Desk

_drawing = threading.Lock()  # matplotlib's look is one for the whole process
KINDS = {"svg": "image/svg+xml", "pdf": "application/pdf", "png": "image/png", "csv": "text/csv"}
CHOICES: dict[str, Any] = {
    "panels": {name: panel.title for name, panel in PANELS.items()},
    "of_groups": GROUP_FIGURES,
    "families": ("sans-serif", "serif", "monospace"),
    "formats": tuple(KINDS),
}
"""What the page offers."""


@settings_class
class Wish:
    """A figure that is wished for: of an animal or, where there is none, of a group against the reference.

    `figure` is one of groups; `csv` are the numbers of their comparison.
    """

    animal: str = ""
    group: str = ""
    figure: Annotated[str, MaxLen(30)] = "ratios"
    panels: Annotated[list[Annotated[str, Check(checked_panel)]], MinLen(1), MaxLen(len(PANELS))] = field(
        default_factory=lambda: ["pressure"]
    )
    width: Annotated[float, Ge(20), Le(400)] = 170.0
    height: Annotated[float, Ge(20), Le(400)] = 60.0
    font: Annotated[float, Ge(4), Le(24)] = 8.0
    family: Annotated[str, MinLen(1), MaxLen(100)] = "sans-serif"
    color: Annotated[str, MinLen(1), MaxLen(30)] = CTL
    format: Literal["svg", "pdf", "png", "csv"] = "svg"


def line_of(desk: Desk, wish: Wish) -> str:
    """Return the line of Python that writes a figure."""
    results = f"import vasowave as vw; vw.read_results({str(desk.folder.absolute())!r})"
    if not wish.animal:
        figure = "" if wish.figure == "ratios" else f", {wish.figure!r}"
        return f"{results}.compare({wish.group!r}).save('figure.{wish.format}'{figure})"
    size = f"width={wish.width:g}, height={wish.height:g}, font={wish.font:g}"
    style = f"family={wish.family!r}, color={wish.color!r}"
    return f"{results}[{wish.animal!r}].plot.save('figure.{wish.format}', {wish.panels!r}, {size}, {style})"


def figure_file(desk: Desk, wish: Wish) -> bytes:
    """Return a figure as a file.

    Raises
    ------
    InputError
        There is no such result, font or color.
    """
    stored = desk.stored()
    if wish.animal and wish.animal not in stored:
        raise InputError(f"there is no result of '{wish.animal[:80]}'")
    if wish.animal and wish.format == "csv":
        raise InputError("numbers are written of a comparison of groups; those of animals stand in results.table()")
    return desk.of_results(repr(wish), lambda: _drawn(desk, stored, wish))


def _drawn(desk: Desk, stored: Results, wish: Wish) -> bytes:
    with _drawing:
        if not wish.animal:
            comparison = desk.of_results(("comparison", wish.group), lambda: stored.compare(wish.group))
            return comparison.as_file(wish.format, wish.figure)
        appearance = Appearance(wish.width, wish.height, wish.font, wish.family, wish.color)
        return figure_bytes(stored[wish.animal], wish.panels, wish.format, appearance)
