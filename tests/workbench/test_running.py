"""A run that the workbench began: who runs the study, how it is stopped, and what is told of it."""

import json
import signal
import subprocess
import sys
import time

import pytest

from vasowave.errors import InputError
from vasowave.study.plan import RESULTS
from vasowave.study.template import new_study
from vasowave.workbench.desk import Desk
from vasowave.workbench.lungs import Wishes, stored_wishes
from vasowave.workbench.running import _ERRORS, _LOG, Runs


@pytest.fixture
def desk(tmp_path):
    new_study(tmp_path / "study")
    (tmp_path / "study" / RESULTS).mkdir(exist_ok=True)
    return Desk(tmp_path / "study")


@pytest.fixture
def program():
    """A program that waits, and ends with status 7 when it is interrupted as by Ctrl-C."""
    waits = "import signal, sys, time\nsignal.signal(signal.SIGINT, lambda *_: sys.exit(7))\nprint(1, flush=True)\n"
    started = subprocess.Popen([sys.executable, "-c", waits + "time.sleep(60)"], stdout=subprocess.PIPE)
    started.stdout.readline()
    yield started
    started.kill()
    started.wait()
    started.stdout.close()


def begun(program):
    runs = Runs()
    runs.program = program
    return runs


def test_a_run_goes_on_when_the_workbench_is_closed_unless_it_is_to_stop_with_it(program):
    runs = begun(program)
    assert runs.close()
    assert program.poll() is None
    runs.stops_with_us = True
    assert not runs.close()
    assert program.wait(10) == 7
    runs.stops_with_us = False
    assert not runs.close()  # it has ended
    assert not Runs().close()  # none was begun


def test_who_runs_the_study_is_named_and_interrupted_and_a_second_run_is_refused(desk, program):
    runs = begun(program)
    assert runs.runner(desk).startswith(f"process {program.pid} on ")
    with pytest.raises(InputError, match="is being run by process"):
        runs.start(desk)
    runs.stop(desk)
    assert program.wait(10) == 7
    assert runs.runner(desk) is None
    runs.stop(desk)  # nothing runs: nothing to do


def test_a_run_on_another_machine_is_not_interrupted_here(desk, monkeypatch):
    monkeypatch.setattr("vasowave.workbench.running.holder", lambda path: "process 12 on another.lab since today")
    with pytest.raises(InputError, match=r"run by process 12 on another\.lab since today; stop it there"):
        Runs().stop(desk)


def test_the_last_whole_lines_that_a_run_wrote_say_how_far_it_is(desk):
    told, errors = desk.results / _LOG, desk.results / _ERRORS
    assert Runs().progress(desk, None)["error"] == ""
    lines = [{"event": "animal", "left_s": 9.0}, {"event": "animal", "left_s": 4.0}]
    told.write_text("\n".join([*map(json.dumps, lines), "[1]", '{"event": "ani']), encoding="utf-8")
    errors.write_text("noise\nError: no beats found\nfailed: mouse 2\n", encoding="utf-8")
    found = Runs().progress(desk, None)
    assert (found["runner"], found["left"], found["ended"]) == (None, None, False)
    assert found["error"] == "Error: no beats found\nfailed: mouse 2"
    told.write_text(json.dumps({"event": "done"}) + "\n", encoding="utf-8")
    found = Runs().progress(desk, None)
    assert (found["ended"], found["error"], found["animals"]) == (True, "", {})


def test_time_left_is_told_of_a_run_that_goes_on(desk, program):
    (desk.results / _LOG).write_text('{"event": "animal", "left_s": 4.0}\n', encoding="utf-8")
    (desk.results / _ERRORS).write_text("Error: of one animal\n", encoding="utf-8")
    found = begun(program).progress(desk, None)
    assert (found["left"], found["error"]) == (4.0, "")
    program.send_signal(signal.SIGINT)
    deadline = time.monotonic() + 10
    while program.poll() is None and time.monotonic() < deadline:
        time.sleep(0.01)
    assert begun(program).progress(desk, None)["error"] == "Error: of one animal"


@pytest.mark.parametrize(("loops", "open_loops"), [("open", True), ("refuse", False)])
def test_the_lung_desk_begins_with_what_an_extraction_was_made_with(loops, open_loops, tmp_path):
    path = tmp_path / "extraction.json"
    path.write_text(json.dumps({"settings": {"threshold": 61.5, "species": "rat", "loops": loops}}), encoding="utf-8")
    assert stored_wishes(path) == Wishes(threshold=61.5, species="rat", open_loops=open_loops)
    path.write_text(json.dumps({"settings": {"threshold": "high"}}), encoding="utf-8")
    assert stored_wishes(path) == Wishes()
    assert stored_wishes(tmp_path / "none.json") == Wishes()
