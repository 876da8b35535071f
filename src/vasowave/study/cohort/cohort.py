"""Animals in their groups, and the representative animal of each group."""

from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
import xarray as xr

from vasowave.base.errors import InputError
from vasowave.pulse.quantities import INDICES, QUANTITIES, RECORDED
from vasowave.study.animal.failure import Failure
from vasowave.study.animal.law_result import LawResult
from vasowave.study.animal.result import AnimalResult, as_chosen, network_dataset
from vasowave.study.cohort.attribution import GroupAttribution
from vasowave.study.cohort.declared import Declaration
from vasowave.study.cohort.design import Design
from vasowave.study.cohort.lungs import LungDifferences, lungs_of
from vasowave.study.cohort.table import cohort_table, columns, rows_of
from vasowave.study.cohort.variables import Variable
from vasowave.study.cohort.votes import Ballots, misfits, stored, unusable_walls

_MAX_LEVELS = 6
"""Levels of a column that are described one by one; a dose or time of more is a number, not a few classes."""
_CONTROL = "CTL"
"""The group that others are compared with unless another is named."""


class Cell(NamedTuple):
    """The recordings of one group at one level; of the whole group where the design has no second column."""

    group: str
    level: str
    results: list[AnimalResult]


def levels_of(second: Variable | None) -> list[str]:
    """Return the levels that are described one by one, the reference first; none where there is nothing to divide."""
    order = second.order if second else []
    return order if len(order) <= _MAX_LEVELS else []


def cells_of(groups: Mapping[str, Sequence[AnimalResult]], second: Variable | None) -> dict[str, Cell]:
    """Return the recordings by group and level, called ``group, level``; the groups themselves without a column."""
    levels = levels_of(second)
    if second is None or not levels:
        return {group: Cell(group, "", list(results)) for group, results in groups.items()}
    level_by_animal = second.levels
    cells = {}
    for group, results in groups.items():
        for level in [*levels, f"{second.name} not known"]:
            members = [
                result for result in results if level_by_animal.get(result.name, f"{second.name} not known") == level
            ]
            if members:
                cells[f"{group}, {level}"] = Cell(group, level, members)
    return cells


def common_level(groups: Mapping[str, Sequence[AnimalResult]], second: Variable | None) -> str:
    """Return the first level that every group has, at which one recording of each may stand beside the others."""
    level_by_animal = {} if second is None else second.levels
    for level in levels_of(second):
        if all(any(level_by_animal.get(result.name) == level for result in results) for results in groups.values()):
            return level
    return ""


