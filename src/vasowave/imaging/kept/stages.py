"""Stages of an extraction in a folder: a value, what it was made of, and the warnings that came with it.

A stage is believed only if its key, a digest of everything that it depends on, is the one asked for and its file is
whole (every part of it carries a check sum). Anything else is made anew, in silence: what is kept saves time only.
"""

import json
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from vasowave.errors import VasowaveWarning
from vasowave.files import made_inside, write_folder
from vasowave.imaging.kept.packing import packed, unpacked

T = TypeVar("T")
FOLDER = "stages"
_SUFFIX = ".npz"


class Stages:
    """The stages of one extraction.

    It changes while it is used, for what was made anew is written only once the whole extraction has succeeded.

    Parameters
    ----------
    parent : Path, optional
        The extraction's folder, in which they are kept in a folder of their own; without it nothing is kept.
    """

    def __init__(self, parent: Path | None = None) -> None:
        self.parent = parent
        self._asked: set[str] = set()
        self._fresh: dict[str, tuple[str, Any, tuple[str, ...]]] = {}

    def kept(self, name: str, key: str, make: Callable[[], T]) -> T:
        """Return what `make` returns, and warn as it does; from the disk, if that stands there under `key`."""
        if self.parent is None:
            return make()
        self._asked.add(name)
        found = self._read(name, key)
        if found is None:
            with warnings.catch_warnings(record=True) as told:
                warnings.simplefilter("always", VasowaveWarning)
                try:
                    value = make()
                finally:
                    notes = tuple(str(one.message) for one in told if issubclass(one.category, VasowaveWarning))
                    _warn(notes)
            self._fresh[name] = key, value, notes
            return value
        value, notes = found
        _warn(notes)
        return value

    def save(self) -> None:
        """Write the stages that were made anew, whole or not at all, and remove those that were not asked for.

        Raises
        ------
        InputError
            The folder cannot be written.
        """
        if self.parent is None:
            return
        folder = made_inside(self.parent, FOLDER)
        with write_folder(folder) as part:
            for name, (key, value, notes) in self._fresh.items():
                plain, arrays = packed(value)
                arrays["head"] = np.array(json.dumps({"key": key, "notes": notes, "value": plain}))
                np.savez(part / f"{name}{_SUFFIX}", allow_pickle=False, **arrays)
        for file in folder.glob(f"*{_SUFFIX}"):
            if file.stem not in self._asked:
                file.unlink()
        self._fresh.clear()

    def _read(self, name: str, key: str) -> tuple[Any, tuple[str, ...]] | None:
        """Return value and warnings of a stage; None where it is not there, not whole, or of something else."""
        assert self.parent is not None
        try:
            with np.load(self.parent / FOLDER / f"{name}{_SUFFIX}", allow_pickle=False) as file:
                head = json.loads(str(file["head"]))
                return (unpacked(head["value"], file), tuple(head["notes"])) if head["key"] == key else None
        except Exception:  # whatever stands there, the stage can be made anew
            return None


def _warn(notes: tuple[str, ...]) -> None:
    for note in notes:
        warnings.warn(note, VasowaveWarning, stacklevel=4)
