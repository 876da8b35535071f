"""Volumes from files: a DICOM folder, NRRD, NIfTI, MetaImage, RAW with header, or a TIFF stack."""

from pathlib import Path

import numpy as np

from vasowave.errors import InputError
from vasowave.imaging.read.dicom import read_dicom_series
from vasowave.imaging.read.itk import MISSING, read_itk
from vasowave.imaging.read.volume import Volume


def read_volume(path: str | Path, spacing: float | None = None) -> Volume:
    """Read a DICOM series (a folder), or NRRD, NIfTI, MetaImage, RAW with header, TIFF stack (a file).

    Axes that the file turns or flips are turned back, so that z, y, x are the patient's as DICOM counts them.

    Parameters
    ----------
    path : path
    spacing : float, optional
        Voxel size in cm; needed for TIFF stacks, which carry none that can be trusted; replaces the file's own.

    Raises
    ------
    InputError
        Missing, truncated or unreadable file, RAW without header, a series with missing, doubled or foreign slices
        (each named), a `spacing` that is not positive.

    Warns
    -----
    VasowaveWarning
        Axes that are not the patient's even after turning: places count along the image's own.
    """
    path = Path(path)
    if not path.exists():
        raise InputError(f"{path}: no such file or folder")
    if spacing is not None and not (np.isfinite(spacing) and spacing > 0):
        raise InputError(f"voxel size {spacing:g} cm; give a positive number of cm")
    if path.is_dir():
        volume = read_dicom_series(path)
    elif path.suffix.lower() in (".tif", ".tiff"):
        return _read_tiff(path, spacing)
    else:
        volume = read_itk(path)
    return volume if spacing is None else Volume(volume.grey, np.full(3, spacing), volume.origin)


def _read_tiff(path: Path, spacing: float | None) -> Volume:
    try:
        import tifffile
    except ImportError:
        raise InputError(MISSING) from None
    if spacing is None:
        raise InputError(f"{path}: a TIFF stack says nothing reliable about its voxel size; give spacing in cm")
    try:
        grey = tifffile.imread(path)
    except Exception:
        raise InputError(f"{path}: not a readable TIFF stack; export it again") from None
    return Volume(grey, np.full(3, spacing), np.zeros(3))
