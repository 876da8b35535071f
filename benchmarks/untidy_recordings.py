"""Untidy recordings of a known truth by a generator of their own: what the average makes of each kind.

uv run python benchmarks/untidy_recordings.py                       all kinds, six seeds each
uv run python benchmarks/untidy_recordings.py 3 --kind sine hum     three seeds of two kinds

A heart ejects beat by beat into a tube that ends in a Windkessel, solved in time, so that every rhythm has the pressure
that belongs to it. On top come breaths, instruments and accidents. True are mean pressure, mean flow and heart rate of
the animal at end-expiration, or over breaths that rest at neither end, before any intervention. A number that is off by
more than 2 % without a finding that asks for a look is silently wrong.
"""

import argparse
import warnings
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from scipy.signal import butter, lfilter, sosfilt, sosfilt_zi

from vasowave.base import Severity, VasowaveError
from vasowave.catheter.signals import Comment, RawRecording

MATTERS = 0.02


@dataclass(frozen=True)
class Animal:
    """Beat length, s; stroke volume, ml; ejection, s; resistances, mmHg s/ml; decay, s; travel time, s."""

    beat: float
    stroke: float
    ejection: float
    characteristic: float
    resistance: float
    decay: float
    travel: float
    rate: float = 1000.0


def mouse(rng: np.random.Generator, rate: float = 1000.0) -> Animal:
    beat, flow, mean = 60 / rng.uniform(430, 600), rng.uniform(0.14, 0.25), rng.uniform(15, 30)
    resistance = mean / flow
    return Animal(beat, flow * beat, 0.45 * beat, 0.1 * resistance, 0.9 * resistance, 1.0 * beat, 0.03 * beat, rate)


def human(rng: np.random.Generator) -> Animal:
    beat, flow, mean = 60 / rng.uniform(58, 85), rng.uniform(70, 110), rng.uniform(14, 45)
    resistance = mean / flow
    return Animal(beat, flow * beat, 0.32, 0.08 * resistance, 0.92 * resistance, 0.8 * beat, 0.03 * beat, 500.0)


@dataclass
class Scene:
    """Signals by time, and the truth: mean pressure, mean flow, heart rate."""

    time: np.ndarray
    pressure: np.ndarray
    flow: np.ndarray
    ecg: np.ndarray | None
    truth: tuple[float, float, float]
    animal: Animal
    comments: tuple[Comment, ...] = ()

    def raw(self) -> RawRecording:
        return RawRecording(
            self.pressure, self.flow, self.animal.rate, self.ecg, "generated", comments=self.comments
        )  # fmt: skip


Rhythm = Callable[[np.random.Generator, int], tuple[np.ndarray, np.ndarray]]
"""Lengths and strokes of so many beats, in those of the usual one."""


def regular(rng: np.random.Generator, count: int) -> tuple[np.ndarray, np.ndarray]:
    return 1 + 0.015 * np.clip(rng.standard_normal(count), -3, 3), 1 + 0.01 * rng.standard_normal(count)


def play(
    rng: np.random.Generator, animal: Animal, lasts: float, rhythm: Rhythm = regular, ecg: bool = True,
    course: Callable[[np.ndarray], np.ndarray] | None = None,
) -> Scene:  # fmt: skip
    """Return the heart alone, with a little noise; `course` multiplies resistance over time."""
    lead = 30 * animal.beat
    rng_beats = np.random.default_rng(rng.integers(1 << 31))
    count = int((lead + lasts) / animal.beat * 2.5) + 20
    lengths, strokes = rhythm(rng_beats, count)
    starts = np.concatenate([[0.0], np.cumsum(lengths * animal.beat)[:-1]]) + rng.uniform(0, animal.beat)
    time = np.arange(round((lead + lasts) * animal.rate)) / animal.rate - lead
    starts = starts - lead
    flow = np.zeros(len(time))
    for start, stroke in zip(starts, strokes, strict=True):
        if start > time[-1]:
            break
        near = slice(*np.searchsorted(time, [start, start + animal.ejection]))
        x = (time[near] - start) / animal.ejection
        flow[near] += stroke * animal.stroke / animal.ejection * 2.0 * np.sin(np.pi * x**0.85) ** 2
    pressure = _tube(flow, animal, None if course is None else course(time))
    electric = None
    if ecg:
        electric, width = 0.04 * rng.standard_normal(len(time)), 0.0015 if animal.beat < 0.3 else 0.012
        for start in starts:
            at = start - 0.1 * min(animal.beat, 0.9)
            near = slice(*np.searchsorted(time, [at - 6 * width, at + 6 * width]))
            electric[near] += np.exp(-0.5 * ((time[near] - at) / width) ** 2)
        electric += 0.2 * np.sin(2 * np.pi * 1.3 * time)
    here = time >= -1e-9
    within = (starts >= 0) & (starts < lasts)
    inside = starts[within]
    whole = here & (time >= inside[0]) & (time < inside[-1])
    truth = (
        float(pressure[whole].mean()), float(flow[whole].mean()), 60 * (len(inside) - 1) / float(np.ptp(inside)),
    )  # fmt: skip
    noisy = pressure[here] + 0.1 * rng.standard_normal(here.sum())
    flowing = flow[here] + 0.004 * np.ptp(flow) * rng.standard_normal(here.sum())
    return Scene(time[here], noisy, flowing, None if electric is None else electric[here], truth, animal)


