"""What the Lung desk shows: an image at the size of a screen, the vessels that are found in it, and their doubts."""

import json
import threading
import warnings
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, NamedTuple

import numpy as np
from annotated_types import Ge

from vasowave.base.errors import InputError, VasowaveError, VasowaveWarning
from vasowave.base.findings import texts
from vasowave.base.io.files import alone_in, content_of, made_inside
from vasowave.base.io.textfile import read_bytes, regular_file
from vasowave.base.settings import settings_class
from vasowave.base.species import SPECIES, SpeciesName
from vasowave.base.stores import parsed, stored
from vasowave.lung.extraction import Extraction, extract
from vasowave.lung.kept.stages import Stages
from vasowave.lung.lumen.levels import levels_of
from vasowave.lung.options import Options
from vasowave.lung.places import VoxelSize, voxel_text
from vasowave.lung.read.files import read_volume
from vasowave.lung.read.formats import VOLUMES
from vasowave.lung.read.volume import Volume
from vasowave.study.folder.names import plain_name
from vasowave.study.report.extraction import SETTINGS, write_extraction
from vasowave.workbench.desk import EDITS, Desk
from vasowave.workbench.values import number

IMAGES, LUNGS = "images", "lungs"
"""Folders of the images that are dropped, and of what is extracted from each."""

_MAX_EDGE_VOXELS = 144  # voxels along an edge of what is sent to the page
_POINTS = 40  # of a vessel, likewise
_LEVELS = 65535  # grey levels, likewise
_CAPACITY = 8  # extractions of one image, so that an edit that is undone costs nothing


@settings_class
class Wishes:
    """What the desk lets a person choose of an extraction; all else are the defaults of `vasowave extract`."""

    threshold: float = 45.0
    cannula: Annotated[float, Ge(0)] = 0.086
    pressure: Annotated[float, Ge(0)] = 0.0
    species: SpeciesName = "mouse"
    open_loops: bool = False
    voxel: VoxelSize | None = None


class Found(NamedTuple):
    """An extraction, and what it was made of."""

    key: tuple[Any, ...]
    extraction: Extraction


