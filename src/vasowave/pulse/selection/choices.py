"""How the answer moves with what an analyst chooses: the harmonics that are compared, the pressure of the image."""

from collections.abc import Callable, Sequence
from dataclasses import replace

import pandas as pd

from vasowave.pulse.calibration.fitting import NUMERICS, Search, calibrate
from vasowave.pulse.calibration.result import CalibratedModel
from vasowave.pulse.cycle.cycle import Recording
from vasowave.pulse.model.blood import Blood
from vasowave.pulse.model.numerics import Numerics
from vasowave.pulse.network.network import Network
from vasowave.pulse.quantities import ACROSS_LAWS, QUANTITIES, derived
from vasowave.pulse.selection.compare import Comparing, compare_models

Progress = Callable[[int, int], None]
"""Called with finished and all fits."""

LIKELY = 6.3
"""Pressure at which the paper's lungs were filled for the image, mmHg."""

WALLS = ("linear", "tangent", "power")


def answers_by_harmonics(
    network: Network,
    recording: Recording,
    walls: Sequence[str | type] = WALLS,
    harmonics: Sequence[int | str] = (10, "signal", 20, "all"),
    *,
    search: Search | None = None,
    blood: Blood | None = None,
    numerics: Numerics | None = None,
    covariance: str = "circulant",
    progress: Progress | None = None,
) -> pd.DataFrame:
    """Fit every wall law to more and more harmonics of the pressure, and compare the laws each time.

    Parameters
    ----------
    network, recording, blood, numerics
        As `calibrate` takes them.
    walls : sequence of str or type
    harmonics : sequence of {"signal", "all"} or int
        As `Search.pressure_harmonics`.
    search : Search, optional
    covariance : str
        Noise model of the comparison, of `noise.OF_PAPER`; one for all laws, from their joint likelihood.
    progress : callable, optional
        Called with finished and all fits.

    Returns
    -------
    DataFrame
        Indexed by ``harmonics`` and ``wall``: ``N``, ``S [mmHg2]``, ``mean square [mmHg2]``, ``AICc difference`` to the
        best law, every parameter, and `quantities.ACROSS_LAWS`, each with its unit: ``wave_speed [cm/s]``.

    Raises
    ------
    InputError
        As `calibrate` and `compare_models`.
    """
    plan = search or Search()
    searches = [replace(plan, pressure_harmonics=number) for number in harmonics]
    groups = _fits([(network, setting) for setting in searches], recording, walls, blood, numerics, progress)
    tables = [answers(fits, covariance).assign(harmonics=fits[0].compared.harmonics) for fits in groups]
    return pd.concat(tables).reset_index().set_index(["harmonics", "wall"])


def answers_by_image_pressure(
    network: Network,
    recording: Recording,
    walls: Sequence[str | type] = WALLS,
    pressures: Sequence[float] | None = None,
    *,
    search: Search | None = None,
    blood: Blood | None = None,
    numerics: Numerics | None = None,
    covariance: str = "circulant",
    progress: Progress | None = None,
) -> pd.DataFrame:
    """Fit every wall law with the radii taken as those at other pressures, and compare the laws each time.

    Parameters
    ----------
    pressures : sequence of float, optional
        mmHg; 0 and the network's own, or, where that is not known, 0 and `LIKELY`.
    network, recording, walls, search, blood, numerics, covariance, progress
        As in `answers_by_harmonics`.

    Returns
    -------
    DataFrame
        As from `answers_by_harmonics`, indexed by ``image pressure [mmHg]`` and ``wall``.

    Raises
    ------
    InputError
        As `Network`, `calibrate` and `compare_models`.
    """
    image_pressures = (0.0, network.pressure or LIKELY) if pressures is None else pressures
    networks = [replace(network, pressure=pressure) for pressure in image_pressures]
    groups = _fits([(variant, search or Search()) for variant in networks], recording, walls, blood, numerics, progress)
    label = "image pressure [mmHg]"
    tables = [
        answers(fits, covariance).assign(**{label: pressure})
        for fits, pressure in zip(groups, image_pressures, strict=True)
    ]
    return pd.concat(tables).reset_index().set_index([label, "wall"])


def _fits(
    choices: Sequence[tuple[Network, Search]],
    recording: Recording,
    walls: Sequence[str | type],
    blood: Blood | None,
    numerics: Numerics | None,
    progress: Progress | None,
) -> list[list[CalibratedModel]]:
    """Return the fits of all wall laws for each choice of a network and a search."""
    groups: list[list[CalibratedModel]] = [[] for _ in choices]
    blood, numerics = blood or Blood(), numerics or NUMERICS
    for i, (network, search) in enumerate(choices):
        for wall in walls:
            groups[i].append(calibrate(network, recording, wall, search, blood=blood, numerics=numerics))
            if progress is not None:
                progress(i * len(walls) + len(groups[i]), len(choices) * len(walls))
    return groups


def answers(fits: Sequence[CalibratedModel], covariance: str = "circulant") -> pd.DataFrame:
    """One row for each fit of one recording, indexed by ``wall``; columns as in `answers_by_harmonics`."""
    table = pd.DataFrame([answer(fit) for fit in fits], index=pd.Index([fit.wall for fit in fits], name="wall"))
    if len(fits) > 1:
        compared = compare_models(fits, Comparing(covariances=(covariance,)), samples=None)
        differences = pd.Series(compared["AICc_difference"].values, index=compared["wall"].values.astype(str))
        table.insert(3, "AICc difference", differences)
    return table


def answer(fit: CalibratedModel) -> dict[str, float]:
    """What a fit says, each number with its unit in its name."""
    values = derived(fit.model, fit.recording.mean_pressure)
    return {
        "N": fit.N,
        "S [mmHg2]": fit.S,
        "mean square [mmHg2]": fit.mean_square,
        **{f"{name} [{row['unit']}]": float(row["value"]) for name, row in fit.parameters.iterrows()},
        **{f"{name} [{QUANTITIES[name].unit}]": values[name] for name in ACROSS_LAWS if name in values},
    }
