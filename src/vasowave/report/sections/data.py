"""The measurements, and what follows from them without a model."""

from vasowave.cohort.cohort import Cohort
from vasowave.figures import measured as figures
from vasowave.report.blocks import Block, Drawing, Section
from vasowave.report.tables import data as tables
from vasowave.report.tables.cells import nearest


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
    ]  # fmt: skip
    return Section("data", "Measurements and nominal parameters", blocks)


def _hemodynamics(cohort: Cohort) -> str:
    what = (
        "Measured pressure and flow from the foot of the pressure, impedance modulus |Z| and unwrapped phase θ (eq. 19)"
    )
    noise = "Grey circles: harmonics whose flow is near the noise."
    if cohort.single:
        return f"{what}. {noise}"
    if cohort.shown_at:
        few = len(figures.cells_drawn(cohort)) < len(cohort.cells)
        others = f" Drawn are the recordings at {cohort.shown_at}." if few else ""
        shown = (
            f"Black: {nearest(cohort)}, which is shown below too{'' if few else ', with its other recordings'}.{others}"
        )
    else:
        shown = "Black: the animal nearest to the medians of its group, which is shown below too."
    return f"{what} of every {'recording' if cohort.repeated else 'animal'}. {shown} {noise}"
