"""What enters the model: how often intervals hold the truth where the flow, or the pressure, is measured badly.

    python benchmarks/entering.py --animals 40 [--posteriors 20] [--docs]

Trees of seven vessels with a linear wall. Every harmonic of the averaged flow and of the averaged pressure has an error
of its own, whose size the recording knows, as from the scatter of its beats: small in one signal, large in the other.
Animals 0 to 23 showed that the upper end of R_T took the flow for exact, 100 to 219 that an error of the mean flow
moves all harmonics; those from 400 on were looked at afterwards.
"""

import argparse
import zlib
from pathlib import Path

import numpy as np

from known_animals import heart
from posterior_modes import tree
from robustness_page import put, shown
from vasowave.pulse import derived
from vasowave.pulse.calibration import Search, calibrate
from vasowave.pulse.cycle import Recording, resample
from vasowave.pulse.inference import columns, posterior
from vasowave.pulse.model import LinearWall, Model, Numerics, windkessels
from vasowave.pulse.solver import simulate
from vasowave.study.animal import Animal, Settings, result_of

KINDS = {"flow known badly": (0.003, 0.04), "pressure known badly": (0.04, 0.003), "both alike": (0.02, 0.02)}
"""Standard error of the mean of pressure and of flow, as shares of their pulses."""
FALLS = 4.0  # harmonic at which an error is half of that of the mean
HARMONICS = 12
SAMPLES = 64
TOLD = ("wave_speed", "R_T")
ENTERS = ("flow", "pressure", "both")
PAGE = Path(__file__).parents[1] / "docs" / "coverage.md"


def with_errors(wave, share, rng):
    """Return a wave whose harmonics are wrong, and the standard errors of their amplitudes."""
    k = np.arange(HARMONICS + 1)
    error = share * np.ptp(wave) / (1 + k / FALLS)
    wrong = error * rng.standard_normal(HARMONICS + 1) + 1j * error * rng.standard_normal(HARMONICS + 1)
    spectrum = np.zeros(SAMPLES // 2 + 1, complex)
    spectrum[1 : HARMONICS + 1] = wrong[1:] * SAMPLES / 2
    spectrum[0] = wrong[0].real * SAMPLES
    return wave + np.fft.irfft(spectrum, SAMPLES), error


def animal(kind, number):
    """Return network, recording and true quantities of an animal."""
    rng = np.random.default_rng([zlib.crc32(kind.encode()), number])
    network, inflow = tree(rng), heart(rng)
    resistance, tau = 76.0 * np.exp(0.2 * rng.standard_normal()), 0.12 * np.exp(0.2 * rng.standard_normal())
    beds = windkessels(network, resistance, tau, rng.uniform(0.06, 0.25))
    model = Model(network, LinearWall(57.0 * np.exp(0.3 * rng.standard_normal())), beds)
    waves = simulate(model, inflow, Numerics(samples=SAMPLES))["pressure"].to_numpy()[:, network.root, 0]
    of_pressure, of_flow = KINDS[kind]
    pressure, pressure_error = with_errors(waves, of_pressure, rng)
    flow, flow_error = with_errors(resample(inflow.flow, SAMPLES), of_flow, rng)
    recording = Recording(
        pressure, flow, inflow.period, pressure_error=pressure_error, flow_error=flow_error, source=f"{kind} {number}"
    )
    return network, recording, derived(model, float(waves.mean()))


def held(network, recording, truth, enters, drawn):
    """Return of each quantity whether its interval holds the truth, and half its width, %, by fit or by posterior."""
    how = {"search": Search(starts=4, pressure_harmonics=HARMONICS, enters=enters)}
    if drawn:
        table = posterior(network, recording, "linear", draws=150, workers=1, **how).summary
    else:
        fit = calibrate(network, recording, "linear", **how)
        exact = Settings(walls=("linear",), enters=enters, model_selection=False, **dict.fromkeys(columns(), 0.0))
        result = result_of(Animal("mouse", "CTL", network, recording), [fit], exact)
        table = result.laws["linear"].summary()
    names = ("interval_low", "interval_high") if drawn else ("low", "high")
    ends = {name: [float(table.loc[name, one]) for one in names] for name in TOLD}
    return [(low < truth[name] < high, 50 * np.log(high / low)) for name, (low, high) in ends.items()]


def rows(animals, posteriors, first):
    """Yield the lines of the table."""
    yield "| animals | what enters | analyzed | wave speed held | half width, % | R_T held | half width, % |"
    yield "|---" * 7 + "|"
    for kind in KINDS:
        known = [animal(kind, first + number) for number in range(max(animals, posteriors))]
        for drawn, count in ((False, animals), (True, posteriors)):
            for enters in ENTERS if count else ():
                found = np.array([held(n, r, t, enters, drawn) for n, r, t in known[:count]])
                cells = [
                    text for name in range(len(TOLD))
                    for text in (f"{int(found[:, name, 0].sum())} of {count}", f"{np.median(found[:, name, 1]):.0f}")
                ]  # fmt: skip
                way = "posterior" if drawn else "fit"
                yield f"| {kind} | {enters} | {way} | {' | '.join(cells)} |"


def main():
    """Print the table, and put it into the docs if asked."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--animals", type=int, default=40)
    parser.add_argument("--posteriors", type=int, default=20)
    parser.add_argument("--first", type=int, default=400, help="Number of the first animal.")
    parser.add_argument("--docs", action="store_true")
    options = parser.parse_args()
    table = shown(rows(options.animals, options.posteriors, options.first))
    if options.docs:
        put("entering", table, PAGE)


if __name__ == "__main__":
    main()
