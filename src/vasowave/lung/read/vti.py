"""VTK's XML: its arrays, as text, base64 or raw bytes, perhaps packed; and images (.vti), whose unit is asked for."""

import base64
import lzma
import zlib
from collections.abc import Callable
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np

from vasowave.base.errors import InputError
from vasowave.base.io.textfile import read_bytes
from vasowave.lung.read.formats import VOLUMES, VolumeFormat
from vasowave.lung.read.itk import itk, upright
from vasowave.lung.read.volume import UNSIZED, Image

TYPES = {
    "Int8": "i1", "UInt8": "u1", "Int16": "i2", "UInt16": "u2", "Int32": "i4", "UInt32": "u4",
    "Int64": "i8", "UInt64": "u8", "Float32": "f4", "Float64": "f8",
}  # fmt: skip
"""What VTK and NumPy call the types of numbers."""
DAMAGE = (ValueError, KeyError, IndexError, TypeError, OverflowError, MemoryError, zlib.error, lzma.LZMAError)
"""What a damaged file raises."""
_MOST = 1 << 28
"""Bytes that an array may hold beside 64 times what it takes in the file."""


def document(raw: bytes) -> tuple[ElementTree.Element, bytes]:
    """Return the tree of a file, and the bytes appended to it, which may be raw, as no XML parser takes them."""
    appended, begin = b"", raw.find(b"<AppendedData")
    if begin >= 0:
        start = raw.index(b"_", raw.index(b">", begin)) + 1
        end = raw.rindex(b"</AppendedData>")
        appended, raw = raw[start:end], raw[:start] + raw[end:]
    return ElementTree.fromstring(raw), appended


def array_of(element: Any, top: Any, appended: bytes) -> np.ndarray:
    """Return the values of a DataArray element."""
    order = "<" if top.get("byte_order", "LittleEndian") == "LittleEndian" else ">"
    kind = np.dtype(order + TYPES[element.get("type")])
    form = element.get("format", "ascii")
    if form == "ascii":
        text = element.text or ""
        if not text.isascii() or "_" in text:  # Python takes 1_0 and the digits of every script for numbers
            raise InputError("numbers with signs that no number has; write the file again")
        return _shaped(np.array(text.split(), dtype=kind), element)
    header = np.dtype(order + TYPES[top.get("header_type", "UInt32")])
    encoded = True
    if form == "appended":
        offset = int(element.get("offset"))
        if not 0 <= offset < len(appended):
            raise InputError(f"an array begins at byte {offset} of {len(appended)}; write the file again")
        source = appended[offset:]
        appended_data = top.find("AppendedData")
        encoded = appended_data is None or appended_data.get("encoding", "base64") != "raw"
    else:
        source = b"".join((element.text or "").encode().split())
    content = _unpacked(source, encoded, header, top.get("compressor"))
    return _shaped(np.frombuffer(content, kind), element)


def _shaped(values: np.ndarray, element: Any) -> np.ndarray:
    width = int(element.get("NumberOfComponents", 1))
    return values.reshape(-1, width) if width > 1 else values