def _tube(flow: np.ndarray, animal: Animal, course: np.ndarray | None) -> np.ndarray:
    """Return the pressure at the inlet of a tube with a Windkessel at its end."""
    step, zc = 1 / animal.rate, animal.characteristic
    if course is not None:  # the lumped Windkessel with a resistance that changes
        pressure, state = np.zeros(len(flow)), animal.resistance * flow.mean()
        compliance = animal.decay / animal.resistance
        for i, inflow in enumerate(flow):
            state += step * (inflow - state / (animal.resistance * course[i])) / compliance
            pressure[i] = zc * inflow + state
        return pressure
    r1, r2, tau = 1.2 * zc, animal.resistance - 0.2 * zc, animal.decay
    k = tau / step
    # Gamma = (ZL - zc)/(ZL + zc), ZL = r1 + r2/(1 + s tau), s = backward difference
    top, bottom = (
        np.array([r1 - zc + r2 + (r1 - zc) * k, -(r1 - zc) * k]),
        np.array([r1 + zc + r2 + (r1 + zc) * k, -(r1 + zc) * k]),
    )
    late = max(1, round(2 * animal.travel * animal.rate))
    forward, backward = np.zeros(len(flow)), np.zeros(len(flow) + late)
    state = np.zeros(1)
    for first in range(0, len(flow), late):
        part = slice(first, min(first + late, len(flow)))
        forward[part] = zc * flow[part] + backward[part]
        reflected, state = lfilter(top / bottom[0], bottom / bottom[0], forward[part], zi=state)
        backward[first + late : first + late + len(reflected)] = reflected
    return forward + backward[: len(flow)]


def breathe(scene: Scene, rng: np.random.Generator, shape: Callable[[np.ndarray], np.ndarray], height: float,
            per_minute: float | None = None, flow: float = 0.05) -> Scene:  # fmt: skip
    """Return the scene with breaths: `shape` over the phase 0 to 1 is 0 at end-expiration."""
    rate = (per_minute or (rng.uniform(70, 110) if scene.animal.beat < 0.3 else rng.uniform(11, 16))) / 60
    swell = shape((scene.time * rate + rng.random()) % 1.0)
    pressure, output, heart_rate = scene.truth
    if shape in (sine_shape, square):  # which rest at neither end
        share = float(shape(np.arange(1000) / 1000).mean())
        pressure, output = pressure + share * height, output * (1 - share * flow)
    return replace(scene, pressure=scene.pressure + height * swell, flow=scene.flow * (1 - flow * np.abs(swell)),
                   truth=(pressure, output, heart_rate))  # fmt: skip


def hump(phase: np.ndarray) -> np.ndarray:
    return np.where(phase < 0.4, np.sin(np.pi * phase / 0.4) ** 2, 0.0)


def sine_shape(phase: np.ndarray) -> np.ndarray:
    return 0.5 - 0.5 * np.cos(2 * np.pi * phase)


def square(phase: np.ndarray) -> np.ndarray:
    return 0.5 * (np.tanh((phase - 0.05) / 0.02) - np.tanh((phase - 0.5) / 0.03))


