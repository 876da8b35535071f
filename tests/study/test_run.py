import os
import random
import resource
import shutil
import signal
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pandas as pd
import pytest
import xarray as xr
from small_study import make_study_in

from vasowave.base import InputError, VasowaveWarning
from vasowave.study.animal import AnimalResult, Stage
from vasowave.study.folder import RESULTS
from vasowave.study.results import animal_key, read_results
from vasowave.study.running import Done, read_study, report_study, run_study, study_status

pytestmark = pytest.mark.usefixtures("undrawn")

# A background job inherits a SIGINT that is ignored.
HEARD = "import signal; signal.signal(signal.SIGINT, signal.default_int_handler)"
PROGRAM = [sys.executable, "-c", f"{HEARD}; from vasowave.cli import run; run()"]


def start(folder: Path, **more) -> subprocess.Popen:
    command = [*PROGRAM, "run", str(folder), "--workers", "1", "--no-report"]
    return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, **more)


def finish(folder: Path) -> Done:
    """Run a study in this process, which has its modules in memory already."""
    with ThreadPoolExecutor(1) as executor:
        return run_study(read_study(folder), executor=executor)


def results(folder: Path) -> dict[str, AnimalResult]:
    results = read_results(folder)
    return {name: results[name] for name in results}


def test_every_tree_names_its_files_with_their_hashes(undisturbed):
    import hashlib

    found = results(undisturbed)["mouse 1"].origin
    for role, name in (("network", "n.csv"), ("recording", "recordings/1.csv")):
        assert found[f"sha256 of {role}"] == f"{hashlib.sha256((undisturbed / name).read_bytes()).hexdigest()} ({name})"


def assert_same(one: dict[str, AnimalResult], other: dict[str, AnimalResult]) -> None:
    """Compare every value, coordinate and attribute of all animals."""
    assert list(one) == list(other)
    for name in one:
        xr.testing.assert_identical(one[name].to_datatree(), other[name].to_datatree())


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory, mice) -> Path:
    """Return a study that ran through."""
    folder = make_study_in(tmp_path_factory.mktemp("run") / "study", mice)
    done = finish(folder)
    assert (done.computed, done.failures) == (("mouse 0", "mouse 1", "mouse 2"), ())
    return folder


def copied(undisturbed, to: Path) -> Path:
    shutil.copytree(undisturbed, to)
    return to


def killed_after(folder: Path, seconds: float) -> bool:
    """Kill a run after some time; return whether it was still at it."""
    with start(folder) as program:
        try:
            program.wait(seconds)
        except subprocess.TimeoutExpired:
            program.send_signal(signal.SIGKILL)
            program.wait()
            return True
    return False


def warm_duration(source: Path, folder: Path) -> float:
    """Return how long a whole run lasts once the solver is compiled, s; the first one of a clone lasts longer."""
    shutil.copytree(source, folder, ignore=shutil.ignore_patterns(RESULTS))
    began = time.monotonic()
    with start(folder) as program:
        program.communicate()
    return time.monotonic() - began


def finish_as(undisturbed: Path, folder: Path) -> None:
    """Let a run go on to its end, and find in it what the undisturbed one found."""
    with start(folder) as program:
        said = program.communicate()[0]
    assert program.returncode == 0, said
    assert_same(results(folder), results(undisturbed))
    assert not list((folder / RESULTS).rglob(".vasowave-part-*"))


def test_what_a_run_left_unfinished_that_was_killed_while_it_wrote_its_results_is_removed(undisturbed, tmp_path):
    folder = copied(undisturbed, tmp_path / "killed")
    for place in ("", "animals", "cache"):
        (folder / RESULTS / place / ".vasowave-part-x").write_text("half an index")
    assert finish(folder).computed == ()
    assert_same(results(folder), results(undisturbed))
    assert not list((folder / RESULTS).rglob(".vasowave-part-*"))


