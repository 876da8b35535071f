"""A virtual cohort of 7 + 5 mice: recordings that the package makes itself.

All of it is synthetic. Every animal of the cohort has the parameters published
for one animal of the study, and its vascular resistance; cardiac output and heart rate are drawn so that the groups
have the published mean and SD. What no wave model explains is added to the pressure as smooth periodic noise with the
root-mean-square residual that the published fit of that animal left.
"""

from dataclasses import dataclass

import numpy as np
import pandas as pd

from vasowave.catheter.signals.raw import RawRecording
from vasowave.catheter.synthetic import Disturbances, synthetic_raw_recording
from vasowave.pulse.cycle.cycle import Inflow, Recording
from vasowave.pulse.examples.mouse import FROM_PARAMETERS, SAMPLES, ejection
from vasowave.pulse.examples.published import control_network, hypertensive_network, published_table
from vasowave.pulse.model.linear import linear_solution
from vasowave.pulse.model.model import Model
from vasowave.pulse.model.nominal import windkessels
from vasowave.pulse.model.numerics import Numerics
from vasowave.pulse.model.walls import LinearWall, TangentWall
from vasowave.pulse.network.network import Network
from vasowave.pulse.solver.simulation import simulate

PUBLISHED_SAMPLES = 1024
"""Samples over which the published S was summed; with them its root mean square is that of a residual in mmHg."""

_NETWORKS = {"CTL": control_network, "HPH": hypertensive_network}
_RESISTANCE_AND_OUTPUT = {"CTL": -0.67, "HPH": -0.9}
"""Correlation of vascular resistance and cardiac output that makes the SD of their product, mPAP, the published one."""
_DECAY = 2.0  # harmonics over which the power of what the model misses falls to 1/e; near that of measured mouse C6
_SLIP = {("HPH", 2): 100.0}  # the published compliance of this animal has a slip in its exponent


@dataclass(frozen=True, eq=False)
class VirtualAnimal:
    """One synthetic animal and the truth about it.

    Attributes
    ----------
    name, group : str
    network : Network
        The published one of its group, as in the paper one image stands for all.
    model : Model
        What its pressure was simulated with.
    truth : dict of str to float
        beta, or p1 and gamma (mmHg, 1), R_T (mmHg s/ml), a, C_p (ml/mmHg, weighted), tau = R_T C of every bed (s),
        discrepancy (mmHg, SD of the noise in the cycle), HR (beats/min), CO (ml/s).
    cycle : Recording
        Pressure (with that noise) and flow of which every beat is a copy.
    raw : RawRecording
        What the instruments saw: pressure, flow, ECG, with ventilation, drift and white noise.
    """

    name: str
    group: str
    network: Network
    model: Model
    truth: dict[str, float]
    cycle: Recording
    raw: RawRecording


def virtual_cohort(seed: int = 1, wall: str = "linear") -> tuple[VirtualAnimal, ...]:
    """Make the 7 control and 5 hypertensive animals of the study anew; everything about them is synthetic.

    Parameters
    ----------
    seed : int
    wall : {"linear", "tangent"}
        Law of the vessel walls, and the published table their parameters come from.
    """
    rng = np.random.default_rng(seed)
    table = published_table(f"optimized_{wall}").merge(published_table("nominal"), on=["group", "animal"])
    animals = []
    for group, rows in table.groupby("group", sort=False):
        hearts = _hearts(str(group), rows["R_T0 [mmHg s/ml]"].to_numpy(float), rng)
        for (_, row), heart in zip(rows.iterrows(), hearts, strict=True):
            animals.append(_animal(row, heart, rng))
    return tuple(animals)


