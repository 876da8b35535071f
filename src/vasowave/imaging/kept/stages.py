"""Stages of an extraction in a folder: a value, what it was made of, and the warnings that came with it.

A stage is believed only if its key is the one asked for and its file is whole (see `runtime.kept`). Anything else is
made anew, in silence.
"""

import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

from vasowave.errors import VasowaveWarning
from vasowave.findings import Finding, as_json, found_in, from_json, warn
from vasowave.imaging.kept.packing import read_value, write_value
from vasowave.io.files import made_inside, not_written, remove_parts

T = TypeVar("T")
FOLDER = "stages"
_SUFFIX = ".stage"


class Stages:
    """The stages of one extraction.

    It changes while it is used, for what was made anew is written only once the whole extraction has succeeded.

    Parameters
    ----------
    parent : Path, optional
        The extraction's folder, in which they are kept in a folder of their own; without it nothing is kept.
    hold : bool, optional
        Whether values stay in memory too, so that asking again reads no file.
    """

    def __init__(self, parent: Path | None = None, hold: bool = False) -> None:
        self.parent, self.hold = parent, hold
        self._held: dict[str, tuple[str, Any, tuple[Finding, ...]]] = {}
        self._asked: set[str] = set()
        self._fresh: dict[str, tuple[str, Any, tuple[Finding, ...]]] = {}

    def kept(self, name: str, key: str, make: Callable[[], T]) -> T:
        """Return what `make` returns, and warn as it does; from the disk, if that stands there under `key`."""
        if self.parent is None:
            return make()
        self._asked.add(name)
        stored = self._read(name, key)
        if stored is None:
            value, notes = _made(make)
            self._fresh[name] = self._remembered(name, key, value, notes)
            return value
        value, notes = stored
        _warn(notes)
        return value

    def stored(self, name: str, key: str) -> Any:
        """Return what stands on the disk under `key`, an empty tuple if nothing does."""
        stored = self._read(name, key) if self.parent is not None else None
        return () if stored is None else stored[0]

    def keep(self, name: str, key: str, value: Any) -> None:
        """Keep a value that was made with the help of what was `stored`."""
        self._asked.add(name)
        self._fresh[name] = self._remembered(name, key, value, ())

    def save(self) -> None:
        """Write the stages that were made anew, each whole or not at all, and remove those that were not asked for.

        Raises
        ------
        InputError
            The folder cannot be written.
        """
        if self.parent is None:
            return
        folder = made_inside(self.parent, FOLDER)
        remove_parts(folder)
        for name, (key, value, notes) in self._fresh.items():
            try:
                write_value(folder / f"{name}{_SUFFIX}", key, (as_json(notes), value))
            except OSError as error:
                raise not_written(folder, error) from None
        for file in folder.glob(f"*{_SUFFIX}"):
            if file.stem not in self._asked:
                file.unlink()
        self._fresh.clear()

    def _read(self, name: str, key: str) -> tuple[Any, tuple[Finding, ...]] | None:
        """Return value and warnings of a stage; None where it is not there, not whole, or of something else."""
        assert self.parent is not None
        held = self._held.get(name)
        if held is not None and held[0] == key:
            return held[1:]
        try:
            notes, value = read_value(self.parent / FOLDER / f"{name}{_SUFFIX}", key)
            return self._remembered(name, key, value, from_json(notes))[1:]
        except Exception:  # whatever stands there, the stage can be made anew
            return None

    def _remembered(
        self, name: str, key: str, value: Any, notes: tuple[Finding, ...]
    ) -> tuple[str, Any, tuple[Finding, ...]]:
        if self.hold:
            self._held[name] = key, value, notes
        return key, value, notes


def forget_stages(parent: Path) -> None:
    """Remove what was kept in the extraction's folder `parent`."""
    folder = made_inside(parent, FOLDER)
    for file in folder.glob(f"*{_SUFFIX}"):
        file.unlink()
    if not any(folder.iterdir()):
        folder.rmdir()


def _made(make: Callable[[], T]) -> tuple[T, tuple[Finding, ...]]:
    """Return what `make` returns and what it warned of, having warned."""
    notes: tuple[Finding, ...] = ()
    try:
        with warnings.catch_warnings(record=True) as told:
            warnings.simplefilter("always", VasowaveWarning)
            value = make()
    finally:
        notes = found_in(told)
        _warn(notes)
    return value, notes


def _warn(notes: tuple[Finding, ...]) -> None:
    for note in notes:
        warn(note, stacklevel=4)