def ramp(phase: np.ndarray) -> np.ndarray:
    return np.where(phase < 0.4, phase / 0.4, np.exp(-(phase - 0.4) / 0.12))


def dip(phase: np.ndarray) -> np.ndarray:
    return -hump(phase)


def block(every: int) -> Rhythm:
    def lengths(rng: np.random.Generator, count: int) -> tuple[np.ndarray, np.ndarray]:
        length, stroke = regular(rng, count)
        length[every - 1 :: every] *= 2.0
        return length, stroke

    return lengths


def silent(every: int) -> Rhythm:
    """Beats of the ECG of which every so manieth ejects nothing."""

    def strokes(rng: np.random.Generator, count: int) -> tuple[np.ndarray, np.ndarray]:
        length, stroke = regular(rng, count)
        stroke[every - 1 :: every] = 0.0
        return length, stroke

    return strokes


def fibrillation(rng: np.random.Generator, count: int) -> tuple[np.ndarray, np.ndarray]:
    length = np.clip(rng.gamma(25, 1 / 25, count), 0.6, 1.7)
    before = np.concatenate([[1.0], length[:-1]])
    return length, 1.6 * (1 - np.exp(-before / 1.0))


def alternans(rng: np.random.Generator, count: int) -> tuple[np.ndarray, np.ndarray]:
    length, stroke = regular(rng, count)
    return length, stroke * (1 + 0.15 * (-1.0) ** np.arange(count))


def bigeminy(rng: np.random.Generator, count: int) -> tuple[np.ndarray, np.ndarray]:
    length, stroke = regular(rng, count)
    odd = np.arange(count) % 2 == 1
    return length * np.where(odd, 1.3, 0.7), stroke * np.where(odd, 0.6, 1.2)


def extrasystoles(rng: np.random.Generator, count: int) -> tuple[np.ndarray, np.ndarray]:
    length, stroke = regular(rng, count)
    for at in np.flatnonzero(rng.random(count - 1) < 0.05):
        length[at : at + 2], stroke[at + 1] = (0.65, 1.35), 0.5
    return length, stroke


def sinus(share: float, per_beat: float) -> Rhythm:
    """A heart rate that rises and falls so many times a beat, by a share, and no breath in the pressure."""

    def lengths(rng: np.random.Generator, count: int) -> tuple[np.ndarray, np.ndarray]:
        length, stroke = regular(rng, count)
        return length * (1 + share * np.sin(2 * np.pi * per_beat * np.arange(count) + rng.random())), stroke

    return lengths


def trigeminy(rng: np.random.Generator, count: int) -> tuple[np.ndarray, np.ndarray]:
    length, stroke = regular(rng, count)
    third = np.arange(count) % 3
    return length * np.choose(third, [1.0, 0.65, 1.35]), stroke * np.choose(third, [1.0, 1.0, 0.5])


def wenckebach(rng: np.random.Generator, count: int) -> tuple[np.ndarray, np.ndarray]:
    length, stroke = regular(rng, count)
    return length * np.choose(np.arange(count) % 4, [1.06, 1.02, 1.0, 1.75]), stroke


def slow_waves(rng: np.random.Generator, count: int) -> tuple[np.ndarray, np.ndarray]:
    length, stroke = regular(rng, count)
    return length * (1 + 0.05 * np.sin(2 * np.pi * np.arange(count) / 70)), stroke


def with_breath(
    rng: np.random.Generator, rhythm: float, shape: Callable[[np.ndarray], np.ndarray], height: float
) -> Scene:
    """Return a heart whose rate swings with the breath that moves the pressure, at one rate and with a lag."""
    animal = mouse(rng)
    rate = rng.uniform(1.2, 1.7)
    return breathe(play(rng, animal, 20.0, sinus(rhythm, rate * animal.beat)), rng, shape, height, 60 * rate)


def pause(lead: int, seconds_in_beats: float) -> Rhythm:
    def lengths(rng: np.random.Generator, count: int) -> tuple[np.ndarray, np.ndarray]:
        length, stroke = regular(rng, count)
        length[lead] = seconds_in_beats
        return length, stroke

    return lengths


