"""What happens to the files of a study while it runs, or stands where they should be."""

import os
from concurrent.futures import Executor, Future
from contextlib import contextmanager

import cheap_tasks
import pytest

from vasowave.base import InputError
from vasowave.study.folder import StudyFile
from vasowave.study.results import ResultStore, write_results
from vasowave.study.running import Job, run_jobs


class Vanishing(Executor):
    """What is left of a cluster whose scheduler was killed: its client cancels what it was asked for."""

    def submit(self, function, /, *arguments, **named):
        future: Future = Future()
        future.cancel()
        future.set_running_or_notify_cancel()
        return future


def test_a_scheduler_that_is_killed_ends_the_run_as_one_that_does_not_answer(tmp_path):
    opened = []

    @contextmanager
    def cluster(count):
        opened.append(count)
        if len(opened) > 1:
            raise InputError("no Dask scheduler answers at 'tcp://host:8786'")
        yield Vanishing()

    jobs = [Job(name, name, lambda name=name: (str(tmp_path / "log"), name)) for name in "ab"]
    with pytest.raises(InputError, match="no Dask scheduler answers"):
        run_jobs(jobs, cheap_tasks.decay_time, lambda job, result: None, cluster, 2)


def test_work_that_is_cancelled_again_and_again_is_a_failure_of_its_animal(tmp_path):
    @contextmanager
    def cluster(count):
        yield Vanishing()

    jobs = [Job("a", "a", lambda: (str(tmp_path / "log"), "a"))]
    failures = run_jobs(jobs, cheap_tasks.decay_time, lambda job, result: None, cluster, 1)
    assert "died" in failures["a"]


@pytest.fixture
def store(tmp_path):
    return ResultStore(tmp_path)


def test_a_folder_in_place_of_a_piece_is_named(store):
    (store.folder / "aa-00.nc").mkdir()
    with pytest.raises(InputError, match=r"aa-00\.nc: a folder where a finished piece should be"):
        store.find("aa")


def test_a_loop_of_links_or_a_pipe_in_place_of_a_piece_is_no_piece_and_goes(store):
    (store.folder / "aa-00.nc").symlink_to("aa-00.nc")
    os.mkfifo(store.folder / "aa-01.nc")
    assert store.find("aa") is None
    assert list(store.folder.iterdir()) == []


def test_results_that_are_removed_while_a_study_runs_are_missed_in_words(store):
    piece = store.keep("aa", b"content")
    piece.unlink()
    with pytest.raises(InputError, match="was removed while the study ran; run again"):
        write_results(store.folder, {("CTL 1", "CTL"): piece}, {}, StudyFile(groups=["CTL"]))
    store.folder.joinpath("animals").rmdir()
    store.folder.rmdir()
    with pytest.raises(InputError, match="was removed while the study ran; run again"):
        store.keep("bb", b"content")
