"""Beds that are trees, as a fit sees them: how often intervals hold the truth, and what a Windkessel makes of the same.

    python benchmarks/tree_beds.py --animals 40 --out found.csv

Every animal has the published control mouse's network, a linear wall, and structured trees of one of three kinds behind
its vessels; its recording has the noise of `known_animals`. It is fitted by the trees of its kind, whose lengths and
stiffness are free, and by the Windkessel. What was told of the trees is right; asked is what the data determine.
"""

import argparse
import csv
from pathlib import Path
from typing import ClassVar

import numpy as np
import pandas as pd

from known_animals import NOISE, SAMPLES, WHITE, heart, smooth_noise
from vasowave.pulse import derived
from vasowave.pulse.calibration import Search, calibrate
from vasowave.pulse.cycle import Recording
from vasowave.pulse.examples import control_network
from vasowave.pulse.model import Blood, LinearWall, Model, Numerics, Site, StructuredTree
from vasowave.pulse.solver import simulate
from vasowave.study.animal import derived_of, errors_of


class Viscous(StructuredTree):
    """The trees of Colebank et al.: viscosity by radius, one stiffness."""

    NOMINAL: ClassVar = {"hematocrit": 0.45}

    @staticmethod
    def bed():
        return StructuredTree.bed()._replace(name="viscous")


class Stiffening(StructuredTree):
    """Trees whose thin vessels are stiffer by up to a factor of five, with one viscosity."""

    NOMINAL: ClassVar = {"stiffening": 4.0, "stiffening_radius": 0.01}

    @staticmethod
    def bed():
        return StructuredTree.bed()._replace(name="stiffening")


class Asymmetric(StructuredTree):
    """The trees of Olufsen 1999: asymmetry 0.41, exponent 2.76, down to 30 µm."""

    NOMINAL: ClassVar = {"exponent": 2.76, "asymmetry": 0.41, "smallest": 0.003}

    @staticmethod
    def bed():
        return StructuredTree.bed()._replace(name="asymmetric")


KINDS = {"viscous": Viscous, "stiffening": Stiffening, "asymmetric": Asymmetric}
COLUMNS = ("kind", "animal", "fit", "quantity", "truth", "low", "value", "high", "rmse")


def animal(kind, number):
    """Return the recording of an animal, and its true model."""
    rng = np.random.default_rng([number, list(KINDS).index(kind)])
    network, inflow = control_network(), heart(rng)
    beta, resistance = 57.0 * np.exp(0.3 * rng.standard_normal()), 76.0 * np.exp(0.15 * rng.standard_normal())
    beds = KINDS[kind].of(network, Site(resistance, 0.12, beta, Blood()))
    beds = beds._replace(stiffness=beds.stiffness * np.exp(0.4 * rng.standard_normal()))
    model = Model(network, LinearWall(beta), beds)
    pressure = simulate(model, inflow, Numerics(samples=SAMPLES))["pressure"].to_numpy()[:, network.root, 0]
    pressure = pressure + NOISE * smooth_noise(rng) + WHITE * rng.standard_normal(SAMPLES)
    return Recording(pressure, inflow.flow, inflow.period), model


def lines(kind, number):
    """Yield a line for every quantity and fit of an animal."""
    recording, model = animal(kind, number)
    for name, bed in (("tree", KINDS[kind]), ("windkessel", "windkessel")):
        fit = calibrate(model.network, recording, bed=bed, search=Search(starts=2))
        truth = derived(model, recording.mean_pressure) | {"beta": float(model.wall.beta[0])}
        if name == "tree":
            for field in ("length_ratio", "stiffness"):
                share = getattr(model.outlets, field)[0] / getattr(fit.nominal.outlets, field)[0]
                truth[f"{bed.bed().name}.tree_{field.removesuffix('_ratio')}"] = share

        def derive(values, fit=fit):
            return derived_of(fit, values, np.full(len(model.network), recording.diastolic_pressure))

        found, errors = derive(fit.parameters["value"].to_dict()), errors_of(fit, derive)
        for quantity in truth:
            if quantity in errors and np.isfinite(errors[quantity][1]):
                reach = np.exp(min(errors[quantity][1], 200.0))
                value = found[quantity]
                row = quantity.rpartition(".")[2]
                yield [kind, number, name, row, truth[quantity], value / reach, value, value * reach, fit.rmse]


def told(path):
    """Print how often intervals held the truth, their median half width and the median error, %."""
    found = pd.read_csv(path)
    found["held"] = (found["low"] <= found["truth"]) & (found["truth"] <= found["high"])
    found["half width %"] = 50 * (found["high"] - found["low"]) / found["value"]
    found["error %"] = 100 * (found["value"] / found["truth"] - 1)
    for by in (["fit", "quantity"], ["kind", "fit", "quantity"]):
        groups = found.groupby(by)
        held = groups["held"].agg(["sum", "count"]).rename(columns={"sum": "held", "count": "of"})
        print(held.join(groups[["half width %", "error %", "rmse"]].median().round(2)).to_string())


def main():
    options = argparse.ArgumentParser()
    options.add_argument("--animals", type=int, default=40)
    options.add_argument("--out", type=Path, required=True)
    options.add_argument("--table", action="store_true")
    chosen = options.parse_args()
    if not chosen.table:
        with chosen.out.open("w", newline="", encoding="utf-8") as file:
            writer = csv.writer(file)
            writer.writerow(COLUMNS)
            for number in range(chosen.animals):
                writer.writerows(lines(list(KINDS)[number % len(KINDS)], number))
                file.flush()
    told(chosen.out)


if __name__ == "__main__":
    main()
