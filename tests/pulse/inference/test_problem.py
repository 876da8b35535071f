"""One animal as a problem: models at points, harmonics of simulations, sensitivities to single vessels, errors."""

from dataclasses import replace

import numpy as np
import pytest

from vasowave.base import InputError
from vasowave.pulse import derived
from vasowave.pulse.analysis import operating_point, wave_intensity
from vasowave.pulse.calibration import ParameterLimits, compared_part, parameter_space
from vasowave.pulse.cycle import resample
from vasowave.pulse.examples import control_network, virtual_mouse
from vasowave.pulse.inference import Priors, Problem, Unknowns, kinds
from vasowave.pulse.model import (
    BEDS,
    LAWS,
    STRUCTURE,
    Blood,
    LinearWall,
    Model,
    Numerics,
    Shape,
    bed_factors,
    estimate_nominal,
    parameter_name,
    parameter_names,
    windkessels,
)
from vasowave.pulse.network import Network
from vasowave.pulse.solver import simulate


def problem(priors=None, wall="linear", fixed=None, network=None):
    network, mouse = network or control_network(), virtual_mouse()
    nominal = estimate_nominal(network, mouse)
    space = parameter_space(wall, network, nominal, Blood(), ParameterLimits(fixed=fixed or {}))
    return Problem(Unknowns(space, nominal, priors or Priors(), mouse), compared_part(mouse), Numerics(), 1)


@pytest.fixture(scope="module")
def whole():
    return problem()


def test_one_score_is_one_sd_of_the_prior(whole):
    unknowns = whole.unknowns
    at = {name: i for i, name in enumerate(unknowns.all)}
    point = np.zeros(len(at))
    point[[at["radius_scale"], at["k"], at["beta"]]] = 1.0, 2.0, -1.0
    model, network = unknowns.model(point), control_network()
    assert np.allclose(model.network.radius, np.exp(0.05) * network.radius)
    narrow = network.radius / network.radius[network.root]
    assert np.allclose(model.wall.beta, unknowns.nominal.beta * np.exp(-1.0) * narrow**-1.0)  # k = 2 · 0.5


def test_a_parameter_of_a_law_and_a_number_of_the_image_have_two_names():
    assert {*kinds(), "wedge", "taper_scale"} == STRUCTURE
    parameters = {name for law in LAWS.values() for name in parameter_names(law)}
    assert not STRUCTURE & (parameters | {name for bed in BEDS.values() for name in bed_factors(bed)})
    assert parameter_name(LinearWall, "k") == "linear.k"


def test_harmonics_are_those_of_the_simulated_pressure(whole):
    point = whole.unknowns.scores({"beta": 57.0})
    waves = simulate(whole.unknowns.model(point), whole.recording, Numerics(samples=512))
    inlet = waves["pressure"].to_numpy()[:, control_network().root, 0]
    found = whole.in_time(whole.simulate([point]))[0]
    assert found == pytest.approx(resample(inlet, whole.samples), abs=2e-3)  # two tolerances of 1e-4, other steps


def test_what_one_vessel_changes_is_what_a_network_with_that_vessel_changes(whole):
    point = whole.unknowns.scores({"beta": 57.0, "r1": 0.6})
    columns = whole.in_time(whole.vessels(point).T)
    network, model, waves = control_network(), whole.unknowns.model(point), []
    longer = network.length.copy()
    longer[2] *= np.exp(0.05)
    for one in (network, replace(network, length=longer)):
        beds = windkessels(one, whole.unknowns.nominal.total_resistance, whole.unknowns.nominal.time_constant)
        changed = Model(one, model.wall, beds.scaled(0.6, 1.0, 1.0))
        waves.append(
            simulate(changed, whole.recording, Numerics(samples=512))["pressure"].to_numpy()[:, network.root, 0]
        )
    expected = resample(waves[1] - waves[0], whole.samples)
    assert columns.shape == (44, whole.samples)  # the last two of a taper that nobody stated
    assert columns[21 + 2] == pytest.approx(expected, abs=2e-3)  # tolerances of four simulations
    assert np.abs(expected).max() > 0.02


