"""The kinds of a lab's files, told by their content and their names: networks, recordings, halves of a cycle."""

import os
import re
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

from vasowave.base import units
from vasowave.base.errors import InputError
from vasowave.base.io.columns import read_columns
from vasowave.base.io.spreadsheet import WORKBOOKS
from vasowave.base.io.textfile import look
from vasowave.base.sites import PULMONARY
from vasowave.catheter.read.choosing import Choice, choose, column_of, wanted_titles
from vasowave.catheter.read.describe import (
    BlockDescription,
    ChannelDescription,
    FileDescription,
    describe_recording,
    kind_of,
)
from vasowave.catheter.read.formats import RECORDINGS, check_subject, companion_files
from vasowave.catheter.read.formats.workbook import SHEET_READ
from vasowave.catheter.read.subject_rows import SUBJECT, subject_as_written, subjects_of
from vasowave.catheter.signals.gaps import Span, longest_between
from vasowave.catheter.signals.raw import MIN_DURATION_S
from vasowave.pulse.network_formats import NETWORKS, unit_wanted
from vasowave.study.entering.animal_sheet import AnimalSheet, animal_sheet
from vasowave.study.entering.several_animals import animals_side_by_side

_NO_DATA = frozenset({
    ".bmp", ".dcm", ".docx", ".gif", ".htm", ".html", ".ima", ".ini", ".jpeg", ".jpg", ".json", ".log", ".md", ".mha",
    ".mhd", ".nhdr", ".nii", ".nrrd", ".odt", ".pdf", ".png", ".pptx", ".py", ".raw", ".rtf", ".sh", ".svg", ".tif",
    ".tiff", ".vtp", ".xml", ".yaml", ".yml", ".zip",
})  # fmt: skip
"""Endings of images, texts and programs, which lie beside recordings without a word."""
_NUMBER = re.compile(r"\s*[\"']?[-+]?[.,]?\d[\d.,]*([eE][-+]?\d+)?[\"']?(?![^\s;,])\s*")
_SIGNAL_WORDS = {
    "pressure": ("pressure", "press", "druck", "pression", "presion", "pap", "p"),
    "flow": ("flow", "fluss", "debit", "flujo", "q"),
}


@dataclass(frozen=True)
class Choosing:
    """What a user says of files that are sorted.

    Attributes
    ----------
    titles : mapping
        Titles of channels, by quantity.
    block : int, optional
        Counted from 1.
    site : str
        The artery.
    sheet : str
        Of workbooks.
    subject_row : str
        Of tables with a row a subject.
    diameter : bool
        Whether the diameter of the vessel is said, whose velocity was recorded.
    """

    titles: Mapping[str, str] = field(default_factory=dict)
    block: int | None = None
    site: str = PULMONARY
    sheet: str = ""
    subject_row: str = ""
    diameter: bool = False


class Recorded(NamedTuple):
    """The recording of one animal.

    Attributes
    ----------
    name : str
    files : tuple of Path
        One file, or pressure and flow.
    kind : str
    channels : tuple of (str, str)
        Quantity and title of channels that neither the user nor their titles alone decided.
    stretch : Span, optional
        The longest stretch without a gap, s, where there are gaps.
    remarks : tuple of str
        What was decided for the user.
    titles : tuple of str
        Of the channels of a continuous recording.
    subject_row : str
        Of a table with a row a subject, as it is written there.
    beside_others : bool
        Whether the file holds other animals too, so that the channel of its pressure tells it from them.
    sheet : str
        Of a workbook the sheet that was named; empty if none was.
    """

    name: str
    files: tuple[Path, ...]
    kind: str
    channels: tuple[tuple[str, str], ...] = ()
    stretch: Span | None = None
    remarks: tuple[str, ...] = ()
    titles: tuple[str, ...] = ()
    subject_row: str = ""
    beside_others: bool = False
    sheet: str = ""

    @property
    def in_file(self) -> str:
        """What tells the animal from others in its file, in lower case; empty where it is the only one."""
        title = dict(self.channels).get("pressure", "") if self.beside_others else self.subject_row
        return title.strip().casefold()


class Sorted(NamedTuple):
    """The kinds of a set of files; `refused` says why others are nothing of use, `texts` which are prose."""

    networks: tuple[Path, ...]
    recordings: tuple[Recorded, ...]
    refused: tuple[str, ...]
    remarks: tuple[str, ...] = ()
    sheets: tuple[AnimalSheet, ...] = ()
    texts: tuple[Path, ...] = ()


