"""What a person may open: a study, a fit, a folder that becomes one, a recording or an image alone; and files that are
dropped on the page: where they come to lie in the study, and that none replaces another.
"""

import shutil
import unicodedata
from pathlib import Path, PurePosixPath
from typing import NamedTuple
from urllib.parse import quote

from vasowave.base.errors import InputError
from vasowave.base.io.files import alone_in, check_writable, made_inside, make_folder, take_free_place
from vasowave.base.io.textfile import look
from vasowave.base.runtime.writing import flush
from vasowave.catheter.read.formats import RECORDINGS
from vasowave.pulse.network_formats import NETWORKS
from vasowave.study.entering.adding import Added, add_files
from vasowave.study.entering.table import read_rows
from vasowave.study.entering.template import FOLDERS, new_study
from vasowave.study.folder.names import plain_name
from vasowave.study.folder.places import RESULTS, STUDY_FILE
from vasowave.workbench.desk import Desk
from vasowave.workbench.lungs import IMAGES, is_image, name_of

_NETWORKS, _RECORDINGS = FOLDERS
_MAX_FOLDERS, _MAX_NAME_LETTERS = 8, 120  # folders, and letters of a name
_FORBIDDEN_LETTERS = set('<>:"|?*\\')  # which one of the systems has no files of


class OpenedPlace(NamedTuple):
    """The folder of the study, which desk is shown first (the address behind its ``#``), what was decided, an image."""

    folder: Path
    desk: str
    notices: tuple[str, ...] = ()
    image: Path | None = None


def opened(place: Path) -> OpenedPlace:
    """Return what is to be opened.

    A recording or an image needs a study, which holds what is chosen of it: the one it lies in and is listed in, or a
    new one beside it, called after it. A folder of DICOM slices is an image.

    Raises
    ------
    InputError
        It is nothing that can be opened.
    """
    if is_image(place) or _slices(place):
        return _image(place)
    if place.is_dir() or not place.suffix:
        return _folder(place)
    if place.name == STUDY_FILE:
        return _folder(place.parent)
    if not place.is_file():
        raise InputError(f"{place}: there is no such file")
    if place.suffix.lower() not in RECORDINGS.suffixes:
        raise InputError(f"{place}: the workbench opens studies, fits, recordings and images")
    for folder in place.absolute().parents[:3]:
        if (folder / STUDY_FILE).is_file() and (name := _animal(folder, place)):
            return OpenedPlace(folder, f"#recording/{name}")
    folder = place.absolute().with_name(f"{place.stem} study")
    if not _is_study(folder) or not _animal(folder, place):
        _put_into(folder, place.absolute())
    return OpenedPlace(
        folder, f"#recording/{_animal(folder, place)}", (f"Its study, which holds what is chosen: {folder}",)
    )


def _image(place: Path) -> OpenedPlace:
    if not place.exists():
        raise InputError(f"{place}: there is no such file")
    place = place.absolute()
    home = next((parent for parent in place.parents[:2] if (parent / STUDY_FILE).is_file()), None)
    folder = home or place.with_name(f"{name_of(place)} study")
    if home is None and not (folder / STUDY_FILE).is_file():
        new_study(folder)
    inside = place.parent == folder / IMAGES
    notices = () if home else (f"Its study, which holds what is found: {folder}",)
    return OpenedPlace(folder, f"#lung/{quote(plain_name(name_of(place)))}", notices, None if inside else place)


def _slices(place: Path) -> bool:
    """Whether a folder holds DICOM slices."""
    files = sorted(file for file in place.iterdir() if file.is_file()) if place.is_dir() else []
    return any(file.suffix.lower() == ".dcm" or look(file).start[128:132] == b"DICM" for file in files[:1])


