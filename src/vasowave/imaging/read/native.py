"""Compiled readers of images, run where a crash, a hang or a lack of memory ends a helper and not the program."""

import atexit
import json
import os
import signal
import subprocess
import sys
import threading
from pathlib import Path
from typing import Any

import numpy as np

from vasowave.errors import InputError
from vasowave.imaging.read.volume import Image

MEMORY = 7 << 28
"""Bytes of addresses that reading may take beside eight times what the files are long."""

SECONDS = 15
"""Seconds of a processor that reading may take beside what grows with the files; a busy machine waits longer."""

_ALONE = dict.fromkeys(
    ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS", "ITK_GLOBAL_DEFAULT_NUMBER_OF_THREADS"), "1"
) | {"MALLOC_ARENA_MAX": "1"}  # every thread takes addresses, which are counted


def read_image(path: Path) -> Image:
    """Return the image in a file (all that SimpleITK reads, TIFF) or in a folder of DICOM slices.

    Raises
    ------
    InputError
        It cannot be read; reading ended the process, did not end, or took far more memory than the files are long.
    """
    size = sum(one.stat().st_size for one in path.iterdir() if one.is_file()) if path.is_dir() else path.stat().st_size
    with _HELPER.lock:
        return _HELPER.read(path, MEMORY + 8 * size, SECONDS + size / 2e7)


class _Helper:
    """The process that reads; started when it is first needed, and anew after it died."""

    def __init__(self) -> None:
        self.lock = threading.Lock()
        self._process: subprocess.Popen[bytes] | None = None

    def read(self, path: Path, size: int, seconds: float) -> Image:
        process = self._running()
        late = threading.Timer(8 * seconds, process.kill)
        late.start()
        try:
            return _asked(process, path, size, seconds)
        except (EOFError, BrokenPipeError):
            raise InputError(f"{path}: {_how_it_ended(process)}; the file is damaged, export it again") from None
        finally:
            late.cancel()
            if sys.exc_info()[0] not in (None, InputError) or process.poll() is not None:
                self.stop()  # also after Ctrl-C, when an answer is still on its way

    def _running(self) -> subprocess.Popen[bytes]:
        if self._process is None or self._process.poll() is not None:
            self.stop()
            command = [sys.executable, "-P", "-W", "ignore", "-m", "vasowave.imaging.read.worker"]
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


def _asked(process: subprocess.Popen[bytes], path: Path, size: int, seconds: float) -> Image:
    """Ask the process for one image; `EOFError` if it ends before it has answered."""
    assert process.stdin is not None
    assert process.stdout is not None
    process.stdin.write(json.dumps({"path": str(path.absolute()), "bytes": size, "seconds": seconds}).encode() + b"\n")
    process.stdin.flush()
    line = process.stdout.readline()
    if not line.endswith(b"\n"):
        raise EOFError
    head: dict[str, Any] = json.loads(line)
    if "memory" in head:
        raise InputError(
            f"{path}: reading it takes more than {size / 1e9:.1f} GB, far more than the file is long; it is damaged, "
            "or packed so tightly that it must be saved without compression"
        )
    if "error" in head:
        raise InputError(head["error"].replace(str(path.absolute()), str(path)))
    grey = np.empty(head["shape"], head["type"])
    rest = memoryview(grey.reshape(-1).view(np.uint8))
    while len(rest):
        count = process.stdout.readinto(rest)  # type: ignore[attr-defined]
        if not count:
            raise EOFError
        rest = rest[count:]
    spacing, origin, axes = (np.array(head[name]) for name in ("spacing", "origin", "axes"))
    return Image(grey, spacing, origin, axes)


def _how_it_ended(process: subprocess.Popen[bytes]) -> str:
    ended = -process.wait()
    slow = ended in (signal.SIGKILL, getattr(signal, "SIGXCPU", 0))
    return "reading it did not end" if slow else "reading it ended the process that read it"


_HELPER = _Helper()
atexit.register(_HELPER.stop)
