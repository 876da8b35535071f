"""The parts of a fit that are arithmetic: what is compared, where searches begin and end, sites, profiles, tables."""

import threading
from dataclasses import replace
from importlib import import_module
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest

import vasowave as vw
from vasowave.calibration import beside, generalized, profile, screening, search, starts
from vasowave.calibration.compared import Compared, PassedOn, _first, checked_harmonics, compared_part, flow_scale
from vasowave.calibration.objective import Objective
from vasowave.calibration.parameters import parameter_space, trial
from vasowave.calibration.result import Fit
from vasowave.calibration.search import SearchEnd, _Jacobians
from vasowave.calibration.sites import Sites, places_of, sites_of
from vasowave.calibration.uncertainty import covariance
from vasowave.errors import InputError, NumericalError
from vasowave.model.blood import Blood
from vasowave.model.linear import linear_solution
from vasowave.model.nominal import estimate_nominal
from vasowave.noise.spectrum import fourier, harmonics
from vasowave.recording import HarmonicErrors, Inflow, InletPressure, Observation
from vasowave.solver.places import Places, Waves
from vasowave.solver.simulate import Numerics
from vasowave.solver.validity import STRAINED

NETWORK, MOUSE = vw.control_network(), vw.virtual_mouse()
NOMINAL = estimate_nominal(NETWORK, MOUSE)
RNG = np.random.default_rng(4)
calibrate = import_module("vasowave.calibration.calibrate")


def space_of(wall="linear", bounds=None, fixed=None, **more):
    return parameter_space(wall, NETWORK, NOMINAL, Blood(), bounds or {}, fixed or {}, False, **more)


SPACE = space_of()


@pytest.mark.parametrize("value", [8, "8", 511, "511", "signal", "all"])
def test_harmonics_that_may_be_asked_for(value):
    assert checked_harmonics(value) == (value if value in ("signal", "all") else int(value))


@pytest.mark.parametrize("value", [7, 512, "7.5", "x", -8])
def test_harmonics_that_may_not(value):
    with pytest.raises(InputError, match=f"'{value}': give 'signal', 'all', or a number of harmonics from 8 to 511"):
        checked_harmonics(value)


def part(samples=19, choice="signal", signal=9, source="beats", enters="flow", **more):
    errors = HarmonicErrors(np.r_[np.full(signal + 1, 9.0), np.full(30 - signal, 0.1)], np.full(31, 0.5), source)
    return Compared(MOUSE, samples, choice, errors, enters=enters, **more)


def test_the_harmonics_that_are_compared_are_told_with_where_the_signal_ends(monkeypatch):
    def told(harmonics_, choice, signal, source):
        errors = SimpleNamespace(with_signal=signal, source=source, error=np.full(31, 0.5))
        found = Compared(MOUSE, 2 * harmonics_ + 1, choice, errors).findings()
        return found[0].code.removeprefix("fit.harmonics-"), str(found[0])

    assert told(9, "signal", 9, "beats")[0] == "with-signal"
    assert told(9, "signal", 10, "cycle")[0] == "of-averaged-cycle"
    assert told(9, "signal", 8, "beats")[0] == "fewest"
    assert told(9, "given", 9, "beats")[0] == "as-asked"
    assert told(9, "given", 8, "beats")[0] == "above-signal"
    assert told(9, "all", 10, "beats")[0] == "as-asked"
    said = told(9, "signal", 8, "beats")[1]
    assert said.startswith(
        "harmonics 0 to 9 of the pressure are compared (19 samples): signal stands out of the scatter"
    )
    assert "beats up to harmonic 8, and fewer leave" in said
    assert "of the rounding and the own high-frequency level of the averaged cycle" in told(9, "given", 8, "cycle")[1]


