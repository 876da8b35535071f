"""All starts are led together by the linear network and what simulations say of it; none is lost by that."""

from dataclasses import replace

import numpy as np
import pytest

from vasowave import pulse
from vasowave.pulse.calibration import (
    Coordinates,
    CorrectedNetwork,
    ParameterLimits,
    compared_part,
    descend,
    linear_optimum,
    linear_spectra,
    parameter_space,
    spanning_tree,
    spectrum_of,
)
from vasowave.pulse.examples import virtual_mouse
from vasowave.pulse.model import Blood, Numerics, StructuredTree, estimate_nominal
from vasowave.pulse.network import Network

NETWORK, MOUSE = Network(("1", "2", "3"), [-1, 0, 0], [0.4, 0.4, 0.5], [0.05, 0.035, 0.04]), virtual_mouse()
COARSE = Numerics(cell_size=0.3, tolerance=1e-6)


def posed(law, bed=None, enters=None):
    nominal = estimate_nominal(NETWORK, MOUSE, Blood(), *([bed] if bed else []))
    return parameter_space(law, NETWORK, nominal, Blood(), ParameterLimits()), compared_part(MOUSE, "signal", enters)


def test_the_real_spectrum_of_a_residual_has_its_sum_of_squares_over_its_samples():
    rng = np.random.default_rng(1)
    for samples in (21, 24):
        residual = rng.standard_normal(samples)
        spectrum = spectrum_of(residual, samples)
        assert np.sum(spectrum**2) == pytest.approx(np.sum(residual**2) / samples, rel=1e-12)


def test_a_surrogate_passes_through_what_it_learned_with_its_derivatives():
    space, compared = posed("tangent")
    coordinates, linear = Coordinates(space, MOUSE.mean_pressure), linear_spectra(space, compared)
    middle = coordinates.of(np.log(space.nominal[space.free]))
    surrogate, rng, step = CorrectedNetwork(coordinates, linear, 1.0), np.random.default_rng(2), 1e-4
    known = []
    for place in middle + 0.3 * rng.standard_normal((4, len(middle))):
        value = linear(coordinates.logarithms(place[np.newaxis]))[0]
        value, slopes = value + rng.standard_normal(value.shape), rng.standard_normal((len(value), len(middle)))
        surrogate.learn(place, value, slopes)
        known.append((place, value, slopes))
    for place, value, slopes in known:
        assert np.allclose(surrogate.residuals(place[np.newaxis])[0, :-1], value, atol=1e-4)
        for number, unit in enumerate(step * np.eye(len(middle))):
            up, down = surrogate.residuals(np.array([place + unit, place - unit]))
            assert np.allclose((up - down)[:-1] / (2 * step), slopes[:, number], atol=2e-2)
        assert surrogate.deviation(place[np.newaxis]) < 1e-2


@pytest.mark.parametrize("law", ["linear", "tangent", "power"])
def test_coordinates_of_many_places_are_those_of_each(law):
    space, _ = posed(law)
    coordinates, rng = Coordinates(space, MOUSE.mean_pressure), np.random.default_rng(3)
    x = np.log(space.nominal[space.free]) + 0.3 * rng.standard_normal((5, int(space.free.sum())))
    z = coordinates.of(x)
    np.testing.assert_allclose(z, [coordinates.of(place) for place in x], rtol=1e-13)  # powers of many are vectorized
    assert np.allclose(coordinates.logarithms(z), x, atol=1e-9)


def test_places_are_led_to_the_minimum_of_a_function_that_is_known_and_stop_at_bounds():
    space, _ = posed("linear")
    coordinates = Coordinates(space, MOUSE.mean_pressure)
    low, high = space.log_bounds
    target = np.log(space.nominal[space.free]) + np.array([0.3, -0.2, 0.1, 0.0])
    target[3] = high[3] + 0.5
    starts = np.clip(target + np.random.default_rng(4).uniform(-0.5, 0.5, (6, 4)), low + 0.1, high - 0.1)
    ends = descend(lambda _, x: x - target, coordinates, starts, 1e6)
    assert ends.end.tolist() == [0] * 6
    assert np.allclose(ends.x[0], np.minimum(target, high), atol=1e-4)


def test_the_linear_network_alone_leads_a_linear_wall_to_where_the_fit_ends():
    space, compared = posed("linear")
    fit = pulse.calibrate(NETWORK, MOUSE, "linear", starts=1, numerics=COARSE)
    ended = np.log(fit.parameters["value"].to_numpy()[space.free])
    assert np.max(np.abs(linear_optimum(space, compared) - ended)) < 0.3


