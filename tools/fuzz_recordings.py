"""Damage recordings of every format in ways their structure suggests, and count what the readers make of them.

uv run python tools/fuzz_recordings.py                   200 mutants of every format
uv run python tools/fuzz_recordings.py 2000 --seed 7     2000 of every format
uv run python tools/fuzz_recordings.py 50 --format edf   one format

Outcomes: refused (an error of ours), told (read, and a warning or a note says something), same (read, nothing changed),
other values (numbers changed without a word), cut between lines (a text that ends earlier, whole to its last line:
nothing in it tells), other structure (count of samples, rate or channels changed without a word), foreign (an exception
that is not ours), hang (longer than 20 s). Exit code 1: a foreign exception or a hang.
"""

import argparse
import contextlib
import resource
import signal
import sys
import tempfile
import warnings
from collections import Counter
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np
from scipy.io import savemat

from vasowave.errors import VasowaveError, VasowaveWarning
from vasowave.recording import read_raw_recording, read_recording

OUTCOMES = ("refused", "told", "same", "other values", "cut between lines", "other structure", "foreign", "hang")
LONGEST = 20  # s
RATE, COUNT = 1000.0, 1500
TIME = np.arange(COUNT) / RATE
WAVE = np.sin(2 * np.pi * 9 * TIME)
SIGNALS = {"pressure": 14 + 5 * WAVE, "flow": 0.2 + 0.2 * WAVE, "ecg": np.cos(2 * np.pi * 9 * TIME) ** 31}
PHASE = np.arange(128) / 128
CYCLE = (0.11 * PHASE, 14 + 4 * np.sin(2 * np.pi * PHASE), 0.18 + 0.2 * np.sin(2 * np.pi * PHASE))
NASTY = (
    "", "nan", "inf", "-inf", "1e308", "-1e308", "1e999", "1_0", "0x10", "٣", "1,2,3", "1.2.3", "--1", "1 2", "#",
    "12:30:00", '"', "=1+1", "\0", "9" * 400, "*", "1e-400",
)  # fmt: skip


class Format(NamedTuple):
    """How a sound file is made, damaged and read."""

    suffix: str
    write: Callable[[Path], object]
    mutate: Callable[[bytes, np.random.Generator], bytes]
    read: Callable


def rows(separator: str, decimal: str, *columns: np.ndarray) -> str:
    text = "\n".join(separator.join(f"{value:.6f}" for value in row) for row in zip(*columns, strict=True)) + "\n"
    return text.replace(".", decimal)


def table(separator: str, decimal: str) -> Callable[[Path], object]:
    head = separator.join(["time [s]", "pressure [mmHg]", "flow [ml/s]", "ecg [mV]"]) + "\n"
    return lambda path: path.write_text(head + rows(separator, decimal, TIME, *SIGNALS.values()))


def labchart_text(path: Path) -> None:
    head = (
        "Interval=\t0.001 s\nTimeFormat=\tStartOfBlock\nChannelTitle=\tPAP\tFlow\tECG\n"
        "Range=\t50 mmHg\t10 ml/s\t2 mV\nUnitName=\tmmHg\tml/s\tmV\n"
    )
    path.write_text(head + rows("\t", ".", TIME, *SIGNALS.values()).replace("\n", "\t#* start\n", 1))


def labchart_mat(path: Path) -> None:
    ends = COUNT * np.arange(1.0, 4.0)[:, None]
    variables = {
        "data": np.concatenate(list(SIGNALS.values()))[None, :], "datastart": ends - COUNT + 1, "dataend": ends,
        "titles": np.array(["PAP ", "Flow", "ECG "]), "samplerate": np.full((3, 1), RATE),
        "unittext": np.array(["mmHg", "ml/s", "mV  "]), "unittextmap": np.array([[1.0], [2.0], [3.0]]),
        "tickrate": np.array([[RATE]]), "com": np.array([[-1.0, 1, 20, 1, 1]]), "comtext": np.array(["start"]),
    }  # fmt: skip
    savemat(path, variables)


