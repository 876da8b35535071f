"""Narrowings and angles: what they lose, against Young and Tsai, Poiseuille and the change of momentum."""

from dataclasses import replace

import numpy as np
import pytest

import vasowave as vw
from vasowave.base import InputError, VasowaveWarning
from vasowave.pulse.cycle import Inflow
from vasowave.pulse.model import BoundaryLayer, Poiseuille, linear_solution, windkessels
from vasowave.pulse.solver import simulate_run

Q = 0.1  # ml/s, steady
RIGID = vw.LinearWall(20_000.0)


def tube(**parts) -> vw.Model:
    """Return one stiff vessel of 1 cm, radius 0.05 cm, before a resistance."""
    network = vw.Network(("only",), [-1], [1.0], [0.05])
    return vw.Model(network, RIGID, vw.Resistance([100.0]), vw.Blood(friction=Poiseuille()), **parts)


def fall(model: vw.Model, flow: float = Q) -> float:
    """Return the fall of the mean pressure from inlet to bed, mmHg, at steady flow."""
    waves = vw.simulate(model, Inflow(np.full(64, flow), 0.1), vw.Numerics(samples=64))
    mean = waves.pressure.mean("time")
    return float(mean.isel(vessel=0).sel(station="inlet") - mean.isel(vessel=-1).sel(station="outlet"))


def by_the_sources(radius, area_lost, length, flow, blood):
    """Fall of pressure, mmHg, of Young and Tsai (1973) with the K_v of Seeley and Young (1976)."""
    D, areas = 2 * radius, 1 / (1 - area_lost)
    U = flow / (np.pi * radius**2)
    K_v = 32 * (0.83 * length + 1.64 * D / np.sqrt(areas)) / D * areas**2
    return blood.inertia * (K_v * blood.viscosity * U / D + 0.5 * 1.52 * (areas - 1) ** 2 * U**2)


@pytest.mark.parametrize("friction", [Poiseuille(), BoundaryLayer()])
@pytest.mark.parametrize("junctions", ["static", "total"])
@pytest.mark.parametrize(
    ("radius", "area_lost", "length", "flow"),  # Reynolds numbers 11 to 826
    [(0.05, 0.5, 0.1, 0.2), (0.05, 0.75, 0.05, 0.1), (0.05, 0.85, 0.1, 0.04), (0.03, 0.8, 0.02, 0.2),
     (0.3, 0.6, 0.4, 4.0), (0.3, 0.4, 0.2, 18.0)],
)  # fmt: skip
def test_a_narrowing_takes_what_its_sources_say_whatever_the_drag_of_its_cells(
    radius, area_lost, length, flow, junctions, friction
):
    network = vw.Network(("only",), [-1], [20 * radius], [radius])
    blood = vw.Blood(friction=friction)
    whole = vw.Model(network, RIGID, vw.Resistance([10.0 / flow]), blood, junctions=junctions)
    cut = vw.Model(replace(network, length=network.length - length), RIGID, whole.outlets, blood)  # without that piece
    expected = by_the_sources(radius, area_lost, length, flow, blood)
    assert fall(vw.narrowed(whole, "only", area_lost, length), flow) - fall(cut, flow) == pytest.approx(
        expected, rel=0.02
    )


