"""The MATLAB files of AcqKnowledge, which hold a channel a column, and of bioread's acq2mat, a structure a channel."""

import re
from pathlib import Path
from typing import Any

import numpy as np

from vasowave.base import units
from vasowave.base.errors import InputError
from vasowave.base.io.matlab import is_mat, read_mat
from vasowave.catheter.read.formats import RECORDINGS, RecordingFormat
from vasowave.catheter.read.formats.labchart_mat import rows_of_text
from vasowave.catheter.signals.channels import Block, Channel

_COLUMNS = {"data", "isi", "isi_units", "labels", "units"}


def is_acqknowledge_mat(path: Path, start: bytes) -> bool:
    """Whether a file is one of MATLAB and holds the variables of AcqKnowledge's export, or acq2mat's channels."""
    return is_mat(path, start) and (
        _COLUMNS <= set(read_mat(path)) or "channels(1).samples_per_second" in read_mat(path)
    )


def read_acqknowledge_mat(path: Path) -> list[Block]:
    """Read all channels, each with its title, unit and rate.

    Raises
    ------
    InputError
        A file that cannot be read, or whose titles, units and numbers contradict each other.
    """
    variables, rows = read_mat(path), list[tuple[str, str, float, np.ndarray]]()
    if _COLUMNS <= set(variables):
        data, titles, unit_texts = (
            np.atleast_2d(variables["data"]),
            *map(rows_of_text, (variables["labels"], variables["units"])),
        )
        if data.ndim != 2 or not data.shape[1] == len(titles) == len(unit_texts):
            raise InputError(
                f"{path}: {data.shape} numbers, {len(titles)} labels, {len(unit_texts)} units; export it again"
            )
        rate = 1.0 / (
            _number(path, variables["isi"]) * units.factor("".join(rows_of_text(variables["isi_units"])), "time")
        )
        rows = [(title, unit, rate, column) for title, unit, column in zip(titles, unit_texts, data.T, strict=True)]
    for stem in (name.removesuffix(".data") for name in variables if re.fullmatch(r"channels\(\d+\)\.data", name)):
        if not np.size(variables[f"{stem}.data"]):
            continue
        title, unit = ("".join(rows_of_text(variables.get(f"{stem}.{name}", ""))) for name in ("name", "units"))
        rows.append(
            (
                title,
                unit,
                _number(path, variables.get(f"{stem}.samples_per_second")),
                np.ravel(variables[f"{stem}.data"]),
            )
        )
    if any(values.dtype.kind not in "iuf" for *_, values in rows):
        raise InputError(f"{path}: a channel without numbers; export it again")
    return [Block(tuple(Channel(title, unit, values.astype(float), rate, f"{path}, channel '{title}'")
                        for title, unit, rate, values in rows), program="AcqKnowledge")]  # fmt: skip


def _number(path: Path, value: Any) -> float:
    number = np.ravel(value)
    if number.size != 1 or number.dtype.kind not in "iuf" or not 1e-9 < float(number[0]) < 1e9:
        raise InputError(f"{path}: a channel without an interval between samples, or a rate; export it again")
    return float(number[0])


RECORDINGS.register(
    RecordingFormat(
        "acqknowledge mat", "AcqKnowledge MATLAB file", (), is_acqknowledge_mat,
        lambda path, rate, progress: read_acqknowledge_mat(path), continuous=True,
    )
)  # fmt: skip
