"""The results of a study: one netCDF-4 file an animal, and an index that says whose they are and what they must be.

::

    results/
    ├── index.json           order and groups of the animals, their files with SHA-256, failures, settings, versions
    └── animals/             CTL 1-0a1b2c3d4e5f.nc, …

A file's name ends with the beginning of its SHA-256, so that files of a new run stand beside those of the run before
until the index, written last and in one step, names them. What a file costs does not depend on how many there are.
"""

import hashlib
import json
import os
import re
import unicodedata
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from functools import partial
from pathlib import Path, PurePosixPath
from typing import TYPE_CHECKING, Any

import pandas as pd

from vasowave.base.errors import InputError, did_you_mean
from vasowave.base.io.files import check_home, copy_file, made_inside, remove_file, write_file
from vasowave.base.io.textfile import read_bytes
from vasowave.base.notebook import card
from vasowave.base.settings import given_values
from vasowave.base.software import provenance
from vasowave.base.stores import parsed_as, stored
from vasowave.pulse.model.law_files import looking_in, plain, remember
from vasowave.study.animal.failure import Failure, as_plain, from_plain
from vasowave.study.animal.files import read_result
from vasowave.study.animal.result import TIDY_COLUMNS, AnimalResult
from vasowave.study.cohort.cohort import Cohort, gathered
from vasowave.study.cohort.declared import Declaration
from vasowave.study.cohort.primary import primary_comparison
from vasowave.study.cohort.variables import Variable
from vasowave.study.folder.settings import StudyFile
from vasowave.study.report.settings import ReportSettings
from vasowave.study.report.wording import some_of
from vasowave.study.results.store import piece_digest

if TYPE_CHECKING:
    from vasowave.study.report.answer.comparison import Comparison
    from vasowave.study.report.files import Each

INDEX = "index.json"
ANIMALS = "animals"
FORM = "vasowave study 3"
"""What the index says of itself; the number grows with the stored form."""

_EARLIER_FILE = "results.nc"
_MAX_NAMED_ANIMALS = 6  # animals, in a sentence
_MAX_NAME_BYTES = 80  # bytes of an animal's name in that of its file


@dataclass(frozen=True)
class StoredAnimal:
    """The place of the result of one animal.

    Attributes
    ----------
    animal, group : str
    file : str
        Seen from the folder of the index.
    sha256 : str
        Of the file.
    """

    animal: str
    group: str
    file: str
    sha256: str


