"""What a second site adds: animals of known truth, fits and posteriors with one site and with two.

Each animal has its own wall, beds and geometry; its image is wrong by a factor of all radii and by one of each vessel.
All signals carry the noise of a periodic Ornstein-Uhlenbeck process, which no prior of vasowave knows, white noise, a
zero of their own (pressures) or a gain of their own (others). Run as ``python benchmarks/sites.py 20 posterior``;
``fit``, ``together`` (posteriors with two quantities in the branch), or ``units`` for what is said of every pair of
units; a third number is the first seed.
"""

import sys
from dataclasses import replace
from itertools import permutations

import numpy as np
import pandas as pd

import vasowave as vw
from vasowave.base import ratios
from vasowave.pulse import derived
from vasowave.pulse.calibration import beside, compared_part, parameter_space, sites_of
from vasowave.pulse.cycle import resample
from vasowave.pulse.solver import Places, simulate_run, waves_at

KINDS = ("none", "pressure", "flow", "diameter")
TOGETHER = ("pressure + diameter", "pressure + flow", "flow + diameter")
"""Two quantities in one branch."""
EVERY = (*KINDS[1:], "velocity", "area")
TOLD = ("wave_speed", "R_T", "beta")
BRANCH = 1
SAMPLES = 128
LIKENESS = 0.05  # of the period, over which the noise forgets
NOISE, WHITE, ZERO, GAIN = 0.02, 0.005, 0.5, 0.05


