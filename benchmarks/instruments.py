"""How often a filter in the amplifier of the pressure is told, and what it does to stiffness with and without a word.

    python benchmarks/instruments.py --out found.csv --animals 5     fits of one start: 1 s of CPU each
    python benchmarks/instruments.py --out found.csv --catheters     the same through fluid-filled catheters

Animals of `known_animals` (noise of 0.15 mmHg) and trees of seven vessels (noise of 0.4 mmHg) whose radii and lengths
are 4 % wrong, all alike (common) or each (each), and which taper by 12 % untold; their pressure, noise of the beats
included, went through a filter of first order, through a catheter, whose converter adds white noise of 0.03 mmHg, or
through nothing. The stiffness E at mean pressure is fitted to what was recorded, to what is corrected with the response
known, and to what was recorded with a lag of 3 ms (SD) allowed for, of catheters with the inertia of 60 Hz (SD), too.
"""

import argparse
import contextlib
import csv
import warnings
from dataclasses import replace
from itertools import product
from pathlib import Path

import numpy as np

from known_animals import ROWS, WHITE, image_of
from known_animals import animal as row_of
from untold_geometry import KINDS
from untold_geometry import animal as geometry
from vasowave.base import VasowaveError, VasowaveWarning
from vasowave.catheter.check import Catheter, LowPass, correct_catheter
from vasowave.pulse import derived
from vasowave.pulse.calibration import calibrate

CUTOFFS = (0.0, 200.0, 100.0, 50.0, 20.0)
"""Hz; 0: no filter."""
CATHETERS = ((0.0, 0.0), *product((40.0, 60.0, 100.0), (0.15, 0.4, 0.8)))
"""Natural frequency, Hz, and damping ratio; 0: no catheter."""
FIELDS = ("kind", "animal", "cutoff", "damping", "told", "seen", "truth", "fitted", "corrected", "clean",
          "allowed", "low", "high", "lag", "inertia")  # fmt: skip
LAG, INERTIA = 0.003, 7e-6  # s and s², SD


def filtered(recording, cutoff, damping=0.0):
    """Return the recording with its pressure through a filter at `cutoff`, Hz, or a catheter of that frequency."""
    if not cutoff:
        return recording
    count = len(recording.pressure)
    ratio = np.fft.rfftfreq(count, recording.period / count) / cutoff
    response = 1 - ratio**2 + 2j * damping * ratio if damping else 1 + 1j * ratio
    pressure = np.fft.irfft(np.fft.rfft(recording.pressure) / response, count)
    if damping:
        pressure += WHITE * np.random.default_rng([55, int(cutoff), int(100 * damping)]).standard_normal(count)
    return replace(recording, pressure=pressure)


def stiffness(network, recording, law):
    """Return the fitted stiffness, and what the fit tells of instruments."""
    fit = calibrate(network, recording, law, starts=1)
    told = [one for one in fit.findings if one.code == "fit.low-pass"]
    return derived(fit.model, recording.mean_pressure)["stiffness"], dict(told[0].values) if told else {}


def allowed(network, recording, law, inertia=0.0):
    """Return stiffness, its 95 % interval by the recording, lag and inertia of a fit that allows for them."""
    fit = calibrate(network, recording, law, starts=1, pressure_lag_sd=LAG, pressure_inertia_sd=inertia)
    value = derived(fit.model, recording.mean_pressure)["stiffness"]
    first = fit.parameters.iloc[0]  # to which the stiffness of a linear wall is proportional
    ends = (value * first[f"interval_{end}"] / first["value"] for end in ("low", "high"))
    return value, *ends, *fit.compared.response


def animal(kind, number):
    """Return the network as the image shows it, the recording, the true model, and the law to fit."""
    if kind in KINDS:
        return *geometry(number, kind), "linear"
    recording, model, law = row_of(kind, number, noise=0.15)
    return image_of(kind), recording, model, law


def lines(kind, number, responses, inertia=0.0):
    """Fit one animal with and without filters; return its lines of the file as they come."""
    network, recording, model, law = animal(kind, number)
    truth = derived(model, recording.mean_pressure)["stiffness"]
    clean = np.nan
    for cutoff, damping in responses:
        seen = filtered(recording, cutoff, damping)
        fitted, told = stiffness(network, seen, law)
        clean = clean if cutoff else fitted
        corrected = np.nan
        if cutoff:
            with contextlib.suppress(VasowaveError):  # a harmonic of which too little came through
                known = Catheter(cutoff, damping) if damping else LowPass(cutoff)
                corrected, _ = stiffness(network, correct_catheter(seen, known), law)
        yield (kind, number, cutoff, damping, told.get("signal", ""), told.get("cutoff", np.nan), truth, fitted,
               corrected, clean, *allowed(network, seen, law, inertia))  # fmt: skip


def main():
    """Write what was found of every animal."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--kinds", nargs="+", default=["linear"], choices=[*ROWS, *KINDS])
    parser.add_argument("--animals", type=int, default=5)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--cutoffs", type=float, nargs="+", default=CUTOFFS)
    parser.add_argument("--catheters", action="store_true")
    asked = parser.parse_args()
    filters = CATHETERS if asked.catheters else [(cutoff, 0.0) for cutoff in asked.cutoffs]
    warnings.simplefilter("ignore", VasowaveWarning)
    with asked.out.open("w", encoding="utf-8", newline="") as file:
        table = csv.writer(file)
        table.writerow(FIELDS)
        for kind in asked.kinds:
            for number in range(asked.first, asked.first + asked.animals):
                for one in lines(kind, number, filters, INERTIA if asked.catheters else 0.0):
                    table.writerow(one)
                    file.flush()


if __name__ == "__main__":
    main()
