"""Draws of a whole posterior from the distributions learned around its modes, and whether two halves of it agree.

Every component is a density whose integral is known (by bridge sampling). Draws of all of them are weighted by the true
density over that of their mixture (Veach & Guibas, SIGGRAPH 1995, the balance heuristic): it does not matter which
component a draw came from, nor whether components overlap.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import NamedTuple

import numpy as np
from scipy.special import logsumexp

from vasowave.base.errors import NumericalError
from vasowave.pulse.inference.emulator import Emulator
from vasowave.pulse.inference.ensemble import log_integral
from vasowave.pulse.inference.mode import Climbed
from vasowave.pulse.inference.reweighting import ImportanceWeights, smoothed
from vasowave.pulse.inference.rounds import (
    DRAWN_POWER,
    Component,
    Target,
    learn,
    log_error,
    log_prior,
    moved,
    simulated_at,
    taught,
)


@dataclass(frozen=True)
class MixtureRules:
    """How modes are explored and drawn from.

    Attributes
    ----------
    steps : int
        Steps of the walkers.
    burn_in_share : float
        Share of the steps that is not drawn from: the walkers come from a density that is a little wider.
    max_tries : int
        Draws that cannot be trusted teach the emulators, and others are drawn, up to so many times.
    max_mode_nats : float
        Nats below the likeliest mode from which one is not explored: a thousandth of the probability.
    min_component_share : float
        Share of the draws that every component has.
    max_modes : int
        Modes that are explored.
    max_overlap : float
        Probability that may belong to either of two components, above which they are ends of one mode.
    batch_draws : int
        Draws that are simulated at a time, and teach the emulators.
    max_log_error : float
        SD of the error of the log-likelihood of draws that the emulators did not know, up to which they speak for the
        draws that are left.
    """

    steps: int = 400
    burn_in_share: float = 0.25
    max_tries: int = 3
    max_mode_nats: float = 7.0
    min_component_share: float = 0.1
    max_modes: int = 3
    max_overlap: float = 0.01
    batch_draws: int = 80
    max_log_error: float = 0.35


RULES = MixtureRules()


@dataclass(frozen=True, eq=False)
class Explored:
    """Draws of the mixture with the weights that make them draws of the posterior.

    Attributes
    ----------
    points : array, shape (draw, unknown)
    residuals : array, shape (draw, output)
        Measured minus simulated, or minus emulated where nothing else was worth it.
    weights : ImportanceWeights
    effective : float
        Independent draws that would be worth as much: few weights are large, and walkers remember.
    missed : array, shape (draw, output)
        Simulated minus emulated, of the last draws that were simulated and that the emulators did not know.
    log_error : float
        SD of the emulators' error of the log-likelihood there.
    log_evidence, log_evidence_error : float
    emulator : Emulator
        Of the likeliest component.
    rounds : int
        Of all components.
    shares : array, shape (mode,)
        Probability of each mode; components that overlap are one.
    halves_distance : float
        Largest distance between the means of two independent halves, or of one from the whole, in posterior SD.
    best_log_likelihood : float
        Of all draws.
    """

    points: np.ndarray
    residuals: np.ndarray
    weights: ImportanceWeights
    effective: float
    missed: np.ndarray
    log_error: float
    log_evidence: float
    log_evidence_error: float
    emulator: Emulator
    rounds: int
    shares: np.ndarray
    halves_distance: float
    best_log_likelihood: float


def explore(target: Target, modes: Sequence[Climbed], rng: np.random.Generator, draws: int = 400) -> Explored:
    """Return draws of the posterior of points with prior N(0, 1), from its modes, the likeliest first.

    Raises
    ------
    NumericalError
        Most points near every mode cannot be simulated.
    """
    components = _components(target, modes, rng)
    for tries_left in reversed(range(RULES.max_tries)):
        components, clouds = _likely(components, rng)
        drawn = _simulated(target, components, _drawn(components, clouds, draws, rng))
        if drawn.weights.trusted or not tries_left:
            break
        components = _taught(target, components, drawn, drawn.simulated)
    return _explored(target, components, clouds, modes, drawn)


def _components(target: Target, modes: Sequence[Climbed], rng: np.random.Generator) -> list[Component]:
    """Learn around every mode that may matter and that no other component covers."""
    evidence = [candidate.log_evidence(target.noise, target.measured) for candidate in modes]
    components: list[Component] = []
    failure: NumericalError | None = None
    for mode, log in zip(modes, evidence, strict=True):
        if components and log < max(evidence) - RULES.max_mode_nats:
            continue
        covering = [i for i, candidate in enumerate(components) if candidate.covers(mode, target)]
        if covering:
            i = covering[0]
            components[i] = components[i].found_by(mode.halves)
        elif len(components) < RULES.max_modes:
            try:
                components.append(learn(target, mode, rng))
            except NumericalError as error:
                failure = error
    if not components and failure is not None:
        raise failure
    return components


class _Cloud(NamedTuple):
    """Draws of one component: those of two independent halves of walkers, and the logarithm of the integral."""

    halves: tuple[np.ndarray, np.ndarray]
    independent: float  # draws that both halves are worth together
    log_integral: float
    error: float
    log_evidence: float


def _likely(components: Sequence[Component], rng: np.random.Generator) -> tuple[list[Component], list[_Cloud]]:
    """Return the components that hold more than a thousandth of the probability, and draws of them."""
    pairs = [(component, _cloud(component, rng)) for component in components]
    threshold = max(cloud.log_evidence for _, cloud in pairs) - RULES.max_mode_nats
    likely = [(component, cloud) for component, cloud in pairs if cloud.log_evidence >= threshold]
    return [component for component, _ in likely], [cloud for _, cloud in likely]


def _cloud(component: Component, rng: np.random.Generator) -> _Cloud:
    log_drawn = component.surrogate.log_drawn
    ensemble = moved(log_drawn, component.walkers, RULES.steps, rng, groups=2)
    first = int(RULES.burn_in_share * len(ensemble.points))
    walks = [ensemble.points[first:, half::2] for half in (0, 1)]
    halves = [walk.reshape(-1, walk.shape[-1]) for walk in walks]
    together = np.concatenate([ensemble.log_density[first:, half::2].ravel() for half in (0, 1)])
    integral, error = log_integral(log_drawn, np.concatenate(halves), together, rng)
    log_ratio = (1 / DRAWN_POWER - 1) * together  # log posterior density over the drawn one
    evidence = integral + float(logsumexp(log_ratio)) - np.log(len(log_ratio))
    independent = sum(map(worth, walks))
    return _Cloud((halves[0], halves[1]), independent, integral, error, float(evidence))


def worth(points: np.ndarray) -> float:
    """Return how many independent draws walkers are worth, from points of shape (step, walker, unknown).

    What the walkers' own means scatter by tells how long each remembers where it was.
    """
    scatter = points.mean(axis=0).var(axis=0, ddof=1) / points.var(axis=(0, 1))
    return points.shape[1] / float(scatter.mean())


class _Drawn(NamedTuple):
    """Draws: the component and the half that each came from, and the logarithms of the densities there."""

    points: np.ndarray
    component: np.ndarray
    half: np.ndarray
    log_density: np.ndarray  # of every component, shape (component, draw), with its share of the draws
    outputs: np.ndarray  # simulated, or emulated
    simulated: np.ndarray  # which are
    log_true: np.ndarray
    missed: np.ndarray  # by the emulators, in the last batch
    log_error: float  # likewise
    log_offset: float  # of the log-likelihood that they foretold there, on average

    def log_ratio(self, components: Sequence[int] | range, rows: np.ndarray | slice = slice(None)) -> np.ndarray:
        """Return the true density over that of a mixture of some components, at some draws."""
        return self.log_true[rows] - logsumexp(self.log_density[list(components)][:, rows], axis=0)

    def weighted(self, rows: np.ndarray | slice = slice(None)) -> ImportanceWeights:
        """Return the weights that make some of the draws draws of the posterior."""
        return smoothed(self.log_ratio(range(len(self.log_density)), rows))

    @property
    def weights(self) -> ImportanceWeights:
        """The weights of all draws, with the longer tail of theirs and those of the simulated ones."""
        weights, simulated = self.weighted(), self.weighted(self.simulated)
        return weights if simulated.trusted else weights._replace(k_hat=max(weights.k_hat, simulated.k_hat))


def _drawn(components: Sequence[Component], clouds: Sequence[_Cloud], draws: int, rng: np.random.Generator) -> _Drawn:
    """Draw of every component, the more the likelier it is, from both halves alike; nothing is simulated yet."""
    evidence = np.array([source.log_evidence for source in clouds])
    shares = np.maximum(np.exp(evidence - logsumexp(evidence)), RULES.min_component_share)
    counts = np.maximum(np.round(draws * shares / shares.sum() / 2).astype(int), 1)  # of each half
    chunks = [
        (cloud[rng.choice(len(cloud), min(count, len(cloud)), replace=False)], i, half)
        for i, (source, count) in enumerate(zip(clouds, counts, strict=True))
        for half, cloud in enumerate(source.halves)
    ]
    points = np.concatenate([chosen for chosen, _, _ in chunks])
    component = np.concatenate([np.full(len(chosen), i) for chosen, i, _ in chunks])
    half = np.concatenate([np.full(len(chosen), half) for chosen, _, half in chunks])
    density = np.array([
        source.surrogate.log_drawn(points) - cloud.log_integral + np.log(np.mean(component == i))
        for i, (source, cloud) in enumerate(zip(components, clouds, strict=True))
    ])  # fmt: skip
    nothing = np.empty((len(points), 0))
    unknown = np.full(len(points), -np.inf)
    return _Drawn(
        points, component, half, density, nothing, np.zeros(len(points), bool), unknown, nothing, np.inf, np.nan
    )


def _simulated(target: Target, components: Sequence[Component], drawn: _Drawn) -> _Drawn:
    """Simulate draws, batch by batch, until the emulators, which learn from each, foretell those of one.

    They then speak for the draws that are left, unless weights cannot be trusted or a draw could not be simulated.
    """
    points, batches = drawn.points, max(1, len(drawn.points) // RULES.batch_draws)
    outputs, foretold = _foretold(components, drawn)
    for batch in range(batches):
        rows = np.arange(len(points)) % batches == batch  # of all components and halves
        done = drawn.simulated | rows
        simulated = simulated_at(target, points[rows])
        missed, outputs[rows] = simulated - outputs[rows], simulated
        error = log_error(target, foretold[rows], points[rows], simulated, DRAWN_POWER)
        offset = _log_offset(target, simulated, missed)
        drawn = drawn._replace(simulated=done, outputs=outputs, missed=missed, log_error=error, log_offset=offset)
        if batch < batches - 1:
            components = _taught(target, components, drawn, rows)
            emulated, foretold = _foretold(components, drawn)
            outputs = np.where(done[:, np.newaxis], outputs, emulated)
        log_true = target.log_likelihood(outputs) + log_prior(points)
        drawn = drawn._replace(outputs=outputs, log_true=log_true)
        if np.isfinite(outputs[done]).all() and error <= RULES.max_log_error and drawn.weights.trusted:
            break
    return drawn


def _log_offset(target: Target, simulated: np.ndarray, missed: np.ndarray) -> float:
    """Return how much larger the log-likelihood of emulated outputs is than that of simulated ones, on average."""
    good = np.isfinite(simulated).all(axis=1)
    emulated, true = (target.log_likelihood(outputs[good]) for outputs in (simulated - missed, simulated))
    return float(np.mean(emulated - true)) if good.any() else np.nan


def _foretold(components: Sequence[Component], drawn: _Drawn) -> tuple[np.ndarray, np.ndarray]:
    """Return emulated outputs and log-likelihoods of draws."""
    surrogates = [component.surrogate for component in components]
    outputs = np.array([surrogate.emulator(drawn.points) for surrogate in surrogates])
    logs = np.array([surrogate.log_likelihood(drawn.points) for surrogate in surrogates])
    rows = np.arange(len(drawn.points))
    return outputs[drawn.component, rows], logs[drawn.component, rows]


def _taught(target: Target, components: Sequence[Component], drawn: _Drawn, rows: np.ndarray) -> list[Component]:
    """Return components that know some of the draws."""
    return [
        taught(target, component, drawn.points[chosen], drawn.outputs[chosen])
        for i, component in enumerate(components)
        for chosen in [rows & (drawn.component == i)]
    ]


def _explored(
    target: Target,
    components: Sequence[Component],
    clouds: Sequence[_Cloud],
    modes: Sequence[Climbed],
    drawn: _Drawn,
) -> Explored:
    weights = drawn.weights
    ratio = drawn.log_ratio(range(len(components)))
    evidence = float(logsumexp(ratio)) - np.log(len(ratio))
    spread = float(np.std(np.exp(ratio - evidence)) / np.sqrt(len(ratio)))
    posterior = np.exp(weights.log_weight)
    shares = np.array([posterior[drawn.component == i].sum() for i in range(len(components))])
    errors = shares * [cloud.error for cloud in clouds]
    offset = 0.0 if drawn.simulated.all() else drawn.log_offset * float(np.mean(~drawn.simulated))
    remembered = sum(share**2 / cloud.independent for share, cloud in zip(shares, clouds, strict=True))
    effective = 1 / (1 / weights.effective + remembered)
    return Explored(
        drawn.points, target.measured - drawn.outputs, weights, effective, drawn.missed, drawn.log_error,
        evidence, float(np.linalg.norm([*errors, spread, offset])),
        components[int(np.argmax(shares))].surrogate.emulator, sum(component.rounds for component in components),
        separate(drawn.log_density, posterior), _apart(components, modes, drawn, posterior),
        float(np.max(drawn.log_true - log_prior(drawn.points))),
    )  # fmt: skip


def separate(log_density: np.ndarray, weight: np.ndarray) -> np.ndarray:
    """Return the probability of each separate mode, from densities (component, draw) and the draws' weights.

    Ends of one long ridge may be learned as two components; what they share tells that they are one mode.
    """
    belongs = np.exp(log_density - logsumexp(log_density, axis=0))
    mode = np.arange(len(belongs))
    for i, j in combinations(range(len(belongs)), 2):
        if weight @ np.minimum(belongs[i], belongs[j]) > RULES.max_overlap:
            mode[mode == mode[j]] = mode[i]
    return np.array([float(weight @ belongs[mode == label].sum(axis=0)) for label in np.unique(mode)])


def _apart(components: Sequence[Component], modes: Sequence[Climbed], drawn: _Drawn, weight: np.ndarray) -> float:
    """Return how far the means of two halves are from each other and from the whole, in posterior SD.

    Each half knows the modes that its own starts found and its own walkers; one whose modes were all left out because
    they are hopeless stands at the best of them.
    """
    mean = weight @ drawn.points
    sd = np.sqrt(weight @ (drawn.points - mean) ** 2)
    means = [mean]
    for half in (0, 1):
        members = [i for i, component in enumerate(components) if half in component.halves]
        middles = [mode.middle for mode in modes if half in mode.halves]
        rows = (drawn.half == half) & np.isin(drawn.component, members)
        if rows.any():
            means.append(np.exp(smoothed(drawn.log_ratio(members, rows)).log_weight) @ drawn.points[rows])
        elif middles:
            means.append(middles[0])
        else:
            return np.inf
    return max(float(np.max(np.abs(first - second) / sd)) for first, second in combinations(means, 2))