def _hearts(group: str, resistance: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Return cardiac output (ml/s) and heart rate (beats/min), shape (animal, 2), with the published mean and SD."""
    stats = published_table("hemodynamics").set_index("quantity")
    r = _RESISTANCE_AND_OUTPUT[group]
    along = _standardized(resistance)
    free = rng.standard_normal(len(resistance))
    free -= free.mean()
    across = _standardized(free - along * (free @ along) / (along @ along))
    scores = {"CO": r * along + np.sqrt(1 - r * r) * across, "HR": _standardized(rng.standard_normal(len(resistance)))}
    return np.stack(
        [stats.loc[name, f"{group} mean"] + stats.loc[name, f"{group} SD"] * z for name, z in scores.items()], axis=1
    )


def _animal(row: pd.Series, heart: np.ndarray, rng: np.random.Generator) -> VirtualAnimal:
    group, number = str(row["group"]), int(row["animal"])
    network, output, rate = _NETWORKS[group](), float(heart[0]), float(heart[1])
    inflow = _inflow(output, 60.0 / rate, rng)
    C_p = row["C_T [ml/mmHg]"] * _SLIP.get((group, number), 1.0) * row["C_p/C_T"]
    a = float(row["a"])
    wall: LinearWall | TangentWall
    if "beta [mmHg]" in row.index:
        wall = LinearWall(float(row["beta [mmHg]"]))
    else:
        wall = TangentWall(float(row["pi p1 [mmHg]"]) / np.pi, float(row["gamma"]))
    model, R_T, tau = _resisting(network, wall, inflow, float(row["R_T0 [mmHg s/ml]"]), a, C_p)
    simulated = simulate(model, inflow, Numerics(samples=SAMPLES))["pressure"].to_numpy()[:, network.root, 0]
    discrepancy = float(np.sqrt(row["S [mmHg2]"] / PUBLISHED_SAMPLES))
    note = FROM_PARAMETERS(which="published")
    pressure = simulated + discrepancy * _smooth_noise(rng)
    name = f"{group} {number}"
    cycle = Recording(pressure, inflow.flow, inflow.period, f"virtual mouse {name}, synthetic", (note,))
    raw = synthetic_raw_recording(cycle, rng, disturbances=_disturbances(rng)).raw
    parameters = {key: float(value) for key, value in zip(wall._fields, wall, strict=True)}
    truth = parameters | {"R_T": R_T, "a": a, "C_p": C_p, "tau": tau, "discrepancy": discrepancy}
    return VirtualAnimal(name, group, network, model, truth | {"HR": rate, "CO": output}, cycle, raw)


def _inflow(output: float, period: float, rng: np.random.Generator) -> Inflow:
    """Return an ejection whose length and skewness vary a little from animal to animal."""
    length, skewness = 0.40 + 0.015 * rng.standard_normal(), 0.70 + 0.05 * rng.standard_normal()
    shape = ejection(SAMPLES, length, skewness).flow
    return Inflow(output * shape / shape.mean(), period)


def _resisting(
    network: Network, wall: LinearWall | TangentWall, inflow: Inflow, PVR: float, a: float, C_p: float
) -> tuple[Model, float, float]:
    """Return the model whose mean pressure over mean flow is PVR (mmHg s/ml), the R_T of its beds, and τ = R_T C."""
    R_T = 0.85 * PVR
    for _ in range(4):
        tau = C_p * R_T / (1 - a)
        model = Model(network, wall, windkessels(network, R_T, tau, a))
        mean = linear_solution(model, inflow, harmonics=1).pressure[0, network.root].real
        R_T += PVR - mean / inflow.flow.mean()
    tau = C_p * R_T / (1 - a)
    return Model(network, wall, windkessels(network, R_T, tau, a)), R_T, tau


def _smooth_noise(rng: np.random.Generator) -> np.ndarray:
    """Return one period of stationary Gaussian noise of variance 1; its power falls exponentially with the harmonic."""
    harmonic = np.arange(SAMPLES // 2 + 1)
    amplitude = np.exp(-0.5 * harmonic / _DECAY)
    noise = np.fft.irfft(np.fft.rfft(rng.standard_normal(SAMPLES)) * amplitude, SAMPLES)
    variance = (amplitude[0] ** 2 + 2 * np.sum(amplitude[1:-1] ** 2) + amplitude[-1] ** 2) / SAMPLES
    return noise / np.sqrt(variance)


def _disturbances(rng: np.random.Generator) -> Disturbances:
    """Return what ventilator and instruments do to this animal's recording."""
    return Disturbances(
        breaths_per_minute=float(rng.uniform(80, 100)),
        ventilation_pressure=float(rng.uniform(1.0, 2.0)),
        pressure_drift=float(rng.uniform(-0.5, 0.5)),
    )


def _standardized(values: np.ndarray) -> np.ndarray:
    centered = values - values.mean()
    return centered / centered.std(ddof=1)
