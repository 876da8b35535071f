"""The rows that recordings are to have in the table of animals: their cells, names and networks, and what is said."""

import os
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from vasowave.base.io.spreadsheet import WORKBOOKS
from vasowave.study.entering.animal_sheet import AnimalSheet
from vasowave.study.entering.grouping import Marks, told_group, within
from vasowave.study.entering.grouping import words as words_of
from vasowave.study.entering.occasions import is_occasion
from vasowave.study.entering.sorting import Recorded, files_in, sort_files
from vasowave.study.entering.table import RecordingIndex, seen_from
from vasowave.study.folder.names import plain_name
from vasowave.study.report.wording import some_of

_MAX_NAMED_FILES = 3  # files, in a sentence

Ask = Callable[[str, str], str]
"""Asks a person a question, with the answer that is proposed; returns what was answered."""


@dataclass(frozen=True)
class AddedRow:
    """A recording, the cells that it tells, its row in the table if it has one, and how it is called without its
    occasion.
    """

    recorded: Recorded
    cells: dict[str, str]
    old: dict[str, str] | None
    bare_file: Path | None = None

    @property
    def names(self) -> tuple[str, ...]:
        """What may hold the ID of the animal: its file, the file's folder, and the folder of that."""
        return (self.recorded.name, *(parent.name for parent in self.recorded.files[0].absolute().parents[:2]))

    @property
    def named_file(self) -> Path:
        """Its file, whose name may tell the group; of a table of subjects one that is called like the subject."""
        file, subject = self.recorded.files[0], self.recorded.subject_row
        if self.bare_file is not None:
            return self.bare_file
        return file.parent / subject.replace("/", " ") if subject else file


def sheet_groups(
    sheets: Sequence[AnimalSheet], entries: Sequence[AddedRow], before: Sequence[Mapping[str, str]]
) -> list[str]:
    """Return the groups, the reference first, that labs' tables of animals tell of rows that have none yet."""
    names = [entry.names for entry in entries if not (entry.old or {}).get("group")]
    names += [of_row for row, of_row in zip(before, names_of(before), strict=True) if not row.get("group")]
    labels = {sheet.row_of(of_row).get("group", "") for sheet in sheets for of_row in names}
    return [label for sheet in sheets for label in sheet.groups if label in labels]


def names_of(rows: Sequence[Mapping[str, str]]) -> list[tuple[str, ...]]:
    """Return what may hold the ID of the animal of each row: its name, and that of its file if it is of it alone."""
    recordings = [row.get("recording", "") for row in rows]
    count = Counter(recordings)
    return [(row.get("animal", ""), *([Path(file).stem] if count[file] == 1 else []))
            for row, file in zip(rows, recordings, strict=True)]  # fmt: skip


def told_cells(
    sheet: AnimalSheet, new: Sequence[AddedRow], before: Sequence[dict[str, str]], groups: Marks
) -> list[str]:
    """Write what a lab's table of animals tells into new rows, and into empty cells of rows that were there.

    An animal with several recordings is named in the column ``subject``. Returns the animals of rows that say more now.
    """
    of_before = names_of(before)
    subjects = subjects_of(sheet, [*(entry.names for entry in new), *of_before])
    for entry in new:
        cells = dict(sheet.row_of(entry.names)) | _subject(subjects, entry.names)
        entry.cells.update({title: text for title, text in cells.items() if title != "group"})
    changed = []
    for row, names in zip(before, of_before, strict=True):
        cells = dict(sheet.row_of(names)) | _subject(subjects, names)
        fresh = {title: text for title, text in cells.items() if text and not row.get(title)
                 and (title != "group" or text in groups)}  # fmt: skip
        row.update(fresh)
        changed += [row["animal"]] if fresh else []
    return changed


def _subject(subjects: Mapping[tuple[str, ...], str], names: tuple[str, ...]) -> dict[str, str]:
    return {"subject": subjects[names]} if names in subjects else {}


def subjects_of(sheet: AnimalSheet, names: Sequence[tuple[str, ...]]) -> dict[tuple[str, ...], str]:
    """Return by its names whose recording each is, where some animal has several; else nothing."""
    keys = [sheet.animal_of(of_row)[0] for of_row in names]  # also of two files that have one name in one folder
    subjects = {of_row: key for of_row, key in zip(names, keys, strict=True) if key}
    return subjects if len({*subjects.values()}) < sum(map(bool, keys)) else {}