def test_a_flow_that_is_compared_counts_in_mmhg_of_the_pulse():
    one, other = part(), part(enters="pressure")
    scale = float(np.ptp(MOUSE.pressure) / np.ptp(MOUSE.flow))
    assert flow_scale(MOUSE) == pytest.approx(scale)
    assert (one.what, one.unit, one.scale, one.per_pressure) == ("pressure", "mmHg", 1.0, 1.0)
    assert (other.what, other.unit, other.scale) == ("flow", "ml/s", pytest.approx(scale))
    assert other.per_pressure == pytest.approx(
        scale * MOUSE.cardiac_output / (MOUSE.mean_pressure - MOUSE.wedge_pressure)
    )
    assert np.array_equal(one.signal_of(MOUSE), MOUSE.pressure)
    assert other.signal_of(MOUSE) == pytest.approx(scale * MOUSE.flow)
    assert isinstance(one.driven, Inflow)
    assert isinstance(other.driven, InletPressure)
    assert np.array_equal(other.driven.pressure, MOUSE.pressure)
    assert one.harmonics == 9
    assert one.time == pytest.approx(np.arange(19) * MOUSE.period / 19)
    residual = np.linspace(-1, 2, 19)
    assert one.mean_state(residual) == pytest.approx((one.measured.mean() - 0.5, MOUSE.cardiac_output))
    assert other.mean_state(residual) == pytest.approx((MOUSE.mean_pressure, (other.measured.mean() - 0.5) / scale))
    solved = SimpleNamespace(flow=np.array([[1, 2], [3, 4]]), pressure=np.array([[5, 6], [7, 8]]))
    assert one.of_linear(solved, 1).tolist() == [6, 8]
    assert other.of_linear(solved, 1) == pytest.approx([2 * scale, 4 * scale])
    said = [str(found) for found in other.findings()]
    assert said[1].startswith(
        "The measured pressure enters the model, and the flow is compared: 1 ml/s of it counts as"
    )
    assert f"{scale:.4g} mmHg" in said[1]


def test_errors_that_pass_on_add_in_their_squares_and_are_told():
    passed = PassedOn(np.full(10, 1.2), np.zeros(10), np.ones(10))
    one = part(passed_on=passed)
    assert part().error_power() == pytest.approx(np.full(10, 0.25))
    assert one.error_power() == pytest.approx(np.full(10, 0.25 + 1.44))
    said = str(one.findings()[-1])
    assert f"adds {np.sqrt(14.4):.2g} mmHg (root mean square) to that of the pressure, {np.sqrt(2.5):.2g} mmHg" in said
    assert _first(np.array([1.0, 2, 3]), 5).tolist() == [1, 2, 3, 3, 3]
    assert _first(np.array([1.0, 2, 3]), 2).tolist() == [1, 2]
    left = RNG.normal(size=19)
    table = one.spectrum(left)
    power = np.abs(np.fft.rfft(left) / 19) * np.r_[1.0, np.full(9, 2.0)]
    assert table["residual_modulus"].to_numpy() == pytest.approx(power)
    error = np.r_[1.69, np.full(9, 2 * 1.69)]
    assert table["measurement_error"].to_numpy() ** 2 == pytest.approx(error)
    assert table["discrepancy"].to_numpy() == pytest.approx(np.sqrt(np.maximum(power**2 - error, 0)))


def test_as_many_harmonics_are_compared_as_are_asked_for_or_held():
    assert compared_part(MOUSE, 12).samples == 25
    assert compared_part(MOUSE, 12).choice == "given"
    held = (len(MOUSE.pressure) - 1) // 2
    assert held == 255
    assert compared_part(MOUSE, 255).samples == 511
    with pytest.raises(
        InputError, match="512 samples hold 255 harmonics, 256 cannot be compared; give fewer, or 'all'"
    ):
        compared_part(MOUSE, 256)
    assert compared_part(MOUSE).samples % 2 == 1
    assert compared_part(MOUSE).enters == "flow"
    assert compared_part(MOUSE, "all").choice == "all"


def test_searches_begin_at_the_nominal_point_and_around_it_inside_the_bounds():
    low, high = SPACE.log_bounds
    points = starts.starting_points(SPACE, 40, 3)
    nominal = np.log(SPACE.nominal[SPACE.free])
    inside = 0.02 * (high - low)
    assert len(points) == 40
    assert points[0] == pytest.approx(np.clip(nominal, low + inside, high - inside))
    away = np.array(points[1:]) - nominal
    assert np.abs(away).max() <= 0.5
    assert np.abs(away).max() > 0.45
    assert not np.array_equal(points[1], starts.starting_points(SPACE, 40, 4)[1])
    narrow = space_of(bounds={name: (v, v * 1.01) for name, v in zip(SPACE.names, SPACE.nominal, strict=True)})
    low, high = narrow.log_bounds
    for point in starts.starting_points(narrow, 6, 1):
        assert np.all(point >= low + 0.0199 * (high - low))
        assert np.all(point <= high - 0.0199 * (high - low))


def test_a_start_that_was_led_says_by_which():
    end = starts._led(SearchEnd(np.zeros(1), 2.0, 30, True, "x"), 2)
    assert (end.simulations, end.S, end.message) == (
        0, 2.0, "the linear model leads it where start 3 was followed from"
    )  # fmt: skip


