"""What a plan of a study starts from: the spread of each quantity, and what shall be shown."""

from typing import Annotated, NamedTuple

import numpy as np
from annotated_types import Ge, Gt, Le, Lt

from vasowave.base.errors import InputError
from vasowave.base.settings import settings_class


class Spread(NamedTuple):
    """What is known of one quantity before a study."""

    quantity: str
    between: tuple[float, float]
    """SD of the animals' logarithms in the two groups, without the errors."""
    error: float = 0.0
    """SD of the logarithm of one animal's estimate; 0 where `between` contains it."""
    shared: float = 0.0
    """Standard error of the difference of the groups from images that they share."""
    within: float = 0.0
    """SD of the logarithm of one animal from occasion to occasion, without the errors; 0 where `between` contains
    it."""

    @property
    def alike(self) -> float:
        """Correlation of an animal's true values on two occasions, in the mean of the groups; 1 if it is not known."""
        animals = float(np.mean(np.square(self.between)))
        return animals / (animals + self.within**2) if animals else 0.0

    def on_one_occasion(self, group: int) -> float:
        """Return the SD of the true values of a group."""
        return float(np.hypot(self.between[group], self.within))


@settings_class
class Planning:
    """What a study shall show."""

    effect: Annotated[float, Gt(0)] = 1.5
    """Ratio of the groups that shall be shown."""
    power: Annotated[float, Gt(0.05), Lt(1)] = 0.8
    """How often it shall be."""
    occasions: Annotated[int, Ge(1), Le(20)] = 1
    """Recordings of each animal, in pairs of each of the two: what differs between them falls by the root of their
    number, an error always, what an animal differs from occasion to occasion where groups are compared."""
    pairs: Annotated[float, Ge(0), Lt(1)] | None = None
    """Correlation of the two true values of a pair, where pairs are compared, an animal before and after for instance.
    None: groups of independent animals."""
    littermates: bool = False
    """Whether a pair is two littermates, of which each group has one; else one animal on two occasions."""
    seed: Annotated[int, Ge(0)] = 0
    """Of the cohorts that are drawn."""

    def __post_init__(self) -> None:
        """Refuse an effect that is none."""
        if abs(np.log(self.effect)) < 1e-3:
            raise InputError("effect: a ratio of 1 is no effect; give one such as 1.5 or 0.7")
        if self.littermates and self.pairs is None:
            raise InputError("littermates: say how far their true values are correlated (pairs), 0.5 for instance")
