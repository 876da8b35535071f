"""How often 95 % intervals hold the truth when model, geometry or recording are wrong, and how wide they are.

    python benchmarks/interval_coverage.py --out found.csv                 10 animals of every row; an hour or more
    python benchmarks/interval_coverage.py --out found.csv --method fit --animals 40      minutes: no posterior
    python benchmarks/interval_coverage.py --out found.csv --docs          tables of what is in the file, into the docs;
                                                                           with --method, only those of one

Every animal of `known_animals` is analyzed twice with default settings: by the fit with its interval (two starts), and
by the posterior (150 draws; where it alone is asked for, it starts from a fit with one start). Each animal is a line in
the file as soon as it is done; a run that was stopped goes on where it was. Animals that have the posteriors of two
laws tell how often the evidence takes the wrong one.
"""

import argparse
import csv
from pathlib import Path

import numpy as np
import pandas as pd
from scipy.stats import beta

from known_animals import ROWS, animal, image_of, priors_of
from robustness_page import put
from vasowave.base import CLEAR_EVIDENCE_RATIO
from vasowave.pulse import derived
from vasowave.pulse.calibration import Search, calibrate
from vasowave.pulse.inference import MAX_PARETO_K, posterior
from vasowave.study.animal import derived_of, errors_of

METHODS = ("fit", "posterior")
QUANTITIES = ("wave_speed", "R_T", "a", "C_p")

PAIRS = {
    "linear": ("linear again", "linear as tangent"),
    "linear, geometry wrong": ("geometry", "geometry, tangent"),
    "linear, stiffness ∝ r^-0.7": ("stiffening", "stiffening, tangent"),
    "linear, taper": ("taper", "taper, tangent"),
    "tangent": ("tangent, linear", "tangent"),
}
"""What is true, and the rows whose animals were analyzed by the linear and by the tangent law."""

FEWEST = 5  # animals of a row that is shown
LEAST = 0.90  # share of intervals that hold the truth, below which an entry is marked
PAGE = Path(__file__).parents[1] / "docs" / "coverage.md"
SELECTION = PAGE.with_name("wall-laws.md")

FIELDS = (
    "row", "animal", "method", "quantity", "truth", "low", "middle", "high", "k_hat", "simulations", "log_evidence",
)  # fmt: skip


def by_fit(fit, network, recording):
    """Return low, middle, high of every quantity as the fit reports them."""
    diastolic = np.full(len(network), recording.diastolic_pressure)

    def derive(values):
        return derived_of(fit, values, diastolic)

    middle, errors = derive(fit.parameters["value"].to_dict()), errors_of(fit, derive)
    reach = {name: np.exp(min(errors[name][1], 200.0)) for name in QUANTITIES}
    return {name: (middle[name] / reach[name], middle[name], middle[name] * reach[name]) for name in QUANTITIES}


def by_posterior(network, recording, wall, fit, priors, draws):
    found = posterior(network, recording, wall, fit=fit, priors=priors, draws=draws)
    columns = ["interval_low", "median", "interval_high"]
    return {name: tuple(found.summary.loc[name, columns]) for name in QUANTITIES}, found.diagnostics


def lines(row, number, methods, draws):
    """Analyze one animal by the methods asked for; yield the lines of the file."""
    recording, model, wall = animal(row, number)
    network, truth = image_of(row), derived(model, recording.mean_pressure)
    fit = calibrate(network, recording, wall, search=Search(starts=2 if "fit" in methods else 1))
    rows = {}
    if "fit" in methods:
        rows["fit"] = (by_fit(fit, network, recording), np.nan, int(fit.starts["simulations"].sum()), np.nan)
    if "posterior" in methods:
        bayes, diagnostics = by_posterior(network, recording, wall, fit, priors_of(row), draws)
        rows["posterior"] = (bayes, diagnostics.k_hat, diagnostics.simulations, diagnostics.log_evidence)
    for method in methods:
        found, *rest = rows[method]
        for name in QUANTITIES:
            yield [row, number, method, name, truth[name], *found[name], *rest]


def entry(group):
    """Return how many intervals hold the truth, their median half width, and the one that all would need, %."""
    inside = int(((group["low"] <= group["truth"]) & (group["truth"] <= group["high"])).sum())
    half = 50 * np.log(group["high"] / group["low"]).median()
    needed = 100 * np.quantile(np.abs(np.log(group["middle"] / group["truth"])), 0.95)
    missing = "**" if inside < LEAST * len(group) else ""
    return f"{missing}{inside}{missing} ({half:.0f}; {needed:.0f})"


