"""Which programs a study runs: the laws that it names, and nothing that lies beside it."""

import json
import subprocess
import sys
import warnings
from pathlib import Path

import pytest
from small_study import SETTINGS

from own_laws import EXPONENTIAL
from vasowave.pulse.model import plain
from vasowave.study.entering import check_study
from vasowave.study.results import read_results
from vasowave.study.running import read_study, run_study, trust_study

NAME = "our_laws:ExponentialWall"
OPTIONAL = ("dask", "pyarrow", "bottleneck", "numexpr", "coverage", "typst", "statsmodels", "cupy", "sparse", "pint")
"""Modules that libraries look for when they are loaded or first used."""


@pytest.fixture
def study(make_study):
    folder = make_study(animals=2, settings=SETTINGS.replace("[linear]", f"[{NAME}]").replace("starts: 2", "starts: 1"))
    (folder / "our_laws.py").write_text(EXPONENTIAL, "utf-8")
    trust_study(folder)
    return folder


def test_check_says_which_program_a_study_runs(study, monkeypatch):
    monkeypatch.chdir(study.parent)
    said = [str(problem) for problem in check_study(study).problems]
    assert [one for one in said if f"runs the program {study / 'our_laws.py'}" in one]


def test_a_law_that_cannot_be_run_is_an_error_of_the_study_file(study):
    (study / "our_laws.py").write_text("1 / 0", "utf-8")
    trust_study(study)
    said = [str(problem) for problem in check_study(study).problems]
    assert any("study.yaml, line" in one and "our_laws.py, line 1: ZeroDivisionError" in one for one in said)


def test_a_law_stands_in_the_key_of_an_animal_by_its_content(study):
    from vasowave.study.results import animal_key

    def keys():
        plan = read_study(study)
        return [animal_key(row, plan.settings, plan.folder) for row in plan.animals]

    before = keys()
    assert keys() == before
    (study / "our_laws.py").write_text(EXPONENTIAL + "# changed\n", "utf-8")
    trust_study(study)
    assert not set(keys()) & set(before)


@pytest.mark.validation  # a law of its own is compiled anew in both workers
def test_workers_run_the_law_that_the_study_names_and_its_results_are_read_without_it(study, monkeypatch, tmp_path):
    (tmp_path / "our_laws.py").write_text("raise SystemExit('a law of the folder one is in was run')", "utf-8")
    monkeypatch.chdir(tmp_path)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        done = run_study(read_study(study), workers=2)
    assert done.failures == ()
    (study / "our_laws.py").unlink()
    code = f"""if True:
        import sys
        import vasowave as vw
        results = vw.read_results({str(study)!r})
        print(float(results["mouse 0"].laws["exponential"].calibration["RMSE"]))
        print([one for one in sys.modules if "_law_" in one])
    """
    said = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.split("\n")
    assert float(said[0]) < 1.0  # mmHg
    assert said[1] == "[]"


@pytest.mark.parametrize("named", ["evil:Wall", "evil.py:Wall", "evil@0123456789abcdef:Wall"])
def test_results_from_elsewhere_run_nothing(study, monkeypatch, named):
    from vasowave.study.folder import StudyFile
    from vasowave.study.results import write_results
    from vasowave.study.results.results import _digest

    (study / "evil.py").write_text("raise SystemExit('ran')", "utf-8")
    (study / "study.yaml").write_text("groups: [CTL]\n", "utf-8")
    (study / "results").mkdir()
    index = write_results(study / "results", {}, {}, StudyFile(groups=["CTL"]))
    content = json.loads(index.read_text("utf-8"))
    content.pop("sha256")
    content["settings"]["calibration"]["walls"] = [named]
    index.write_text(json.dumps(content | {"sha256": _digest(content)}), "utf-8")
    monkeypatch.chdir(study)
    assert {plain(one) for one in read_results(study).settings.calibration.walls} == {"evil:Wall"}


@pytest.fixture
def planted(make_study):
    """A study beside whose files lie modules, each of which leaves a mark when it is run."""
    folder = make_study(animals=1, settings=SETTINGS.replace("starts: 2", "starts: 1"))
    mark = f"open({str(folder / 'ran')!r}, 'a').write(__name__ + chr(10))"
    standard = ("ast", "pathlib", "typing", "struct", "socket", "selectors", "csv", "json", "typer", "numpy")
    for name in (*OPTIONAL, *standard, "our_laws", "sitecustomize", "usercustomize"):
        (folder / f"{name}.py").write_text(mark, "utf-8")
    return folder


@pytest.mark.parametrize(
    ("program", "command"),
    [
        pytest.param("-m vasowave", "run . --no-report --workers 1", marks=pytest.mark.validation),
        ("vasowave", "check"),
    ],  # -m alone looks into the folder one is in
)
def test_no_module_that_lies_in_the_studys_folder_is_run(planted, program, command):
    start = [sys.executable, "-m", "vasowave"] if program[0] == "-" else [Path(sys.executable).with_name("vasowave")]
    done = subprocess.run([*start, *command.split()], cwd=planted, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    assert not (planted / "ran").exists(), (planted / "ran").read_text("utf-8")


def test_modules_that_are_planted_would_leave_their_mark(planted):
    """What the test above relies on: Python itself runs them."""
    subprocess.run([sys.executable, "-c", "import dask"], cwd=planted, check=True)
    assert (planted / "ran").read_text("utf-8") == "dask\n"


@pytest.mark.parametrize(
    ("file", "text", "what"),
    [(".numba_config.yaml", "disable_jit: 1", "how the solver is compiled"),
     ("matplotlibrc", "text.usetex: True", "how figures are drawn, and by what")],
)  # fmt: skip
def test_a_file_that_would_steer_compiler_or_figures_ends_the_program_in_words(planted, file, text, what):
    (planted / file).write_text(text, "utf-8")
    command = [sys.executable, "-m", "vasowave", "check"]
    done = subprocess.run(command, cwd=planted, capture_output=True, text=True, check=False)
    assert done.returncode == 1
    assert f"{file}: would change {what}" in done.stderr
