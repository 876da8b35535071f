"""HDF5: the one array of three axes in a file, with the size of a voxel where an attribute says it."""

from pathlib import Path
from typing import Any

import numpy as np

from vasowave.base.errors import InputError
from vasowave.lung.read.formats import VOLUMES, VolumeFormat
from vasowave.lung.read.itk import MISSING
from vasowave.lung.read.payload import centimeters
from vasowave.lung.read.volume import UNSIZED, Image


def read_hdf5(path: Path) -> Image:
    """Read the only array of at least 3 x 3 x 3 numbers; its attribute element_size_um is a voxel's size (z, y, x)."""
    try:
        import h5py
    except ImportError:
        raise InputError(MISSING) from None
    arrays: list[Any] = []

    def keep(name: str, entry: Any) -> None:
        if isinstance(entry, h5py.Dataset) and entry.ndim == 3 and min(entry.shape) > 2 and entry.dtype.kind in "iuf":
            arrays.append(entry)

    try:
        with h5py.File(path, "r") as file:
            file.visititems(keep)
            if len(arrays) != 1:
                names = ", ".join(array.name for array in arrays) or "none"
                raise InputError(f"{path}: not one array of three axes ({names}); save the image alone")
            grey, size = (
                arrays[0][()],
                np.array(arrays[0].attrs.get("element_size_um", UNSIZED), dtype=float),
            )
    except InputError:
        raise
    except Exception:
        raise InputError(f"{path}: not a readable HDF5 file, or truncated; export it again") from None
    if size.shape != (3,) or not (size > 0).all():
        return Image(grey, UNSIZED, np.zeros(3), provenance="no attribute element_size_um")
    return Image(grey, size * centimeters("um"), np.zeros(3), provenance="its attribute element_size_um")


VOLUMES.register(VolumeFormat("hdf5", "HDF5 array", (".h5", ".hdf5", ".hdf"), None, read_hdf5, oriented=False))
