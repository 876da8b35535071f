"""From stored results back to the model that was fitted: it can be simulated, changed and swept again."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from vasowave.base.errors import InputError, VasowaveError, did_you_mean
from vasowave.base.findings import from_json
from vasowave.base.settings import given_values
from vasowave.base.stores import parsed
from vasowave.pulse.analysis.uncertain import UncertainModel
from vasowave.pulse.calibration.fitting import for_fits
from vasowave.pulse.cycle.cycle import MIN_SAMPLES, Inflow, Recording, resample
from vasowave.pulse.cycle.observation import NUMBERS, Observation
from vasowave.pulse.inference.measurements import ExpectedPrecision, expected_precision
from vasowave.pulse.inference.sampling import Sampling, problem_of
from vasowave.pulse.model.blood import FRICTIONS, Blood
from vasowave.pulse.model.law_files import looking_in, plain
from vasowave.pulse.model.laws import bed_quantities, find_bed, find_law, parameter_names
from vasowave.pulse.model.model import Model
from vasowave.pulse.model.numerics import Numerics
from vasowave.pulse.model.outlets import Outlets
from vasowave.pulse.model.walls import WALL_VISCOSITY
from vasowave.study.animal.animal import Settings
from vasowave.study.animal.law_result import LawResult
from vasowave.study.animal.result import AnimalResult


def stored_recording(result: AnimalResult) -> Recording:
    """Return the averaged cycle of an animal's stored results, with its notes and the errors of its harmonics."""
    data = result.recording
    stored: dict[str, Any] = {
        name: data[name].values for name in ("pressure_error", "flow_error", "wedge_pulsation") if name in data
    }
    stored |= {name: data.attrs[name] for name in ("site", "flow_delay_sd") if name in data.attrs}
    return Recording(data["pressure"].values, data["flow"].values, float(data.attrs["period"]), data.attrs["source"],
                     from_json(data.attrs["findings"]), **stored,
                     wedge_pressure=float(data.get("wedge_pressure", 0.0)))  # fmt: skip


def stored_inflow(result: AnimalResult, wall: str | type = "") -> Recording | Inflow:
    """Return what enters the model that was fitted: the recording's flow, or what a pressure that entered lets in."""
    law = result.laws[stored_law(result, wall)[0]]
    if law.compared == "pressure":
        return stored_recording(result)
    return Inflow(law.simulated("flow", result.root).values, float(result.recording.attrs["period"]))


def stored_sites(result: AnimalResult) -> tuple[Observation, ...]:
    """Return what was observed elsewhere of an animal's stored results, in the harmonics that its fits compared."""
    data = next((law.sites for law in result.laws.values() if law.sites is not None), None)
    if data is None:
        return ()
    observations = []
    for row in range(data.sizes["site"]):
        site = {name: variable.values[row] for name, variable in data.data_vars.items() if variable.dims[0] == "site"}
        numbers: dict[str, Any] = {name: float(site[name]) for name in NUMBERS if np.isfinite(site[name])}
        wave: dict[str, Any] = (
            {} if numbers else {"waveform": resample(site["measured"], max(len(site["measured"]), MIN_SAMPLES))}
        )
        errors: dict[str, Any] = {name: float(site[name]) for name in ("error", "place", "zero_sd", "gain_sd")}
        observations.append(Observation(str(site["observed"]), str(site["vessel"]), **errors, **numbers, **wave))
    return tuple(observations)


@looking_in(Path())  # what results name was typed by nobody
def stored_settings(result: AnimalResult) -> Settings:
    """Return the settings that an animal was analyzed with."""
    data = dict(result.settings)
    return Settings(**data | {"blood": _blood(data["blood"]), "numerics": Numerics(**data["numerics"])})


def _blood(data: Mapping[str, Any]) -> Blood:
    friction = dict(data["friction"])
    kind = {friction_class.__name__: friction_class for friction_class in FRICTIONS.values()}[friction.pop("law")]
    return Blood(float(data["density"]), float(data["viscosity"]), kind(**friction))


@looking_in(Path())
def stored_law(result: AnimalResult, wall: str | type = "") -> tuple[str, Any]:
    """Return the name under which a law that was fitted is stored, and its class.

    Parameters
    ----------
    result : AnimalResult
    wall : str or class
        Name of the law; of one of a user's own also ``our_laws:Class`` or the class. By default the first law.

    Raises
    ------
    InputError
        The results hold no fit with this law, or the law itself is not here.
    """
    stored = {name: str(law.calibration.attrs["law"]) for name, law in result.laws.items()}
    requested_law: Any = wall or next(iter(stored), "")
    text = requested_law if isinstance(requested_law, str) else requested_law.law().name
    name = next((name for name, law in stored.items() if text in (name, law, plain(law))), None)
    if name is None:
        hint, stored_names = did_you_mean(text, stored), ", ".join(stored) or "none"
        raise InputError(f"no fit with the wall law '{text}'{hint}; there are: {stored_names}")
    return name, find_law(stored[name] if isinstance(requested_law, str) else requested_law)


