"""Recording and beats, nominal parameters, calibration and posterior as labelled data, every variable with its unit."""

import json
from collections.abc import Callable, Sequence
from dataclasses import asdict
from typing import Any

import numpy as np
import xarray as xr

from vasowave.base.findings import Finding, as_json
from vasowave.catheter.beats.rejection import cause
from vasowave.catheter.signals.raw import RawRecording
from vasowave.pulse.analysis.loops import mean_loop
from vasowave.pulse.analysis.ventricle_coupling import Coupling
from vasowave.pulse.analysis.ventricular_function import VentricularFunction
from vasowave.pulse.calibration.parameters import fitted_parameters
from vasowave.pulse.calibration.result import CalibratedModel
from vasowave.pulse.cycle.averaged import Beat, EnsembleAverage
from vasowave.pulse.cycle.cycle import Recording, resample
from vasowave.pulse.cycle.ventricular import VentricularPressure
from vasowave.pulse.inference.known_errors import SOURCES
from vasowave.pulse.inference.result import Posterior
from vasowave.pulse.model.laws import bed_quantities, identity, parameter_name, wall_parameters
from vasowave.pulse.model.names import joined
from vasowave.pulse.model.nominal import Nominal
from vasowave.pulse.model.walls import VISCOSITY, WALL_VISCOSITY
from vasowave.pulse.network.network import Network
from vasowave.pulse.quantities import QUANTITIES, lacking
from vasowave.study.animal.labelled import labelled, table_dataset
from vasowave.study.animal.law_result import PosteriorResult

EXCERPT_SECONDS = 6.0
"""Length of the stretch of raw signals that is kept for a figure, s."""

_LOOP_SAMPLES = 128  # of a loop that is kept for a figure
_STEADY_LOOPS = 30  # of the steady state, before the family, that are kept


def recording_dataset(recording: Recording) -> xr.Dataset:
    """Return measured pressure and flow on their own time axes, and the indices of Table 1."""
    flow_time = np.arange(len(recording.flow)) * (recording.period / len(recording.flow))
    measured = {
        "pressure": labelled("time", recording.pressure, "mmHg", "measured pressure"),
        "flow": labelled("flow_time", recording.flow, "ml/s", "measured flow"),
    }
    for name, unit in (("pressure", "mmHg"), ("flow", "ml/s")):
        if (error := getattr(recording, f"{name}_error")) is not None:
            words = f"standard error of the amplitude of each harmonic of the {name}, the mean first"
            measured[f"{name}_error"] = labelled(f"{name}_harmonic", error, unit, words)
    if recording.wedge_pressure:
        wedge = np.asarray(recording.wedge_pressure)
        measured["wedge_pressure"] = labelled((), wedge, "mmHg", "pressure behind the vascular beds")
    if recording.wedge_pulsation is not None:
        words = "what the pressure behind the vascular beds does about its mean"
        measured["wedge_pulsation"] = labelled("wedge_time", recording.wedge_pulsation, "mmHg", words)
    indices = {name: _quantity(name, value) for name, value in recording.indices().items()}
    return xr.Dataset(
        measured | indices,
        coords={
            "time": labelled("time", recording.time, "s", "time of the pressure samples"),
            "flow_time": labelled("flow_time", flow_time, "s", "time of the flow samples"),
        },
        attrs={
            "period": recording.period,
            "source": recording.source,
            "findings": as_json(recording.notes),
            "site": recording.site,
            **({"flow_delay_sd": recording.flow_delay_sd} if recording.flow_delay_sd else {}),
        },
    )


