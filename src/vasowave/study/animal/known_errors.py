"""The effects of a lab's errors on the quantities of a recording and of a fit, each by one SD of every error."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
import pandas as pd

from vasowave.base.errors import InputError
from vasowave.base.findings import look_kind, warn
from vasowave.pulse.analysis.impedance_spectrum import characteristic_impedances
from vasowave.pulse.analysis.operating import operating_point
from vasowave.pulse.analysis.waves import wave_intensity
from vasowave.pulse.calibration.result import CalibratedModel
from vasowave.pulse.cycle.cycle import Recording
from vasowave.pulse.inference.known_errors import Observed, kinds
from vasowave.pulse.inference.priors import Priors
from vasowave.pulse.inference.problem import Problem
from vasowave.pulse.inference.sampling import Sampling, problem_of
from vasowave.pulse.model.model import Model
from vasowave.pulse.network.network import Network
from vasowave.study.animal.animal import Settings

_ROUNDING_ERROR = 1e-9  # below it a difference of logarithms is none
_LOG_STEP = 0.02  # of differences, in the logarithm of a parameter and in SD of an error

_SIMULATED_QUANTITIES = ("I_R", "Z_c", "Z_0")  # quantities of the waves at the inlet

UNKNOWN = look_kind(
    "fit.errors-unknown",
    "{law} wall: a model beside the optimum cannot be simulated, so that its intervals take image, probe and zero for "
    "exact; between groups it has the errors of the other animals.",
    "Look at the fit: its wall is near the end of its law.",
)

Derive = Callable[[Mapping[str, float], Model, float], dict[str, float]]
"""Quantities of a model, from its parameters, itself, and the mean pressure (mmHg)."""


def effects_on_measured(
    observed: Observed, spreads: Mapping[str, float], quantities: Callable[[Observed], dict[str, float]]
) -> pd.DataFrame:
    """Return what one SD of each error moves in the logarithm of what the recording alone says.

    Parameters
    ----------
    observed : Observed
    spreads : mapping of str to float
        SD of the errors, by unknown.
    quantities : callable
        Returns the positive quantities of what was seen.

    Returns
    -------
    DataFrame
        Index: quantity; columns: unknown; attribute ``sd``: the SD by unknown. NaN of what is not positive.
    """
    effects = {}
    for name, sd in spreads.items():
        kind = kinds()[name]
        center = kind.center(observed)
        if kind.positive and center == 0:
            continue
        ends = []
        for score in (-_LOG_STEP, _LOG_STEP):
            value = center * np.exp(sd * score) if kind.positive else center + sd * score
            ends.append(_logs(quantities(kind.without(observed, value))))
        effects[name] = (ends[1] - ends[0]) / (2 * _LOG_STEP)
    table = pd.DataFrame(effects)
    return _with_spreads(table.where(~(table.abs() < _ROUNDING_ERROR), 0.0), spreads)


class FitEffects(NamedTuple):
    """What moves the logarithms of a fit's quantities; index: quantity.

    `errors`: one SD of each assumed error, by unknown, NaN of what is not positive. `parameters`: the logarithm of each
    free parameter, of the quantities that need a simulation (I_R, Z_c, Z_0).
    """

    errors: pd.DataFrame = pd.DataFrame()
    parameters: pd.DataFrame = pd.DataFrame()


def effects_on_fit(fit: CalibratedModel, settings: Settings, derive: Derive) -> FitEffects:
    """Return what one SD of each assumed error moves in the logarithms of a fit's quantities.

    Had the error been known, least squares would have made up for it by the free parameters: to first order their
    shift is ``-J⁺ E``, J and E being the derivatives of the simulated pressure by parameters and errors.

    Parameters
    ----------
    fit : CalibratedModel
    settings : Settings
    derive : callable

    Returns
    -------
    FitEffects
        Empty where every error is said to be none, and, with a warning, where a model beside the optimum cannot be
        simulated.
    """
    spreads = spreads_of(fit.model.network, settings)
    if not spreads:
        return FitEffects()
    problem = _problem(fit, settings, spreads)
    unknowns, names = problem.unknowns, list[str](problem.unknowns.all)
    values = {str(name): float(row["value"]) for name, row in fit.parameters.iterrows()}
    fitted = {
        name: response.value for name, response in fit.response.items()
    }  # beside the parameters: no error is left of it
    middle, taper = unknowns.scores(values | fitted), np.array(names) == "taper"
    # Only a tree that tapers has other junctions.
    up, down = np.where(taper, 1.0, _LOG_STEP), np.where(taper, 0.0, _LOG_STEP)
    points = np.array([*(middle + np.diag(up)), *(middle - np.diag(down)), middle])
    outputs = problem.simulate(points)
    taper_rows = np.flatnonzero(taper)
    if not np.isfinite(outputs[taper_rows]).all():  # a flow as fast as its waves: what two smaller tapers say goes on
        half, quarter = (problem.simulate(middle[np.newaxis] + share * taper) for share in (0.5, 0.25))
        outputs[taper_rows] = 3 * half - 2 * quarter
    if not np.isfinite(outputs).all():
        warn(UNKNOWN(law=fit.wall))
        return FitEffects()
    waves = problem.through_amplifier(points, outputs, back=True)
    ups, downs = np.split(np.arange(2 * len(names)), 2)
    slopes = (outputs[ups] - outputs[downs]).T / (up + down)
    open_ = fit.parameters["free"] & ~fit.parameters["at_bound"]
    parameters = [i for i, name in enumerate(names) if name in fitted or (name in open_.index and open_[name])]

    def effect_at(place: int, zero: float = 0.0) -> pd.Series:
        at_point = unknowns.values(points[place])
        parameter_values = {name: float(value) for name, value in at_point.items() if name in values}
        mean = fit.recording.mean_pressure - float(at_point.get("zero", 0.0)) - zero
        mean *= float(at_point["pressure_gain"])
        model, recorded = unknowns.posed(points[place])
        return _logs(derive(parameter_values, model, mean) | _simulated(problem, model, recorded, waves[place], mean))

    ends = zip(names, map(effect_at, ups), map(effect_at, downs), up + down, strict=True)
    direct = pd.DataFrame({name: (after - before) / distance for name, after, before, distance in ends})
    inverse = np.linalg.pinv(slopes[:, parameters])
    by_parameter = direct.iloc[:, parameters].to_numpy()
    effects = {}
    for name, sd in spreads.items():
        if name == "zero" and name not in names:
            moved = np.zeros(problem.samples)
            moved[0] = sd * np.sqrt(problem.samples)  # which the pressure of the animal does not have
            effect = ((effect_at(-1, sd * _LOG_STEP) - effect_at(-1, -sd * _LOG_STEP)) / (2 * _LOG_STEP)).to_numpy()
        elif name in names and name not in fitted:
            moved, effect = slopes[:, names.index(name)], direct[name].to_numpy()
        else:
            continue
        effects[name] = effect - by_parameter @ (inverse @ moved)
    simulated = direct.loc[[*_SIMULATED_QUANTITIES], [name for name in names if name in values]]
    return FitEffects(_with_spreads(pd.DataFrame(effects, index=direct.index), spreads), simulated.dropna())


def _with_spreads(effects: pd.DataFrame, sd: Mapping[str, float]) -> pd.DataFrame:
    """Return effects of one SD with the SD themselves as attributes, so that derivatives can be told."""
    effects.attrs["sd"] = dict(sd)
    return effects


def _simulated(
    problem: Problem, model: Model, recorded: Recording, output: np.ndarray, mean: float
) -> dict[str, float]:
    """Return the quantities of the simulated waves at the inlet."""
    (pressure,), (flow,) = problem.inlet_waves(recorded.flow[np.newaxis], output[np.newaxis])
    waves = wave_intensity(pressure, flow, recorded.period, *operating_point(model, mean), model.blood.inertia)
    try:
        Z_c = float(characteristic_impedances(Recording(pressure, flow, recorded.period))["up-slope"])
    except InputError:  # a flow without an upstroke
        Z_c = np.nan
    values = float(waves.reflection_coefficient), Z_c, float(pressure.mean() / flow.mean())
    return dict(zip(_SIMULATED_QUANTITIES, values, strict=True))


def spreads_of(network: Network, settings: Settings, source: str = "") -> dict[str, float]:
    """Return the SD of every error that there is and that the `source` tells, by default any, by unknown."""
    return {
        error.name: error.sd for error in settings.assumed(network) if error.sd > 0 and source in ("", error.source)
    }


def _problem(fit: CalibratedModel, settings: Settings, spreads: Mapping[str, float]) -> Problem:
    """Return the animal as a problem whose unknowns are the fit's parameters and its errors."""
    errors: dict[str, Any] = {f"{name}_sd": spreads.get(name, 0.0) for name in kinds()}
    free = fit.parameters[fit.parameters["free"]]
    priors = Priors(
        parameters={str(name): (float(row["nominal"]), 1.0) for name, row in free.iterrows()},
        radius=0.0, length=0.0, taper_scale=0.0, **errors,
    )  # fmt: skip
    held = {str(name): float(value) for name, value in fit.parameters["value"][~fit.parameters["free"]].items()}
    law = type(fit.model.wall)
    search = replace(settings.search(law), fixed=held)
    sampling = Sampling(bed=type(fit.model.outlets), blood=settings.blood, search=search, numerics=settings.numerics,
                   priors=priors)  # fmt: skip
    network = fit.model.network
    if fit.model.profile is None:  # measured tapers within their errors: its vessels are straight
        network = replace(network, taper=None, taper_sd=None)
    problem = problem_of(network, fit.recording, law, sampling)
    return replace(problem, unknowns=replace(problem.unknowns, taper_enters=True))


def _logs(values: Mapping[str, float]) -> pd.Series:
    numbers = pd.Series(values, dtype=float)
    return pd.Series(np.log(numbers.where(numbers > 0)), numbers.index)
