"""Every animal: what must be considered, its beats, its fits (drawn and in words), its values, how it was searched."""

from collections.abc import Mapping, Sequence
from functools import partial

import numpy as np
import pandas as pd
import xarray as xr

from vasowave.base.findings import texts
from vasowave.pulse.inference.known_errors import SOURCES
from vasowave.study.animal.law_result import PosteriorResult
from vasowave.study.animal.result import AnimalResult
from vasowave.study.cohort.cohort import Cohort
from vasowave.study.figures.fit import ON_A_SHEET, sheet_figure, sheets
from vasowave.study.figures.matplotlib_style import group_looks
from vasowave.study.figures.measured import beats_figure
from vasowave.study.figures.modeled import fit_figure
from vasowave.study.report.blocks import (
    Block,
    Bullets,
    Drawing,
    Fold,
    Heading,
    OnScreen,
    Paragraph,
    Remarks,
    Section,
    Table,
)
from vasowave.study.report.sections.laws import laws_by_posterior
from vasowave.study.report.sections.models import MARKS, mark
from vasowave.study.report.wording import Row, listed, number, unit, value_text, with_error, with_unit

ANIMALS = "animals"
"""Name of the section that shows every animal of several."""


def animals_section(cohort: Cohort, written: dict[str, str]) -> Section:
    """All animals small, on sheets; each by itself folded, which paper leaves out; a few are drawn large there."""
    large = len(cohort.results) <= ON_A_SHEET
    colors = {group: group_look.color for group, group_look in group_looks(cohort.groups).items()}
    folds = []
    for place, result in enumerate(cohort.results, start=1):
        drawings = (_fit(result, place, colors[result.group]), _beats(result, place)) if large else ([], [])
        folds.append(_folded(result, *drawings, written))
    looks = [f"{result.name}: {text}" for result in cohort.results for text in texts(result.looks)]
    return Section(
        ANIMALS,
        "Every animal",
        [*_sheets(cohort), *([Remarks("Recordings to look at", looks)] if looks else []), OnScreen(folds)],
    )


def animal_sections(cohort: Cohort, written: dict[str, str]) -> tuple[Section, Section]:
    """The only animal: what was found of it, and how it was searched for."""
    (result,) = cohort.results
    color = group_looks(cohort.groups)[result.group].color
    fit = [*_sentences(result, written), *_fit(result, 1, color)]
    notes = _remarks(result)  # folded, as they stand with the animals of a cohort
    folded = [Fold(f"Notes ({len(result.findings)})", notes)] if notes else []
    return (
        Section("animal", "Fit and values", [*fit, *_values(result, written), *_beats(result, 1), *folded]),
        Section("search", "Search, correlations, numerics", _search(result, written)),
    )


def _remarks(result: AnimalResult) -> list[Block]:
    notes = texts(result.findings)
    return [Remarks("Notes", notes)] if notes else []


def _sentences(result: AnimalResult, written: dict[str, str]) -> list[Block]:
    blocks: list[Block] = []
    for wall in result.laws:
        blocks += [Heading(f"{wall.capitalize()} wall"), Bullets(fit_sentences(result, wall, written))]
    return blocks


def _folded(result: AnimalResult, fit: Sequence[Block], beats: Sequence[Block], written: dict[str, str]) -> Fold:
    made, count = ", synthetic" if result.synthetic else "", len(result.findings)
    notes = f", {count} {'note' if count == 1 else 'notes'}" if count else ""
    details = _sentences(result, written) + _search(result, written)
    blocks = [*_remarks(result), *fit, *_values(result, written), *beats]
    blocks += [Fold("The fits in words; search, correlations, numerics", details)] if details else []
    return Fold(f"{result.name} ({result.group}{made}{notes})", blocks)


def _sheets(cohort: Cohort) -> list[Block]:
    caption = (
        "Measured (black) and fitted pressure at the inlet over one cycle, the largest error first; above each panel "
        "the RMSE in mmHg, in it the range of the measured pressure in mmHg, which its height shows"
    )
    sheet_groups = sheets(cohort.results)
    figures = [
        Drawing(
            f"fits-{place}",
            f"{caption} (sheet {place} of {len(sheet_groups)}).",
            sheet_figure(sheet, list(cohort.groups)),
        )
        for place, sheet in enumerate(sheet_groups, start=1)
    ]
    where = "Beats, values and notes: on pages of the supplement; one alone: vasowave report STUDY --animal NAME."
    return [Paragraph(where), *figures]


