"""What speaks for and against wall laws: further sites, the data they leave, AICc and BIC, and their posteriors."""

from collections.abc import Mapping

import pandas as pd
import xarray as xr

from vasowave.base.descriptions import MOST_LEFT
from vasowave.pulse.quantities import QUANTITIES
from vasowave.study.animal.law_result import LawResult
from vasowave.study.cohort.cohort import Cohort
from vasowave.study.cohort.votes import DECISIVE_AICC_DIFFERENCE, MAX_RESIDUAL_RATIO, differences
from vasowave.study.cohort.walls import evidences
from vasowave.study.figures.matplotlib_style import group_looks
from vasowave.study.figures.modeled import sites_figure, sites_of
from vasowave.study.report.blocks import Block, Drawing, Fold, Table
from vasowave.study.report.wording import animal_cells, interval, number, symbols

_TOLD = ("wave_speed", "R_T")
"""Quantities on the page; the file has every parameter."""
_ENDS = ("value", "low", "high")
_CONDITIONS = {"with": "", "without": "_without"}
"""Whether a fit knew the site, and how the names of its numbers end."""
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


def sites_blocks(cohort: Cohort) -> list[Block]:
    """What further sites add: a figure and a table where any animal has some."""
    shown = {group: result for group, result in cohort.shown.items() if sites_of(result)}
    if not any(sites_of(result) for result in cohort.results):
        return []
    drawn: list[Block] = [
        Drawing(f"Sites-{place}", f"What was observed at further sites of {cohort.name(group)} (black; dotted: mean, "
                "largest and smallest value), the fit to all sites (colored), and what the fit without that site "
                "predicts (grey).", sites_figure(result, group_looks(cohort.groups)[group].color))
        for place, (group, result) in enumerate(shown.items(), start=1)
    ]  # fmt: skip
    return [*drawn, sites_table(cohort)]


def selection_blocks(cohort: Cohort, law: str) -> list[Block]:
    """AICc and BIC of the laws, pooled over animals and animal by animal; nothing where they were not compared."""
    if not cohort.compared:
        return []
    table: Table = selection_table(cohort)
    if cohort.single:
        return [table]
    return [preference_table(cohort, law), Fold("Model selection, animal by animal", [table])]


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
    columns = {f"{written.get(name, name)} {condition} [{QUANTITIES[name].unit}]": (name, suffix)
            for name in _TOLD for condition, suffix in _CONDITIONS.items()}  # fmt: skip
    cells, rows = [], []
    for result in cohort.results:
        for wall, data in sites_of(result).items():
            units = _units(result.laws[wall])
            for site in (data.isel(site=place) for place in range(data.sizes["site"])):
                name, ratio, misfit = str(site["site"].item()), float(site["ratio"]), float(site["misfit"])
                intervals = [interval(site.sel(quantity=quantity), *(f"{end}{suffix}" for end in _ENDS))
                             for quantity, suffix in columns.values()]  # fmt: skip
                cells.append((result.name, wall, name, number(ratio, 3), number(misfit, 2), *intervals))
                labels = animal_cells(result) | {"wall law": wall, "site": name}
                labels |= {"ratio [1]": ratio, "misfit [1]": misfit}
                rows += [labels | _site_row(site.sel(quantity=name), units) for name in data["quantity"].values]
    header = ("animal", "wall law", "site", "ratio", "misfit", *columns)
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
        for suffix in _CONDITIONS.values()
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
    columns = {
        "wall": lambda row: str(row["wall"]),
        "noise model": lambda row: str(row["noise"]),
        "animals": lambda row: f"{row['n']} of {row['n'] + row['left out']}",
        f"AICc minus that of the {law} wall, per animal [95 %]": lambda row: interval(row, "mean", "low", "high"),
        "fixed price of parameters": lambda row: number(row["price"], 2),
        "residuals' own part [95 %]": lambda row: interval(row, "residuals", "residuals low", "residuals high"),
        "SD over animals": lambda row: number(row["residuals SD"], 2),
        "speaks for": lambda row: str(row["speaks for"]) or "open",
    }
    note = (
        f"Positive numbers speak for the {law} wall. AICc is the price of a law's parameters, whatever the data say, "
        "and the residuals' own part, minus twice the log-likelihood. Intervals are Student's, from the scatter of the "
        "animals. A law is named where the whole and the residuals' own part "
        f"both speak for it, beyond that scatter and by {DECISIVE_AICC_DIFFERENCE:g} over all animals. "
        "What the noise model changes, the data have not decided. Animals of which a fit of either law must not be "
        "used are left out; where they leave too few, no law is named."
    )
    if evidences(cohort, law):
        note += " Which wall is answered by the evidences of posteriors; AICc, beside them, takes the image as exact."
    rows = (row for _, row in data.iterrows())
    return Table.from_items("Preference", "Wall laws compared over all animals", rows, columns, note, data)


def misfit_table(cohort: Cohort) -> Table:
    """The residual of every law, beside the error of the averaged cycle."""
    data = cohort.misfits
    columns = {
        "animal": lambda row: row["animal"],
        "group": lambda row: row["group"],
        "wall": lambda row: row["wall"],
        "RMSE [mmHg]": lambda row: number(row["RMSE"], 2),
        "error of the cycle [mmHg]": lambda row: number(row["error"], 2),
        "of the pulse": lambda row: f"{100 * row['share']:.1f} %",
        "over the best law": lambda row: number(row["over best"], 2),
        "": lambda row: "overstrained" if row["growth"] > 0 else "misses" if row["missed"] else "",
    }
    note = (
        "Error of the cycle: standard error of the averaged beats (– if a cycle was given). A law misses its data "
        f"where it leaves more than {MAX_RESIDUAL_RATIO:g} times what the animal's best law leaves, or more than "
        f"{100 * MOST_LEFT:g} % of the pulse pressure. Overstrained: a vessel's area grows beyond what an artery "
        "survives; such a law is never the best."
    )
    rows = (row for _, row in data.iterrows())
    return Table.from_items("Misfit", "What the wall laws leave of the data", rows, columns, note, data)
