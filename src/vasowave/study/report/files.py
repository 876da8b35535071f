"""Figures and tables of a report as files: SVG; CSV in full precision, LaTeX as they stand on the page."""

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import pandas as pd

from vasowave.base.io.columns import spreadsheet_cell
from vasowave.base.io.files import make_folder, write_file
from vasowave.study.figures.rendering import described
from vasowave.study.report.blocks import Drawing, Table, drawn

Each = Callable[[Callable[[Any], Any], Iterable[Any]], Iterable[Any]]
"""Applies a function to each of many things, in order, as the built-in `map` does; perhaps in other processes."""

_LATEX = {
    **{mark: f"\\{mark}" for mark in "&%$#_{}"},
    "\\": r"\textbackslash{}", "~": r"\textasciitilde{}", "^": r"\textasciicircum{}",
    "<": "$<$", ">": "$>$", "|": "$|$",
    "±": r"$\pm$", "·": r"$\cdot$", "–": "--", "−": "$-$", "√": r"$\surd$", "≤": r"$\leq$", "≥": r"$\geq$",
    "†": r"\dag{}", "‡": r"\ddag{}", "…": r"\dots{}", "₊": "$_+$", "₋": "$_-$",
    "α": r"$\alpha$", "β": r"$\beta$", "γ": r"$\gamma$", "δ": r"$\delta$", "η": r"$\eta$", "θ": r"$\theta$",
    "λ": r"$\lambda$", "μ": r"$\mu$", "ν": r"$\nu$", "π": r"$\pi$", "ρ": r"$\rho$", "σ": r"$\sigma$", "τ": r"$\tau$",
    "ω": r"$\omega$", "Δ": r"$\Delta$", "Σ": r"$\Sigma$",
}  # fmt: skip
_RAISED = str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "-0123456789")
_LOWERED = str.maketrans("₀₁₂₃₄₅₆₇₈₉", "0123456789")
_PIECE = re.compile(
    r"(?P<symbol>\b[A-Za-z]_[A-Za-z0-9]\b)|(?P<raised>[⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+)|(?P<lowered>[₀₁₂₃₄₅₆₇₈₉]+)|(?P<mark>.)", re.DOTALL
)


def write_figures(drawings: Sequence[Drawing], folder: Path, mapper: Each = map) -> None:
    """Write every figure to `folder` as SVG with editable letters; `mapper` may draw several at a time."""
    make_folder(folder)
    for drawing, text in zip(drawings, mapper(drawn, [drawing.figure for drawing in drawings]), strict=True):
        drawing.keep(text)
        svg = described(text, drawing.name, drawing.caption)
        write_file(folder / f"{drawing.name}.svg", svg)


def write_tables(tables: Sequence[Table], records: Mapping[str, pd.DataFrame], folder: Path) -> None:
    """Write tables as CSV (full precision, units in the headers) and LaTeX (package booktabs), records as CSV only."""
    make_folder(folder)
    for table in tables:
        data = pd.DataFrame(table.rows, columns=list(table.header)) if table.data is None else table.data
        _write_csv(data, folder / f"{table.name}.csv")
        write_file(folder / f"{table.name}.tex", latex_table(table))
    for name, data in records.items():
        _write_csv(data, folder / f"{name}.csv")


def _write_csv(data: pd.DataFrame, path: Path) -> None:
    """Write a table whose texts no spreadsheet runs; those of millions of rows are few, and each is looked at once."""
    safe = data.rename(columns=spreadsheet_cell)
    for place, kind in enumerate(data.dtypes):
        if not pd.api.types.is_numeric_dtype(kind):
            column = data.iloc[:, place]
            texts = {text: spreadsheet_cell(text) for text in column.unique() if isinstance(text, str)}
            safe.isetitem(
                place, column.replace({text: cell for text, cell in texts.items() if text != cell}).to_numpy()
            )
    write_file(path, safe.to_csv(index=False, lineterminator="\n"))


def latex_table(table: Table) -> str:
    """Return the table as LaTeX, for a document with ``\\usepackage{booktabs}``."""
    frame = pd.DataFrame([[latex(cell) for cell in row] for row in table.rows], columns=list(map(latex, table.header)))
    caption = f"{table.caption}. {table.note}" if table.note else table.caption
    text = frame.to_latex(
        index=False, escape=False, caption=latex(caption), label=f"tab:{table.name}", column_format="l" * frame.shape[1]
    )
    return f"% needs \\usepackage{{booktabs}}\n{text}"


def latex(text: str) -> str:
    """Return text with everything that LaTeX would take for a command, and every Greek letter, as LaTeX writes it."""
    return _PIECE.sub(_as_latex, text)


def _as_latex(piece: re.Match[str]) -> str:
    if piece["symbol"]:
        return f"${piece['symbol']}$"
    if piece["raised"]:
        return f"$^{{{piece['raised'].translate(_RAISED)}}}$"
    if piece["lowered"]:
        return f"$_{{{piece['lowered'].translate(_LOWERED)}}}$"
    return _LATEX.get(piece["mark"], piece["mark"])
