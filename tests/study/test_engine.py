import errno
import multiprocessing
import multiprocessing.queues
import os
import signal
import subprocess
import sys
import time
from collections import Counter
from concurrent.futures import BrokenExecutor, ThreadPoolExecutor
from contextlib import nullcontext
from functools import partial
from pathlib import Path

import cheap_tasks
import grimp
import pytest

from vasowave.base import InputError
from vasowave.base.runtime import cores
from vasowave.study.results import ResultStore, locked
from vasowave.study.results.store import _NOT_NUMERICAL
from vasowave.study.running import Job, dask_cluster, engine, process_pool, run_jobs

HERE = Path(__file__).parent


def run(function, names, log, pools=None, workers=2, threads=1, keep=None, progress=None):
    """Run jobs called `names`; return what was kept and what failed."""
    kept = {}
    jobs = [Job(name, name, lambda name=name: (str(log), name)) for name in names]
    store = keep or (lambda job, result: kept.update({job.name: result}))
    pools = pools or partial(_pool, threads=threads)
    failures = run_jobs(jobs, function, store, pools, workers, threads, progress)
    return kept, failures


def _pool(count, threads):
    return process_pool(count, threads, loaded=())


def in_threads(count):
    return ThreadPoolExecutor(count)


def test_any_executor_gives_the_same_results(tmp_path):
    names = ["a", "bb", "ccc"]
    in_processes, _ = run(cheap_tasks.decay_time, names, tmp_path / "log")
    in_a_thread, _ = run(cheap_tasks.decay_time, names, tmp_path / "log2", in_threads)
    assert in_processes == in_a_thread
    assert all(value == pytest.approx(0.3, rel=0.02) for value in in_processes.values())
    assert Counter((tmp_path / "log").read_text().split()) == Counter(names)


def test_one_that_fails_is_named_with_why_and_the_others_go_on(tmp_path):
    kept, failures = run(cheap_tasks.sometimes_wrong, ["a", "wrong", "unforeseen", "b"], tmp_path / "log", in_threads)
    assert set(kept) == {"a", "b"}
    assert failures["wrong"] == "wrong.csv, line 3: a gap"
    assert "unexpected IndexError" in failures["unforeseen"]
    assert "cheap_tasks.py" in failures["unforeseen"]


def test_one_that_cannot_be_loaded_is_named_and_the_others_go_on(tmp_path):
    def broken():
        raise InputError("n.csv: no such file")

    kept = {}
    jobs = [Job("a", "a", broken), Job("b", "b", lambda: (str(tmp_path / "log"), "b"))]
    failures = run_jobs(jobs, cheap_tasks.decay_time, lambda job, x: kept.update({job.name: x}), in_threads, 2)
    assert failures == {"a": "n.csv: no such file"}
    assert set(kept) == {"b"}


def test_a_result_that_cannot_be_kept_is_a_failure_and_the_others_go_on(tmp_path):
    kept = []

    def keep(job, result):
        if job.name == "odd":
            raise AttributeError("Name contains illegal characters")
        kept.append(job.name)

    _, failures = run(cheap_tasks.decay_time, ["a", "odd", "b"], tmp_path / "log", in_threads, keep=keep)
    assert sorted(kept) == ["a", "b"]
    assert "unexpected AttributeError" in failures["odd"]


@pytest.mark.validation
def test_one_that_kills_its_process_is_found_out_and_the_others_go_on(tmp_path):
    kept, failures = run(cheap_tasks.kills_its_process, ["a", "deadly", "b", "c"], tmp_path / "log")
    assert set(kept) == {"a", "b", "c"}
    assert set(failures) == {"deadly"}
    assert "died" in failures["deadly"]


def test_one_that_runs_out_of_memory_beside_others_is_computed_alone(tmp_path):
    kept, failures = run(cheap_tasks.starved_once, ["a", "b"], tmp_path / "log", in_threads)
    assert set(kept) == {"a", "b"}
    assert not failures


def test_one_that_has_no_memory_even_alone_is_named_with_what_to_do(tmp_path):
    kept, failures = run(cheap_tasks.always_starved, ["greedy"], tmp_path / "log", in_threads)
    assert not kept
    assert "ran out of memory" in failures["greedy"]
    assert "please report" not in failures["greedy"]


def test_a_pool_whose_own_thread_dies_of_a_lack_of_memory_breaks_instead_of_waiting(monkeypatch):
    def starve(*anything, **more):
        raise RuntimeError("can't start new thread")

    with process_pool(1, loaded=()) as pool:
        monkeypatch.setattr(multiprocessing.queues.Queue, "put", starve)
        waiting = pool.submit(time.sleep, 60)
        with pytest.raises(BrokenExecutor, match="no memory left"):
            waiting.result(timeout=30)
        with pytest.raises(BrokenExecutor, match="no memory left"):
            pool.submit(time.sleep, 0).result(timeout=30)
    assert not multiprocessing.active_children()


