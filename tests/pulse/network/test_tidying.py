from pathlib import Path

import numpy as np
import pytest

import vasowave as vw
from vasowave.base import InputError, VasowaveWarning
from vasowave.pulse.model import estimate_nominal, linear_solution, windkessels
from vasowave.pulse.network import SHORTEST, Network, repaired, tidy

FOREIGN = Path(__file__).parents[4] / "shared/data/structured-trees/net_chambers_C1_hard.csv"


def resistance(network):
    """Resistance of the whole tree to Poiseuille flow, all terminals at one pressure."""

    def below(row):
        daughters = network.daughters[row]
        beyond = 1 / sum(1 / below(one) for one in daughters) if daughters else 0.0
        return network.length[row] / network.radius[row] ** 4 + beyond

    return below(network.root)


def compliance(network):
    return float(network.length @ network.radius**2)


def made(rng, levels=3):
    """A tree of two daughters a junction."""
    names, parent, length, radius = ["0"], [-1], [0.4], [0.05]
    level = [0]
    for _ in range(levels):
        fresh = []
        for row in level:
            for _ in range(2):
                fresh.append(len(names))
                names.append(str(len(names)))
                parent.append(row)
                length.append(rng.uniform(0.1, 0.4))
                radius.append(radius[row] * rng.uniform(0.6, 0.9))
        level = fresh
    return Network(tuple(names), parent, length, radius)


def cut(network, row, share):
    """The network with one vessel cut in two pieces in line."""
    count = len(network)
    parent = network.parent.copy()
    parent[list(network.daughters[row])] = count
    length = np.append(network.length, share * network.length[row])
    length[row] *= 1 - share
    return Network(
        (*network.name, "piece"), [*parent, row], length, [*network.radius, network.radius[row]],
        pressure=network.pressure,
    )  # fmt: skip


@pytest.mark.parametrize("row", [0, 2, 9])
def test_a_vessel_cut_in_two_becomes_one_again(row):
    network = made(np.random.default_rng(row))
    again = tidy(cut(network, row, 0.3))
    parts = ["piece", network.name[row]]
    kept = "piece" if row in network.terminals else network.name[row]  # a terminal's bed may be called by its name
    assert [(one.code, one.vessel, one.into) for one in again.repairs] == [("joined", *sorted(parts, key=kept.__eq__))]
    np.testing.assert_allclose(again.network.length, network.length, rtol=1e-12)
    np.testing.assert_allclose(again.network.radius, network.radius, rtol=1e-12)
    assert again.network.name == tuple(kept if name == network.name[row] else name for name in network.name)
    np.testing.assert_array_equal(again.network.parent, network.parent)


def test_a_chain_of_unlike_vessels_keeps_resistance_and_compliance():
    chain = Network(("a", "b", "c", "left", "right"), [-1, 0, 1, 2, 2], [0.1, 0.2, 0.3, 0.2, 0.2],
                    [0.05, 0.04, 0.045, 0.03, 0.02])  # fmt: skip
    tidied = tidy(chain)
    assert tidied.network.name == ("a", "left", "right")
    assert resistance(tidied.network) == pytest.approx(resistance(chain), rel=1e-12)
    assert compliance(tidied.network) == pytest.approx(compliance(chain), rel=1e-12)


@pytest.mark.parametrize("seed", range(5))
def test_a_vessel_too_short_for_a_wave_hands_resistance_and_compliance_to_its_daughters(seed):
    rng = np.random.default_rng(seed)
    network = made(rng)
    row = int(rng.choice([1, 2, 3, 4]))
    length = network.length.copy()
    length[row] = 1.4e-4
    short = Network(network.name, network.parent, length, network.radius)
    tidied = tidy(short)
    assert [(one.code, one.vessel) for one in tidied.repairs] == [("merged", network.name[row])]
    assert len(tidied.network) == len(network) - 1
    assert tidied.added_volume == 0.0
    assert compliance(tidied.network) == pytest.approx(compliance(short), rel=1e-12)
    # With the flow that the daughters share, each loses the pressure of the short vessel and its own.
    below = [tidied.network.row(network.name[one]) for one in network.daughters[row]]
    conductance = network.radius**4 / network.length
    share = conductance[list(network.daughters[row])] / conductance[list(network.daughters[row])].sum()
    for place, one, part in zip(below, network.daughters[row], share, strict=True):
        lost = part * tidied.network.length[place] / tidied.network.radius[place] ** 4
        assert lost == pytest.approx(part / conductance[one] + short.length[row] / short.radius[row] ** 4, rel=1e-12)