def test_the_last_jacobian_is_kept_where_the_step_was_small_and_as_foretold():
    asked = []

    def jacobian(x):
        asked.append(float(x[0]))
        return np.array([[1.0], [0.0]])

    def along(tolerance):
        asked.clear()
        one = _Jacobians(lambda x: np.array([x[0], 3.0]), jacobian, tolerance, np.inf)
        one.at(np.array([1.0]))  # S is 10
        one.at(np.array([0.9]))  # 9.81: 0.19 gained, all that was foretold
        return len(asked)

    assert along(0.0191) == 1
    assert along(0.0189) == 2
    asked.clear()
    bent = _Jacobians(lambda x: np.array([x[0] if x[0] == 1 else 0.98, 3.0]), jacobian, 1.0, np.inf)
    bent.at(np.array([1.0]))
    bent.at(np.array([0.5]))  # 0.0396 gained of 0.75 foretold
    assert len(asked) == 2


def test_a_search_ends_with_words_of_its_end():
    assert set(search._ENDS) == {0, 1, 2, 3, 4}
    assert (search.TOLERANCE, search.ROUGH) == (1e-8, 1e-6)


class Bowl:
    """Residuals of two parameters, linear but for a region that cannot be."""

    def __init__(self, broken=lambda x: False):
        self.broken, self.simulations, self.best = broken, 0, None
        self.space = SimpleNamespace(log_bounds=(np.array([-2.0, -2.0]), np.array([2.0, 2.0])))

    def at(self, x):
        if self.broken(x):
            raise NumericalError("cannot be")

    def residuals(self, x):
        self.at(x)
        self.simulations += 1
        return np.array([x[0] - 0.5, 2 * (x[1] + 0.25), 0.1])

    def jacobian(self, x):
        return np.array([[1.0, 0], [0, 2.0], [0, 0]])


def test_the_papers_search_finds_a_bowls_bottom_and_says_why_another_does_not_begin():
    end = search.search(Bowl(), np.array([1.0, 1.0]), "sqp")
    assert end.x == pytest.approx([0.5, -0.25], abs=1e-4)
    assert end.S == pytest.approx(0.01, abs=1e-6)
    assert end.converged
    none = search.search(Bowl(lambda x: True), np.ones(2), "sqp")
    assert (none.S, none.converged, none.message) == (np.inf, False, "the start cannot be simulated: cannot be")
    left = search.search(Bowl(), np.ones(2), "sqp", enough=0.009)
    assert left.message == "far above the best optimum, and on no way to it"
    assert left.x.tolist() == [1.0, 1.0]
    assert left.S == pytest.approx(0.25 + 6.25 + 0.01)
    assert search.search(Bowl(), np.ones(2), "sqp", enough=0.011).converged
    broken = search.search(Bowl(lambda x: x[0] < 0.9), np.ones(2), "sqp")
    assert (broken.converged, broken.message) == (False, "cannot be")


def waves(count=64):
    return Waves(*(RNG.uniform(1, 2, (count, 3)) for _ in range(3)))


OBSERVED = (
    Observation("pressure", NETWORK.name[1], error=0.4, place=0.25, waveform=10 + RNG.normal(size=33), zero_sd=0.6),
    Observation("flow", NETWORK.name[2], error=0.01, mean=0.08, systolic=0.2, gain_sd=0.1),
    Observation("diameter", NETWORK.name[3], error=0.002, systolic=0.09, mean=0.08, diastolic=0.07),
)


@pytest.fixture(scope="module")
def sites():
    places = Places(np.array([1, 2, 3]), np.array([0.25, 0.5, 0.5]))
    return Sites(OBSERVED, places, 41, 12.0, 0.36)


def test_sites_have_rows_of_harmonics_or_of_numbers(sites):
    rows = [(one.start, one.stop) for one in sites.rows]
    assert rows == [(0, 33), (33, 35), (35, 38)]
    names = [[*one.numbers] for one in OBSERVED]
    assert sites.harmonic[:33].tolist() == [*range(17), *range(1, 17)]
    assert sites.harmonic[33:].tolist() == [0 if name == "mean" else -1 for name in [*names[1], *names[2]]]
    pulses = [np.ptp(OBSERVED[0].waveform), OBSERVED[1].pulse or 0.2, OBSERVED[2].pulse or 0.09]
    assert sites.scales == pytest.approx([12.0 / one for one in pulses])


