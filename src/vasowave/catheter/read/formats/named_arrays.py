"""Signals that files of NumPy (``.npz``), JSON and Igor Pro (``.itx``) hold by name, as those of MATLAB do."""

from pathlib import Path
from typing import Any

from vasowave.base.io.named_arrays import holds_names, read_named
from vasowave.catheter.read.formats import RECORDINGS, RecordingFormat
from vasowave.catheter.read.formats.matlab_structures import has_structures, read_structures
from vasowave.catheter.read.formats.matlab_variables import read_variables
from vasowave.catheter.signals.channels import Block
from vasowave.pulse.network_formats import NETWORKS


def _sniff(path: Path, start: bytes) -> bool:
    """Whether a file holds arrays by name and is no network."""
    return holds_names(path, start) and NETWORKS.known(path) is None


def _read(path: Path, sampling_rate: float | None, progress: Any) -> list[Block]:
    is_structured = has_structures(read_named(path))
    return read_structures(path, sampling_rate) if is_structured else [read_variables(path, sampling_rate)]


RECORDINGS.register(
    RecordingFormat(
        "named arrays", "arrays by name", (".npz", ".npy", ".itx", ".json"), _sniff, _read, unit_assumed=True
    )
)
