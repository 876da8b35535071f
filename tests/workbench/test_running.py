"""A run that the workbench began: who runs the study, how it is stopped, and what is told of it."""

import errno
import json
import os
import shutil
from contextlib import suppress
from types import SimpleNamespace

import pytest

from held_run import held_run
from vasowave.base import InputError
from vasowave.study.entering import new_study
from vasowave.study.folder import RESULTS
from vasowave.study.running import ONE_BY_ONE, REPORT_FOLDER, report_study, running
from vasowave.workbench import Desk, Runs, Wishes, stored_wishes


@pytest.fixture
def desk(tmp_path):
    new_study(tmp_path / "study")
    (tmp_path / "study" / RESULTS).mkdir(exist_ok=True)
    return Desk(tmp_path / "study")


@pytest.fixture
def listed(desk):
    """The desk of a study that lists an animal, whose files are there."""
    (desk.folder / "animals.csv").write_text("animal,group,network,recording\na,CTL,n.csv,r.txt\n")
    for name in ("n.csv", "r.txt"):
        (desk.folder / name).touch()
    return desk


class Program:
    """A process as `subprocess` would show it."""

    def __init__(self, process):
        self.process, self.pid = process, process.pid

    @property
    def returncode(self):
        return self.process.exitcode

    def poll(self):
        return self.returncode


@pytest.fixture
def runs(desk):
    """The workbench after it has begun a run, of whose three animals one is done."""
    begun = Runs()
    process = held_run(desk.folder, deaf=True)
    begun.program, begun.results = Program(process), desk.results
    yield begun
    process.kill()
    process.join()


def test_a_run_goes_on_when_the_workbench_is_closed_unless_it_is_to_stop_with_it(desk, runs):
    assert runs.close()
    assert runs.progress(desk, None)["ended"] is None
    runs.stops_with_us = True
    assert not runs.close()
    runs.program.process.join()
    assert runs.progress(desk, None)["ended"] == "stopped"
    runs.stops_with_us = False
    assert not runs.close()  # it has ended
    assert not Runs().close()  # none was begun


def test_who_runs_the_study_is_named_and_stopped_and_a_second_run_is_refused(listed, runs):
    desk = listed
    assert runs.runner(desk).startswith(f"process {runs.program.pid} on ")
    with pytest.raises(InputError, match="is being run by process"):
        runs.start(desk)
    assert "is being stopped" in Runs().stop(desk)  # another workbench
    runs.program.process.join()
    assert runs.runner(desk) is None
    assert "stopped by the workbench (process" in runs.progress(desk, None)["said"]
    assert runs.stop(desk) == "nothing runs here"


def test_the_page_tells_how_far_a_run_is_and_that_it_was_killed(desk, runs):
    found = runs.progress(desk, None)
    assert (found["left"], found["ended"], found["said"]) == (7.0, None, "computing, 1 of 3 animals done")
    runs.program.process.kill()
    runs.program.process.join()
    found = runs.progress(desk, None)
    assert (found["runner"], found["left"], found["ended"]) == (None, None, "killed")
    assert "killed while computing, 1 of 3 animals done. Its process ended without a word (SIGKILL)" in found["said"]
    assert Runs().progress(desk, None) == found | {"stops_with_us": False}  # a workbench that is opened afterwards


def test_the_page_is_told_the_error_that_ended_a_run_and_what_came_out_of_one_that_finished(desk):
    assert Runs().progress(desk, None)["said"] == ""
    with suppress(InputError), running(desk.folder, 2):
        raise InputError("no beats found")
    found = Runs().progress(desk, None)
    assert (found["ended"], found["said"].endswith("no beats found")) == ("failed", True)
    with running(desk.folder, 2) as run:
        run.write(message="2 computed")
    assert Runs().progress(desk, None)["said"].endswith(": finished. 2 computed")


def test_a_run_on_another_machine_is_asked_to_stop_through_the_disk(desk, runs, monkeypatch):
    monkeypatch.setattr("platform.node", lambda: "another.lab")
    assert "is being stopped" in Runs().stop(desk)
    runs.program.process.join()
    assert "process" in Runs().progress(desk, None)["said"]


def test_a_run_that_ends_before_it_has_written_anything_is_told(desk):
    runs = Runs()
    runs.program, runs.results = Program(SimpleNamespace(pid=1, exitcode=3)), desk.results
    assert "before it read the study (exit status 3); run it" in runs.progress(desk, None)["said"]


@pytest.mark.parametrize("error", [errno.ENOSPC, errno.EROFS])
def test_a_run_that_could_write_nothing_is_not_begun_and_why_is_said(error, listed, monkeypatch):
    def fails(*rest):
        raise OSError(error, os.strerror(error))

    monkeypatch.setattr("vasowave.base.io.reserved.put", fails)
    with pytest.raises(
        InputError, match=r"run\.status: (no space left; .* make room|cannot be written: the disk is read)"
    ):
        Runs().start(listed)


@pytest.mark.parametrize(("loops", "open_loops"), [("open", True), ("refuse", False)])
def test_the_lung_desk_begins_with_what_an_extraction_was_made_with(loops, open_loops, tmp_path):
    path = tmp_path / "extraction.json"
    path.write_text(json.dumps({"settings": {"threshold": 61.5, "species": "rat", "loops": loops}}), encoding="utf-8")
    assert stored_wishes(path) == Wishes(threshold=61.5, species="rat", open_loops=open_loops)
    path.write_text(json.dumps({"settings": {"threshold": "high"}}), encoding="utf-8")
    assert stored_wishes(path) == Wishes()
    assert stored_wishes(tmp_path / "none.json") == Wishes()


def test_a_report_is_not_written_through_a_link_out_of_the_study(ran, tmp_path):
    (tmp_path / "elsewhere").mkdir()
    for name in (REPORT_FOLDER, ONE_BY_ONE):
        shutil.rmtree(ran / name, ignore_errors=True)
        (ran / name).symlink_to(tmp_path / "elsewhere")
    for animal in ("", "CTL 0"):
        with pytest.raises(InputError, match="is a link that leads out of"):
            report_study(ran, pdf=False, animal=animal)
    assert list((tmp_path / "elsewhere").iterdir()) == []