def test_workers_share_the_cores_and_linear_algebra_takes_one(tmp_path):
    kept, _ = run(cheap_tasks.allowed_threads, ["a"], tmp_path / "log", workers=1, threads=3)
    assert kept == {"a": (3, "1")}
    assert cores() >= 1


def test_a_full_disk_where_it_is_computed_ends_the_run_with_a_clear_message(tmp_path):
    with pytest.raises(InputError, match="no space left"):
        run(cheap_tasks.no_space, ["a", "b"], tmp_path / "log", in_threads)


def test_progress_counts_every_piece_and_estimates_the_time_left(tmp_path):
    steps = []
    run(cheap_tasks.sometimes_wrong, ["a", "wrong", "b"], tmp_path / "log", in_threads, progress=steps.append)
    assert [step.done for step in steps] == [1, 2, 3]
    assert Counter(step.what for step in steps) == {"computed": 2, "failed": 1}
    assert steps[0].left >= steps[-1].left == 0


def test_a_worker_of_another_version_is_refused():
    with pytest.raises(InputError, match="another version"):
        engine.perform(int, (), 1, "another")


def alive(process: int) -> bool:
    """Whether a process runs (a zombie does not)."""
    try:
        return Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


def wait_until(true, seconds: float = 60) -> None:
    end = time.monotonic() + seconds
    while not true():
        assert time.monotonic() < end, "waited too long"
        time.sleep(0.05)


@pytest.mark.skipif(not Path("/proc").is_dir(), reason="looks at processes through /proc")
def test_workers_end_when_their_program_is_killed(tmp_path):
    log = tmp_path / "worker"
    program = (
        f"import sys; sys.path.insert(0, {str(HERE)!r})\n"
        "import cheap_tasks\nfrom vasowave.study.running.executors import process_pool\n"
        "with process_pool(1, loaded=()) as pool:\n"
        f"    pool.submit(cheap_tasks.process_and_wait, {str(log)!r}, 'a').result()\n"
    )
    with subprocess.Popen([sys.executable, "-c", program]) as parent:
        wait_until(lambda: log.exists() and log.read_text())
        worker = int(log.read_text())
        assert alive(worker)
        parent.send_signal(signal.SIGKILL)
    wait_until(lambda: not alive(worker), 10)


def test_an_interrupt_while_a_process_starts_neither_ends_it_nor_is_lost(tmp_path):
    """Ctrl-C goes to every process of a terminal: here every 20 ms, from before the first one is started."""
    program = tmp_path / "program.py"
    program.write_text(
        "import os, signal, threading\nfrom vasowave.study.running.executors import interrupts_held, process_pool\n"
        "def interrupt():\n    while not over.wait(0.02):\n        os.killpg(0, signal.SIGINT)\n"
        "if __name__ == '__main__':\n"
        "    heard, over = [], threading.Event()\n"
        "    signal.signal(signal.SIGINT, lambda *given: heard.append(given))\n"
        "    teller = threading.Thread(target=interrupt, daemon=True)\n    teller.start()\n"
        "    with process_pool(1, loaded=('decimal',)) as pool:\n"
        "        print(pool.submit(int, '7').result(), len(heard) > 0)\n"
        "    over.set()\n    teller.join()\n"
        "    signal.signal(signal.SIGINT, signal.default_int_handler)\n"
        "    try:\n        with interrupts_held():\n            os.kill(os.getpid(), signal.SIGINT)\n"
        "            print('started')\n"
        "    except KeyboardInterrupt:\n        print('heard')\n"
    )
    with subprocess.Popen([sys.executable, program], stdout=-1, stderr=-1, text=True, start_new_session=True) as done:
        said = done.communicate()
    assert said == ("7 True\nstarted\nheard\n", "")


def test_two_runs_in_one_study_are_refused_and_a_dead_one_holds_nothing(tmp_path):
    lock = tmp_path / "results" / "running.lock"
    program = (
        "import sys, time\nfrom pathlib import Path\nfrom vasowave.study.results.store import locked\n"
        f"with locked(Path({str(lock)!r})):\n    print('locked', flush=True)\n    time.sleep(60)\n"
    )
    with subprocess.Popen([sys.executable, "-c", program], stdout=subprocess.PIPE, text=True) as other:
        assert other.stdout is not None
        assert other.stdout.readline() == "locked\n"
        with pytest.raises(InputError, match=rf"being run by process {other.pid} on .* since 2"), locked(lock):
            pass
        other.kill()
        other.wait()
        with locked(lock):
            pass


