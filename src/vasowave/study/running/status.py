"""The progress of a study: what is kept of every animal, read from files of a run that may go on elsewhere."""

from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple

from vasowave.base.errors import InputError
from vasowave.pulse.calibration.starts import STAGE
from vasowave.pulse.inference.simulations import simulations_in
from vasowave.study.animal.failure import Failure
from vasowave.study.animal.files import failures_in
from vasowave.study.folder.places import RESULTS
from vasowave.study.folder.study import Study
from vasowave.study.results.loading import animal_key
from vasowave.study.results.results import INDEX, Results, read_results
from vasowave.study.results.store import CACHE, LOCK, SEARCHES, holder, read_journal
from vasowave.study.running.run_state import RunStatus, run_status

POSTERIOR = " posterior"


class AnimalStatus(NamedTuple):
    """The progress of one animal.

    Attributes
    ----------
    animal : str
    state : {"done", "begun", "waiting", "failed", "unreadable"}
        Finished and kept; some searches are kept; nothing is; the last run, which has ended, lost it; its files cannot
        be read.
    searches : dict of str to (int, int)
        For every wall law that was begun, searches that have ended and all of them; for its posterior (the law's name
        with `POSTERIOR`) the simulations so far and 0, since their number shows only as they are made.
    message : str
        Why it is unreadable or lost.
    failures : tuple of Failure
        What failed of an animal that is done.
    """

    animal: str
    state: str
    searches: dict[str, tuple[int, int]]
    message: str = ""
    failures: tuple[Failure, ...] = ()

    def __str__(self) -> str:
        """Return the state in words."""
        if self.state != "begun":
            failed = "".join(f"; failed: {failure}" for failure in self.failures)
            return f"{self.state}: {self.message}" if self.message else f"{self.state}{failed}"
        return ", ".join(stage(*search) for search in self.searches.items())


class StudyStatus(NamedTuple):
    """The progress of a study.

    Attributes
    ----------
    animals : tuple of AnimalStatus
    runner : str or None
        Who is running it now; None if nobody is.
    run : RunStatus or None
        How far that run is, or how the last one ended; None where none was begun.
    """

    animals: tuple[AnimalStatus, ...]
    runner: str | None
    run: RunStatus | None = None


def stage(name: str, counts: tuple[int, int]) -> str:
    """Return how far the fit or the posterior of a wall law is, in words."""
    done, count = counts
    return f"{name} {done} of {count} searches" if count else f"{name} {done} simulations"


def study_status(study: Study) -> StudyStatus:
    """Return how far a study is, and how its run goes or the last one ended.

    Animals whose files, settings or program changed since count as not begun. On a cluster without a common disk,
    searches are not kept: its animals are done, or waiting.

    Examples
    --------
    >>> import vasowave as vw
    >>> from pathlib import Path
    >>> vw.write_network(vw.control_network(), "lung.csv")
    >>> _ = Path("cycle.csv").write_text("time [s],pressure [mmHg],flow [ml/s]\\n")
    >>> _ = Path("animals.csv").write_text("animal,group,network,recording\\nmouse 6,CTL,lung.csv,cycle.csv\\n")
    >>> _ = Path("study.yaml").write_text("groups: [CTL]\\ncalibration: {walls: [linear], starts: 1}\\n")
    >>> found = vw.study_status(vw.read_study("study.yaml"))
    >>> found.animals[0].state, found.runner, found.run
    ('waiting', None, None)
    """
    statuses, runner = [], holder(study.results / LOCK)
    lost = _lost(study.results) if runner is None else {}
    for row in study.animals:
        try:
            key = animal_key(row, study.settings, study.folder)
        except InputError as error:
            statuses.append(AnimalStatus(row.animal, "unreadable", {}, str(error)))
        else:
            statuses.append(_status(row.animal, key, study.results, lost))
    return StudyStatus(tuple(statuses), runner, run_status(study.results))


OF_PAGE = ("title", "groups", "design", "report")
"""Settings of the page; the others enter the key of every animal."""


def outdated(study: Study, stored: Results) -> tuple[list[str], list[str]]:
    """Return the settings of the page, and the lab's own columns, that say something else than when it was run."""
    now, before = ({variable.label: variable for variable in source.variables} for source in (study, stored))
    columns = [label for label in {**before, **now} if now.get(label) != before.get(label)]
    return [name for name in OF_PAGE if getattr(study.settings, name) != getattr(stored.settings, name)], columns


def _lost(results: Path) -> dict[str, str]:
    """Return the animals that the last run lost, and why."""
    try:
        return {failure.animal: str(failure) for failure in read_results(results).lost}
    except InputError:
        return {}


def fit_status(folder: Path) -> StudyStatus | None:
    """Return how far the fit of one animal is whose results stand in a folder; None if it holds no fit.

    What a fit was started with is not written down before it ends, so its searches are those of all journals there.
    """
    results = folder / RESULTS
    if not results.is_dir():
        return None
    statuses = {}
    if (results / INDEX).is_file():
        statuses = {name: AnimalStatus(name, "done", {}) for name in read_results(folder)}
    runner = holder(results / LOCK)
    keys = sorted({path.stem for path in (results / SEARCHES).glob("*.jsonl")})
    begun = [searches for searches in (_searches(results, key) for key in keys) if searches]
    if begun and (runner or not statuses):
        statuses = {"animal": AnimalStatus(next(iter(statuses), "the animal"), "begun", begun[-1])}
    return StudyStatus(tuple(statuses.values()), runner, run_status(results))


def searches_of(results: Path, keys: Mapping[str, str]) -> dict[str, dict[str, tuple[int, int]]]:
    """Return, for every animal of `keys` that was begun, the searches that have ended and all, by wall law."""
    by_animal = {animal: _searches(results, key) for animal, key in keys.items()}
    return {animal: searches for animal, searches in by_animal.items() if searches}


def _status(animal: str, key: str, results: Path, lost: Mapping[str, str]) -> AnimalStatus:
    if piece := next((results / CACHE).glob(f"{key}-*.nc"), None):
        return AnimalStatus(animal, "done", {}, failures=failures_in(piece))
    searches = _searches(results, key)
    if animal in lost:
        return AnimalStatus(animal, "failed", searches, lost[animal])
    return AnimalStatus(animal, "begun" if searches else "waiting", searches)


def _searches(results: Path, key: str) -> dict[str, tuple[int, int]]:
    searches: dict[str, tuple[int, int]] = {}
    for end in read_journal(results / SEARCHES / f"{key}.jsonl"):
        before = searches.get(end.wall, (0, 0))[0]
        searches[end.wall] = (before + (end.stage == STAGE), end.starts)
    for path in sorted((results / SEARCHES).glob(f"{key}-*.npz")):
        if made := simulations_in(path):
            searches[path.stem.removeprefix(f"{key}-") + POSTERIOR] = (made, 0)
    return searches
