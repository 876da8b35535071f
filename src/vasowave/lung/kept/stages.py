"""Stages of an extraction in a folder: a value, what it was made of, and the warnings that came with it.

A stage is believed only if its key, a digest of the image, the options it uses and the program, is the one asked for
and its file is whole (see `runtime.kept`). Anything else is made anew, in silence. A file holds a piece of JSON, then
plain arrays; no code is ever read.
"""

import json
import re
import warnings
from collections.abc import Callable
from dataclasses import fields, is_dataclass
from pathlib import Path
from typing import Any, NamedTuple, TypeVar

import numpy as np

from vasowave.base.errors import VasowaveWarning
from vasowave.base.findings import Finding, as_json, found_in, from_json, warn
from vasowave.base.io.files import in_words, made_inside, remove_file, remove_parts
from vasowave.base.io.textfile import look, read_start, regular_file
from vasowave.base.runtime.kept import digest_of, keep, program, recall
from vasowave.base.stores import parsed, stored
from vasowave.lung.axes.starts import Settled
from vasowave.lung.lumen.segmentation import Segmentation
from vasowave.lung.measure.grey_levels import GreyScale
from vasowave.lung.measure.profiles import Profile
from vasowave.lung.measure.spread import Elsewhere
from vasowave.lung.options import Options
from vasowave.lung.places import VoxelSize
from vasowave.lung.read.volume import Volume
from vasowave.lung.supplied import Given
from vasowave.lung.tree import Line, Tree
from vasowave.lung.witness.grey import GreyLook
from vasowave.lung.witness.skeleton import Thinned

T = TypeVar("T")
FOLDER = "stages"
_SUFFIX = ".stage"
_STORED_TYPES = (Volume, Segmentation, Line, Tree, Elsewhere, Settled, Thinned, Profile, GreyLook, GreyScale)
_KINDS: dict[str, type] = {kind.__name__: kind for kind in _STORED_TYPES}
_BITS = np.dtype(bool).str
_WORD = 16
"""Arrays begin at multiples of so many bytes."""
_LIBRARIES = ("numpy", "scipy", "scikit-image", "SimpleITK", "pydicom", "tifffile")
_HEADER = 1 << 16
"""No header is longer, bytes."""
_SELF_CONTAINED = (".nrrd", ".nhdr", ".nii", ".nii.gz", ".mha", ".mhd", ".tif", ".tiff")
_ELSEWHERE = re.compile(rb"^(data ?file *:|ElementDataFile *=(?! *LOCAL))", re.MULTILINE | re.IGNORECASE)
"""How a header says that its voxels stand in another file."""


class Stages:
    """The stages of one extraction.

    It changes while it is used, for what was made anew is written only once the whole extraction has succeeded.

    Parameters
    ----------
    parent : Path, optional
        The extraction's folder, in which they are kept in a folder of their own; without it nothing is kept.
    hold : bool, optional
        Whether values stay in memory too, so that asking again reads no file.
    """

    def __init__(self, parent: Path | None = None, hold: bool = False) -> None:
        self.parent: Path | None = parent
        self._hold = hold
        self._held: dict[str, tuple[str, Any, tuple[Finding, ...]]] = {}
        self._asked: set[str] = set()
        self._fresh: dict[str, tuple[str, Any, tuple[Finding, ...]]] = {}

    def kept(self, name: str, key: str, make: Callable[[], T]) -> T:
        """Return what `make` returns, and warn as it does; from the disk, if that stands there under `key`."""
        if self.parent is None:
            return make()
        self._asked.add(name)
        stored = self._read(name, key)
        if stored is None:
            value, notes = _made(make)
            self._fresh[name] = self._remembered(name, key, value, notes)
            return value
        value, notes = stored
        _warn(notes)
        return value

    def stored(self, name: str, key: str) -> Any:
        """Return what stands on the disk under `key`, an empty tuple if nothing does."""
        stored = self._read(name, key) if self.parent is not None else None
        return () if stored is None else stored[0]

    def keep(self, name: str, key: str, value: Any) -> None:
        """Keep a value that was made with the help of what was `stored`."""
        self._asked.add(name)
        self._fresh[name] = self._remembered(name, key, value, ())

    def save(self) -> None:
        """Write the stages that were made anew, each whole or not at all, and remove those that were not asked for.

        Raises
        ------
        InputError
            The folder cannot be written.
        """
        if self.parent is None:
            return
        folder = made_inside(self.parent, FOLDER)
        remove_parts(folder)
        for name, (key, value, notes) in self._fresh.items():
            with in_words(folder):
                write_value(folder / f"{name}{_SUFFIX}", key, (as_json(notes), value))
        for file in folder.glob(f"*{_SUFFIX}"):
            if file.stem not in self._asked:
                remove_file(file)
        self._fresh.clear()

    def _read(self, name: str, key: str) -> tuple[Any, tuple[Finding, ...]] | None:
        """Return value and warnings of a stage; None where it is not there, not whole, or of something else."""
        assert self.parent is not None
        held = self._held.get(name)
        if held is not None and held[0] == key:
            return held[1:]
        try:
            notes, value = read_value(self.parent / FOLDER / f"{name}{_SUFFIX}", key)
            return self._remembered(name, key, value, from_json(notes))[1:]
        except Exception:  # whatever stands there, the stage can be made anew
            return None

    def _remembered(
        self, name: str, key: str, value: Any, notes: tuple[Finding, ...]
    ) -> tuple[str, Any, tuple[Finding, ...]]:
        if self._hold:
            self._held[name] = key, value, notes
        return key, value, notes


