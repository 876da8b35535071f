"""Narrowings and angles: what they lose, against Young and Tsai, Poiseuille and the change of momentum."""

import numpy as np
import pytest

import vasowave as vw
from vasowave.errors import InputError
from vasowave.model.blood import Poiseuille
from vasowave.model.nominal import windkessels
from vasowave.recording import Inflow
from vasowave.solver.simulate import simulate_run

Q = 0.1  # ml/s, steady
RIGID = vw.LinearWall(20_000.0)


def tube(**parts) -> vw.Model:
    """Return one stiff vessel of 1 cm, radius 0.05 cm, before a resistance."""
    network = vw.Network(("only",), [-1], [1.0], [0.05])
    return vw.Model(network, RIGID, vw.Resistance([100.0]), vw.Blood(friction=Poiseuille()), **parts)


def fall(model: vw.Model) -> float:
    """Return the fall of the mean pressure from inlet to bed, mmHg, at steady flow."""
    waves = vw.simulate(model, Inflow(np.full(64, Q), 0.1), vw.Numerics(samples=64))
    mean = waves.pressure.mean("time")
    return float(mean.isel(vessel=0).sel(station="inlet") - mean.isel(vessel=-1).sel(station="outlet"))


@pytest.mark.parametrize("junctions", ["static", "total"])
@pytest.mark.parametrize(("area_lost", "length"), [(0.5, 0.1), (0.75, 0.05), (0.85, 0.1)])
def test_a_narrowing_takes_what_young_and_tsai_say_of_its_jet_and_poiseuille_of_its_length(
    area_lost, length, junctions
):
    whole = tube(junctions=junctions)
    with_it = vw.narrowed(whole, "only", area_lost, length)
    area0, blood = np.pi * 0.05**2, whole.blood
    areas = area0 / (area0 * (1 - area_lost))
    jet = 1.52 * 0.5 * blood.inertia * (areas - 1) ** 2 * (Q / area0) ** 2
    along = 8 * np.pi * blood.inertia * blood.viscosity * Q * length / area0**2  # of the vessel itself, before
    expected = jet + along * (areas**2 - 1)
    assert fall(with_it) - fall(whole) == pytest.approx(expected, rel=0.02)


@pytest.mark.parametrize("vessel", ["1", "3", "21"])
def test_a_narrowing_of_nothing_leaves_all_waves_where_they_were(inflow, vessel):
    """A root, a vessel within the tree, and one that leads to a bed: pieces keep their places, walls and beds."""
    network = vw.control_network()
    stiffness, viscosity = np.linspace(50.0, 70.0, 21), np.linspace(0.0, 0.5, 21)
    beds = windkessels(network, 76.0, 0.11, a=0.12)
    model = vw.Model(network, vw.LinearWall(stiffness), beds, wall_viscosity=viscosity)
    whole = simulate_run(model, inflow, vw.Numerics(samples=64))
    parted = vw.narrowed(model, vessel, 1e-9, 0.02, 0.4)
    found = simulate_run(parted, inflow, vw.Numerics(samples=64))
    names = list(parted.network.name)
    rows = [names.index(name) for name in network.name]
    row = network.row(vessel)
    np.testing.assert_allclose(found.pressure[:, 0][:, rows], whole.pressure[:, 0], atol=0.02)
    beyond = names.index(f"{vessel} beyond")
    np.testing.assert_allclose(found.pressure[:, 2, beyond], whole.pressure[:, 2, row], atol=0.02)
    assert np.sum(parted.network.length) == pytest.approx(np.sum(network.length))


def test_a_narrowing_within_a_loop_slows_the_half_in_which_it_is(inflow):
    ring = vw.Network(("in", "a", "b", "out"), None, [1.0, 0.5, 0.5, 1.0], [0.05, 0.035, 0.035, 0.05],
                      nodes=[[0, 1], [1, 2], [1, 2], [2, 3]])  # fmt: skip
    model = vw.Model(ring, vw.LinearWall(57.0), windkessels(ring, 76.0, 0.11, a=0.12), loss=0.3)
    waves = vw.simulate(vw.narrowed(model, "b", 0.9, 0.1), inflow, vw.Numerics(samples=64))
    mean = waves.flow.sel(station="middle").mean("time")
    assert float(mean.sel(vessel="b narrow")) == pytest.approx(float(mean.sel(vessel="b beyond")), rel=1e-3)
    assert float(mean.sel(vessel="b")) < 0.2 * float(mean.sel(vessel="a"))


