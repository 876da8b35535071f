"""What made the change of animals that were recorded twice, or the difference of two groups, as values."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import pandas as pd

from vasowave.base.descriptions import LEVEL

_MIN_ANIMALS = 3  # from which on a mean has an interval
_TITLES = ["group", "before", "after", "quantity", "unit", "value before", "value after", "change"]


class ComponentExchange(NamedTuple):
    """What the exchange of components between two states does, see `pulse.analysis.attribution.Attribution`."""

    shares: pd.DataFrame
    undone: pd.DataFrame


@dataclass(frozen=True, eq=False)
class GroupAttribution:
    """What made a group what it is: its change between two occasions, or its difference from another group.

    Attributes
    ----------
    group : str
    first, last : str
        The two occasions; of groups the reference and this group.
    exchanges : dict of (str, str) to ComponentExchange
        By the names of the two recordings.
    failures : dict of (str, str) to str
        Why pairs are absent.
    of_groups : bool
        Whether animals of two groups were exchanged, and not two occasions of one animal.
    of_images : tuple of ComponentExchange
        What an error of one SD of each image that several animals share moves.
    """

    group: str
    first: str
    last: str
    exchanges: dict[tuple[str, str], ComponentExchange]
    failures: dict[tuple[str, str], str]
    of_groups: bool
    of_images: tuple[ComponentExchange, ...] = ()

    def animals(self) -> list[int]:
        """Return how many animals were exchanged: of the group and of the reference, or with both occasions."""
        befores, afters = zip(*self.exchanges, strict=True)
        return [len(set(afters)), len(set(befores))] if self.of_groups else [len(afters)]

    def means(self, quantity: str, kind: str = "shares") -> pd.DataFrame:
        """Return means over the animals, ``mean, low, high`` (95 %), of the shares or of what is undone.

        Of shares the first row is ``change``, then what was exchanged; what does not differ in a pair has 0 there.
        Intervals are by Student; of two groups by Welch, to which errors of shared images are added.
        """
        rows = self.rows(quantity, kind)
        margins = [rows.groupby(level=level).mean() for level in ((0, 1) if self.of_groups else (1,))]
        images = self._image_variance(quantity, kind, rows.columns)
        return _with_interval(rows.mean(), margins, images, _of_partners(len(rows), *map(len, margins)))

    def rows(self, quantity: str, kind: str = "shares") -> pd.DataFrame:
        """Return the shares of every pair, or what is undone, a row each; what does not differ in a pair has 0."""
        of_pairs = {pair: _changes(getattr(exchange, kind).loc[quantity]) for pair, exchange in self.exchanges.items()}
        columns = list(dict.fromkeys(column for of_pair in of_pairs.values() for column in of_pair.index))
        return pd.DataFrame(of_pairs).T.reindex(columns=columns).fillna(0.0)  # the union of pandas is sorted

    def _image_variance(self, quantity: str, kind: str, columns: pd.Index) -> np.ndarray:
        moved = (
            _changes(getattr(of_image, kind).loc[quantity]).reindex(columns, fill_value=0.0)
            for of_image in self.of_images
        )
        return sum((error.to_numpy() ** 2 for error in moved), np.zeros(len(columns)))


def difference_of_changes(group: GroupAttribution, reference: GroupAttribution, quantity: str) -> pd.DataFrame:
    """Return by how much a group changed more than another, and the shares of that, as `GroupAttribution.means` does.

    Intervals are Welch's: the animals of the two groups are others.
    """
    rows = [changed.rows(quantity) for changed in (group, reference)]
    columns = list(dict.fromkeys(column for of_group in rows for column in of_group))
    ours, theirs = (of_group.reindex(columns=columns, fill_value=0.0) for of_group in rows)
    return _with_interval(ours.mean() - theirs.mean(), [ours, theirs], np.zeros(len(columns)))


def _of_partners(pairs: int, befores: int, afters: int = 1) -> float:
    """Return how many times the scatter of the means of animals exceeds that of the animals, as each is a mean over a
    few partners that other animals do not have; 1 where all are exchanged with all.
    """
    return 1.0 if afters == 1 else 1 + min(befores / pairs - 1 / afters, afters / pairs - 1 / befores)


def _with_interval(
    mean: pd.Series, margins: Sequence[pd.DataFrame], added: np.ndarray, excess: float = 1.0
) -> pd.DataFrame:
    """Return means with 95 % intervals by the scatter of animals, each kind with a row each, and an added variance."""
    from scipy.stats import t as student

    if min(map(len, margins)) < _MIN_ANIMALS:
        return pd.DataFrame({"mean": mean, "low": np.nan, "high": np.nan})
    variances = np.array([of_animals.var(ddof=1) / len(of_animals) for of_animals in margins])
    freedoms = np.array([[len(of_animals) - 1] for of_animals in margins])
    scatter, by_freedom = variances.sum(axis=0), (variances**2 / freedoms).sum(axis=0)
    freedom = np.divide(scatter**2, by_freedom, where=by_freedom > 0, out=np.full(len(scatter), np.inf))
    half = student.ppf((1 + LEVEL) / 2, freedom / excess) * np.sqrt(scatter / excess + added)
    return pd.DataFrame({"mean": mean, "low": mean - half, "high": mean + half})


def _changes(row: pd.Series) -> pd.Series:
    return row.drop(["unit", "before", "after"], errors="ignore").astype(float)


def attribution_table(groups: Iterable[GroupAttribution]) -> pd.DataFrame:
    """Return the shares of single pairs, a row for each pair and quantity.

    Columns ``group, before, after`` (the two animals, or occasions of one), ``quantity, unit, value before, value
    after, change`` and one for each component, in the unit of the row.
    """
    tables = [
        exchange.shares.rename(columns={"before": "value before", "after": "value after"})
        .rename_axis("quantity")
        .reset_index()
        .assign(group=changed.group, before=before, after=after)
        for changed in groups
        for (before, after), exchange in changed.exchanges.items()
    ]
    if not tables:
        return pd.DataFrame(columns=_TITLES)
    table = pd.concat(tables, ignore_index=True)
    return table[_TITLES + [column for column in table if column not in _TITLES]].fillna(0.0)
