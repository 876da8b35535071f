"""Put files into a study: rows of its table, written from what the files and their names tell."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from vasowave.base.cures import UNKNOWN, Cure, NameGroups, SetCells
from vasowave.base.errors import InputError, did_you_mean
from vasowave.base.findings import Place
from vasowave.base.io.files import alone_in, content_of, write_files
from vasowave.base.io.spreadsheet import WORKBOOKS
from vasowave.study.entering.added_rows import (
    AddedRow,
    Ask,
    cells_of,
    fill_networks,
    fill_row,
    kept_groups,
    kept_networks,
    missing_cells,
    name_animals,
    names_of,
    networks_of,
    shared_remarks,
    sheet_groups,
    sheet_remark,
    told_cells,
    told_network,
    without_copies,
)
from vasowave.study.entering.animal_sheet import AnimalSheet
from vasowave.study.entering.following import followed
from vasowave.study.entering.grouping import (
    Proposal,
    is_reference,
    parsed_groups,
    path_names,
    proposed_groups,
    told_group,
)
from vasowave.study.entering.sorting import Choosing, Sorted, files_in, passed_over, sort_files
from vasowave.study.entering.table import RecordingIndex, read_rows, seen_from, written_rows
from vasowave.study.entering.template import with_values, written
from vasowave.study.folder.animal_columns import FILES
from vasowave.study.folder.animals import read_row
from vasowave.study.folder.places import RESULTS, study_path
from vasowave.study.folder.reading import read_settings
from vasowave.study.folder.settings import StudyFile
from vasowave.study.running.reporting import ONE_BY_ONE, REPORT_FOLDER

_MAX_NAMES = 4  # files named in a sentence

MarksOf = dict[str, tuple[str, ...]]
"""Labels of groups in their order, and what names that belong to them hold."""


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
    cures : tuple of Cure
        How a person says what is lacking, or otherwise than it was decided.
    """

    table: Path
    rows: tuple[dict[str, str], ...]
    updated: tuple[str, ...]
    said: tuple[str, ...]
    refused: tuple[str, ...] = ()
    cures: tuple[Cure, ...] = ()


def add_files(study: Path, paths: Sequence[Path], *, group: str = "", groups: str = "", network: Path | None = None,
              cells: Mapping[str, str] | None = None, ask: Ask | None = None) -> Added:  # fmt: skip
    """Write a row into the table of a study for every recording among `paths`, files or folders.

    A file with a column `parent` is a network, others are recordings. Two files that hold pressure and flow alone, and
    whose names differ in that word only, are one animal. An animal is called like its file. Its group is the one that
    its file, or a folder above it, is named by; where no name holds a group of the study, the groups that names speak
    of are proposed. Its network is the one of its name, of its group, or the only one, unless a file was refused,
    which may be another; animals of the table that wait for a network get theirs likewise. A recording that is in the
    table keeps its row, whose empty cells are filled; one with the bytes of another is left out.

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
        No study, a name that is not a file, nothing among them that is a recording, an unknown group, a cell that no
        animal can have, or a table that cannot be read or written; the table is then as it was.
    """
    path = study_path(Path(study))
    settings = _settings(path)
    table = path.parent / settings.animals
    _check_cells(cells or {})
    cells = {title: seen_from(path.parent, Path(text)) if title in FILES and text else text
             for title, text in (cells or {}).items()}  # fmt: skip
    files = _sorted(path.parent, table, paths, network, cells, settings.site)
    parsed = parsed_groups(groups) if groups else {}
    options = AddingOptions(group, parsed, network, cells, None if ask is None else cache(ask))
    contents_before = {file: content_of(file) for file in (table, path)}
    plan = plan_rows(path, files, options)
    with alone_in(path.parent):  # for milliseconds: neither reading recordings nor a person's answer holds others up
        if (now := {file: content_of(file) for file in contents_before}) != contents_before:
            plan = plan_rows(path, files, options)
        write_files(plan.contents, now)
    return plan.added


