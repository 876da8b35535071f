"""Calibrate a model to one recording from several starts in parallel."""

import threading
from collections.abc import Callable, Mapping
from dataclasses import field, replace
from typing import Annotated, Any, Literal

import numpy as np
import pandas as pd
from annotated_types import Ge, Le
from pydantic import BeforeValidator

from vasowave.base.errors import InputError, NumericalError
from vasowave.base.findings import look_kind, warn
from vasowave.base.runtime.thread_limits import threads
from vasowave.base.settings import Check, Example, Positive, Range, given_values, settings_class
from vasowave.pulse.calibration import optimization
from vasowave.pulse.calibration.beside import what_sites_add
from vasowave.pulse.calibration.compared import (
    MAX_SAMPLES,
    MIN_HARMONICS,
    Compared,
    Enters,
    checked_harmonics,
    compared_part,
    sites_of,
)
from vasowave.pulse.calibration.instruments import instrument_findings
from vasowave.pulse.calibration.objective import Objective, Stopped
from vasowave.pulse.calibration.optimization import SAME_OPTIMUM_SHARE, SearchEnd
from vasowave.pulse.calibration.parameters import ParameterLimits, ParameterSpace, parameter_space
from vasowave.pulse.calibration.response import estimates
from vasowave.pulse.calibration.response import findings as response_findings
from vasowave.pulse.calibration.response_search import RESPONSE, fit_response, response_columns
from vasowave.pulse.calibration.result import CalibratedModel
from vasowave.pulse.calibration.starts import SearchCache, search_all, starting_points
from vasowave.pulse.calibration.uncertainty import correlations, fit_findings, parameter_table, spread_of
from vasowave.pulse.cycle.averaged import EnsembleAverage, one_cycle
from vasowave.pulse.cycle.cycle import Recording
from vasowave.pulse.model.blood import Blood
from vasowave.pulse.model.law_files import in_words
from vasowave.pulse.model.laws import find_bed
from vasowave.pulse.model.nominal import estimate_nominal, oddities
from vasowave.pulse.model.numerics import Numerics
from vasowave.pulse.network.network import Network, a_network
from vasowave.pulse.network.remarks import unknown_pressure
from vasowave.pulse.solver.dataset import as_dataset

NUMERICS = Numerics(tolerance=1e-7)
"""How a fit simulates unless told otherwise."""

_MIN_VISIBLE_RMS = 1e-3
"""Starts agree, too, if their root-mean-square residuals differ by less, mmHg, which no recording shows."""
_COARSE_SAMPLES = 64  # the searches choose their step in multiples of this
_MAX_TOLERANCE = 1e-6  # mmHg, tolerance of a fit
_MIN_DISCREPANCY_SHARE = 0.1  # of the usual discrepancy, below which none counts where sites are weighted
_SEARCH_TOLERANCE_RATIO = 10.0  # ratio of the searches' tolerance to that of the final one

INTERRUPTED = look_kind(
    "fit.interrupted",
    "Interrupted: {done} of {starts} starts had finished.",
    "Run again: what had finished is not computed twice.",
)
NOT_AGAIN = look_kind(
    "fit.best-not-repeated",
    "the best {lost} of {ends} ends could not be simulated a second time; the next was taken",
    "Look at the table of starts, and fit again with narrower bounds.",
)


def _harmonics_schema() -> dict[str, Any]:
    return {"anyOf": [{"enum": ["signal", "all"]}, {"type": "integer", "minimum": MIN_HARMONICS}]}


@settings_class
class Search:
    """How to search.

    Raises
    ------
    InputError
        A value outside its limits.

    Examples
    --------
    >>> import vasowave as vw
    >>> vw.Search(starts=8, fixed={"c1": 1.0}).starts
    8
    """

    starts: Annotated[int, Ge(1), Le(1000)] = 20
    """Starts of each fit: the nominal parameters and others nearby. The paper's 4 miss the best optimum one time in
    three."""
    method: Literal["least-squares", "sqp"] = "least-squares"
    """least-squares (bounded, trust region), or sqp as in the paper."""
    paper_bounds: bool = False
    """The paper's bounds instead of wide ones."""
    bounds: Annotated[Mapping[str, Range], Example({"beta": [10, 400], "c1": [0.05, 5]})] = field(default_factory=dict)
    """Own bounds of single parameters, [lower, upper], in the unit of the parameter (beta and p1 in mmHg; gamma, r1, r2
    and c1 have none). p1 is that of eq. 4; the published table lists π p1."""
    fixed: Annotated[Mapping[str, Positive], Example({"gamma": 2})] = field(default_factory=dict)
    """Parameters held at a value, in the same units."""
    pressure_harmonics: Annotated[
        str | int, BeforeValidator(checked_harmonics), Check(checked_harmonics, _harmonics_schema)
    ] = "signal"
    """Harmonics of the pressure that are compared: those that carry signal, all that the recording holds (the paper's
    practice, up to 1024 samples), or up to a number, at least 8."""
    seed: Annotated[int, Ge(0)] = 0
    """Seed of everything random; the same seed gives the same result."""
    viscous: bool | None = None
    """Whether walls are viscous, so that their viscosity `wall_viscosity` (mmHg s) is fitted beside the parameters of
    their law; by default they are elastic."""
    enters: Enters | None = None
    """What enters the model as it was measured: flow, and the pressure is compared, or pressure, and the flow is; with
    both the flow enters, and the errors of both count in intervals and posteriors. By default the flow."""


