"""A document as one HTML page that needs no network."""

import re
from typing import TYPE_CHECKING

from vasowave.study.figures.subscripts import lowered
from vasowave.study.report.blocks import Drawing, Report, drawn, size_of
from vasowave.study.report.terms import explained

if TYPE_CHECKING:
    from jinja2 import Environment


def templates() -> "Environment":
    """Return the templates of all pages."""
    from jinja2 import Environment, PackageLoader, StrictUndefined

    return Environment(
        loader=PackageLoader("vasowave.study.report"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )


def page(report: Report, links: dict[str, str]) -> str:
    """Return the page as HTML text with the figures inside.

    Parameters
    ----------
    report : Report
    links : dict of str to str
        Files that stand beside it, by what a link calls them.
    """
    from markupsafe import Markup

    environment = templates()
    environment.globals["drawn"] = lambda drawing: Markup(embedded(drawing))
    environment.filters["explained"] = explained(report.glossary)
    return lowered(environment.get_template("report.html").render(report=report, others=links))


def embedded(drawing: Drawing) -> str:
    """Return the figure as SVG to stand inside HTML; of one with a narrow form both, the page shows one of them."""
    if drawing.narrow is None:
        return _inside(drawing.svg, drawing.name)
    wide = _inside(drawing.svg, drawing.name, "wide")
    return wide + _inside(drawn(drawing.narrow), f"{drawing.name}-narrow", "narrow")


def _inside(text: str, name: str, form: str = "") -> str:
    """Return SVG without prolog, scalable, with ids that are unique in the page."""
    pixels = 96 * size_of(text)[0]
    opening, body = text[text.index("<svg") :].split(">", 1)
    opening = re.sub(r'\s(xmlns(:\w+)?|width|height|version)="[^"]*"', "", opening)
    # Letters stay readable: the drawing shrinks to 0.7 of its size at most, then its box scrolls.
    opening += f' class="{form}"' if form else ""
    opening += f' style="width: {1.3 * pixels:.0f}px; min-width: {0.7 * pixels:.0f}px; max-width: 100%"'
    body = re.sub(r'\bid="', f'id="{name}-', body)
    body = re.sub(r'(xlink:href="#|url\(#)', rf"\g<1>{name}-", body)
    # A hundredth of a point is finer than any screen or printer, and the page half as large.
    body = re.sub(r' d="[^"]*"', lambda path: re.sub(r"(\.\d\d)\d+", r"\1", path[0]), body)
    return f"{opening}>{body}"