def test_a_branch_loses_the_square_of_the_change_of_its_velocity():
    """Straight on into one as wide: nothing. Into one twice as wide: Borda and Carnot's (2 - 1)² of its own ½ρu²."""
    root = np.sqrt(2.0)
    chain = vw.Network(("a", "same", "wide"), [-1, 0, 1], [1.0, 1.0, 1.0], [0.05, 0.05, 0.05 * root])
    np.testing.assert_allclose(vw.angle_losses(chain, 0.0), [0.0, 0.0, 1.0], atol=1e-12)
    fork = vw.Network(("a", "left", "right"), [-1, 0, 0], [1.0, 1.0, 1.0], [0.05, 0.04, 0.04])
    u0, u1 = 1.0 / 0.05**2, 0.5 / 0.04**2
    turned = np.radians(0.75 * 60.0)
    change = np.hypot(u1 - u0 * np.cos(turned), u0 * np.sin(turned))
    np.testing.assert_allclose(vw.angle_losses(fork, [0.0, 60.0, 60.0])[1:], (change / u1) ** 2)


@pytest.mark.parametrize(
    ("parts", "words"),
    [
        (("nobody", 0.5, 0.1), "nobody"),
        (("only", 1.0, 0.1), "closes 1 of the area; give the share that is closed, above 0 and below 1"),
        (("only", 0.5, 0.0), "of 0 cm; give its length"),
        (("only", 0.5, 0.1, 0.5, -1.0), "-1 times as stiff"),
        (("only", 0.5, 1.2), "a narrowing of 1.2 cm at 0.5 of its length does not fit into vessel 'only'"),
        (("only", 0.5, 0.1, 0.98), "does not fit into vessel 'only', which is 1 cm long"),
    ],
)
def test_a_narrowing_that_cannot_be_is_refused(parts, words):
    with pytest.raises(InputError, match=words):
        vw.narrowed(tube(), *parts)


def test_a_suture_stays_as_narrow_as_it_is_and_an_elastic_narrowing_gives_way():
    """Widened by 20 mmHg: the area of the linear law, A0 (1 + p/β)², with the stiffness that was asked for."""
    network = vw.Network(("only",), [-1], [1.0], [0.05])
    model = vw.Model(network, vw.LinearWall(57.0), vw.Resistance([200.0]))
    for stiffer in (1.0, 20.0):
        parted = vw.narrowed(model, "only", 0.7, 0.2, stiffer=stiffer)
        waves = vw.simulate(parted, Inflow(np.full(64, Q), 0.1), vw.Numerics(samples=64)).mean("time")
        seen = waves.sel(vessel="only narrow", station="middle")
        expected = 0.3 * np.pi * 0.05**2 * (1 + float(seen.pressure) / (57.0 * stiffer)) ** 2
        assert float(seen.pressure) == pytest.approx(20.0, rel=0.05)
        assert float(seen.area) == pytest.approx(expected, rel=1e-3)


def test_a_second_narrowing_of_one_vessel_has_names_of_its_own():
    twice = vw.narrowed(vw.narrowed(tube(), "only", 0.5, 0.1), "only", 0.5, 0.1)
    assert twice.network.name == ("only", "only narrow 2", "only beyond 2", "only narrow", "only beyond")
    assert [twice.network.parent.tolist()] == [[-1, 0, 1, 2, 3]]


def test_a_taper_within_its_error_counts_once_and_not_for_every_piece():
    """At 1.9 SD a straight tree seems to taper as much; thrice so all its vessels would taper and junctions change."""
    network = vw.Network(("only",), [-1], [1.0], [0.05], taper=[0.0019], taper_sd=[0.001])
    model = vw.Model(network, RIGID, vw.Resistance([100.0]))
    parted = vw.narrowed(model, "only", 0.9, 0.1)
    assert not model.changing.any()
    assert not parted.changing.any()
    assert not parted.total_pressure
    np.testing.assert_array_equal(parted.network.taper, [0.0019, np.nan, np.nan])


def test_a_vessel_that_tapers_has_no_narrowing_and_angles_are_degrees():
    with pytest.raises(InputError, match="Network was given where a Model is needed"):
        vw.narrowed(vw.control_network(), "2", 0.5, 0.1)
    with pytest.raises(InputError, match="changes along its way"):
        vw.narrowed(tube(shape=vw.Shape([1.1, 0.9])), "only", 0.5, 0.1)
    with pytest.raises(InputError, match=r"between 0 .* and 180 degrees"):
        vw.angle_losses(vw.control_network(), 190.0)
    with pytest.raises(InputError, match="one for each of the 21 vessels"):
        vw.angle_losses(vw.control_network(), [1.0, 2.0])