def test_beds_that_are_no_circuits_are_right_to_first_order_about_the_nominal_ones():
    space, compared = posed("linear", StructuredTree)
    nominal, linear = np.log(space.nominal[space.free]), linear_spectra(space, compared)

    def direct(x):
        solved = pulse.model.linear.linear_solution(space.model(space.values(x)), compared.driven, 12)
        return solved.pressure[:, NETWORK.root]

    count = min(compared.samples // 2, 12) + 1
    held = compared.samples // 2 + 1
    scale = np.where(np.arange(count) > 0, np.sqrt(0.5), 1.0)
    base = linear(nominal[np.newaxis])[0]
    for unit, tolerance in zip(1e-2 * np.eye(len(nominal)), [1e-8, *[2e-3] * (len(nominal) - 1)], strict=True):
        change = linear((nominal + unit)[np.newaxis])[0] - base
        true = -scale * (direct(nominal + unit) - direct(nominal))[:count]
        error = np.hypot(change[:count] - true.real, change[held : held + count] - true.imag)
        assert error.max() <= tolerance * np.abs(true).max() + 1e-9


def test_where_the_pressure_enters_the_linear_network_leaves_what_its_exact_solution_leaves_of_the_flow():
    space, compared = posed("linear", enters="pressure")
    nominal = np.log(space.nominal[space.free])
    solved = pulse.model.linear.linear_solution(space.model(space.nominal), compared.driven, 12)
    count, held = min((compared.samples - 1) // 2, 12) + 1, compared.samples // 2 + 1
    left = linear_spectra(space, compared)(nominal[np.newaxis])[0]
    scale, simulated = np.where(np.arange(count) > 0, np.sqrt(0.5), 1), compared.of_linear(solved, NETWORK.root)[:count]
    measured = np.fft.rfft(compared.measured)[:count] / compared.samples / scale**2
    exact = scale * (measured - simulated)
    assert np.allclose(left[:count] + 1j * left[held : held + count], exact, atol=0.01 * np.abs(simulated).max())


def test_a_law_that_raises_for_some_places_leaves_the_others_what_they_leave_alone():
    class Picky(pulse.model.LinearWall):
        @staticmethod
        def ratio_at(pressure, beta):
            if np.any(np.asarray(beta) > 1e3):
                raise ArithmeticError("too stiff")
            return pulse.model.LinearWall.ratio_at(pressure, beta)

    space, compared = posed("linear")
    places = np.log(space.nominal[space.free]) + np.array([[0.0, 0, 0, 0], [9.0, 0, 0, 0], [0.1, 0, 0, 0]])
    plain = linear_spectra(space, compared)(places)
    picky = linear_spectra(replace(space, law=Picky), compared)(places)
    assert np.array_equal(picky[[0, 2]], plain[[0, 2]])
    assert np.isnan(picky[1]).any()


def test_the_tree_of_a_network_with_a_loop_has_all_its_beds_and_no_loop():
    nodes = [[0, 1], [1, 2], [1, 3], [2, 3], [2, 4], [3, 5]]
    graph = Network(tuple("abcdef"), None, [1.0] * 6, [0.05, 0.04, 0.035, 0.03, 0.025, 0.02], nodes=nodes)
    tree = spanning_tree(graph)
    assert tree.nodes is None
    assert tree.name == tuple("abcef")
    assert [tree.name[row] for row in tree.terminals] == [graph.name[row] for row in graph.terminals] == ["e", "f"]
    assert [tree.name[row] for row in tree.parent if row >= 0] == ["a", "a", "b", "c"]
    assert np.array_equal(tree.radius, np.delete(graph.radius, 3))
    assert spanning_tree(tree) is tree


def test_every_start_has_its_row_and_the_best_valley_bears_its_simulations():
    reached = []
    fit = pulse.calibrate(
        NETWORK, MOUSE, "tangent", starts=8, numerics=COARSE, progress=lambda *state: reached.append(state)
    )
    assert len(fit.starts) == 8
    best = fit.starts[fit.starts["agrees"]]
    assert best["message"].str.contains("valley of the best optimum").all()
    assert (best["simulations"] > 0).sum() == 1
    assert fit.starts["simulations"].sum() < 40
    assert reached[-1][:2] == (8, 8)


def test_the_papers_method_begins_where_the_paper_begins():
    fit = pulse.calibrate(NETWORK, MOUSE, "linear", starts=2, method="sqp", numerics=COARSE)
    assert (fit.starts["simulations"] > 0).all()
