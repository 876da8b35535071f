"""What is told of a run: how far it is, who asked it to stop, and how it ended, also of one that could not say so."""

import errno
import os
import platform
import signal
from contextlib import suppress

import pytest
from typer.testing import CliRunner

from held_run import held_run
from vasowave.base import InputError, NumericalError
from vasowave.base.io import SLOT, not_written
from vasowave.cli import app
from vasowave.study.folder import RESULTS
from vasowave.study.running import STATUS, Ended, ask_to_stop, record_end, run_status, running
from vasowave.study.running import run_state as module


@pytest.fixture
def results(tmp_path):
    return tmp_path / RESULTS


def ended_by(error, folder):
    with suppress(type(error)), running(folder, 2) as run:
        run.write(stage="computing", done=1, left=3.0)
        raise error
    return run_status(folder / RESULTS)


def test_a_run_that_goes_on_and_then_finishes_is_told_as_it_is(results):
    assert run_status(results) is None
    with running(results.parent, 4) as run:
        now = run_status(results)
        assert (now.stage, now.done, now.count, now.left, now.ended) == ("reading files", 0, 4, None, None)
        assert (now.process, now.node) == (os.getpid(), platform.node())
        run.write(stage="writing the report", done=4, left=0.5, message="4 computed")
        now = run_status(results)
        assert (str(now), now.left) == ("writing the report, 4 of 4 animals done", 0.5)
    over = run_status(results)
    assert (over.ended, over.message, over.left) == (Ended.FINISHED, "4 computed", None)
    assert str(over) == f"The last run, of {over.begun}: finished. 4 computed"


@pytest.mark.parametrize(
    ("error", "ended", "message"),
    [
        (InputError("n.csv: no such file"), Ended.FAILED, "n.csv: no such file"),
        (NumericalError("no\x1b[31m beat"), Ended.FAILED, "no?[31m beat"),
        (MemoryError(), Ended.OUT_OF_MEMORY, "What had finished is kept"),
        (KeyboardInterrupt("SIGTERM"), Ended.STOPPED, "What had finished is kept"),
        (OSError(errno.ENOSPC, "No space"), Ended.DISK_FULL, None),
    ],
)
def test_an_error_that_ends_a_run_is_told_by_its_kind(error, ended, message, tmp_path):
    found = ended_by(error, tmp_path)
    assert (found.ended, found.done, found.stage) == (ended, 1, "computing")
    assert found.stopped_by == ("SIGTERM" if ended is Ended.STOPPED else "")
    assert message is None or found.message == message


def test_an_interruption_that_python_made_another_error_of_is_one_too(tmp_path):
    error = RuntimeError("Error calling __set_name__")
    error.__cause__ = KeyboardInterrupt()
    found = ended_by(error, tmp_path)
    assert (found.ended, found.stopped_by, found.message) == (Ended.STOPPED, "Ctrl-C", "What had finished is kept")


def test_a_full_disk_is_known_behind_the_sentence_that_says_so(tmp_path):
    try:
        raise OSError(errno.ENOSPC, "No space left on device")
    except OSError as error:
        said = not_written(tmp_path / "a.nc", error)
        said.__cause__ = error
    found = ended_by(said, tmp_path)
    assert found.ended is Ended.DISK_FULL
    assert str(found).endswith("make room and run again. Make room on the disk, and run it again")


@pytest.mark.parametrize(("by", "name"), [(signal.SIGINT, "SIGINT"), (signal.SIGTERM, "SIGTERM")])
def test_a_run_begun_in_the_background_where_interrupts_are_ignored_is_stopped_by_a_signal(by, name, results):
    process = held_run(results.parent, deaf=True)
    os.kill(process.pid, by)
    process.join()
    assert (run_status(results).ended, run_status(results).stopped_by) == (Ended.STOPPED, name)


def test_a_run_begun_in_the_background_is_stopped_by_whoever_asks_it(results):
    process = held_run(results.parent, deaf=True)
    assert ask_to_stop(results, "the workbench").startswith("the run is being stopped")
    process.join()
    found = run_status(results)
    assert (found.ended, found.stopped_by, found.done) == (Ended.STOPPED, "the workbench", 1)
    assert str(found).partition(": ")[2] == (
        "stopped by the workbench while computing, 1 of 3 animals done. What had finished is kept. "
        "Run it again to go on"
    )
    assert ask_to_stop(results, "me") == "nothing runs here"


