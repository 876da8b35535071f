"""Wall laws: ours by name, and those in files of a user's own, of which only what a study names is run."""

import os
import re
import sys
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest

from own_laws import EXPONENTIAL, printed_law
from small_tree import SMALL
from vasowave.base import InputError
from vasowave.pulse.calibration import Search, calibrate, fitted_parameters
from vasowave.pulse.cycle import Inflow, Recording
from vasowave.pulse.model import (
    LAWS,
    LinearWall,
    Model,
    Numerics,
    find_bed,
    find_law,
    in_words,
    named,
    plain,
    wave_speed,
    windkessels,
)
from vasowave.pulse.solver import simulate

NAME = "our_laws:ExponentialWall"


@pytest.fixture
def folder(tmp_path, monkeypatch):
    (tmp_path / "our_laws.py").write_text(EXPONENTIAL, "utf-8")
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_a_law_is_named_by_its_files_content_and_leaves_no_trace_on_the_path_of_imports(folder):
    (folder / "our_laws.py").write_text(f"{EXPONENTIAL}# loaded by no other test\n", "utf-8")
    path, modules = list(sys.path), set(sys.modules)
    law = find_law(NAME)
    assert law(1.0, 2.0) == (1.0, 2.0)
    assert find_law("our_laws.py:ExponentialWall") is law
    assert find_law(named(NAME)) is law
    assert sys.path == path
    assert {one for one in set(sys.modules) - modules if "law" in one} == {law.__module__}
    assert sys.modules[law.__module__].__file__ == str(folder / "our_laws.py")
    assert not (folder / "__pycache__").exists()


def test_a_changed_file_is_another_law_and_both_are_known(folder):
    first = named(NAME)
    (folder / "our_laws.py").write_text(EXPONENTIAL.replace("0.25", "0.26"), "utf-8")
    second = named(NAME)
    assert first != second
    assert plain(first) == plain(second) == NAME
    nominal = [find_law(one).law().parameters[0].nominal for one in (first, second, NAME)]
    assert nominal == [0.25, 0.26, 0.26]


def test_compiled_python_beside_a_law_is_not_run(folder):
    """Python itself would load a file of compiled code whose date and size fit, whatever the law says."""
    import py_compile

    evil = folder / "evil.py"
    evil.write_text("raise SystemExit('ran')".ljust(len(EXPONENTIAL.encode())))
    os.utime(evil, (1e9, 1e9))
    os.utime(folder / "our_laws.py", (1e9, 1e9))
    compiled = Path(py_compile.compile(str(evil), doraise=True))
    compiled.rename(compiled.with_name(compiled.name.replace("evil", "our_laws")))
    assert find_law(NAME).__name__ == "ExponentialWall"


SLIPS = {
    "a missing bracket": ("def limits(k, m): return", "def limits(k, m: return", r"line \d+: .*"),
    "a misspelled name": ("class ExponentialWall(NamedTuple)", "class ExponentialWall(Named)", "line 7: NameError"),
    "a file beside it": ("import numpy as np", "import sibling", "line 3: No module named 'sibling'; a law is one"),
    "an end": ("import numpy as np", "raise SystemExit", "line 3: SystemExit"),
    "a null byte": ("import numpy as np", "\0", "null bytes"),
    "a wrong type": ('2.0, (0.1, 40.0)', '"2", (0.1, 40.0)', "parameter 'm': its nominal value must be a number"),
    "an outlying value": ("2.0, (0.1, 40.0)", "50.0, (0.1, 40.0)", "its nominal value 50 lies outside its bounds 0.1"),
    "bounds exchanged": ("(0.1, 40.0)", "(40.0, 0.1)", "parameter 'm': .*bounds positive and ordered"),
    "another unit": ('Parameter("mmHg"', 'Parameter("kPa"', "write mmHg for a pressure"),
    "no description": ('return Law("exponential"', 'return ("exponential"', r"law\(\) must return"),
    "an unknown function": ("np.log(np.max", "np.logg(np.max", r"line 18: AttributeError.*logg"),
    "too many arguments": ("def slope_at(p, k, m)", "def slope_at(p, k, m, n)", "TypeError.*missing 1 required"),
    "one number": ("return 0.0 * k, 0.0 * k + np.inf", "return 0.0 * k", "not a wall law|limits"),
    "a missing @staticmethod": ("    @staticmethod\n    def limits", "    def limits", "@staticmethod above limits"),
    "two times @staticmethod": (
        "    @staticmethod\n    def ratio_at",
        "    @staticmethod\n    @staticmethod\n    def ratio_at",
        "@staticmethod above ratio_at, once",
    ),
    "another class": ("class ExponentialWall", "class Exponential", "our_laws.py has no 'ExponentialWall'"),
}  # fmt: skip


@pytest.mark.parametrize("slip", SLIPS)
def test_a_slip_in_a_law_is_told_with_its_file_and_line(folder, slip):
    right, wrong, said = SLIPS[slip]
    assert EXPONENTIAL.count(right) == 1
    (folder / "our_laws.py").write_text(EXPONENTIAL.replace(right, wrong), "utf-8")
    (folder / "sibling.py").write_text("raise SystemExit('a file that nobody named was run')", "utf-8")
    with pytest.raises(InputError, match=said) as caught:
        find_law(NAME)
    if "line" in said or "null" in said:
        assert str(folder / "our_laws.py") in str(caught.value)


