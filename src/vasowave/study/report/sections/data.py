"""The measurements, and what follows from them without a model."""

import numpy as np
import xarray as xr

from vasowave.study.cohort.cohort import Cohort
from vasowave.study.figures import measured as figures
from vasowave.study.figures.matplotlib_style import group_looks
from vasowave.study.figures.measured import ventricle_figure
from vasowave.study.report.blocks import Block, Drawing, Section
from vasowave.study.report.tables import data as tables
from vasowave.study.report.tables.cells import nearest
from vasowave.study.report.wording import number


def data_section(cohort: Cohort) -> Section:
    """Failures, measured waveforms and indices, networks, nominal parameters."""
    blocks: list[Block] = [
        *tables.failures(cohort),
        *tables.variables(cohort),
        Drawing("hemoData", _hemodynamics(cohort), figures.hemodynamics_figure(cohort)),
        tables.hemodynamics(cohort),
        Drawing("Network", "The network as a directed graph, with each vessel's share of the mean flow (eq. 11); width "
                "is the radius, lengths are not to scale.", figures.networks_figure(cohort)),
        *tables.networks(cohort),
        Drawing("parEst", "Nominal parameters: characteristic impedance Z_c from the slope of the pressure-flow loop "
                "(eq. 8), time constant τ from the diastolic decay (eq. 12).",
                figures.nominal_figure(cohort)),
        tables.nominal(cohort),
        tables.characteristic_impedances(cohort),
        *_ventricles(cohort),
    ]  # fmt: skip
    return Section("data", "Measurements and nominal parameters", blocks)


def _ventricles(cohort: Cohort) -> list[Block]:
    """Pressure and loop of the ventricle of the animals that are shown, where they have one."""
    looks = group_looks(cohort.groups)
    drawn: list[Block] = [
        Drawing(f"Ventricle-{place}", f"Pressure in the ventricle of {cohort.name(group)}, and its loop with "
                "the volume above that without pressure, by its elastance E_es and the measured flow. E_a: "
                f"end-systolic pressure over stroke volume. {_single_beat(result.ventricle)}",
                ventricle_figure(result.ventricle, looks[group].color))
        for place, (group, result) in enumerate(cohort.shown.items(), start=1)
        if result.ventricle is not None
    ]  # fmt: skip
    return drawn


def _single_beat(data: xr.Dataset) -> str:
    """Say what the single-beat method makes of the same beat."""
    ratio = float(data["single_beat"])
    method = "The single-beat method (a sine through the isovolumic parts)"
    return f"{method} finds no E_es/E_a." if np.isnan(ratio) else f"{method} makes E_es/E_a {number(ratio, 2)}."


def _hemodynamics(cohort: Cohort) -> str:
    subject = (
        "Measured pressure and flow from the foot of the pressure, impedance modulus |Z| and unwrapped phase θ (eq. 19)"
    )
    noise = "Grey circles: harmonics whose flow is near the noise."
    if cohort.single:
        return f"{subject}. {noise}"
    if cohort.shown_at:
        is_subset = len(figures.cells_drawn(cohort)) < len(cohort.cells)
        remark = f" Drawn are the recordings at {cohort.shown_at}." if is_subset else ""
        addition = "" if is_subset else ", with its other recordings"
        shown = f"Black: {nearest(cohort)}, which is shown below too{addition}.{remark}"
    else:
        shown = "Black: the animal nearest to the medians of its group, which is shown below too."
    return f"{subject} of every {'recording' if cohort.repeated else 'animal'}. {shown} {noise}"
