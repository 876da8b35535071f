"""What a user can ask of an extraction: the one definition from which the command line is made too."""

from collections.abc import Sequence
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Annotated, Literal, NamedTuple, get_args, get_origin

from vasowave.errors import InputError

PLACE = "x,y,z in the image's coordinates, cm (or with a unit: '9.1 12 4.5 mm')"
_OUTLETS = "Guided mode: an outlet x,y,z, repeated, or a CSV with x \\[cm], y \\[cm], z \\[cm]."


class Setting(NamedTuple):
    """How a setting is asked for on the command line; `read` names how text becomes its value."""

    help: str
    read: Literal["", "place", "places", "region"] = ""


@dataclass(frozen=True, eq=False)
class Options:
    """What the user decides; places are z, y, x in cm, in the image's own coordinates.

    Attributes
    ----------
    root : sequence of 3 floats, optional
        Where the blood enters: the outer end of the cannula. An edit `root` overrules it, label 2 of `mask` stands in.
    outlets : sequence of points, optional
        Guided mode: the network reaches these and no other; labels from 3 on of `mask` stand in for them.
    threshold : float
        Grey level of the wall; radii are repeated at ±20 % of it for their uncertainty.
    seed : sequence of 3 floats, optional
        A point inside the tree, where the root is not inside it.
    method : "threshold" or "level-set"
        Region growing, or the active contour of `lumen.contours.level_set`.
    mask, edits : Path, optional
        The lumen as edited by hand (see `read.labels`), corrections of the tree (see `revise.edits`).
    region : Path or pair of corners, optional
        Mask file or box outside which nothing is lumen.
    voxel : float, optional
        Voxel size, cm, in place of the file's.
    cannula : float
        Known inner diameter, cm; 0 where there is no cannula.
    scale : "file" or "cannula"
        Whether lengths follow the file's voxel size or the cannula's known diameter.
    loops : "open" or "refuse"
        What becomes of a lumen that closes loops: an error, or a tree that cuts them, with a warning; both say where.
    generations, vessels, min_radius : optional
        At most one: the part of the tree to keep, see `revise.parts`.
    """

    root: Annotated[Sequence[float] | None, Setting(f"Where the blood enters: {PLACE}.", "place")] = None
    outlets: Annotated[Sequence[Sequence[float]] | None, Setting(_OUTLETS, "places")] = None
    threshold: Annotated[float, Setting("Grey level of the vessel wall.")] = 45.0
    seed: Annotated[Sequence[float] | None, Setting("A point inside the tree, if the root is not.", "place")] = None
    method: Annotated[Literal["threshold", "level-set"], Setting("threshold, or level-set (active contour).")] = (
        "threshold"
    )
    mask: Annotated[Path | None, Setting("Edited mask; labels: 1 lumen, 2 root, 3… outlets.")] = None
    edits: Annotated[Path | None, Setting("Corrections: remove, cut, merge, root, one a line.")] = None
    region: Annotated[
        Path | tuple[Sequence[float], Sequence[float]] | None,
        Setting("Mask file, or box x,y,z:x,y,z; outside is no lumen.", "region"),
    ] = None
    voxel: Annotated[float | None, Setting("Voxel size in cm, in place of the file's.")] = None
    cannula: Annotated[float, Setting("Inner diameter of the cannula, cm (PE-90: 0.086); 0: none.")] = 0.086
    scale: Annotated[Literal["file", "cannula"], Setting("Lengths follow the 'file' or the 'cannula'.")] = "file"
    loops: Annotated[
        Literal["open", "refuse"], Setting("'refuse' a lumen that closes loops, or 'open' them with a warning.")
    ] = "refuse"
    generations: Annotated[int | None, Setting("Keep the first so many generations.")] = None
    vessels: Annotated[int | None, Setting("Keep the largest so many vessels.")] = None
    min_radius: Annotated[float | None, Setting("Keep the vessels above this radius, cm.")] = None

    def __post_init__(self) -> None:
        """Refuse what contradicts itself before any file is read."""
        for entry in fields(self):
            kind, value = get_args(entry.type)[0], getattr(self, entry.name)
            if get_origin(kind) is Literal and value not in get_args(kind):
                raise InputError(f"{entry.name} '{value}'; there are: {', '.join(get_args(kind))}")
        check_wishes(self.generations, self.vessels, self.min_radius)
        if self.scale == "cannula" and not self.cannula:
            raise InputError("scale 'cannula' needs a cannula of known diameter")
        if not 0 <= self.cannula < 2:
            raise InputError(f"a cannula of {self.cannula:g} cm; give its inner diameter in cm, 0 where there is none")
        if self.mask is not None and self.method != "threshold":
            raise InputError("a mask is the lumen; the method 'level-set' would find another: leave one out")


def check_wishes(*wishes: float | None) -> None:
    """Raise `InputError` if more than one part of the tree is wanted."""
    if sum(wish is not None for wish in wishes) > 1:
        raise InputError("keep either the first generations, or so many vessels, or all above a radius")