@dataclass(frozen=True)
class AddingOptions:
    """What a person says of all files that are added; see `add_files`."""

    group: str
    groups: dict[str, tuple[str, ...]]
    network: Path | None
    cells: Mapping[str, str]
    ask: Ask | None

    @property
    def columns(self) -> set[str]:
        """The columns that were said, whose cells replace what stands in a row."""
        return {*self.cells, *(["group"] if self.groups else []), *(["network"] if self.network else [])}


@dataclass(frozen=True)
class RowPlan:
    """What is to be written, by file, and the outcome that this will have."""

    contents: dict[Path, str]
    added: Added


def plan_rows(path: Path, files: Sorted, options: AddingOptions) -> RowPlan:
    """Return what table and study file are to hold with the files, and what is said of it; nothing is written."""
    settings = _settings(path)
    table, folder = path.parent / settings.animals, path.parent
    before = read_rows(table)
    networks = networks_of(folder, files.networks, before.rows, options.network)
    lookup, had = RecordingIndex(folder, before.rows), {row["group"] for row in before.rows}
    entries = [
        AddedRow(recorded, cells_of(recorded, folder, options.cells), lookup.row_of(recorded))
        for recorded in files.recordings
    ]
    touched = [entry for entry in entries if entry.old is not None]
    new, copies = without_copies([entry for entry in entries if entry.old is None], lookup)
    times = followed([*new, *touched], before.rows, folder, settings.design, files.sheets, options.ask)
    new, touched = list(times.entries[: len(new)]), list(times.entries[len(new) :])
    marks, remarks, cures = _grouped([*new, *touched], before.rows, path, settings, options, files.sheets)
    remarks += [*files.remarks, *times.remarks]
    cures += times.cures
    in_sheets = [name for sheet in files.sheets for name in told_cells(sheet, new, before.rows, marks)]
    of_before = {id(row): names for row, names in zip(before.rows, names_of(before.rows), strict=True)}
    of_rows = [*(entry.names + of_before.pop(id(entry.old), ()) for entry in [*new, *touched]), *of_before.values()]
    recorded_files = {file for entry in entries for file in entry.recorded.files}  # whose other sheets may be notes
    remarks += [sheet_remark(sheet, of_rows) for sheet in files.sheets
                if sheet.file not in recorded_files or any(map(sheet.row_of, of_rows))]  # fmt: skip
    serves_all = options.network is not None or not files.refused
    for entry in [*new, *touched]:
        group = entry.cells["group"] or (entry.old or {}).get("group", "")
        file = options.network or told_network(entry.recorded.name, group, marks, networks, folder, serves_all)
        entry.cells["network"] = seen_from(folder, file) if file else ""
    remarks += [*kept_networks(touched, networks), *kept_groups(touched, options.group)]
    name_animals(new, [row["animal"] for row in before.rows])
    updated = [entry for entry in touched if fill_row(entry, options.columns)]
    filled = fill_networks(before.rows, lambda name, group: told_network(
        name, group, marks, files.networks, folder, serves_all and not new), folder)  # fmt: skip
    rows = [entry.cells for entry in new]
    concerned = [*rows, *(entry.old for entry in touched if entry.old is not None)]
    if files.networks:
        concerned += [row for row in before.rows if not (row.get("network") or row in concerned)]
    in_use = {*settings.groups, *(row["group"] for row in concerned)}
    marks = {label: words for label, words in marks.items() if label != options.group or label in in_use}
    marks = _settled(marks, options.groups, {row["group"] for row in [*before.rows, *rows]}, had)
    contents = {table: written_rows(before, rows)}
    keys: dict[tuple[str, ...], str] = {("design", key): text for key, text in times.keys.items()}
    if list(marks) != settings.groups:
        keys[("groups",)] = written(list(marks))
        remarks.append(_of_groups(path, marks, settings, options.group))
    if keys:
        contents[path] = with_values(path, keys)
    remarks += missing_cells(concerned, marks, networks, bool(files.refused))
    if (unchanged := len(touched) - len(updated)) > 0:
        remarks.append(f"{unchanged} of these recordings are in the table already, with all this")
    sentences = dict.fromkeys([*copies, *shared_remarks([*new, *updated]), *remarks])
    changed = tuple(dict.fromkeys([*(entry.old["animal"] for entry in updated if entry.old), *in_sheets,
                             *times.updated, *filled]))  # fmt: skip
    if any(not row.get("network") for row in concerned):
        cures += [SetCells("Name the network", (("network", UNKNOWN),))]
    return RowPlan(contents, Added(table, tuple(rows), changed, tuple(sentences),
                                    (*files.refused, *_of_texts(files.texts)), tuple(cures)))  # fmt: skip