def catheter(scene: Scene, natural: float, damping: float) -> Scene:
    fine, rate = 8, scene.animal.rate * 8
    time = np.arange(len(scene.pressure) * fine) / rate
    values = np.interp(time, scene.time, scene.pressure)
    omega, state, speed = 2 * np.pi * natural, values[0], 0.0
    heard = np.empty(len(values))
    for i, one in enumerate(values):
        speed += (omega**2 * (one - state) - 2 * damping * omega * speed) / rate
        state += speed / rate
        heard[i] = state
    return replace(scene, pressure=heard[::fine])


def shifted(scene: Scene, signal: str, delay: Callable[[np.ndarray], np.ndarray]) -> Scene:
    return replace(scene, **{signal: np.interp(scene.time - delay(scene.time), scene.time, getattr(scene, signal))})


def spiked(scene: Scene, rng: np.random.Generator, rate: float) -> Scene:
    pressure, flow = scene.pressure.copy(), scene.flow.copy()
    for values in (pressure, flow):
        at = rng.integers(0, len(values), round(rate * scene.time[-1]))
        pulse = np.ptp(scene.flow if values is flow else scene.pressure)
        values[at] += rng.choice([-1, 1, 1], len(at)) * rng.uniform(2, 6, len(at)) * pulse
    return replace(scene, pressure=pressure, flow=flow)


def drug(rng: np.random.Generator, text: str, after: float) -> Scene:
    animal, at = mouse(rng), rng.uniform(15, 30)
    scene = play(rng, animal, 60.0, course=lambda t: 1 + (after - 1) / (1 + np.exp(-(t - at - 3) / 0.5)))
    before = play(np.random.default_rng(rng.integers(1 << 31)), animal, 20.0, course=lambda t: 1 + 0 * t)
    return replace(scene, comments=(Comment(2.0, "baseline"), Comment(at, text)), truth=before.truth)


def _plain(rng: np.random.Generator) -> Scene:
    return breathe(play(rng, mouse(rng), 12.0), rng, hump, 1.5)


def _no_ecg(rng: np.random.Generator) -> Scene:
    return breathe(play(rng, mouse(rng), 12.0, ecg=False), rng, hump, 1.5)


def hummed(scene: Scene, hertz: float, pressure: float = 0.0, flow: float = 0.0, phase: float = 0.0) -> Scene:
    """Return a scene with mains hum of so many mmHg, and of a share of the flow's pulse."""
    hum = np.sin(2 * np.pi * hertz * scene.time + phase)
    return replace(scene, pressure=scene.pressure + pressure * hum, flow=scene.flow + flow * np.ptp(scene.flow) * hum)


def amplified(scene: Scene, rng: np.random.Generator, cutoff: float, order: int = 1, sd: float = 0.2) -> Scene:
    """Return a scene whose pressure, with white noise, went through an analog low-pass: eight times as many samples."""
    rate, fine = scene.animal.rate, 8
    inner = np.interp(np.arange(fine * len(scene.time)) / fine, np.arange(len(scene.time)), scene.pressure)
    sections = butter(order, cutoff, fs=fine * rate, output="sos")
    start = sosfilt_zi(sections) * inner[0]
    heard = inner + sd * np.sqrt(fine) * rng.standard_normal(len(inner))
    return replace(scene, pressure=sosfilt(sections, heard, zi=start)[0][::fine])


def noisy(scene: Scene, rng: np.random.Generator, sd: float) -> Scene:
    return replace(scene, pressure=scene.pressure + sd * rng.standard_normal(len(scene.time)))


def locked(rng: np.random.Generator) -> Scene:
    """Return a scene whose breaths last a whole number of beats, all of one length."""
    animal = mouse(rng)
    scene = play(rng, animal, 15.0, rhythm=lambda g, n: (np.ones(n), np.ones(n)))
    return breathe(scene, rng, hump, 4.0, 60 / animal.beat / int(rng.integers(3, 7)))


def dropped_out(scene: Scene, rng: np.random.Generator, rate: float) -> Scene:
    """Return a scene whose signals are 0 for one to three samples, so many times a second, as in telemetry."""
    gone = np.zeros(len(scene.time), dtype=bool)
    for at in rng.integers(5, len(gone) - 5, round(rate * scene.time[-1])):
        gone[at : at + int(rng.integers(1, 4))] = True
    return replace(scene, pressure=np.where(gone, 0.0, scene.pressure), flow=np.where(gone, 0.0, scene.flow))