def table(path, method):
    """Return the table of one method."""
    data = pd.read_csv(path)
    data = data[data["method"] == method]
    lines = [f"| truth → fitted | animals | {' | '.join(QUANTITIES)} |", "|---|---|" + "---|" * len(QUANTITIES)]
    animals = data.groupby("row")["animal"].nunique()
    for row in [row for row in ROWS if animals.get(row, 0) >= FEWEST]:
        one = data[data["row"] == row]
        cells = [entry(one[one["quantity"] == name]) for name in QUANTITIES]
        lines.append(f"| {ROWS[row].said} | {one['animal'].nunique()} | {' | '.join(cells)} |")
    return "\n".join(lines)


def selection(path):
    """Return how often the evidence takes which law for clearly likelier, by truth."""
    data = pd.read_csv(path)
    data = data[(data["method"] == "posterior") & (data["quantity"] == QUANTITIES[0])].dropna(subset="log_evidence")
    evidence = data.set_index(["row", "animal"])[["log_evidence", "k_hat", "truth", "low", "high"]]
    pairs = {
        truth: evidence.loc[one].join(evidence.loc[other].add_suffix(" of tangent"), how="inner")
        for truth, (one, other) in PAIRS.items()
        if {one, other} <= set(data["row"])
    }
    linear = [both for truth, both in pairs.items() if truth != "tangent"]
    if linear:
        pairs["all whose wall is linear"] = pd.concat(linear)
    header = (
        "| truth | animals | linear clearly likelier | tangent clearly likelier | undecided | taken wrongly: at most "
        "| ln of the evidences' ratio, tangent over linear: median (least; most) | a posterior not to be trusted "
        "| wave speed held by the likelier law's interval |",
        "|---|---|---|---|---|---|---|---|---|",
    )
    return "\n".join([*header, *(_decided(truth, both) for truth, both in pairs.items())])


def _decided(truth, both):
    """Return the line of animals of one truth, with the limit that their number sets to wrong choices."""
    gain = both["log_evidence of tangent"] - both["log_evidence"]
    linear, tangent = (
        int((gain <= -np.log(CLEAR_EVIDENCE_RATIO)).sum()),
        int((gain >= np.log(CLEAR_EVIDENCE_RATIO)).sum()),
    )
    wrong = linear if truth == "tangent" else tangent
    most = beta.ppf(0.95, wrong + 1, len(gain) - wrong) if wrong < len(gain) else 1.0  # Clopper and Pearson, one-sided
    poor = int((both[["k_hat", "k_hat of tangent"]].max(axis=1) > MAX_PARETO_K).sum())
    inside = [both["truth"].between(both["low" + law], both["high" + law]) for law in ("", " of tangent")]
    held = int(inside[0].where(gain < 0, inside[1]).sum())
    spread = f"{gain.median():.1f} ({gain.min():.1f}; {gain.max():.1f})"
    counts = f"{len(gain)} | {linear} | {tangent} | {len(gain) - linear - tangent}"
    return f"| {truth} | {counts} | {100 * most:.1f} % | {spread} | {poor} | {held} |"


def done(path):
    """Return row, animal and method of all that stands in the file."""
    if not path.exists():
        with path.open("w", newline="") as file:
            csv.writer(file).writerow(FIELDS)
    data = pd.read_csv(path)
    return set(data[["row", "animal", "method"]].itertuples(index=False, name=None))


def work(chosen):
    """Yield row, number and methods of the animals that are not in the file yet, every row's first animal first."""
    finished = done(chosen.out)
    for number in range(chosen.first, chosen.first + chosen.animals):
        for row in chosen.rows:
            methods = [one for one in chosen.method if (row, number, one) not in finished]
            if methods:
                yield row, number, methods


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=Path, required=True, help="file of results, one line a quantity")
    parser.add_argument("--animals", type=int, default=10, help="of every row")
    parser.add_argument("--first", type=int, default=0, help="number of the first animal")
    parser.add_argument("--rows", nargs="*", default=list(ROWS), choices=list(ROWS))
    parser.add_argument("--method", nargs="*", default=list(METHODS), choices=list(METHODS))
    parser.add_argument("--draws", type=int, default=150, help="draws of each posterior")
    parser.add_argument("--docs", action="store_true", help="compute nothing; put the tables into docs/coverage.md")
    chosen = parser.parse_args()
    for row, number, methods in [] if chosen.docs else work(chosen):
        found = list(lines(row, number, methods, chosen.draws))
        with chosen.out.open("a", newline="") as file:
            csv.writer(file).writerows(found)
        print(row, number, *(f"{x[2]} {x[3]} {x[4]:.3g} in [{x[5]:.3g}, {x[7]:.3g}]" for x in found[::4]), flush=True)
    for method in chosen.method:
        print(table(chosen.out, method))
        if chosen.docs:
            put(method, table(chosen.out, method), PAGE)
    print(selection(chosen.out))
    if chosen.docs:
        put("laws", selection(chosen.out), SELECTION)


if __name__ == "__main__":
    main()
