"""Every search of a fit is kept as it ends, a killed run goes on from there, and anyone can see how far it is."""

import json
import os
import re
import signal
import subprocess
import sys
import time

import numpy as np
import pytest
from typer.testing import CliRunner

from vasowave.cli import app
from vasowave.cli.watching import JsonLines
from vasowave.pulse.calibration import Search, SearchEnd, calibrate
from vasowave.pulse.examples import virtual_mouse
from vasowave.pulse.inference import Simulations
from vasowave.pulse.network import Network
from vasowave.study.results import LOCK, SEARCHES, Journal, locked, read_journal, read_results
from vasowave.study.running import AnimalStatus, StudyStatus, fit_status, read_study, searches_of, study_status

END = SearchEnd(np.array([0.1, -1 / 3]), 12.5, 31, True, "the step is below the tolerance", np.array([1e-17, 2.0]))


def test_an_end_comes_back_from_the_journal_to_the_last_bit(tmp_path):
    Journal(tmp_path / "a.jsonl").searches("linear", 4).keep("start", 2, END)
    found = Journal(tmp_path / "a.jsonl").searches("linear", 4).find("start", 2)
    assert np.array_equal(found.x, END.x)
    assert np.array_equal(found.residual, END.residual)
    assert (found.S, found.simulations, found.converged, found.message) == (12.5, 31, True, END.message)
    assert Journal(tmp_path / "a.jsonl").searches("tangent", 4).find("start", 2) is None


def test_a_line_that_was_cut_off_or_damaged_counts_for_nothing_and_the_next_one_counts(tmp_path):
    path = tmp_path / "a.jsonl"
    ends = Journal(path).searches("linear", 4)
    for start in range(3):
        ends.keep("start", start, END)
    text = path.read_text()
    first, second, third = text.splitlines()
    path.write_text(f"{first}\n{second.replace('12.5', '12.4')}\n{third[:-20]}")
    Journal(path).searches("linear", 4).keep("start", 3, END)
    assert [one.start for one in read_journal(path)] == [0, 3]


def test_a_journal_that_cannot_be_written_does_not_stop_the_fit(tmp_path):
    Journal(tmp_path / "nowhere" / "a.jsonl").searches("linear", 1).keep("start", 0, END)
    assert not (tmp_path / "nowhere").exists()


def test_a_fit_that_goes_on_from_a_journal_is_the_same_fit_and_makes_only_the_searches_that_are_missing(tmp_path):
    network = Network(("1", "2", "3"), [-1, 0, 0], [0.41, 0.45, 0.37], [0.047, 0.026, 0.037])
    mouse, search = virtual_mouse(), Search(starts=3)
    whole = Journal(tmp_path / "whole.jsonl")
    first = calibrate(network, mouse, search=search, ends=whole.searches("linear", 3))
    lines = (tmp_path / "whole.jsonl").read_text().splitlines(keepends=True)
    part = tmp_path / "part" / "whole.jsonl"  # a journal counts under its own name alone
    part.parent.mkdir()
    assert len(lines) >= 2
    part.write_text("".join(lines[:-1]))
    again = calibrate(network, mouse, search=search, ends=Journal(part).searches("linear", 3))
    assert np.array_equal(first.parameters["value"], again.parameters["value"])
    assert first.starts.equals(again.starts)
    assert part.read_text().splitlines(keepends=True) == lines


def test_the_simulations_of_a_posterior_are_told_as_they_are_made(tmp_path, capsys):
    journal = Journal(tmp_path / SEARCHES / "key.jsonl")
    journal.path.parent.mkdir()
    journal.searches("linear", 1).keep("start", 0, END)
    made = Simulations(lambda points: points, journal.simulations("linear"), "problem")
    made(np.arange(80.0).reshape(40, 2))
    under_way = searches_of(tmp_path, {"a": "key"})
    assert under_way == {"a": {"linear": (1, 1), "linear posterior": (40, 0)}}
    assert str(AnimalStatus("a", "begun", under_way["a"])) == "linear 1 of 1 searches, linear posterior 40 simulations"
    JsonLines().searches(under_way)
    events = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
    assert events[1] == {"event": "simulations", "animal": "a", "wall": "linear", "done": 40}
    journal.simulations("linear").write_bytes(b"PK torn")
    assert searches_of(tmp_path, {"a": "key"}) == {"a": {"linear": (1, 1)}}


