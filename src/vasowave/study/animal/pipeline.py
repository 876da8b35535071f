"""Calibrate one animal's model with every wall law and make all analyses: one labelled result.

A fit or posterior that fails is recorded, and the others go on.
"""

import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any, Protocol

from vasowave.base.errors import VasowaveWarning
from vasowave.base.findings import Finding, finding_of, warn
from vasowave.base.software import provenance
from vasowave.base.stores import parsed
from vasowave.pulse.analysis.ejection import beat_indices
from vasowave.pulse.analysis.ventricle_coupling import coupled
from vasowave.pulse.calibration.fitting import calibrate
from vasowave.pulse.calibration.result import CalibratedModel
from vasowave.pulse.calibration.starts import SearchCache
from vasowave.pulse.inference.known_errors import Observed
from vasowave.pulse.inference.laws import compare_laws
from vasowave.pulse.inference.result import Posterior
from vasowave.pulse.inference.sampling import posterior
from vasowave.pulse.model.laws import find_bed, find_law, identity
from vasowave.pulse.model.nominal import estimate_nominal
from vasowave.pulse.selection.stiffening_test import profiled, stiffening
from vasowave.study.animal.animal import Animal, Settings
from vasowave.study.animal.datasets import (
    beats_dataset,
    calibration_dataset,
    loops_dataset,
    nominal_dataset,
    posterior_result,
    recording_with_scatter,
    ventricle_dataset,
)
from vasowave.study.animal.failure import Failure, Stage, attempted
from vasowave.study.animal.known_errors import effects_on_measured, spreads_of
from vasowave.study.animal.law_result import LawResult, Measured
from vasowave.study.animal.quantities import (
    compared_laws,
    loop_quantities,
    measured_quantities,
    measured_values,
    model_quantities,
    sites_within_bounds,
)
from vasowave.study.animal.result import AnimalResult
from vasowave.study.animal.signals import (
    flow_noise,
    impedance_dataset,
    measured_station,
    simulated_station,
    waves_dataset,
)
from vasowave.study.animal.vessels import vessels_dataset, with_load_intervals

Progress = Callable[[str, int, int, float], None]
"""Called with the wall law, its finished starts, all its starts, and the best S so far (mmHg²)."""


class OpenWork(Protocol):
    """The place where the unfinished work on one animal is kept."""

    def searches(self, wall: str, starts: int) -> SearchCache:
        """Return where the ends of the searches with one wall law are kept."""
        ...

    def simulations(self, wall: str) -> Path | None:
        """Return the file that keeps the simulations of the posterior of one wall law, if there can be one."""
        ...


def teller(animal: Animal, law: str, stage: Stage, failures: list[Failure]) -> Callable[[str], None]:
    """Return what adds a failure for its reason."""

    def record(reason: str) -> None:
        failures.append(Failure(animal.name, animal.group, law, stage, reason, animal.recording.mean_pressure))

    return record


def fits_of(
    animal: Animal, settings: Settings, progress: Progress | None, journal: OpenWork | None, failures: list[Failure]
) -> tuple[list[CalibratedModel], bool]:
    """Return the fits of all wall laws, or what had finished when it was interrupted, and whether it was."""
    fits: list[CalibratedModel] = []
    for wall in settings.walls:
        on_failure = teller(animal, find_law(wall).law().name, Stage.FIT, failures)
        try:
            fit = attempted(partial(_calibrated, animal, settings, wall, progress, journal), on_failure)
        except KeyboardInterrupt:
            if not fits:
                raise
            return fits, True
        if fit is not None:
            fits.append(fit)
            if len(fit.starts) < settings.starts:
                return fits, True
    return fits, False


def _calibrated(
    animal: Animal, settings: Settings, wall: str, progress: Progress | None, journal: OpenWork | None
) -> CalibratedModel:
    def report(done: int, count: int, best: float) -> None:
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
        pressure_lag_sd=settings.pressure_lag_sd or 0.0,
        pressure_inertia_sd=settings.pressure_inertia_sd or 0.0,
        progress=report,
        ends=journal.searches(wall, settings.starts) if journal is not None else None,
    )