@dataclass(frozen=True, eq=False, repr=False)
class Results(Mapping[str, AnimalResult]):
    """The results of a study: a mapping of every animal's name to its result.

    The animals are read when they are asked for, each checked against its SHA-256. See `read_results`.

    Attributes
    ----------
    folder : Path
        The folder of the index.
    animals : tuple of StoredAnimal
        Every animal that was analyzed, in the order of the table.
    failures : tuple of Failure
        What failed: animals that have no result, and wall laws, posteriors or comparisons of those that have one.
    settings : StudyFile
        The settings it was run with.
    versions : dict of str to str
        Date (UTC) and versions of the programs.
    variables : tuple of Variable
        The columns of the table of animals that are the lab's own.
    declared : tuple of Declaration
        What the study said that it would compare, and when.
    """

    folder: Path
    animals: tuple[StoredAnimal, ...]
    failures: tuple[Failure, ...]
    settings: StudyFile
    versions: dict[str, str]
    variables: tuple[Variable, ...] = ()
    declared: tuple[Declaration, ...] = ()
    _light: dict[str, AnimalResult] = field(default_factory=dict, init=False)  # read once: tables are asked for again

    def __getitem__(self, animal: str) -> AnimalResult:
        """Return the result of one animal.

        Raises
        ------
        KeyError
            There is no animal of this name.
        InputError
            Its file is missing or damaged.
        """
        stored = {entry.animal: entry for entry in self.animals}
        if animal not in stored:
            raise KeyError(self._absent(animal))
        return _read(self.folder, stored[animal])

    def __contains__(self, animal: object) -> bool:
        """Whether an animal has a result; its file is not read."""
        return any(entry.animal == animal for entry in self.animals)

    def file_of(self, animal: str) -> Path:
        """Return the file of an animal, seen from the folder of the index.

        Raises
        ------
        InputError
            There is no result of this animal.
        """
        files = {entry.animal: Path(entry.file) for entry in self.animals}
        if animal not in files:
            raise InputError(self._absent(animal))
        return files[animal]

    def _absent(self, animal: str) -> str:
        lost = {failure.animal: f": {failure}" for failure in self.lost}
        like = [name for name in self if str(animal).casefold() in name.casefold()]
        mean = f" (did you mean {some_of([repr(name) for name in like], _MAX_NAMED_ANIMALS)}?)" if like else ""
        reason = lost.get(animal) or mean or did_you_mean(str(animal), self)
        stored = some_of(list(self), _MAX_NAMED_ANIMALS)
        return f"{self.folder}: there is no result of '{animal}'{reason}; there are: {stored}"

    @property
    def lost(self) -> tuple[Failure, ...]:
        """The failures of the animals that have no result."""
        return tuple(failure for failure in self.failures if failure.is_total)

    def __iter__(self) -> Iterator[str]:
        """Go through the names of the animals."""
        return (entry.animal for entry in self.animals)

    def __len__(self) -> int:
        """Return how many animals were analyzed."""
        return len(self.animals)

    def __repr__(self) -> str:
        """Return a short table: the animals by group, the laws, what failed, and what can be typed next."""
        labels = [label for label, names in self._members.items() if names][1:]
        facts = {label: f"{len(names)}  {some_of(names, _MAX_NAMED_ANIMALS)}" for label, names in self._members.items()}
        facts["wall laws"] = self._laws
        if self.failures:
            failed = [f"{failure.animal}, {failure}" for failure in self.failures]
            facts["failed"] = some_of(failed, _MAX_NAMED_ANIMALS)
        calls = [*(f"results[{name!r}]" for name in [*self][:1]), "results.table()"]
        facts["next"] = ", ".join([*calls, *(f"results.compare({label!r})" for label in labels[:1])])
        width = max(map(len, facts))
        rows = [f"  {name:<{width}}  {text}" for name, text in facts.items()]
        return "\n".join([f"Study: {self.settings.title}", *rows])

    def _repr_html_(self) -> str:
        facts: dict[str, object] = {
            label: f"{len(names)}: {', '.join(names)}" for label, names in self._members.items()
        }
        facts["wall laws"] = self._laws
        facts["run"] = ", ".join(f"{name} {version}" for name, version in self.versions.items())
        failed = [f"{failure.animal} failed, {failure}" for failure in self.failures]
        return card(f"Study: {self.settings.title}", facts, failed)

    @property
    def _members(self) -> dict[str, list[str]]:
        return {
            label: [entry.animal for entry in self.animals if entry.group == label] for label in self.settings.groups
        }

    @property
    def _laws(self) -> str:
        return ", ".join(map(plain, self.settings.calibration.walls))

    def table(self) -> pd.DataFrame:
        """Return the single numbers of all animals, a row each: tidy data for pandas, seaborn or R.

        Columns ``animal, group, law`` ("measured" for the recording), ``quantity``, ``value, low, high`` (95 %,
        NaN where nothing tells it), ``unit``, then the lab's own (sex, weight [g], …).

        Raises
        ------
        InputError
            The file of an animal is missing or damaged.
        """
        tables = [result.table() for result in self.in_order(whole=False)]
        table = pd.concat(tables, ignore_index=True) if tables else pd.DataFrame(columns=[*TIDY_COLUMNS])
        return table.assign(**{variable.label: table["animal"].map(variable.values) for variable in self.variables})

    def compare(self, group: str, reference: str | None = None, **family: Any) -> "Comparison":
        """Compare a group with another as the report does, by its primary comparison.

        Parameters
        ----------
        group : str
        reference : str, optional
            By default the group that the report compares with.
        family
            ``law`` and ``quantities``, in place of what the study's ``report`` says of them.

        Raises
        ------
        InputError
            There is no such group, or it is the reference; a law or a quantity that no animal has; the file of an
            animal is missing or damaged.
        """
        from vasowave.study.report.answer.comparison import Comparison

        results = self.in_order(whole=False)
        first = reference or (results[0].group if results else None)
        cohort = self.gathered(results, first)
        alternatives = [*cohort.groups][1:]
        listed = ", ".join(alternatives) or "none, for all animals are of one group"
        if group == cohort.reference:
            raise InputError(f"'{group}' is the reference itself; compare one of the others with it: {listed}")
        if group not in alternatives:
            hint = did_you_mean(group, alternatives)
            raise InputError(f"no group '{group}' to compare with {cohort.reference}{hint}; there are: {listed}")
        primary = primary_comparison(cohort, given_values(ReportSettings, self.settings.report, family))
        return Comparison(group, cohort, primary.of_group(group))

    def gathered(self, results: Sequence[AnimalResult], reference: str | None = None) -> Cohort:
        """Return results of these animals in their groups, with what the lab knows of them and the study's design."""
        study_facts = (self.variables, self.settings.design, self.declared)
        return gathered(results, reference, self.__getitem__, self.lost, *study_facts)

    def in_order(self, each: "Each" = map, whole: bool = True) -> list[AnimalResult]:
        """Return the results of all animals, in the order of their groups; `each` may read several at a time.

        Unless `whole`, simulations are those `at_inlets`, and hundreds of animals need little memory.
        """
        order = list(self.settings.groups)
        grouped = sorted(self.animals, key=lambda entry: order.index(entry.group))
        if whole:
            return list(each(partial(_read, self.folder), grouped))
        new = [entry for entry in grouped if entry.animal not in self._light]
        read = each(partial(_read_light, self.folder), new)
        self._light.update((entry.animal, result) for entry, result in zip(new, read, strict=True))
        return [self._light[entry.animal] for entry in grouped]


