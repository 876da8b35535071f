"""Volumes as scanners store them, a header and then voxels: Scanco, GE (.vff), Quantum (.vox), Bruker (2dseq)."""

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
_JCAMP = re.compile(r"^##\$(\w+)=(?:\([ \d,]*\))?([^#$]*)", re.MULTILINE)
_BRUKER_TYPES = {"_8BIT_UNSGN_INT": "u1", "_16BIT_SGN_INT": "i2", "_32BIT_SGN_INT": "i4", "_32BIT_FLOAT": "f4"}


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
    steps = np.array(fields.get("spacing", "nan").split()[::-1], dtype=float)
    spacing = steps * float(fields.get("elementsize", "nan")) * centimeters("mm")
    if spacing.shape != (3,) or not (np.isfinite(spacing).all() and spacing.min() > 0):
        spacing = UNSIZED
    lengths = "elementsize and spacing of its header"
    provenance = "its header has no elementsize or spacing" if spacing is UNSIZED else lengths
    return RawVoxels(path, end.end(), (z, y, x), kind, spacing, provenance).image()


def map_vox(path: Path) -> Image:
    """Return the image in a .vox file of Quantum or Rigaku: two pieces of text, each up to a form feed."""
    start = read_start(path, _MAX_VFF_BYTES)
    head = re.match(rb"Vox1999a\r?\n.*?##\f\r?\n(.*?)##\f\r?\n", start, re.DOTALL)
    fields = dict(re.findall(r"^(\w+) +(.+?)\s*$", head[1].decode("latin-1"), re.MULTILINE)) if head else {}
    sizes, bits = fields.get("VolumeSize", "").split(), fields.get("VoxelSize", "")
    if head is None or len(sizes) != 3 or not all(map(str.isdigit, sizes)) or bits not in ("8", "16"):
        raise InputError(f"{path}: not a .vox volume that can be read; export it as DICOM")
    x, y, z = map(int, sizes)
    kind = np.dtype(f"{'>' if fields.get('Endian', 'L').startswith('B') else '<'}u{int(bits) // 8}")
    scale = f"a VolumeScale of {fields['VolumeScale']} without a unit" if "VolumeScale" in fields else "no VolumeScale"
    return RawVoxels(path, head.end(), (z, y, x), kind, UNSIZED, f"its header has {scale}").image()


def map_2dseq(path: Path) -> Image:
    """Return the image in a 2dseq of Bruker's ParaVision, by the visu_pars beside it; `InputError` unless it is 3D."""
    fields = _jcamp(path.with_name("visu_pars"))
    sizes, edges = (fields.get(f"VisuCore{name}", "").split() for name in ("Size", "Extent"))
    unit = centimeters(fields.get("VisuCoreUnits", "").split(">")[0].strip("< "))
    word = fields.get("VisuCoreWordType", "")
    if len(sizes) != 3 or len(edges) != 3 or fields.get("VisuCoreFrameCount") != "1" or word not in _BRUKER_TYPES:
        raise InputError(f"{path}: not one volume of three axes by its visu_pars; export it as DICOM or NIfTI")
    x, y, z = map(int, sizes)
    order = ">" if fields.get("VisuCoreByteOrder", "").startswith("big") else "<"
    spacing = np.array(edges, float)[::-1] / (z, y, x) * unit if unit else UNSIZED
    provenance = "the extent in its visu_pars" if unit else "its visu_pars has no unit"
    reco = path.with_name("reco")
    view = _jcamp(reco).get("RECO_fov", "").split() if unit and reco.exists() else []  # cm, perhaps in another order
    if view and not np.allclose(sorted(map(float, view)), sorted(np.array(edges, float) * unit), rtol=1e-3):
        raise InputError(f"{path}: visu_pars says an extent of {edges}, reco one of {view} cm; export it again")
    return RawVoxels(path, 0, (z, y, x), np.dtype(order + _BRUKER_TYPES[word]), spacing, provenance).image()


def _jcamp(path: Path) -> dict[str, str]:
    """Return the parameters in a text of ParaVision."""
    text = read_start(path, _MAX_VFF_BYTES).decode("latin-1")
    return {name: " ".join(value.split()) for name, value in re.findall(_JCAMP, text)}


VOLUMES.register(VolumeFormat("isq", "Scanco volume", (".isq", ".rsq"), None, map_isq, None, map_isq, False))
VOLUMES.register(VolumeFormat("vff", "VFF volume", (".vff",), None, map_vff, None, map_vff, False))
VOLUMES.register(VolumeFormat("vox", "VOX volume", (".vox",), None, map_vox, None, map_vox, False))
VOLUMES.register(VolumeFormat("paravision", "ParaVision volume", ("2dseq",), None, map_2dseq, None, map_2dseq, False))
