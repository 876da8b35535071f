"""What made the change of animals that were recorded before and after: their fitted models, exchanged."""

from collections.abc import Iterator
from dataclasses import replace

from vasowave.base.errors import VasowaveError
from vasowave.pulse.analysis.attribution import attribute_change
from vasowave.study.animal.result import AnimalResult
from vasowave.study.animal.stored import stored_inflow, stored_model, stored_numerics
from vasowave.study.cohort.attribution import GroupAttribution
from vasowave.study.cohort.cohort import Cohort, levels_of
from vasowave.study.cohort.primary import Family, primary_law


def attributed(cohort: Cohort, family: Family | None = None) -> Cohort:
    """Return a cohort that knows what made the change of each group from the first to the last occasion.

    Parameters
    ----------
    cohort : Cohort
        One whose design has no subject and occasion is returned as it is.
    family : Family, optional
        The primary comparison; fits of its wall law are exchanged.
    """
    if not (cohort.design.subject and cohort.design.occasion and len(levels_of(cohort.second)) > 1):
        return cohort
    law = primary_law(cohort, family or Family())
    if not law:
        return cohort
    groups = (_of_group(cohort, group, law) for group in cohort.groups)
    return replace(cohort, changes=tuple(group for group in groups if group.tables or group.failures))


def _of_group(cohort: Cohort, group: str, law: str) -> GroupAttribution:
    first, *_, last = levels_of(cohort.second)
    tables, failures = {}, {}
    for subject, before, after in _pairs(cohort, group, first, last):
        try:
            inflows = stored_inflow(before, law), stored_inflow(after, law)
            models, numerics = (stored_model(before, law), stored_model(after, law)), stored_numerics(before, law)
            tables[subject] = attribute_change(*models, inflows, numerics).table
        except VasowaveError as error:
            failures[subject] = str(error)
    return GroupAttribution(group, first, last, tables, failures)


def _pairs(cohort: Cohort, group: str, first: str, last: str) -> Iterator[tuple[str, AnimalResult, AnimalResult]]:
    """Go through the animals of a group that have both occasions, each with its first recording of either."""
    assert cohort.second is not None
    level = cohort.second.levels
    recorded: dict[str, dict[str, AnimalResult]] = {}
    for result in cohort.groups[group]:
        recorded.setdefault(cohort.subjects[result.name], {}).setdefault(level.get(result.name, ""), result)
    for subject, results in recorded.items():
        if first in results and last in results:
            yield subject, results[first], results[last]