def test_what_sites_measured_counts_as_samples_of_their_means(sites):
    root = np.sqrt(41)
    wave = OBSERVED[0].waveform
    own = np.fft.rfft(wave) / 33
    expected = [root * own[0].real, *(root * np.sqrt(2) * own[1:17].real), *(-root * np.sqrt(2) * own[1:17].imag)]
    assert sites.measured[:33] == pytest.approx(sites.scales[0] * np.array(expected))
    flow = [value * (root if name == "mean" else 1) for name, value in OBSERVED[1].numbers.items()]
    assert sites.measured[33:35] == pytest.approx(sites.scales[1] * np.array(flow))


def test_errors_of_sites_are_their_own_their_zero_and_their_gain(sites):
    root, scale = np.sqrt(41), sites.scales
    first = (scale[0] * 0.4) ** 2 * np.eye(33)
    first[0, 0] += (0.6 * scale[0] * root) ** 2
    assert sites.covariance[:33, :33] == pytest.approx(first)
    known = scale[1] * np.array([root if name == "mean" else 1 for name in OBSERVED[1].numbers])
    second = np.diag((known * 0.01) ** 2) + 0.01 * np.outer(sites.measured[33:35], sites.measured[33:35])
    assert sites.covariance[33:35, 33:35] == pytest.approx(second)
    assert np.all(sites.covariance[:33, 33:] == 0)
    both = sites.covariance + 0.36**2 * np.eye(38)
    assert sites.balance @ both @ sites.balance == pytest.approx(0.36**2 * np.eye(38), abs=1e-10)


def test_simulated_waves_stand_where_the_measured_ones_do(sites):
    one = waves()
    found = sites.coefficients(one)
    k = harmonics(41)
    coarse = np.fft.irfft(np.fft.rfft(one.pressure[:, 0]), 41) * 41 / 64
    assert found[:33] == pytest.approx(sites.scales[0] * fourier(coarse)[k <= 16])
    root = np.sqrt(41)
    flow = {"mean": root * one.flow[:, 1].mean(), "systolic": one.flow[:, 1].max()}
    assert found[33:35] == pytest.approx([sites.scales[1] * flow[name] for name in OBSERVED[1].numbers])
    d = 2 * np.sqrt(one.area[:, 2] / np.pi)
    wide = {"mean": root * d.mean(), "systolic": d.max(), "diastolic": d.min()}
    assert found[35:] == pytest.approx([sites.scales[2] * wide[name] for name in OBSERVED[2].numbers])
    change = Waves(*(RNG.normal(size=(2, 64, 3)) for _ in range(3)))
    slopes = sites.jacobian(one, change)
    assert slopes.shape == (38, 2)
    for column in range(2):
        moved = Waves(*(a + 1e-6 * b[column] for a, b in zip(one, change, strict=True)))
        assert slopes[:, column] == pytest.approx((sites.coefficients(moved) - found) / 1e-6, rel=1e-3, abs=1e-3)


def test_a_site_can_be_left_out_and_the_last_one_leaves_none(sites):
    rest = sites.without(1)
    assert [one.vessel for one in rest.observations] == [NETWORK.name[1], NETWORK.name[3]]
    assert (rest.places.vessel.tolist(), rest.places.share.tolist()) == ([1, 3], [0.25, 0.5])
    assert rest.without(0).without(0) is None


def test_places_lie_in_their_vessels_and_cycles_are_as_long():
    length = float(NETWORK.length[1])

    def at(**more):
        one = Observation("pressure", NETWORK.name[1], error=1.0, mean=10.0, **more)
        return places_of([one], NETWORK, 0.1)

    assert at(cm=length).share == pytest.approx([1.0])
    assert at(cm=0.25 * length).share == pytest.approx([0.25])
    assert at().vessel.tolist() == [1]
    with pytest.raises(InputError, match="the place lies beyond it"):
        at(cm=1.01 * length)
    with pytest.raises(InputError, match="is no site; give Observation"):
        places_of(["flow"], NETWORK, 0.1)
    with pytest.raises(InputError, match=r"its cycle lasts 0.2 s and that of the recording 0.1 s"):
        at(period=0.2)
    assert at(period=0.1).share == pytest.approx([0.5])
    assert sites_of((), NETWORK, part()) is None
    made = sites_of(OBSERVED, NETWORK, part())
    assert (made.samples, made.pulse) == (19, pytest.approx(np.ptp(MOUSE.pressure)))
    assert made.deviation == pytest.approx(0.03 * made.pulse)


