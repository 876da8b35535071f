"""Which stenosis is worth most, against the direct simulation of the tree that made the recording."""

from dataclasses import replace

import numpy as np
import pytest

import vasowave as vw
from vasowave.pulse.calibration import calibrate


def tree(random, outlets):
    """A binary tree: the widest open end divides, by Murray's law, until there are so many."""
    parent, length, radius, ends = [-1], [0.4], [0.05], [0]
    while len(ends) < outlets:
        row = max(ends, key=lambda end: radius[end])
        ends.remove(row)
        share = random.uniform(0.3, 0.7)
        for part in (share, 1 - share):
            parent.append(row)
            radius.append(radius[row] * part ** (1 / 3))
            length.append(random.uniform(6, 12) * radius[-1])
            ends.append(len(parent) - 1)
    return vw.Network(tuple(str(row + 1) for row in range(len(parent))), parent, length, radius)


def numbers(model, driven):
    waves = vw.simulate(model, driven).sel(vessel="1", station="inlet")
    pressure = waves.pressure.values
    return pressure, np.array([pressure.mean(), np.ptp(pressure), 0.1333224 * np.mean(pressure * waves.flow.values)])


def stenosed(model, stenoses):
    for vessel, size in stenoses.items():
        model = vw.narrowed(model, vessel, *size)
    return model


@pytest.mark.validation
@pytest.mark.filterwarnings("ignore::vasowave.base.findings.FindingWarning")
@pytest.mark.parametrize("seed", [3, 4])
def test_the_ranking_of_a_tree_of_twenty_beds_is_that_of_its_direct_simulation(seed):
    random, mouse = np.random.default_rng(seed), vw.virtual_mouse()
    network = tree(random, 20)
    beds = vw.estimate_nominal(network, mouse).outlets.scaled(*np.exp(random.normal(0, 0.2, 3)))
    free = vw.Model(network, vw.LinearWall(random.uniform(50, 110)), beds)
    inner = [row for row in range(1, len(network)) if network.daughters[row] and network.length[row] > 0.2]
    chosen = random.choice(inner, 4, replace=False)
    stenoses = {network.name[row]: (random.uniform(0.7, 0.93), random.uniform(0.03, 0.06)) for row in chosen}
    pressure, before = numbers(stenosed(free, stenoses), mouse)
    smooth = np.convolve(np.tile(random.normal(size=512), 3), np.hanning(40), "same")[512:1024]
    noise = 0.15 * (smooth - smooth.mean()) / smooth.std()
    recording = vw.Recording(pressure + np.interp(np.linspace(0, 512, len(pressure), False), np.arange(512), noise),
                             mouse.flow, mouse.period)  # fmt: skip
    table = vw.rank_stenoses(calibrate(network, recording, search=vw.Search(starts=2)), stenoses, draws=12)
    gains = {}
    for vessel in stenoses:
        others = {name: size for name, size in stenoses.items() if name != vessel}
        gains[vessel] = before - numbers(stenosed(free, others), mouse)[1]
    assert [*table.index[:-1]] == sorted(gains, key=lambda vessel: -gains[vessel][0])
    gains["all of them"] = before - numbers(free, mouse)[1]
    held = [
        table.loc[vessel, f"{name}_low"] <= gain <= table.loc[vessel, f"{name}_high"]
        for vessel, row in gains.items()
        for name, gain in zip(("mPAP", "pPAP", "power"), row, strict=True)
    ]
    assert np.mean(held) >= 0.85


def test_without_draws_there_are_gains_and_no_chances_and_all_together_give_most():
    network = vw.Network(("1", "2", "3"), [-1, 0, 0], [0.4, 0.3, 0.3], [0.05, 0.04, 0.04])
    fit = calibrate(network, vw.virtual_mouse(), search=vw.Search(starts=1))
    table = vw.rank_stenoses(fit, {"2": (0.5, 0.03), "3": (0.7, 0.03)}, draws=0)
    assert [*table.index] == ["3", "2", "all of them"]
    assert table["first"].isna().all()
    assert table["mPAP"].idxmax() == "all of them"
    assert any("regulates itself" in text for text in table.attrs["assumptions"])


@pytest.mark.parametrize(
    ("stenoses", "message"),
    [({}, "no stenoses to rank"), ({"7": (0.5, 0.03)}, "no vessel '7'"), ({"2": 0.5}, "share of the area"),
     ({"2": (1.5, 0.03)}, "closes 1.5 of the area"), (["2"], "no stenoses to rank")],
)  # fmt: skip
def test_what_is_no_stenosis_is_refused(stenoses, message):
    network = vw.Network(("1", "2", "3"), [-1, 0, 0], [0.4, 0.3, 0.3], [0.05, 0.04, 0.04])
    fit = calibrate(network, vw.virtual_mouse(), search=vw.Search(starts=1))
    with pytest.raises(vw.errors.InputError, match=message):
        vw.rank_stenoses(fit, stenoses, draws=0)


def test_a_ranking_tells_how_far_it_is_and_can_be_interrupted():
    fit = calibrate(vw.control_network(), vw.virtual_mouse(), search=vw.Search(starts=1))
    heard = []

    def interrupted(done, count):
        heard.append((done, count))
        if done == 1:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        vw.rank_stenoses(fit, {"2": (0.8, 0.05)}, draws=50, progress=interrupted)
    assert heard == [(0, 50), (1, 50)]


@pytest.mark.filterwarnings("ignore::vasowave.base.findings.FindingWarning")
def test_a_ranking_is_simulated_as_finely_as_the_fit():
    tube, mouse = vw.Network(("1",), [-1], [0.4], [0.05]), vw.virtual_mouse()
    search = vw.Search(starts=1, fixed={"r1": 1.0, "r2": 1.0, "c1": 1.0})
    fit = calibrate(tube, mouse, search=search, numerics=vw.Numerics(cell_size=0.2))
    gains = [vw.rank_stenoses(same, {"1": (0.8, 0.05)}, draws=0).loc["1", "pPAP"]
             for same in (fit, replace(fit, numerics=vw.Numerics()))]  # fmt: skip
    assert gains[0] == pytest.approx(gains[1], rel=0.5)
    assert gains[0] != pytest.approx(gains[1], rel=1e-4)
