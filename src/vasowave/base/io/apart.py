"""Readers of what may be damaged, run where a crash, a hang or a lack of memory ends a helper and not the program.

The helper is this module, started as a program: it reads one file a line of its input until the input ends. A line
holds the reader, the path, and the bytes and seconds that may be taken; the answer is a line, then the arrays as in
memory.
"""

import atexit
import json
import os
import signal
import subprocess
import sys
import threading
from collections.abc import Callable, Sequence
from importlib import import_module
from pathlib import Path
from typing import Any, BinaryIO, NamedTuple

import numpy as np

from vasowave.base.errors import InputError
from vasowave.base.stores import parsed

MEMORY = 7 << 28
"""Bytes of addresses that reading may take beside eight times what the files are long."""

SECONDS = 15
"""Seconds of a processor that reading may take beside what grows with the files; a busy machine waits longer."""

_MOST = 1 << 42  # bytes of a file or folder; of what a damaged header announces nobody waits for more
_KINDS = "biufcU"  # of arrays that a helper may give; none of them can hold a program
_ALONE = dict.fromkeys(
    ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS", "ITK_GLOBAL_DEFAULT_NUMBER_OF_THREADS"), "1"
) | {"MALLOC_ARENA_MAX": "1"}  # every thread takes addresses, which are counted


class ReaderAnswer(NamedTuple):
    """What a reader found: anything that JSON can hold, and arrays."""

    head: Any
    arrays: Sequence[np.ndarray]


def read_apart(
    reader: Callable[[Path], ReaderAnswer], path: Path, kind: str, again: str = "export it again", content: int = 0
) -> ReaderAnswer:
    """Return what a reader, a function of a module, finds in a file or folder; it runs in another process.

    Parameters
    ----------
    reader : callable
    path : Path
    kind : str
        What the file should be, for messages: ``a MATLAB file``.
    again : str
        How to get a sound one.
    content : int
        Bytes that its header announces and that may stand elsewhere or packed.

    Raises
    ------
    InputError
        The reader's own; any other error; reading ended the process, did not end, or took far more memory than the file
        is long.
    """
    size = (
        sum(entry.stat().st_size for entry in path.iterdir() if entry.is_file())
        if path.is_dir()
        else path.stat().st_size
    )
    size = min(max(size, content), _MOST)
    with _HELPER.lock:
        try:
            return _HELPER.read(reader, path, MEMORY + 8 * size, SECONDS + size / 2e7)
        except _NotReadError as error:
            raise InputError(f"{path}: truncated, damaged, or not {kind} ({error}); {again}") from None


class _NotReadError(Exception):
    """Why a reader found nothing."""


class _Helper:
    """The process that reads; started when it is first needed, and anew after it died."""

    def __init__(self) -> None:
        self.lock = threading.Lock()
        self._process: subprocess.Popen[bytes] | None = None

    def read(self, reader: Callable[[Path], ReaderAnswer], path: Path, size: int, seconds: float) -> ReaderAnswer:
        process = self._running()
        late = threading.Timer(8 * seconds, process.kill)
        late.start()
        try:
            return _asked(process, reader, path, size, seconds)
        except (EOFError, BrokenPipeError):
            raise _NotReadError(_how_it_ended(process)) from None
        finally:
            late.cancel()
            if sys.exc_info()[0] not in (None, InputError, _NotReadError) or process.poll() is not None:
                self.stop()  # also after Ctrl-C, when an answer is still on its way

    def _running(self) -> "subprocess.Popen[bytes]":
        if self._process is None or self._process.poll() is not None:
            self.stop()
            command = [sys.executable, "-P", "-W", "ignore", "-m", "vasowave.base.io.apart"]
            pipe, nowhere = subprocess.PIPE, subprocess.DEVNULL
            self._process = subprocess.Popen(
                command, stdin=pipe, stdout=pipe, stderr=nowhere, env=os.environ | _ALONE, bufsize=-1
            )
        return self._process

    def stop(self) -> None:
        """End the process, if there is one."""
        process, self._process = self._process, None
        if process is not None:
            process.kill()
            process.communicate()


