"""A report and its figures as PDF, by Typst: no browser, the figures as vectors, the letters as text."""

import tempfile
import warnings
from pathlib import Path

from vasowave.errors import VasowaveWarning
from vasowave.report.blocks import Block, Bullets, Drawing, Fold, Heading, Notice, Paragraph, Remarks, Report, Table

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
#let boxed(tint, edge, body) = block(fill: tint, stroke: (left: 3pt + edge), inset: 8pt, width: 100%, body)
"""
_WIDE, _VERY_WIDE = 8, 12  # columns from which a table gets smaller letters


def write_pdf(report: Report, path: Path, figures: Path) -> bool:
    """Write the report to `path` and each figure to the folder `figures`; return whether that was possible.

    Warns
    -----
    VasowaveWarning
        The typesetting library is not installed; nothing is written.
    """
    try:
        from typst import Compiler
    except ImportError:
        warnings.warn(
            "the report has no PDF: install vasowave with the extra 'pdf', or print the page from a browser",
            VasowaveWarning,
            stacklevel=2,
        )
        return False
    import matplotlib

    fonts = [str(Path(matplotlib.get_data_path()) / "fonts" / "ttf")]
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for drawing in report.drawings():
            (folder / f"{drawing.name}.svg").write_text(drawing.svg, encoding="utf-8")
        (folder / "report.typ").write_text(markup(report), encoding="utf-8")
        alone = "#set page(width: auto, height: auto, margin: 0pt)\n"
        compiler = Compiler(root=str(folder), font_paths=fonts, ignore_system_fonts=True)
        for drawing in report.drawings():
            source = folder / f"{drawing.name}.typ"
            source.write_text(f"{alone}#image({quoted(drawing.name + '.svg')})", encoding="utf-8")
            compiler.compile(str(source), output=str(figures / f"{drawing.name}.pdf"), format="pdf")
        compiler.compile(str(folder / "report.typ"), output=str(path), format="pdf")
    return True


def markup(report: Report) -> str:
    """Return the report in Typst's markup; figures are files ``NAME.svg`` beside it."""
    parts = [
        f"#set document(title: {quoted(report.title)})",
        _STYLE,
        f"= #{quoted(report.title)}",
        f"#text(fill: luma(90), {quoted(report.subtitle)})",
    ]
    if report.synthetic:
        words = f"*Synthetic data.* #{quoted(report.synthetic)}"
        parts.append(f'#boxed(rgb("fdf0d5"), rgb("b26a00"))[{words}]')
    for section in report.sections:
        parts += [f"== #{quoted(section.title)}", *map(_block, section.blocks)]
    origin = Table("", "", ("program or input", "version or SHA-256"), list(report.provenance.items()))
    return "\n\n".join([*parts, "== Provenance", _block(origin), ""])


def quoted(text: str) -> str:
    """Return a string literal of Typst; nothing in it is read as markup."""
    escaped = str(text).replace("\\", "\\\\").replace('"', '\\"').replace("\n", "\\n")
    return f'"{escaped}"'


def _block(block: Block) -> str:
    match block:
        case Paragraph():
            return f"#{quoted(block.text)}"
        case Heading():
            return f"=== #{quoted(block.text)}"
        case Bullets():
            return _bullets(block.items)
        case Notice():
            return f'#boxed(rgb("fdecea"), rgb("a4262c"))[*#{quoted(block.title)}*\n{_bullets(block.items)}\n]'
        case Remarks():
            return f'#boxed(rgb("f3f6f7"), rgb("90a4ae"))[*#{quoted(block.title)}*\n{_bullets(block.items)}\n]'
        case Table():
            return _table(block)
        case Drawing():
            width = f"{min(block.figure.get_figwidth(), 17.4 / 2.54):.3f}in"
            image = f"image({quoted(block.name + '.svg')}, width: {width})"
            return f"#block(breakable: false)[#{image}\n#text(7.5pt, {quoted(block.caption)})]"
        case Fold():
            if not block.printed:
                return ""
            return "\n\n".join([f"=== #{quoted(block.title)}", *map(_block, block.blocks)])


def _bullets(items: object) -> str:
    return "#list(" + ", ".join(quoted(item) for item in items) + ",)"  # type: ignore[attr-defined]


def _table(table: Table) -> str:
    count = len(table.header)
    size = 7.5 if count < _WIDE else 6.2 if count < _VERY_WIDE else 5.2
    header = ", ".join(f"[*#{quoted(cell)}*]" for cell in table.header)
    cells = ",\n".join(", ".join(quoted(cell) for cell in row) for row in table.rows)
    body = (
        f"#[#set text({size}pt)\n#table(columns: {count}, align: left, "
        f"table.header({header}, table.hline(stroke: 0.5pt)),\n{cells})]"
    )
    caption = f"#block(below: 0.4em, sticky: true)[*#{quoted(table.caption)}*]\n" if table.caption else ""
    note = f"\n#text(7pt, fill: luma(90), {quoted(table.note)})" if table.note else ""
    return f"{caption}{body}{note}"