def ventricle_dataset(coupling: Coupling, recorded: VentricularPressure) -> xr.Dataset:
    """Return the pressure of a ventricle from where contraction begins, and what was fitted to it."""
    single = labelled((), np.asarray(coupling.single_beat), "1", "E_es/E_a by a sine through the isovolumic parts")
    return xr.Dataset(
        {
            "pressure": labelled("time", coupling.measured, "mmHg", "measured pressure in the ventricle"),
            "fitted_pressure": labelled("time", coupling.fitted, "mmHg", "pressure by elastance and flow"),
            "isovolumic_pressure": labelled(
                "time", coupling.isovolumic, "mmHg", "pressure if nothing left the ventricle"
            ),
            "volume": labelled("time", coupling.volume, "ml", "volume above that without pressure"),
            "stroke_volume": labelled((), np.asarray(coupling.stroke_volume), "ml", "stroke volume"),
            "filling_pressure": labelled(
                (), np.asarray(coupling.filling_pressure), "mmHg", "pressure before contraction"
            ),
            "single_beat": single,
        },
        coords={"time": labelled("time", coupling.time, "s", "time from where contraction begins")},
        attrs={"period": coupling.period, "source": recorded.source, "beats": recorded.beats},
    )


def loops_dataset(function: VentricularFunction) -> xr.Dataset:
    """Return the loops of the steady state and of the family, each at equal shares of its beat, and their corners."""
    before = [number for number in function.steady if number not in function.family]
    numbers = [*before[-_STEADY_LOOPS:], *function.family]
    loops = [function.loops[number] for number in numbers]
    zero = function.estimates["V_0"].value if "E_es" in function.estimates else None
    waves = np.array([mean_loop([loop], _LOOP_SAMPLES) for loop in loops])
    ends = np.array([loop.end_systole(zero) for loop in loops])
    chosen = {
        name: labelled("loop", np.isin(numbers, beats).astype(np.int8), "1", f"part of the {meaning}")
        for name, beats, meaning in (
            ("steady", function.steady, "steady state"),
            ("family", function.family, "family, whose preload falls"),
        )
    }
    return xr.Dataset(
        {
            "pressure": labelled(("loop", "sample"), waves[:, 0], "mmHg", "pressure, from an end of diastole on"),
            "volume": labelled(("loop", "sample"), waves[:, 1], "ml", "volume of the ventricle"),
            "end_systolic_pressure": labelled("loop", ends[:, 1], "mmHg", "pressure at the end of systole"),
            "end_systolic_volume": labelled("loop", ends[:, 0], "ml", "volume at the end of systole"),
            **chosen,
            **_end_systolic_line(function, -0.1 * waves[:, 1].max(), ends[:, 0].max()),
        },
        coords={"loop": labelled("loop", [loop.start for loop in loops], "s", "begin of the loop")},
        attrs={"source": function.source},
    )


def _end_systolic_line(
    function: VentricularFunction, smallest_volume: float, largest_volume: float
) -> dict[str, xr.Variable]:
    """Return both ends of the line of slope E_es, between two volumes, from V_0 on; nothing without a family."""
    if "E_es" not in function.estimates:
        return {}
    elastance, zero = (function.estimates[name].value for name in ("E_es", "V_0"))
    volume = np.array([max(zero, smallest_volume), largest_volume])
    return {
        "line_volume": labelled("line_end", volume, "ml", "volume at the ends of the end-systolic line"),
        "line_pressure": labelled("line_end", elastance * (volume - zero), "mmHg", "pressure there"),
    }


def nominal_dataset(nominal: Nominal, network: Network) -> xr.Dataset:
    """Return the nominal parameters and the samples behind Z_c and τ."""
    (flow, pressure), (time, falling) = nominal.upstroke, nominal.decay
    return xr.Dataset(
        {
            "Z_c": _quantity("Z_c", nominal.characteristic_impedance, "characteristic impedance (eq. 8)"),
            "beta": _quantity("beta", nominal.beta, "nominal stiffness (eq. 9)"),
            "R_T": _quantity("R_T", nominal.total_resistance, "nominal total resistance"),
            "tau": _quantity("tau", nominal.time_constant, "time constant of the diastolic decay (eq. 12)"),
            "upstroke_flow": labelled("upstroke", flow, "ml/s", "flow of the samples behind Z_c"),
            "upstroke_pressure": labelled("upstroke", pressure, "mmHg", "pressure of the samples behind Z_c"),
            "decay_time": labelled("decay", time, "s", "time of the samples behind tau"),
            "decay_pressure": labelled("decay", falling, "mmHg", "pressure of the samples behind tau"),
            **_outlets(nominal.outlets),
        },
        coords=_terminals(network),
    )


