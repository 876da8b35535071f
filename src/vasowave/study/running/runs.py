"""Do a study: every animal on all cores, what is already known from the store, then results, tables and report."""

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Executor
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from vasowave.base.errors import InputError
from vasowave.base.findings import Finding, look_kind, warn
from vasowave.base.io.files import made_inside, remove_parts
from vasowave.base.runtime.thread_limits import cores
from vasowave.pulse.model.law_files import files_of
from vasowave.study.animal.failure import Failure, Stage
from vasowave.study.animal.files import read_result, to_bytes
from vasowave.study.animal.pipeline import Progress as FitProgress
from vasowave.study.folder.settings import StudyFile, animal_settings
from vasowave.study.folder.study import Study
from vasowave.study.results.loading import analyze_animal, analyzed_bytes, animal_key, file_hashes, load_animal
from vasowave.study.results.physiology import looks_of, tell_blood
from vasowave.study.results.results import ANIMALS, read_results, write_results
from vasowave.study.results.store import SEARCHES, ResultStore, read_journal, remove_journals
from vasowave.study.running.engine import Job, Pools, Progress, run_jobs
from vasowave.study.running.executors import dask_cluster, process_pool
from vasowave.study.running.plan import declare
from vasowave.study.running.programs import refuse_unread
from vasowave.study.running.run_state import RunRecord, running

_CLUSTER_BATCH = 256  # animals that are handed to a cluster at once

NO_LONGER_THERE = look_kind(
    "run.animals-lost",
    "{animals}: in the results of the last run, but no longer in the table of animals; {remedy}",
    "if a line was lost, put it back and run again: nothing is computed twice",
)


@dataclass(frozen=True)
class Done:
    """The outcome of a run.

    Attributes
    ----------
    results : Path
        The index of the results.
    computed, kept : tuple of str
        Animals that were computed now, and that were known from earlier runs.
    resumed : tuple of str
        Animals among `computed` of which searches or simulations were kept from a run that was interrupted.
    failures : tuple of Failure
        What failed: whole animals, and wall laws of animals that have a result.
    warnings : dict of str to tuple of Finding
        What asks for a look at the recording or the network of an animal, by animals that have any.
    """

    results: Path
    computed: tuple[str, ...]
    kept: tuple[str, ...]
    failures: tuple[Failure, ...]
    warnings: Mapping[str, tuple[Finding, ...]]
    resumed: tuple[str, ...] = ()

    @property
    def lost(self) -> tuple[Failure, ...]:
        """The failures of whole animals."""
        return tuple(failure for failure in self.failures if failure.is_total)


def run_study(
    study: Study,
    *,
    executor: Executor | None = None,
    scheduler: str | None = None,
    workers: int | None = None,
    progress: Callable[[Progress], None] | None = None,
) -> Done:
    """Analyze every animal of a study and write its results.

    Finished animals are kept at once; after an interruption of any kind the next run goes on from there. What is kept
    is found by the content of everything that entered: bytes of the files, settings, program.

    Parameters
    ----------
    study : Study
    executor : Executor, optional
        Where to compute; it is not shut down. By default a pool of processes.
    scheduler : str, optional
        Address of a Dask scheduler to use instead.
    workers : int, optional
        Processes of the pool; by default one for every core.
    progress : callable, optional
        Called whenever an animal is done.

    Returns
    -------
    Done
        What failed stands in it and in the results.

    Warns
    -----
    VasowaveWarning
        The table no longer names an animal of the last results; density or viscosity are no blood's.

    Raises
    ------
    InputError
        Another run is going on in this study; a disk is full; the scheduler does not answer; every animal failed; the
        study names a program that nobody has allowed to run (see `trust_study`).

    Examples
    --------
    >>> import vasowave as vw
    >>> from concurrent.futures import ThreadPoolExecutor
    >>> from pathlib import Path
    >>> mouse = vw.virtual_mouse()
    >>> rows = (f"{t:.6f},{p:.6f},{q:.6f}" for t, p, q in zip(mouse.time, mouse.pressure, mouse.flow))
    >>> _ = Path("cycle.csv").write_text("\\n".join(["time [s],pressure [mmHg],flow [ml/s]", *rows, ""]))
    >>> vw.write_network(vw.control_network(), "lung.csv")
    >>> _ = Path("animals.csv").write_text("animal,group,network,recording\\nmouse 6,CTL,lung.csv,cycle.csv\\n")
    >>> _ = Path("study.yaml").write_text("groups: [CTL]\\ncalibration: {walls: [linear], starts: 1}\\n")
    >>> with ThreadPoolExecutor(1) as here:
    ...     done = vw.run_study(vw.read_study("study.yaml"), executor=here)
    >>> done.computed
    ('mouse 6',)
    """
    with running(study.folder, len(study.animals)) as run:
        return analyze_study(run, study, executor=executor, scheduler=scheduler, workers=workers, progress=progress)


