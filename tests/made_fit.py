"""A fit made from smooth formulas, to test what is written and drawn; no simulation and no optimization behind it."""

import numpy as np
import pandas as pd
import xarray as xr

from vasowave.pulse.calibration import UNDETERMINED, CalibratedModel, compared_part
from vasowave.pulse.cycle import Recording, resample
from vasowave.pulse.examples import control_network
from vasowave.pulse.model import Model, Windkessel, area, estimate_nominal, find_law, wave_speed

PERIOD = 0.11
PARAMETERS = {
    "linear": {"beta": 57.3, "r1": 0.55, "r2": 0.95, "c1": 1.2},
    "tangent": {"p1": 9.1, "gamma": 1.6, "r1": 0.4, "r2": 1.02, "c1": 1.1},
    "power": {"beta": 49.0, "m": 1.7, "r1": 0.45, "r2": 1.0, "c1": 1.15},
}


def made_recording(source="synthetic: made from formulas", count=128):
    time = np.arange(count) * (PERIOD / count)
    ejection = 0.045
    flow = np.where(time < ejection, 0.75 * np.sin(np.pi * time / ejection) ** 2, 0.0) + 0.012
    resistance, compliance, impedance = 75.0, 1.4e-3, 12.0
    harmonics = np.arange(count // 2 + 1)
    Z = impedance + resistance / (1 + 2j * np.pi * harmonics / PERIOD * resistance * compliance)
    return Recording(np.fft.irfft(np.fft.rfft(flow) * Z, count), flow, PERIOD, source)


def made_fit(
    wall="linear", source="synthetic: made from formulas", count=128, recording=None, network=None, factor=1.0
):
    recording, network = recording or made_recording(source, count), network or control_network()
    nominal = estimate_nominal(network, recording)
    values = PARAMETERS[wall] | {
        name: factor * PARAMETERS[wall][name] for name in ("beta", "p1") if name in PARAMETERS[wall]
    }
    law = find_law(wall)(*list(values.values())[:-3])
    R1, R2, C = nominal.outlets
    model = Model(network, law, Windkessel(values["r1"] * R1, values["r2"] * R2, values["c1"] * C))
    simulation = made_simulation(model, recording, 0.25 if wall == "linear" else 0.15)
    whole = compared_part(recording, "all")
    inlet = simulation["pressure"].sel(vessel="1", station="inlet").to_numpy()
    residual = whole.measured - resample(inlet, whole.samples)
    names = list(values)
    correlation = pd.DataFrame(0.3 + 0.7 * np.eye(len(names)), index=names, columns=names)
    return CalibratedModel(
        wall, model, whole, nominal, made_parameters(values), correlation, made_starts(values, wall), simulation,
        residual, float(np.sum(residual**2)),
        (UNDETERMINED(parameter="r1", low=0.5, high=2.5),) if wall == "tangent" else (),
    )  # fmt: skip


def made_parameters(values):
    rows = {}
    for name, value in values.items():
        rows[name] = {
            "unit": "mmHg" if name in ("beta", "p1") else "1", "nominal": 0.8 * value, "lower": 0.1 * value,
            "upper": 2.5 * value, "value": value, "standard_error": 0.04 * value,
            "standard_error_correlated": 0.3 * value,
            "interval_low": 0.5 * value, "interval_high": 2.0 * value, "at_bound": False, "free": True,
            "determined": name != "r1",
        }  # fmt: skip
    return pd.DataFrame.from_dict(rows, orient="index").rename_axis("parameter")


def made_starts(values, wall):
    rows = []
    for start in range(4):
        rows.append({
            "start": start, "S [mmHg2]": 149.2 + (5.1 if start == 3 and wall == "tangent" else 1e-7 * start),
            "simulations": 61 + start, "converged": True, "agrees": not (start == 3 and wall == "tangent"),
            "message": "the step is below the tolerance", **values,
        })  # fmt: skip
    return pd.DataFrame(rows)


def made_simulation(model, recording, misfit):
    """Delay and spread the measured cycle along the tree; the area follows from the wall law."""
    network = model.network
    time, count = recording.time, len(recording.pressure)
    distance = np.zeros(len(network))
    for rows in network.generations[1:]:
        distance[rows] = distance[network.parent[rows]] + network.length[network.parent[rows]]
    omega = 2 * np.pi * np.arange(count // 2 + 1) / recording.period
    wave = misfit * np.sin(2 * np.pi * 3 * time / recording.period)
    pressure = np.empty((count, len(network), 3))
    flow = np.empty_like(pressure)
    for row in range(len(network)):
        for station, share in enumerate((0.0, 0.5, 1.0)):
            x = distance[row] + share * network.length[row]
            shift = np.exp(-1j * omega * x / 200.0 - (omega * 0.0008 * x) ** 2)
            p = np.fft.irfft(np.fft.rfft(recording.pressure - wave) * shift, count)
            pressure[:, row, station] = p - 0.3 * x
            flow[:, row, station] = network.flow_fraction[row] * np.fft.irfft(
                np.fft.rfft(recording.flow) * shift, count
            )
    wide = np.moveaxis(pressure, 1, 2)
    A = np.moveaxis(area(model.wall, wide, model.area0), 2, 1)
    c = np.moveaxis(wave_speed(model.wall, wide, model.blood.inertia), 2, 1)
    columns = {
        "pressure": (pressure, "mmHg", "transmural pressure"), "flow": (flow, "ml/s", "flow"),
        "area": (A, "cm2", "cross-sectional area"), "velocity": (flow / A, "cm/s", "mean velocity"),
        "wave_speed": (c, "cm/s", "pulse wave velocity"),
    }  # fmt: skip
    dims = ("time", "vessel", "station")
    return xr.Dataset(
        {key: (dims, value, {"units": unit, "long_name": name}) for key, (value, unit, name) in columns.items()},
        coords={
            "time": ("time", time, {"units": "s", "long_name": "time"}),
            "vessel": list(network.name), "station": ["inlet", "middle", "outlet"],
        },
        attrs={
            "period": recording.period, "cycles": 7, "change": 3.2e-9, "courant": 0.61, "steps_per_cycle": 2048,
            "cell_size": 0.1, "tolerance": 1e-4, "converged": 1,
        },
    )  # fmt: skip
