"""Which parameter matters for which quantity: Sobol' indices with the box in which they hold."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import pandas as pd

from vasowave.base.accessors import Accessor

if TYPE_CHECKING:
    from matplotlib.figure import Figure

COLUMNS = ("first", "first_low", "first_high", "total", "total_low", "total_high")


@dataclass(frozen=True, eq=False)
class Sensitivity:
    """Which parameter matters for which quantity, within a box of parameters.

    Each parameter is independent and even in its logarithm: the indices are of the model in this box, not of a
    posterior, in which parameters depend on each other.

    Attributes
    ----------
    table : DataFrame
        Index: quantity, parameter; Sobol' indices `COLUMNS` with 95 % intervals, which hold the error of the samples
        alone. ``first`` is the share of the variance that the parameter brings alone, ``total`` with all others; NaN
        where a quantity does not change.
    box : DataFrame
        Index: parameter; columns ``low, high, unit``: within which it varies.
    quantities : DataFrame
        Index: quantity; columns ``unit``, ``sd`` in the box, and ``error`` of the emulator, below which 95 % of its
        errors lie. Where the error is no small share of the SD the indices mean little.

    Examples
    --------
    >>> import vasowave as vw
    >>> network = vw.Network(("1",), [-1], [0.4], [0.05])  # a quick one: one vessel, and one unknown
    >>> search = vw.Search(starts=1, fixed={"r1": 1.0, "r2": 1.0, "c1": 1.0})
    >>> fit = vw.calibrate(network, vw.virtual_mouse(), search=search)
    >>> round(float(fit.sensitivity(samples=256).table.loc[("pPAP", "beta"), "total"]), 1)
    1.0
    """

    table: pd.DataFrame
    box: pd.DataFrame
    quantities: pd.DataFrame

    def __repr__(self) -> str:
        totals = self.table["total"].unstack("quantity")[[*self.quantities.index]]
        ranges = ", ".join(f"{name} {row['low']:.4g} to {row['high']:.4g}" for name, row in self.box.iterrows())
        return f"Sensitivity(within {ranges}); total indices:\n{totals.round(2)}"

    @Accessor
    def figure(self) -> "Figure":
        """Draw the indices of first and total order of pressures, power and Z_c."""
        raise NotImplementedError
