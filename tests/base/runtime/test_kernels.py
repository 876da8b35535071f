"""Compiled kernels: made once for all processes of a user, in a private place, never met by another source."""

import os
import pickle
import subprocess
import sys
import time
from pathlib import Path
from types import ModuleType
from typing import NamedTuple

import pytest

from vasowave.base.runtime import kept


@pytest.fixture
def place_of_kernels(tmp_path, monkeypatch):
    """The folder that a user chose for kernels."""
    import numba

    with monkeypatch.context() as patch:
        patch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "one"))
        numba.config.reload_config()
        yield tmp_path / "one"
    numba.config.reload_config()


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
