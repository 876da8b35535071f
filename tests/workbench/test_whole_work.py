"""The workbench end to end, a program of its own: from raw files to a report, killed, interrupted, on a full disk."""

import os
import re
import shutil
import signal
import subprocess
import sys
import time
from contextlib import contextmanager, suppress
from pathlib import Path
from urllib.parse import urlsplit

import numpy as np
import pytest

import vasowave as vw
from vasowave.study.entering import read_rows
from vasowave.study.running import study_status

PROGRAM = [sys.executable, "-m", "vasowave"]
READ = "document.querySelector('#checking')?.textContent === ''"
CANVAS = "canvas.signals"
SHOWN = f"Number(document.querySelector('{CANVAS}')?.dataset.drawn) > 0"


def rows(folder):
    return {row["animal"]: row for row in read_rows(folder / "animals.csv").rows}


@contextmanager
def workbench(folder, before=()):
    """Start `vasowave open`; give the program and its address."""
    command = [*before, *PROGRAM, "open", str(folder), "--no-browser"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True) as program:
        try:
            said = []
            for line in program.stdout:
                said.append(line)
                if line.startswith("Workbench:"):
                    yield program, line.split()[-1]
                    break
            else:
                pytest.fail("".join(said))
        finally:
            if program.poll() is None:
                program.kill()


SENDING = """
window.answered = [];
(async (from, most) => {
  for (let k = 1; k <= most; k++) {
    const message = { do: "edit-beats", animal: "mouse_c1", edits: [["reject", from + 0.01 * k, null]] };
    const how = { method: "POST", headers: { "content-type": "application/json" }, body: JSON.stringify(message) };
    if ((await fetch("act", how)).ok) window.answered.push(from + 0.01 * k);
  }
})(%d, %g).catch(() => {});
0
"""


@pytest.mark.weekly
def test_a_server_that_is_killed_at_any_moment_leaves_whole_files_and_all_that_it_answered(program, study):
    """Twelve times: edits as fast as the page can send them, and SIGKILL after a random while."""
    random, known = np.random.default_rng(1), 0
    for attempt in range(12):
        with workbench(study) as (server, address):
            page = program.page(address + "#study")
            page.js(SENDING % (100 * (attempt + 1), 1e9))
            page.until("window.answered.length > 2")
            time.sleep(random.uniform(0, 0.3))
            server.kill()
            server.wait()
            page.until("document.querySelector('#said').textContent.includes('start `vasowave open` again')")
            answered = page.js("window.answered")
        kept = {round(one.time, 3) for one in vw.read_edits(study / rows(study)["mouse_c1"]["beat edits"])}
        assert {round(one, 3) for one in answered} <= kept
        assert len(kept) - known - len(answered) in (0, 1)  # one may be written whose answer never came
        known = len(kept)
        assert len(rows(study)) == 6
    with workbench(study) as (_, address):
        page = program.page(address + "#study")
        page.until(READ, 60)
        page.until("document.querySelectorAll('tr[data-animal]').length === 6")
        time.sleep(2.5)  # a younger piece may be of somebody who is about to lock it
        page.js(SENDING % (5000, 1))  # the next change removes what the last kill left beside its file
        page.until("window.answered.length === 1")
    assert [one for one in study.rglob(".vasowave-part-*") if one.name.endswith(".csv")] == []


def listening():
    """Return address and port of every socket of this machine that waits for connections."""
    rows = [line.split() for line in Path("/proc/net/tcp").read_text(encoding="utf-8").splitlines()[1:]]
    return [(address, int(port, 16)) for address, _, port in (row[1].partition(":") for row in rows if row[3] == "0A")]


@pytest.mark.validation
@pytest.mark.parametrize("stops", [False, True])
def test_control_c_ends_it_at_once_and_the_run_goes_on_or_stops_as_was_chosen(program, study, stops):
    with workbench(study) as (server, address):
        assert {local for local, port in listening() if port == urlsplit(address).port} == {"0100007F"}  # 127.0.0.1
        page = program.page(address)
        page.until(READ, 60)
        if stops:
            page.click("[data-key=at-end]")
            page.until("document.querySelector('[data-key=at-end]').checked")
        page.until("!document.querySelector('#run').disabled", 60)
        page.click("#run")
        page.until("document.querySelector('#stop')", 60)
        page.until("document.querySelector('#running').textContent.startsWith('Running')", 60)
        time.sleep(2.0)
        runner = int(re.search(r"process (\d+)", page.js("document.body.innerText"))[1])
        begun = time.monotonic()
        server.send_signal(signal.SIGINT)
        said = server.stdout.read()
        server.wait(10)
        assert time.monotonic() - begun < 5.0
        assert ("goes on" in said) is not stops
    end = time.monotonic() + 120
    while _lives(runner):
        assert time.monotonic() < end
        time.sleep(0.2)
    states = {one.state for one in study_status(vw.read_study(study)).animals}
    assert (states == {"done"}) is not stops
    assert not list((study / "results").glob(".vasowave-part-*"))


def _lives(process):
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    return Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0] != "Z"


def fill(path):
    """Take all room that is left."""
    with path.open("wb", buffering=0) as file, suppress(OSError):
        while True:
            file.write(b"x" * 4096)


@pytest.mark.validation
def test_a_full_disk_refuses_in_a_sentence_changes_nothing_and_goes_on_when_there_is_room(program, study, tmp_path):
    """A file system of four megabytes in memory, in a mount name space of its own, where the system allows that."""
    small = tmp_path / "small"
    small.mkdir()
    script = f"mount -t tmpfs -o size=4m tmpfs '{small}' && cp -r '{study}'/. '{small}' && exec \"$@\""
    if shutil.which("unshare") is None:
        pytest.skip("no unshare here")
    tried = subprocess.run(
        ["unshare", "-rm", "sh", "-c", script, "sh", "true"], check=False, capture_output=True, text=True
    )
    if tried.returncode:
        pytest.skip(f"no mounts here: {tried.stderr.strip()}")
    with workbench(small, ["unshare", "-rm", "sh", "-c", script, "sh"]) as (server, address):
        seen = Path(f"/proc/{server.pid}/root{small}")  # the file system as the server has it
        page = program.page(address + "#recording/mouse_c1")
        page.until(SHOWN, 60)
        table = (seen / "animals.csv").read_bytes()
        fill(seen / "filler")
        page.js(f"document.querySelector('{CANVAS}').focus()")
        page.key("n")
        page.key("x")
        page.until("document.querySelector('#said.wrong')?.textContent.match(/no space|full/i)")
        assert (seen / "animals.csv").read_bytes() == table
        assert not (seen / "edits" / "mouse_c1.csv").exists()
        (seen / "filler").unlink()
        page.key("x")
        page.until("document.body.innerText.includes('1 beats edited')")
        assert "edits/mouse_c1.csv" in (seen / "animals.csv").read_text(encoding="utf-8")
        assert [one for one in page.errors if "507" not in one and "400" not in one] == []
