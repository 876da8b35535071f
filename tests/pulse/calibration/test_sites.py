"""Fits to what was observed at further sites: one objective, honest intervals, wrong units noticed."""

import threading
from dataclasses import replace

import numpy as np
import pytest

import vasowave as vw
from small_tree import SMALL
from vasowave import pulse
from vasowave.base import InputError, ratios
from vasowave.pulse.calibration import POINT_HARMONIC, Objective, compared_part, parameter_space, sites_of
from vasowave.pulse.cycle import resample
from vasowave.pulse.solver import Places, simulate_run, waves_at

NETWORK, MOUSE = vw.control_network(), vw.virtual_mouse()
BRANCH = "2"
COARSE = vw.Numerics(cell_size=0.3, tolerance=1e-6)
ERROR = {"pressure": 0.1, "flow": 0.002, "velocity": 0.5, "area": 2e-5, "diameter": 5e-4}


def true_in(network):
    """Return a recording at the inlet of a network and the waves there and in the branch."""
    model = vw.Model(network, vw.LinearWall(70.0), vw.estimate_nominal(network, MOUSE).outlets)
    run = simulate_run(model, MOUSE.inflow, vw.Numerics(samples=256))
    waves = waves_at(run, MOUSE.inflow, Places(np.array([0, network.row(BRANCH)]), np.array([0.0, 0.5])))
    pressure = resample(waves.pressure[:, 0], 256) + 0.1 * np.random.default_rng(1).standard_normal(256)
    return vw.Recording(pressure, MOUSE.flow, MOUSE.period), waves


@pytest.fixture(scope="module")
def truth():
    return true_in(NETWORK)


@pytest.fixture(scope="module")
def small_truth():
    return true_in(SMALL)


def site(truth, quantity, factor=1.0, **more):
    wave = resample(truth[1].of(quantity)[:, 1], 128)
    noise = ERROR[quantity] * np.random.default_rng(2).standard_normal(128)
    return vw.Observation(quantity, BRANCH, factor * ERROR[quantity], waveform=factor * (wave + noise), **more)


@pytest.mark.parametrize("quantity", ERROR)
def test_a_true_site_agrees_and_widens_no_interval(truth, quantity):
    fit = pulse.calibrate(NETWORK, truth[0], starts=1, sites=[site(truth, quantity)])
    d = fit.sites.isel(site=0)
    assert float(d.misfit) < 2
    assert float(d.ratio) == pytest.approx(1, abs=0.1)
    assert np.all(np.log(d.high / d.low) < 1.02 * np.log(d.high_without / d.low_without))
    assert d.low.sel(quantity="beta") < 70 < d.high.sel(quantity="beta")
    assert not {"fit.site-unit", "fit.site-apart"} & {one.code for one in fit.findings}
    measured, predicted = d.measured.values, d.predicted.values
    assert np.sqrt(np.mean((measured - predicted) ** 2)) < 0.1 * np.ptp(measured)


def test_the_jacobian_of_sites_is_that_of_differences(truth):
    numbers = vw.Observation("flow", BRANCH, 0.01, cm=0.1, mean=0.1, systolic=0.4, diastolic=0.0)
    observations = [site(truth, "pressure"), site(truth, "diameter", place=1.0), numbers]
    nominal = vw.estimate_nominal(NETWORK, truth[0])
    space = parameter_space("linear", NETWORK, nominal, vw.Blood())
    compared = compared_part(truth[0])
    compared = replace(compared, sites=sites_of(observations, NETWORK, compared))
    numerics = vw.Numerics(samples=64, steps_per_cycle=2048, tolerance=1e-10)
    objective = Objective(space, compared, numerics, 1, threading.Event(), 1e-8)
    x = np.log(space.nominal[space.free])
    jacobian, step = objective.jacobian(x), 1e-3
    for i, unit in enumerate(np.eye(len(x))):
        ends = [objective.residuals(x + k * step * unit) for k in (1, -1, 2, -2)]
        expected = (8 * (ends[0] - ends[1]) - (ends[2] - ends[3])) / (12 * step)
        assert np.max(np.abs(jacobian[:, i] - expected)) < 1e-4 * np.max(np.abs(expected))


def test_a_waveform_and_its_numbers_say_the_same_of_a_cycle(truth):
    """A mean counts as the waveform's first coefficient, and scaled values are in mmHg of the inlet's pulse."""
    wave = site(truth, "flow")
    numbers = vw.Observation("flow", BRANCH, 0.01, mean=wave.waveform.mean(), systolic=wave.waveform.max(),
                             diastolic=wave.waveform.min())  # fmt: skip
    sites = sites_of([wave, numbers], NETWORK, compared_part(truth[0]))
    one, other = (sites.measured[rows] for rows in sites.rows)
    assert one[0] == pytest.approx(other[0])
    assert list(sites.harmonic[sites.rows[1]]) == [0, POINT_HARMONIC, POINT_HARMONIC]
    assert other[1] - other[2] == pytest.approx(truth[0].pulse_pressure)


