"""Whether the shares in the difference of two groups hold the truth where the image of one group is wrong.

uv run python benchmarks/group_attribution.py SEED FACTOR

A virtual cohort whose hypertensive lung is imaged wider by FACTOR; a minute of a processor. Prints every share of mean
and pulse pressure with its interval, the truth by the models that made the recordings, and whether it lies inside, with
and without the error of the images.
"""

import sys
from dataclasses import replace

import pandas as pd

import vasowave as vw
from vasowave.study.cohort import GroupAttribution, gathered
from vasowave.study.datasets import VirtualAnimal, virtual_cohort
from vasowave.study.results import attributed

QUANTITIES = ("mPAP", "pPAP")


def imaged(animal: VirtualAnimal, factor: float) -> vw.Animal:
    """Return an animal whose radii are seen larger."""
    network = animal.network.resized(radius=animal.network.radius * factor)
    return vw.Animal(animal.name, animal.group, network, animal.cycle, synthetic=True)


def true_shares(animals: dict[str, VirtualAnimal], made: GroupAttribution) -> list[pd.DataFrame]:
    """Return the shares by the models that made the recordings, pair by pair."""
    inflows = {name: vw.Inflow(animal.cycle.flow, animal.cycle.period) for name, animal in animals.items()}
    return [
        vw.attribute_change(animals[before].model, animals[after].model, (inflows[before], inflows[after])).table
        for before, after in made.exchanges
    ]


def main(seed: int, factor: float) -> None:
    """Fit a cohort and compare its shares with the truth."""
    animals = {animal.name: animal for animal in virtual_cohort(seed)}
    settings = vw.Settings(walls=("linear",), starts=1)
    results = [
        vw.analyze(imaged(animal, factor if animal.group == "HPH" else 1.0), settings) for animal in animals.values()
    ]
    [made] = attributed(gathered(results, "CTL")).changes
    truth = true_shares(animals, made)
    for quantity in QUANTITIES:
        means, without = made.means(quantity), replace(made, of_images=()).means(quantity)
        true = pd.DataFrame([table.loc[quantity][means.index] for table in truth]).astype(float).mean()
        inside = {
            "inside": true.between(means["low"], means["high"]),
            "inside without images": true.between(without["low"], without["high"]),
        }
        print(f"{quantity} [mmHg]\n{means.assign(truth=true, **inside).round(2).to_string()}")


if __name__ == "__main__":
    main(int(sys.argv[1]), float(sys.argv[2]))
