"""The measurements, and what follows from them without a model: figures, and tables of animals, indices, networks."""

from collections import Counter
from collections.abc import Sequence

import numpy as np
import pandas as pd
import xarray as xr

from vasowave.base.io.columns import split_unit
from vasowave.pulse.quantities import INDICES
from vasowave.study.animal.result import AnimalResult
from vasowave.study.cohort.cohort import Cohort
from vasowave.study.cohort.table import columns, describe
from vasowave.study.cohort.unused import Role, role_of
from vasowave.study.cohort.variables import Variable
from vasowave.study.figures import measured as figures
from vasowave.study.figures.loops import loops_figure
from vasowave.study.figures.matplotlib_style import group_looks
from vasowave.study.figures.measured import ventricle_figure
from vasowave.study.report.blocks import Block, Drawing, Section, Table
from vasowave.study.report.wording import (
    Row,
    also_read,
    animal_cells,
    mean_sd,
    named,
    nearest,
    number,
    span,
    symbols,
    with_error,
    with_unit,
)


def data_section(cohort: Cohort) -> Section:
    """Failures, measured waveforms and indices, networks, nominal parameters."""
    blocks: list[Block] = [
        *failures(cohort),
        *variables(cohort),
        Drawing("hemoData", _hemodynamics(cohort), figures.hemodynamics_figure(cohort)),
        hemodynamics(cohort),
        Drawing("Network", "The network as a directed graph, with each vessel's share of the mean flow (eq. 11); width "
                "is the radius, lengths are not to scale.", figures.networks_figure(cohort)),
        *networks(cohort),
        Drawing("parEst", "Nominal parameters: characteristic impedance Z_c from the slope of the pressure-flow loop "
                "(eq. 8), time constant τ from the diastolic decay (eq. 12).",
                figures.nominal_figure(cohort)),
        nominal(cohort),
        characteristic_impedances(cohort),
        *_ventricles(cohort),
        *_loops(cohort),
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


def _loops(cohort: Cohort) -> list[Block]:
    """Loops of an animal of each group that has them, where it can be the one that is shown."""
    looks = group_looks(cohort.groups)
    drawn: list[Block] = []
    for place, (group, shown) in enumerate(cohort.shown.items(), start=1):
        of_group = [shown, *(result for result in cohort.results if result.group == group)]
        result = next((result for result in of_group if result.loops is not None), None)
        if result is not None and result.loops is not None:
            whose = "" if cohort.single else f" of {result.name}, {group}"
            caption = f"Loops of pressure and volume in a ventricle{whose}. {_OF_LOOPS}"
            drawn.append(Drawing(f"Loops-{place}", caption, loops_figure(result.loops, looks[group].color)))
    return drawn


def _single_beat(data: xr.Dataset) -> str:
    """Say what the single-beat method makes of the same beat."""
    ratio = float(data["single_beat"])
    method = "The single-beat method (a sine through the isovolumic parts)"
    return f"{method} finds no E_es/E_a." if np.isnan(ratio) else f"{method} makes E_es/E_a {number(ratio, 2)}."


_OF_LOOPS = (
    "Black: the steady state; grey: beats whose preload falls. E_es: the line through the ends of systole, where the "
    "preload falls far enough for one."
)


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


_FIRST = ("HR", "mPAP", "CO", "PVR")
_NOMINAL = {"Z_c": "Z_c", "beta": "β₀", "R_T": "R_T0", "tau": "τ₀"}


def hemodynamics(cohort: Cohort) -> Table:
    """Mean ± SD of the measured indices ("HemoStats")."""
    rows = cohort.described[cohort.described["source"] == "measured"]
    data = describe(rows, columns(rows, INDICES))
    groups = [f"{cell} ({cohort.count(cell)})" for cell in cohort.cells]
    header = ("index", *(["measured"] if cohort.single else groups))
    meanings = cohort.meanings
    note = "; ".join(f"{name}: {meanings[name]}" for name in INDICES if name in meanings and name != "PVR")
    caption = "Hemodynamic indices" if cohort.single else "Hemodynamic indices, mean ± SD"
    return Table("HemoStats", caption, header, _means(cohort, data), f"{note}. {outflow(cohort)}", data)


def wedge_pressures(cohort: Cohort) -> list[float]:
    """Return the wedge pressures of the recordings that have one, mmHg."""
    recordings = [result.recording for result in cohort.results]
    return [float(recording["wedge_pressure"]) for recording in recordings if "wedge_pressure" in recording]


def outflow(cohort: Cohort) -> str:
    """Say over what pressure behind the beds the resistance is computed."""
    pressures, count = wedge_pressures(cohort), len(cohort.results)
    if not pressures:
        return (
            "PVR: mean pressure above 0 mmHg, assumed for want of a wedge pressure, over mean flow; above a wedge "
            "pressure PVR, R_T and the measured decay are smaller, and their ratios between groups change."
        )
    scope = f"; in {count - len(pressures)} of {count} recordings over 0 mmHg" if len(pressures) < count else ""
    return f"PVR: mean pressure above the wedge pressure ({span(np.array(pressures))} mmHg{scope}) over mean flow."


def _means(cohort: Cohort, data: pd.DataFrame) -> list[Row]:
    """Return a row for each quantity of `describe`: its symbol, and mean ± SD of every group, in the header's order."""
    texts = {(row["quantity"], row["group"]): _mean(row) for _, row in data.iterrows()}
    written = symbols(cohort)
    return [
        (with_unit(label, written), *(texts.get((label, cell), "–") for cell in cohort.cells))
        for label in data["quantity"].unique()
    ]


def _mean(row: pd.Series) -> str:
    """Return mean ± SD, and in brackets in further units that people read."""
    further = [f" ({mean_sd(row, factor)} {unit})" for unit, factor in also_read(split_unit(row["quantity"])[1])]
    return "".join([mean_sd(row), *further])


def animals_table(cohort: Cohort) -> list[Table]:
    """The animals of each group in a few rows ("Animals"): what the lab says of them, and what was measured."""
    if cohort.single:
        return []
    rows = cohort.described[cohort.described["source"] == "measured"]
    data = describe(rows, columns(rows, _FIRST))
    shown = [variable for variable in cohort.variables.values()
             if role_of(variable.name) is Role.COVARIATE and variable.kind != "date"]  # fmt: skip
    first = [
        (variable.label, *(_summary(variable, cell.results) for cell in cohort.cells.values())) for variable in shown
    ]
    header = ("mean ± SD", *(f"{cell} ({cohort.count(cell)})" for cell in cohort.cells))
    plain = cohort.design.plain
    means = "geometric ones" if plain else "geometric means by the design, which adjusts them"
    note = f"Arithmetic means{'' if plain else ' as measured'}; the answer compares {means}. {outflow(cohort)}"
    return [Table("Animals", "Table 1. The animals", header, [*first, *_means(cohort, data)], note, data)]


def _summary(variable: Variable, results: Sequence[AnimalResult]) -> str:
    """Return mean ± SD of numbers, or how many have each level."""
    if variable.kind == "category":
        levels = Counter(variable.levels[result.name] for result in results if result.name in variable.levels)
        return ", ".join(f"{count} {level}" for level, count in levels.items()) or "–"
    values = np.array([variable.numbers[result.name] for result in results if result.name in variable.numbers])
    if not len(values):
        return "–"
    return with_error(float(values.mean()), float(values.std(ddof=1)) if len(values) > 1 else np.nan)


def failures(cohort: Cohort) -> list[Table]:
    """Everything that failed ("Failures"), if anything did."""
    if not cohort.failures:
        return []
    measured = {result.name: float(result.measured.quantities["mPAP"]) for result in cohort.results}
    data = pd.DataFrame(
        {
            "animal": failure.animal, "group": failure.group, "law": failure.law or "–", "stage": str(failure.stage),
            "mPAP [mmHg]": measured.get(failure.animal, failure.mean_pressure), "reason": failure.reason,
        }
        for failure in cohort.failures
    ).astype({"mPAP [mmHg]": float})  # fmt: skip
    note = (
        "Reading and computing: the animal has no result. Fit, analysis: it has none with this law. Posterior, "
        "comparison: all else is there. mPAP as measured, whatever failed."
    )
    return [Table.from_frame("Failures", "What failed, and why", data, note)]


def networks(cohort: Cohort) -> list[Table]:
    """Connectivity and size of the vessels ("Network"), side by side where the groups' vessels are the same."""
    by_topology: dict[tuple[str, ...], dict[str, AnimalResult]] = {}
    for group, result in cohort.shown.items():
        vessels = result.network
        by_topology.setdefault((*vessels.name, *map(str, (*vessels.start, *vessels.end))), {})[group] = result
    return [
        _network("Network" if place == 1 else f"Network-{place}", results, cohort.single)
        for place, results in enumerate(by_topology.values(), start=1)
    ]


def _network(name: str, results: dict[str, AnimalResult], single: bool) -> Table:
    first = next(iter(results.values())).network
    behind = {row: junction.beginning for junction in first.junctions for row in junction.ending}
    daughters = [", ".join(first.name[next_] for next_ in behind.get(row, ())) or "–" for row in range(len(first))]
    data = pd.DataFrame({"vessel": first.name, "daughters": daughters})
    for group, result in results.items():
        vessels, label = result.network, "" if single else f" {group}"
        data[f"r0{label} [cm]"], data[f"L{label} [cm]"] = vessels.radius, vessels.length
    whose = "" if single else f" of {' and '.join(results)} (animals {named(list(results.values()))})"
    note = "– marks a terminal vessel; the first one is the root."
    return Table.from_frame(name, f"Dimensions of the vessels{whose}", data, note)


def nominal(cohort: Cohort) -> Table:
    """Nominal parameters of every animal ("ParNom", eqs. 8 to 12)."""
    rows = []
    for result in cohort.results:
        start = result.nominal
        values = {f"{label} [{start[name].attrs['units']}]": float(start[name]) for name, label in _NOMINAL.items()}
        rows.append(animal_cells(result) | values)
    note = "Every wall law starts at the stiffness β₀ (eqs. 9, 10), all vascular beds at a = R₁/R_T = 0.2."
    return Table.from_frame("ParNom", "Nominal parameters", pd.DataFrame(rows), note)


def characteristic_impedances(cohort: Cohort) -> Table:
    """Z_c of every animal by several estimators (eq. 8)."""
    rows = []
    for result in cohort.results:
        spectrum = result.measured.impedance
        values = zip(spectrum["estimator"].values, spectrum["Z_c"].values, strict=True)
        rows.append(animal_cells(result) | {f"{name} [mmHg s/ml]": float(value) for name, value in values})
    note = (
        "The nominal stiffness follows from the up-slope, which is 20 to 45 % too large before beds that store much, "
        "its first half 5 to 15 %; where estimators disagree, reflections or delays are at work."
    )
    return Table.from_frame("Zc", "Characteristic impedance by several estimators, measured", pd.DataFrame(rows), note)


def variables(cohort: Cohort) -> list[Table]:
    """Return what the lab's own columns say of the animals, where there are any."""
    if not cohort.variables:
        return []
    labels = {variable.label: variable.values for variable in cohort.variables.values()}
    rows = pd.DataFrame(
        [
            animal_cells(result) | {label: values.get(result.name) for label, values in labels.items()}
            for result in cohort.results
        ]
    )
    return [Table.from_frame("Columns", "What the table of animals says of each", rows)]
