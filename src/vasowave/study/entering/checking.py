"""Say everything that is wrong or odd about a study before it is run. Nothing is simulated and nothing is fitted."""

import warnings
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from vasowave.base.cures import UNKNOWN, RemoveAnimal, SetCells, SetSetting
from vasowave.base.errors import InputError, VasowaveError, VasowaveWarning, did_you_mean
from vasowave.base.findings import ITSELF, Finding, FindingKind, Place, Severity, Value, error_kind, kind, look_kind
from vasowave.base.io.remembered import made_once
from vasowave.base.io.textfile import look
from vasowave.base.sites import PULMONARY
from vasowave.catheter.signals.same_signal import PressureTrace, are_of_one, trace_of
from vasowave.pulse.calibration.parameters import ParameterLimits, fitted_parameters, parameter_space
from vasowave.pulse.cycle.cycle import Recording
from vasowave.pulse.model.law_files import files_of, is_unread, looking_in, plain
from vasowave.pulse.model.laws import find_bed, find_law
from vasowave.pulse.model.nominal import Nominal, estimate_nominal
from vasowave.pulse.quantities import INDICES, QUANTITIES, question_of
from vasowave.study.animal.animal import Animal, Settings
from vasowave.study.entering.breath_ends import different_breaths
from vasowave.study.entering.table import read_rows
from vasowave.study.folder.animals import read_half_row
from vasowave.study.folder.designing import understood
from vasowave.study.folder.problems import StudyProblem, one_per_cause, unreadable
from vasowave.study.folder.reading import Document, read_document
from vasowave.study.folder.rows import AnimalRow
from vasowave.study.folder.settings import StudyFile, animal_settings
from vasowave.study.folder.study import Study
from vasowave.study.results.loading import animal_key, load_animal, read_measured
from vasowave.study.results.overview import AnimalRead, read_of
from vasowave.study.results.physiology import blood_findings, physiology_findings
from vasowave.study.running.plan import inspect_study
from vasowave.study.running.programs import without_unread

_SAME_RANGE_SHARE = 1e-3  # of their range: two heartbeats never agree as well, one written with fewer digits does
_MAX_VALUE_RATIO = 3.0  # a known value that differs by more than this factor is no other method, but another number


