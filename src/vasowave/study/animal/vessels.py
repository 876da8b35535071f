"""Changes along the tree of a calibrated model, vessel by vessel, as labelled data."""

from dataclasses import replace

import numpy as np
import xarray as xr

from vasowave.pulse.analysis.compliances import compliance
from vasowave.pulse.analysis.shear import vessel_loads
from vasowave.pulse.analysis.tree import pressure_drop, wave_speeds
from vasowave.pulse.analysis.uncertain_loads import LEAST_DRAWS, load_intervals
from vasowave.pulse.calibration.result import CalibratedModel
from vasowave.pulse.model import walls
from vasowave.pulse.quantities import QUANTITIES, network_sums
from vasowave.study.animal.labelled import labelled, table_dataset
from vasowave.study.animal.law_result import LawResult
from vasowave.study.animal.quantities import quantities_dataset
from vasowave.study.animal.result import AnimalResult
from vasowave.study.animal.stored import stored_fit

_PRESSURE_RATIO, _CURVE_POINTS = 1.05, 101  # how far the curve of the law is drawn, of the highest pressure; its points


def vessels_dataset(fit: CalibratedModel) -> xr.Dataset:
    """Return wave speed at mean pressure, compliance at diastolic pressure (eqs. 25 to 33), pressure drops, and loads.

    Pressures are those at the middle of each vessel.
    """
    network = fit.model.network
    pressure = fit.simulation["pressure"]
    middle = pressure.sel(station="middle").to_numpy()
    mean, diastolic = middle.mean(axis=0), middle.min(axis=0)
    at_diastole = compliance(fit.model, diastolic)
    ends = pressure.sel(station="outlet").to_numpy()[:, network.terminals]
    inlet = pressure.sel(station="inlet").to_numpy()[:, network.root]
    speeds = _renamed(table_dataset(wave_speeds(fit.model, mean).reset_index(), "vessel"))
    drops = _renamed(table_dataset(pressure_drop(network, inlet, ends).reset_index(), "terminal"))
    drops = drops.rename({"distance": "terminal_distance"})
    per = "vessel"
    vessel_values = {
        "mean_pressure": labelled(per, mean, "mmHg", "mean pressure at the middle of the vessel"),
        "diastolic_pressure": labelled(per, diastolic, "mmHg", "diastolic pressure at the middle of the vessel"),
        "compliance": labelled(per, at_diastole.vessel, "ml/mmHg", "volume compliance at diastolic pressure (eq. 25)"),
    }
    loads = _renamed(table_dataset(vessel_loads(fit.model, fit.simulation).reset_index(), "vessel"))
    dataset = xr.merge([speeds.assign(vessel_values), drops, loads], combine_attrs="override", join="exact")
    sums = quantities_dataset(network_sums(at_diastole), QUANTITIES)
    return dataset.merge(sums).merge(_law_curve(fit))


def with_load_intervals(result: AnimalResult, law: LawResult) -> LawResult:
    """Return a wall law's results with 95 % intervals of the loads of vessels, if its posterior has draws for them."""
    stored = stored_fit(result, law.name)
    if len(stored.drawn) < LEAST_DRAWS:
        return law
    intervals = _renamed(table_dataset(load_intervals(stored).reset_index(), "vessel"))
    return replace(law, vessels=law.vessels.merge(intervals))


def _law_curve(fit: CalibratedModel) -> xr.Dataset:
    """Return the wall law of the root vessel as a curve, from zero pressure to above the highest that is met."""
    network = fit.model.network
    root = network.root
    wall = type(fit.model.wall)(*(value[root] for value in fit.model.wall))
    highest = float(fit.simulation["pressure"].isel(vessel=root).max())
    pressure = np.linspace(0.0, max(_PRESSURE_RATIO * highest, 1.0), _CURVE_POINTS)
    area = np.asarray(walls.area(wall, pressure, fit.model.area0[root]))
    return xr.Dataset(
        {
            "law_pressure": labelled("law_point", pressure, "mmHg", "pressure along the wall law"),
            "law_area": labelled("law_point", area, "cm2", "area of the root vessel at that pressure"),
        }
    )


def _renamed(dataset: xr.Dataset) -> xr.Dataset:
    """Return the dataset with names in one word, "wave speed" as ``wave_speed``, and that text as meaning."""
    for name in dataset.data_vars:
        dataset[name].attrs.setdefault("long_name", str(name))
        dataset[name].attrs.setdefault("units", "1")
    return dataset.rename({name: str(name).replace(" ", "_") for name in dataset.data_vars})
