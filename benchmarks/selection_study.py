"""How often each procedure of model selection chooses the wall law that made the data, and how often intervals cover.

    uv run python benchmarks/selection_study.py                     the table of docs/wall-laws.md
    uv run python benchmarks/selection_study.py --sets 5 --cheap    a quick look: circulant and independent noise only

The truth is a linear or a tangent wall at parameters like those of a control mouse, plus drawn noise. So that hundreds
of fits take minutes, an emulator stands for the solver: every pressure sample is a polynomial of degree four in the
logarithms of the parameters, fitted to simulations; its error at points it has not seen is printed first.
"""

import argparse
from dataclasses import dataclass
from itertools import combinations_with_replacement

import numpy as np
from scipy.optimize import least_squares

from vasowave.pulse.cycle import Inflow
from vasowave.pulse.examples import control_network
from vasowave.pulse.model import LinearWall, Model, Numerics, TangentWall, Windkessel, windkessels
from vasowave.pulse.noise import FAMILIES, OF_PAPER, CirculantNoise, fit_noise, maximize
from vasowave.pulse.noise.likelihood import concentrated
from vasowave.pulse.selection import UNDECIDED, aicc, bic
from vasowave.pulse.solver import simulate_runs

PERIOD, SAMPLES = 0.11, 128
TRUTH = {"linear": (57.8, 1.0, 1.0, 1.0), "tangent": (3.85, 4.41, 1.0, 1.0, 1.0)}
REACH = {"linear": (0.4, 1.2, 0.15, 0.6), "tangent": (0.7, 0.7, 0.6, 0.15, 0.6)}  # of the emulator, in logarithms
DEGREE, TRAINING, TEST = 4, {"linear": 220, "tangent": 400}, 40


@dataclass(frozen=True)
class Emulator:
    """Pressure (mmHg) of one wall law as polynomials of u = (log parameters - log truth)/reach, |u| <= 1."""

    wall: str
    terms: list[tuple[int, ...]]
    weights: np.ndarray

    @property
    def D(self):
        return len(TRUTH[self.wall])

    def pressure(self, u):
        return features(u[None], self.terms)[0] @ self.weights

    def jacobian(self, u):
        step = 1e-5 * np.eye(self.D)
        ends = features(np.vstack([u + step, u - step]), self.terms) @ self.weights
        return ((ends[: self.D] - ends[self.D :]) / 2e-5).T

    def fit(self, measured, whiten=lambda values: values, start=None):
        """Return u, residual and Jacobian (by u) of the optimum inside the emulator's reach."""
        found = least_squares(
            lambda u: whiten(measured - self.pressure(u)), np.zeros(self.D) if start is None else 0.999 * start,
            lambda u: -whiten(self.jacobian(u)), bounds=(-1, 1), xtol=1e-7, ftol=1e-9, max_nfev=100,
        )  # fmt: skip
        return found.x, measured - self.pressure(found.x), -self.jacobian(found.x)


def features(u, terms):
    factors = np.array([[*term, *[-1] * (DEGREE - len(term))] for term in terms])  # -1: a column of ones
    return np.prod(np.hstack([u, np.ones((len(u), 1))])[:, factors], axis=2)


def models(wall, u):
    network = control_network()
    R1, R2, C = windkessels(network, 76.0, 0.11, a=0.12)
    law = LinearWall if wall == "linear" else TangentWall
    for row in np.log(TRUTH[wall]) + u * np.array(REACH[wall]):
        *elastic, r1, r2, c1 = np.exp(row)
        yield Model(network, law(*elastic), Windkessel(r1 * R1, r2 * R2, c1 * C))