PROGRAM = look_kind(
    "check.program", "a wall law or bed runs the program {file}; {remedy}", "read it, if it is not yours"
)
NO_PARAMETER = look_kind("check.no-parameter", "{key}: no parameter of the {laws} wall", "Remove the line.")
BOUNDS_OF_FIXED = look_kind(
    "check.bounds-of-fixed", "{key}: is fixed, so these bounds have no meaning", "Remove the bounds or the fixed value."
)
NOT_FITTED = error_kind(
    "check.law-not-fitted",
    "{key}: '{law}' is none of calibration.walls; {remedy}",
    "choose one that is fitted: {walls}",
    SetSetting("Choose the law", "report.law"),
)
NO_QUANTITY = look_kind(
    "check.no-quantity", "{key}: no animal will have '{name}'{hint}", "Correct its name, or remove it."
)
_GIVE_WEDGE = SetCells("Give its wedge pressure", (("wedge [mmHg]", UNKNOWN),))
WEDGE_OF_SOME = look_kind(
    "check.wedge-of-some",
    "{count} of {all} recordings have a wedge pressure; in the others PVR and R_T count from 0, which alone "
    "can make groups differ",
    "Give the wedge of every recording, or of none.",
)
WEDGE_OF_NONE = look_kind(
    "check.wedge-of-none",
    "no recording has a wedge pressure, in a {species} often a third of the mean pressure: PVR and R_T count from 0, "
    "are too large, and differ less between groups than they should",
    "Give the wedge of every recording, or say with the results that it was not measured.",
    _GIVE_WEDGE,
)
WEDGE_ASSUMED = kind(
    "check.wedge-assumed",
    Severity.NOTE,
    "no recording has a wedge pressure: PVR, R_T and the measured decay are over an assumed outflow pressure of "
    "0 mmHg; {remedy}",
    "say so with the results, or give the wedge pressure where it was measured",
    _GIVE_WEDGE,
)
UNNAMED = kind(
    "check.no-primary-quantity",
    Severity.NOTE,
    "{count} quantities are tested together, so that each must differ by more to be shown; {remedy}",
    "if one is the question, name it before anybody sees results: a p of one that was chosen afterwards does not hold",
    SetSetting("Name the question", "report.quantities", f"[{UNKNOWN}]"),
)
_WEDGED_SPECIES = "dog", "pig", "human"  # whose right hearts are catheterized with a balloon
PAPER_BOUNDS = look_kind(
    "check.paper-bounds",
    "{key}: some optima that the paper prints lie outside its own bounds of β and c1; {remedy}",
    "expect parameters that end at a bound",
)
FEW_STARTS = look_kind(
    "check.few-starts",
    "{key}: {starts} starts now and then miss the tangent wall's best optimum; {remedy}",
    "20 seldom do",
    SetSetting("20 starts", "calibration.starts", "20"),
)
EXPONENT = look_kind(
    "check.known-differs",
    "{name} {given:.4g} {unit} as given, {expected:.4g} from the {source}: a factor of {factor:.3g}",
    "Check the exponent and the unit of the cell.",
)
BOUNDS = error_kind("check.bounds", "'{name}': {text}", ITSELF)
NOMINAL_EXCLUDED = error_kind(
    "check.nominal-excluded",
    "'{name}': the bounds of {parameter}, {low:.4g} to {high:.4g}{unit}, exclude the nominal value of this animal, "
    "{value:.4g}{unit}; {remedy}",
    "widen them",
)
_ONE_OF_TWO = (
    "remove one of the two rows, or, if two animals are meant to share it, write yes into the column 'shared "
    "recording' of both"
)
_SHARED = SetCells("Both are meant to share it", (("shared recording", "yes"),)), RemoveAnimal()
SAME_RECORDING = error_kind(
    "check.same-recording", "the same recording as '{other}' (line {at}); {remedy}", _ONE_OF_TWO, *_SHARED
)
SAME_VENTRICLE = error_kind(
    "check.same-ventricle",
    "the same pressure in the ventricle as '{other}' (line {at}); {remedy}",
    _ONE_OF_TWO,
    *_SHARED,
)
SAME_LOOPS = error_kind(
    "check.same-loops",
    "the same loops of pressure and volume as '{other}' (line {at}); {remedy}",
    _ONE_OF_TWO,
    *_SHARED,
)
SAME_CYCLE = error_kind(
    "check.same-cycle", "its averaged cycle is that of '{other}' (line {at}); {remedy}", _ONE_OF_TWO, *_SHARED
)
SAME_SIGNAL = error_kind(
    "check.same-signal",
    "its pressure is in that of '{other}' (line {at}), written anew; {remedy}",
    _ONE_OF_TWO,
    *_SHARED,
)


class Checked(NamedTuple):
    """The problems in the order of the files, what was read of every animal whose files are in order, the design in
    words, if it is in order, and what is assumed where the study says nothing.
    """

    problems: list[StudyProblem]
    read: list[AnimalRead]
    settings: StudyFile | None
    design: str = ""
    notes: tuple[StudyProblem, ...] = ()


def check_study(path: Path) -> Checked:
    """Return everything that is wrong or odd, and what was read.

    Reads the study file, the table of animals and every file that it names, averages the beats of continuous
    recordings and makes the closed-form estimates of the nominal parameters.

    Raises
    ------
    InputError
        There is no study file.
    """
    study, problems = inspect_study(path)
    if study is None:
        return Checked(one_per_cause(problems), [], None)
    design = understood(study, complete=not any(problem.error and problem.place.line for problem in problems))
    document, read, animals = read_document(study.path), [], []
    problems += _programs(study, document)
    named, study = study, replace(study, settings=without_unread(study.settings, study.folder))
    problems += _settings(study, document)
    for row in study.animals:
        place = Place(str(study.table), row.line, animal=row.animal)
        try:
            loaded = _loaded(row, study)
            problems += _animal(study, row, loaded.animal, document, place)
            read.append(loaded.read)
            animals.append((row, loaded))
        except VasowaveError as error:
            problems.append(unreadable(error, place, row.files.values()))
    problems += [*_unwedged(study), *_unnamed(study, document)]
    problems += _half_known(study)
    problems += different_breaths(study, [(row, loaded.animal.recording) for row, loaded in animals])
    problems += _once([*doubled_animals(study), *_alike(study, animals), *_of_one_recording(study, animals)])
    notes = tuple(problem for problem in problems if problem.finding.severity is Severity.NOTE)
    wrong = [problem for problem in problems if problem not in notes]
    return Checked(one_per_cause(wrong), read, named.settings, design, notes)