def sheet_remark(sheet: AnimalSheet, rows: Sequence[tuple[str, ...]]) -> str:
    """Return what to say of a lab's table of animals, by the names of each row that is added or there."""
    if not any(map(sheet.row_of, rows)):
        ids = some_of([*sheet.rows], _MAX_NAMED_FILES)
        return f"{sheet.file.name}: a table of animals ({ids}), none of which any file here is called by"
    titles = ", ".join(dict.fromkeys(title for row in sheet.rows.values() for title in row))
    lost = f"; without {', '.join(sheet.passed_over)}, which a study's table cannot have" if sheet.passed_over else ""
    taken = some_of([f"{name} for {key}" for name, key in sheet.guesses(rows).items()], _MAX_NAMED_FILES)
    guessed = f"; taken were {taken}" if taken else ""
    remark = (
        f"{sheet.file.name}: a table of {len(sheet.rows)} animals, which tells {titles or 'nothing'}{lost}{guessed}"
    )
    counts = Counter(sheet.animal_of(of_row)[0] for of_row in rows)
    repeated = some_of([key for key, count in counts.items() if key and count > 1], _MAX_NAMED_FILES)
    several = [f"several recordings of {repeated}: column subject"] if repeated else []
    return "; ".join([remark, *sheet.taken, *several])


def without_copies(new: Sequence[AddedRow], lookup: RecordingIndex) -> tuple[list[AddedRow], list[str]]:
    """Return the recordings without those that hold the bytes of another, and what to say of these.

    Of two files the one with the shorter name is taken for the original: "mouse 1", not "mouse 1 (copy)"; of files with
    one name, that in the upper folder.
    """
    by_name = sorted(new, key=lambda row: (len(row.recorded.name), len(row.recorded.files[0].parts)))
    twins = {row.recorded.files: lookup.twin_of(row.recorded) for row in by_name}
    messages = [f"{files[0]}: holds the same bytes as the recording of {twin}; left out"
            for files, twin in twins.items() if twin]  # fmt: skip
    return [row for row in new if not twins[row.recorded.files]], messages


def cells_of(recorded: Recorded, folder: Path, option_cells: Mapping[str, str]) -> dict[str, str]:
    """Return the cells that a recording tells, and those that were given."""
    cells = {"animal": "", "group": "", "network": "", "recording": seen_from(folder, recorded.files[0])}
    cells |= {"kind": "cycle" if option_cells.get("period [s]") and recorded.kind != "raw" else recorded.kind}
    if len(recorded.files) == 2:
        cells["flow"] = seen_from(folder, recorded.files[1])
    cells |= {f"{quantity} channel": title for quantity, title in recorded.channels}
    if recorded.stretch is not None and not (option_cells.get("start [s]") or option_cells.get("end [s]")):
        cells |= {"start [s]": f"{recorded.stretch.start:g}", "end [s]": f"{recorded.stretch.end:g}"}
    titles = {title.strip().casefold() for title in recorded.titles}

    def applies(title: str, text: str) -> bool:
        if title == "period [s]":
            return recorded.kind != "raw"
        named = title.endswith(" channel") and len(recorded.files) == 1
        if title == "sheet":
            return any(file.suffix.lower() in WORKBOOKS for file in recorded.files)
        return not named or text.strip().casefold() in titles

    cells |= {title: text for title, text in option_cells.items() if applies(title, text)}
    return cells | ({"subject row": recorded.subject_row} if recorded.subject_row else {})


def networks_of(
    folder: Path, networks: Sequence[Path], rows: Sequence[dict[str, str]], network: Path | None
) -> tuple[Path, ...]:
    """Return the networks an animal can have: the one that is wished, those given, or those the study has."""
    if network is not None:
        return (network,)
    if networks:
        return tuple(networks)
    named = {os.path.normpath(folder / row["network"]) for row in rows if row.get("network")}
    place = folder / "networks"
    folder_networks = sort_files(files_in([place])).networks if place.is_dir() and any(place.iterdir()) else ()
    return tuple(dict.fromkeys([*(Path(name) for name in sorted(named)), *folder_networks]))


def told_network(
    name: str, group: str, marks: Marks, networks: Sequence[Path], folder: Path, serves_all: bool = True
) -> Path | None:
    """Return the network that carries an animal's name, its beginning or its group, or the only one if it `serves_all`.

    The name of a recording may begin with that of the animal: ``Süd 1 before`` has the network ``Süd 1``.
    """
    called = words_of(name)
    of_name = [file for file in networks if within(called, words_of(file.stem))]
    groups = {file: told_group(file, folder, marks) for file in networks}
    begun = {file: len(words_of(file.stem)) for file in networks
             if words_of(file.stem) == called[: len(words_of(file.stem))] and groups[file] in ("", group)}  # fmt: skip
    longest = [file for file, length in begun.items() if 0 < length == max(begun.values())]
    of_group = [file for file in networks if group and groups[file] == group]
    unnamed = [file for file in networks if groups[file] in ("", group)]  # not one that is called like another group
    candidate_lists = (of_name, longest, of_group, unnamed if serves_all and len(networks) == 1 else [])
    return next((candidates[0] for candidates in candidate_lists if len(candidates) == 1), None)


