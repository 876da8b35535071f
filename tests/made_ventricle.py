"""Ventricles whose elastance varies in time, filled and loaded as hearts are, while the vena cava is closed.

Written without a look at what analyses them: ``p = e(t) E_es (V - V0) + (1 - e(t)) A (exp(B (V - V0)) - 1)`` with an
activation e(t) from 0 to 1, a source of venous pressure behind a valve, and a three-element Windkessel behind another.
"""

from dataclasses import dataclass

import numpy as np

SPECIES = {  # volume over a human's, period, s
    "mouse": (3e-4, 0.12),
    "rat": (4e-3, 0.17),
    "dog": (0.4, 0.55),
    "human": (1.0, 0.85),
}
SHAPES = ("two hills", "cosine", "gauss", "ramp")
STEPS = 600  # of a beat
BEFORE, DURING = 8, 14  # beats at rest, and while the preload falls


@dataclass(frozen=True)
class MadeVentricle:
    """What is true of a made recording; mmHg, ml, s."""

    name: str
    time: np.ndarray
    pressure: np.ndarray
    volume: np.ndarray
    clean_pressure: np.ndarray
    clean_volume: np.ndarray
    elastance: float
    zero_volume: float
    period: float
    stroke_volume: float
    rate: float


def activation(shape: str, phase: np.ndarray, peak: float) -> np.ndarray:
    """Return e(t), 0 to 1, at phases of the cycle; contraction begins at phase 0."""
    return _raised(shape, phase, peak) / _raised(shape, np.linspace(0, 1, 20001), peak).max()


def _raised(shape, phase, peak):
    t = np.clip(np.asarray(phase) / peak, 1e-9, None)
    if shape == "two hills":  # Stergiopulos, Meister and Westerhof 1996
        rise, fall = (t / 0.7) ** 1.9, np.minimum((t / 1.17) ** 21.9, 1e12)
        return rise / (1 + rise) / (1 + fall)
    if shape == "cosine":
        fallen = 0.5 * (1 + np.cos(np.pi * np.clip((t - 1) / 0.55, 0, 1)))
        return np.where(t < 1, 0.5 * (1 - np.cos(np.pi * t)), fallen)
    if shape == "gauss":
        return np.exp(-0.5 * ((t - 1) / np.where(t < 1, 0.33, 0.17)) ** 2)
    if shape == "ramp":  # nearly straight up, an exponential down
        up, down = np.clip(t, 0, 1), np.exp(-np.clip(t - 1.0, 0, None) / 0.16)
        return np.sin(0.5 * np.pi * up) ** 1.2 * down
    raise ValueError(shape)


def made_ventricles(rng, shapes=SHAPES, species=tuple(SPECIES), each=1, **fixed):
    """Return recordings of ventricles of all shapes and species; `fixed` overrides what is drawn of each."""
    cases = [_drawn(rng, shape, kind) | fixed for shape in shapes for kind in species for _ in range(each)]
    return [_measured(rng, case, *course) for case, course in zip(cases, _courses(cases), strict=True)]


def _drawn(rng, shape, kind):
    size, period = SPECIES[kind]
    right = bool(rng.random() < 0.5)
    rates = {"mouse": (1000, 2000), "rat": (500, 1000, 2000), "dog": (200, 500, 1000), "human": (200, 500, 1000)}
    return {
        "shape": shape,
        "kind": kind,
        "right": right,
        "elastance": rng.uniform(0.6, 1.6) * 2.2,
        "zero_volume": rng.uniform(-8, 25),
        "resistance": rng.uniform(0.7, 1.5) * 1.1,
        "compliance": rng.uniform(0.7, 1.4) * 1.4,
        "filling": rng.uniform(8, 13),
        "period": period * rng.uniform(0.85, 1.15),
        "peak": rng.uniform(0.3, 0.42),
        "rate": int(rng.choice(rates[kind])),
        "noise": rng.uniform(0.003, 0.01),
        "volume_noise": rng.uniform(0.005, 0.02),
        "breaths": float(rng.choice([0.0, rng.uniform(0.3, 1.2)])),
        "drift": rng.uniform(-0.05, 0.05),
        "closing": rng.uniform(0.3, 0.5),
        "reflex": float(rng.choice([0.0, rng.uniform(0.0, 0.08)])),
        "breath_phase": rng.uniform(0, 2 * np.pi),
        "size": size,
        "beats": (BEFORE, DURING),
    }


