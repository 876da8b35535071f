"""What a recording alone tells, of recordings with a known truth: power, energies, slopes, notch and ejection.

    python benchmarks/indices.py 100 --docs      a hundred recordings: two minutes; docs/recording-accuracy.md

Each recording is a flow by a formula, sin(π xᵃ) with a leak behind it, into a Windkessel that is solved by its
impedance, and a dicrotic wave. Species, rhythm, rate, breaths and noise vary. Each number has a second way to its
truth: powers and energies as sums over harmonics, slopes of a cycle of 8192 samples without noise, its lowest sample
behind the ejection, and the times that the formula has. A notch that is not there is right where none is told.
"""

import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np

import vasowave as vw
from robustness_page import main_of_table
from vasowave.base.species import heart_rates_of
from vasowave.catheter.signals import RawRecording

PAGE = Path(__file__).parents[1] / "docs" / "recording-accuracy.md"
FINE = 8192
MILLIJOULE = 0.133322387415  # of 1 mmHg ml
CORNERS = 0.005  # SD of what rounds off the corners of the flow, of the period
WALLS = (0.01, 0.02)  # and of what rounds off the pressure once more; of a measured mouse it is 0.025
MATTERS = 0.02
MIN_RISE = 0.01  # of the pulse, behind a notch
SPECIES = {  # period, s; stroke, ml; mean pressure, mmHg; samples/s
    "mouse": (0.11, 0.02, 18.0, (1000, 2000, 4000)),
    "rat": (0.17, 0.2, 20.0, (500, 1000, 2000)),
    "rabbit": (0.25, 1.0, 16.0, (500, 1000)),
    "dog": (0.55, 25.0, 18.0, (250, 500, 1000)),
    "human": (0.85, 75.0, 22.0, (200, 500, 1000)),
}
RHYTHMS = ("steady", "variable", "with the breaths", "extra beats")
NUMBERS = ("SV", "power", "steady_power", "oscillatory_power", "incident_energy", "reflected_energy", "dp_dt_max",
           "dp_dt_min", "notch", "ejection_time", "acceleration_time")  # fmt: skip
TIMES = ("ejection_time", "acceleration_time")
ENERGIES = ("incident_energy", "reflected_energy")
OWN = " by the recording's Z_c"
HEAD = (
    "number",
    "told",
    "within 2 %, times of the period",
    "off by, median",
    "off by, largest",
    "within ± SD of its beats",
)


class Pulse(NamedTuple):
    """One cycle of pressure (mmHg) and flow (ml/s), FINE samples, from the onset of the flow on, and what is true."""

    period: float
    pressure: np.ndarray
    flow: np.ndarray
    truth: dict[str, float]


def drawn_pulse(rng: np.random.Generator, species: str) -> Pulse:
    """Return a cycle of random shape and size, with its truth."""
    period, stroke, mean, _ = SPECIES[species]
    period, stroke, mean = (value * rng.uniform(0.85, 1.15) for value in (period, stroke, mean))
    ejection, skew, leak = rng.uniform(0.3, 0.45), rng.uniform(0.6, 1.0), rng.uniform(0.05, 0.15)
    phase, frequency = np.arange(FINE) / FINE, np.fft.rfftfreq(FINE, 1 / FINE)
    forward = np.where(phase < ejection, np.sin(np.pi * np.clip(phase / ejection, 0, 1) ** skew), 0.0)
    behind = np.clip((phase - ejection) / 0.08, 0, 1)
    flow = rounded_off(forward - leak * np.sin(np.pi * behind), CORNERS)
    flow *= stroke / (period * flow.mean())
    resistance = mean / flow.mean()
    Z_c, decay = rng.uniform(0.06, 0.14) * resistance, rng.uniform(0.5, 1.2)  # of the period
    impedance = Z_c + (resistance - Z_c) / (1 + 2j * np.pi * frequency * decay)
    pressure = np.fft.irfft(np.fft.rfft(flow) * impedance, FINE)
    place, width = ejection + rng.uniform(0.1, 0.15), rng.uniform(0.03, 0.05)
    pressure += rng.uniform(0.05, 0.15) * np.ptp(pressure) * np.exp(-0.5 * ((phase - place) / width) ** 2)
    pressure = rounded_off(pressure, rng.uniform(*WALLS))
    truth = truths(pressure, flow, period, Z_c)
    notch = lowest_before_rise(pressure[(phase > ejection - 0.1) & (phase < place)], np.ptp(pressure))
    times = {"ejection_time": ejection * period, "acceleration_time": 0.5 ** (1 / skew) * ejection * period}
    return Pulse(period, pressure, flow, truth | {"notch": notch, "Z_c": Z_c} | times)


