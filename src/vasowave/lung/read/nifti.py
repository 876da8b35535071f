"""Whether a NIfTI file is whole."""

import gzip
import struct
import zlib
from math import prod
from pathlib import Path
from typing import Any

from vasowave.base.errors import InputError
from vasowave.lung.read.formats import VOLUMES, VolumeFormat
from vasowave.lung.read.itk import read_itk
from vasowave.lung.read.payload import no_voxel_size, require_bytes

_FIELDS: dict[int, dict[str, tuple[str, int]]] = {
    348: {"dim": ("8h", 40), "bits": ("h", 72), "sizes": ("3f", 80), "offset": ("f", 108), "unit": ("B", 123)},
    540: {"bits": ("h", 14), "dim": ("8q", 16), "sizes": ("3d", 112), "offset": ("q", 168), "unit": ("i", 500)},
}
"""Types and places of what is read of a header, by its size: that of version 1 or 2."""


def require_whole_nifti(path: Path, sized: bool = False) -> None:
    """Raise `InputError` unless `path` (.nii or .nii.gz) holds the voxels its header announces, and no more.

    Nor, if it must be `sized`, without their size and its unit.
    """
    packed = path.name.lower().endswith(".gz")
    twin = path.with_name(path.name[:-3]) if packed else path.with_name(path.name + ".gz")
    if twin.exists():
        raise InputError(f"{path}: {twin.name} lies beside it, and the reader may confuse the two; move one of them")
    try:
        with gzip.open(path) if packed else path.open("rb") as file:
            header = file.read(544)
            expected = _announced(header)
    except (EOFError, zlib.error, struct.error):
        raise InputError(f"{path}: truncated; copy or export it again") from None
    except (OSError, ValueError, OverflowError) as error:
        raise InputError(f"{path}: not a NIfTI file that can be read ({error})") from None
    require_bytes(path, 0, expected, "gzip" if packed else "raw")
    if sized and not _is_sized(header):
        raise no_voxel_size(path, "its header leaves out a voxel's size (pixdim) or the unit (xyzt_units)")


def _is_sized(header: bytes) -> bool:
    """Whether a header says how large a voxel is, and in which unit: m, mm or µm."""
    sizes, (unit,) = _field(header, "sizes"), _field(header, "unit")
    return all(size > 0 for size in sizes) and unit & 7 in (1, 2, 3)


def _announced(header: bytes) -> int:
    """Return the size of a whole file with this header, bytes."""
    (count, *dim), (bits,), (offset,) = _field(header, "dim"), _field(header, "bits"), _field(header, "offset")
    if not (1 <= count <= 7 and min(dim[:count]) > 0 and bits > 0 and offset >= _size(header)[1]):
        raise ValueError("its header announces no voxels")
    return int(offset) + prod(dim[:count]) * bits // 8


def _field(header: bytes, name: str) -> tuple[Any, ...]:
    order, size = _size(header)
    kind, place = _FIELDS[size][name]
    return struct.unpack_from(order + kind, header, place)


def _size(header: bytes) -> tuple[str, int]:
    """Return the order of a header's bytes, and its size, by which versions 1 and 2 are told apart."""
    for order in "<>":
        (size,) = struct.unpack_from(f"{order}i", header)
        if size in _FIELDS:
            return order, size
    raise ValueError("its first number is neither 348 nor 540")


VOLUMES.register(VolumeFormat("nifti", "NIfTI", (".nii", ".nii.gz"), None, read_itk, require_whole_nifti))
