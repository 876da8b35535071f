"""Volumes in every format that `read_volume` takes, raw and packed."""

import gzip
import json
import zlib
from collections.abc import Callable
from pathlib import Path

import numpy as np

from fuzzing.forms import Form, Mutate
from fuzzing.mutations import bombs, inside_gzip, mutate_binary, mutate_mat, mutate_text, packed_zeros, with_header
from vasowave.lung.read import Volume, read_volume


def volume() -> Volume:
    z, y, x = np.meshgrid(np.arange(9), np.arange(10), np.arange(11), indexing="ij")
    grey = 100 + 80 * np.exp(-((y - 5) ** 2 + (x - 5) ** 2) / 6) + z
    return Volume(np.round(grey), np.array([0.02, 0.01, 0.01]), np.array([0.1, 0.2, 0.3]))


def itk_file(name: str, packed: bool) -> Callable[[Path], object]:
    def write(folder: Path) -> None:
        import SimpleITK

        image = SimpleITK.GetImageFromArray(volume().grey.astype(np.int16))
        image.SetSpacing([0.1, 0.1, 0.2])
        image.SetOrigin([3.0, 2.0, 1.0])
        SimpleITK.WriteImage(image, str(folder / name), packed)

    return write


def tiff(folder: Path) -> None:
    import tifffile

    tifffile.imwrite(folder / "v.tif", volume().grey.astype(np.int16))


def dicom(folder: Path) -> None:
    from phantom import write_dicom_series

    write_dicom_series(volume(), folder)


def grey() -> np.ndarray:
    return volume().grey.astype(np.int16)


def pictures(folder: Path) -> None:
    from PIL import Image

    for k, level in enumerate(grey()):
        Image.fromarray(level.astype(np.uint8)).save(folder / f"v{k:02d}.png")
    (folder / "v.log").write_text("[Reconstruction]\nPixel Size (um)=100.0\nFirst Section=0\nLast Section=8\n")


def several_files(folder: Path) -> None:
    """Write a header of NRRD with a file a slice."""
    names = [f"s{k}.raw" for k in range(9)]
    for name, level in zip(names, grey(), strict=True):
        (folder / name).write_bytes(level.astype("<i2").tobytes())
    head = "NRRD0004\ntype: short\ndimension: 3\nsizes: 11 10 9\nspacings: 0.1 0.1 0.2\nendian: little\n"
    (folder / "v.nhdr").write_text(f"{head}encoding: raw\ndata file: LIST\n" + "\n".join(names) + "\n")


def vti(folder: Path) -> None:
    """Write an image of VTK with its voxels appended."""
    content = grey().astype("<i2").tobytes()
    head = (
        '<VTKFile type="ImageData" byte_order="LittleEndian" header_type="UInt32">\n'
        '<ImageData WholeExtent="0 10 0 9 0 8" Origin="0 0 0" Spacing="0.1 0.1 0.2">\n<Piece Extent="0 10 0 9 0 8">\n'
        '<PointData><DataArray type="Int16" Name="grey" format="appended" offset="0"/></PointData>\n'
        '</Piece></ImageData>\n<AppendedData encoding="raw">_'
    )
    size = np.array([len(content)], "<u4").tobytes()
    (folder / "v.vti").write_bytes(head.encode() + size + content + b"</AppendedData></VTKFile>")


def scanco(folder: Path) -> None:
    header = bytearray(512)
    header[:16] = b"CTDATA-HEADER_V1"
    header[44:68] = np.array([11, 10, 9, 1100, 1000, 1800], "<i4").tobytes()
    (folder / "v.isq").write_bytes(bytes(header) + grey().astype("<i2").tobytes())


def vff(folder: Path) -> None:
    header = b"ncaa\nrank=3;\nsize=11 10 9;\nbits=16;\nspacing=1 1 2;\nelementsize=0.1;\n\f\n"
    (folder / "v.vff").write_bytes(header + grey().astype(">i2").tobytes())


