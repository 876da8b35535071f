"""TIFF stacks: grey levels only, because what they say of their voxels cannot be trusted."""

from pathlib import Path

import numpy as np

from vasowave.base.errors import InputError
from vasowave.lung.read.formats import VOLUMES, VolumeFormat
from vasowave.lung.read.itk import MISSING
from vasowave.lung.read.volume import Image


def read_tiff(path: Path) -> Image:
    """Read a stack; its spacing is 1 until somebody says what it is."""
    try:
        import tifffile
    except ImportError:
        raise InputError(MISSING) from None
    try:
        with tifffile.TiffFile(path) as file:
            pages = len(file.series[0].pages)
            if pages < len(file.pages):
                raise InputError(f"{path}: {pages} of its {len(file.pages)} pages have one size and type; export again")
            grey = file.asarray()
    except InputError:
        raise
    except Exception:
        raise InputError(f"{path}: not a readable TIFF stack, or truncated; export it again") from None
    return Image(grey, np.ones(3), np.zeros(3))


VOLUMES.register(VolumeFormat("tiff", "TIFF stack", (".tif", ".tiff"), None, read_tiff))
