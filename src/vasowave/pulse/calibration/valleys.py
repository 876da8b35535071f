"""All starts of a fit together: which valleys they lie in, and how deep those are.

The linear network, corrected by the simulations so far (`surrogate`), leads every start to the floor of a valley. Where
that promises most is simulated, value and derivatives, and corrects it; until no floor promises less than the best
simulation. In the end every floor has been simulated.
"""

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from vasowave.base.errors import NumericalError
from vasowave.pulse.calibration.coordinates import Coordinates
from vasowave.pulse.calibration.descent import Descent, descend
from vasowave.pulse.calibration.linear_tree import linear_spectra, spectrum_of
from vasowave.pulse.calibration.objective import Objective
from vasowave.pulse.calibration.optimization import ROUGH_TOLERANCE, SAME_OPTIMUM_SHARE, SearchEnd
from vasowave.pulse.calibration.surrogate import RULES as SURROGATE
from vasowave.pulse.calibration.surrogate import CorrectedNetwork
from vasowave.pulse.solver.result import Run


@dataclass(frozen=True)
class ValleyRules:
    """When a place is simulated.

    Attributes
    ----------
    reach : float
        Distance within which a simulation speaks for a place, in the coordinates.
    same : float
        Distance within which it is one of that place, likewise.
    doubt : float
        SD of the correction by which a floor may lie lower than it says.
    max_simulations : int
        Places, beyond which the correction misleads.
    """

    reach: float = 0.15
    same: float = 1e-5
    doubt: float = 2.0
    max_simulations: int = 40


RULES = ValleyRules()
IN_BEST = "in the valley of the best optimum"
AS_DEEP = "in a valley as deep as the best optimum"
IN_OTHER = "in another valley, whose floor lies higher"


class Misled(Exception):  # noqa: N818  a signal between two files, not an error
    """The corrected linear network leads nowhere: each start is to be followed by simulations."""


@dataclass(frozen=True, eq=False)
class Simulated:
    """One simulation: place, what it leaves, and its state, from which one near by starts."""

    x: np.ndarray
    z: np.ndarray
    S: float
    residual: np.ndarray
    run: Run


