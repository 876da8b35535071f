"""The package as others get it: wheel, conda recipe, container, and what stands on the index's page."""

import hashlib
import json
import os
import re
import shutil
import subprocess
import tomllib
from importlib.metadata import version
from pathlib import Path

import numpy as np
import pytest
import yaml

import parts
import vasowave as vw
from programs_by_others import environment_with

ROOT = Path(__file__).parents[1]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
CONDA_NAMES = {"matplotlib": "matplotlib-base"}
"""Packages that conda-forge calls differently."""


def test_the_page_for_the_index_has_no_link_that_ends_there():
    page = (ROOT / PROJECT["readme"]).read_text(encoding="utf-8")
    assert re.findall(r"\]\((?!https?:)[^)]*\)", page) == []
    assert "uv run" not in page  # which needs the source


def test_every_command_of_the_command_line_stands_in_the_docs():
    from typer.main import get_command

    from vasowave.cli import app

    page = (ROOT / "docs" / "commands.md").read_text(encoding="utf-8")
    told = set(re.findall(r"^\| `vasowave ([\w-]+)`", page, re.MULTILINE))
    assert told == set(get_command(app).commands)


def test_every_public_name_stands_in_the_reference():
    page = (ROOT / "docs" / "api.md").read_text(encoding="utf-8")
    assert set(
        re.findall(
            r"^\.\. auto(?:class|function|module):: vasowave\.(?:pulse\.model\.|base\.)?(\w+)$", page, re.MULTILINE
        )
    ) == set(vw.__all__)


def test_the_conda_recipe_asks_for_what_the_project_asks_for():
    text = (ROOT / "recipe" / "recipe.yaml").read_text(encoding="utf-8")
    recipe = yaml.safe_load(text)
    assert recipe["context"]["version"] == PROJECT["version"]
    asked = {re.sub(r"(?=[<>=])", " ", one, count=1) for one in PROJECT["dependencies"]}
    conda = {" ".join([CONDA_NAMES.get(one.split()[0], one.split()[0]), *one.split()[1:]]) for one in asked}
    assert set(recipe["requirements"]["run"]) == conda | {f"python {PROJECT['requires-python']}"}
    assert recipe["about"]["license"] == PROJECT["license"]


def test_wheel_recipe_and_container_start_the_same_function():
    recipe = yaml.safe_load((ROOT / "recipe" / "recipe.yaml").read_text(encoding="utf-8"))
    started = [f"{name} = {function}" for name, function in PROJECT["scripts"].items()]
    assert started == ["vasowave = vasowave.__main__:main"]  # whose file alone takes the current folder off the path
    assert recipe["build"]["python"]["entry_points"] == started
    lines = (ROOT / "Containerfile").read_text(encoding="utf-8").splitlines()
    assert [line for line in lines if line.startswith("ENTRYPOINT")] == [
        'ENTRYPOINT ["vasowave"]'
    ]  # the wheel's script


def test_the_citation_is_of_this_project_and_version():
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    assert {"cff-version", "message", "title", "authors", "version", "license"} <= set(citation)
    assert (citation["title"], citation["version"]) == (PROJECT["name"], PROJECT["version"])
    assert citation["license"] == PROJECT["license"]


def test_the_container_copies_only_what_exists():
    lines = (ROOT / "Containerfile").read_text(encoding="utf-8").splitlines()
    copied = [word for line in lines if line.startswith("COPY") for word in line.split()[1:-1]]
    assert {"src", PROJECT["readme"]} <= set(copied)
    assert all((ROOT / name).exists() for name in copied)