def files_in(paths: Sequence[Path], leave: Collection[Path] = ()) -> list[Path]:
    """Return the files that are meant: those named, and all in the folders named, whose type can be a table or record.

    Hidden files and folders inside a folder that is named are left alone, and so are those in `leave` (resolved). Links
    are followed; a file that is reached twice is one.

    Raises
    ------
    InputError
        A name that is neither a file nor a folder, or nothing at all.
    """
    files: dict[Path, Path] = {}
    suffixes = {*RECORDINGS.suffixes, *NETWORKS.suffixes}
    for path in paths:
        if path.is_dir():
            inside = sorted(_walked(path, leave))
            candidates = [file for file in inside if file.is_file() and file.suffix.lower() in suffixes]
        elif path.is_file():
            candidates = [path]
        else:
            raise InputError(f"{path}: there is no such file or folder")
        for file in candidates:
            files.setdefault(file.resolve(), file)
    if not files:
        raise InputError(f"{', '.join(map(str, paths))}: no file there ends in {', '.join(sorted(suffixes))}")
    return list(files.values())


def passed_over(paths: Sequence[Path], leave: Collection[Path] = ()) -> list[str]:
    """Return the names of files in the folders named whose type is neither a table's, a recorder's nor a picture's."""
    suffixes = {*RECORDINGS.suffixes, *NETWORKS.suffixes, *_NO_DATA}
    files = [file for path in paths if path.is_dir() for file in _walked(path, leave)]
    return [file.name for file in files if file.suffix and file.suffix.lower() not in suffixes]


def _walked(folder: Path, leave: Collection[Path]) -> Iterator[Path]:
    """Go through the files in a folder and its folders, each folder once, whatever links there are."""
    visited: set[Path] = set()
    for place, folders, names in os.walk(folder, followlinks=True):
        real = Path(place).resolve()
        subfolders = [name for name in folders if not name.startswith(".") and Path(place, name).resolve() not in leave]
        folders[:] = sorted(subfolders) if real not in visited else []
        if real not in visited:
            files = (Path(place, name) for name in names if not name.startswith("."))
            yield from (file for file in files if file.resolve() not in leave)
        visited.add(real)


def sort_files(files: Iterable[Path], choosing: Choosing = Choosing()) -> Sorted:
    """Tell networks from recordings, and join the pressure and the flow of one averaged cycle.

    Parameters
    ----------
    files : iterable of Path
    choosing : Choosing
        What the user said of them.
    """
    networks, recordings, refused, sheets, texts = [], [], [], [], []
    halves: list[tuple[str, str, Path]] = []
    files = list(files)
    samples = {
        sample for file in files for sample in companion_files(file) if file.suffix.lower() in RECORDINGS.suffixes
    }
    for file in files:
        if file in samples and file.suffix.lower() not in RECORDINGS.suffixes:
            continue  # read with the header that names it
        if is_prose(file):
            texts.append(file)
            continue
        try:
            network = NETWORKS.known(file)
            if network is not None:
                if not network.says_unit(file):
                    raise unit_wanted(file, network)
                networks.append(file)
                continue
            _refuse_vessels(file)
            if choosing.subject_row:
                recordings += _of_subjects(file, choosing)
                continue
            sheet, workbook = animal_sheet(file), file.suffix.lower() in WORKBOOKS
            if sheet is not None:
                sheets.append(sheet)
                if not workbook or not (choosing.sheet or _has_signals(file)):
                    continue
            described = describe_recording(file, sheet=choosing.sheet if workbook else "")
            _refuse_volume(file, described)
        except InputError as error:
            subjects = _of_subjects(file, choosing) if SUBJECT in error.cures else []
            recordings += subjects
            refused += [] if subjects else [str(error)]
            continue
        half, stem = _half(file, used_block(described, None))
        if half:
            halves.append((stem, half, file))
        else:
            recorded = _recorded(file, described, choosing)
            if sheet is not None:
                name = used_block(described, choosing.block).sheet
                remark = f"its sheet '{name}' is a recording, beside the table of animals"
                recorded = recorded._replace(remarks=(remark, *recorded.remarks))
            recordings += _each_animal(recorded, used_block(described, choosing.block), choosing)
    joined, alone = _joined(halves)
    for half, file in alone:
        missing = "flow" if half == "pressure" else "pressure"
        refused.append(f"{file}: holds the {half} of a cycle alone; the file of its {missing} is not among these")
    recordings = [recorded._replace(sheet=choosing.sheet) if recorded.files[0].suffix.lower() in WORKBOOKS else recorded
                  for recorded in [*recordings, *joined]]  # fmt: skip
    return Sorted(tuple(networks), tuple(recordings), tuple(refused), sheets=tuple(sheets), texts=tuple(texts))


