"""TIFF: stacks and slices, with the scale that ImageJ and OME write into them."""

from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np

from vasowave.base.errors import InputError
from vasowave.lung.read.findings import INVERTED
from vasowave.lung.read.formats import VOLUMES, VolumeFormat
from vasowave.lung.read.itk import MISSING
from vasowave.lung.read.payload import centimeters
from vasowave.lung.read.volume import UNSIZED, Image

_UNSAID = "a TIFF says its voxels' size only where ImageJ or OME wrote it, with a unit and the distance of slices"


def read_tiff(path: Path) -> Image:
    """Read a stack, or one slice; grey levels of a file in which the lowest is white are inverted."""
    try:
        import tifffile
    except ImportError:
        raise InputError(MISSING) from None
    try:
        with tifffile.TiffFile(path) as file:
            pages = len(file.series[0].pages)
            if pages < len(file.pages):
                raise InputError(f"{path}: {pages} of its {len(file.pages)} pages have one size and type; export again")
            grey, is_white = file.asarray(), file.pages.first.photometric == tifffile.PHOTOMETRIC.MINISWHITE
            spacing, provenance = _scale(file)
    except InputError:
        raise
    except Exception:
        raise InputError(f"{path}: not a readable TIFF stack, or truncated; export it again") from None
    findings = (INVERTED(source="it says that its lowest level is white"),) if is_white else ()
    return Image(inverted(grey) if is_white else grey, spacing, np.zeros(3), provenance=provenance, findings=findings)


def inverted(grey: np.ndarray) -> np.ndarray:
    """Return grey levels with black and white exchanged, within what their type holds; of decimals, what there is."""
    if grey.dtype.kind == "f":
        return grey.max() + grey.min() - grey
    return ~grey  # of signed numbers -1 - g


def _scale(file: Any) -> tuple[np.ndarray, str]:
    """Return the size of a voxel, z, y, x, cm, NaN where it is not said, and what says it."""
    if file.ome_metadata:
        pixels = next(node for node in ElementTree.fromstring(file.ome_metadata).iter() if node.tag.endswith("Pixels"))
        lengths = [float(pixels.get(f"PhysicalSize{axis}", "nan")) for axis in "ZYX"]
        units = [centimeters(pixels.get(f"PhysicalSize{axis}Unit", "µm")) or np.nan for axis in "ZYX"]
        return _sized(np.array(lengths) * units, "PhysicalSize of its OME metadata")
    tags = file.pages.first.tags
    if file.imagej_metadata and "XResolution" in tags and "YResolution" in tags:
        across, down = (tags[name].value for name in ("XResolution", "YResolution"))
        unit = centimeters(str(file.imagej_metadata.get("unit", "")))
        sides = [float(file.imagej_metadata.get("spacing", "nan")), down[1] / down[0], across[1] / across[0]]
        return _sized(np.array(sides) * (unit or np.nan), "the scale that ImageJ wrote")
    return UNSIZED, _UNSAID


def _sized(sizes: np.ndarray, source: str) -> tuple[np.ndarray, str]:
    sizes = np.where(sizes > 0, sizes, np.nan)
    return sizes, source if np.isfinite(sizes).all() else f"{source} lacks a length of a voxel or its unit"


VOLUMES.register(VolumeFormat("tiff", "TIFF stack", (".tif", ".tiff"), None, read_tiff, oriented=False))
