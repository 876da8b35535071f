"""Put files into a study: rows of its table, written from what the files and their names tell."""

import os
import shlex
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from functools import cache, partial
from pathlib import Path

from vasowave.base.errors import InputError, did_you_mean
from vasowave.base.findings import Place
from vasowave.base.io.files import alone_in, content_of, write_files
from vasowave.study.entering.grouping import (
    Marks,
    Proposal,
    is_reference,
    parsed_groups,
    proposed_groups,
    told_group,
    within,
)
from vasowave.study.entering.grouping import words as words_of
from vasowave.study.entering.sorting import Recorded, Sorted, files_in, sort_files
from vasowave.study.entering.table import RecordingIndex, read_rows, seen_from, written_rows
from vasowave.study.entering.template import with_groups
from vasowave.study.folder.animals import read_row
from vasowave.study.folder.names import plain_name
from vasowave.study.folder.reading import read_settings, study_path
from vasowave.study.folder.rows import FILES
from vasowave.study.folder.settings import StudyFile
from vasowave.study.folder.study import RESULTS
from vasowave.study.report.wording import some_of
from vasowave.study.running.reporting import ONE_BY_ONE, REPORT_FOLDER

_MAX_NAMED_FILES = 3  # files, in a sentence
Ask = Callable[[str, str], str]
"""Asks a person a question, with the answer that is proposed; returns what was answered."""


@dataclass(frozen=True)
class Added:
    """The outcome of adding files.

    Attributes
    ----------
    table : Path
        The table of animals.
    rows : tuple of dict
        The new rows, by column; a cell that nothing tells is empty.
    updated : tuple of str
        Animals whose rows were there and say more now.
    said : tuple of str
        What was decided for the user, and what a person has to fill in.
    refused : tuple of str
        Why a file could not be read, for every one that is in no row.
    """

    table: Path
    rows: tuple[dict[str, str], ...]
    updated: tuple[str, ...]
    said: tuple[str, ...]
    refused: tuple[str, ...] = ()


def add_files(study: Path, paths: Sequence[Path], *, group: str = "", groups: str = "", network: Path | None = None,
              cells: Mapping[str, str] | None = None, ask: Ask | None = None) -> Added:  # fmt: skip
    """Write a row into the table of a study for every recording among `paths`, files or folders.

    A file with a column `parent` is a network, others are recordings. Two files that hold pressure and flow alone, and
    whose names differ in that word only, are one animal. An animal is called like its file. Its group is the one that
    its file, or a folder above it, is named by; where no name holds a group of the study, the groups that names speak
    of are proposed. Its network is the one of its name, of its group, or the only one, unless a file was refused,
    which may be another. A recording that is in the table keeps its row, whose empty cells are filled; one with the
    bytes of another is left out.

    Parameters
    ----------
    study : Path
        The folder of the study or its study file.
    paths : sequence of Path
    group : str, optional
        The group of all of them that have none yet.
    groups : str, optional
        The groups of the study, the reference first: ``WT,HOX``, or ``control=WT,hypoxic=HOX`` where names hold other
        words.
    network : Path, optional
        The network of all of them.
    cells : mapping of str to str, optional
        What to write into further columns of all of them; it replaces what stands there.
    ask : callable, optional
        Asks a person; without one, proposals are taken and said.

    Raises
    ------
    InputError
        No study, a name that is no file, nothing among them that is a recording, an unknown group, a cell that no
        animal can have, or a table that cannot be read or written; the table is then as it was.
    """
    path = study_path(Path(study))
    table = path.parent / _settings(path).animals
    _check_cells(cells or {})
    cells = {title: seen_from(path.parent, Path(text)) if title in FILES and text else text
             for title, text in (cells or {}).items()}  # fmt: skip
    sorted_files = _sorted(path.parent, table, paths, network, cells)
    laid_out = partial(
        _laid_out, path, sorted_files, cells, group, groups, network, None if ask is None else cache(ask)
    )
    contents_before = {file: content_of(file) for file in (table, path)}
    contents, added = laid_out()
    with alone_in(path.parent):  # for milliseconds: neither reading recordings nor a person's answer holds others up
        if (now := {file: content_of(file) for file in contents_before}) != contents_before:
            contents, added = laid_out()
        write_files(contents, now)
    return added