def test_what_is_known_of_radii_is_kept():
    lung = Network(("a", "b", "left", "right"), [-1, 0, 1, 1], [0.2, 0.2, 0.2, 0.2], [0.05, 0.05, 0.03, 0.03],
                   pressure=6.3, radius_sd=[0.002, 0.004, np.nan, 0.001])  # fmt: skip
    tidied = tidy(lung).network
    assert tidied.pressure == 6.3
    np.testing.assert_allclose(tidied.radius_sd, [0.003, np.nan, 0.001])


@pytest.mark.parametrize("shortest", [-1.0, np.nan, np.inf])
def test_an_impossible_shortest_vessel_is_refused(shortest):
    with pytest.raises(InputError, match="shortest vessel"):
        tidy(vw.control_network(), shortest)


@pytest.mark.skipif(not FOREIGN.is_file(), reason=f"no measured network at {FOREIGN}")
def test_repairs_of_a_measured_tree_do_not_change_its_impedance():
    network, mouse = vw.read_network(FOREIGN), vw.virtual_mouse()
    tidied = tidy(network)
    assert {one.code for one in tidied.repairs} == {"merged", "lengthened"}
    spectra = []
    for one in (network, tidied.network):
        beds = estimate_nominal(network, mouse).outlets if one is network else estimate_nominal(one, mouse).outlets
        solution = linear_solution(vw.Model(one, vw.LinearWall(60.0), beds), mouse.inflow, 10)
        spectra.append(solution.pressure[:, one.root])
    # The pressure's own largest harmonics; a fit leaves 1 to 3 % of them.
    np.testing.assert_allclose(spectra[1], spectra[0], atol=0.003 * abs(spectra[0][0]), rtol=0)


def test_unasked_a_micrometer_vessel_goes_a_chain_of_long_ones_stays_and_the_record_says_it():
    whole = made(np.random.default_rng(3))
    chain = cut(whole, 1, 0.5)
    stub = Network(
        (*chain.name, "stub"), [*np.where(chain.parent == 1, len(chain), chain.parent), 1], [*chain.length, 1e-4],
        [*chain.radius, 0.9 * chain.radius[1]], pressure=chain.pressure,
    )  # fmt: skip
    network, (record,) = repaired(stub)
    assert network.name == chain.name  # both halves of the chain are still there
    assert record.code == "network.repaired"
    assert "'stub' (0.0001 cm)" in str(record)
    assert resistance(network) == pytest.approx(resistance(stub), rel=1e-9)
    assert compliance(network) == pytest.approx(compliance(stub), rel=1e-9)
    assert repaired(whole) == (whole, [])


def test_unasked_nothing_is_repaired_that_would_add_volume():
    short = Network(("main", "left", "right"), [-1, 0, 0], [0.4, 1e-4, 0.2], [0.05, 0.04, 0.03])
    network, (record,) = repaired(short)
    assert network is short
    assert record.code == "network.not-repaired"
    added = 0.04**2 * (SHORTEST * 0.04 - 1e-4) / compliance(short)
    assert dict(record.values)["percent"] == pytest.approx(100 * added)


def test_a_vessel_with_one_daughter_is_warned_about_and_repaired(tmp_path):
    (tmp_path / "chain.csv").write_text("name,parent,length [cm],radius [cm]\na,,0.4,0.04\nb,a,0.3,0.03\n", "utf-8")
    with pytest.warns(VasowaveWarning, match="one daughter"):
        network = vw.read_network(tmp_path / "chain.csv")
    assert tidy(network).network.name == ("b",)  # the bed's vessel keeps its name


