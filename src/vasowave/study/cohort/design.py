"""How a lab laid out its animals: what groups are compared for, what is adjusted for, who belongs together."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import product
from typing import Annotated, Any

import numpy as np
from annotated_types import MinLen
from pydantic import BeforeValidator

from vasowave.base.errors import InputError, did_you_mean
from vasowave.base.io.columns import split_unit
from vasowave.base.settings import Example, settings_class
from vasowave.study.cohort.contrast import Contrast, DesignCells, NotEstimable, split_estimable
from vasowave.study.cohort.effects import ContrastLabel
from vasowave.study.cohort.mixed import is_diagonal
from vasowave.study.cohort.variables import Variable


def _as_titled(name: Any) -> Any:
    """Return the name of a column as tables are read: capitals do not count, and a unit stands beside the name."""
    return split_unit(name)[0].lower() if isinstance(name, str) else name


MIN_TIMES = 3
"""Times of a design from which on recordings of a subject that are near in time may be more alike than those far
apart."""
DRIFT = "subjects: drift"
"""The variance component of what they have in common beyond their subject."""

Column = Annotated[str, BeforeValidator(_as_titled), MinLen(1)]


@settings_class
class Design:
    """How the animals were laid out, by columns of the table of animals; all empty: groups of independent animals.

    Examples
    --------
    >>> import vasowave as vw
    >>> vw.Design(covariates=("sex",), blocks=("litter",)).terms
    ('sex', 'litter')
    """

    covariates: tuple[Column, ...] = ()
    """Columns that groups are adjusted for: categories (sex), numbers (age, weight, hematocrit) or dates."""
    blocks: tuple[Column, ...] = ()
    """Columns whose levels are random effects: litter, batch, day, operator."""
    subject: Column | None = None
    """Column that says which rows are of one animal: pairs and repeated measures."""
    occasion: Column | None = None
    """Column of when a subject was measured (before, after; 0, 3, 6 weeks); compared as a second factor."""
    factor: Column | None = None
    """Column of a second factor, crossed with the groups (genotype in `group`, oxygen here)."""
    interaction: bool = True
    """Whether the second factor may act differently in each group; that then is a comparison of its own."""
    dose: Column | None = None
    """Column of numbers whose trend is compared: a dose, or time."""
    contrasts: Annotated[dict[str, dict[str, float]], Example({"rescue": {"HPH, drug": 1, "HPH, vehicle": -1}})] = (
        field(default_factory=dict)
    )
    """Comparisons of one's own, in place of the usual ones: of each a name, and the weights of groups (or of "group,
    level" where there is a second factor or dose); they sum to 0."""
    crossover: bool = False
    """Whether a subject may be in several groups, one after the other; otherwise that is an error."""

    def __post_init__(self) -> None:
        """Refuse what cannot be together."""
        named = [name for name in ("occasion", "factor", "dose") if getattr(self, name)]
        if len(named) > 1:
            raise InputError(f"{' and '.join(named)}: a design has one of these; make one column of two")
        if self.occasion and not self.subject:
            raise InputError(
                f"occasion: {self.occasion}: name the column that says which recordings are of one animal as subject; "
                "without it they would count as different animals. Of other animals at each time it is a factor"
            )
        if self.crossover and not self.subject:
            raise InputError("crossover: name the column that says which recordings are of one animal as subject")
        twice = [name for name in dict.fromkeys(self.terms) if self.terms.count(name) > 1]
        if twice:
            raise InputError(f"'{twice[0]}' stands in two places; keep one")
        for name, weights in self.contrasts.items():
            if len(weights) < 2 or abs(sum(weights.values())) > 1e-9 or not any(weights.values()):
                raise InputError(f"contrast '{name}': its weights must sum to 0, as in {{HPH: 1, CTL: -1}}")

    @property
    def terms(self) -> tuple[str, ...]:
        """The columns that it names."""
        single = (self.subject, self.second)
        return (*self.covariates, *self.blocks, *(name for name in single if name))

    @property
    def second(self) -> str | None:
        """The column that is crossed with the groups, if there is one."""
        return self.factor or self.occasion or self.dose

    @property
    def plain(self) -> bool:
        """Whether it says nothing: groups of independent animals, each compared with the first."""
        return not (self.terms or self.contrasts)


