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
from collections.abc import Callable, Sequence
from pathlib import Path
from queue import Empty
from typing import Any, NamedTuple

import numpy as np

import vasowave as vw
from vasowave.errors import VasowaveError

sys.path.append(str(Path(__file__).parents[1] / "tools"))

PROGRAM = [sys.executable, "-m", "vasowave", "run"]
OPTIONAL = ("bottleneck", "coverage", "cupy", "dask", "numexpr", "pint", "pyarrow", "sparse", "statsmodels", "typst")
"""Modules that libraries look for when they are loaded or first used."""

NO_ROOM = ("no space left", "larger than this system or its limits allow")
LONGEST = 400  # s, of a fit with a mutated law on a busy machine


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

    from vasowave import kernels

    rng, outcomes = np.random.default_rng(0), Counter[str]()

    def kernel(x: float) -> float:
        return 3.0 * x + 1.0

    with tempfile.TemporaryDirectory() as place:
        kernels.numba.config.CACHE_DIR = place
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
    """Flip a byte, empty and cut the solver's own kernels; run the study after each."""
    with tempfile.TemporaryDirectory() as place:
        options: Any = {"env": os.environ | {"NUMBA_CACHE_DIR": place}}
        said = [started(folder, **options)]
        damages: list[Callable[[bytes], bytes]] = [
            lambda content: content[:9999] + bytes([content[9999] ^ 4]) + content[10000:],
            lambda content: b"",
            lambda content: content[: len(content) // 2],
        ]
        for damage in damages:
            for file in Path(place).rglob("*.kernel"):
                file.write_bytes(damage(file.read_bytes()))
            shutil.rmtree(folder / "results")
            said.append(started(folder, **options))
    told = sum("was damaged; it is compiled anew" in one.words for one in said)
    held = told == len(damages) and not any(one.status for one in said)
    return Said(max(one.status for one in said), f"{len(damages)} damages, {told} told, all runs finished", held)


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


def room_left(sizes: Sequence[int], fresh: bool, folder: Path) -> Said | None:
    """Run on a disk with so many bytes left, with the animals kept already or to be computed."""
    if not fresh:
        assert started(folder).status == 0
        (folder / "results" / "index.json").unlink()
    small, ended = folder.with_name("small"), Counter[str]()
    small.mkdir()
    for size in sizes:
        script = (
            f"mount -t tmpfs -o size=4m tmpfs '{small}' || exit 77\ncp -r '{folder}'/. '{small}'\n"
            f"free=$(($(stat -f -c %a '{small}') * $(stat -f -c %S '{small}') - {size}))\n"
            f"head -c $free /dev/zero > '{small}/filler'\n"
            f"'{PROGRAM[0]}' -m vasowave run '{small}' --workers 1 --no-report\n"
        )
        done = subprocess.run(["unshare", "-rm", "sh", "-c", script], check=False, capture_output=True, text=True)
        if done.returncode == 77 or "unshare" in done.stderr:
            return None
        ended[_ending(done.returncode, done.stdout + done.stderr)] += 1
    return _endings(ended, f"{len(sizes)} disks")


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
    lines = [line for line in words.splitlines() if "Error:" in line or "failed:" in line]
    if status == 0:
        return "finished"
    return "one sentence" if len(lines) == 1 and any(why in lines[0] for why in NO_ROOM) else f"other: {words[-300:]}"


def _endings(ended: Counter[str], what: str) -> Said:
    words = ", ".join(f"{count} {how}" for how, count in ended.items())
    return Said(1 if ended["one sentence"] else 0, f"{what}: {words}", set(ended) <= {"finished", "one sentence"})


def laws_mutated(count: int, seed: int, folder: Path) -> Said:
    """Damage the file of a law, check the study, and fit with every law that the check lets pass."""
    from fuzzing.mutations import mutate_text
    from fuzzing.studies import LAW, checked_law, study_with_a_law

    place, ended = folder / "law", Counter[str]()
    place.mkdir()
    study_with_a_law(place)
    sound = ast.dump(ast.parse(LAW))
    for number in range(count):
        mutant = mutate_text(LAW.encode(), np.random.default_rng([seed, number]))
        (place / "our_laws.py").write_bytes(mutant)
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                law = checked_law(place)
        except VasowaveError:
            ended["refused by check"] += 1
            continue
        except Exception as error:
            ended[f"foreign in check: {type(error).__name__}: {error}"] += 1
            continue
        if ast.dump(ast.parse(mutant)) == sound:
            ended["means the same"] += 1
            continue
        ended[_fitted(law.__name__, place)] += 1
    shutil.rmtree(place)
    words = ", ".join(f"{number} {how}" for how, number in ended.items())
    good = {"refused by check", "means the same", "fitted", "refused by fit"}
    return Said(0, f"{count} mutants: {words}", set(ended) <= good)


def _fitted(name: str, place: Path) -> str:
    """Return what became of a fit with a law, in a process of its own."""
    context = multiprocessing.get_context("spawn")
    told = context.Queue()
    process = context.Process(target=_fit, args=(name, str(place), told))
    process.start()
    try:
        return str(told.get(timeout=LONGEST))
    except Empty:
        return "hang" if process.is_alive() else "crash in fit"
    finally:
        process.kill()
        process.join()


def _fit(name: str, place: str, told: Any) -> None:
    os.chdir(place)
    os.environ["NUMBA_OPT"] = "0"
    warnings.simplefilter("ignore")
    network, cycle = vw.read_network("n.csv"), vw.read_recording("0.csv", period=0.11)
    try:
        vw.calibrate(network, cycle, f"our_laws:{name}", search=vw.Search(starts=1))
        told.put("fitted")
    except VasowaveError:
        told.put("refused by fit")
    except BaseException as error:
        told.put(f"foreign in fit: {type(error).__name__}: {str(error)[:200]}")
