"""OME-Zarr up to version 0.4 (Zarr 2): the finest level of the first image, read through netCDF-C."""

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from vasowave.base.errors import InputError
from vasowave.base.findings import look_kind
from vasowave.base.io.files import link_without_signs
from vasowave.base.io.textfile import read_bytes
from vasowave.base.stores import parsed
from vasowave.lung.read.folder import is_zarr
from vasowave.lung.read.formats import VOLUMES, Contents, VolumeFormat
from vasowave.lung.read.payload import centimeters
from vasowave.lung.read.volume import UNSIZED, Image

EMPTY_CHUNKS = look_kind(
    "image.chunks-empty",
    "{count} of the {total} pieces of the store have no file; their voxels are {fill}. {remedy}",
    "If the image is not empty there, copy the store again.",
)
_INSTEAD = "save it as OME-TIFF, NRRD or HDF5 (napari, Fiji), or as OME-Zarr 0.4"
_SPACE = ("z", "y", "x")


class _Level(NamedTuple):
    """The finest level of an image: folder, name in it, axes, their steps (cm, NaN without a unit) and `.zarray`."""

    folder: Path
    name: str
    axes: Sequence[str]
    steps: np.ndarray
    array: dict[str, Any]


def _content(path: Path) -> Any:
    try:
        return parsed(read_bytes(path))
    except ValueError:
        raise InputError(f"{path}: damaged, not JSON; copy the store again") from None


def _finest(path: Path) -> _Level:
    """Return the finest level of the first image in a store."""
    if (path / "zarr.json").exists():
        raise InputError(f"{path}: a Zarr store of version 3 (OME-Zarr 0.5), which is not read; {_INSTEAD}")
    for folder in (path, path / "0"):  # the second as bioformats2raw writes them
        attributes = _content(folder / ".zattrs") if (folder / ".zattrs").is_file() else {}
        if isinstance(attributes, dict) and attributes.get("multiscales"):
            break
    else:
        raise InputError(f"{path}: a Zarr store without an image of OME (multiscales); {_INSTEAD}")
    _require_single(path, folder, attributes["multiscales"])
    try:
        scales = attributes["multiscales"][0]
        level = scales["datasets"][0]
        name = str(level["path"])
        array = _content(folder / name / ".zarray")
        axes = [axis if isinstance(axis, str) else axis["name"] for axis in scales.get("axes", "tczyx")]
        names = [str(axis.get("unit", "")) if isinstance(axis, dict) else "" for axis in scales.get("axes", "tczyx")]
        steps = np.array([centimeters(unit) or np.nan for unit in names])
        changes = [*level.get("coordinateTransformations", ()), *scales.get("coordinateTransformations", ())]
        scaled = [np.array(change["scale"], dtype=float) for change in changes if change["type"] == "scale"]
        if any(scale.shape != steps.shape for scale in scaled):
            raise ValueError
        steps = steps * math.prod(scaled) if scaled else np.full(len(axes), np.nan)
        shape = [int(count) for count in array["shape"]]
        sound = len(shape) == len(axes) == len(steps) and set(_SPACE) <= set(axes) and min(shape) > 0
        sound = sound and np.dtype(array["dtype"]).kind in "iuf" and ".." not in Path(name).parts
    except (LookupError, TypeError, ValueError, AttributeError, OverflowError):
        sound = False
    if not sound:
        raise InputError(f"{path}: the description of its image is damaged or of another version; {_INSTEAD}")
    many = [axis for axis, count in zip(axes, shape, strict=True) if axis not in _SPACE and count > 1]
    if many:
        raise InputError(f"{path}: several images along {', '.join(many)}; save one channel and one time alone")
    return _Level(folder, name, axes, steps[[axes.index(axis) for axis in _SPACE]], array)


def _require_single(path: Path, folder: Path, images: Sequence[Any]) -> None:
    """Refuse a store of several images: side by side in its description, or as the series that a converter wrote."""
    if len(images) > 1:
        raise InputError(f"{path}: describes {len(images)} images; {_INSTEAD}, each image alone")
    if folder != path and (path / "1").is_dir():
        series = sorted(entry.name for entry in path.iterdir() if entry.is_dir() and entry.name.isdecimal())
        raise InputError(f"{path}: holds {len(series)} images ({', '.join(series)}); give one of these folders")


def check_zarr(path: Path) -> Contents:
    """Return the bytes of the voxels, and whether their size is said."""
    level = _finest(path)
    size = math.prod(level.array["shape"]) * np.dtype(level.array["dtype"]).itemsize
    sized = bool(np.isfinite(level.steps).all() and (level.steps > 0).all())
    return Contents(size, "" if sized else "its axes say no scale with a unit of length")


def read_zarr(path: Path) -> Image:
    """Read the finest level; any exception of netCDF-C, or the end of the process."""
    import netCDF4

    level = _finest(path)
    with link_without_signs(level.folder) as link, netCDF4.Dataset(f"file://{link}#mode=zarr,file") as file:
        file.set_auto_maskandscale(False)
        grey = np.asarray(file[level.name][:])
    extra = tuple(i for i, axis in enumerate(level.axes) if axis not in _SPACE)
    space = [axis for axis in level.axes if axis in _SPACE]
    grey = grey.squeeze(extra).transpose([space.index(axis) for axis in _SPACE])
    array, written = level.array, level.folder / level.name
    total = math.prod(-(-count // step) for count, step in zip(array["shape"], array["chunks"], strict=True))
    present = sum(1 for chunk in written.rglob("*") if chunk.is_file() and not chunk.name.startswith("."))
    missing = EMPTY_CHUNKS(count=total - present, total=total, fill=str(array.get("fill_value")))
    findings = (missing,) if present < total else ()
    steps = level.steps if np.isfinite(level.steps).all() else UNSIZED
    return Image(grey, steps, np.zeros(3), provenance="the scale of its OME-Zarr axes", findings=findings)


VOLUMES.register(
    VolumeFormat("zarr", "OME-Zarr store", (".zarr",), lambda path, start: is_zarr(path), read_zarr, check_zarr,
                 oriented=False)
)  # fmt: skip