def _unwedged(study: Study) -> list[StudyProblem]:
    """Return what is to be said of recordings without a pressure behind the vascular beds."""
    wedged = [row for row in study.animals if row.wedge is not None or row.wedge_wave is not None]
    species, place = study.settings.species, Place(str(study.table), part="column 'wedge [mmHg]'")
    if wedged and len(wedged) < len(study.animals):
        return [StudyProblem(WEDGE_OF_SOME(count=len(wedged), all=len(study.animals)).placed(place))]
    if not study.animals or wedged or study.settings.site != PULMONARY:
        return []
    finding = WEDGE_OF_NONE(species=species) if species in _WEDGED_SPECIES else WEDGE_ASSUMED()
    return [StudyProblem(finding.placed(place))]


def _unnamed(study: Study, document: Document) -> list[StudyProblem]:
    """Return the offer to name one quantity as the question, where groups are compared by all at once."""
    if len({row.group for row in study.animals}) < 2 or study.settings.report.stated:
        return []
    finding = UNNAMED(count=len(study.settings.report.quantities))
    return [StudyProblem(finding.placed(document.place(("report",), key=True)))]


class _Loaded(NamedTuple):
    """One animal without its samples, what was read of it, by what it is compared with others, and the key of all that
    decides about them.
    """

    animal: Animal
    read: AnimalRead
    trace: PressureTrace | None
    key: tuple[str, ...]


def _loaded(row: AnimalRow, study: Study) -> _Loaded:
    """Return what the files of an animal hold, read once for as long as row, settings and files stay as they are.

    Raises
    ------
    VasowaveError
        A file is wrong, or its beats cannot be averaged.
    """

    def key() -> tuple[str, ...]:
        return str(study.folder), *map(str, row.files.values()), animal_key(row, study.settings, study.folder)

    def load() -> _Loaded:
        before, animal = key(), load_animal(row, study.settings, study.folder)
        if key() != before:
            raise InputError("its files changed while they were being read; check again")
        trace = None if animal.raw is None else trace_of(animal.raw, animal.recording.heart_rate)
        return _Loaded(replace(animal, raw=None, beats=None), read_of(animal), trace, before)

    return made_once(key, load)


def _half_known(study: Study) -> list[StudyProblem]:
    """Return which recordings cannot be read of rows whose network or group is still to be filled in."""
    try:
        rows = read_rows(study.table).rows
    except InputError:  # which the table's own reader says
        return []
    problems = []
    for cells in rows:
        if not (cells.get("network") and cells.get("group")) and cells.get("recording"):
            place = Place(str(study.table), animal=cells["animal"])
            row, _ = read_half_row(cells, study.folder, study.settings.groups)
            if row is None:
                continue
            try:
                with warnings.catch_warnings():
                    warnings.simplefilter("ignore", VasowaveWarning)
                    read_measured(row, study.settings)
            except VasowaveError as error:
                problems.append(unreadable(error, place, row.files.values()))
    return problems


def _programs(study: Study, document: Document) -> list[StudyProblem]:
    """Return which files beside the study are run as programs."""
    place, fitted = document.place(("calibration", "walls")), study.settings.calibration
    with looking_in(study.folder):
        files = files_of(law for law in (*fitted.walls, fitted.beds) if not is_unread(law))
    return [StudyProblem(PROGRAM(file=str(file.path)).placed(place)) for file in files]


