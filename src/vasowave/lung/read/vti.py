"""Images of VTK (.vti): one piece, by point or by cell. VTK names no unit, so the size of a voxel is asked for."""

from pathlib import Path
from xml.etree import ElementTree

import numpy as np

from vasowave.base.errors import InputError
from vasowave.base.io.textfile import read_bytes
from vasowave.lung.read.formats import VOLUMES, VolumeFormat
from vasowave.lung.read.itk import itk, upright
from vasowave.lung.read.volume import UNSIZED, Image
from vasowave.lung.read.vtk_arrays import DAMAGE, TYPES, array_of, document


def read_vti(path: Path) -> Image:
    """Read an image of VTK; `InputError` unless it is one piece of grey levels, whole."""
    try:
        grey, fields = _content(path)
        image = itk().GetImageFromArray(grey)
        image.SetDirection(_numbers(fields, "Direction", "1 0 0 0 1 0 0 0 1"))
    except ElementTree.ParseError as error:
        raise InputError(f"{path}: not valid XML ({error}); truncated, or no .vti file") from None
    except (*DAMAGE, RuntimeError) as error:
        raise InputError(f"{path}: a damaged or truncated image of VTK ({error}); save it again") from None
    steps = fields.get("Spacing", "1 1 1")
    return upright(image, path)._replace(spacing=UNSIZED, provenance=f"VTK names no unit of its Spacing ({steps})")


def _content(path: Path) -> tuple[np.ndarray, dict[str, str]]:
    """Return the grey levels, z, y, x, and the attributes of the image."""
    top, appended = document(read_bytes(path))
    image, *more = top.findall("./ImageData/Piece")
    fields = next(top.iter("ImageData")).attrib
    arrays = [array for kind in ("PointData", "CellData") for array in image.findall(f"./{kind}/DataArray")]
    kinds = [(array.get("NumberOfComponents", "1"), array.get("type") in TYPES) for array in arrays]
    if more or kinds != [("1", True)]:
        raise InputError(f"{path}: not one piece with one array of grey levels; save it as NRRD or MetaImage, in mm")
    first, last = np.array(image.attrib["Extent"].split(), int).reshape(3, 2).T
    by_point = image.find("./PointData/DataArray") is not None
    values = array_of(arrays[0], top, appended)
    return values.reshape((last - first + by_point)[::-1]).astype(values.dtype.newbyteorder("=")), dict(fields)


def _numbers(fields: dict[str, str], name: str, default: str) -> list[float]:
    return [float(word) for word in fields.get(name, default).split()]


VOLUMES.register(VolumeFormat("vti", "VTK image", (".vti",), None, read_vti, oriented=False))
