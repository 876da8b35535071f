"""One animal without a study file: its files and settings become a study of one."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path

import numpy as np
import xarray as xr

from vasowave.base.descriptions import parameter_mark
from vasowave.base.errors import InputError
from vasowave.base.findings import Finding, Place, Severity, sentence, texts
from vasowave.base.io.files import check_writable, remove_file
from vasowave.pulse.network_formats import NETWORKS
from vasowave.pulse.quantities import OF_ONE_ANIMAL
from vasowave.study.animal.law_result import LawResult
from vasowave.study.animal.result import AnimalResult
from vasowave.study.cohort.cohort import gathered
from vasowave.study.cohort.primary import Family
from vasowave.study.folder.animals import read_row
from vasowave.study.folder.names import checked_name
from vasowave.study.folder.places import RESULTS, STUDY_FILE
from vasowave.study.folder.problems import refuse
from vasowave.study.folder.rows import AnimalRow
from vasowave.study.folder.settings import StudyFile
from vasowave.study.folder.study import Study
from vasowave.study.report.answer.animal import animal_answers
from vasowave.study.report.answer.limits import assumed_errors
from vasowave.study.report.answer.marks import Marks
from vasowave.study.report.answer.problem_list import of_models
from vasowave.study.report.sections.models import MARKS
from vasowave.study.report.terms import caller
from vasowave.study.report.wording import symbols
from vasowave.study.results.loading import file_hashes
from vasowave.study.results.results import INDEX, read_results
from vasowave.study.results.store import CACHE, LOCK, SEARCHES
from vasowave.study.running.run_state import STATUS

_FOLDER = "is a folder; name one file of it, or make a study of all"
SENTENCE_QUANTITIES = Family(quantities=OF_ONE_ANIMAL)


def animal_alone(
    folder: Path,
    settings: StudyFile,
    network: Path,
    recordings: Sequence[Path],
    animal: str,
    cells: Mapping[str, str] | None = None,
) -> Study:
    """Return the study of one animal whose results will stand in `folder`.

    Parameters
    ----------
    folder : Path
        Made when the study runs; other files in it stay.
    settings : StudyFile
        With one group, the animal's.
    network : Path
    recordings : sequence of Path
        One file, or pressure and flow of one averaged cycle.
    animal : str
        Its name.
    cells : mapping of str to str, optional
        What else a table of animals would say of it, by the titles of its columns.

    Raises
    ------
    InputError
        `folder` is a file, cannot be written, or holds something else or the fit of another animal; a file of the
        animal is missing.
    """
    folder = Path(folder)
    _check_place(folder)
    row = one_row(network, recordings, animal, settings.groups[0], cells or {})
    _check_animal(folder, row)
    return Study(folder / STUDY_FILE, settings, (row,))


@contextmanager
def nothing_left(folder: Path) -> Iterator[None]:
    """Remove what a fit makes in a folder if it is refused before anything is computed; what stood there stays."""
    results = folder / RESULTS
    inner = [results / name for name in (CACHE, SEARCHES)]
    missing = [place for place in (*inner, results, folder, *folder.absolute().parents) if not place.exists()]
    try:
        yield
    except InputError:
        if results in missing and not any(place.is_dir() and any(place.iterdir()) for place in inner):
            for name in (STATUS, LOCK):
                remove_file(results / name)
            with suppress(OSError):  # of a place that holds something else by now
                for place in (place for place in missing if place.exists()):
                    place.rmdir()
        raise


def one_row(
    network: Path | None, recordings: Sequence[Path], animal: str, group: str, cells: Mapping[str, str]
) -> AnimalRow:
    """Return what a table of animals would say of one animal, whose further cells were given as options.

    Without a network its recording stands in its place, for whoever reads the recording alone.

    Raises
    ------
    InputError
        Everything that is wrong with them, with the option.
    """
    if len(recordings) > 2:
        raise InputError(f"{len(recordings)} files given; a recording is one file, or one of pressure and one of flow")
    is_alone, network = network is None, network or recordings[0]
    for file in (network, *recordings):
        if not file.is_file():
            raise InputError(f"{file}: {_FOLDER if file.is_dir() else 'there is no such file'}")
    are_networks = [NETWORKS.known(file) is not None for file in (network, *recordings)]
    if is_alone and any(are_networks):
        vessels = recordings[are_networks[1:].index(True)]
        raise InputError(f"{vessels} holds vessels; give the recording of pressure and flow")
    if not are_networks[0] and any(are_networks[1:]):
        raise InputError(
            f"{recordings[are_networks[1:].index(True)]} holds vessels, {network} does not: the network comes first"
        )
    files = dict(zip(("recording", "flow"), map(str, recordings), strict=False))
    cell = {"animal": checked_name(animal), "group": group, "network": str(network), **files, **cells}
    row, problems = read_row(cell, Path(), [group], option_of)
    refuse(problems)
    assert row is not None
    return row


def option_of(title: str) -> Place:
    """Return the option that stands for a column of the table of animals."""
    plain = title.partition(" [")[0]
    name, _, suffix = plain.rpartition(" ")
    return Place(part=f"--{suffix} {name}" if suffix in ("channel", "unit") else f"--{plain.replace(' ', '-')}")


def _check_place(folder: Path) -> None:
    if folder.exists() and not folder.is_dir():
        raise InputError(f"{folder} is a file; give the name of a folder")
    if (folder / STUDY_FILE).exists():
        raise InputError(f"{folder} is a study; add the animal to its table, or give another folder")
    earlier, results = folder / "results.nc", folder / RESULTS
    if earlier.exists():
        raise InputError(f"{earlier} is of an earlier version of vasowave; give another folder, or remove its result")
    if results.is_dir() and any(results.iterdir()) and not any((results / name).exists() for name in (INDEX, "cache")):
        raise InputError(f"{results} is not empty and not a vasowave result; give another folder or empty it first")
    check_writable(folder)


def _check_animal(folder: Path, row: AnimalRow) -> None:
    """Refuse to put one animal in another's place; a recording may change in its place, or be the same elsewhere."""
    try:
        (result,) = read_results(folder).in_order(whole=False)
    except (InputError, ValueError):  # nothing is there, or nothing whole
        return
    before, now = (
        str(text) for text in (result.origin.get("sha256 of recording", ""), file_hashes(row, folder)["recording"])
    )
    same = not set(before.split(" ", 1)).isdisjoint(now.split(" ", 1))  # the content, or the name
    if result.name != row.animal or (before and not same):
        raise InputError(
            f"{folder}: holds the fit of '{result.name}' from {before.partition(' ')[2] or 'another recording'}; "
            "give another folder with --output, or remove this one first"
        )


