"""Ways to damage a file: as texts are damaged by people and programs, and as disks and networks damage bytes."""

import gzip
import io
import re
import zipfile
import zlib
from collections.abc import Callable

import numpy as np

from fuzzing.forms import Mutate

NASTY = (
    "", "nan", "inf", "-inf", "1e308", "-1e308", "1e999", "1_0", "0x10", "٣", "1,2,3", "1.2.3", "--1", "1 2", "#", "-1",
    "12:30:00", '"', "=1+1", "\0", "9" * 400, "*", "1e-400", "0", "2147483648", "4294967296", "99999999999", "0.5",
)  # fmt: skip
_WORD = re.compile(r"[^\s,;:|=<>\[\](){}]+")
_WORDS = (0, 1, 9, 14, 15, 255, 0x7FFFFFFF, 0xFFFFFFFF, 0x40000000, 0x00010000, 0x7F800000, 0xFFC00000)


def mutate_text(content: bytes, rng: np.random.Generator) -> bytes:
    """Lose, double, exchange or cut lines and words, or put something nasty in their place."""
    lines = content.decode().split("\n")
    at, other = (int(rng.integers(len(lines))) for _ in range(2))
    kind = int(rng.integers(12))
    if kind == 0:
        return mutate_bytes(content, rng)
    if kind == 1:
        return content[: int(rng.integers(len(content)))]
    if kind == 2:
        return "\n".join(lines[:at]).encode() + b"\n"
    if kind == 3:
        del lines[at]
    elif kind == 4:
        lines.insert(other, lines[at])
    elif kind == 5:
        lines[at], lines[other] = lines[other], lines[at]
    else:
        lines[at] = _mutated_line(lines[at], kind, rng)
    return "\n".join(lines).encode("utf-8", errors="replace")


def _mutated_line(line: str, kind: int, rng: np.random.Generator) -> str:
    words = list(_WORD.finditer(line))
    if not words:
        return line + str(rng.choice(NASTY))
    word = words[int(rng.integers(len(words)))]
    cut = int(rng.integers(len(word[0]) + 1))
    new = {
        6: str(rng.choice(NASTY)),
        7: "",
        8: f"{word[0]}{line[word.end() : word.end() + 1] or ' '}{word[0]}",
        9: word[0].replace(".", ",") if "." in word[0] else word[0].replace(",", "."),
        10: word[0][:cut],
        11: f"-{word[0]}",
    }[kind]
    return line[: word.start()] + new + line[word.end() :]


def mutate_bytes(content: bytes, rng: np.random.Generator) -> bytes:
    """Change up to four bytes."""
    damaged = bytearray(content)
    for _ in range(int(rng.integers(1, 5))):
        damaged[int(rng.integers(len(damaged)))] = int(rng.integers(256))
    return bytes(damaged)


def mutate_ends(content: bytes, rng: np.random.Generator, kind: int) -> bytes:
    """Change bytes (kind 0), cut (1), or lengthen (2)."""
    if kind == 0:
        return mutate_bytes(content, rng)
    if kind == 1:
        return content[: int(rng.integers(len(content)))]
    return content + bytes(rng.integers(0, 256, int(rng.integers(1, 5000)), dtype=np.uint8))


def mutate_binary(content: bytes, rng: np.random.Generator) -> bytes:
    """Change bytes, cut, lengthen, blank a stretch, or put a nasty number of four bytes; mostly near the beginning."""
    kind = int(rng.integers(6))
    near = int(rng.integers(min(len(content), 600) if rng.integers(4) else len(content)))
    if kind < 3:
        return mutate_ends(content, rng, kind)
    if kind == 3:
        length = int(rng.integers(1, 64))
        return (content[:near] + bytes(length) + content[near + length :])[: len(content)]
    at = near // 4 * 4 if kind == 4 else near
    order = "little" if rng.integers(2) else "big"
    return content[:at] + int(rng.choice(_WORDS)).to_bytes(4, order) + content[at + 4 :]


def mutate_mat(content: bytes, rng: np.random.Generator) -> bytes:
    kind = int(rng.integers(4))
    if kind < 2:
        return mutate_ends(content, rng, kind)
    # Tags, sizes and dimensions stand in words of four bytes, most of them near the variables' beginnings.
    damaged = bytearray(content)
    at = 128 + 4 * int(
        rng.integers(min(40, (len(content) - 132) // 4)) if kind == 2 else rng.integers(len(content) // 4)
    )
    at = min(at, len(content) - 4)
    word = int(rng.choice([0, 1, 9, 14, 15, 255, 0x7FFFFFFF, 0xFFFFFFFF, 0x40000000, 0x00010000]))
    damaged[at : at + 4] = word.to_bytes(4, "little")
    return bytes(damaged)


def with_header(end: bytes) -> Mutate:
    """Return a mutation of files whose text header ends with `end`: half of the damage falls on it."""

    def mutate(content: bytes, rng: np.random.Generator) -> bytes:
        at = content.index(end) + len(end)
        if rng.integers(2):
            return mutate_text(content[:at], rng) + content[at:]
        return mutate_binary(content, rng)

    return mutate


def inside_gzip(mutate: Mutate) -> Mutate:
    """Return a mutation that damages half of the time what is packed, half of the time the packing."""

    def packed(content: bytes, rng: np.random.Generator) -> bytes:
        if rng.integers(2):
            return mutate_binary(content, rng)
        return gzip.compress(mutate(gzip.decompress(content), rng), 1)

    return packed


def inside_zip(mutate: Mutate, main: str) -> Mutate:
    """Return a mutation that damages half of the time a packed file, mostly `main`, half of the time the archive."""

    def packed(content: bytes, rng: np.random.Generator) -> bytes:
        if rng.integers(2):
            return mutate_binary(content, rng)
        with zipfile.ZipFile(io.BytesIO(content)) as archive:
            parts = {name: archive.read(name) for name in archive.namelist()}
        chosen = (
            next(name for name in parts if name.endswith(main)) if rng.integers(4) else str(rng.choice(list(parts)))
        )
        parts[chosen] = mutate(parts[chosen], rng)
        again = io.BytesIO()
        with zipfile.ZipFile(again, "w", zipfile.ZIP_DEFLATED) as archive:
            for name, part in parts.items():
                archive.writestr(name, part)
        return again.getvalue()

    return packed


def mutate_markup(content: bytes, rng: np.random.Generator) -> bytes:
    """Damage markup as a text of one element a line."""
    return mutate_text(content.replace(b"><", b">\n<"), rng).replace(b">\n<", b"><")


def bombs(of: Callable[[int], bytes], mutate: Mutate) -> Mutate:
    """Return a mutation that, once in 500, gives a file that unpacks to 3 GB, made by `of`."""

    def mixed(content: bytes, rng: np.random.Generator) -> bytes:
        return of(3 << 30) if rng.integers(500) == 0 else mutate(content, rng)

    return mixed


def packed_zeros(size: int, window: int) -> bytes:
    """Return `size` zeros packed by zlib with a window (15: zlib, whose check sum is wrong; 31: gzip), at once."""
    piece = bytes(1 << 24)
    if window == 31:
        return gzip.compress(piece) * (size >> 24)
    engine = zlib.compressobj(9, wbits=-15)
    return b"\x78\xda" + (engine.compress(piece) + engine.flush(zlib.Z_FULL_FLUSH)) * (size >> 24) + b"\3\0" + bytes(4)
