"""How often the interval of E_es/E_a holds the truth, for ventricles whose elastance has other shapes.

    python benchmarks/coupling.py 20 --docs      twenty hearts of each kind: minutes; the table goes to docs/coverage.md

Each heart ejects into the control network; stiffness and resistance of the network, peak, filling and valve of the
ventricle vary. Ventricle and artery get white noise and are cut anywhere in the cycle. The shapes that the table calls
seen were in sight while the priors and the SD of the shape were chosen, the others were not.
"""

import argparse
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np

import vasowave as vw
from robustness_page import put
from vasowave.base import VasowaveError
from vasowave.pulse.model import activation, windkessels

PAGE = Path(__file__).parents[1] / "docs" / "coverage.md"
PERIOD, NOISE = 0.11, 0.2  # s, mmHg
HEAD = ("elastance", "seen", "hearts", "ratio found over true, median", "between which 90 % lie", "95 % hold")


def cosines(t: np.ndarray) -> np.ndarray:
    """Half a cosine up, half one down."""
    return np.where(t < 1, 0.5 - 0.5 * np.cos(np.pi * t), 0.5 + 0.5 * np.cos(np.pi * np.clip((t - 1) / 0.6, 0, 1)))


def gaussians(t: np.ndarray) -> np.ndarray:
    """Two halves of Gaussians."""
    rest = np.exp(-0.5 / 0.45**2)
    hill = np.exp(-0.5 * ((t - 1) / np.where(t < 1, 0.45, 0.22)) ** 2)
    return np.clip((hill - rest) / (1 - rest), 0, None)


def saturating(t: np.ndarray) -> np.ndarray:
    """A rise that saturates, and a Gaussian relaxation."""
    return np.where(t < 1, (1 - np.exp(-2.2 * t**1.5)) / (1 - np.exp(-2.2)), np.exp(-(((t - 1) / 0.28) ** 2)))


def logistic(t: np.ndarray) -> np.ndarray:
    """A logistic rise and fall."""

    def hill(t: np.ndarray) -> np.ndarray:
        return 1 / (1 + np.exp(-9 * (t - 0.5))) / (1 + np.exp(11 * (t - 1.25)))

    return np.clip((hill(t) - hill(np.zeros(1))) / (hill(np.linspace(0, 2, 999)).max() - hill(np.zeros(1))), 0, None)


def beta(t: np.ndarray) -> np.ndarray:
    """A density of the beta distribution."""
    share = np.clip(t / 1.5, 0, 1)
    return (share**2 * (1 - share)) / (4 / 27)


def ramp(t: np.ndarray) -> np.ndarray:
    """A straight rise with a rounded top, and an exponential relaxation."""
    edge = np.convolve(np.interp(t, [0, 0.15, 0.95, 1.1], [0, 0.05, 1, 1]), np.ones(25) / 25, "same")
    return edge * np.where(t < 1.05, 1.0, np.exp(-np.clip(t - 1.05, 0, None) / 0.13))


KINDS: dict[str, tuple[Callable[[np.ndarray], np.ndarray], bool]] = {
    "published": (lambda t: activation(t, 1.0), True),
    "half cosines": (cosines, True),
    "half Gaussians": (gaussians, True),
    "saturating": (saturating, True),
    "logistic": (logistic, True),
    "beta density": (beta, False),
    "ramp, exponential relaxation": (ramp, True),
}


def hearts(shape: Callable[[np.ndarray], np.ndarray], count: int, rng: np.random.Generator) -> Iterator[tuple]:
    """Yield recording, pressure of the ventricle, and true E_es/E_a."""
    network, made = vw.control_network(), 0
    while made < count:
        R_T, tau, stiff = (np.exp(rng.normal(np.log(m), s)) for m, s in ((90, 0.35), (0.12, 0.25), (60, 0.4)))
        peak, filled = np.exp(rng.normal(np.log(1500), 0.35)), np.exp(rng.normal(np.log(0.04), 0.25))
        at, filling, valve = rng.uniform(0.3, 0.42), rng.uniform(2, 8), rng.uniform(0.3, 2)
        rest = filling / filled
        if rest > peak / 4:
            continue
        elastance = rest + (peak - rest) * shape(np.arange(1024) / 1024 / at)
        model = vw.Model(network, vw.LinearWall(stiff), windkessels(network, R_T, tau, 0.2))
        try:
            waves = vw.simulate(model, vw.Ventricle(elastance, PERIOD, filling, valve), vw.Numerics(samples=512))
        except VasowaveError:
            continue
        made += 1
        at_root = waves.sel(vessel=network.name[network.root], station="inlet")
        inside, volume = waves.ventricular_pressure.to_numpy(), waves.ventricular_volume.to_numpy()
        load = inside[np.argmax(inside / volume)] / (volume[0] - volume[-1])
        peak = int(np.argmax(inside))
        empty = peak + int(np.argmax(inside[peak:] <= 1.05 * inside[-1]))
        inside[empty:] = np.linspace(inside[empty], filling, len(inside) - empty)  # it fills again
        turned = np.roll(inside + NOISE * rng.standard_normal(512), rng.integers(512))
        pressure = at_root.pressure.to_numpy() + NOISE * rng.standard_normal(512)
        recording = vw.Recording(pressure, np.clip(at_root.flow.to_numpy(), 0, None), PERIOD)
        yield recording, vw.VentricularPressure(turned, PERIOD), elastance.max() / load


def row(kind: str, count: int) -> str:
    """Return the row of one kind of elastance."""
    shape, seen = KINDS[kind]
    rng = np.random.default_rng([2026, list(KINDS).index(kind)])
    found = [(vw.coupling(recording, inside), true) for recording, inside, true in hearts(shape, count, rng)]
    off = np.array([np.log(one.ratio / true) for one, true in found])
    held = int(np.sum(np.abs(off) < 1.96 * np.array([one.error for one, _ in found])))
    low, middle, high = np.exp(np.quantile(off, (0.05, 0.5, 0.95)))
    cells = (kind, "yes" if seen else "no", count, f"{middle:.2f}", f"{low:.2f} to {high:.2f}", f"{held} of {count}")
    return f"| {' | '.join(map(str, cells))} |"


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("count", type=int, nargs="?", default=20)
    parser.add_argument("--docs", action="store_true")
    options = parser.parse_args()
    lines = [f"| {' | '.join(HEAD)} |", "|---" * len(HEAD) + "|"]
    for kind in KINDS:
        lines.append(row(kind, options.count))
        print(lines[-1], flush=True)
    if options.docs:
        put("coupling", "\n".join(lines), PAGE)


if __name__ == "__main__":
    main()