def analyze_study(
    run: RunRecord,
    study: Study,
    *,
    executor: Executor | None = None,
    scheduler: str | None = None,
    workers: int | None = None,
    progress: Callable[[Progress], None] | None = None,
) -> Done:
    """Do what `run_study` does within a run that has begun (see `running`), to which its report belongs, too."""
    refuse_unread(study.settings, study.folder)
    _tell_lost(study)
    tell_blood(study.settings.blood)
    for place in (study.results, study.results / ANIMALS):
        remove_parts(place)  # of a run that was killed while it wrote its results
    store = ResultStore(study.results)
    pressures: dict[str, float] = {}
    pieces, jobs, reasons = _plan(study, store, pressures)
    kept_names = tuple(pieces)
    begun = {job.name for job in jobs if read_journal(study.results / SEARCHES / f"{job.key}.jsonl")}

    def show(step: Progress) -> None:
        over = step.done == step.count
        run.write(stage="writing the results" if over else "computing", done=step.done, left=step.left)
        if progress is not None:
            progress(step)
        run.go_on()

    def keep(job: Job, content: bytes) -> None:
        pieces[job.name] = store.keep(job.key, content)

    def shifted(step: Progress) -> None:
        show(replace(step, done=len(kept_names) + step.done, count=len(study.animals)))

    for number, name in enumerate(kept_names, 1):
        show(Progress(name, "kept", number, len(study.animals)))
    if jobs:
        laws = study.settings.calibration.walls
        run.write(stage="computing")
        pools, at_once, threads = _pools(executor, scheduler, workers, len(jobs), laws)
        reasons |= run_jobs(jobs, analyzed_bytes, keep, pools, at_once, threads, shifted)
    results, failures, warnings = _write(study, pieces, _lost(study, reasons, pressures))
    if not reasons:
        remove_journals(study.results)
    computed = tuple(job.name for job in jobs if job.name in pieces)
    resumed = tuple(name for name in computed if name in begun)
    done = Done(results, computed, kept_names, failures, warnings, resumed)
    run.write(message=f"{len(computed)} computed, {len(kept_names)} kept from earlier, {len(done.lost)} failed")
    return done


def run_alone(run: RunRecord, study: Study, progress: FitProgress | None = None) -> Done:
    """Analyze the one animal of a study in this process and write its results, within a run that has begun.

    After an interrupt (Ctrl-C) the results hold what the starts that had finished found, and say so; the next call
    computes the animal anew.

    Parameters
    ----------
    run : RunRecord
    study : Study
        Of one animal.
    progress : callable, optional
        As for `animal.analyze`.

    Warns
    -----
    VasowaveWarning
        Density or viscosity are no blood's.

    Raises
    ------
    InputError
        A file of the animal is wrong; the results cannot be written.
    """
    (row,) = study.animals
    tell_blood(study.settings.blood)
    run.write(stage="computing")
    store = ResultStore(study.results)
    pieces, jobs, reasons = _plan(study, store, {})
    if reasons:
        raise InputError(reasons[row.animal])
    for job in jobs:
        animal, settings, hashes, journal, key, laws = job.load()
        result = analyze_animal(animal, settings, hashes, journal, key, laws, progress)
        name = f"interrupted-{key}" if result.interrupted else key
        pieces[row.animal] = store.keep(name, to_bytes(result.to_datatree()))
        if not result.interrupted:
            remove_journals(study.results)
    results, failures, warnings = _write(study, pieces, ())
    computed = tuple(job.name for job in jobs)
    return Done(results, computed, () if computed else (row.animal,), failures, warnings)