def test_slips_of_units_and_shapes_are_told_by_their_factor():
    flows = list(beside._slips("flow"))
    assert (60.0, "ml/min had been read as ml/s") in flows
    assert (1 / 60, "ml/s had been read as ml/min") in flows
    canonical = ["ml/s" in what.replace("had been read as ", "").split() for _, what in flows]
    assert canonical == sorted(canonical, reverse=True)  # slips from and to the usual unit come first
    assert len(flows) == 7 * 6
    assert min(beside._slips("area"))[0] < 1e-4
    wide = {what: factor for factor, what in beside._slips("diameter")}
    assert (wide["a radius had been given for it"], wide["it had been given for a radius"]) == (0.5, 2.0)
    square = {what: factor for factor, what in beside._slips("area")}
    assert square["a radius squared had been given for it"] == pytest.approx(1 / np.pi, rel=1e-3)
    assert square["a diameter squared had been given for it"] == pytest.approx(4 / np.pi, rel=1e-3)


def an_end(rows, jacobian, covariance_):
    return SimpleNamespace(
        coefficients=np.asarray(rows, float), jacobian=np.asarray(jacobian, float), covariance=covariance_
    )


def test_what_a_site_observed_over_what_the_others_foretell_is_weighted_by_the_foretold():
    fake = SimpleNamespace(
        rows=(slice(0, 1), slice(1, 3)), measured=np.array([9.0, 3.0, 5.0]), covariance=np.diag([9.0, 0.5, 0.7]),
        deviation=0.4, observations=[None, SimpleNamespace(gain=0.05)],
    )  # fmt: skip
    end = an_end([8.0, 1.0, 2.0], [[0, 0], [1.0, 0.5], [0.0, 2.0]], np.array([[0.04, 0.01], [0.01, 0.09]]))
    assert beside._ratio(fake, 1, end) == pytest.approx((3 * 1 + 5 * 2) / 5)
    spread = [0.04 + 2 * 0.5 * 0.01 + 0.25 * 0.09, 4 * 0.09]
    expected = 0.5 + 0.16 + spread[0] + 0.7 + 0.16 + spread[1]
    assert beside._misfit(fake, 1, end) == pytest.approx(np.sqrt((4 + 9) / expected))
    slope = (np.array([1.0, 0.5]) + 2 * np.array([0.0, 2.0])) / 5
    sd = np.sqrt(slope @ end.covariance @ slope + 0.05**2 + 0.03**2)
    edge = np.exp(4 * sd)

    def slip(ratio):
        return beside._slip("diameter", ratio, end, fake, 1)

    assert slip(edge * 0.999) is None
    assert slip(0.0) is None
    assert slip(-3.0) is None
    assert slip(10.0) == "mm had been read as cm"
    assert slip(100.0) is not None
    sharp = an_end([8.0, 1.0, 2.0], np.zeros((3, 2)), np.zeros((2, 2)))
    sure = np.sqrt(0.05**2 + 0.03**2)
    assert beside._slip("diameter", np.exp(4.01 * sure), sharp, fake, 1) is None  # nearest is no slip at all
    assert beside._slip("diameter", 2.0, sharp, fake, 1) == "it had been given for a radius"
    assert beside._slip("diameter", 0.5, sharp, fake, 1) == "a radius had been given for it"


def test_noise_is_whitened_at_the_inlet_and_sites_count_by_their_deviation():
    fit = SimpleNamespace(compared=SimpleNamespace(sites=SimpleNamespace(deviation=4.0)), N=3)
    white = generalized.beside_sites(lambda values: 10 * values, fit)
    assert white(np.array([1.0, 2, 3, 8, 12])).tolist() == [10, 20, 30, 2, 3]
    assert white(np.arange(10.0).reshape(5, 2))[3:].tolist() == [[1.5, 1.75], [2.0, 2.25]]
    plain = SimpleNamespace(compared=SimpleNamespace(sites=None), N=3)
    assert generalized.beside_sites(np.negative, plain) is np.negative


def test_a_generalized_search_ends_at_the_bottom_or_at_a_bound():
    bowl = Bowl()
    x, converged, _ = generalized._descend(bowl, lambda r: r / 3, np.array([1.0, 1.0]))
    assert converged
    assert x == pytest.approx([0.5, -0.25], abs=1e-2)
    bowl.space = SimpleNamespace(log_bounds=(np.array([0.75, -2.0]), np.array([2.0, 2.0])))
    x, _, _ = generalized._descend(bowl, lambda r: r / 3, np.array([1.0, 1.0]))
    assert x == pytest.approx([0.75, -0.25], abs=1e-2)
    assert x[0] >= 0.75
    bowl.space = SimpleNamespace(log_bounds=(np.array([-2.0, -2.0]), np.array([2.0, -0.5])))
    assert generalized._descend(bowl, lambda r: r / 3, np.array([1.0, -1.0]))[0] == pytest.approx([0.5, -0.5], abs=1e-2)


