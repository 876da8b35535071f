"""What the files of a lab are, told from their content and their names: networks, recordings, halves of a cycle."""

import re
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import NamedTuple

from vasowave import units
from vasowave.columns import read_columns
from vasowave.errors import InputError
from vasowave.recording import describe_recording
from vasowave.recording.describe import BlockDescription

_SUFFIXES = (".csv", ".tsv", ".txt", ".dat", ".mat", ".edf", ".rec")
_HALVES = {"pressure": ("pressure", "press", "pap", "p"), "flow": ("flow", "q")}
_WORD = re.compile(r"[^\W\d_]+|\d+")


class Recorded(NamedTuple):
    """The recording of one animal: its name, one file or pressure and flow, and channels that only units tell."""

    name: str
    files: tuple[Path, ...]
    kind: str
    channels: dict[str, str]


class Sorted(NamedTuple):
    """What a set of files is; `refused` says of each other file why it is nothing of use."""

    networks: tuple[Path, ...]
    recordings: tuple[Recorded, ...]
    refused: tuple[str, ...]


def files_in(paths: Sequence[Path]) -> list[Path]:
    """Return the files that are meant: those named, and all in the folders named, whose type can be a table or record.

    Raises
    ------
    InputError
        A name that is no file and no folder, or nothing at all.
    """
    files: list[Path] = []
    for path in paths:
        if path.is_dir():
            inside = sorted(one for one in path.rglob("*") if one.is_file() and one.suffix.lower() in _SUFFIXES)
            files += [one for one in inside if not any(part.startswith(".") for part in one.parts)]
        elif path.is_file():
            files.append(path)
        else:
            raise InputError(f"{path}: there is no such file or folder")
    if not files:
        raise InputError(f"{', '.join(map(str, paths))}: no file there ends in {', '.join(_SUFFIXES)}")
    return list(dict.fromkeys(files))


def sort_files(files: Iterable[Path]) -> Sorted:
    """Tell networks from recordings, and join the pressure and the flow of one averaged cycle."""
    networks, recordings, refused = [], [], []
    halves: dict[str, dict[str, Path]] = {}
    for file in files:
        if _is_network(file):
            networks.append(file)
            continue
        try:
            described = describe_recording(file)
        except InputError as error:
            refused.append(str(error))
            continue
        block = max(described.blocks, key=lambda one: one.samples)
        half, stem = _half(file, block)
        if half:
            halves.setdefault(stem, {})[half] = file
        else:
            recordings.append(Recorded(file.stem, (file,), described.kind, _told_by_unit(block)))
    for stem, pair in halves.items():
        if len(pair) == 2:
            recordings.append(Recorded(stem, (pair["pressure"], pair["flow"]), "cycle", {}))
        else:
            ((half, file),) = pair.items()
            missing = "flow" if half == "pressure" else "pressure"
            refused.append(f"{file}: holds the {half} of a cycle alone; the file of its {missing} is not among these")
    return Sorted(tuple(networks), tuple(recordings), tuple(refused))


def words(name: str) -> list[str]:
    """Return the words and numbers of a name, in lower case: ``p_C6`` is p, c, 6."""
    return [word.casefold() for word in _WORD.findall(name)]


def _is_network(file: Path) -> bool:
    if file.suffix.lower() not in (".csv", ".tsv", ".txt", ".dat"):
        return False
    try:
        return "parent" in read_columns(file).names
    except InputError:
        return False


def _half(file: Path, block: BlockDescription) -> tuple[str, str]:
    """Return whether a file holds the pressure or the flow of a cycle alone, and what its name says beside that."""
    signals = [one for one in block.channels if one.quantity != "time"]
    if len(signals) != 1:
        return "", ""
    parts = re.split(r"([^\W_]+)", file.stem)
    for half, known in _HALVES.items():
        said = [i for i, part in enumerate(parts) if part.casefold() in known]
        if said or signals[0].quantity == half:
            rest = "".join(part for i, part in enumerate(parts) if i not in said).strip(" _-.")
            return half, re.sub(r"[ _-]{2,}", "_", rest) or file.parent.name
    return "", ""


def _told_by_unit(block: BlockDescription) -> dict[str, str]:
    """Return the channels whose titles do not say what they hold, but whose units leave one answer."""
    known = {one.quantity for one in block.channels}
    told = {}
    for quantity, dimension in (("pressure", "pressure"), ("flow", "flow"), ("ecg", "voltage")):
        if quantity in known:
            continue
        fit = [one.title for one in block.channels if not one.quantity and _has_unit(one.unit, dimension)]
        if len(fit) == 1 and fit[0]:
            told[quantity] = fit[0]
    return told


def _has_unit(unit: str, quantity: str) -> bool:
    try:
        units.factor(unit, quantity)
    except InputError:
        return False
    return bool(unit)
