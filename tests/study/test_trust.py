"""A study from elsewhere runs a program of its own only where its user has allowed it: this study, these bytes."""

import hashlib
import json
import os
import shutil
import subprocess
import sys
import warnings
from pathlib import Path

import pytest
from small_study import SETTINGS
from typer.testing import CliRunner

import vasowave as vw
from own_laws import EXPONENTIAL
from vasowave.base import InputError, VasowaveWarning
from vasowave.base.io import is_allowed
from vasowave.cli.app import app
from vasowave.pulse.model import find_bed, find_law
from vasowave.study.entering import check_study
from vasowave.study.running import programs_of, run_study, study_status, trust_study

NAME = "our_laws:ExponentialWall"


@pytest.fixture
def foreign(make_study, tmp_path):
    """A study whose wall law and beds are programs that leave a mark when they run; its folder and the mark."""
    settings = SETTINGS.replace("[linear]", "[linear, evil:Wall]\n  beds: evil_bed:Bed").replace(
        "starts: 2", "starts: 1"
    )
    settings = settings.replace("calibration:", "calibration:\n  fixed: {evil.k: 1.0}", 1)
    folder, mark = make_study(animals=2, settings=settings), tmp_path / "ran"
    for name in ("evil", "evil_bed"):
        (folder / f"{name}.py").write_text(
            f"import pathlib; pathlib.Path({str(mark)!r}).touch()\n{EXPONENTIAL}", "utf-8"
        )
    return folder, mark


def test_the_mark_is_left_by_a_program_that_runs(foreign, monkeypatch):
    """What the tests below rely on."""
    folder, mark = foreign
    monkeypatch.chdir(folder)
    with pytest.raises(InputError):
        find_law("evil:NoSuchLaw")
    assert mark.is_file()


def test_reading_checking_and_status_run_no_program_and_say_so(foreign):
    folder, mark = foreign
    with pytest.warns(VasowaveWarning, match=r"evil.*not run"):
        study = vw.read_study(folder)
    assert [one.state for one in study_status(study).animals] == ["waiting", "waiting"]
    found = check_study(folder)
    said = [one for one in found.problems if one.finding.code == "study.program-not-run"]
    assert {dict(one.finding.values)["file"] for one in said} == {str(folder / "evil.py"), str(folder / "evil_bed.py")}
    assert [one for one in found.problems if one.error] == []
    assert [one.animal for one in found.read] == ["mouse 0", "mouse 1"]
    with pytest.raises(InputError, match=r"evil\.py.*nobody has allowed it to run"):
        run_study(study)
    assert not mark.exists()


@pytest.mark.parametrize("command", ["status", "check", "run --no-report", "run --workers 1", "add 0.csv", "report"])
def test_no_command_runs_a_program_unasked(foreign, command, monkeypatch):
    folder, mark = foreign
    monkeypatch.chdir(folder)
    name, *more = command.split()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # which a process would print
        done = CliRunner().invoke(app, [name, str(folder), *more])
    assert done.exception is None or isinstance(done.exception, (SystemExit, InputError))
    assert not mark.exists()
    if command in ("status", "check"):
        assert "evil.py, which was not run" in " ".join(done.output.split())


@pytest.mark.parametrize("named", ["antigravity:Wall", "this.py:Wall", "idlelib.idle:Wall"])
def test_an_installed_module_that_a_study_names_is_a_program_too(make_study, named):
    module = named.partition(":")[0].removesuffix(".py")
    folder = make_study(animals=1, settings=SETTINGS.replace("[linear]", f"[linear, {named}]"))
    check_study(folder)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        study = vw.read_study(folder)
    study_status(study)
    with pytest.raises(InputError, match=r"the installed module .* nobody has allowed"):
        run_study(study)
    assert module not in sys.modules


def test_a_permission_holds_for_these_bytes_and_this_study_alone(make_study, tmp_path):
    folder = make_study(animals=1, settings=SETTINGS.replace("[linear]", f"[{NAME}]"))
    (folder / "our_laws.py").write_text(EXPONENTIAL + "# of one study\n", "utf-8")
    (program,) = programs_of(folder)
    assert trust_study(folder) == (folder / "our_laws.py",)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        vw.read_study(folder)
    copied = Path(shutil.copytree(folder, tmp_path / "elsewhere"))
    with pytest.warns(VasowaveWarning, match="not run"):
        vw.read_study(copied)
    assert is_allowed(folder, program.source)
    assert not is_allowed(folder, program.source + b"\n")
    (folder / "our_laws.py").write_text(EXPONENTIAL + "# changed\n", "utf-8")
    with pytest.warns(VasowaveWarning, match="not run"):
        vw.read_study(folder)