def test_a_profile_crosses_its_limit_between_points_by_the_root_of_the_deviance():
    limit = 3.841458820694124
    x = np.arange(7.0)
    deviance = np.array([9.0, 4.0, 1.0, 0.0, 0.25, 2.25, 6.25])
    low, high = profile._crossings(x, deviance)
    assert low == pytest.approx(2 - (np.sqrt(limit) - 1.0))
    assert high == pytest.approx(5 + (np.sqrt(limit) - 1.5))
    assert np.isnan(profile._crossings(x, np.array([3.0, 2, 1, 0, 1, 2, 3]))).all()
    assert np.isnan(profile._crossings(x[:4], deviance[:4])[1])
    exact = profile._crossings(x[:3], np.array([limit, 0.0, 1.0]))
    assert exact[0] == pytest.approx(0.0)


def test_a_profile_reaches_as_far_as_its_span_or_bounds():
    table = pd.DataFrame({"lower": [1.0], "upper": [30.0], "free": [True]}, index=["a"])
    fit = SimpleNamespace(parameters=table, residual=np.array([1.0, 2.0, 2.0, 4.0]), N=4)
    grid = profile._grid(fit, "a", 20.0, 5, 0.7)
    assert grid[[0, -1]] == pytest.approx([20 * np.exp(-0.7), 30.0])
    assert np.diff(np.log(grid)) == pytest.approx(np.full(4, np.log(grid[-1] / grid[0]) / 4))
    assert profile._grid(fit, "a", 1.5, 5, 0.7)[0] == 1.0
    assert profile._independent(fit)(np.array([5.0])) == pytest.approx([5 / np.sqrt(25 / 3)])


def test_profiles_need_four_points_and_a_free_parameter():
    table = pd.DataFrame({"free": [True, False, True]}, index=["a", "b", "c"])
    fit = SimpleNamespace(parameters=table, wall="linear")
    for name in ("b", "x"):
        with pytest.raises(InputError, match=f"'{name}' is no free parameter of the linear wall; free are: a, c"):
            profile.profile_likelihood(fit, name)
    for points, span in ((3, 0.7), (4, 0.0), (4, -1.0)):
        with pytest.raises(
            InputError, match=f"points {points}, span {span:g}: give at least four points and a positive"
        ):
            profile.profile_likelihood(fit, "a", points=points, span=span)


def test_a_dataset_of_a_profile_counts_from_its_least():
    ends = [
        SimpleNamespace(
            values={"a": value}, residual=np.array([r, 1.0]), converged=ok,
            space=SimpleNamespace(names=("a",), parameters={"a": SimpleNamespace(unit="mmHg")}),
        )
        for value, r, ok in ((1.0, 4.0, True), (2.0, 1.0, True), (4.0, 3.0, False))
    ]  # fmt: skip
    found = profile._dataset("a", ends, lambda r: r / 2)
    assert found["deviance"].values == pytest.approx([15 / 4, 0.0, 2.0])
    assert found["S"].values == pytest.approx([17.0, 2.0, 10.0])
    assert found["converged"].values.tolist() == [True, True, False]
    assert found.attrs["level"] == 0.95
    assert np.isnan(found.attrs["lower"])
    assert found["a"].attrs["units"] == "mmHg"


def test_the_plain_covariance_has_as_many_degrees_as_samples_are_left():
    J, r = RNG.normal(size=(6, 2)), np.array([1.0, 2, 2, 0, 0, 0])
    assert covariance(J, r) == pytest.approx(9 / 4 * np.linalg.inv(J.T @ J))
    assert covariance(J[:2], r[:2]) == pytest.approx(5 * np.linalg.inv(J[:2].T @ J[:2]))


def test_starts_that_begin_alike_have_one_lead(monkeypatch):
    points = [
        np.array([0.0, 0]),
        np.array([0.149, 0]),
        np.array([0.1, 0.151]),
        np.array([0.2, 0.2]),
        np.array([5.0, 5]),
    ]
    monkeypatch.setattr(screening, "led", lambda space, compared, start: start)
    assert screening.screened(None, None, points)[1] == [0, 0, 2, 2, 4]


