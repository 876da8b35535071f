"""What `import vasowave` offers: names, types, examples, representations."""

import doctest
import inspect
import subprocess
import sys
import warnings

import numpy as np
import pytest

import vasowave
from made_fit import made_fit
from vasowave.catheter import synthetic_raw_recording

EXPLAINED = [name for name in vasowave.__all__ if not inspect.ismodule(getattr(vasowave, name))]
LONG = ("plan", "write_report", "Posterior")  # examples of ten seconds, of what other tests run too
SCRIPT = """
import vasowave as vw

network: vw.Network = vw.read_network("network.csv")
recording = vw.read_recording("pressure.dat", "flow.dat", period=0.11)
fit = vw.calibrate(network, recording, "linear", search=vw.Search(starts=2))
error: float = fit.rmse
waves = vw.simulate(fit.model, recording)
print(fit, error, waves, vw.__version__)
"""


@pytest.mark.parametrize("name", vasowave.__all__)
def test_every_public_name_exists_and_is_documented(name):
    assert getattr(vasowave, name).__doc__


@pytest.mark.parametrize(
    "name", [pytest.param(one, marks=pytest.mark.validation) if one in LONG else one for one in EXPLAINED]
)
def test_every_public_name_has_an_example_that_works(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    found = doctest.DocTestFinder(recurse=False).find(getattr(vasowave, name), name)
    assert sum(len(one.examples) for one in found), f"{name} has no example"
    runner = doctest.DocTestRunner(optionflags=doctest.ELLIPSIS)
    said: list[str] = []
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", vasowave.base.errors.VasowaveWarning)
        for one in found:
            runner.run(one, out=said.append)
    assert not runner.failures, "".join(said)


def test_an_unknown_name_is_an_attribute_error_that_offers_the_nearest_or_says_where_all_stand():
    with pytest.raises(AttributeError, match="calibrate"):
        _ = vasowave.calibrat
    with pytest.raises(AttributeError, match=r"dir\(vasowave\)"):
        _ = vasowave.zzz


def test_importing_the_package_loads_nothing_heavy():
    code = "import sys, vasowave; print(sorted({'numpy', 'numba', 'pandas', 'matplotlib'} & set(sys.modules)))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def strict_mypy(script, folder):
    path = folder / "script.py"
    path.write_text(script)
    command = [sys.executable, "-m", "mypy", "--strict", "--config-file=", "--cache-dir", str(folder), str(path)]
    return subprocess.run(command, capture_output=True, text=True, check=False)


@pytest.mark.validation
def test_strict_mypy_sees_real_types_in_a_users_script_and_finds_what_is_wrong(tmp_path):
    pytest.importorskip("mypy")
    right = strict_mypy(SCRIPT, tmp_path)
    assert right.returncode == 0, right.stdout
    wrong = strict_mypy('import vasowave as vw\nvw.calibrate(1, "nonsense", wall=3)\n', tmp_path)
    for word in ('"int"; expected "Network"', '"str"; expected "Recording', '"wall"'):
        assert word in wrong.stdout


NETWORK, MOUSE = vasowave.Network(("<b>root</b>", "left"), [-1, 0], [0.4, 0.4], [0.05, 0.03]), vasowave.virtual_mouse()
BEDS = vasowave.estimate_nominal(NETWORK, MOUSE).outlets


@pytest.mark.parametrize(
    ("value", "words"),
    [
        (NETWORK, "&lt;b&gt;root&lt;/b&gt;"),  # escaped, as every text
        (made_fit("linear"), "β"),
        (MOUSE, f"{MOUSE.pressure.mean():.1f} mmHg"),
        (synthetic_raw_recording(MOUSE, np.random.default_rng(1), duration=6.0).raw, "6 s at"),
        (vasowave.Model(NETWORK, vasowave.LinearWall(np.array([60.0, 90.0])), BEDS), "60 to 90"),
    ],
    ids=lambda one: type(one).__name__,
)
def test_values_show_themselves_in_a_notebook(value, words):
    assert words in value._repr_html_()
