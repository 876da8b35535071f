"""Parameters and the response of an instrument, sought together on the linear network that simulations correct.

The pressure before the instrument does not depend on it: so every simulation, values and derivatives, speaks for every
response, and a response costs nothing but its factor in each harmonic.
"""

from collections.abc import Collection, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import product
from typing import NamedTuple

import numpy as np

from vasowave.base.errors import NumericalError
from vasowave.pulse.calibration.compared import Compared
from vasowave.pulse.calibration.coordinates import Coordinates
from vasowave.pulse.calibration.descent import Descent
from vasowave.pulse.calibration.linear_tree import spectrum_of
from vasowave.pulse.calibration.objective import Objective
from vasowave.pulse.calibration.optimization import SearchEnd, search
from vasowave.pulse.calibration.parameters import trial
from vasowave.pulse.calibration.starts import DERIVATIVE_ERROR
from vasowave.pulse.calibration.surrogate import RULES as SURROGATE
from vasowave.pulse.calibration.surrogate import CorrectedNetwork
from vasowave.pulse.calibration.valleys import Misled, Simulated, Valleys
from vasowave.pulse.cycle.response import second_order


@dataclass(frozen=True)
class ResponseRules:
    """How a response is looked for.

    Attributes
    ----------
    farthest : float
        What a response may be, SD of the prior.
    spread : float
        SD of a lag that is assumed where the search is led, share of the cycle over 2π; its square of an inertia.
    lags, inertias : tuple of float
        Responses, in such SD, from which the search begins: a large one is told from no other place, where the wall has
        bent to imitate it.
    gain : float
        Relative change of S that a place must promise to be simulated.
    small : float
        Difference of the responses of two searches, below which they are the same, SD of the prior.
    searches : int
        With a response that is held, at most.
    """

    farthest: float = 8.0
    spread: float = 1 / 6
    lags: tuple[float, ...] = (1.0, 3.0)
    inertias: tuple[float, ...] = (0.0, 1.0)
    gain: float = 1e-4
    small: float = 0.01
    searches: int = 8


RULES = ResponseRules()
_STEP_SD = 1e-3  # SD of the prior, of differences
RESPONSE = "pressure_lag", "pressure_inertia"
"""Names of the two numbers of a response, as of `KnownErrors`."""


class HeldResponse(NamedTuple):
    """An objective with a response, an end of its search, and the scores of the response: in SD of their prior."""

    objective: Objective
    end: SearchEnd
    scores: np.ndarray

    def by(self, units: np.ndarray) -> "HeldResponse":
        """Return the same with scores by other units."""
        return self._replace(scores=np.array(self.objective.compared.response)[units.any(axis=0)] / units.sum(axis=1))

    @property
    def unlikely(self) -> float:
        """-2 of the logarithm of the likelihood of the end and of the prior of the response."""
        count = self.objective.compared.samples - len(self.end.x)
        return float(count * np.log(self.end.S) + self.scores @ self.scores)


def fit_response(
    objective: Objective, best: SearchEnd, start: np.ndarray, priors: Mapping[str, float], method: str
) -> tuple[Objective, SearchEnd]:
    """Return the objective with the likeliest response, whose SD are `priors`, and its optimum.

    `objective` has none, and `best` is its optimum; `start` is where another search may begin. From where the linear
    network leads, parameters are searched with the response held that is likeliest there, until it stays.
    """
    units = _units(priors)
    plain = HeldResponse(objective, best, np.zeros(len(units)))
    reached, place = [plain], response_of_linear_network(objective, best, start, priors)
    for begin in (plain,) if place is None else (place.by(units), plain):
        reached += _followed(begin, units, method)
        likeliest = min(reached, key=lambda place: place.unlikely)
        if likeliest is not plain:
            break
    return likeliest[:2]


def _followed(place: HeldResponse, units: np.ndarray, method: str) -> Iterator[HeldResponse]:
    """Search parameters with the response held that is likeliest where the last search ended, until it stays."""
    for _ in range(RULES.searches):
        scores, _ = _likeliest(place.objective, place.end.x, place.scores, units)
        moved = np.abs(scores - place.scores).max()
        held = _behind(place.objective, scores @ units)
        place = HeldResponse(held, search(held, place.end.x, method), scores)
        yield place
        if moved < RULES.small:
            break


