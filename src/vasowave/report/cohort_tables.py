"""The tables of the paper, and those that it lacks, for a cohort."""

from collections.abc import Sequence

import numpy as np
import pandas as pd
import xarray as xr

from vasowave.analysis import WAVES
from vasowave.archive import split_unit
from vasowave.cohort import describe
from vasowave.figures.cohort_gallery import Cohort
from vasowave.figures.trees import network, wall_laws
from vasowave.report.cohort_statistics import INDICES, STIFFNESS, Comparison, column, columns, described
from vasowave.report.document import Table
from vasowave.report.wording import Row, column_label, name_and_unit, number

_SUBSCRIPTS = {"_0": "₀", "_1": "₁", "_2": "₂", "cm2": "cm²"}
_PARAMETERS = ("p1_over_gamma", "wave_speed", "R_T", "C_T", "C_p_over_C_T", "tau", "I_R", "a", "S", "RMSE")
MARKS = "† at a bound of its search; ‡ not determined by the data (standard error above half of the value)."


def symbols(trees: Sequence[xr.DataTree]) -> dict[str, str]:
    """Return the symbol of every quantity of the trees, as people write it."""
    found = {}
    for tree in trees:
        for node in tree.children.values():
            for name, value in node["quantities"].data_vars.items() if "quantities" in node.children else ():
                text = str(value.attrs.get("symbol", name))
                for plain, written in _SUBSCRIPTS.items():
                    text = text.replace(plain, written)
                found.setdefault(str(name), text)
    return found


def meanings(trees: Sequence[xr.DataTree]) -> dict[str, str]:
    """Return what every quantity of the trees is, with the paper's equation."""
    found: dict[str, str] = {}
    for tree in trees:
        for node in reversed(list(tree.children.values())):  # the models first: theirs is the general meaning
            for name, value in node["quantities"].data_vars.items() if "quantities" in node.children else ():
                equation = value.attrs.get("equation")
                where = "" if not equation else f" ({equation})" if "Table" in equation else f" (eq. {equation})"
                found.setdefault(str(name), f"{value.attrs.get('long_name', name)}{where}")
    return found


