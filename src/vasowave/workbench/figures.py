"""What the Figure desk makes: chosen panels at a size in mm, and the line of Python that draws the same again."""

import threading
from dataclasses import field
from typing import Annotated, Any, Literal

from annotated_types import Ge, Le, MaxLen, MinLen

from vasowave.errors import InputError
from vasowave.figures.fitted import figure_bytes
from vasowave.figures.style import CTL
from vasowave.settings import settings_class
from vasowave.workbench.desk import Desk

_drawing = threading.Lock()  # matplotlib's look is one for the whole process
_KINDS = {"svg": "image/svg+xml", "pdf": "application/pdf", "png": "image/png"}


@settings_class
class Wish:
    """A figure that is wished for: of an animal or, where there is none, of a group against the reference."""

    animal: str = ""
    group: str = ""
    panels: Annotated[
        list[Literal["pressure", "flow", "residuals", "autocorrelation", "pressure_area", "impedance"]], MinLen(1)
    ] = field(default_factory=lambda: ["pressure"])
    width: Annotated[float, Ge(20), Le(400)] = 170.0
    height: Annotated[float, Ge(20), Le(400)] = 60.0
    font: Annotated[float, Ge(4), Le(24)] = 8.0
    family: Annotated[str, MinLen(1), MaxLen(100)] = "sans-serif"
    color: Annotated[str, MinLen(1), MaxLen(30)] = CTL
    format: Literal["svg", "pdf", "png"] = "svg"


def figure_file(desk: Desk, message: dict[str, Any]) -> tuple[bytes, str, str]:
    """Return a figure as a file, its type, and the line of Python that writes the same.

    Raises
    ------
    InputError
        A value that a figure cannot have; there is no such result.
    """
    wish = Wish(**{name: value for name, value in message.items() if name != "only"})
    if not wish.animal:
        return _of_group(desk, wish, line_only=message.get("only") == "line")
    size = f"width={wish.width:g}, height={wish.height:g}, font={wish.font:g}"
    look = f"family={wish.family!r}, color={wish.color!r}"
    line = (
        f"import vasowave as vw; vw.read_results({str(desk.folder.absolute())!r})[{wish.animal!r}].plot.save("
        f"'figure.{wish.format}', {wish.panels!r}, {size}, {look})"
    )
    if message.get("only") == "line":
        return b"", "", line
    stored = desk.stored()
    if wish.animal not in stored:
        raise InputError(f"there is no result of '{wish.animal[:80]}'")
    with _drawing:
        content = figure_bytes(
            stored[wish.animal], wish.panels, wish.format,
            width=wish.width, height=wish.height, font=wish.font, family=wish.family, color=wish.color,
        )  # fmt: skip
    return content, _KINDS[wish.format], line


def _of_group(desk: Desk, wish: Wish, line_only: bool) -> tuple[bytes, str, str]:
    line = (
        f"import vasowave as vw; vw.read_results({str(desk.folder.absolute())!r}).compare({wish.group!r})"
        f".save('figure.{wish.format}')"
    )
    if line_only:
        return b"", "", line
    with _drawing:
        return desk.stored().compare(wish.group).as_file(wish.format), _KINDS[wish.format], line
