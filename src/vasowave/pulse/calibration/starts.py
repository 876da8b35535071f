"""The starts of one fit: all are led together, and those that cannot be are followed alone, by simulations.

`valleys` leads all of them at once. Alone are followed starts in a valley whose floor cannot be simulated, or of which
nothing is known; and all of them where derivatives are missing, where the corrected linear network misleads, and with
the paper's method, which begins where the paper does.
"""

import threading
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np

from vasowave.base.errors import NumericalError
from vasowave.base.findings import look_kind, warn
from vasowave.base.runtime.thread_limits import threads
from vasowave.pulse.calibration.compared import Compared
from vasowave.pulse.calibration.objective import Objective
from vasowave.pulse.calibration.optimization import ROUGH_TOLERANCE, SearchEnd, search
from vasowave.pulse.calibration.parameters import ParameterSpace, trial
from vasowave.pulse.calibration.valleys import Misled, Valleys
from vasowave.pulse.model.numerics import Numerics

Progress = Callable[[int, int, float], None]

STAGE = "start"
"""The name under which the end of a start is kept."""

NOT_KEPT = look_kind(
    "fit.searches-not-kept",
    "searches that an interrupted run had kept do not come out again ({count}), and were made anew; {remedy}",
    "look who else writes into results/searches; nothing of it is in these results",
)
DERIVATIVE_ERROR = 3e-3
"""Exactness of derivatives while searching."""

_MAX_REPEAT_RMS = 0.01
"""By so many mmHg, and this share of the residual, an end that was stored may differ from its simulation here."""
_START_LOG_RANGE = 0.5  # other starts differ from the nominal one by up to this in every logarithm


def starting_points(space: ParameterSpace, count: int, seed: int) -> list[np.ndarray]:
    """Return logarithms of the free parameters to start from: the nominal ones, and others nearby."""
    low, high = space.log_bounds
    inside = 0.02 * (high - low)
    nominal = np.log(space.nominal[space.free])
    random = np.random.default_rng(seed)
    moved = nominal + random.uniform(-_START_LOG_RANGE, _START_LOG_RANGE, (count - 1, len(nominal)))
    return [np.clip(x, low + inside, high - inside) for x in (nominal, *moved)]


class SearchCache(Protocol):
    """Where the ends of the searches of one fit are kept, by stage and number of the start."""

    def find(self, stage: str, start: int) -> SearchEnd | None:
        """Return where a search ended, if that is known."""
        ...

    def keep(self, stage: str, start: int, end: SearchEnd) -> None:
        """Keep where a search ended; called from several threads."""
        ...


def search_all(
    space: ParameterSpace,
    compared: Compared,
    numerics: Numerics,
    starts: Sequence[np.ndarray],
    method: str,
    progress: Progress | None = None,
    ends: SearchCache | None = None,
) -> tuple[list[SearchEnd], bool]:
    """Search from all starts; returns where they ended, and whether they were stopped.

    A start whose end is known from `ends`, and comes out again, need not be searched from. Those that are followed
    alone begin with nothing but their place.

    Raises
    ------
    NumericalError
        No start could be simulated.
    """
    searches = _Searches(space, compared, numerics, starts, method, progress, ends)
    try:
        searches.recall()
        if method == "least-squares" and len(searches.reached) < len(starts):
            searches.lead()
        searches.follow()
    except KeyboardInterrupt:
        if not any(np.isfinite(end.S) for end in searches.reached.values()):
            raise
    if searches.refused:
        warn(NOT_KEPT(count=searches.refused), stacklevel=3)
    reached = [searches.reached[number] for number in sorted(searches.reached)]
    if not any(np.isfinite(end.S) for end in reached):
        raise NumericalError(f"no start of the fit could be simulated; the first: {reached[0].message}")
    return reached, searches.stop.is_set()