def test_the_inertia_of_a_narrowing_is_that_of_its_blood_or_what_was_measured():
    """A flow that grows by ΔQ/Δt in a stiff tube without viscosity needs K_u ρ L/A of it in the narrow piece."""
    network, t = vw.Network(("only",), [-1], [1.0], [0.05]), 2 * np.pi * np.arange(256) / 256
    blood = vw.Blood(viscosity=1e-9, friction=Poiseuille())
    whole = vw.Model(network, RIGID, vw.Resistance([100.0]), blood)
    inflow, area = Inflow(0.1 + 1e-3 * np.sin(t), 0.5), np.pi * 0.05**2
    numerics = vw.Numerics(samples=256, tolerance=1e-8)

    def inertance(model):
        run = simulate_run(model, inflow, numerics)
        first = (
            np.fft.rfft(run.pressure[:, 0, 0] - run.pressure[:, 2, -1])[1] / np.fft.rfft(run.recorded[1, :, 0, 0])[1]
        )
        return float(first.imag / (2 * np.pi / 0.5)) * run.recorded.shape[1] / len(run.pressure)

    plain = inertance(whole)
    assert plain == pytest.approx(blood.inertia / area, rel=0.02)
    for given, K_u in ((None, 2.0), (1.2, 1.2)):
        coefficients = vw.Stenosis(turbulent=0.0, inertial=given)
        found = inertance(vw.narrowed(whole, "only", 0.5, 0.2, coefficients=coefficients)) - 0.8 * plain
        assert found == pytest.approx(K_u * 0.2 * blood.inertia / area, rel=0.03)


def test_a_flow_outside_the_range_of_the_sources_is_told():
    for flow, told in ((0.001, True), (0.1, False), (6.0, True)):
        network = vw.Network(("only",), [-1], [1.0], [0.05])
        model = vw.narrowed(vw.Model(network, RIGID, vw.Resistance([10 / flow])), "only", 0.3, 0.1)
        notes = simulate_run(model, Inflow(np.full(64, flow), 0.1), vw.Numerics(samples=64)).notes
        seen = [one for one in notes if one.code == "solver.stenosis-beyond-its-source"]
        assert bool(seen) == told
        if told:
            reynolds = flow / (np.pi * 0.05**2) * 0.1 / model.blood.viscosity
            assert dict(seen[0].values)["value"] == pytest.approx(reynolds, rel=0.01)


def test_linear_theory_has_the_resistance_of_a_narrowing():
    model = vw.narrowed(tube(), "only", 0.8, 0.05, coefficients=vw.Stenosis(turbulent=0.0))
    t = 2 * np.pi * np.arange(128) / 128
    inflow = Inflow(0.01 + 1e-3 * np.sin(t), 0.1)
    theory = linear_solution(model, inflow)
    run = simulate_run(model, inflow, vw.Numerics(samples=128, tolerance=1e-8))
    np.testing.assert_allclose(run.pressure[:, 0, 0], theory.over_cycle(theory.pressure, 128)[:, 0], rtol=3e-3)


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
    with pytest.warns(VasowaveWarning, match=r"before 'b narrow' reaches a Reynolds number of 3\.11"):
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
    with pytest.raises(InputError, match="Stenosis: turbulent = -1"):
        vw.Stenosis(turbulent=-1.0)
    with pytest.raises(InputError, match=r"between 0 .* and 180 degrees"):
        vw.angle_losses(vw.control_network(), 190.0)
    with pytest.raises(InputError, match="one for each of the 21 vessels"):
        vw.angle_losses(vw.control_network(), [1.0, 2.0])


def test_a_resistance_of_the_root_has_no_effect_and_that_of_others_is_that_of_a_narrowing():
    network, t = vw.Network(("a", "b"), [-1, 0], [0.5, 0.5], [0.05, 0.05]), np.arange(64)
    inflow, numerics = Inflow(0.1 + 0.02 * np.sin(2 * np.pi * t / 64), 0.1), vw.Numerics(samples=64)

    def mean_fall(resistance):
        model = vw.Model(network, RIGID, vw.Resistance([100.0]), vw.Blood(friction=Poiseuille()), resistance=resistance)
        run = simulate_run(model, inflow, numerics)
        return float(np.mean(run.pressure[:, 0, 0] - run.pressure[:, 2, -1]))

    own = 8 * np.pi * vw.Blood().inertia * vw.Blood().viscosity * 0.5 / (np.pi * 0.05**2) ** 2
    assert mean_fall([20.0, 0.0]) == pytest.approx(mean_fall(0.0), rel=1e-10)
    assert mean_fall([20.0, 20.0]) - mean_fall(0.0) == pytest.approx(0.1 * (20.0 - own), rel=0.01)