@pytest.mark.weekly
def test_runs_killed_at_twenty_random_moments_go_on_to_the_same_results(undisturbed, tmp_path):
    moment, lasts = random.Random(2), warm_duration(undisturbed, tmp_path / "warm")
    killed = 0
    for number in range(60):
        folder = tmp_path / f"killed {number}"
        shutil.copytree(undisturbed, folder, ignore=shutil.ignore_patterns(RESULTS))
        after = moment.uniform(0.1, 0.95) * lasts
        if killed_after(folder, after):
            killed += 1
            finish_as(undisturbed, folder)
        else:
            lasts = after  # the machine has become quicker than it was when the run was timed
        if killed == 20:
            return
    pytest.fail(f"only {killed} of 60 runs were still at it when they were to be killed")


def test_what_has_finished_is_found_by_content_and_only_what_changed_is_computed(undisturbed, tmp_path):
    folder = copied(undisturbed, tmp_path / "study")
    for path in folder.rglob("*.csv"):
        os.utime(path, (1, 1))
    assert finish(folder).computed == ()

    first = folder / "recordings/0.csv"
    lines = first.read_text().splitlines()
    t, p, q = lines[5].split(",")
    lines[5] = f"{t},{float(p) + 0.05},{q}"
    changed = "\n".join(lines) + "\n"
    original = first.read_text()
    first.write_text(changed)
    done = finish(folder)
    assert (done.computed, done.kept) == (("mouse 0",), ("mouse 1", "mouse 2"))
    with pytest.raises(AssertionError):
        assert_same(results(folder), results(undisturbed))

    first.write_text(original)  # the earlier result was not overwritten by that of the other input
    assert finish(folder).computed == ()
    assert_same(results(folder), results(undisturbed))


def test_a_line_lost_from_the_table_is_missed_and_comes_back_without_computing(undisturbed, tmp_path):
    folder = copied(undisturbed, tmp_path / "study")
    table = folder / "animals.csv"
    whole = table.read_text()
    table.write_text("\n".join(line for line in whole.splitlines() if not line.startswith("mouse 1")) + "\n")
    with pytest.warns(VasowaveWarning, match="mouse 1: in the results of the last run, but no longer in the table"):
        assert finish(folder).kept == ("mouse 0", "mouse 2")
    table.write_text(whole)
    assert finish(folder).computed == ()
    assert_same(results(folder), results(undisturbed))


