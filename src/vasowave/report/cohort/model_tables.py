"""Tables of the calibrated models: Bounds, Parameters, starts, single waves, intervals of one animal."""

import numpy as np
import pandas as pd
import xarray as xr

from vasowave.analysis import WAVES
from vasowave.animal.datasets import split_unit
from vasowave.animal.reading import data_of, wall_laws
from vasowave.cohort.comparison import columns
from vasowave.figures.cohort_gallery import Cohort
from vasowave.report.cohort.cells import mean_sd, span, symbols, who, with_unit
from vasowave.report.document import Table
from vasowave.report.wording import Row, column_label, number

_PARAMETERS = ("p1_over_gamma", "wave_speed", "R_T", "C_T", "C_p_over_C_T", "tau", "I_R", "a", "S", "RMSE")
_MARKS = "† at a bound of its search; ‡ not determined by the data (standard error above half of the value)."


def bounds(cohort: Cohort) -> Table:
    """Bounds of the searches ("Bounds")."""
    rows = []
    for wall in cohort.walls:
        fits = [data_of(tree, f"{wall}/calibration") for tree in cohort.trees if wall in wall_laws(tree)]
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
    return Table.of("Bounds", "Bounds of the search; ranges over the animals", pd.DataFrame(rows))


def parameters(cohort: Cohort, wall: str) -> Table:
    """Optimized values of every animal with one wall law ("Parameters")."""
    own = ("beta",) if wall == "linear" else ("p1", "gamma")
    table = cohort.table[cohort.table["source"] == wall]
    written = symbols(cohort.trees)
    there = [label for label in columns(table, (*own, *_PARAMETERS)) if np.isfinite(table[label].astype(float)).any()]
    header = ("animal", "group", *(with_unit(label, written) for label in there))
    trees = {tree.attrs["animal"]: tree for tree in cohort.trees}
    cells: list[Row] = []
    for _, row in table.iterrows():
        fit = data_of(trees[row["animal"]], f"{wall}/calibration")
        marked = [number(row[label]) + _mark(fit, split_unit(label)[0]) for label in there]
        cells.append((row["animal"], row["group"], *marked))
    data = table[["animal", "group", *there]]
    return Table(f"Parameters-{wall}", f"Optimized values, {wall} wall", header, cells, _MARKS, data)


def starts(cohort: Cohort) -> Table:
    """How many starts of every calibration found its optimum."""
    rows = []
    for tree in cohort.trees:
        row = who(tree)
        for wall in wall_laws(tree):
            fit = data_of(tree, f"{wall}/calibration")
            row[f"{wall}: starts"] = int(fit.sizes["start"])
            row[f"{wall}: agree"] = int(fit["start_agrees"].values.astype(bool).sum())
            row[f"{wall}: simulations"] = int(fit["start_simulations"].values.sum())
        rows.append(row)
    return Table.of("Starts", "Starts of every calibration, and how many found its optimum", pd.DataFrame(rows))


def waves(cohort: Cohort) -> Table:
    """Peak, area and time of the largest wave of each kind, by group and source."""
    rows = []
    for tree in cohort.trees:
        for source in ["measured", *wall_laws(tree)]:
            rows += [who(tree) | {"source": source} | wave for wave in _largest_waves(data_of(tree, f"{source}/waves"))]
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
        "Mean ± SD of the largest wave of each kind: F forward, B backward, C compression, D decompression; backward "
        "intensities are negative. Measured: with A₀ and the wave speed that the up-slope gives."
    )
    return Table("Waves", "Single waves at the inlet", header, cells, note, data)


def _largest_waves(data: xr.Dataset) -> list[dict[str, object]]:
    found: dict[str, dict[str, object]] = {}
    for row in np.argsort(-np.abs(data["wave_area"].values), kind="stable"):
        name = str(data["wave_name"].values[row])
        values = {
            "peak [W/cm2/s2]": float(data["wave_peak"][row]), "area [W/cm2/s]": float(data["wave_area"][row]),
            "time/T [1]": float(data["wave_time"][row]) / float(data.attrs["period"]),
        }  # fmt: skip
        found.setdefault(name, {"wave": name, **values})
    return list(found.values())


def intervals(tree: xr.DataTree, written: dict[str, str]) -> Table:
    """What was calibrated for one animal, with 95 % intervals where they are known."""
    names = {wall: [str(name) for name in data_of(tree, f"{wall}/quantities").data_vars] for wall in wall_laws(tree)}
    cells = []
    for name in dict.fromkeys(name for found in names.values() for name in found):
        unit = next(data_of(tree, f"{wall}/quantities")[name].attrs["units"] for wall in names if name in names[wall])
        values = [_with_interval(tree, wall, name) if name in names[wall] else "" for wall in names]
        cells.append((with_unit(f"{name} [{unit}]", written), *values))
    return Table("", "Calibrated values [95 % interval]", ("quantity", *(f"{wall} wall" for wall in names)), cells)


def _with_interval(tree: xr.DataTree, wall: str, name: str) -> str:
    value = data_of(tree, f"{wall}/quantities")[name]
    text = number(float(value)) + _mark(data_of(tree, f"{wall}/calibration"), name)
    if "interval_low" not in value.attrs:
        return text
    low, high = float(value.attrs["interval_low"]), float(value.attrs["interval_high"])
    return f"{text} [{number(low, 2)}, {number(high, 2)}]"


def _mark(fit: xr.Dataset, name: str) -> str:
    names = [str(parameter) for parameter in fit["parameter"].values]
    if name not in names:
        return ""
    place = names.index(name)
    if fit["at_bound"].values[place]:
        return " †"
    return "" if fit["determined"].values[place] or not fit["free"].values[place] else " ‡"