def posteriors_of(
    animal: Animal,
    fits: Sequence[CalibratedModel],
    settings: Settings,
    journal: OpenWork | None,
    failures: list[Failure],
) -> dict[str, Posterior]:
    """Return the posterior of every fitted wall law of which it is asked for, and that has one."""
    walls = {find_law(wall).law().name for wall in settings.sampled_walls}

    def drawn(fit: CalibratedModel) -> Posterior:
        return posterior(
            animal.network, animal.recording, type(fit.model.wall), bed=type(fit.model.outlets), fit=fit,
            blood=settings.blood, sites=animal.sites,
            search=settings.search(type(fit.model.wall)), numerics=settings.numerics, seed=settings.seed,
            priors=settings.priors,
            path=journal.simulations(fit.wall) if journal is not None else None,
        )  # fmt: skip

    tried = {
        fit.wall: attempted(partial(drawn, fit), teller(animal, fit.wall, Stage.POSTERIOR, failures))
        for fit in fits
        if fit.wall in walls
    }
    return {wall: outcome for wall, outcome in tried.items() if outcome is not None}


def analyze(
    animal: Animal, settings: Settings | None = None, progress: Progress | None = None, kept: OpenWork | None = None
) -> AnimalResult:
    """Return everything about one animal as one labelled result.

    Parameters
    ----------
    animal : Animal
    settings : Settings, optional
    progress : callable, optional
        Called with the wall law, its finished starts, all its starts, and the best S so far (mmHg²).
    kept : OpenWork, optional
        Where unfinished work is kept and found again (see `calibrate` and `posterior`).

    Returns
    -------
    AnimalResult
        A law that cannot be fitted is missing, and the others stay; where none can, what was measured stays. The same
        input gives the same result, unless it was interrupted (Ctrl-C): then it holds the laws and starts that had
        finished, and says so.

    Raises
    ------
    InputError
        A recording that hardly changes.

    Examples
    --------
    >>> import vasowave as vw
    >>> quick = vw.Settings(walls=("linear",), starts=1)
    >>> mouse = vw.Animal("mouse 6", "CTL", vw.control_network(), vw.virtual_mouse(), synthetic=True)
    >>> result = vw.analyze(mouse, quick)
    >>> result.laws["linear"].quantities["R_T"].attrs["units"]
    'mmHg s/ml'
    """
    settings = (settings or Settings()).allowing_for(animal.recording)
    failures: list[Failure] = []
    estimate_nominal(
        animal.network, animal.recording, settings.blood, find_bed(settings.beds)
    )  # without them nothing can be said
    with _collected() as warned:
        fits, interrupted = fits_of(animal, settings, progress, kept, failures)
        drawn = posteriors_of(animal, fits, settings, kept, failures) if not interrupted else {}
    return result_of(animal, fits, settings, warned, interrupted, drawn, failures)


def result_of(
    animal: Animal,
    fits: Sequence[CalibratedModel],
    settings: Settings,
    warned: Sequence[Finding] = (),
    interrupted: bool = False,
    posteriors: Mapping[str, Posterior] | None = None,
    failures: Sequence[Failure] = (),
) -> AnimalResult:
    """Return the result of `analyze` of an animal that is calibrated already; `warned` becomes part of its findings."""
    posteriors, fits, failed = posteriors or {}, profiled(fits), list(failures)
    with _collected() as further_findings:
        measured = _measured(animal, settings)
        laws: dict[str, LawResult] = {}
        for fit in fits:
            law = attempted(partial(_modeled, animal, fit, settings), teller(animal, fit.wall, Stage.ANALYSIS, failed))
            laws |= {fit.wall: law} if law is not None else {}
        fits = [fit for fit in fits if fit.wall in laws]
        posteriors = {wall: posteriors[wall] for wall in laws if wall in posteriors}
        for wall, drawn in posteriors.items():
            on_failure = teller(animal, wall, Stage.POSTERIOR, failed)
            laws[wall] = replace(laws[wall], posterior=attempted(partial(posterior_result, drawn), on_failure))
        compared = _compared(animal, fits, settings, list(posteriors.values()), laws, failed)
    result = AnimalResult(
        name=animal.name,
        group=animal.group,
        network=animal.network,
        laws=laws,
        beats=beats_dataset(animal.beats, animal.raw) if animal.beats is not None else None,
        synthetic=animal.synthetic,
        interrupted=interrupted,
        noticed=tuple(dict.fromkeys([*warned, *further_findings])),
        failures=tuple(failed),
        settings=parsed(settings.as_json()),
        assumed_errors=settings.assumed(animal.network),
        origin={program: version for program, version in provenance().items() if program != "created"},
        **measured,
        **compared,
    )
    for wall in posteriors:
        on_failure = teller(animal, wall, Stage.POSTERIOR, failed)
        laws[wall] = attempted(partial(with_load_intervals, result, laws[wall]), on_failure) or laws[wall]
    return replace(result, laws=laws, failures=tuple(failed))


