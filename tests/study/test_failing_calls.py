"""Whichever call to the system fails: a sentence, files that are whole or unchanged, and the same result afterwards."""

import json
import shutil
import subprocess
import sys
import warnings
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest
from small_study import SETTINGS, make_study_in, write_cycle

import failing_calls
import vasowave as vw
from failing_calls import JOBS, KINDS, contents, failing, wrong
from phantom import embed, render
from vasowave.lung.read import write_volume
from vasowave.pulse.examples import virtual_mouse
from vasowave.pulse.network import Network

pytest.importorskip("vasowave.workbench", reason="a study alone has no workbench")
ABOVE = ("workbench",)
pytestmark = pytest.mark.skipif(not Path("/proc/self/fd").is_dir(), reason="this system does not name open files")
STEPS = {"run": 1, "report": 40, "add": 1, "open": 1, "extract": 40}
"""Every so many calls are tried in the validation; what lies between writes one more file in the same way."""


def before(job, place, mice):
    """Write what a job finds: a study of an animal, and beside it what is added."""
    if job == "extract":
        (place / "before").mkdir()
        small = Network(("1", "2", "3"), [-1, 0, 0], [0.35, 0.4, 0.3], [0.052, 0.042, 0.032])
        placed = embed(small, np.random.default_rng(5))
        write_volume(render(placed, 110, 0.0105, np.random.default_rng(5)), place / "before" / "image.nrrd")
        return place / "before"
    folder = make_study_in(place / "before", mice[:1], SETTINGS.replace("starts: 2", "starts: 1"))
    (place / "new" / "CTL").mkdir(parents=True)
    write_cycle(place / "new" / "CTL" / "rat 1.csv", virtual_mouse(seed=1))
    if job == "report":
        with warnings.catch_warnings(), ThreadPoolExecutor(1) as here:
            warnings.simplefilter("ignore")
            vw.run_study(vw.read_study(folder), executor=here)
    return folder


@pytest.fixture
def quiet(monkeypatch):
    """Put back what a command sets for its whole process."""
    for name in ("argv", "unraisablehook"):
        monkeypatch.setattr(sys, name, getattr(sys, name))
    monkeypatch.setattr("vasowave.base.runtime.thread_limits.spare_threads", lambda: None)
    with warnings.catch_warnings():
        yield


@pytest.mark.parametrize(("job", "calls"), [("add", (2, 9, 15, 17, 20)), ("open", (4, 11, 14, 16, 43))])
def test_a_call_that_fails_ends_in_a_sentence_and_whole_files(job, calls, tmp_path, mice, quiet, capsys):
    folder, study, ended = before(job, tmp_path, mice), tmp_path / "study", []
    kinds = [code for code in KINDS.values() if code]
    for call, code in zip(calls, (*kinds, kinds[0]), strict=True):
        shutil.rmtree(study, ignore_errors=True)
        shutil.copytree(folder, study)
        with failing(study, call, code) as here:
            status = JOBS[job](study)
        assert here.what, "fewer calls were made"
        ended.append((status, "".join(capsys.readouterr()), contents(study)))
    assert JOBS[job](study) == 0
    sound = contents(study)
    assert [wrong(*one, contents(folder), sound) for one in ended] == [[]] * len(calls)
    assert 1 in {status for status, *_ in ended}


@pytest.mark.parametrize(
    "job",
    [
        pytest.param(job, marks=pytest.mark.weekly if job in ("extract", "run") else pytest.mark.validation)
        for job in JOBS
    ],
)
def test_whichever_call_fails_or_is_the_last_the_job_goes_on_to_the_same_result(job, tmp_path, mice):
    before(job, tmp_path, mice)
    program = [sys.executable, failing_calls.__file__, job, str(tmp_path), str(STEPS[job])]
    done = subprocess.run(program, check=False, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    tries = [json.loads(line) for line in done.stdout.splitlines()]
    assert len(tries) >= 20
    assert [one for one in tries if one["wrong"]] == []
    assert {one["status"] for one in tries} >= {-9, 1}