def test_a_truncated_piece_is_computed_again(undisturbed, tmp_path):
    folder = copied(undisturbed, tmp_path / "study")
    piece = max((folder / RESULTS / "cache").iterdir())
    os.truncate(piece, piece.stat().st_size // 2)
    done = finish(folder)
    assert len(done.computed) == 1
    assert len(done.kept) == 2
    assert_same(results(folder), results(undisturbed))


@pytest.mark.parametrize(
    ("changed", "computed"),
    [
        (lambda text: f"title: another\nspecies: other\n{text}", False),
        (lambda text: f"averaging: {{beats: 5}}\n{text}", False),  # no animal of this study is averaged
        (lambda text: text.replace("starts: 2", "starts: 3"), True),
        (lambda text: f"{text}blood: {{viscosity: 0.05}}\n", True),
    ],
)
def test_settings_that_change_numbers_ask_for_new_ones_and_others_do_not(make_study, changed, computed):
    folder = make_study(animals=1)

    def key() -> str:
        study = read_study(folder)
        return animal_key(study.animals[0], study.settings, folder)

    before = key()
    (folder / "study.yaml").write_text(changed((folder / "study.yaml").read_text()))
    assert (key() != before) is computed


def test_a_failed_animal_is_reported_and_the_others_are_there(undisturbed, tmp_path):
    folder = copied(undisturbed, tmp_path / "study")
    with (folder / "study.yaml").open("a") as file:
        file.write("title: Two mice and a slip\n")
    bad = folder / "recordings/1.csv"
    lines = bad.read_text().splitlines()
    lines[40] = lines[40].rpartition(",")[0] + ","
    bad.write_text("\n".join(lines) + "\n")
    done = finish(folder)
    assert (done.computed, done.kept) == ((), ("mouse 0", "mouse 2"))
    results = read_results(folder)
    assert done.failures == results.failures
    assert list(results) == ["mouse 0", "mouse 2"]
    (lost,) = results.failures
    assert (lost.animal, lost.group, lost.law, lost.stage) == ("mouse 1", "CTL", "", Stage.READING)
    assert "line 41" in lost.reason
    assert lost.mean_pressure is None
    status = study_status(read_study(folder)).animals[1]
    assert status.state == "failed"
    assert "1.csv, line 41" in str(status)

    # The report needs the stored results and nothing else.
    for name in ("recordings", f"{RESULTS}/cache"):
        shutil.rmtree(folder / name)
    for name in ("animals.csv", "n.csv", "study.yaml"):
        (folder / name).unlink()
    told: list[tuple[str, str]] = []
    page = report_study(folder / "study.yaml", announce=told.extend).read_text(encoding="utf-8")
    assert told
    assert all(question in page for question, _ in told)
    for words in ("mouse 1", "line 41", "Two mice and a slip"):
        assert words in page
    table = pd.read_csv(folder / "report" / "tables" / "HemoStats.csv")
    rate = table[(table["quantity"] == "HR [beats/min]") & (table["group"] == "CTL")].iloc[0]
    assert rate["n"] == 1
    assert rate["mean"] == pytest.approx(533, rel=1e-6)  # that of the virtual mouse
    alone = report_study(folder, animal="mouse 2")
    assert "Hemodynamic assessment of mouse 2" in alone.read_text(encoding="utf-8")
    assert alone.parent.parent.name == "report of animals"
    for name, words in (("mouse 1", "line 41"), ("mouse 22", "did you mean 'mouse 2'")):
        with pytest.raises(InputError, match=words):
            report_study(folder, animal=name)


def test_an_animal_that_goes_on_from_kept_searches_is_counted_as_such(make_study):
    folder = make_study(animals=2)
    other = folder / "recordings/1.csv"
    other.write_text("time [s],pressure [mmHg],flow [ml/s]\n0,1,2\n")
    first = finish(folder)  # searches are kept as long as an animal is wanting
    assert (first.computed, first.resumed) == (("mouse 0",), ())
    for piece in (folder / RESULTS / "cache").iterdir():
        piece.unlink()
    again = finish(folder)
    assert (again.computed, again.resumed) == (("mouse 0",), ("mouse 0",))


def test_an_interrupted_run_ends_at_once_and_keeps_what_had_finished(undisturbed, tmp_path):
    folder = tmp_path / "study"
    shutil.copytree(undisturbed, folder, ignore=shutil.ignore_patterns(RESULTS))
    with start(folder) as program:
        assert program.stdout is not None
        assert program.stdout.readline().startswith("3 animals.")
        for line in program.stdout:  # a slow machine tells of single fits too
            if line.startswith("1 of 3: mouse 0 computed"):
                break
        program.send_signal(signal.SIGINT)
        said = program.communicate()[0]
    assert program.returncode == 130
    assert "What had finished is kept" in said
    assert "Traceback" not in said
    assert len(list((folder / RESULTS / "cache").iterdir())) == 1


def test_a_report_says_that_the_study_changed_since_it_was_run(undisturbed, tmp_path, recwarn):
    folder = copied(undisturbed, tmp_path / "study")
    report_study(folder, animal="mouse 1")
    assert len(recwarn) == 0
    table, settings = folder / "animals.csv", folder / "study.yaml"
    first, second, *others = table.read_text().splitlines()[1:]
    header = table.read_text().splitlines()[0]
    moved = second.replace(",CTL,", ",HPH,")
    table.write_text("\n".join([header, first, moved, *others, first.replace("mouse 0", "mouse 9")]) + "\n")
    settings.write_text(f"title: Another\n{settings.read_text()}")
    with pytest.warns(VasowaveWarning, match="changed since it was run") as caught:
        report_study(folder, animal="mouse 1")
    said = str(caught[0].message)
    assert "another group: mouse 1 (HPH, was CTL); " in said
    assert "program) changed: mouse 1; new animals: mouse 9; settings: title" in said
    table.write_text("\n".join([header, first, *others]) + "\n")
    with pytest.warns(VasowaveWarning, match="no longer in the table: mouse 1; settings"):
        report_study(folder, animal="mouse 1")


def test_a_folder_one_level_too_deep_is_told_where_the_study_is(tmp_path):
    for name in ("study.yaml", "results/index.json", "report/report.html"):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).touch()
    with pytest.raises(InputError, match=f"the study is {tmp_path}$"):
        read_study(tmp_path / "report")
    with pytest.raises(InputError, match=f"they are those of {tmp_path}$"):
        read_results(tmp_path / "report")


