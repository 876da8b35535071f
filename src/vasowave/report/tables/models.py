"""Tables of the calibrated models: Bounds, Parameters, Starts, Waves."""

import numpy as np
import pandas as pd
import xarray as xr

from vasowave.analysis.events import WAVES
from vasowave.animal.reading import largest_waves
from vasowave.cohort.cohort import Cohort
from vasowave.cohort.table import columns
from vasowave.io.columns import split_unit
from vasowave.report.blocks import Table
from vasowave.report.tables.cells import mean_sd, span, symbols, who, with_unit
from vasowave.report.wording import Row, column_label, number

_DERIVED = ("wave_speed", "R_T", "C_T", "C_p_over_C_T", "tau", "I_R", "a", "S", "RMSE")
MARKS = (
    "† at a bound of its search; ‡ not determined by the data (the ends of its 95 % interval differ by more than a "
    "factor of 4)."
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
    return Table.of("Bounds", f"Bounds of the search{ranges}", pd.DataFrame(rows))


def parameters(cohort: Cohort, wall: str) -> Table:
    """Optimized values of every animal with one wall law ("Parameters")."""
    law, written = cohort.law(wall), symbols(cohort)
    names = dict.fromkeys((*law.parameters, law.stiffness, *_DERIVED))
    table = cohort.table[cohort.table["source"] == wall]
    there = [label for label in columns(table, tuple(names)) if table[label].notna().any()]
    header = ("animal", "group", *(with_unit(label, written) for label in there))
    cells: list[Row] = []
    for (_, row), fit in zip(table.iterrows(), cohort.calibrations(wall), strict=True):
        marked = [number(row[label]) + mark(fit, split_unit(label)[0]) for label in there]
        cells.append((row["animal"], row["group"], *marked))
    data = table[["animal", "group", *there]]
    return Table(f"Parameters-{wall}", f"Optimized values, {wall} wall", header, cells, MARKS, data)


def starts(cohort: Cohort) -> Table:
    """The number of starts of every calibration that found its optimum."""
    rows = []
    for result in cohort.results:
        row = who(result)
        for wall in result.laws:
            fit = result.laws[wall].calibration
            row[f"{wall}: starts"] = int(fit.sizes["start"])
            row[f"{wall}: agree"] = int(fit["start_agrees"].values.astype(bool).sum())
            row[f"{wall}: simulations"] = int(fit["start_simulations"].values.sum())
        rows.append(row)
    return Table.of("Starts", "Starts of every calibration, and how many found its optimum", pd.DataFrame(rows))


def waves(cohort: Cohort) -> Table:
    """Peak, area and time of the largest wave of each kind, by group (and level, if crossed) and source."""
    rows = []
    for cell, (_, _, results) in cohort.cells.items():
        for result in results:
            row = who(result) | {"group": cell}
            for source, one in result.sources.items():
                rows += [row | {"source": source} | wave for wave in _largest_waves(one.waves)]
    data = pd.DataFrame(rows)
    data = data.sort_values("wave", key=lambda wave: wave.map(list(WAVES).index), kind="stable", ignore_index=True)
    measures = [label for label in data.columns if "[" in label]
    header = ("wave", "source", "group", "n", *map(column_label, measures))
    cells = [
        (str(wave), str(source), str(group), str(len(part)),
         *(mean_sd(part[label].agg(mean="mean", SD="std")) for label in measures))
        for (wave, source, group), part in data.groupby(["wave", "source", "group"], sort=False)
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
    known = fit.variables  # a value looked up in the data set itself gathers its coordinates, which takes long
    names = known["parameter"].values.tolist()
    if name not in names:
        return ""
    place = names.index(name)
    if known["at_bound"].values[place]:
        return " †"
    return "" if known["determined"].values[place] or not known["free"].values[place] else " ‡"


def laws_by_posterior(data: xr.Dataset) -> Table:
    """Return evidence and weight of every law, and how well it predicts each block of harmonics from the others."""
    from vasowave.inference.reweighting import UNTRUSTED  # loads the compiler, which few reports need

    blocks = [str(block) for block in data["block"].values]
    rows = []
    for wall in data["wall"].values:
        one = data.sel(wall=wall)
        evidence = f"{float(one['log_evidence']):.1f} ± {float(one['log_evidence_error']):.1f}"
        predicted = zip(one["left_out"].values, one["left_out_k_hat"].values, strict=True)
        cells = [f"{value:.1f}{'?' if k > UNTRUSTED else ''}" for value, k in predicted]
        rows.append((str(wall), evidence, number(float(one["weight"]), 2), *cells))
    header = ("wall law", "log evidence", "probability", *(f"harmonic {block}" for block in blocks))
    note = (
        f"{data.attrs['said']} Evidence: the probability density of the measured harmonics, everything unknown "
        "integrated out; probability: of the law, if all were as likely before. By harmonic: the log density of these "
        "harmonics given all others, larger is better; ?: the harmonics decide alone, and the number is rough (Pareto "
        f"k above {UNTRUSTED}). What is not among the unknowns, such as taper, can look like another wall."
    )
    return Table("", "Wall laws by their posteriors", header, rows, note)
