"""The formats of recordings: one module each, which registers what it reads; a further one needs nothing else."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from vasowave.base.cures import SetCells
from vasowave.base.errors import InputError
from vasowave.base.io.formats import Format, Registry
from vasowave.base.io.textfile import Progress
from vasowave.base.sites import PULMONARY
from vasowave.base.units import CANONICAL
from vasowave.catheter.read.choosing import pick_channels
from vasowave.catheter.signals.channels import Block, at_their_rates, without_codes
from vasowave.catheter.signals.signal import Signal, given_unit

Wanted = Mapping[str, str | None]
"""Quantities to read, each with the unit to take where the file names none."""


@dataclass(frozen=True)
class RecordingFormat(Format):
    """A format of recordings: how its files are known and read.

    Attributes
    ----------
    read : callable
        Takes path, samples per second (None if nobody gave them, nan if that does not matter yet) and `progress`, a
        callable that gets the fraction that was read. Returns the blocks of channels, each in the unit of the file.
        What it does not read again belongs into `io.remembered`.
    continuous : bool
        Whether such a file always holds a continuous recording; else its length tells.
    cycle : callable, optional
        Takes path, the quantities that are wanted of one averaged cycle, and the artery; returns a signal for each. By
        default they are taken from what `read` returns.
    sheets : bool
        Whether it is a workbook, whose `read` and `cycle` take a `sheet`, too.
    subjects : bool
        Whether it may have a row a subject, so that `cycle` takes a `subject_row`, too.
    unit_assumed : bool
        Whether pressure and flow of one cycle that have no unit are in mmHg and ml/s, which a note says.
    companions : callable
        Takes path and returns the files that are read along with it.
    """

    continuous: bool = False
    cycle: Callable[..., list[Signal]] | None = None
    sheets: bool = False
    subjects: bool = False
    unit_assumed: bool = False
    companions: Callable[[Path], tuple[Path, ...]] = lambda path: ()

    def of_sheet(self, path: Path, sheet: str) -> dict[str, str]:
        """Return what `read` and `cycle` take beside all else, of the sheet that is named, if one is."""
        return {"sheet": sheet} if sheet and self.sheets else {}


def check_sheet(paths: Sequence[str | Path], sheet: str) -> None:
    """Raise `InputError` for a sheet that is named where no file of a recording is a workbook."""
    if sheet and not any(RECORDINGS.of(path).sheets for path in paths):
        raise InputError(f"{paths[0]}: is not a workbook and has no sheet '{sheet}'; leave the sheet out")


def check_subject(paths: Sequence[str | Path], subject_row: str) -> None:
    """Raise `InputError` for a subject that is named where a file is not a table, which has a row for each."""
    for path in paths if subject_row else ():
        if not (form := RECORDINGS.of(path)).subjects:
            raise InputError(f"{path}: {form.title}, has no row of '{subject_row}'; leave the subject out")


def companion_files(path: Path) -> tuple[Path, ...]:
    """Return the files that are read along with a recording; none where nobody can tell."""
    try:
        return RECORDINGS.of(path).companions(path)
    except InputError:
        return ()


RECORDINGS = Registry[RecordingFormat](__name__, "table")
"""Every format of recordings."""


def read_blocks(
    path: str | Path, sampling_rate: float | None = None, progress: Progress | None = None, sheet: str = ""
) -> list[Block]:
    """Return the blocks of a continuous recording of any format; the arguments are those of `read_raw_recording`."""
    path = Path(path)
    form = RECORDINGS.of(path)
    blocks = form.read(path, sampling_rate, progress, **form.of_sheet(path, sheet))
    blocks = [at_their_rates(without_codes(block)) for block in blocks]
    if not any(block.channels for block in blocks):
        raise InputError(f"{path}: headers and no samples")
    return blocks


def read_signals(
    path: str | Path, quantities: Wanted, site: str = PULMONARY, sheet: str = "", subject_row: str = ""
) -> list[Signal]:
    """Read the `quantities` of one averaged cycle from one file, of a table with a row a subject from that of one.

    Raises
    ------
    InputError
        A file that holds no cycle, and what the reader of the format raises.
    """
    path = Path(path)
    form = RECORDINGS.of(path)
    if form.continuous:
        raise InputError(
            f"{path}: a continuous recording ({form.title}), not one cycle; read it as continuous and "
            "average its beats",
            [SetCells("It is continuous", (("kind", "raw"),))],
        )
    if form.cycle is None:
        return _of_channels(path, form, quantities, site)
    of_subject = {"subject_row": subject_row} if subject_row else {}
    return form.cycle(path, quantities, site, **form.of_sheet(path, sheet), **of_subject)


def _of_channels(path: Path, form: RecordingFormat, quantities: Wanted, site: str) -> list[Signal]:
    """Return the signals of a cycle whose format knows channels only."""
    blocks = form.read(path, np.nan, None)
    if len(blocks) != 1:
        raise InputError(f"{path}: {len(blocks)} blocks, and a cycle is one; export one of them")
    (block,) = blocks
    picked, taken = pick_channels(path, block.channels, dict.fromkeys(quantities), site, block.program)
    signals = []
    for quantity, unit in quantities.items():
        channel = picked[quantity]
        assumed = CANONICAL[quantity] if form.unit_assumed and not (channel.unit or unit) else ""
        scale, unit_notes = given_unit(quantity, channel.unit or assumed, unit, channel.place)
        values = channel.values * scale
        gaps = np.flatnonzero(~np.isfinite(values))
        if len(gaps):
            raise InputError(f"{channel.place}: sample {gaps[0] + 1} is missing (a gap); fill it before averaging")
        time = np.arange(len(values)) / channel.sampling_rate if np.isfinite(channel.sampling_rate) else None
        places = tuple(f"{channel.place}, sample {row + 1}" for row in range(len(values)))
        quantum = 0.0 if time is None else float(np.spacing(time[-1]))
        signals.append(Signal(quantity, values, time, quantum, str(path), places, assumed, (*taken, *unit_notes)))
        taken = []
    return signals


__all__ = ["RECORDINGS", "RecordingFormat", "Wanted", "read_blocks", "read_signals"]