def rounded_off(wave: np.ndarray, share: float) -> np.ndarray:
    """Return a cycle behind a Gaussian of an SD of such a share of the period."""
    return np.fft.irfft(np.fft.rfft(wave) * np.exp(-0.5 * (2 * np.pi * share * np.arange(FINE // 2 + 1)) ** 2), FINE)


def lowest_before_rise(pressure: np.ndarray, pulse: float) -> float:
    """Return the pressure of the notch, the first lowest that enough of a rise follows; NaN where there is none."""
    falls = np.diff(pressure) < 0
    lowest = np.flatnonzero(falls[:-1] & ~falls[1:]) + 1
    rises = [place for place in lowest if pressure[place:].max() - pressure[place] >= MIN_RISE * pulse]
    return float(pressure[rises[0]]) if rises else np.nan


def truths(pressure: np.ndarray, flow: np.ndarray, period: float, Z_c: float) -> dict[str, float]:
    """Return powers and energies as sums over harmonics, and the steepest slopes."""
    p, q = (np.fft.rfft(wave)[:-1] / FINE for wave in (pressure, flow))
    steady, moving = MILLIJOULE * (p[0] * q[0]).real, MILLIJOULE * 2 * (p[1:] * q[1:].conj()).real.sum()
    energies = (
        MILLIJOULE * period * 2 * (np.abs(p[1:] + sign * Z_c * q[1:]) ** 2).sum() / (4 * Z_c) for sign in (1, -1)
    )
    slope = np.gradient(pressure) * FINE / period
    values = (q[0].real * period, steady + moving, steady, moving, *energies, slope.max(), slope.min())
    return dict(zip(NUMBERS, map(float, values), strict=False))


def beat_ends(rng: np.random.Generator, rhythm: str, beats: int) -> np.ndarray:
    """Return where beats end, in usual beats."""
    lengths = np.ones(beats)
    if rhythm == "variable":
        lengths += 0.03 * np.clip(rng.standard_normal(beats), -2.5, 2.5)
    if rhythm == "with the breaths":
        lengths += 0.02 * np.sin(2 * np.pi * np.arange(beats) / rng.uniform(5, 9))
    if rhythm == "extra beats":
        lengths[rng.integers(4, 9) :: rng.integers(7, 11)] = 0.7
    return np.cumsum(lengths)


def drawn_recording(rng: np.random.Generator, species: str, rhythm: str) -> tuple[Pulse, RawRecording]:
    """Return a pulse and a recording of sixty beats of it, with noise, breaths and an ECG in half of them."""
    pulse, rate = drawn_pulse(rng, species), int(rng.choice(SPECIES[species][3]))
    ends = np.concatenate([[0.0], beat_ends(rng, rhythm, 60)])
    time = np.arange(0, ends[-1] * pulse.period, 1 / rate)
    place = np.interp(time / pulse.period, ends, np.arange(len(ends)))  # in beats
    along = place % 1.0 * FINE
    pressure, flow = (np.interp(along, np.arange(FINE + 1), np.append(wave, wave[0])) for wave in pulse[1:3])
    breath = np.clip(np.sin(2 * np.pi * time / (rng.uniform(5, 9) * pulse.period)), 0, None)
    pressure = pressure + rng.choice([0.0, 0.05]) * np.ptp(pressure) * breath
    noise = rng.uniform(0.002, 0.01)
    noisy_pressure, noisy_flow = (wave + noise * np.ptp(wave) * rng.standard_normal(len(wave))
                                  for wave in (pressure, flow))  # fmt: skip
    ecg = np.exp(-0.5 * (((place + 0.08 + 0.5) % 1.0 - 0.5) / 0.01) ** 2)
    has_ecg = rng.random() < 0.5
    noisy_ecg = ecg + 0.02 * rng.standard_normal(len(ecg)) if has_ecg else None
    return pulse, RawRecording(noisy_pressure, noisy_flow, rate, noisy_ecg)


def errors(count: int) -> Iterator[tuple[dict[str, float], dict[str, float]]]:
    """Yield by how much each number is off and the SD of beats, times as a share of the period; else NaN."""
    for number in range(count):
        rng = np.random.default_rng([2031, number])
        species, rhythm = [*SPECIES][number % len(SPECIES)], RHYTHMS[number // len(SPECIES) % len(RHYTHMS)]
        pulse, raw = drawn_recording(rng, species, rhythm)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", vw.errors.VasowaveWarning)
            average = vw.average_beats(raw, 20, heart_rates=heart_rates_of(species))
            indices = vw.cycle_indices(average, pulse.truth["Z_c"]).values
            own = vw.cycle_indices(average).values
            beats = vw.beat_indices(average)
        sizes = {name: pulse.period if name in TIMES else abs(pulse.truth[name]) for name in NUMBERS}
        off = {name: (indices.get(name, np.nan) - pulse.truth[name]) / sizes[name] for name in NUMBERS}
        off |= {name + OWN: own.get(name, np.nan) / pulse.truth[name] - 1 for name in ENERGIES}
        missed = ("notch" in indices) != np.isfinite(pulse.truth["notch"])
        spread = beats.std(ddof=1)
        halves = {name: spread.get(name, np.nan) / sizes[name] for name in NUMBERS if name not in ENERGIES}
        yield off | ({"notch": np.inf} if missed else {}), halves


def right(name: str, off: float) -> bool:
    """Return whether a number is off by less than 2 %; a notch also where none is there and none is told."""
    return off < MATTERS or (name == "notch" and np.isnan(off))


def table(count: int) -> Iterator[str]:
    """Yield the lines of the table."""
    yield f"| {' | '.join(HEAD)} |"
    yield "|---" * len(HEAD) + "|"
    rows = [*errors(count)]
    for name in (*NUMBERS, *(name + OWN for name in ENERGIES)):
        off = np.abs([row[name] for row, _ in rows])
        half = np.array([halves.get(name, np.nan) for _, halves in rows])
        finite, spread = off[np.isfinite(off)], np.isfinite(off) & np.isfinite(half)
        held = f"{np.sum(off[spread] < half[spread])} of {spread.sum()}" if spread.any() else "-"
        shown = f"`{name}`" if name in NUMBERS else f"`{name.removesuffix(OWN)}`{OWN}"
        cells = (shown, f"{len(finite)} of {count}", f"{sum(right(name, value) for value in off)} of {count}",
                 *(f"{100 * value:.1f} %" for value in (np.median(finite), finite.max())), held)  # fmt: skip
        yield f"| {' | '.join(cells)} |"


if __name__ == "__main__":
    main_of_table(__doc__ or "", "indices", PAGE, table, 100)