def response_of_linear_network(
    objective: Objective, best: SearchEnd, start: np.ndarray, names: Collection[str]
) -> HeldResponse | None:
    """Return where the corrected linear network leads parameters and the numbers of a response that have names.

    It assumes little of these: SD of `ResponseRules.spread`. None where nothing can be said.
    """
    spread = RULES.spread * objective.compared.recording.period / (2 * np.pi)
    fitted = [number for number, name in enumerate(RESPONSE) if name in names]
    units = np.diag([spread, spread**2])[fitted]
    held = np.array(list(product(*((RULES.lags, RULES.inertias)[number] for number in fitted))))
    scores = np.vstack([np.zeros((2, len(units))), held])
    starts = np.column_stack([np.vstack([best.x, *(len(scores) - 1) * [start]]), scores])
    try:
        with trial():
            valleys = ResponseValleys(replace(objective, exactness=DERIVATIVE_ERROR), starts, units=units)
        place = valleys.seek()
    except NumericalError:
        return None
    if place is None:
        return None
    x, scores = np.split(place.x, [len(best.x)])
    behind = _behind(objective, scores @ units)
    behind.begin_from(place.run)
    residual = behind.residuals(x)
    return HeldResponse(behind, replace(best, x=x, S=float(residual @ residual), residual=residual), scores)


def response_columns(objective: Objective, x: np.ndarray, priors: Mapping[str, float]) -> np.ndarray:
    """Return the derivatives of the residuals at `x` by what is fitted of the response, in SD of its prior."""
    return _columns(objective, x, _units(priors))


def _columns(objective: Objective, x: np.ndarray, units: np.ndarray) -> np.ndarray:
    compared, current, columns = objective.compared, np.array(objective.compared.response), []
    pressure = replace(compared, response=(0.0, 0.0)).simulated(objective.at(x))
    for step in _STEP_SD * units:
        upper, lower = (compared.behind(pressure, current + side * step) for side in (1, -1))
        columns.append((lower - upper) / (2 * _STEP_SD))
    return np.pad(np.transpose(columns), ((0, len(objective.residuals(x)) - compared.samples), (0, 0)))


def _units(priors: Mapping[str, float]) -> np.ndarray:
    """Return what one score of each number that is fitted adds to lag and inertia."""
    sd = np.array([priors.get(name, 0.0) for name in RESPONSE])
    return np.diag(sd)[sd > 0]


def _behind(objective: Objective, response: Sequence[float] | np.ndarray) -> Objective:
    lag, inertia = response
    return objective.compared_with(replace(objective.compared, response=(float(lag), float(inertia))))


def _likeliest(objective: Objective, x: np.ndarray, scores: np.ndarray, units: np.ndarray) -> tuple[np.ndarray, float]:
    """Return the scores that are likeliest where the parameters follow them, and the variance of what then remains.

    To first order about an objective with a response.
    """
    residual = objective.residuals(x)
    columns = np.column_stack([objective.jacobian(x), _columns(objective, x, units)])
    remainder = residual - columns @ np.linalg.lstsq(columns, residual)[0]
    noise = float(remainder @ remainder) / max(1, objective.compared.samples - columns.shape[1])
    prior = np.sqrt(noise) * np.eye(columns.shape[1])[len(x) :]
    step = np.linalg.lstsq(np.vstack([columns, prior]), -np.append(residual, np.sqrt(noise) * scores))[0]
    return np.clip(scores + step[len(x) :], -RULES.farthest, RULES.farthest), noise


@dataclass(frozen=True, eq=False)
class _WithScores(Coordinates):
    """Coordinates and logarithms that scores follow, which are alike in both."""

    numbers: int

    def of(self, x: np.ndarray) -> np.ndarray:
        return np.concatenate([super().of(x[..., : self.free]), x[..., self.free :]], axis=-1)

    def logarithms(self, z: np.ndarray) -> np.ndarray:
        return np.concatenate([super().logarithms(z[..., : self.free]), z[..., self.free :]], axis=-1)

    @property
    def log_bounds(self) -> tuple[np.ndarray, np.ndarray]:
        (low, high), farthest = self.space.log_bounds, np.full(self.numbers, RULES.farthest)
        return np.append(low, -farthest), np.append(high, farthest)