def _folder(place: Path) -> OpenedPlace:
    if place.is_dir():
        has_study = (place / STUDY_FILE).is_file() or (place / RESULTS).is_dir()
        if not has_study and any(not entry.name.startswith(".") for entry in place.iterdir()):
            return _collected(place.absolute())
    if not place.exists():
        raise InputError(
            f"{place}: there is no such folder; `vasowave new {place}` makes a study there, to be opened then"
        )
    check_writable(place)
    fit = (place / RESULTS).is_dir() and not (place / STUDY_FILE).is_file()
    return OpenedPlace(place, "#explorer" if fit else "")


def _collected(place: Path) -> OpenedPlace:
    """Return the study beside a folder of recordings, made of them where there is none yet.

    Raises
    ------
    InputError
        Nothing in the folder is a recording; nothing is written then.
    """
    folder = place.with_name(f"{place.name} study")
    notices = [f"The study of the files in {place.name}, which stay as they are: {folder}"]
    if not _is_study(folder):
        added = _put_into(folder, place)
        notices += [*added.said, *added.refused]
    return OpenedPlace(folder, "", tuple(notices))


def _is_study(folder: Path) -> bool:
    return (folder / STUDY_FILE).is_file()


def _put_into(folder: Path, place: Path) -> Added:
    """Add a recording or a folder of them to a study; one that is made for them and stays empty is taken away."""
    fresh = not folder.exists()
    if not _is_study(folder):
        new_study(folder)
    try:
        return add_files(folder, [place])
    except InputError as error:
        if fresh:
            shutil.rmtree(folder)
        raise InputError(
            f"{place}: no study can be made of it; name a study, recordings, or an empty folder for a study: {error}"
        ) from None


def _animal(folder: Path, recording: Path) -> str:
    """Return the animal whose recording a file is."""
    for row in read_rows(Desk(folder).table).rows:
        if row.get("recording") and (folder / row["recording"]).resolve() == recording.resolve():
            return quote(row["animal"])
    return ""


def place_of(desk: Desk, name: str) -> Path:
    """Return where a file that is dropped as `name`, with the folders it was in, is to lie.

    Below ``recordings``, an image below ``images``.

    Raises
    ------
    InputError
        A name that leads out of the study, is hidden, or is none that any system can have; not a type that is read.
    """
    components = PurePosixPath(unicodedata.normalize("NFC", name)).parts
    good = 0 < len(components) <= _MAX_FOLDERS and all(
        len(component) <= _MAX_NAME_LETTERS and component.isprintable() and not component.startswith(".")
        and not set(component) & _FORBIDDEN_LETTERS and component not in ("/", "..") and component == component.strip()
        for component in components
    )  # fmt: skip
    if not good:
        raise InputError(f"'{name[:80]}' is not a name of a file inside this study; rename it and drop it again")
    image, suffixes = is_image(Path(name)), {*RECORDINGS.suffixes, *NETWORKS.suffixes}
    if not image and PurePosixPath(name).suffix.lower() not in suffixes:
        raise InputError(f"{components[-1]}: no reader has its type; save it as .xlsx or CSV, and drop it again")
    place = PurePosixPath(IMAGES, components[-1]) if image else PurePosixPath(_RECORDINGS, *components)
    path = desk.inside(str(place))
    make_folder(desk.folder)
    made_inside(desk.folder, str(place.parent))
    return path


def sorted_in(desk: Desk, upload: Path, place: Path) -> str:
    """Put what has arrived whole into its place, a network among the networks; return its name in the study.

    Raises
    ------
    InputError
        A file of this name with another content is there.
    """
    try:
        network = not is_image(place) and NETWORKS.known(upload) is not None
    except InputError:
        network = False
    if network:
        place = made_inside(desk.folder, _NETWORKS) / place.name
    with alone_in(desk.folder):
        try:
            take_free_place(upload, place)
        except FileExistsError:
            if look(place).sha256 != look(upload).sha256:
                raise InputError(
                    f"{place.name}: the study has another file of this name; rename one of the two"
                ) from None
        flush(place.parent)
    return place.relative_to(desk.folder).as_posix()