def _read(folder: Path, stored: StoredAnimal) -> AnimalResult:
    result = read_result(folder / stored.file, stored.sha256)
    if result.name != stored.animal:
        path = folder / stored.file
        raise InputError(f"{path}: holds the result of '{result.name}', not of '{stored.animal}'; run again")
    return result


def _read_light(folder: Path, stored: StoredAnimal) -> AnimalResult:
    return _read(folder, stored).at_inlets()


def write_results(
    folder: Path, pieces: Mapping[tuple[str, str], Path], failures: Sequence[Failure], settings: StudyFile,
    variables: Sequence[Variable] = (), declared: Sequence[Declaration] = (),
) -> Path:  # fmt: skip
    """Write the index of a study and put the animals' files beside it; returns the index.

    Parameters
    ----------
    folder : Path
        Must exist.
    pieces : mapping of (animal, group) to Path
        The piece of every animal (see `results.store`). Where the file system can, it is linked and not copied.
    failures : sequence of Failure
    settings : StudyFile
    variables : sequence of Variable
        The columns of the table of animals that are the lab's own.
    declared : sequence of Declaration

    Raises
    ------
    InputError
        Something cannot be written; the index, and so the results, are those of the run before.
    """
    check_home(folder / INDEX, 1)
    inside = made_inside(folder, ANIMALS)
    animals = []
    for (animal, group), piece in pieces.items():
        digest = piece_digest(piece)
        place = inside / f"{_file_name(animal)}-{digest[:12]}.nc"
        _put(piece, place)
        animals.append(StoredAnimal(animal, group, f"{ANIMALS}/{place.name}", digest))
    content = {
        "form": FORM,
        "animals": [asdict(entry) for entry in animals],
        "failures": as_plain(failures),
        "settings": asdict(settings),
        "variables": [asdict(variable) for variable in variables],
        "declared": [asdict(declaration) for declaration in declared],
        "versions": provenance(),
    }
    index = write_file(folder / INDEX, json.dumps(content | {"sha256": _digest(content)}, indent=1, ensure_ascii=False))
    named = {Path(entry.file).name for entry in animals}
    for stale_file in (file for file in inside.glob("*.nc") if file.name not in named):
        remove_file(stale_file)
    return index