def _settled(marks: MarksOf, requested: MarksOf, used: set[str], had: set[str]) -> MarksOf:
    """Return the groups of a study where some are named anew: without those that rows had until now and none has."""
    if not requested:
        return marks
    remaining = used | requested.keys()
    marks = {label: words for label, words in marks.items() if label in remaining or label not in had}
    return requested if marks.keys() == requested.keys() else marks


def _of_groups(path: Path, marks: MarksOf, settings: StudyFile, group: str) -> str:
    """Say which groups the study has now."""
    added = f"; '{group}' is new" if group and group not in settings.groups else ""
    return f"{path.name}: groups are [{', '.join(marks)}] now, the first is the reference{added}"


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


def _settings(path: Path) -> StudyFile:
    settings, document = read_settings(path)
    if settings is None:
        raise InputError(f"{path}: mend the study file first: "
                         f"{document.problems[0].finding}")  # fmt: skip
    if settings.animals.lower().endswith(WORKBOOKS):
        raise InputError(f"{path.parent / settings.animals}: rows are added to CSV only; save it as CSV and name that "
                         f"under 'animals' in {path}")  # fmt: skip
    return settings


def _sorted(folder: Path, table: Path, paths: Sequence[Path], network: Path | None, cells: Mapping[str, str],
            site: str) -> Sorted:  # fmt: skip
    """Return what the files are; those of the study's own table and results are not among them."""
    own_files = {file.resolve() for file in (table, *(folder / name for name in (RESULTS, REPORT_FOLDER, ONE_BY_ONE)))}
    titles = {title.removesuffix(" channel"): text for title, text in cells.items() if title.endswith(" channel")}
    files = files_in([*paths, *([network] if network else [])], own_files)
    block = int(cells["block"]) if cells.get("block", "").isdigit() else None
    choosing = Choosing(titles, block, cells.get("site") or site, cells.get("sheet", ""),
                        cells.get("subject row", ""), bool(cells.get("flow diameter [mm]")))  # fmt: skip
    sorted_files = sort_files(files, choosing)
    if unread := passed_over(paths, own_files):
        names = ", ".join(unread[:_MAX_NAMES]) + (
            f" and {surplus} more" if (surplus := len(unread) - _MAX_NAMES) > 0 else ""
        )
        remark = f"passed over, for no reader has their type (save as .xlsx or CSV): {names}"
        sorted_files = sorted_files._replace(remarks=(remark,))
    rows = read_rows(table).rows
    for_rows = sorted_files.networks and any(not row.get("network") for row in rows)
    if not (sorted_files.recordings or sorted_files.sheets or for_rows):
        reasons = "\n".join(f"  {refusal}" for refusal in (*sorted_files.refused, *_of_texts(sorted_files.texts)))
        complete = ", and every animal has a network" if rows and sorted_files.networks else ""
        hint = "; give the recordings along with them, or their whole folder" if sorted_files.networks else ""
        name_network = [SetCells("Name the network", (("network", str(file)),)) for file in sorted_files.networks[:1]]
        raise InputError(f"no recording among these files{complete}{hint}" + (f":\n{reasons}" if reasons else ""),
                         name_network if complete else [])  # fmt: skip
    return sorted_files._replace(texts=tuple(file for file in sorted_files.texts if file in paths))


def _of_texts(texts: Sequence[Path]) -> list[str]:
    """Say of texts that were named, or are all there is, that they are nothing of use."""
    return [f"{file}: a text without numbers, neither a recording nor a network" for file in texts]


