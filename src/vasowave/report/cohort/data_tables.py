"""Tables of what was measured: HemoStats, Network, ParNom, and Z_c by several estimators."""

import pandas as pd
import xarray as xr

from vasowave.animal.reading import data_of, network
from vasowave.cohort.comparison import INDICES, columns
from vasowave.cohort.statistics import describe
from vasowave.figures.cohort_gallery import Cohort
from vasowave.report.cohort.cells import mean_sd, meanings, names, symbols, who, with_unit
from vasowave.report.document import Table


def hemodynamics(cohort: Cohort) -> Table:
    """Mean ± SD of the measured indices ("HemoStats")."""
    rows = cohort.table[cohort.table["source"] == "measured"]
    data = describe(rows, columns(rows, INDICES))
    header = ("index", *(f"{group} (n = {len(trees)})" for group, trees in cohort.groups.items()))
    known = meanings(cohort.trees)
    cells = [
        (with_unit(label, symbols(cohort.trees)), *(mean_sd(row) for _, row in part.iterrows()))
        for label, part in data.groupby("quantity", sort=False)
    ]
    note = "; ".join(f"{name}: {known[name].split(' (')[0]}" for name in INDICES if name in known)
    return Table("HemoStats", "Hemodynamic indices, mean ± SD", header, cells, f"{note}.", data)


def networks(cohort: Cohort) -> list[Table]:
    """Connectivity and size of the vessels ("Network"), side by side where the groups' vessels are the same."""
    tables: list[Table] = []
    by_topology: dict[tuple[str, ...], dict[str, xr.DataTree]] = {}
    for group, tree in cohort.shown.items():
        vessels = network(tree)
        by_topology.setdefault((*vessels.name, *map(str, vessels.parent)), {})[group] = tree
    for trees in by_topology.values():
        first = network(next(iter(trees.values())))
        data = pd.DataFrame(
            {
                "vessel": first.name,
                "daughters": [", ".join(first.name[row] for row in rows) or "–" for rows in first.daughters],
            }
        )
        for group, tree in trees.items():
            vessels = network(tree)
            data[f"r0 {group} [cm]"], data[f"L {group} [cm]"] = vessels.radius, vessels.length
        name = "Network" if not tables else f"Network-{len(tables) + 1}"
        caption = f"Dimensions of the vessels of {' and '.join(trees)} (animals {names(list(trees.values()))})"
        tables.append(Table.of(name, caption, data, "– marks a terminal vessel; the first one is the root."))
    return tables


def nominal(cohort: Cohort) -> Table:
    """Nominal parameters of every animal ("ParNom", eqs. 8 to 12)."""
    names = {"Z_c": "Z_c", "beta": "β₀", "R_T": "R_T0", "tau": "τ₀"}
    rows = []
    for tree in cohort.trees:
        start = data_of(tree, "nominal")
        values = {f"{label} [{start[name].attrs['units']}]": float(start[name]) for name, label in names.items()}
        rows.append(who(tree) | values)
    note = "The tangent wall starts at p₁ = β₀/π and γ = 2 (eq. 10), all vascular beds at a = R₁/R_T = 0.2."
    return Table.of("ParNom", "Nominal parameters of every animal", pd.DataFrame(rows), note)


def characteristic_impedances(cohort: Cohort) -> Table:
    """Z_c of every animal by several estimators (eq. 8)."""
    rows = []
    for tree in cohort.trees:
        spectrum = data_of(tree, "measured/impedance")
        values = zip(spectrum["estimator"].values, spectrum["Z_c"].values, strict=True)
        rows.append(who(tree) | {f"{name} [mmHg s/ml]": float(value) for name, value in values})
    note = (
        "The nominal stiffness follows from the up-slope; where estimators disagree, reflections or delays are at work."
    )
    return Table.of("Zc", "Characteristic impedance by several estimators, measured", pd.DataFrame(rows), note)