@stored("index of results", f"results/{INDEX}")
def read_results(folder: str | Path) -> Results:
    """Return the results of a study or of a fit.

    Parameters
    ----------
    folder : str or Path
        The folder of the study (or of the fit), or ``results`` in it.

    Raises
    ------
    InputError
        There are none, they are of an earlier version, or the index is damaged.

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
    ...     _ = vw.run_study(vw.read_study("study.yaml"), executor=here)
    >>> results = vw.read_results(Path())
    >>> results["mouse 6"].laws["linear"].rmse < 0.5  # mmHg
    True
    >>> results.table().query("law == 'linear' and quantity == 'R_T'")[["animal", "unit"]].to_numpy().tolist()
    [['mouse 6', 'mmHg s/ml']]
    """
    folder = Path(folder)
    where = next((place for place in (folder / "results", folder) if (place / INDEX).is_file()), None)
    if where is None:
        raise InputError(_nothing(folder))
    index = where / INDEX
    try:
        content = parsed_as(dict[str, Any], read_bytes(index))
        if content["form"] != FORM:
            raise InputError(f"{index}: of another version ('{content['form']}', not '{FORM}'); run it again")
        if content.pop("sha256") != _digest(content):
            raise ValueError("its content does not match its SHA-256")
        animals = tuple(StoredAnimal(**entry) for entry in content["animals"])
        if any(PurePosixPath(entry.file).parent != PurePosixPath(ANIMALS) for entry in animals):
            raise ValueError("a result lies elsewhere")
        failures = from_plain(content["failures"])
        with looking_in(None):
            fitted = content["settings"]["calibration"]
            remember([*map(str, fitted["walls"]), str(fitted.get("beds"))], (where.parent, where))
            settings = StudyFile(**content["settings"])
        if not {entry.group for entry in animals} <= {*settings.groups}:
            raise ValueError("an animal of no group")
        variables = tuple(Variable(**entry) for entry in content.get("variables", ()))
        declared = tuple(Declaration(**entry) for entry in content.get("declared", ()))
    except InputError:
        raise
    except (ValueError, LookupError, TypeError, AttributeError) as error:
        raise InputError(f"{index}: damaged ({error}); run again, what had finished is kept") from None
    return Results(where, animals, failures, settings, content["versions"], variables, declared)


def _nothing(folder: Path) -> str:
    for earlier in (folder / "results" / _EARLIER_FILE, folder / _EARLIER_FILE):
        if earlier.exists():
            return (
                f"{earlier}: of an earlier version of vasowave, whose results this one does not read; run the study or "
                "the fit again, and remove the file afterwards"
            )
    if (folder.absolute().parent / "results" / INDEX).is_file():
        return f"{folder}: there are no results; they are those of {folder.absolute().parent}"
    if (folder / "report.html").is_file():
        return f"{folder}: a report alone, without results; a run of the study, or a fit, keeps both"
    return f"{folder}: there are no results yet; run the study or the fit"


def _digest(content: Mapping[str, object]) -> str:
    return hashlib.sha256(json.dumps(content, sort_keys=True, ensure_ascii=False).encode()).hexdigest()


def _file_name(animal: str) -> str:
    """Return an animal's name as far as every file system takes it."""
    plain = re.sub(r"[^\w .,+()-]", "_", unicodedata.normalize("NFC", animal))
    return plain.encode()[:_MAX_NAME_BYTES].decode(errors="ignore").strip(" .")


def _put(piece: Path, place: Path) -> None:
    if not piece.is_file():
        raise InputError(f"{piece}: was removed while the study ran; run again, what is missing is computed anew")
    if place.is_file() and not place.is_symlink() and os.path.samefile(piece, place):
        return
    copy_file(piece, place)
