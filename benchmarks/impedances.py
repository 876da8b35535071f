"""Z_c, C_T and the energy of reflected waves by one cycle, of pulses whose Z_c and compliance are known.

    python benchmarks/impedances.py 60 --docs      sixty pulses of each kind: half a minute; docs/recording-accuracy.md

A flow of one of three shapes enters a Windkessel, a line with friction before a Windkessel, or the published trees with
other walls and beds, solved harmonic by harmonic. As recorded, the pressure is rounded off by 1.5 % of the period, or
both have a noise of 0.5 %, or the flow is 1 % of the period early or late. The share of the upstroke was chosen with
Windkessels and trees behind sin², as they are; nothing was chosen with the others.
"""

from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np

import vasowave as vw
from robustness_page import main_of_table
from vasowave.base import InputError
from vasowave.pulse.analysis import characteristic_impedances, compliance, wave_speeds
from vasowave.pulse.cycle.cycle import Inflow
from vasowave.pulse.examples.published import hypertensive_network
from vasowave.pulse.model.linear import linear_solution
from vasowave.pulse.model.nominal import diastole, time_constant, windkessels

PAGE = Path(__file__).parents[1] / "docs" / "recording-accuracy.md"
COUNT, PERIOD, OUTPUT, MEAN = 1024, 0.11, 0.18, 15.0
HARMONICS = np.arange(COUNT // 2 + 1)
ANGULAR = 2j * np.pi * HARMONICS  # 1/T
ESTIMATORS = ("up-slope", "first half")
HEAD = (
    "before",
    "flow",
    "recorded",
    *(f"{what}, {name}" for what in ("Z_c", "reflected") for name in ESTIMATORS),
    "C_T, τ/PVR",
)
INSTRUMENTS = {
    "as it is": {},
    "noise of 0.5 %": {"noise": 0.005},
    "rounded off": {"noise": 0.005, "corners": 0.015},
    "flow 1 % early": {"delay": 0.01},
    "flow 1 % late": {"delay": -0.01},
}


def sine(rng: np.random.Generator, phase: np.ndarray) -> np.ndarray:
    """Return a flow sin(π xᵃ) with rounded corners and a leak behind it."""
    end = rng.uniform(0.3, 0.45)
    forward = np.where(phase < end, np.sin(np.pi * np.clip(phase / end, 0, 1) ** rng.uniform(0.6, 1.0)), 0.0)
    return behind(forward - rng.uniform(0, 0.15) * np.sin(np.pi * np.clip((phase - end) / 0.08, 0, 1)), corners=0.005)


def squared_sine(rng: np.random.Generator, phase: np.ndarray) -> np.ndarray:
    """Return a flow that begins and ends without a slope."""
    along = np.clip((phase - 0.05) / rng.uniform(0.3, 0.5), 0, 1)
    return np.sin(np.pi * along) ** 2 * (1.35 - rng.uniform(0.3, 0.9) * along)


def early_peak(rng: np.random.Generator, phase: np.ndarray) -> np.ndarray:
    """Return a flow that rises as half a cosine and falls for longer as another."""
    rise, end = rng.uniform(0.1, 0.2), rng.uniform(0.35, 0.5)
    rising, falling = 1 - np.cos(np.pi * phase / rise), 1 + np.cos(np.pi * (phase - rise) / (end - rise))
    return np.where(phase < rise, rising, np.where(phase < end, falling, 0.0))


def behind(wave: np.ndarray, corners: float = 0.0, delay: float = 0.0) -> np.ndarray:
    """Return a cycle rounded off by a Gaussian, and late; both as a share of the period."""
    response = np.exp(-0.5 * (corners * np.abs(ANGULAR)) ** 2 - ANGULAR * delay)
    return np.fft.irfft(np.fft.rfft(wave) * response, COUNT)


def windkessel(rng: np.random.Generator, flow: np.ndarray) -> tuple[np.ndarray, float, float]:
    """Return pressure, Z_c and compliance of three elements."""
    Z_c, decay = rng.uniform(0.05, 0.2) * MEAN / OUTPUT, rng.uniform(0.4, 1.5)
    behind_Z_c = MEAN / OUTPUT - Z_c
    return before(flow, Z_c + behind_Z_c / (1 + ANGULAR * decay)), Z_c, decay * PERIOD / behind_Z_c


def line(rng: np.random.Generator, flow: np.ndarray) -> tuple[np.ndarray, float, float]:
    """Return pressure, Z_c and compliance of a line with friction before a Windkessel that does not match."""
    resistance = MEAN / OUTPUT
    Z_c, passage, friction = rng.uniform(0.05, 0.2) * resistance, rng.uniform(0.02, 0.12), rng.uniform(0, 0.1)
    near, decay = Z_c * rng.uniform(0.4, 1.5), rng.uniform(0.2, 1.0)
    load = near + (resistance - near) / (1 + ANGULAR * decay)
    along = np.tanh(ANGULAR * passage + friction * np.sqrt(HARMONICS))
    stored = passage * PERIOD / Z_c + decay * PERIOD / (resistance - near)
    return before(flow, Z_c * (load + Z_c * along) / (Z_c + load * along)), Z_c, stored


def before(flow: np.ndarray, impedance: np.ndarray) -> np.ndarray:
    """Return the pressure of a flow into an impedance."""
    return np.fft.irfft(np.fft.rfft(flow) * impedance, COUNT)


def tree(rng: np.random.Generator, flow: np.ndarray) -> tuple[np.ndarray, float, float]:
    """Return pressure and Z_c at the root, and compliance, of a published tree."""
    network = (vw.control_network(), hypertensive_network())[rng.integers(2)]
    beds = windkessels(network, rng.uniform(50, 150), rng.uniform(0.06, 0.2), rng.uniform(0.05, 0.3))
    model = vw.Model(network, vw.LinearWall(rng.uniform(20, 150)), beds)
    solution = linear_solution(model, Inflow(flow, PERIOD), 100)
    pressure = solution.over_cycle(solution.pressure[:, network.root], COUNT)
    Z_c = float(wave_speeds(model, pressure.mean())["Z_c [mmHg s/ml]"].iloc[network.root])
    return pressure, Z_c, compliance(model, float(pressure.min())).total(published=False)


def errors(
    seed: list[int], load: Callable[..., tuple[np.ndarray, float, float]], shape: Callable[..., np.ndarray],
    noise: float = 0.0, corners: float = 0.0, delay: float = 0.0,
) -> list[float]:  # fmt: skip
    """Return by how much Z_c and the reflected energy are off, by each estimator, and C_T = τ/PVR (eq. 12)."""
    rng = np.random.default_rng(seed)
    flow = shape(rng, np.arange(COUNT) / COUNT)
    flow *= OUTPUT / flow.mean()
    pressure, Z_c, C_T = load(rng, flow)
    true = vw.cycle_indices(vw.Recording(pressure, flow, PERIOD), Z_c).values["reflected_energy"]
    waves = (behind(pressure, corners, delay)[::4], flow[::4])
    noisy = [wave + noise * np.ptp(wave) * rng.standard_normal(len(wave)) for wave in waves]
    recorded = vw.Recording(noisy[0], noisy[1], PERIOD)
    estimates = characteristic_impedances(recorded)[[*ESTIMATORS]]
    energies = [vw.cycle_indices(recorded, Z).values["reflected_energy"] for Z in estimates]
    try:
        measured = time_constant(*diastole(recorded)) / recorded.vascular_resistance
    except InputError:  # no decay
        measured = np.nan
    return [*(estimates / Z_c - 1), *(energy / true - 1 for energy in energies), measured / C_T - 1]


def table(count: int) -> Iterator[str]:
    """Yield the lines of the table: medians, and in brackets what a tenth is below and above."""
    yield f"| {' | '.join(HEAD)} |"
    yield "|---" * len(HEAD) + "|"
    for load in (windkessel, line, tree):
        for shape in (sine, squared_sine, early_peak):
            for instrument, of_instrument in INSTRUMENTS.items():
                if instrument != "as it is" and shape is not sine:
                    continue
                off = 100 * np.array([errors([2041, number], load, shape, **of_instrument) for number in range(count)])
                cells = (
                    f"{m:+.0f} % ({low:+.0f} to {high:+.0f})"
                    for low, m, high in np.nanpercentile(off, (10, 50, 90), axis=0).T
                )
                words = (load.__name__, shape.__name__.replace("_", " "), instrument)
                yield f"| {' | '.join([*words, *cells])} |"


if __name__ == "__main__":
    main_of_table(__doc__ or "", "impedances", PAGE, table, 60)
