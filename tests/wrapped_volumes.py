"""One small anisotropic volume with landmarks, in files as scanners and programs describe theirs."""

import gzip
import io
import json
import struct
import zlib

import numpy as np

SIZE = np.array([0.005, 0.003, 0.002])
"""Of a voxel, z, y, x, cm."""
CUBE = np.full(3, 0.002)
LANDMARKS = {(1, 2, 3): 220, (8, 3, 4): 200, (2, 11, 5): 180, (3, 4, 15): 160}
GREY = np.random.default_rng(3).integers(28, 34, (10, 14, 18)).astype(np.uint8)
for _place, _level in LANDMARKS.items():
    GREY[_place] = _level
NZ, NY, NX = GREY.shape

WRAPPINGS = {}
"""Functions that write a volume into a folder and return what is opened, with the size that the file says."""


def wrapping(size=SIZE):
    def keep(write):
        WRAPPINGS[write.__name__] = write, size
        return write

    return keep


def put(folder, name, content):
    (folder / name).write_bytes(content if isinstance(content, bytes) else content.encode("utf-8"))
    return folder / name


def pictures(folder, pattern="slice_%03d.png", grey=GREY, first=0):
    from PIL import Image

    for number, level in enumerate(grey, first):
        Image.fromarray(level).save(folder / (pattern % number))
    return folder


NRECON = (
    "[System]\r\nScanner=SkyScan1272\r\nCamera Pixel Size (um)=7.4\r\n[Acquisition]\r\nImage Pixel Size (um)=10\r\n"
    "[Reconstruction]\r\nProgram=NRecon\r\nPixel Size (um)=20.0\r\nFirst Section=100\r\nLast Section=109\r\n"
)


def nrrd_header(kind="uint8", encoding="raw", files="LIST 3\ns0\ns1\n"):
    return (
        f"NRRD0004\ntype: {kind}\ndimension: 3\nspace: left-posterior-superior\nsizes: {NX} {NY} {NZ}\n"
        f'space directions: (20,0,0) (0,30,0) (0,0,50)\nspace units: "um" "um" "um"\nencoding: {encoding}\n'
        f"endian: big\ndata file: {files}"
    )


@wrapping()
def nrrd_of_two_slabs(folder):
    for k in range(2):
        put(folder, f"s{k}", GREY[5 * k : 5 * k + 5].tobytes())
    return put(folder, "a.nhdr", nrrd_header())


@wrapping()
def nrrd_of_packed_slices(folder):
    for k, level in enumerate(GREY):
        put(folder, f"I.{k + 1:03d}", gzip.compress(level.astype(">u2").tobytes()))
    return put(folder, "a.nhdr", nrrd_header("ushort", "gzip", f"I.%03d 1 {NZ} 1\n"))


@wrapping(CUBE)
def skyscan(folder):
    put(folder, "lung__rec.log", NRECON)
    return pictures(folder, "lung__rec%08d.bmp", first=100)


@wrapping()
def scanco_slices(folder):
    put(folder, "C01.txt", "!> dim   18 14 10\n!> el_size_mm     0.0200    0.0300    0.0500\n")
    return pictures(folder, "C01_%d.tif")


@wrapping(CUBE)
def ge_slices(folder):
    put(folder, "a.pca", "[Geometry]\nFDD=800\nVoxelSizeX=0.02\nVoxelSizeY=0.02\n[Detector]\nPixelsizeX=0.2\n")
    return pictures(folder, "a_%04d.png")


@wrapping(CUBE)
def zeiss_slices(folder):
    put(folder, "recon.txt", "Instrument\tVersa\nPixel Size (um)\t20.00\n")
    return pictures(folder, "recon%04d.tiff")


@wrapping()
def scanco(folder):
    header = bytearray(512)
    header[:16] = b"CTDATA-HEADER_V1"
    struct.pack_into("<6i", header, 44, NX, NY, NZ, 20 * NX, 30 * NY, 50 * NZ)
    struct.pack_into("<i", header, 508, 1)
    return put(folder, "C01.isq", bytes(header) + bytes(512) + (GREY.astype("<i2") * 50).tobytes() + bytes(100))