def comes_again(objective: Objective, end: SearchEnd, begin: np.ndarray) -> bool:
    """Whether the end of a search that was kept is one of this fit: simulated again it leaves the same residual.

    One that could not be simulated is where its search began, and cannot be simulated now either.
    """
    if end.x.shape != begin.shape:
        return False
    if not np.isfinite(end.S):
        return bool(end.S == np.inf and np.array_equal(end.x, begin) and not objective.can_be(begin))
    if not objective.can_be(end.x) or end.residual.shape != (again := objective.residuals(end.x)).shape:
        return False
    size, off = (float(np.sqrt(np.mean(values**2))) for values in (again, end.residual - again))
    return off <= _MAX_REPEAT_RMS * (1.0 + size) and bool(
        np.isclose(end.S, end.residual @ end.residual, rtol=1e-9, atol=0.0)
    )


@dataclass(eq=False)
class _Searches:
    """The searches of one fit, and where they ended, by number of the start."""

    space: ParameterSpace
    compared: Compared
    numerics: Numerics
    starts: Sequence[np.ndarray]
    method: str
    progress: Progress | None
    ends: SearchCache | None
    reached: dict[int, SearchEnd] = field(default_factory=dict)
    refused: int = 0
    stop: threading.Event = field(default_factory=threading.Event)

    def objective(self, searches: int = 1) -> Objective:
        """Return an objective that remembers nothing yet, for one of so many searches at once."""
        workers = max(1, threads() // max(1, searches))
        return Objective(self.space, self.compared, self.numerics, workers, self.stop, DERIVATIVE_ERROR)

    def recall(self) -> None:
        """Take over the ends that are kept and come out again."""
        again: dict[bytes, bool] = {}
        for number, start in enumerate(self.starts):
            end = self.ends.find(STAGE, number) if self.ends is not None else None
            if end is None:
                continue
            content = end.x.tobytes() + end.residual.tobytes()
            if content not in again:
                again[content] = comes_again(self.objective(), end, start)
            if again[content]:
                self.reached[number] = end
            else:
                self.refused += 1

    def lead(self) -> None:
        """Search from all starts together; those that cannot be led do not end."""
        try:
            with trial():
                valleys = Valleys(self.objective(), np.array(self.starts))
        except NumericalError:
            return
        try:
            valleys.search(lambda S: self._tell(len(self.reached), S))
        except (Misled, NumericalError):
            return
        except KeyboardInterrupt:
            self.stop.set()
            self.reached = valleys.ends() | self.reached
            raise
        for number, end in valleys.ends().items():
            self._reach(number, end)

    def follow(self) -> None:
        """Search from every start alone that has not ended, as many at once as there are cores."""
        alone = [number for number in range(len(self.starts)) if number not in self.reached]
        for number, end in _finished(alone, lambda number: self._end(number, len(alone)), self.stop):
            self._reach(number, end)

    def _end(self, number: int, searches: int) -> SearchEnd:
        return search(self.objective(searches), self.starts[number], self.method, ROUGH_TOLERANCE)

    def _reach(self, number: int, end: SearchEnd) -> None:
        if number not in self.reached:
            self.reached[number] = end
            if self.ends is not None:
                self.ends.keep(STAGE, number, end)
            self._tell(len(self.reached), min(end.S for end in self.reached.values()))

    def _tell(self, done: int, S: float) -> None:
        if self.progress is not None:
            self.progress(done, len(self.starts), S)


def _finished(
    chosen: Sequence[int], task: Callable[[int], SearchEnd], stop: threading.Event
) -> Iterator[tuple[int, SearchEnd]]:
    """Run the task for every chosen number, and yield what is finished; whatever ends this sets `stop`."""
    with ThreadPoolExecutor(max(1, min(threads(), len(chosen)))) as pool:
        pending: dict[Future[SearchEnd], int] = {pool.submit(task, number): number for number in chosen}
        try:
            while pending:
                for future in wait(pending, timeout=0.2, return_when=FIRST_COMPLETED).done:
                    yield pending.pop(future), future.result()
        except BaseException:
            stop.set()
            pool.shutdown(cancel_futures=True)
            raise
