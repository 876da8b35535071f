"""HDF5: the one array of three axes in a file, with the size of a voxel where an attribute says it."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from vasowave.base.errors import InputError
from vasowave.lung.read.formats import VOLUMES, VolumeFormat
from vasowave.lung.read.payload import centimeters
from vasowave.lung.read.volume import UNSIZED, Image


def read_hdf5(path: Path) -> Image:
    """Read the only array of at least 3 x 3 x 3 numbers; its attribute element_size_um is a voxel's size (z, y, x)."""
    import netCDF4

    with netCDF4.Dataset(path) as file:
        file.set_auto_maskandscale(False)
        arrays = [array for array in _arrays(file) if array.ndim == 3 and min(array.shape) > 2]
        if len(arrays) != 1:
            names = ", ".join(array.name for array in arrays) or "none"
            raise InputError(f"{path}: not one array of three axes ({names}); save the image alone")
        grey, size = arrays[0][:], np.array(getattr(arrays[0], "element_size_um", UNSIZED), dtype=float)
    if size.shape != (3,) or not (size > 0).all():
        return Image(grey, UNSIZED, np.zeros(3), provenance="it has no attribute element_size_um")
    return Image(grey, size * centimeters("um"), np.zeros(3), provenance="its attribute element_size_um")


def _arrays(group: Any) -> Iterator[Any]:
    yield from group.variables.values()
    for subgroup in group.groups.values():
        yield from _arrays(subgroup)


VOLUMES.register(VolumeFormat("hdf5", "HDF5 array", (".h5", ".hdf5", ".hdf"), None, read_hdf5, oriented=False))
