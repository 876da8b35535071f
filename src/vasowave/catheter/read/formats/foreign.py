"""Recorders' own files, which their programs alone open, and other containers: each is named, with what helps."""

from pathlib import Path
from typing import Any, NamedTuple, NoReturn

from vasowave.base.errors import InputError
from vasowave.catheter.read.formats import RECORDINGS, RecordingFormat
from vasowave.catheter.signals.channels import Block
from vasowave.pulse.network_formats import NETWORKS


class Foreign(NamedTuple):
    """A program's own file: how it is known, by its name or its first bytes, and what its program exports instead."""

    title: str
    suffixes: tuple[str, ...]
    program: str
    steps: str
    starts: tuple[bytes, ...] = ()


_TABLE = "write a CSV table with the columns time [s], pressure [mmHg] and flow [ml/s]"
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
    Foreign("Axon", (".abf",), "Clampfit", "open it, File > Save As…, 'Axon Text File (*.atf)' or text"),
    Foreign(
        "Igor Pro", (".ibw", ".pxp"), "Igor Pro", "Data > Save Waves > Save Igor Text… (*.itx)",
    ),
    Foreign(
        "LabVIEW TDMS", (".tdms",), "LabVIEW, DIAdem or Excel with NI's add-in",
        "save it as text (*.lvm or *.csv) with titles, units and times", (b"TDSm", b"TDSh"),
    ),
    Foreign(
        "WinDaq", (".wdq", ".wdh"), "WinDaq Browser", "File > Save As…, 'Spreadsheet print (CSV)', with relative times",
    ),
    Foreign("HDF5", (".h5", ".hdf5", ".nwb"), "MATLAB or Python", _TABLE, (b"\x89HDF\r\n\x1a\n",)),
    Foreign("Octave", (), "Octave", "save it by save -v7 FILE.mat time pressure flow", (b"# Created by Octave",)),
    Foreign("Parquet", (".parquet", ".feather"), "Python or R", _TABLE, (b"PAR1", b"ARROW1", b"FEA1")),
    Foreign(
        "pictures", (), "the program that drew it",
        "export the numbers as text; where the picture alone is left, a digitizer makes a table of one cycle of it",
        (b"\x89PNG", b"\xff\xd8\xff", b"GIF8", b"II*\0", b"MM\0*", b"%PDF-"),
    ),
)  # fmt: skip


def _recognized(path: Path, start: bytes) -> Foreign | None:
    """Return whose file it is; text that is called like a program's file is a table."""
    by_start = (form for form in FOREIGN if start.startswith(form.starts))
    binary = b"\0" in start[:4096]
    named = (form for form in FOREIGN if path.suffix.lower() in form.suffixes and (binary or form is FOREIGN[0]))
    return next(by_start, None) or next(named, None)


def _refuse(path: Path, *arguments: Any) -> list[Block]:
    """Say how to export such a file; text that is called so is a table."""
    form = _recognized(path, RECORDINGS.start(path))
    if form is None:
        return RECORDINGS["table"].read(path, *arguments)
    raise InputError(
        f"{path}: a file of {form.title}, which is not read. In {form.program}: {form.steps}. Then read that file"
    )


def _refuse_vessels(path: Path, *arguments: Any) -> NoReturn:
    raise InputError(f"{path} holds vessels; give the recording of pressure and flow")


RECORDINGS.register(
    RecordingFormat(
        "vessels", "network of vessels", (), lambda path, start: NETWORKS.known(path) is not None, _refuse_vessels,
        cycle=_refuse_vessels,
    )
)  # fmt: skip
_SUFFIXES = tuple(suffix for form in FOREIGN for suffix in form.suffixes)
RECORDINGS.register(
    RecordingFormat(
        "foreign", "a recorder's own file", _SUFFIXES, lambda path, start: _recognized(path, start) is not None,
        _refuse, True,
    )
)  # fmt: skip
