"""Models that the data allow: drawn about a fit from its errors, or the draws of its posterior."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr

from vasowave.animal.law_result import PosteriorResult
from vasowave.model.laws import bed_factors, parameter_names
from vasowave.model.model import Model
from vasowave.model.outlets import Bed
from vasowave.model.walls import WALL_VISCOSITY
from vasowave.workbench.values import number

BANDS = ("pressure", "forward", "backward", "modulus")
"""Curves of which a band is drawn."""

_DRAWS = 40  # models about a fit
_WALKED = 100  # draws of a posterior, of all that there are


def models_around(model: Model, fit: xr.Dataset) -> list[Model]:
    """Return models drawn from the correlated errors of a fit about it; parameters at a bound stay at it."""
    if "correlation" not in fit or not isinstance(model.outlets, Bed):
        return []
    free = fit.sel(parameter=fit["free_parameter"].values)
    value, low, high = (free[name].values for name in ("value", "lower", "upper"))
    scale = free["standard_error_correlated"].values / value
    loose, held = ~free["at_bound"].values.astype(bool), free["at_bound"].values.astype(bool)
    covariance = fit["correlation"].values * np.outer(scale, scale)
    between = covariance[np.ix_(loose, held)]
    known = between @ np.linalg.pinv(covariance[np.ix_(held, held)]) @ between.T
    conditional = covariance[np.ix_(loose, loose)] - known
    if not np.isfinite(conditional).all() or not loose.any():
        return []
    sizes, axes = np.linalg.eigh(conditional)
    normal = np.random.default_rng(0).standard_normal((_DRAWS, len(sizes)))
    moved = np.zeros((_DRAWS, len(value)))
    moved[:, loose] = normal * np.sqrt(np.maximum(sizes, 0.0)) @ axes.T
    drawn = np.clip(value * np.exp(moved), low, high) / value
    names = [str(one) for one in free["parameter"].values]
    return [_scaled(model, dict(zip(names, one, strict=True))) for one in drawn]


def _scaled(model: Model, factors: Mapping[str, float]) -> Model:
    """Return a model whose fitted parameters are multiplied by factors."""
    fields = zip(parameter_names(type(model.wall)), model.wall._fields, strict=True)
    wall = model.wall._replace(**{field: np.asarray(getattr(model.wall, field)) * factors[name]
                                  for name, field in fields if name in factors})  # fmt: skip
    beds = model.outlets
    if isinstance(beds, Bed):
        beds = beds.scaled(*(factors.get(name, 1.0) for name in bed_factors(type(beds))))
    viscosity = model.wall_viscosity * factors.get(WALL_VISCOSITY, 1.0)
    return model.changed(wall=wall, outlets=beds, wall_viscosity=viscosity)


def total_of(beds: Bed, name: str) -> float:
    """Return what `Bed.with_totals` would change."""
    if name == "R_T":
        return float(beds.total_resistance())
    share = beds.resistance_ratio() if "a" in beds.knobs() else 0.0
    return float(share) if name == "a" else float(np.median(beds.time_constants())) / (1.0 - share)


def drawn_about_fit(drawn: Sequence[tuple[Model, Mapping[str, list[float | None]]]]) -> dict[str, Any]:
    """Return models about a fit one by one: curves, and the values of the parameters that make them."""
    values: dict[str, list[float | None]] = {}
    for model, _ in drawn:
        for name, value in parameters_of(model).items():
            values.setdefault(name, []).append(number(value))
    curves = [{name: one[name] for name in BANDS} for _, one in drawn]
    return {"kind": "models drawn from the errors of the fit", "count": len(curves), "curves": curves, "values": values}


def posterior_draws(posterior: PosteriorResult) -> dict[str, Any]:
    """Return draws of a posterior one by one: the pressure that was simulated, and every unknown and quantity."""
    drawn, told = posterior.groups["posterior"], posterior.groups.get("posterior_predictive")
    count = drawn.sizes["chain"] * drawn.sizes["draw"]
    kept = np.unique(np.linspace(0, count - 1, min(count, _WALKED)).round().astype(int))
    values = {
        str(name): [number(one) for one in value.values.reshape(count)[kept]]
        for name, value in drawn.data_vars.items() if value.dims == ("chain", "draw")
    }  # fmt: skip
    curves: list[dict[str, Any]] = [{} for _ in kept]
    if told is not None and "simulated" in told:
        pressures = told["simulated"].values.reshape(count, -1)[kept]
        of = "flow" if "flow" in told else "pressure"
        curves = [{of: [number(one) for one in pressure]} for pressure in pressures]
    return {"kind": "draws of the posterior", "count": len(curves), "curves": curves, "values": values}


def parameters_of(model: Model) -> dict[str, float]:
    """Return what the sliders would show of a model."""
    named = zip(parameter_names(type(model.wall)), model.wall, strict=True)
    values = {name: float(np.median(value)) for name, value in named}
    beds = model.outlets
    return values | ({name: total_of(beds, name) for name in beds.knobs()} if isinstance(beds, Bed) else {})
