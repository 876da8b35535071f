"""Many starts of one fit: all of them look for the way, and only those that may lead elsewhere are followed.

First every start searches until a step gains little. The best of them goes on to its optimum. Another need not where
the linear model of that optimum explains its residual: between the two there is no other valley. What is left is
followed until it ends, or until even the linear model of its own place leads nowhere near the best.
"""

import threading
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from dataclasses import replace

import numpy as np

from vasowave.calibration.compared import Compared
from vasowave.calibration.objective import Objective
from vasowave.calibration.parameters import Space
from vasowave.calibration.search import ROUGH, Found, search
from vasowave.errors import NumericalError
from vasowave.solver.simulate import Numerics
from vasowave.threads import threads

Progress = Callable[[int, int, float], None]

SAME = 1e-3
"""Share by which the S of starts may differ that ended at the same optimum."""

DERIVATIVES = 3e-3
"""Exactness of derivatives while searching."""

_NEARBY = 0.5  # other starts differ from the nominal one by up to this in every logarithm
_SCOUT = 1e-2  # relative gain of S below which a start waits
_BEYOND = 1.1  # ratio to the best S above which a start is left that its linear model does not lead below it either
_UNEXPLAINED = 0.25  # share of a residual's change that the linear model of the best optimum may leave unexplained


def starting_points(space: Space, count: int, seed: int) -> list[np.ndarray]:
    """Return logarithms of the free parameters to start from: the nominal ones, and others nearby."""
    low, high = space.log_bounds
    inside = 0.02 * (high - low)
    nominal = np.log(space.nominal[space.free])
    random = np.random.default_rng(seed)
    moved = nominal + random.uniform(-_NEARBY, _NEARBY, (count - 1, len(nominal)))
    return [np.clip(x, low + inside, high - inside) for x in (nominal, *moved)]


def search_all(
    space: Space,
    compared: Compared,
    numerics: Numerics,
    starts: Sequence[np.ndarray],
    method: str,
    progress: Progress | None = None,
) -> tuple[list[Found], bool]:
    """Search from every start, as many at once as there are cores; returns what was found, and if it was stopped.

    Raises
    ------
    NumericalError
        No start could be simulated.
    """
    stop, workers = threading.Event(), max(1, threads() // len(starts))
    objectives = [Objective(space, compared, numerics, workers, stop, DERIVATIVES) for _ in starts]
    found: dict[int, Found] = {}

    def follow(chosen: Sequence[int], task: Callable[[int], Found], told: Progress | None = None) -> None:
        for number, one in _finished(chosen, task, stop):
            found[number] = one
            if told is not None:
                told(len(found), len(starts), min(one.S for one in found.values()))

    first = _SCOUT if len(starts) > 1 else ROUGH
    try:
        follow(range(len(starts)), lambda i: search(objectives[i], starts[i], method, first), progress)
        best = min(found, key=lambda i: found[i].S)
        if len(starts) > 1 and np.isfinite(found[best].S):
            follow([best], lambda i: search(objectives[i], found[i].x, method, ROUGH))
            found |= _joined(objectives, found, best)
            alone = [i for i, one in found.items() if np.isfinite(one.S) and not one.joined and i != best]
            enough = _BEYOND * found[best].S
            follow(alone, lambda i: search(objectives[i], found[i].x, method, ROUGH, enough))
    except KeyboardInterrupt:
        if not any(np.isfinite(one.S) for one in found.values()):
            raise
    if not any(np.isfinite(one.S) for one in found.values()):
        raise NumericalError(f"no start of the fit could be simulated; the first: {found[0].message}")
    return [found[number] for number in sorted(found)], stop.is_set()


def _finished(
    chosen: Sequence[int], task: Callable[[int], Found], stop: threading.Event
) -> Iterator[tuple[int, Found]]:
    """Run the task for every chosen number, and yield what is finished; whatever ends this sets `stop`."""
    with ThreadPoolExecutor(max(1, min(threads(), len(chosen)))) as pool:
        pending: dict[Future[Found], int] = {pool.submit(task, number): number for number in chosen}
        try:
            while pending:
                for future in wait(pending, timeout=0.2, return_when=FIRST_COMPLETED).done:
                    yield pending.pop(future), future.result()
        except BaseException:
            stop.set()
            pool.shutdown(cancel_futures=True)
            raise


def _joined(objectives: Sequence[Objective], found: dict[int, Found], best: int) -> dict[int, Found]:
    """Return the starts that lie in the bowl of the best optimum: its linear model explains their residuals."""
    optimum, objective, joined = found[best].x, objectives[best], {}
    residual, jacobian = objective.residuals(optimum), objective.jacobian(optimum)
    for number, one in found.items():
        if number != best and np.isfinite(one.S):
            change = objectives[number].residuals(one.x) - residual
            left = change - jacobian @ (one.x - optimum)
            if left @ left <= _UNEXPLAINED * (change @ change):
                message = "in the bowl of the best optimum, to which it need not be followed"
                joined[number] = replace(one, converged=True, joined=True, message=message)
    return joined
