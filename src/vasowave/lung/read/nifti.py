"""NIfTI files: whether they are whole, and whether their two transforms agree."""

import gzip
import struct
import zlib
from math import prod
from pathlib import Path
from typing import Any

import numpy as np

from vasowave.base.errors import InputError
from vasowave.base.findings import look_kind
from vasowave.lung.read.formats import VOLUMES, Contents, VolumeFormat
from vasowave.lung.read.itk import read_itk
from vasowave.lung.read.payload import require_bytes
from vasowave.lung.read.volume import Image

_FIELDS: dict[int, dict[str, tuple[str, int]]] = {
    348: {
        "dim": ("8h", 40), "bits": ("h", 72), "sizes": ("3f", 80), "offset": ("f", 108), "unit": ("B", 123),
        "words": ("4s", 56), "codes": ("2h", 252), "side": ("f", 76), "turn": ("3f", 256), "first": ("3f", 268),
        "affine": ("12f", 280),
    },
    540: {
        "bits": ("h", 14), "dim": ("8q", 16), "sizes": ("3d", 112), "offset": ("q", 168), "unit": ("i", 500),
        "side": ("d", 104), "codes": ("2i", 344), "turn": ("3d", 352), "first": ("3d", 376), "affine": ("12d", 400),
    },
}  # fmt: skip
"""Types and places of what is read of a header, by its size: that of version 1 or 2."""


_HEADER_BYTES = 544
_SCANNER = 1
"""Code of the transform into the scanner's frame (nifti1.h); SimpleITK takes the sform where it has this code."""

TWO_FRAMES = look_kind(
    "image.two-frames",
    "its header places it twice, and differently (qform and sform); the {used} is taken, as SimpleITK does; viewers "
    "that take the other show other places. {remedy}",
    "Save the image with one transform, and compare left and right with what you know of the animal.",
)


def check_nifti(path: Path) -> Contents:
    """Return what a header (.nii, .nii.gz, .hdr) announces; `InputError` unless just these voxels are there."""
    packed = path.name.lower().endswith(".gz")
    twin = path.with_name(path.name[:-3]) if packed else path.with_name(path.name + ".gz")
    if twin.exists():
        raise InputError(f"{path}: {twin.name} lies beside it, and the reader may confuse the two; move one of them")
    try:
        header = _header(path)
        expected = _announced(header, single := path.suffix.lower() != ".hdr")
    except (EOFError, zlib.error, struct.error):
        raise InputError(f"{path}: truncated; copy or export it again") from None
    except (OSError, ValueError, OverflowError) as error:
        raise InputError(f"{path}: not a NIfTI file that can be read ({error})") from None
    if single:
        require_bytes(path, 0, expected, "gzip" if packed else "raw")
    if not _is_sized(header):
        return Contents(expected, "its header leaves out a voxel's size (pixdim) or the unit (xyzt_units)")
    frames = _frames(header)
    sizes = [np.linalg.norm(frame[:, :3], axis=0) for frame in frames]
    if len(frames) == 2 and not np.allclose(sizes[0], sizes[1], rtol=1e-3):
        return Contents(expected, "its header names two sizes of a voxel (qform and sform)")
    return Contents(expected)


def read_nifti(path: Path) -> Image:
    """Read a NIfTI file; a finding where its two transforms differ."""
    header = _header(path)
    if _size(header)[1] == 540:
        raise InputError(f"{path}: NIfTI-2, which SimpleITK does not read; save it as NIfTI-1 (FSL, nibabel) or NRRD")
    image = read_itk(path)
    image = image._replace(provenance="pixdim and xyzt_units of its header")
    frames, corners = _frames(header), np.eye(4) * [*_field(header, "dim")[1:4], 1]
    corners[:3, 3] = 1
    shift = np.abs((frames[0] - frames[-1]) @ corners.T).max() if frames else 0.0
    if not 0 < min(_field(header, "sizes")) < 2 * shift:  # without sizes there is no qform
        return image
    used = "sform" if _field(header, "codes")[1] == _SCANNER else "qform"
    return image._replace(findings=(TWO_FRAMES(used=used),))


def _header(path: Path) -> bytes:
    with gzip.open(path) if path.name.lower().endswith(".gz") else path.open("rb") as file:
        return file.read(_HEADER_BYTES)


def _frames(header: bytes) -> list[np.ndarray]:
    """Return the transforms from voxels i, j, k to places that a header names, shape (3, 4): qform, sform."""
    if _is_analyze(header):
        return []  # Analyze, which has no transforms
    codes, affine = _field(header, "codes"), np.reshape(_field(header, "affine"), (3, 4))
    b, c, d = _field(header, "turn")
    (side,), first, sizes = _field(header, "side"), _field(header, "first"), np.array(_field(header, "sizes"))
    turned = np.array([b, c, d])
    cross = np.array([[0, -d, c], [d, 0, -b], [-c, b, 0]])
    real = np.sqrt(max(0.0, 1.0 - turned @ turned))
    turn = np.eye(3) + 2 * (real * cross + cross @ cross)
    quaternion = np.column_stack([turn * sizes * [1, 1, -1 if side < 0 else 1], first])
    return [frame for frame, code in zip((quaternion, affine), codes, strict=True) if code > 0]


def _is_sized(header: bytes) -> bool:
    """Whether a header says how large a voxel is, and in which unit: m, mm or µm; Analyze's says it in letters."""
    sizes, (unit,) = _field(header, "sizes"), _field(header, "unit")
    if _is_analyze(header):
        return all(size > 0 for size in sizes) and _field(header, "words")[0].strip(b"\0 ").lower() == b"mm"
    return all(size > 0 for size in sizes) and unit & 7 in (1, 2, 3)


def _is_analyze(header: bytes) -> bool:
    """Whether a header is that of Analyze 7.5, in the place of whose later fields other things may stand."""
    return _size(header)[1] == 348 and not header.startswith((b"n+1", b"ni1"), 344)


def _announced(header: bytes, single: bool) -> int:
    """Return the size of a whole file with this header, bytes; voxels in a file of their own have any offset."""
    (count, *dim), (bits,), (offset,) = _field(header, "dim"), _field(header, "bits"), _field(header, "offset")
    if not (1 <= count <= 7 and min(dim[:count]) > 0 and bits > 0 and offset >= (_size(header)[1] if single else 0)):
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


VOLUMES.register(VolumeFormat("nifti", "NIfTI", (".nii", ".nii.gz", ".hdr"), None, read_nifti, check_nifti))
