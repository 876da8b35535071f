"""The table of further sites: how each is predicted without it, and what it adds."""

from collections.abc import Mapping

import pandas as pd
import xarray as xr

from vasowave.animal.law_result import LawResult
from vasowave.cohort.cohort import Cohort
from vasowave.figures.sites import sites_of
from vasowave.quantities import QUANTITIES
from vasowave.report.blocks import Table
from vasowave.report.tables.cells import symbols, who
from vasowave.report.wording import number, with_interval

_TOLD = ("wave_speed", "R_T")
"""Quantities on the page; the file has every parameter."""

_ENDS = ("value", "low", "high")

NOTE = (
    "Ratio: observed over what the recording at the inlet alone predicts, by least squares. Misfit: root mean square "
    "of what the fit without the site misses there, over what its error, the model's and the spread of that fit let "
    "expect; about 1 or less is agreement, more than 3 is a finding. With: 95 % interval of the fit to all sites; "
    "without: of the fit to all but this one. The CSV file has them for every parameter."
)


def sites_table(cohort: Cohort) -> Table:
    """Return a row for every site of every animal and wall law; its data have one for every quantity of these."""
    written = symbols(cohort)
    header = ("animal", "wall law", "site", "ratio", "misfit",
              *(f"{written.get(name, name)} {how} [{QUANTITIES[name].unit}]"
                for name in _TOLD for how in ("with", "without")))  # fmt: skip
    cells, rows = [], []
    for result in cohort.results:
        for wall, data in sites_of(result).items():
            units = _units(result.laws[wall])
            for site in range(data.sizes["site"]):
                one = data.isel(site=site)
                name, ratio, misfit = str(one["site"].item()), float(one["ratio"]), float(one["misfit"])
                told = [_interval(one.sel(quantity=each), how) for each in _TOLD for how in ("", "_without")]
                cells.append((result.name, wall, name, number(ratio, 3), number(misfit, 2), *told))
                known = who(result) | {"wall law": wall, "site": name, "ratio [1]": ratio, "misfit [1]": misfit}
                rows += [known | _row(one.sel(quantity=each), units) for each in data["quantity"].values]
    return Table("Sites", "Further sites: predicted without each, and what it adds", header, cells, NOTE,
                 pd.DataFrame(rows))  # fmt: skip


def _units(law: LawResult) -> dict[str, str]:
    """Return the units of the quantities that sites tell something of."""
    parameters = zip(law.calibration["parameter"].values, law.calibration["unit"].values, strict=True)
    return {str(name): str(unit) for name, unit in parameters} | {name: QUANTITIES[name].unit for name in _TOLD}


def _row(one: xr.Dataset, units: Mapping[str, str]) -> dict[str, object]:
    """Return the cells of one quantity."""
    name = str(one["quantity"].item())
    both = {f"{end}{how.replace('_', ' ')}": float(one[f"{end}{how}"]) for how in ("", "_without") for end in _ENDS}
    return {"quantity": name, "unit": units[name], **both}


def _interval(one: xr.Dataset, how: str) -> str:
    value, low, high = (float(one[f"{end}{how}"]) for end in _ENDS)
    return with_interval(value, low, high)
