"""A study that has not changed is checked, and run, at once; whatever has changed is looked at again."""

import os
import shutil
import subprocess
import sys

import pytest

import vasowave as vw
from vasowave.study.running import run_status

HEAVY = ("numba", "pandas", "scipy", "xarray")
"""Libraries that only computing needs, each of which takes a second to load."""


@pytest.fixture
def study(tmp_path, monkeypatch):
    """Three averaged cycles."""
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))
    folder = tmp_path / "study"
    folder.mkdir()
    vw.write_network(
        vw.Network(("1", "2", "3"), [-1, 0, 0], [0.41, 0.45, 0.37], [0.047, 0.026, 0.037]), folder / "n.csv"
    )
    rows = ["animal,group,network,recording,synthetic"]
    for seed in range(3):
        mouse = vw.virtual_mouse(seed=seed)
        lines = (f"{t:.6f},{p:.6f},{q:.6f}" for t, p, q in zip(mouse.time, mouse.pressure, mouse.flow, strict=True))
        text = "\n".join(["time [s],pressure [mmHg],flow [ml/s]", *lines, ""])
        (folder / f"{seed}.csv").write_text(text, "utf-8")
        rows.append(f"mouse {seed},{'CTL' if seed else 'HPH'},n.csv,{seed}.csv,yes")
    (folder / "animals.csv").write_text("\n".join([*rows, ""]), "utf-8")
    settings = "calibration: {walls: [linear], starts: 1}\nmodel_selection: false\nreport: {pdf: false}\n"
    (folder / "study.yaml").write_text(settings, "utf-8")
    return folder


def said(*words):
    """Return what a command says in a process of its own, and whether it loaded any heavy library."""
    code = f"""
import sys
from vasowave.cli import run
sys.argv = ["vasowave", *{[*map(str, words)]}]
try:
    run()
finally:
    print([name for name in {HEAVY} if name in sys.modules])
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode in (0, 1), done.stderr
    *lines, loaded = done.stdout.splitlines()
    return [line for line in lines if not line.startswith(("Results", "Report"))], loaded != "[]"


def changed(file, text, other):
    """Write another text of the same length into a file, and give it back its time."""
    about, content = file.stat(), file.read_text("utf-8")
    assert text in content
    file.write_text(content.replace(text, other, 1), "utf-8")
    os.utime(file, ns=(about.st_atime_ns, about.st_mtime_ns))


@pytest.mark.validation
def test_a_study_that_has_not_changed_is_checked_without_a_library(study, monkeypatch):
    first, looked = said("check", study)
    assert looked
    assert any("Animals 3" in line for line in first)
    assert said("check", study) == (first, False)
    monkeypatch.chdir(study.parent)
    here, looked = said("check", "study")
    assert looked
    assert any(line.startswith("warning: study/animals.csv") for line in here)  # as it was typed now
    (study / "a sibling.hea").write_text("", "utf-8")
    assert said("check", study) == (first, True)
    changed(study / "n.csv", "0.047", "0.049")
    assert said("check", study)[1]
    (study / "declared.json").unlink()
    assert said("check", study)[1]
    assert (study / "declared.json").is_file()


@pytest.mark.validation
def test_an_error_or_a_program_of_the_study_is_looked_at_every_time(study):
    settings = (study / "study.yaml").read_text("utf-8")
    changed(study / "animals.csv", "1.csv", "9.csv")
    assert said("check", study)[1]
    assert said("check", study)[1]
    changed(study / "animals.csv", "9.csv", "1.csv")
    (study / "study.yaml").write_text(settings.replace("[linear]", '["my_law:Wall"]'), "utf-8")
    (study / "my_law.py").write_text("class Wall: pass\n", "utf-8")
    assert said("check", study)[1]
    assert said("check", study)[1]


@pytest.mark.validation
def test_a_run_with_nothing_to_do_says_so_at_once_and_mends_what_was_damaged(study):
    report, index = study / "report" / "report.html", study / "results" / "index.json"
    first, looked = said("run", study)
    assert looked
    assert "3 animals computed, 0 kept from earlier, 0 failed." in first
    written, page = index.stat().st_mtime_ns, report.read_text("utf-8")
    second, looked = said("run", study)
    assert not looked
    assert "0 animals computed, 3 kept from earlier, 0 failed." in second
    assert len(second) == len(first)
    assert (index.stat().st_mtime_ns, report.read_text("utf-8")) == (written, page)
    status = run_status(study / "results")
    assert (status.ended, status.done, status.count) == ("finished", 3, 3)
    assert "0 computed, 3 kept from earlier" in str(status)
    changed(report, "could be compared", "could be compiled")
    assert said("run", study) == (second, True)
    assert "could be compiled" not in report.read_text("utf-8")
    next((study / "results" / "animals").iterdir()).unlink()
    assert said("run", study) == (second, True)
    assert said("run", study) == (second, False)
    shutil.rmtree(study / "results")
    assert "3 animals computed, 0 kept from earlier, 0 failed." in said("run", study)[0]