@settings_class
class Fitting(Search):
    """How to search, and with what beds, blood and numerics: what `calibrate` takes by name.

    Examples
    --------
    >>> import vasowave as vw
    >>> vw.Fitting(starts=4, bed="rc").bed
    'rc'
    """

    bed: str | type = "windkessel"
    """What stands behind the terminals: ``windkessel``, ``rc``, ``resistance``, or a class of your own; see
    `laws.find_bed`."""
    blood: Blood = field(default_factory=Blood)
    """Density, viscosity and friction."""
    numerics: Numerics = NUMERICS
    """Its `samples` is ignored: the simulation has the recording's (at most 1024). A tolerance above 1e-6 mmHg becomes
    1e-6."""
    sites: tuple[Any, ...] = ()
    """What was observed elsewhere over the cycle of the recording, an `Observation` each; see `read_sites`."""
    pressure_lag_sd: Annotated[float, Ge(0)] = 0.0
    """SD of the lag of the pressure, s, as of `KnownErrors`: where it is not 0 and the pressure is compared, the lag is
    fitted, too."""
    pressure_inertia_sd: Annotated[float, Ge(0)] = 0.0
    """SD of the inertia of the catheter, s², likewise."""


@in_words()
def calibrate(
    network: Network,
    recording: Recording | EnsembleAverage,
    wall: str | type = "linear",
    search: Search | None = None,
    *,
    progress: Callable[[int, int, float], None] | None = None,
    ends: SearchCache | None = None,
    **settings: Any,
) -> CalibratedModel:
    """Find the parameters that minimize S (eq. 14) between measured and simulated pressure and flow at the inlet.

    The flow enters, and the pressure is compared, or the other way round (`Search.enters`).
    What was observed at further sites (`Fitting.sites`) counts beside it, each value by its error and the model's.

    Parameters
    ----------
    network : Network
    recording : Recording or EnsembleAverage
    wall : str or class
        Name of a wall law (``linear``: fits {β, r1, r2, c1}; ``tangent``: {p1, γ, r1, r2, c1}), or a class of your own;
        see `laws.find_law`.
    search : Search, optional
        Starts, method, bounds.
    progress : callable, optional
        Called with finished starts, all starts and the best S so far.
    ends : SearchCache, optional
        Where the ends of searches are kept as they come, and found again by a fit that goes on after a kill.
    settings
        Those of `Fitting` by name, ``starts=4, bed="rc"``, in place of what `search` says of them.

    Returns
    -------
    Fit
        After an interrupt (Ctrl-C) from the starts that had finished, with a warning that says so.

    Raises
    ------
    InputError
        Wrong wall, bounds or parameter names; a recording that hardly changes; a site in no vessel of the network.
    NumericalError
        No start could be simulated, or no optimum a second time.

    Examples
    --------
    >>> import vasowave as vw
    >>> search = vw.Search(starts=1)
    >>> vw.calibrate(vw.control_network(), vw.virtual_mouse(), "linear", search=search)
    Fit(linear wall: beta ..., r1 ..., r2 ..., c1 ...; S ..., N ..., RMSE ... mmHg)
    """
    plan = given_values(Fitting, search, settings)
    network, recording = a_network(network), one_cycle(recording)
    nominal = estimate_nominal(network, recording, plan.blood, find_bed(plan.bed))
    limits = ParameterLimits(plan.bounds, plan.fixed, plan.paper_bounds, plan.viscous)
    space = parameter_space(wall, network, nominal, plan.blood, limits)
    compared = compared_part(recording, plan.pressure_harmonics, plan.enters)
    compared = replace(compared, sites=sites_of(plan.sites, network, compared))
    if (plan.sites or plan.enters == "pressure") and plan.numerics.cycles_from_rest is not None:
        reason = "further sites need" if plan.sites else "a pressure that enters needs"
        raise InputError(f"{reason} a periodic state; leave out cycles_from_rest")
    numerics = for_fits(plan.numerics, min(len(compared.signal_of(recording)), MAX_SAMPLES))
    starts = starting_points(space, plan.starts, plan.seed)
    searched, stopped = search_all(space, compared, _coarser(numerics), starts, plan.method, progress, ends)
    alone = _alone(space, compared, numerics, plan, starts) if plan.sites else None
    if alone is not None:
        compared = _weighted(compared, alone)
    objective, best = _polish(space, compared, numerics, plan, searched)
    sds = {name: getattr(plan, f"{name}_sd") for name in RESPONSE if compared.what == "pressure"}
    priors = {name: sd for name, sd in sds.items() if sd > 0}
    if priors:
        objective, best = fit_response(objective, best, starts[0], priors, plan.method)
    residual, jacobian = objective.residuals(best.x), objective.jacobian(best.x)
    compared = objective.compared.with_flow_error(space.model(space.values(best.x)))
    of_response = response_columns(objective, best.x, priors) if priors else None
    spread = spread_of(space, best.x, jacobian, residual, compared, of_response)
    response = estimates(compared.response, spread.response, priors)
    table, correlation = parameter_table(space, best.x, spread), correlations(space, spread)
    table_of_starts = _starts_table(space, searched, len(residual))
    run = objective.run(best.x)
    findings = [INTERRUPTED(done=len(searched), starts=plan.starts)] if stopped else []
    findings += [*compared.findings(), *unknown_pressure(network), *oddities(nominal, recording.flow)]
    findings += [*fit_findings(table, correlation, table_of_starts, spread), *run.notes]
    findings += response_findings(response)
    if not response:
        findings += instrument_findings(objective, best, jacobian, starts[0])
    added = (
        (None, [])
        if alone is None
        else what_sites_add(space, compared, objective.numerics, plan.method, best.x, alone.x)
    )
    findings += added[1]
    at_inlet = residual[: compared.samples]
    return CalibratedModel(
        space.law.law().name, run.model, compared, nominal, table, correlation, table_of_starts, as_dataset(run),
        at_inlet, float(at_inlet @ at_inlet), tuple(findings), added[0], response, numerics,
    )  # fmt: skip


