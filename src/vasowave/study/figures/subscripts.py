"""True subscripts: texts have ``R_T`` in them, and what is read shows the second letter lowered."""

import re
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from typing import TYPE_CHECKING

from vasowave.pulse.quantities import QUANTITIES

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_FURTHER = ("R_1", "R_2", "R_T0", "V_0", "A_0", "r_0", "R_a")  # of formulas, and in no quantity's symbol


def _pattern() -> re.Pattern[str]:
    symbols = [*(quantity.symbol for quantity in QUANTITIES.values()), *_FURTHER]
    signs = {sign for symbol in symbols for sign in re.findall(r"[A-Za-z]+_\w+", symbol)}
    alternatives = "|".join(
        f"{base}_{low}" for base, low in sorted((sign.split("_", 1) for sign in signs), reverse=True)
    )
    return re.compile(rf"(?<![\w.-])({alternatives})(?!\w|\.\w)")


_SIGN = _pattern()
_TAG = re.compile(r"(<(script|style)\b.*?</\2>|<[^>]*>)", re.DOTALL)
_READ_ALOUD = re.compile(r'(?<= )(title|aria-label)="[^"]*"')
_UNMARKED = ("title", "desc", "option", "code")
"""Elements of which no part can be lowered."""


def pieces(text: str) -> Iterator[tuple[str, str]]:
    """Return a text as pieces, each with what is lowered behind it: ``("total R", "T"), (" of a mouse", "")``."""
    end = 0
    for sign in _SIGN.finditer(text):
        base, low = sign[1].split("_", 1)
        yield text[end : sign.start()] + base, low
        end = sign.end()
    if end < len(text) or not text:
        yield text[end:], ""


def lowered(markup: str) -> str:
    """Return a page or a drawing with true subscripts in all that is read of it."""
    written, inside = [], ""
    for place, piece in enumerate(_TAG.split(markup)):
        if place % 3 == 0:
            written.append(_FORMS.get(inside, _html)(piece) if "_" in piece else piece)
        elif place % 3 == 1:
            written.append(_READ_ALOUD.sub(lambda match: _plain(match[0]), piece) if "_" in piece else piece)
            inside = _entered(piece, inside)
    return "".join(written)


def _entered(tag: str, inside: str) -> str:
    """Return which element text after a tag stands in, as far as that decides how it is lowered."""
    name = re.split(r"[\s>/]", tag.lstrip("</"), maxsplit=1)[0]
    if name not in _FORMS or tag.endswith("/>"):
        return inside
    return "" if tag.startswith("</") else name


def _html(text: str) -> str:
    return "".join(f"{base}<sub>{low}</sub>" if low else base for base, low in pieces(text))


def _svg(text: str) -> str:
    """Return the text of a drawing: what follows a lowered part is raised again."""
    written = ""
    for place, (base, low) in enumerate(pieces(text)):
        written += f'<tspan dy="-0.16em">{base}</tspan>' if place else base
        written += f'<tspan dy="0.22em" font-size="72%">{low}</tspan>' if low else ""
    return written


def _plain(text: str) -> str:
    return _SIGN.sub(lambda sign: sign[1].replace("_", ""), text)


_FORMS: Mapping[str, Callable[[str], str]] = {"text": _svg} | dict.fromkeys(_UNMARKED, _plain)


@contextmanager
def as_mathtext(figure: "Figure") -> Iterator[None]:
    """Draw a figure with true subscripts within this block, by matplotlib's own text."""
    from matplotlib.text import Text

    texts: list[Text] = [label for label in figure.findobj(Text) if _SIGN.search(label.get_text())]
    before = [(label.get_text(), label.get_parse_math()) for label in texts]
    for label in texts:
        label.set_text(_SIGN.sub(_math, label.get_text().replace("$", r"\$")))
        label.set_parse_math(True)
    try:
        yield
    finally:
        for label, (text, parsed) in zip(texts, before, strict=True):
            label.set_text(text)
            label.set_parse_math(parsed)


def _math(sign: re.Match[str]) -> str:
    base, low = sign[1].split("_", 1)
    return rf"$\mathregular{{{base}_{{{low}}}}}$"