@dataclass(eq=False)
class _BehindInstrument(CorrectedNetwork):
    """c + d behind an instrument, with what the prior of its scores adds to S."""

    compared: Compared = field(kw_only=True)
    units: np.ndarray = field(kw_only=True)
    noise: float = 0.0

    @cached_property
    def _measured(self) -> np.ndarray:
        return spectrum_of(self.compared.measured, self.compared.samples)

    def residuals(self, z: np.ndarray, x: np.ndarray | None = None) -> np.ndarray:
        free, count = self.coordinates.free, self.compared.samples // 2 + 1
        before, scores = super().residuals(z[:, :free], None if x is None else x[:, :free]), z[:, free:]
        measured = np.pad(self._measured, (0, before.shape[1] - len(self._measured)))
        pressure = measured - before
        lag, inertia = (scores @ self.units).T[..., np.newaxis]
        passed = second_order(lag, inertia, np.arange(count) / self.compared.recording.period)
        halves = passed * (pressure[:, :count] + 1j * pressure[:, count : 2 * count])
        behind = measured - np.column_stack([halves.real, halves.imag, pressure[:, 2 * count :]])
        return np.column_stack([behind, np.sqrt(self.noise / self.compared.samples) * scores])


@dataclass(eq=False)
class ResponseValleys(Valleys):
    """The valleys of parameters and scores together; places are logarithms that scores follow.

    The first two starts have no response: an optimum, and where the wall imitates no instrument.
    """

    units: np.ndarray = field(kw_only=True)

    def __post_init__(self) -> None:
        super().__post_init__()
        plain, compared = self.guide, self.objective.compared
        self.coordinates = _WithScores(plain.coordinates.space, plain.coordinates.pressure, len(self.units))
        self.guide = self.behind = _BehindInstrument(
            plain.coordinates, plain.linear, plain.strictness, compared=compared, units=self.units
        )

    def seek(self) -> Simulated | None:
        """Return the deepest place when no floor promises less; None where nothing could be simulated."""
        for x in self.starts[:2]:
            z = self.coordinates.of(x)
            if not self.simulated or np.sum((z - self.simulated[0].z) ** 2) > SURROGATE.trusted**2:
                self._simulate(x, z)
        with suppress(Misled):
            while self.simulated and self._deepen():
                pass
        return self.best if self.simulated else None

    def _deepen(self) -> bool:
        """Simulate the floors to which the starts lead until none promises; return whether any was simulated."""
        samples, count = self.objective.compared.samples, len(self.simulated) + len(self.failed)
        floors = self._lead(np.vstack([self.starts, self.best.x]))
        while len(untried := np.flatnonzero(self._distances(floors.z, failed=True) > self.rules.same)):
            first = untried[0]
            if self.best.S <= (1 + RULES.gain) * samples * floors.S[first]:
                break
            self._simulate(floors.x[first], floors.z[first])
            floors = self._lead(np.vstack([floors.x, self.best.x]))
        return len(self.simulated) + len(self.failed) > count

    def _lead(self, places: np.ndarray) -> Descent:
        """Lead by a prior that adds to S, and put in order by the likelihood."""
        floors = super()._lead(places)
        distance = (floors.x[:, self.guide.coordinates.free :] ** 2).sum(axis=1)
        S = (floors.S - self.behind.noise / self.objective.compared.samples * distance) * self._prior(distance)
        order = np.argsort(S, kind="stable")
        return floors._replace(x=floors.x[order], z=floors.z[order], S=S[order])

    def _prior(self, distance: np.ndarray) -> np.ndarray:
        """Return by what the prior multiplies S, so that -2 log L is (N - parameters) log S."""
        return np.exp(distance / (self.objective.compared.samples - self.guide.coordinates.free))

    def _simulate(self, x: np.ndarray, z: np.ndarray) -> None:
        count = len(self.simulated)
        super()._simulate(x, z)
        if len(self.simulated) > count:
            logarithms, scores = np.split(x, [self.guide.coordinates.free])
            behind = _behind(self.objective, scores @ self.units)
            residual = behind.residuals(logarithms)
            S = float(residual @ residual * self._prior(scores @ scores))
            self.simulated[-1] = replace(self.simulated[-1], S=S)
            if self.best is self.simulated[-1]:
                _, self.behind.noise = _likeliest(behind, logarithms, scores, self.units)
