"""Calibrate one animal's model with every wall law and make all analyses: one labelled result."""

import json
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Protocol

import xarray as xr

from vasowave.animal.animal import Animal, Settings
from vasowave.animal.beats import beats_dataset, recording_with_scatter
from vasowave.animal.comparison import compared_datasets, stiffening_dataset
from vasowave.animal.datasets import calibration_dataset, network_dataset, nominal_dataset
from vasowave.animal.files import KIND
from vasowave.animal.posterior import posterior_datasets
from vasowave.animal.quantities import measured_quantities, model_quantities
from vasowave.animal.signals import (
    flow_noise,
    impedance_dataset,
    measured_station,
    simulated_station,
    waves_dataset,
)
from vasowave.animal.vessels import vessels_dataset
from vasowave.calibration import Ends, Fit, calibrate
from vasowave.errors import VasowaveWarning
from vasowave.inference import Posterior, Priors, compare_laws, posterior
from vasowave.nominal import estimate_nominal
from vasowave.provenance import provenance

Progress = Callable[[str, int, int, float], None]
"""Called with the wall law, its finished starts, all its starts, and the best S so far (mmHg²)."""


class Kept(Protocol):
    """Where the unfinished work on one animal is kept."""

    def of(self, wall: str, starts: int) -> Ends:
        """Return where the ends of the searches with one wall law are kept."""
        ...

    def simulations(self, wall: str) -> Path | None:
        """Return the file that keeps the simulations of the posterior of one wall law, if there can be one."""
        ...


def analyze(
    animal: Animal, settings: Settings | None = None, progress: Progress | None = None, kept: Kept | None = None
) -> xr.DataTree:
    """Return everything about one animal as one labelled result.

    Parameters
    ----------
    animal : Animal
    settings : Settings, optional
    progress : callable, optional
        Called with the wall law, its finished starts, all its starts, and the best S so far (mmHg²).
    kept : Kept, optional
        Where unfinished work is kept and found again (see `calibrate` and `posterior`).

    Returns
    -------
    DataTree
        Groups ``network``, ``recording``, ``beats`` (of a continuous recording), ``nominal``, ``selection`` and
        ``averages`` over the laws (if asked for), ``laws`` (what their posteriors say of them), ``measured`` with
        ``waves, impedance, quantities``, and for each wall law a group of its name with ``calibration, simulation,
        waves, impedance, tree, quantities``, ``stiffening`` where the law has a parameter for it, and ``inference``
        where a posterior was asked for. Every variable has its unit; ``quantities``
        holds single numbers, those that were fitted with their 95 % interval in the attributes. Attributes of the root:
        ``animal, group, synthetic, interrupted, settings, notes`` (what a reader must know, JSON list) and the versions
        of the programs. The same input gives the same result, unless it was interrupted (Ctrl-C): then it holds the
        laws and starts that had finished, and says so.

    Raises
    ------
    InputError
        A recording without nominal parameters, or bounds that exclude them.
    NumericalError
        No start of a calibration could be simulated.

    Examples
    --------
    >>> import vasowave as vw
    >>> quick = vw.Settings(walls=("linear",), starts=1)
    >>> mouse = vw.Animal("mouse 6", "CTL", vw.control_network(), vw.virtual_mouse(), synthetic=True)
    >>> result = vw.analyze(mouse, quick)
    >>> [name for name in result.children if name not in ("beats", "selection")]
    ['network', 'recording', 'nominal', 'measured', 'linear']
    >>> result["linear/quantities"]["R_T"].attrs["units"]
    'mmHg s/ml'
    """
    settings = settings or Settings()
    with _collected() as warned:
        fits, interrupted = _fits(animal, settings, progress, kept)
        drawn = _posteriors(animal, fits, settings, kept) if not interrupted else {}
    return result_of(animal, fits, settings, warned, interrupted, drawn)


def result_of(
    animal: Animal,
    fits: Sequence[Fit],
    settings: Settings,
    warned: Sequence[str] = (),
    interrupted: bool = False,
    posteriors: Mapping[str, Posterior] | None = None,
) -> xr.DataTree:
    """Return the result of `analyze` of an animal that is calibrated already; `warned` becomes part of its notes."""
    from vasowave.selection import profiled

    posteriors, fits = posteriors or {}, profiled(fits)
    with _collected() as more:
        groups = _measured(animal, settings)
        for fit in fits:
            groups |= _modeled(animal, fit, settings)
        for wall, drawn in posteriors.items():
            groups |= posterior_datasets(wall, drawn)
        if len(posteriors) > 1:
            groups["laws"] = compare_laws(list(posteriors.values()))
        if settings.model_selection and len(fits) > 1:
            groups |= compared_datasets(fits, settings, groups)
    doubts = (f"{wall} wall, posterior: {note}" for wall, one in posteriors.items() for note in one.warnings)
    notes = [*animal.recording.notes, *warned, *more, *_said(fits), *doubts]
    result = xr.DataTree.from_dict({f"/{name}": dataset for name, dataset in groups.items()})
    result.attrs = {
        "title": KIND,
        "Conventions": "CF-1.11",
        "animal": animal.name,
        "group": animal.group,
        "synthetic": int(animal.synthetic),
        "interrupted": int(interrupted),
        "notes": json.dumps(list(dict.fromkeys(notes)), ensure_ascii=False),
        "settings": settings.as_json(),
        **{program: version for program, version in provenance().items() if program != "created"},
    }
    return result


