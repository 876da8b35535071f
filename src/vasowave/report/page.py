"""The report of one calibrated animal: figures drawn, numbers written, one HTML file that needs no network."""

import os
import re
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from vasowave.calibration.result import Fit
from vasowave.errors import InputError
from vasowave.figures.gallery import gallery, svg, write_figures
from vasowave.figures.style import CTL
from vasowave.provenance import provenance
from vasowave.report import methods, summary
from vasowave.results import FIGURES, REPORT, check_fits, check_folder, starts_table

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


def write_report(fits: Sequence[Fit], folder: Path, inputs: Sequence[Path] = (), color: str = CTL) -> Path:
    """Write ``report.html`` and ``figures/`` (SVG, PNG) into `folder`, and return the page's path.

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
    check_fits(fits)
    folder = Path(folder).resolve()
    check_folder(folder)
    drawn = gallery(fits, color)
    page = render(fits, drawn, provenance(inputs))
    try:
        folder.mkdir(parents=True, exist_ok=True)
        write_figures(drawn, folder / FIGURES)
        _write_whole(page, folder / REPORT)
    except OSError as error:
        raise InputError(f"{folder}: the report cannot be written ({error.strerror or error})") from error
    return folder / REPORT


def render(fits: Sequence[Fit], figures: dict[str, "Figure"], origin: dict[str, str]) -> str:
    """Return the page as HTML text with the figures inside."""
    from jinja2 import Environment, PackageLoader, StrictUndefined

    environment = Environment(
        loader=PackageLoader("vasowave.report"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    return environment.get_template("page.html").render(_content(fits, figures, origin))


def embedded(figure: "Figure", name: str) -> str:
    """Return the figure as SVG to stand inside HTML: no prolog, scalable, ids that are unique in the page."""
    text = svg(figure)
    text = text[text.index("<svg") :]
    opening, rest = text.split(">", 1)
    opening = re.sub(r'\s(xmlns(:\w+)?|width|height|version)="[^"]*"', "", opening)
    # Letters stay readable: the drawing shrinks to 0.7 of its size at most, then its box scrolls.
    pixels = 96 * figure.get_figwidth()
    opening += f' style="width: 100%; min-width: {0.7 * pixels:.0f}px; max-width: {1.3 * pixels:.0f}px"'
    rest = re.sub(r'\bid="', f'id="{name}-', rest)
    rest = re.sub(r'(xlink:href="#|url\(#)', rf"\g<1>{name}-", rest)
    return f"{opening}>{rest}"


def _content(fits: Sequence[Fit], figures: dict[str, "Figure"], origin: dict[str, str]) -> dict[str, Any]:
    recording = fits[0].recording
    return {
        "source": recording.source,
        "synthetic": summary.is_synthetic(fits),
        "recording_sentences": summary.recording_sentences(fits),
        "fits": [
            {
                "wall": fit.wall,
                "sentences": summary.fit_sentences(fit),
                "parameters": summary.parameter_rows(fit),
                "correlation": summary.table_rows(fit.correlation.rename_axis("").reset_index(), 2),
                "starts": summary.table_rows(starts_table(fit)),
            }
            for fit in fits
        ],
        "warnings": summary.warnings(fits),
        "outcome": summary.outcome_rows(fits),
        "indices": summary.indices_rows(fits),
        "nominal": summary.nominal_rows(fits[0]),
        "figures": [
            {"name": name, "svg": embedded(figure, name), "caption": CAPTIONS[name]} for name, figure in figures.items()
        ],
        "methods": methods.methods_sentences(fits),
        "numerics": methods.numerics_rows(fits),
        "provenance": origin,
    }


def _write_whole(text: str, path: Path) -> None:
    """Write the text beside `path` first and rename, so that a reader never meets half a page."""
    handle, name = tempfile.mkstemp(prefix=f".{path.name}-", dir=path.parent)
    try:
        with os.fdopen(handle, "w", encoding="utf-8") as file:
            file.write(text)
        Path(name).chmod(0o644)
        os.replace(name, path)
    finally:
        Path(name).unlink(missing_ok=True)
