"""The folder of a network that comes from the centerlines of another program."""

import json
from collections.abc import Mapping, Sequence
from pathlib import Path

from vasowave.figures.style import style
from vasowave.imaging.measure.measurement import Measurement
from vasowave.io.files import check_folder, write_folder
from vasowave.provenance import provenance
from vasowave.report.extraction import FIGURES, network_figure, write_network_files

SETTINGS = "centerlines.json"
MARKS = {SETTINGS: b'"vasowave"'}


def check_centerlines_folder(folder: Path) -> None:
    """Raise `InputError` unless `folder` is missing, empty, or an earlier network of centerlines."""
    check_folder(Path(folder), MARKS)


def write_centerline_network(
    measured: Measurement, sources: Sequence[Path], settings: Mapping[str, str | float], folder: Path
) -> None:
    """Write the network, its tables, centerlines and graph into `folder`, whole or not at all.

    Parameters
    ----------
    measured : Measurement
        See `measure.measurement.measured_alone`.
    sources : sequence of Path
        The file it comes from, and the others that were read.
    settings : mapping
        How it was read, for the record.
    folder : Path

    Raises
    ------
    InputError
        The folder holds something else or cannot be written.
    """
    folder = Path(folder).resolve()
    check_centerlines_folder(folder)
    origin = provenance(list(sources))
    with write_folder(folder) as fresh:
        write_network_files(measured, fresh)
        (fresh / FIGURES).mkdir()
        with style():
            figure = network_figure(measured.network)
            for kind, made in (("svg", {"Date": None}), ("png", {"Software": None})):
                figure.savefig(fresh / FIGURES / f"network.{kind}", metadata=made)
        stored = {"file": sources[0].name, "settings": dict(settings), "provenance": origin}
        (fresh / SETTINGS).write_text(json.dumps(stored, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