def is_prose(file: Path) -> bool:
    """Whether a file is a text in which no line begins with a number and no cell is one: notes beside recordings."""
    if file.suffix.lower() != ".txt" or b"\0" in (start := look(file).start):
        return False
    lines = start.decode("utf-8", "replace").splitlines()
    return not any(_NUMBER.match(line) or any(map(_NUMBER.fullmatch, re.split("[;,\t]", line))) for line in lines)


def _each_animal(recorded: Recorded, block: BlockDescription, choosing: Choosing) -> list[Recorded]:
    """Return the recording of each animal that a file holds, one as it is."""
    animals = animals_side_by_side(recorded.name, block.channels, choosing.site, choosing.titles)
    if recorded.kind != "raw" or not animals:
        return [recorded]
    remark = f"holds several animals, by the titles of its channels: {', '.join(animals)}"
    return [recorded._replace(name=name, channels=tuple(held.items()), remarks=(remark,), beside_others=True)
            for name, held in animals.items()]  # fmt: skip


def _refuse_volume(file: Path, described: FileDescription) -> None:
    """Raise `InputError` for loops of pressure and volume, which are no recording of an artery."""
    held = {kind for channel in used_block(described, None).channels for kind in ("volume", "relative volume", "flow",
            "velocity") if units.is_of(channel.unit, kind) or channel.quantity == kind}  # fmt: skip
    if held and not held & {"flow", "velocity"}:
        raise InputError(
            f"{file}: holds a ventricle's volume and no flow; write it into the column 'loops' of its animal"
        )


def _has_signals(workbook: Path) -> bool:
    """Whether a sheet of a workbook, beside its table of animals, holds pressure or flow."""
    try:
        channels = describe_recording(workbook).used.channels
    except InputError:
        return False
    return any(channel.quantity in ("pressure", "flow") for channel in channels)


def _of_subjects(file: Path, choosing: Choosing) -> list[Recorded]:
    """Return the recording of the subject in a table that is named, else of all of them, called as they are there."""
    check_subject([file], choosing.subject_row)
    sheet = choosing.sheet if file.suffix.lower() in WORKBOOKS else ""
    named = choosing.subject_row
    names = [subject_as_written(file, named, sheet)] if named else subjects_of(file, sheet)
    return [Recorded(name, (file,), "cycle", subject_row=name) for name in names]


def _refuse_vessels(file: Path) -> None:
    """Raise `InputError` for a table of vessels whose titles are not known, which is not a recording."""
    try:
        table = read_columns(file)
    except InputError:
        return
    if not table.names:
        return
    sizes = [name for name, unit in zip(table.names, table.units, strict=True) if unit and units.is_of(unit, "length")]
    signals = [
        unit for unit in table.units if any(unit and units.is_of(unit, quantity) for quantity in ("pressure", "flow"))
    ]
    if len(sizes) > 1 and not signals:
        raise InputError(
            f"{file}: looks like a table of vessels ({' and '.join(sizes)} are lengths), whose columns are called "
            f"'name', 'parent', 'length' and 'radius' or 'diameter'; this header has: {', '.join(table.names)}. Change "
            "the titles"
        )


def _joined(halves: Sequence[tuple[str, str, Path]]) -> tuple[list[Recorded], list[tuple[str, Path]]]:
    """Return pressures with their flows, of one folder or else of one name anywhere, and what stays alone."""
    joined, unpaired = [], list(halves)
    for same_folder in (True, False):
        for pressure in [pressure for pressure in unpaired if pressure[1] == "pressure"]:
            fits = [q for q in unpaired if q[1] == "flow" and q[0] == pressure[0]]
            fits = [q for q in fits if q[2].parent == pressure[2].parent] if same_folder else fits
            rivals = [p for p in unpaired if p[1] == "pressure" and p[0] == pressure[0]]
            if len(fits) == 1 and (same_folder or len(rivals) == 1):
                pair = (pressure[2], fits[0][2])
                joined.append(Recorded(pressure[0], pair, kind_of(pair)))
                unpaired = [candidate for candidate in unpaired if candidate not in (pressure, fits[0])]
    return joined, [(half, file) for _, half, file in unpaired]