def test_a_diameter_that_is_half_of_what_is_foretold_was_a_radius(truth):
    half = site(truth, "diameter", 0.5)
    fit = pulse.calibrate(NETWORK, truth[0], starts=1, sites=[half], numerics=COARSE, pressure_harmonics=8)
    (named,) = (str(one) for one in fit.findings if one.code == "fit.site-unit")
    assert "a radius had been given for it" in named


def test_errors_of_sites_are_their_own_and_those_of_their_gain(truth):
    """Of one number of a flow with an error of 10 % in its gain, in mmHg of the inlet's pulse."""
    flow = vw.Observation("flow", BRANCH, 0.01, mean=0.08, systolic=0.2, gain_sd=0.1)
    sites = sites_of([flow], NETWORK, compared_part(truth[0]))
    own = sites.measured / np.array(list(flow.numbers.values()))  # how much of a site's unit counts as 1 mmHg
    expected = np.diag((0.01 * own) ** 2) + 0.1**2 * np.outer(sites.measured, sites.measured)
    np.testing.assert_allclose(sites.covariance, expected)


@pytest.mark.parametrize(
    "quantity",
    [pytest.param(one, marks=pytest.mark.validation) if one != "diameter" else one for one in ERROR],
)
def test_wrong_units_are_noticed_and_named(small_truth, quantity):
    known = ratios(quantity)
    pairs = sorted({round(known[one] / known[other], 12): (one, other) for one in known for other in known
                    if known[one] != known[other]}.items())  # fmt: skip
    for ratio, (one, other) in (pairs[0], pairs[-1]):
        wrong = site(small_truth, quantity, ratio)
        fit = pulse.calibrate(SMALL, small_truth[0], starts=1, sites=[wrong], numerics=COARSE, pressure_harmonics=8)
        named = [str(each) for each in fit.findings if each.code == "fit.site-unit"]
        assert len(named) == 1, (one, other)


@pytest.mark.validation
def test_without_its_only_site_a_fit_is_the_fit_that_never_knew_it():
    """Of a lumped bed without waves, which the stiffest wall fits too: there the site, 7.5 times too high, leads."""
    rng, n, period, output, mean = np.random.default_rng(3), 128, 0.11, 0.18, 15.0
    share = np.arange(n) / n
    flow = np.where(share < 0.4, np.abs(np.sin(np.pi * share / 0.4)) ** 1.5, 0.0)
    flow *= output / flow.mean()
    R, omega = mean / output, 2j * np.pi * np.fft.rfftfreq(n, period / n)
    Z = 0.12 * R + 0.88 * R / (1 + omega * 0.88 * 0.5 * period * 20 / 12)
    pressure = np.fft.irfft(np.fft.rfft(flow) * Z, n) + 0.05 * rng.standard_normal(n)
    lumped = vw.Recording(pressure, flow + 0.002 * rng.standard_normal(n), period)
    lengths, radii = (0.41, 0.44, 0.37, 0.24, 0.06, 0.2, 0.25), (0.047, 0.026, 0.037, 0.024, 0.015, 0.03, 0.02)
    network = vw.Network(("MPA", "LPA", "RPA", "L1", "L2", "R1", "R2"), [-1, 0, 0, 1, 1, 2, 2], lengths, radii)
    wrong = vw.Observation("pressure", "LPA", 2.0, waveform=7.5 * pressure)
    asked = {"starts": 4, "numerics": COARSE}
    alone = pulse.calibrate(network, lumped, "tangent", **asked)
    added = pulse.calibrate(network, lumped, "tangent", **asked, sites=[wrong]).sites.isel(site=0)
    named = [str(name) for name in alone.parameters.index]
    without = added["value_without"].sel(quantity=named).values
    np.testing.assert_allclose(without, alone.parameters["value"].to_numpy(float), rtol=0.01)


def test_a_site_somewhere_else_stands_apart(truth):
    late = np.roll(site(truth, "pressure").waveform, 16)
    fit = pulse.calibrate(NETWORK, truth[0], starts=1, sites=[vw.Observation("pressure", BRANCH, 0.1, waveform=late)])
    assert "fit.site-apart" in [one.code for one in fit.findings]


def test_what_is_no_site_of_the_network_is_refused(truth):
    def fit(one, **more):
        return pulse.calibrate(NETWORK, truth[0], starts=1, sites=[one], **more)

    with pytest.raises(InputError, match="the network has no vessel 'LPA'"):
        fit(vw.Observation("flow", "LPA", 0.01, mean=0.1))
    with pytest.raises(InputError, match="the place lies beyond it"):
        fit(vw.Observation("flow", BRANCH, 0.01, cm=3.0, mean=0.1))
    for wrong in (0.2, 1.03 * MOUSE.period):
        with pytest.raises(InputError, match="its cycle lasts"):
            fit(replace(site(truth, "flow"), period=wrong))
    with pytest.raises(InputError, match="is no site"):
        fit("flow")
    with pytest.raises(InputError, match="need a periodic state"):
        fit(site(truth, "flow"), numerics=vw.Numerics(cycles_from_rest=3))
