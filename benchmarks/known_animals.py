"""Animals whose truth is known, and what may be wrong with their image, their wall or their recording.

Every animal is drawn around the published control mouse, simulated with the solver, disturbed as its row says, and
given smooth noise of 0.4 mmHg (its spectrum is not of the family that is assumed) and white noise of 0.03 mmHg.
"""

import warnings
import zlib
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from vasowave.base import VasowaveWarning
from vasowave.catheter import Disturbances, average_beats, synthetic_raw_recording
from vasowave.pulse.cycle import Inflow, Recording
from vasowave.pulse.examples import control_network, ejection
from vasowave.pulse.inference import Priors
from vasowave.pulse.model import LinearWall, Model, Numerics, Shape, TangentWall, windkessels
from vasowave.pulse.solver import simulate

SAMPLES, NOISE, WHITE = 512, 0.4, 0.03
LASTS, DRIFT = 12.0, 2.0  # s, mmHg


class Row(NamedTuple):
    """Truth, fitted law, what is wrong, what is said of it, and the row whose animals it takes, if not its own."""

    truth: str
    fitted: str
    wrong: str
    said: str
    animals: str = ""


GEOMETRY = "radii 5 % in common and 5 % each, lengths 5 % wrong"
ROWS = {
    "linear": Row("linear", "linear", "nothing", "linear → linear"),
    "geometry": Row("linear", "linear", "geometry", f"linear, {GEOMETRY} → linear"),
    "stiffening": Row("linear", "linear", "stiffening", "linear, stiffness ∝ r^-0.7 → linear"),
    "tangent": Row("tangent", "tangent", "nothing", "tangent → tangent"),
    "linear as tangent": Row("linear", "tangent", "nothing", "linear → tangent"),
    "tangent as linear": Row("tangent", "linear", "nothing", "tangent → linear"),
    "taper": Row("linear", "linear", "taper", "linear, vessels taper by 20 % → linear"),
    "drift": Row("linear", "linear", "offset", "linear, zero 1 mmHg off and nobody knows → linear"),
    "drift seen": Row("linear", "linear", "drift", "linear, 2 mmHg of drift left in, seen in the beats → linear"),
    "drift told": Row("linear", "linear", "offset", "linear, zero 1 mmHg off, `zero_sd: 1` → linear", "drift"),
    "linear again": Row("linear", "linear", "nothing", "linear → linear, other animals", "linear as tangent"),
    "tangent, linear": Row("tangent", "linear", "nothing", "tangent → linear, other animals", "tangent"),
    "geometry, tangent": Row("linear", "tangent", "geometry", f"linear, {GEOMETRY} → tangent", "geometry"),
    "stiffening, tangent": Row("linear", "tangent", "stiffening", "linear, stiffness ∝ r^-0.7 → tangent", "stiffening"),
    "taper known": Row("linear", "linear", "taper", "linear, vessels taper by 20 %, measured → linear", "taper"),
    "taper, tangent": Row("linear", "tangent", "taper", "linear, vessels taper by 20 % → tangent", "taper"),
}
"""Every row of the tables."""


def heart(rng):
    """Return an inflow that varies from animal to animal."""
    shape = ejection(SAMPLES, 0.40 + 0.015 * rng.standard_normal(), 0.70 + 0.05 * rng.standard_normal()).flow
    output = 0.18 * np.exp(0.1 * rng.standard_normal())
    return Inflow(output * shape / shape.mean(), 0.11 * np.exp(0.08 * rng.standard_normal()))


def wall_of(law, rng):
    first, second = rng.standard_normal(2)
    if law == "linear":
        return LinearWall(57.0 * np.exp(0.3 * first))
    return TangentWall(7.0 * np.exp(0.3 * first), 4.0 * np.exp(0.2 * second))


def wrong_sizes(network, rng):
    """Radii 5 % in common and 5 % each, lengths 5 % each."""
    radius = np.exp(0.05 * rng.standard_normal() + 0.05 * rng.standard_normal(len(network)))
    length = np.exp(0.05 * rng.standard_normal(len(network)))
    return replace(network, radius=network.radius * radius, length=network.length * length)


def image_of(row):
    """Return the network as the image of an animal shows it."""
    network = control_network()
    if row != "taper known":
        return network
    share = network.radius / network.length
    return replace(network, taper=0.2 * share, taper_sd=0.05 * share)


def priors_of(row):
    """Return what is assumed of an animal before it is analyzed."""
    return Priors(zero_sd=1.0) if row == "drift told" else Priors()


def truth_of(law, wrong, rng):
    """Return the true model; the image shows the control network."""
    image = control_network()
    network = wrong_sizes(image, rng) if wrong == "geometry" else image
    wall = wall_of(law, rng)
    if wrong == "stiffening":
        wall = LinearWall(wall.beta * (network.radius / network.radius[network.root]) ** -0.7)
    R_T, tau = 76.0 * np.exp(0.15 * rng.standard_normal()), 0.12 * np.exp(0.15 * rng.standard_normal())
    shape = Shape([1.1, 0.9]) if wrong == "taper" else None
    return Model(network, wall, windkessels(network, R_T, tau, rng.uniform(0.06, 0.25)), shape=shape)


def noise_amplitude():
    """Size of the noise in each harmonic, up to a factor: its power falls exponentially, to 1/e over two."""
    return np.exp(-0.25 * np.arange(SAMPLES // 2 + 1))


def smooth_noise(rng):
    """One period of noise of variance 1."""
    amplitude = noise_amplitude()
    whole = np.fft.irfft(np.fft.rfft(rng.standard_normal(SAMPLES)) * amplitude, SAMPLES)
    return whole / np.sqrt((amplitude[0] ** 2 + 2 * np.sum(amplitude[1:-1] ** 2) + amplitude[-1] ** 2) / SAMPLES)


def animal(row, number, noise=NOISE):
    """Return the recording of an animal with so much smooth noise (mmHg), its true model, and the law to fit."""
    law, fitted, wrong, _, others = ROWS[row]
    rng = np.random.default_rng([zlib.crc32((others or row).encode()), number])
    model, inflow = truth_of(law, wrong, rng), heart(rng)
    waves = simulate(model, inflow, Numerics(samples=SAMPLES))["pressure"].to_numpy()
    pressure = waves[:, model.network.root, 0] + noise * smooth_noise(rng) + WHITE * rng.standard_normal(SAMPLES)
    if wrong == "offset":  # as of 2 mmHg of drift in the beats behind an averaged cycle
        pressure = pressure + rng.choice([-1.0, 1.0])
    recording = Recording(pressure, inflow.flow, inflow.period)
    return (with_drift(recording, rng) if wrong == "drift" else recording), model, fitted


def with_drift(cycle, rng):
    """Return the average of beats from a recording whose pressure drifts by 2 mmHg, its zero right at the start."""
    fall = rng.choice([-DRIFT, DRIFT]) / LASTS
    usual = Disturbances(pressure_drift=60.0 * fall)  # mmHg/min
    raw = synthetic_raw_recording(cycle, rng, duration=LASTS, disturbances=usual).raw
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", VasowaveWarning)  # that it drifts
        return average_beats(raw, drift="warn").recording
