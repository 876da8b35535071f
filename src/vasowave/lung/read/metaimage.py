"""Whether a MetaImage (.mha, .mhd) is whole, and what its header names."""

import re
from math import prod
from pathlib import Path

import numpy as np

from vasowave.base.errors import InputError
from vasowave.base.io.textfile import read_start
from vasowave.lung.read.formats import VOLUMES, Contents, VolumeFormat
from vasowave.lung.read.itk import read_itk
from vasowave.lung.read.payload import centimeters, data_file, require_bytes
from vasowave.lung.read.raw import RawVoxels
from vasowave.lung.read.volume import Image

_TYPES = {
    "CHAR": "i1", "UCHAR": "u1", "SHORT": "i2", "USHORT": "u2", "INT": "i4", "UINT": "u4", "LONG": "i4", "ULONG": "u4",
    "LONG_LONG": "i8", "ULONG_LONG": "u8", "FLOAT": "f4", "DOUBLE": "f8",
}  # fmt: skip
_YES = ("true", "1", "t")
_MAX_HEADER_BYTES = 1 << 16
"""No header is longer, bytes."""
_PROVENANCE = "ElementSpacing of its header"


def check_metaimage(path: Path) -> Contents:
    """Return what a header announces; `InputError` unless just these voxels are there, in its own folder."""
    fields, holder, start = _header(path)
    count = _require_voxels(path, fields, holder, start)
    if not {"ElementSpacing", "ElementSize"} & set(fields):
        return Contents(count, "its header has no ElementSpacing")
    unit = fields.get("DistanceUnits", "mm")
    return Contents(count, "" if centimeters(unit) else f"its header has lengths in '{unit}' (DistanceUnits)")


def _header(path: Path) -> tuple[dict[str, str], Path, int]:
    """Return the fields of a header, the file of the voxels and where they may begin in it."""
    start = read_start(path, _MAX_HEADER_BYTES)
    last = re.search(rb"^ElementDataFile *= *([^\r\n]*)\r?(\n|$)", start, re.MULTILINE)
    if last is None:
        raise InputError(f"{path}: not an image that can be read: its header has no ElementDataFile; export it again")
    lines = start[: last.start()].decode("latin-1").splitlines()
    fields = {key.strip(): value.strip() for key, _, value in (line.partition("=") for line in lines)}
    if fields.get("ObjectType", "Image") != "Image":
        raise InputError(f"{path}: not an image that can be read: its ObjectType is {fields['ObjectType']}")
    name = last[1].decode("utf-8", errors="replace").strip()
    if name.upper().startswith("LIST") or "%" in name:
        raise InputError(f"{path}: its voxels are spread over several files; save it as one")
    is_local = name.upper() == "LOCAL"
    return fields, path if is_local else data_file(path, name), last.end() if is_local else 0


def read_metaimage(path: Path) -> Image:
    """Read a MetaImage as `read_itk` does, with lengths in its DistanceUnits; mm where it names none, as in MetaIO."""
    scale, image = 10 * (centimeters(_header(path)[0].get("DistanceUnits", "mm")) or 0.1), read_itk(path)
    return image._replace(spacing=image.spacing * scale, origin=image.origin * scale, provenance=_PROVENANCE)


def map_metaimage(path: Path) -> Image | None:
    """Return an image whose voxels lie unpacked in a file of three axes that are not turned."""
    fields, holder, start = _header(path)
    turned = next((fields[key] for key in ("TransformMatrix", "Rotation", "Orientation") if key in fields), "")
    packed, text = fields.get("CompressedData", "False"), fields.get("BinaryData", "True")
    channels, sizes = fields.get("ElementNumberOfChannels", "1"), [int(size) for size in fields["DimSize"].split()]
    straight = [float(component) for component in turned.split()] in ([], np.eye(3).ravel().tolist())
    plain = packed.lower() not in _YES and text.lower() in _YES and channels == "1" and len(sizes) == 3
    if start or not (straight and plain):
        return None
    order = fields.get("BinaryDataByteOrderMSB", fields.get("ElementByteOrderMSB", "False")).lower() in _YES
    kind = np.dtype((">" if order else "<") + _TYPES[fields["ElementType"].removeprefix("MET_")])
    offset, unit = int(fields.get("HeaderSize", 0)), centimeters(fields.get("DistanceUnits", "mm")) or 0.1
    first = next((fields[key] for key in ("Offset", "Position", "Origin") if key in fields), "0 0 0")
    lengths = fields.get("ElementSpacing", fields.get("ElementSize", "nan nan nan"))
    offset = holder.stat().st_size - int(np.prod(sizes)) * kind.itemsize if offset == -1 else offset
    spacing, origin = (np.array(text.split()[::-1], dtype=float) * unit for text in (lengths, first))
    return RawVoxels(holder, offset, (sizes[2], sizes[1], sizes[0]), kind, spacing, _PROVENANCE, origin).image()


def _require_voxels(path: Path, fields: dict[str, str], holder: Path, start: int) -> int:
    try:
        sizes = [int(size) for size in fields["DimSize"].split()]
        channels = int(fields.get("ElementNumberOfChannels", 1))
        offset = int(fields.get("HeaderSize", 0))
        width = np.dtype(_TYPES[fields["ElementType"].removeprefix("MET_").removesuffix("_ARRAY")]).itemsize
        if len(sizes) != int(fields.get("NDims", len(sizes))) or min(sizes, default=0) < 1 or channels < 1:
            raise ValueError
        turned = [float(component) for component in fields.get("TransformMatrix", "").split()]
        if any(not abs(component) <= 1.01 for component in turned):
            raise ValueError
    except (KeyError, ValueError):
        raise InputError(f"{path}: not an image that can be read: its header is damaged; export it again") from None
    count = prod(sizes) * channels * width
    packed = fields.get("CompressedData", "False").lower() in _YES
    if packed:
        require_bytes(holder, start, count, "zlib")
    elif offset == -1 or fields.get("BinaryData", "True").lower() in _YES:
        require_bytes(holder, start, count, offset=offset)
    if start and (offset > 0 or (packed and "CompressedDataSize" not in fields)):  # ITK reads other voxels
        reason = "names the length of a header before its voxels" if offset > 0 else "has no CompressedDataSize"
        raise InputError(f"{path}: not an image that can be read: its header {reason}; export it again")
    return count


VOLUMES.register(
    VolumeFormat("metaimage", "MetaImage", (".mha", ".mhd"), None, read_metaimage, check_metaimage, map_metaimage)
)
