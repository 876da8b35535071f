"""What made the change of animals that were recorded before and after, by group, as values."""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
import pandas as pd

from vasowave.base.descriptions import LEVEL

_MIN_ANIMALS = 3  # from which on a mean has an interval
_TITLES = ["group", "animal", "quantity", "unit", "before", "after", "change"]


@dataclass(frozen=True, eq=False)
class GroupAttribution:
    """The shares of a change in the animals of a group.

    Attributes
    ----------
    group, first, last : str
        The group, and the occasions between which it changed.
    tables : dict of str to DataFrame
        By animal, see `vasowave.pulse.analysis.attribution.Attribution`.
    failures : dict of str to str
        Why other animals are absent.
    """

    group: str
    first: str
    last: str
    tables: dict[str, pd.DataFrame]
    failures: dict[str, str]

    def means(self, quantity: str) -> pd.DataFrame:
        """Return the mean change of a quantity and its shares over the animals: ``mean, low, high`` (95 %, by Student).

        The first row is ``change``, then what was exchanged; what does not differ in an animal has the share 0 there.
        """
        from scipy.stats import t as student

        rows = pd.DataFrame([table.loc[quantity].iloc[3:] for table in self.tables.values()]).astype(float)
        rows, count = rows.fillna(0.0), len(rows)
        means = rows.mean()
        reach = student.ppf((1 + LEVEL) / 2, count - 1) / np.sqrt(count) if count >= _MIN_ANIMALS else np.nan
        half = reach * rows.std(ddof=1)
        return pd.DataFrame({"mean": means, "low": means - half, "high": means + half})


def attribution_table(groups: Iterable[GroupAttribution]) -> pd.DataFrame:
    """Return the shares of single animals, a row for each animal and quantity.

    Columns ``group, animal, quantity, unit, before, after, change`` and one for each component, in the unit of the row.
    """
    tables = [
        table.rename_axis("quantity").reset_index().assign(group=changed.group, animal=animal)
        for changed in groups
        for animal, table in changed.tables.items()
    ]
    if not tables:
        return pd.DataFrame(columns=_TITLES)
    table = pd.concat(tables, ignore_index=True)
    return table[_TITLES + [column for column in table if column not in _TITLES]].fillna(0.0)
