"""A grey-level volume on a grid of known spacing, read from a DICOM series or an image file."""

import warnings
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from vasowave.errors import InputError, VasowaveWarning
from vasowave.imaging.nifti import require_whole

_MISSING = "reading images needs the extra 'imaging': install vasowave[imaging]"


@dataclass(frozen=True, eq=False)
class Volume:
    """Grey levels and where they lie.

    Attributes
    ----------
    grey : float32 array, shape (z, y, x)
    spacing : float array, shape (3,)
        Distance of neighboring voxels along z, y, x, cm.
    origin : float array, shape (3,)
        Position of voxel (0, 0, 0), z, y, x, cm.

    Raises
    ------
    InputError
        Not three-dimensional, values that are not finite, one grey level everywhere, a spacing that is not positive.
    """

    grey: np.ndarray
    spacing: np.ndarray
    origin: np.ndarray

    def __post_init__(self) -> None:
        """Check the grid and the grey levels once, and freeze them."""
        for name, dtype in (("grey", np.float32), ("spacing", np.float64), ("origin", np.float64)):
            array = np.asarray(getattr(self, name), dtype=dtype).view()
            array.setflags(write=False)
            object.__setattr__(self, name, array)
        if self.grey.ndim != 3 or min(self.grey.shape) < 3:
            raise InputError(f"volume: shape {self.grey.shape}; a stack of at least 3 x 3 x 3 voxels is needed")
        if self.spacing.shape != (3,) or not (np.isfinite(self.spacing).all() and (self.spacing > 0).all()):
            raise InputError(f"volume: spacing {self.spacing} cm; give three positive numbers (z, y, x)")
        if not np.isfinite(self.grey).all():
            raise InputError("volume: grey levels that are not finite (NaN or infinity); repair the reconstruction")
        if self.grey.min() == self.grey.max():
            raise InputError(f"volume: every voxel has grey level {self.grey.flat[0]:g}; is this the right file?")


def isotropic(volume: Volume) -> Volume:
    """Return `volume` resampled linearly to cubes of its smallest spacing; unchanged if it is cubic within 0.1 %."""
    from scipy.ndimage import zoom

    smallest = volume.spacing.min()
    if np.allclose(volume.spacing, smallest, rtol=1e-3):
        return volume
    counts = np.array(volume.grey.shape)
    finer = np.maximum(np.round((counts - 1) * volume.spacing / smallest).astype(int) + 1, 3)
    grey = zoom(volume.grey, finer / counts, order=1, grid_mode=False)
    return Volume(grey, (counts - 1) * volume.spacing / (np.array(grey.shape) - 1), volume.origin)


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
        volume = _read_itk(path)
    return volume if spacing is None else Volume(volume.grey, np.full(3, spacing), volume.origin)


def read_dicom_series(folder: Path) -> Volume:
    """Read the one DICOM series in `folder`, in the order of the slices' positions.

    Grey levels are rescaled (slope, intercept); the slice distance comes from the positions.
    """
    try:
        import pydicom
    except ImportError:
        raise InputError(_MISSING) from None
    slices = []
    for file in sorted(p for p in folder.iterdir() if p.is_file() and not p.name.startswith(".")):
        try:
            slices.append((file.name, pydicom.dcmread(file)))
        except Exception:
            raise InputError(f"{file}: not a readable DICOM file; remove it from the folder or export again") from None
    if len(slices) < 3:
        raise InputError(f"{folder}: {len(slices)} DICOM slices; a series has at least 3")
    _require_one_series(folder, slices)
    try:
        normal = np.cross(*np.array(slices[0][1].ImageOrientationPatient, dtype=float).reshape(2, 3))
        height = np.array([normal @ np.array(image.ImagePositionPatient, dtype=float) for _, image in slices])
        in_plane = np.array(slices[0][1].PixelSpacing, dtype=float)
    except (AttributeError, TypeError, ValueError):
        raise InputError(
            f"{folder}: slices without position, orientation or pixel spacing; export them again"
        ) from None
    order = np.argsort(height)
    gap = _slice_distance(folder, height[order], [slices[i][0] for i in order])
    planes = [_pixels(folder / slices[i][0], slices[i][1]) for i in order]
    first = np.array(slices[order[0]][1].ImagePositionPatient, dtype=float)
    axes = np.array(slices[0][1].ImageOrientationPatient, dtype=float).reshape(2, 3)
    if np.allclose(axes, [[1, 0, 0], [0, 1, 0]], atol=1e-4):
        return Volume(np.stack(planes), np.array([gap, *in_plane]) / 10, first[::-1] / 10)
    image = _itk().GetImageFromArray(np.stack(planes))
    image.SetSpacing([float(h) for h in (in_plane[1], in_plane[0], gap)])
    image.SetOrigin(first.tolist())
    image.SetDirection(np.column_stack([*axes, normal]).ravel().tolist())
    return _upright(image, folder)


