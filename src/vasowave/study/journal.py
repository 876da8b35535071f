"""The journal of one animal: every search of its fits as it ends, so that a run that was killed goes on from there.

One line of JSON an end, with a check sum. A line that was cut off by a kill or damaged since counts for nothing: its
search is made again. Whoever watches a run reads the journals of the animals that are being computed.
"""

import json
import re
import threading
import zlib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from vasowave.calibration import SearchEnd

FOLDER = "searches"
"""Folder of the journals, in that of the results."""


class Journal:
    """The file of one animal; made when the first search ends.

    Parameters
    ----------
    path : Path
        Its folder exists on this machine, or nothing is kept (a cluster without a common disk).
    """

    def __init__(self, path: Path) -> None:
        self.path, self._lock = path, threading.Lock()
        self.known = {(one["wall"], one["stage"], one["start"]): _found(one) for one in read_journal(path)}

    def of(self, wall: str, starts: int) -> "WallEnds":
        """Return where the ends of the searches of one wall law are found and kept."""
        return WallEnds(self, wall, starts)

    def simulations(self, wall: str) -> Path | None:
        """Return the file that keeps the simulations of the posterior of one wall law, if its folder is here."""
        name = re.sub(r"\W", "_", wall)
        return self.path.with_name(f"{self.path.stem}-{name}.npz") if self.path.parent.is_dir() else None

    def write(self, entry: Mapping[str, Any]) -> None:
        """Add an end; what cannot be written is not kept, and the work goes on."""
        text = json.dumps(entry)
        with self._lock:
            try:
                torn = self.path.exists() and not self.path.read_bytes().endswith(b"\n")
                with self.path.open("a", encoding="utf-8") as file:
                    file.write("\n" * torn + f"{_check(text):08x} {text}\n")
            except OSError:
                return


class WallEnds:
    """The ends of the searches with one wall law, see `calibration.calibrate`."""

    def __init__(self, journal: Journal, wall: str, starts: int) -> None:
        self.journal, self.wall, self.starts = journal, wall, starts

    def find(self, stage: str, start: int) -> SearchEnd | None:
        """Return where the search of a stage from a start ended, if that is known."""
        return self.journal.known.get((self.wall, stage, start))

    def keep(self, stage: str, start: int, end: SearchEnd) -> None:
        """Keep where the search of a stage from a start ended."""
        entry = {"wall": self.wall, "stage": stage, "start": start, "starts": self.starts} | vars(end)
        self.journal.write(entry | {"x": end.x.tolist(), "residual": end.residual.tolist()})


def read_journal(path: Path) -> list[dict[str, Any]]:
    """Return the whole lines of a journal, in order; none where there is no journal."""
    try:
        lines = path.read_text("utf-8", errors="replace").splitlines()
    except OSError:
        return []
    split = (line.partition(" ") for line in lines)
    return [json.loads(text) for check, _, text in split if check == f"{_check(text):08x}"]


def remove_journals(folder: Path) -> None:
    """Remove the journals of animals that are done."""
    for kind in ("*.jsonl", "*.npz"):
        for path in (folder / FOLDER).glob(kind):
            path.unlink(missing_ok=True)


def _found(entry: Mapping[str, Any]) -> SearchEnd:
    values = {name: entry[name] for name in ("S", "simulations", "converged", "message", "joined")}
    return SearchEnd(x=np.array(entry["x"]), residual=np.array(entry["residual"]), **values)


def _check(text: str) -> int:
    return zlib.crc32(text.encode())
