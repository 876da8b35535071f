"""Say everything that is wrong or odd about a study before it is run. Nothing is simulated and nothing is fitted."""

from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from vasowave.animal.animal import Animal, Settings
from vasowave.calibration.parameters import fitted_parameters, parameter_space
from vasowave.errors import InputError, VasowaveError
from vasowave.findings import Finding, Severity
from vasowave.law_files import files_of, plain
from vasowave.network_remarks import ROOT_RADIUS
from vasowave.nominal import Nominal, estimate_nominal, oddities
from vasowave.provenance import sha256
from vasowave.recording import INDEX_UNITS, Recording
from vasowave.study.document import Document, read_document
from vasowave.study.loading import load_animal
from vasowave.study.overview import AnimalRead, read_of
from vasowave.study.plan import Study, inspect_study
from vasowave.study.problems import Problem, one_per_cause
from vasowave.study.rows import AnimalRow
from vasowave.study.settings import StudyFile, animal_settings

NORMAL = {
    "mouse": {
        "HR": (300.0, 800.0, "beats/min"),
        "mPAP": (7.0, 45.0, "mmHg"),
        "pPAP": (4.0, 50.0, "mmHg"),
        "CO": (0.05, 0.45, "ml/s"),
        "root radius": (*ROOT_RADIUS["mouse"], "cm"),
    },
    "rat": {
        "HR": (200.0, 550.0, "beats/min"),
        "mPAP": (8.0, 70.0, "mmHg"),
        "pPAP": (5.0, 80.0, "mmHg"),
        "CO": (0.4, 4.0, "ml/s"),
        "root radius": (*ROOT_RADIUS["rat"], "cm"),
    },
}
"""Values outside are taken for slips until somebody has looked. For mice: well beyond three SD from the means
of the paper's Table 1; its two main pulmonary arteries have radii of 0.047 and 0.051 cm, so that a diameter in place
of the radius is noticed."""

BLOOD = {"density": (0.95, 1.3, "g/ml", 1.057), "viscosity": (0.005, 0.3, "cm²/s", 0.0462)}
"""What blood and the liquids used in its place have, unit, and the default."""

_TAU = (0.02, 0.6)  # s, between which the time constant of a mouse or a rat is not odd
_ALIKE = 1e-3  # of their range: two heartbeats never agree as well, one written with fewer digits does
_SLIP = 3.0  # a known value that differs by more than this factor is no other method, but another number


class Checked(NamedTuple):
    """What is wrong or odd, in the order of the files, and what was read of every animal whose files are in order."""

    problems: list[Problem]
    read: list[AnimalRead]
    settings: StudyFile | None


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
    document, read, cycles = read_document(study.path), [], []
    problems += [*_programs(study, document), *_settings(study, document)]
    for row in study.animals:
        place = f"{study.table}, line {row.line} ('{row.animal}')"
        try:
            animal = load_animal(row, study.settings, study.folder)
            problems += _animal(study, row, animal, document, place)
            read.append(read_of(animal))
            cycles.append((row, animal.recording))
        except VasowaveError as error:
            problems.append(_unreadable(place, row, str(error)))
    doubled = doubled_animals(study)
    return Checked(one_per_cause(problems + doubled + _alike(study, cycles, doubled)), read, study.settings)


def _unreadable(place: str, row: AnimalRow, message: str) -> Problem:
    """Return the problem that one of an animal's files is wrong, so that the same in another's is known as the same."""
    file = next((str(one) for one in row.files if message.startswith(f"{one}: ")), "")
    return Problem(place, message.removeprefix(f"{file}: ") if file else message, file=file)


def _programs(study: Study, document: Document) -> list[Problem]:
    """Say which files beside the study are run as programs."""
    place = document.place(("calibration", "walls"))
    return [
        Problem(place, f"a wall law runs the program {file.path}; read it, if it is not yours", False)
        for file in files_of(study.settings.calibration.walls)
    ]


