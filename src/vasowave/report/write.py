"""A report as files: one page, its PDF, every figure and table."""

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

import xarray as xr

from vasowave.cohort.cohort import gathered
from vasowave.errors import InputError
from vasowave.figures.style import style
from vasowave.files import write_folder
from vasowave.report.blocks import Report
from vasowave.report.contents import report_of
from vasowave.report.files import write_figures, write_tables
from vasowave.report.html import page
from vasowave.report.pdf import write_pdf

PAGE, PDF, FIGURES, TABLES = "report.html", "report.pdf", "figures", "tables"
_MARK = 'name="generator" content="vasowave'

Failures = Mapping[str, str] | Iterable[tuple[str, str]]


def write_report(
    trees: Sequence[xr.DataTree],
    folder: Path,
    *,
    failures: Failures = (),
    pdf: bool = True,
    reference: str | None = None,
    title: str = "",
) -> Path:
    """Write ``report.html``, ``report.pdf``, ``figures/`` and ``tables/`` into `folder`; return the page's path.

    Parameters
    ----------
    trees : sequence of DataTree
        One per animal, from `animal.analyze` or `animal.read_tree`; one is enough.
    folder : Path
        Made if missing. An earlier report in it is replaced, other files stay; whole or not at all.
    failures : mapping of animal to reason, or pairs of them
        Animals that have no tree; the report names them and why.
    pdf : bool
        Whether to typeset the PDF too.
    reference : str, optional
        Group that the others are compared with; by default CTL, or the first.
    title : str
        Of the page; by default what it is about.

    Raises
    ------
    InputError
        No animal, two of the same name, an unknown reference, or a folder that holds another report or cannot be
        written.

    Warns
    -----
    VasowaveWarning
        The library that makes the PDF is not installed.

    Examples
    --------
    >>> import vasowave as vw
    >>> quick = vw.Settings(starts=1, model_selection=False)
    >>> mouse = vw.Animal("mouse 6", "CTL", vw.control_network(), vw.virtual_mouse(), synthetic=True)
    >>> vw.write_report([vw.analyze(mouse, quick)], "my-report", pdf=False).name
    'report.html'
    """
    folder = Path(folder).resolve()
    _check_free(folder)
    why = dict(failures.items() if isinstance(failures, Mapping) else failures)
    if not trees:
        raise InputError(
            "; ".join(["there is no animal to report", *(f"{name}: {text}" for name, text in why.items())])
        )
    with style():
        report = report_of(gathered(trees, reference), why, title)
    _place(report, folder, pdf)
    return folder / PAGE


def _place(report: Report, folder: Path, pdf: bool) -> None:
    with write_folder(folder) as fresh:
        write_figures(report.drawings(), fresh / FIGURES)
        write_tables(report.tables(), report.records, fresh / TABLES)
        if pdf:
            write_pdf(report, fresh / PDF, fresh / FIGURES)
        (fresh / PAGE).write_text(page(report), encoding="utf-8")
    if not pdf:
        (folder / PDF).unlink(missing_ok=True)  # an earlier one would contradict the page


def _check_free(folder: Path) -> None:
    """Raise `InputError` if writing the report would replace something that is not an earlier report."""
    if folder.exists() and not folder.is_dir():
        raise InputError(f"{folder} is a file; give the name of a folder")
    there = folder / PAGE
    if there.is_file() and _MARK in there.read_text(encoding="utf-8", errors="replace")[:2000]:
        return
    for name in (PAGE, PDF, FIGURES, TABLES):
        if (folder / name).exists():
            raise InputError(f"{folder / name} is not of an earlier vasowave report; give another folder or move it")
