"""The report of a cohort, from the trees of its animals alone: one page, its PDF, figures and tables as files."""

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

import xarray as xr

from vasowave.animal.reading import data_of, wall_laws
from vasowave.cohort.comparison import compare, typical_animal
from vasowave.cohort.statistics import cohort_table
from vasowave.errors import InputError
from vasowave.figures.cohort_gallery import Cohort
from vasowave.figures.style import style
from vasowave.provenance import provenance
from vasowave.report.cohort import methods, words
from vasowave.report.cohort.cells import symbols
from vasowave.report.cohort.sections import animals_section, data_section, groups_section, model_section
from vasowave.report.document import Bullets, Document, Notice, Paragraph, Section
from vasowave.report.files import write_figures, write_tables
from vasowave.report.html import page
from vasowave.report.pdf import write_pdf
from vasowave.report.place import placing
from vasowave.results import FIGURES, REPORT

TABLES = "tables"
PDF = "report.pdf"
_MARK = 'name="generator" content="vasowave'
TITLE = "Hemodynamic assessment of a cohort"
_OWN_ATTRIBUTES = ("title", "Conventions", "animal", "group", "synthetic", "notes")

Failures = Mapping[str, str] | Iterable[tuple[str, str]]


def write_cohort_report(
    trees: Sequence[xr.DataTree],
    folder: Path,
    *,
    failures: Failures = (),
    pdf: bool = True,
    reference: str | None = None,
    title: str = TITLE,
) -> Path:
    """Write ``report.html``, ``report.pdf``, ``figures/`` and ``tables/`` into `folder`; return the page's path.

    Parameters
    ----------
    trees : sequence of DataTree
        One per animal, from `animal.analyze` or `animal.read_tree`.
    folder : Path
        Made if missing. An earlier report in it is replaced, other files stay; whole or not at all.
    failures : mapping of animal to reason, or pairs of them
        Animals that have no tree; the report names them and why.
    pdf : bool
        Whether to typeset the PDF too.
    reference : str, optional
        Group that the others are compared with; by default CTL, or the first.
    title : str
        Title of the page.

    Raises
    ------
    InputError
        No animal, two of the same name, an unknown reference, or a folder that holds another report or cannot be
        written.

    Warns
    -----
    VasowaveWarning
        The library that makes the PDF is not installed.
    """
    folder = Path(folder).resolve()
    _check_free(folder)
    why = dict(failures.items() if isinstance(failures, Mapping) else failures)
    with style():
        document = cohort_document(arranged(trees, why, reference), why, title)
    with placing(folder) as fresh:
        write_figures(document.drawings(), fresh / FIGURES)
        write_tables(document.tables(), fresh / TABLES)
        if pdf:
            write_pdf(document, fresh / PDF, fresh / FIGURES)
        (fresh / REPORT).write_text(page(document), encoding="utf-8")
    if not pdf:
        (folder / PDF).unlink(missing_ok=True)  # an earlier one would contradict the page
    return folder / REPORT


def arranged(trees: Sequence[xr.DataTree], failures: Mapping[str, str], reference: str | None = None) -> Cohort:
    """Return the animals in their groups, the reference group first, and the one that stands for each group."""
    if not trees:
        failed = "".join(f"; {name}: {reason}" for name, reason in failures.items())
        raise InputError(f"there is no animal to report{failed}")
    table = cohort_table(trees)
    labels = list(dict.fromkeys(str(tree.attrs["group"]) for tree in trees))
    first = reference or ("CTL" if "CTL" in labels else labels[0])
    if first not in labels:
        raise InputError(f"no animal is of the reference group '{first}'; there are: {', '.join(labels)}")
    labels.sort(key=lambda label: label != first)
    groups = {label: [tree for tree in trees if str(tree.attrs["group"]) == label] for label in labels}
    ordered = [tree for members in groups.values() for tree in members]
    order = {str(tree.attrs["animal"]): place for place, tree in enumerate(ordered)}
    table = table.iloc[table["animal"].map(order).argsort(kind="stable")].reset_index(drop=True)
    shown = {}
    for label, members in groups.items():
        typical = typical_animal(table, label)
        shown[label] = next(tree for tree in members if str(tree.attrs["animal"]) == typical)
    return Cohort(groups, shown, table)


