"""Volumes that only their programs open: each is named, with what its program exports instead."""

from pathlib import Path
from typing import NoReturn

from vasowave.base.errors import InputError
from vasowave.lung.read.formats import VOLUMES, VolumeFormat

_FIJI = "open it in Fiji and save it as TIFF, which keeps its scale"
_EXPORTS = {
    ".czi": ("Zeiss ZEN", _FIJI), ".lif": ("Leica LAS X", _FIJI), ".nd2": ("Nikon NIS-Elements", _FIJI),
    ".oir": ("Olympus FluoView", _FIJI), ".ims": ("Imaris", _FIJI),
    ".txm": ("Zeiss Xradia", "in XM3DViewer, export the volume as DICOM or as TIFF"),
    ".aim": ("Scanco", "export the measurement as ISQ or as DICOM"),
    ".nc": ("netCDF", "in Mango, ImageJ or Python, write it as NRRD or MetaImage, with its voxels' size in mm"),
    ".mnc": ("MINC", "mnc2nii writes it as NIfTI, with its orientation"),
}  # fmt: skip


def _refuse(path: Path) -> NoReturn:
    program, steps = _EXPORTS[path.suffix.lower()]
    raise InputError(f"{path}: an image of {program}, which is not read: {steps}. Then open that")


VOLUMES.register(VolumeFormat("foreign", "a program's own image", tuple(_EXPORTS), None, _refuse, _refuse))
