"""Compiled kernels: made once for all processes of a user, in a private place, never met by another source."""

import os
import pickle
import platform
import shutil
import stat
import subprocess
import sys
import time
from pathlib import Path
from types import ModuleType
from typing import NamedTuple

import pytest

import vasowave
from vasowave.base.runtime import kept

SCRIPT = """
import sys, time
from numba import njit
from numba.extending import overload
from vasowave.base.runtime import kernels
kernels.inspect.getsource = lambda module: sys.argv[1]

def twice(x): ...

@overload(twice)
def compile_twice(x):
    time.sleep(4.0)  # so that processes that start together meet here
    return lambda x: 2.0 * x

@kernels.kept
@njit
def doubled(x):
    return twice(x)

assert doubled(3.0) == 6.0
print(sum(doubled.stats.cache_hits.values()), sum(doubled.stats.cache_misses.values()), doubled.stats.cache_path)
"""


def installed(folder, writable=True):
    """A copy of what keeps kernels, where nothing can be written beside it unless it is writable."""
    package = folder / "vasowave"
    (package / "base" / "runtime").mkdir(parents=True)
    source = Path(vasowave.__file__).parent
    for room in ("", "base", "base/runtime"):
        for file in (source / room).glob("*.py*"):
            shutil.copy(file, package / room)
    if not writable:
        (package / "__pycache__").write_text("a file where a folder would have to be")
        (package / "base" / "runtime" / "__pycache__").write_text("a file where a folder would have to be")
        (package / "base" / "runtime").chmod(0o555)
        package.chmod(0o555)  # for all but the administrator, to whom nothing is forbidden
    return folder


