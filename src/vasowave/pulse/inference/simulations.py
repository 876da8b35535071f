"""Simulations that are kept as they are made, so that a run that was killed goes on where it stopped."""

import io
import random
import zipfile
from collections.abc import Callable
from pathlib import Path

import numpy as np

from vasowave.base.errors import InputError
from vasowave.base.findings import look_kind, warn
from vasowave.base.io.files import check_home, write_file
from vasowave.base.io.textfile import regular_file
from vasowave.base.stores import stored

Simulate = Callable[[np.ndarray], np.ndarray]
"""Maps points (point, unknown) to outputs (point, output); a row of NaN where a point cannot be simulated."""

NOT_KEPT = look_kind(
    "posterior.simulations-not-kept",
    "simulations that an interrupted run had kept do not come out again ({count}), and were made anew; {remedy}",
    "look who else writes into results/searches; nothing of it is in these results",
)
_READ_ERRORS = (
    InputError,
    OSError,
    ValueError,
    KeyError,
    EOFError,
    MemoryError,
    NotImplementedError,
    RuntimeError,
    zipfile.BadZipFile,
)
"""Fmt: skip."""
_RECHECKED_SIMULATIONS = 8  # of the simulations that were kept, by chance
_MAX_REPEAT_ERROR = 1e-3  # mmHg, and share of an output, by which they may differ from those made here
_SIMULATIONS_PER_WRITE = 32  # simulations between two writes of the file: less than a second of work, more than a write


class Simulations:
    """Outputs at points, computed once each.

    It remembers, which is its purpose: every random choice of a run follows from its seed, so that a run that starts
    again asks for the same points and finds them here.

    Parameters
    ----------
    simulate : callable
    path : Path, optional
        File in which outputs are kept. One that belongs to another problem is refused.
    key : str
        Stands for everything that enters a simulation.
    progress : callable, optional
        Called with the number of points asked for so far.
    """

    def __init__(
        self,
        simulate: Simulate,
        path: Path | None = None,
        key: str = "",
        progress: Callable[[int], None] | None = None,
    ) -> None:
        self._simulate, self._path, self._key, self._progress = simulate, path, key, progress
        self._known: dict[bytes, np.ndarray] = {} if path is None or not path.exists() else read_simulations(path, key)
        if not self._come_again():
            warn(NOT_KEPT(count=len(self._known)))
            self._known = {}
        self.asked: int = 0
        self.computed: int = 0

    def __call__(self, points: np.ndarray) -> np.ndarray:
        """Return the outputs at points, shape (point, output)."""
        points = np.ascontiguousarray(points, dtype=float)
        missing = [point for point in points if point.tobytes() not in self._known]
        self.asked += len(points) - len(missing)
        for first in range(0, len(missing), _SIMULATIONS_PER_WRITE):
            batch = np.array(missing[first : first + _SIMULATIONS_PER_WRITE])
            for point, output in zip(batch, self._simulate(batch), strict=True):
                self._known[point.tobytes()] = output
            self.asked += len(batch)
            self.computed += len(batch)
            self._save()
            if self._progress is not None:
                self._progress(self.asked)
        return np.array([self._known[point.tobytes()] for point in points])

    def _come_again(self) -> bool:
        """Whether some of what was kept, which nobody can foresee, are the same when they are simulated here."""
        tried = random.SystemRandom().sample(sorted(self._known), min(_RECHECKED_SIMULATIONS, len(self._known)))
        if not tried:
            return True
        again, stored = self._simulate(np.array(list(map(np.frombuffer, tried)))), [self._known[key] for key in tried]
        return again.shape == np.shape(stored) and np.allclose(
            stored, again, _MAX_REPEAT_ERROR, _MAX_REPEAT_ERROR, equal_nan=True
        )

    def _save(self) -> None:
        if self._path is None:
            return
        points = np.array([np.frombuffer(key) for key in self._known])
        content = io.BytesIO()
        np.savez(content, key=np.array(self._key), points=points, outputs=np.array(list(self._known.values())))
        check_home(self._path, 2)
        write_file(self._path, content.getvalue())


def simulations_in(path: Path) -> int:
    """Return how many simulations a file holds; 0 if it cannot be read, as when it is damaged or just removed."""
    try:
        with regular_file(path).open("rb") as file, np.load(file, allow_pickle=False) as archive:
            return len(archive["points"])
    except _READ_ERRORS:
        return 0


@stored("simulations of a posterior", "results/searches/*.npz")
def read_simulations(path: Path, key: str) -> dict[bytes, np.ndarray]:
    """Return the outputs at points by the bytes of the points.

    Raises
    ------
    InputError
        A file that is none, is damaged, or is of another problem than `key`.
    """
    try:
        with regular_file(path).open("rb") as file, np.load(file, allow_pickle=False) as archive:
            stored_key, points, outputs = str(archive["key"]), archive["points"], archive["outputs"]
        if points.ndim != 2 or len(points) != len(outputs) or not points.dtype == outputs.dtype == float:
            raise ValueError("no outputs at points")
    except _READ_ERRORS:
        raise InputError(f"{path}: not a file of simulations, or damaged; remove it or give another path") from None
    if stored_key != key:
        raise InputError(f"{path} holds simulations of another problem; remove it or give another path")
    return {point.tobytes(): output for point, output in zip(points, outputs, strict=True)}