def test_an_error_while_a_law_is_used_is_told_with_its_line_and_others_stay_what_they_are(folder):
    (folder / "our_laws.py").write_text(
        EXPONENTIAL.replace("return 1 + np.log", "assert np.all(np.less(p, 1e6))\n        return 1 + np.log").replace(
            "def ratio_at(p, k, m): ", "def ratio_at(p, k, m):\n        "
        ),
        "utf-8",
    )
    law = find_law(NAME)
    with pytest.raises(InputError, match=r"our_laws\.py, line 19: AssertionError; correct the law"), in_words():
        law.ratio_at(2e6, 1.0, 2.0)
    with pytest.raises(ZeroDivisionError), in_words():
        raise ZeroDivisionError


@pytest.mark.validation  # a law of its own is compiled anew
def test_what_the_compiler_cannot_translate_is_told_with_its_line(folder):
    from vasowave.pulse.solver import compile_kernels

    (folder / "our_laws.py").write_text(
        EXPONENTIAL.replace("np.log(np.max", "np.log(np.asarray(eval('p')) * 0 + np.max"), "utf-8"
    )
    with pytest.raises(InputError, match=r"our_laws\.py, line \d+: the compiler of the solver cannot translate it"):
        compile_kernels(NAME)


@pytest.mark.validation  # a law of its own is compiled anew
def test_a_law_in_a_file_of_ones_own_is_simulated_and_its_parameters_come_back(folder):
    (folder / "our_laws.py").write_text(printed_law(), "utf-8")
    law, network = find_law(NAME), SMALL
    assert find_law(law) is law
    phase = np.arange(64) / 64
    flow = np.exp(-0.5 * ((phase - 0.3) / 0.09) ** 2)
    inflow = Inflow(0.17 * flow / flow.mean(), 0.11)
    model = Model(network, law(14.0, 2.5), windkessels(network, 76.0, 0.12, 0.2))
    pressure = simulate(model, inflow, Numerics(samples=64, tolerance=1e-8)).pressure.values[:, network.root, 0]
    recording = Recording(pressure, inflow.flow, 0.11)
    fit = calibrate(network, recording, NAME, search=Search(starts=1))
    assert fit.wall == "exponential"
    assert fit.S < 1e-6 * 64
    speed = wave_speed(law(*fit.parameters["value"][["exponential.k", "exponential.m"]]), 15.0, model.blood.inertia)
    assert speed == pytest.approx(wave_speed(law(14.0, 2.5), 15.0, model.blood.inertia), rel=1e-3)
    assert fit.total_resistance == pytest.approx(76.0, rel=1e-3)


def test_a_package_offers_a_wall_law_by_the_entry_point_that_the_page_names(tmp_path, monkeypatch):
    page = (Path(__file__).parents[3] / "docs" / "walls.md").read_text("utf-8")
    (group,) = re.findall(r"entry point of the group `([a-z.]+)`", page)
    (tmp_path / "offered_laws.py").write_text(EXPONENTIAL, "utf-8")
    installed = tmp_path / "offered_laws-1.0.dist-info"
    installed.mkdir()
    (installed / "METADATA").write_text("Metadata-Version: 2.1\nName: offered-laws\nVersion: 1.0\n", "utf-8")
    (installed / "entry_points.txt").write_text(f"[{group}]\noffered = offered_laws:ExponentialWall\n", "utf-8")
    monkeypatch.syspath_prepend(tmp_path)
    assert find_law("offered").law().name == "exponential"
    with pytest.raises(InputError, match=r"choose from: .*offered"):
        find_law("nowhere offered")


def test_an_unknown_law_is_refused_with_the_nearest_known_one():
    with pytest.raises(InputError, match=r"unknown wall law 'liner' \(did you mean 'linear'\?\).*module:Class"):
        find_law("liner")
    with pytest.raises(InputError, match="no_such_module_of_mine"):
        find_law("no_such_module_of_mine:Wall")
    with pytest.raises(InputError, match="has no 'NoWall'"):
        find_law("vasowave.pulse.model.walls:NoWall")


@pytest.mark.parametrize("name", ["", "foo:", ":Foo", ":", "linear,vein"])
def test_a_name_that_is_none_is_answered_with_those_there_are(name):
    with pytest.raises(InputError, match=f"unknown wall law '{name}'.*choose from: linear, tangent, power, vein"):
        find_law(name)
    with pytest.raises(InputError, match=f"unknown beds '{name}'.*choose from: windkessel"):
        find_bed(name)


def test_a_law_whose_equations_contradict_each_other_is_refused():
    class Wrong(NamedTuple):
        beta: float
        law = staticmethod(lambda: LinearWall.law()._replace(name="wrong"))
        pressure_at = LinearWall.pressure_at
        ratio_at = LinearWall.ratio_at
        slope_at = staticmethod(lambda p, beta: 2.0 / beta * (1.0 + 2.0 * p / beta))
        limits = LinearWall.limits

    with pytest.raises(InputError, match=r"slope_at.*derivative of ratio_at does not hold"):
        find_law(Wrong)
    with pytest.raises(InputError, match=r"is not a wall law.*pressure_at"):
        find_law(dict)


@pytest.mark.parametrize("name", LAWS)
def test_the_nominal_values_of_our_laws_lie_within_their_bounds(name):
    assert list(fitted_parameters(name))[-3:] == ["r1", "r2", "c1"]
    for parameter in LAWS[name].law().parameters:
        low, high = parameter.bounds
        assert low < parameter.nominal < high