@pytest.mark.validation
def test_the_wheel_stands_alone(tmp_path):
    uv = shutil.which("uv")
    if uv is None:
        pytest.skip("uv, which builds the wheel, is not on the path")
    subprocess.run([uv, "build", "--quiet", "--wheel", "--out-dir", str(tmp_path), str(ROOT)], check=True)
    (wheel,) = tmp_path.glob("*.whl")
    python = environment_with(tmp_path, str(wheel))
    vw.write_network(vw.Network(("a", "b", "c"), [-1, 0, 0], [0.4, 0.4, 0.3], [0.05, 0.03, 0.04]), tmp_path / "n.csv")
    mouse = vw.virtual_mouse()
    columns = np.column_stack([mouse.time, mouse.pressure, mouse.flow])
    np.savetxt(tmp_path / "c.csv", columns, delimiter=",", header="time [s],pressure [mmHg],flow [ml/s]", comments="")
    command = python.parent / "vasowave"
    told = subprocess.run([command, "--version"], capture_output=True, text=True, check=True, cwd=tmp_path).stdout
    assert told.strip() == f"vasowave {PROJECT['version']}"
    fit = [command, "fit", "n.csv", "c.csv", "--walls", "linear", "--starts", "1", "-o", "mouse"]
    done = subprocess.run(fit, capture_output=True, text=True, check=False, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "mouse" / "report" / "report.html").stat().st_size > 10_000
    where = subprocess.run([python, "-c", "import vasowave; print(vasowave.__file__)"], capture_output=True, text=True,
                           check=True, cwd=tmp_path).stdout  # fmt: skip
    assert str(tmp_path) in where


@pytest.fixture(scope="module")
def shipped(tmp_path_factory):
    """Everything that is shipped, by its file's name; where kernels can be compiled, a wheel holds them."""
    if shutil.which("uv") is None:
        pytest.skip("uv, which builds the wheels, is not on the path")
    return {path.name: path for path in parts.build(tmp_path_factory.mktemp("shipped"))}


@pytest.mark.validation
def test_what_is_shipped_is_listed_with_versions_and_hashes(shipped):
    sums = dict(reversed(line.split()) for line in shipped["SHA256SUMS"].read_text("utf-8").splitlines())
    assert set(sums) == set(shipped) - {"SHA256SUMS"}
    assert sum(name.endswith(("-none-any.whl", ".tar.gz", ".json")) for name in sums) == 3
    assert all(hashlib.sha256(shipped[name].read_bytes()).hexdigest() == found for name, found in sums.items())
    components = json.loads(shipped["parts.cdx.json"].read_text("utf-8"))["components"]
    listed = {(part["name"], part["version"]): part["hashes"] for part in components}
    needed = {re.split(r"[<>=\[ ]", one)[0] for one in PROJECT["dependencies"]}
    assert needed
    assert all(listed[name, version(name)] for name in needed)  # what these tests run with


@pytest.mark.validation
def test_in_an_empty_home_the_demo_from_a_wheel_with_kernels_compiles_nothing(shipped, tmp_path):
    wheels = [path for name, path in shipped.items() if name.endswith("x86_64.whl")]
    if not wheels:
        pytest.skip("wheels hold kernels on Linux on x86-64 alone")
    if not {"avx2", "bmi2", "fma"} <= set(Path("/proc/cpuinfo").read_text("utf-8").split()):
        pytest.skip("this processor is older than those that the kernels are for")
    beside = [f"{name}=={version(name)}" for name in ("numba", "llvmlite", "numpy")]
    python = environment_with(tmp_path, str(wheels[0]), *beside)
    home = tmp_path / "home"
    home.mkdir()
    variables = os.environ | {"HOME": str(home), "XDG_CACHE_HOME": str(home / "cache")}
    for name in ("NUMBA_CACHE_DIR", "NUMBA_CPU_NAME", "NUMBA_CPU_FEATURES", "PYTHONPATH"):
        variables.pop(name, None)
    demo = [python.parent / "vasowave", "demo", "-o", tmp_path / "study", "--starts", "1"]
    done = subprocess.run(demo, env=variables, capture_output=True, text=True, check=False, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "study" / "report" / "report.html").is_file()
    assert list(home.rglob("*.kernel")) == []


@pytest.mark.validation
def test_the_container_builds_and_answers(tmp_path):
    tool = shutil.which("podman") or shutil.which("docker")
    if tool is None:
        pytest.skip("neither podman nor docker is installed here")
    if subprocess.run([tool, "info"], capture_output=True, check=False).returncode:
        pytest.skip(f"{Path(tool).name} is installed here, but its engine does not run")
    subprocess.run([tool, "build", "-q", "-f", "Containerfile", "-t", "vasowave-test", "."], cwd=ROOT, check=True)
    told = subprocess.run(
        [tool, "run", "--rm", "vasowave-test", "--version"], capture_output=True, text=True, check=True
    )
    assert told.stdout.strip() == f"vasowave {PROJECT['version']}"