def _settings(study: Study, document: Document) -> list[StudyProblem]:
    """Return what is odd about the settings by themselves."""
    calibration, problems = study.settings.calibration, []

    def note(finding_kind: FindingKind, *keys: str, **values: Value) -> None:
        problems.append(StudyProblem(finding_kind(key=".".join(keys), **values).placed(document.place(keys, key=True))))

    laws = " and ".join(map(plain, calibration.walls))
    kind = calibration.beds, calibration.viscous
    names = {name for wall in calibration.walls for name in fitted_parameters(wall, *kind)}
    for section, section_values in (("bounds", calibration.bounds), ("fixed", calibration.fixed)):
        for name in sorted(set(section_values) - names):
            note(NO_PARAMETER, "calibration", section, name, laws=laws)
    for name in sorted(set(calibration.bounds) & set(calibration.fixed)):
        note(BOUNDS_OF_FIXED, "calibration", "bounds", name)
    law, walls = study.settings.report.law, list(map(plain, calibration.walls))
    if law and law not in {*calibration.walls, *walls, *(find_law(wall).law().name for wall in calibration.walls)}:
        note(NOT_FITTED, "report", "law", law=law, walls=", ".join(walls))
    known_names = names | set(QUANTITIES) | set(INDICES)
    for name in study.settings.report.quantities:
        if name not in known_names and question_of(name) == name:
            note(NO_QUANTITY, "report", "quantities", name=name, hint=did_you_mean(name, known_names))
    if calibration.paper_bounds:
        note(PAPER_BOUNDS, "calibration", "paper_bounds")
    if calibration.starts < 10 and "tangent" in calibration.walls:
        note(FEW_STARTS, "calibration", "starts", starts=calibration.starts)
    for finding in blood_findings(study.settings.blood):
        place = document.place(("blood", str(dict(finding.values)["quantity"])), key=True)
        problems.append(StudyProblem(finding.placed(place)))
    return problems


def _animal(study: Study, row: AnimalRow, animal: Animal, document: Document, place: Place) -> list[StudyProblem]:
    """Return what is wrong or odd about what the files of one animal hold."""
    settings = animal_settings(study.settings)
    nominal = estimate_nominal(animal.network, animal.recording, settings.blood, find_bed(settings.beds))
    values = animal.recording.indices() | {"root radius": float(animal.network.radius[animal.network.root])}
    findings = [
        *(finding for finding in animal.recording.notes if finding.severity is Severity.LOOK),
        *physiology_findings(values, nominal.time_constant, study.settings.species, animal.recording.site),
        *_known_values(row, nominal),
    ]
    problems = [StudyProblem(finding) for finding in dict.fromkeys(finding.placed(place) for finding in findings)]
    for name, wrong in _bounds(row.animal, animal, nominal, settings).items():
        bound_place = document.place(("calibration", "bounds", name), key=True)
        problems.append(StudyProblem(wrong.placed(bound_place), also=(row.animal,)))
    return problems


def _known_values(row: AnimalRow, nominal: Nominal) -> list[Finding]:
    """Compare what is known from elsewhere with the recording: an exponent slip shows at once."""
    R_T, tau = nominal.total_resistance, nominal.time_constant
    pairs = [
        ("R_T", row.R_T, R_T, "mmHg s/ml", "mean pressure above the wedge pressure over mean flow"),
        ("tau", row.tau, tau, "s", "decay of the recording"),
        ("C_T", row.C_T, (row.tau or tau) / (row.R_T or R_T), "ml/mmHg", "τ/R_T"),
    ]
    return [
        EXPONENT(name=name, given=value, unit=unit, expected=expected, source=source,
                 factor=max(value / expected, expected / value))
        for name, value, expected, unit, source in pairs
        if value is not None and not 1 / _MAX_VALUE_RATIO <= value / expected <= _MAX_VALUE_RATIO
    ]  # fmt: skip


def _bounds(name_of_animal: str, animal: Animal, nominal: Nominal, settings: Settings) -> dict[str, Finding]:
    """Return the parameters whose nominal value their bounds exclude, and what is wrong with each."""
    findings: dict[str, Finding] = {}
    for wall in settings.walls:
        search = settings.search(wall)
        try:
            limits = ParameterLimits(search.bounds, search.fixed, search.paper_bounds, search.viscous)
            space = parameter_space(wall, animal.network, nominal, settings.blood, limits)
        except VasowaveError as error:
            findings[""] = BOUNDS(name=name_of_animal, text=str(error))
            continue
        for i, name in enumerate(space.names):
            low, high, value = space.lower[i], space.upper[i], space.nominal[i]
            if space.free[i] and not low * (1 - 1e-9) <= value <= high * (1 + 1e-9):
                unit = "" if space.parameters[name].unit == "1" else f" {space.parameters[name].unit}"
                findings[name] = NOMINAL_EXCLUDED(
                    name=name_of_animal, parameter=name, low=float(low), high=float(high), value=float(value), unit=unit
                )
    return findings


