"""The report of one calibrated animal: summary, tables, figures, methods, provenance."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import xarray as xr

from vasowave.animal.datasets import groups
from vasowave.calibration.result import Fit
from vasowave.figures.gallery import gallery
from vasowave.figures.style import CTL
from vasowave.provenance import provenance
from vasowave.report import methods, summary
from vasowave.report.document import Block, Bullets, Document, Drawing, Heading, Notice, Paragraph, Section, Table
from vasowave.report.files import write_figures
from vasowave.report.html import page
from vasowave.report.place import placing
from vasowave.report.wording import table_rows
from vasowave.results import FIGURES, REPORT, prepared_folder, starts_table

if TYPE_CHECKING:
    from matplotlib.figure import Figure

CAPTIONS = {
    "fit": "Measured (black) and fitted pressure and flow at the inlet of the root vessel, and what is left: "
    "measured minus simulated pressure.",
    "nominal": "Where the fit starts: characteristic impedance Z_c from the slope of the pressure-flow loop during "
    "early ejection (left); time constant τ from the diastolic decay (right).",
    "tree": "Pressure and flow at the middle of chosen vessels; in brackets the vessel's share of the mean flow "
    "(eq. 11).",
    "loop": "Pressure against area at the middle of the root vessel over one cycle (thick), and the wall law from zero "
    "pressure on (thin).",
    "network": "The network as a directed graph, with each vessel's share of the mean flow; width follows the radius, "
    "lengths are not to scale.",
}
SYNTHETIC = (
    "This recording was made by a model, not measured in an animal. The numbers below show how the program works and "
    "say nothing about any animal."
)


def write_report(fits: Sequence[Fit], folder: Path, inputs: Sequence[Path] = (), color: str = CTL) -> Path:
    """Write ``report.html`` and ``figures/`` (SVG, PDF, PNG) into `folder`, and return the page's path.

    Parameters
    ----------
    fits : sequence of Fit
        One fit per wall law, all of the same recording.
    folder : Path
        Made if missing; usually the one that `write_results` filled.
    inputs : sequence of Path, optional
        Files that were read; their SHA-256 stands in the page.
    color : str
        Color of the animal's group, see `figures.style`.

    Raises
    ------
    InputError
        The folder holds something else than a vasowave result or cannot be written; the fits do not belong together.
    """
    folder = prepared_folder(fits, folder)
    drawn = gallery(xr.DataTree.from_dict({f"/{name}": dataset for name, dataset in groups(fits).items()}), color)
    document = animal_document(fits, drawn, provenance(inputs))
    with placing(folder) as fresh:
        write_figures(document.drawings(), fresh / FIGURES, pixels=True)
        (fresh / REPORT).write_text(page(document), encoding="utf-8")
    return folder / REPORT


def animal_document(fits: Sequence[Fit], figures: dict[str, "Figure"], origin: dict[str, str]) -> Document:
    """Return the report of one animal."""
    return Document(
        "Calibrated pulse-wave model",
        f"Recording: {fits[0].recording.source}",
        SYNTHETIC if summary.is_synthetic(fits) else "",
        [
            Section("summary", "Summary", _summary(fits)),
            Section("figures", "Figures", [Drawing(name, CAPTIONS[name], figure) for name, figure in figures.items()]),
            Section("tables", "Tables", _tables(fits)),
            Section(
                "methods",
                "Methods",
                [
                    *map(Paragraph, methods.methods_sentences(fits)),
                    Table("", "Settings and checks of the simulations", *methods.numerics_rows(fits)),
                ],
            ),
        ],
        origin,
    )


def _summary(fits: Sequence[Fit]) -> list[Block]:
    blocks: list[Block] = [Paragraph(text) for text in summary.recording_sentences(fits)]
    for fit in fits:
        blocks += [Heading(f"{fit.wall.capitalize()} wall"), Bullets(summary.fit_sentences(fit))]
    if found := summary.warnings(fits):
        blocks.append(Notice("To be considered", found))
    return [*blocks, Table("", "What sums up each fit", *summary.outcome_rows(fits))]


def _tables(fits: Sequence[Fit]) -> list[Block]:
    blocks: list[Block] = [
        Table("", "Hemodynamic indices, measured and simulated", *summary.indices_rows(fits)),
        Table("", "Nominal parameters", *summary.nominal_rows(fits[0])),
    ]
    for fit in fits:
        wall, matrix = f"{fit.wall.capitalize()} wall", fit.correlation.rename_axis("").reset_index()
        blocks += [
            Table("", f"{wall}: parameters", *summary.parameter_rows(fit)),
            Table("", f"{wall}: correlation of the estimates", *table_rows(matrix, 2)),
            Table("", f"{wall}: starts of the optimization", *table_rows(starts_table(fit))),
        ]
    return blocks
