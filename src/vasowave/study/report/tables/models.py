"""Tables of the calibrated models: Bounds, Parameters, Starts, Waves, Sites, AICcBIC, Preference, Misfit."""

from collections.abc import Mapping

import numpy as np
import pandas as pd
import xarray as xr

from vasowave.base.descriptions import AT_BOUND, MOST_LEFT, OPEN, parameter_mark
from vasowave.base.io.columns import split_unit
from vasowave.pulse.analysis.waves import WAVES
from vasowave.pulse.quantities import OPTIMIZED, QUANTITIES
from vasowave.study.animal.law_result import LawResult
from vasowave.study.animal.reading import largest_waves
from vasowave.study.cohort.cohort import Cohort
from vasowave.study.cohort.table import columns
from vasowave.study.cohort.votes import DECISIVE_AICC_DIFFERENCE, MAX_RESIDUAL_RATIO, differences
from vasowave.study.cohort.walls import evidences
from vasowave.study.figures.modeled import sites_of
from vasowave.study.report.blocks import Table
from vasowave.study.report.tables.cells import animal_cells, interval, mean_sd, span, symbols, with_unit
from vasowave.study.report.wording import Row, column_label, number

MARKS = (
    f"{AT_BOUND} at a bound of its search; {OPEN} not determined by the data (the ends of its 95 % interval differ by "
    "more than a factor of 4)."
)
_TOLD = ("wave_speed", "R_T")
"""Quantities on the page; the file has every parameter."""
_ENDS = ("value", "low", "high")
_SITES_NOTE = (
    "Ratio: observed over what the recording at the inlet alone predicts, by least squares. Misfit: root mean square "
    "of what the fit without the site misses there, over what its error, the model's and the spread of that fit let "
    "expect; about 1 or less is agreement, more than 3 is a finding. With: 95 % interval of the fit to all sites; "
    "without: of the fit to all but this one. The CSV file has them for every parameter."
)
_SELECTION_NOTE = (
    "λ: weight of the regularization; noise models that need more than allowed are discarded and stand last. D: fitted "
    "parameters of each law, N: pressure samples."
)


def bounds(cohort: Cohort) -> Table:
    """Bounds of the searches ("Bounds")."""
    rows = []
    for wall in cohort.walls:
        fits = cohort.calibrations(wall)
        for place, name in enumerate(fits[0]["parameter"].values):
            unit = str(fits[0]["unit"].values[place])
            low, high, start = (
                np.array([fit[key].values[place] for fit in fits]) for key in ("lower", "upper", "nominal")
            )
            rows.append(
                {
                    "wall": wall, "parameter": f"{name} [{unit}]",
                    "lower bound": span(low), "upper bound": span(high),
                    "lower / nominal": span(low / start), "upper / nominal": span(high / start),
                }
            )  # fmt: skip
    ranges = "" if cohort.single else "; ranges over the animals"
    return Table.from_frame("Bounds", f"Bounds of the search{ranges}", pd.DataFrame(rows))


def parameters(cohort: Cohort, wall: str) -> Table:
    """Optimized values of every animal with one wall law ("Parameters")."""
    law, written = cohort.law(wall), symbols(cohort)
    names = dict.fromkeys((*law.parameters, law.stiffness, *OPTIMIZED))
    table = cohort.table[cohort.table["source"] == wall]
    labels = [label for label in columns(table, tuple(names)) if table[label].notna().any()]
    header = ("animal", "group", *(with_unit(label, written) for label in labels))
    cells: list[Row] = []
    for (_, row), fit in zip(table.iterrows(), cohort.calibrations(wall), strict=True):
        marked = [number(row[label]) + mark(fit, split_unit(label)[0]) for label in labels]
        cells.append((row["animal"], row["group"], *marked))
    data = table[["animal", "group", *labels]]
    return Table(f"Parameters-{wall}", f"Optimized values, {wall} wall", header, cells, MARKS, data)


def starts(cohort: Cohort) -> Table:
    """The number of starts of every calibration that found its optimum."""
    rows = []
    for result in cohort.results:
        row = animal_cells(result)
        for wall in result.laws:
            fit = result.laws[wall].calibration
            row[f"{wall}: starts"] = int(fit.sizes["start"])
            row[f"{wall}: agree"] = int(fit["start_agrees"].values.astype(bool).sum())
            row[f"{wall}: simulations"] = int(fit["start_simulations"].values.sum())
        rows.append(row)
    return Table.from_frame("Starts", "Starts of every calibration, and how many found its optimum", pd.DataFrame(rows))