def result_of_fit(fit: CalibratedModel) -> AnimalResult:
    """Return the result of `analyze` of a fit alone."""
    animal = Animal("animal", "animal", fit.model.network, fit.recording)
    law, beds = identity(type(fit.model.wall)), identity(type(fit.model.outlets))
    settings = Settings(walls=(law,), beds=beds, starts=len(fit.starts), blood=fit.model.blood, numerics=fit.numerics)
    return result_of(animal, [fit], settings)


def _measured(animal: Animal, settings: Settings) -> dict[str, Any]:
    """Return the parts that need no model."""
    network, recording, blood = animal.network, animal.recording, settings.blood
    nominal = estimate_nominal(network, recording, blood, find_bed(settings.beds))
    station = measured_station(recording, network, nominal, blood.inertia, settings.waves_at)
    waves = waves_dataset(station, blood.inertia)
    coupling, findings = coupled(recording, animal.ventricle)
    for finding in (*findings, *(animal.loops.findings if animal.loops else ())):
        warn(finding)
    spectrum = impedance_dataset(station, settings.harmonics, flow_noise(recording, animal.beats))

    def values(observed: Observed) -> dict[str, float]:
        start = estimate_nominal(observed.network, observed.recording, observed.blood, find_bed(settings.beds))
        place = measured_station(observed.recording, observed.network, start, observed.blood.inertia, settings.waves_at)
        of_ventricle = coupling if observed.recording is recording else coupled(observed.recording, animal.ventricle)[0]
        return measured_values(
            observed.recording, start, place, waves_dataset(place, observed.blood.inertia), of_ventricle
        )

    lab_spreads = spreads_of(network, settings, "lab")  # what is usual is part of the scatter of animals
    effects = effects_on_measured(Observed(network, recording, blood), lab_spreads, values)
    values_here = measured_values(recording, nominal, station, waves, coupling)
    quantities = measured_quantities(values_here, station, effects, coupling)
    if animal.loops is not None:
        quantities = quantities.assign(loop_quantities(animal.loops))
    if animal.beats is not None:
        for name, sd in beat_indices(animal.beats, recording).std(ddof=1).dropna().items():
            if name in quantities:
                quantities[name].attrs["beat_sd"] = float(sd)
    return {
        "ventricle": ventricle_dataset(coupling, animal.ventricle) if coupling and animal.ventricle else None,
        "loops": loops_dataset(animal.loops) if animal.loops is not None else None,
        "recording": recording_with_scatter(recording, animal.beats),
        "nominal": nominal_dataset(nominal, network),
        "measured": Measured(waves=waves, impedance=spectrum, quantities=quantities),
    }


def _compared(
    animal: Animal,
    fits: Sequence[CalibratedModel],
    settings: Settings,
    posteriors: Sequence[Posterior],
    laws: Mapping[str, LawResult],
    failures: list[Failure],
) -> dict[str, Any]:
    """Return the parts that compare the wall laws, by their posteriors and by their fits."""
    on_failure = teller(animal, "", Stage.COMPARISON, failures)
    compared: dict[str, Any] = {}
    if len(posteriors) > 1:
        compared["evidence"] = attempted(partial(compare_laws, posteriors), on_failure)
    if settings.model_selection and len(fits) > 1:
        quantities = {wall: law.quantities for wall, law in laws.items()}
        compared |= attempted(partial(compared_laws, fits, settings, quantities), on_failure) or {}
    return compared


def _modeled(animal: Animal, fit: CalibratedModel, settings: Settings) -> LawResult:
    """Return what one wall law says."""
    inertia = settings.blood.inertia
    station = simulated_station(fit, settings.waves_at)
    waves = waves_dataset(station, inertia)
    spectrum = impedance_dataset(station, settings.harmonics, flow_noise(animal.recording, animal.beats))
    vessels = vessels_dataset(fit)
    return LawResult(
        name=fit.wall,
        calibration=calibration_dataset(fit),
        simulation=fit.simulation,
        waves=waves,
        impedance=spectrum,
        vessels=vessels,
        quantities=model_quantities(fit, station, waves, spectrum, vessels, settings),
        stiffening=stiffening(fit),
        sites=sites_within_bounds(fit, settings),
    )


@contextmanager
def _collected() -> Iterator[list[Finding]]:
    """Collect our own warnings as findings: they belong into the result. Others go their usual way."""
    findings: list[Finding] = []
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", VasowaveWarning)
        yield findings
    for warning in caught:
        if issubclass(warning.category, VasowaveWarning):
            findings.append(finding_of(warning.message))
        else:
            warnings.warn_explicit(warning.message, warning.category, warning.filename, warning.lineno)
