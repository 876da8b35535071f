"""The emulator of an animal, against simulations that it has not seen; Sobol' indices against Ishigami's formula."""

import time
from dataclasses import replace

import numpy as np
import pytest

import vasowave as vw
from vasowave.pulse.analysis import uncertain_model
from vasowave.pulse.calibration import calibrate
from vasowave.pulse.inference import sensitivity_of, sobol_table
from vasowave.pulse.model import with_parameters

NETWORK = vw.Network(("1", "2", "3"), [-1, 0, 0], [0.4, 0.3, 0.5], [0.05, 0.042, 0.036])


@pytest.fixture(scope="module")
def fit():
    """Return a fit of which stiffness and distal resistance are free, which makes few simulations do."""
    return calibrate(NETWORK, vw.virtual_mouse(), search=vw.Search(starts=1, fixed={"r1": 0.5, "c1": 1.0}))


@pytest.fixture(scope="module")
def emulator(fit):
    return vw.emulate(fit)


def drawn(emulator, count, seed):
    low, high = emulator.box["low"].to_numpy(), emulator.box["high"].to_numpy()
    return low * (high / low) ** np.random.default_rng(seed).random((count, len(low)))


def simulated(fit, names, points):
    """mPAP, sPAP, dPAP, pPAP and power of models, by their waves."""
    beds, rows = fit.nominal.outlets, []
    values = {str(name): float(value) for name, value in fit.parameters["value"].items()}
    models = [with_parameters(fit.model, values | dict(zip(names, point, strict=True)), beds) for point in points]
    waves = vw.simulate(models, fit.recording)
    inlet = waves.sel(vessel="1", station="inlet")
    for pressure, flow in zip(inlet.pressure.values, inlet.flow.values, strict=True):
        power = 0.1333224 * np.mean(pressure * flow)
        rows.append([pressure.mean(), pressure.max(), pressure.min(), np.ptp(pressure), power])
    return np.array(rows)


NAMES = ("mPAP", "sPAP", "dPAP", "pPAP", "power")


def shares_within(fit, emulator, count):
    """Share of unseen sets whose answers are within the stated error, by quantity."""
    points = drawn(emulator, count, 7)
    answers = emulator(dict(zip(emulator.box.index, points.T, strict=True)))[[*NAMES]].to_numpy()
    stated = emulator.quantities.loc[[*NAMES], "error"].to_numpy()
    return (np.abs(answers - simulated(fit, emulator.box.index, points)) <= stated).mean(axis=0)


def test_unseen_sets_are_within_the_error_that_it_states(fit, emulator):
    assert (shares_within(fit, emulator, 20) >= 0.85).all()
    assert (emulator.quantities["error"] < 0.05).all()


@pytest.mark.parametrize(
    "law",
    [
        pytest.param("linear", marks=pytest.mark.validation),
        pytest.param("tangent", marks=pytest.mark.validation),
        pytest.param("power", marks=pytest.mark.weekly),
    ],
)
def test_of_two_hundred_unseen_sets_95_percent_are_within_the_stated_error(law):
    fit = calibrate(NETWORK, vw.virtual_mouse(), law, search=vw.Search(starts=2))
    assert (shares_within(fit, vw.emulate(fit), 200) >= 0.95).all()


def test_it_answers_a_thousand_times_faster_than_the_model(fit, emulator):
    points = drawn(emulator, 20_000, 8)
    begin = time.process_time()
    emulator.answers(points)
    answer = (time.process_time() - begin) / len(points)
    begin = time.process_time()
    for _ in range(5):
        vw.simulate(fit.model, fit.recording)
    assert answer < 1e-3 * (time.process_time() - begin) / 5


def test_what_is_not_named_stays_as_fitted_and_outside_of_the_box_it_refuses(emulator):
    alone = emulator({"r2": [0.9, 1.0]})
    both = emulator({"r2": [0.9, 1.0], "beta": emulator.box.loc["beta", "value"]})
    assert np.array_equal(alone.to_numpy(), both.to_numpy())
    with pytest.raises(vw.errors.InputError, match=r"beta = 1000 lies outside of where this emulator was made"):
        emulator({"beta": 1000.0})
    with pytest.raises(vw.errors.InputError, match="did you mean 'beta'"):
        emulator({"bta": 60.0})
    with pytest.raises(vw.errors.InputError, match="outside"):
        emulator({"beta": np.nan})


def test_a_box_is_as_wide_as_was_asked_and_no_fit_and_no_factor_are_refused(fit):
    with pytest.raises(vw.errors.InputError, match="above 1"):
        vw.emulate(fit, factors={"beta": 0.5})
    with pytest.raises(vw.errors.InputError, match="not free"):
        vw.emulate(fit, factors={"gamma": 1.5})
    with pytest.raises(vw.errors.InputError, match="a fit is needed"):
        vw.emulate(fit.model)


def ishigami(x):
    return (np.sin(x[:, 0]) + 7 * np.sin(x[:, 1]) ** 2 + 0.1 * x[:, 2] ** 4 * np.sin(x[:, 0]))[:, np.newaxis]