def calibration_dataset(fit: CalibratedModel) -> xr.Dataset:
    """Return everything a fit found but its simulation."""
    units = dict(fit.parameters["unit"])
    starts = table_dataset(fit.starts, "start", units).drop_vars("start", errors="ignore")
    starts = starts.rename({str(name): f"start_{name}" for name in starts.data_vars})
    parameters = table_dataset(fit.parameters.rename_axis("parameter").reset_index(), "parameter")
    correlation = xr.Dataset(
        {"correlation": (("free_parameter", "other_parameter"), fit.correlation.to_numpy(float), {"units": "1"})},
        coords={
            "free_parameter": np.array(fit.correlation.index, dtype=object),
            "other_parameter": np.array(fit.correlation.columns, dtype=object),
        },
    )
    fitted = fitted_parameters(type(fit.model.wall), type(fit.model.outlets), viscous=True)
    for name in ("symbol", "meaning"):
        texts = [getattr(fitted[parameter], name) for parameter in fit.parameters.index]
        parameters[name] = ("parameter", np.array(texts, dtype=object))
    datasets = [_fitted(fit), parameters, correlation, starts, harmonics_dataset(fit)]
    return xr.merge(datasets, combine_attrs="override", join="exact")


def _fitted(fit: CalibratedModel) -> xr.Dataset:
    """Return the model that was fitted, the numbers that sum it up, its residual, and what is said of its law."""
    wall, kind, law, compared = fit.model.wall, type(fit.model.wall), fit.model.wall.law(), fit.compared
    walls = {
        name: labelled("vessel", value, quantity.unit, quantity.meaning)
        for (name, quantity), value in zip(wall_parameters(kind).items(), wall, strict=True)
    }
    if np.any(fit.model.wall_viscosity):
        viscosity = np.broadcast_to(fit.model.wall_viscosity, len(fit.model.network))
        walls[WALL_VISCOSITY] = labelled("vessel", viscosity, VISCOSITY.unit, VISCOSITY.meaning)
    return xr.Dataset(
        {
            **joined(walls, _outlets(fit.model.outlets), scalars(fit)),
            f"{compared.what}_residual": labelled(
                "time", fit.residual / compared.scale, compared.unit, f"measured minus simulated {compared.what}"
            ),
        },
        coords={
            "vessel": np.array(fit.model.network.name, dtype=object),
            "time": labelled("time", fit.compared.time, "s", "time of the compared samples"),
            **_terminals(fit.model.network),
        },
        attrs={
            "wall": fit.wall,
            "enters": compared.enters,
            "law": identity(kind),
            "title": law.title,
            "formula": law.formula,
            "equation": law.equation,
            **_bed(type(fit.model.outlets)),
            "stiffness": law.stiffness if law.stiffness == "stiffness" else parameter_name(kind, law.stiffness),
            "findings": as_json(fit.findings),
            **_blood(fit),
        },
    )


def harmonics_dataset(fit: CalibratedModel) -> xr.Dataset:
    """Return what was compared, its error, residual and discrepancy by harmonic, mmHg, and which and why."""
    meanings = {
        "measured_modulus": f"modulus of the measured {fit.compared.what}",
        "measurement_error": "expected modulus of the error of the measurement",
        "residual_modulus": "modulus of the residual",
        "discrepancy": "modulus of the residual beyond the error of the measurement",
    }
    table = fit.harmonics
    variables = {name: labelled("harmonic", table[name].to_numpy(), "mmHg", text) for name, text in meanings.items()}
    compared = fit.compared
    variables["harmonics"] = labelled((), compared.harmonics, "1", "highest harmonic that was compared")
    variables["harmonics"].attrs |= {
        "choice": compared.choice,
        "with_signal": compared.errors.with_signal,
        "error_source": compared.errors.source,
    }
    return xr.Dataset(variables, coords={"harmonic": ("harmonic", table.index.to_numpy(), {"units": "1"})})