def _settings(study: Study, document: Document) -> list[Problem]:
    """Return what is odd about the settings by themselves."""
    calibration, problems = study.settings.calibration, []

    def say(message: str, *at: str) -> None:
        problems.append(Problem(document.place(at, key=True), f"{'.'.join(at)}: {message}", False))

    names = {name for wall in calibration.walls for name in fitted_parameters(wall)}
    for section, given in (("bounds", calibration.bounds), ("fixed", calibration.fixed)):
        for name in sorted(set(given) - names):
            say(f"no parameter of the {' and '.join(map(plain, calibration.walls))} wall", "calibration", section, name)
    for name in sorted(set(calibration.bounds) & set(calibration.fixed)):
        say("is fixed, so these bounds have no meaning", "calibration", "bounds", name)
    if calibration.paper_bounds:
        say(
            "the published optima of CTL 3, CTL 5 and HPH 3 lie outside the paper's own bounds of β, and c1 of CTL 2 "
            "is 3.0 where 2.5 is allowed; expect parameters that end at a bound",
            "calibration",
            "paper_bounds",
        )
    if study.settings.model_selection and len(calibration.walls) < 2:
        say("needs two wall laws; with one there is nothing to compare", "model_selection")
    if calibration.starts < 10 and "tangent" in calibration.walls:
        say(
            f"{calibration.starts} starts now and then miss the tangent wall's best optimum; 20 seldom do",
            "calibration",
            "starts",
        )
    for quantity, (low, high, unit, usual) in BLOOD.items():
        value = getattr(study.settings.blood, quantity)
        if not low <= value <= high:
            say(
                f"{value:g} {unit} is no blood's ({low:g} to {high:g}, usual {usual:g}); is the unit right?",
                "blood",
                quantity,
            )
    return problems


def _animal(study: Study, row: AnimalRow, animal: Animal, document: Document, place: str) -> list[Problem]:
    """Return what is wrong or odd about what the files of one animal hold."""
    settings = animal_settings(study.settings)
    nominal = estimate_nominal(animal.network, animal.recording, settings.blood)
    said: list[str | Finding] = [
        *(one for one in animal.recording.notes if one.severity is Severity.LOOK),
        *_physiology(animal, nominal, study.settings),
        *oddities(nominal),
        *_known(row, nominal),
    ]
    problems = [Problem(place, message, False) for message in dict.fromkeys(said)]
    for name, message in _bounds(animal, nominal, settings).items():
        problems.append(
            Problem(document.place(("calibration", "bounds", name), key=True), f"'{row.animal}': {message}")
        )
    return problems


def _physiology(animal: Animal, nominal: Nominal, settings: StudyFile) -> list[str]:
    problems = []
    values = animal.recording.indices() | {"root radius": float(animal.network.radius[animal.network.root])}
    for name, (low, high, unit) in NORMAL.get(settings.species, {}).items():
        if not low <= values[name] <= high:
            doubt = "is it one whole cycle?" if name in INDEX_UNITS else "is it a radius, not a diameter?"
            problems.append(
                f"{name} {values[name]:.4g} {unit} is implausible for a {settings.species} ({low:g} to {high:g}); "
                f"is the unit right, and {doubt}"
            )
    if settings.species != "other" and not _TAU[0] <= nominal.time_constant <= _TAU[1]:
        problems.append(
            f"the pressure decays with τ = {nominal.time_constant:.3g} s after ejection (usual are {_TAU[0]:g} to "
            f"{_TAU[1]:g} s); do pressure and flow belong together, and are they aligned?"
        )
    return problems


