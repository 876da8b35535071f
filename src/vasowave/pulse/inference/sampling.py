"""The posterior of one animal under one wall law, from network and recording to draws and words."""

from collections.abc import Callable
from dataclasses import field, replace
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from annotated_types import Ge

from vasowave.base.errors import InputError
from vasowave.base.runtime.thread_limits import threads
from vasowave.base.settings import given_values, settings_class
from vasowave.pulse.calibration.compared import compared_part, sites_of
from vasowave.pulse.calibration.fitting import Search
from vasowave.pulse.calibration.parameters import ParameterLimits, parameter_space
from vasowave.pulse.calibration.result import CalibratedModel
from vasowave.pulse.calibration.surrogate import linear_optimum
from vasowave.pulse.cycle.averaged import EnsembleAverage, one_cycle
from vasowave.pulse.cycle.cycle import Recording
from vasowave.pulse.inference.diagnostics import FitOptimum
from vasowave.pulse.inference.mixture import explore
from vasowave.pulse.inference.priors import Priors
from vasowave.pulse.inference.problem import Problem
from vasowave.pulse.inference.reporting import reported
from vasowave.pulse.inference.result import Posterior
from vasowave.pulse.inference.rounds import Target
from vasowave.pulse.inference.simulations import Simulations
from vasowave.pulse.inference.starts import find_modes, screened
from vasowave.pulse.inference.unknowns import Unknowns
from vasowave.pulse.model.blood import Blood
from vasowave.pulse.model.laws import find_bed
from vasowave.pulse.model.nominal import estimate_nominal
from vasowave.pulse.model.numerics import Numerics
from vasowave.pulse.network.network import Network, a_network
from vasowave.pulse.quantities import derived

_MAX_START_SD = 2.0
"""SD of the prior at which a search begins where a fit ended farther away: what a fit leaves open runs away."""


@settings_class
class Sampling:
    """What a posterior is of, and how it is drawn: what `posterior` takes by name.

    Examples
    --------
    >>> import vasowave as vw
    >>> vw.Sampling(draws=200, search=vw.Search(fixed={"c1": 1.0})).draws
    200
    """

    bed: str | type = "windkessel"
    """As for `calibrate`."""
    blood: Blood = field(default_factory=Blood)
    """Density, viscosity and friction."""
    search: Search = field(default_factory=Search)
    """Its ``fixed`` parameters are held, its ``pressure_harmonics`` are compared, and what it says ``enters``; the rest
    does not matter here."""
    numerics: Numerics = field(default_factory=Numerics)
    """How finely is simulated."""
    priors: Priors = field(default_factory=Priors)
    """What is assumed before."""
    sites: tuple[Any, ...] = ()
    """What was observed elsewhere over the cycle of the recording, an `Observation` each; see `read_sites`."""
    draws: Annotated[int, Ge(40)] = 400
    """Draws that are weighted; with fewer than 40 none lies in the 2.5 % at either end. They are simulated, 80 at a
    time, until the emulator foretells the likelihood of 80 that it does not know, and then foretells the others'."""
    seed: Annotated[int, Ge(0)] = 0
    """Of everything random; the same seed gives the same result."""
    workers: Annotated[int, Ge(1)] | None = None
    """Threads; by default as many as the process may use."""