def _asked(
    process: "subprocess.Popen[bytes]", reader: Callable[[Path], ReaderAnswer], path: Path, size: int, seconds: float
) -> ReaderAnswer:
    """Ask the process for one file; `EOFError` if it ends before it has answered."""
    assert process.stdin is not None
    assert process.stdout is not None
    request = {"reader": [reader.__module__, reader.__name__], "path": str(path.absolute()), "bytes": size,
             "seconds": seconds}  # fmt: skip
    process.stdin.write(json.dumps(request).encode() + b"\n")
    process.stdin.flush()
    line = process.stdout.readline()
    if not line.endswith(b"\n"):
        raise EOFError
    answer: dict[str, Any] = parsed(line)
    if "error" in answer:
        raise InputError(answer["error"].replace(str(path.absolute()), str(path)))
    if "damage" in answer:
        raise _NotReadError(answer["damage"].replace(str(path.absolute()), str(path)))
    forms = [(tuple(shape), np.dtype(kind)) for shape, kind in answer.get("arrays", [])]
    if "memory" in answer or sum(int(np.prod(shape)) * kind.itemsize for shape, kind in forms) > size:
        if forms:  # which nobody takes from the pipe
            process.kill()
        raise InputError(
            f"{path}: reading it takes more than {size / 1e9:.1f} GB, far more memory than the file is long; it is "
            "damaged, or packed so tightly that it must be saved without compression"
        )
    return ReaderAnswer(answer["head"], [_received(process.stdout, *form) for form in forms])


def _received(pipe: Any, shape: tuple[int, ...], kind: np.dtype) -> np.ndarray:
    if kind.kind not in _KINDS:
        raise EOFError
    values = np.empty(shape, kind)
    remainder = memoryview(values.reshape(-1).view(np.uint8)) if values.size else memoryview(b"")
    while len(remainder):
        if not (count := pipe.readinto(remainder)):
            raise EOFError
        remainder = remainder[count:]
    return values


def _how_it_ended(process: "subprocess.Popen[bytes]") -> str:
    ended = -process.wait()
    slow = ended in (signal.SIGKILL, getattr(signal, "SIGXCPU", 0))
    return "reading it did not end" if slow else "reading it ended the process that read it"


_HELPER = _Helper()
atexit.register(_HELPER.stop)


def main() -> None:
    """Answer until nobody asks any more."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for the program that waits for us
    out = os.fdopen(os.dup(sys.stdout.fileno()), "wb")
    os.dup2(sys.stderr.fileno(), sys.stdout.fileno())  # what libraries print is no answer
    for line in sys.stdin.buffer:
        _answer(parsed(line), out)


def _answer(request: dict[str, Any], out: BinaryIO) -> None:
    """Read the file that is asked for and write what it holds to `out`, or why it cannot be read."""
    arrays: Sequence[np.ndarray] = ()
    try:
        _limit(request["bytes"], request["seconds"])
        module, name = request["reader"]
        head, arrays = getattr(import_module(module), name)(Path(request["path"]))
        arrays = [np.ascontiguousarray(array) for array in arrays]
        answer = {"head": head, "arrays": [[array.shape, array.dtype.str] for array in arrays]}
    except InputError as error:
        answer = {"error": str(error)}
    except MemoryError:
        answer = {"memory": True}
    except Exception as error:
        answer = {"damage": f"{type(error).__name__}: {error}"}
    out.write(json.dumps(answer).encode() + b"\n")
    for array in arrays if "head" in answer else ():
        if array.size:
            out.write(array.reshape(-1).view(np.uint8).data)
    out.flush()


def _limit(size: int, seconds: float) -> None:
    """Let this process have `size` bytes of addresses, and `seconds` more of a processor, where the system can."""
    try:
        import resource
    except ImportError:
        return
    used = sum(resource.getrusage(resource.RUSAGE_SELF)[:2])
    for kind, value in ((resource.RLIMIT_CPU, int(used + seconds) + 1), (resource.RLIMIT_AS, size)):
        try:
            hard = resource.getrlimit(kind)[1]
            resource.setrlimit(kind, (value if hard == resource.RLIM_INFINITY else min(value, hard), hard))
        except (ValueError, OSError):
            continue


if __name__ == "__main__":
    main()