def vox(folder: Path) -> None:
    header = b"Vox1999a\nVolumeCount 1\n##\f\n##\nVolumeSize 11 10 9\nVoxelSize 16\nEndian L\n##\f\n"
    (folder / "v.vox").write_bytes(header + grey().astype("<u2").tobytes())


def paravision(folder: Path) -> None:
    text = "##$VisuCoreFrameCount=1\n##$VisuCoreSize=( 3 )\n11 10 9\n##$VisuCoreExtent=( 3 )\n1.1 1.0 1.8\n"
    text += "##$VisuCoreUnits=( 3, 65 )\n<mm> <mm> <mm>\n##$VisuCoreWordType=_16BIT_SGN_INT\n##END=\n"
    (folder / "visu_pars").write_text(text)
    (folder / "reco").write_text("##$RECO_fov=( 3 )\n0.11 0.1 0.18\n##END=\n")
    (folder / "2dseq").write_bytes(grey().astype("<i2").tobytes())


def amira(folder: Path) -> None:
    header = '# AmiraMesh BINARY-LITTLE-ENDIAN 2.1\ndefine Lattice 11 10 9\nParameters { Units { Coordinates "mm" }\n'
    header += 'BoundingBox 0 1 0 0.9 0 1.6,\nCoordType "uniform" }\nLattice { short Data } @1(HxZip,%d)\n@1\n'
    packed = zlib.compress(grey().astype("<i2").tobytes())
    (folder / "v.am").write_bytes((header % len(packed)).encode() + packed)


def vgstudio(folder: Path) -> None:
    header = "[file1]\nSize = 11 10 9\nName = v.vol\nDatatype = signed integer\nBitsPerElement = 16\n"
    (folder / "v.vgi").write_text(f"{header}[geometry]\nresolution = 0.1 0.1 0.2\nunit = mm\n")
    (folder / "v.vol").write_bytes(grey().astype("<i2").tobytes())


def numpy_array(folder: Path) -> None:
    np.save(folder / "v.npy", grey())


def hdf5(folder: Path) -> None:
    import netCDF4

    with netCDF4.Dataset(folder / "v.h5", "w") as file:
        for axis, count in zip("zyx", grey().shape, strict=True):
            file.createDimension(axis, count)
        variable = file.createVariable("grey", "i2", tuple("zyx"))
        variable[:] = grey()
        variable.element_size_um = [200.0, 100.0, 100.0]


def matlab_array(folder: Path) -> None:
    from scipy.io import savemat

    savemat(folder / "v.mat", {"V": grey().transpose(1, 2, 0)})


def inveon(folder: Path) -> None:
    depth, height, width = grey().shape
    sizes = f"x_dimension {width}\ny_dimension {height}\nz_dimension {depth}\n"
    edges = "pixel_size_x 0.1\npixel_size_y 0.1\npixel_size_z 0.2\n"
    (folder / "v.img.hdr").write_text(f"# Header file for data file v.img\ndata_type 2\n{sizes}{edges}")
    (folder / "v.img").write_bytes(grey().astype("<i2").tobytes())


def zarr(folder: Path) -> None:
    """Write a store of OME-Zarr 0.4, one piece."""
    store = folder / "v.zarr"
    (store / "0").mkdir(parents=True)
    shape = list(grey().shape)
    array = {"zarr_format": 2, "shape": shape, "chunks": shape, "dtype": "<i2", "fill_value": 0,
             "compressor": {"id": "zlib", "level": 1}, "order": "C", "filters": None}  # fmt: skip
    axes = [{"name": name, "type": "space", "unit": "millimeter"} for name in "zyx"]
    change = {"type": "scale", "scale": [0.2, 0.1, 0.1]}
    scales = {"version": "0.4", "axes": axes, "datasets": [{"path": "0", "coordinateTransformations": [change]}]}
    (store / ".zgroup").write_text('{"zarr_format": 2}')
    (store / ".zattrs").write_text(json.dumps({"multiscales": [scales]}, indent=1))
    (store / "0" / ".zarray").write_text(json.dumps(array, indent=1))
    (store / "0" / "0.0.0").write_bytes(zlib.compress(grey().astype("<i2").tobytes()))