def _outcome(piece: Path, settings: StudyFile) -> tuple[tuple[Failure, ...], tuple[Finding, ...]]:
    """Return what failed of an animal that is stored, and what must be looked at; opening its file takes most of it."""
    try:
        result = read_result(piece, laws=False)
    except InputError:  # a file that was damaged since is told by whoever reads it whole
        return (), ()
    return result.failures, looks_of(result, settings.species)


def _tell_lost(study: Study) -> None:
    """Warn of animals that the last results hold and the table no longer names: nothing else misses a lost line."""
    try:
        before = read_results(study.results)
    except InputError:
        return
    lost = [name for name in before if name not in {row.animal for row in study.animals}]
    if lost:
        warn(NO_LONGER_THERE(animals=", ".join(lost)).at(str(study.path)), stacklevel=4)


def _lost(study: Study, reasons: Mapping[str, str], pressures: Mapping[str, float]) -> list[Failure]:
    """Return the animals that have no result, in the order of the table; one whose pressure is known was read."""
    stages = {name: Stage.COMPUTING if name in pressures else Stage.READING for name in reasons}
    return [
        Failure(row.animal, row.group, "", stages[row.animal], reasons[row.animal], pressures.get(row.animal))
        for row in study.animals
        if row.animal in reasons
    ]


def _write(
    study: Study, pieces: Mapping[str, Path], lost: Sequence[Failure]
) -> tuple[Path, tuple[Failure, ...], dict[str, tuple[Finding, ...]]]:
    """Write the results from the pieces, in the order of the table; returns index, failures and looks by animal."""
    if not pieces:
        listed = "\n".join(f"  {failure.animal}: {failure.reason}" for failure in lost)
        raise InputError(f"{study.path}: every animal failed\n{listed}")
    stored = {(row.animal, row.group): pieces[row.animal] for row in study.animals if row.animal in pieces}
    summaries = {name: _outcome(piece, study.settings) for (name, _), piece in stored.items()}
    failures = (*lost, *(failure for failed, _ in summaries.values() for failure in failed))
    index = write_results(study.results, stored, failures, study.settings, study.variables, declare(study))
    return index, failures, {name: looks for name, (_, looks) in summaries.items() if looks}


def _plan(
    study: Study, store: ResultStore, pressures: dict[str, float]
) -> tuple[dict[str, Path], list[Job], dict[str, str]]:
    """Return the animals that are known already, those to compute, and those whose files cannot be read, with why.

    Of every animal that is read for its computation, `pressures` gets the measured mean pressure, mmHg.
    """
    pieces: dict[str, Path] = {}
    jobs: list[Job] = []
    reasons: dict[str, str] = {}
    journals = made_inside(study.results, SEARCHES)
    for row in study.animals:
        try:
            key = animal_key(row, study.settings, study.folder)
        except InputError as error:
            reasons[row.animal] = str(error)
            continue
        piece = store.find(key)
        if piece is not None:
            pieces[row.animal] = piece
            continue

        def load(row: Any = row, key: str = key) -> tuple[Any, ...]:
            animal, hashes = load_animal(row, study.settings, study.folder), file_hashes(row, study.folder)
            settings = animal_settings(study.settings, row)
            if animal_key(row, study.settings, study.folder) != key:
                raise InputError("its files changed while they were being read; run again")
            pressures[row.animal] = animal.recording.mean_pressure
            return (
                animal,
                settings,
                hashes,
                str(journals / f"{key}.jsonl"),
                key,
                files_of((*settings.walls, settings.beds)),
            )

        jobs.append(Job(row.animal, key, load))
    return pieces, jobs, reasons


def _pools(
    executor: Executor | None, scheduler: str | None, workers: int | None, jobs: int, laws: Sequence[str]
) -> tuple[Pools, int, int | None]:
    """Return what gives executors, how many jobs to hand out at once, and the threads of each."""
    if executor is not None:
        return lambda count: nullcontext(executor), _CLUSTER_BATCH, None
    if scheduler is not None:
        return lambda count: dask_cluster(scheduler), _CLUSTER_BATCH, 1
    at_once = max(1, min(workers or cores(), jobs))
    threads = max(1, cores() // at_once)

    def pools(count: int) -> AbstractContextManager[Executor]:
        return process_pool(count, threads, laws)

    return pools, at_once, threads
