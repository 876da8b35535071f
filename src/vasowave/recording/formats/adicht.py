"""LabChart's own binary files: what to do, since nothing but LabChart reads them."""

from pathlib import Path
from typing import Any, NoReturn

from vasowave.errors import InputError
from vasowave.recording.formats import RECORDINGS, RecordingFormat

_SUFFIXES = (".adicht", ".adidat", ".adibin")


def refuse(path: Path, *_: Any) -> NoReturn:
    """Say how to export such a file."""
    raise InputError(
        f"{path}: LabChart's own binary file, which only LabChart opens. In LabChart: open it, select the stretch to "
        "use (nothing means all), File > Export…, 'Save as type': 'LabChart Text File (*.txt)' or 'MATLAB File "
        "(*.mat)', Save; in the dialog tick time, comments and the block header, do not downsample. Then read the "
        "exported file"
    )


RECORDINGS.register(
    RecordingFormat(
        "adicht", "LabChart's own file", _SUFFIXES, lambda path, start: path.suffix.lower() in _SUFFIXES, refuse, True
    )
)
