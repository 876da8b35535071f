"""A cohort whose fits are made from formulas: real analyses and real trees, no search behind them."""

import numpy as np
import pytest

import made_fit
from vasowave.datasets import control_network, hypertensive_network
from vasowave.datasets.raw import synthetic_raw_recording
from vasowave.recording import Recording
from vasowave.subject import Animal, Settings, analyze

NETWORKS = {"HPH": hypertensive_network}


def made_trees(groups, *, raw=True, walls=("linear", "tangent"), selection=False):
    """Return the trees of a cohort; `groups` says how many animals each has, later groups are stiffer."""
    rng = np.random.default_rng(7)
    trees = []
    for place, (group, count) in enumerate(groups.items()):
        for number in range(1, count + 1):
            factor = (1 + 0.8 * place) * np.exp(0.12 * rng.standard_normal())
            trees.append(made_tree(f"{group} {number}", group, factor, rng, raw, walls, selection))
    return trees


def made_tree(name, group, factor, rng, raw, walls, selection):
    """Return one animal whose pressure and stiffness are `factor` times those of `made_fit`."""
    base = made_fit.made_recording(count=128)
    cycle = Recording(
        base.pressure * factor, base.flow * np.exp(0.08 * rng.standard_normal()), base.period, f"synthetic {name}"
    )
    network = NETWORKS.get(group, control_network)()
    if raw:
        animal = Animal.from_raw(
            name, group, network, synthetic_raw_recording(cycle, rng, duration=8.0).raw, synthetic=True
        )
    else:
        animal = Animal(name, group, network, cycle, synthetic=True)

    def fitted(network, recording, wall, **more):
        return made_fit.made_fit(wall, recording=recording, network=network, factor=factor)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("vasowave.subject.pipeline.calibrate", fitted)
        return analyze(animal, Settings(starts=4, walls=walls, selection=selection))
