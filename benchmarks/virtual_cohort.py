"""The virtual cohort through the whole analysis of every animal: what is found of its truth and of the paper.

Run: python benchmarks/virtual_cohort.py [--seed 1] [--truth linear|tangent] [--walls linear,tangent] [--starts 4]
"""

import argparse
import time
import warnings
from pathlib import Path

import pandas as pd

from recovery import against_table_1, coverage, quantities_table, recovered, signs
from vasowave.base import VasowaveWarning, texts
from vasowave.study.animal import Animal, Settings, analyze, write_result
from vasowave.study.datasets import virtual_cohort


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--truth", default="linear")
    parser.add_argument("--walls", default="linear,tangent")
    parser.add_argument("--starts", type=int, default=4)
    parser.add_argument("--results", type=Path, help="folder for the results of the animals")
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
        result = analyze(animal, settings)
        if options.results:
            options.results.mkdir(parents=True, exist_ok=True)
            write_result(result, options.results / f"{one.name.replace(' ', '-')}.nc")
        tables.append(recovered(result, one))
        numbers.append(quantities_table(result))
        fitted = texts(one for one in result.findings if one.place.law)
        print(f"{one.name}: {time.perf_counter() - begun:.1f} s; " + " ".join(fitted), flush=True)
    table, values = pd.concat(tables, ignore_index=True), pd.concat(numbers, ignore_index=True)
    print("\nEvery fit\n", table.round(5).to_string())
    print(
        "\nIntervals that hold the truth (half width and error in %, medians)\n", coverage(table).round(1).to_string()
    )
    print("\nGroup means of the measured indices against Table 1\n", against_table_1(values).round(2).to_string())
    print("\nImportance index\n", signs(values).round(2).to_string())


if __name__ == "__main__":
    main()
