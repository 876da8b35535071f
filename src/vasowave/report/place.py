"""Putting a finished report into its folder, whole or not at all."""

import os
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from vasowave.errors import InputError


@contextmanager
def placing(folder: Path) -> Iterator[Path]:
    """Give an empty folder to fill; at the end move what is in it into `folder`, each file or folder in one step.

    ``report.html`` comes last, so that a page never speaks of figures that are not there yet. If anything goes wrong
    before the first move, `folder` stays as it was.

    Raises
    ------
    InputError
        `folder` cannot be written.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(prefix=".report-", dir=folder) as name:
            fresh = Path(name) / "new"
            fresh.mkdir()
            yield fresh
            for item in sorted(fresh.iterdir(), key=lambda path: path.suffix == ".html"):
                _move(item, folder / item.name, Path(name))
    except OSError as error:
        raise InputError(
            f"{folder}: the report cannot be written ({error.strerror or error}); choose another place or make room"
        ) from error


def _move(item: Path, target: Path, aside: Path) -> None:
    if target.is_dir() and not target.is_symlink():
        os.replace(target, aside / f"old-{target.name}")
    os.replace(item, target)
    shutil.rmtree(aside / f"old-{target.name}", ignore_errors=True)