class Lungs:
    """The image that was looked at last, and what was found in it lately; one at a time, for images are large.

    Parameters
    ----------
    opened_image : Path, optional
        An image that was opened by its name and lies elsewhere.
    """

    def __init__(self, opened_image: Path | None = None) -> None:
        self.opened_image = opened_image
        self.stage: str = ""
        self._volume: tuple[Any, Volume] | None = None
        self._found: list[Found] = []
        self._stages: tuple[Path, Stages] | None = None
        self._lock = threading.Lock()

    def images(self, desk: Desk) -> dict[str, Path]:
        """Return the images of a study by their names."""
        folder = desk.folder.absolute() / IMAGES
        inside = [path for path in sorted(folder.iterdir()) if not path.name.startswith(".")] if folder.is_dir() else []
        candidates = [path for path in inside if path.is_dir() or is_image(path)]
        before = [_stored(path).get("image", "") for path in sorted((desk.folder / LUNGS).glob(f"*/{SETTINGS}"))]
        elsewhere = [*map(Path, before), *([] if self.opened_image is None else [self.opened_image])]
        return {
            plain_name(name_of(path)): path
            for path in (*elsewhere, *candidates)
            if path.is_absolute() and path.exists()
        }

    def image(self, desk: Desk, name: str) -> Path:
        """Return the image of a name; `InputError` if there is none."""
        images = self.images(desk)
        if name not in images:
            raise InputError(f"there is no image '{name[:80]}'; there are: {', '.join(images) or 'none'}")
        return images[name]

    def described(self, desk: Desk, name: str) -> dict[str, Any]:
        """Return which images there are, and of one what was chosen and edited, and whether its network is current."""
        names = list(self.images(desk))
        name = name if name in names else next(iter(names), "")
        if not name:
            return {"images": [], "image": ""}
        path, edits = self.image(desk, name), edits_of(desk, name)
        lines = lines_of(edits)
        done = folder_of(desk, name) / SETTINGS
        wishes = stored_wishes(done)
        return {
            "images": names, "image": name, "file": path.name, "stage": self.stage, "species": [*SPECIES, "other"],
            "wishes": {wish: getattr(wishes, wish) for wish in Wishes.__dataclass_fields__} | {
                "voxel": None if wishes.voxel is None else voxel_text(wishes.voxel)
            },
            "edits": [[number, line] for number, line in enumerate(lines, 1) if line.split("#")[0].strip()],
            "root": any(line.split()[:1] == ["root"] for line in lines), "file of edits": edits.name,
            "written": done.is_file(),
            "outdated": done.is_file() and edits.is_file() and edits.stat().st_mtime_ns > done.stat().st_mtime_ns,
        }  # fmt: skip

    def volume(self, desk: Desk, name: str, voxel: VoxelSize | None = None) -> Volume:
        """Return an image as it is read."""
        path = self.image(desk, name)
        key = (path, voxel, _mark(path))
        with self._lock:
            if self._volume is None or self._volume[0] != key:
                self._volume, self._found, self._stages = None, [], None  # room for the next
                self._volume = key, read_volume(path, voxel)
            return self._volume[1]

    def reduced(self, desk: Desk, name: str, voxel: VoxelSize | None = None) -> bytes:
        """Return an image as small as a screen shows: a line of JSON, then grey levels of 16 bits, x fastest."""
        volume = self.volume(desk, name, voxel)
        grey, step = smaller(volume.grey)
        low, high = float(grey.min()), float(grey.max())
        levels = np.round((grey - low) * (_LEVELS / (high - low or 1.0))).astype("<u2")
        spacing = volume.spacing * step
        about = {
            "shape": list(grey.shape), "low": low, "high": high, "spacing": spacing.tolist(),
            "origin": (volume.origin + 0.5 * (step - 1) * volume.spacing).tolist(),
            "voxels": list(volume.grey.shape), "voxel": volume.spacing.tolist(),
            "threshold": levels_of(volume).threshold,
        }  # fmt: skip
        return json.dumps(about).encode() + b"\n" + levels.tobytes()

    def extracted(self, desk: Desk, name: str, wishes: Wishes) -> Extraction:
        """Return what `vasowave extract` finds with the edits as they stand; what still holds is not computed again.

        Raises
        ------
        InputError, NumericalError
            As `extract`.
        """
        path, edits = self.image(desk, name), edits_of(desk, name)
        with self._lock:
            key = (path, _mark(path), wishes, edits.read_bytes() if edits.is_file() else b"")
            entry = next((candidate for candidate in self._found if candidate.key == key), None)
            if entry is None:
                options = options_of(wishes, edits)
                try:
                    with warnings.catch_warnings():
                        warnings.simplefilter("ignore", VasowaveWarning)  # they stand in the extraction
                        extraction = extract(path, options, self._say, self._kept(folder_of(desk, name)))
                finally:
                    self.stage = ""
                entry = Found(key, extraction)
                self._volume = (path, wishes.voxel, _mark(path)), extraction.image  # the one that the stages hold
            self._found = [*(candidate for candidate in self._found if candidate is not entry), entry][-_CAPACITY:]
            return entry.extraction

    def shown(self, desk: Desk, name: str, wishes: Wishes) -> dict[str, Any]:
        """Return the vessels that are found, as the desk draws them; places: x, y, z in cm along the image's axes."""
        return _shown(self.extracted(desk, name, wishes))

    def write(self, desk: Desk, name: str, wishes: Wishes) -> Path:
        """Write the folder of an extraction as `vasowave extract` does; return it."""
        folder, extraction = folder_of(desk, name), self.extracted(desk, name, wishes)
        made_inside(desk.folder, LUNGS)
        with alone_in(desk.folder):
            write_extraction(extraction, folder)
            with self._lock:
                self._kept(folder).save()
        return folder

    def own(self, desk: Desk, name: str, place: tuple[float, float, float]) -> np.ndarray:
        """Return x, y, z of the page as x, y, z in the world, cm."""
        cached_volume = self._volume
        if cached_volume is None or cached_volume[0][0] != self.image(desk, name):
            raise InputError("another image was looked at meanwhile; look at this one again, and then do it")
        return cached_volume[1].frame.world(np.array(place[::-1]))[::-1]

    def finds(self, desk: Desk, name: str) -> Wishes | None:
        """Return with what an image's vessels were looked for last here, None if they were not."""
        if not self._found or self._found[-1].key[0] != self.image(desk, name):
            return None
        wishes: Wishes = self._found[-1].key[2]
        return wishes

    def _say(self, stage: str) -> None:
        self.stage = stage

    def _kept(self, folder: Path) -> Stages:
        if self._stages is None or self._stages[0] != folder:
            self._stages = folder, Stages(folder, hold=True)
        return self._stages[1]


def folder_of(desk: Desk, name: str) -> Path:
    """Return the folder of the extraction of an image."""
    return desk.inside(f"{LUNGS}/{name}")


def lines_of(edits: Path) -> list[str]:
    """Return the lines of a file of edits, none where it is not there; `InputError` where it is not a text of UTF-8."""
    try:
        return (content_of(edits) or b"").decode("utf-8").splitlines()
    except UnicodeDecodeError:
        raise InputError(f"{edits}: is not a text in UTF-8; save it as that, or remove it") from None


