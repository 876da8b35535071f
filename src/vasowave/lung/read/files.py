"""Volumes from files: a DICOM folder, NRRD, NIfTI, MetaImage, RAW with header, or a TIFF stack."""

from pathlib import Path

import numpy as np

from vasowave.base.errors import InputError
from vasowave.base.io.apart import ReaderAnswer, read_apart
from vasowave.base.io.textfile import regular_file
from vasowave.lung.read.formats import VOLUMES
from vasowave.lung.read.volume import VOXELS, Image, Volume


def read_volume(path: str | Path, spacing: float | None = None) -> Volume:
    """Read a DICOM series (a folder), or NRRD, NIfTI, MetaImage, RAW with header, TIFF stack (a file).

    Axes are permuted and flipped so that z, y, x are nearest to the patient's as DICOM counts them; how far they are
    turned from these is `Volume.axes`. Compiled libraries read in another process, within limits of time and memory.

    Parameters
    ----------
    path : path
    spacing : float, optional
        Voxel size in cm; needed for TIFF stacks, which carry none that can be trusted, and for headers without one;
        replaces the file's own.

    Raises
    ------
    InputError
        Missing, truncated, damaged or unreadable file, voxels that lie outside the folder of their header, RAW without
        header, a series with missing, doubled or foreign slices (each named), no voxel size or unit of it, a voxel
        size that no image of an animal has.
    """
    path = Path(path)
    if not path.exists():
        raise InputError(f"{path}: no such file or folder")
    if spacing is not None and not VOXELS[0] <= spacing <= VOXELS[1]:
        low, high = VOXELS
        raise InputError(f"voxel size {spacing:g} cm; give a positive number of cm between {low:g} and {high:g}")
    if not path.is_dir():
        path = _checked(path, spacing)
    head, (grey,) = read_apart(image_in, path, "an image that can be read")
    image = Image(grey, *map(np.array, head))
    try:
        spacing_used = image.spacing if spacing is None else np.full(3, spacing)
        return Volume(image.grey, spacing_used, image.origin, image.axes)
    except InputError as error:
        raise InputError(f"{path}: {error}") from None


def _checked(path: Path, spacing: float | None) -> Path:
    """Return the file to read, in which everything is there that its header announces."""
    path = regular_file(path)
    name = path.name.lower()
    if name.endswith((".tif", ".tiff")) and spacing is None:
        raise InputError(f"{path}: a TIFF stack says nothing reliable about its voxel size; give spacing in cm")
    if name.endswith(".raw"):
        path = _header_of(path)
    form = VOLUMES.of(path)
    if form.check is not None:
        form.check(path, spacing is None)
    return path


def image_in(path: Path) -> ReaderAnswer:
    """Return spacing, origin and axes of an image, and its grey levels."""
    image: Image = VOLUMES.of(path).read(path)
    return ReaderAnswer([array.tolist() for array in (image.spacing, image.origin, image.axes)], [image.grey])


def _header_of(path: Path) -> Path:
    """Return the header beside a .raw file, which says nothing about itself."""
    headers = [path.with_suffix(suffix) for suffix in (".mhd", ".nhdr") if path.with_suffix(suffix).exists()]
    if not headers:
        header_names = f"{path.stem}.mhd (MetaImage) or {path.stem}.nhdr (NRRD)"
        raise InputError(f"{path}: RAW says nothing about its size; put its header beside it: {header_names}")
    return headers[0]
