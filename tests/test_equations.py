"""The equation map: every numbered equation of the paper has a function that cites it and a test of it."""

import ast
import csv
import importlib
import re
from pathlib import Path

import numpy as np
import pytest

from made_fit import made_recording
from vasowave.pulse.analysis import fourier_series, wave_intensity
from vasowave.pulse.calibration import Search, calibrate
from vasowave.pulse.cycle import Recording
from vasowave.pulse.examples import control_network
from vasowave.pulse.model import (
    Blood,
    LinearWall,
    Model,
    Numerics,
    TangentWall,
    area_compliance,
    estimate_nominal,
    windkessels,
)
from vasowave.pulse.model.walls import stiffness
from vasowave.pulse.solver import simulate

TESTS = Path(__file__).parent
EQUATIONS = 33
"""Numbered equations of the paper, appendices included."""

with (TESTS / "equation_map.csv").open(encoding="utf-8") as _file:
    MAP = {int(row["equation"]): (row["function"], row["test"]) for row in csv.DictReader(_file)}


def cited(docstring: str) -> set[int]:
    """Return the equations that a docstring names: eq. 3, eqs. 3 and 4, eqs. 25 to 27, eqs. 31, 32, 8."""
    found: set[int] = set()
    for group in re.findall(r"\beqs?\.\s*((?:\d+(?:\s*(?:,|and|to)\s*)?)+)", docstring):
        for first, last in re.findall(r"(\d+)(?:\s*to\s*(\d+))?", group):
            found |= set(range(int(first), int(last or first) + 1))
    return found


def resolve(path: str):
    """Return the object at a dotted path below vasowave."""
    parts = path.split(".")
    for cut in range(len(parts), 0, -1):
        try:
            found = importlib.import_module(".".join(["vasowave", *parts[:cut]]))
        except ModuleNotFoundError as error:
            if not str(error.name).startswith("vasowave"):
                raise
            continue
        for name in parts[cut:]:
            found = getattr(found, name) if not isinstance(found, type) else vars(found)[name]
        return found
    raise AssertionError(f"no module for {path}")


def test_every_equation_of_the_paper_is_in_the_map():
    assert sorted(MAP) == list(range(1, EQUATIONS + 1))


@pytest.mark.parametrize("number", sorted(MAP))
def test_the_equation_has_a_public_function_that_cites_it(number):
    if number == 1:
        pytest.importorskip("skimage", reason="imaging needs its extra")
    path, _ = MAP[number]
    assert not any(part.startswith("_") for part in path.split(".")), "the function is public"
    function = resolve(path)
    assert callable(
        getattr(function, "func", None) or getattr(function, "fget", None) or getattr(function, "__func__", function)
    )
    assert number in cited(function.__doc__ or ""), f"{path} does not cite eq. {number}"


@pytest.mark.parametrize("number", sorted(MAP))
def test_the_equation_has_a_test(number):
    file, name = MAP[number][1].split("::")
    tree = ast.parse((TESTS / file).read_text(encoding="utf-8"))
    functions = {node.name: node for node in tree.body if isinstance(node, ast.FunctionDef)}
    assert name in functions, f"eq. {number}: no {name} in {file}"
    assert any(isinstance(node, ast.Assert) or "assert" in ast.dump(node) for node in ast.walk(functions[name]))


def test_the_paper_has_as_many_numbered_equations(shared):
    text = "\n".join(path.read_text(encoding="utf-8") for path in (shared.parent / "paper").glob("*.txt"))
    count = len(re.findall(r"\\begin\{equation\}", text))
    for body in re.findall(r"\\begin\{eqnarray\}(.*?)\\end\{eqnarray\}", text, re.S):
        count += sum("\\nonumber" not in line and bool(line.strip()) for line in body.split("\\\\"))
    assert count == EQUATIONS


def test_the_nominal_tangent_wall_has_the_stiffness_of_equation_10():
    nominal = estimate_nominal(control_network(), made_recording())
    wall = nominal.wall(TangentWall)
    Z_c, A0, rho = nominal.characteristic_impedance, np.pi * 0.047**2, Blood().inertia
    assert wall.p1 / wall.gamma == pytest.approx((A0 * Z_c) ** 2 / (np.pi * rho), rel=1e-12)
    assert wall.gamma == 2.0