def _unpacked(source: bytes, encoded: bool, header: np.dtype, compressor: str | None) -> bytes:
    """Return the bytes of one array: header and blocks, each base64 by itself, or raw."""

    def taken(start: int, count: int) -> tuple[bytes, int]:
        """Return `count` bytes of the stream that begins at `start`, and where the next stream begins."""
        size = -(-count // 3) * 4 if encoded else count
        piece = source[start : start + size]
        content = base64.b64decode(piece, validate=True) if encoded else piece
        if len(content) < count:
            raise InputError("truncated; write the file again")
        return content[:count], start + size

    width = header.itemsize
    first = int(np.frombuffer(taken(0, width)[0], header)[0])
    if compressor is None:
        joint = not encoded or not source[: -(-width // 3) * 4].endswith(b"=")
        if joint:  # length and values in one stream, as VTK writes them
            return taken(0, width + first)[0][width:]
        return taken(-(-width // 3) * 4, first)[0]
    if compressor not in _UNPACKERS:
        raise InputError(f"compressed with {compressor}; write it with zlib")
    if first == 0:
        return b""
    head, start = taken(0, width * (3 + first))
    block_size, last, *packed_sizes = (int(size) for size in np.frombuffer(head, header)[1:])
    packed = taken(start, sum(packed_sizes))[0]
    sizes = [block_size] * (first - 1) + [last or block_size]
    if sum(sizes) > _MOST + 64 * len(packed):
        raise InputError(f"an array of {len(packed)} bytes says that it holds {sum(sizes)}; it is damaged")
    blocks, position = [], 0
    for count, size in zip(packed_sizes, sizes, strict=True):
        blocks.append(_UNPACKERS[compressor](packed[position : position + count], size))
        position += count
    return b"".join(blocks)


def _unpacked_by(engine: Any, packed: bytes, size: int) -> bytes:
    content: bytes = engine.decompress(packed, size + 1)
    if len(content) != size or not engine.eof:
        raise InputError(f"a block does not hold the {size} bytes that it announces; write the file again")
    return content


def lz4_block(packed: bytes, size: int) -> bytes:
    """Return the content of one LZ4 block that holds `size` bytes.

    Raises
    ------
    InputError
        A block that ends early, copies from before its beginning, or holds more or less.
    """
    unpacked, position = bytearray(), 0
    try:
        while position < len(packed) and len(unpacked) <= size:
            token = packed[position]
            count, position = _count(packed, position + 1, token >> 4)
            if position + count > len(packed):
                raise IndexError
            unpacked += packed[position : position + count]
            position += count
            if position == len(packed):  # the last sequence has no copy
                break
            back = packed[position] | packed[position + 1] << 8
            count, position = _count(packed, position + 2, token & 15)
            if not 0 < back <= len(unpacked):
                raise IndexError
            for _ in range(min(count + 4, size + 1 - len(unpacked))):  # may overlap what it writes
                unpacked.append(unpacked[-back])
        if len(unpacked) != size:
            raise IndexError
    except IndexError:
        raise InputError("truncated or damaged LZ4 data; write the file again") from None
    return bytes(unpacked)


def _count(packed: bytes, position: int, first: int) -> tuple[int, int]:
    """Return a length of which `first` is the beginning, and where reading goes on."""
    count = first
    while first == 15:
        count += packed[position]
        position += 1
        if packed[position - 1] != 255:
            break
    return count, position


_UNPACKERS: dict[str, Callable[[bytes, int], bytes]] = {
    "vtkZLibDataCompressor": lambda packed, size: _unpacked_by(zlib.decompressobj(), packed, size),
    "vtkLZMADataCompressor": lambda packed, size: _unpacked_by(lzma.LZMADecompressor(), packed, size),
    "vtkLZ4DataCompressor": lz4_block,
}


def read_vti(path: Path) -> Image:
    """Read an image of VTK; `InputError` unless it is one piece of grey levels, whole."""
    try:
        grey, fields = _content(path)
        image = itk().GetImageFromArray(grey)
        image.SetDirection(_numbers(fields, "Direction", "1 0 0 0 1 0 0 0 1"))
        image.SetSpacing(_numbers(fields, "Spacing", "1 1 1"))
    except InputError:
        raise
    except ElementTree.ParseError as error:
        raise InputError(f"{path}: not valid XML ({error}); truncated, or no .vti file") from None
    except (*DAMAGE, RuntimeError) as error:
        raise InputError(f"{path}: a damaged or truncated image of VTK ({error}); save it again") from None
    lying = upright(image, path)
    steps = ", ".join(f"{step:g}" for step in 10 * lying.spacing[::-1])
    return lying._replace(spacing=UNSIZED, provenance=f"VTK names no unit of its Spacing ({steps})")


def _content(path: Path) -> tuple[np.ndarray, dict[str, str]]:
    """Return the grey levels, z, y, x, and the attributes of the image."""
    top, appended = document(read_bytes(path))
    image, *further = top.findall("./ImageData/Piece")
    fields = next(top.iter("ImageData")).attrib
    arrays = [array for kind in ("PointData", "CellData") for array in image.findall(f"./{kind}/DataArray")]
    kinds = [(array.get("NumberOfComponents", "1"), array.get("type") in TYPES) for array in arrays]
    if further or kinds != [("1", True)]:
        raise InputError(f"{path}: not one piece with one array of grey levels; save it as NRRD or MetaImage, in mm")
    first, last = np.array(image.attrib["Extent"].split(), int).reshape(3, 2).T
    by_point = image.find("./PointData/DataArray") is not None
    values = array_of(arrays[0], top, appended)
    return values.reshape((last - first + by_point)[::-1]).astype(values.dtype.newbyteorder("=")), dict(fields)


def _numbers(fields: dict[str, str], name: str, default: str) -> list[float]:
    return [float(word) for word in fields.get(name, default).split()]


VOLUMES.register(VolumeFormat("vti", "VTK image", (".vti",), None, read_vti, oriented=False))
