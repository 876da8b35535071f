"""DICOM series: slices in the order of their positions, none missing, doubled or foreign."""

from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from vasowave.base.errors import InputError
from vasowave.lung.read.formats import VOLUMES, VolumeFormat
from vasowave.lung.read.itk import MISSING, itk, upright
from vasowave.lung.read.volume import Image


class Slice(NamedTuple):
    """What is used of one file.

    Attributes
    ----------
    name : str
        Of the file.
    same : dict of str to str
        What all slices of a series have in common.
    axes : float array, shape (2, 3)
        Directions of rows and columns.
    place : float array, shape (3,)
        Of the first voxel, mm.
    spacing : float array, shape (2,)
        Of rows and columns, mm.
    grey : float32 array, shape (row, column)
    """

    name: str
    same: dict[str, str]
    axes: np.ndarray
    place: np.ndarray
    spacing: np.ndarray
    grey: np.ndarray


_MAX_SHIFT_VOXELS = 1.0
"""Voxels by which the last slice may stand beside the first; rounded positions stay far below."""

_SERIES_KEYS = ("SeriesInstanceUID", "Rows", "Columns", "PixelSpacing", "ImageOrientationPatient")


def read_dicom_series(folder: Path) -> Image:
    """Read the one DICOM series in `folder`, in the order of the slices' positions.

    Grey levels are rescaled (slope, intercept); the slice distance comes from the positions.
    """
    files = sorted(p for p in folder.iterdir() if p.is_file() and not p.name.startswith("."))
    slices = [_slice(file) for file in files]
    if len(slices) < 3:
        raise InputError(f"{folder}: {len(slices)} DICOM slices; a series has at least 3")
    _require_one_series(folder, slices)
    axes, spacing = slices[0].axes, slices[0].spacing
    normal = np.cross(*axes)
    height = np.array([normal @ image_slice.place for image_slice in slices])
    order = np.argsort(height)
    gap = _slice_distance(folder, height[order], [slices[i].name for i in order])
    _require_upright(folder, slices[order[0]], slices[order[-1]])
    grey, first = np.stack([slices[i].grey for i in order]), slices[order[0]].place
    if np.allclose(axes, [[1, 0, 0], [0, 1, 0]], atol=1e-4):
        return Image(grey, np.array([gap, *spacing]) / 10, first[::-1] / 10)
    image = itk().GetImageFromArray(grey)
    image.SetSpacing([float(h) for h in (spacing[1], spacing[0], gap)])
    image.SetOrigin(first.tolist())
    image.SetDirection(np.column_stack([*axes, normal]).ravel().tolist())
    return upright(image, folder)


def _slice(file: Path) -> Slice:
    """Return what is used of one file; the library raises anything at all where it is damaged."""
    try:
        import pydicom
    except ImportError:
        raise InputError(MISSING) from None
    try:
        image = pydicom.dcmread(file)
        same = {key: str(image.get(key)) for key in _SERIES_KEYS}
    except Exception:
        raise InputError(f"{file}: not a readable DICOM file; remove it from the folder or export again") from None
    try:
        axes = np.array(image.ImageOrientationPatient, dtype=float).reshape(2, 3)
        place = np.array(image.ImagePositionPatient, dtype=float).reshape(3)
        spacing = np.array(image.PixelSpacing, dtype=float).reshape(2)
    except Exception:
        raise InputError(
            f"{file}: a slice without position, orientation or pixel spacing; export the series again"
        ) from None
    if not (np.isfinite(np.concatenate([axes.ravel(), place, spacing])).all() and (spacing > 0).all()):
        raise InputError(f"{file}: its position, orientation or pixel spacing is no finite number; export it again")
    if not np.allclose(axes @ axes.T, np.eye(2), atol=1e-2):
        raise InputError(f"{file}: the directions of its rows and columns are not perpendicular; export it again")
    return Slice(file.name, same, axes, place, spacing, _pixels(file, image))


def _require_one_series(folder: Path, slices: list[Slice]) -> None:
    for key in _SERIES_KEYS:
        mismatch = next((candidate for candidate in slices if candidate.same[key] != slices[0].same[key]), None)
        if mismatch is not None:
            raise InputError(
                f"{folder}: more than one series: {slices[0].name} and {mismatch.name} differ in {key}; "
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


def _require_upright(folder: Path, first: Slice, last: Slice) -> None:
    """Raise `InputError` if the last slice does not stand above the first, as with a tilted gantry."""
    shift = np.abs(first.axes @ (last.place - first.place)) / first.spacing[::-1]
    if shift.max() > _MAX_SHIFT_VOXELS:
        raise InputError(
            f"{folder}: slices are shifted sideways ({last.name} by {shift.max():.1f} voxels from {first.name}), as "
            "those of a tilted gantry; resample the series to upright slices (Slicer, dcm2niix) and give the result"
        )


def _pixels(file: Path, image: Any) -> np.ndarray:
    try:
        grey = image.pixel_array.astype(np.float32)
        if grey.ndim != 2:
            raise ValueError
        grey *= np.float32(image.get("RescaleSlope", 1))
        grey += np.float32(image.get("RescaleIntercept", 0))
        return grey
    except Exception:
        raise InputError(f"{file}: its pixels are truncated or compressed in an unknown way; export it again") from None


VOLUMES.register(VolumeFormat("dicom", "DICOM series", (), lambda path, start: path.is_dir(), read_dicom_series))