def doubly_spiked(scene: Scene, rng: np.random.Generator) -> Scene:
    pressure = scene.pressure.copy()
    for at in rng.integers(5, len(pressure) - 5, round(8 * scene.time[-1])):
        pressure[at : at + 2] += rng.uniform(10, 60)
    return replace(scene, pressure=pressure)


def salvos(rng: np.random.Generator, count: int) -> tuple[np.ndarray, np.ndarray]:
    length, stroke = regular(rng, count)
    fourth = np.arange(count) % 4
    return length * np.choose(fourth, [0.7, 0.7, 0.7, 1.7]), stroke * np.choose(fourth, [1.3, 0.6, 0.6, 0.7])


def moved(scene: Scene, rng: np.random.Generator) -> Scene:
    """Return a scene with a second in which the animal moves the catheter."""
    at = rng.uniform(3, 8)
    shaken = np.where(np.abs(scene.time - at) < 0.5, 8.0, 0.0) * rng.standard_normal(len(scene.time))
    return replace(scene, pressure=scene.pressure + shaken)


def lost_contact(scene: Scene, rng: np.random.Generator) -> Scene:
    at = rng.uniform(3, 9)
    return replace(scene, flow=scene.flow * (np.abs(scene.time - at) > 1.5))


KINDS: dict[str, Callable[[np.random.Generator], Scene]] = {
    "plain": _plain,
    "plain no ECG": lambda r: breathe(play(r, mouse(r), 12.0, ecg=False), r, hump, 1.5),
    "plain human": lambda r: breathe(play(r, human(r), 60.0), r, hump, 3.0),
    "sine 4": lambda r: breathe(play(r, mouse(r), 15.0), r, sine_shape, 4.0),
    "sine 4 no ECG": lambda r: breathe(play(r, mouse(r), 15.0, ecg=False), r, sine_shape, 4.0),
    "sine human": lambda r: breathe(play(r, human(r), 60.0), r, sine_shape, 4.0),
    "square 1:1": lambda r: breathe(play(r, mouse(r), 15.0), r, square, 4.0),
    "ramp": lambda r: breathe(play(r, mouse(r), 15.0), r, ramp, 4.0),
    "own breaths": lambda r: breathe(play(r, mouse(r), 15.0), r, dip, 3.0),
    "locked breaths": locked,
    "hum 2": lambda r: hummed(_no_ecg(r), 50.0, 2.0, phase=r.random()),
    "hum 60": lambda r: hummed(_no_ecg(r), 60.0, 1.5, phase=r.random()),
    "hum flow": lambda r: hummed(_plain(r), 50.0, flow=0.15),
    "block 2:1": lambda r: play(r, mouse(r), 20.0, block(2)),
    "block 3:2": lambda r: play(r, mouse(r), 20.0, block(2)),
    "block 4:3": lambda r: play(r, mouse(r), 20.0, block(3)),
    "block 4:3 no ECG": lambda r: play(r, mouse(r), 20.0, block(3), ecg=False),
    "block 5:4 human": lambda r: play(r, human(r), 60.0, block(4)),
    "silent 4": lambda r: play(r, mouse(r), 20.0, silent(4)),
    "silent 3 no ECG": lambda r: play(r, mouse(r), 20.0, silent(3), ecg=False),
    "fibrillation": lambda r: play(r, human(r), 40.0, fibrillation),
    "fibrillation mouse": lambda r: play(r, mouse(r), 20.0, fibrillation),
    "alternans": lambda r: play(r, mouse(r), 12.0, alternans),
    "bigeminy": lambda r: play(r, mouse(r), 15.0, bigeminy),
    "bigeminy no ECG": lambda r: play(r, mouse(r), 15.0, bigeminy, ecg=False),
    "extrasystoles": lambda r: play(r, mouse(r), 15.0, extrasystoles),
    "sinus arrhythmia": lambda r: (lambda a: play(r, a, 20.0, sinus(0.08, 1.1 * a.beat)))(mouse(r)),
    "sinus no ECG": lambda r: (lambda a: play(r, a, 20.0, sinus(0.08, 1.1 * a.beat), ecg=False))(mouse(r)),
    "sinus ventilated": lambda r: (
        lambda a: breathe(play(r, a, 20.0, sinus(0.05, 1.1 * a.beat)), r, sine_shape, 4.0)
    )(mouse(r)),
    "sinus human": lambda r: (lambda a: play(r, a, 60.0, sinus(0.08, 0.22 * a.beat)))(human(r)),
    "pause of 2 s": lambda r: (lambda a: play(r, a, 8.0, pause(30 + 20, 2.0 / a.beat)))(mouse(r)),
    "2.5 s": lambda r: play(r, mouse(r), 2.5),
    "2 s no ECG": lambda r: play(r, mouse(r), 2.0, ecg=False),
    "15 s human": lambda r: play(r, human(r), 15.0),
    "flow zero": lambda r: (
        lambda s: replace(s, flow=s.flow + r.choice([-1, 1]) * r.uniform(0.05, 0.07) * s.truth[1])
    )(_plain(r)),
    "resonant": lambda r: catheter(_plain(r), r.uniform(30, 60), r.uniform(0.1, 0.2)),
    "damped": lambda r: catheter(_plain(r), r.uniform(10, 16), r.uniform(0.7, 1.1)),
    "damped human": lambda r: catheter(play(r, human(r), 60.0), r.uniform(2, 4), r.uniform(0.8, 1.2)),
    "spikes": lambda r: spiked(_plain(r), r, 3.0),
    "many spikes": lambda r: spiked(_plain(r), r, 20.0),
    "noise 3": lambda r: noisy(_plain(r), r, 3.0),
    "noise 3 no ECG": lambda r: replace(noisy(_plain(r), r, 3.0), ecg=None),
    "clock 0.1 %": lambda r: shifted(breathe(play(r, mouse(r), 60.0), r, hump, 1.5), "flow", lambda t: 1e-3 * t),
    "pressure late": lambda r: shifted(_plain(r), "pressure", lambda t: 0.004 + 0 * t),
    "flow late": lambda r: shifted(_plain(r), "flow", lambda t: 0.004 + 0 * t),
    "drift": lambda r: (lambda s: replace(s, pressure=s.pressure + 3 * s.time / 25))(
        breathe(play(r, mouse(r), 25.0), r, hump, 2.0)
    ),
    "sag 20 %": lambda r: (
        lambda s: replace(s, flow=s.flow * np.where(np.abs(s.time - r.uniform(4, 10)) < 2.5, 0.8, 1.0))
    )(_plain(r)),
    "sildenafil": lambda r: drug(r, "sildenafil 1 mg/kg i.v.", 0.74),
    "hypoxia": lambda r: drug(r, "10 % O2", 1.5),
    "apart: trigeminy": lambda r: play(r, mouse(r), 15.0, trigeminy),
    "apart: wenckebach": lambda r: play(r, mouse(r), 15.0, wenckebach),
    "apart: slow waves": lambda r: play(r, mouse(r), 30.0, slow_waves),
    "apart: own+rhythm": lambda r: with_breath(r, 0.03, dip, 3.0),
    "apart: hump+rhythm": lambda r: with_breath(r, 0.03, hump, 3.0),
    "apart: sine+rhythm": lambda r: with_breath(r, 0.02, sine_shape, 4.0),
    "apart: sine 8": lambda r: breathe(play(r, mouse(r), 15.0), r, sine_shape, 8.0),
    "apart: sine 2.3 Hz": lambda r: breathe(play(r, mouse(r), 15.0), r, sine_shape, 3.0, 138.0),
    "apart: own, flow too": lambda r: breathe(play(r, mouse(r), 15.0), r, dip, 2.0, flow=0.15),
    "apart: hum 100 Hz": lambda r: hummed(_no_ecg(r), 100.0, 2.0),
    "unseen: dropouts": lambda r: dropped_out(_plain(r), r, 5.0),
    "unseen: spikes of 2": lambda r: doubly_spiked(play(r, mouse(r, 2000.0), 12.0, ecg=False), r),
    "unseen: clock": lambda r: shifted(
        breathe(play(r, mouse(r), 40.0, ecg=False), r, hump, 1.5), "flow", lambda t: -2e-4 * t
    ),
    "unseen: clock of ECG": lambda r: shifted(play(r, mouse(r), 40.0), "ecg", lambda t: 2e-3 * t),
    "unseen: late, sine": lambda r: shifted(
        breathe(play(r, mouse(r), 15.0), r, sine_shape, 3.0), "pressure", lambda t: 0.008 + 0 * t
    ),
    "unseen: trigeminy": lambda r: play(r, mouse(r), 15.0, trigeminy, ecg=False),
    "unseen: fibrillation": lambda r: play(r, mouse(r), 20.0, fibrillation, ecg=False),
    "unseen: movement": lambda r: moved(_plain(r), r),
    "unseen: contact": lambda r: lost_contact(_plain(r), r),
    "low-pass 50": lambda r: amplified(_plain(r), r, 50.0),
    "low-pass 100": lambda r: amplified(_plain(r), r, 100.0),
    "low-pass 30, 2nd": lambda r: amplified(_plain(r), r, 30.0, 2),
    "low-pass 20 human": lambda r: amplified(breathe(play(r, human(r), 60.0), r, hump, 3.0), r, 20.0),
    "unseen: salvos": lambda r: play(r, mouse(r), 15.0, salvos),
}  # fmt: skip


