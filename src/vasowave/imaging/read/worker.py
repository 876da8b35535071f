"""The process in which compiled readers work: one image a line of its input, until the input ends.

A line holds path, bytes and seconds that may be taken; the answer is a line, then the grey levels as in memory.
"""

import json
import os
import signal
import sys
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np

from vasowave.errors import InputError
from vasowave.imaging.read.dicom import read_dicom_series
from vasowave.imaging.read.itk import read_itk
from vasowave.imaging.read.tiff import read_tiff
from vasowave.imaging.read.volume import Image


def main() -> None:
    """Answer until nobody asks any more."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for the program that waits for us
    out = os.fdopen(os.dup(sys.stdout.fileno()), "wb")
    os.dup2(sys.stderr.fileno(), sys.stdout.fileno())  # what libraries print is no answer
    for line in sys.stdin.buffer:
        answer(json.loads(line), out)


def answer(asked: dict[str, Any], out: BinaryIO) -> None:
    """Read the image that is asked for and write it to `out`, or why it cannot be read."""
    path = Path(asked["path"])
    try:
        limit(asked["bytes"], asked["seconds"])
        image = read_any(path)
    except InputError as error:
        _tell(out, {"error": str(error)})
    except MemoryError:
        _tell(out, {"memory": True})
    except Exception as error:
        _tell(out, {"error": f"{path}: not an image that can be read ({type(error).__name__}: {error})"})
    else:
        grey = np.ascontiguousarray(image.grey)
        head = {"shape": grey.shape, "type": grey.dtype.str}
        places = {name: getattr(image, name).tolist() for name in ("spacing", "origin", "axes")}
        _tell(out, head | places, grey)


def read_any(path: Path) -> Image:
    """Return the image in a file or a folder of DICOM slices."""
    if path.is_dir():
        return read_dicom_series(path)
    return read_tiff(path) if path.suffix.lower() in (".tif", ".tiff") else read_itk(path)


def limit(size: int, seconds: float) -> None:
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


def _tell(out: BinaryIO, head: dict[str, Any], values: np.ndarray | None = None) -> None:
    out.write(json.dumps(head).encode() + b"\n")
    if values is not None:
        out.write(values.reshape(-1).view(np.uint8).data)
    out.flush()


if __name__ == "__main__":
    main()
