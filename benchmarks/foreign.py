"""What others bring: modules beside a study, laws with slips, damaged kernels, exchanged pieces, disks without room."""

import ast
import hashlib
import multiprocessing
import os
import resource
import shutil
import subprocess
import sys
import tempfile
import warnings
from collections import Counter
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numba
import numpy as np

import vasowave as vw
from vasowave.base import VasowaveError

sys.path.append(str(Path(__file__).parents[1] / "tools"))

PROGRAM = [sys.executable, "-m", "vasowave", "run"]
OPTIONAL = ("bottleneck", "coverage", "cupy", "dask", "numexpr", "pint", "pyarrow", "sparse", "statsmodels", "typst")
"""Modules that libraries look for when they are loaded or first used."""

NO_ROOM = ("no space left", "larger than this system or its limits allow")
LONGEST = 400  # s, of a fit with a mutated law on a busy machine
LAW_NAME = "our_laws:ExponentialWall"


class Said(NamedTuple):
    """Status and words of a run, and whether something else was seen that must not be."""

    status: int
    words: str
    held: bool = True


def started(folder: Path, *more: str, program: Sequence[str] = PROGRAM, **options: Any) -> Said:
    """Run a study without its report."""
    command = [*program, str(folder), "--workers", "1", "--no-report", *more]
    done = subprocess.run(command, check=False, capture_output=True, text=True, **options)
    return Said(done.returncode, done.stdout + done.stderr)


def modules_planted(folder: Path) -> Said:
    """Put a module of every name that Python or a library may look for beside the study, and run it from there."""
    mark = folder / "ran"
    names = sorted({*OPTIONAL, *sys.stdlib_module_names, "numba", "numpy", "typer", "xarray", "yaml", "usercustomize"})
    for name in names:
        (folder / f"{name}.py").write_text(f"open({str(mark)!r}, 'a').write(__name__ + ' ')")
    script = [str(Path(sys.executable).with_name("vasowave")), "run"]
    said = [started(folder, program=script, cwd=folder)]
    safe = [sys.executable, "-P", "-m", "vasowave", "run"]  # for a bare -m Python looks here itself, before any program
    said.append(started(folder, program=safe, cwd=folder))
    ran = mark.read_text() if mark.exists() else ""
    for name in names:
        (folder / f"{name}.py").unlink(missing_ok=True)
    words = f"{len(names)} modules planted, {len(ran.split())} run {ran}; {said[0].words.strip().splitlines()[-1]}"
    return Said(max(one.status for one in said), words, not ran)


def kernels_flipped(count: int, folder: Path) -> Said:
    """Flip one byte of a kept kernel, `count` times, and take the function anew each time."""
    from numba import njit

    from vasowave.base.runtime import kernels

    rng, outcomes = np.random.default_rng(0), Counter[str]()

    def kernel(x: float) -> float:
        return 3.0 * x + 1.0

    with tempfile.TemporaryDirectory() as place:
        vars(numba.config)["CACHE_DIR"] = place
        kernels.kept(njit(kernel))(2.0)
        (file,) = Path(place).rglob("*.kernel")
        for _ in range(count):
            content = bytearray(file.read_bytes())
            content[int(rng.integers(len(content)))] ^= 1 << int(rng.integers(8))
            file.write_bytes(content)
            taken = [kernels.kept(njit(kernel)) for _ in range(2)]
            good = [one(2.0) == 7.0 for one in taken]
            hits = [sum(one.stats.cache_hits.values()) for one in taken]
            outcomes["compiled anew, then kept" if all(good) and hits == [0, 1] else f"{good} {hits}"] += 1
    said = started(folder)
    words = ", ".join(f"{number} {what}" for what, number in outcomes.items())
    return Said(said.status, f"{count} flips: {words}", set(outcomes) == {"compiled anew, then kept"})


