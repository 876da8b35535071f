"""One comparison of a design, as a value."""

from typing import NamedTuple

import numpy as np


class Contrast(NamedTuple):
    """One comparison of the means of cells: `second` minus `first`, on logarithms.

    Attributes
    ----------
    other, reference : str
        What is compared with what.
    first, second : array, shape (cell,)
        Weights of the cells.
    what : {"groups", "factor", "interaction", "trend", "contrast"}
    change : str
        Of an interaction, whose sides are ratios: of what.
    within : str
        Where it is compared, if that is not everywhere: ``at time before``, ``in HPH``.
    """

    other: str
    reference: str
    first: np.ndarray
    second: np.ndarray
    what: str
    change: str = ""
    within: str = ""

    @property
    def text(self) -> str:
        """What is compared with what, in words."""
        return self.worded("change")

    def worded(self, what: str) -> str:
        """Return the same, with what an interaction's sides are: a change within animals, or a ratio between them."""
        change = f"in the {what} {self.change}" if self.change else ""
        pair = f"{self.other} against {self.reference}" if self.reference else self.other
        return " ".join(filter(None, (pair, change, self.within)))

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