def dicom_dataset(uid, **values):
    import pydicom

    meta = pydicom.dataset.FileMetaDataset()
    meta.MediaStorageSOPClassUID = uid
    meta.MediaStorageSOPInstanceUID = pydicom.uid.generate_uid()
    meta.TransferSyntaxUID = pydicom.uid.ExplicitVRLittleEndian
    image = pydicom.dataset.Dataset()
    image.file_meta = meta
    values = {
        "SOPClassUID": uid, "SOPInstanceUID": meta.MediaStorageSOPInstanceUID, "SeriesInstanceUID": "1.2.3",
        "Rows": NY, "Columns": NX, "SamplesPerPixel": 1, "PhotometricInterpretation": "MONOCHROME2",
        "BitsAllocated": 16, "BitsStored": 16, "HighBit": 15, "PixelRepresentation": 0,
    } | values  # fmt: skip
    for key, value in values.items():
        setattr(image, key, value)
    return image


PLACES = [[1.0, 2.0, 3 + 0.05 * k] for k in range(NZ)]


def dicom_slices(folder, grey=GREY, **values):
    for k, level in enumerate(grey):
        image = dicom_dataset(
            "1.2.840.10008.5.1.4.1.1.2", PixelSpacing=[0.03, 0.02], ImageOrientationPatient=[1, 0, 0, 0, 1, 0],
            ImagePositionPatient=PLACES[k], PixelData=level.astype("<u2").tobytes(), **values,
        )  # fmt: skip
        image.save_as(folder / f"I{k:03d}.dcm", enforce_file_format=True)
    return folder


@wrapping()
def dicom_with_a_readme(folder):
    put(folder, "README.txt", "mouse 3")
    put(folder, "Thumbs.db", b"\xd0\xcf\x11\xe0")
    return dicom_slices(folder)


@wrapping()
def dicom_frames(folder):
    from pydicom.dataset import Dataset

    def group(name, **values):
        inner, outer = Dataset(), Dataset()
        for key, value in values.items():
            setattr(inner, key, value)
        setattr(outer, name, [inner])
        return outer

    shared = group("PixelMeasuresSequence", PixelSpacing=[0.03, 0.02])
    shared.update(group("PlaneOrientationSequence", ImageOrientationPatient=[1, 0, 0, 0, 1, 0]))
    shared.update(group("PixelValueTransformationSequence", RescaleSlope=2, RescaleIntercept=-10))
    order = [3, 1, 0, 2, 9, 8, 7, 6, 5, 4]
    frames = [group("PlanePositionSequence", ImagePositionPatient=PLACES[k]) for k in order]
    image = dicom_dataset(
        "1.2.840.10008.5.1.4.1.1.2.1", NumberOfFrames=NZ, SharedFunctionalGroupsSequence=[shared],
        PerFrameFunctionalGroupsSequence=frames, PixelData=GREY[order].astype("<u2").tobytes(),
    )  # fmt: skip
    image.save_as(folder / "all.dcm", enforce_file_format=True)
    return folder / "all.dcm"


def nrrd(folder, sizes, directions, more=""):
    header = f"NRRD0005\ntype: uint8\ndimension: {len(sizes.split())}\nsizes: {sizes}\nencoding: raw\n"
    header += f"space: left-posterior-superior\nspace directions: {directions}\n{more}\n"
    return put(folder, "a.nrrd", header.encode() + GREY.tobytes())


MILLIMETERS = "(0.02,0,0) (0,0.03,0) (0,0,0.05)"


@wrapping()
def nrrd_in_a_folder(folder):
    nrrd(folder, "18 14 10", MILLIMETERS)
    return folder