def _laid_out(
    path: Path, sorted_files: Sorted, cells: Mapping[str, str], group: str, groups: str, network: Path | None,
    ask: Ask | None,
) -> tuple[dict[Path, str], Added]:  # fmt: skip
    """Return what table and study file are to hold with the files, and what is said of it; nothing is written."""
    settings = _settings(path)
    table = path.parent / settings.animals
    before = read_rows(table)
    networks = _networks(path.parent, sorted_files.networks, before.rows, network)
    lookup, had = RecordingIndex(path.parent, before.rows), {row["group"] for row in before.rows}
    recorded_rows = [
        _Row(recorded, _cells(recorded, path.parent, cells), lookup.row_of(recorded))
        for recorded in sorted_files.recordings
    ]
    touched = [entry for entry in recorded_rows if entry.old is not None]
    new, messages = _without_copies([entry for entry in recorded_rows if entry.old is None], lookup)
    requested_groups = parsed_groups(groups) if groups else {}
    marks, remarks = _grouped([*new, *touched], before.rows, path, settings, group, requested_groups, ask)
    serves_all = len(networks) == 1 and (network is not None or not sorted_files.refused)
    for entry in [*new, *touched]:
        group_of_it = entry.cells["group"] or (entry.old or {}).get("group", "")
        network_file = network or told_network(
            entry.recorded.name, group_of_it, marks, networks, path.parent, serves_all
        )
        entry.cells["network"] = seen_from(path.parent, network_file) if network_file else ""
    remarks += _kept_networks(touched, networks)
    _name(new, [row["animal"] for row in before.rows])
    explicit = {*cells, *(["group"] if groups else []), *(["network"] if network else [])}
    remarks += _kept_groups(touched, group)
    updated = [entry for entry in touched if _filled(entry, explicit)]
    rows = [entry.cells for entry in new]
    all_new = [*rows, *(entry.old for entry in touched if entry.old is not None)]
    in_use = {*settings.groups, *(row["group"] for row in all_new)}
    marks = {
        label: label_marks for label, label_marks in marks.items() if label != group or label in in_use
    }  # no row takes it
    if requested_groups:
        remaining_labels = {
            row["group"] for row in [*before.rows, *rows]
        } | requested_groups.keys()  # not what rows were called until now
        marks = {
            label: label_marks for label, label_marks in marks.items() if label in remaining_labels or label not in had
        }
        marks = requested_groups if marks.keys() == requested_groups.keys() else marks
    settings_text = with_groups(path, list(marks)) if list(marks) != settings.groups else ""
    contents = {table: written_rows(before, rows)}
    if settings_text:
        contents[path] = settings_text
        added = f"; --group adds '{group}'" if group and group not in settings.groups else ""
        remarks.append(f"{path.name}: groups are [{', '.join(marks)}] now, the first is the reference{added}")
    messages = [
        *messages,
        *_once([*new, *updated]),
        *remarks,
        *_missing(all_new, marks, networks, bool(sorted_files.refused)),
    ]
    if len(updated) < len(touched):
        messages.append(f"{len(touched) - len(updated)} of these recordings are in the table already, with all this")
    names = tuple(entry.old["animal"] for entry in updated if entry.old)
    return contents, Added(table, tuple(rows), names, tuple(dict.fromkeys(messages)), sorted_files.refused)


def _check_cells(cells: Mapping[str, str]) -> None:
    """Raise `InputError` for what no row of a table may hold, before it stands in one."""
    _, problems = read_row(dict(cells), Path(), None, lambda title: Place(part=title))
    wrong = [f"{problem.place.part}: {problem.finding}" for problem in problems
             if problem.error and cells.get(problem.place.part)]  # fmt: skip
    if wrong:
        raise InputError("; ".join(wrong) + "; nothing was added")
    start, end = (float(cells.get(title) or default) for title, default in (("start [s]", 0), ("end [s]", "inf")))
    if start >= end:
        raise InputError(f"the stretch from {start:g} to {end:g} s ends before it begins; nothing was added")


def _once(rows: Sequence["_Row"]) -> list[str]:
    """Return what was decided of recordings, each decision once with the files it is about."""
    files_by_remark: dict[str, list[str]] = {}
    for row in rows:
        for remark in row.recorded.remarks:
            files_by_remark.setdefault(remark, []).append(row.recorded.files[0].name)
    return [f"{some_of(files, _MAX_NAMED_FILES)}: {remark}" for remark, files in files_by_remark.items()]


@dataclass(frozen=True)
class _Row:
    """A recording, the cells that it tells, and its row in the table if it has one."""

    recorded: Recorded
    cells: dict[str, str]
    old: dict[str, str] | None