def test_s_is_the_sum_of_squares_of_equation_14(inflow):
    model = Model(control_network(), LinearWall(57.0), windkessels(control_network(), 76.0, 0.12, 0.12))
    simulated = simulate(model, inflow, Numerics(samples=64)).pressure.to_numpy()[:, 0, 0]
    measured = simulated + 0.4 * np.sin(2 * np.pi * 5 * np.arange(64) / 64)
    recording = Recording(measured, inflow.resampled(64), inflow.period)
    fit = calibrate(control_network(), recording, search=Search(starts=1, pressure_harmonics="all"))
    here = fit.simulation.sel(vessel="1", station="inlet")
    q = here["flow"].to_numpy()
    S = sum((p_n - p) ** 2 + (q_n - q) ** 2 for p_n, p, q_n, q in zip(measured, here["pressure"], recording.flow, q))
    assert pytest.approx(float(S), rel=1e-6) == fit.S


def _station():
    t = np.arange(400) / 400
    p = 15 + 6 * np.sin(2 * np.pi * t) + 2 * np.cos(6 * np.pi * t)
    q = 0.2 + 0.15 * np.sin(2 * np.pi * t + 0.4)
    return p, q, 0.1, 0.008, 230.0, Blood().inertia


def test_separated_waves_obey_equation_15():
    p, q, T, A, c, rho = _station()
    waves = wave_intensity(p, q, T, A, c, rho)
    dp, du = np.diff(p), np.diff(q / A)
    np.testing.assert_allclose(np.diff(waves.forward_pressure), 0.5 * (dp + rho * c * du), atol=1e-12)
    np.testing.assert_allclose(np.diff(waves.backward_pressure), 0.5 * (dp - rho * c * du), atol=1e-12)
    np.testing.assert_allclose(np.diff(waves.forward_velocity), 0.5 * (du + dp / (rho * c)), atol=1e-10)
    np.testing.assert_allclose(np.diff(waves.backward_velocity), 0.5 * (du - dp / (rho * c)), atol=1e-10)
    assert waves.forward_pressure[0] == p[0]
    assert waves.forward_velocity[0] == q[0] / A


def test_wave_intensity_is_the_product_of_equation_16():
    p, q, T, A, c, rho = _station()
    waves = wave_intensity(p, q, T, A, c, rho)
    step = T / len(p)
    slope = lambda x: (np.roll(x, -1) - np.roll(x, 1)) / (2 * step)  # noqa: E731
    inner = slice(1, -1)
    watt = 133.322 * 1e-2 * 1e-4  # mmHg cm/s in W/cm²: Pa · m/s per m², over 10⁴ cm²
    for pressure, velocity, intensity in (
        (waves.forward_pressure, waves.forward_velocity, waves.forward_intensity),
        (waves.backward_pressure, waves.backward_velocity, waves.backward_intensity),
    ):
        product = watt * slope(pressure) * slope(velocity)
        np.testing.assert_allclose(intensity[inner], product[inner], rtol=1e-9, atol=1e-12)


def test_the_series_of_equation_18_is_the_signal():
    t = np.arange(60) / 60
    signal = 3 + 2 * np.cos(2 * np.pi * t + 0.7) + 0.5 * np.cos(2 * np.pi * 14 * t - 1.1)
    S = fourier_series(signal, 14)
    assert abs(S[1]) == pytest.approx(2)
    assert np.angle(S[1]) == pytest.approx(0.7)
    series = sum((S[k] * np.exp(2j * np.pi * k * t)).real for k in range(15))
    np.testing.assert_allclose(series, signal, atol=1e-12)


def test_at_small_strain_the_tangent_wall_is_the_linear_one_of_equation_24():
    beta, a = float(stiffness(TangentWall(7.0, 4.0))), 1 + np.array([-1e-4, 1e-4])
    assert beta == pytest.approx(2 * np.pi * 7.0 / 4.0)
    np.testing.assert_allclose(TangentWall.pressure_at(a, 7.0, 4.0), LinearWall.pressure_at(a, beta), rtol=1e-4)


def test_compliance_at_rest_is_that_of_equation_27():
    A0, L = 0.007, 0.41
    assert L * area_compliance(LinearWall(57.0), 0.0, A0) == pytest.approx(2 * A0 * L / 57.0)
    assert L * area_compliance(TangentWall(7.0, 4.0), 0.0, A0) == pytest.approx(4.0 * A0 * L / (np.pi * 7.0))