def edf(path: Path) -> None:
    count, records = len(SIGNALS), COUNT // 500
    ranges = {"pressure": ("mmHg", -10, 60), "flow": ("ml/s", -1, 2), "ecg": ("mV", -2, 2)}

    def field(values: list, width: int) -> bytes:
        return b"".join(str(value).encode().ljust(width)[:width] for value in values)

    header = b"0".ljust(8) + b"X".ljust(80) * 2 + b"01.01.2001.01.01" + str(256 * (count + 1)).encode().ljust(8)
    header += b" " * 44 + str(records).encode().ljust(8) + b"0.5".ljust(8) + str(count).encode().ljust(4)
    low, high = [r[1] for r in ranges.values()], [r[2] for r in ranges.values()]
    header += field(list(ranges), 16) + b" " * 80 * count + field([r[0] for r in ranges.values()], 8)
    header += field(low, 8) + field(high, 8) + field([-32768] * count, 8) + field([32767] * count, 8)
    header += b" " * 80 * count + field([500] * count, 8) + b" " * 32 * count
    digital = [np.rint((v - a) / (b - a) * 65535 - 32768) for v, a, b in zip(SIGNALS.values(), low, high, strict=True)]
    samples = np.stack([one.reshape(records, 500) for one in digital], axis=1)
    path.write_bytes(header + samples.astype("<i2").tobytes())


def cycle_table(path: Path) -> None:
    path.write_text("time [s],pressure [mmHg],flow [ml/s]\n" + rows(",", ".", *CYCLE))


def cycle_mat(path: Path) -> None:
    savemat(path, dict(zip("tpq", CYCLE, strict=True)), do_compression=True)


def mutate_text(content: bytes, rng: np.random.Generator) -> bytes:
    lines = content.decode().split("\n")
    at, other = (int(rng.integers(len(lines))) for _ in range(2))
    mark = next(sign for sign in ("\t", ";", ",") if sign in lines[-2])
    cells = lines[at].split(mark)
    cell = int(rng.integers(len(cells)))
    kind = int(rng.integers(14))
    if kind == 0:
        return mutate_bytes(content, rng)
    if kind == 1:
        del lines[at]
    elif kind == 2:
        lines.insert(other, lines[at])
    elif kind == 3:
        lines[at], lines[other] = lines[other], lines[at]
    elif kind in (4, 5):
        cells[cell] = NASTY[int(rng.integers(len(NASTY)))]
    elif kind == 6:
        del cells[cell]
    elif kind == 7:
        cells.insert(cell, cells[cell])
    elif kind == 8:
        cells[cell] = cells[cell].replace(".", ",") if "." in cells[cell] else cells[cell].replace(",", ".")
    elif kind == 9:
        return "\n".join(lines)[: int(rng.integers(len(content)))].encode()
    elif kind == 10:
        return "\n".join(lines[:at]).encode() + b"\n"
    elif kind == 11:
        lines[at] = lines[at].replace(mark, str(rng.choice(["\t", ";", ",", " ", "|"])))
    elif kind == 12:
        lines[0], lines[1] = lines[int(rng.integers(min(7, len(lines))))], lines[0]
    else:
        cells[cell] = cells[cell][: int(rng.integers(len(cells[cell]) + 1))]
    if kind in (4, 5, 6, 7, 8, 13):
        lines[at] = mark.join(cells)
    return "\n".join(lines).encode("utf-8", errors="replace")


def mutate_bytes(content: bytes, rng: np.random.Generator) -> bytes:
    damaged = bytearray(content)
    for _ in range(int(rng.integers(1, 5))):
        at = int(rng.integers(len(damaged)))
        damaged[at] = int(rng.integers(256))
    return bytes(damaged)


def mutate_edf(content: bytes, rng: np.random.Generator) -> bytes:
    kind = int(rng.integers(4))
    damaged = bytearray(content)
    if kind == 0:
        return mutate_bytes(content, rng)
    if kind == 1:
        return content[: int(rng.integers(len(content)))]
    if kind == 2:
        return content + bytes(rng.integers(0, 256, int(rng.integers(1, 5000)), dtype=np.uint8))
    field = str(rng.choice(["-1", "0", "1", "nan", "1e9", "99999999", "3.5", "-32769", "", "1E308", "2147483648"]))
    starts = [0, 184, 236, 244, 252, *range(256 + 3 * 96, 256 + 3 * 136, 8), *range(256 + 3 * 216, 256 + 3 * 224, 8)]
    at = int(rng.choice(starts))
    damaged[at : at + 8] = field.encode().ljust(8)[:8]
    return bytes(damaged)


