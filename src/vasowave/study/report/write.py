"""A report as files: the page of one result and the supplement, their PDF, every figure and table."""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from vasowave.base.errors import InputError
from vasowave.base.io.files import remove_file, write_file, write_folder
from vasowave.base.settings import given_values
from vasowave.study.animal.failure import Failure
from vasowave.study.animal.result import AnimalResult
from vasowave.study.cohort.cohort import Cohort, gathered
from vasowave.study.cohort.primary import primary_comparison
from vasowave.study.figures.matplotlib_style import style
from vasowave.study.report.blocks import REPORT, SUPPLEMENT, Report
from vasowave.study.report.documents import pages_of, report_of, supplement_of
from vasowave.study.report.files import Each, write_figures, write_tables
from vasowave.study.report.html import page
from vasowave.study.report.pdf import write_pdf
from vasowave.study.report.settings import ReportSettings

Tell = Callable[[Sequence[tuple[str, str]]], None]
"""What is given the questions of a page with their answers."""

PAGE, FIGURES, TABLES = f"{REPORT}.html", "figures", "tables"
PDFS = f"{REPORT}.pdf", f"{SUPPLEMENT}.pdf"
_FURTHER = f"{SUPPLEMENT}-animals-{{}}.html"
_OURS = (PAGE, f"{SUPPLEMENT}.html", *PDFS, FIGURES, TABLES)
_MARK = 'name="generator" content="vasowave'


def write_report(
    results: Sequence[AnimalResult],
    folder: str | Path,
    *,
    lost: Sequence[Failure] = (),
    reference: str | None = None,
    title: str = "",
    each: Each = map,
    **settings: Any,
) -> Path:
    """Write ``report`` and ``supplement`` (.html, .pdf), ``figures/`` and ``tables/``; return the report's page.

    Where animals are many, pages beside the supplement show them one by one, 48 on each.

    Parameters
    ----------
    results : sequence of AnimalResult
        One per animal, from `animal.analyze` or `animal.read_result`; one is enough.
    folder : str or Path
        Made if missing. An earlier report in it is replaced, other files stay; whole or not at all.
    lost : sequence of Failure
        Animals that have no result, see `animal.failure`; the report names them and why. What failed of an animal that
        has one stands in its result.
    reference : str, optional
        Group that the others are compared with; by default CTL, or the first.
    title : str
        Of the page; by default what it is about.
    each : callable
        Draws the figures as `map` would; that of a pool of processes draws several at a time.
    settings
        Those of `ReportSettings` by name: ``pdf=False``; ``law, quantities``, the primary family.

    Raises
    ------
    InputError
        No animal, two of the same name, an unknown reference, law or quantity, or a folder that holds another report
        or cannot be written.

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
    report_settings = given_values(ReportSettings, None, settings)
    if not results:
        raise InputError(
            "; ".join(["there is no animal to report", *(f"{failure.animal}: {failure.reason}" for failure in lost)])
        )
    cohort = gathered(results, reference, lost=lost)
    return write_cohort_report(cohort, folder, report_settings, title=title, mapper=each)


def write_cohort_report(
    cohort: Cohort,
    folder: str | Path,
    report_settings: ReportSettings,
    *,
    title: str,
    mapper: Each = map,
    on_answers: Tell | None = None,
) -> Path:
    """Do what `write_report` does, for animals that are gathered already; `on_answers` gets the answers of the page."""
    folder = Path(folder).resolve()
    _check_free(folder)
    with style():
        primary = primary_comparison(cohort, report_settings)
        documents = (report_of(cohort, primary, report_settings, title), supplement_of(cohort, primary, title))
    _place(documents, folder, report_settings.pdf, mapper)
    if on_answers is not None:
        on_answers(documents[0].answers())
    return folder / PAGE


def _place(documents: Sequence[Report], folder: Path, pdf: bool, mapper: Each) -> None:
    with write_folder(folder) as fresh:
        write_figures([drawing for document in documents for drawing in document.drawings()], fresh / FIGURES, mapper)
        for document in documents:
            write_tables(document.tables(), document.records, fresh / TABLES)
        typeset = pdf and write_pdf(documents, fresh, fresh / FIGURES)
        report, supplement = documents
        further = _write_supplement(supplement, fresh, typeset)
        write_file(fresh / PAGE, page(report, {"Supplement": f"{SUPPLEMENT}.html"} | _pdf_of(report, typeset)))
    outdated = {folder / name for name in PDFS if not typeset} | {
        file for file in folder.glob(_FURTHER.format("[0-9]*")) if _is_report(file)
    }
    for file in outdated - {folder / name for name in further}:
        remove_file(file)  # of an earlier report, which would contradict the page


def _write_supplement(supplement: Report, folder: Path, typeset: bool) -> list[str]:
    """Write the page of the supplement and its further ones, and return the files of those."""
    (_, main_page), *further = pages_of(supplement).items()
    files = {title: _FURTHER.format(place) for place, (title, _) in enumerate(further, start=1)}
    back = {"Supplement": f"{SUPPLEMENT}.html", "The result on one page": PAGE}
    for title, document in further:
        write_file(folder / files[title], page(document, back))
    links = {"The result on one page": PAGE} | files | _pdf_of(supplement, typeset)
    write_file(folder / f"{SUPPLEMENT}.html", page(main_page, links))
    return list(files.values())


def _pdf_of(document: Report, typeset: bool) -> dict[str, str]:
    """Return the document's PDF by what a link calls it, where it was typeset."""
    return {"PDF": f"{document.name}.pdf"} if typeset else {}


def _is_report(file: Path) -> bool:
    """Whether a page is of an earlier report."""
    return _MARK in file.read_text(encoding="utf-8", errors="replace")[:2000]


def _check_free(folder: Path) -> None:
    """Raise `InputError` if writing the report would replace something that is not an earlier report."""
    if folder.exists() and not folder.is_dir():
        raise InputError(f"{folder} is a file; give the name of a folder")
    page_path = folder / PAGE
    if page_path.is_file() and _is_report(page_path):
        return
    for name in _OURS:
        if (folder / name).exists():
            raise InputError(f"{folder / name} is not of an earlier vasowave report; give another folder or move it")