def scalars(fit: CalibratedModel) -> dict[str, xr.Variable]:
    """Return the numbers that sum up a fit: S, N, RMSE, R_T, and where its beds have them a, C_p."""
    shares = {"a": fit.resistance_ratio, "C_p": fit.peripheral_compliance}
    return {
        "S": _quantity("S", fit.S),
        "N": labelled((), fit.N, "1", "number of samples compared"),
        "mean_square": labelled((), fit.mean_square, "mmHg2", "S/N, mean square of the residual"),
        "RMSE": _quantity("RMSE", fit.rmse),
        "R_T": _quantity("R_T", fit.total_resistance),
        **{name: _quantity(name, value) for name, value in shares.items() if name not in lacking(fit.model.outlets)},
    }


def _terminals(network: Network) -> dict[str, Any]:
    return {"terminal": ("terminal", np.array([network.name[row] for row in network.terminals], dtype=object))}


def _quantity(name: str, value: float, meaning: str = "") -> xr.Variable:
    return labelled((), value, QUANTITIES[name].unit, meaning or QUANTITIES[name].meaning)


def _outlets(outlets: Any) -> dict[str, xr.Variable]:
    quantities = bed_quantities(type(outlets))
    return {
        name: labelled("terminal", value, quantity.unit, quantity.meaning)
        for (name, quantity), value in zip(quantities.items(), outlets, strict=True)
    }


def _bed(kind: Any) -> dict[str, str]:
    """Return what is stored of the kind of beds: by what it is found again, and what it is in words."""
    description = kind.bed()
    fitted = (
        f"{field} = {parameter_name(kind, factor)}·{field}⁰"
        for field, factor in zip(description.fitted or description.quantities, description.factors, strict=True)
    )
    return {
        "bed": identity(kind),
        "bed_title": description.title,
        "bed_formula": description.formula,
        "bed_equation": description.equation,
        "bed_factors": ", ".join(fitted),
    }


def _blood(fit: CalibratedModel) -> dict[str, Any]:
    blood = fit.model.blood
    friction = {"law": type(blood.friction).__name__, **asdict(blood.friction)}  # type: ignore[call-overload]
    return {
        "blood_density_g_per_ml": blood.density,
        "blood_viscosity_cm2_per_s": blood.viscosity,
        "friction": json.dumps(friction),
    }


def beats_dataset(average: EnsembleAverage, raw: RawRecording | None) -> xr.Dataset:
    """Return onset, length, level and fate of every beat, and an excerpt of the signals around the averaged ones."""
    beats, baseline = average.beats, average.baseline
    indices = np.searchsorted(baseline.time, [beat.start for beat in beats])  # others are beside what is read
    variables = {
        "onset": labelled("beat", [beat.start for beat in beats], "s", "start of the beat"),
        "length": labelled("beat", [beat.end - beat.start for beat in beats], "s", "length of the beat"),
        "kept": labelled(
            "beat", np.array([beat.averaged for beat in beats], dtype=np.int8), "1", "part of the average"
        ),
        "reason": _rejection_texts(beats, str, "why it was rejected"),
        "cause": _rejection_texts(beats, cause, "the same in one word"),
        "level": labelled("beat", baseline.level[indices], "mmHg", "diastolic level of the beat"),
        "drift": labelled(
            "beat", baseline.trend[indices], "mmHg", "drift of the level since the zero of the transducer"
        ),
        "delay": labelled((), average.delay, "s", "flow behind pressure (p-q delay)"),
    }
    done = {
        "fiducial": average.fiducial,
        "delay_corrected": int(average.delay_corrected),
        "drift_size": baseline.size,
        "drift_error": baseline.error,
        "drift_removed": int(baseline.removed),
    }
    dataset = xr.Dataset(variables, attrs=done)
    return dataset if raw is None else dataset.merge(_excerpt(average, raw))


