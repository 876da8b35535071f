"""The effects of a lab's errors on the quantities of a recording and of a fit, each by one SD of every error."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np
import pandas as pd

from vasowave.animal.animal import Settings
from vasowave.calibration import Fit
from vasowave.errors import NumericalError
from vasowave.inference import Priors, Sampling
from vasowave.inference.known_errors import Seen, kinds
from vasowave.inference.posterior import problem_of
from vasowave.inference.problem import Problem
from vasowave.model.model import Model

_STEP = 0.02  # of differences, in the logarithm of a parameter and in SD of an error

Derive = Callable[[Mapping[str, float], Model, float], dict[str, float]]
"""Quantities of a model, from its parameters, itself, and the mean pressure (mmHg)."""


def effects_on_measured(seen: Seen, settings: Settings, quantities: Callable[[Seen], dict[str, float]]) -> pd.DataFrame:
    """Return what one SD of each error that is said moves in the logarithm of what the recording alone says.

    Parameters
    ----------
    seen : Seen
    settings : Settings
    quantities : callable
        Returns the positive quantities of what was seen.

    Returns
    -------
    DataFrame
        Index: quantity; columns: unknown. NaN of what is not positive.
    """
    effects = {}
    for name, sd in settings.said().items():
        one = kinds()[name]
        center = one.center(seen)
        if one.positive and center == 0:
            continue
        ends = []
        for score in (-_STEP, _STEP):
            value = center * np.exp(sd * score) if one.positive else center + sd * score
            ends.append(_logs(quantities(one.without(seen, value))))
        effects[name] = (ends[1] - ends[0]) / (2 * _STEP)
    return pd.DataFrame(effects)


def effects_on_fit(fit: Fit, settings: Settings, derive: Derive) -> pd.DataFrame:
    """Return what one SD of each error that is said moves in the logarithms of a fit's quantities.

    Had the error been known, least squares would have made up for it by the free parameters: to first order their
    shift is ``-J⁺ E``, J and E being the derivatives of the simulated pressure by parameters and errors.

    Parameters
    ----------
    fit : Fit
    settings : Settings
    derive : callable

    Raises
    ------
    NumericalError
        A model beside the optimum cannot be simulated.
    """
    said = settings.said()
    if not said:
        return pd.DataFrame()
    problem = _problem(fit, settings)
    unknowns, names = problem.unknowns, list(problem.unknowns.all)
    values = {str(name): float(row["value"]) for name, row in fit.parameters.iterrows()}
    middle, steps = unknowns.scores(values), _STEP * np.eye(len(names))
    outputs = problem.simulate([*(middle + steps), *(middle - steps)])
    if not np.isfinite(outputs).all():
        raise NumericalError("a model beside the optimum cannot be simulated; what the errors do cannot be told")
    slopes = (outputs[: len(names)] - outputs[len(names) :]).T / (2 * _STEP)
    open_ = fit.parameters["free"] & ~fit.parameters["at_bound"]
    parameters = [i for i, name in enumerate(names) if name in open_.index and open_[name]]
    mean = fit.recording.mean_pressure

    def at(point: np.ndarray, mean: float = mean) -> pd.Series:
        at_point = unknowns.values(point)
        known = {name: float(value) for name, value in at_point.items() if name in values}
        return _logs(derive(known, unknowns.model(point), mean - float(at_point.get("zero", 0.0))))

    ends = [(at(middle + step), at(middle - step)) for step in steps]
    direct = pd.DataFrame({name: (up - down) / (2 * _STEP) for name, (up, down) in zip(names, ends, strict=True)})
    inverse = np.linalg.pinv(slopes[:, parameters])
    by_parameter = direct.iloc[:, parameters].to_numpy()
    effects = {}
    for name, sd in said.items():
        if name == "zero" and name not in names:
            moved = np.zeros(problem.samples)
            moved[0] = sd * np.sqrt(problem.samples)  # which the pressure of the animal does not have
            up, down = (at(middle, mean - side * sd * _STEP) for side in (1, -1))
            own = ((up - down) / (2 * _STEP)).to_numpy()
        elif name in names:
            moved, own = slopes[:, names.index(name)], direct[name].to_numpy()
        else:
            continue
        effects[name] = own - by_parameter @ (inverse @ moved)
    return pd.DataFrame(effects, index=direct.index)


def _problem(fit: Fit, settings: Settings) -> Problem:
    """Return the animal as a problem whose unknowns are the fit's parameters and the errors that are said."""
    said = settings.said()
    errors: dict[str, Any] = {f"{name}_sd": said.get(name, 0.0) for name in kinds()}
    free = fit.parameters[fit.parameters["free"]]
    priors = Priors(
        parameters={str(name): (float(row["nominal"]), 1.0) for name, row in free.iterrows()},
        radius=0.0, length=0.0, taper_scale=0.0, **errors,
    )  # fmt: skip
    held = {str(name): float(value) for name, value in fit.parameters["value"][~fit.parameters["free"]].items()}
    law = type(fit.model.wall)
    search = replace(settings.search(law), fixed=held)
    how = Sampling(bed=type(fit.model.outlets), blood=settings.blood, search=search, numerics=settings.numerics,
                   priors=priors)  # fmt: skip
    return problem_of(fit.model.network, fit.recording, law, how)


def _logs(values: Mapping[str, float]) -> pd.Series:
    numbers = pd.Series(values, dtype=float)
    return pd.Series(np.log(numbers.where(numbers > 0)), numbers.index)
