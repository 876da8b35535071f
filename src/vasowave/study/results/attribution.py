"""What made a group what it is: fitted models, exchanged between two occasions of an animal or between two groups."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from vasowave.base.errors import VasowaveError
from vasowave.pulse.analysis.attribution import attribute_change
from vasowave.pulse.analysis.changes import with_factors
from vasowave.pulse.cycle.cycle import Inflow, Recording
from vasowave.pulse.model.model import Model
from vasowave.pulse.model.numerics import Numerics
from vasowave.study.animal.result import AnimalResult
from vasowave.study.animal.stored import stored_inflow, stored_model, stored_numerics
from vasowave.study.cohort.attribution import ComponentExchange, GroupAttribution
from vasowave.study.cohort.cohort import Cohort, levels_of
from vasowave.study.cohort.estimates import numbered
from vasowave.study.cohort.primary import Family, primary_law

MAX_PAIRS = 40
"""Pairs of animals of two groups; each takes as many simulations as a fit, and so many tell the means."""
_MAX_CROSSED_PAIRS = 80  # of all comparisons where a second factor crosses the groups
_MAX_VESSELS = 2400  # of all pairs; of large trees each animal stands in fewer pairs
_IMAGE = "image"
_REPEATED = (
    "because animals were recorded more than once and the design names no `occasion`: their pairs are not independent. "
    "Name the columns `subject` and `occasion` in the design"
)


class _FittedState(NamedTuple):
    """A fitted animal, what its image stands for, and how its parameters follow the radii of the image."""

    name: str
    model: Model
    inflow: Recording | Inflow
    numerics: Numerics
    image: int
    radius_sd: float
    per_radius: dict[str, float]

    def imaged_wider(self) -> "_FittedState":
        """Return the fit of an image whose radii are one SD larger, to first order."""
        factors = {name: float(np.exp(slope * self.radius_sd)) for name, slope in self.per_radius.items()}
        return self._replace(model=with_factors(self.model, factors | {"radius": float(np.exp(self.radius_sd))}))


_StatePair = tuple[_FittedState, _FittedState]


def attributed(cohort: Cohort, family: Family | None = None) -> Cohort:
    """Return a cohort that knows what made the change of each group, or the difference of groups from the reference.

    Parameters
    ----------
    cohort : Cohort
        Of a design with subject and occasion the change from the first to the last occasion is told. Of groups whose
        animals were recorded once it is their difference; where a second factor crosses them, that at each of its
        levels, and the difference of its levels from the first within each group.
    family : Family, optional
        The primary comparison; fits of its wall law are exchanged.
    """
    is_longitudinal = bool(cohort.design.occasion and cohort.second and len(cohort.second.order) > 1)
    labels = _compared_cells(cohort)
    if not (labels or is_longitudinal) or not (law := primary_law(cohort, family or Family())):
        return cohort
    if is_longitudinal:
        changes = [_of_occasions(cohort, group, law) for group in cohort.groups]
    else:
        changes = _of_cells(cohort, labels, law)
    return replace(cohort, changes=tuple(change for change in changes if change.exchanges or change.failures))


def _of_cells(cohort: Cohort, labels: Sequence[tuple[str, str]], law: str) -> list[GroupAttribution]:
    """Return what makes the second cell of each pair differ from the first, or why that is not told."""
    if cohort.repeated:
        return [GroupAttribution(after, before, after, {}, {(before, after): _REPEATED}, of_groups=True)
                for before, after in labels[:1]]  # fmt: skip
    max_pairs = max(1, _MAX_CROSSED_PAIRS // len(labels)) if cohort.crossed else MAX_PAIRS
    return [_of_groups(cohort, pair, law, max_pairs) for pair in labels]


def _compared_cells(cohort: Cohort) -> list[tuple[str, str]]:
    """Return which cells are compared: groups with the reference at one level, levels with the first in one group."""
    labels = {(cell.group, cell.level): label for label, cell in cohort.cells.items()}
    groups, levels = list(cohort.groups), levels_of(cohort.second) or [""]
    pairs = [((groups[0], level), (group, level)) for group in groups[1:] for level in levels]
    pairs += [((group, levels[0]), (group, level)) for level in levels[1:] for group in groups]
    return [(labels[before], labels[after]) for before, after in pairs if before in labels and after in labels]


def _of_occasions(cohort: Cohort, group: str, law: str) -> GroupAttribution:
    assert cohort.second is not None
    first, *_, last = cohort.second.order  # however many there are between
    recorded = list(_recorded_twice(cohort, group, first, last))
    states, failures = _states([result for pair in recorded for result in pair], law)
    pairs = [(states[before.name], states[after.name]) for before, after in recorded
             if before.name in states and after.name in states]  # fmt: skip
    return _made((group, first, last), pairs, failures, of_groups=False)


def _of_groups(cohort: Cohort, labels: tuple[str, str], law: str, max_pairs: int) -> GroupAttribution:
    """Exchange animals of a cell with those of another, and the images that several of them share."""
    members = [result for label in labels for result in cohort.cells[label].results if law in result.laws]
    images = numbered(members, _IMAGE, cohort.variables[_IMAGE].levels if _IMAGE in cohort.variables else {})
    states, failures = _states(members, law, images, cohort.lungs.sd)
    befores, afters = (
        [states[result.name] for result in cohort.cells[label].results if result.name in states] for label in labels
    )
    pairs = _pairs(befores, afters, max_pairs)
    made = _made((labels[1], *labels), pairs, failures, of_groups=True)
    if not made.exchanges:
        return made
    shared = np.flatnonzero(np.bincount(images) > 1)
    return replace(made, of_images=tuple(_of_image(pairs, made, int(image)) for image in shared))


def _made(
    names: tuple[str, str, str],
    pairs: Sequence[_StatePair],
    failures: Mapping[tuple[str, str], str],
    of_groups: bool,
) -> GroupAttribution:
    exchanges, failures = {}, dict(failures)
    for before, after in pairs:
        pair = before.name, after.name
        try:
            exchanges[pair] = _exchanged(before, after)
        except VasowaveError as error:
            failures[pair] = str(error)
    return GroupAttribution(*names, exchanges, failures, of_groups)


def _states(
    results: Sequence[AnimalResult], law: str, images: Sequence[int] | np.ndarray = (), lung_sd: float = 0.0
) -> tuple[dict[str, _FittedState], dict[tuple[str, str], str]]:
    """Return the fitted animals by name, and why others are absent: their law is not here."""
    states, failures = {}, {}
    for place, result in enumerate(results):
        try:
            states[result.name] = _state(result, law, int(images[place]) if len(images) else 0, lung_sd)
        except VasowaveError as error:
            failures[result.name, result.name] = str(error)
    return states, failures


def _state(result: AnimalResult, law: str, image: int, lung_sd: float) -> _FittedState:
    """Return a fitted animal whose radii err with those of its image, and as its lung differs from the imaged one."""
    model, quantities = stored_model(result, law), result.laws[law].quantities
    slopes = {
        str(name): float(quantities[name].attrs.get("per_radius", 0.0))
        for name in result.laws[law].calibration["parameter"].values
    }
    image_sd = {error.name: error.sd for error in result.assumed_errors}.get("radius_scale", 0.0)
    inflow, numerics = stored_inflow(result, law), stored_numerics(result, law)
    return _FittedState(result.name, model, inflow, numerics, image, float(np.hypot(image_sd, lung_sd)), slopes)


def _exchanged(before: _FittedState, after: _FittedState) -> ComponentExchange:
    made = attribute_change(before.model, after.model, (before.inflow, after.inflow), before.numerics)
    return ComponentExchange(made.table, made.undone)


def _pairs(befores: Sequence[_FittedState], afters: Sequence[_FittedState], max_pairs: int) -> list[_StatePair]:
    """Return all pairs, or as many as are worked on, in which every animal stands about as often."""
    befores, afters = _spread(befores), _spread(afters)
    count = max(len(befores), len(afters))
    vessels = max((len(state.model.network) for state in (*befores, *afters)), default=1)
    limit = min(max(max_pairs, count), max(count, _MAX_VESSELS // vessels))
    if len(befores) * len(afters) <= limit:
        return [(before, after) for after in afters for before in befores]
    return [
        (befores[(place + shift) % len(befores)], afters[place % len(afters)])
        for shift in range(limit // count)
        for place in range(count)
    ]


def _spread(states: Sequence[_FittedState]) -> list[_FittedState]:
    places = np.linspace(0, len(states) - 1, min(len(states), MAX_PAIRS)).round().astype(int)
    return [states[place] for place in places]


def _of_image(pairs: Sequence[_StatePair], made: GroupAttribution, image: int) -> ComponentExchange:
    """Return what the means would be more were the radii of an image one SD larger, by a typical pair that has it.

    NaN, which leaves means without intervals, where that cannot be simulated.
    """
    exchanged = [(pair, made.exchanges[names]) for pair in pairs
                 if (names := (pair[0].name, pair[1].name)) in made.exchanges]  # fmt: skip
    imaged = [entry for entry in exchanged if image in (entry[0][0].image, entry[0][1].image)]
    if not imaged:
        exchange = exchanged[0][1]
        return ComponentExchange(0.0 * exchange.shares.iloc[:, 3:], 0.0 * exchange.undone)
    changes = np.array([exchange.shares.loc["mPAP", "change"] for _, exchange in imaged], dtype=float)
    pair, exchange = imaged[int(np.abs(changes - np.median(changes)).argmin())]
    share = len(imaged) / len(exchanged)  # of the mean that the image moves
    shares, undone = exchange.shares.iloc[:, 3:], exchange.undone
    try:
        moved = _exchanged(*(state.imaged_wider() if state.image == image else state for state in pair))
    except VasowaveError:
        return ComponentExchange(np.nan * shares, np.nan * undone)
    differences = (
        share * (after.reindex(columns=before.columns, fill_value=0.0) - before)
        for before, after in ((shares, moved.shares), (undone, moved.undone))
    )
    return ComponentExchange(*differences)


def _recorded_twice(cohort: Cohort, group: str, first: str, last: str) -> Iterator[tuple[AnimalResult, AnimalResult]]:
    """Go through the animals of a group that have both occasions, each with its first recording of either."""
    assert cohort.second is not None
    level = cohort.second.levels
    recorded: dict[str, dict[str, AnimalResult]] = {}
    for result in cohort.groups[group]:
        recorded.setdefault(cohort.subjects[result.name], {}).setdefault(level.get(result.name, ""), result)
    for results in recorded.values():
        if first in results and last in results:
            yield results[first], results[last]
