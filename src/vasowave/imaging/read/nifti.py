"""Whether a NIfTI file is whole."""

import gzip
import struct
import zlib
from math import prod
from pathlib import Path

from vasowave.errors import InputError
from vasowave.imaging.read.formats import VOLUMES, VolumeFormat
from vasowave.imaging.read.itk import read_itk
from vasowave.imaging.read.payload import no_voxel_size, require_bytes


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
    order = next(order for order in "<>" if struct.unpack_from(f"{order}i", header)[0] in (348, 540))
    if struct.unpack_from(f"{order}i", header)[0] == 348:
        sizes, (unit,) = struct.unpack_from(f"{order}3f", header, 80), struct.unpack_from("B", header, 123)
    else:
        sizes, (unit,) = struct.unpack_from(f"{order}3d", header, 112), struct.unpack_from(f"{order}i", header, 500)
    return all(size > 0 for size in sizes) and unit & 7 in (1, 2, 3)


def _announced(header: bytes) -> int:
    """Return the size of a whole file with this header, bytes."""
    for order in "<>":
        (size,) = struct.unpack_from(f"{order}i", header)
        if size == 348:
            dim = struct.unpack_from(f"{order}8h", header, 40)
            bits = struct.unpack_from(f"{order}h", header, 72)[0]
            offset = struct.unpack_from(f"{order}f", header, 108)[0]
        elif size == 540:
            dim = struct.unpack_from(f"{order}8q", header, 16)
            bits = struct.unpack_from(f"{order}h", header, 14)[0]
            offset = struct.unpack_from(f"{order}q", header, 168)[0]
        else:
            continue
        if not (1 <= dim[0] <= 7 and min(dim[1 : dim[0] + 1]) > 0 and bits > 0 and offset >= size):
            raise ValueError("its header announces no voxels")
        return int(offset) + prod(dim[1 : dim[0] + 1]) * bits // 8
    raise ValueError("its first number is neither 348 nor 540")


VOLUMES.register(VolumeFormat("nifti", "NIfTI", (".nii", ".nii.gz"), None, read_itk, require_whole_nifti))