@wrapping()
def nrrd_none_first(folder):
    return nrrd(folder, "1 18 14 10", f"none {MILLIMETERS}", "kinds: vector domain domain domain\n")


@wrapping()
def nrrd_none_last(folder):
    return nrrd(folder, "18 14 10 1", f"{MILLIMETERS} none", "kinds: domain domain domain list\n")


@wrapping()
def nrrd_micrometers(folder):
    return nrrd(folder, "18 14 10", "(20,0,0) (0,30,0) (0,0,50)", 'space units: "um" "um" "um"\n')


def metaimage(folder, more="", spacing="0.02 0.03 0.05", kind="MET_UCHAR", content=None):
    put(folder, "a.raw", GREY.tobytes() if content is None else content)
    header = f"ObjectType = Image\nNDims = 3\n{more}ElementSpacing = {spacing}\nDimSize = {NX} {NY} {NZ}\n"
    return put(folder, "a.mhd", f"{header}ElementType = {kind}\nElementDataFile = a.raw\n")


@wrapping()
def metaimage_in_a_folder(folder):
    metaimage(folder)
    return folder


@wrapping()
def metaimage_micrometers(folder):
    return metaimage(folder, "DistanceUnits = um\n", "20 30 50")


@wrapping()
def metaimage_high_byte_first(folder):
    return metaimage(folder, "BinaryDataByteOrderMSB = True\n", kind="MET_USHORT", content=GREY.astype(">u2").tobytes())


def nifti(folder, unit=2, sform=None, name="a.nii"):
    """A header of version 1; its quaternion turns by 180 degrees about z, from right-anterior to left-posterior."""
    header = bytearray(352)
    struct.pack_into("<i", header, 0, 348)
    struct.pack_into("<8h", header, 40, 3, NX, NY, NZ, 1, 1, 1, 1)
    struct.pack_into("<2h", header, 70, 2, 8)
    struct.pack_into("<4f", header, 76, 1, 0.02, 0.03, 0.05)
    struct.pack_into("<f", header, 108, 352)
    header[123] = unit
    struct.pack_into("<2h", header, 252, 1, 0 if sform is None else 1)
    struct.pack_into("<3f", header, 256, 0, 0, 1)
    struct.pack_into("<12f", header, 280, *(np.zeros(12) if sform is None else np.ravel(sform)))
    header[344:348] = b"n+1\0"
    content = bytes(header) + GREY.tobytes()
    return put(folder, name, gzip.compress(content) if name.endswith("gz") else content)


QFORM = np.array([[-0.02, 0, 0, 0], [0, -0.03, 0, 0], [0, 0, 0.05, 0]])


@wrapping()
def nifti_of_two_equal_transforms(folder):
    return nifti(folder, sform=QFORM)


def tiff(folder, grey=GREY, **options):
    import tifffile

    tifffile.imwrite(folder / "a.tif", grey, **options)
    return folder / "a.tif"


def imagej(unit, scale, **more):
    metadata = {"axes": "ZYX", "unit": unit, "spacing": 0.05 * scale} | more
    return {"imagej": True, "resolution": (50 / scale, 1 / (0.03 * scale)), "metadata": metadata}


@wrapping()
def imagej_millimeters(folder):
    return tiff(folder, **imagej("mm", 1))


@wrapping()
def imagej_micrometers(folder):
    return tiff(folder, **imagej("\\u00B5m", 1000))


@wrapping()
def imagej_inch(folder):
    return tiff(folder, **imagej("inch", 1 / 25.4))


@wrapping()
def ome_tiff(folder):
    sizes = {"PhysicalSizeX": 20.0, "PhysicalSizeY": 30.0, "PhysicalSizeZ": 0.05, "PhysicalSizeZUnit": "mm"}
    return tiff(folder, ome=True, metadata={"axes": "ZYX"} | sizes)