@dataclass(frozen=True, eq=False)
class Layout:
    """A design applied to animals: the matrices of its model."""

    animals: tuple[str, ...]
    """Those that all columns of the design know."""
    group: tuple[str, ...]
    """Of each animal."""
    cells: tuple[str, ...]
    """Combinations of group and second factor."""
    cell: np.ndarray
    """Int, shape (animal,)."""
    fixed: np.ndarray
    """Independent columns. Shape (animal, coefficient)."""
    means: np.ndarray
    """What takes coefficients to the mean of a cell, at the average of the covariates. Shape (cell, coefficient)."""
    lost: np.ndarray
    """Of the mean of each cell, what nothing tells; 0 in sides and contrasts that have a mean. Shape (cell, any)."""
    random: Mapping[str, np.ndarray]
    """Variance components by what they belong to. Shape (animal, animal)."""
    contrasts: tuple[Contrast, ...]
    """Those that the animals tell."""
    untold: tuple[NotEstimable, ...]
    """Those that were asked for and that they do not tell."""
    left_out: Mapping[str, str]
    """Animals that a column of the design does not know, and which column."""
    subject: tuple[str, ...]
    """Of each animal; its own name where the design has no subjects."""

    def left_for_scatter(self, blocks: Sequence[str]) -> int:
        """Return how many animals are left when each coefficient and each level of the blocks has taken one."""
        taken = np.hstack([self.fixed, *(self.random[name] for name in blocks if name in self.random)])
        return len(self.animals) - int(np.linalg.matrix_rank(taken))

    @property
    def repeated(self) -> bool:
        """Whether an animal has more than one recording."""
        return len(set(self.subject)) < len(self.animals)

    @property
    def text(self) -> str:
        """What is compared, of how many: a sentence or two."""
        count, subjects = len(self.animals), len(set(self.subject))
        sample = f"{count} recordings of {subjects} animals" if self.repeated else f"{count} animals"
        side_kind = "change" if self.repeated else "ratio"  # nothing changes between animals
        omissions = f" Left out, for a column does not know them: {', '.join(self.left_out)}." if self.left_out else ""
        effects = "; ".join(contrast.label.describe(side_kind) for contrast in self.contrasts)
        return f"{sample}; compared: {effects or 'nothing'}.{omissions}"

    def has_mean(self, side: np.ndarray) -> bool:
        """Whether the animals tell the mean that one side of a contrast is."""
        return not self.lost.size or float(np.abs(side @ self.lost).max()) < 1e-7


def laid_out(
    design: Design, variables: Mapping[str, Variable], members: Mapping[str, str], groups: Sequence[str]
) -> Layout:
    """Return the matrices of a design.

    Parameters
    ----------
    design : Design
    variables : mapping of str to Variable
        By name.
    members : mapping of str to str
        The group of every animal.
    groups : sequence of str
        In their order, the reference first.

    Raises
    ------
    InputError
        A column is missing or of the wrong type; two things cannot be told apart; too few animals are left.
    """
    design_variables = {name: _variable(design, variables, name) for name in design.terms}
    gaps = {
        animal: next((name for name, variable in design_variables.items() if animal not in variable.values), "")
        for animal in members
    }
    animals = tuple(animal for animal, gap in gaps.items() if not gap)
    group = tuple(members[animal] for animal in animals)
    second = design_variables[design.second] if design.second else None
    levels = second.order if second else [""]
    within = [second.levels[animal] for animal in animals] if second else [""] * len(animals)
    pairs = [(label, level) for label, level in product(groups, levels)]
    if design.dose:  # groups of which each has doses of its own
        pairs = [pair for pair in pairs if pair in set(zip(group, within, strict=True))]
    cell = np.array([pairs.index(pair) for pair in zip(group, within, strict=True)], dtype=int)
    cells = tuple(", ".join(filter(None, pair)) for pair in pairs)
    coefficients = _coefficients(design, groups, levels, pairs)
    covariates = [column for name in design.covariates for column in covariate_columns(design_variables[name], animals)]
    model_matrix = np.column_stack([coefficients[cell], *covariates]) if len(animals) else np.zeros((0, 1))
    if len(animals) <= np.linalg.matrix_rank(model_matrix) + 1:
        count_text = "1 animal is" if len(animals) == 1 else f"{len(animals)} animals are"
        raise InputError(f"{count_text} too few for this design; name fewer columns in it")
    _, sizes, turned = np.linalg.svd(model_matrix, full_matrices=False)
    basis = turned[sizes > 1e-9 * sizes[0]].T
    means = np.column_stack([coefficients, np.zeros((len(pairs), len(covariates)))])
    subject = (
        tuple(design_variables[design.subject].levels[animal] for animal in animals) if design.subject else animals
    )
    nearness = _nearness(second, animals) if design.subject and not design.factor else None
    random = _random(design, design_variables, animals, cell, subject, model_matrix @ basis, nearness)
    owners = [name for name in design.covariates for _ in covariate_columns(design_variables[name], animals)]
    table = DesignCells(
        pairs, np.bincount(cell, minlength=len(pairs)) > 0, means, model_matrix, owners, design.second or ""
    )
    requested = list(_contrasts(design, groups, levels, pairs, cells, second))
    contrasts, untold = split_estimable(requested, table, smaller=not (design.dose or design.contrasts))
    return Layout(
        animals, group, cells, cell, model_matrix @ basis, means @ basis, means - means @ basis @ basis.T, random,
        contrasts, untold, {animal: gap for animal, gap in gaps.items() if gap}, subject,
    )  # fmt: skip


