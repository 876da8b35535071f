"""The door for volumes: a folder or a file is looked at, read, and told what says the size of its voxels."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from vasowave.base.errors import InputError
from vasowave.base.findings import Finding, as_json, from_json, warn
from vasowave.base.io.apart import ReaderAnswer, read_apart
from vasowave.base.io.textfile import regular_file
from vasowave.lung.read.findings import VOXEL_TYPED, in_micrometers
from vasowave.lung.read.folder import is_zarr, resolved
from vasowave.lung.read.formats import VOLUMES, Contents, VolumeFormat
from vasowave.lung.read.payload import no_voxel_size
from vasowave.lung.read.raw import DATA, header_beside
from vasowave.lung.read.volume import VOXELS, Image, Volume

_SAME = 5e-3
"""Share by which a voxel size that was typed may differ from the file's: rounding."""
_AS_IT_LIES = "; columns are taken for x, rows for y, slices for z, for the file says no orientation"


def read_volume(path: str | Path, spacing: float | Sequence[float] | None = None) -> Volume:
    """Read an image: a folder (DICOM series, slices as pictures, one file), or a file.

    DICOM (classic, multi-frame), NRRD, NIfTI, MetaImage, TIFF, slices as BMP, PNG, JPEG or TIFF with the text of
    their scanner, Scanco, VFF, Amira lattices, raw voxels with the header of their scanner, HDF5, NumPy arrays. Axes
    are permuted and flipped so that z, y, x are nearest to the patient's as DICOM counts them; how far they are turned
    from these is `Volume.axes`. A file without orientation is taken as it lies: columns are x, rows y, slices z.
    Compiled libraries read in another process, within limits of time and memory.

    Parameters
    ----------
    path : path
    spacing : float or sequence of 3 floats, optional
        Voxel size in cm, z, y, x; needed where the file does not say it with its unit; replaces the file's own.

    Raises
    ------
    InputError
        Missing, truncated, damaged or unreadable file, voxels that lie outside the folder of their header, RAW without
        header, a folder of several images, a series with missing, doubled or foreign slices (each named), no voxel size
        or unit of it, a voxel size that no image of an animal has.

    Warns
    -----
    VasowaveWarning
        The file's voxel size is not the one that is given; grey levels were inverted; transforms or numbers of slices
        contradict each other; files of the folder were left out.
    """
    path = Path(path)
    if not path.exists():
        raise InputError(f"{path}: no such file or folder")
    typed = None if spacing is None else _checked_size(spacing)
    source, findings = source_of(path)
    form = VOLUMES.of(source)
    contents = form.check(source) if form.check is not None else Contents(0)
    if contents.unsized and typed is None:
        raise no_voxel_size(source, contents.unsized)
    image = _mapped(form, source) or _read(source, contents.size)
    is_sized = bool(np.isfinite(image.spacing).all()) and not contents.unsized
    if typed is None and not is_sized:
        raise no_voxel_size(source, image.provenance)
    try:
        size = image.spacing if typed is None else typed
        provenance = (image.provenance if typed is None else "what was typed") + ("" if form.oriented else _AS_IT_LIES)
        volume = Volume(image.grey, size, image.origin, image.axes, provenance)
        findings += _contradiction(image, typed) if typed is not None and is_sized else ()
    except InputError as error:
        raise InputError(f"{path}: {error}", error.cures) from None
    for finding in (*findings, *image.findings):
        warn(finding.at(path.name))
    return volume


def source_of(path: Path) -> tuple[Path, tuple[Finding, ...]]:
    """Return the folder or the file that is read: the one in a folder, the header beside raw voxels; and findings."""
    path, findings = resolved(path) if path.is_dir() and not is_zarr(path) else (path, ())
    if path.is_dir():
        return path, findings
    path = regular_file(path)
    return header_beside(path) if path.suffix.lower() in DATA else path, findings


def image_in(path: Path) -> ReaderAnswer:
    """Return spacing, origin, axes, provenance and findings of an image, and its grey levels."""
    image: Image = VOLUMES.of(path).read(path)
    spacing = image.spacing.tolist() if np.isfinite(image.spacing).all() else None
    head = [spacing, image.origin.tolist(), image.axes.tolist(), image.provenance, as_json(image.findings)]
    return ReaderAnswer(head, [image.grey])


def _mapped(form: VolumeFormat, path: Path) -> Image | None:
    """Return an image whose voxels lie in a file as in memory, None if they do not."""
    try:
        return form.mapped(path) if form.mapped is not None else None
    except InputError:
        raise
    except Exception as error:
        raise InputError(f"{path}: not {form.title} that can be read ({error}); export it again") from None


def _read(path: Path, size: int) -> Image:
    """Return the image that another process reads."""
    (spacing, origin, axes, provenance, findings), (grey,) = read_apart(
        image_in, path, "an image that can be read", content=size
    )
    spacing = np.full(3, np.nan) if spacing is None else np.array(spacing)
    return Image(grey, spacing, np.array(origin), np.array(axes), provenance, from_json(findings))


def _checked_size(spacing: float | Sequence[float]) -> np.ndarray:
    """Return a voxel size that was given, z, y, x, cm."""
    low, high = VOXELS
    sizes = np.asarray(spacing, dtype=float)
    if sizes.shape not in ((), (3,)) or not ((low <= sizes) & (sizes <= high)).all():
        raise InputError(
            f"voxel size {spacing} cm; give a positive number of cm between {low:g} and {high:g}, or three of them"
        )
    return np.array(np.broadcast_to(sizes, 3))


def _contradiction(image: Image, typed: np.ndarray) -> tuple[Finding, ...]:
    if np.allclose(image.spacing, typed, rtol=_SAME, atol=0):
        return ()
    return (VOXEL_TYPED(size=in_micrometers(image.spacing), source=image.provenance, typed=in_micrometers(typed)),)