@pytest.mark.parametrize("sd", [0.1, 0.4])
def test_a_taper_that_nobody_states_is_an_error_that_all_vessels_share(sd):
    """Where vessels that narrow by one SD choke, by what a quarter of it does."""
    whole = problem(Priors(taper_sd=sd))
    point = whole.unknowns.scores({"beta": 57.0, "r1": 0.6})
    straight, waves = whole.unknowns.model(point), []
    fall = min(sd, 0.1)
    for shape in (None, Shape.falling(np.full(21, fall)), Shape.falling(np.full(21, -fall))):
        pressure = simulate(replace(straight, shape=shape), whole.recording, Numerics(samples=512))["pressure"]
        waves.append(resample(pressure.to_numpy()[:, straight.network.root, 0], whole.samples))
    sloping, step = whole.in_time(whole.vessels(point).T)[-2:]
    assert fall / sd * sloping + step == pytest.approx(waves[1] - waves[0], abs=3e-3)
    assert -fall / sd * sloping + step == pytest.approx(waves[2] - waves[0], abs=3e-3)
    assert min(np.abs(sloping).max(), np.abs(step).max()) > 0.1


def test_a_taper_is_no_error_where_it_is_known_or_there_is_none(whole):
    point = whole.unknowns.scores({"beta": 57.0, "r1": 0.6})
    assert not problem(Priors(taper_sd=0.0)).vessels(point)[:, -1].any()
    measured = narrowing(0.1, 0.05).unknowns.network
    assert [Priors().sd("taper", network) for network in (control_network(), measured)] == [0.1, 0.0]


def test_known_radii_replace_the_assumed_error(whole):
    measured = replace(control_network(), radius_sd=np.array([0.001, *[np.nan] * 20]))
    space = replace(whole.unknowns.space, network=measured)
    radii, lengths, falls = Unknowns(space, whole.unknowns.nominal, Priors(radius=0.08), virtual_mouse()).own_errors
    assert radii[0] == pytest.approx(0.001 / control_network().radius[0])
    assert np.all(radii[1:] == 0.08)
    assert np.all(lengths == 0.05)
    assert not falls.any()


def narrowing(fall, sd=None, priors=None):
    """The problem of the control mouse in whose image every vessel narrows."""
    network = control_network()
    share = network.radius / network.length
    known = {"taper": fall * share, "taper_sd": None if sd is None else sd * share}
    return problem(priors, network=replace(network, **known))


def in_pieces(network, pieces, fall=0.2):
    """Return the network with every vessel cut into pieces, whose radii fall by 20 % from inlet to outlet."""
    factor = 1 + fall * (0.5 - (np.arange(pieces) + 0.5) / pieces)
    names = tuple(f"{name} {i}" for name in network.name for i in range(pieces))
    first = np.arange(len(network)) * pieces
    parent = np.repeat(first, pieces) + np.tile(np.arange(pieces), len(network)) - 1
    parent[first] = np.where(network.parent >= 0, first[network.parent] + pieces - 1, -1)
    radius = np.repeat(network.radius, pieces) * np.tile(factor, len(network))
    return Network(names, parent, np.repeat(network.length / pieces, pieces), radius)


def test_a_measured_taper_is_what_is_simulated(whole):
    """Against the same animal with each vessel cut into sixteen straight ones, simulated on a finer grid."""
    unknowns = narrowing(np.full(21, 0.2))
    point = unknowns.unknowns.scores({"beta": 57.0})
    model = whole.unknowns.model(whole.unknowns.scores({"beta": 57.0}))
    cut = replace(model, network=in_pieces(control_network(), 16), wall=LinearWall(57.0), junctions="total")
    pressures = [
        simulate(one, whole.recording, Numerics(samples=512, cell_size=size))["pressure"].to_numpy()[:, 0, 0]
        for one, size in ((cut, 0.05), (model, 0.05))
    ]
    fine, straight = (resample(wave, whole.samples) for wave in pressures)
    found = unknowns.in_time(unknowns.simulate([point]))[0]
    assert np.sqrt(np.mean((found - fine) ** 2)) < 0.02  # the grid's own error
    assert np.sqrt(np.mean((found - straight) ** 2)) > 0.06


def test_a_taper_as_uncertain_as_the_prior_is_believed_half():
    unknowns = narrowing(np.full(21, 0.2), np.full(21, 0.3), Priors(taper=0.3)).unknowns
    assert unknowns.fall == pytest.approx(0.1)
    assert unknowns.own_errors[2] == pytest.approx(0.3 / np.sqrt(2))
    assert unknowns.all["taper_scale"].source == "image"