@dataclass(frozen=True, eq=False)
class Cohort:
    """Animals in their groups, and the representative animal of each group, where one is shown."""

    groups: dict[str, list[AnimalResult]]
    """The results of the animals, the reference group first."""
    shown: dict[str, AnimalResult]
    """Of each group, the animal whose measured indices are nearest to the group's medians; of occasions or levels of a
    second factor at the first that all groups have, so that groups are not shown at different ones."""
    table: pd.DataFrame
    """From `cohort_table`: one row per animal and source."""
    lost: tuple[Failure, ...] = ()
    """Animals that have no result."""
    variables: Mapping[str, Variable] = field(default_factory=dict)
    """What the lab knows of the animals beside, by name."""
    design: Design = field(default_factory=Design)
    """How they were laid out."""
    declared: tuple[Declaration, ...] = ()
    """What the study said that it would compare, and when."""
    lung_sd: float | None = None
    """How much the lungs of one group differ, as the lab tells it; see `lungs`."""
    changes: tuple[GroupAttribution, ...] = ()
    """What made the change of animals that were recorded twice, or the difference of groups."""

    @cached_property
    def lungs(self) -> LungDifferences:
        """How much the lungs of one group differ, by one result of each animal."""
        first = {subject: name for name, subject in reversed(self.subjects.items())}
        groups = {
            group: [result for result in results if first[self.subjects[result.name]] == result.name]
            for group, results in self.groups.items()
        }
        words = self.variables["image"].levels if "image" in self.variables else {}
        return lungs_of(groups, words, self.lung_sd)

    @cached_property
    def results(self) -> list[AnimalResult]:
        """All animals, group by group."""
        return [result for results in self.groups.values() for result in results]

    @cached_property
    def failures(self) -> tuple[Failure, ...]:
        """Everything that failed: animals that have no result, and parts of those that have one."""
        return (*self.lost, *(failure for result in self.results for failure in result.failures))

    @property
    def reference(self) -> str:
        """The group that the others are compared with."""
        return next(iter(self.groups))

    @property
    def single(self) -> bool:
        """Whether there is one animal only."""
        return len(self.results) == 1

    @cached_property
    def subjects(self) -> dict[str, str]:
        """The animal of every result, by the result's name, which is its own unless the design has a `subject`."""
        variable = self.variables.get(self.design.subject or "")
        levels = {} if variable is None else variable.levels
        return {result.name: levels.get(result.name, result.name) for result in self.results}

    @property
    def members(self) -> dict[str, str]:
        """The group of every result, by the result's name."""
        return {result.name: result.group for result in self.results}

    @property
    def repeated(self) -> bool:
        """Whether several recordings are of one animal, so that they are not independent of each other."""
        return len(set(self.subjects.values())) < len(self.results)

    @property
    def second(self) -> Variable | None:
        """The column that is crossed with the groups, if there is one."""
        return self.variables.get(self.design.second or "")

    @cached_property
    def cells(self) -> dict[str, Cell]:
        """The recordings by group and level of the second column; the groups themselves where there is none."""
        return cells_of(self.groups, self.second)

    @property
    def crossed(self) -> bool:
        """Whether groups are divided by the levels of a second column."""
        return any(cell.level for cell in self.cells.values())

    @cached_property
    def described(self) -> pd.DataFrame:
        """The table, in which `group` is the cell of a recording: what is described is not pooled over occasions."""
        labels = {result.name: label for label, cell in self.cells.items() for result in cell.results}
        return self.table.assign(group=self.table["animal"].map(labels))

    @cached_property
    def shown_at(self) -> str:
        """The occasion or level at which animals are shown, as text says it: ``time before``; empty without one."""
        level = common_level(self.groups, self.second)
        return f"{self.design.second} {level}" if level else ""

    def count(self, group: str) -> str:
        """Return how many a group or cell has: ``n = 6``, or ``12 recordings, n = 6`` of animals recorded again."""
        results = self.cells[group].results if group in self.cells else self.groups[group]
        names = [result.name for result in results]
        animals = len({self.subjects[name] for name in names})
        return f"n = {animals}" if animals == len(names) else f"{len(names)} recordings, n = {animals}"

    def counts(self, group: str) -> str:
        """Return how many a group has in each of its cells, once where all have as many: ``n = 4``, ``n = 4, 3``."""
        first, *further_counts = dict.fromkeys(
            self.count(label) for label, cell in self.cells.items() if cell.group == group
        )
        return ", ".join([first, *(count.removeprefix("n = ") for count in further_counts)])

    @cached_property
    def walls(self) -> list[str]:
        """Wall laws that were calibrated in any animal, in the order of the settings."""
        laws = {wall: law for result in self.results for wall, law in result.laws.items()}
        return list(as_chosen(laws, self.results[0].settings.get("walls", ())))

    @property
    def sources(self) -> list[str]:
        """Where numbers come from: ``measured``, and every wall law."""
        return ["measured", *self.walls]

    @cached_property
    def symbols(self) -> dict[str, str]:
        """Symbol of every quantity, as stored."""
        return self._descriptions("symbol") | {name: QUANTITIES[name].symbol for name in RECORDED}

    @cached_property
    def meanings(self) -> dict[str, str]:
        """What every quantity is, in words; a model's go before those of a measured index, which are special."""
        return {name: QUANTITIES[name].meaning for name in RECORDED} | self._descriptions("long_name")

    def _descriptions(self, attribute: str) -> dict[str, str]:
        texts: dict[str, str] = {}
        for result in self.results:
            for source in reversed(result.sources.values()):
                for name, value in source.quantities.variables.items():
                    texts.setdefault(str(name), str(value.attrs.get(attribute, name)))
        return texts

    def name(self, group: str) -> str:
        """Return how captions call the animal that stands for a group."""
        name = self.shown[group].name
        return name if self.single else f"{name} ({', '.join(filter(None, (group, self.shown_at)))})"

    @property
    def shown_networks(self) -> list[list[str]]:
        """The groups whose shown animals have the same network, together."""
        alike: list[list[str]] = []
        for group, result in self.shown.items():
            dataset = network_dataset(result.network)
            for groups in alike:
                if dataset.identical(network_dataset(self.shown[groups[0]].network)):
                    groups.append(group)
                    break
            else:
                alike.append([group])
        return alike

    def calibrated(self, wall: str) -> list[AnimalResult]:
        """Return the animals that were calibrated with a wall law."""
        return [result for result in self.results if wall in result.laws]

    @cached_property
    def misfits(self) -> pd.DataFrame:
        """How well every law meets every animal, see `votes.misfits`."""
        return misfits(self.results)

    @cached_property
    def unusable(self) -> dict[str, frozenset[str]]:
        """The laws of every animal that must not be weighed against another, see `votes.unusable_walls`."""
        return {result.name: frozenset[str]() for result in self.results} | unusable_walls(self.misfits)

    def forbidden(self, wall: str) -> list[AnimalResult]:
        """Return the animals of which a law's numbers must not be used: it misses the data or overstrains a vessel."""
        table = self.misfits
        names = set(table["animal"][(table["wall"] == wall) & (table["missed"] | table["growth"].notna())])
        return [result for result in self.results if result.name in names]

    @cached_property
    def ballots(self) -> list[Ballots]:
        """What the comparisons of the wall laws came to, animal by animal."""
        return [stored(result.selection, self.subjects[result.name], self.unusable[result.name])
                for result in self.compared if result.selection is not None]  # fmt: skip

    @property
    def compared(self) -> list[AnimalResult]:
        """The animals whose wall laws were compared by AICc and BIC."""
        return [result for result in self.results if result.selection is not None]

    def calibrations(self, wall: str) -> list[xr.Dataset]:
        """Return what the calibrations with a wall law came to, animal by animal."""
        return [result.laws[wall].calibration for result in self.calibrated(wall)]

    def law(self, wall: str) -> LawResult:
        """Return what the first animal with a wall law says of it."""
        return self.calibrated(wall)[0].laws[wall]

    @cached_property
    def settings(self) -> dict[str, Any]:
        """The settings that all animals share; those that differ are left out."""
        first, *further_settings = (result.settings for result in self.results)
        return {
            key: value
            for key, value in first.items()
            if all(settings.get(key) == value for settings in further_settings)
        }

    @property
    def differing_settings(self) -> list[str]:
        """Names of the settings that are not the same for all animals."""
        return [key for key in dict.fromkeys(key for result in self.results for key in result.settings)
                if key not in self.settings]  # fmt: skip


