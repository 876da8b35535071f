"""Recorders' own binary files, which their programs alone open: each is named, with the export that helps."""

from pathlib import Path
from typing import Any, NamedTuple

from vasowave.base.errors import InputError
from vasowave.catheter.read.formats import RECORDINGS, RecordingFormat
from vasowave.catheter.signals.channels import Block


class Foreign(NamedTuple):
    """A program's own file: how it is known, and what its program exports instead."""

    title: str
    suffixes: tuple[str, ...]
    program: str
    steps: str


FOREIGN = (
    Foreign(
        "LabChart", (".adicht", ".adidat", ".adibin"), "LabChart",
        "open it, select the stretch to use (nothing means all), File > Export…, 'Save as type': 'LabChart Text File "
        "(*.txt)' or 'MATLAB File (*.mat)', Save; in the dialog tick time, comments and the block header, do not "
        "downsample",
    ),
    Foreign(
        "AcqKnowledge", (".acq",), "AcqKnowledge",
        "open it, File > Save As…, 'Save as type': 'Text (*.txt, *.csv)', tick the header, the times and the channel "
        "titles, do not resample",
    ),
    Foreign(
        "Spike2", (".smr", ".smrx"), "Spike2",
        "open it, File > Export As…, 'Text file (*.txt)' or 'Spreadsheet text', choose the channels of pressure, flow "
        "and ECG at their own rate, Export",
    ),
    Foreign(
        "emka IOX", (".mkt", ".iox"), "IOX or ECGauto",
        "open it, export the raw signals as text (*.txt) or Excel with titles, units and the site time",
    ),
    Foreign(
        "Notocord-hem", (".nss", ".ncd"), "Notocord-hem",
        "replay it with an export module (ASCII) on the streams of pressure, flow and ECG, at their own rate, with "
        "names and units",
    ),
    Foreign(
        "Ponemah", (".rvw", ".pnm", ".pnmexp"), "Ponemah",
        "open it in the review, export the waveforms as ASCII text with the header and absolute or elapsed time, not "
        "the derived parameters",
    ),
    Foreign(
        "Axon", (".abf",), "Clampfit", "open it, File > Save As…, 'Axon Text File (*.atf)' or text",
    ),
)  # fmt: skip


def _recognized(path: Path) -> Foreign | None:
    return next((form for form in FOREIGN if path.suffix.lower() in form.suffixes), None)


def _is_foreign(path: Path, start: bytes) -> bool:
    form = _recognized(path)
    return form is not None and (form is FOREIGN[0] or b"\0" in start[:4096])


def _refuse(path: Path, *arguments: Any) -> list[Block]:
    """Say how to export such a file; text that is called so is a table."""
    form = _recognized(path) or FOREIGN[0]
    if not _is_foreign(path, RECORDINGS.start(path)):
        return RECORDINGS["table"].read(path, *arguments)
    raise InputError(
        f"{path}: {form.title}'s own binary file, which only {form.program} opens. In {form.program}: {form.steps}. "
        "Then read the exported file"
    )


_SUFFIXES = tuple(suffix for form in FOREIGN for suffix in form.suffixes)
RECORDINGS.register(RecordingFormat("foreign", "a recorder's own file", _SUFFIXES, _is_foreign, _refuse, True))
