"""DICOM series: slices in the order of their positions, none missing, doubled or foreign."""

from pathlib import Path
from typing import Any

import numpy as np

from vasowave.errors import InputError
from vasowave.imaging.read.itk import MISSING, itk, upright
from vasowave.imaging.read.volume import Volume


def read_dicom_series(folder: Path) -> Volume:
    """Read the one DICOM series in `folder`, in the order of the slices' positions.

    Grey levels are rescaled (slope, intercept); the slice distance comes from the positions.
    """
    try:
        import pydicom
    except ImportError:
        raise InputError(MISSING) from None
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
    image = itk().GetImageFromArray(np.stack(planes))
    image.SetSpacing([float(h) for h in (in_plane[1], in_plane[0], gap)])
    image.SetOrigin(first.tolist())
    image.SetDirection(np.column_stack([*axes, normal]).ravel().tolist())
    return upright(image, folder)


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
