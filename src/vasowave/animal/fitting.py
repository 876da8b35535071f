"""The fits and posteriors of one animal, law by law: one that fails is recorded, and the others go on."""

from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Protocol

from vasowave.animal.animal import Animal, Settings
from vasowave.animal.failure import Failure, Stage, attempted
from vasowave.calibration import Ends, Fit, calibrate
from vasowave.inference import Posterior, posterior
from vasowave.model.laws import find_law

Progress = Callable[[str, int, int, float], None]
"""Called with the wall law, its finished starts, all its starts, and the best S so far (mmHg²)."""


class Kept(Protocol):
    """The place where the unfinished work on one animal is kept."""

    def of(self, wall: str, starts: int) -> Ends:
        """Return where the ends of the searches with one wall law are kept."""
        ...

    def simulations(self, wall: str) -> Path | None:
        """Return the file that keeps the simulations of the posterior of one wall law, if there can be one."""
        ...


def teller(animal: Animal, law: str, stage: Stage, failures: list[Failure]) -> Callable[[str], None]:
    """Return what adds a failure for its reason."""

    def tell(reason: str) -> None:
        failures.append(Failure(animal.name, animal.group, law, stage, reason, animal.recording.mean_pressure))

    return tell


def fits_of(
    animal: Animal, settings: Settings, progress: Progress | None, kept: Kept | None, failures: list[Failure]
) -> tuple[list[Fit], bool]:
    """Return the fits of all wall laws, or what had finished when it was interrupted, and whether it was."""
    fits: list[Fit] = []
    for wall in settings.walls:
        tell = teller(animal, find_law(wall).law().name, Stage.FIT, failures)
        try:
            fit = attempted(partial(_calibrated, animal, settings, wall, progress, kept), tell)
        except KeyboardInterrupt:
            if not fits:
                raise
            return fits, True
        if fit is not None:
            fits.append(fit)
            if len(fit.starts) < settings.starts:
                return fits, True
    return fits, False


def _calibrated(animal: Animal, settings: Settings, wall: str, progress: Progress | None, kept: Kept | None) -> Fit:
    def say(done: int, count: int, best: float) -> None:
        if progress is not None:
            progress(wall, done, count, best)

    return calibrate(
        animal.network,
        animal.recording,
        wall,
        sites=animal.sites,
        bed=settings.beds,
        blood=settings.blood,
        search=settings.search(wall),
        numerics=settings.numerics,
        progress=say,
        ends=kept.of(wall, settings.starts) if kept is not None else None,
    )


def posteriors_of(
    animal: Animal, fits: Sequence[Fit], settings: Settings, kept: Kept | None, failures: list[Failure]
) -> dict[str, Posterior]:
    """Return the posterior of every fitted wall law that has one, if it is asked for."""
    if settings.inference != "posterior":
        return {}

    def drawn(fit: Fit) -> Posterior:
        return posterior(
            animal.network, animal.recording, type(fit.model.wall), bed=type(fit.model.outlets), fit=fit,
            blood=settings.blood, sites=animal.sites,
            search=settings.search(type(fit.model.wall)), numerics=settings.numerics, seed=settings.seed,
            priors=settings.priors,
            path=kept.simulations(fit.wall) if kept is not None else None,
        )  # fmt: skip

    tried = {
        fit.wall: attempted(partial(drawn, fit), teller(animal, fit.wall, Stage.POSTERIOR, failures)) for fit in fits
    }
    return {wall: one for wall, one in tried.items() if one is not None}