def _require_one_series(folder: Path, slices: list[tuple[str, Any]]) -> None:
    for key in ("SeriesInstanceUID", "Rows", "Columns", "PixelSpacing", "ImageOrientationPatient"):
        values = [str(image.get(key)) for _, image in slices]
        other = next((i for i, value in enumerate(values) if value != values[0]), None)
        if other is not None:
            raise InputError(
                f"{folder}: more than one series: {slices[0][0]} and {slices[other][0]} differ in {key}; "
                "put each series in a folder of its own"
            )


def _slice_distance(folder: Path, height: np.ndarray, names: list[str]) -> float:
    """Return the distance of the slices, mm; missing and doubled slices are errors."""
    gaps = np.diff(height)
    usual = float(np.median(gaps))
    if usual <= 0 or gaps.min() < 0.5 * usual:
        i = int(gaps.argmin())
        raise InputError(f"{folder}: {names[i]} and {names[i + 1]} lie at the same place; remove one")
    if gaps.max() > 1.5 * usual:
        i = int(gaps.argmax())
        lost = round(gaps[i] / usual) - 1
        raise InputError(
            f"{folder}: {lost} slices missing between {names[i]} and {names[i + 1]}; export the series again"
        )
    return float(gaps.mean())


def _pixels(file: Path, image: Any) -> np.ndarray:
    try:
        grey = image.pixel_array.astype(np.float32)
    except Exception:
        raise InputError(f"{file}: its pixels are truncated or compressed in an unknown way; export it again") from None
    return grey * np.float32(image.get("RescaleSlope", 1)) + np.float32(image.get("RescaleIntercept", 0))


def _read_tiff(path: Path, spacing: float | None) -> Volume:
    try:
        import tifffile
    except ImportError:
        raise InputError(_MISSING) from None
    if spacing is None:
        raise InputError(f"{path}: a TIFF stack says nothing reliable about its voxel size; give spacing in cm")
    try:
        grey = tifffile.imread(path)
    except Exception:
        raise InputError(f"{path}: not a readable TIFF stack; export it again") from None
    return Volume(grey, np.full(3, spacing), np.zeros(3))


def _itk() -> Any:
    try:
        import SimpleITK
    except ImportError:
        raise InputError(_MISSING) from None
    return SimpleITK


def _read_itk(path: Path) -> Volume:
    if path.suffix.lower() == ".raw":
        path = _header_of(path)
    if path.name.lower().endswith((".nii", ".nii.gz")):
        require_whole(path)
    try:
        image = _itk().ReadImage(str(path))
    except RuntimeError:
        raise InputError(
            f"{path}: not an image that can be read (NRRD, NIfTI, MetaImage), truncated, or its data file is missing"
        ) from None
    if image.GetDimension() != 3 or image.GetNumberOfComponentsPerPixel() != 1:
        raise InputError(f"{path}: not a three-dimensional grey-level image; export one channel of a 3D volume")
    return _upright(image, path)


def _header_of(path: Path) -> Path:
    """Return the header beside a .raw file, which says nothing about itself."""
    found = [path.with_suffix(suffix) for suffix in (".mhd", ".nhdr") if path.with_suffix(suffix).exists()]
    if not found:
        wanted = f"{path.stem}.mhd (MetaImage) or {path.stem}.nhdr (NRRD)"
        raise InputError(f"{path}: RAW says nothing about its size; put its header beside it: {wanted}")
    return found[0]


def _upright(image: Any, source: Path) -> Volume:
    """Return the volume with its axes turned to x left, y posterior, z superior, as DICOM counts."""
    if not np.allclose(image.GetDirection(), np.eye(3).ravel(), atol=1e-4):
        image = _itk().DICOMOrient(image, "LPS")
        if not np.allclose(image.GetDirection(), np.eye(3).ravel(), atol=1e-2):
            warnings.warn(
                f"{source}: its axes are oblique; places count along the image's own axes, from its first voxel",
                VasowaveWarning,
                stacklevel=4,
            )
    grey = _itk().GetArrayFromImage(image)
    return Volume(grey, np.array(image.GetSpacing())[::-1] / 10, np.array(image.GetOrigin())[::-1] / 10)


def write_volume(volume: Volume, path: str | Path) -> None:
    """Write `volume` as NRRD, NIfTI or MetaImage (by the suffix), spacing in mm."""
    image = _itk().GetImageFromArray(np.asarray(volume.grey))
    image.SetSpacing([float(h) for h in volume.spacing[::-1] * 10])
    image.SetOrigin([float(h) for h in volume.origin[::-1] * 10])
    _itk().WriteImage(image, str(path))