def solvers_kernels_damaged(folder: Path) -> Said:
    """Flip bytes all over the solver's own kernels, empty and halve them; run the study after each damage."""
    rng, said = np.random.default_rng(24), []
    with tempfile.TemporaryDirectory() as place:
        options: Any = {"env": os.environ | {"NUMBA_CACHE_DIR": place}}
        assert started(folder, **options).status == 0
        files = sorted(Path(place).rglob("*.kernel"), key=lambda file: -file.stat().st_size)
        largest, digest = files[0], hashlib.sha256().digest_size
        places = [int(rng.integers(digest)), *rng.integers(digest, largest.stat().st_size, 2).tolist()]
        damages = [(largest, partial(_flipped, at)) for at in places]
        damages += [(largest, lambda content: b""), (largest, lambda content: content[: len(content) // 2])]
        damages += [(file, lambda content: _flipped(int(rng.integers(len(content))), content)) for file in files[1:]]
        sound = vw.read_results(folder).in_order()
        for file, damage in damages:
            file.write_bytes(damage(file.read_bytes()))
            shutil.rmtree(folder / "results")
            said.append(started(folder, **options))
            again = [] if said[-1].status else vw.read_results(folder).in_order()
            if not again or not all(one.identical(other) for one, other in zip(again, sound, strict=True)):
                return Said(said[-1].status, f"{file.name} damaged: {said[-1].words}", held=False)
    told = sum("was damaged; it is compiled anew" in one.words for one in said)
    words = f"{len(damages)} damages of {len(files)} kernels, {told} told, all runs finished with the same values"
    return Said(0, words, told == len(damages))


def _flipped(at: int, content: bytes) -> bytes:
    return content[:at] + bytes([content[at] ^ 4]) + content[at + 1 :]


def pieces_swapped(folder: Path) -> Said:
    """Put the piece of one animal under the key of another, with a name that fits its bytes."""
    started(folder)
    one, other = sorted((folder / "results" / "cache").glob("*.nc"))[:2]
    content = one.read_bytes()
    key = other.name.partition("-")[0]
    other.unlink()
    (other.parent / f"{key}-{hashlib.sha256(content).hexdigest()}.nc").write_bytes(content)
    said = started(folder)
    return Said(said.status, said.words.strip(), "1 animal computed, 2 kept" in said.words)


def room_left(sizes: Sequence[int], what: str, folder: Path) -> Said | None:
    """Run on disks with so many bytes left, then with room again; no size may leave a part of a file behind.

    Written are ``animals`` and the index, the ``index`` alone with the animals kept, or the ``report``.
    """
    more = [] if what == "report" else ["--no-report"]
    sound, small, ended = folder.with_name("sound of room"), folder.with_name("small"), Counter[str]()
    shutil.copytree(folder, sound)
    assert started(sound).status == 0
    small.mkdir()
    if what != "animals":
        subprocess.run(["cp", "-a", sound / "results", folder], check=True)  # links stay links: copies are freed
        (folder / "results" / "index.json").unlink()
    for size in sizes:
        run = f"'{PROGRAM[0]}' -m vasowave run '{small}' --workers 1 {' '.join(more)}"
        script = (
            f"mount -t tmpfs -o size=16m tmpfs '{small}' || exit 77\ncp -a '{folder}'/. '{small}'\n"
            f"free=$(($(stat -f -c %a '{small}') * $(stat -f -c %S '{small}') - {size}))\n"
            f"head -c $free /dev/zero > '{small}/filler'\n{run}\nstatus=$?\n"
            f"find '{small}' -name '.vasowave-part*' | sed 's/^/Left behind: /'\nrm '{small}/filler'\n"
            f"{run} >'{small}/said' 2>&1 || {{ echo Not mended: ; cat '{small}/said'; }}\n"
            f"rm -rf '{small}.after'; cp -a '{small}' '{small}.after'\nexit $status\n"
        )
        done = subprocess.run(["unshare", "-rm", "sh", "-c", script], check=False, capture_output=True, text=True)
        if done.returncode == 77 or "unshare" in done.stderr:
            return None
        became = _ending(done.returncode, done.stdout + done.stderr)
        if became in ("finished", "one sentence") and not same(sound, small.with_name("small.after")):
            became = "other values afterwards"
        ended[became] += 1
    shutil.rmtree(folder / "results", ignore_errors=True)
    return _endings(ended, f"{len(sizes)} disks")


def same(one: Path, other: Path) -> bool:
    """Whether two studies hold identical trees."""
    first, second = vw.read_results(one), vw.read_results(other)
    return list(first) == list(second) and all(first[name].identical(second[name]) for name in first)


def files_limited(sizes: Sequence[int], folder: Path) -> Said:
    """Let no file grow beyond so many bytes."""
    ended = Counter[str]()
    for size in sizes:
        said = started(folder, preexec_fn=lambda size=size: resource.setrlimit(resource.RLIMIT_FSIZE, (size, size)))
        ended[_ending(*said[:2])] += 1
    return _endings(ended, f"{len(sizes)} limits")


def _ending(status: int, words: str) -> str:
    if "Traceback" in words or "please report" in words:
        return "foreign"
    if "Left behind:" in words or "Not mended:" in words:
        return f"not mended: {words[-300:]}"
    lines = [line for line in words.splitlines() if "Error:" in line or "failed:" in line]
    if status == 0:
        return "finished"
    return "one sentence" if len(lines) == 1 and any(why in lines[0] for why in NO_ROOM) else f"other: {words[-300:]}"


def _endings(ended: Counter[str], what: str) -> Said:
    words = ", ".join(f"{count} {how}" for how, count in ended.items())
    return Said(1 if ended["one sentence"] else 0, f"{what}: {words}", set(ended) <= {"finished", "one sentence"})


def laws_mutated(count: int, seed: int, folder: Path) -> Said:
    """Damage the file of a law; check the study that names it, and fit with it, whatever the check said."""
    from fuzzing.mutations import mutate_text
    from fuzzing.studies import LAW, study_with_a_law

    place, ended = folder / "law", Counter[str]()
    place.mkdir()
    study_with_a_law(place)
    fitting = _Fitting(place)
    for number in range(count):
        (place / "our_laws.py").write_bytes(mutate_text(LAW.encode(), np.random.default_rng([seed, number])))
        became = fitting.became()
        ended[became] += 1
        if became not in _GOOD:
            print(f"mutant {number} of seed {seed}: {became}", file=sys.stderr, flush=True)
    fitting.end()
    shutil.rmtree(place)
    words = ", ".join(f"{number} {how}" for how, number in ended.most_common())
    return Said(0, f"{count} mutants: {words}", set(ended) <= _GOOD)


_GOOD = {"refused by check and fit", "the same program", "fitted", "refused by fit"}


class _Fitting:
    """A process that fits with one law after the other: what does not depend on the law is compiled once."""

    def __init__(self, place: Path) -> None:
        context = multiprocessing.get_context("spawn")
        self._start = lambda end: context.Process(target=_fit_each, args=(str(place), end), daemon=True)
        self._pipe = context.Pipe
        self._begin()

    def _begin(self) -> None:
        self._told, end = self._pipe()
        self._process = self._start(end)
        self._process.start()
        end.close()  # so that the end of the process ends the pipe

    def became(self) -> str:
        """Return what became of the law whose file lies there now."""
        self._told.send("next")
        try:
            if self._told.poll(LONGEST):
                return str(self._told.recv())
            outcome = "hang"
        except (EOFError, ConnectionError):
            outcome = "crash"
        self.end()
        self._begin()
        return outcome

    def end(self) -> None:
        self._process.kill()
        self._process.join()


def _fit_each(place: str, told: Any) -> None:
    os.chdir(place)
    os.environ["NUMBA_OPT"] = "0"
    warnings.simplefilter("ignore")
    from fuzzing.studies import LAW

    sound = ast.dump(ast.parse(LAW))
    while told.recv():
        told.send(_became(Path(place), sound))


def _became(place: Path, sound: str) -> str:
    from fuzzing.studies import checked_law

    checked = ""
    try:
        checked_law(place)
    except VasowaveError:
        checked = "refused by check and "
    except BaseException as error:
        return f"foreign in check: {type(error).__name__}: {str(error)[:200]}"
    if not checked and ast.dump(ast.parse((place / "our_laws.py").read_bytes())) == sound:
        return "the same program"
    network, cycle = vw.Network(("1",), [-1], [0.4], [0.05]), vw.read_recording(place / "0.csv", period=0.11)
    fixed = dict.fromkeys(("r1", "r2", "c1"), 1.0)
    coarse = vw.Numerics(cell_size=1.0, samples=64, steps_per_cycle=256, cycles_from_rest=2)
    try:
        vw.calibrate(network, cycle, LAW_NAME, search=vw.Search(starts=1, fixed=fixed), numerics=coarse)
    except VasowaveError:
        return checked + ("fit" if checked else "refused by fit")
    except BaseException as error:
        return f"{checked}foreign in fit: {type(error).__name__}: {str(error)[:200]}"
    return checked + "fitted"
