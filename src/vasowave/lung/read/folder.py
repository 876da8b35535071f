"""What lies in a folder: one file with a volume, a DICOM series, or slices as pictures."""

import os
import re
from pathlib import Path
from typing import NamedTuple

from vasowave.base.errors import InputError
from vasowave.base.findings import Finding
from vasowave.base.io.textfile import read_start
from vasowave.lung.read.findings import LEFT_OUT
from vasowave.lung.read.formats import VOLUMES
from vasowave.lung.read.raw import DATA, HEADERS
from vasowave.lung.read.sidecars import SIDECARS

PICTURES = (".bmp", ".png", ".jpg", ".jpeg", ".jp2", ".tif", ".tiff")
_DICOM_ENDINGS = (".dcm", ".dic", ".dicom", ".ima")
_DICOM_STARTS = (b"\x08\x00", b"\x02\x00")
"""First tag of a file without the preamble."""
_HARMLESS = re.compile(
    r"thumbs\.db|desktop\.ini|dicomdir|readme.*|license.*|.*\.(md|pdf|docx?|xlsx?|csv|json|xml|html?|zip|bat)", re.I
)
"""Names of files that are never slices."""
_SHOWN = 4


class Survey(NamedTuple):
    """The files of a folder by what they are."""

    volumes: list[Path]
    dicom: list[Path]
    pictures: list[Path]
    texts: list[Path]
    unlike: list[Path]


def surveyed(folder: Path) -> Survey:
    """Return what lies in a folder, hidden files left out."""
    files = sorted(path for path in folder.iterdir() if path.is_file() and not path.name.startswith("."))
    has_data = any(path.suffix.lower() in DATA for path in files)
    survey = Survey([], [], [], [], [])
    for path in files:
        name = path.name.lower()
        if re.fullmatch(_HARMLESS, name):
            continue
        if name.endswith(".mat"):  # a recording, or somebody's notes; an array of voxels is named itself
            survey.unlike.append(path)
        elif is_dicom(path):
            survey.dicom.append(path)
        elif name.endswith(PICTURES):
            survey.pictures.append(path)
        elif name.endswith(VOLUMES.suffixes) and (has_data or not name.endswith(HEADERS)):
            survey.volumes.append(path)
        elif name.endswith(SIDECARS):
            survey.texts.append(path)
        else:
            survey.unlike.append(path)
    if survey.volumes:  # whose voxels these are
        survey.unlike[:] = [path for path in survey.unlike if path.suffix.lower() not in (*DATA, ".zraw")]
    return survey


def is_zarr(path: Path) -> bool:
    """Whether a folder is a Zarr store."""
    return any((path / name).is_file() for name in (".zattrs", ".zgroup", ".zarray", "zarr.json"))


def is_dicom(path: Path) -> bool:
    """Whether a file is DICOM by its ending or its first bytes."""
    if path.suffix.lower() in _DICOM_ENDINGS:
        return True
    if path.suffix.lower() in PICTURES:
        return False
    start = read_start(path, 132)
    has_ending = bool(re.fullmatch(r"\.[A-Za-z]\w{1,5}", path.suffix))
    return start[128:] == b"DICM" or (not has_ending and start.startswith(_DICOM_STARTS))


def resolved(path: Path) -> tuple[Path, tuple[Finding, ...]]:
    """Return the folder, or the one file in it that holds the volume, and a finding of files that were left out.

    Raises
    ------
    InputError
        Nothing that is an image, or more than one thing.
    """
    survey = surveyed(path)
    stems = {re.sub(r"(\.vol|\.raw|\.nii)?\.\w+$", "", volume.name) for volume in survey.volumes}
    pictures = len(survey.pictures) >= 2
    kinds = [
        *([f"volumes ({_names(survey.volumes)})"] if survey.volumes else []),
        *([f"DICOM files ({_names(survey.dicom)})"] if survey.dicom else []),
        *([f"slices ({_names(survey.pictures)})"] if pictures else []),
    ]
    if not kinds and not survey.pictures:
        if len(within := [place for place, _, _ in os.walk(path) if _has_image(Path(place))]) == 1:
            return resolved(Path(within[0]))
        if within:
            shown = ", ".join(Path(place).relative_to(path).as_posix() for place in within[:_SHOWN])
            raise InputError(f"{path}: holds several folders with images: {shown}; give one of them")
        raise InputError(f"{path}: no image in this folder; give a folder of DICOM files or slices, or one file")
    if len(kinds) > 1 or len(stems) > 1:
        raise InputError(f"{path}: holds more than one image: {'; '.join(kinds)}; give one file, or move the rest away")
    findings = (LEFT_OUT(count=len(survey.unlike), names=_names(survey.unlike)),) if survey.unlike else ()
    if survey.volumes:
        header_first = sorted(survey.volumes, key=lambda volume: [volume.name.lower().endswith(end) for end in HEADERS])
        return header_first[-1], findings
    return (path if survey.dicom or pictures else survey.pictures[0]), findings


def _has_image(folder: Path) -> bool:
    """Whether a folder holds a volume, DICOM files or slices itself."""
    survey = surveyed(folder)
    return bool(survey.volumes or survey.dicom or len(survey.pictures) >= 2)


def _names(paths: list[Path]) -> str:
    names = ", ".join(path.name for path in paths[:_SHOWN])
    return names if len(paths) <= _SHOWN else f"{names} … {len(paths)} in all"