def doubled_animals(study: Study) -> list[StudyProblem]:
    """Return an error for every file recorded of an animal that is another's too, unless the table says it is meant.

    Any stretch of it counts: an animal that is analyzed twice is one, and doubles what a study rests on.
    """
    problems = []
    for double_kind, title in ((SAME_RECORDING, "recording"), (SAME_VENTRICLE, "ventricle"), (SAME_LOOPS, "loops")):
        first = dict[str, AnimalRow]()
        for row in study.animals:
            files = row.recordings if title == "recording" else filter(None, [getattr(row, title)])
            in_file = row.subject_row or row.pressure_channel  # what tells it from others in its file
            in_file = f"{in_file} {row.sheet}".casefold() if title == "recording" else ""
            for content in _contents([*files]):
                earlier_row = first.setdefault(content + in_file, row)
                if earlier_row is not row and not _meant(row, earlier_row):
                    problems.append(_doubled(study, row, earlier_row, double_kind, title))
                    break
    return problems


def _alike(study: Study, animals: Sequence[tuple[AnimalRow, _Loaded]]) -> Iterator[StudyProblem]:
    """Yield an error for every animal whose averaged cycle is another's, whatever bytes their files are written in."""
    cycles = ((row, loaded.animal.recording) for row, loaded in animals)
    ordered = sorted(cycles, key=lambda entry: entry[1].mean_pressure)
    for i, (row, cycle) in enumerate(ordered):
        for earlier_row, earlier in reversed(ordered[:i]):
            if cycle.mean_pressure - earlier.mean_pressure > _SAME_RANGE_SHARE * np.ptp(cycle.pressure):
                break
            early, late = sorted((row, earlier_row), key=lambda entry: entry.line)
            if _same_cycle(cycle, earlier) and not _meant(row, earlier_row):
                yield _doubled(study, late, early, SAME_CYCLE)


def _of_one_recording(study: Study, animals: Sequence[tuple[AnimalRow, _Loaded]]) -> Iterator[StudyProblem]:
    """Yield an error for every animal whose signal stands in that of another, exported anew."""
    for late, (row, loaded) in enumerate(animals):
        for earlier_row, earlier in animals[:late]:
            if not _meant(row, earlier_row) and _is_one_signal(loaded, earlier):
                yield _doubled(study, row, earlier_row, SAME_SIGNAL)
                break


def _is_one_signal(late: _Loaded, earlier: _Loaded) -> bool:
    trace, earlier_trace = late.trace, earlier.trace
    if trace is None or earlier_trace is None:
        return False
    return made_once(lambda: (late.key, earlier.key), lambda: are_of_one(trace, earlier_trace))


def _meant(row: AnimalRow, earlier_row: AnimalRow) -> bool:
    return row.shared_recording and earlier_row.shared_recording


def _once(doubled: Sequence[StudyProblem]) -> list[StudyProblem]:
    """Return the first that is said of each animal's recording: the same bytes are the same cycle, too."""
    first_by_place: dict[Place, StudyProblem] = {}
    for problem in doubled:
        first_by_place.setdefault(problem.place, problem)
    return [*first_by_place.values()]


def _same_cycle(first: Recording, second: Recording) -> bool:
    signals = ((first.pressure, second.pressure), (first.flow, second.flow))
    return abs(first.period - second.period) <= _SAME_RANGE_SHARE * first.period and all(
        len(a) == len(b) and float(np.abs(a - b).max()) <= _SAME_RANGE_SHARE * float(np.ptp(a)) for a, b in signals
    )


def _doubled(
    study: Study, row: AnimalRow, earlier_row: AnimalRow, kind: FindingKind, title: str = "recording"
) -> StudyProblem:
    finding = kind(other=earlier_row.animal, at=earlier_row.line)
    placed = finding.at(str(study.table), line=row.line, part=f"column '{title}'")
    return StudyProblem(placed, also=(row.animal, earlier_row.animal))


def _contents(paths: Sequence[Path]) -> list[str]:
    try:
        return [look(path).sha256 for path in paths]
    except InputError:
        return []
