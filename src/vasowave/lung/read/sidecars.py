"""What scanners write beside an image as text: keys, values, and among them the size of a voxel."""

import re
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from vasowave.base.cures import VOXEL
from vasowave.base.errors import InputError
from vasowave.base.io.textfile import read_start
from vasowave.lung.read.payload import centimeters

SIDECARS = (".log", ".txt", ".pca", ".pcr", ".vgi", ".xtekct", ".info", ".nfo", ".ini", "visu_pars", "reco", "procs")
"""Endings of texts that scanners and reconstructions write beside slices."""
_MAX_BYTES = 1 << 20
"""Nothing beyond is looked at."""
_BARE = r"(?:(?<=\w_[xyz])|(?<=_type)|(?<=_size)|(?<=_dimension)) (?=[^=:\t\[(]*$)"  # a blank in place of a sign
_ENTRY = re.compile(rf"(.+?)\s*(?:=|:|\t|\s{{2,}}|{_BARE})\s*(.*)")
_NAMED = r"(?:pixel|voxel)[ _]?size"
_IN_UNIT = r"(?:[ _]?[\[(]?([µμa-z]+)[\])]?)?"
_EVERY_AXIS = r"pixel_size_[xyz]"
"""Keys of which every axis has one, also where voxels are cubes."""
RANKS = (
    r"voxelsizerec", r"geometry/resolution", r"el_size_mm", r"[xyz]?voxelsize[xyz]?", _EVERY_AXIS,
    rf"{_NAMED}{_IN_UNIT}", rf"(?:image|reconstructed|result) {_NAMED}{_IN_UNIT}", rf"scaled image {_NAMED}{_IN_UNIT}",
)  # fmt: skip
"""Keys that hold the size of a voxel, what was reconstructed before what was acquired (datos|x; VGStudio; Scanco;
Nikon, datos|x, MicroView and PyHST; Inveon; NRecon and others)."""


def read_fields(path: Path) -> dict[str, str]:
    """Return the entries of a text as keys, in lower case, with their section before a slash, and values."""
    fields: dict[str, str] = {}
    section = ""
    for line in read_start(path, _MAX_BYTES).decode("latin-1").replace("\xc2\xb5", "µ").splitlines():
        line = line.strip().removeprefix("!>").strip()
        if heading := re.fullmatch(r"\[(.+)\]", line):
            section = f"{heading[1].strip().lower()}/"
        elif entry := _ENTRY.fullmatch(line):
            fields.setdefault(f"{section}{re.sub(' +', ' ', entry[1].strip().lower())}", entry[2].strip())
    return fields


def voxel_size_in(texts: Sequence[Mapping[str, str]], source: Path) -> tuple[np.ndarray, str] | None:
    """Return a voxel's size, z, y, x, cm, and the keys that say it; None where none does.

    Raises
    ------
    InputError
        Two entries of the same rank contradict each other.
    """
    entries = [(key, value, fields) for fields in texts for key, value in fields.items()]
    for rule in RANKS:
        sizes = [
            (size, key)
            for key, value, fields in entries
            if (match := re.fullmatch(rule, key if "/" in rule else key.rpartition("/")[2]))
            and (size := _size(match, key, value, fields)) is not None
        ]
        if not sizes:
            continue
        merged = _merged([size for size, _ in sizes], source)
        if rule != _EVERY_AXIS:
            merged = _cubic(merged)
        elif np.isnan(merged).any():
            return None
        if np.isfinite(merged).all():
            step = section_step(texts)
            name = ", ".join(dict.fromkeys(key.rpartition("/")[2] for _, key in sizes))
            steps = f" and its 'Section to Section Step' of {step}" if step > 1 else ""
            return merged[::-1] * [step, 1, 1], f"'{name}' beside it{steps}"
    return None


def section_step(texts: Sequence[Mapping[str, str]]) -> int:
    """Return how many voxels lie between a slice and the next: NRecon may write each second one, or fewer."""
    values = (value for fields in texts for key, value in fields.items() if key.endswith("section to section step"))
    return next((int(value) for value in values if value.isdigit() and int(value) > 0), 1)


def _merged(sizes: list[np.ndarray], source: Path) -> np.ndarray:
    """Return one size, x, y, z, of several that may each leave axes open."""
    merged = np.full(3, np.nan)
    for size in sizes:
        shared = np.isfinite(merged) & np.isfinite(size)
        if not np.allclose(merged[shared], size[shared], rtol=1e-3):
            first, second = (", ".join(f"{1e4 * length:.6g}" for length in row) for row in (merged, size))
            raise InputError(
                f"{source}: the texts beside it name two sizes of a voxel ({first} and {second} µm); keep the right "
                "one, or give it",
                [VOXEL],
            )
        merged = np.where(np.isfinite(size), size, merged)
    return merged


def _cubic(size: np.ndarray) -> np.ndarray:
    """Return a size, x, y, z, whose z is that of x and y where these are one: cone beams reconstruct cubes."""
    is_flat = np.isfinite(size[:2]).all() and np.isnan(size[2]) and np.isclose(size[0], size[1], rtol=1e-3)
    return np.append(size[:2], size[0]) if is_flat else size


def _size(match: re.Match[str], key: str, value: str, fields: Mapping[str, str]) -> np.ndarray | None:
    """Return the size that an entry says, x, y, z, cm, NaN for axes that it leaves open."""
    numbers = [float(word) for word in re.findall(r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?", value)]
    if len(numbers) not in (1, 3) or not all(0 < number < 1e6 for number in numbers):
        return None
    name = key.rpartition("/")[2]
    trailing = re.search(r"([µμa-z]+)\s*$", value.lower())
    if "resolution" in name:
        unit = centimeters(fields.get("geometry/unit", ""))
    elif name.startswith("voxelsize") and any(field.endswith("num_x") for field in fields):
        unit = centimeters("um")  # PyHST
    elif re.fullmatch("pixel_size_[xyz]", name):  # Inveon, mm; others write their unit behind it
        unit = centimeters(trailing[1] if trailing else "mm")
    elif re.fullmatch("voxelsizerec|el_size_mm|[xyz]?voxelsize[xyz]?", name):
        unit = centimeters("mm")
    else:
        unit = centimeters((match[1] if match.lastindex else "") or (trailing[1] if trailing else ""))
    if not unit:
        return None
    axis = re.fullmatch("([xyz])voxelsize|(?:voxelsize|pixel_size_)([xyz])", name)
    if axis is not None and len(numbers) > 1:
        return None
    if axis is None:
        return np.broadcast_to(np.array(numbers) * unit, 3)
    size = np.full(3, np.nan)
    size["xyz".index(axis[1] or axis[2])] = numbers[0] * unit
    return size