def _courses(cases):
    """Return times in beats, pressures and volumes of all cases, solved together in human sizes."""
    column = {key: np.array([case[key] for case in cases], dtype=float) for key in cases[0] if key not in
              ("shape", "kind", "beats")}  # fmt: skip
    strength = np.where(column["right"] > 0, 0.25, 1.0)  # of the right ventricle over the left one
    E, V0 = column["elastance"] * strength, column["zero_volume"]
    A, B = 1.0 * np.sqrt(strength), 0.022
    R, C, Z = column["resistance"] * strength, column["compliance"] / strength, 0.06 * strength
    T = 0.85  # of all: time is that of a human
    dt = T / STEPS
    before, during = cases[0]["beats"]
    settling = 8
    phase = np.arange(STEPS) / STEPS
    e = np.stack([activation(case["shape"], phase, case["peak"]) for case in cases], axis=1)
    V, pC = V0 + 90.0, 60.0 * strength
    pressures, volumes = [], []
    for beat in range(settling + before + during):
        fallen = np.clip((beat - settling - before) / max(during - 1, 1), 0, 1)
        breath = column["breaths"] * np.sin(2 * np.pi * beat / 4.6 + column["breath_phase"])
        filling = column["filling"] * (1 - (1 - column["closing"]) * fallen) + 0.3 * breath
        filling = np.where(column["right"] > 0, 0.75, 1.0) * filling
        for step in range(STEPS):
            above = V - V0
            p = e[step] * E * above + (1 - e[step]) * A * np.expm1(B * above)
            into = np.maximum(filling - p, 0) / 0.008
            out = np.maximum(p - pC, 0) / (0.01 * strength + Z)
            if beat >= settling:
                pressures.append(p)
                volumes.append(V)
            V = V + dt * (into - out)
            pC = pC + dt * (out - (pC - 3 * strength) / R) / C
    return list(zip(np.array(pressures).T, np.array(volumes).T, strict=True))


def _measured(rng, case, pressure, volume):
    """Return a recording as an instrument would write it."""
    beats = sum(case["beats"])
    lengths = case["period"] * (1 - case["reflex"] * np.clip((np.arange(beats) - case["beats"][0]) / 8, 0, 1))
    ends = np.concatenate([[0], np.cumsum(lengths)])
    fine = np.interp(np.arange(len(pressure)) / STEPS, np.arange(beats + 1), ends)
    # It begins somewhere in a cycle.
    time = np.arange(0, ends[-1] - ends[1] * 0.6, 1 / case["rate"])
    p, V = (np.interp(time + 0.55 * ends[1], fine, values) for values in (pressure, volume))
    V = V * case["size"]
    stroke = float(np.ptp(V[time < 3 * case["period"]]))
    breath = case["breaths"] * np.sin(2 * np.pi * (time / case["period"] + 0.55) / 4.6 + case["breath_phase"] + 0.7)
    noisy = p + case["noise"] * np.ptp(p) * rng.standard_normal(len(p)) + breath + case["drift"] * time
    noisy_volume = V + case["volume_noise"] * stroke * rng.standard_normal(len(p))
    strength = 0.25 if case["right"] else 1.0
    name = f"{case['kind']}, {'right' if case['right'] else 'left'}, {case['shape']}, {case['rate']}/s"
    return MadeVentricle(
        name, time, noisy, noisy_volume, p, V, case["elastance"] * strength / case["size"],
        case["zero_volume"] * case["size"], case["period"], stroke, case["rate"],
    )  # fmt: skip
