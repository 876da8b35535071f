"""Many starts of one fit: all of them look for the way, and only those that may lead elsewhere are followed.

First the linear model leads every start, and of those that it leads to one place the first goes on: it searches until a
step gains little. The best of them goes on to its optimum. Another need not where the linear model of that optimum
explains its residual: between the two there is no other valley. What is left is followed until it ends, or until even
the linear model of its own place leads nowhere near the best.
"""

import threading
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from dataclasses import dataclass, field, replace
from typing import Protocol

import numpy as np

from vasowave.base.errors import NumericalError
from vasowave.base.findings import look_kind, warn
from vasowave.base.runtime.thread_limits import threads
from vasowave.pulse.calibration.compared import Compared
from vasowave.pulse.calibration.objective import Objective
from vasowave.pulse.calibration.optimization import ROUGH_TOLERANCE, SearchEnd, search
from vasowave.pulse.calibration.parameters import ParameterSpace
from vasowave.pulse.calibration.screening import knows, screened
from vasowave.pulse.model.numerics import Numerics

Progress = Callable[[int, int, float], None]

SCOUT_STAGE = "scout"
"""The first stage: every start looks for the way, from where the linear model leads it."""

UNSCREENED_STAGE = "unscreened"
"""The same from where it was, where the linear model leads to what cannot be simulated."""

NOT_KEPT = look_kind(
    "fit.searches-not-kept",
    "searches that an interrupted run had kept do not come out again ({count}), and were made anew; {remedy}",
    "look who else writes into results/searches; nothing of it is in these results",
)
SAME_OPTIMUM_SHARE = 1e-3
"""Share by which the S of starts may differ that ended at the same optimum."""

DERIVATIVE_ERROR = 3e-3
"""Exactness of derivatives while searching."""

_MAX_REPEAT_RMS = 0.01
"""By so many mmHg, and this share of the residual, an end that was stored may differ from its simulation here."""
_START_LOG_RANGE = 0.5  # other starts differ from the nominal one by up to this in every logarithm
_MIN_GAIN = 1e-2  # relative gain of S below which a start waits
_MAX_S_RATIO = 1.1
"""Ratio to the best S above which a start is left that its linear model does not lead below it either."""
_MAX_UNEXPLAINED_SHARE = 0.25
"""Share of a residual's change that the linear model of the best optimum may leave unexplained."""


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
    """Search from every start, as many at once as there are cores; returns where they ended, and if they were stopped.

    Every search of every stage begins with nothing but its place, so that one whose end is known from `ends` need not
    be made, and all others are the same as without.

    Raises
    ------
    NumericalError
        No start could be simulated.
    """
    places, leads = list(starts), list(range(len(starts)))
    if len(starts) > 1 and method == "least-squares" and knows(space):  # the paper's method begins where the paper does
        places, leads = screened(space, compared, starts)
    stages = _Stages(space, compared, numerics, places, leads, method, progress, ends)
    searched = stages.reached
    try:
        stages.follow(SCOUT_STAGE, sorted(set(leads)), _MIN_GAIN if len(starts) > 1 else ROUGH_TOLERANCE)
        if lost := [number for number in range(len(starts)) if not np.isfinite(searched[leads[number]].S)]:
            stages.places, stages.leads = list(starts), list(range(len(starts)))
            stages.follow(UNSCREENED_STAGE, lost, _MIN_GAIN)
        best = min(sorted(searched), key=lambda i: searched[i].S)
        if len(starts) > 1 and np.isfinite(searched[best].S):
            stages.follow("best", [best], ROUGH_TOLERANCE)
            searched |= _joined(stages.objective(), searched, best)
            alone = [i for i, end in sorted(searched.items()) if np.isfinite(end.S) and not end.joined and i != best]
            stages.follow("alone", alone, ROUGH_TOLERANCE, _MAX_S_RATIO * searched[best].S)
    except KeyboardInterrupt:
        if not any(np.isfinite(end.S) for end in searched.values()):
            raise
    if stages.refused:
        warn(NOT_KEPT(count=len(stages.refused)), stacklevel=3)
    if not any(np.isfinite(end.S) for end in searched.values()):
        raise NumericalError(f"no start of the fit could be simulated; the first: {searched[0].message}")
    led = {number: _led(searched[lead], lead) for number, lead in enumerate(leads) if lead in searched}
    searched = led | searched
    return [searched[number] for number in sorted(searched)], stages.stop.is_set()


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


def _led(end: SearchEnd, lead: int) -> SearchEnd:
    """Return the end of a start that was not followed, since the linear model leads it where another one begins."""
    return replace(end, simulations=0, message=f"the linear model leads it where start {lead + 1} was followed from")


@dataclass(eq=False)
class _Stages:
    """The searches of one fit, and where they ended, by number of the start."""

    space: ParameterSpace
    compared: Compared
    numerics: Numerics
    places: Sequence[np.ndarray]
    leads: Sequence[int]
    method: str
    progress: Progress | None
    ends: SearchCache | None
    reached: dict[int, SearchEnd] = field(default_factory=dict)
    refused: list[int] = field(default_factory=list)
    stop: threading.Event = field(default_factory=threading.Event)

    def objective(self) -> Objective:
        """Return an objective that remembers nothing yet."""
        workers = max(1, threads() // len(set(self.leads)))
        return Objective(self.space, self.compared, self.numerics, workers, self.stop, DERIVATIVE_ERROR)

    def follow(self, stage: str, chosen: Sequence[int], tolerance: float, enough: float = np.inf) -> None:
        """Search from the chosen starts, or from where the stage before ended."""
        for number, end in _finished(chosen, lambda number: self.end(stage, number, tolerance, enough), self.stop):
            before = self.reached[number].simulations if number in self.reached else 0
            self.reached[number] = replace(end, simulations=before + end.simulations)
            if stage == SCOUT_STAGE and self.progress is not None:
                done = sum(lead in self.reached for lead in self.leads)
                self.progress(done, len(self.leads), min(end.S for end in self.reached.values()))

    def end(self, stage: str, number: int, tolerance: float, enough: float) -> SearchEnd:
        """Return where a search ends, from what is known or by searching."""
        outcome = self.ends.find(stage, number) if self.ends is not None else None
        begin = self.places[number] if stage in (SCOUT_STAGE, UNSCREENED_STAGE) else self.reached[number].x
        if outcome is not None and not comes_again(self.objective(), outcome, begin):
            self.refused.append(number)
            outcome = None
        if outcome is None:
            outcome = search(self.objective(), begin, self.method, tolerance, enough)
            if self.ends is not None:
                self.ends.keep(stage, number, outcome)
        return outcome


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


def _joined(objective: Objective, searched: dict[int, SearchEnd], best: int) -> dict[int, SearchEnd]:
    """Return the starts that lie in the bowl of the best optimum: its linear model explains their residuals."""
    joined: dict[int, SearchEnd] = {}
    optimum = searched[best]
    try:
        jacobian = objective.jacobian(optimum.x)
    except NumericalError:  # no linear model, so that every start is followed on its own
        return joined
    for number, end in searched.items():
        if number != best and np.isfinite(end.S):
            change = end.residual - optimum.residual
            remainder = change - jacobian @ (end.x - optimum.x)
            if remainder @ remainder <= _MAX_UNEXPLAINED_SHARE * (change @ change):
                message = "in the bowl of the best optimum, to which it need not be followed"
                joined[number] = replace(end, converged=True, joined=True, message=message)
    return joined