def _fit(result: AnimalResult, place: int, color: str) -> list[Block]:
    if not result.laws:
        return []
    caption = "Measured (black) and fitted pressure and flow at the inlet, and what is left."
    return [Drawing(f"fit-{place}", caption, partial(fit_figure, result, color))]


def _beats(result: AnimalResult, place: int) -> list[Block]:
    """Return the beats of a continuous recording; an averaged cycle has none."""
    if result.beats is None or "trace_pressure" not in result.beats.data_vars:
        return []
    return [Drawing(f"beats-{place}", _beats_caption(result.beats), partial(beats_figure, result))]


def _values(result: AnimalResult, written: dict[str, str]) -> list[Block]:
    """Return all values, with their intervals, and what the laws say together."""
    posteriors = {wall: law.posterior for wall, law in result.laws.items() if law.posterior is not None}
    laws = [laws_by_posterior(result.evidence)] if result.evidence is not None else []
    return [
        values(result, written),
        *(posterior(wall, drawn, written) for wall, drawn in posteriors.items()),
        *laws,
    ]


def _search(result: AnimalResult, written: dict[str, str]) -> list[Block]:
    """Return how the parameters were searched and what was simulated."""
    blocks: list[Block] = []
    for wall in result.laws:
        blocks += [
            estimates(result, wall, written),
            correlations(result, wall, written),
            starts(result, wall),
        ]
    return [*blocks, numerics(result)] if blocks else []


def _beats_caption(beats: xr.Dataset) -> str:
    beat_count = int(beats["kept"].sum())
    causes = pd.Series([str(cause) for cause in beats["cause"].values if cause])
    rejected = "; ".join(f"{count} rejected: {cause}" for cause, count in causes.value_counts().items())
    return (
        f"{beats.sizes['beat']} beats detected, {beat_count} averaged{f'; {rejected}' if rejected else ''}. Above: "
        "recorded signals, triangles at detected beats; then every beat's diastolic level over the whole recording, "
        "with its drift; below: the averaged cycle."
    )


def fit_sentences(result: AnimalResult, wall: str, written: Mapping[str, str]) -> list[str]:
    """Return stiffness, outlets, quality, determination and agreement of the starts."""
    fit = result.laws[wall].calibration
    table = estimates_frame(result, wall).set_index("parameter")
    return [
        _walls(result, wall, table, written),
        _beds(fit),
        _quality(result, fit),
        *_limits(table, written),
        _starts(fit),
    ]


def _walls(result: AnimalResult, wall: str, table: pd.DataFrame, written: Mapping[str, str]) -> str:
    quantities = result.laws[wall].quantities
    terms = [
        f"{quantities[name].attrs['long_name']} {written.get(name, name)} = {_with_error(table.loc[[name]].iloc[0])}"
        for name in result.laws[wall].parameters
    ]
    speed = number(float(quantities["wave_speed"]))
    return f"Walls: {listed(terms)}; waves run at {speed} cm/s in the root vessel at the measured mean pressure."


def _with_error(row: pd.Series) -> str:
    units = f" {unit(row['unit'])}".rstrip()
    if not row["free"]:
        return f"{number(row['value'])}{units} (held)"
    error = float(row.get("standard_error_correlated", row["standard_error"]))
    return f"{with_error(float(row['value']), error)}{units}"


def _beds(fit: xr.Dataset) -> str:
    proximal = f", of which {number(100 * float(fit['a']))} % proximal (ratio a)" if "a" in fit else ""
    compliance = f", compliance {number(float(fit['C_p']))} ml/mmHg" if "C_p" in fit else ""
    return f"Vascular beds: total resistance R_T = {number(float(fit['R_T']))} mmHg s/ml{proximal}{compliance}."


