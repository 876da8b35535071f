"""How well drift, steps and breaths are told apart in synthetic recordings.

uv run python benchmarks/recording.py                     250 recordings of every kind, seeds from 0
uv run python benchmarks/recording.py 50 --seed 7000      50 of every kind, seeds from 7000
uv run python benchmarks/recording.py 50 --kind linear    one kind

The true pressure is that at the start of the recording, where the transducer was zeroed: what a drift or a step of the
transducer adds later is error, what the animal changes is truth. The constants of the baseline were chosen on the kinds
'none', 'linear', 'warm_up' and 'slow_wave' with seeds below 1000; the other kinds were looked at afterwards.
"""

import argparse
import warnings
from collections.abc import Callable
from dataclasses import replace

import numpy as np
from scipy.interpolate import CubicSpline

from vasowave.base import VasowaveError
from vasowave.catheter import Disturbances, average_beats, synthetic_raw_recording
from vasowave.pulse.cycle import Recording

PHASE = np.arange(512) / 512
PLANTED = 0.3  # mmHg: a smaller drift need not be told
Drift = Callable[[np.ndarray], np.ndarray]


def cycle(rng: np.random.Generator) -> Recording:
    """A smooth cycle of 10 to 30 mmHg and 0.1 to 0.3 ml/s."""
    rise, fall, pulse = rng.uniform(0.3, 0.5), rng.uniform(0.8, 1.6), rng.uniform(9, 20)
    bump = np.sin(np.pi * np.clip((PHASE - 0.08) / (2 * rise), 0, 1)) ** 2 * np.exp(-fall * PHASE)
    systole = np.clip((PHASE - 0.08) / 0.45, 0, 1)
    flow = np.sin(np.pi * systole) ** 2 * (1 - 0.4 * systole)
    pressure = rng.uniform(6, 20) + pulse * bump / bump.max()
    return Recording(pressure, rng.uniform(0.1, 0.3) * flow / flow.mean(), 0.11)


def linear(rng: np.random.Generator, lasts: float, size: float) -> Drift:
    return lambda t: size * t / lasts


def warm_up(rng: np.random.Generator, lasts: float, size: float) -> Drift:
    tau = lasts * rng.uniform(0.1, 0.5)
    return lambda t: size * (1 - np.exp(-t / tau))


def slow_wave(rng: np.random.Generator, lasts: float, size: float) -> Drift:
    period, phase = rng.uniform(8, 2 * lasts), rng.uniform(0, 2 * np.pi)
    return lambda t: 0.5 * size * (np.sin(2 * np.pi * t / period + phase) - np.sin(phase))


def one_step(rng: np.random.Generator, lasts: float, size: float) -> Drift:
    at = lasts * rng.uniform(0.15, 0.85)
    return lambda t: size * (t >= at)


def step_and_line(rng: np.random.Generator, lasts: float, size: float) -> Drift:
    step, line = one_step(rng, lasts, size), linear(rng, lasts, rng.uniform(-4, 4))
    return lambda t: step(t) + line(t)


def knee(rng: np.random.Generator, lasts: float, size: float) -> Drift:
    begins = lasts * rng.uniform(0.2, 0.7)
    return lambda t: size * np.clip(t - begins, 0, None) / (lasts - begins)


def wandering(rng: np.random.Generator, lasts: float, size: float) -> Drift:
    knots = np.arange(0, lasts + 4, 4.0)
    walk = np.cumsum(rng.standard_normal(len(knots)))
    walk = (walk - walk[0]) * size / np.ptp(walk)
    return CubicSpline(knots, walk)


def none(rng: np.random.Generator, lasts: float, size: float) -> Drift:
    return lambda t: 0.0 * t


KINDS = {f.__name__: f for f in (none, linear, warm_up, slow_wave, knee, wandering, one_step, step_and_line)}


def one(kind: str, seed: int) -> tuple[float, float, bool, str]:
    """Error of the mean pressure (mmHg), size of what was planted (mmHg), whether it was told, why it failed."""
    rng = np.random.default_rng([seed, sorted(KINDS).index(kind)])
    lasts, true = float(rng.uniform(10, 40)), cycle(rng)
    size = float(rng.choice([-1, 1]) * rng.uniform(0, 8))
    drift = KINDS[kind](rng, lasts, size)
    asked = Disturbances(
        length_variation=rng.uniform(0.01, 0.03),
        breaths_per_minute=rng.uniform(60, 150),
        ventilation_pressure=rng.uniform(0, 3),
        pressure_drift=0.0,
        pressure_noise=rng.uniform(0.05, 0.3),
    )
    raw = synthetic_raw_recording(
        true, rng, duration=lasts, heart_rate=rng.uniform(400, 650), disturbances=asked, baseline=drift,
        sampling_rate=float(rng.choice([1000, 2000])), ecg=bool(rng.random() < 0.7),
    ).raw  # fmt: skip
    planted = float(np.abs(drift(raw.time)).max())
    if planted > 1 and raw.pressure.mean() < 6:  # a drift below zero pressure is another error's
        raw = replace(raw, pressure=raw.pressure + 10)
        true = replace(true, pressure=true.pressure + 10)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            average = average_beats(raw)
        except VasowaveError as error:
            return np.nan, planted, False, str(error)
    return average.recording.mean_pressure - true.mean_pressure, planted, average.baseline.alarming, ""


def table(kinds: list[str], count: int, seed: int) -> None:
    print("kind            recordings  within 0.15 mmHg  largest error  told if >= 0.3  false alarms  refused")
    for kind in kinds:
        rows = [one(kind, seed + i) for i in range(count)]
        error, planted = (np.array([row[i] for row in rows], dtype=float) for i in (0, 1))
        told, refused = np.array([row[2] for row in rows]), sum(bool(row[3]) for row in rows)
        real = planted >= PLANTED
        recall = f"{100 * told[real].mean():.1f} %" if real.any() else "-"
        alarms = f"{100 * told[planted == 0].mean():.1f} %" if (planted == 0).any() else "-"
        good = 100 * np.mean(np.abs(error) <= 0.15)
        print(
            f"{kind:<15} {count:>10}  {good:>14.1f} %  {np.nanmax(np.abs(error)):>13.2f}  {recall:>14}  "
            f"{alarms:>12}  {refused:>7}"
        )
        for i in np.argsort(-np.nan_to_num(np.abs(error), nan=99))[:3]:
            print(f"    seed {seed + i}: error {error[i]:+.2f} mmHg, planted {planted[i]:.2f} {rows[i][3]}")


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("count", type=int, nargs="?", default=250)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--kind", choices=sorted(KINDS))
    arguments = parser.parse_args()
    table([arguments.kind] if arguments.kind else list(KINDS), arguments.count, arguments.seed)


if __name__ == "__main__":
    main()
