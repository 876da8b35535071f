"""Break the machine under a running study in known ways, and see what the program says and how it goes on.

uv run python benchmarks/faults.py               every fault: half an hour
uv run python benchmarks/faults.py disk clock    only those with one of these words in their name
uv run python benchmarks/faults.py disk --docs   put their rows into docs/robustness.md

Each fault meets a study of three animals. It must end in a sentence of ours or in results; after the fault is gone,
the same command must end with results that are value-identical to those of an undisturbed run. A fault that this
machine cannot make (no mounts, no ordinary user) is said to be skipped. Exit code 1: one of them did not hold.
"""

import argparse
import os
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path

import numpy as np

import foreign
import vasowave as vw
from foreign import PROGRAM, Said, same
from robustness_page import put, rows_of

SETTINGS = """\
groups: [CTL]
calibration: {walls: [linear], starts: 2}
model_selection: false
numerics: {cell_size: 0.3}
report: {pdf: false}
"""
LONGEST = 300  # s

Fault = Callable[[Path], Said | None]


def write_study(folder: Path) -> Path:
    """Write a study of three mice that share a network of three vessels."""
    folder.mkdir(parents=True)
    vw.write_network(
        vw.Network(("1", "2", "3"), [-1, 0, 0], [0.41, 0.45, 0.37], [0.047, 0.026, 0.037]), folder / "n.csv"
    )
    mouse, rows = vw.virtual_mouse(), ["animal,group,network,recording,synthetic"]
    for number in range(3):
        signals = np.column_stack([mouse.time, mouse.pressure * (1 + 0.05 * number), mouse.flow])
        head = "time [s],pressure [mmHg],flow [ml/s]"
        np.savetxt(folder / f"{number}.csv", signals, "%.9f", ",", header=head, comments="")
        rows.append(f"mouse {number},CTL,n.csv,{number}.csv,yes")
    (folder / "animals.csv").write_text("\n".join(rows) + "\n")
    (folder / "study.yaml").write_text(SETTINGS)
    return folder


def run(
    folder: Path,
    *more: str,
    before: Sequence[str] = (),
    meanwhile: Callable[[int], object] | None = None,
    **options: object,
) -> Said:
    """Run the study; `meanwhile` is called with the process once the first animal is kept."""
    command = [*before, *PROGRAM, str(folder), "--workers", "1", "--no-report", *more]
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.STDOUT, "text": True}
    process = subprocess.Popen(command, **pipes, start_new_session=True, **options)
    late = threading.Timer(LONGEST, os.killpg, (process.pid, signal.SIGKILL))  # with its workers, which hold the pipe
    late.start()
    if meanwhile is not None:
        while process.poll() is None and not list((folder / "results" / "cache").glob("*.nc")):
            time.sleep(0.05)
        meanwhile(process.pid)
    said = process.communicate()[0]
    late.cancel()
    return Said(process.returncode, said)


def full_disk(folder: Path) -> Said | None:
    small = folder.with_name("small")
    small.mkdir()
    script = (
        f"mount -t tmpfs -o size=400k tmpfs '{small}' || exit 77\ncp '{folder}'/* '{small}' 2>/dev/null\n"
        f"'{PROGRAM[0]}' -m vasowave run '{small}' --workers 1 --no-report\n"
        f"status=$?\nmkdir '{folder}/results'\ncp -r '{small}/results/cache' '{folder}/results'\nexit $status\n"
    )
    done = subprocess.run(["unshare", "-rm", "sh", "-c", script], check=False, capture_output=True, text=True)
    return (
        None if done.returncode == 77 or "unshare" in done.stderr else Said(done.returncode, done.stdout + done.stderr)
    )


def read_only_folder(folder: Path) -> Said | None:
    """Run without the right of root to write anywhere."""
    if os.geteuid() == 0 and shutil.which("setpriv") is None:
        return None
    folder.chmod(0o555)
    said = run(folder, before=["setpriv", "--inh-caps=-all", "--bounding-set=-all"] if os.geteuid() == 0 else [])
    folder.chmod(0o755)
    return said


def killed(folder: Path) -> Said:
    return run(folder, meanwhile=lambda process: os.kill(process, signal.SIGKILL))


def interrupted(folder: Path) -> Said:
    def heard() -> None:
        signal.signal(signal.SIGINT, signal.default_int_handler)

    return run(folder, meanwhile=lambda process: os.kill(process, signal.SIGINT), preexec_fn=heard)


def worker_killed(by: signal.Signals, folder: Path) -> Said:
    def kill_children(process: int) -> None:
        listed = subprocess.run(
            ["ps", "-o", "pid=,args=", "--ppid", str(process)], capture_output=True, text=True, check=True
        )
        for line in listed.stdout.splitlines():
            if "spawn_main" in line:
                os.kill(int(line.split()[0]), by)

    return run(folder, meanwhile=kill_children)


def memory_limit(size: float, folder: Path) -> Said:
    """Let every process have `size` GB of addresses: too little for the solver, or even for loading what it needs."""

    def limit() -> None:
        resource.setrlimit(resource.RLIMIT_AS, (round(size * 1e9),) * 2)

    return run(folder, preexec_fn=limit)


def recordings_vanish(folder: Path) -> Said:
    aside = folder.with_name("aside")
    aside.mkdir()
    said = run(folder, meanwhile=lambda process: [one.rename(aside / one.name) for one in folder.glob("[12].csv")])
    for one in aside.iterdir():
        one.rename(folder / one.name)
    return said


def results_removed(folder: Path) -> Said:
    return run(folder, meanwhile=lambda process: shutil.rmtree(folder / "results"))