def cohort_document(cohort: Cohort, failures: Mapping[str, str], title: str = TITLE) -> Document:
    """Return the report of a cohort."""
    found = {source: compare(cohort.table, source) for source in ("measured", *cohort.walls)}
    written = symbols(cohort.trees)
    count = len(cohort.trees)
    return Document(
        title,
        f"{count} {'animal' if count == 1 else 'animals'} in {len(cohort.groups)} "
        f"{'group' if len(cohort.groups) == 1 else 'groups'}: {', '.join(cohort.groups)}",
        words.synthetic_banner(cohort),
        [
            Section(
                "summary",
                "Summary",
                [
                    *([Notice("Animals that failed", words.failure_sentences(failures))] if failures else []),
                    Bullets(words.summary(cohort, found, written)),
                    *_considered(cohort),
                ],
            ),
            data_section(cohort),
            *([model_section(cohort, written)] if cohort.walls else []),
            groups_section(cohort, found, written),
            animals_section(cohort, written),
            Section("methods", "Methods", [Paragraph(text) for text in methods.methods_paragraphs(cohort, found)]),
        ],
        origin(cohort),
    )


def origin(cohort: Cohort) -> dict[str, str]:
    """Return versions, seed, settings and hashes: once where all animals share them, else by animal."""
    rows = {"report made": provenance()["created"], "vasowave": provenance()["vasowave"]}
    keys = dict.fromkeys(str(key) for tree in cohort.trees for key in tree.attrs if key not in _OWN_ATTRIBUTES)
    for key in keys:
        values = {str(tree.attrs["animal"]): str(tree.attrs[key]) for tree in cohort.trees if key in tree.attrs}
        if len(set(values.values())) == 1 and len(values) == len(cohort.trees):
            label = f"{key} of the animals' results" if key in rows else key
            rows[label] = next(iter(values.values()))
        else:
            rows |= {f"{key} ({animal})": value for animal, value in values.items()}
    rows |= {
        f"source of {tree.attrs['animal']}": str(data_of(tree, "recording").attrs.get("source", ""))
        for tree in cohort.trees
    }
    return rows


def _considered(cohort: Cohort) -> list[Notice]:
    """Return where the notes are; each stands in full with its animal."""
    counts = {str(tree.attrs["animal"]): len(words.notes(tree)) for tree in cohort.trees}
    noted = ", ".join(f"{animal} ({count})" for animal, count in counts.items() if count)
    items = [f"Notes stand with the animals under “Every animal”: {noted}."] if noted else []
    missing = {wall: [t for t in cohort.trees if wall not in wall_laws(t)] for wall in cohort.walls}
    items += [
        f"{tree.attrs['animal']} was not calibrated with the {wall} wall."
        for wall, without in missing.items()
        for tree in without
    ]
    if differing := methods.differing_settings(cohort):
        items.append(f"The animals were not all analyzed with the same settings: {', '.join(differing)}.")
    return [Notice("To be considered", items)] if items else []


def _check_free(folder: Path) -> None:
    """Raise `InputError` if writing the report would replace something that is not an earlier report."""
    if folder.exists() and not folder.is_dir():
        raise InputError(f"{folder} is a file; give the name of a folder")
    page_there = folder / REPORT
    if page_there.is_file() and _MARK in page_there.read_text(encoding="utf-8", errors="replace")[:2000]:
        return
    for name in (REPORT, PDF, FIGURES, TABLES):
        if (folder / name).exists():
            raise InputError(f"{folder / name} is not of an earlier vasowave report; give another folder or move it")