def _quality(result: AnimalResult, fit: xr.Dataset) -> str:
    share = 100 * float(fit["RMSE"]) / float(result.measured.quantities["pPAP"])
    misfit = f"{number(float(fit['RMSE']))} mmHg (root mean square), {number(share, 2)} % of the pulse pressure"
    signal = "pressure"
    if fit.attrs.get("enters") == "pressure":
        residual, signal = fit["flow_residual"], "flow"
        ml_per_s = float(np.sqrt(np.mean(residual.values**2)))
        misfit = f"{number(ml_per_s)} {residual.attrs['units']} (root mean square), {number(share, 2)} % of its pulse"
    return (
        f"Fit: the {signal} differs from the measured one by {misfit}; "
        f"S = {number(float(fit['S']))} mmHg² over {int(fit['N'])} samples."
    )


def _limits(table: pd.DataFrame, written: Mapping[str, str]) -> list[str]:
    """Say which parameters end at a bound, and which the data do not determine."""
    free = table[table["free"].astype(bool)]
    symbols = {str(name): written.get(str(name), str(name)) for name in free.index}
    stopped = [
        f"{symbols[str(name)]} at its "
        f"{'lower' if row['value'] - row['lower'] < row['upper'] - row['value'] else 'upper'} bound "
        f"({number(row['value'])})"
        for name, row in free[free["at_bound"].astype(bool)].iterrows()
    ]
    open_ones = [symbols[str(name)] for name in free.index[~free["determined"].astype(bool)]]
    sentences = [f"The search ended with {listed(stopped)}."] if stopped else []
    if open_ones:
        return [*sentences, f"The data do not determine {listed(open_ones)}; other values fit about as well."]
    return [*sentences, "The data determine every free parameter."]


def _starts(fit: xr.Dataset) -> str:
    agree, count = int(fit["start_agrees"].values.astype(bool).sum()), int(fit.sizes["start"])
    if count == 1:
        return "One start was made."
    if agree == count:
        return f"All {count} starts of the optimization came to this optimum, or into its bowl."
    text = f"Only {agree} of {count} starts of the optimization came to this optimum or into its bowl"
    return f"{text}; the others are listed below."


_NUMERICS = {
    "period": ("period", "s"),
    "cycles": ("simulated cycles", ""),
    "change": ("largest change over the last cycle", "mmHg"),
    "tolerance": ("change that counts as periodic", "mmHg"),
    "converged": ("periodic", ""),
    "courant": ("largest Courant number", ""),
    "steps_per_cycle": ("time steps per cycle", ""),
    "cell_size": ("longest cell", "cm"),
    "volume_error": ("volume out of balance over a cycle, relative", ""),
}


def values(result: AnimalResult, written: dict[str, str]) -> Table:
    """Return every single number: measured, and of each wall law with its 95 % interval where it is known."""
    by_source = {source: result.sources[source].quantities for source in result.sources}
    fits = {wall: result.laws[wall].calibration for wall in result.laws}
    rows: list[Row] = []
    for name in dict.fromkeys(str(name) for data in by_source.values() for name in data.data_vars):
        units = next(str(data.variables[name].attrs.get("units", "1")) for data in by_source.values() if name in data)
        cells = [_value(data[name], fits.get(source)) if name in data else "" for source, data in by_source.items()]
        rows.append((with_unit(f"{name} [{units}]", written), *cells))
    header = ("quantity", "measured", *(f"{wall} wall" for wall in result.laws))
    note = (
        "Measured: the indices, and nominal values; β and c follow from the up-slope, τ of the diastolic decay stands "
        f"in the row of R_T C_T, R_T is mean pressure (above the wedge's) over mean flow. {MARKS}"
    )
    return Table("", "Values, measured and calibrated [95 % interval]", header, rows, note)


def estimates(result: AnimalResult, wall: str, written: dict[str, str]) -> Table:
    """Return what the search for the parameters of one wall law came to."""
    data = estimates_frame(result, wall)
    symbols = data["parameter"].map(lambda name: written.get(name, name))
    shown = data.assign(parameter=symbols, unit=data["unit"].map(unit))
    shown = shown.drop(columns=["symbol", "meaning"], errors="ignore")
    shown.columns = shown.columns.str.replace("_", " ")
    return Table.from_frame("", f"{wall.capitalize()} wall: the parameters and their search", shown)


