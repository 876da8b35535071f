"""A report and its figures as PDF, by Typst: no browser, the figures as vectors, the letters as text."""

import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import cast

from vasowave.base.errors import EXTRAS
from vasowave.base.findings import look_kind, warn
from vasowave.base.io.files import write_file
from vasowave.study.figures.subscripts import pieces
from vasowave.study.report.blocks import (
    SUPPLEMENT,
    Answers,
    Block,
    Bullets,
    Drawing,
    Fold,
    Heading,
    Notice,
    OnScreen,
    Paragraph,
    Remarks,
    Report,
    RotatingView,
    SideBySide,
    Table,
)

_STYLE = """
#set page(paper: "a4", margin: (x: 1.8cm, y: 2cm), numbering: "1 / 1")
#set text(font: "DejaVu Sans", size: 8.5pt, lang: "en", hyphenate: false)
#set par(leading: 0.6em, spacing: 0.9em)
#set table(stroke: none, inset: (x: 3pt, y: 2.2pt))
#show heading.where(level: 1): set text(15pt)
#show heading.where(level: 2): it => block(above: 1.8em, below: 0.8em, text(12pt, it.body))
#show heading.where(level: 3): it => block(above: 1.3em, below: 0.6em, text(9.5pt, it.body))
#show figure: set block(breakable: true)
#show figure.caption: it => align(left, text(7.5pt, it.body))
#let fitted(name, width, height, caption) = context {
  let above = query(selector(<words-end>).before(here())).last().location().position().y
  let below = measure(block(width: page.width - 3.6cm, caption)).height
  let share = (page.height - 2cm - above - below - 26pt) / height
  let drawn(scale) = block(breakable: false)[#image(name, width: width * scale)
#caption]
  if share > LEAST { drawn(calc.min(1, share)) } else {
    place(top, float: true, drawn(calc.min(1, (page.height - 4cm - below - 26pt) / height)))
  }
}
#let boxed(tint, edge, body) = block(fill: tint, stroke: (left: 3pt + edge), inset: 8pt, width: 100%, body)
"""
_LEAST_SCALE = 0.7
"""To which a figure shrinks to stand under its words; one that is too tall then stands on top of the next page."""
_UNBROKEN_ROWS = 24  # rows of a table that is not broken over pages
_MAX_ROWS = 36  # rows of a table that paper holds, about a page
_WIDE, _VERY_WIDE = 8, 12  # columns from which a table gets smaller letters

NO_PDF = look_kind(
    "report.no-pdf",
    "the report has no PDF: {remedy}",
    f"install the extra 'pdf' ({EXTRAS}), or print the page from a browser",
)


def write_pdf(reports: Sequence[Report], folder: Path, figures: Path) -> bool:
    """Write ``NAME.pdf`` of every document to `folder`, each figure to `figures`; return whether that was possible.

    Warns
    -----
    VasowaveWarning
        The typesetting library is not installed; nothing is written.
    """
    try:
        from typst import Compiler
    except ImportError:
        warn(NO_PDF())
        return False
    import matplotlib

    fonts = [str(Path(matplotlib.get_data_path()) / "fonts" / "ttf")]
    with tempfile.TemporaryDirectory() as name:
        drafts = Path(name)
        compiler = Compiler(root=str(drafts), font_paths=fonts, ignore_system_fonts=True)

        def typeset(text: str, target: Path) -> None:
            source = drafts / f"{target.stem}.typ"
            write_file(source, text)
            write_file(target, cast(bytes, compiler.compile(str(source), format="pdf")))

        for report in reports:
            for drawing in report.drawings():
                write_file(drafts / f"{drawing.name}.svg", drawing.svg)
                alone = f"#set page(width: auto, height: auto, margin: 0pt)\n#image({quoted(drawing.name + '.svg')})"
                typeset(alone, figures / f"{drawing.name}.pdf")
            typeset(markup(report), folder / f"{report.name}.pdf")
    return True


def markup(report: Report) -> str:
    """Return the report in Typst's markup; figures are files ``NAME.svg`` beside it."""
    paragraphs = [
        f"#set document(title: {quoted(report.title)})",
        _STYLE.replace("LEAST", str(_LEAST_SCALE)),
        f"= #{written(report.title)}",
        f"#text(fill: luma(90), {quoted(report.subtitle)})",
    ]
    if report.synthetic:
        words = f"*Synthetic data.* #{quoted(report.synthetic)}"
        paragraphs.append(f'#boxed(rgb("fdf0d5"), rgb("b26a00"))[{words}]')
    if report.name == SUPPLEMENT:
        paragraphs.append("#outline(title: none, target: heading.where(level: 2), indent: 0pt)")
    for section in report.sections:
        paragraphs += [f"== #{written(section.title)}", *map(_block, section.blocks)]
    if report.name != SUPPLEMENT:
        return "\n\n".join([*paragraphs, ""])
    origin = Table("", "", ("program or input", "version or SHA-256"), list(report.provenance.items()))
    return "\n\n".join([*paragraphs, "== Provenance", _block(origin), ""])


