"""The content of a file before anyone says what it is: kind, blocks, channels, rate, length."""

import math
from collections.abc import Hashable, Sequence
from pathlib import Path
from typing import Literal, NamedTuple

from vasowave.base.errors import InputError
from vasowave.base.findings import Finding
from vasowave.base.io.remembered import marks_of, remembered
from vasowave.base.io.textfile import Progress, look
from vasowave.catheter.check.plausibility import PERIOD_LIMITS
from vasowave.catheter.read.choosing import quantity_of
from vasowave.catheter.read.formats import RECORDINGS, companion_files, read_blocks
from vasowave.catheter.read.gated import MAX_PHASES
from vasowave.catheter.signals.channels import Block, Comment
from vasowave.catheter.signals.gaps import Span, gaps_in
from vasowave.catheter.signals.interventions import listed

_MAX_CYCLE_ROWS = 2000
"""More rows without times are no cycle, unless a period is given, which says so."""
_MAX_CYCLE_BYTES = 4 << 20  # bytes; no table of one cycle is larger


class ChannelDescription(NamedTuple):
    """One channel: its title, its unit, and what its title says that it holds.

    `quantity` is ``pressure``, ``flow``, ``ecg``, ``time`` or empty; `unit` is empty where the file names none. `gaps`
    are the stretches without samples, s since the start of the block.
    """

    title: str
    unit: str
    quantity: str
    gaps: tuple[Span, ...] = ()


class BlockDescription(NamedTuple):
    """One block (a cycle file has one): samples a second, length in s, and its channels.

    `sampling_rate` and `duration` are nan where the file has no times.
    """

    sampling_rate: float
    duration: float
    samples: int
    channels: tuple[ChannelDescription, ...]
    comments: tuple[Comment, ...] = ()
    sheet: str = ""


class FileDescription(NamedTuple):
    """The content of a file.

    Attributes
    ----------
    path : str
    format : str
        ``labchart text``, ``labchart mat``, ``mat``, ``edf``, ``table``, or the name of one that was registered.
    kind : str
        ``raw`` (a continuous recording), ``cycle`` (one averaged cycle), or empty where the file has no times.
    blocks : tuple of BlockDescription
    suspicions : tuple of Finding
        What looks as if the file were not whole.
    """

    path: str
    format: str
    kind: str
    blocks: tuple[BlockDescription, ...]
    suspicions: tuple[Finding, ...] = ()

    @property
    def used(self) -> BlockDescription:
        """The block that is read unless another is named: the longest, or the first sheet."""
        return self.blocks[0] if self.blocks[0].sheet else max(self.blocks, key=lambda block: block.samples)

    def __str__(self) -> str:
        """Return one line: format, length, rate, channels."""
        block = self.used
        channels = ", ".join(f"{c.title or '(untitled)'} [{c.unit or 'no unit'}]" for c in block.channels)
        lasts = (
            f"{block.duration:.4g} s at {block.sampling_rate:.6g} samples/s"
            if math.isfinite(block.duration)
            else f"{block.samples} samples without times"
        )
        kind = {"raw": "continuous", "cycle": "one cycle", "": "cycle or continuous"}[self.kind]
        suffix = f", the longest of {len(self.blocks)} blocks" if len(self.blocks) > 1 else ""
        suffix = f", sheet '{block.sheet}'" if block.sheet else suffix
        comments = f"; comments: {listed(block.comments)}" if block.comments else ""
        return f"{RECORDINGS[self.format].title}, {kind}: {lasts}{suffix}; {channels}{comments}"


def describe_recording(path: str | Path, progress: Progress | None = None, sheet: str = "") -> FileDescription:
    """Return what a file of pressure and flow holds; nothing has to be said about it.

    LabChart's exports and EDF are continuous. A table, or variables of a MATLAB file, is continuous if its times cover
    more than any heartbeat (3 s); without times nobody can tell, and `kind` is empty.

    Raises
    ------
    InputError
        A file that cannot be read, with the place and the cure.

    Examples
    --------
    >>> import vasowave as vw
    >>> import numpy as np
    >>> from pathlib import Path
    >>> t = np.arange(0, 4.0, 1e-3)
    >>> beat = np.exp(-0.5 * (((t / 0.11) % 1 - 0.3) / 0.1) ** 2)
    >>> rows = (f"{a:.3f}\\t{8 + 20 * b:.3f}\\t{0.4 * b:.4f}" for a, b in zip(t, beat))
    >>> _ = Path("mouse.txt").write_text("\\n".join(["time [s]\\tpressure [mmHg]\\tflow [ml/s]", *rows, ""]))
    >>> vw.describe_recording("mouse.txt").kind
    'raw'
    """
    return _described(Path(path), sheet, marks_of(companion_files(Path(path))), progress=progress)


@remembered
def _described(path: Path, sheet: str, companions: Hashable, progress: Progress | None = None) -> FileDescription:
    """Return what `describe_recording` does; `companions` changes with the files that are read along."""
    form = RECORDINGS.of(path)
    blocks = read_blocks(path, math.nan, progress, sheet)
    described = tuple(_block(block) for block in blocks if block.channels)
    suspicions = tuple(dict.fromkeys(suspicion for block in blocks for suspicion in block.suspicions))
    kind = "raw" if form.continuous else _kind(described)
    return FileDescription(str(path), form.name, kind, described, suspicions)


def kind_of(recordings: Sequence[Path], sheet: str = "") -> Literal["cycle", "raw"]:
    """Return what the files of a recording hold: one averaged cycle, or a continuous recording.

    Two files are pressure and flow: continuous if both are. What cannot be told, or read, is taken for a cycle; its
    reader says what is wrong.
    """
    if len(recordings) > 1:
        first, *further = (kind_of([file], sheet) for file in recordings)
        return "raw" if first == "raw" and (set(further) == {"raw"} or _is_gated(recordings[1], sheet)) else "cycle"
    try:
        form, size = RECORDINGS.of(recordings[0]), look(recordings[0]).size
    except InputError:
        return "cycle"
    try:
        if form.continuous:
            return "raw"
        described = describe_recording(recordings[0], sheet=sheet)
        untimed = not described.kind and described.used.samples > _MAX_CYCLE_ROWS
        return "raw" if described.kind == "raw" or untimed else "cycle"
    except InputError:
        return "raw" if size > _MAX_CYCLE_BYTES else "cycle"


def _is_gated(path: Path, sheet: str) -> bool:
    """Whether a file holds one cycle of so few samples that it is the gated flow beside a continuous pressure."""
    try:
        return describe_recording(path, sheet=sheet).used.samples <= MAX_PHASES
    except InputError:
        return False


def _block(block: Block) -> BlockDescription:
    channels = tuple(
        ChannelDescription(c.title, c.unit, quantity_of(c.title), gaps_in(c.values, c.sampling_rate))
        for c in block.channels
    )
    fastest = max(block.channels, key=lambda c: len(c.values))
    rate = fastest.sampling_rate
    return BlockDescription(
        rate, len(fastest.values) / rate, len(fastest.values), channels, block.comments, block.sheet
    )


def _kind(blocks: Sequence[BlockDescription]) -> str:
    """Return what blocks last like; with an ECG they are continuous."""
    if any(channel.quantity == "ecg" for block in blocks for channel in block.channels):
        return "raw"
    lasts = max(block.duration for block in blocks)
    if math.isnan(lasts):
        return ""
    return "raw" if lasts > PERIOD_LIMITS[1] else "cycle"