def mutate_mat(content: bytes, rng: np.random.Generator) -> bytes:
    kind = int(rng.integers(4))
    if kind == 0:
        return mutate_bytes(content, rng)
    if kind == 1:
        return content[: int(rng.integers(len(content)))]
    # Tags, sizes and dimensions stand in words of four bytes, most of them near the variables' beginnings.
    damaged = bytearray(content)
    at = 128 + 4 * int(
        rng.integers(min(40, (len(content) - 132) // 4)) if kind == 2 else rng.integers(len(content) // 4)
    )
    at = min(at, len(content) - 4)
    word = int(rng.choice([0, 1, 9, 14, 15, 255, 0x7FFFFFFF, 0xFFFFFFFF, 0x40000000, 0x00010000]))
    damaged[at : at + 4] = word.to_bytes(4, "little")
    return bytes(damaged)


FORMATS = {
    "table, commas": Format(".csv", table(",", "."), mutate_text, read_raw_recording),
    "table, decimal commas": Format(".csv", table(";", ","), mutate_text, read_raw_recording),
    "labchart text": Format(".txt", labchart_text, mutate_text, read_raw_recording),
    "labchart mat": Format(".mat", labchart_mat, mutate_mat, read_raw_recording),
    "edf": Format(".edf", edf, mutate_edf, read_raw_recording),
    "cycle table": Format(".csv", cycle_table, mutate_text, read_recording),
    "cycle mat": Format(".mat", cycle_mat, mutate_mat, read_recording),
}


@contextlib.contextmanager
def at_most(seconds: int) -> Iterator[None]:
    def stop(*_: object) -> None:
        raise TimeoutError

    before = signal.signal(signal.SIGALRM, stop)
    signal.alarm(seconds)
    try:
        yield
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, before)


def outcome(form: Format, path: Path, sound: object) -> str:
    """Return what became of one file, compared with the sound one."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        try:
            with at_most(LONGEST):
                found = form.read(path)
        except VasowaveError:
            return "refused"
        except TimeoutError:
            return "hang"
        except Exception as error:
            print(f"{path.name}: {type(error).__name__}: {error}", file=sys.stderr)
            return "foreign"
    said = [one for one in caught if issubclass(one.category, VasowaveWarning)] or set(found.notes) - set(sound.notes)
    if said:
        return "told"
    if structure(found) != structure(sound):
        return "other structure"
    same = all(np.array_equal(getattr(found, n), getattr(sound, n)) for n in ("pressure", "flow"))
    return "same" if same else "other values"


def structure(recording: object) -> tuple:
    rate = getattr(recording, "sampling_rate", None) or round(recording.period, 6)
    return len(recording.pressure), len(recording.flow), round(rate, 6), getattr(recording, "ecg", None) is None


def fuzz(name: str, count: int, seed: int, folder: Path, keep: Path | None = None) -> Counter:
    """Return how often each outcome occurred among `count` mutants of one format."""
    form, found = FORMATS[name], Counter()
    sound = folder / f"sound{form.suffix}"
    form.write(sound)
    content, read = sound.read_bytes(), form.read(sound)
    for number in range(count):
        rng = np.random.default_rng([seed, number, list(FORMATS).index(name)])
        path = folder / f"mutant{number}{form.suffix}"
        path.write_bytes(form.mutate(content, rng))
        became = outcome(form, path, read)
        if became == "other structure" and form.mutate is mutate_text and content.startswith(path.read_bytes()):
            became = "cut between lines"
        found[became] += 1
        if keep and became in ("foreign", "hang", "other structure"):
            path.rename(keep / f"{name} {became} {number}{form.suffix}")
        else:
            path.unlink()
    return found


def main() -> int:
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("count", type=int, nargs="?", default=200)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--format", choices=list(FORMATS))
    parser.add_argument("--keep", type=Path, help="folder for mutants with outcomes that need a look")
    arguments = parser.parse_args()
    total = Counter()
    print("| format | mutants | " + " | ".join(OUTCOMES) + " |\n|" + "---|" * (len(OUTCOMES) + 2))
    for name in [arguments.format] if arguments.format else FORMATS:
        with tempfile.TemporaryDirectory() as folder:
            found = fuzz(name, arguments.count, arguments.seed, Path(folder), arguments.keep)
        print(f"| {name} | {arguments.count} | " + " | ".join(str(found[o]) for o in OUTCOMES) + " |", flush=True)
        total += found
    own, theirs = (resource.getrusage(who).ru_maxrss / 1e6 for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
    print(f"\nlargest memory: {own:.2f} GB, in the trial of MATLAB files {theirs:.2f} GB")
    return 1 if total["foreign"] or total["hang"] else 0


if __name__ == "__main__":
    sys.exit(main())
