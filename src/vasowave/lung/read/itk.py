"""Images that SimpleITK reads: NRRD, NIfTI, MetaImage; axes turned as DICOM counts them."""

from pathlib import Path
from typing import Any

import numpy as np

from vasowave.base.errors import EXTRAS, InputError
from vasowave.base.io.files import write_folder
from vasowave.lung.read.formats import VOLUMES, VolumeFormat
from vasowave.lung.read.volume import SKEWED, UNSIZED, Image, Volume

_IN_MILLIMETERS = (".gipl", ".mgh", ".mgz")
MISSING = f"reading and writing images needs the extra 'imaging': {EXTRAS}"


def itk() -> Any:
    """Return the module SimpleITK; `InputError` without the extra."""
    try:
        import SimpleITK
    except ImportError:
        raise InputError(MISSING) from None
    return SimpleITK


def read_itk(path: Path) -> Image:
    """Read one image file; `InputError` where it is truncated, foreign or not three-dimensional.

    Compiled code reads it, which a damaged file can crash or hang: it is called in another process.
    """
    try:
        image = itk().ReadImage(str(path))
    except RuntimeError:
        raise InputError(
            f"{path}: not an image that can be read (NRRD, NIfTI, MetaImage), truncated, or its data file is missing"
        ) from None
    if image.GetDimension() == 4 and 1 in (image.GetSize()[0], image.GetSize()[3]):
        image = image[:, :, :, 0] if image.GetSize()[3] == 1 else image[0]
    if image.GetDimension() != 3 or image.GetNumberOfComponentsPerPixel() != 1:
        raise InputError(f"{path}: not a three-dimensional grey-level image; export one channel of a 3D volume")
    return upright(image, path)


def upright(image: Any, source: Path) -> Image:
    """Return the image with its axes permuted and flipped to about x left, y posterior, z superior, as DICOM counts."""
    axes = np.array(image.GetDirection()).reshape(3, 3)
    if not np.allclose(axes @ axes.T, np.eye(3), atol=SKEWED):
        raise InputError(f"{source}: the directions of its axes are not perpendicular; its header is damaged")
    if not np.allclose(axes, np.eye(3), atol=1e-4):
        image = itk().DICOMOrient(image, "LPS")
        axes = np.array(image.GetDirection()).reshape(3, 3)
    grey, spacing, origin = (
        itk().GetArrayViewFromImage(image).copy(),
        np.array(image.GetSpacing()),
        np.array(image.GetOrigin()),
    )
    return Image(grey, spacing[::-1] / 10, origin[::-1] / 10, axes=axes[::-1, ::-1])


def write_volume(volume: Volume, path: str | Path) -> None:
    """Write `volume` as NRRD, NIfTI or MetaImage (by the suffix), spacing in mm."""
    write_image(np.asarray(volume.grey), volume, path)


def write_image(values: np.ndarray, grid: Volume, path: str | Path) -> None:
    """Write `values` on the grid of a volume, as it lies in the world, in mm; whole numbers are compressed."""
    path = Path(path)
    image = itk().GetImageFromArray(values)
    image.SetSpacing([float(h) for h in grid.spacing[::-1] * 10])
    image.SetOrigin([float(h) for h in grid.origin[::-1] * 10])
    image.SetDirection(grid.axes[::-1, ::-1].ravel().tolist())
    with write_folder(path.parent) as fresh:
        try:
            itk().WriteImage(image, str(fresh / path.name), bool(np.issubdtype(values.dtype, np.integer)))
        except RuntimeError as error:
            reason = str(error).splitlines()[-1].strip()
            raise InputError(f"{path}: the image cannot be written ({reason}); is there room? See its ending") from None


def _read_other(path: Path) -> Image:
    """Read an image of a kind that has no module here; its voxels are sized where the format's lengths are in mm."""
    image = read_itk(path)
    if path.suffix.lower() in _IN_MILLIMETERS:
        return image._replace(provenance="its header, in mm as files of its kind are")
    return image._replace(spacing=UNSIZED, provenance="files of its kind name no unit of length")


VOLUMES.register(VolumeFormat("other image", "image that SimpleITK reads", (), None, _read_other))
