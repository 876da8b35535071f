"""DICOM: slices, each a file or a frame of one, in the order of their positions, none missing, doubled or foreign."""

from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from vasowave.base.errors import InputError
from vasowave.lung.read.findings import INVERTED
from vasowave.lung.read.folder import is_dicom, surveyed
from vasowave.lung.read.formats import VOLUMES, VolumeFormat
from vasowave.lung.read.itk import MISSING, itk, upright
from vasowave.lung.read.volume import Image


class Slice(NamedTuple):
    """What is used of one file, or of one of its frames.

    Attributes
    ----------
    name : str
        Of the file, with the frame's number.
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
_POLARITY, _WHITE = "PhotometricInterpretation", "MONOCHROME1"
_GROUPS = {
    "PlanePositionSequence": ("ImagePositionPatient",), "PlaneOrientationSequence": ("ImageOrientationPatient",),
    "PixelMeasuresSequence": ("PixelSpacing",),
    "PixelValueTransformationSequence": ("RescaleSlope", "RescaleIntercept"),
}  # fmt: skip
"""Functional groups of a frame, and what is used of each (DICOM PS3.3, C.7.6.16)."""

_SERIES_KEYS = ("SeriesInstanceUID", "Rows", "Columns", "PixelSpacing", "ImageOrientationPatient", _POLARITY)
_PROVENANCE = "PixelSpacing and the positions of its slices"


def read_dicom(path: Path) -> Image:
    """Read the one series in a folder, or the frames of one file, in the order of the slices' positions.

    Grey levels are rescaled (slope, intercept); the slice distance comes from the positions. Where the lowest level is
    white (MONOCHROME1), they are inverted before.
    """
    files = surveyed(path).dicom if path.is_dir() else [path]
    slices = [image_slice for file in files for image_slice in _slices(file)]
    if len(slices) < 3:
        alone = "" if path.is_dir() else " in this file; give the folder of the series"
        raise InputError(f"{path}: {len(slices)} DICOM slices{alone}; a series has at least 3")
    _require_one_series(path, slices)
    axes, spacing = slices[0].axes, slices[0].spacing
    normal = np.cross(*axes)
    height = np.array([normal @ image_slice.place for image_slice in slices])
    order = np.argsort(height)
    gap = _slice_distance(path, height[order], [slices[i].name for i in order])
    _require_upright(path, slices[order[0]], slices[order[-1]])
    grey, first = np.stack([slices[i].grey for i in order]), slices[order[0]].place
    is_white = slices[0].same[_POLARITY] == _WHITE
    findings = (INVERTED(source="it is MONOCHROME1"),) if is_white else ()
    if np.allclose(axes, [[1, 0, 0], [0, 1, 0]], atol=1e-4):
        size = np.array([gap, *spacing]) / 10
        return Image(grey, size, first[::-1] / 10, provenance=_PROVENANCE, findings=findings)
    image = itk().GetImageFromArray(grey)
    image.SetSpacing([float(h) for h in (spacing[1], spacing[0], gap)])
    image.SetOrigin(first.tolist())
    image.SetDirection(np.column_stack([*axes, normal]).ravel().tolist())
    return upright(image, path)._replace(provenance=_PROVENANCE, findings=findings)


def _slices(file: Path) -> list[Slice]:
    """Return what is used of one file, by frames; the library raises anything at all where it is damaged."""
    try:
        import pydicom
    except ImportError:
        raise InputError(MISSING) from None
    try:
        image = pydicom.dcmread(file)
        same = {key: str(image.get(key)) for key in _SERIES_KEYS}
        frames = int(image.get("NumberOfFrames", None) or 1)
        groups = list(image.get("PerFrameFunctionalGroupsSequence", []))
    except Exception:
        raise InputError(f"{file}: not a readable DICOM file; remove it from the folder or export again") from None
    pixels = _pixels(file, image, frames)
    shared = image.get("SharedFunctionalGroupsSequence", None) or [{}]
    if not groups and frames == 1:
        return [_slice(file.name, file, same, image, pixels[0])]
    if len(groups) != frames:
        raise InputError(f"{file}: {frames} frames without position of each; export it as enhanced DICOM or as slices")
    return [
        _slice(f"{file.name} frame {k + 1}", file, same, _frame(image, shared[0], group), pixels[k])
        for k, group in enumerate(groups)
    ]


def _frame(image: Any, shared: Any, group: Any) -> dict[str, Any]:
    """Return position, orientation, spacing and scale of a frame, from its own functional groups or the shared ones."""
    values: dict[str, Any] = {}
    for sequence, keys in _GROUPS.items():
        entries = group.get(sequence, None) or shared.get(sequence, None) or [image]
        values |= {key: entries[0].get(key, None) for key in keys if entries[0].get(key, None) is not None}
    return values


def _slice(name: str, file: Path, same: dict[str, str], about: Any, pixels: np.ndarray) -> Slice:
    """Return one slice of what its header, or the groups of its frame, say about it."""
    try:
        axes = np.array(about.get("ImageOrientationPatient"), dtype=float).reshape(2, 3)
        place = np.array(about.get("ImagePositionPatient"), dtype=float).reshape(3)
        spacing = np.array(about.get("PixelSpacing"), dtype=float).reshape(2)
    except Exception:
        raise InputError(
            f"{file}: a slice without position, orientation or pixel spacing; export the series again"
        ) from None
    if not (np.isfinite(np.concatenate([axes.ravel(), place, spacing])).all() and (spacing > 0).all()):
        raise InputError(f"{file}: its position, orientation or pixel spacing is not a finite number; export it again")
    if not np.allclose(axes @ axes.T, np.eye(2), atol=1e-2):
        raise InputError(f"{file}: the directions of its rows and columns are not perpendicular; export it again")
    same = same | {"PixelSpacing": str(spacing.tolist()), "ImageOrientationPatient": str(axes.tolist())}
    try:
        grey = pixels * np.float32(about.get("RescaleSlope", None) or 1)
        grey += np.float32(about.get("RescaleIntercept", None) or 0)
    except Exception:
        raise _unreadable(file) from None
    return Slice(name, same, axes, place, spacing, grey)


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


def _pixels(file: Path, image: Any, frames: int) -> np.ndarray:
    """Return stored values, (frame, row, column), with the lowest as black."""
    try:
        grey = image.pixel_array
        grey = grey[None] if frames == 1 and grey.ndim == 2 else grey
        if grey.ndim != 3 or len(grey) != frames:
            raise ValueError
        if image.get(_POLARITY) == _WHITE:
            signed = image.get("PixelRepresentation", 0) == 1
            grey = (-1 if signed else 2 ** int(image.BitsStored) - 1) - grey.astype(np.int32)
        return grey.astype(np.float32)
    except Exception:
        raise _unreadable(file) from None


def _unreadable(file: Path) -> InputError:
    return InputError(f"{file}: its pixels are truncated or compressed in an unknown way; export it again")


def _is_dicom_source(path: Path, start: bytes) -> bool:
    return bool(surveyed(path).dicom) if path.is_dir() else path.is_file() and is_dicom(path)


VOLUMES.register(VolumeFormat("dicom", "DICOM series", (), _is_dicom_source, read_dicom))
