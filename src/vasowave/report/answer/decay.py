"""The measured diastolic decay beside the model's time constant, which is another number."""

from collections.abc import Mapping

import numpy as np

from vasowave.cohort.cohort import Cohort
from vasowave.cohort.table import column, rows_of
from vasowave.figures.style import short
from vasowave.io.columns import split_unit
from vasowave.report.wording import listed, number

UNLIKE = 0.15
"""Share of the measured decay by which R_T C_T may differ before the page says that the two are not the same."""


def decay(cohort: Cohort, law: str) -> str:
    """Say what the measured decay is (of groups: geometric means), and where R_T C_T is far from it."""
    measured, modeled = (_means(cohort, source, "tau") for source in ("measured", law))
    summed = _means(cohort, law, "tau_plain")
    both = [group for group in modeled if group in measured]
    if not both:
        return ""

    def of(cell: str) -> str:
        group, level, _ = cohort.cells[cell]
        return "" if cohort.single else f" in {short(group, 40)}{f' ({short(level, 40)})' if level else ''}"

    values = listed([f"{number(measured[group])} s{of(group)}" for group in both])
    said = f"The measured diastolic decay has τ = {values}."
    times = {group: modeled[group] / measured[group] for group in both}
    far = [f"{number(one, 2)} times it{of(group)}" for group, one in times.items() if abs(one - 1) > UNLIKE]
    if not far:
        return said
    plain = [f"{number(summed[group])} s{of(group)}" for group in both if group in summed]
    also = f" With the compliances of all vessels summed it is {listed(plain)}." if plain else ""
    return (
        f"{said} R_T C_T is {listed(far)}: it holds the beds' resistance and C_v by the paper's series/parallel rule, "
        f"and says nothing of how fast the pressure decays.{also}"
    )


def _means(cohort: Cohort, source: str, name: str) -> Mapping[str, float]:
    """Return the geometric mean of a time constant in every group (at every occasion or level) that has it."""
    rows = rows_of(cohort.described, source)
    if name not in {split_unit(str(label))[0] for label in rows.columns}:
        return {}
    logs = rows[column(rows, name)].astype(float).map(np.log).groupby(rows["group"], sort=False).mean().dropna()
    return {str(group): float(np.exp(logs[group])) for group in cohort.cells if group in logs.index}