def quoted(text: str) -> str:
    """Return a string literal of Typst; nothing in it is read as markup."""
    escaped = str(text).replace("\\", "\\\\").replace('"', '\\"').replace("\n", "\\n")
    return f'"{escaped}"'


def written(text: str) -> str:
    """Return text as a value of Typst, its subscripts true ones."""
    fragments = [f"#{quoted(base)}" + (f"#sub({quoted(low)})" if low else "") for base, low in pieces(str(text))]
    return quoted(text) if len(fragments) == 1 else f"[{''.join(fragments)}]"


def _block(block: Block) -> str:
    match block:
        case Paragraph():
            return f"#{written(block.text)}"
        case Heading():
            return f"=== #{written(block.text)}"
        case Bullets():
            return _bullets(block.items)
        case Answers():
            ended = [(title if title.endswith("?") else f"{title}.", answer) for title, answer in block.items]
            return "\n\n".join(f"*#{written(title)}* #{written(answer)}" for title, answer in ended)
        case SideBySide():
            return _columns(block)
        case Notice():
            return f'#boxed(rgb("fdecea"), rgb("a4262c"))[*#{written(block.title)}*\n{_bullets(block.items)}\n]'
        case Remarks():
            return f'#boxed(rgb("f3f6f7"), rgb("90a4ae"))[*#{written(block.title)}*\n{_bullets(block.items)}\n]'
        case Table():
            return _table(block)
        case Drawing():
            image = f"image({quoted(block.name + '.svg')}, width: {_size(block)[0]:.3f}in)"
            return f"#block(breakable: false)[#{image}\n#text(7.5pt, {written(block.caption)})]"
        case RotatingView() | OnScreen():
            return ""
        case Fold():
            return "\n\n".join([f"=== #{written(block.title)}", *map(_block, block.blocks)])


def _columns(block: SideBySide) -> str:
    """Two figures stand side by side; words and figures follow each other, one figure on the page of its words."""
    pictures = [picture for picture in block.blocks if isinstance(picture, Drawing)]
    *words, last = block.blocks
    if words and pictures == [last]:
        width, height = _size(pictures[0])
        ended = "\n\n".join(map(_block, words)) + "#metadata(none)<words-end>"
        drawn = f"{quoted(pictures[0].name + '.svg')}, {width:.3f}in, {height:.3f}in"
        return f"{ended}\n\n#fitted({drawn}, text(7.5pt, {written(pictures[0].caption)}))"
    if len(pictures) < 2 or len(pictures) < len(block.blocks):
        return "\n\n".join(map(_block, block.blocks))
    cells = ", ".join(
        f"[#image({quoted(picture.name + '.svg')}, width: 100%)\n#text(7.5pt, {written(picture.caption)})]"
        for picture in pictures
    )
    return f"#grid(columns: {len(pictures)}, gutter: 10pt, {cells})"


def _size(drawing: Drawing) -> tuple[float, float]:
    """Return width and height, in, of a figure that is no wider than the text."""
    width, height = drawing.size
    share = min(1.0, 17.4 / 2.54 / width)
    return share * width, share * height


def _bullets(items: object) -> str:
    return "#list(" + ", ".join(written(item) for item in items) + ",)"  # type: ignore[attr-defined]


def _table(table: Table) -> str:
    if table.name and len(table.rows) > _MAX_ROWS:
        where = f"{len(table.rows)} rows: tables/{table.name}.csv, and the supplement's page."
        return f"#block[*#{written(table.caption)}.* #{written(where)}]"
    count = len(table.header)
    size = 7.5 if count < _WIDE else 6.2 if count < _VERY_WIDE else 5.2
    header = ", ".join(f"[*#{written(cell)}*]" for cell in table.header)
    cells = ",\n".join(", ".join(written(cell) for cell in row) for row in table.rows)
    body = (
        f"#[#set text({size}pt)\n#table(columns: {count}, align: left, "
        f"table.header({header}, table.hline(stroke: 0.5pt)),\n{cells})]"
    )
    caption = f"#block(below: 0.4em, sticky: true)[*#{written(table.caption)}*]\n" if table.caption else ""
    note = f"\n#text(7pt, fill: luma(90), {written(table.note)})" if table.note else ""
    text = f"{caption}{body}{note}"
    return f"#block(breakable: false)[{text}]" if len(table.rows) <= _UNBROKEN_ROWS else text