def forget_stages(parent: Path) -> None:
    """Remove what was kept in the extraction's folder `parent`."""
    folder = made_inside(parent, FOLDER)
    for file in folder.glob(f"*{_SUFFIX}"):
        remove_file(file)
    if not any(folder.iterdir()):
        folder.rmdir()


def _made(make: Callable[[], T]) -> tuple[T, tuple[Finding, ...]]:
    """Return what `make` returns and what it warned of, having warned."""
    notes: tuple[Finding, ...] = ()
    try:
        with warnings.catch_warnings(record=True) as caught_warnings:
            warnings.simplefilter("always", VasowaveWarning)
            value = make()
    finally:
        notes = found_in(caught_warnings)
        _warn(notes)
    return value, notes


def _warn(notes: tuple[Finding, ...]) -> None:
    for note in notes:
        warn(note, stacklevel=4)


def write_value(path: Path, key: str, value: Any) -> None:
    """Write `value` under `key`; `OSError` where that fails.

    It may be of dataclasses of an extraction, tuples, arrays, numbers, text and None, inside one another.
    """
    arrays: list[np.ndarray] = []
    plain = _plain(value, arrays)
    head = json.dumps({"arrays": [(array.dtype.str, array.size) for array in arrays], "value": plain}).encode()
    chunks: list[Any] = [len(head).to_bytes(_WORD, "little"), head, *map(_bytes, arrays)]
    keep(path, key, *(piece for chunk in chunks for piece in (chunk, bytes(-len(chunk) % _WORD))))


@stored("stage of an extraction", f"{FOLDER}/*{_SUFFIX}")
def read_value(path: Path, key: str) -> Any:
    """Return the value that `write_value` wrote under `key`; any error where no such one stands there."""
    with regular_file(path).open("rb") as file:
        content = recall(file, key)
    if content is None:
        raise ValueError("another value, or a damaged one")
    length = int.from_bytes(content[:_WORD].tobytes(), "little")
    head = parsed(content[_WORD : _WORD + length].tobytes())
    arrays, offset = [], _next(_WORD + length)
    for kind, size in head["arrays"]:
        end = offset + size * np.dtype(kind).itemsize
        arrays.append(content[offset:end].view(kind))
        offset = _next(end)
    return _value(head["value"], arrays)


def _next(offset: int) -> int:
    return offset + -offset % _WORD


def _value(plain: Any, arrays: list[np.ndarray]) -> Any:
    if isinstance(plain, list):
        return tuple(_value(element, arrays) for element in plain)
    if not isinstance(plain, dict):
        return plain
    if "kind" in plain:
        return _KINDS[plain["kind"]](**{name: _value(element, arrays) for name, element in plain["fields"].items()})
    array, shape = arrays[plain["array"]], tuple(plain["shape"])
    if plain["type"] == _BITS:
        array = np.unpackbits(array, count=int(np.prod(shape)))
    return array.view(plain["type"]).reshape(shape)


def _plain(value: Any, arrays: list[np.ndarray]) -> Any:
    if isinstance(value, np.ndarray):
        arrays.append(np.packbits(value) if value.dtype == bool else value)
        return {"array": len(arrays) - 1, "shape": value.shape, "type": value.dtype.str}
    if is_dataclass(value):
        contents = {entry.name: _plain(getattr(value, entry.name), arrays) for entry in fields(value)}
        return {"kind": type(value).__name__, "fields": contents}
    if isinstance(value, tuple):
        return [_plain(element, arrays) for element in value]
    return value.item() if isinstance(value, np.generic) else value


def _bytes(array: np.ndarray) -> np.ndarray:
    return np.ascontiguousarray(array).reshape(-1).view(np.uint8)


class Keys(NamedTuple):
    """The digest of each stage; it holds that of the stage before."""

    lumen: str
    loops: str
    axes: str
    elsewhere: str
    witness: str
    profiles: str
    grey: str


def keys_of(image: str, inputs: Given, options: Options) -> Keys:
    """Return the keys of the stages after the image, whose own is `image`.

    Edits, wanted parts, scale and pressure act on what is measured, so that no stage depends on them; a root among
    the edits is the root.
    """
    lumen = _key("lumen", image, inputs.segmenter, options.threshold, inputs.seed)
    loops = _key("loops", lumen, inputs.root, options.loops, inputs.outlets is None)
    axes = _key("axes", lumen, inputs.root, inputs.outlets, bool(options.cannula))
    elsewhere, grey = _key("elsewhere", axes), _key("grey", axes, options.cannula)
    return Keys(lumen, loops, axes, elsewhere, _key("witness", lumen, inputs.root), _key("profiles", lumen), grey)


def _key(stage: str, *values: Any) -> str:
    return digest_of(program("lung", libraries=_LIBRARIES), stage, *values)


def image_key(source: Path, voxel: VoxelSize | None) -> str | None:
    """Return the digest of the files at `source`, with what they are read as; None where other files belong to it."""
    files = sorted(entry for entry in source.iterdir() if entry.is_file()) if source.is_dir() else [source]
    if not source.is_dir() and not _stands_alone(source):
        return None
    return _key("image", source.suffix.lower(), voxel, [(file.name, look(file).sha256) for file in files])


def _stands_alone(source: Path) -> bool:
    self_contained = source.is_file() and source.name.lower().endswith(_SELF_CONTAINED)
    return self_contained and not _ELSEWHERE.search(read_start(source, _HEADER))


def volume_key(volume: Volume) -> str:
    """Return the digest of an image that is given as such."""
    return _key("volume", volume)