def test_a_permission_is_remembered_by_other_processes_and_stands_in_no_study(make_study, state_folder):
    folder = make_study(animals=1, settings=SETTINGS.replace("[linear]", f"[{NAME}]"))
    (folder / "our_laws.py").write_text(EXPONENTIAL + "# remembered\n", "utf-8")
    before = {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()}
    trust_study(folder)
    assert {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()} == before
    code = f"""if True:
        import shutil, warnings
        import vasowave as vw
        from vasowave.base.errors import VasowaveWarning
        warnings.simplefilter("error")
        vw.read_study({str(folder)!r})
        shutil.rmtree({str(state_folder / "vasowave" / "trusted")!r})
        try:
            vw.read_study({str(folder)!r})
        except VasowaveWarning as warning:
            print(warning)
    """
    said = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
    assert "our_laws.py, which was not run" in said


def test_where_nothing_can_be_remembered_a_permission_holds_for_the_process_and_says_so(
    make_study, monkeypatch, tmp_path
):
    folder = make_study(animals=1, settings=SETTINGS.replace("[linear]", f"[{NAME}]"))
    (folder / "our_laws.py").write_text(EXPONENTIAL + "# a home that is a file\n", "utf-8")
    (tmp_path / "state").write_text("")
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))
    with pytest.warns(VasowaveWarning, match="holds for this command alone"):
        trust_study(folder)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        vw.read_study(folder)


@pytest.mark.parametrize("find", [find_law, find_bed])
def test_what_results_name_is_not_run(foreign, find):
    """As `stored_model` looks for a law: by the name that stands in a file of results."""
    from vasowave.pulse.model import looking_in

    folder, mark = foreign
    before = os.getcwd()
    os.chdir(folder)
    try:
        for name in ("evil:Wall", "antigravity:Wall"):
            with looking_in(Path()), pytest.raises(InputError, match="nobody has allowed"):
                find(name)
    finally:
        os.chdir(before)
    assert not mark.exists()
    assert "antigravity" not in sys.modules


def write_results_of(folder, law):
    """Write results without animals that name a law."""
    from vasowave.study.folder import StudyFile
    from vasowave.study.results import write_results
    from vasowave.study.results.results import _digest

    (folder / "results").mkdir(parents=True)
    index = write_results(folder / "results", {}, {}, StudyFile(groups=["CTL"]))
    content = json.loads(index.read_text("utf-8"))
    content.pop("sha256")
    content["settings"]["calibration"]["walls"] = [law]
    index.write_text(json.dumps(content | {"sha256": _digest(content)}), "utf-8")


def test_results_that_name_programs_are_asked_about(make_study):
    folder = make_study(animals=1)
    write_results_of(folder, "antigravity:Wall")
    assert [one.path for one in programs_of(folder)] == ["the installed module antigravity"]


def test_the_law_of_a_fit_may_lie_where_one_stands_and_is_allowed_there(tmp_path, monkeypatch):
    from vasowave.pulse.model import looking_in

    law = tmp_path / "bench_laws.py"
    law.write_text(EXPONENTIAL + "# of a bench\n", "utf-8")
    digest = hashlib.sha256(law.read_bytes()).hexdigest()[:16]
    write_results_of(tmp_path / "fit", f"bench_laws@{digest}:ExponentialWall")
    monkeypatch.chdir(tmp_path)
    with looking_in(Path.cwd()), pytest.raises(InputError, match="nobody has allowed"):
        find_law(f"bench_laws@{digest}:ExponentialWall")
    assert trust_study("fit") == (law,)
    with looking_in(Path.cwd()):
        assert find_law(f"bench_laws@{digest}:ExponentialWall").__name__ == "ExponentialWall"


def test_the_name_of_a_law_does_not_depend_on_what_was_read_before(tmp_path, monkeypatch):
    from vasowave.pulse.model import identity

    for place in ("first", "second"):
        (tmp_path / f"{place}.py").write_text(EXPONENTIAL + "# of two names\n", "utf-8")
    monkeypatch.chdir(tmp_path)
    first, second = (find_law(f"{place}:ExponentialWall") for place in ("first", "second"))
    assert identity(first).startswith("first@")
    assert identity(second).startswith("second@")
