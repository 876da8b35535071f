"""Voxels that lie in a file as in memory: of raw files with a header of their scanner beside them, of NumPy."""

import re
from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple

import numpy as np

from vasowave.base.errors import InputError
from vasowave.base.io.textfile import regular_file
from vasowave.lung.read.formats import VOLUMES, VolumeFormat
from vasowave.lung.read.payload import data_file, require_bytes
from vasowave.lung.read.sidecars import read_fields, voxel_size_in
from vasowave.lung.read.volume import UNSIZED, Image

MAPPED_BYTES = 1 << 31
"""Longer files stay on the disk until their voxels are asked for."""


class RawVoxels(NamedTuple):
    """Where voxels lie in a file, x fastest; spacing, provenance and origin as in `Image`."""

    file: Path
    start: int
    shape: tuple[int, int, int]
    kind: np.dtype
    spacing: np.ndarray
    provenance: str
    origin: np.ndarray = np.zeros(3)

    def image(self, padded: bool = False) -> Image:
        """Return the image; `InputError` unless just its voxels are there, or more where a file may be padded."""
        if min(self.shape) < 1:
            raise InputError(f"{self.file}: its header announces {self.shape} voxels; export it again")
        count = int(np.prod(self.shape, dtype=object)) * self.kind.itemsize
        if not padded or self.file.stat().st_size < self.start + count:
            require_bytes(self.file, self.start, count)
        grey: np.ndarray = np.memmap(self.file, self.kind, "r", self.start, self.shape)
        if count < MAPPED_BYTES:
            grey = np.array(grey)
        return Image(grey, self.spacing, self.origin, provenance=self.provenance)


HEADERS = (".img.hdr", ".vgi", ".pcr", ".xtekct", ".vol.info", ".raw.info", ".nfo")
"""Endings of the headers beside raw voxels, the one that says most first."""
DATA = (".vol", ".raw", ".img")
"""Endings of files of voxels that say nothing about themselves."""
_PCR_TYPES = {"1": "u1", "5": "u2", "10": "f4"}  # datos|x
# MicroView's manual, app. C
_NFO_TYPES = {"2": "i1", "3": "u1", "4": "i2", "5": "u2", "8": "i4", "9": "u4", "10": "f4"}
_INVEON_TYPES = {"1": "<i1", "2": "<i2", "3": "<i4", "4": "<f4", "5": ">f4", "6": ">i2", "7": ">i4"}
_WIDTHS = {1: "u1", 2: "u2", 4: "f4"}


def _is_inveon(path: Path, start: bytes = b"") -> bool:
    return path.name.lower().endswith(".img.hdr")


def header_beside(path: Path) -> Path:
    """Return the header of a file of voxels; `InputError` where there is none."""
    endings = (".mhd", ".nhdr", ".hdr", *HEADERS)
    header = next((header for ending in endings if (header := path.with_suffix(ending)).exists()), None)
    if header is None:
        names = f"{path.stem}.mhd (MetaImage), {path.stem}.nhdr (NRRD) or the scanner's ({', '.join(endings[2:])})"
        raise InputError(f"{path}: RAW says nothing about its size; put its header beside it: {names}")
    return header


def map_raw(path: Path) -> Image:
    """Return the image that the header of a scanner's raw file describes, of a kind in `HEADERS`."""
    fields = read_fields(path)
    holder = _holder(path, fields)
    sizes = _sizes(path, fields)
    start = int(fields.get("file1/skipheader", "0"))
    kind = np.dtype(_kind(path, fields, (holder.stat().st_size - start) / np.prod(sizes, dtype=float)))
    size = voxel_size_in([fields], path)
    spacing, provenance = (UNSIZED, f"{path.name} has no size of a voxel") if size is None else size
    return RawVoxels(holder, start, (sizes[2], sizes[1], sizes[0]), kind, spacing, provenance).image()


def _holder(path: Path, fields: Mapping[str, str]) -> Path:
    name = fields.get("file1/name", "").replace("\\", "/").rpartition("/")[2]
    if name:
        return data_file(path, name)
    stem = path.with_name(path.name.removesuffix(".info")).with_suffix("")
    files = [path.with_suffix("")] if _is_inveon(path) else [Path(f"{stem}{end}") for end in DATA]
    holder = next(filter(Path.exists, files), None)
    if holder is None:
        raise InputError(f"{path}: a header without its voxels; put {stem.name}{DATA[0]} beside it")
    return regular_file(holder)


def _sizes(path: Path, fields: Mapping[str, str]) -> list[int]:
    """Return the numbers of voxels along x, y, z."""
    names = (("volume_sizex", "volume_sizey", "volume_sizez"), ("voxelsx", "voxelsy", "voxelsz"),
             ("x_dimension", "y_dimension", "z_dimension"), ("num_x", "num_y", "num_z"),
             ("width", "height", "numframes"))  # fmt: skip
    text = fields.get("file1/size") or fields.get("representation/size", "")
    plain = {key.rpartition("/")[2]: value for key, value in fields.items()}
    columns = next(([plain[name] for name in row] for row in names if set(row) <= set(plain)), text.split())
    sizes = [int(number) for number in columns]
    if len(sizes) != 3 or not all(0 < size < 1 << 20 for size in sizes):
        raise InputError(f"{path}: its header does not say how many voxels there are; export it again")
    return sizes


def _kind(path: Path, fields: Mapping[str, str], width: float) -> str:
    """Return the type of the voxels; where the header does not say it, by the bytes that each has."""
    plain = {key.rpartition("/")[2]: value.lower() for key, value in fields.items()}
    order = ">" if plain.get("byteorder", "").startswith("high") else "<"
    if path.name.endswith(".pcr") and "format" in plain:
        kind = _PCR_TYPES.get(plain["format"], "")
    elif "datatype" in plain and path.name.lower().endswith(".nfo"):
        kind = _NFO_TYPES.get(plain["datatype"], "")
    elif _is_inveon(path):
        return _INVEON_TYPES.get(plain.get("data_type", ""), "")
    elif "file1/datatype" in fields:
        word, bits = fields["file1/datatype"].lower(), fields.get("file1/bitsperelement", "0")
        letter = "f" if "float" in word else "u" if "unsigned" in word else "i" if "integer" in word else ""
        kind = f"{letter}{int(bits) // 8}" if letter and re.fullmatch("8|16|32", bits) else ""
    else:
        kind = _WIDTHS.get(round(width) if abs(width - round(width)) < 1e-9 else 0, "")
    if kind not in ("i1", "u1", "i2", "u2", "i4", "u4", "f4"):
        raise InputError(f"{path}: the type of its voxels is not clear; export it as NRRD, MetaImage or TIFF")
    return order + kind


def map_npy(path: Path) -> Image:
    """Return the array of a .npy file, z, y, x; it says nothing of its voxels' size."""
    array = np.load(path, mmap_mode="r", allow_pickle=False)
    if array.ndim != 3 or array.dtype.kind not in "biuf":
        raise InputError(f"{path}: no array of three axes and plain numbers; save it with numpy.save")
    grey = array if array.nbytes > MAPPED_BYTES else np.array(array)
    return Image(grey, UNSIZED, np.zeros(3), provenance="an array says nothing of its voxels")


VOLUMES.register(VolumeFormat("raw", "raw voxels with a header", HEADERS, _is_inveon, map_raw, None, map_raw, False))
VOLUMES.register(VolumeFormat("npy", "NumPy array", (".npy",), None, map_npy, None, map_npy, False))