def fit_sentences(
    result: AnimalResult, warned: Sequence[Finding] = (), below: Callable[[Finding], str] = lambda finding: ""
) -> list[str]:
    """Return what a person at the terminal wants to know of an animal: problems, answers, fits, what to consider.

    What must not be used is said first, and numbers carry the marks that they have on the page; `below` returns what
    follows a finding, as the command that mends it.
    """
    cohort = gathered([result])
    called, written, answers = caller(cohort), symbols(cohort), list[tuple[str, str]]()
    for wall in result.laws:
        marks = Marks(cohort, wall)
        by_wall = animal_answers(result, wall, SENTENCE_QUANTITIES, called, marks)
        answers += [*by_wall, *marks.legend(by_wall, written)]
    doubts = {
        (finding.code, dict(finding.values)["site"]): finding
        for law in result.laws.values()
        for finding in law.site_doubts
    }
    sentences = [
        f"warning: {sentence(finding)} Do not use the numbers below before that is settled."
        for finding in doubts.values()
    ]
    sentences += [f"problem: {text}" for text in of_models(cohort, list(result.laws))]
    sentences += [f"warning: {sentence(finding)}{below(finding)}" for finding in warned]
    sentences += [f"{question}: {text}" for question, text in dict.fromkeys(answers)]
    sentences += assumed_errors([result]) if result.laws else []
    sentences += [_best(wall, law) for wall, law in result.laws.items()]
    doubt_codes = {code for code, _ in doubts}
    further_findings = sorted(
        (finding for finding in result.findings if finding not in warned and finding.code not in doubt_codes),
        key=lambda finding: finding.severity == Severity.NOTE,
    )
    return sentences + [
        f"{finding.severity}: {text}{below(finding)}"
        for finding, text in zip(further_findings, texts(further_findings), strict=True)
    ]


def _best(wall: str, law: LawResult) -> str:
    """Return the parameters of the best fit with their marks, what it leaves, and how many starts agree."""
    data = law.calibration
    values = ", ".join(_parameter(data.sel(parameter=name)) for name in data["parameter"].values)
    S, count, agree = float(data["S"]), int(data["N"]), int(np.sum(data["start_agrees"].values))
    meaning = [f" {text}" for text in MARKS.removesuffix(".").split("; ") if text[0] in values]
    agreeing = "1 start agrees" if agree == 1 else f"{agree} starts agree"
    return (
        f"best fit, {wall} wall: {values}; S {S:.4g} mmHg², N {count}, RMSE {law.rmse:.3g} mmHg, {agreeing}"
        f"{';' if meaning else ''}{','.join(meaning)}"
    )


def _parameter(parameter: xr.Dataset) -> str:
    unit, meaning = str(parameter["unit"].item()), str(parameter["meaning"].item())
    marked = parameter_mark(*(bool(parameter[name]) for name in ("free", "at_bound", "determined")))
    name, value = parameter["parameter"].item(), float(parameter["value"])
    return f"{name} {value:.4g}{marked} {f'({meaning})' if unit == '1' else unit}"