def emulator(wall, rng):
    """Train on simulations; the second value is the root-mean-square error on other ones, mmHg."""
    t = np.arange(256) / 256
    q = np.exp(-0.5 * ((t - 0.45) / 0.09) ** 2)
    inflow = Inflow(0.17 * q / q.mean(), PERIOD)
    D = len(TRUTH[wall])
    terms = [term for d in range(DEGREE + 1) for term in combinations_with_replacement(range(D), d)]
    u = rng.uniform(-1, 1, (TRAINING[wall] + TEST, D))
    u[: TRAINING[wall] // 2] *= 0.6  # denser where optima lie
    runs = list(simulate_runs(list(models(wall, u)), inflow, Numerics(samples=SAMPLES, tolerance=1e-6)))
    good = np.array([not isinstance(run, Exception) for run in runs])
    pressure = np.stack([run.inlet_pressure(SAMPLES) for run, ok in zip(runs, good) if ok])
    seen = (np.arange(len(u)) < TRAINING[wall])[good]
    weights = np.linalg.lstsq(features(u[good][seen], terms), pressure[seen], rcond=None)[0]
    error = features(u[good][~seen], terms) @ weights - pressure[~seen]
    return Emulator(wall, terms, weights), float(np.sqrt(np.mean(error**2))), int((~good).sum())


def true_noise(sd):
    """Periodic noise with the spectrum of mouse C6's residuals: corner at harmonic 5, then k^-5 in power, a floor."""
    power = (1 + (np.arange(SAMPLES // 2 + 1) / 5) ** 2) ** -2.5 + 1e-5
    return CirculantNoise(power * sd**2 / np.fft.irfft(power, SAMPLES)[0], SAMPLES, {})


def scored(ends, noise):
    """Return AICc and BIC of both wall laws under one noise model."""
    found = {wall: noise.log_likelihood(end[1]) for wall, end in ends.items()}
    size = {wall: len(end[0]) for wall, end in ends.items()}
    return [{w: score(found[w], size[w], SAMPLES) for w in ends} for score in (aicc, bic)]


def separate(measured, emulators, ends, rng):
    """Full maximum likelihood: every wall law with its own circulant covariance, iterated with its parameters."""
    scores = [{}, {}]
    family = FAMILIES["circulant"]
    for wall, one in emulators.items():
        u, residual, _ = ends[wall]
        for _ in range(3):
            theta, _ = maximize(family, residual[None], rng, 2)
            noise = family.noise(SAMPLES, theta)
            found = concentrated(noise, residual[None])[0]
            u, residual, _ = one.fit(measured, noise.whiten, u)
        for score, criterion in zip(scores, (aicc, bic)):
            score[wall] = criterion(found, one.D, SAMPLES)
    return scores


def scores_of_all(measured, emulators, covariances, rng):
    """Return (procedure, [AICc, BIC] of both wall laws) for one data set."""
    ends = {wall: one.fit(measured) for wall, one in emulators.items()}
    series = np.stack([end[1] for end in ends.values()])
    S = {wall: float(end[1] @ end[1]) for wall, end in ends.items()}
    own = {wall: -0.5 * SAMPLES * (np.log(2 * np.pi * value / SAMPLES) + 1) for wall, value in S.items()}
    D = {wall: one.D + 1 for wall, one in emulators.items()}
    yield "independent, own variance | OLS", [{w: f(own[w], D[w], SAMPLES) for w in S} for f in (aicc, bic)]
    for name in covariances:
        noise = fit_noise(name, series, PERIOD, starts=2, rng=rng)
        yield f"{name} | OLS", scored(ends, noise)
        refitted = {wall: one.fit(measured, noise.whiten, ends[wall][0]) for wall, one in emulators.items()}
        yield f"{name} | GLS", scored(refitted, noise)
    yield "circulant, own | full likelihood", separate(measured, emulators, ends, rng)


def covered(one, measured, truth, rng):
    """Return for each parameter whether 95 % intervals hold the truth: independent and plugged-in noise."""
    u, residual, jacobian = one.fit(measured)
    variance = residual @ residual / (SAMPLES - one.D)
    plain = 1.96 * np.sqrt(np.diag(variance * np.linalg.pinv(jacobian.T @ jacobian)))
    rows = {"OLS, independent noise": np.abs(u - truth) <= plain}
    family = FAMILIES["circulant"]
    theta, amplitude = maximize(family, residual[None], rng, 2)
    noise = family.noise(SAMPLES, theta)
    u, residual, jacobian = one.fit(measured, noise.whiten, u)
    white = noise.whiten(jacobian)
    plugged = 1.96 * np.sqrt(np.diag(amplitude * np.linalg.inv(white.T @ white)))
    rows["GLS, maximum likelihood plugged in"] = np.abs(u - truth) <= plugged
    return rows


def wilson(hits, count):
    """Return the 95 % interval of a share."""
    z, p = 1.96, hits / count
    middle, half = p + z**2 / (2 * count), z * np.sqrt(p * (1 - p) / count + z**2 / (4 * count**2))
    return (middle - half) / (1 + z**2 / count), (middle + half) / (1 + z**2 / count)


def report(name, truth, outcomes):
    """Print one line: share of right choices by AICc and BIC, and what AICc decides by 5 or more."""
    count, other = len(outcomes), "tangent" if truth == "linear" else "linear"
    gaps = np.array([[scores[other] - scores[truth] for scores in pair] for pair in outcomes])  # positive: right
    cells = []
    for column in (0, 1):
        hits = int((gaps[:, column] > 0).sum())
        low, high = wilson(hits, count)
        cells.append(f"{hits:3d}/{count} [{low:.2f}, {high:.2f}]")
    right, wrong = (int((sign * gaps[:, 0] >= UNDECIDED).sum()) for sign in (1, -1))
    print(
        f"{truth:8s} {name:36s} AICc {cells[0]}  BIC {cells[1]}  decided right {right:3d} wrong {wrong:3d}", flush=True
    )


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--sets", type=int, default=14, help="data sets of each truth")
    parser.add_argument("--sd", type=float, default=0.6, help="standard deviation of the noise, mmHg")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--cheap", action="store_true", help="circulant and independent noise only")
    parser.add_argument("--intervals", action="store_true", help="coverage of the intervals only")
    chosen = parser.parse_args()
    rng = np.random.default_rng(chosen.seed)
    emulators = {}
    for wall in TRUTH:
        emulators[wall], error, failed = emulator(wall, rng)
        print(f"{wall}: emulator's error {error:.4f} mmHg RMS at {TEST} new points; {failed} sets not simulated")
    covariances = ("circulant", "independent") if chosen.cheap else OF_PAPER
    factor = np.linalg.cholesky(true_noise(chosen.sd).covariance)
    print(f"seed {chosen.seed}, N {SAMPLES}, noise {chosen.sd} mmHg, {chosen.sets} sets of each truth", flush=True)
    for truth in TRUTH:
        outcomes, coverage = {}, {}
        for _ in range(chosen.sets):
            measured = emulators[truth].pressure(np.zeros(emulators[truth].D)) + factor @ rng.standard_normal(SAMPLES)
            every = [] if chosen.intervals else scores_of_all(measured, emulators, covariances, rng)
            for name, scores in every:
                outcomes.setdefault(name, []).append(scores)
            for name, hits in covered(emulators[truth], measured, np.zeros(emulators[truth].D), rng).items():
                coverage.setdefault(name, []).append(hits)
        for name, found in outcomes.items():
            report(name, truth, found)
        for name, hits in coverage.items():
            shares = " ".join(f"{share:.2f}" for share in np.mean(hits, axis=0))
            print(f"{truth:8s} {name:36s} 95 % intervals cover: {shares}; {np.mean(hits):.2f} of all", flush=True)


if __name__ == "__main__":
    main()