def started(folder, home, source="one", code=SCRIPT, name="script.py", **environment):
    script = home / name
    script.write_text(code)
    variables = {**os.environ, "PYTHONPATH": str(folder), "HOME": str(home), "XDG_CACHE_HOME": str(home / "cache")}
    variables.pop("NUMBA_CACHE_DIR", None)
    variables |= {"PYTHONDONTWRITEBYTECODE": "1", **environment}
    command = [sys.executable, str(script), source]
    return subprocess.Popen(command, env=variables, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


def told(process):
    out, error = process.communicate(timeout=120)
    assert process.returncode == 0, error
    hits, misses, path = out.strip().split(" ", 2)
    return int(hits), int(misses), Path(path)


@pytest.fixture(scope="module")
def sealed(tmp_path_factory):
    return installed(tmp_path_factory.mktemp("sealed"), writable=False)


@pytest.mark.validation
def test_a_read_only_installation_compiles_once_for_all_processes_and_anew_for_another_source(sealed, tmp_path):
    """Two start together: one compiles, the other waits and loads; one of another source meets none of it."""
    first, second, other = map(told, [started(sealed, tmp_path, source) for source in ("one", "one", "another")])
    assert sorted([first[:2], second[:2]]) == [(0, 1), (1, 0)]
    assert other[:2] == (0, 1)
    assert first[2] == second[2] != other[2]
    assert (tmp_path / "cache") in first[2].parents


@pytest.mark.validation
def test_kernels_for_other_arguments_are_compiled_at_the_same_time_and_all_kept(sealed, tmp_path):
    """Each compiles one of two kernels of a function, neither waits for the other, and a third process loads both."""
    head = SCRIPT.split("assert doubled")[0].replace("time.sleep(4.0)", "time.sleep(4.0); print('slept', time.time())")
    for code, count in ((head + "doubled(3.0)\n", 1), (head + "doubled(3)\n", 1), (head, 0)):
        assert code.count("doubled(3") == count
    pair = [
        started(sealed, tmp_path, code=head + f"doubled({argument})\n", name=f"{number}.py")
        for number, argument in enumerate(("3.0", "3"))
    ]
    slept = [float(process.communicate(timeout=120)[0].split()[1]) for process in pair]
    assert abs(slept[0] - slept[1]) < 4.0
    both = head + "doubled(3.0), doubled(3)\nprint(len(doubled.stats.cache_hits), 0, '.')\n"
    assert told(started(sealed, tmp_path, code=both))[0] == 2


@pytest.mark.validation
def test_where_nothing_at_all_can_be_written_every_process_compiles(sealed, tmp_path):
    (tmp_path / "cache").write_text("a file")
    code = SCRIPT.rsplit("print", 1)[0] + "print(0, 1, doubled._cache.__class__.__name__)\n"
    assert told(started(sealed, tmp_path, code=code))[2] == Path("NullCache")


@pytest.mark.validation
def test_kernels_lie_in_a_private_folder_of_the_user_also_where_the_package_could_be_written(tmp_path):
    folder, home = installed(tmp_path / "here"), tmp_path / "home"
    home.mkdir()
    place = told(started(folder, home))[2]
    assert home in place.parents
    assert stat.S_IMODE(place.stat().st_mode) == 0o700
    assert {stat.S_IMODE(one.stat().st_mode) for one in place.glob("*.kernel")} == {0o600}


def hits_and_misses(folder, home, source="one", **environment):
    """What a process in a home of its own loaded and compiled, and what it said."""
    home.mkdir()
    process = started(folder, home, source, QUICK, **environment)
    out, error = process.communicate(timeout=120)
    assert process.returncode == 0, error
    return tuple(map(int, out.split(" ", 2)[:2])), error


QUICK = SCRIPT.replace("time.sleep(4.0)", "pass")
LEVEL = {"NUMBA_CPU_NAME": "x86-64-v3", "NUMBA_CPU_FEATURES": ""}


@pytest.mark.skipif(platform.machine() != "x86_64", reason="kernels are shipped for x86-64")
@pytest.mark.validation
def test_a_kernel_that_came_with_the_package_is_loaded_where_source_and_target_are_its_own(tmp_path):
    """It was compiled for the level of processors elsewhere; a fresh home then compiles nothing and keeps nothing."""
    folder, made = installed(tmp_path / "here"), tmp_path / "made"
    assert hits_and_misses(folder, tmp_path / "builder", NUMBA_CACHE_DIR=str(made), **LEVEL)[0] == (0, 1)
    shutil.copytree(made, folder / "vasowave" / "compiled")
    (kernel,) = (folder / "vasowave" / "compiled").rglob("*.kernel")
    os.link(kernel, tmp_path / "in the installer's cache")  # as installers do
    assert hits_and_misses(folder, tmp_path / "fresh") == ((1, 0), "")
    assert not list((tmp_path / "fresh").rglob("*.kernel"))
    assert hits_and_misses(folder, tmp_path / "changed", "another")[0] == (0, 1)
    assert hits_and_misses(folder, tmp_path / "asked", NUMBA_CPU_NAME="x86-64-v2")[0] == (0, 1)
    assert hits_and_misses(folder, tmp_path / "older", NUMBA_ENABLE_AVX="0")[0] == (0, 1)
    (closed := tmp_path / "closed.file").write_text("no folder can be made here")
    assert hits_and_misses(folder, tmp_path / "closed", XDG_CACHE_HOME=str(closed))[0] == (1, 0)
    kernel.write_bytes(kernel.read_bytes()[:-1])
    counts, error = hits_and_misses(folder, tmp_path / "damaged")
    assert counts == (0, 1)
    assert "a compiled function was damaged; it is compiled anew" in error


@pytest.fixture
def place_of_kernels(tmp_path, monkeypatch):
    """The folder that a user chose for kernels."""
    import numba

    with monkeypatch.context() as patch:
        patch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "one"))
        numba.config.reload_config()
        yield tmp_path / "one"
    numba.config.reload_config()


@pytest.mark.skipif(os.name == "nt", reason="Windows has no modes")
@pytest.mark.parametrize("fault", ["open to a group", "a link", "a file"])
def test_a_folder_that_others_may_write_to_is_not_used(place_of_kernels, tmp_path, monkeypatch, fault):
    from numba import njit

    from vasowave.base.runtime import kernels

    def folder():
        return Path(kernels.kept(njit(lambda x: x)).stats.cache_path)

    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "other"))
    place = folder()
    assert place.parent == place_of_kernels
    if fault == "open to a group":
        place.chmod(0o770)
    else:
        place.rmdir()
        (tmp_path / "elsewhere").mkdir(mode=0o700)
        place.symlink_to(tmp_path / "elsewhere") if fault == "a link" else place.write_text("")
    assert folder().parent == tmp_path / "other" / "vasowave"


@pytest.fixture
def thrice(place_of_kernels):
    """A kernel that was compiled and kept: what compiles or loads it anew, and its file."""
    from numba import njit

    from vasowave.base.runtime import kernels

    def tripled(x):
        return 3.0 * x

    def again():
        taken = kernels.kept(njit(tripled))
        assert taken(2.0) == 6.0
        return sum(taken.stats.cache_hits.values())

    assert [again(), again()] == [0, 1]
    (file,) = place_of_kernels.rglob("*.kernel")
    return again, file


DAMAGES = {
    "a byte flipped": lambda content: content[:5000] + bytes([content[5000] ^ 1]) + content[5001:],
    "a byte of the check sum flipped": lambda content: bytes([content[0] ^ 128]) + content[1:],
    "cut": lambda content: content[:-1],
    "empty": lambda content: b"",
    "longer": lambda content: content + b"\0",
    "nothing that can be unpickled": b"no",
}