def _without_copies(new: Sequence[_Row], lookup: RecordingIndex) -> tuple[list[_Row], list[str]]:
    """Return the recordings without those that hold the bytes of another, and what to say of these.

    Of two files the one with the shorter name is taken for the original: "mouse 1", not "mouse 1 (copy)"; of files with
    one name, that in the upper folder.
    """
    by_name = sorted(new, key=lambda row: (len(row.recorded.name), len(row.recorded.files[0].parts)))
    twins = {row.recorded.files: lookup.twin_of(row.recorded) for row in by_name}
    messages = [f"{files[0]}: holds the same bytes as the recording of {twin}; left out"
            for files, twin in twins.items() if twin]  # fmt: skip
    return [row for row in new if not twins[row.recorded.files]], messages


def _settings(path: Path) -> StudyFile:
    settings, document = read_settings(path)
    if settings is None:
        raise InputError(f"{path}: mend the study file first (`vasowave check` says what is wrong): "
                         f"{document.problems[0].finding}")  # fmt: skip
    if settings.animals.lower().endswith(".xlsx"):
        raise InputError(f"{path.parent / settings.animals}: rows are added to CSV only; save it as CSV and name that "
                         f"under 'animals' in {path}")  # fmt: skip
    return settings


def _sorted(folder: Path, table: Path, paths: Sequence[Path], network: Path | None, cells: Mapping[str, str]
            ) -> Sorted:  # fmt: skip
    """Return what the files are; those of the study's own table and results are not among them."""
    own_files = {file.resolve() for file in (table, *(folder / name for name in (RESULTS, REPORT_FOLDER, ONE_BY_ONE)))}
    titles = {title.removesuffix(" channel"): text for title, text in cells.items() if title.endswith(" channel")}
    files = files_in([*paths, *([network] if network else [])], own_files)
    sorted_files = sort_files(files, titles, int(cells["block"]) if cells.get("block", "").isdigit() else None)
    if not sorted_files.recordings:
        reasons = "\n".join(f"  {refusal}" for refusal in sorted_files.refused)
        hint = "; give the recordings along with them, or their whole folder" if sorted_files.networks else ""
        raise InputError(f"no recording among these files{hint}" + (f":\n{reasons}" if reasons else ""))
    return sorted_files


