"""What each stage of an extraction depends on, as a digest: the image, the options it uses, and the program."""

import re
from pathlib import Path
from typing import Any, NamedTuple

from vasowave.imaging.given import Given
from vasowave.imaging.options import Options
from vasowave.imaging.read.volume import Volume
from vasowave.io.textfile import look, read_start
from vasowave.runtime.kept import digest_of, program

_LIBRARIES = ("numpy", "scipy", "scikit-image", "SimpleITK", "pydicom", "tifffile")
_HEADER = 1 << 16
"""No header is longer, bytes."""
_SELF_CONTAINED = (".nrrd", ".nhdr", ".nii", ".nii.gz", ".mha", ".mhd", ".tif", ".tiff")
_ELSEWHERE = re.compile(rb"^(data ?file *:|ElementDataFile *=(?! *LOCAL))", re.MULTILINE | re.IGNORECASE)
"""How a header says that its voxels stand in another file."""


class Keys(NamedTuple):
    """The digest of each stage; it holds that of the stage before."""

    lumen: str
    loops: str
    axes: str
    elsewhere: str
    witness: str
    profiles: str
    grey: str


def keys_of(image: str, said: Given, options: Options) -> Keys:
    """Return the keys of the stages after the image, whose own is `image`.

    Edits, wanted parts, scale and pressure act on what is measured, so that no stage depends on them; a root among
    the edits is the root.
    """
    lumen = _key("lumen", image, said.segmenter, options.threshold, said.seed)
    loops = _key("loops", lumen, options.loops, said.outlets is None)
    axes = _key("axes", lumen, said.root, said.outlets, bool(options.cannula))
    elsewhere, grey = _key("elsewhere", axes), _key("grey", axes, options.cannula)
    return Keys(lumen, loops, axes, elsewhere, _key("witness", lumen, said.root), _key("profiles", image), grey)


def _key(stage: str, *values: Any) -> str:
    return digest_of(program("imaging", libraries=_LIBRARIES), stage, *values)


def image_key(source: Path, voxel: float | None) -> str | None:
    """Return the digest of the files at `source`, with what they are read as; None where other files belong to it."""
    files = sorted(one for one in source.iterdir() if one.is_file()) if source.is_dir() else [source]
    if not source.is_dir() and not _stands_alone(source):
        return None
    return _key("image", source.suffix.lower(), voxel, [(file.name, look(file).sha256) for file in files])


def _stands_alone(source: Path) -> bool:
    whole = source.is_file() and source.name.lower().endswith(_SELF_CONTAINED)
    return whole and not _ELSEWHERE.search(read_start(source, _HEADER))


def volume_key(volume: Volume) -> str:
    """Return the digest of an image that is given as such."""
    return _key("volume", volume)
