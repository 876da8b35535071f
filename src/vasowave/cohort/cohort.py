"""Animals in their groups, and the one of each group that stands for it."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr

from vasowave.animal.failure import Failure, failures_of
from vasowave.animal.reading import StoredLaw, data_of, group_of, law_of, name_of, settings_of, sources, wall_laws
from vasowave.cohort.table import INDICES, cohort_table, columns, rows_of
from vasowave.cohort.votes import Ballots, stored
from vasowave.errors import InputError

_CONTROL = "CTL"
"""The group that others are compared with unless another is named."""


@dataclass(frozen=True, eq=False)
class Cohort:
    """Animals in their groups, and the one of each group that stands for it where one is shown.

    Attributes
    ----------
    groups : dict of str to list of DataTree
        The results of the animals, the reference group first.
    shown : dict of str to DataTree
        Of each group, the animal whose measured indices are nearest to the group's medians.
    table : DataFrame
        From `cohort_table`: one row per animal and source.
    lost : tuple of Failure
        Animals that have no result.
    """

    groups: dict[str, list[xr.DataTree]]
    shown: dict[str, xr.DataTree]
    table: pd.DataFrame
    lost: tuple[Failure, ...] = ()

    @cached_property
    def results(self) -> list[xr.DataTree]:
        """All animals, group by group."""
        return [result for results in self.groups.values() for result in results]

    @cached_property
    def failures(self) -> tuple[Failure, ...]:
        """Everything that failed: animals that have no result, and parts of those that have one."""
        return (*self.lost, *(one for result in self.results for one in failures_of(result)))

    @property
    def reference(self) -> str:
        """The group that the others are compared with."""
        return next(iter(self.groups))

    @property
    def single(self) -> bool:
        """Whether there is one animal only."""
        return len(self.results) == 1

    @cached_property
    def walls(self) -> list[str]:
        """Wall laws that were calibrated in any animal."""
        return list(dict.fromkeys(wall for result in self.results for wall in wall_laws(result)))

    @property
    def sources(self) -> list[str]:
        """Where numbers come from: ``measured``, and every wall law."""
        return ["measured", *self.walls]

    @cached_property
    def symbols(self) -> dict[str, str]:
        """Symbol of every quantity, as stored."""
        return self._said("symbol", sources)

    @cached_property
    def meanings(self) -> dict[str, str]:
        """What every quantity is, in words; a model's go before those of a measured index, which are special."""
        return self._said("long_name", lambda result: sources(result)[::-1])

    def _said(self, attribute: str, order: Callable[[xr.DataTree], list[str]]) -> dict[str, str]:
        said: dict[str, str] = {}
        for result in self.results:
            for source in order(result):
                for name, value in data_of(result, f"{source}/quantities").variables.items():
                    said.setdefault(str(name), str(value.attrs.get(attribute, name)))
        return said

    def name(self, group: str) -> str:
        """Return how captions call the animal that stands for a group."""
        name = name_of(self.shown[group])
        return name if self.single else f"{name} ({group})"

    @property
    def shown_networks(self) -> list[list[str]]:
        """The groups whose shown animals have the same network, together."""
        alike: list[list[str]] = []
        for group, result in self.shown.items():
            own = data_of(result, "network")
            for groups in alike:
                if own.identical(data_of(self.shown[groups[0]], "network")):
                    groups.append(group)
                    break
            else:
                alike.append([group])
        return alike

    def calibrated(self, wall: str) -> list[xr.DataTree]:
        """Return the animals that were calibrated with a wall law."""
        return [result for result in self.results if wall in wall_laws(result)]

    @cached_property
    def ballots(self) -> list[Ballots]:
        """What the comparisons of the wall laws came to, animal by animal."""
        return [stored(result) for result in self.compared]

    @property
    def compared(self) -> list[xr.DataTree]:
        """The animals whose wall laws were compared by AICc and BIC."""
        return [result for result in self.results if "selection" in result.children]

    def calibrations(self, wall: str) -> list[xr.Dataset]:
        """Return what the calibrations with a wall law came to, animal by animal."""
        return [data_of(result, f"{wall}/calibration") for result in self.calibrated(wall)]

    def law(self, wall: str) -> StoredLaw:
        """Return what is said of a wall law."""
        return law_of(self.calibrated(wall)[0], wall)

    @cached_property
    def settings(self) -> dict[str, Any]:
        """The settings that all animals share; those that differ are left out."""
        first, *others = map(settings_of, self.results)
        return {key: value for key, value in first.items() if all(one.get(key) == value for one in others)}

    @property
    def differing_settings(self) -> list[str]:
        """Names of the settings that are not the same for all animals."""
        return [key for key in dict.fromkeys(key for result in self.results for key in settings_of(result))
                if key not in self.settings]  # fmt: skip


def gathered(
    results: Sequence[xr.DataTree],
    reference: str | None = None,
    whole: Callable[[str], xr.DataTree] | None = None,
    lost: Iterable[Failure] = (),
) -> Cohort:
    """Return the animals in their groups.

    Parameters
    ----------
    results : sequence of DataTree
        One per animal.
    reference : str, optional
        Group that the others are compared with; by default CTL, or the first.
    whole : callable, optional
        Returns the result of an animal by its name, where `results` are those `at_inlets`; for the animals shown.
    lost : iterable of Failure
        Animals that have no result.

    Raises
    ------
    InputError
        No animal, two of the same name, an unknown reference, or a quantity in two units.
    """
    if not results:
        raise InputError("there is no animal to report")
    labels = list(dict.fromkeys(group_of(result) for result in results))
    first = reference or (_CONTROL if _CONTROL in labels else labels[0])
    if first not in labels:
        raise InputError(f"no animal is of the reference group '{first}'; there are: {', '.join(labels)}")
    labels.sort(key=lambda label: label != first)
    groups = {label: [result for result in results if group_of(result) == label] for label in labels}
    table = cohort_table([result for members in groups.values() for result in members])
    typical = {label: typical_animal(table, label) for label in groups}
    if whole is None:
        return Cohort(groups, {label: _named(groups[label], name) for label, name in typical.items()}, table,
                      tuple(lost))  # fmt: skip
    return Cohort(groups, {label: whole(name) for label, name in typical.items()}, table, tuple(lost))


def typical_animal(table: pd.DataFrame, group: str) -> str:
    """Return the animal of a group whose measured indices lie nearest to the group's medians, in their SDs."""
    rows = rows_of(table, "measured")
    rows = rows[rows["group"] == group]
    values = rows[columns(rows, INDICES)].to_numpy(float)
    scale = values.std(axis=0)
    away = (values - np.median(values, axis=0)) / np.where(scale > 0, scale, 1.0)
    return str(rows.index[int(np.argmin((away**2).sum(axis=1)))])


def _named(results: Iterable[xr.DataTree], name: str) -> xr.DataTree:
    return next(result for result in results if name_of(result) == name)