def fill_networks(
    rows: Sequence[dict[str, str]], network_of: Callable[[str, str], Path | None], folder: Path
) -> list[str]:
    """Write the network that goes with an animal's name and group into rows without any; return their animals."""
    filled = []
    for row in rows:
        if not row.get("network") and (file := network_of(row["animal"], row.get("group", ""))):
            row["network"] = seen_from(folder, file)
            filled.append(row["animal"])
    return filled


def name_animals(new: Sequence[AddedRow], taken: Sequence[str]) -> None:
    """Call the animals like their files; of files called alike, or after an occasion, the folder stands before it."""
    stems = [row.recorded.name.casefold() for row in new]
    names = {name.casefold() for name in taken}
    for row in new:
        stem, folder = row.recorded.name, row.recorded.files[0].absolute().parent.name
        alike = stems.count(stem.casefold()) > 1 or plain_name(stem).casefold() in names
        name = plain_name(f"{folder} {stem}" if alike or is_occasion(stem) else stem)
        name = plain_name(f"{stem} {row.recorded.sheet}") if alike and row.recorded.sheet else name
        numbered = (name if n == 1 else f"{name} ({n})" for n in range(1, len(names) + 2))
        row.cells["animal"] = next(candidate for candidate in numbered if candidate.casefold() not in names)
        names.add(row.cells["animal"].casefold())


def fill_row(row: AddedRow, explicit: set[str]) -> bool:
    """Fill the empty cells of a row that was there, and those that were given; return whether anything changed."""
    assert row.old is not None
    cells_before, cells = dict(row.old), row.cells
    if row.old.get("start [s]") or row.old.get("end [s]") or row.old.get("block"):
        cells = {title: text for title, text in cells.items() if title in explicit or title not in
                 ("start [s]", "end [s]")}  # fmt: skip
    for title, text in cells.items():
        if title not in ("animal", "recording") and text and (title in explicit or not row.old.get(title)):
            row.old[title] = text
    return row.old != cells_before


def shared_remarks(rows: Sequence[AddedRow]) -> list[str]:
    """Return what was decided of recordings, each decision once with the files it is about."""
    files_by_remark: dict[str, dict[str, None]] = {}
    for row in rows:
        for remark in row.recorded.remarks:
            files_by_remark.setdefault(remark, {})[row.recorded.files[0].name] = None
    return [f"{some_of([*files], _MAX_NAMED_FILES)}: {remark}" for remark, files in files_by_remark.items()]


def kept_networks(touched: Sequence[AddedRow], networks: Sequence[Path]) -> list[str]:
    """Return what to say of rows that name another network than the one which their name or group tells now."""
    conflicting_rows = [row for row in touched if row.old and row.old.get("network") and row.cells["network"]
             and os.path.normpath(row.old["network"]) != os.path.normpath(row.cells["network"])]  # fmt: skip
    if len(networks) < 2 or not conflicting_rows:
        return []
    pairs = dict.fromkeys(f"{row.old['network']} (not {row.cells['network']})" for row in conflicting_rows if row.old)
    names = some_of([row.old["animal"] for row in conflicting_rows if row.old], _MAX_NAMED_FILES)
    return [f"{names}: the table keeps {', '.join(pairs)}; to change that, empty the cells 'network' or name another"]


def kept_groups(touched: Sequence[AddedRow], group: str) -> list[str]:
    """Return what to say of animals that were there and keep a group which is not that of the files being added."""
    animals = [row.old["animal"] for row in touched if group and row.old and row.old.get("group") not in ("", group)]
    if not animals:
        return []
    return [f"{some_of(animals, _MAX_NAMED_FILES)}: in the table already, with another group than {group}, and stays "
            "there; to change it, write it into the column 'group'"]  # fmt: skip


def missing_cells(rows: Sequence[dict[str, str]], groups: Marks, networks: Sequence[Path], refused: bool) -> list[str]:
    """Return what to say of rows whose group or network is still to be filled in."""
    messages = []
    if lost := [row["animal"] for row in rows if not row.get("group")]:
        messages.append(
            f"neither name nor folder tells the group of {', '.join(lost)}; the study has {', '.join(groups)}: "
            "name the groups as names hold them, or write it into the column 'group'"
        )
    if lost := [row["animal"] for row in rows if not row.get("network")]:
        reason = f"none of {len(networks)} networks carries their name or group" if networks else "there is no network"
        if len(networks) == 1:
            unread = ", and some files could not be read" if refused else ""
            reason = f"{networks[0].name} carries neither their name nor their group{unread}"
        messages.append(f"{reason}: {', '.join(lost)}; write it into the column 'network'")
    return messages
