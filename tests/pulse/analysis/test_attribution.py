"""What made the change between two states, against theory of the mean pressure and the definition of a share."""

from dataclasses import replace
from itertools import permutations

import numpy as np
import pytest

import vasowave as vw
from vasowave.base import InputError


@pytest.fixture
def healthy():
    network, mouse = vw.control_network(), vw.virtual_mouse()
    return vw.Model(network, vw.LinearWall(60.0), vw.estimate_nominal(network, mouse).outlets), mouse


def ill(model):
    """Stiffer walls, narrower vessels and beds that resist more."""
    network = replace(model.network, radius=0.95 * model.network.radius)
    return model.changed(
        network=network, wall=vw.LinearWall(95.0), outlets=model.outlets.scaled(1.7, 1.4, 0.8), outlet_pressure=3.0
    )


def faster(mouse):
    return vw.Inflow(1.2 * mouse.flow, mouse.period / 1.1)


def test_the_shares_are_the_whole_change(healthy):
    model, mouse = healthy
    made = vw.attribute_change(model, ill(model), (mouse, faster(mouse)))
    assert made.components == ("heart", "walls", "beds", "geometry", "pressure behind beds")
    np.testing.assert_allclose(
        made.table[list(made.components)].sum(axis=1), made.table["change"], rtol=1e-9, atol=1e-12
    )
    assert abs(made.table.loc["mPAP", "walls"]) < 0.05 * made.table.loc["mPAP", "change"]
    assert made.table.loc["pPAP", "walls"] > 1.0


def test_mean_pressure_is_shared_by_the_law_of_ohm(healthy):
    """Of R Q the shares are ΔR and ΔQ with the mean of the other; stiff vessels resist the same."""
    model, mouse = healthy
    model = model.changed(wall=vw.LinearWall(5000.0))
    after = model.changed(outlets=model.outlets.scaled(1.5, 1.5, 1.0), outlet_pressure=2.0)
    table = vw.attribute_change(model, after, (mouse, vw.Inflow(1.2 * mouse.flow, mouse.period))).table
    flow, more = mouse.flow.mean(), 0.5 * model.outlets.total_resistance()
    before = table.loc["mPAP", "before"] / flow
    assert table.loc["mPAP", "beds"] == pytest.approx(more * 1.1 * flow, rel=0.01)
    assert table.loc["mPAP", "heart"] == pytest.approx(0.2 * flow * (before + more / 2), rel=0.01)
    assert table.loc["mPAP", "pressure behind beds"] == pytest.approx(2.0, rel=0.01)


def test_a_share_is_the_mean_over_all_orders_of_exchange(healthy):
    model, mouse = healthy
    after = ill(model).changed(outlet_pressure=0.0)
    fields = {"walls": ("wall",), "beds": ("outlets",), "geometry": ("network",)}

    def pulse(exchanged):
        chosen = {name: getattr(after, name) for part in exchanged for name in fields[part]}
        waves = vw.simulate(model.changed(**chosen), mouse)
        return np.ptp(waves.pressure.sel(vessel=model.network.name[model.network.root], station="inlet").values)

    steps = [pulse(order[: order.index("walls") + 1]) - pulse(order[: order.index("walls")])
             for order in permutations(fields)]  # fmt: skip
    made = vw.attribute_change(model, after, (mouse, mouse)).table
    assert made.loc["pPAP", "walls"] == pytest.approx(np.mean(steps), rel=1e-3)


def test_beds_and_walls_go_to_a_tree_with_other_vessels(healthy):
    model, mouse = healthy
    names = tuple(f"second {name}" for name in model.network.name)
    renamed = ill(model).changed(network=replace(ill(model).network, name=names))
    same, other = (vw.attribute_change(model, after, (mouse, mouse)).table for after in (ill(model), renamed))
    np.testing.assert_allclose(other.drop(columns="unit"), same.drop(columns="unit"), rtol=2e-3, atol=2e-3)


def test_states_that_cannot_be_exchanged_are_refused(healthy):
    model, mouse = healthy
    with pytest.raises(InputError, match="walls: LinearWall before and TangentWall after"):
        vw.attribute_change(model, model.changed(wall=vw.TangentWall(20.0, 2.0)), (mouse, mouse))
    with pytest.raises(InputError, match=r"of a fit: fit\.model"):
        vw.attribute_change(model, mouse, (mouse, mouse))
    uneven = vw.LinearWall(60.0 + np.arange(len(model.network)))
    names = tuple(f"second {name}" for name in model.network.name)
    moved = model.changed(network=replace(model.network, name=names), wall=uneven)
    with pytest.raises(InputError, match="walls differ from vessel to vessel"):
        vw.attribute_change(model, moved, (mouse, mouse))


def test_trees_with_other_numbers_of_beds_are_exchanged(healthy):
    model, mouse = healthy
    tree = vw.Network(("1", "2", "3"), [-1, 0, 0], model.network.length[:3], model.network.radius[:3])
    small = model.changed(network=tree, wall=vw.LinearWall(60.0), outlet_pressure=0.0,
                          outlets=vw.estimate_nominal(tree, mouse).outlets)  # fmt: skip
    made = vw.attribute_change(model, small, (mouse, mouse))
    assert "geometry" in made.components
    assert "pressure behind beds" not in made.components
    together = made.table[list(made.components)].sum(axis=1)
    np.testing.assert_allclose(together, made.table["change"], rtol=1e-9, atol=1e-12)
    with pytest.raises(InputError, match="the flow before and the flow after"):
        vw.attribute_change(model, small, mouse)