def waves(cohort: Cohort) -> Table:
    """Peak, area and time of the largest wave of each kind, by group (and level, if crossed) and source."""
    rows = []
    for cell, (_, _, results) in cohort.cells.items():
        for result in results:
            row = animal_cells(result) | {"group": cell}
            for source, source_result in result.sources.items():
                rows += [row | {"source": source} | wave for wave in _largest_waves(source_result.waves)]
    data = pd.DataFrame(rows)
    data = data.sort_values("wave", key=lambda wave: wave.map(list(WAVES).index), kind="stable", ignore_index=True)
    measures = [label for label in data.columns if "[" in label]
    header = ("wave", "source", "group", "n", *map(column_label, measures))
    cells = [
        (str(wave), str(source), str(group), str(len(wave_rows)),
         *(mean_sd(wave_rows[label].agg(mean="mean", SD="std")) for label in measures))
        for (wave, source, group), wave_rows in data.groupby(["wave", "source", "group"], sort=False)
    ]  # fmt: skip
    note = (
        f"{'The' if cohort.single else 'Mean ± SD of the'} largest wave of each kind: F forward, B backward, C "
        "compression, D decompression; backward intensities are negative. Measured: with A₀ and the wave speed that "
        "the up-slope gives."
    )
    return Table("Waves", "Single waves at the inlet", header, cells, note, data)


def _largest_waves(data: xr.Dataset) -> list[dict[str, object]]:
    return [
        {
            "wave": name,
            "peak [W/cm2/s2]": float(data["wave_peak"][row]), "area [W/cm2/s]": float(data["wave_area"][row]),
            "time/T [1]": float(data["wave_time"][row]) / float(data.attrs["period"]),
        }
        for name, row in largest_waves(data).items()
    ]  # fmt: skip


def mark(fit: xr.Dataset, name: str) -> str:
    """Return the mark of a parameter that lies at a bound or is not determined; see `MARKS`."""
    variables = fit.variables  # a value looked up in the data set itself gathers its coordinates, which takes long
    names = variables["parameter"].values.tolist()
    if name not in names:
        return ""
    place = names.index(name)
    shown = parameter_mark(*(bool(variables[flag].values[place]) for flag in ("free", "at_bound", "determined")))
    return f" {shown}" if shown else ""


def laws_by_posterior(data: xr.Dataset) -> Table:
    """Return evidence and weight of every law, and how well it predicts each block of harmonics from the others."""
    from vasowave.pulse.inference.reweighting import MAX_PARETO_K  # loads the compiler, which few reports need

    blocks = [str(block) for block in data["block"].values]
    rows = []
    for wall in data["wall"].values:
        law = data.sel(wall=wall)
        evidence = f"{float(law['log_evidence']):.1f} ± {float(law['log_evidence_error']):.1f}"
        predicted = zip(law["left_out"].values, law["left_out_k_hat"].values, strict=True)
        cells = [f"{value:.1f}{'?' if k > MAX_PARETO_K else ''}" for value, k in predicted]
        rows.append((str(wall), evidence, number(float(law["weight"]), 2), *cells))
    header = ("wall law", "log evidence", "probability", *(f"harmonic {block}" for block in blocks))
    note = (
        f"{data.attrs['said']} Evidence: the probability density of the measured harmonics, everything unknown "
        "integrated out; probability: of the law, if all were as likely before. By harmonic: the log density of these "
        "harmonics given all others, larger is better; ?: the harmonics decide alone, and the number is rough (Pareto "
        f"k above {MAX_PARETO_K}). What is not among the unknowns, such as taper, can look like another wall."
    )
    return Table("", "Wall laws by their posteriors", header, rows, note)


def sites_table(cohort: Cohort) -> Table:
    """Return a row for every site of every animal and wall law; its data have one for every quantity of these."""
    written = symbols(cohort)
    header = ("animal", "wall law", "site", "ratio", "misfit",
              *(f"{written.get(name, name)} {condition} [{QUANTITIES[name].unit}]"
                for name in _TOLD for condition in ("with", "without")))  # fmt: skip
    cells, rows = [], []
    for result in cohort.results:
        for wall, data in sites_of(result).items():
            units = _units(result.laws[wall])
            for site in range(data.sizes["site"]):
                site_data = data.isel(site=site)
                name, ratio, misfit = (
                    str(site_data["site"].item()),
                    float(site_data["ratio"]),
                    float(site_data["misfit"]),
                )
                intervals = [
                    interval(site_data.sel(quantity=quantity), *(f"{end}{condition}" for end in _ENDS))
                    for quantity in _TOLD
                    for condition in ("", "_without")
                ]
                cells.append((result.name, wall, name, number(ratio, 3), number(misfit, 2), *intervals))
                labels = animal_cells(result) | {
                    "wall law": wall,
                    "site": name,
                    "ratio [1]": ratio,
                    "misfit [1]": misfit,
                }
                rows += [
                    labels | _site_row(site_data.sel(quantity=quantity), units) for quantity in data["quantity"].values
                ]
    return Table("Sites", "Further sites: predicted without each, and what it adds", header, cells, _SITES_NOTE,
                 pd.DataFrame(rows))  # fmt: skip