def _known(row: AnimalRow, nominal: Nominal) -> list[str]:
    """Compare what is known from elsewhere with the recording: an exponent slip shows at once."""
    R_T, tau = nominal.total_resistance, nominal.time_constant
    pairs = [
        ("R_T", row.R_T, R_T, "mmHg s/ml", "mean pressure over mean flow"),
        ("tau", row.tau, tau, "s", "decay of the recording"),
        ("C_T", row.C_T, (row.tau or tau) / (row.R_T or R_T), "ml/mmHg", "τ/R_T"),
    ]
    problems = []
    for name, given, expected, unit, source in pairs:
        if given is not None and not 1 / _SLIP <= given / expected <= _SLIP:
            problems.append(
                f"{name} {given:.4g} {unit} as given, {expected:.4g} from the {source}: a factor of "
                f"{max(given / expected, expected / given):.3g}; a slip of the exponent? (The published C_T of HPH 2, "
                "0.13e-4, is one.)"
            )
    return problems


def _bounds(animal: Animal, nominal: Nominal, settings: Settings) -> dict[str, str]:
    """Return the parameters whose nominal value their bounds exclude, and a sentence for each."""
    problems: dict[str, str] = {}
    for wall in settings.walls:
        search = settings.search(wall)
        try:
            space = parameter_space(
                wall, animal.network, nominal, settings.blood, search.bounds, search.fixed, search.paper_bounds
            )
        except VasowaveError as error:
            problems[""] = str(error)
            continue
        for i, name in enumerate(space.names):
            low, high, value = space.lower[i], space.upper[i], space.nominal[i]
            if space.free[i] and not low * (1 - 1e-9) <= value <= high * (1 + 1e-9):
                unit = "" if space.parameters[name].unit == "1" else f" {space.parameters[name].unit}"
                problems[name] = (
                    f"the bounds of {name}, {low:.4g} to {high:.4g}{unit}, exclude the nominal value of this animal, "
                    f"{value:.4g}{unit}; widen them"
                )
    return problems


def doubled_animals(study: Study) -> list[Problem]:
    """Return an error for every recording that holds the bytes of another animal's, unless the table says it is meant.

    Any stretch of it counts: an animal that is analyzed twice is one, and doubles what a study rests on.
    """
    problems, first = [], dict[str, AnimalRow]()
    for row in study.animals:
        for content in _contents(row.recordings):
            other = first.setdefault(content, row)
            if other is not row and not (row.shared_recording and other.shared_recording):
                problems.append(_doubled(study, row, other, "the same recording as"))
                break
    return problems


def _alike(study: Study, cycles: Sequence[tuple[AnimalRow, Recording]], known: Sequence[Problem]) -> list[Problem]:
    """Return an error for every animal whose averaged cycle is another's, whatever bytes their files are written in."""
    said, problems = {problem.place for problem in known}, []
    ordered = sorted(cycles, key=lambda one: one[1].mean_pressure)
    for i, (row, cycle) in enumerate(ordered):
        for other, earlier in reversed(ordered[:i]):
            if cycle.mean_pressure - earlier.mean_pressure > _ALIKE * np.ptp(cycle.pressure):
                break
            early, late = sorted((row, other), key=lambda one: one.line)
            if _same_cycle(cycle, earlier) and not (row.shared_recording and other.shared_recording):
                problem = _doubled(study, late, early, "its averaged cycle is that of")
                problems += [problem] if problem.place not in said else []
                said.add(problem.place)
    return problems


def _same_cycle(one: Recording, other: Recording) -> bool:
    signals = ((one.pressure, other.pressure), (one.flow, other.flow))
    return abs(one.period - other.period) <= _ALIKE * one.period and all(
        len(a) == len(b) and float(np.abs(a - b).max()) <= _ALIKE * float(np.ptp(a)) for a, b in signals
    )


def _doubled(study: Study, row: AnimalRow, other: AnimalRow, what: str) -> Problem:
    place = f"{study.table}, line {row.line}, column 'recording'"
    return Problem(
        place,
        f"{what} '{other.animal}' (line {other.line}); remove one of the two rows, or, if two animals are meant to "
        "share it, write yes into the column 'shared recording' of both",
    )


def _contents(paths: Sequence[Path]) -> list[str]:
    try:
        return [sha256(path) for path in paths]
    except InputError:
        return []