def _measured(animal: Animal, settings: Settings) -> dict[str, xr.Dataset]:
    """Return the groups that need no model."""
    network, recording, blood = animal.network, animal.recording, settings.blood
    nominal = estimate_nominal(network, recording, blood)
    station = measured_station(recording, network, nominal, blood.inertia, settings.waves_at)
    waves = waves_dataset(station, blood.inertia)
    groups = {
        "network": network_dataset(network),
        "recording": recording_with_scatter(animal.recording, animal.beats),
        "nominal": nominal_dataset(nominal, network),
        "measured/waves": waves,
        "measured/impedance": impedance_dataset(station, settings.harmonics, flow_noise(recording, animal.beats)),
        "measured/quantities": measured_quantities(recording, nominal, station, waves),
    }
    if animal.beats is not None:
        groups["beats"] = beats_dataset(animal.beats, animal.raw)
    return groups


def _fits(animal: Animal, settings: Settings, progress: Progress | None, kept: Kept | None) -> tuple[list[Fit], bool]:
    """Return the fits of all wall laws, or what had finished when it was interrupted, and whether it was."""
    fits: list[Fit] = []
    for wall in settings.walls:
        try:
            fits.append(_calibrated(animal, settings, wall, progress, kept))
        except KeyboardInterrupt:
            if not fits:
                raise
            return fits, True
        if len(fits[-1].starts) < settings.starts:
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
        blood=settings.blood,
        search=settings.search(wall),
        numerics=settings.numerics,
        progress=say,
        ends=kept.of(wall, settings.starts) if kept is not None else None,
    )


def _posteriors(animal: Animal, fits: Sequence[Fit], settings: Settings, kept: Kept | None) -> dict[str, Posterior]:
    """Return the posterior of every fitted wall law, if it is asked for."""
    if settings.inference != "posterior":
        return {}
    return {
        fit.wall: posterior(
            animal.network, animal.recording, type(fit.model.wall), fit=fit, blood=settings.blood,
            search=settings.search(fit.wall), numerics=settings.numerics, seed=settings.seed,
            priors=Priors(zero=settings.zero_sd),
            path=kept.simulations(fit.wall) if kept is not None else None,
        )
        for fit in fits
    }  # fmt: skip


def _modeled(animal: Animal, fit: Fit, settings: Settings) -> dict[str, xr.Dataset]:
    """Return the groups of one wall law."""
    inertia = settings.blood.inertia
    station = simulated_station(fit, settings.waves_at)
    waves = waves_dataset(station, inertia)
    spectrum = impedance_dataset(station, settings.harmonics, flow_noise(animal.recording, animal.beats))
    vessels = vessels_dataset(fit)
    return {
        f"{fit.wall}/calibration": calibration_dataset(fit),
        f"{fit.wall}/simulation": fit.simulation,
        f"{fit.wall}/waves": waves,
        f"{fit.wall}/impedance": spectrum,
        f"{fit.wall}/tree": vessels,
        f"{fit.wall}/quantities": model_quantities(fit, station, waves, spectrum, vessels),
        **stiffening_dataset(fit),
    }


def _said(fits: Sequence[Fit]) -> list[str]:
    """Return the warnings of the fits: once what all laws share, what belongs to one with its name."""
    each = {fit.wall: _own(fit) for fit in fits}
    shared = [note for note in _own(fits[0]) if all(note in one for one in each.values())] if len(fits) > 1 else []
    own = [f"{wall} wall: {note}" for wall, notes in each.items() for note in notes if note not in shared]
    return [*shared, *own]


def _own(fit: Fit) -> Sequence[str]:
    """Return the warnings of a fit without those of its recording, which stand once."""
    return [note for note in fit.warnings if note not in fit.recording.notes]


@contextmanager
def _collected() -> Iterator[list[str]]:
    """Collect our own warnings as sentences: they belong into the result. Others go their usual way."""
    sentences: list[str] = []
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", VasowaveWarning)
        yield sentences
    for one in caught:
        if issubclass(one.category, VasowaveWarning):
            sentences.append(str(one.message))
        else:
            warnings.warn_explicit(one.message, one.category, one.filename, one.lineno)


__all__ = ["Progress", "analyze", "result_of"]
