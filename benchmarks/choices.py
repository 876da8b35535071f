"""How the answer moves with what an analyst chooses: the harmonics that are compared, the pressure of the image.

answers_by_harmonics(network, recording)         the table of docs/selection.md
answers_by_image_pressure(network, recording)    that of docs/walls.md
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import pandas as pd

from vasowave.pulse import ACROSS_LAWS, QUANTITIES, derived
from vasowave.pulse.calibration import CalibratedModel, calibrate
from vasowave.pulse.cycle import Recording
from vasowave.pulse.network import Network
from vasowave.pulse.selection import Comparing, compare_models

IMAGE_PRESSURE = 6.3  # mmHg, at which the paper's lungs were filled for the image
WALLS = ("linear", "tangent", "power")


def answers_by_harmonics(
    network: Network, recording: Recording, walls: Sequence[str | type] = WALLS,
    harmonics: Sequence[int | str] = (10, "signal", 20, "all"), **fitting: Any,
) -> pd.DataFrame:  # fmt: skip
    """Fit every wall law to more and more harmonics of the pressure, and compare the laws each time.

    Returns columns of `answers`, indexed by ``harmonics`` and ``wall``; `fitting` are settings of `calibrate`.
    """
    tables = {}
    for number in harmonics:
        fits = [calibrate(network, recording, wall, **fitting, pressure_harmonics=number) for wall in walls]
        tables[fits[0].compared.harmonics] = answers(fits)
    return pd.concat(tables, names=["harmonics"])


def answers_by_image_pressure(
    network: Network, recording: Recording, walls: Sequence[str | type] = WALLS,
    pressures: Sequence[float] | None = None, **fitting: Any,
) -> pd.DataFrame:  # fmt: skip
    """Fit every wall law with the radii taken as those at other pressures (mmHg), and compare the laws each time.

    Without `pressures`, 0 and the network's own, or `IMAGE_PRESSURE` where that is not known.
    """
    tables = {}
    for pressure in (0.0, network.pressure or IMAGE_PRESSURE) if pressures is None else pressures:
        variant = replace(network, pressure=pressure)
        tables[pressure] = answers([calibrate(variant, recording, wall, **fitting) for wall in walls])
    return pd.concat(tables, names=["image pressure [mmHg]"])


def answers(fits: Sequence[CalibratedModel], covariance: str = "circulant") -> pd.DataFrame:
    """One row for each fit of one recording, indexed by ``wall``; of several the difference of AICc to the best."""
    table = pd.DataFrame([answer(fit) for fit in fits], index=pd.Index([fit.wall for fit in fits], name="wall"))
    if len(fits) > 1:
        compared = compare_models(fits, Comparing(covariances=(covariance,)), samples=None)
        differences = pd.Series(compared["AICc_difference"].values, index=compared["wall"].values.astype(str))
        table.insert(3, "AICc difference", differences)
    return table


def answer(fit: CalibratedModel) -> Mapping[str, float]:
    """What a fit says, each number with its unit in its name."""
    values = derived(fit.model, fit.recording.mean_pressure)
    return {
        "N": fit.N,
        "S [mmHg2]": fit.S,
        "mean square [mmHg2]": fit.mean_square,
        **{f"{name} [{row['unit']}]": float(row["value"]) for name, row in fit.parameters.iterrows()},
        **{f"{name} [{QUANTITIES[name].unit}]": values[name] for name in ACROSS_LAWS if name in values},
    }
