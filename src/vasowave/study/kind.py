"""Whether a file holds one averaged cycle or a continuous recording, told from what is in it."""

from collections.abc import Sequence
from pathlib import Path
from typing import Literal

from vasowave.errors import InputError
from vasowave.io.columns import read_columns
from vasowave.recording.choosing import with_time
from vasowave.recording.edf import is_edf
from vasowave.recording.labchart_text import is_labchart_text
from vasowave.recording.mat_variables import is_continuous
from vasowave.recording.matlab import read_mat
from vasowave.recording.plausibility import PERIODS

Kind = Literal["cycle", "raw"]

_CONTINUOUS = (".adicht", ".adidat", ".adibin", ".edf")
_LARGEST = 4 << 20  # bytes; no table of one cycle is larger
_HEAD = 4096  # bytes that tell what a file is


def kind_of(recordings: Sequence[Path]) -> Kind:
    """Return what the files of a recording hold.

    A LabChart export, an EDF file, and a table that lasts longer than any heartbeat or holds an ECG are continuous.
    Two files are the pressure and the flow of one cycle. What cannot be read is taken for a cycle; its reader says what
    is wrong.
    """
    path = recordings[0]
    if len(recordings) > 1:
        return "cycle"
    try:
        with path.open("rb") as file:
            head = file.read(_HEAD)
        if path.suffix.lower() in _CONTINUOUS or is_edf(head) or is_labchart_text(head):
            return "raw"
        if path.suffix.lower() == ".mat":
            return "raw" if "datastart" in (found := read_mat(path)) or is_continuous(path, found) else "cycle"
        return _kind_of_table(path)
    except (OSError, InputError):
        return "cycle"


def _kind_of_table(path: Path) -> Kind:
    if path.stat().st_size > _LARGEST:
        return "raw"
    table = read_columns(path)
    if table.find("ecg", ("ekg",)) is not None:
        return "raw"
    named = with_time(table.names, table.units)
    column = named.index("time") if "time" in named else table.find("time", ("t",))
    time = table.numbers(column, "time") if column is not None else None
    return "raw" if time is not None and len(time) and time[-1] - time[0] > PERIODS[1] else "cycle"
