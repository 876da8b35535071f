"""The calibrated models: waveforms, walls, parameters, starts, waves, impedance, residuals, selection."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr

from vasowave.pulse.quantities import MEANS
from vasowave.study.animal.result import AnimalResult
from vasowave.study.cohort.cohort import Cohort
from vasowave.study.cohort.primary import Primary
from vasowave.study.cohort.table import column, rows_of
from vasowave.study.figures import modeled as figures
from vasowave.study.figures.compared import means_figure
from vasowave.study.figures.fit import PANELS
from vasowave.study.figures.matplotlib_style import color_stops, group_looks, short, source_looks
from vasowave.study.figures.modeled import sites_figure, sites_of
from vasowave.study.figures.network import axes_in_space
from vasowave.study.report.blocks import Block, Drawing, Fold, RotatingView, Section, Table
from vasowave.study.report.tables import models as tables
from vasowave.study.report.tables.models import misfit_table, preference_table, selection_table, sites_table
from vasowave.study.report.wording import column_label, listed, probability

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
        *(tables.parameters(cohort, wall) for wall in cohort.walls),
        *_sites(cohort),
        tables.bounds(cohort),
        *_means(cohort, primary, written),
        Drawing("Waterfall", "S of every start over the best S of its animal, in rising order: a flat line is a "
                "calibration whose starts agree.", figures.waterfall_figure(cohort)),
        tables.starts(cohort),
        *_waves(cohort, primary, written),
        Drawing("Impd", f"Impedance modulus and unwrapped phase (eq. 19) at harmonics 0 to "
                f"{harmonics}{whose}; bars: 95 % by the scatter of the averaged beats, where it is "
                "known; grey circles: harmonics whose flow is near the noise.", figures.impedance_figure(cohort)),
        Drawing("Residuals", "Measured minus simulated pressure and its autocorrelation; inside the grey band an "
                "autocorrelation cannot be told from that of independent noise.", figures.residuals_figure(cohort)),
        misfit_table(cohort),
        *_selection(cohort, law),
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
    return [
        *(Drawing(f"PQsim-{place}", f"Pressure and flow at the middle of chosen vessels of {cohort.name(group)}, "
                  "each with its share of the mean flow.", figures.vessels_figure(result, looks[group].color))
          for place, (group, result) in enumerate(cohort.shown.items(), start=1)),
        *(Drawing(panel.figure, panel.caption, figures.panel_figure(cohort, panel))
          for panel in PANELS.values() if panel.caption),
        Drawing("Tree", "Wave speed at mean pressure in every vessel (eqs. 31, 32), fall of the mean pressure from the "
                "inlet to the end of every terminal vessel, mean shear at the wall (Womersley's profile), and range of "
                "the radius over its mean.",
                figures.along_network_figure(cohort)),
    ]  # fmt: skip


def _sites(cohort: Cohort) -> list[Block]:
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
    return [*blocks, tables.waves(cohort)]


def _selection(cohort: Cohort, law: str) -> list[Block]:
    if not cohort.compared:
        return []
    table: Table = selection_table(cohort)
    if cohort.single:
        return [table]
    return [preference_table(cohort, law), Fold("Model selection, animal by animal", [table])]


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