def recording_with_scatter(recording: Recording, average: EnsembleAverage | None) -> xr.Dataset:
    """Return the recording, with the standard deviation of the averaged beats where there are any."""
    dataset = recording_dataset(recording)
    if average is None:
        return dataset
    for name, dim, unit in (("pressure", "time", "mmHg"), ("flow", "flow_time", "ml/s")):
        words = f"standard deviation of the {name} of the averaged beats"
        deviation = resample(getattr(average, f"{name}_sd"), dataset.sizes[dim])  # the paper's practice has others
        dataset[f"{name}_sd"] = labelled(dim, np.maximum(deviation, 0.0), unit, words)
    return dataset


def _excerpt(average: EnsembleAverage, raw: RawRecording) -> xr.Dataset:
    """Return the signals from the first averaged beat on, or as near as the recording's end allows."""
    used = [beat for beat in average.beats if beat.averaged]
    count = min(len(raw.pressure), round(EXCERPT_SECONDS * raw.sampling_rate))
    middle = (0.5 * (used[0].start + used[-1].end) - raw.origin) * raw.sampling_rate
    first = int(np.clip(middle - count / 2, 0, len(raw.pressure) - count))
    window = slice(first, first + count)
    traces = {
        "trace_pressure": labelled("trace_time", raw.pressure[window], "mmHg", "pressure as recorded"),
        "trace_flow": labelled("trace_time", raw.flow[window], "ml/s", "flow as recorded"),
    }
    if raw.ecg is not None:
        traces["trace_ecg"] = labelled("trace_time", raw.ecg[window], "mV", "ECG as recorded")
    return xr.Dataset(traces, coords={"trace_time": labelled("trace_time", raw.time[window], "s", "time")})


def _rejection_texts(beats: Sequence[Beat], text: Callable[[Finding], str], meaning: str) -> xr.Variable:
    words = [text(beat.rejected) if beat.rejected else "" for beat in beats]
    return xr.Variable("beat", np.array(words, dtype=object), {"long_name": meaning})


def posterior_result(drawn: Posterior) -> PosteriorResult:
    """Return a posterior as it is stored.

    The table has, by ``quantity``, ``median, interval_low, interval_high, prior_low, prior_high, contraction`` and the
    shares of the variance, ``share_recording, share_probe, share_calibration, share_image, share_model, share_prior``,
    how well each ``block`` of harmonics is predicted by the others (``left_out``, ``left_out_k_hat``), and the
    diagnostics. Its attributes say whether it is ``trusted``, and the ``findings`` with their numbers (JSON).
    """
    summary = drawn.summary.rename(columns={name: f"share_{name}" for name in SOURCES})
    table = table_dataset(summary.rename_axis("quantity").reset_index(), "quantity")
    blocks = drawn.left_out
    table = table.assign_coords(block=blocks.index.to_numpy(object))
    table["left_out"] = ("block", blocks["log_density"].to_numpy(), {"units": "1"})
    table["left_out_k_hat"] = ("block", blocks["k_hat"].to_numpy(), {"units": "1"})
    for name, value in drawn.diagnostics._asdict().items():
        table[name] = ((), float(value), {"units": "1"})
    table.attrs = {"trusted": int(drawn.diagnostics.trusted), "findings": as_json(drawn.findings)}
    groups = {str(name): node.to_dataset() for name, node in drawn.data.children.items()}
    for group in groups.values():  # netCDF holds no Boolean attributes
        attrs = group.attrs.items()
        group.attrs = {key: int(value) if isinstance(value, bool | np.bool_) else value for key, value in attrs}
    return PosteriorResult(table, groups)
