"""Animals that were recorded more than once: their columns of the table and the design, from what names tell."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

from vasowave.base.cures import UNKNOWN, Cure, SetCells, SetSetting
from vasowave.study.cohort.design import Design
from vasowave.study.entering.added_rows import AddedRow, Ask, names_of
from vasowave.study.entering.animal_sheet import AnimalSheet
from vasowave.study.entering.occasions import Occasions, told_occasions
from vasowave.study.report.wording import some_of

_SUBJECT = "subject"
_MAX_NAMES = 5  # animals, in a sentence
_YES = ("y", "yes", "j", "ja", "oui", "si", "sí")


class Followed(NamedTuple):
    """What names tell of animals that were recorded more than once.

    Attributes
    ----------
    entries : list of AddedRow
        Those that are added, called without their occasions.
    keys : dict of str to str
        What the design of the study file is to hold.
    updated : list of str
        Animals of rows that were there and say more now.
    remarks : list of str
    cures : list of Cure
    """

    entries: Sequence[AddedRow]
    keys: Mapping[str, str] = {}
    updated: Sequence[str] = ()
    remarks: Sequence[str] = ()
    cures: Sequence[Cure] = ()


def followed(
    entries: Sequence[AddedRow], before: Sequence[dict[str, str]], folder: Path, design: Design,
    sheets: Sequence[AnimalSheet] = (), ask: Ask | None = None,
) -> Followed:  # fmt: skip
    """Write animal and occasion into the rows of recordings whose names tell them, and both into the design.

    Nothing is written, and it is said how to, where animals differ in their occasions and nobody is there to be asked.
    """
    added = [id(entry.old) for entry in entries]
    rows = [row for row in before if row.get("recording") and id(row) not in added]
    if design.factor or design.dose or design.crossover or (design.subject and not design.occasion):
        return Followed(entries)
    subject = design.subject or _SUBJECT
    sheet_names = [*(entry.names for entry in entries), *names_of(rows)]
    cells = [*(entry.old or {} for entry in entries), *rows]
    subjects = [row.get(subject) or _in_sheets(sheets, names) for row, names in zip(cells, sheet_names, strict=True)]
    files = [*(entry.named_file for entry in entries), *(folder / row["recording"] for row in rows)]
    occasions = told_occasions(files, folder, subjects)
    if occasions is None:
        return Followed(entries)
    entries = [replace(entry, bare_file=file) for entry, file in zip(entries, occasions.files)]
    column = design.occasion or occasions.column
    if any(row.get(subject) and row.get(column) for row in cells) and not design.subject:
        return Followed(entries)  # somebody took them out of the design
    if not occasions.clear and not (ask and _confirmed(occasions, ask)):
        return Followed(entries, remarks=[_unclear(occasions)], cures=_by_hand(subject, column))
    targets = [*(entry.cells for entry in entries), *rows]
    changed = [_fill(target, row, {subject: animal, column: level}) for target, row, animal, level
               in zip(targets, cells, occasions.subjects, occasions.levels, strict=True)]  # fmt: skip
    keys = {} if design.occasion else {"subject": subject, "occasion": column}
    updated = [row["animal"] for row, fresh in zip(rows, changed[len(entries) :], strict=True) if fresh]
    if not any(changed):
        return Followed(entries)
    return Followed(entries, keys, updated, [_clear(occasions, subject, column)], _undo() if keys else ())


def _in_sheets(sheets: Sequence[AnimalSheet], names: Sequence[str]) -> str:
    return next(filter(None, (sheet.animal_of(names)[0] for sheet in sheets)), "")


def _fill(target: dict[str, str], row: Mapping[str, str], texts: Mapping[str, str]) -> bool:
    """Write texts into empty cells; return whether that is more than the table's row says."""
    fresh = {title: text for title, text in texts.items() if text and not (target.get(title) or row.get(title))}
    target.update(fresh)
    return bool(fresh)


def _confirmed(occasions: Occasions, ask: Ask) -> bool:
    question = f"Names speak of {occasions}, which differ between animals. Compare each animal with itself"
    return ask(question, "no").strip().casefold() in _YES


def _clear(occasions: Occasions, subject: str, column: str) -> str:
    unsaid = some_of([*occasions.assumed], _MAX_NAMES)
    assumed = f" (of {unsaid} no name says when, which counts as the first)" if unsaid else ""
    return (
        f"names tell {occasions}{assumed}: columns '{subject}' and '{column}', by which the design compares each "
        "animal with itself. If every recording is of an animal of its own, take both out of the design"
    )


def _unclear(occasions: Occasions) -> str:
    return (
        f"names speak of {occasions}, which differ between animals, so that every recording counts as an animal of "
        "its own. If some are of one animal, write its name and the occasion into two columns that the design names"
    )


def _by_hand(subject: str, column: str) -> list[Cure]:
    return [
        SetCells("Say which animal, and when", ((subject, UNKNOWN), (column, UNKNOWN))),
        SetSetting("Recordings of one animal belong together", "design.subject", subject),
        SetSetting("Compare each animal with itself", "design.occasion", column),
    ]


def _undo() -> list[Cure]:
    """Return how every recording becomes an animal again; the occasion goes first, which needs the animal."""
    return [
        SetSetting("Compare no occasions", "design.occasion", "null"),
        SetSetting("Count every recording as an animal", "design.subject", "null"),
    ]