def _variable(design: Design, variables: Mapping[str, Variable], name: str) -> Variable:
    if name == "group":
        raise InputError("'group' is not a column of the lab's own: groups are compared in every design; take it out")
    if name == "animal":
        raise InputError("'animal' names each row; give a column of the lab's own, as one that says which mouse it was")
    if name not in variables:
        hint = f"there are: {', '.join(variables)}" if variables else "it has no columns of its own"
        raise InputError(f"the table of animals has no column '{name}'{did_you_mean(name, variables)}; {hint}")
    variable = variables[name]
    if name == design.dose and variable.kind == "category":
        raise InputError(f"the column '{name}' holds words; a dose needs numbers")
    if not variable.values:
        raise InputError(f"the column '{name}' is empty; fill its cells or take it out of the design")
    return variable


def _coefficients(
    design: Design, groups: Sequence[str], levels: Sequence[str], pairs: Sequence[tuple[str, str]]
) -> np.ndarray:
    """Return what takes coefficients to the means of cells: one for each cell, or the sum of two effects."""
    if design.interaction or design.dose or len(levels) == 1:
        return np.eye(len(pairs))
    return np.array(
        [[label == group for label in groups] + [label == level for label in levels[1:]] for group, level in pairs],
        float,
    )


def covariate_columns(variable: Variable, animals: Sequence[str]) -> list[np.ndarray]:
    """Return the columns of a covariate, so coded that cells are compared at its average."""
    if variable.kind != "category":
        values = np.array([variable.numbers[animal] for animal in animals])
        spread = values.std()
        return [(values - values.mean()) / spread] if spread > 0 else []
    levels = [variable.levels[animal] for animal in animals]
    return [np.array([(level == coded_level) - (level == variable.order[-1]) for level in levels], float)
            for coded_level in variable.order[:-1] if coded_level in levels]  # fmt: skip


def _nearness(occasion: Variable | None, animals: Sequence[str]) -> np.ndarray | None:
    """Return 1 for rows of one time down to 0 for the first and the last, by the time between; None of few times.

    Times that are words are equally far apart, in their order.
    """
    if occasion is None or len(occasion.order) < MIN_TIMES:
        return None
    place = {level: float(number) for number, level in enumerate(occasion.order)}
    times = np.array([occasion.numbers.get(animal, place[occasion.levels[animal]]) for animal in animals])
    between = np.abs(np.subtract.outer(times, times))
    return np.asarray(1 - between / max(float(between.max()), 1e-300))


def _random(
    design: Design, design_variables: Mapping[str, Variable], animals: Sequence[str], cell: np.ndarray,
    subject: Sequence[str], fixed: np.ndarray, nearness: np.ndarray | None,
) -> dict[str, np.ndarray]:  # fmt: skip
    """Return the variance components; cells have each their own where no subject is in two and each tells enough.

    Subjects that are recorded three times or more also drift: their recordings are the more alike the nearer they are,
    by a covariance, linear in a variance, that falls in a straight line with the time between them. All cells share it.
    """
    blocks = {name: _same([design_variables[name].levels[animal] for animal in animals]) for name in design.blocks}
    same = _same(subject)
    drifts = [] if nearness is None else [{DRIFT: same * nearness}]
    strata = _strata(cell, subject)
    components: dict[str, np.ndarray] = {}
    for drift, stratum_labels in product([*drifts, {}], (strata, np.zeros_like(strata))):
        components = {}
        for stratum in np.unique(stratum_labels):
            inside = np.outer(stratum_labels == stratum, stratum_labels == stratum)
            components[f"animals {stratum}"] = np.eye(len(animals)) * inside
            components[f"subjects {stratum}"] = same * inside
        components |= drift | blocks
        components = {
            name: component
            for name, component in components.items()
            if name.startswith("animals") or not is_diagonal(component)
        }
        if min(np.bincount(stratum_labels)[np.unique(stratum_labels)]) > 2 and not _confounded(components, fixed):
            return components
    if name := _confounded(components, fixed):
        raise InputError(
            f"'{name}' cannot be told apart from the groups or from the differences between animals: its levels hold "
            "one animal each, or a whole group; take it out of the design"
        )
    return components


def _same(labels: Sequence[str]) -> np.ndarray:
    names = np.array(labels)
    return (names[:, np.newaxis] == names).astype(float)