def test_the_linear_models_residuals_are_half_the_squares_of_its_harmonics():
    compared = part(samples=61)
    residuals = screening.linear_residuals(SPACE, compared)
    x = np.log(SPACE.nominal[SPACE.free])
    got = residuals(x)
    assert len(got) == 26  # the mean and twelve harmonics, real and imaginary
    solved = linear_solution(SPACE.model(SPACE.nominal), compared.driven, 12)
    measured = np.fft.rfft(compared.measured)[:13] / 61 * np.r_[1.0, np.full(12, 2.0)]
    missed = (measured - solved.pressure[:, NETWORK.root]) * np.sqrt(np.r_[1.0, np.full(12, 0.5)])
    assert got == pytest.approx(np.r_[missed.real, missed.imag])
    assert len(screening.linear_residuals(SPACE, part(samples=17))(x)) == 18
    assert residuals(np.full(len(x), np.nan)).tolist() == [1000.0] * 26
    assert screening.knows(SPACE)
    assert not screening.knows(space_of("tangent"))


def test_numerics_of_searches_are_coarser_than_those_of_the_end():
    given = Numerics(tolerance=1e-7)
    fine = calibrate._for_fits(given, 300)
    assert (fine.samples, fine.every_cell, fine.tolerance) == (300, False, 1e-7)
    assert calibrate._for_fits(Numerics(tolerance=1e-3), 300).tolerance == 1e-6
    rough = calibrate._coarser(fine)
    assert (rough.samples, rough.tolerance) == (64, pytest.approx(1e-6))
    for fixed in (Numerics(cycles_from_rest=3), Numerics(steps_per_cycle=4096)):
        assert calibrate._coarser(fixed) is fixed


def test_sites_count_by_what_the_inlet_alone_leaves():
    fake = part(samples=13)
    fake = replace(fake, sites=Sites(OBSERVED, Places(np.array([1, 2, 3]), np.array([0.25, 0.5, 0.5])), 13, 12.0, 0.36))
    alone = SearchEnd(np.zeros(4), 2.25, 1, True, "")
    assert calibrate._weighted(fake, alone).sites.deviation == pytest.approx(np.sqrt(2.25 / 9))
    assert calibrate._weighted(fake, replace(alone, S=1e-9)).sites.deviation == pytest.approx(0.036)
    assert calibrate._weighted(replace(fake, samples=3), alone).sites.deviation == pytest.approx(1.5)


def test_starts_agree_that_end_as_low_or_lower_than_can_be_seen():
    x = np.log(SPACE.nominal[SPACE.free])

    def ends(*S):
        return [SearchEnd(x, one, 5, True, "") for one in S]

    table = calibrate._starts_table(SPACE, ends(10.02, 10.0, 10.0101, 10.0109, 12.0), 1000)
    assert table["S [mmHg2]"].tolist() == [10.0, 10.0101, 10.0109, 10.02, 12.0]
    assert table["start"].tolist() == [1, 2, 3, 4, 5]
    assert table["agrees"].tolist() == [True, True, True, False, False]  # 10 · 1.001 + 1000 · 1e-6
    joined = [SearchEnd(x, 12.0, 1, True, "", joined=True), *ends(10.0)]
    assert calibrate._starts_table(SPACE, joined, 10)["agrees"].tolist() == [True, True]
    assert table[SPACE.names[0]].tolist() == pytest.approx([SPACE.nominal[0]] * 5)


def test_the_best_end_that_can_be_simulated_again_is_taken(monkeypatch):
    lost = {1.0: np.inf, 2.0: np.inf, 3.0: 2.9}
    again = lambda objective, x, method: SearchEnd(x, lost[float(x[0])], 1, True, "gone")  # noqa: E731
    monkeypatch.setattr(calibrate.searching, "search", again)
    ends = [SearchEnd(np.array([S]), S, 1, True, "") for S in (3.0, np.inf, 1.0, 2.0)]
    plan = SimpleNamespace(method="sqp")
    with pytest.warns(UserWarning, match="the best 2 of 3 ends could not be simulated a second time"):
        assert calibrate._polish(SPACE, part(), Numerics(), plan, ends)[1].S == 2.9
    lost[3.0] = np.inf
    with pytest.raises(NumericalError, match="no optimum of the 3 starts could be simulated a second time; gone"):
        calibrate._polish(SPACE, part(), Numerics(), plan, ends)