def coloured(rng, size):
    """Return a periodic Ornstein-Uhlenbeck process of SD `size`."""
    k = np.arange(SAMPLES // 2 + 1)
    power = 1 / (1 + (2 * np.pi * k * LIKENESS) ** 2)
    noise = np.fft.irfft(np.sqrt(power) * (rng.standard_normal(len(k)) + 1j * rng.standard_normal(len(k))), SAMPLES)
    return size * noise / np.sqrt(np.mean(np.fft.irfft(np.sqrt(power), SAMPLES) ** 2) * 2)


def animal(seed):
    """Return truth (numbers by name), image, recording, and the site of every kind."""
    rng = np.random.default_rng([seed, 77])
    image, mouse = vw.control_network(), vw.virtual_mouse()
    nominal = vw.estimate_nominal(image, mouse)
    radius = image.radius * np.exp(0.05 * rng.standard_normal() + 0.05 * rng.standard_normal(len(image)))
    length = image.length * np.exp(0.05 * rng.standard_normal() + 0.05 * rng.standard_normal(len(image)))
    network = replace(image, radius=radius, length=length)
    factors = np.exp([0.2, 0.1, 0.3] * rng.standard_normal(3))
    beta = 60.0 * np.exp(0.25 * rng.standard_normal())
    model = vw.Model(network, vw.LinearWall(beta), nominal.outlets.scaled(*factors))
    run = simulate_run(model, mouse.inflow, vw.Numerics(samples=256))
    waves = waves_at(run, mouse.inflow, Places(np.array([0, BRANCH]), np.array([0.0, 0.5])))

    def seen(quantity, place, error):
        wave = resample(waves.of(quantity)[:, place], SAMPLES)
        return wave + coloured(rng, NOISE * np.ptp(wave)) + error * rng.standard_normal(SAMPLES)

    white = {name: WHITE * float(np.ptp(waves.of(name)[:, 1])) for name in EVERY}
    pressure = seen("pressure", 0, WHITE * float(np.ptp(waves.pressure[:, 0]))) + ZERO * rng.standard_normal()
    sites: dict[str, list[vw.Observation]] = {"none": []}
    for name in EVERY:
        wave = seen(name, 1, white[name])
        shift = ZERO * rng.standard_normal()
        wave = wave + shift if name == "pressure" else wave * np.exp(GAIN * shift / ZERO)
        sites[name] = [vw.Observation(name, image.name[BRANCH], white[name], waveform=wave)]
    sites |= {pair: [one for name in pair.split(" + ") for one in sites[name]] for pair in TOGETHER}
    truth = derived(model, float(waves.pressure[:, 0].mean())) | {"beta": beta}
    return truth, image, vw.Recording(pressure, mouse.flow, mouse.period, "made"), sites


def rows_of(seed, how):
    """Yield a row for every kind and quantity of an animal: truth, and the interval."""
    truth, image, recording, sites = animal(seed)
    for kind in (KINDS[0], *TOGETHER) if how == "together" else KINDS:
        if how != "fit":
            table = vw.posterior(image, recording, sites=sites[kind], draws=150, seed=seed).summary
            found = {name: tuple(table.loc[name, ["interval_low", "interval_high"]]) for name in TOLD}
            misfit = np.nan
        elif kind == "none":
            continue
        else:
            fit = vw.calibrate(image, recording, sites=sites[kind], starts=2)
            data = fit.sites.isel(site=0)
            found = {name: tuple(float(data[side].sel(quantity=name)) for side in ("low", "high")) for name in TOLD}
            for name in TOLD:
                low, high = (float(data[f"{side}_without"].sel(quantity=name)) for side in ("low", "high"))
                yield {"seed": seed, "kind": f"{kind}, without", "quantity": name, "truth": truth[name], "low": low,
                       "high": high}  # fmt: skip
            misfit = float(data["misfit"])
        for name, (low, high) in found.items():
            yield {"seed": seed, "kind": kind, "quantity": name, "truth": truth[name], "low": low, "high": high,
                   "misfit": misfit}  # fmt: skip


def units_of(seed):
    """Yield what is said of every pair of units, a row each: of what was held, read as what, whether it is noticed."""
    _, image, recording, sites = animal(seed)
    for kind in EVERY:
        known = ratios(kind)
        told = {
            one: factor for one, factor in known.items() if list(known.values()).index(factor) == list(known).index(one)
        }
        pairs = [
            ("right", "right", 1.0),
            *((one, other, told[other] / told[one]) for one, other in permutations(told, 2)),
        ]
        (right,) = sites[kind]
        nominal = vw.estimate_nominal(image, recording)
        space = parameter_space("linear", image, nominal, vw.Blood())
        compared, how = compared_part(recording), vw.Numerics(samples=64, tolerance=1e-6)
        begin = np.log(space.nominal[space.free])
        at = sites_of([right], image, compared)
        alone = beside._ended(space, compared, at, how, "least-squares", begin)
        for one, other, factor in pairs:
            wrong = replace(right, waveform=right.waveform * factor, error=right.error * factor)
            read = sites_of([wrong], image, compared)
            scaled = replace(alone, coefficients=alone.coefficients / factor, jacobian=alone.jacobian / factor)
            ratio = beside._ratio(read, 0, scaled)
            said = beside._slip(kind, ratio, scaled, read, 0)
            row = {"seed": seed, "quantity": kind, "unit": one, "read as": other, "factor": factor, "ratio": ratio}
            yield row | {"noticed": said is not None}


def summed(frame):
    """Return coverage and median width (of the logarithm) by kind and quantity."""
    frame = frame.assign(held=(frame.low < frame.truth) & (frame.truth < frame.high))
    frame = frame.assign(width=np.log(frame.high / frame.low))
    return frame.groupby(["quantity", "kind"]).agg(n=("held", "size"), held=("held", "sum"), width=("width", "median"))


def main():
    """Print the summary after every animal."""
    count, how, first = int(sys.argv[1]), sys.argv[2], int(sys.argv[3]) if len(sys.argv) > 3 else 0
    if how == "units":
        frame = pd.DataFrame([row for seed in range(first, first + count) for row in units_of(seed)])
        frame = frame.assign(pair=frame["unit"] + " as " + frame["read as"])
        print(frame.groupby("quantity")["noticed"].sum(), frame.groupby("quantity").size())
        print(frame[~frame.noticed & (frame.factor != 1)].groupby(["quantity", "pair", "factor"]).size())
        print(frame[frame.noticed & (frame.factor == 1)])
        return
    rows = []
    for seed in range(first, first + count):
        rows += rows_of(seed, how)
        print(seed, flush=True)
        if seed % 4 == 3 or seed == first + count - 1:
            print(summed(pd.DataFrame(rows)).to_string(), flush=True)
    if how == "fit":
        frame = pd.DataFrame(rows)
        print(frame.groupby("kind")["misfit"].describe().to_string())


if __name__ == "__main__":
    main()