def gathered(
    results: Sequence[AnimalResult],
    reference: str | None = None,
    full_result: Callable[[str], AnimalResult] | None = None,
    lost: Iterable[Failure] = (),
    variables: Iterable[Variable] = (),
    design: Design | None = None,
    declared: Iterable[Declaration] = (),
) -> Cohort:
    """Return the animals in their groups.

    Parameters
    ----------
    results : sequence of AnimalResult
        One per animal.
    reference : str, optional
        Group that the others are compared with; by default CTL, or the first.
    full_result : callable, optional
        Returns the result of an animal by its name, where `results` are those `at_inlets`; for the animals shown.
    lost : iterable of Failure
        Animals that have no result.
    variables : iterable of Variable
        What the lab knows of the animals beside.
    design : Design, optional
        How they were laid out; by default groups of independent animals.
    declared : iterable of Declaration
        What the study said that it would compare, and when.

    Raises
    ------
    InputError
        No animal, two of the same name, an unknown reference, or a quantity in two units.
    """
    if not results:
        raise InputError("there is no animal to report")
    labels = list(dict.fromkeys(result.group for result in results))
    first = reference or (_CONTROL if _CONTROL in labels else labels[0])
    if first not in labels:
        raise InputError(f"no animal is of the reference group '{first}'; there are: {', '.join(labels)}")
    labels.sort(key=lambda label: label != first)
    groups = {label: [result for result in results if result.group == label] for label in labels}
    table = cohort_table([result for members in groups.values() for result in members])
    variable_by_name = {variable.name: variable for variable in variables}
    second = variable_by_name.get(design.second or "") if design else None
    level = common_level(groups, second)
    names_at_level = (
        {name for name, animal_level in second.levels.items() if animal_level == level} if second and level else None
    )
    typical = {label: typical_animal(table, label, names_at_level) for label in groups}
    by_name = {result.name: result for result in results}
    shown = {label: full_result(name) if full_result else by_name[name] for label, name in typical.items()}
    return Cohort(groups, shown, table, tuple(lost), variable_by_name, design or Design(), tuple(declared))


def typical_animal(table: pd.DataFrame, group: str, among: Collection[str] | None = None) -> str:
    """Return the animal of a group (`among` some) whose measured indices lie nearest to their medians, in their SDs."""
    rows = rows_of(table, "measured")
    rows = rows[(rows["group"] == group) & (True if among is None else rows.index.isin(among))]
    values = rows[columns(rows, INDICES)].to_numpy(float)
    scale = values.std(axis=0)
    away = (values - np.median(values, axis=0)) / np.where(scale > 0, scale, 1.0)
    return str(rows.index[int(np.argmin((away**2).sum(axis=1)))])
