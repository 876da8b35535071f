"""Put files into a study: rows of its table, written from what the files and their names tell."""

import csv
import io
import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from vasowave.columns import read_columns
from vasowave.errors import InputError
from vasowave.files import write_file
from vasowave.study.names import checked_name
from vasowave.study.reading import read_settings, study_path
from vasowave.study.rows import COLUMNS
from vasowave.study.sorting import Recorded, files_in, sort_files, words


@dataclass(frozen=True)
class Added:
    """What became of the files.

    Attributes
    ----------
    table : Path
        The table of animals.
    rows : tuple of dict
        The new rows, by column; a cell that nothing tells is empty.
    said : tuple of str
        What was not used, and what a person has to fill in.
    """

    table: Path
    rows: tuple[dict[str, str], ...]
    said: tuple[str, ...]


def add_files(study: Path, paths: Sequence[Path], *, group: str = "", network: Path | None = None,
              period: float | None = None) -> Added:  # fmt: skip
    """Write a row into the table of a study for every recording among `paths`, files or folders.

    A file with a column `parent` is a network, others are recordings. Two files that hold pressure and flow alone, and
    whose names differ in that word only, are one animal. An animal is called like its file. Its group is the one that
    its file, or a folder above it, is named by; its network the one of its name, of its group, or the only one.

    Parameters
    ----------
    study : Path
        The folder of the study or its study file.
    paths : sequence of Path
    group : str, optional
        The group of all of them.
    network : Path, optional
        The network of all of them.
    period : float, optional
        s; of averaged cycles without a time column.

    Raises
    ------
    InputError
        No study, a name that is no file, nothing among them that is a recording, an unknown group, or a table that
        cannot be read or written; the table is then as it was.
    """
    path = study_path(Path(study))
    settings, document = read_settings(path)
    if settings is None:
        raise InputError(f"{path}: mend the study file first (`vasowave check` says what is wrong): "
                         f"{document.problems[0].message}")  # fmt: skip
    if group and group not in settings.groups:
        raise InputError(f"'{group}' is not a group of the study; its groups: {', '.join(settings.groups)}")
    table = path.parent / settings.animals
    if table.suffix.lower() == ".xlsx":
        raise InputError(f"{table}: rows are added to CSV only; save it as CSV and name that under 'animals' in {path}")
    titles, rows = _table(table)
    sorted_files = sort_files(files_in([*paths, *([network] if network else [])]))
    if not sorted_files.recordings:
        why = "\n".join(f"  {one}" for one in sorted_files.refused)
        raise InputError("no recording among these files" + (f":\n{why}" if why else ""))
    networks = _networks(path.parent, sorted_files.networks, rows, network)
    new: list[dict[str, str]] = []
    said = list(sorted_files.refused)
    listed = {os.path.normpath(path.parent / row["recording"]) for row in rows}
    for recorded in sorted_files.recordings:
        if os.path.normpath(recorded.files[0].absolute()) in listed:
            said.append(f"{recorded.files[0]}: is in the table already")
            continue
        row = _row(recorded, path.parent, settings.groups, group, networks, period)
        row["animal"] = _free_name(row["animal"], [one["animal"] for one in [*rows, *new]])
        new.append(row)
    said += _missing(new, settings.groups, networks)
    _write(table, titles, rows, new)
    return Added(table, tuple(new), tuple(said))


def _table(path: Path) -> tuple[list[str], list[dict[str, str]]]:
    """Return titles and rows of the table as they stand; none if it has no rows yet."""
    try:
        table = read_columns(path)
    except InputError as error:
        if "and no data" in str(error) or "is empty" in str(error) or not path.exists():
            return [], []
        raise
    titles = [f"{name} [{unit}]" if unit else name for name, unit in zip(table.names, table.units, strict=True)]
    exact = {title.casefold(): title for title in COLUMNS}
    titles = [exact.get(title.casefold(), title) for title in titles]
    return titles, [dict(zip(titles, row, strict=True)) for row in table.cells]


def _networks(
    folder: Path, given: Sequence[Path], rows: Sequence[dict[str, str]], network: Path | None
) -> tuple[Path, ...]:
    """Return the networks an animal can have: the one that is wished, those given, or those the study has."""
    if network is not None:
        return (network,)
    if given:
        return tuple(given)
    named = {os.path.normpath(folder / row["network"]) for row in rows if row.get("network")}
    beside = sort_files(files_in([folder / "networks"])).networks if _any(folder / "networks") else ()
    return tuple(dict.fromkeys([*(Path(one) for one in sorted(named)), *beside]))


