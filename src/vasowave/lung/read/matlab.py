"""MATLAB files: the one array of three axes in a file."""

from pathlib import Path

import numpy as np

from vasowave.base.errors import InputError
from vasowave.base.io.matlab import reader_of
from vasowave.lung.read.formats import VOLUMES, VolumeFormat
from vasowave.lung.read.volume import UNSIZED, Image


def read_mat_array(path: Path) -> Image:
    """Read the only array of at least 4 x 4 x 4 numbers (rows are y, columns x, pages z), in a process of its own."""
    try:
        names, values = reader_of(path)(path)
    except Exception as error:  # of SciPy or HDF5, whatever it is
        raise InputError(f"{path}: not a MATLAB file, or damaged ({str(error)[:80]}); save it again") from None
    arrays = dict(zip((name for name, has_value in names if has_value), values, strict=True))
    images = {name: grey for name, grey in arrays.items()
              if grey.ndim == 3 and min(grey.shape) > 3 and grey.dtype.kind in "biuf"}  # fmt: skip
    if len(images) != 1:
        held = ", ".join(images or arrays) or "nothing"
        raise InputError(
            f"{path}: not one array of three axes, rows, columns and slices ({held}); save the image alone"
        )
    grey = np.ascontiguousarray(next(iter(images.values())).transpose(2, 0, 1))
    unread = ", ".join(name for name in arrays if name not in images)
    beside = f"; beside it, not read: {unread}" if unread else ""
    return Image(grey, UNSIZED, np.zeros(3), provenance=f"an array says nothing of its voxels{beside}")


VOLUMES.register(VolumeFormat("matlab array", "MATLAB array", (".mat",), None, read_mat_array, oriented=False))
