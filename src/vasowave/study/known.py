"""The recordings that a table of animals has already: by place, by the name of a file that is gone, by content."""

import os
from collections.abc import Sequence
from pathlib import Path

from vasowave.errors import InputError
from vasowave.io.textfile import look
from vasowave.study.sorting import Recorded


class Known:
    """The recordings that the table has, by place, by the name of a file that is gone, and by content."""

    def __init__(self, folder: Path, rows: Sequence[dict[str, str]]) -> None:
        self.folder = folder
        files = [(folder / row["recording"], row) for row in rows if row.get("recording")]
        self.by_place = {file.resolve(): row for file, row in files}
        self.lost = {file.name: row for file, row in files if not file.exists()}
        self.by_content = {_digest(file): row["animal"] for file, row in files if file.is_file()}

    def row_of(self, recorded: Recorded) -> dict[str, str] | None:
        """Return the row of a recording; that of a file that is gone if it had the same name."""
        file = recorded.files[0]
        row = self.by_place.get(file.resolve())
        if row is None and file.name in self.lost:
            row = self.lost.pop(file.name)
            row["recording"] = seen_from(self.folder, file)
            if len(recorded.files) == 2:
                row["flow"] = seen_from(self.folder, recorded.files[1])
        return row

    def twin_of(self, recorded: Recorded) -> str:
        """Return the animal whose recording has the same bytes; else remember this one."""
        digest = _digest(recorded.files[0])
        if digest in self.by_content:
            return self.by_content[digest]
        self.by_content[digest] = recorded.files[0].name
        return ""


def _digest(file: Path) -> str:
    try:
        return look(file).sha256
    except InputError:
        return str(file)


def seen_from(folder: Path, file: Path) -> str:
    """Return the name of a file as the table writes it, whatever links lead to the folder or the file."""
    ways, real = [], folder.resolve()
    for place, start in ((file.absolute(), folder.absolute()), (file.absolute(), real), (file.resolve(), real)):
        try:
            ways.append(Path(os.path.relpath(place, start)))
        except ValueError:  # another drive
            continue
    right = (one for one in ways if (folder / one).exists() and (folder / one).samefile(file))
    return next(right, file.resolve()).as_posix()
