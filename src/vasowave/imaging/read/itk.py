"""Images that SimpleITK reads: NRRD, NIfTI, MetaImage; axes turned as DICOM counts them."""

from pathlib import Path
from typing import Any

import numpy as np

from vasowave.errors import InputError
from vasowave.imaging.read.volume import Image, Volume

MISSING = "reading and writing images needs the extra 'imaging': install vasowave[imaging]"
_TURNED = 1e-2
"""An axis that is off by more than this is oblique, and axes that are no rotation within it are damaged."""


def itk() -> Any:
    """Return the module SimpleITK; `InputError` without the extra."""
    try:
        import SimpleITK
    except ImportError:
        raise InputError(MISSING) from None
    return SimpleITK


def read_itk(path: Path) -> Image:
    """Read one image file; `InputError` where it is truncated, foreign or not three-dimensional.

    Compiled code reads it, which a damaged file can crash or hang: `native.read_image` calls this in another process.
    """
    try:
        image = itk().ReadImage(str(path))
    except RuntimeError:
        raise InputError(
            f"{path}: not an image that can be read (NRRD, NIfTI, MetaImage), truncated, or its data file is missing"
        ) from None
    if image.GetDimension() != 3 or image.GetNumberOfComponentsPerPixel() != 1:
        raise InputError(f"{path}: not a three-dimensional grey-level image; export one channel of a 3D volume")
    return upright(image, path)


def upright(image: Any, source: Path) -> Image:
    """Return the image with its axes turned to x left, y posterior, z superior, as DICOM counts."""
    axes = np.array(image.GetDirection()).reshape(3, 3)
    if not np.allclose(axes @ axes.T, np.eye(3), atol=_TURNED):
        raise InputError(f"{source}: the directions of its axes are not perpendicular; its header is damaged")
    notes: tuple[str, ...] = ()
    if not np.allclose(axes, np.eye(3), atol=1e-4):
        image = itk().DICOMOrient(image, "LPS")
        if not np.allclose(image.GetDirection(), np.eye(3).ravel(), atol=_TURNED):
            notes = (f"{source}: its axes are oblique; places count along the image's own axes, from its first voxel",)
    grey = itk().GetArrayFromImage(image)
    return Image(grey, np.array(image.GetSpacing())[::-1] / 10, np.array(image.GetOrigin())[::-1] / 10, notes)


def write_volume(volume: Volume, path: str | Path) -> None:
    """Write `volume` as NRRD, NIfTI or MetaImage (by the suffix), spacing in mm."""
    write_image(np.asarray(volume.grey), volume, path)


def write_image(values: np.ndarray, grid: Volume, path: str | Path) -> None:
    """Write `values` on the grid of a volume, spacing in mm; whole numbers are compressed."""
    image = itk().GetImageFromArray(values)
    image.SetSpacing([float(h) for h in grid.spacing[::-1] * 10])
    image.SetOrigin([float(h) for h in grid.origin[::-1] * 10])
    itk().WriteImage(image, str(path), bool(np.issubdtype(values.dtype, np.integer)))
