"""The calibrated models: waveforms, walls, parameters, starts, waves, impedance and residuals, drawn and in tables."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr

from vasowave.base.descriptions import AT_BOUND, OPEN, parameter_mark
from vasowave.base.io.columns import split_unit
from vasowave.pulse.analysis.waves import WAVES
from vasowave.pulse.quantities import MEANS, OPTIMIZED
from vasowave.study.animal.reading import largest_waves
from vasowave.study.animal.result import AnimalResult
from vasowave.study.cohort.cohort import Cohort
from vasowave.study.cohort.primary import Primary
from vasowave.study.cohort.table import column, columns, rows_of
from vasowave.study.figures import modeled as figures
from vasowave.study.figures.compared import means_figure
from vasowave.study.figures.fit import PANELS
from vasowave.study.figures.matplotlib_style import color_stops, group_looks, short, source_looks
from vasowave.study.figures.network import axes_in_space
from vasowave.study.report.blocks import Block, Drawing, RotatingView, Section, Table
from vasowave.study.report.sections.laws import misfit_table, selection_blocks, sites_blocks
from vasowave.study.report.wording import (
    Row,
    animal_cells,
    column_label,
    listed,
    mean_sd,
    number,
    probability,
    span,
    symbols,
    with_unit,
)

_SAME = 1e-9  # logarithms that differ by less are equal but for rounding
_P = (
    " p: primary comparison, all its rows together; none where animals of a group share an image whose error is not "
    "known."
)


def model_section(cohort: Cohort, primary: Primary, written: Mapping[str, str]) -> Section:
    """The section of the calibrated models."""
    law, whose = primary.law, "" if cohort.single else " of the shown animals"
    harmonics = max(int(result.measured.impedance["harmonic"].max()) for result in cohort.results)
    blocks = [
        *space_block(cohort, law or cohort.walls[0]),
        *_waveforms(cohort),
        *(parameters(cohort, wall) for wall in cohort.walls),
        *sites_blocks(cohort),
        bounds(cohort),
        *_means(cohort, primary, written),
        Drawing("Waterfall", "S of every start over the best S of its animal, in rising order: a flat line is a "
                "calibration whose starts agree.", figures.waterfall_figure(cohort)),
        starts(cohort),
        *_waves(cohort, primary, written),
        Drawing("Impd", f"Impedance modulus and unwrapped phase (eq. 19) at harmonics 0 to "
                f"{harmonics}{whose}; bars: 95 % by the scatter of the averaged beats, where it is "
                "known; grey circles: harmonics whose flow is near the noise.", figures.impedance_figure(cohort)),
        Drawing("Residuals", "Measured minus simulated pressure and its autocorrelation; inside the grey band an "
                "autocorrelation cannot be told from that of independent noise.", figures.residuals_figure(cohort)),
        misfit_table(cohort),
        *selection_blocks(cohort, law),
    ]  # fmt: skip
    return Section("models", "Calibrated model" if cohort.single else "Calibrated models", blocks)


def labelled(cohort: Cohort, names: tuple[str, ...], written: Mapping[str, str]) -> dict[str, str]:
    """Return the columns of those quantities that a model has, and what their axes are called."""
    modeled = cohort.table[cohort.table["source"].isin(cohort.walls)]
    labels = {}
    for name in dict.fromkeys(names):
        label = column(modeled, name)
        if label and modeled[label].notna().any():
            unit = column_label(label).partition(" [")[2] or "1]"
            labels[label] = f"{written.get(name, name)} [{unit}"
    return labels


def _waveforms(cohort: Cohort) -> list[Block]:
    looks = group_looks(cohort.groups)
    drawn = any("strain_low" in law.vessels for result in cohort.shown.values() for law in result.laws.values())
    return [
        *(Drawing(f"PQsim-{place}", f"Pressure and flow at the middle of chosen vessels of {cohort.name(group)}, "
                  "each with its share of the mean flow.", figures.vessels_figure(result, looks[group].color))
          for place, (group, result) in enumerate(cohort.shown.items(), start=1)),
        *(Drawing(panel.figure, panel.caption, figures.panel_figure(cohort, panel))
          for panel in PANELS.values() if panel.caption),
        Drawing("Tree", "Wave speed at mean pressure in every vessel (eqs. 31, 32), fall of the mean pressure from the "
                "inlet to the end of every terminal vessel, mean shear at the wall (Womersley's profile), and range of "
                "the radius over its mean." + (" Lines are 95 % intervals by the posterior." if drawn else ""),
                figures.along_network_figure(cohort)),
    ]  # fmt: skip


def _means(cohort: Cohort, primary: Primary, written: Mapping[str, str]) -> list[Block]:
    if cohort.single:
        return []
    laws = [cohort.law(wall) for wall in cohort.walls]
    parameters = (name for law in laws for name in law.parameters)
    names = (*parameters, *MEANS[0], *(law.stiffness for law in laws), *MEANS[1])
    caption = (
        "Optimized parameters and what follows from them, and the least-squares error S of \"PQsim\" (eq. 14). "
    )  # fmt: skip
    columns = labelled(cohort, names, written)
    above = _above(cohort, primary, columns)
    drawn = means_figure(cohort, columns, cohort.walls, above)
    return [Drawing("ParOpt", f"{caption}{_points(cohort, cohort.walls, above)}", drawn)]


def _points(cohort: Cohort, sources: Sequence[str], above: Mapping[str, object]) -> str:
    """Return what points, lines and means of a figure are, and the p where any is written."""
    open_ones = [
        f"the {source} wall" for source, source_look in source_looks(sources).items() if not source_look.filled
    ]
    hollow = f", hollow ones of {listed(open_ones)}" if open_ones and len(sources) > 1 else ""
    noun = "recordings" if cohort.repeated else "animals"
    joined = ", lines join those of one animal" if cohort.crossed and cohort.repeated else ""
    if cohort.crossed and cohort.second:
        levels = list(dict.fromkeys(short(cell.level) for cell in cohort.cells.values()))
        joined += f", {cohort.second.name} from left to right {listed(levels)}"
    return (
        f"Points: {noun}{hollow}{joined}; beside them geometric means with 95 % intervals, each by itself "
        f"(random effects, {noun} weighted by how well each is known).{_P if above else ''}"
    )


def _above(cohort: Cohort, primary: Primary, columns: Mapping[str, str]) -> dict[str, dict[str, str]]:
    """Return by column and group the p that the primary comparison gives a quantity of its law."""
    if not cohort.design.plain:
        return {}
    table = rows_of(cohort.table, primary.law)
    texts: dict[str, dict[str, str]] = {}
    for effect in primary.effects:
        if effect.source != primary.law:
            continue
        for label in columns:
            if _proportional(table, label, column(table, effect.quantity)):
                text = "no p" if effect.untested else probability(effect.p)
                texts.setdefault(label, {})[effect.contrast.group] = text
    return texts


def _proportional(rows: pd.DataFrame, first: str, second: str) -> bool:
    """Return whether two columns differ by a factor at most, so that their ratios are the same."""
    if first == second:
        return True
    a, b = (rows[name].to_numpy(float) for name in (first, second))
    return bool(np.all(a > 0) and np.all(b > 0) and np.ptp(np.log(a / b)) < _SAME and np.ptp(np.log(a)) > _SAME)


def _waves(cohort: Cohort, primary: Primary, written: Mapping[str, str]) -> list[Block]:
    blocks: list[Block] = [
        Drawing(f"WIA-{place}", f"Forward and backward pressure (eq. 15, left) and time-normalized wave intensity "
                f"(eq. 16, right) at the inlet of {cohort.name(group)}: measured and with each wall law. F forward, B "
                "backward, C compression, D decompression wave.", figures.waves_figure(cohort, group))
        for place, group in enumerate(cohort.shown, start=1)
    ]  # fmt: skip
    if not cohort.single:
        columns = labelled(cohort, ("I_R",), written)
        above = _above(cohort, primary, columns)
        drawn = means_figure(cohort, columns, cohort.sources, above)
        caption = f"Reflection coefficient I_R (eq. 17). {_points(cohort, cohort.sources, above)}"
        blocks.append(Drawing("WIA-I_R", caption, drawn))
    return [*blocks, waves(cohort)]


_SAMPLES, _FEWER, _MANY = 64, 32, 100  # of each waveform; of each where there are many vessels
_CALLED = {"radius": "radius at mean pressure", "distance": "distance of its end from the inlet", "Z_c": "Z_c"}


def space_block(cohort: Cohort, law: str) -> list[RotatingView]:
    """Return the networks of the shown animals with what one wall law says of every vessel; nothing without the law."""
    shown = {group: result for group, result in cohort.shown.items() if law in result.laws}
    if not shown:
        return []
    networks = [{"label": cohort.name(group), **_network(result, law)} for group, result in shown.items()]
    caption = (
        f"The network in space, with the {law} wall. Drag to turn it, wheel or + and − to zoom, click a vessel for its "
        "waveforms at its middle (grey: the root's). Lengths and radii are measured; directions are drawn, since a "
        "table of vessels does not hold them."
    )
    return [RotatingView("RotatingView", caption, {"stops": color_stops(9), "networks": networks})]


def _network(result: AnimalResult, law: str) -> dict[str, Any]:
    network, simulation = result.network, result.laws[law].simulation
    names = list(network.name)
    middle = simulation[["pressure", "flow"]].sel(station="middle", vessel=names)
    step = max(1, middle.sizes["time"] // (_FEWER if len(names) > _MANY else _SAMPLES))
    thinned = middle.isel(time=slice(None, None, step))
    quantities = _quantities(result.laws[law].vessels.sel(vessel=names), middle)
    return {
        "period": result.period,
        "names": names,
        "axes": _rounded(axes_in_space(network)),
        "radius": _rounded(network.radius),
        "quantities": [{"label": label, "values": _rounded(values)} for label, values in quantities.items()],
        "pressure": _rounded(thinned["pressure"].transpose("vessel", "time").values),
        "flow": _rounded(thinned["flow"].transpose("vessel", "time").values),
    }


def _quantities(vessels: xr.Dataset, middle: xr.Dataset) -> dict[str, np.ndarray]:
    """Return every number of each vessel by its name and unit: of the waveforms first, then what is stored."""
    pressure, flow = middle["pressure"], middle["flow"]
    values = {
        "mean pressure [mmHg]": pressure.mean("time").values,
        "pulse pressure [mmHg]": (pressure.max("time") - pressure.min("time")).values,
        "mean flow [ml/s]": flow.mean("time").values,
    }
    for name, value in vessels.data_vars.items():
        if value.dims == ("vessel",) and value.dtype.kind in "fi" and name != "mean_pressure":
            called = _CALLED.get(str(name), str(name).replace("_", " "))
            values[f"{called} [{value.attrs['units']}]"] = value.values.astype(float)
    return values


def _rounded(values: np.ndarray) -> Any:
    """Return numbers of four digits as lists; None where there is no number."""
    return np.vectorize(lambda value: float(f"{value:.4g}") if np.isfinite(value) else None, otypes=[object])(
        values
    ).tolist()


MARKS = (
    f"{AT_BOUND} at a bound of its search; {OPEN} not determined by the data (the ends of its 95 % interval differ by "
    "more than a factor of 4)."
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