def test_the_pressure_of_the_image_is_unknown_and_anchors_the_wall(whole):
    space = replace(whole.unknowns.space, network=replace(control_network(), pressure=6.3))
    unknowns = Unknowns(space, whole.unknowns.nominal, Priors(), virtual_mouse())
    found = unknowns.all["image_pressure"]
    assert (found.center, found.unit, found.source) == (6.3, "mmHg", "image")
    model = unknowns.model(unknowns.scores({"image_pressure": 8.0, "beta": 50.0}))
    assert model.network.pressure == pytest.approx(8.0)
    assert np.allclose(
        model.area0 * (1 + 8.0 / 50.0) ** 2, control_network().area
    )  # eq. 3 at the pressure of the image


def test_smaller_vessels_are_stiffer_and_more_viscous_by_the_exponent_that_is_unknown():
    network, mouse = control_network(), virtual_mouse()
    nominal = estimate_nominal(network, mouse)
    space = parameter_space("linear", network, nominal, Blood(), ParameterLimits(viscous=True))
    unknowns = Unknowns(space, nominal, Priors(k_sd=0.5, wedge=2.0), mouse)
    nothing = dict.fromkeys(unknowns.all, 0.0)
    plain, model = (unknowns.model(np.array([*(nothing | moved).values()])) for moved in ({}, {"k": 0.8, "wedge": 1.5}))
    ratio = (network.radius / network.radius[network.root]) ** -0.4
    assert model.wall.beta == pytest.approx(plain.wall.beta * ratio)
    assert model.wall_viscosity == pytest.approx(plain.wall_viscosity * ratio)
    assert model.outlet_pressure == pytest.approx(space.outlet_pressure + 3.0)


def test_a_prior_of_something_else_is_an_error_that_names_what_there_is():
    with pytest.raises(InputError, match=r"no parameter 'betta' \(did you mean 'beta'\?\); it has: beta, r1"):
        problem(Priors(parameters={"betta": (50.0, 0.3)}))


def test_a_point_whose_numbers_overflow_is_a_row_of_nan(whole):
    point = np.zeros(len(whole.unknowns.all))
    point[0] = 2000.0
    assert np.isnan(whole.simulate([point])).all()


def test_everything_that_enters_a_simulation_enters_its_key(whole):
    keys = {whole.key, problem(wall="tangent").key, problem(Priors(k_sd=0.1)).key, problem(fixed={"c1": 2.0}).key}
    keys.add(replace(whole, numerics=Numerics(cell_size=0.05)).key)
    keys.add(narrowing(np.full(21, 0.2)).key)
    assert len(keys) == 6
    assert problem().key == whole.key


@pytest.mark.parametrize("wall", ["linear", "tangent"])
def test_the_linear_model_has_the_pressure_of_the_simulation_the_closer_the_stiffer_the_wall(wall):
    one = problem(wall=wall)
    points = np.zeros((2, len(one.unknowns.all)))
    points[:, 0] = np.log([20.0, 100.0])  # the first unknown is the stiffness, and the SD of its logarithm is 1
    simulated = one.simulate(points)
    missed = np.linalg.norm(one.linear(points) - simulated, axis=1) / np.linalg.norm(simulated, axis=1)
    assert missed[1] < 0.01
    assert missed[1] < missed[0] / 3  # what is left out is of second order: a fifth, and the grid's error


@pytest.mark.parametrize("enters", ["flow", "pressure"])
def test_reflections_of_the_measured_waves_are_those_of_the_measured_cycle(enters):
    """What is compared stands where the wave of the model does, without the error of the probe where it is flow."""
    one = problem(Priors(flow_gain_sd=0.1))
    mouse = one.recording
    one = replace(one, compared=compared_part(mouse, "all", enters))
    outputs = np.tile(one.measured, (2, 1))
    outputs[1, 4] = np.nan
    louder = np.zeros((2, len(one.unknowns.all)))
    louder[:, list(one.unknowns.all).index("flow_gain")] = 1.0
    model, seen = one.unknowns.posed(louder[0])
    place = operating_point(model, mouse.mean_pressure)
    expected = wave_intensity(mouse.pressure, seen.flow, mouse.period, *place, model.blood.inertia)
    found = one.quantities(louder, outputs, np.zeros(2))["I_R"]
    assert found[0] == pytest.approx(float(expected.reflection_coefficient), rel=2e-3)
    assert np.isnan(found[1])