@pytest.mark.parametrize("damage", DAMAGES)
def test_a_damaged_kernel_is_said_once_and_compiled_anew(thrice, damage, caplog):
    again, file = thrice
    made = DAMAGES[damage]
    kept.keep(file, file.name, made) if isinstance(made, bytes) else file.write_bytes(made(file.read_bytes()))
    assert [again(), again()] == [0, 1]
    assert [record.getMessage() for record in caplog.records] == [
        f"{file}: a compiled function was damaged; it is compiled anew."
    ]


class Hostile:
    """Makes a file when it is unpickled."""

    def __init__(self, trace):
        self.trace = trace

    def __reduce__(self):
        return Path.touch, (self.trace,)


@pytest.mark.skipif(os.name == "nt", reason="Windows has no modes")
@pytest.mark.parametrize(("mode", "run"), [(0o620, False), (0o600, True)])
def test_a_kernel_that_others_may_write_to_is_not_unpickled(thrice, tmp_path, mode, run):
    """What only the user can have written is trusted, and would run."""
    again, file = thrice
    kept.keep(file, file.name, pickle.dumps(Hostile(tmp_path / "was here")))
    file.chmod(mode)
    assert again() == 0
    assert (tmp_path / "was here").exists() is run


def test_a_compilation_that_fails_keeps_nobody_waiting(place_of_kernels):
    """The lock of the failed one is let go of before the next is asked for."""
    from numba import njit
    from numba.core.errors import TypingError

    from vasowave.base.runtime import kernels

    def first(x):
        return x[0]

    taken = kernels.kept(njit(first))
    began = time.monotonic()
    for _ in range(2):
        with pytest.raises(TypingError):
            taken(1.0)
    assert taken((1.0, 2.0)) == 1.0
    assert time.monotonic() - began < 20.0


def test_a_kernel_for_a_class_from_elsewhere_is_compiled_in_every_process(thrice):
    """Its source is not in the folder's name: a changed class of the same name would meet the kernel of the old one."""
    from numba import njit

    from vasowave.base.runtime import kernels

    def first(pair):
        return pair[0]

    class Pair(NamedTuple):
        one: float
        other: float

    _, file = thrice
    for pair in (Pair(1.0, 2.0), (0, Pair(1.0, 2.0))):
        kernels.kept(njit(first))(pair)
    assert [one.name for one in file.parents[1].rglob("*.kernel")] == [file.name]
    kernels.kept(njit(first))((1.0, 2.0))
    assert len(list(file.parents[1].rglob("*.kernel"))) == 2


PAIR = "from typing import NamedTuple\nclass Pair(NamedTuple):\n    one: float\n    other: float\n"


def test_a_kernel_for_a_law_of_a_file_is_kept_by_the_content_of_the_file_unless_it_uses_what_could_change(thrice):
    from numba import njit

    from vasowave.base.runtime import kernels

    def first(pair):
        return pair[0]

    def used(name, source):
        module = sys.modules[name] = ModuleType(name)
        exec(source, vars(module))
        taken = kernels.kept(njit(first))
        assert taken(module.Pair(1.0, 2.0)) == 1.0
        del sys.modules[name]
        return sum(taken.stats.cache_hits.values()), len(list(file.parents[1].rglob("*.kernel")))

    _, file = thrice
    assert used("vasowave_law_0123", PAIR) == (0, 2)
    assert used("vasowave_law_0123", PAIR) == (1, 2)
    assert used("vasowave_law_4567", PAIR) == (0, 3)  # another content
    assert used("vasowave_law_89ab", f"from scipy.special import erf\n{PAIR}") == (0, 3)
    assert used("vasowave_law_89ab", f"import scipy\n{PAIR}") == (0, 3)


@pytest.mark.validation
def test_an_analysis_asks_for_no_kernel_that_was_not_compiled_beforehand():
    code = """
import vasowave as vw
from vasowave.pulse.noise import arma
from vasowave.base.runtime.kernels import seconds_compiling
from vasowave.pulse.solver.ready import compile_kernels
mouse = vw.virtual_mouse()
compile_kernels("linear")
arma.compile_kernels()
before = seconds_compiling()
vw.analyze(vw.Animal("m", "CTL", vw.control_network(), mouse), vw.Settings(walls=("linear",), starts=1))
print(before > 0.0, seconds_compiling() - before)
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, timeout=300)
    assert done.stdout == "True 0.0\n"