def names_signal(file: Path) -> bool:
    """Return whether the name of a file, or of its folder, has a word for pressure or flow."""
    words, folder = re.findall(r"[^\W_]+", file.stem.casefold()), file.parent.name.casefold()
    return any(folder in signal_words[:-1] or {*words} & {*signal_words} for signal_words in _SIGNAL_WORDS.values())


def _recorded(file: Path, described: FileDescription, choosing: Choosing) -> Recorded:
    """Return a recording that one file holds, with what was decided about its channels and gaps."""
    of_sheet = [str(finding) for finding in described.suspicions if finding.code == SHEET_READ.code]
    if described.kind == "cycle":
        return Recorded(file.stem, (file,), described.kind, remarks=tuple(of_sheet))
    block = used_block(described, choosing.block)
    titles = tuple(channel.title for channel in block.channels)
    lower_titles = {title.strip().casefold() for title in titles}
    named = {name: title for name, title in choosing.titles.items() if title.strip().casefold() in lower_titles}
    quantities = wanted_titles(
        named.get("pressure"), named.get("flow"), named.get("ecg"), velocity=bool(choosing.diameter)
    )
    choice = choose(block.channels, quantities, choosing.site)
    longest = choosing.block is None and len(described.blocks) > 1 and not block.sheet
    remarks = [*([_longest(described, block)] if longest else []), *of_sheet]
    remarks += [
        f"'{choice.picked[name].title}' was taken for {name}: {reason}" for name, reason in choice.guessed.items()
    ]
    stretch = _unbroken_stretch(block, choice)
    if stretch is not None:
        remarks.append(
            f"samples are missing; the longest stretch without a gap is read, {stretch.start:g} to {stretch.end:g} s"
        )
    remarks += [f"no channel '{title}': its row does not name it" for name, title in choosing.titles.items()
                if name not in named]  # fmt: skip
    channels = tuple((column_of(name), choice.picked[name].title) for name in choice.guessed)
    return Recorded(file.stem, (file,), described.kind, channels, stretch, tuple(remarks), titles)


def used_block(described: FileDescription, number: int | None) -> BlockDescription:
    """Return the block that is read: the one named, or the longest."""
    blocks = described.blocks
    if number is not None and 1 <= number <= len(blocks):
        return blocks[number - 1]
    return described.used


def _longest(described: FileDescription, used: BlockDescription) -> str:
    lengths = ", ".join(f"{block.duration:.4g} s" for block in described.blocks)
    return (
        f"block {described.blocks.index(used) + 1} of {len(described.blocks)} is read, the longest (blocks last "
        f"{lengths}); the column 'block' takes another"
    )


def _unbroken_stretch(block: BlockDescription, choice: Choice[ChannelDescription]) -> Span | None:
    """Return the longest stretch without a gap in the channels that are read, None if all is or too little is."""
    gaps = [gap for channel in choice.picked.values() for gap in channel.gaps]
    if not gaps:
        return None
    stretch = longest_between(gaps, 0.0, block.duration)
    return stretch if stretch.end - stretch.start >= MIN_DURATION_S else None


def _counts(channel: ChannelDescription) -> bool:
    """Whether a column numbers or times the phases of a gated flow."""
    return bool(re.match(r"phase|frame|image|trigger|slice", channel.title, re.IGNORECASE)) and not (
        channel.unit and any(units.is_of(channel.unit, quantity) for quantity in ("pressure", "flow"))
    )


def _half(file: Path, block: BlockDescription) -> tuple[str, str]:
    """Return whether a file holds the pressure or the flow of a cycle alone, and what its name says beside that."""
    signals = [channel for channel in block.channels if channel.quantity != "time" and not _counts(channel)]
    if len(signals) != 1:
        return "", ""
    words, folder = re.findall(r"[^\W_]+", file.stem), file.parent.name.casefold()
    for half, half_words in _SIGNAL_WORDS.items():
        if {*map(str.casefold, words)} & {*half_words} or signals[0].quantity == half or folder in half_words[:-1]:
            return half, pair_name(file, half_words)
    return "", ""


def pair_name(file: Path, signal_words: Collection[str] = frozenset().union(*_SIGNAL_WORDS.values())) -> str:
    """Return what the name of a file says beside the words for its signal; of a pair of files the same."""
    words = re.split(r"([^\W_]+)", file.stem)
    name = "".join(word for word in words if word.casefold() not in signal_words).strip(" _-.")
    return re.sub(r"[ _-]{2,}", "_", name) or file.parent.name
