"""Volumes as scanners store them, a header and then voxels: Scanco's .isq, GE's .vff."""

import re
import struct
from pathlib import Path

import numpy as np

from vasowave.base.errors import InputError
from vasowave.base.io.textfile import read_start
from vasowave.lung.read.formats import VOLUMES, VolumeFormat
from vasowave.lung.read.payload import centimeters
from vasowave.lung.read.raw import RawVoxels
from vasowave.lung.read.volume import UNSIZED, Image

_ISQ = b"CTDATA-HEADER_V1"
_ISQ_BLOCK = 512
"""Bytes of the header and of each block after it; its last number counts blocks before the voxels (Scanco)."""
_MAX_VFF_BYTES = 1 << 16


def map_isq(path: Path) -> Image:
    """Return the image in a .isq or .rsq file of Scanco: whole edges in µm, voxels of 16 bits."""
    header = read_start(path, _ISQ_BLOCK)
    if len(header) < _ISQ_BLOCK or not header.startswith(_ISQ):
        raise InputError(f"{path}: not a Scanco volume that can be read (no {_ISQ.decode()}); export it again")
    counts, edges = (np.array(struct.unpack_from("<3i", header, place)) for place in (44, 56))
    (blocks,) = struct.unpack_from("<i", header, 508)
    if counts.min() < 1 or edges.min() < 0 or blocks < 0:
        raise InputError(f"{path}: its header is damaged; export it again")
    spacing = (edges / counts)[::-1] * centimeters("um") if edges.min() > 0 else UNSIZED
    x, y, z = counts.tolist()
    provenance = "the edges in its header" if edges.min() > 0 else "its header has no edges"
    layout = RawVoxels(path, (blocks + 1) * _ISQ_BLOCK, (z, y, x), np.dtype("<i2"), spacing, provenance)
    return layout.image(padded=True)  # its blocks may end after the voxels


def map_vff(path: Path) -> Image:
    """Return the image in a .vff file of GE's scanners: text up to a form feed, then voxels, high byte first."""
    start = read_start(path, _MAX_VFF_BYTES)
    end = re.search(rb"\f\r?\n?", start)
    if not start.startswith(b"ncaa") or end is None:
        raise InputError(f"{path}: not a .vff volume that can be read; export it again")
    fields = dict(re.findall(r"(\w+)\s*=\s*([^;\n]*)", start[: end.start()].decode("latin-1")))
    if int(fields.get("bands", 1)) != 1 or int(fields.get("rank", 3)) != 3:
        raise InputError(f"{path}: no grey-level volume; export one channel")
    x, y, z = (int(number) for number in fields["size"].split())
    kind = np.dtype({"8": "u1", "16": ">i2", "32": ">f4"}[fields["bits"].strip()])
    steps = np.array(fields.get("spacing", "1 1 1").split()[::-1], dtype=float)
    spacing = steps * float(fields.get("elementsize", "nan")) * centimeters("mm")
    if spacing.shape != (3,) or not (np.isfinite(spacing).all() and spacing.min() > 0):
        spacing = UNSIZED
    provenance = "its header has no elementsize" if spacing is UNSIZED else "elementsize and spacing of its header"
    return RawVoxels(path, end.end(), (z, y, x), kind, spacing, provenance).image()


VOLUMES.register(VolumeFormat("isq", "Scanco volume", (".isq", ".rsq"), None, map_isq, None, map_isq, False))
VOLUMES.register(VolumeFormat("vff", "VFF volume", (".vff",), None, map_vff, None, map_vff, False))