def chains(rng, fall, links=4):
    """A tree of seven chains, whose links narrow by `fall`, more or less."""
    names, parent, length, radius = [], [], [], []

    def chain(above, first, depth):
        for _ in range(links):
            names.append(f"v{len(names)}")
            parent.append(above)
            length.append(rng.uniform(2, 5) * first)
            radius.append(first)
            above, first = len(names) - 1, first * (1 - fall * rng.uniform(0.5, 1.5))
        for _ in range(2 if depth < 2 else 0):
            chain(above, radius[above] * rng.uniform(0.6, 0.85), depth + 1)

    chain(-1, 0.05, 0)
    return Network(tuple(names), parent, length, radius)


def impedance(network, beds):
    """Input impedance at ten harmonics of a mouse's usual heart rate, with a linear wall and Windkessels by name."""
    flow = 0.15 * (1 + sum(np.cos(2 * np.pi * k * np.arange(64) / 64) for k in range(1, 11)))
    own = [beds[network.name[row]] for row in network.terminals]
    model = vw.Model(network, vw.LinearWall(57.0), vw.Windkessel(*np.array(own).T))
    return linear_solution(model, vw.Inflow(flow, 60 / np.sqrt(300 * 800)), 10).input_impedance[1:, network.root]


@pytest.mark.parametrize("fall", [0.0, 0.005, 0.05, 0.2])
def test_terminals_keep_their_names_and_the_impedance_stays_within_a_hundredth(fall):
    for seed in range(5):
        network = chains(np.random.default_rng(seed), fall)
        tidied = vw.tidy(network)
        ends = [one.name[row] for one in (network, tidied.network) for row in one.terminals]
        assert sorted(ends[:4]) == sorted(ends[4:])
        total = {name: 400.0 + 100 * place for place, name in enumerate(ends[:4])}
        beds = {name: (0.1 * R, 0.9 * R, 0.1 / R) for name, R in total.items()}
        change = np.abs(impedance(tidied.network, beds) / impedance(network, beds) - 1)
        assert change.max() < 0.015  # with other beds than the nominal ones, for which 0.01 holds
        assert tidied.change is None or tidied.change.max() <= 0.01
        assert len(tidied.network) >= 7
        assert fall or len(tidied.network) == 7
        assert fall < 0.05 or len(tidied.network) > 20  # unlike vessels stay


def test_unlike_vessels_in_line_are_joined_where_that_is_allowed_and_the_change_is_told():
    network = chains(np.random.default_rng(1), 0.2)
    tidied = vw.tidy(network, change=np.inf, species="mouse")
    assert len(tidied.network) == 7
    nominal = windkessels(network, np.sqrt(7 * 45 / (0.05 * 0.45)), np.sqrt(0.02 * 0.6))
    ends = [network.name[row] for row in network.terminals]
    beds = dict(zip(ends, np.transpose([nominal.R1, nominal.R2, nominal.C]), strict=True))
    change = np.abs(impedance(tidied.network, beds) / impedance(network, beds) - 1)
    # Their mean pressures differ by what the mean of another inflow is taken over.
    np.testing.assert_allclose(tidied.change, change, rtol=0.05)
    assert change.max() > 0.1
    assert f"changes its input impedance by {100 * tidied.change.max():.3g} %" in tidied.summary()


def test_short_vessels_whose_repair_changes_the_impedance_are_refused_until_more_is_allowed():
    short = Network(("main", "stub", "left", "right"), [-1, 0, 1, 1], [0.3, 0.02, 0.3, 0.2], [0.05, 0.015, 0.04, 0.03])
    with pytest.raises(
        InputError, match=r"changes the input impedance by [\d.]+ %, more than the 1 % that are allowed"
    ):
        vw.tidy(short, 2.0)
    assert len(vw.tidy(short, 2.0, change=np.inf).network) == 3
    with pytest.raises(InputError, match="a share of at least 0"):
        vw.tidy(short, change=np.nan)
    with pytest.raises(InputError, match="needs a species with a heart rate"):
        vw.tidy(short, 2.0, species="other")
