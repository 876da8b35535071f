"""Files that are dropped on the page: where they come to lie in the study, and that none replaces another."""

import os
import unicodedata
from pathlib import Path, PurePosixPath

from vasowave.errors import InputError
from vasowave.imaging.read.formats import VOLUMES
from vasowave.io.files import made_inside
from vasowave.io.textfile import look
from vasowave.network_formats import NETWORKS
from vasowave.recording.formats import RECORDINGS
from vasowave.study.template import FOLDERS
from vasowave.workbench.desk import Desk
from vasowave.workbench.lungs import IMAGES, is_image

_NETWORKS, _RECORDINGS = FOLDERS
_DEEPEST, _LONGEST = 8, 120  # folders, and letters of a name
_FORBIDDEN = set('<>:"|?*\\')  # which one of the systems has no files of


def place_of(desk: Desk, name: str) -> Path:
    """Return where a file that is dropped as `name`, with the folders it was in, is to lie.

    Below ``recordings``, an image below ``images``.

    Raises
    ------
    InputError
        A name that leads out of the study, is hidden, or is none that any system can have; not a type that is read.
    """
    parts = PurePosixPath(unicodedata.normalize("NFC", name)).parts
    good = 0 < len(parts) <= _DEEPEST and all(
        len(one) <= _LONGEST and one.isprintable() and not one.startswith(".") and not set(one) & _FORBIDDEN
        and one not in ("/", "..") and one == one.strip()
        for one in parts
    )  # fmt: skip
    if not good:
        raise InputError(f"'{name[:80]}' is no name of a file inside this study; rename it and drop it again")
    image, known = is_image(Path(name)), {*RECORDINGS.suffixes, *NETWORKS.suffixes}
    if not image and PurePosixPath(name).suffix.lower() not in known:
        raise InputError(f"{parts[-1]}: files that are read end in {', '.join(sorted({*known, *VOLUMES.suffixes}))}")
    place = PurePosixPath(IMAGES, parts[-1]) if image else PurePosixPath(_RECORDINGS, *parts)
    path = desk.inside(str(place))
    desk.folder.mkdir(parents=True, exist_ok=True)
    made_inside(desk.folder, str(place.parent))
    return path


def sorted_in(desk: Desk, part: Path, place: Path) -> str:
    """Put what has arrived whole into its place, a network among the networks; return its name in the study.

    Raises
    ------
    InputError
        A file of this name with another content is there.
    """
    named = part.with_name(part.name + place.suffix)
    part.rename(named)
    try:
        try:
            network = not is_image(place) and NETWORKS.known(named) is not None
        except InputError:
            network = False
        if network:
            place = made_inside(desk.folder, _NETWORKS) / place.name
        try:
            os.link(named, place)  # unlike a renaming it never takes another's place
        except FileExistsError:
            if look(place).sha256 != look(named).sha256:
                raise InputError(
                    f"{place.name}: the study has another file of this name; rename one of the two"
                ) from None
        except OSError:  # a file system without links
            if place.exists():
                raise
            named.rename(place)
    finally:
        named.unlink(missing_ok=True)
    return place.relative_to(desk.folder).as_posix()