@dataclass(eq=False)
class Valleys:
    """The valleys of one fit, as far as they are known.

    Attributes
    ----------
    objective : Objective
    starts : array, shape (start, free)
        Logarithms of the free parameters.
    simulated : list of Simulated
    failed : list of array, shape (free,)
        Coordinates where nothing could be simulated.
    floors : Descent or None
        Where the starts are led now.
    rules : ValleyRules
    """

    objective: Objective
    starts: np.ndarray
    simulated: list[Simulated] = field(default_factory=list)
    failed: list[np.ndarray] = field(default_factory=list)
    floors: Descent | None = None
    rules: ValleyRules = RULES

    def __post_init__(self) -> None:
        space, compared = self.objective.space, self.objective.compared
        self.coordinates: Coordinates = Coordinates(space, compared.recording.mean_pressure)
        strictness = float(np.ptp(compared.measured))
        self.guide: CorrectedNetwork = CorrectedNetwork(self.coordinates, linear_spectra(space, compared), strictness)

    @property
    def best(self) -> Simulated:
        """The deepest place so far."""
        return min(self.simulated, key=lambda place: place.S)

    def search(self, progress: Callable[[float], None]) -> None:
        """Simulate until no floor promises less than the best simulation; `progress` hears of its S.

        Raises
        ------
        Misled
            Nothing could be simulated where the starts are led, or too often.
        """
        for start in self.starts:
            self._simulate(start, self.coordinates.of(start))
            if self.simulated:
                break
        floors = self._lead(self.starts)
        while (number := self._promising(floors)) is not None:
            floors = self._deepened(floors, number, progress)
        self.guide.strictness = 0.0
        floors = self._lead(self.starts)
        while (number := self._promising(floors, self._unseen(floors))) is not None:
            floors = self._deepened(floors, number, progress)
        self.floors = floors

    def _deepened(self, floors: Descent, number: int, progress: Callable[[float], None]) -> Descent:
        """Simulate a floor; return where all of them lie then."""
        self._simulate(floors.x[number], floors.z[number])
        best = [self.best.x[np.newaxis]] if self.simulated else []
        again = self._lead(np.concatenate([floors.x, *best]))
        if self.simulated:
            progress(self.best.S)
        return again._replace(end=np.where(floors.end < 0, -1, again.end[floors.end]))

    def _lead(self, places: np.ndarray) -> Descent:
        return descend(self.guide.residuals, self.coordinates, places, SURROGATE.failed_residual**2)

    def _promising(self, floors: Descent, otherwise: int | None = None) -> int | None:
        """Return the lowest floor that promises less than the best simulation; another number where none does."""
        if not len(floors.x):
            return None
        if not self.simulated:
            untried = np.flatnonzero(self._distances(floors.z, failed=True) > self.rules.same)
            return int(untried[0]) if len(untried) else None
        best = self.best.S / self.objective.compared.samples
        away = self._distances(floors.z, failed=True)
        lowest = np.clip(np.sqrt(floors.S) - self.rules.doubt * self.guide.deviation(floors.z), 0.0, None) ** 2
        doubtful = (lowest < best) & (away > self.rules.reach)
        promises = doubtful | ((best - floors.S > ROUGH_TOLERANCE * best) & (away > self.rules.same))
        return int(np.argmax(promises)) if promises.any() else otherwise

    def _unseen(self, floors: Descent) -> int | None:
        """Return a floor that no simulation speaks for, None where there is none."""
        unseen = self._distances(floors.z, failed=True) > self.rules.reach
        return int(np.argmax(unseen)) if unseen.any() else None

    def _distances(self, z: np.ndarray, failed: bool = False) -> np.ndarray:
        """Return how far places are from the next one that was simulated."""
        tried = [place.z for place in self.simulated] + (self.failed if failed else [])
        if not tried:
            return np.full(len(z), np.inf)
        return np.abs(z[:, np.newaxis] - np.array(tried)).max(axis=2).min(axis=1)

    def _nearest(self, z: np.ndarray) -> Simulated:
        return min(self.simulated, key=lambda place: float(np.abs(place.z - z).max()))

    def _simulate(self, x: np.ndarray, z: np.ndarray) -> None:
        """Simulate a place, and learn what it says."""
        objective, coordinates = self.objective, self.guide.coordinates
        parameters, place = x[: (free := coordinates.free)], z[:free]
        if len(self.simulated) + len(self.failed) >= self.rules.max_simulations:
            raise Misled
        if self.simulated:
            objective.begin_from(self._nearest(z).run)
        try:
            run = objective.at(parameters)
            residual, jacobian = objective.residuals(parameters), objective.jacobian(parameters)
        except NumericalError:
            self.failed.append(z)
            return
        count = objective.compared.samples
        slopes = spectrum_of(jacobian, count) @ coordinates.slopes(place)
        self.guide.learn(place, spectrum_of(residual, count), slopes)
        self.simulated.append(Simulated(x, z, float(residual @ residual), residual, run))

    def ends(self) -> dict[int, SearchEnd]:
        """Return where the starts ended, by number: those in a valley whose floor was simulated.

        The first of each valley bears its simulations.
        """
        floors, ends, counted = self.floors, dict[int, SearchEnd](), set[int]()
        if floors is None:  # stopped on the way
            return {0: self._stopped()} if self.simulated else {}
        spoken_for = self._distances(floors.z) <= self.rules.reach
        speaks = [self._speaker(z) if spoken else None for z, spoken in zip(floors.z, spoken_for, strict=True)]
        for number, floor in enumerate(floors.end):
            place = speaks[floor] if floor >= 0 else None
            if place is not None:
                total = 0 if id(place) in counted else self._borne(place, speaks)
                ends[number] = self._end(place, total, self._is_as_deep(floors, floor))
                counted.add(id(place))
        return ends

    def _is_as_deep(self, floors: Descent, floor: int) -> bool:
        """Whether a floor is as deep as the best simulation, in spite of the doubt that is left of the correction."""
        deviation = self.guide.deviation(floors.z[floor : floor + 1])[0]
        highest = (np.sqrt(floors.S[floor]) + self.rules.doubt * deviation) ** 2
        return bool(highest <= (1 + SAME_OPTIMUM_SHARE) * self.best.S / self.objective.compared.samples)

    def _speaker(self, z: np.ndarray) -> Simulated:
        """Return the deepest simulation that speaks for a floor."""
        candidates = [place for place in self.simulated if np.abs(place.z - z).max() <= self.rules.reach]
        return min(candidates, key=lambda place: place.S)

    def _borne(self, place: Simulated, speaks: list[Simulated | None]) -> int:
        """Return the simulations that the valley of a place has taken: its own, of the best all that no other has."""
        if place is not self.best:
            return 2
        shallower = {id(end) for end in speaks if end is not None and end is not place}
        return self.objective.simulations - 2 * len(shallower)

    def _stopped(self) -> SearchEnd:
        best = self.best
        return SearchEnd(best.x, best.S, self.objective.simulations, False, "stopped on the way", best.residual)

    def _end(self, place: Simulated, simulations: int, as_deep: bool = True) -> SearchEnd:
        in_best = place is self.best
        message = IN_BEST if in_best else AS_DEEP if as_deep else IN_OTHER
        return SearchEnd(place.x, place.S, simulations, in_best, message, place.residual, in_best or as_deep)