def amira(folder, form="BINARY-LITTLE-ENDIAN 2.1", unit='Units { Coordinates "mm" }', content=None, packing=""):
    header = f"# AmiraMesh {form}\n\ndefine Lattice {NX} {NY} {NZ}\nParameters {{\n  {unit}\n"
    header += f"  BoundingBox 0 {17 * 0.02} 0 {13 * 0.03} 1 {1 + 9 * 0.05},\n"
    header += f'  CoordType "uniform"\n}}\nLattice {{ byte Data }} @1{packing}\n# Data section follows\n@1\n'
    return put(folder, "a.am", header.encode() + (GREY.tobytes() if content is None else content) + b"\n")


@wrapping()
def amira_bytes(folder):
    return amira(folder)


@wrapping()
def amira_text(folder):
    return amira(folder, "ASCII 1.0", content="\n".join(map(str, GREY.ravel())).encode())


@wrapping()
def amira_packed(folder):
    packed = zlib.compress(GREY.tobytes())
    return amira(folder, content=packed, packing=f"(HxZip,{len(packed)})")


@wrapping()
def amira_run_lengths(folder):
    """Runs of one voxel each, but for two pieces as they are."""
    flat = GREY.tobytes()
    packed = bytes([128 + 100]) + flat[:100] + bytes([128 + 20]) + flat[100:120]
    packed += b"".join(bytes([1, level]) for level in flat[120:])
    return amira(folder, content=packed, packing=f"(HxByteRLE,{len(packed)})")


@wrapping(CUBE * [2.5, 1.5, 1])
def vff(folder):
    header = f"ncaa\nrank=3;\nsize={NX} {NY} {NZ};\nbands=1;\nbits=16;\nspacing=1.0 1.5 2.5;\nelementsize=0.02;\n\f\n"
    return put(folder, "a.vff", header.encode() + (GREY.astype(int) * 100 - 1000).astype(">i2").tobytes())


@wrapping()
def paravision(folder):
    put(folder, "visu_pars", f"##TITLE=Parameter List\n##$VisuCoreFrameCount=1\n##$VisuCoreSize=( 3 )\n{NX} {NY} {NZ}\n"
        f"##$VisuCoreExtent=( 3 )\n{0.02 * NX} {0.03 * NY}\n{0.05 * NZ}\n##$VisuCoreUnits=( 3, 65 )\n<mm> <mm> <mm>\n"
        "##$VisuCoreWordType=_16BIT_SGN_INT\n##$VisuCoreByteOrder=bigEndian\n##END=\n")  # fmt: skip
    return put(folder, "2dseq", GREY.astype(">i2").tobytes())


FLOATS = (GREY.astype("<f4") / 100).tobytes()


@wrapping()
def vgstudio(folder):
    header = f"{{volume1}}\n[representation]\nsize = {NX} {NY} {NZ}\ndatatype = unsigned integer\nbitsperelement = 16\n"
    header += f"[file1]\nSize = {NX} {NY} {NZ}\nName = a.vol\nDatatype = float\nBitsPerElement = 32\n[geometry]\n"
    put(folder, "a.vgi", f"{header}resolution = 0.02 0.03 0.05\nunit = mm\n")
    return put(folder, "a.vol", FLOATS)


@wrapping(CUBE)
def datosx(folder):
    sizes = "".join(f"Volume_Size{axis}={count}\n" for axis, count in zip("XYZ", (NX, NY, NZ), strict=True))
    put(folder, "a.pca", "[Geometry]\nVoxelSizeX=0.05\nVoxelSizeY=0.05\n")
    put(folder, "a.pcr", f"[VolumeData]\nFormat=10\n{sizes}VoxelSizeRec=0.02\n")
    put(folder, "a.vol", FLOATS)
    return folder


@wrapping()
def nikon(folder):
    rows = zip("XYZ", (NX, NY, NZ), (0.02, 0.03, 0.05), strict=True)
    fields = "".join(f"Voxels{axis}={count}\nVoxelSize{axis}={edge}\n" for axis, count, edge in rows)
    put(folder, "a.xtekct", f"[XTekCT]\nName=a\n{fields}DetectorPixelSizeX=0.2\n")
    return put(folder, "a.vol", GREY.astype("<u2").tobytes())