def _strata(cell: np.ndarray, subject: Sequence[str]) -> np.ndarray:
    """Return a number for each animal, the same in cells that a subject links."""
    strata = cell.copy()
    for label in set(subject):
        members = np.array([name == label for name in subject])
        for number in np.unique(strata[members])[1:]:
            strata[strata == number] = strata[members].min()
    return strata


def _confounded(random: Mapping[str, np.ndarray], fixed: np.ndarray) -> str:
    """Return the first variance component that the values cannot tell from others or from the fixed effects."""
    projection = np.eye(len(fixed)) - fixed @ np.linalg.pinv(fixed)
    basis: list[np.ndarray] = []
    for name, component in random.items():
        projected = (projection @ component @ projection).ravel()
        remainder = projected
        if basis:
            remainder = projected - np.array(basis).T @ np.linalg.lstsq(np.array(basis).T, projected, rcond=None)[0]
        if np.linalg.norm(remainder) < 1e-6 * max(float(np.linalg.norm(component)), 1.0):
            return name
        basis.append(projected)
    return ""


def _contrasts(
    design: Design,
    groups: Sequence[str],
    levels: Sequence[str],
    pairs: Sequence[tuple[str, str]],
    cells: Sequence[str],
    second: Variable | None,
) -> Iterator[Contrast]:
    """Return the comparisons: those that the design names, or the usual ones of its kind."""
    if design.contrasts:
        for name, weights in design.contrasts.items():
            for cell in weights:
                if cell not in cells:
                    raise InputError(f"contrast '{name}': no cell '{cell}'{did_you_mean(cell, cells)}; there are: "
                                     f"{'; '.join(cells)}")  # fmt: skip
            signed = np.array([weights.get(cell, 0.0) for cell in cells])
            yield Contrast(ContrastLabel(name, "", "contrast"), np.maximum(-signed, 0), np.maximum(signed, 0))
        return
    inside = {group: np.array([float(label == group) for label, _ in pairs]) for group in groups}
    reference, *compared_groups = groups
    if design.dose and second is not None:
        yield from _trends(groups, pairs, inside, second)
        return
    mean = {group: indicator / max(indicator.sum(), 1) for group, indicator in inside.items()}
    for compared in compared_groups:
        yield Contrast(ContrastLabel(compared, reference), mean[reference], mean[compared])
    if second is None:
        return
    of_level = {level: np.array([float(label == level) for _, label in pairs]) for level in levels}
    at_cell = {(group, level): inside[group] * of_level[level] for group in groups for level in levels}
    over = {level: np.mean([at_cell[group, level] for group in groups], axis=0) for level in levels}
    base, *later = levels
    for level in later:
        label = ContrastLabel(second.titled(level), second.titled(base), "factor")
        yield Contrast(label, over[base], over[level])
    if design.interaction:
        for compared, level in product(compared_groups, later):
            change = {group: at_cell[group, level] - at_cell[group, base] for group in (reference, compared)}
            label = ContrastLabel(compared, reference, "interaction", f"{level}/{base}")
            yield Contrast(label, change[reference], change[compared])


def _trends(
    groups: Sequence[str], pairs: Sequence[tuple[str, str]], inside: Mapping[str, np.ndarray], dose: Variable
) -> Iterator[Contrast]:
    """Return the trend over all cells, or where groups have doses of their own, in each group and between them."""
    size: dict[str, float] = {dose.levels[animal]: number for animal, number in dose.numbers.items()}
    doses = np.array([size[level] for _, level in pairs])

    def ends(indicator: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the weights that the line through cells has at the lowest and at the highest dose."""
        away = np.where(indicator > 0, doses - doses[indicator > 0].mean(), 0.0)
        low, high = (place - doses[indicator > 0].mean() for place in (doses.min(), doses.max()))
        mean = indicator / indicator.sum()
        return mean + away * low / (away @ away), mean + away * high / (away @ away)

    lowest, highest = (f"{dose.name} {pairs[int(place)][1]}" for place in (doses.argmin(), doses.argmax()))
    trend = ContrastLabel(highest, lowest, "trend")
    if len(groups) == 1 or any(inside[group].sum() < 2 for group in groups):
        yield Contrast(trend, *ends(np.ones(len(pairs))))
        return
    sides = {group: ends(inside[group]) for group in groups}
    first, second = (np.mean([sides[group][side] for group in groups], axis=0) for side in (0, 1))
    yield Contrast(trend, first, second)
    reference, *compared_groups = groups
    for compared in compared_groups:
        change = {group: sides[group][1] - sides[group][0] for group in (reference, compared)}
        label = ContrastLabel(compared, reference, "interaction", f"{highest}/{lowest}")
        yield Contrast(label, change[reference], change[compared])
        mean = {group: inside[group] / inside[group].sum() for group in (reference, compared)}
        yield Contrast(ContrastLabel(compared, reference), mean[reference], mean[compared])