def test_how_far_a_fit_of_one_animal_is_stands_in_its_folder_even_while_it_is_new(tmp_path):
    """Two journals lie there, the last of which is of two laws; a folder that holds none is of no fit."""
    assert fit_status(tmp_path) is None
    results = tmp_path / "results"
    (results / SEARCHES).mkdir(parents=True)
    assert fit_status(tmp_path) == StudyStatus((), None)
    Journal(results / SEARCHES / "a.jsonl").searches("linear", 4).keep("start", 0, END)
    last = Journal(results / SEARCHES / "b.jsonl")
    for start in range(2):
        last.searches("linear", 4).keep("start", start, END)
    last.searches("tangent", 3).keep("start", 0, END)
    (results / SEARCHES / "c.jsonl").touch()
    (one,), runner, _ = fit_status(tmp_path)
    assert runner is None
    assert (one.animal, str(one)) == ("the animal", "linear 2 of 4 searches, tangent 1 of 3 searches")
    with locked(results / LOCK):
        (one,), runner, _ = fit_status(tmp_path)
    assert one.state == "begun"
    assert str(os.getpid()) in runner


def begun(folder, least, patience=120.0):
    """Start the run of a study as a process; return it when so many searches are kept."""
    command = [sys.executable, "-m", "vasowave", "run", str(folder), "--no-report", "--workers", "1"]
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    until = time.monotonic() + patience
    while time.monotonic() < until and process.poll() is None:
        if sum(len(read_journal(path)) for path in (folder / "results" / SEARCHES).glob("*.jsonl")) >= least:
            return process
        time.sleep(0.05)
    raise AssertionError("the run did not come so far")


@pytest.mark.validation
def test_a_run_that_is_killed_after_its_third_search_keeps_three_and_ends_with_the_same_numbers(make_study):
    settings = "groups: [CTL]\ncalibration: {walls: [tangent], starts: 8}\n"
    folder = make_study("killed", 1, settings)
    (folder / "animals.csv").write_text("animal,group,network,recording\na,CTL,n.csv,recordings/0.csv\n")
    process = begun(folder, 3)
    assert study_status(read_study(folder)).runner.startswith("process")
    os.kill(process.pid, signal.SIGKILL)
    process.wait()
    (status,), runner, run = study_status(read_study(folder))
    assert (runner, run.ended) == (None, "killed")
    kept = status.searches["tangent"][0]
    assert status.state == "begun"
    assert 3 <= kept <= 8
    shown = CliRunner().invoke(app, ["status", str(folder)])
    told = re.search(r"a: tangent (\d) of 8 searches", shown.output)
    assert kept <= int(told[1]) <= 8  # a worker that outlives the run by a moment may still end its search
    told = CliRunner().invoke(app, ["run", str(folder), "--no-report", "--json", "--workers", "1"])
    events = [json.loads(line) for line in told.stdout.splitlines() if line.startswith("{")]
    assert [one["what"] for one in events if one["event"] == "animal"] == ["computed"]
    assert events[-1]["event"] == "done"
    assert not list((folder / "results" / SEARCHES).iterdir())
    resumed = read_results(folder)["a"]
    other = make_study("whole", 1, settings)
    (other / "animals.csv").write_text("animal,group,network,recording\na,CTL,n.csv,recordings/0.csv\n")
    assert CliRunner().invoke(app, ["run", str(other), "--no-report", "--workers", "1"]).exit_code == 0
    whole = read_results(other)["a"]
    assert resumed.laws["tangent"].calibration.identical(whole.laws["tangent"].calibration)
