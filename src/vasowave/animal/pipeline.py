"""Calibrate one animal's model with every wall law and make all analyses: one labelled result."""

import json
import warnings
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import partial

import xarray as xr

from vasowave.animal.animal import Animal, Settings
from vasowave.animal.beats import beats_dataset, recording_with_scatter
from vasowave.animal.comparison import compared_datasets, stiffening_dataset
from vasowave.animal.datasets import calibration_dataset, network_dataset, nominal_dataset
from vasowave.animal.failure import ATTRIBUTE, Failure, Stage, as_plain, attempted
from vasowave.animal.files import KIND
from vasowave.animal.fitting import Kept, Progress, fits_of, posteriors_of, teller
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
from vasowave.calibration import Fit
from vasowave.errors import VasowaveWarning
from vasowave.findings import texts
from vasowave.inference import Posterior, compare_laws
from vasowave.nominal import estimate_nominal
from vasowave.provenance import provenance


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
        ``animal, group, synthetic, interrupted, settings, notes`` (what a reader must know, JSON list), ``failures``
        (what of the laws failed, and why, see `animal.failure`; JSON list) and the versions of the programs. A law that
        cannot be fitted has no group, and the others stay; where none can, what was measured stays. The same
        input gives the same result, unless it was interrupted (Ctrl-C): then it holds the laws and starts that had
        finished, and says so.

    Raises
    ------
    InputError
        A recording without nominal parameters.

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
    failures: list[Failure] = []
    estimate_nominal(animal.network, animal.recording, settings.blood)  # without them nothing can be said
    with _collected() as warned:
        fits, interrupted = fits_of(animal, settings, progress, kept, failures)
        drawn = posteriors_of(animal, fits, settings, kept, failures) if not interrupted else {}
    return result_of(animal, fits, settings, warned, interrupted, drawn, failures)


def result_of(
    animal: Animal,
    fits: Sequence[Fit],
    settings: Settings,
    warned: Sequence[str] = (),
    interrupted: bool = False,
    posteriors: Mapping[str, Posterior] | None = None,
    failures: Sequence[Failure] = (),
) -> xr.DataTree:
    """Return the result of `analyze` of an animal that is calibrated already; `warned` becomes part of its notes."""
    from vasowave.selection import profiled

    posteriors, fits, failed = dict(posteriors or {}), profiled(fits), list(failures)
    with _collected() as more:
        groups = _measured(animal, settings)
        for fit in fits:
            tell = teller(animal, fit.wall, Stage.ANALYSIS, failed)
            groups |= attempted(partial(_modeled, animal, fit, settings), tell) or {}
        fits = [fit for fit in fits if f"{fit.wall}/calibration" in groups]
        posteriors = {fit.wall: posteriors[fit.wall] for fit in fits if fit.wall in posteriors}
        for wall, drawn in posteriors.items():
            tell = teller(animal, wall, Stage.POSTERIOR, failed)
            groups |= attempted(partial(posterior_datasets, wall, drawn), tell) or {}
        groups |= _compared(animal, fits, settings, list(posteriors.values()), groups, failed)
    doubts = (f"{wall} wall, posterior: {note}" for wall, one in posteriors.items() for note in one.warnings)
    notes = [*texts(animal.recording.notes), *warned, *more, *_said(fits), *doubts]
    result = xr.DataTree.from_dict({f"/{name}": dataset for name, dataset in groups.items()})
    result.attrs = {
        "title": KIND,
        "Conventions": "CF-1.11",
        "animal": animal.name,
        "group": animal.group,
        "synthetic": int(animal.synthetic),
        "interrupted": int(interrupted),
        "notes": json.dumps(list(dict.fromkeys(notes)), ensure_ascii=False),
        ATTRIBUTE: json.dumps(as_plain(failed), ensure_ascii=False),
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


def _compared(
    animal: Animal,
    fits: Sequence[Fit],
    settings: Settings,
    posteriors: Sequence[Posterior],
    groups: Mapping[str, xr.Dataset],
    failures: list[Failure],
) -> dict[str, xr.Dataset]:
    """Return the groups that compare the wall laws, by their posteriors and by their fits."""
    tell = teller(animal, "", Stage.COMPARISON, failures)
    compared: dict[str, xr.Dataset] = {}
    if len(posteriors) > 1:
        laws = attempted(partial(compare_laws, posteriors), tell)
        compared |= {} if laws is None else {"laws": laws}
    if settings.model_selection and len(fits) > 1:
        compared |= attempted(partial(compared_datasets, fits, settings, groups), tell) or {}
    return compared


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
    return [note for note in fit.warnings if note not in texts(fit.recording.notes)]


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
