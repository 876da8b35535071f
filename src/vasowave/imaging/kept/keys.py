"""What each stage of an extraction depends on, as a digest: the image, the options it uses, and the program."""

import hashlib
import re
from collections.abc import Iterator
from dataclasses import fields, is_dataclass
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from vasowave.imaging.given import Given
from vasowave.imaging.options import Options
from vasowave.imaging.read.volume import Volume
from vasowave.io.textfile import read_start

_LIBRARIES = ("numpy", "scipy", "scikit-image", "SimpleITK", "pydicom", "tifffile")
_SOURCE = Path(__file__).parents[1]
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


def keys_of(image: str, said: Given, options: Options) -> Keys:
    """Return the keys of the stages after the image, whose own is `image`.

    Edits, wanted parts, scale and pressure act on what is measured, so that no stage depends on them; a root among
    the edits is the root.
    """
    lumen = digest_of("lumen", image, said.segmenter, options.threshold, said.seed)
    loops = digest_of("loops", lumen, options.loops, said.outlets is None)
    axes = digest_of("axes", lumen, said.root, said.outlets, bool(options.cannula))
    witness, profiles = digest_of("witness", lumen, said.root), digest_of("profiles", image)
    return Keys(lumen, loops, axes, digest_of("elsewhere", axes), witness, profiles)


def image_key(source: Path, voxel: float | None) -> str | None:
    """Return the digest of the files at `source`, with what they are read as; None where other files belong to it."""
    files = sorted(one for one in source.iterdir() if one.is_file()) if source.is_dir() else [source]
    if not source.is_dir() and not _stands_alone(source):
        return None
    digest = hashlib.sha256(digest_of("image", source.suffix.lower(), voxel).encode())
    for file in files:
        with file.open("rb") as content:
            digest.update(file.name.encode() + hashlib.file_digest(content, "sha256").digest())
    return digest.hexdigest()


def _stands_alone(source: Path) -> bool:
    whole = source.is_file() and source.name.lower().endswith(_SELF_CONTAINED)
    return whole and not _ELSEWHERE.search(read_start(source, _HEADER))


def volume_key(volume: Volume) -> str:
    """Return the digest of an image that is given as such."""
    return digest_of("volume", volume)


def digest_of(*parts: Any) -> str:
    """Return the digest of values (arrays, dataclasses, numbers, text, in one another) and of the program."""
    digest = hashlib.sha256(program().encode())
    for piece in _pieces(parts):
        digest.update(piece)
    return digest.hexdigest()


def _pieces(value: Any) -> Iterator[bytes | np.ndarray]:
    """Yield what makes `value` another one: kinds, shapes and contents."""
    if isinstance(value, np.ndarray):
        yield f"{value.dtype.str}{value.shape}".encode()
        yield np.ascontiguousarray(value).reshape(-1).view(np.uint8)
    elif is_dataclass(value) and not isinstance(value, type):
        yield type(value).__name__.encode()
        for entry in fields(value):
            # A segmenter's grid is that of the image, whose own digest is there already.
            yield from _pieces(None if entry.name == "grid" else getattr(value, entry.name))
    elif isinstance(value, tuple | list):
        yield f"({len(value)}".encode()
        for one in value:
            yield from _pieces(one)
    else:
        yield f"{getattr(value, '__qualname__', None) or repr(value)};".encode()


@cache
def program() -> str:
    """Return the digest of imaging's own sources and of the versions of the libraries that it computes with."""
    digest = hashlib.sha256()
    for file in sorted(_SOURCE.rglob("*.py")):
        digest.update(file.relative_to(_SOURCE).as_posix().encode() + file.read_bytes())
    for name in _LIBRARIES:
        try:
            digest.update(f"{name} {version(name)};".encode())
        except PackageNotFoundError:
            digest.update(f"{name} absent;".encode())
    return digest.hexdigest()
