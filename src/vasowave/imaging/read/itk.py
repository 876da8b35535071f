"""Images that SimpleITK reads: NRRD, NIfTI, MetaImage, RAW with its header; axes turned as DICOM counts them."""

import warnings
from pathlib import Path
from typing import Any

import numpy as np

from vasowave.errors import InputError, VasowaveWarning
from vasowave.imaging.read.nifti import require_whole
from vasowave.imaging.read.volume import Volume

MISSING = "reading and writing images needs the extra 'imaging': install vasowave[imaging]"


def itk() -> Any:
    """Return the module SimpleITK; `InputError` without the extra."""
    try:
        import SimpleITK
    except ImportError:
        raise InputError(MISSING) from None
    return SimpleITK


def read_itk(path: Path) -> Volume:
    """Read one image file; `InputError` where it is truncated, foreign or not three-dimensional."""
    if path.suffix.lower() == ".raw":
        path = _header_of(path)
    if path.name.lower().endswith((".nii", ".nii.gz")):
        require_whole(path)
    try:
        image = itk().ReadImage(str(path))
    except RuntimeError:
        raise InputError(
            f"{path}: not an image that can be read (NRRD, NIfTI, MetaImage), truncated, or its data file is missing"
        ) from None
    if image.GetDimension() != 3 or image.GetNumberOfComponentsPerPixel() != 1:
        raise InputError(f"{path}: not a three-dimensional grey-level image; export one channel of a 3D volume")
    return upright(image, path)


def _header_of(path: Path) -> Path:
    """Return the header beside a .raw file, which says nothing about itself."""
    headers = [path.with_suffix(suffix) for suffix in (".mhd", ".nhdr") if path.with_suffix(suffix).exists()]
    if not headers:
        wanted = f"{path.stem}.mhd (MetaImage) or {path.stem}.nhdr (NRRD)"
        raise InputError(f"{path}: RAW says nothing about its size; put its header beside it: {wanted}")
    return headers[0]


def upright(image: Any, source: Path) -> Volume:
    """Return the volume with its axes turned to x left, y posterior, z superior, as DICOM counts."""
    if not np.allclose(image.GetDirection(), np.eye(3).ravel(), atol=1e-4):
        image = itk().DICOMOrient(image, "LPS")
        if not np.allclose(image.GetDirection(), np.eye(3).ravel(), atol=1e-2):
            warnings.warn(
                f"{source}: its axes are oblique; places count along the image's own axes, from its first voxel",
                VasowaveWarning,
                stacklevel=4,
            )
    grey = itk().GetArrayFromImage(image)
    return Volume(grey, np.array(image.GetSpacing())[::-1] / 10, np.array(image.GetOrigin())[::-1] / 10)


def write_volume(volume: Volume, path: str | Path) -> None:
    """Write `volume` as NRRD, NIfTI or MetaImage (by the suffix), spacing in mm."""
    write_image(np.asarray(volume.grey), volume, path)


def write_image(values: np.ndarray, grid: Volume, path: str | Path) -> None:
    """Write `values` on the grid of a volume, spacing in mm; whole numbers are compressed."""
    image = itk().GetImageFromArray(values)
    image.SetSpacing([float(h) for h in grid.spacing[::-1] * 10])
    image.SetOrigin([float(h) for h in grid.origin[::-1] * 10])
    itk().WriteImage(image, str(path), bool(np.issubdtype(values.dtype, np.integer)))