def posterior(wall: str, posterior_result: PosteriorResult, written: dict[str, str]) -> Table:
    """Return what the posterior of one wall law says of every quantity, and where its uncertainty comes from."""
    data = posterior_result.table
    header = (
        "quantity",
        "median [95 %]",
        "assumed before [95 %]",
        *(f"from {source}" if source != "prior" else "assumed" for source in SOURCES),
    )
    rows: list[Row] = []
    for name in data["quantity"].values:
        row = data.sel(quantity=name)
        value, before = f"{number(float(row['median']))} {_ends(row, 'interval')}", _ends(row, "prior")
        shares = [float(row.get(f"share_{source}", np.nan)) for source in SOURCES]
        cells = ["" if np.isnan(share) else f"{100 * share:.0f} %" for share in shares]
        rows.append((with_unit(f"{name} [{row['unit'].item()}]", written), value, before, *cells))
    trusted = "the sampling succeeded" if posterior_result.trusted else "do not believe these numbers"
    note = (
        "Parameters, geometry and the model's own error are unknown together; the shares say where the variance comes "
        f"from. Pareto k {float(data['k_hat']):.2f}, {float(data['effective']):.0f} effective draws, two halves "
        f"{float(data['halves_apart']):.1f} SD apart: {trusted}."
    )
    return Table("", f"{wall.capitalize()} wall: posterior", header, rows, note)


def _ends(row: xr.Dataset, prefix: str) -> str:
    return f"[{number(float(row[f'{prefix}_low']))}, {number(float(row[f'{prefix}_high']))}]"


def correlations(result: AnimalResult, wall: str, written: dict[str, str]) -> Table:
    """Return the correlation of the estimates of one wall law."""
    matrix = result.laws[wall].calibration["correlation"]
    names = [written.get(str(name), str(name)) for name in matrix["free_parameter"].values]
    rows = [(name, *(f"{value:.2f}" for value in row)) for name, row in zip(names, matrix.values, strict=True)]
    return Table("", f"{wall.capitalize()} wall: correlation of the estimates", (" ", *names), rows)


def starts(result: AnimalResult, wall: str) -> Table:
    """Return where every start of the search ended."""
    return Table.from_frame("", f"{wall.capitalize()} wall: starts of the search", starts_frame(result, wall), digits=4)


def numerics(result: AnimalResult) -> Table:
    """Return settings and checks of the simulations, one column per wall law."""
    by_wall = {wall: result.laws[wall].simulation.attrs for wall in result.laws}
    rows: list[Row] = []
    for key in dict.fromkeys(str(key) for attrs in by_wall.values() for key in attrs if key != "wall"):
        cells = [number(bool(attrs.get(key)) if key == "converged" else attrs.get(key)) for attrs in by_wall.values()]
        rows.append((*_NUMERICS.get(key, (key.replace("_", " "), "")), *cells))
    header = ("setting", "unit", *(f"{wall} wall" for wall in by_wall))
    return Table("", "Settings and checks of the simulations", header, rows)


def estimates_frame(result: AnimalResult, wall: str) -> pd.DataFrame:
    """Return parameters, bounds, values and errors of one calibration in full precision."""
    fit = result.laws[wall].calibration
    along = [
        str(name) for name, value in fit.variables.items() if value.dims == ("parameter",) and name in fit.data_vars
    ]
    order = ["unit", *(name for name in along if name != "unit")]
    return pd.DataFrame({"parameter": fit["parameter"].values, **{name: fit.variables[name].values for name in order}})


def starts_frame(result: AnimalResult, wall: str) -> pd.DataFrame:
    """Return where every start ended in full precision, units in the column names."""
    fit = result.laws[wall].calibration
    count = {"start": np.arange(fit.sizes["start"])}
    columns = {}
    for name, value in fit.variables.items():
        if value.dims == ("start",) and name in fit.data_vars:
            units = value.attrs.get("units", "")
            label = str(name).removeprefix("start_")
            columns[f"{label} [{units}]" if units else label] = value.values
    return pd.DataFrame(count | columns)


def _value(value: xr.DataArray, fit: xr.Dataset | None) -> str:
    return value_text(value, with_unit=False) + ("" if fit is None else mark(fit, str(value.name)))
