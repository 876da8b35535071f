"""The virtual cohort through the whole analysis of every animal: what is found of its truth and of the paper.

Run: python benchmarks/virtual_cohort.py [--seed 1] [--truth linear|tangent] [--walls linear,tangent] [--starts 4]
"""

import argparse
import json
import time
import warnings
from pathlib import Path

import numpy as np
import pandas as pd

from vasowave.cohort import importance_index
from vasowave.datasets import published_table
from vasowave.datasets.recovery import coverage, recovered
from vasowave.datasets.virtual_cohort import virtual_cohort
from vasowave.errors import VasowaveWarning
from vasowave.subject import Animal, Settings, analyze, write_tree

SIGNS = {
    "HR": 1, "CO": -1, "mPAP": 1, "sPAP": 1, "dPAP": 1, "pPAP": 1, "PVR": 1, "beta": 1, "p1_over_gamma": 1, "R_T": 1,
    "C_T": -1, "C_v": -1, "C_v_plain": -1, "C_p": -1, "C_p_over_C_T": -1, "tau": -1, "I_R": 1, "a": 1,
}  # fmt: skip
"""Signs of η in the paper's figure "ParAll_change"; that of C_p/C_T from its figure "ParOpt" (linear wall)."""


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--truth", default="linear")
    parser.add_argument("--walls", default="linear,tangent")
    parser.add_argument("--starts", type=int, default=4)
    parser.add_argument("--trees", type=Path, help="folder for the trees of the animals")
    options = parser.parse_args()
    warnings.simplefilter("ignore", VasowaveWarning)
    pd.set_option("display.width", 200)
    settings = Settings(walls=tuple(options.walls.split(",")), starts=options.starts)
    begun = time.perf_counter()
    cohort = virtual_cohort(options.seed, options.truth)
    print(f"{len(cohort)} animals made in {time.perf_counter() - begun:.1f} s (compilation included)")
    tables, numbers = [], []
    for one in cohort:
        begun = time.perf_counter()
        animal = Animal.from_raw(one.name, one.group, one.network, one.raw, synthetic=True)
        tree = analyze(animal, settings)
        if options.trees:
            options.trees.mkdir(parents=True, exist_ok=True)
            write_tree(tree, options.trees / f"{one.name.replace(' ', '-')}.nc")
        tables.append(recovered(tree, one))
        for source in ("measured", *settings.walls):
            row = {name: float(value) for name, value in tree[f"{source}/quantities"].data_vars.items()}
            numbers.append({"animal": one.name, "group": one.group, "source": source, **row})
        fitted = [note for note in json.loads(tree.attrs["notes"]) if " wall: " in note]
        print(f"{one.name}: {time.perf_counter() - begun:.1f} s; " + " ".join(fitted), flush=True)
    table, values = pd.concat(tables, ignore_index=True), pd.DataFrame(numbers)
    print("\nEvery fit\n", table.round(5).to_string())
    print(
        "\nIntervals that hold the truth (half width and error in %, medians)\n", coverage(table).round(1).to_string()
    )
    print("\nGroup means of the measured indices against Table 1\n", against_table_1(values).round(2).to_string())
    print("\nImportance index\n", signs(values).round(2).to_string())


def against_table_1(values: pd.DataFrame) -> pd.DataFrame:
    """Return group means, the published ones and their difference in published SD."""
    means = values[values["source"] == "measured"].groupby("group").mean(numeric_only=True)
    rows = []
    for _, row in published_table("hemodynamics").iterrows():
        for group in ("CTL", "HPH"):
            name, mean = row["quantity"], means.loc[group, row["quantity"]]
            published, sd = row[f"{group} mean"], row[f"{group} SD"]
            rows.append((name, group, mean, published, sd, (mean - published) / sd))
    return pd.DataFrame(rows, columns=["quantity", "group", "mean", "published", "published SD", "difference / SD"])


def signs(values: pd.DataFrame) -> pd.DataFrame:
    """Return η of every quantity and source, and whether its sign is the paper's."""
    rows = []
    for source, part in values.groupby("source", sort=False):
        means = part.groupby("group").mean(numeric_only=True)
        for name, sign in SIGNS.items():
            if name in means.columns and np.isfinite(means[name]).all():
                eta = importance_index(means.loc["CTL", name], means.loc["HPH", name])
                rows.append((source, name, means.loc["CTL", name], means.loc["HPH", name], eta, np.sign(eta) == sign))
    return pd.DataFrame(rows, columns=["source", "quantity", "CTL", "HPH", "eta", "sign as in the paper"])


if __name__ == "__main__":
    main()
