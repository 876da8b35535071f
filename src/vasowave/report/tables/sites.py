"""The table of further sites: how each is predicted without it, and what it adds."""

import numpy as np
import pandas as pd

from vasowave.cohort.cohort import Cohort
from vasowave.figures.sites import sites_of
from vasowave.report.blocks import Table
from vasowave.report.tables.cells import who

_TOLD = {"wave_speed": "cm/s", "R_T": "mmHg s/ml"}
"""Quantities whose intervals are compared, and their units."""

NOTE = (
    "Ratio: observed over what the recording at the inlet alone predicts, by least squares. Misfit: root mean square "
    "of what the fit without the site misses there, over what its error, the model's and the spread of that fit let "
    "expect; about 1 or less is agreement, more than 3 is a finding. Narrower: share of the 95 % interval (of the "
    "logarithm) that the site takes away; less than 0 where it disagrees with the others."
)


def sites_table(cohort: Cohort) -> Table:
    """Return a row for every site of every animal and wall law."""
    rows = []
    for result in cohort.results:
        for wall, data in sites_of(result).items():
            for site in range(data.sizes["site"]):
                one = data.isel(site=site)
                row = who(result) | {
                    "wall law": wall, "site": str(one["site"].item()), "ratio [1]": float(one["ratio"]),
                    "misfit [1]": float(one["misfit"]),
                }  # fmt: skip
                for name, unit in _TOLD.items():
                    here = one.sel(quantity=name)
                    width, without = (np.log(float(here[f"high{end}"] / here[f"low{end}"])) for end in ("", "_without"))
                    row[f"{name} [{unit}]"] = float(here["value"])
                    row[f"{name} without [{unit}]"] = float(here["value_without"])
                    row[f"{name} narrower [%]"] = 100 * (1 - width / without)
                rows.append(row)
    return Table.of("Sites", "Further sites: predicted without each, and what it adds", pd.DataFrame(rows), NOTE)
