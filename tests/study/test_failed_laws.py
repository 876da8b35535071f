"""A law that fails in a study, and an animal whose program ends: told by results, index, status and commands."""

import json
from concurrent.futures import ThreadPoolExecutor

import pytest
from typer.testing import CliRunner

from vasowave.base import NumericalError
from vasowave.cli.app import app
from vasowave.pulse.calibration import calibrate
from vasowave.study.animal import Failure, Stage, pipeline
from vasowave.study.results import INDEX, read_results
from vasowave.study.running import read_study, run_study, runs, study_status

TWO_LAWS = """\
calibration:
  walls: [linear, tangent]
  starts: 1
model_selection: false
numerics:
  cell_size: 0.3
report:
  pdf: false
"""


def run(folder):
    with ThreadPoolExecutor(1) as here:
        return run_study(read_study(folder), executor=here)


@pytest.fixture
def study(make_study, mice, monkeypatch):
    """Return a study of two mice: of mouse 0 the tangent law cannot be fitted, mouse 1 cannot be computed at all."""
    folder = make_study(animals=2, settings=TWO_LAWS)

    def sometimes(network, recording, wall, **more):
        if wall == "tangent":
            raise NumericalError("no start of the fit could be simulated; the first: vessel '1' collapses")
        if recording.mean_pressure == pytest.approx(mice[1].mean_pressure, rel=1e-6):
            raise SystemExit
        return calibrate(network, recording, wall, **more)

    def as_processes_do(function, arguments, threads, source):
        try:
            return performed(function, arguments, threads, source)
        except SystemExit:
            raise RuntimeError("the process of mouse 1 ended") from None

    performed = runs.run_jobs.__globals__["perform"]
    monkeypatch.setitem(runs.run_jobs.__globals__, "perform", as_processes_do)
    monkeypatch.setattr(pipeline, "calibrate", sometimes)
    return folder


def test_a_law_and_an_animal_that_failed_are_told_everywhere(study, mice):
    done = run(study)
    law = Failure("mouse 0", "CTL", "tangent", Stage.FIT, done.failures[1].reason, mice[0].mean_pressure)
    lost, other = done.failures
    assert (other.animal, other.group, other.law, other.stage) == (law.animal, law.group, law.law, law.stage)
    assert "vessel '1' collapses" in other.reason
    assert other.mean_pressure == pytest.approx(mice[0].mean_pressure, rel=1e-6)
    assert (lost.animal, lost.law, lost.stage) == ("mouse 1", "", Stage.COMPUTING)
    assert lost.mean_pressure == pytest.approx(mice[1].mean_pressure, rel=1e-6)  # measured, though it was lost
    assert done.lost == (lost,)

    results = read_results(study)
    assert results.failures == done.failures
    assert list(results["mouse 0"].laws) == ["linear"]
    index = json.loads((study / "results" / INDEX).read_text("utf-8"))
    assert [(one["animal"], one["law"], one["stage"]) for one in index["failures"]] == [
        ("mouse 1", "", "computing"),
        ("mouse 0", "tangent", "fit"),
    ]

    first, second = study_status(read_study(study)).animals
    assert (first.state, second.state) == ("done", "failed")
    assert "tangent wall, fit: no start" in str(first)
    assert "mouse 1 ended" in str(second)
    said = CliRunner().invoke(app, ["status", str(study)]).output
    assert "1 of 2 animals done; 1 failed; not being run" in said
    assert "searches" not in said

    again = run(study)
    assert again.kept == ("mouse 0",)  # with its failure, which is not tried again
    assert again.failures[1] == other


def test_the_commands_tell_what_failed_and_end_with_status_3(study, monkeypatch):
    done = run(study)
    monkeypatch.setattr(runs, "analyze_study", lambda *given, **more: done)
    told = CliRunner().invoke(app, ["run", str(study), "--json", "--no-report"])
    assert told.exit_code == 3
    last = [json.loads(line) for line in told.stdout.splitlines() if line.startswith("{")][-1]
    assert [(one["animal"], one["law"], one["stage"]) for one in last["failures"]] == [
        ("mouse 1", "", "computing"),
        ("mouse 0", "tangent", "fit"),
    ]
    (missing,) = last["missing"]
    assert (missing["group"], missing["animals"], missing["count"]) == ("CTL", ["mouse 1"], 2)
    assert missing["pressures"] == pytest.approx([done.lost[0].mean_pressure])
    assert missing["others"] == pytest.approx([done.failures[1].mean_pressure], rel=1e-3)
    plain = CliRunner().invoke(app, ["run", str(study), "--no-report"])
    assert plain.exit_code == 3
    assert "1 failed" in plain.output
    assert "failed: mouse 0: tangent wall, fit: no start" in plain.output