def clock_jumps_back(folder: Path) -> Said:
    """Let the clock of the program stand an hour earlier at every second look."""
    jump = "import itertools, time\nreal, looks = time.time, itertools.count()\n"
    jump += "time.time = lambda: real() - 3600 * (next(looks) % 2)\nfrom vasowave.cli import run; run()"
    command = [sys.executable, "-c", jump, "run", str(folder), "--workers", "1", "--no-report"]
    done = subprocess.run(command, check=False, capture_output=True, text=True, timeout=LONGEST)
    return Said(done.returncode, done.stdout + done.stderr)


def folder_in_place_of_a_piece(folder: Path) -> Said:
    run(folder)
    piece = next((folder / "results" / "cache").glob("*.nc"))
    piece.unlink()
    piece.mkdir()
    said = run(folder)
    piece.rmdir()
    return said


def pipe_as_recording(folder: Path) -> Said:
    (folder / "2.csv").rename(folder / "2.aside")
    os.mkfifo(folder / "2.csv")
    said = run(folder)
    (folder / "2.csv").unlink()
    (folder / "2.aside").rename(folder / "2.csv")
    return said


def scheduler_killed(folder: Path) -> Said | None:
    dask = Path(sys.executable).with_name("dask")
    if not dask.exists():
        return None
    address = "tcp://127.0.0.1:18786"
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    scheduler = subprocess.Popen(
        [str(dask), "scheduler", "--host", "127.0.0.1", "--port", "18786", "--no-dashboard"], **quiet
    )
    worker = subprocess.Popen([str(dask), "worker", address, "--nthreads", "1", "--no-dashboard"], **quiet)
    try:
        return run(folder, "--scheduler", address, meanwhile=lambda process: scheduler.kill())
    finally:
        for one in (worker, scheduler):
            one.kill()
            one.wait()


FAULTS: dict[str, Fault] = {
    "disk full": full_disk,
    "folder read-only": read_only_folder,
    "program killed": killed,
    "program interrupted (Ctrl-C)": interrupted,
    "worker killed": partial(worker_killed, signal.SIGKILL),
    "worker crashes": partial(worker_killed, signal.SIGSEGV),
    "memory limited to 0.9 GB": partial(memory_limit, 0.9),
    "memory limited to 0.78 GB": partial(memory_limit, 0.78),
    "memory limited to 0.7 GB": partial(memory_limit, 0.7),
    "recordings vanish": recordings_vanish,
    "results/ removed": results_removed,
    "clock jumps back": clock_jumps_back,
    "folder in place of a piece": folder_in_place_of_a_piece,
    "pipe as recording": pipe_as_recording,
    "scheduler killed": scheduler_killed,
    "modules planted": foreign.modules_planted,
    "pieces swapped": foreign.pieces_swapped,
    "100 flips of a kernel": partial(foreign.kernels_flipped, 100),
    "kernels of the solver damaged": foreign.solvers_kernels_damaged,
    "little room left": partial(foreign.room_left, [0, 4096, 65536], "index"),
    "0 to 64 kB left for the index": partial(foreign.room_left, range(0, 65537, 4096), "index"),
    "0 to 64 kB left for animals": partial(foreign.room_left, range(0, 65537, 4096), "animals"),
    "0 to 64 kB left for the report": partial(foreign.room_left, range(0, 65537, 8192), "report"),
    "files of at most 0 to 64 kB": partial(foreign.files_limited, [0, 1, 17, 500, 4095, 9999, 33333, 65536]),
    "a few mutants of a law": partial(foreign.laws_mutated, 30, 4),
    "300 mutants of a law": partial(foreign.laws_mutated, 300, 43),
}


def tried(name: str, sound: Path, folder: Path) -> tuple[str, str, bool]:
    """Return what a fault made the program say, how it went on, and whether both are as they must be."""
    said = FAULTS[name](write_study(folder / "study"))
    if said is None:
        return "skipped: this machine cannot make it", "", True
    held = said.held and "Traceback" not in said.words and "please report it" not in said.words
    lines = [line.strip() for line in said.words.splitlines() if line.strip()]
    last = next((line for line in reversed(lines) if "Error" in line or "failed" in line), lines[-1] if lines else "")
    words = f"status {said.status}: {last.replace(str(folder), '')[:160]}"
    after = run(folder / "study")
    whole = after.status == 0 and same(sound, folder / "study")
    return (
        words,
        "results identical" if whole else f"status {after.status}: {after.words[-200:]}",
        whole and held,
    )


def main() -> int:
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("words", nargs="*")
    parser.add_argument("--docs", action="store_true", help="put these rows into docs/robustness.md")
    arguments = parser.parse_args()
    chosen = [name for name in FAULTS if not arguments.words or any(word in name for word in arguments.words)]
    rows, held = {}, True
    with tempfile.TemporaryDirectory() as place:
        sound = write_study(Path(place) / "sound")
        assert run(sound).status == 0
        for number, name in enumerate(chosen):
            words, after, good = tried(name, sound, Path(place) / str(number))
            rows[name] = f"| {name} | {words.replace('|', '/')} | {after.replace('|', '/')} |"
            print(rows[name] + ("" if good else " DID NOT HOLD"), flush=True)
            held &= good
    if arguments.docs:
        rows = rows_of("faults") | rows
        table = ["| fault | what the program says | run again afterwards |", "|---|---|---|"]
        put("faults", "\n".join([*table, *(rows[name] for name in FAULTS if name in rows)]))
    return 0 if held else 1


if __name__ == "__main__":
    sys.exit(main())