def test_a_piece_is_found_by_its_key_and_a_damaged_one_is_not(tmp_path):
    store = ResultStore(tmp_path)
    path = store.keep("aa", b"key aa" + b"0123456789" * 1000)
    store.keep("ab", b"key ab, other")
    assert store.find("aa") == path
    assert store.find("a") is None
    os.truncate(path, 9999)
    assert store.find("aa") is None
    assert not path.exists()
    assert store.find("ab") is not None


def test_what_enters_no_key_is_not_needed_to_compute_an_animal():
    """By all imports, late ones too; of two rooms only the settings of a report and of comparisons are."""
    graph = grimp.build_graph("vasowave")
    computing = (
        "vasowave.study.animal.pipeline",
        "vasowave.study.results.loading",
        "vasowave.pulse.network_formats.ncsu",
    )
    upstream = [name.split(".") for one in computing for name in graph.find_upstream_modules(one)]
    needed = {"/".join(parts[1:end]) for parts in upstream for end in (2, 3)}
    assert needed > {"pulse/solver", "pulse/calibration", "pulse/inference", "catheter", "pulse/network"}
    assert needed & set(_NOT_NUMERICAL) == {"study/report", "study/cohort"}


def test_the_bytes_of_one_piece_under_the_key_of_another_are_no_piece(tmp_path):
    store = ResultStore(tmp_path)
    one = store.keep("aa", b"key aa, a result")
    other = one.rename(one.with_name(one.name.replace("aa-", "ab-")))
    assert store.find("ab") is None
    assert not other.exists()


def test_a_lock_on_a_full_disk_holds_all_the_same(tmp_path, monkeypatch):
    def full(handle, content):
        raise OSError(28, "No space left on device")

    lock = tmp_path / "running.lock"
    monkeypatch.setattr(os, "write", full)
    with locked(lock):
        monkeypatch.undo()
        with pytest.raises(InputError, match="being run by another program"), locked(lock):
            pass


def test_a_program_killed_while_it_writes_leaves_no_piece(tmp_path):
    program = (
        "import os, signal\nfrom pathlib import Path\nfrom vasowave.study.results.store import ResultStore\n"
        "os.fsync = lambda handle: os.kill(os.getpid(), signal.SIGKILL)\n"
        f"ResultStore(Path({str(tmp_path)!r})).keep('aa', b'half')\n"
    )
    assert subprocess.run([sys.executable, "-c", program], check=False).returncode == -signal.SIGKILL
    folder = tmp_path / "cache"
    assert len(list(folder.iterdir())) == 1
    assert ResultStore(tmp_path).find("aa") is None
    assert list(folder.iterdir()) == []


def test_a_scheduler_that_does_not_answer_is_named():
    with (
        pytest.raises(InputError, match=r"no Dask scheduler answers at 'tcp://127\.0\.0\.1:9'"),
        dask_cluster("tcp://127.0.0.1:9", 1),
    ):
        pass


@pytest.mark.validation
def test_a_dask_worker_killed_in_the_middle_loses_nothing_and_repeats_nothing_kept(tmp_path):
    from distributed import LocalCluster

    names = [f"animal {i}" for i in range(8)]
    store, log = ResultStore(tmp_path), tmp_path / "log"
    at_kill: dict[str, list[str]] = {}

    with LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None, silence_logs=50) as cluster:

        def keep(job, result):
            store.keep(key := job.key.replace(" ", "_"), f"{key} {result!r}".encode())
            if len(list(store.folder.iterdir())) == 3:
                wait_until(lambda: len(log.read_text().splitlines()) > 4)
                at_kill["kept"] = [path.name.partition("-")[0] for path in store.folder.iterdir()]
                process = next(iter(cluster.workers.values())).process.process.pid
                os.kill(process, signal.SIGKILL)

        with dask_cluster(cluster.scheduler_address) as executor:
            jobs = [Job(name, name, lambda name=name: (str(log), name, 0.4)) for name in names]
            failures = run_jobs(jobs, cheap_tasks.decay_time, keep, lambda count: nullcontext(executor), 100)
    assert failures == {}
    assert all(store.find(name.replace(" ", "_")) for name in names)
    runs = Counter(log.read_text().splitlines())
    assert set(runs) == set(names)
    kept = [name.replace("_", " ") for name in at_kill["kept"]]
    assert len(kept) == 3
    assert all(runs[name] == 1 for name in kept)
    assert sum(runs.values()) <= len(names) + 2  # what the killed worker was at, and a result it had not handed over


def test_a_system_without_room_for_shared_locks_is_one_sentence(monkeypatch):
    """Their semaphores are files in /dev/shm, which a container may not have and a limit of sizes may forbid."""
    monkeypatch.delenv("PYTHONSAFEPATH", raising=False)

    def none_left(*_, **__):
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr("multiprocessing.synchronize.SemLock.__init__", none_left)
    with pytest.raises(InputError, match=r"processes cannot be started.*no space left.*/dev/shm"), process_pool(1):
        pass
    assert "PYTHONSAFEPATH" not in os.environ
