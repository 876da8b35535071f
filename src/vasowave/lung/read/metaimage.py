"""Whether a MetaImage (.mha, .mhd) is whole, and what its header names."""

import re
from math import prod
from pathlib import Path

from vasowave.base.errors import InputError
from vasowave.base.io.textfile import read_start
from vasowave.lung.read.formats import VOLUMES, VolumeFormat
from vasowave.lung.read.itk import read_itk
from vasowave.lung.read.payload import data_file, no_voxel_size, require_bytes

_BYTES = {
    "CHAR": 1, "UCHAR": 1, "SHORT": 2, "USHORT": 2, "INT": 4, "UINT": 4, "LONG": 4, "ULONG": 4, "LONG_LONG": 8,
    "ULONG_LONG": 8, "FLOAT": 4, "DOUBLE": 8,
}  # fmt: skip
_MAX_HEADER_BYTES = 1 << 16
"""No header is longer, bytes."""


def require_whole_metaimage(path: Path, sized: bool = False) -> None:
    """Raise `InputError` unless the voxels that the header announces are there, in its own folder, and no more.

    Nor, if it must be `sized`, without their size.
    """
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
    _require_voxels(path, fields, path if is_local else data_file(path, name), last.end() if is_local else 0)
    if sized and not {"ElementSpacing", "ElementSize"} & set(fields):
        raise no_voxel_size(path, "its header has no ElementSpacing")


def _require_voxels(path: Path, fields: dict[str, str], holder: Path, start: int) -> None:
    try:
        sizes = [int(size) for size in fields["DimSize"].split()]
        channels = int(fields.get("ElementNumberOfChannels", 1))
        offset = int(fields.get("HeaderSize", 0))
        width = _BYTES[fields["ElementType"].removeprefix("MET_").removesuffix("_ARRAY")]
        if len(sizes) != int(fields.get("NDims", len(sizes))) or min(sizes, default=0) < 1 or channels < 1:
            raise ValueError
        turned = [float(component) for component in fields.get("TransformMatrix", "").split()]
        if any(not abs(component) <= 1.01 for component in turned):
            raise ValueError
    except (KeyError, ValueError):
        raise InputError(f"{path}: not an image that can be read: its header is damaged; export it again") from None
    count = prod(sizes) * channels * width
    packed = fields.get("CompressedData", "False").lower() in ("true", "1", "t")
    if packed:
        require_bytes(holder, start, count, "zlib")
    elif offset == -1:  # the voxels are the last bytes of their file
        require_bytes(holder, max(holder.stat().st_size - count, start), count)
    elif fields.get("BinaryData", "True").lower() in ("true", "1", "t"):
        require_bytes(holder, start + offset, count)
    if start and (offset > 0 or (packed and "CompressedDataSize" not in fields)):  # ITK reads other voxels
        reason = "names the length of a header before its voxels" if offset > 0 else "has no CompressedDataSize"
        raise InputError(f"{path}: not an image that can be read: its header {reason}; export it again")


VOLUMES.register(VolumeFormat("metaimage", "MetaImage", (".mha", ".mhd"), None, read_itk, require_whole_metaimage))