@dataclass(frozen=True)
class Outcome:
    """Relative errors of mean, flow and rate; the mean's error in its stated ones; looks; why it was refused."""

    errors: tuple[float, float, float]
    off: float
    stated: float
    looks: tuple[str, ...]
    refused: str = ""

    @property
    def silent(self) -> bool:
        return not self.refused and not self.looks and max(map(abs, self.errors)) > MATTERS


def outcome(kind: str, seed: int) -> Outcome:
    """Return what the average makes of a recording."""
    scene = KINDS[kind](np.random.default_rng([seed, *kind.encode()]))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            rates = (30.0, 200.0) if scene.animal.beat > 0.3 else (250.0, 900.0)
            average = scene.raw().average(heart_rates=rates)
        except VasowaveError as error:
            return Outcome((np.nan,) * 3, np.nan, np.nan, (), str(error))
    cycle = average.recording
    seen = (cycle.mean_pressure, cycle.cardiac_output, cycle.heart_rate)
    looks = tuple(f.code.partition(".")[2] for f in average.findings if f.severity is Severity.LOOK)
    errors = [float(a / b - 1) for a, b in zip(seen, scene.truth, strict=True)]
    stated = np.nan if cycle.pressure_error is None else float(cycle.pressure_error[0])
    return Outcome((errors[0], errors[1], errors[2]), seen[0] - scene.truth[0], stated, looks)


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("count", type=int, nargs="?", default=6)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--kind", nargs="*", default=[])
    arguments = parser.parse_args()
    chosen = [kind for kind in KINDS if not arguments.kind or any(one in kind for one in arguments.kind)]
    print(f"{'kind':<20} right told silent refused | mean   flow   rate (largest, %) | mean off/stated | looks")
    held, counted = 0, 0
    for kind in chosen:
        rows = [outcome(kind, arguments.seed + i) for i in range(arguments.count)]
        used = [one for one in rows if not one.refused]
        wrong = [max(map(abs, one.errors)) > MATTERS for one in used]
        quiet = sum(one.silent for one in used)
        right = sum(not bad for bad in wrong)
        largest = [max((one.errors[i] for one in used), key=abs, default=np.nan) for i in range(3)]
        held += sum(abs(one.off) <= 2 * one.stated for one in used)
        counted += len(used)
        looks = sorted({look for one in used for look in one.looks})
        offs = " ".join(f"{one.off:+.2f}/{one.stated:.2f}" for one in used)
        print(
            f"{kind:<20} {right:>5} {sum(wrong) - quiet:>4} {quiet:>6} {len(rows) - len(used):>7} | "
            f"{' '.join(f'{100 * one:+6.1f}' for one in largest)} | {offs} | {', '.join(looks)}"
        )
        for one in rows:
            if one.refused:
                print(f"      refused: {one.refused[:150]}")
    print(f"mean within twice its stated error: {held} of {counted}")


if __name__ == "__main__":
    main()