def _networks(
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


def _cells(recorded: Recorded, folder: Path, option_cells: Mapping[str, str]) -> dict[str, str]:
    """Return the cells that a recording tells, and those that were given."""
    cells = {"animal": "", "group": "", "network": "", "recording": seen_from(folder, recorded.files[0])}
    cells |= {"kind": "cycle" if option_cells.get("period [s]") and recorded.kind != "raw" else recorded.kind}
    if len(recorded.files) == 2:
        cells["flow"] = seen_from(folder, recorded.files[1])
    cells |= {f"{quantity} channel": title for quantity, title in recorded.channels}
    if recorded.stretch is not None and not (option_cells.get("start [s]") or option_cells.get("end [s]")):
        cells |= {"start [s]": f"{recorded.stretch.start:g}", "end [s]": f"{recorded.stretch.end:g}"}
    applicable_cells = {
        title: text for title, text in option_cells.items() if not (title == "period [s]" and recorded.kind == "raw")
    }
    return cells | applicable_cells


def _grouped(
    rows: Sequence[_Row], before: Sequence[dict[str, str]], path: Path, settings: StudyFile, group: str,
    requested_groups: dict[str, tuple[str, ...]], ask: Ask | None,
) -> tuple[dict[str, tuple[str, ...]], list[str]]:  # fmt: skip
    """Fill the column `group` of what was found; return the groups of the study with their marks, and what to say."""
    used = {row.get("group", "") for row in before} & set(settings.groups)
    free = not used and settings.groups == StudyFile().groups
    marks: dict[str, tuple[str, ...]] = {label: (label,) for label in settings.groups}
    if requested_groups:
        marks = _regrouped([] if free else settings.groups, used, requested_groups)
    elif group and group not in marks:
        if not free and (hint := did_you_mean(group, marks)):
            raise InputError(f"'{group}' is not a group of the study{hint}; its groups: {', '.join(marks)}")
        marks = ({} if free else marks) | {group: (group,)}

    def assign() -> list[_Row]:
        for entry in rows:
            candidates = (told_group(entry.recorded.files[0], path.parent, by) for by in (requested_groups, marks))
            entry.cells["group"] = group or next(filter(None, candidates), "")
        return [entry for entry in rows if not (entry.cells["group"] or (entry.old and entry.old.get("group")))]

    lost = assign()
    proposal = (
        proposed_groups([entry.recorded.files[0] for entry in lost], path.parent)
        if lost and not requested_groups
        else None
    )
    if proposal is None:
        return marks, []
    marks_in_use = {
        label: label_marks for label, label_marks in marks.items() if label in used or len(lost) < len(rows)
    }
    if ask is not None:
        marks = marks_in_use | _confirmed_groups(proposal, ask)
    elif free and not marks_in_use:
        marks = dict(proposal.marks)
    else:
        sure = is_reference(next(iter(proposal.sizes)))  # else the order of the words says nothing
        words = list(proposal.sizes) if sure else ["WORD"] * len(marks)
        example = shlex.quote(",".join(f"{label}={word}" for label, word in zip(marks, words)))
        return marks, [f"{proposal}, which are no groups of the study ({', '.join(marks)}). Say which is which: "
                       f"--groups {example}"]  # fmt: skip
    assign()
    return marks, [] if ask else [f"groups: {proposal}. If that is not right: --groups ONE,OTHER, the reference first"]


def _regrouped(
    before: Sequence[str], used: Collection[str], requested_groups: dict[str, tuple[str, ...]]
) -> dict[str, tuple[str, ...]]:
    """Return the groups of a study in which some are named anew, the reference first.

    A list that names all groups in use decides the order; another adds to the groups that were there.
    """
    if len(requested_groups) > 1 and set(used) <= set(requested_groups):
        return requested_groups
    labels = [label for label in before if label in used or label in requested_groups or len(requested_groups) == 1]
    return {label: requested_groups.get(label, (label,)) for label in [*labels, *requested_groups]}


def _confirmed_groups(proposal: Proposal, ask: Ask) -> dict[str, tuple[str, ...]]:
    """Return the groups that a person confirms or gives; a label that was proposed keeps its mark."""
    answer = ask(f"{str(proposal).capitalize()}. Groups, the reference first", ",".join(proposal.marks))
    return {label: proposal.marks.get(label, label_marks) for label, label_marks in parsed_groups(answer).items()}


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


def _kept_networks(touched: Sequence[_Row], networks: Sequence[Path]) -> list[str]:
    """Return what to say of rows that name another network than the one which their name or group tells now."""
    conflicting_rows = [row for row in touched if row.old and row.old.get("network") and row.cells["network"]
             and os.path.normpath(row.old["network"]) != os.path.normpath(row.cells["network"])]  # fmt: skip
    if len(networks) < 2 or not conflicting_rows:
        return []
    pairs = dict.fromkeys(f"{row.old['network']} (not {row.cells['network']})" for row in conflicting_rows if row.old)
    names = some_of([row.old["animal"] for row in conflicting_rows if row.old], _MAX_NAMED_FILES)
    return [f"{names}: the table keeps {', '.join(pairs)}; to change that, empty the cells 'network' or give --network"]


def _kept_groups(touched: Sequence[_Row], group: str) -> list[str]:
    """Return what to say of animals that were there and keep a group which is not that of the files being added."""
    animals = [row.old["animal"] for row in touched if group and row.old and row.old.get("group") not in ("", group)]
    if not animals:
        return []
    return [f"{some_of(animals, _MAX_NAMED_FILES)}: in the table already, with another group than {group}, and stays "
            "there; to change it, write it into the column 'group'"]  # fmt: skip


def _name(new: Sequence[_Row], taken: Sequence[str]) -> None:
    """Call the animals like their files; those whose files are called alike get their folder's name before it."""
    stems = [row.recorded.name.casefold() for row in new]
    names = {name.casefold() for name in taken}
    for row in new:
        stem, folder = row.recorded.name, row.recorded.files[0].absolute().parent.name
        alike = stems.count(stem.casefold()) > 1 or plain_name(stem).casefold() in names
        name = plain_name(f"{folder} {stem}" if alike else stem)
        numbered = (name if n == 1 else f"{name} ({n})" for n in range(1, len(names) + 2))
        row.cells["animal"] = next(candidate for candidate in numbered if candidate.casefold() not in names)
        names.add(row.cells["animal"].casefold())


def _filled(row: _Row, explicit: set[str]) -> bool:
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


def _missing(rows: Sequence[dict[str, str]], groups: Marks, networks: Sequence[Path], refused: bool) -> list[str]:
    messages = []
    if lost := [row["animal"] for row in rows if not row.get("group")]:
        messages.append(
            f"neither name nor folder tells the group of {', '.join(lost)}; the study has {', '.join(groups)}: "
            "give --group or --groups, or write it into the column 'group'"
        )
    if lost := [row["animal"] for row in rows if not row.get("network")]:
        reason = f"none of {len(networks)} networks carries their name or group" if networks else "there is no network"
        if len(networks) == 1:
            unread = ", and some files could not be read" if refused else ""
            reason = f"{networks[0].name} carries neither their name nor their group{unread}"
        messages.append(f"{reason}: {', '.join(lost)}; give --network, or write it into the column 'network'")
    return messages