def test_a_space_has_bounds_in_the_units_of_the_nominal_wall():
    own = SPACE.parameters
    for place, (name, one) in enumerate(own.items()):
        unit = NOMINAL.beta if one.unit in ("mmHg", "mmHg s") else 1.0
        assert (SPACE.lower[place], SPACE.upper[place]) == pytest.approx(tuple(unit * end for end in one.bounds)), name
        assert SPACE.nominal[place] == pytest.approx(unit * one.nominal)
    held = space_of(fixed={"beta": 55.0})
    assert held.nominal[0] == 55.0
    assert held.free.tolist() == [False, *SPACE.free[1:]]
    assert held.free_names == SPACE.names[1:]
    assert held.values(np.log([2.0, 3.0, 4.0])).tolist() == pytest.approx([55.0, 2.0, 3.0, 4.0])
    assert space_of(bounds={"beta": (10.0, 400.0)}).lower[0] == 10.0
    for bounds in ((0.0, 1.0), (2.0, 2.0), (3.0, 2.0), (1.0, np.inf)):
        with pytest.raises(InputError, match="they must be positive and ordered"):
            space_of(bounds={"beta": bounds})
    for value in (0.0, -1.0, np.inf, np.nan):
        with pytest.raises(InputError, match=r"beta cannot be held at .*; it must be positive"):
            space_of(fixed={"beta": value})
    with pytest.raises(InputError, match="every parameter is held fixed"):
        space_of(fixed=dict.fromkeys(SPACE.names, 1.0))
    with pytest.raises(
        InputError, match=r"the linear wall has no parameter 'betta' \(did you mean 'beta'\?\); it has: beta"
    ):
        space_of(bounds={"betta": (1, 2)})


@pytest.mark.parametrize(
    ("error", "words"),
    [
        (InputError("why"), "^why$"), (ZeroDivisionError("why"), r"make no model \(ZeroDivisionError: why\)"),
        (ValueError("why"), r"make no model \(ValueError: why\)"), (NumericalError("why"), "^why$"),
    ],
)  # fmt: skip
def test_what_goes_wrong_in_a_trial_is_a_trial_that_failed(error, words):
    with pytest.raises(NumericalError, match=words), trial():
        raise error
    with pytest.raises(KeyError), trial():
        raise KeyError


def test_a_trial_that_fails_counts_more_than_all_before(monkeypatch):
    one = Objective(SPACE, part(samples=13), Numerics(), 1, threading.Event())
    x = np.mean(SPACE.log_bounds, axis=0)

    def broken(x):
        raise NumericalError("no")

    monkeypatch.setattr(one, "at", broken)
    assert one.residuals(x).tolist() == [1000.0] * 13
    assert not one.can_be(x)
    one._largest = 50.0
    assert one.residuals(x).tolist() == [1050.0] * 13
    assert one.best is None


def shown_fit(pulse, findings=(), at_bound=False):
    table = pd.DataFrame(
        {"value": [50.123, 2.0], "unit": ["mmHg", "1"], "free": [True, False], "interval_low": [40.0, 1.0],
         "interval_high": [60.0, 3.0], "at_bound": [at_bound, False], "determined": [not at_bound, False]},
        index=["beta", "c1"],
    )  # fmt: skip
    cycle = SimpleNamespace(notes=(), pulse_pressure=pulse)
    compared = SimpleNamespace(harmonics=9, recording=cycle, error_power=lambda: np.zeros(10))
    model = SimpleNamespace(wall=SimpleNamespace(law=lambda: SimpleNamespace(formula="p = A")))
    begun = pd.DataFrame({"agrees": [True, True, False]})
    residual = np.array([3.0, 4.0, 0.0, 0.0])
    return Fit("linear", model, compared, None, table, pd.DataFrame(), begun, None, residual, 25.0, findings)


def test_a_fit_shows_its_numbers():
    one = shown_fit(100.0)
    assert repr(one) == "Fit(linear wall: beta 50.12, c1 2; S 25, N 4, RMSE 2.5 mmHg)"
    assert (one.mean_square, one.rmse, one.misses) == (6.25, 2.5, "")
    shown = one._repr_html_()
    for said in (
        "beta [mmHg]", "50.12 [40, 60]<", "2 [1, 3] (held)", "25 mmHg² over 4 samples (harmonics 0 to 9)",
        "root mean square 2.5 mmHg", "2 of 3 came to this optimum", "<strong>Fit, linear wall: p = A</strong>",
    ):  # fmt: skip
        assert said in shown, said


def test_a_fit_says_first_that_it_misses_the_data_and_marks_what_stopped_at_a_bound():
    one = shown_fit(7.5, at_bound=True)
    assert repr(one) == (
        "Fit(linear wall, misses the data by 33 % of the pulse pressure; do not use its numbers: beta 50.12†, c1 2; "
        "S 25, N 4, RMSE 2.5 mmHg; † at a bound of its search)"
    )
    shown = one._repr_html_()
    assert "misses the data by 33 %" in shown
    assert shown.index("misses the data") < shown.index("beta")
    strained = shown_fit(100.0, (STRAINED(vessel="1", percent=300.0, time=0.1),))
    assert "strains a vessel beyond what an artery survives; do not use" in repr(strained)
