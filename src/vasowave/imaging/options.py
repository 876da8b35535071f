"""What a user can ask of an extraction: the one definition from which the command line is made too."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

from annotated_types import Ge, Le, Lt

from vasowave.errors import InputError
from vasowave.imaging.places import Place, Places, Region
from vasowave.network.network import HIGHEST
from vasowave.settings import check_settings


@dataclass(frozen=True, eq=False)
class Options:
    """What the user decides; places are z, y, x in cm, in the world as a viewer shows the image.

    Attributes
    ----------
    root : sequence of 3 floats, optional
        Where the blood enters, the outer end of the cannula: x,y,z as a viewer shows it, cm (or with a unit:
        '9.1 12 4.5 mm'). An edit `root` overrules it, label 2 of the mask stands in.
    outlets : sequence of points, optional
        Guided mode, the network reaches these and no other: an outlet x,y,z, repeated, or a CSV with x [cm], y [cm],
        z [cm]. Labels from 3 on of the mask stand in for them.
    threshold : float
        Grey level of the vessel wall; radii are repeated at ±20 % of it for their uncertainty.
    seed : sequence of 3 floats, optional
        A point inside the vessels, where the root is not inside them.
    method : "threshold" or "level-set"
        threshold (region growing), or level-set (active contour).
    mask : Path, optional
        The lumen as edited by hand; labels: 1 lumen, 2 root, 3… outlets.
    edits : Path, optional
        Corrections: remove, cut, merge, root, one a line.
    region : Path or pair of corners, optional
        Mask file, or box x,y,z:x,y,z; outside is no lumen.
    voxel : float, optional
        Voxel size, cm, in place of the file's.
    cannula : float
        Known inner diameter of the cannula, cm (PE-90: 0.086); 0 where there is none.
    species : "mouse", "rat", "human" or "other"
        Whose main pulmonary artery the voxel size is checked by where there is no cannula; other: not checked.
    pressure : float
        Transmural pressure at which the vessels were filled for the image, mmHg; 0 where it is not known.
    scale : "file" or "cannula"
        Whether lengths follow the file's voxel size or the cannula's known diameter.
    loops : "open" or "refuse"
        Refuse a lumen that closes loops, or open them with a warning; both say where.
    junction : "axes", "tube" or "vmtk"
        Where a junction is said to be, for lengths alone: where the axes meet, or, for comparison with other programs,
        where daughters leave each other's tubes of half the radius (tube) or of the whole (VMTK's split point).
    generations : int, optional
        Keep the first so many generations.
    vessels : int, optional
        Keep the largest so many vessels.
    min_radius : float, optional
        Keep the vessels above this radius, cm.
    """

    root: Place | None = None
    outlets: Places | None = None
    threshold: float = 45.0
    seed: Place | None = None
    method: Literal["threshold", "level-set"] = "threshold"
    mask: Path | None = None
    edits: Path | None = None
    region: Region | None = None
    voxel: float | None = None
    cannula: Annotated[float, Ge(0), Lt(2)] = 0.086
    species: Literal["mouse", "rat", "human", "other"] = "mouse"
    pressure: Annotated[float, Ge(0), Le(HIGHEST)] = 0.0
    scale: Literal["file", "cannula"] = "file"
    loops: Literal["open", "refuse"] = "refuse"
    junction: Literal["axes", "tube", "vmtk"] = "axes"
    generations: int | None = None
    vessels: int | None = None
    min_radius: float | None = None

    def __post_init__(self) -> None:
        """Refuse what contradicts itself before any file is read."""
        check_settings(self)
        check_wishes(self.generations, self.vessels, self.min_radius)
        if self.scale == "cannula" and not self.cannula:
            raise InputError("scale 'cannula' needs a cannula of known diameter")
        if self.mask is not None and self.method != "threshold":
            raise InputError("a mask is the lumen; the method 'level-set' would find another: leave one out")


def check_wishes(*wishes: float | None) -> None:
    """Raise `InputError` if more than one part of the tree is wanted."""
    if sum(wish is not None for wish in wishes) > 1:
        raise InputError("keep either the first generations, or so many vessels, or all above a radius")