def test_waves_are_taken_apart_in_a_root_as_wide_as_its_own_error_says(whole):
    mouse, point, root = whole.recording, np.zeros(len(whole.unknowns.all)), control_network().root
    errors = np.zeros((1, 44))
    errors[0, root] = -2.0  # SD, of 5 % each
    model, _ = whole.unknowns.posed(point, radii=-0.1 * np.eye(21)[root])
    place = operating_point(model, mouse.mean_pressure)
    expected = wave_intensity(mouse.pressure, mouse.flow, mouse.period, *place, model.blood.inertia)
    complete = replace(whole, compared=compared_part(mouse, "all"))
    outputs = complete.measured[np.newaxis]
    found = complete.quantities(point[np.newaxis], outputs, np.zeros(1), errors)
    assert found["I_R"] == pytest.approx(float(expected.reflection_coefficient), rel=2e-3)
    assert found["area_compliance"] == pytest.approx(derived(model, mouse.mean_pressure)["area_compliance"])
    plain = complete.quantities(point[np.newaxis], outputs, np.zeros(1))
    assert abs(plain["I_R"] / found["I_R"] - 1) > 0.02


def test_indices_that_an_error_moves_follow_from_zero_and_gain(whole):
    """Mean pressure less its zero, output times its gain, and resistance of both beyond the wedge pressure."""
    mouse = whole.recording
    wide = problem(Priors(zero_sd=2.0, flow_gain_sd=0.1))
    points = np.zeros((2, len(wide.unknowns.all)))
    gain = list(wide.unknowns.all).index("flow_gain")
    points[1, gain] = 1.0
    found = wide.quantities(points, np.tile(wide.measured, (2, 1)), np.array([0.0, 0.5]))
    factor = wide.unknowns.values(points)["flow_gain"]
    pressure, flow = mouse.mean_pressure - np.array([0.0, 1.0]), mouse.cardiac_output * factor
    assert found["mPAP"] == pytest.approx(pressure)
    assert found["CO"] == pytest.approx(flow)
    assert factor[1] != pytest.approx(1.0)
    assert found["PVR"] == pytest.approx((pressure - mouse.wedge_pressure) / flow)
    model = wide.unknowns.model(points[0])
    assert found["R_T"][0] == pytest.approx(model.outlets.total_resistance(), rel=0.2)
    sure = problem(Priors(zero_sd=0.0, flow_gain_sd=0.0))
    nothing = np.zeros((1, len(sure.unknowns.all)))
    assert not {"mPAP", "CO", "PVR"} & set(sure.quantities(nothing, sure.measured[np.newaxis], np.zeros(1)))


@pytest.mark.parametrize("inertia", [0.0, 7e-6])
def test_lag_and_inertia_of_the_pressure_are_a_catheter_between_model_and_recording(inertia):
    lagging = problem(Priors(pressure_lag_sd=0.003, pressure_inertia_sd=inertia))
    point = np.zeros(len(lagging.unknowns.all))
    late = lagging.unknowns.scores({"pressure_lag": 0.0036, "pressure_inertia": 0.5 * inertia})
    outputs = lagging.simulate([point, late])
    plain, filtered = (np.fft.rfft(one) for one in lagging.in_time(outputs))
    rate = 2 * np.pi * np.arange(len(plain)) / lagging.recording.period
    passed = 1 + 1j * rate * 0.0036 - rate**2 * 0.5 * inertia
    np.testing.assert_allclose(filtered * passed, plain, rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(lagging.through_amplifier([late], outputs[1:], back=True), outputs[:1], atol=1e-9)
    theory = [np.fft.rfft(one) for one in lagging.in_time(lagging.linear(np.array([point, late])))]
    np.testing.assert_allclose(theory[1] * passed, theory[0], rtol=1e-9, atol=1e-9)


def test_a_gain_of_the_pressure_divides_what_is_compared_at_the_inlet():
    loud = problem(Priors(pressure_gain_sd=0.1))
    point = 1.5 * np.eye(len(loud.unknowns.all))[list(loud.unknowns.all).index("pressure_gain")]
    plain, seen = loud.simulate([0 * point, point])
    np.testing.assert_allclose(seen * np.exp(0.15), plain, rtol=1e-9)
    found = loud.quantities(np.array([point]), seen[np.newaxis], np.zeros(1))
    assert found["mPAP"] == pytest.approx(loud.recording.mean_pressure * np.exp(0.15))


def test_a_zero_of_the_flow_moves_its_mean_alone():
    unknowns = problem(Priors(flow_zero_sd=0.01)).unknowns
    point = -2.0 * np.eye(len(unknowns.all))[list(unknowns.all).index("flow_zero")]
    np.testing.assert_allclose(unknowns.posed(point)[1].flow, unknowns.recording.flow + 0.02)
