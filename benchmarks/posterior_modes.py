"""Do posteriors of tangent animals lie in the right mode? Trees of seven vessels whose walls are far from nominal.

    python benchmarks/posterior_modes.py --out found.csv --kind spread --animals 40

Every animal is analyzed from nominal, without a fit, and once more by a search that begins at its truth and knows of
no other start. Each animal is a line in the file as soon as it is done; a run that was stopped goes on where it was.
"""

import argparse
import csv
import time
import zlib
from pathlib import Path

import numpy as np
import pandas as pd

from known_animals import SAMPLES, WHITE, heart, smooth_noise
from vasowave.errors import NumericalError
from vasowave.inference.derived import derived
from vasowave.inference.posterior import posterior
from vasowave.model import Model
from vasowave.network import Network
from vasowave.nominal import windkessels
from vasowave.recording import Recording
from vasowave.solver import Numerics, simulate
from vasowave.walls import TangentWall

NOISE = 0.4  # mmHg
KINDS = {
    "spread": ((3.0, 25.0), (0.7, 6.0)),
    "soft": ((4.0, 10.0), (0.5, 1.5)),
    "stiff": ((10.0, 40.0), (0.7, 3.0)),
}
"""Ranges of p1 (mmHg) and γ of the true walls."""


def tree(rng):
    """Return a tree of seven vessels: every daughter 0.6 to 0.8 times as wide as its mother."""
    parent = np.array([-1, 0, 0, 1, 1, 2, 2])
    radius = np.full(7, 0.047 * np.exp(0.1 * rng.standard_normal()))
    for row in range(1, 7):
        radius[row] = radius[parent[row]] * rng.uniform(0.6, 0.8)
    return Network(tuple("abcdefg"), parent, rng.uniform(0.15, 0.6, 7), radius)


def animal(kind, number):
    """Return the network, the recording and the true model of an animal; walls that cannot be are drawn anew."""
    rng = np.random.default_rng([zlib.crc32(kind.encode()), number])
    pressures, scales = KINDS[kind]
    while True:
        network, inflow = tree(rng), heart(rng)
        wall = TangentWall(*(float(np.exp(rng.uniform(*np.log(ends)))) for ends in (pressures, scales)))
        R_T, tau = 76.0 * np.exp(0.2 * rng.standard_normal()), 0.12 * np.exp(0.2 * rng.standard_normal())
        model = Model(network, wall, windkessels(network, R_T, tau, rng.uniform(0.06, 0.25)))
        try:
            waves = simulate(model, inflow, Numerics(samples=SAMPLES))["pressure"].to_numpy()
        except NumericalError:
            continue
        pressure = waves[:, network.root, 0] + NOISE * smooth_noise(rng) + WHITE * rng.standard_normal(SAMPLES)
        return network, Recording(pressure, inflow.flow, inflow.period), model