@wrapping(CUBE)
def pyhst(folder):
    header = f"! PyHST_SLAVE VOLUME INFO FILE\nNUM_X = {NX}\nNUM_Y = {NY}\nNUM_Z = {NZ}\nvoxelSize = 20.0\n"
    put(folder, "a.vol.info", f"{header}BYTEORDER = HIGHBYTEFIRST\n")
    return put(folder, "a.vol", GREY.astype(">f4").tobytes())


@wrapping()
def microview(folder):
    header = f"width: {NX}\nheight: {NY}\nnumFrames: {NZ}\nxVoxelSize: 0.02\nyVoxelSize: 0.03\nzVoxelSize: 0.05\n"
    put(folder, "a.img", GREY.astype("<i2").tobytes())
    return put(folder, "a.nfo", f"{header}dataType: 4\n")


@wrapping()
def inveon(folder):
    header = f"#\n# Header file for data file a.ct.img\nmodel 2002\ndata_type 6\nx_dimension {NX}\ny_dimension {NY}\n"
    edges = "pixel_size 0.02\npixel_size_x 0.02\npixel_size_y 0.03\npixel_size_z 0.05\nend_of_header\n"
    put(folder, "a.ct.img.hdr", f"{header}z_dimension {NZ}\n{edges}")
    return put(folder, "a.ct.img", GREY.astype(">i2").tobytes())


@wrapping()
def hdf5(folder):
    import h5py

    with h5py.File(folder / "a.h5", "w") as file:
        file["entry/angles"] = np.arange(5.0)
        file["entry/grey"] = GREY
        file["entry/grey"].attrs["element_size_um"] = [50.0, 30.0, 20.0]
    return folder / "a.h5"


def numpy_array(folder):
    content = io.BytesIO()
    np.save(content, GREY)
    return put(folder, "a.npy", content.getvalue())


def matlab_array(folder):
    from scipy.io import savemat

    savemat(folder / "a.mat", {"V": GREY.transpose(1, 2, 0), "voxel": SIZE, "note": "mouse 3"}, do_compression=True)
    return folder / "a.mat"


@wrapping()
def ome_zarr(folder):
    """Version 0.4: pieces of 6 x 8 x 10 voxels, packed, in a folder whose name an address cannot hold."""
    store, steps = folder / "a b#1.zarr", (6, 8, 10)
    array = {"zarr_format": 2, "shape": GREY.shape, "chunks": steps, "dtype": "|u1", "fill_value": 0, "order": "C",
             "filters": None, "compressor": {"id": "zlib", "level": 5}}  # fmt: skip
    axes = [{"name": name, "type": "space", "unit": "micrometer"} for name in "zyx"]
    scale = {"type": "scale", "scale": [50.0, 30.0, 20.0]}
    scales = {"version": "0.4", "axes": axes, "datasets": [{"path": "0", "coordinateTransformations": [scale]}]}
    (store / "0").mkdir(parents=True)
    put(store, ".zgroup", json.dumps({"zarr_format": 2}))
    put(store, ".zattrs", json.dumps({"multiscales": [scales]}))
    put(store / "0", ".zarray", json.dumps(array))
    counts = [-(-size // step) for size, step in zip(GREY.shape, steps, strict=True)]
    for place in np.ndindex(*counts):
        corner = tuple(slice(i * step, (i + 1) * step) for i, step in zip(place, steps, strict=True))
        piece = np.zeros(steps, np.uint8)
        piece[tuple(slice(0, size) for size in GREY[corner].shape)] = GREY[corner]
        put(store / "0", ".".join(map(str, place)), zlib.compress(piece.tobytes()))
    return store


def zarr(folder):
    put(folder, "zarr.json", json.dumps({"zarr_format": 3, "node_type": "group"}))
    return folder