def test_sobol_indices_of_ishigamis_function_are_those_of_its_formula():
    table = sobol_table(ishigami, np.tile([-np.pi, np.pi], (3, 1)), ["a", "b", "c"], ["y"])
    pi4 = 0.1 * np.pi**4
    alone, joint = (0.5 * (1 + pi4 / 5) ** 2, 49 / 8, 0.0), 8 * pi4**2 / 225
    variance = sum(alone) + joint
    first = np.array(alone) / variance
    total = first + np.array([joint, 0, joint]) / variance
    assert table["first"].to_numpy() == pytest.approx(first, abs=0.02)
    assert table["total"].to_numpy() == pytest.approx(total, abs=0.02)
    for name, truth in (("first", first), ("total", total)):
        assert (table[f"{name}_low"] - 0.005 <= truth).all()
        assert (table[f"{name}_high"] + 0.005 >= truth).all()
    with pytest.raises(vw.errors.InputError, match="power of 2"):
        sobol_table(ishigami, np.tile([-np.pi, np.pi], (3, 1)), ["a", "b", "c"], ["y"], samples=1000)


@pytest.mark.weekly
def test_sobol_indices_of_three_vessels_are_those_of_direct_runs():
    fit = calibrate(NETWORK, vw.virtual_mouse(), search=vw.Search(starts=1, fixed={"r1": 0.5}))
    emulator = vw.emulate(fit)
    bounds = np.log(emulator.box[["low", "high"]].to_numpy())
    names, numbers = [*emulator.box.index], ["mPAP", "pPAP", "power"]
    columns = [NAMES.index(name) for name in numbers]
    asked = []

    def direct(points):
        asked.append(len(points))
        blocks = np.array_split(np.exp(points), max(1, len(points) // 256))
        return np.concatenate([simulated(fit, names, block)[:, columns] for block in blocks])

    expected = sobol_table(direct, bounds, names, numbers, samples=4096, seed=5)
    assert sum(asked) >= 2**14
    table = emulator.sensitivity(seed=1).table.loc[numbers]
    for order in ("first", "total"):
        assert table[order].to_numpy() == pytest.approx(expected[order].to_numpy(), abs=0.02)


def test_in_a_small_box_the_indices_are_those_of_the_derivatives(fit):
    """In a small box the model is linear: the share of a parameter is that of its squared slope."""
    free, width = fit.parameters.loc[["beta", "r2"], "value"], {"beta": 1.1, "r2": 1.03}
    box = {name: (value / width[name], value * width[name]) for name, value in free.items()}
    found = sensitivity_of(fit, box, samples=1024)
    corners = [[box["beta"][end], free["r2"]] for end in (0, 1)] + [[free["beta"], box["r2"][end]] for end in (0, 1)]
    numbers = simulated(fit, ["beta", "r2"], corners)
    squares = np.array([numbers[1] - numbers[0], numbers[3] - numbers[2]]) ** 2
    expected = (squares / squares.sum(axis=0)).T
    assert found.table["first"].unstack()[["beta", "r2"]].loc[[*NAMES]].to_numpy() == pytest.approx(expected, abs=0.02)
    assert found.box.loc["beta", ["low", "high"]].tolist() == pytest.approx(box["beta"])
    assert (found.quantities["error"] < found.quantities["sd"]).all()


def test_a_fit_is_asked_within_its_intervals_but_for_ranges_that_are_named(fit, emulator):
    found = sensitivity_of(fit, samples=64)
    table = fit.parameters.loc[found.box.index]
    assert (found.box["low"] >= table["interval_low"] * (1 - 1e-9)).all()
    assert (found.box["high"] <= table["interval_high"] * (1 + 1e-9)).all()
    named = tuple(table.loc["r2", "value"] * np.array([0.8, 1.3]))
    box = sensitivity_of(fit, {"r2": named}, samples=64).box
    assert box.loc["beta", ["low", "high"]].tolist() == pytest.approx(found.box.loc["beta", ["low", "high"]].tolist())
    assert box.loc["r2", ["low", "high"]].tolist() == pytest.approx(named)
    with pytest.raises(vw.errors.InputError, match="outside"):
        emulator.sensitivity({"beta": (1.0, 50.0)})
    with pytest.raises(vw.errors.InputError, match="by name"):
        emulator.sensitivity(5)


@pytest.mark.parametrize(
    ("asked", "words"),
    [({"box": {"bta": (1, 2)}}, "not free"), ({"box": {5: (1, 2)}}, "not free"),
     ({"box": {"beta": (60, 50)}}, "not a range"), ({"box": {"beta": 50}}, r"\{'beta': \(40.0, 60.0\)\}"),
     ({"box": {"beta": "49"}}, "lowest and highest"), ({"box": [("beta", (40, 60))]}, "by name"),
     ({"box": 5}, "by name"), ({"box": {"beta": (40, 1e6)}}, "too far; give a range within the fit's bounds .* to "),
     ({"samples": 1000}, "power of 2"), ({"samples": 64.0}, "power of 2")],
)  # fmt: skip
def test_a_box_that_is_none_is_refused_before_anything_is_simulated(fit, asked, words):
    without_flow = replace(uncertain_model(fit), inflow=None)  # so that no simulation can be
    with pytest.raises(vw.errors.InputError, match=words):
        sensitivity_of(without_flow, **asked)
