"""How well a posterior knows shear, strain and perfusion of each vessel."""

import numpy as np
import pandas as pd

from vasowave.base.descriptions import TAILS
from vasowave.base.errors import InputError
from vasowave.base.io.columns import split_unit
from vasowave.pulse.analysis.prediction import Progress, values_of_draws
from vasowave.pulse.analysis.shear import LOADS, vessel_loads
from vasowave.pulse.analysis.uncertain import UncertainModel

LEAST_DRAWS = 40
"""With fewer draws none lies in the 2.5 % at either end."""


def load_intervals(
    fit: UncertainModel, *, draws: int = 100, seed: int = 0, progress: Progress | None = None
) -> pd.DataFrame:
    """Return 95 % intervals of what waves do to each vessel.

    Parameters
    ----------
    fit : UncertainModel
        A stored one with draws of its posterior: shear goes with r⁻³, and a fit's intervals know no errors of radii.
    draws, seed : int
        How many draws are simulated; choice of them.
    progress : callable, optional
        Called with the draws that are done, and all.

    Returns
    -------
    DataFrame
        Indexed by vessel: ``mean shear low [Pa], mean shear high [Pa]``, and so for every column of `vessel_loads`.

    Raises
    ------
    InputError
        No posterior that may be believed, or fewer than 40 draws that can be simulated.

    Examples
    --------
    >>> from dataclasses import replace
    >>> import vasowave as vw
    >>> mouse = vw.Animal("mouse 6", "CTL", vw.control_network(), vw.virtual_mouse(), synthetic=True)
    >>> stored = vw.stored_fit(vw.analyze(mouse, vw.Settings(walls=("linear",), starts=1)))
    >>> sure = replace(stored, drawn=((stored.model, stored.inflow),) * 40)  # or analyze with inference="posterior"
    >>> list(vw.load_intervals(sure).columns[:2])
    ['mean shear low [Pa]', 'mean shear high [Pa]']
    """
    if not isinstance(fit, UncertainModel) or not fit.drawn:
        raise InputError(
            "intervals of shear and flow in vessels need a posterior that may be believed; analyze the animal with "
            "inference: posterior and take vasowave.stored_fit"
        )
    values, _ = values_of_draws(fit, draws, seed, lambda *drawn: iter([drawn]), progress, vessel_loads)
    if len(values) < LEAST_DRAWS:
        raise InputError(
            f"intervals of shear and flow in vessels need {LEAST_DRAWS} draws, of which {len(values)} could be "
            "simulated; ask for more draws"
        )
    low, _, high = np.quantile(values[:, 0], TAILS, axis=0, method="weibull")
    columns: dict[str, np.ndarray] = {}
    for column, (name, unit) in enumerate(map(split_unit, LOADS)):
        columns |= {f"{name} low [{unit}]": low[:, column], f"{name} high [{unit}]": high[:, column]}
    return pd.DataFrame(columns, pd.Index(fit.model.network.name, name="vessel"))
