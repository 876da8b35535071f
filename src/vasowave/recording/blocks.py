"""What kind of recording a file is, by its content, and its blocks of channels."""

from pathlib import Path

from vasowave.errors import InputError
from vasowave.io.textfile import Progress, read_start
from vasowave.recording.channels import Block
from vasowave.recording.edf import is_edf, read_edf
from vasowave.recording.labchart_mat import is_labchart_mat, read_labchart_mat
from vasowave.recording.labchart_text import is_labchart_text, read_labchart_text
from vasowave.recording.mat_variables import read_variables
from vasowave.recording.number_table import read_number_table

_ADICHT = (
    "LabChart's own binary file, which only LabChart opens. In LabChart: open it, select the stretch to use (nothing "
    "means all), File > Export…, 'Save as type': 'LabChart Text File (*.txt)' or 'MATLAB File (*.mat)', Save; in the "
    "dialog tick time, comments and the block header, do not downsample. Then read the exported file"
)

KINDS = {
    "labchart text": "LabChart text export",
    "mat": "MATLAB file",
    "edf": "EDF",
    "table": "table",
}
"""The kinds of files that are read, and what people call them."""


def file_kind(path: str | Path) -> str:
    """Return which of `KINDS` a file is, by its first bytes; `InputError` for what cannot be read."""
    path = Path(path)
    if path.suffix.lower() in (".adicht", ".adidat", ".adibin"):
        raise InputError(f"{path}: {_ADICHT}")
    start = read_start(path)
    if path.suffix.lower() == ".mat" or start.startswith(b"MATLAB "):
        return "mat"
    if path.suffix.lower() == ".edf" or is_edf(start):
        return "edf"
    return "labchart text" if is_labchart_text(start) else "table"


def read_blocks(path: str | Path, sampling_rate: float | None = None, progress: Progress | None = None) -> list[Block]:
    """Return the blocks of a continuous recording of any kind; the arguments are those of `read_raw_recording`."""
    kind = file_kind(path)
    if kind == "mat":
        blocks = read_labchart_mat(path) if is_labchart_mat(path) else [read_variables(path, sampling_rate)]
    elif kind == "edf":
        blocks = read_edf(path)
    elif kind == "labchart text":
        blocks = read_labchart_text(path, progress)
    else:
        blocks = [read_number_table(path, sampling_rate, progress)]
    if not blocks:
        raise InputError(f"{path}: headers and no samples")
    return blocks