def test_a_killed_run_is_told_as_killed_and_whoever_began_it_adds_the_signal(results):
    process = held_run(results.parent)
    process.kill()
    process.join()
    found = run_status(results)
    assert (found.ended, found.done, found.stopped_by) == (Ended.KILLED, 1, "")
    assert "lack of memory" in str(found)
    record_end(results, process.pid + 1, -9)  # of another
    assert run_status(results) == found
    record_end(results, process.pid, process.exitcode)
    assert run_status(results).message == "Its process ended without a word (SIGKILL)"
    record_end(results, process.pid, 5)  # it is written, and stays
    assert "(SIGKILL)" in str(run_status(results))


def test_programs_that_the_system_killed_meanwhile_make_it_a_lack_of_memory(results, monkeypatch):
    process = held_run(results.parent)
    process.kill()
    process.join()
    before = module.kills_for_memory()
    monkeypatch.setattr(module, "kills_for_memory", lambda: before + 1)
    assert run_status(results).ended is Ended.OUT_OF_MEMORY


def test_a_run_that_does_not_stop_is_ended_at_once_when_it_is_asked_again_some_seconds_later(results, monkeypatch):
    process = held_run(results.parent)
    os.kill(process.pid, signal.SIGSTOP)  # it hears nothing
    try:
        assert "being stopped" in ask_to_stop(results, "me")
        assert "being stopped" in ask_to_stop(results, "me")  # too early
        monkeypatch.setattr(module, "_STOP_PATIENCE_S", -1.0)
        assert "ended at once" in ask_to_stop(results, "me")
    finally:
        process.kill()
    process.join()
    assert process.exitcode == -signal.SIGKILL
    assert (run_status(results).ended, run_status(results).stopped_by) == (Ended.STOPPED, "me")


@pytest.mark.parametrize("other", [{"node": "another.lab"}, {"started": "0"}])
def test_a_run_elsewhere_or_a_process_that_only_has_its_number_is_asked_and_never_ended(other, results, monkeypatch):
    monkeypatch.setattr(module, "is_heard", lambda: False)
    monkeypatch.setattr(module, "_STOP_PATIENCE_S", -1.0)
    with running(results.parent) as run:
        run.write(**other)
        assert "being stopped" in ask_to_stop(results, "me")
        with pytest.raises(InputError, match=f"does not; end process {os.getpid()} on {run.status.node}"):
            ask_to_stop(results, "me")
        assert str(run_status(results)).endswith("asked to stop by me")


def test_what_is_no_status_of_ours_is_none(results):
    with running(results.parent):
        pass
    whole = (results / STATUS).read_bytes()
    for content in (b"", whole[:-1], whole.replace(b"reading", b"READING"), b"[" * 3 * SLOT, b"\0" * 3 * SLOT):
        (results / STATUS).write_bytes(content)
        assert run_status(results) is None
    (results / STATUS).unlink()
    (results / STATUS).symlink_to("/dev/zero")
    assert run_status(results) is None
    (results / STATUS).unlink()
    os.mkfifo(results / STATUS)
    assert run_status(results) is None
    with running(results.parent):  # which puts a file in its place
        assert run_status(results).ended is None


def test_a_torn_record_leaves_the_one_before(results):
    with running(results.parent) as run:
        run.write(done=1)
        run.write(done=2)
        content = (results / STATUS).read_bytes()
        (results / STATUS).write_bytes(content.replace(b'"done": 2', b'"done": 7'))
        assert run_status(results).done == 1


def test_how_the_last_run_ended_stands_in_status(make_study):
    folder = make_study()
    ended_by(InputError("n.csv: a gap"), folder)
    said = CliRunner().invoke(app, ["status", str(folder)]).output
    assert "0 of 3 animals done; not being run\n" in said
    assert "failed while computing, 1 of 2 animals done. n.csv: a gap\n" in said
