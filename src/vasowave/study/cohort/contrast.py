"""The comparisons of a design: which its animals tell, what is told in place of others, and what is left to judge."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from vasowave.base.findings import Finding, error_kind, look_kind
from vasowave.study.cohort.effects import ContrastLabel

CONFOUNDED = look_kind(
    "design.confounded", "{effect}{instead}: not compared, for {columns} differs just as it does, and nothing tells "
    "one from the other; {remedy}", "take the column out of covariates, and write that it may be the reason",
)  # fmt: skip
NO_CELL = look_kind(
    "design.no-cell", "{effect}{instead}: not compared, for nothing is known of {cells}; {remedy}",
    "add animals there if there are any",
)  # fmt: skip
NOTHING_TOLD = error_kind(
    "design.nothing-told", "nothing can be compared by this design: {columns} cannot be told apart from {effects}; "
    "{remedy}", "take it out of the design, or add animals in which they differ",
)  # fmt: skip
NOBODY = error_kind(
    "design.nobody", "nothing can be compared by this design: {effects} would need recordings of {cells}; {remedy}",
    "add them, or name other comparisons",
)  # fmt: skip
MIN_FREEDOM = 4
"""Degrees of freedom below which a study is told: quantiles of Student's t for many rows grow steeply there."""


class Contrast(NamedTuple):
    """One comparison of the means of cells: `second` minus `first`, on logarithms; weights of shape (cell,)."""

    label: ContrastLabel
    first: np.ndarray
    second: np.ndarray

    @property
    def text(self) -> str:
        """What is compared with what, in words."""
        return self.label.describe("change")

    @property
    def weights(self) -> np.ndarray:
        """What takes the means of cells to the comparison, shape (cell,)."""
        return self.second - self.first

    @property
    def cells(self) -> np.ndarray:
        """Whether each cell has a part in it."""
        return np.asarray((self.first != 0) | (self.second != 0))

    @property
    def of_values(self) -> bool:
        """Whether both sides are means of values, and not themselves ratios."""
        return bool(np.allclose([self.first.sum(), self.second.sum()], 1))

    @property
    def of_ratios(self) -> bool:
        """Whether both sides are themselves ratios."""
        return bool(np.allclose([self.first.sum(), self.second.sum()], 0) and self.first.any())


class DesignCells(NamedTuple):
    """The cells of a design, and what its model makes of them."""

    pairs: Sequence[tuple[str, str]]
    """Group and level of the second factor."""
    filled: np.ndarray
    """Whether any animal is in it. Bool, shape (cell,)."""
    means: np.ndarray
    """What takes the columns' coefficients to the mean of a cell. Shape (cell, column)."""
    rows: np.ndarray
    """All columns of the fixed effects; they may depend on each other. Shape (animal, column)."""
    owners: Sequence[str]
    """The covariates of the last columns."""
    second: str
    """Name of the second factor; empty where there is none."""

    def tells(self, weights: np.ndarray, without: Sequence[str] = ()) -> bool:
        """Whether the animals tell a sum of cell means: it is one of rows; `without` are covariates to leave out."""
        column_owners = [""] * (self.rows.shape[1] - len(self.owners)) + [*self.owners]
        selected = np.array([name not in without for name in column_owners])
        rows, sought = self.rows[:, selected], (weights @ self.means)[selected]
        solution = np.linalg.lstsq(rows.T, sought, rcond=None)[0]
        return bool(np.abs(rows.T @ solution - sought).max() < 1e-7 * max(1.0, float(np.abs(sought).max())))

    def names(self, mask: np.ndarray) -> tuple[str, ...]:
        """Return the names of some cells."""
        return tuple(", ".join(filter(None, pair)) for pair, selected in zip(self.pairs, mask, strict=True) if selected)


class NotEstimable(NamedTuple):
    """A comparison that was asked for and that the animals do not tell."""

    contrast: Contrast
    columns: tuple[str, ...]
    """The covariates that go with it; without them it would be told."""
    cells: tuple[str, ...]
    """Those of which nothing is known."""
    instead: str = ""
    """What is compared in its place; empty if nothing is."""

    @property
    def finding(self) -> Finding:
        """What is not compared, and why."""
        instead = f" (compared is {self.instead})" if self.instead else ""
        if self.columns:
            return CONFOUNDED(effect=self.contrast.text, columns=" and ".join(self.columns), instead=instead)
        return NO_CELL(effect=self.contrast.text, cells="; ".join(self.cells), instead=instead)


def split_estimable(
    contrasts: Sequence[Contrast], cells: DesignCells, smaller: bool = True
) -> tuple[tuple[Contrast, ...], tuple[NotEstimable, ...]]:
    """Return the comparisons that animals tell, those in place of others among them, and those that they do not."""
    estimable, untold = [], []
    for contrast in contrasts:
        if cells.tells(contrast.weights):
            estimable.append(contrast)
            continue
        instead = _smaller(contrast, cells) if smaller else None
        estimable += [instead] if instead else []
        untold.append(_not_estimable(contrast, cells)._replace(instead=instead.text if instead else ""))
    return tuple(estimable), tuple(untold)


def untold_findings(estimable: Sequence[Contrast], untold: Sequence[NotEstimable]) -> list[Finding]:
    """Return what a study cannot compare; an error if it then compares nothing."""
    if estimable or not untold:
        return [effect.finding for effect in untold]
    effects = "; ".join(effect.contrast.text for effect in untold)
    if columns := dict.fromkeys(name for effect in untold for name in effect.columns):
        return [NOTHING_TOLD(columns=" and ".join(columns), effects=effects)]
    return [NOBODY(effects=effects, cells="; ".join(dict.fromkeys(cell for effect in untold for cell in effect.cells)))]


def _not_estimable(contrast: Contrast, cells: DesignCells) -> NotEstimable:
    weights, covariates = contrast.weights, list(dict.fromkeys(cells.owners))
    if covariates and cells.tells(weights, covariates):
        alone = [name for name in covariates if cells.tells(weights, [name])]
        return NotEstimable(contrast, tuple(alone or covariates), ())
    return NotEstimable(contrast, (), cells.names(contrast.cells & ~cells.filled))


def _smaller(contrast: Contrast, cells: DesignCells) -> Contrast | None:
    """Return the comparison of groups at the levels that tell it, or of levels in the groups that do."""
    if contrast.label.kind not in ("groups", "factor"):
        return None
    across = 1 if contrast.label.kind == "groups" else 0  # levels where groups are compared, groups where levels are
    selected = np.zeros(len(cells.pairs), dtype=bool)
    places = dict.fromkeys(pair[across] for pair in cells.pairs)
    good = []
    for place in places:
        mask = np.array([pair[across] == place for pair in cells.pairs])
        if (contrast.first[mask].any() and contrast.second[mask].any()
                and cells.tells(mask * contrast.weights)):  # fmt: skip
            selected |= mask
            good.append(place)
    if not good or len(good) == len(places):
        return None
    first, second = (side * selected / (side * selected).sum() for side in (contrast.first, contrast.second))
    within = f"{f'at {cells.second}' if across else 'in'} {' and '.join(good)}"
    return Contrast(contrast.label._replace(within=within), first, second)