def _grouped(
    rows: Sequence[AddedRow],
    before: Sequence[dict[str, str]],
    path: Path,
    settings: StudyFile,
    options: AddingOptions,
    sheets: Sequence[AnimalSheet] = (),
) -> tuple[MarksOf, list[str], list[Cure]]:
    """Fill the column `group` of what was found; return the groups of the study with their marks, what to say, and
    what a person may do.
    """
    marks, used, free = _named_groups(rows, before, settings, options, sheets)
    group, requested_groups = options.group, options.groups

    def assign() -> list[AddedRow]:
        for entry in rows:
            candidates = (told_group(entry.named_file, path.parent, by) for by in (requested_groups, marks))
            words = [sheet.row_of(entry.names).get("group", "") for sheet in sheets]
            in_sheet = (label for label, of_label in marks.items() if {label, *of_label} & {*words})
            entry.cells["group"] = group or next(filter(None, [*in_sheet, *candidates]), "")
        return [entry for entry in rows if not (entry.cells["group"] or (entry.old and entry.old.get("group")))]

    lost = assign()
    proposal = (
        proposed_groups([entry.named_file for entry in lost], path.parent) if lost and not requested_groups else None
    )
    names = [*marks, *(name for entry in lost for name in path_names(entry.named_file, path.parent))]
    if proposal is None and len(marks) == 1 and lost and not any(map(is_reference, names)):  # else it may be another
        (label,) = marks
        for entry in lost:
            entry.cells["group"] = label
        return marks, [f"all in {label}, the only group of the study"], [NameGroups()]
    if proposal is None:
        return marks, [], [NameGroups()] if lost else []
    marks_in_use = {
        label: label_marks for label, label_marks in marks.items() if label in used or len(lost) < len(rows)
    }
    if options.ask is not None:
        marks = marks_in_use | _confirmed_groups(proposal, options.ask)
    elif free and not marks_in_use:
        marks = dict(proposal.marks)
    else:
        sure = is_reference(next(iter(proposal.sizes)))  # else the order of the words says nothing
        words = list(proposal.sizes) if sure else ["WORD"] * len(marks)
        example = ",".join(f"{label}={word}" for label, word in zip(marks, words))
        remark = f"{proposal}, which are no groups of the study ({', '.join(marks)}). Say which is which: {example}"
        return marks, [remark], [NameGroups(example)]
    assign()
    if options.ask:
        return marks, [], []
    return marks, [f"groups: {proposal}. If that is not right, name them, the reference first"], [NameGroups()]


def _named_groups(
    rows: Sequence[AddedRow], before: Sequence[dict[str, str]], settings: StudyFile, options: AddingOptions,
    sheets: Sequence[AnimalSheet],
) -> tuple[MarksOf, set[str], bool]:  # fmt: skip
    """Return the groups that a person, a lab's table or the study names, those of rows, and whether none was chosen."""
    used = {row.get("group", "") for row in before} & set(settings.groups)
    free = not used and settings.groups == StudyFile().groups
    marks: MarksOf = {label: (label,) for label in settings.groups}
    group, requested_groups = options.group, options.groups
    if requested_groups:
        marks = _regrouped([] if free else settings.groups, used, requested_groups)
    elif group and group not in marks:
        if not free and (hint := did_you_mean(group, marks)):
            raise InputError(f"'{group}' is not a group of the study{hint}; its groups: {', '.join(marks)}")
        marks = ({} if free else marks) | {group: (group,)}

    labels = [] if requested_groups else sheet_groups(sheets, rows, before)
    marks = ({} if free and labels else marks) | {label: marks.get(label, (label,)) for label in labels}
    return marks, used, free


def _regrouped(before: Sequence[str], used: Collection[str], requested_groups: MarksOf) -> MarksOf:
    """Return the groups of a study in which some are named anew, the reference first.

    A list that names all groups in use decides the order; another adds to the groups that were there.
    """
    if len(requested_groups) > 1 and set(used) <= set(requested_groups):
        return requested_groups
    labels = [label for label in before if label in used or label in requested_groups or len(requested_groups) == 1]
    return {label: requested_groups.get(label, (label,)) for label in [*labels, *requested_groups]}


def _confirmed_groups(proposal: Proposal, ask: Ask) -> MarksOf:
    """Return the groups that a person confirms or gives; a label that was proposed keeps its mark."""
    answer = ask(f"{str(proposal).capitalize()}. Groups, the reference first", ",".join(proposal.marks))
    return {label: proposal.marks.get(label, label_marks) for label, label_marks in parsed_groups(answer).items()}