def edits_of(desk: Desk, name: str) -> Path:
    """Return the file of the edits of an image's tree."""
    return desk.inside(f"{EDITS}/{name}.txt")


def name_of(image: Path) -> str:
    """Return the name of an image without what says its format."""
    return image.name if image.is_dir() else image.name.removesuffix(".gz").rpartition(".")[0]


def is_image(path: Path) -> bool:
    """Whether a file's name is one of an image; a MATLAB file that is put here is a recording."""
    name = path.name.lower().removesuffix(".gz")
    return name.endswith(tuple(VOLUMES.suffixes)) and not name.endswith(".mat")


def options_of(wishes: Wishes, edits: Path) -> Options:
    """Return the options of `vasowave extract` for what the desk lets a person choose."""
    return Options(
        threshold=wishes.threshold, cannula=wishes.cannula, pressure=wishes.pressure, species=wishes.species,
        loops="open" if wishes.open_loops else "refuse", voxel=wishes.voxel, edits=edits if edits.is_file() else None,
    )  # fmt: skip


@stored("settings of an extraction", f"{LUNGS}/*/{SETTINGS}")
def stored_wishes(settings: Path) -> Wishes:
    """Return what an extraction was made with, the defaults where there is none."""
    rows = _stored(settings)
    try:
        cells = {name: rows[name] for name in ("threshold", "cannula", "pressure", "species", "voxel") if name in rows}
        values: Any = {name: text if name in ("species", "voxel") else float(text) for name, text in cells.items()}
        return Wishes(**values, open_loops=rows.get("loops") == "open")
    except (ValueError, VasowaveError):
        return Wishes()


def _stored(settings: Path) -> Mapping[str, str]:
    """Return the settings of an extraction as it was written, nothing where there is none."""
    try:
        rows = parsed(read_bytes(settings))["settings"]
        return {str(name): str(value) for name, value in rows.items()}
    except (InputError, ValueError, LookupError, TypeError, AttributeError):
        return {}


def smaller(grey: np.ndarray) -> tuple[np.ndarray, int]:
    """Return the means of cubes of voxels, so large that no edge has more than 144, and their edge in voxels.

    The last cube of an edge that they do not fill is filled with its last plane.
    """
    step = -(-max(grey.shape) // _MAX_EDGE_VOXELS)
    if step == 1:
        return np.asarray(grey, dtype=np.float32), 1
    padded = np.pad(grey, [(0, -length % step) for length in grey.shape], mode="edge")
    shape = [number for length in padded.shape for number in (length // step, step)]
    return padded.reshape(shape).mean(axis=(1, 3, 5), dtype=np.float32), step


def _mark(path: Path) -> tuple[Any, ...]:
    files = sorted(file for file in path.iterdir() if file.is_file()) if path.is_dir() else [regular_file(path)]
    return tuple((file.name, file.stat().st_mtime_ns, file.stat().st_size) for file in files)


def _shown(extraction: Extraction) -> dict[str, Any]:
    network, measured, to_image = extraction.network, extraction.measured, extraction.image.frame.own
    terminals = set(network.terminals.tolist())
    vessels = []
    for row, line in enumerate(extraction.tree.lines):
        indices = np.unique(np.linspace(0, len(line) - 1, min(len(line), _POINTS)).round().astype(int))
        name = network.name[row]
        points = np.column_stack([to_image(line.points[indices])[:, ::-1], line.radius[indices]])
        vessels.append({
            "name": name, "parent": network.name[network.parent[row]] if network.parent[row] >= 0 else "",
            "terminal": row in terminals, "length": number(network.length[row], 5),
            "radius": number(network.radius[row], 5), "sd": number(measured.radius_sd[row], 5),
            "reliable": bool(measured.reliable[row]),
            "points": np.round(points, 5).tolist(),
            "doubts": sorted({doubt.about for doubt in extraction.doubts if name in doubt.vessels}),
        })  # fmt: skip
    doubts = [
        {
            "about": doubt.about,
            "text": doubt.text,
            "vessels": list(doubt.vessels),
            "places": to_image(doubt.places)[:, ::-1].tolist(),
        }
        for doubt in extraction.doubts
    ]
    return {
        "vessels": vessels, "doubts": doubts, "notes": texts(extraction.notes),
        "root": to_image(extraction.root)[::-1].tolist(),
        "scale": 100 * (extraction.scale - 1) if extraction.options.cannula else None,
        "generations": len(network.generations), "total": number(float(network.length.sum())),
    }  # fmt: skip