def hemodynamics(cohort: Cohort) -> Table:
    """Mean ± SD of the measured indices ("HemoStats")."""
    rows = cohort.table[cohort.table["source"] == "measured"]
    data = describe(rows, columns(rows, INDICES))
    header = ("index", *(f"{group} (n = {len(trees)})" for group, trees in cohort.groups.items()))
    known = meanings(cohort.trees)
    cells = [
        (_with_unit(label, symbols(cohort.trees)), *(_mean_sd(row) for _, row in part.iterrows()))
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
        caption = f"Dimensions of the vessels of {' and '.join(trees)} (animals {_names(list(trees.values()))})"
        tables.append(Table.of(name, caption, data, "– marks a terminal vessel; the first one is the root."))
    return tables


def nominal(cohort: Cohort) -> Table:
    """Nominal parameters of every animal ("ParNom", eqs. 8 to 12)."""
    names = {"Z_c": "Z_c", "beta": "β₀", "R_T": "R_T0", "tau": "τ₀"}
    rows = []
    for tree in cohort.trees:
        start = tree["nominal"]
        values = {f"{label} [{start[name].attrs['units']}]": float(start[name]) for name, label in names.items()}
        rows.append(_who(tree) | values)
    note = "The tangent wall starts at p₁ = β₀/π and γ = 2 (eq. 10), all vascular beds at a = R₁/R_T = 0.2."
    return Table.of("ParNom", "Nominal parameters of every animal", pd.DataFrame(rows), note)


def bounds(cohort: Cohort) -> Table:
    """Bounds of the searches ("Bounds")."""
    rows = []
    for wall in cohort.walls:
        fits = [tree[f"{wall}/calibration"] for tree in cohort.trees if wall in wall_laws(tree)]
        for place, name in enumerate(fits[0]["parameter"].values):
            unit = str(fits[0]["unit"].values[place])
            low, high, start = (np.array([fit[key].values[place] for fit in fits]) for key in ("lower", "upper", "nominal"))
            rows.append(
                {
                    "wall": wall, "parameter": f"{name} [{unit}]",
                    "lower bound": _range(low), "upper bound": _range(high),
                    "lower / nominal": _range(low / start), "upper / nominal": _range(high / start),
                }
            )  # fmt: skip
    return Table.of("Bounds", "Bounds of the search; ranges over the animals", pd.DataFrame(rows))


def parameters(cohort: Cohort, wall: str) -> Table:
    """Optimized values of every animal with one wall law ("Parameters")."""
    own = ("beta",) if wall == "linear" else ("p1", "gamma")
    table = cohort.table[cohort.table["source"] == wall]
    written = symbols(cohort.trees)
    there = [label for label in columns(table, (*own, *_PARAMETERS)) if np.isfinite(table[label].astype(float)).any()]
    header = ("animal", "group", *(_with_unit(label, written) for label in there))
    trees = {tree.attrs["animal"]: tree for tree in cohort.trees}
    cells: list[Row] = []
    for _, row in table.iterrows():
        fit = trees[row["animal"]][f"{wall}/calibration"]
        marked = [number(row[label]) + _mark(fit, split_unit(label)[0]) for label in there]
        cells.append((row["animal"], row["group"], *marked))
    data = table[["animal", "group", *there]]
    return Table(f"Parameters-{wall}", f"Optimized values, {wall} wall", header, cells, MARKS, data)


def groups(cohort: Cohort) -> Table:
    """Every single number of every source, described by group."""
    data = pd.concat([described(cohort.table, source) for source in cohort.table["source"].unique()])
    header = ("source", "quantity", *(f"{group}: {what}" for group in cohort.groups for what in ("mean ± SD", "median [IQR]")))
    written, cells = symbols(cohort.trees), []
    for (source, label), part in data.groupby(["source", "quantity"], sort=False):
        by_group = part.set_index("group")
        texts = [
            text
            for group in cohort.groups
            for text in ((_mean_sd(by_group.loc[group]), _median_iqr(by_group.loc[group])) if group in by_group.index else ("–", "–"))
        ]
        cells.append((str(source), _with_unit(label, written), *texts))
    return Table("Groups", "All quantities by group", header, cells, "IQR: from the first to the third quartile.", data)


def contrasts(found: Comparison, source: str, written: dict[str, str]) -> Table:
    """The comparison of the groups by one source of numbers."""
    data = found.contrasts
    several = data[["reference", "other"]].drop_duplicates().shape[0] > 1
    pair = data.iloc[0]
    header = ("quantity", *(("groups",) if several else ()), "η", "ratio [95 %]", "Hedges g [95 %]", "p", "p Holm")
    cells = []
    for _, row in data.iterrows():
        between = (f"{row['other']} / {row['reference']}",) if several else ()
        intervals = (_interval(row, "ratio", "ratio"), _interval(row, "Hedges g", "g"))
        cells.append((_with_unit(row["quantity"], written), *between, number(row["eta"], 2), *intervals,
                      number(row["p"], 2), number(row["p Holm"], 2)))  # fmt: skip
    who = "every pair of groups" if several else f"{pair['other']} against {pair['reference']}"
    note = (
        "η: relative change of the mean (eq. 20), never below -1 for a positive quantity; ratio: of geometric means, "
        f"Welch interval; p: exact Mann-Whitney test; Holm over these {len(data)} tests."
    )
    return Table(f"Contrasts-{source}", f"{_source(source)}: {who}", header, cells, note, data)


def without_one(found: Comparison, source: str, written: dict[str, str]) -> Table:
    """What leaving out any one animal does to the comparison."""
    data, cells = found.without_one, []
    for (reference, other, label), part in data.groupby(["reference", "other", "quantity"], sort=False):
        deciding = part.loc[part["decides"], "left out"].astype(str).tolist()
        cells.append((f"{other} / {reference}", _with_unit(label, written), _range(part["ratio"].to_numpy()),
                      _range(part["p"].to_numpy(), 2), ", ".join(deciding) or "none"))  # fmt: skip
    header = ("groups", "quantity", "ratio", "p", "p crosses 0.05 without")
    note = "Smallest and largest value over all ways of leaving one animal out; p of the exact test before Holm."
    return Table(f"LeaveOneOut-{source}", f"{_source(source)}, one animal left out", header, cells, note, data)


def all_groups(found: Comparison, source: str) -> Table:
    """Kruskal-Wallis tests of more than two groups at once."""
    note = "Kruskal-Wallis H; p from random relabelings of the animals, Holm over the quantities."
    return Table.of(f"AllGroups-{source}", f"{_source(source)}: all groups at once", found.all_groups, note, 2)


def starts(cohort: Cohort) -> Table:
    """How many starts of every calibration found its optimum."""
    rows = []
    for tree in cohort.trees:
        row = _who(tree)
        for wall in wall_laws(tree):
            fit = tree[f"{wall}/calibration"]
            row[f"{wall}: starts"] = int(fit.sizes["start"])
            row[f"{wall}: agree"] = int(fit["start_agrees"].values.astype(bool).sum())
            row[f"{wall}: simulations"] = int(fit["start_simulations"].values.sum())
        rows.append(row)
    return Table.of("Starts", "Starts of every calibration, and how many found its optimum", pd.DataFrame(rows))


def characteristic_impedances(cohort: Cohort) -> Table:
    """Z_c of every animal by several estimators (eq. 8)."""
    rows = []
    for tree in cohort.trees:
        spectrum = tree["measured/impedance"]
        values = zip(spectrum["estimator"].values, spectrum["Z_c"].values, strict=True)
        rows.append(_who(tree) | {f"{name} [mmHg s/ml]": float(value) for name, value in values})
    note = "The nominal stiffness follows from the up-slope; where estimators disagree, reflections or delays are at work."
    return Table.of("Zc", "Characteristic impedance by several estimators, measured", pd.DataFrame(rows), note)


def waves(cohort: Cohort) -> Table:
    """Peak, area and time of the largest wave of each kind, by group and source."""
    rows = []
    for tree in cohort.trees:
        for source in ["measured", *wall_laws(tree)]:
            rows += [_who(tree) | {"source": source} | wave for wave in _largest_waves(tree[f"{source}/waves"])]
    data = pd.DataFrame(rows)
    data = data.sort_values("wave", key=lambda wave: wave.map(list(WAVES).index), kind="stable", ignore_index=True)
    measures = [label for label in data.columns if "[" in label]
    header = ("wave", "source", "group", "n", *map(column_label, measures))
    cells = [
        (str(wave), str(source), str(group), str(len(part)),
         *(f"{number(part[label].mean())} ± {number(part[label].std(), 2)}" for label in measures))
        for (wave, source, group), part in data.groupby(["wave", "source", "group"], sort=False)
    ]  # fmt: skip
    note = (
        "Mean ± SD of the largest wave of each kind: F forward, B backward, C compression, D decompression; backward "
        "intensities are negative. Measured: with A₀ and the wave speed that the up-slope gives."
    )
    return Table("Waves", "Single waves at the inlet", header, cells, note, data)


def selection(cohort: Cohort) -> Table:
    """AICc and BIC of both wall laws under every noise model, for every animal, best first ("AICcBIC")."""
    data = pd.concat([_candidates(tree) for tree in cohort.trees if "selection" in tree.children], ignore_index=True)
    return Table.of("AICcBIC", "AICc and BIC of the wall laws; the lower score is better", data, _SELECTION_NOTE)


_SELECTION_NOTE = (
    "Differences below 5 decide nothing. λ: weight of the regularization; noise models that need more than allowed are "
    "discarded and stand last."
)


def _candidates(tree: xr.DataTree) -> pd.DataFrame:
    frame = tree["selection"].to_dataset().to_dataframe().reset_index(drop=True)
    keys = [key for key in frame.columns if key not in ("wall", "loglik", "D", "N", "AICc", "BIC", "lambda", "discarded")]
    rows = []
    for which, part in frame.groupby(keys, sort=False):
        scores = part.set_index("wall")
        best = {criterion: scores[criterion].idxmin() for criterion in ("AICc", "BIC")}
        row: dict[str, object] = _who(tree) | dict(zip(keys, which if isinstance(which, tuple) else (which,), strict=True))
        for criterion in ("AICc", "BIC"):
            row |= {f"{criterion} {wall}": float(scores.loc[wall, criterion]) for wall in scores.index}
            gap = float(scores[criterion].max() - scores[criterion].min())
            discarded = bool(scores["discarded"].astype(bool).any())
            row[f"{criterion} prefers"] = "discarded" if discarded else best[criterion] if gap >= 5 else "undecided"
        row |= {"λ": float(scores["lambda"].max()), "N": int(scores["N"].iloc[0])}
        row["D"] = ", ".join(f"{int(scores.loc[wall, 'D'])}" for wall in scores.index)
        rows.append(row)
    found = pd.DataFrame(rows)
    score = found[[label for label in found.columns if label.startswith("AICc ") and "prefers" not in label]].min(axis=1)
    order = pd.DataFrame({"last": found["AICc prefers"] == "discarded", "score": score}).sort_values(["last", "score"])
    return found.loc[order.index]


def _largest_waves(data: xr.DataTree) -> list[dict[str, object]]:
    found: dict[str, dict[str, object]] = {}
    for row in np.argsort(-np.abs(data["wave_area"].values), kind="stable"):
        name = str(data["wave_name"].values[row])
        values = {
            "peak [W/cm2/s2]": float(data["wave_peak"][row]), "area [W/cm2/s]": float(data["wave_area"][row]),
            "time/T [1]": float(data["wave_time"][row]) / float(data.attrs["period"]),
        }  # fmt: skip
        found.setdefault(name, {"wave": name} | values)
    return list(found.values())


def intervals(tree: xr.DataTree, written: dict[str, str]) -> Table:
    """What was calibrated for one animal, with 95 % intervals where they are known."""
    names = {wall: [str(name) for name in tree[f"{wall}/quantities"].data_vars] for wall in wall_laws(tree)}
    cells = []
    for name in dict.fromkeys(name for found in names.values() for name in found):
        unit = next(tree[f"{wall}/quantities"][name].attrs["units"] for wall in names if name in names[wall])
        values = [_with_interval(tree, wall, name) if name in names[wall] else "" for wall in names]
        cells.append((_with_unit(f"{name} [{unit}]", written), *values))
    return Table("", "Calibrated values [95 % interval]", ("quantity", *(f"{wall} wall" for wall in names)), cells)


def _with_interval(tree: xr.DataTree, wall: str, name: str) -> str:
    value = tree[f"{wall}/quantities"][name]
    text = number(float(value)) + _mark(tree[f"{wall}/calibration"], name)
    if "interval_low" not in value.attrs:
        return text
    low, high = float(value.attrs["interval_low"]), float(value.attrs["interval_high"])
    return f"{text} [{number(low, 2)}, {number(high, 2)}]"


def _mark(fit: xr.DataTree, name: str) -> str:
    names = [str(parameter) for parameter in fit["parameter"].values]
    if name not in names:
        return ""
    place = names.index(name)
    if fit["at_bound"].values[place]:
        return " †"
    return "" if fit["determined"].values[place] or not fit["free"].values[place] else " ‡"


def _who(tree: xr.DataTree) -> dict[str, object]:
    return {"animal": str(tree.attrs["animal"]), "group": str(tree.attrs["group"])}


def _names(trees: Sequence[xr.DataTree]) -> str:
    return ", ".join(str(tree.attrs["animal"]) for tree in trees)


def _source(source: str) -> str:
    return "Measured indices" if source == "measured" else f"{source.capitalize()} wall"


def _with_unit(label: object, written: dict[str, str]) -> str:
    name, unit = name_and_unit(label)
    return f"{written.get(name, name)} [{unit}]" if unit else written.get(name, name)


def _mean_sd(row: pd.Series) -> str:
    return number(row["mean"]) + (f" ± {number(row['SD'], 2)}" if np.isfinite(row["SD"]) else "")


def _median_iqr(row: pd.Series) -> str:
    return f"{number(row['median'])} [{number(row['Q1'])}, {number(row['Q3'])}]"


def _interval(row: pd.Series, center: str, name: str) -> str:
    return f"{number(row[center], 2)} [{number(row[f'{name} low'], 2)}, {number(row[f'{name} high'], 2)}]"


def _range(values: np.ndarray, digits: int = 3) -> str:
    low, high = number(float(values.min()), digits), number(float(values.max()), digits)
    return low if low == high else f"{low} to {high}"