def for_fits(numerics: Numerics, samples: int) -> Numerics:
    """Return how finely a fit is simulated that was asked for with some numerics."""
    return replace(numerics, samples=samples, every_cell=False, tolerance=min(numerics.tolerance, _MAX_TOLERANCE))


def _coarser(numerics: Numerics) -> Numerics:
    """Return what serves the searches: free choice of the step, and a cycle that repeats itself less exactly."""
    if numerics.cycles_from_rest is not None or numerics.steps_per_cycle is not None:
        return numerics
    return replace(numerics, samples=_COARSE_SAMPLES, tolerance=_SEARCH_TOLERANCE_RATIO * numerics.tolerance)


def _polish(
    space: ParameterSpace, compared: Compared, numerics: Numerics, plan: Search, searched: list[SearchEnd]
) -> tuple[Objective, SearchEnd]:
    """Search again from the best end, with the step that suits it, so that no start's detours stay in the result.

    Where the best end cannot be simulated with that step, the next one takes its place.
    """
    ends = sorted((end for end in searched if np.isfinite(end.S)), key=lambda end: end.S)
    for place, end in enumerate(ends):
        objective = Objective(space, compared, numerics, threads(), threading.Event())
        again = optimization.search(objective, end.x, plan.method)
        if np.isfinite(again.S):
            if place:
                warn(NOT_AGAIN(lost=place, ends=len(ends)), stacklevel=3)
            return objective, again
    raise NumericalError(f"no optimum of the {len(ends)} starts could be simulated a second time; {again.message}")


def _alone(
    space: ParameterSpace, compared: Compared, numerics: Numerics, plan: Fitting, starts: list[np.ndarray]
) -> SearchEnd:
    """Return where the search from all starts ends without sites: a wrong one can pull every start elsewhere."""
    compared = replace(compared, sites=None)
    searched, _ = search_all(space, compared, _coarser(numerics), starts, plan.method)
    return _polish(space, compared, numerics, plan, searched)[1]


def _weighted(compared: Compared, alone: SearchEnd) -> Compared:
    """Return what is compared with its sites weighted by what the model leaves unexplained at the inlet alone."""
    sites = compared.sites
    assert sites is not None
    deviation = float(np.sqrt(alone.S / max(1, compared.samples - len(alone.x))))
    return replace(compared, sites=replace(sites, deviation=max(deviation, _MIN_DISCREPANCY_SHARE * sites.deviation)))


def _starts_table(space: ParameterSpace, searched: list[SearchEnd], samples: int) -> pd.DataFrame:
    rows = []
    smallest = min(end.S for end in searched)  # rough ends are compared with each other, not with the polished one
    limit = smallest * (1 + SAME_OPTIMUM_SHARE) + samples * _MIN_VISIBLE_RMS**2
    deepest_led = min((end.S for end in searched if end.joined), default=np.inf)  # the valley that others joined
    for number, end in enumerate(sorted(searched, key=lambda end: end.S), 1):
        row: dict[str, object] = {
            "start": number,
            "S [mmHg2]": end.S,
            "simulations": end.simulations,
            "converged": end.converged,
            "agrees": bool(end.S <= limit or (end.joined and deepest_led <= limit)),
            "message": end.message,
        }
        rows.append(row | dict(zip(space.names, space.values(end.x), strict=True)))
    return pd.DataFrame(rows)


__all__ = ["Search", "Stopped", "calibrate"]