def smallest_piece(folder: Path) -> int:
    return min(path.stat().st_size for path in (folder / RESULTS / "cache").iterdir())


@pytest.mark.validation
def test_a_disk_that_takes_no_more_stops_the_run_with_a_message_and_it_goes_on_later(undisturbed, tmp_path):
    """No file may grow beyond a limit (RLIMIT_FSIZE): the system then refuses writes as a full disk does."""
    folder = copied(undisturbed, tmp_path / "study")
    pieces = sorted((folder / RESULTS / "cache").iterdir())
    pieces[0].unlink()
    (folder / RESULTS / "index.json").unlink()
    limit = smallest_piece(folder) // 2

    def refuse_large_files():
        resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit))

    with start(folder, preexec_fn=refuse_large_files) as program:
        said = program.communicate()[0]
    assert program.returncode == 1
    assert "Error: " in said
    assert "Traceback" not in said
    assert {path.name for path in (folder / RESULTS / "cache").iterdir()} == {path.name for path in pieces[1:]}
    assert not (folder / RESULTS / "index.json").exists()

    done = finish(folder)
    assert len(done.computed) == 1
    assert_same(results(folder), results(undisturbed))


@pytest.mark.validation  # a whole run; the test above shows the same of one animal
def test_a_full_file_system_stops_the_run_with_a_message_and_it_goes_on_later(undisturbed, tmp_path):
    """A real file system of a megabyte in memory, in a mount name space of its own, where the system allows that."""
    folder = tmp_path / "small"
    folder.mkdir()
    source = undisturbed
    room = smallest_piece(source) * 2 // 1024 + 200
    saved = tmp_path / "saved"
    script = (
        f"mount -t tmpfs -o size={room}k tmpfs '{folder}' || exit 77\n"
        f"cp -r '{source}'/*.csv '{source}'/study.yaml '{source}/recordings' '{folder}'\n"
        f"{' '.join(map(shell_quoted, PROGRAM))} run '{folder}' --workers 1 --no-report\n"
        "status=$?\n"
        f"cp -r '{folder}' '{saved}'\n"
        "exit $status\n"
    )
    if shutil.which("unshare") is None:
        pytest.skip("no unshare here")
    program = subprocess.run(["unshare", "-rm", "sh", "-c", script], check=False, capture_output=True, text=True)
    if program.returncode == 77 or "unshare" in program.stderr:
        pytest.skip(f"no mounts here: {program.stderr.strip()}")
    assert program.returncode == 1, program.stderr
    assert "Traceback" not in program.stderr
    assert "what had finished is kept" in program.stderr
    assert not (saved / RESULTS / "index.json").exists()
    kept = list((saved / RESULTS / "cache").glob("*"))
    assert 1 <= len(kept) < 3

    done = finish(saved)
    assert len(done.kept) == len(kept)
    assert len(done.computed) == 3 - len(kept)
    assert_same(results(saved), results(source))


def shell_quoted(text: str) -> str:
    return f"'{text}'"


def test_a_study_of_which_every_animal_fails_says_why(make_study):
    folder = make_study(animals=1)
    (folder / "recordings/0.csv").write_text("time [s],pressure [mmHg],flow [ml/s]\n0,1,2\n")
    with pytest.raises(InputError, match=r"every animal failed\n  mouse 0: .*0\.csv"):
        finish(folder)