def _units(law: LawResult) -> dict[str, str]:
    """Return the units of the quantities that sites tell something of."""
    parameters = zip(law.calibration["parameter"].values, law.calibration["unit"].values, strict=True)
    return {str(name): str(unit) for name, unit in parameters} | {name: QUANTITIES[name].unit for name in _TOLD}


def _site_row(data: xr.Dataset, units: Mapping[str, str]) -> dict[str, object]:
    """Return the cells of one quantity."""
    name = str(data["quantity"].item())
    interval_ends = {
        f"{end}{suffix.replace('_', ' ')}": float(data[f"{end}{suffix}"])
        for suffix in ("", "_without")
        for end in _ENDS
    }
    return {"quantity": name, "unit": units[name], **interval_ends}


def selection_table(cohort: Cohort) -> Table:
    """AICc and BIC of the wall laws under every noise model, for every animal, likeliest noise model first."""
    pairs = zip(cohort.ballots, cohort.compared, strict=True)
    tables = [ballots.table.assign(**animal_cells(result)) for ballots, result in pairs]  # type: ignore[arg-type]
    data = pd.concat(tables, ignore_index=True)
    data = data[["animal", "group", *(label for label in data.columns if label not in ("animal", "group"))]]
    selection = cohort.compared[0].selection
    verdict = selection["AICc_verdict"].attrs.get("long_name", "") if selection is not None else ""
    note = f"Prefers: {verdict}. {_SELECTION_NOTE}" if verdict else _SELECTION_NOTE
    return Table.from_frame("AICcBIC", "AICc and BIC of the wall laws; the lower score is better", data, note)


def preference_table(cohort: Cohort, law: str) -> Table:
    """The difference of every other law from `law`, pooled over animals, by noise model."""
    tables = [differences(cohort.ballots, law).assign(noise="likeliest of each animal")]
    for covariance in dict.fromkeys(name for ballots in cohort.ballots for name in ballots.table["covariance"]):
        tables.append(differences(cohort.ballots, law, covariance=str(covariance)).assign(noise=str(covariance)))
    data = pd.concat([table for table in tables if len(table)] or tables[:1], ignore_index=True)
    cells = [
        (str(row["wall"]), str(row["noise"]), str(row["n"]), interval(row, "mean", "low", "high"),
         number(row["price"], 2), interval(row, "residuals", "residuals low", "residuals high"),
         number(row["residuals SD"], 2), str(row["speaks for"]) or "open")
        for _, row in data.iterrows()
    ]  # fmt: skip
    header = ("wall", "noise model", "animals", f"AICc minus that of the {law} wall, per animal [95 %]",
              "fixed price of parameters", "residuals' own part [95 %]", "SD over animals", "speaks for")  # fmt: skip
    note = (
        f"Positive numbers speak for the {law} wall. AICc is the price of a law's parameters, whatever the data say, "
        "and the residuals' own part, minus twice the log-likelihood. Intervals are Student's, from the scatter of the "
        "animals. A law is named where the whole and the residuals' own part "
        f"both speak for it, beyond that scatter and by {DECISIVE_AICC_DIFFERENCE:g} over all animals. "
        "What the noise model changes, the data have not decided."
    )
    if evidences(cohort, law):
        note += " Which wall is answered by the evidences of posteriors; AICc, beside them, takes the image as exact."
    return Table("Preference", "Wall laws compared over all animals", header, cells, note, data)


def misfit_table(cohort: Cohort) -> Table:
    """The residual of every law, beside the error of the averaged cycle."""
    data = cohort.misfits
    cells = [
        (row["animal"], row["group"], row["wall"], number(row["RMSE"], 2), number(row["error"], 2),
         f"{100 * row['share']:.1f} %", number(row["over best"], 2),
         "overstrained" if row["growth"] > 0 else "misses" if row["missed"] else "")
        for _, row in data.iterrows()
    ]  # fmt: skip
    header = (
        "animal",
        "group",
        "wall",
        "RMSE [mmHg]",
        "error of the cycle [mmHg]",
        "of the pulse",
        "over the best law",
        "",
    )
    note = (
        "Error of the cycle: standard error of the averaged beats (– if a cycle was given). A law misses its data "
        f"where it leaves more than {MAX_RESIDUAL_RATIO:g} times what the animal's best law leaves, or more than "
        f"{100 * MOST_LEFT:g} % of the pulse pressure. Overstrained: a vessel's area grows beyond what an artery "
        "survives; such a law is never the best."
    )
    return Table("Misfit", "What the wall laws leave of the data", header, cells, note, data)