def _any(folder: Path) -> bool:
    return folder.is_dir() and any(folder.iterdir())


def _row(
    recorded: Recorded, folder: Path, groups: Sequence[str], group: str, networks: Sequence[Path], period: float | None
) -> dict[str, str]:
    label = group or _told_group(recorded.files[0].absolute(), groups)
    network = _told_network(recorded, label, groups, networks)
    row = {
        "animal": _name(recorded.name),
        "group": label,
        "network": _seen_from(folder, network) if network else "",
        "recording": _seen_from(folder, recorded.files[0]),
        "kind": recorded.kind,
    }
    if len(recorded.files) == 2:
        row["flow"] = _seen_from(folder, recorded.files[1])
    if period is not None and recorded.kind != "raw":
        row |= {"period [s]": repr(period), "kind": "cycle"}
    return row | {f"{quantity} channel": title for quantity, title in recorded.channels.items()}


def _told_group(path: Path, groups: Sequence[str]) -> str:
    """Return the group by which a file is named, or else the innermost folder that is; empty if none or two are."""
    for part in (path.stem, *(one.name for one in path.parents)):
        said = words(part)
        hits = [label for label in groups if _within(words(label), said)]
        if len(hits) == 1:
            return hits[0]
        if hits:
            return max(hits, key=len) if all(_within(words(one), words(max(hits, key=len))) for one in hits) else ""
    return ""


def _within(few: Sequence[str], many: Sequence[str]) -> bool:
    """Whether the words of `few` stand in `many`, in one piece; a label may be written as the beginning of a word."""
    size = len(few)
    return size > 0 and any(list(many[i : i + size]) == list(few) for i in range(len(many) - size + 1))


def _told_network(recorded: Recorded, group: str, groups: Sequence[str], networks: Sequence[Path]) -> Path | None:
    """Return the network that carries an animal's name, stands beside it alone, carries its group, or is the only."""
    own = [one for one in networks if _within(words(recorded.name), words(one.stem))]
    of_group = [one for one in networks if group and _told_group(one.absolute(), groups) == group]
    return next((few[0] for few in (own, of_group, list(networks)) if len(few) == 1), None)


def _name(stem: str) -> str:
    """Return a file's stem as an animal's name: signs that a name cannot have become blanks."""
    plain = "".join(sign if sign.isalnum() or sign in " .,_+-()" else " " for sign in stem).strip(" .,_+-()")
    return checked_name(plain[:60] or "animal")


def _free_name(name: str, taken: Sequence[str]) -> str:
    used = {one.casefold() for one in taken}
    return next(
        one for n in range(1, len(used) + 2) if (one := name if n == 1 else f"{name} ({n})").casefold() not in used
    )


def _seen_from(folder: Path, file: Path) -> str:
    return Path(os.path.relpath(file.absolute(), folder.absolute())).as_posix()


def _missing(rows: Sequence[dict[str, str]], groups: Sequence[str], networks: Sequence[Path]) -> list[str]:
    said = []
    if lost := [row["animal"] for row in rows if not row["group"]]:
        said.append(f"no group is told by name or folder of {', '.join(lost)}; the study has {', '.join(groups)}: "
                    "give --group, or write it into the column 'group'")  # fmt: skip
    if lost := [row["animal"] for row in rows if not row["network"]]:
        why = f"none of {len(networks)} networks carries their name or group" if networks else "there is no network"
        said.append(f"{why}: {', '.join(lost)}; give --network, or write it into the column 'network'")
    return said


def _write(table: Path, titles: Sequence[str], rows: Sequence[dict[str, str]], new: Sequence[dict[str, str]]) -> None:
    """Write the table with the new rows below the old ones, comments at its head kept."""
    head = (
        [line for line in table.read_text("utf-8-sig").splitlines() if line.startswith("#")] if table.exists() else []
    )
    needed = [title for title in COLUMNS if title in titles or any(row.get(title) for row in new)]
    header = [*titles, *(title for title in needed if title not in titles)]
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(header)
    writer.writerows([row.get(title, "") for title in header] for row in [*rows, *new])
    write_file(table, "\n".join([*head, text.getvalue()]))