def metaimage_bomb(size: int) -> bytes:
    packed = packed_zeros(size, 15)
    head = (
        f"ObjectType = Image\nNDims = 3\nBinaryData = True\nCompressedData = True\nCompressedDataSize = {len(packed)}\n"
    )
    return f"{head}DimSize = 9 10 11\nElementType = MET_SHORT\nElementDataFile = LOCAL\n".encode() + packed


def nifti_bomb(size: int) -> bytes:
    head = np.zeros(352, np.uint8)
    head[:4] = np.array([348], "<i4").view(np.uint8)
    side = round((size / 2) ** (1 / 3))
    head[40:56] = np.array([3, side, side, side, 1, 1, 1, 1], "<i2").view(np.uint8)
    head[70:74] = np.array([4, 16], "<i2").view(np.uint8)
    head[76:108] = np.ones(8, "<f4").view(np.uint8)
    head[108:112] = np.array([352], "<f4").view(np.uint8)
    head[344:348] = list(b"n+1\0")
    return gzip.compress(head.tobytes(), 1) + packed_zeros(size, 31)


def _form(name: str, write: Callable, mutate: Mutate, opened: str = "", spacing: float | None = None) -> Form:
    return Form(
        write, opened or name, name, mutate, lambda path: read_volume(path, spacing),
        lambda found: (found.grey.shape, tuple(found.spacing)), lambda found: [found.grey, found.origin],
    )  # fmt: skip


_LOCAL, _BLANK = with_header(b"LOCAL\n"), with_header(b"\n\n")
FORMS = {
    "mha": _form("v.mha", itk_file("v.mha", False), _LOCAL),
    "mha, packed": _form("v.mha", itk_file("v.mha", True), bombs(metaimage_bomb, _LOCAL)),
    "mhd": _form("v.mhd", itk_file("v.mhd", False), with_header(b"v.raw\n")),
    "raw": _form("v.raw", itk_file("v.mhd", False), mutate_binary),
    "nrrd": _form("v.nrrd", itk_file("v.nrrd", False), _BLANK),
    "nrrd, packed": _form("v.nrrd", itk_file("v.nrrd", True), _BLANK),
    "nrrd, several files": _form("v.nhdr", several_files, mutate_text),
    "vti": _form("v.vti", vti, with_header(b"_"), spacing=0.01),
    "nii": _form("v.nii", itk_file("v.nii", False), mutate_binary),
    "nii.gz": _form("v.nii.gz", itk_file("v.nii.gz", True), bombs(nifti_bomb, inside_gzip(mutate_binary))),
    "tif": _form("v.tif", tiff, mutate_binary, spacing=0.01),
    "dicom": _form("slice0004.dcm", dicom, mutate_binary, "."),
    "slices": _form("v04.png", pictures, mutate_binary, "."),
    "slices, log": _form("v.log", pictures, mutate_text, "."),
    "isq": _form("v.isq", scanco, mutate_binary),
    "vff": _form("v.vff", vff, with_header(b"\f\n")),
    "vox": _form("v.vox", vox, with_header(b"L\n##\f\n"), spacing=0.01),
    "paravision": _form("visu_pars", paravision, mutate_text, "2dseq"),
    "amira": _form("v.am", amira, with_header(b"@1\n")),
    "raw, vgi": _form("v.vgi", vgstudio, mutate_text),
    "npy": _form("v.npy", numpy_array, mutate_binary, spacing=0.01),
    "matlab array": _form("v.mat", matlab_array, mutate_mat, spacing=0.01),
    "raw, inveon": _form("v.img.hdr", inveon, mutate_text),
    "hdf5": _form("v.h5", hdf5, mutate_binary),
    "zarr": _form("v.zarr/0/0.0.0", zarr, mutate_binary, "v.zarr"),
    "zarr, array": _form("v.zarr/0/.zarray", zarr, mutate_text, "v.zarr"),
    "zarr, axes": _form("v.zarr/.zattrs", zarr, mutate_text, "v.zarr"),
}