@looking_in(Path())
def stored_model(result: AnimalResult, wall: str | type = "") -> Model:
    """Return the model that was fitted to an animal, to the last bit.

    Parameters
    ----------
    result : AnimalResult
    wall : str or class
        The wall law, see `stored_law`; by default the first that was fitted.

    Raises
    ------
    InputError
        The results hold no fit with this law, or the law, one of a user's own, is not here.

    Examples
    --------
    >>> import vasowave as vw
    >>> mouse = vw.Animal("mouse 6", "CTL", vw.control_network(), vw.virtual_mouse(), synthetic=True)
    >>> result = vw.analyze(mouse, vw.Settings(walls=("linear",), starts=1))
    >>> vw.stored_model(result)
    Model(LinearWall(beta ...), Windkessel, Network(21 vessels, ...))
    """
    name, law = stored_law(result, wall)
    data = result.laws[name].calibration
    blood = _blood(
        {
            "density": data.attrs["blood_density_g_per_ml"],
            "viscosity": data.attrs["blood_viscosity_cm2_per_s"],
            "friction": parsed(data.attrs["friction"]),
        }
    )
    bed = find_bed(str(data.attrs["bed"]))
    outlets = _beds(bed, data)
    wall, cycle = law(*(data[name].values for name in parameter_names(law))), stored_recording(result)
    viscosity = data[WALL_VISCOSITY].values if WALL_VISCOSITY in data else 0.0
    return Model(result.network, wall, outlets, blood, cycle.wedge_pressure, wall_viscosity=viscosity,
                 outlet_pulsation=cycle.wedge_pulsation)  # fmt: skip


def stored_fit(result: AnimalResult, wall: str | type = "") -> UncertainModel:
    """Return a fit of stored results with what its data leave open, for `predict`, `rank_stenoses` and `emulate`.

    Parameters
    ----------
    result : AnimalResult
    wall : str or class
        The wall law, see `stored_law`; by default the first that was fitted.

    Returns
    -------
    UncertainModel
        With the draws of its posterior, where the results hold one that may be believed and the flow entered the model.

    Raises
    ------
    InputError
        As `stored_model`.

    Examples
    --------
    >>> import vasowave as vw
    >>> mouse = vw.Animal("mouse 6", "CTL", vw.control_network(), vw.virtual_mouse(), synthetic=True)
    >>> result = vw.analyze(mouse, vw.Settings(walls=("linear",), starts=1))
    >>> list(vw.stored_fit(result).free.index)
    ['beta', 'r1', 'r2', 'c1']
    """
    model, cycle = stored_model(result, wall), stored_recording(result)
    law = result.laws[stored_law(result, wall)[0]]
    data = law.calibration
    inflow = Inflow(law.simulated("flow", result.root).values, cycle.period)
    columns = {name: data[name].values for name in data.data_vars if data[name].dims == ("parameter",)}
    names = [str(name) for name in data["free_parameter"].values]
    parameters = pd.DataFrame(columns, [str(name) for name in data["parameter"].values])
    correlation = pd.DataFrame(data["correlation"].values, names, names)
    beds, drawn = _beds(type(model.outlets), result.nominal), _posterior_models(result, law, type(model.wall))
    if drawn:
        assert law.posterior is not None
        sampled = [name for name in names if name in law.posterior.table["quantity"].values]
        for end in ("interval_low", "interval_high"):
            parameters.loc[sampled, end] = law.posterior.table[end].sel(quantity=sampled).values
    return UncertainModel(model, inflow, parameters, correlation, beds, drawn, stored_numerics(result, wall))


def stored_numerics(result: AnimalResult, wall: str | type = "") -> Numerics:
    """Return how finely the fit of a law was simulated."""
    samples = result.laws[stored_law(result, wall)[0]].simulation.sizes["time"]
    return for_fits(stored_settings(result).numerics, samples)


def stored_sampling(result: AnimalResult, wall: type) -> dict[str, Any]:
    """Return how the posterior of an animal is drawn, the settings of `posterior` by name."""
    settings = stored_settings(result)
    priors = settings.priors.allowing_for(stored_recording(result))
    return {"bed": settings.beds, "blood": settings.blood, "search": settings.search(wall), "priors": priors,
            "numerics": settings.numerics, "sites": stored_sites(result)}  # fmt: skip


def stored_precision(
    result: AnimalResult, wall: str | type = "", vessels: Sequence[str] | None = None
) -> ExpectedPrecision:
    """Return what further measurements of an animal would add to its stored fit, see `expected_precision`."""
    (name, law), cycle = stored_law(result, wall), stored_recording(result)
    calibration = result.laws[name].calibration
    values = dict(zip(calibration["parameter"].values, calibration["value"].values.tolist(), strict=True))
    arguments = stored_sampling(result, law)
    return expected_precision(result.network, cycle, law, vessels=vessels, start=values, **arguments)


def _beds(bed: Any, data: Any) -> Outlets:
    return bed(*(data[name].values for name in bed_quantities(bed)))


def _posterior_models(result: AnimalResult, law: LawResult, wall: type) -> tuple[tuple[Model, Inflow], ...]:
    """Return the models of a posterior's draws, each with the flow as it would have been recorded without errors.

    Errors of single vessels are drawn as the image has them: of these many the recording sees few directions.
    """
    if law.posterior is None or not law.posterior.trusted or law.compared == "flow":
        return ()
    sampling = given_values(Sampling, None, stored_sampling(result, wall))
    unknowns = problem_of(result.network, stored_recording(result), wall, sampling).unknowns
    columns = {name: law.posterior.draws(str(name)).ravel() for name in unknowns.all}
    pairs, rng = [], np.random.default_rng(0)
    for row in range(len(next(iter(columns.values())))):
        own_errors = (sd * rng.standard_normal(len(sd)) for sd in unknowns.own_errors)
        scores = unknowns.scores({name: draws[row] for name, draws in columns.items()})
        try:
            model, recorded = unknowns.posed(scores, *own_errors)
        except VasowaveError:
            continue
        pairs.append((model, recorded.inflow))
    return tuple(pairs)