def posterior(
    network: Network,
    recording: Recording | EnsembleAverage,
    wall: str | type = "linear",
    *,
    fit: CalibratedModel | None = None,
    path: str | Path | None = None,
    progress: Callable[[int], None] | None = None,
    **settings: Any,
) -> Posterior:
    """Draw what is compatible with a recording: parameters, geometry and structure together.

    Polynomials stand for the simulations; they are learned in rounds where the posterior lies. The draws are then
    weighted by what the polynomials missed, so that they are draws of the posterior itself: simulated until the
    polynomials, which learn from them, miss little. Two halves of
    the search, which know nothing of each other, begin where the network in the frequency domain sees a chance; every
    mode that either finds is drawn from as often as it is likely, and how far the halves are apart is a diagnostic.

    Parameters
    ----------
    network : Network
    recording : Recording or EnsembleAverage
        One that comes from averaged beats brings the standard errors of its harmonics along.
    wall : str or class
        As for `calibrate`.
    fit : CalibratedModel, optional
        Of the same animal and law: one more start. If the posterior lies elsewhere, that is one of the findings.
    path : str or Path, optional
        File in which simulations are kept as they are made; a run that was killed goes on from it.
    progress : callable, optional
        Called with the number of simulations so far.
    settings
        Those of `Sampling` by name: ``draws=200, priors=vw.Priors(radius_scale_sd=0.1)``.

    Raises
    ------
    InputError
        Wrong wall, priors of parameters that there are none, a fit of another law, too few draws, a file of another
        problem; a recording that hardly changes.
    NumericalError
        No start, or nearly no point near them, can be simulated.

    Examples
    --------
    >>> import vasowave as vw
    >>> network = vw.Network(("1",), [-1], [0.4], [0.05])  # a quick one: one vessel, and one unknown
    >>> search = vw.Search(fixed={"r1": 1.0, "r2": 1.0, "c1": 1.0}, pressure_harmonics=8)
    >>> exact = dict.fromkeys(("radius_scale_sd", "length_scale_sd", "k_sd", "flow_gain_sd", "taper_sd"), 0.0)
    >>> priors = vw.Priors(radius=0, length=0, **exact)
    >>> vw.posterior(network, vw.virtual_mouse(), priors=priors, search=search, draws=40)
    Posterior(linear wall: beta ... [..., ...], stiffness ...; Pareto k ...)
    """
    sampling, cycle = given_values(Sampling, None, settings), one_cycle(recording)
    sampling = replace(sampling, priors=sampling.priors.allowing_for(cycle))
    problem = problem_of(a_network(network), cycle, wall, sampling)
    return posterior_of(problem, sampling, fit, None if path is None else Path(path), progress)


def posterior_of(
    problem: Problem,
    sampling: Sampling,
    fit: CalibratedModel | None = None,
    path: Path | None = None,
    progress: Callable[[int], None] | None = None,
) -> Posterior:
    """Return the posterior of a problem; of `sampling` the draws and their seed matter here. Raises as `posterior`."""
    starts = [] if fit is None else [np.clip(_scores(problem.unknowns, fit), -_MAX_START_SD, _MAX_START_SD)]
    simulations = Simulations(problem.simulate, path, problem.key, progress)
    size, rng = len(problem.unknowns.all), np.random.default_rng(sampling.seed)
    halves = screened(problem.linear, size, sampling.seed)
    modes = find_modes(simulations, problem.linear, problem.measured, problem.discrepancy(), starts, halves)
    noise = problem.discrepancy(problem.vessels(modes[0].middle)).near(problem.measured - modes[0].output)
    target = Target(simulations, problem.measured, noise, problem.seen, problem.linear)
    explored = explore(target, modes, rng, sampling.draws)
    optimum = None if fit is None else _optimum(target, problem, fit)
    rng = np.random.default_rng([sampling.seed, 1])
    return reported(problem, noise, explored, halves, simulations.asked, rng, optimum)


def problem_of(network: Network, recording: Recording, wall: str | type, sampling: Sampling) -> Problem:
    """Return an animal as a problem of inference; raises as `posterior`."""
    nominal = estimate_nominal(network, recording, sampling.blood, find_bed(sampling.bed))
    limits = ParameterLimits(fixed=sampling.search.fixed, viscous=sampling.search.viscous)
    space = parameter_space(wall, network, nominal, sampling.blood, limits)
    unknowns = Unknowns(space, nominal, sampling.priors, recording, sampling.search.enters == "pressure")
    compared = compared_part(recording, sampling.search.pressure_harmonics, sampling.search.enters)
    compared = replace(compared, sites=sites_of(sampling.sites, network, compared))
    if compared.enters == "both":
        compared = compared.with_flow_error(space.model(space.values(linear_optimum(space, compared))))
    return Problem(unknowns, compared, sampling.numerics, sampling.workers or threads())


def _scores(unknowns: Unknowns, fit: CalibratedModel) -> np.ndarray:
    """Return the scores of the fit's optimum."""
    if type(fit.model.wall) is not unknowns.space.law or type(fit.model.outlets) is not type(unknowns.space.outlets):
        raise InputError(
            f"the fit is one of the {fit.wall} wall, or with other beds, not of {unknowns.space.law.law().name}"
        )
    response = {name: estimate.value for name, estimate in fit.response.items()}
    return unknowns.scores({str(name): float(value) for name, value in fit.parameters["value"].items()} | response)


def _optimum(target: Target, problem: Problem, fit: CalibratedModel) -> FitOptimum:
    """Return what the likelihood of the posterior says of the fit's optimum."""
    outputs = target.simulate(_scores(problem.unknowns, fit)[np.newaxis])
    return FitOptimum(float(target.log_likelihood(outputs)[0]), derived(fit.model, problem.recording.mean_pressure))
